//! What the tests and benches of this crate need: scenes that grow harder by one knob,
//! random numbers, and the knobs of the engine and of the reader.
//!
//! This is no part of the public interface, and may change with every version.

pub mod families;
pub mod random;

use crate::{
    camera::ImageSize,
    render::{Method, Renderer},
    scene::{Scene, SceneError},
};
pub use crate::{
    exact::tuning::{Bounds, Tuning},
    scene::windows::Sizes,
};

/// As [`Renderer::new`], with the engine's knobs in hand.
#[must_use]
pub fn tuned(scene: &Scene, size: ImageSize, method: Method, tuning: Tuning) -> Renderer<'_> {
    Renderer::tuned(scene, size, method, tuning)
}

/// As [`Scene::parse`], with the reader's knobs in hand.
///
/// # Errors
///
/// If the text is not a scene, or too large for memory.
pub fn parse_in_windows(text: &[u8], sizes: Sizes) -> Result<Scene, SceneError> {
    Scene::parse_in_windows(text, sizes)
}
