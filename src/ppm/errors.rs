//! Why an image can't be written or read, and how to fix that.

use std::{
    io,
    path::{Path, PathBuf},
};

use super::system::remedy::{reason, remedy};
use crate::{camera::ImageSize, name::shown};

/// Why an image can't be written or read. The message names the file and says how to
/// fix it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The name is that of a directory.
    #[error("{}: this is a directory; name a file in it", shown(path))]
    Directory {
        /// The name asked for.
        path: PathBuf,
    },
    /// The name ends with a slash, as only that of a directory may, but it is a file.
    #[error(
        "{}: this is a file, and only the name of a directory ends with a slash; leave the slash out",
        shown(path)
    )]
    TrailingSlash {
        /// The name asked for.
        path: PathBuf,
    },
    /// The name is that of a socket or another object that can be neither mapped nor
    /// replaced.
    #[error(
        "{}: this is neither a file nor a stream; name another file",
        shown(path)
    )]
    NotAFile {
        /// The name asked for.
        path: PathBuf,
    },
    /// The operating system follows one of the symbolic links on the way to another file
    /// than the one with that name: to one that was removed, or to one of another process.
    #[error(
        "{}: its symbolic links lead to a file that has no such name (any more); name the file itself, or write to standard output (-)",
        shown(path)
    )]
    NoSuchName {
        /// The name asked for.
        path: PathBuf,
    },
    /// The file exists already, and may not be written.
    #[error(
        "{}: this file is write-protected, and is left as it is; name another file, or allow it with chmod u+w",
        shown(path)
    )]
    WriteProtected {
        /// The name asked for.
        path: PathBuf,
    },
    /// The file exists already, with an attribute that keeps even its owner and root from
    /// replacing it.
    #[error(
        "{}: this file is kept from being changed by an attribute ({attribute}), and is left as it is; name another file, or take the attribute away with chattr -{attribute}",
        shown(path)
    )]
    Locked {
        /// The name asked for.
        path: PathBuf,
        /// As `chattr` calls it: `i` or `a`.
        attribute: char,
    },
    /// The file exists already, in a directory where only its owner may replace it.
    #[error(
        "{}: this file is another user's, in a directory where users may replace only their own (chmod +t); name another file",
        shown(path)
    )]
    OthersFile {
        /// The name asked for.
        path: PathBuf,
    },
    /// The name is that of a file that is itself a mount point.
    #[error(
        "{}: this file is mounted by itself, as into a container, and can't be replaced; mount its directory instead, or write into it: give the image the name - and redirect standard output to it (>)",
        shown(path)
    )]
    Mounted {
        /// The name asked for.
        path: PathBuf,
    },
    /// An attribute of the directory prevents files in it from being made, or from being
    /// replaced or removed.
    #[error(
        "{}: its directory is kept from being changed by an attribute ({attribute}); name a file in another directory, or take the attribute away with chattr -{attribute}",
        shown(path)
    )]
    LockedDirectory {
        /// The name asked for.
        path: PathBuf,
        /// As `chattr` calls it: `i`, or `a` where files can be added.
        attribute: char,
    },
    /// The file is not the one that was there when the drawing began.
    #[error(
        "{}: {what} while it was drawn; draw it again, or name another file",
        shown(path)
    )]
    Changed {
        /// The name asked for.
        path: PathBuf,
        /// What happened to it.
        what: &'static str,
    },
    /// The file whose rows were to be drawn is not a picture of this size.
    #[error(
        "{}: this file is not a {} x {} picture ({found}), and is left as it is; name another file, or move it away",
        shown(path), size.width(), size.height()
    )]
    OtherPicture {
        /// The file.
        path: PathBuf,
        /// The size asked for.
        size: ImageSize,
        /// What was found instead.
        found: String,
    },
    /// The picture that was to be read is not a binary PPM of the size asked for.
    #[error("{}: {problem}", shown(path))]
    Unlike {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and how to fix it.
        problem: String,
    },
    /// No file can be made, although there is room for bytes.
    #[error(
        "{}: can't make a file in its directory: its file system has no inode left; remove some files, or name a file on another file system",
        shown(path)
    )]
    NoInodes {
        /// The name asked for.
        path: PathBuf,
    },
    /// The image could not be given its name, and its temporary name could not be removed.
    #[error(
        "{}: can't give it its name: {}{}; the image is in {}, which can't be removed",
        shown(path),
        reason(source),
        remedy(source),
        shown(temporary)
    )]
    Stranded {
        /// The name asked for.
        path: PathBuf,
        /// The name that it has instead.
        temporary: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The operating system refused.
    #[error(
        "{}: can't {action}: {}{}",
        shown(path),
        reason(source),
        remedy(source)
    )]
    System {
        /// The file.
        path: PathBuf,
        /// What was refused.
        action: &'static str,
        /// Why.
        source: io::Error,
    },
}

/// Turns an error into one about a file: `.map_err(refused(path, OPEN))`.
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

/// What was refused: the `action` of [`ImageError::System`].
pub(super) const FOLLOW: &str = "follow its symbolic links";
pub(super) const LOOK: &str = "look at it";
pub(super) const OPEN: &str = "open it";
pub(super) const READ: &str = "read it";
pub(super) const WRITE: &str = "write it";
pub(super) const RESERVE: &str = "reserve its blocks";
pub(super) const NAME: &str = "give it its name";
