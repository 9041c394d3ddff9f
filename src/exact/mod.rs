//! The engine: every pixel proven right.

mod decide;
mod integers;

use std::ops::{AddAssign, Range};

use crate::{
    camera::{BYTES_PER_PIXEL, Camera},
    methods::{NONE, Seen},
    scene::Scene,
};

/// How many pixels each rung of the ladder settled, and at what effort.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Counts {
    /// Pixels settled as part of a rectangle.
    pub rectangles: u64,
    /// Pixels settled by a packet.
    pub packets: u64,
    /// Pixels settled one by one in doubles.
    pub doubles: u64,
    /// Pixels settled one by one in integers.
    pub integers: u64,
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.rectangles += other.rectangles;
        self.packets += other.packets;
        self.doubles += other.doubles;
        self.integers += other.integers;
    }
}

/// A scene set up for exact drawing at one size.
#[derive(Debug)]
pub(crate) struct Engine<'scene> {
    scene: &'scene Scene,
    camera: Camera,
}

impl<'scene> Engine<'scene> {
    pub(crate) fn new(scene: &'scene Scene, camera: Camera) -> Self {
        Self { scene, camera }
    }

    /// Rows of the bands the engine draws.
    pub(crate) fn band_rows(&self) -> u32 {
        16
    }

    /// Colours a band of rows.
    pub(crate) fn draw_band(&self, rows: Range<u32>, bytes: &mut [u8]) -> Counts {
        let mut counts = Counts::default();
        let candidates = 0..self.scene.spheres.len() as Seen;
        for (row, bytes) in rows.zip(bytes.chunks_exact_mut(self.camera.size().row_bytes())) {
            for (column, pixel) in bytes.chunks_exact_mut(BYTES_PER_PIXEL).enumerate() {
                let at = (column as u32, row);
                let (seen, rung) = decide::decide(
                    &self.scene.spheres,
                    &self.camera,
                    at,
                    candidates.clone(),
                    true,
                );
                match rung {
                    decide::Rung::Doubles => counts.doubles += 1,
                    decide::Rung::Integers => counts.integers += 1,
                }
                pixel.copy_from_slice(match seen {
                    NONE => &self.scene.background,
                    _ => &self.scene.spheres.colour()[seen as usize],
                });
            }
        }
        counts
    }
}
