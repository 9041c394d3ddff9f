//! Systems other than Unix: Windows, and those that `std` gives no more than files.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Read, Seek, SeekFrom, Write},
    path::Path,
    time::SystemTime,
};

use crate::ppm::errors::ImageError;

/// Makes a file that does not exist yet.
pub(in crate::ppm) fn new_file(path: &Path, _private: bool) -> io::Result<File> {
    OpenOptions::new()
        .read(true)
        .write(true)
        .create_new(true)
        .open(path)
}

/// Fills `buffer` with the bytes of a file at `offset`.
pub(in crate::ppm) fn read_at(mut file: &File, buffer: &mut [u8], offset: u64) -> io::Result<()> {
    file.seek(SeekFrom::Start(offset))?;
    file.read_exact(buffer)
}

/// Writes all `bytes` to a file at `offset`.
pub(in crate::ppm) fn write_at(mut file: &File, bytes: &[u8], offset: u64) -> io::Result<()> {
    file.seek(SeekFrom::Start(offset))?;
    file.write_all(bytes)
}

/// Whether a file may be written.
pub(in crate::ppm) fn may_write(_path: &Path, metadata: &fs::Metadata) -> io::Result<bool> {
    Ok(!metadata.permissions().readonly())
}

/// The error of links that run in a circle.
pub(in crate::ppm) fn too_many_links() -> io::Error {
    io::Error::other("the symbolic links run in a circle")
}

/// There is nothing to pass on: a protected file is not replaced.
#[derive(Debug)]
pub(in crate::ppm) struct Permissions;

impl Permissions {
    pub(in crate::ppm) fn of(_path: &Path, _metadata: &fs::Metadata) -> Result<Self, ImageError> {
        Ok(Self)
    }

    pub(in crate::ppm) fn pass_on(&self, _file: &File) -> io::Result<()> {
        Ok(())
    }
}

/// A new file can be written.
pub(in crate::ppm) fn make_writable(_file: &File) -> io::Result<()> {
    Ok(())
}

/// Not known.
pub(in crate::ppm) fn lacks_inodes(_folder: &Path, _error: &io::Error) -> bool {
    false
}

/// There are no directories of this kind.
pub(in crate::ppm) fn only_owner_replaces(_folder: &fs::Metadata, _file: &fs::Metadata) -> bool {
    false
}

/// What identifies a file: the times of its creation and last change, which have a
/// resolution of 10^-7 seconds, and its length. `std` knows no number of a file.
pub(in crate::ppm) type Identity = (Option<SystemTime>, Option<SystemTime>, u64);

pub(in crate::ppm) fn identity(metadata: &fs::Metadata) -> Identity {
    (
        metadata.created().ok(),
        metadata.modified().ok(),
        metadata.len(),
    )
}

/// Whether two files are one, although one of them may just be written to.
pub(in crate::ppm) fn is_same(one: &fs::Metadata, other: &fs::Metadata) -> bool {
    (one.created().ok(), one.len()) == (other.created().ok(), other.len())
}

/// Reserves every block of a new file, as Windows does when its length is set. Returns
/// whether it may then be mapped.
pub(in crate::ppm) fn reserve(file: &File, bytes: u64) -> io::Result<bool> {
    if cfg!(windows) {
        file.set_len(bytes)?;
    }
    Ok(cfg!(windows))
}
