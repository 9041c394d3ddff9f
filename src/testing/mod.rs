//! Helpers of the tests and benches of this crate: scenes of increasing difficulty, random
//! numbers, and settings of the engine and of the reader.
//!
//! This module is not part of the public interface and may change with every version.

pub mod families;

use crate::{
    camera::ImageSize,
    render::{Method, Renderer, Workspace},
    scene::{Scene, SceneError},
};
pub use crate::{
    exact::tuning::{Bounds, Tuning},
    random::Random,
    scene::windows::Sizes,
};

/// Like [`Renderer::new`], with settings of the engine.
#[must_use]
pub fn tuned(scene: &Scene, size: ImageSize, method: Method, tuning: Tuning) -> Renderer<'_> {
    tuned_in(Workspace::default(), scene, size, method, tuning)
}

/// Like [`Renderer::new_in`], with settings of the engine.
#[must_use]
pub fn tuned_in(
    workspace: Workspace,
    scene: &Scene,
    size: ImageSize,
    method: Method,
    tuning: Tuning,
) -> Renderer<'_> {
    Renderer::tuned(workspace, scene, size, method, tuning)
}

/// Like [`Scene::parse`], with settings of the reader.
///
/// # Errors
///
/// If the text is not a scene, or too large for memory.
pub fn parse_in_windows(text: &[u8], sizes: Sizes) -> Result<Scene, SceneError> {
    Scene::parse_in_windows(text, sizes)
}
