//! Scene text to [`Scene`].
//!
//! ```text
//! VP 1.777 1 1            # viewport: width, height, distance
//! BG 255 255 255          # background: red, green, blue
//! OBJ_N 2                 # how many spheres follow
//! S 0.2 1 4 0.2 200 0 0   # sphere: x, y, z, radius, red, green, blue
//! S 0 0 3 0.2 127 0 0
//! ```
//!
//! Words are separated by white space, as C's `scanf` defines it; line ends mean
//! no more than blanks. `#` begins a comment, which ends with the line. Numbers are
//! decimal and mean the nearest `f32`; lengths are greater than zero, colours
//! are integers from 0 to 255. A UTF-8 byte order mark at the very beginning is
//! skipped.
//!
//! The modules:
//!
//! | module | what it does |
//! | --- | --- |
//! | `text` | words, blanks and comments |
//! | `number` | decimal text to the nearest `f32`, for one word and in lanes |
//! | `grammar` | which words stand where, and their values |
//! | `windows` | reads the source in pieces that split no word |
//! | `chunks` | reads many spheres, in parallel, if all of them are well-formed |
//! | `parser` | reads word by word; its `messages` say what is wrong |
//! | `position` | lines and columns |
//! | `reader` | all of these together |
//! | `advice`, `comment`, `foreign` | advice on a word, a comment, a file of another kind |
//! | `excerpt`, `error` | the message |
//! | `lines` | the lines on which spheres begin |

mod advice;
mod chunks;
mod comment;
mod error;
mod excerpt;
mod foreign;
mod grammar;
mod lines;
mod number;
mod parser;
mod position;
mod reader;
mod text;
pub(crate) mod windows;

use std::{fmt, fs::File, io, path::Path, str::FromStr};

use self::windows::Sizes;
pub use self::{
    error::{SceneError, SceneErrorKind},
    lines::lines_of_spheres,
};
use crate::spheres::{LengthError, Rgb, Sphere, Spheres, positive};

/// The viewport, centred on the z axis. Its lengths are finite and greater than zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewport {
    pub(crate) width: f32,
    pub(crate) height: f32,
    pub(crate) distance: f32,
}

impl Viewport {
    /// The viewport of this width and height, at this distance from the camera along +z.
    ///
    /// # Errors
    ///
    /// If a length is not finite, or not greater than zero.
    pub fn new(width: f32, height: f32, distance: f32) -> Result<Self, LengthError> {
        Ok(Self {
            width: positive("the width of the viewport", width)?,
            height: positive("the height of the viewport", height)?,
            distance: positive("the distance of the viewport", distance)?,
        })
    }

    /// The width.
    #[must_use]
    pub fn width(&self) -> f32 {
        self.width
    }

    /// The height.
    #[must_use]
    pub fn height(&self) -> f32 {
        self.height
    }

    /// The distance from the camera along +z.
    #[must_use]
    pub fn distance(&self) -> f32 {
        self.distance
    }
}

/// A scene: one viewport, a background, spheres in file order.
///
/// Displayed, it is the text of the scene; reading that text gives the same scene again.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    pub(crate) viewport: Viewport,
    pub(crate) background: Rgb,
    pub(crate) spheres: Spheres,
}

/// More spheres than a scene can have, which is [`u32::MAX`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{count} spheres are more than a scene can have, which is {}",
    u32::MAX
)]
pub struct TooManySpheres {
    count: usize,
}

impl Scene {
    /// A scene of spheres that are in memory. Where two of them are equally near, the
    /// first is seen.
    ///
    /// ```
    /// use sfera::{scene::{Scene, Viewport}, spheres::Sphere};
    ///
    /// let viewport = Viewport::new(1.0, 1.0, 1.0)?;
    /// let ball = Sphere::new([0.0, 0.0, 5.0], 1.0, [200, 0, 0])?;
    /// let scene = Scene::new(viewport, [255; 3], [ball])?;
    /// assert_eq!(scene, "VP 1 1 1 BG 255 255 255 OBJ_N 1 S 0 0 5 1 200 0 0".parse()?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// If there are more than [`u32::MAX`] spheres.
    pub fn new(
        viewport: Viewport,
        background: Rgb,
        spheres: impl IntoIterator<Item = Sphere>,
    ) -> Result<Self, TooManySpheres> {
        let spheres: Spheres = spheres.into_iter().collect();
        let count = spheres.len();
        if u32::try_from(count).is_err() {
            return Err(TooManySpheres { count });
        }
        Ok(Self {
            viewport,
            background,
            spheres,
        })
    }

    /// What the camera looks through.
    #[must_use]
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    /// The colour of a pixel whose ray meets no sphere.
    #[must_use]
    pub fn background(&self) -> Rgb {
        self.background
    }

    /// The spheres, in file order.
    #[must_use]
    pub fn spheres(&self) -> &Spheres {
        &self.spheres
    }

    /// Reads a scene from its text.
    ///
    /// Long texts are read on all threads of rayon's current pool.
    ///
    /// # Errors
    ///
    /// If the text is not a scene, or too large for memory.
    pub fn parse(text: &[u8]) -> Result<Self, SceneError> {
        Self::parse_in_windows(text, Sizes::USUAL)
    }

    /// As [`parse`](Self::parse), with windows and chunks of these sizes, for tests.
    pub(crate) fn parse_in_windows(text: &[u8], sizes: Sizes) -> Result<Self, SceneError> {
        let size = u64::try_from(text.len()).ok();
        reader::read(&mut &*text, size, sizes, |_| |_: &Sphere| true)
    }

    /// Reads a scene file, which may be a pipe.
    ///
    /// # Errors
    ///
    /// If the file can't be read, is not a scene, or is too large for memory.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let mut file = open(path)?;
        let size = file.metadata().ok().map(|metadata| metadata.len());
        reader::read(&mut file, size, Sizes::USUAL, |_| |_: &Sphere| true)
            .map_err(|error| error.in_file(path))
    }

    /// Reads a scene file without the spheres that a filter, made for the
    /// viewport, does not keep. They take no memory, but are checked like the others.
    ///
    /// A sphere may be shown to the filter more than once, and in any order.
    ///
    /// # Errors
    ///
    /// If the file can't be read, is not a scene, or is too large for memory.
    pub fn read_kept<K>(
        path: impl AsRef<Path>,
        filter: impl FnOnce(Viewport) -> K,
    ) -> Result<Self, SceneError>
    where
        K: Fn(&Sphere) -> bool + Sync,
    {
        let path = path.as_ref();
        Self::read_stream(&mut open(path)?, path, filter)
    }

    /// Reads a scene from a stream as [`read_kept`](Self::read_kept) does from a
    /// file. Messages give it `name`.
    ///
    /// ```
    /// use sfera::scene::{Scene, Viewport};
    ///
    /// let everything = |_: Viewport| |_: &_| true;
    /// let mut stream = b"VP 1 1 1 BG 0 0 0 OBJ_N zero".as_slice();
    /// let refused = Scene::read_stream(&mut stream, "a string", everything);
    /// let message = refused.unwrap_err().to_string();
    /// assert!(message.starts_with("a string:1:25: expected the number of spheres"));
    /// ```
    ///
    /// # Errors
    ///
    /// If the stream can't be read, is not a scene, or is too large for memory.
    pub fn read_stream<K>(
        stream: &mut (impl io::Read + Send),
        name: impl AsRef<Path>,
        filter: impl FnOnce(Viewport) -> K,
    ) -> Result<Self, SceneError>
    where
        K: Fn(&Sphere) -> bool + Sync,
    {
        reader::read(stream, None, Sizes::USUAL, filter)
            .map_err(|error| error.in_file(name.as_ref()))
    }

    /// Writes the text of the scene.
    ///
    /// # Errors
    ///
    /// If `output` can't be written to.
    pub fn write_text(&self, output: &mut impl io::Write) -> io::Result<()> {
        write!(output, "{self}")
    }
}

fn open(path: &Path) -> Result<File, SceneError> {
    File::open(path).map_err(|error| SceneError::unreadable(error).in_file(path))
}

impl FromStr for Scene {
    type Err = SceneError;

    fn from_str(text: &str) -> Result<Self, SceneError> {
        Self::parse(text.as_bytes())
    }
}

impl fmt::Display for Scene {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Viewport {
            width,
            height,
            distance,
        } = self.viewport;
        writeln!(f, "VP {width} {height} {distance}")?;
        let [red, green, blue] = self.background;
        writeln!(f, "BG {red} {green} {blue}")?;
        writeln!(f, "OBJ_N {}", self.spheres.len())?;
        for sphere in self.spheres.iter() {
            let [x, y, z] = sphere.centre;
            let [red, green, blue] = sphere.colour;
            writeln!(f, "S {x} {y} {z} {} {red} {green} {blue}", sphere.radius)?;
        }
        Ok(())
    }
}
