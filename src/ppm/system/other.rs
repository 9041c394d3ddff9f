//! Systems that are no Unix: Windows, and those that have files and no more.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Read, Seek, SeekFrom, Write},
    path::Path,
    time::SystemTime,
};

use crate::ppm::ImageError;

/// Makes a file that was not there.
pub(in crate::ppm) fn new_file(path: &Path, _private: bool) -> io::Result<File> {
    OpenOptions::new()
        .read(true)
        .write(true)
        .create_new(true)
        .open(path)
}

/// Fills `buffer` from the bytes of a file at `offset`.
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

/// There is nothing to hand on: a file that is protected is not replaced.
#[derive(Debug)]
pub(in crate::ppm) struct Permissions;

impl Permissions {
    pub(in crate::ppm) fn of(_path: &Path, _metadata: &fs::Metadata) -> Result<Self, ImageError> {
        Ok(Self)
    }

    pub(in crate::ppm) fn hand_on(&self, _file: &File) -> io::Result<()> {
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

/// There are no such directories.
pub(in crate::ppm) fn only_owner_replaces(_folder: &fs::Metadata, _file: &fs::Metadata) -> bool {
    false
}

/// What tells a file from others: the times of its making and changing, which are told
/// to a ten-millionth of a second, and its length. `std` knows no number of a file.
pub(in crate::ppm) type Identity = (Option<SystemTime>, Option<SystemTime>, u64);

pub(in crate::ppm) fn identity(metadata: &fs::Metadata) -> Identity {
    (
        metadata.created().ok(),
        metadata.modified().ok(),
        metadata.len(),
    )
}

/// Whether two files are one, of which one may be written just now.
pub(in crate::ppm) fn is_same(one: &fs::Metadata, other: &fs::Metadata) -> bool {
    (one.created().ok(), one.len()) == (other.created().ok(), other.len())
}

/// Reserves every block of a new file, as Windows does for the length of a file. Whether
/// it may be mapped then.
pub(in crate::ppm) fn reserve(file: &File, bytes: u64) -> io::Result<bool> {
    if cfg!(windows) {
        file.set_len(bytes)?;
    }
    Ok(cfg!(windows))
}

/// There is nothing to add to what every system knows.
pub(super) fn remedy(_error: &io::Error) -> &'static str {
    ""
}
