//! Why an image can't be written or read, and what would mend it.

use std::{
    io,
    path::{Path, PathBuf},
};

use super::system::{reason, remedy};
use crate::camera::ImageSize;

/// Why an image can't be written or read. The message names the file and what would
/// mend it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The name is that of a directory.
    #[error("{}: this is a directory; name a file in it", path.display())]
    Directory {
        /// The name asked for.
        path: PathBuf,
    },
    /// The name is that of a device, a socket or another thing that can't be
    /// mapped or replaced.
    #[error("{}: this is neither a file nor a stream; name another file", path.display())]
    NotAFile {
        /// The name asked for.
        path: PathBuf,
    },
    /// An image is there already, and may not be written.
    #[error(
        "{}: this file is write-protected, and is left as it is; name another file, or allow it with chmod u+w",
        path.display()
    )]
    WriteProtected {
        /// The name asked for.
        path: PathBuf,
    },
    /// The file whose rows were to be drawn is not a picture of this size.
    #[error(
        "{}: this file is not a {} x {} picture ({found}), and is left as it is; name another file, or move it away",
        path.display(), size.width(), size.height()
    )]
    OtherPicture {
        /// The file.
        path: PathBuf,
        /// The size asked for.
        size: ImageSize,
        /// What it is instead.
        found: String,
    },
    /// What was to be read is not a binary PPM of the size asked for.
    #[error("{}: {problem}", path.display())]
    Unlike {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and what would mend it.
        problem: String,
    },
    /// The operating system refused.
    #[error("{}: can't {action}: {}{}", path.display(), reason(source), remedy(source))]
    System {
        /// The file.
        path: PathBuf,
        /// What was refused.
        action: &'static str,
        /// Why.
        source: io::Error,
    },
}

/// Turns an error into one about a file: `.map_err(refused(path, "open it"))`.
pub(super) fn refused<E: Into<io::Error>>(
    path: &Path,
    action: &'static str,
) -> impl FnOnce(E) -> ImageError {
    move |error| ImageError::System {
        path: path.to_owned(),
        action,
        source: error.into(),
    }
}

/// What was refused, in the words of [`ImageError::System`].
pub(super) const OPEN: &str = "open it";
pub(super) const READ: &str = "read it";
pub(super) const WRITE: &str = "write it";
pub(super) const RESERVE: &str = "reserve its blocks";
pub(super) const NAME: &str = "give it its name";
