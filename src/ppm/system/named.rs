//! Systems where an unfinished file needs a name. (Some have others, but no way to give
//! them a name later.)

use std::{
    fs::File,
    io,
    path::{Path, PathBuf},
};

use super::Attributes;

/// No file without a name.
pub(in crate::ppm) fn unnamed_file(_folder: &Path, _private: bool) -> Option<File> {
    None
}

/// There is no such file to be given a name.
pub(in crate::ppm) fn link(_file: &File, _name: &Path) -> io::Result<()> {
    Err(io::ErrorKind::Unsupported.into())
}

/// Names are as long as they are.
pub(in crate::ppm) fn short_name(_folder: &Path) -> Option<(File, PathBuf)> {
    None
}

/// They are not asked: the system refuses later what they forbid.
pub(in crate::ppm) fn attributes(_path: &Path) -> Attributes {
    Attributes::default()
}

/// What was written is not waited for.
pub(in crate::ppm) fn settle(_file: &File) -> io::Result<()> {
    Ok(())
}
