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

use super::write_zeros;

/// Makes a file that was not there.
pub(in crate::ppm) fn new_file(path: &Path) -> io::Result<File> {
    OpenOptions::new()
        .read(true)
        .write(true)
        .create_new(true)
        .mode(0o666)
        .open(path)
}

/// Fills `buffer` from the bytes of a file at `offset`.
pub(in crate::ppm) fn read_at(file: &File, buffer: &mut [u8], offset: u64) -> io::Result<()> {
    file.read_exact_at(buffer, offset)
}

/// Writes all `bytes` to a file at `offset`.
pub(in crate::ppm) fn write_at(file: &File, bytes: &[u8], offset: u64) -> io::Result<()> {
    file.write_all_at(bytes, offset)
}

/// Whether a file may be written, asking its permissions and not only the
/// system: that keeps root, who may do everything, from replacing a file that
/// is protected on purpose.
pub(in crate::ppm) fn may_write(path: &Path, metadata: &fs::Metadata) -> io::Result<bool> {
    let anybody_may = metadata.permissions().mode() & 0o222 != 0;
    match rustix::fs::accessat(CWD, path, Access::WRITE_OK, AtFlags::EACCESS) {
        Ok(()) => Ok(anybody_may),
        Err(Errno::ACCESS | Errno::PERM) => Ok(false),
        Err(error) => Err(error.into()),
    }
}

/// The error of links that run in a circle.
pub(in crate::ppm) fn too_many_links() -> io::Error {
    Errno::LOOP.into()
}

/// The permissions and, where that is allowed, the owner of the file replaced.
pub(in crate::ppm) fn keep_permissions(file: &File, before: &fs::Metadata) -> io::Result<()> {
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
pub(in crate::ppm) fn reserve(file: &File, bytes: u64) -> io::Result<()> {
    match retried(|| allocate(file, bytes)) {
        Err(error) if can_not_be_asked(error) => write_zeros(file, bytes),
        reserved => Ok(reserved?),
    }
}

/// Reserves the blocks that a file lacks, where the file system can be asked.
pub(in crate::ppm) fn fill_holes(file: &File, bytes: u64) -> io::Result<()> {
    match retried(|| allocate(file, bytes)) {
        Err(error) if can_not_be_asked(error) => Ok(()),
        reserved => Ok(reserved?),
    }
}

#[cfg(any(
    target_os = "linux",
    target_os = "android",
    target_os = "freebsd",
    target_vendor = "apple"
))]
fn allocate(file: &File, bytes: u64) -> Result<(), Errno> {
    rustix::fs::fallocate(file, rustix::fs::FallocateFlags::empty(), 0, bytes)
}

#[cfg(not(any(
    target_os = "linux",
    target_os = "android",
    target_os = "freebsd",
    target_vendor = "apple"
)))]
fn allocate(_file: &File, _bytes: u64) -> Result<(), Errno> {
    Err(Errno::NOSYS)
}

/// Whether a file system has no way to reserve blocks; some call the question invalid.
fn can_not_be_asked(error: Errno) -> bool {
    error == Errno::OPNOTSUPP || error == Errno::NOSYS || error == Errno::INVAL
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

/// What a user can do about an error that only Unix knows.
pub(super) fn remedy(error: &io::Error) -> &'static str {
    match Errno::from_io_error(error) {
        Some(Errno::FBIG) => {
            "; raise the limit on file sizes (ulimit -f), or name a file on a file system without one"
        }
        Some(Errno::NOMEM) => "; raise the limit on addresses (ulimit -v), or free some memory",
        Some(Errno::LOOP) => "; the symbolic links run in a circle",
        Some(Errno::MFILE | Errno::NFILE) => "; raise the limit on open files (ulimit -n)",
        _ => "",
    }
}
