//! Why a scene is refused, as a message that can be acted on.

use std::{
    fmt, io,
    path::{Path, PathBuf},
};

use super::excerpt::Excerpt;
use crate::name::shown;

/// What is wrong with a scene.
#[derive(Debug)]
#[non_exhaustive]
pub enum SceneErrorKind {
    /// The file can't be opened or read.
    Read(io::Error),
    /// There is not enough memory for the spheres of the file.
    Memory,
    /// The file is of another kind: an image, compressed, UTF-16, ...
    NotAScene,
    /// The file is empty, or holds only blanks and comments.
    Empty,
    /// Another word stands where `VP`, `BG`, `OBJ_N` or `S` must stand.
    Keyword,
    /// A word is not a decimal number.
    Number,
    /// A number is beyond the range of `f32`.
    TooLarge,
    /// A length that must be greater than zero is not.
    NotPositive,
    /// A word is not an integer.
    Integer,
    /// A colour is not in `0..=255`, or the number of spheres is out of range.
    OutOfRange,
    /// The file ends within the header or within a sphere.
    Incomplete,
    /// The file ends before the spheres that `OBJ_N` announces.
    TooFewSpheres,
    /// The file holds more spheres than `OBJ_N` announces.
    TooManySpheres,
    /// Something that is not a sphere follows the last sphere.
    Trailing,
    /// A word is longer than any number needs to be.
    WordTooLong,
}

/// Why a scene was refused, and where.
///
/// Displayed, it is a message of several lines: file, line, column, what was
/// expected and what was found; the line with a caret under the column; and
/// how to mend it. Only printable text is shown, whatever the file holds.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct SceneError(Box<Refusal>);

#[derive(Debug)]
struct Refusal {
    path: Option<PathBuf>,
    place: Option<Place>,
    kind: SceneErrorKind,
    message: String,
    help: Option<String>,
}

/// Where in a file, with a piece of the line to show.
#[derive(Debug)]
pub(super) struct Place {
    pub(super) line: u64,
    pub(super) column: u64,
    pub(super) excerpt: Option<Excerpt>,
}

impl SceneError {
    pub(super) fn new(
        place: Option<Place>,
        kind: SceneErrorKind,
        message: String,
        help: Option<String>,
    ) -> Self {
        Self(Box::new(Refusal {
            path: None,
            place,
            kind,
            message,
            help,
        }))
    }

    pub(super) fn unreadable(error: io::Error) -> Self {
        let help = match error.kind() {
            io::ErrorKind::NotFound => Some("check the spelling of the file and of its folder"),
            io::ErrorKind::IsADirectory => Some("this is a folder: name a scene file in it"),
            io::ErrorKind::PermissionDenied => {
                Some("you may not read this file: ask its owner, or see `chmod +r`")
            }
            _ => None,
        };
        let message = format!("can't read the scene: {error}");
        let kind = SceneErrorKind::Read(error);
        Self::new(None, kind, message, help.map(str::to_owned))
    }

    pub(super) fn in_file(mut self, path: &Path) -> Self {
        self.0.path = Some(path.to_owned());
        self
    }

    /// The file, if the scene was read from one.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        self.0.path.as_deref()
    }

    /// The line, from 1; lines end in line feeds. Nothing if the file can't be read.
    #[must_use]
    pub fn line(&self) -> Option<u64> {
        self.0.place.as_ref().map(|place| place.line)
    }

    /// The column, from 1, in bytes. If the file ends too early it is the column behind
    /// the last word.
    #[must_use]
    pub fn column(&self) -> Option<u64> {
        self.0.place.as_ref().map(|place| place.column)
    }

    /// What is wrong.
    #[must_use]
    pub fn kind(&self) -> &SceneErrorKind {
        &self.0.kind
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(path) = &self.path {
            write!(f, "{}:", shown(path))?;
            if let Some(Place { line, column, .. }) = &self.place {
                write!(f, "{line}:{column}:")?;
            }
            f.write_str(" ")?;
        } else if let Some(Place { line, column, .. }) = &self.place {
            write!(f, "line {line}, column {column}: ")?;
        }
        f.write_str(&self.message)?;
        if let Some(Place { line, excerpt, .. }) = &self.place
            && let Some(Excerpt { text, caret }) = excerpt
        {
            let line = line.to_string();
            let margin = line.len();
            write!(
                f,
                "\n {line} | {text}\n {:margin$} | {:caret$}^",
                "",
                "",
                caret = *caret
            )?;
        }
        if let Some(help) = &self.help {
            write!(f, "\nhelp: {help}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_can_not_be_read_comes_with_what_can_be_done() {
        for (kind, words) in [
            (io::ErrorKind::NotFound, "check the spelling"),
            (io::ErrorKind::IsADirectory, "name a scene file in it"),
            (io::ErrorKind::PermissionDenied, "chmod +r"),
        ] {
            let error = SceneError::unreadable(kind.into()).to_string();
            let (_, help) = error.split_once("\nhelp: ").expect("advice");
            assert!(help.contains(words), "{help}");
        }
        let other = SceneError::unreadable(io::ErrorKind::BrokenPipe.into());
        assert!(!other.to_string().contains("help"), "{other}");
    }
}
