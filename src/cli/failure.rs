//! Why the program fails.

use std::{
    io,
    path::{Path, PathBuf},
};

use sfera::{ppm::ImageError, scene::SceneError};

/// Why the program ends with an exit code other than 0. Messages name the file.
#[derive(Debug)]
pub(crate) enum Failure {
    /// One line for the user, exit code 1.
    Message(String),
    /// Exit code 1, without a message: the report has been printed.
    Reported,
    /// Nobody reads the output: no message, and the exit code of a program that `SIGPIPE`
    /// ended, 141.
    NobodyReads,
}

pub(crate) const EXIT_NOBODY_READS: u8 = 141;

/// The name of standard input in messages.
pub(crate) const STANDARD_INPUT: &str = "standard input";

/// Every conversion is from an error that names its file, or from a message of our own.
impl From<ImageError> for Failure {
    fn from(error: ImageError) -> Self {
        Self::Message(error.to_string())
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Message(error.to_string())
    }
}

impl From<String> for Failure {
    fn from(message: String) -> Self {
        Self::Message(message)
    }
}

/// The name of a file in messages.
fn name_of(path: &Path) -> PathBuf {
    if path == Path::new("-") {
        "standard output".into()
    } else {
        path.to_owned()
    }
}

/// The failure to look up a file.
pub(crate) fn look_up_failed(path: &Path, error: io::Error) -> Failure {
    refused(path, "look at it", error)
}

/// The failure to read a file.
pub(crate) fn read_failed(path: &Path, error: io::Error) -> Failure {
    refused(path, "read it", error)
}

fn refused(path: &Path, action: &'static str, source: io::Error) -> Failure {
    let path = name_of(path);
    Failure::from(ImageError::System {
        path,
        action,
        source,
    })
}

/// The failure to write to a stream.
pub(crate) fn write_failed(path: &Path, error: io::Error) -> Failure {
    if error.kind() == io::ErrorKind::BrokenPipe {
        return Failure::NobodyReads;
    }
    refused(path, "write to it", error)
}
