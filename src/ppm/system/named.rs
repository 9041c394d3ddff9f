//! Systems where an unfinished file needs a name. (Some have others, but no way to give
//! them a name later.)

use std::{fs::File, io, path::Path};

/// No file without a name.
pub(in crate::ppm) fn unnamed_file(_folder: &Path) -> Option<File> {
    None
}

/// There is no such file to be given a name.
pub(in crate::ppm) fn link(_file: &File, _name: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Not known, so rows are written, to the byte.
pub(in crate::ppm) fn shares_pages(_file: &File) -> bool {
    false
}
