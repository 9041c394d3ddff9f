//! Why a scene is refused, as a message that can be acted on.

use std::{
    fmt, io,
    path::{Path, PathBuf},
};

use crate::name::{printable, shown};

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
    /// The file holds nothing, or nothing but blanks and comments.
    Empty,
    /// Something else stands where `VP`, `BG`, `OBJ_N` or `S` belongs.
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
    /// The file ends in the middle of something.
    Incomplete,
    /// The file ends before the spheres that `OBJ_N` promises.
    TooFewSpheres,
    /// The file holds more spheres than `OBJ_N` promises.
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
/// what would mend it. Whatever the file holds, only printable text is shown.
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

    /// The column, from 1, in bytes: what stands before it in its line are words
    /// of the scene, so that bytes are characters. If the file ends too early
    /// this is just behind its last word.
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

/// A piece of a line in printable text, and how many columns stand before the
/// place it is shown for.
#[derive(Debug)]
pub(super) struct Excerpt {
    text: String,
    caret: usize,
}

impl Excerpt {
    /// Bytes of a line that are shown: with the margin they fit in a terminal.
    pub(super) const REACH: usize = 72;

    /// The line around a place: `before` and `after` are the bytes of the line
    /// on either side, at least one more than [`REACH`](Self::REACH) of them if
    /// there are so many.
    pub(super) fn new(before: &[u8], after: &[u8]) -> Self {
        /// Bytes after the place that are shown rather than those before it.
        const AHEAD: usize = Excerpt::REACH / 3;
        const ELLIPSIS: &str = "...";
        // Beyond its reach it may be cut, and what it ends in no end of a line.
        let after = match after.strip_suffix(b"\r") {
            Some(line) if after.len() <= Self::REACH => line,
            _ => after,
        };
        let shown_before = before.len().min(Self::REACH - after.len().min(AHEAD));
        let shown_after = after.len().min(Self::REACH - shown_before);

        let mut text = String::new();
        if shown_before < before.len() {
            text.push_str(ELLIPSIS);
        }
        text.push_str(&printable(&before[before.len() - shown_before..]));
        let caret = text.chars().count();
        if shown_after < after.len() {
            text.push_str(&printable(without_broken_end(&after[..shown_after])));
            text.push_str(ELLIPSIS);
        } else {
            text.push_str(&printable(after.trim_ascii_end()));
        }
        Self { text, caret }
    }
}

/// Without the beginning of a character whose rest is cut off.
fn without_broken_end(bytes: &[u8]) -> &[u8] {
    match str::from_utf8(bytes) {
        Err(error) if error.error_len().is_none() => &bytes[..error.valid_up_to()],
        _ => bytes,
    }
}

/// Bytes of a word that a message quotes.
pub(super) const LONGEST_QUOTE: usize = 40;

/// A word in quotes, shortened if it is long.
pub(super) fn quoted(word: &[u8]) -> String {
    if word.len() > LONGEST_QUOTE {
        format!("{}, {} bytes", quoted_beginning(word), word.len())
    } else {
        format!("\"{}\"", printable(word))
    }
}

/// The beginning of a long word in quotes.
pub(super) fn quoted_beginning(word: &[u8]) -> String {
    let begin = &word[..word.len().min(LONGEST_QUOTE)];
    format!("\"{}...\"", printable(without_broken_end(begin)))
}

/// What a file that does not begin like a scene begins like.
pub(super) fn foreign(begin: &[u8]) -> Option<(&'static str, &'static str)> {
    const UNPACK: &str = "unpack it first";
    const SAVE_AS_UTF8: &str = "save it as UTF-8 or as ASCII";
    const NAME_A_SCENE: &str =
        "name a scene, a text that begins with VP; the image is the second argument";
    const SIGNATURES: [(&[u8], &str, &str); 21] = [
        (b"\xff\xfe\0\0", "a text in UTF-32", SAVE_AS_UTF8),
        (b"\xff\xfe", "a text in UTF-16", SAVE_AS_UTF8),
        (b"\xfe\xff", "a text in UTF-16", SAVE_AS_UTF8),
        (b"V\0", "a text in UTF-16", SAVE_AS_UTF8),
        (b"\0V", "a text in UTF-16", SAVE_AS_UTF8),
        (b"\x1f\x8b", "a gzip archive", UNPACK),
        (b"PK\x03\x04", "a zip archive", UNPACK),
        (b"\x28\xb5\x2f\xfd", "a Zstandard archive", UNPACK),
        (b"\xfd7zXZ", "an xz archive", UNPACK),
        (b"BZh", "a bzip2 archive", UNPACK),
        (b"7z\xbc\xaf", "a 7-Zip archive", UNPACK),
        (b"P6", "a PPM image", NAME_A_SCENE),
        (b"P3", "a PPM image", NAME_A_SCENE),
        (b"P5", "a PGM image", NAME_A_SCENE),
        (b"\x89PNG", "a PNG image", NAME_A_SCENE),
        (b"\xff\xd8\xff", "a JPEG image", NAME_A_SCENE),
        (b"GIF8", "a GIF image", NAME_A_SCENE),
        (
            b"\x7fELF",
            "a program",
            "name a scene, a text that begins with VP",
        ),
        (
            b"%PDF",
            "a PDF document",
            "name a scene, a text that begins with VP",
        ),
        (
            b"{",
            "JSON",
            "a scene is a text of VP, BG, OBJ_N and S lines",
        ),
        (
            b"<",
            "XML or HTML",
            "a scene is a text of VP, BG, OBJ_N and S lines",
        ),
    ];
    SIGNATURES
        .iter()
        .find(|(signature, ..)| begin.starts_with(signature))
        .map(|&(_, name, help)| (name, help))
}
