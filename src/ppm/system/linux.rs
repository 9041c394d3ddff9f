//! Linux: files without a name, attributes of inodes, kinds of file systems.

use std::{
    fs::File,
    io,
    os::fd::AsRawFd,
    path::{Path, PathBuf},
};

use rustix::{
    fs::{Access, AtFlags, CWD, FallocateFlags, Mode, OFlags, StatxAttributes, StatxFlags},
    io::Errno,
};

use super::{attributes::Attributes, permissions::mode_of_new};

/// A file without a name, on the file system of `folder`; `None` where there are no such
/// files, or no way to name one later.
pub(in crate::ppm) fn unnamed_file(folder: &Path, private: bool) -> Option<File> {
    let file = rustix::fs::open(
        folder,
        OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC,
        Mode::from_raw_mode(mode_of_new(private)),
    );
    let file = File::from(file.ok()?);
    // Without /proc there would be no way to give it a name.
    rustix::fs::access(descriptor_path(&file), Access::EXISTS).ok()?;
    Some(file)
}

fn descriptor_path(file: &File) -> String {
    format!("/proc/self/fd/{}", file.as_raw_fd())
}

/// Gives a name to a file that has none.
pub(in crate::ppm) fn link(file: &File, name: &Path) -> io::Result<()> {
    rustix::fs::linkat(
        CWD,
        descriptor_path(file),
        CWD,
        name,
        AtFlags::SYMLINK_FOLLOW,
    )?;
    Ok(())
}

/// The opened directory, and a short name for it that is valid while it is open.
pub(in crate::ppm) fn short_name(folder: &Path) -> Option<(File, PathBuf)> {
    let flags = OFlags::PATH | OFlags::DIRECTORY | OFlags::CLOEXEC;
    let open = rustix::fs::open(folder, flags, Mode::empty()).ok()?;
    let open = File::from(open);
    let short = PathBuf::from(descriptor_path(&open));
    short.exists().then_some((open, short))
}

/// No attributes where they can't be read: the system refuses later what they forbid.
pub(in crate::ppm) fn attributes(path: &Path) -> Attributes {
    let flags = AtFlags::SYMLINK_NOFOLLOW;
    let Ok(found) = rustix::fs::statx(CWD, path, flags, StatxFlags::empty()) else {
        return Attributes::default();
    };
    let set = |attribute| found.stx_attributes.contains(attribute);
    Attributes {
        immutable: set(StatxAttributes::IMMUTABLE),
        append_only: set(StatxAttributes::APPEND),
        mount_root: set(StatxAttributes::MOUNT_ROOT),
    }
}

/// Reserves the bytes of a file. Returns whether a store into it will need no other
/// blocks than these.
pub(super) fn allocate(file: &File, bytes: u64) -> Result<bool, Errno> {
    let (keeps_blocks, flags) = match file_system(file) {
        EXT | TMPFS | F2FS => (true, FallocateFlags::empty()),
        // A store into a block that it shares with a copy would need a new block.
        XFS => (true, FallocateFlags::UNSHARE_RANGE),
        _ => (false, FallocateFlags::empty()),
    };
    rustix::fs::fallocate(file, flags, 0, bytes)?;
    Ok(keeps_blocks)
}

/// Waits until the file system can no longer refuse what was written. A local one refuses
/// at the time of writing; one on a network may refuse when the bytes are sent.
pub(in crate::ppm) fn settle(file: &File) -> io::Result<()> {
    const LOCAL: [u32; 10] = [
        EXT,
        TMPFS,
        F2FS,
        XFS,
        0x9123_683e, // btrfs
        0x794c_7630, // overlayfs
        0x2fc1_2fc1, // zfs
        0xca45_1a4e, // bcachefs
        0x4d44,      // vfat
        0x2011_bab0, // exfat
    ];
    if LOCAL.contains(&file_system(file)) {
        return Ok(());
    }
    match rustix::fs::fdatasync(file) {
        Ok(()) | Err(Errno::INVAL | Errno::NOSYS | Errno::OPNOTSUPP) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

const EXT: u32 = 0xef53; // ext2, ext3 and ext4
const TMPFS: u32 = 0x0102_1994;
const F2FS: u32 = 0xf2f5_2010;
const XFS: u32 = 0x5846_5342;

/// The kind of file system that a file is on; 0 if that is unknown.
fn file_system(file: &File) -> u32 {
    rustix::fs::fstatfs(file).map_or(0, |system| system.f_type as u32)
}

#[cfg(test)]
mod tests {
    use std::fs;

    use rustix::{
        fs::fcntl_getfl,
        io::{FdFlags, fcntl_getfd},
    };

    use super::*;

    #[test]
    fn a_short_name_needs_no_right_to_read_the_directory() {
        let folder = tempfile::tempdir().expect("a folder");
        let (open, short) = short_name(folder.path()).expect("/proc");
        fs::write(short.join("file"), "").expect("a file in it");
        assert!(folder.path().join("file").exists());
        let flags = fcntl_getfl(&open).expect("flags");
        assert!(flags.contains(OFlags::PATH), "{flags:?}");
        assert_eq!(fcntl_getfd(&open), Ok(FdFlags::CLOEXEC));
        assert!(short_name(&short.join("file")).is_none());
    }

    /// Only then rows are mapped.
    #[test]
    fn memory_keeps_the_blocks_that_were_reserved() {
        match tempfile::tempfile_in("/dev/shm") {
            Ok(file) => assert_eq!(allocate(&file, 5000), Ok(true)),
            Err(error) => eprintln!("skipped: no /dev/shm here: {error}"),
        }
    }
}
