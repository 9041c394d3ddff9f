//! The time and the wrong pixels of frames.

use std::time::{Duration, Instant};

use sfera::{
    camera::ImageSize,
    render::{Method, Renderer},
    scene::Scene,
};

/// A picture, from the scene in memory to the last byte; on all threads.
pub(crate) fn frame(scene: &Scene, size: ImageSize, method: Method, pixels: &mut [u8]) -> Duration {
    let start = Instant::now();
    Renderer::new(scene, size, method).draw(0..size.height(), pixels);
    start.elapsed()
}

/// The same picture, in memory of its own.
pub(crate) fn picture(scene: &Scene, size: ImageSize, method: Method) -> Vec<u8> {
    let mut pixels = vec![0; size.pixel_bytes()];
    frame(scene, size, method, &mut pixels);
    pixels
}

/// Above this many spheres a frame of the reference takes minutes.
const REFERENCE_SPHERES: usize = 64;

/// The picture that methods are compared with: that of the reference, or of exact if there are
/// too many spheres for the reference. Then exact is compared with the reference on a small image.
pub(crate) fn judge(scene: &Scene) -> Method {
    if scene.spheres().len() <= REFERENCE_SPHERES {
        Method::Reference
    } else {
        Method::Exact
    }
}

/// The median time of frames: of at least three, for at most about a second.
pub(crate) fn median(mut frame: impl FnMut() -> Duration) -> Duration {
    const LEAST: usize = 3;
    const BUDGET: Duration = Duration::from_secs(1);
    let start = Instant::now();
    let mut times = Vec::new();
    while times.len() < LEAST || start.elapsed() < BUDGET {
        times.push(frame());
    }
    times.sort_unstable();
    times[times.len() / 2]
}
