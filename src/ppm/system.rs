//! What the operating system is asked for, beside what `std` can ask. Nothing
//! else in this folder is of one kind of system.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Write},
    os::{
        fd::AsRawFd,
        unix::{
            ffi::OsStrExt,
            fs::{FileExt, MetadataExt, OpenOptionsExt, PermissionsExt},
        },
    },
    path::Path,
};

use rustix::{
    fs::{Access, AtFlags, CWD, FallocateFlags, Mode, OFlags},
    io::Errno,
};

/// A file without a name, on the file system of `folder`; none where there are
/// no such files, or no way to name one later.
pub(super) fn unnamed_file(folder: &Path) -> Option<File> {
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

/// Makes a file that was not there.
pub(super) fn new_file(path: &Path) -> io::Result<File> {
    OpenOptions::new()
        .read(true)
        .write(true)
        .create_new(true)
        .mode(0o666)
        .open(path)
}

/// Fills `buffer` from the bytes of a file at `offset`.
pub(super) fn read_at(file: &File, buffer: &mut [u8], offset: u64) -> io::Result<()> {
    file.read_exact_at(buffer, offset)
}

/// Writes all `bytes` to a file at `offset`.
pub(super) fn write_at(file: &File, bytes: &[u8], offset: u64) -> io::Result<()> {
    file.write_all_at(bytes, offset)
}

/// Whether a name ends as only that of a directory can.
pub(super) fn names_directory(path: &Path) -> bool {
    path.as_os_str().as_bytes().ends_with(b"/")
}

/// Whether a file may be written, asking its permissions and not only the
/// system: that keeps root, who may do everything, from replacing a file that
/// is protected on purpose.
pub(super) fn may_write(path: &Path, metadata: &fs::Metadata) -> io::Result<bool> {
    let anybody_may = metadata.permissions().mode() & 0o222 != 0;
    match rustix::fs::accessat(CWD, path, Access::WRITE_OK, AtFlags::EACCESS) {
        Ok(()) => Ok(anybody_may),
        Err(Errno::ACCESS | Errno::PERM) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

fn descriptor_path(file: &File) -> String {
    format!("/proc/self/fd/{}", file.as_raw_fd())
}

/// Gives a file without a name its first.
pub(super) fn link(file: &File, name: &Path) -> io::Result<()> {
    rustix::fs::linkat(
        CWD,
        descriptor_path(file),
        CWD,
        name,
        AtFlags::SYMLINK_FOLLOW,
    )?;
    Ok(())
}

/// The error of links that run in a circle.
pub(super) fn too_many_links() -> io::Error {
    Errno::LOOP.into()
}

/// The permissions and, where that is allowed, the owner of the file replaced.
pub(super) fn keep_permissions(file: &File, before: &fs::Metadata) -> io::Result<()> {
    let now = file.metadata()?;
    if (now.uid(), now.gid()) != (before.uid(), before.gid()) {
        let _ = std::os::unix::fs::fchown(file, Some(before.uid()), Some(before.gid()));
    }
    let mode = before.permissions().mode() & 0o777;
    if now.permissions().mode() & 0o777 != mode {
        file.set_permissions(fs::Permissions::from_mode(mode))?;
    }
    Ok(())
}

/// Reserves every block of a new file: by asking for them or, where a file
/// system can't be asked, by writing zeros.
pub(super) fn reserve(file: &File, bytes: u64) -> io::Result<()> {
    match retried(|| rustix::fs::fallocate(file, FallocateFlags::empty(), 0, bytes)) {
        Err(Errno::OPNOTSUPP | Errno::NOSYS) => write_zeros(file, bytes),
        reserved => Ok(reserved?),
    }
}

fn write_zeros(mut file: &File, bytes: u64) -> io::Result<()> {
    let zeros = vec![0; 1 << 20];
    let mut left = bytes;
    while left > 0 {
        let piece = left.min(zeros.len() as u64);
        file.write_all(&zeros[..piece as usize])?;
        left -= piece;
    }
    Ok(())
}

/// Again, as long as a signal comes between.
fn retried<T>(mut call: impl FnMut() -> Result<T, Errno>) -> Result<T, Errno> {
    loop {
        match call() {
            Err(Errno::INTR) => {}
            result => return result,
        }
    }
}

/// Reserves the blocks that a file lacks, where the file system can be asked.
pub(super) fn fill_holes(file: &File, bytes: u64) -> io::Result<()> {
    match retried(|| rustix::fs::fallocate(file, FallocateFlags::empty(), 0, bytes)) {
        Ok(()) | Err(Errno::OPNOTSUPP | Errno::NOSYS) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

/// Whether all processes that map a file see the same pages of it. On network
/// file systems they may not: a machine that writes a page back overwrites what
/// another wrote into the rest of it. There rows are written, to the byte.
pub(super) fn shares_pages(file: &File) -> bool {
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

/// The words of the operating system, without the number of the error.
pub(super) fn reason(error: &io::Error) -> String {
    let text = error.to_string();
    match text.split_once(" (os error") {
        Some((words, _)) => words.to_lowercase(),
        None => text,
    }
}

/// What a user can do about an error of the operating system.
pub(super) fn remedy(error: &io::Error) -> &'static str {
    match Errno::from_io_error(error) {
        Some(Errno::NOSPC | Errno::DQUOT) => {
            "; free some space, or name a file on another file system"
        }
        Some(Errno::FBIG) => {
            "; raise the limit on file sizes (ulimit -f), or name a file on a file system without one"
        }
        Some(Errno::NOMEM) => "; raise the limit on addresses (ulimit -v), or free some memory",
        Some(Errno::NOENT) => "; make the directory first, or name another",
        Some(Errno::NOTDIR) => "; a part of the path is not a directory",
        Some(Errno::ACCESS | Errno::PERM) => {
            "; ask for permission to write there, or name a file in another directory"
        }
        Some(Errno::ROFS) => "; name a file on a file system that can be written",
        Some(Errno::NAMETOOLONG) => "; choose a shorter name",
        Some(Errno::LOOP) => "; the symbolic links run in a circle",
        Some(Errno::MFILE | Errno::NFILE) => "; raise the limit on open files (ulimit -n)",
        _ => "",
    }
}
