//! Systems where an unfinished file needs a name. (Some have files without one, but no way
//! to give them a name later.)

use std::{
    fs::File,
    io,
    path::{Path, PathBuf},
};

use super::attributes::Attributes;

/// There are no files without a name.
pub(in crate::ppm) fn unnamed_file(_folder: &Path, _private: bool) -> Option<File> {
    None
}

/// Never called with a file, since none is without a name.
pub(in crate::ppm) fn link(_file: &File, _name: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// There are no short names.
pub(in crate::ppm) fn short_name(_folder: &Path) -> Option<(File, PathBuf)> {
    None
}

/// Not read: the system refuses later what they forbid.
pub(in crate::ppm) fn attributes(_path: &Path) -> Attributes {
    Attributes::default()
}

/// Does not wait.
pub(in crate::ppm) fn settle(_file: &File) -> io::Result<()> {
    Ok(())
}
