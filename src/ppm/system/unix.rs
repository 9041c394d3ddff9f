//! Unix: permissions and owners, access to a file by offset, blocks.

use std::{
    fs::{self, File, OpenOptions},
    io,
    os::unix::fs::{FileExt, MetadataExt, OpenOptionsExt, PermissionsExt},
    path::Path,
};

use rustix::{
    fs::{Access, AtFlags, CWD},
    io::Errno,
};

use super::permissions::mode_of_new;

/// Makes a file that does not exist yet.
pub(in crate::ppm) fn new_file(path: &Path, private: bool) -> io::Result<File> {
    OpenOptions::new()
        .read(true)
        .write(true)
        .create_new(true)
        .mode(mode_of_new(private))
        .open(path)
}

/// Lets the owner write a file, whatever the umask.
pub(in crate::ppm) fn make_writable(file: &File) -> io::Result<()> {
    let mode = file.metadata()?.permissions().mode();
    if mode & 0o200 == 0 {
        file.set_permissions(fs::Permissions::from_mode(mode | 0o200))?;
    }
    Ok(())
}

/// Whether a file could not be made for lack of an inode, not of space.
pub(in crate::ppm) fn lacks_inodes(folder: &Path, error: &io::Error) -> bool {
    Errno::from_io_error(error) == Some(Errno::NOSPC)
        && rustix::fs::statvfs(folder)
            .is_ok_and(|system| are_used_up(system.f_files, system.f_favail))
}

/// Whether no inode is left of so many. A file system that does not count them has 0.
fn are_used_up(inodes: u64, left: u64) -> bool {
    inodes > 0 && left == 0
}

/// What identifies a file: its device and inode.
pub(in crate::ppm) type Identity = (u64, u64);

pub(in crate::ppm) fn identity(metadata: &fs::Metadata) -> Identity {
    (metadata.dev(), metadata.ino())
}

/// Whether two files are one.
pub(in crate::ppm) fn is_same(one: &fs::Metadata, other: &fs::Metadata) -> bool {
    identity(one) == identity(other)
}

/// Whether only its owner, the owner of the directory and root may replace a file, and
/// this process runs as none of them.
pub(in crate::ppm) fn only_owner_replaces(folder: &fs::Metadata, file: &fs::Metadata) -> bool {
    let is_sticky = folder.mode() & 0o1000 != 0;
    let may_replace = [0, file.uid(), folder.uid()];
    is_sticky && !may_replace.contains(&rustix::process::geteuid().as_raw())
}

/// Fills `buffer` with the bytes of a file at `offset`.
pub(in crate::ppm) fn read_at(file: &File, buffer: &mut [u8], offset: u64) -> io::Result<()> {
    file.read_exact_at(buffer, offset)
}

/// Writes all `bytes` to a file at `offset`.
pub(in crate::ppm) fn write_at(file: &File, bytes: &[u8], offset: u64) -> io::Result<()> {
    file.write_all_at(bytes, offset)
}

/// Whether a file may be written, by its permissions and not only by the system's answer:
/// so root, who may do everything, does not replace a file that is protected on purpose.
pub(in crate::ppm) fn may_write(path: &Path, metadata: &fs::Metadata) -> io::Result<bool> {
    let is_writable = metadata.permissions().mode() & 0o222 != 0;
    match rustix::fs::accessat(CWD, path, Access::WRITE_OK, AtFlags::EACCESS) {
        Ok(()) => Ok(is_writable),
        Err(Errno::ACCESS | Errno::PERM) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// The error for symbolic links that run in a circle.
pub(in crate::ppm) fn too_many_links() -> io::Error {
    Errno::LOOP.into()
}

/// Reserves every block of a file. Returns whether that was possible and a store into the
/// file will need no other blocks. Only then may it be mapped, since a store that finds no
/// room raises a signal.
pub(in crate::ppm) fn reserve(file: &File, bytes: u64) -> io::Result<bool> {
    match retried(|| allocate(file, bytes)) {
        Err(error) if is_unsupported(error) => Ok(false),
        reserved => Ok(reserved?),
    }
}

#[cfg(target_os = "linux")]
use super::linux::allocate;

/// It is not known whether a store into a file of these systems may need other blocks.
#[cfg(any(target_os = "android", target_os = "freebsd", target_vendor = "apple"))]
fn allocate(file: &File, bytes: u64) -> Result<bool, Errno> {
    rustix::fs::fallocate(file, rustix::fs::FallocateFlags::empty(), 0, bytes)?;
    Ok(false)
}

#[cfg(not(any(
    target_os = "linux",
    target_os = "android",
    target_os = "freebsd",
    target_vendor = "apple"
)))]
fn allocate(_file: &File, _bytes: u64) -> Result<bool, Errno> {
    Err(Errno::NOSYS)
}

/// Whether a file system has no way to reserve blocks; some call the request invalid.
fn is_unsupported(error: Errno) -> bool {
    error == Errno::OPNOTSUPP || error == Errno::NOSYS || error == Errno::INVAL
}

/// Repeats a call while signals interrupt it.
fn retried<T>(mut call: impl FnMut() -> Result<T, Errno>) -> Result<T, Errno> {
    loop {
        match call() {
            Err(Errno::INTR) => {}
            result => return result,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_counted_can_be_used_up() {
        assert!(are_used_up(100, 0));
        assert!(!are_used_up(100, 1));
        assert!(!are_used_up(0, 0));
    }

    #[test]
    fn a_directory_with_inodes_left_lacks_none() {
        let folder = tempfile::tempdir().expect("a folder");
        for error in [Errno::NOSPC, Errno::ACCESS] {
            assert!(!lacks_inodes(folder.path(), &error.into()), "{error}");
        }
    }

    #[test]
    fn a_lack_of_room_is_not_a_lack_of_support() {
        for error in [Errno::OPNOTSUPP, Errno::NOSYS, Errno::INVAL] {
            assert!(is_unsupported(error), "{error}");
        }
        for error in [Errno::NOSPC, Errno::DQUOT, Errno::FBIG, Errno::IO] {
            assert!(!is_unsupported(error), "{error}");
        }
    }
}
