//! The engine as the renderer has it: a prepared scene, and memory to draw it in.

use std::ops::Range;

use super::{
    band::{Scratch, draw_band},
    bins::Room,
    counts::Counts,
    pool::Pool,
    prepared::Prepared,
    tuning::Tuning,
};
use crate::{camera::Camera, scene::Scene};

/// Memory for drawing. Reusing it for the next picture saves the time to obtain it, which is a
/// sixth of the time for a million spheres.
#[derive(Debug, Default)]
pub struct Workspace {
    bins: Room,
    scratches: Pool<Scratch>,
}

/// Draws the bands of a scene.
#[derive(Debug)]
pub(crate) struct Engine<'scene> {
    prepared: Prepared<'scene>,
    workspace: Workspace,
}

impl<'scene> Engine<'scene> {
    /// # Panics
    ///
    /// If the tile's side is not 8, 16, 32 or 64.
    pub(crate) fn new(
        scene: &'scene Scene,
        camera: Camera,
        tuning: Tuning,
        workspace: Workspace,
    ) -> Self {
        Self {
            prepared: Prepared::new(scene, camera, tuning, &workspace.bins),
            workspace,
        }
    }

    pub(crate) fn into_workspace(self) -> Workspace {
        self.prepared.bins.return_to(&self.workspace.bins);
        self.workspace
    }

    /// Rows of the bands the engine draws: a row of tiles.
    pub(crate) fn band_rows(&self) -> u32 {
        self.prepared.bins.side()
    }

    /// Draws a band: some rows of one row of tiles.
    pub(crate) fn draw_band(&self, rows: Range<u32>, bytes: &mut [u8]) -> Counts {
        let mut scratch = self.workspace.scratches.lend();
        draw_band(&self.prepared, rows, bytes, &mut scratch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{camera::ImageSize, testing::families::cloud};

    /// The memory of the bins and of the bands.
    #[test]
    fn a_workspace_holds_what_the_engine_used() {
        let scene = cloud(1000, 3);
        let size = ImageSize::new(64, 64).expect("a size");
        let camera = Camera::new(scene.viewport, size);
        let engine = Engine::new(&scene, camera, Tuning::default(), Workspace::default());
        engine.draw_band(0..64, &mut vec![0; size.pixel_bytes()]);
        let Workspace { bins, scratches } = engine.into_workspace();
        let unused = Workspace::default();
        let length = |of: &dyn std::fmt::Debug| format!("{of:?}").len();
        assert!(length(&bins) > 10_000 + length(&unused.bins));
        assert!(length(&scratches) > 10_000 + length(&unused.scratches));
    }
}
