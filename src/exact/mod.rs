//! The engine: every pixel proven right.
//!
//! ```text
//! spheres -> conics -> bins -> bands: runs painted far to near -> packets -> decisions
//! ```

mod band;
mod bins;
mod conic;
mod decide;
mod integers;
mod packet;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod trials;

use std::ops::{AddAssign, Range};

pub(crate) use band::Scratch;
use bins::Bins;
use conic::{Extents, Grid, Lanes};
use decide::Rung;

use crate::{
    camera::{Camera, ImageSize},
    scene::{Scene, Viewport},
    spheres::Sphere,
};

/// How many pixels each rung of the ladder settled, and at what effort.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Counts {
    /// Pixels settled in runs, without looking at them.
    pub rectangles: u64,
    /// Pixels settled by a packet.
    pub packets: u64,
    /// Pixels settled one by one in doubles.
    pub doubles: u64,
    /// Pixels settled one by one in integers.
    pub integers: u64,
    /// Spheres met by a row or by a packet.
    pub tests: u64,
}

impl Counts {
    fn settled_by(&mut self, rung: Rung) {
        match rung {
            Rung::Doubles => self.doubles += 1,
            Rung::Integers => self.integers += 1,
        }
    }
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.rectangles += other.rectangles;
        self.packets += other.packets;
        self.doubles += other.doubles;
        self.integers += other.integers;
        self.tests += other.tests;
    }
}

/// The places of the bits that are set.
fn set_bits(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        place
    })
}

/// What the engine makes of its error bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[doc(hidden)]
pub enum Bounds {
    /// They decide what is settled.
    #[default]
    Proven,
    /// Nothing is settled before integers: for tests.
    Refused,
    /// Everything is settled at once, as if nothing were rounded: for benches.
    Ignored,
}

/// How an engine goes about its work; the picture is the same.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Tuning {
    /// Side of a tile: 8, 16, 32 or 64.
    pub tile: u32,
    /// What is made of error bounds.
    pub bounds: Bounds,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            tile: 64,
            bounds: Bounds::default(),
        }
    }
}

/// Whether a sphere may show in some rows of a picture, so that a scene can be read
/// without the others; see [`Scene::read_kept`](crate::scene::Scene::read_kept). True
/// of every sphere that shows there by the meaning of the picture, which the float
/// methods may miss.
pub fn may_show(
    viewport: Viewport,
    size: ImageSize,
    rows: Range<u32>,
) -> impl Fn(&Sphere) -> bool + Sync {
    let grid = Grid::new(Camera::new(viewport, size));
    move |sphere| {
        let [x, y, z] = sphere.centre;
        let lanes = Lanes::of([[x, y, z, sphere.radius]].into_iter());
        let extents = Extents::new(&grid, &lanes);
        extents.visible & 1 == 1 && extents.top[0] < rows.end && extents.bottom[0] >= rows.start
    }
}

/// A scene set up for exact drawing at one size.
#[derive(Debug)]
pub(crate) struct Engine<'scene> {
    scene: &'scene Scene,
    grid: Grid,
    bins: Bins,
    /// A power of two: the nearest inverse depth times this is about 1.
    scale: f64,
    bounds: Bounds,
}

impl<'scene> Engine<'scene> {
    /// # Panics
    ///
    /// If the tile's side is not 8, 16, 32 or 64.
    pub(crate) fn new(scene: &'scene Scene, camera: Camera, tuning: Tuning) -> Self {
        let Tuning { tile, bounds } = tuning;
        assert!(
            tile.is_power_of_two() && (8..=64).contains(&tile),
            "a tile of {tile} x {tile}"
        );
        let grid = Grid::new(camera);
        let bins = Bins::new(&scene.spheres, &grid, tile, bounds);
        let greatest = bins.greatest.max(f32::MIN_POSITIVE);
        Self {
            scene,
            grid,
            bins,
            scale: f64::from(greatest).log2().floor().exp2().recip(),
            bounds,
        }
    }

    /// Rows of the bands the engine draws: a row of tiles.
    pub(crate) fn band_rows(&self) -> u32 {
        self.bins.side()
    }
}
