//! `--diff`: marks the pixels that a method draws wrong.

use sfera::{
    camera::{BYTES_PER_PIXEL, ImageSize},
    render::{Method, Renderer},
    scene::Scene,
};

/// Marks pixels that differ from the exact picture.
#[derive(Debug)]
pub(crate) struct Marker<'scene> {
    exact: Renderer<'scene>,
    right: Vec<u8>,
    pub(crate) wrong: u64,
}

/// The colour of a wrong pixel.
const WRONG: [u8; BYTES_PER_PIXEL] = [255, 0, 0];

impl<'scene> Marker<'scene> {
    pub(crate) fn new(scene: &'scene Scene, size: ImageSize) -> Self {
        Self {
            exact: Renderer::new(scene, size, Method::Exact),
            right: Vec::new(),
            wrong: 0,
        }
    }

    /// Replaces `pixels`, drawn by a method, with marks.
    pub(crate) fn mark(&mut self, rows: std::ops::Range<u32>, pixels: &mut [u8]) {
        self.right.resize(pixels.len(), 0);
        self.exact.draw(rows, &mut self.right);
        self.wrong += mark(pixels, &self.right);
    }
}

/// Replaces `pixels` with marks: red where they differ from `right`, elsewhere the right
/// picture in pale grey. Returns the number of red pixels.
pub(crate) fn mark(pixels: &mut [u8], right: &[u8]) -> u64 {
    let mut wrong = 0;
    for (pixel, right) in pixels
        .chunks_exact_mut(BYTES_PER_PIXEL)
        .zip(right.chunks_exact(BYTES_PER_PIXEL))
    {
        if pixel == right {
            let sum: u16 = right.iter().map(|&channel| u16::from(channel)).sum();
            pixel.fill(192 + (sum / 16) as u8);
        } else {
            wrong += 1;
            pixel.copy_from_slice(&WRONG);
        }
    }
    wrong
}
