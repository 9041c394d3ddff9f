//! Linux: files without a name, and file systems by their numbers.

use std::{fs::File, io, os::fd::AsRawFd, path::Path};

use rustix::fs::{Access, AtFlags, CWD, Mode, OFlags};

/// A file without a name, on the file system of `folder`; none where there are
/// no such files, or no way to name one later.
pub(in crate::ppm) fn unnamed_file(folder: &Path) -> Option<File> {
    let file = rustix::fs::open(
        folder,
        OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC,
        Mode::from_raw_mode(0o666),
    );
    let file = File::from(file.ok()?);
    // Without /proc there would be no way to give it a name.
    rustix::fs::access(descriptor_path(&file), Access::EXISTS).ok()?;
    Some(file)
}

fn descriptor_path(file: &File) -> String {
    format!("/proc/self/fd/{}", file.as_raw_fd())
}

/// Gives a file without a name its first.
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

/// Whether all processes that map a file see the same pages of it. On network
/// file systems they may not: a machine that writes a page back overwrites what
/// another wrote into the rest of it. There rows are written, to the byte.
pub(in crate::ppm) fn shares_pages(file: &File) -> bool {
    const LOCAL: [u32; 8] = [
        0xef53,      // ext2, ext3, ext4
        0x0102_1994, // tmpfs
        0x5846_5342, // xfs
        0x9123_683e, // btrfs
        0x794c_7630, // overlayfs
        0x2fc1_2fc1, // zfs
        0xf2f5_2010, // f2fs
        0xca45_1a4e, // bcachefs
    ];
    rustix::fs::fstatfs(file).is_ok_and(|system| LOCAL.contains(&(system.f_type as u32)))
}
