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
//! Words are separated by any white space, as C's `scanf` takes it: lines are
//! only for readers. `#` begins a comment, which ends with the line. Numbers are
//! decimal and mean the nearest `f32`; lengths are greater than zero, colours
//! are integers from 0 to 255. A UTF-8 byte order mark at the very beginning is
//! skipped.

mod advice;
mod error;
mod lines;
mod number;
mod parser;
mod windows;

use std::{fmt, fs::File, io, path::Path};

#[doc(hidden)]
pub use self::windows::Sizes;
pub use self::{
    error::{SceneError, SceneErrorKind},
    lines::lines_of_spheres,
};
use crate::spheres::{Rgb, Sphere, Spheres};

/// The viewport: `width` by `height`, centred on the z axis at `distance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewport {
    /// Width, greater than zero.
    pub width: f32,
    /// Height, greater than zero.
    pub height: f32,
    /// Distance from the camera along +z, greater than zero.
    pub distance: f32,
}

/// A scene: one viewport, a background, spheres in file order.
///
/// Displayed, it is its own text: reading that gives the same scene again.
#[derive(Clone, Debug)]
pub struct Scene {
    /// What the camera looks through.
    pub viewport: Viewport,
    /// Colour of a pixel whose ray meets no sphere.
    pub background: Rgb,
    /// The spheres, in file order.
    pub spheres: Spheres,
}

impl Scene {
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

    /// As [`parse`](Self::parse), with the reader's knobs in hand, for tests.
    ///
    /// # Errors
    ///
    /// If the text is not a scene, or too large for memory.
    #[doc(hidden)]
    pub fn parse_in_windows(text: &[u8], sizes: Sizes) -> Result<Self, SceneError> {
        let size = u64::try_from(text.len()).ok();
        windows::read(&mut &*text, size, sizes, |_| |_: &Sphere| true)
    }

    /// Reads a scene file, which may be a pipe.
    ///
    /// # Errors
    ///
    /// If the file can't be read, is not a scene, or is too large for memory.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        let mut file = open(path)?;
        let size = file.metadata().ok().map(|metadata| metadata.len());
        windows::read(&mut file, size, Sizes::USUAL, |_| |_: &Sphere| true)
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
    pub fn read_kept<K>(path: &Path, filter: impl FnOnce(Viewport) -> K) -> Result<Self, SceneError>
    where
        K: Fn(&Sphere) -> bool + Sync,
    {
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
    /// let refused = Scene::read_stream(&mut stream, "a string".as_ref(), everything);
    /// let message = refused.unwrap_err().to_string();
    /// assert!(message.starts_with("a string:1:25: expected the number of spheres"));
    /// ```
    ///
    /// # Errors
    ///
    /// If the stream can't be read, is not a scene, or is too large for memory.
    pub fn read_stream<K>(
        stream: &mut (impl io::Read + Send),
        name: &Path,
        filter: impl FnOnce(Viewport) -> K,
    ) -> Result<Self, SceneError>
    where
        K: Fn(&Sphere) -> bool + Sync,
    {
        windows::read(stream, None, Sizes::USUAL, filter).map_err(|error| error.in_file(name))
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
