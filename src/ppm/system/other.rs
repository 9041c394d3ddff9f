//! Systems that are no Unix: Windows, and those that have files and no more.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, Read, Seek, SeekFrom, Write},
    path::Path,
};

use super::write_zeros;

/// Makes a file that was not there.
pub(in crate::ppm) fn new_file(path: &Path) -> io::Result<File> {
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
pub(in crate::ppm) fn keep_permissions(_file: &File, _before: &fs::Metadata) -> io::Result<()> {
    Ok(())
}

/// Reserves every block of a new file. Windows does so for the length of a file;
/// elsewhere zeros are written.
pub(in crate::ppm) fn reserve(file: &File, bytes: u64) -> io::Result<()> {
    if cfg!(windows) {
        file.set_len(bytes)
    } else {
        write_zeros(file, bytes)
    }
}

/// There is no asking for them.
pub(in crate::ppm) fn fill_holes(_file: &File, _bytes: u64) -> io::Result<()> {
    Ok(())
}

/// There is nothing to add to what every system knows.
pub(super) fn remedy(_error: &io::Error) -> &'static str {
    ""
}
