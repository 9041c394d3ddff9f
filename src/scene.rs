//! Scene text to [`Scene`].

use std::path::Path;

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
#[derive(Clone, Debug)]
pub struct Scene {
    /// What the camera looks through.
    pub viewport: Viewport,
    /// Colour of a pixel whose ray meets no sphere.
    pub background: Rgb,
    /// The spheres, in file order.
    pub spheres: Spheres,
}

/// Why a scene was refused.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct SceneError(String);

impl Scene {
    /// Reads a scene from its text.
    ///
    /// # Errors
    ///
    /// If the text is not a scene.
    pub fn parse(text: &[u8]) -> Result<Self, SceneError> {
        let text = std::str::from_utf8(text).map_err(|e| SceneError(e.to_string()))?;
        let mut tokens = text
            .lines()
            .flat_map(|l| l.split('#').next().unwrap_or("").split_whitespace());
        let mut word = || {
            tokens
                .next()
                .ok_or_else(|| SceneError("end of file".into()))
        };
        fn number<T: std::str::FromStr>(word: &str) -> Result<T, SceneError> {
            word.parse()
                .map_err(|_| SceneError(format!("not a number: {word}")))
        }
        word()?;
        let viewport = Viewport {
            width: number(word()?)?,
            height: number(word()?)?,
            distance: number(word()?)?,
        };
        word()?;
        let background = [number(word()?)?, number(word()?)?, number(word()?)?];
        word()?;
        let n: usize = number(word()?)?;
        let mut spheres = Spheres::default();
        for _ in 0..n {
            word()?;
            spheres.push(Sphere {
                centre: [number(word()?)?, number(word()?)?, number(word()?)?],
                radius: number(word()?)?,
                colour: [number(word()?)?, number(word()?)?, number(word()?)?],
            });
        }
        Ok(Self {
            viewport,
            background,
            spheres,
        })
    }

    /// Reads a scene file.
    ///
    /// # Errors
    ///
    /// If the file can't be read or is not a scene.
    pub fn read(path: &Path) -> Result<Self, SceneError> {
        Self::parse(&std::fs::read(path).map_err(|e| SceneError(e.to_string()))?)
    }
}
