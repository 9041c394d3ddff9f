//! The engine: every pixel proven right.
//!
//! ```text
//! spheres -> boxes -> bins -> tiles: coverage masks or a crowd -> packets -> decisions -> bytes
//! ```
//!
//! | step | module | what it does |
//! | --- | --- | --- |
//! | | `bounds` | every constant of every error bound |
//! | | `kernels` | the formulas whose roundings those bounds count |
//! | | `grid` | the pixel grid, spheres eight at a time |
//! | | `real`, `sight` | a ray and a sphere in doubles and in double-doubles, with running bounds |
//! | spheres -> boxes | `boxes` | the pixels in which a sphere may be visible, and its greatest inverse depth; culling |
//! | boxes -> bins | `bins` | the candidates of every tile |
//! | | `outline` | the columns a sphere covers in eight rows, as masks |
//! | | `depths` | inverse depths in a rectangle, as polynomials with an error bound |
//! | tile of few spheres | `coverage` | masks from far to near; contested pixels |
//! | tile of many spheres | `crowd` | packets for every pixel, nearest first where that pays |
//! | | `packet` | eight pixels against a sphere, each inverse depth an interval |
//! | undecided pixels | `decide`, `integers` | doubles, double-doubles, integers |
//! | bytes | `paint` | runs and packets to bytes |
//! | all of it | `band`, `rows` | a row of tiles; whole rows where no inverse depths overlap |
//!
//! The [`proof`] shows, theorem by theorem, that every pixel is right.

mod band;
mod bins;
mod bounds;
mod boxes;
mod counts;
mod coverage;
mod crowd;
mod decide;
mod depths;
mod grid;
mod integers;
mod kernels;
mod outline;
mod packet;
mod paint;
mod real;
mod rows;
mod sight;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod trials;
pub(crate) mod tuning;
mod workspace;

#[doc = include_str!("proof.md")]
pub mod proof {}

use std::ops::Range;

use bins::Bins;
use boxes::Boxes;
pub use counts::Counts;
use grid::{EightSpheres, Grid};
use tuning::{Bounds, Tuning};
pub use workspace::Workspace;

use crate::{
    camera::{Camera, ImageSize},
    scene::{Scene, Viewport},
    spheres::{LANES, Sphere, Spheres},
};

/// The positions of the bits that are set.
fn set_bits(mut bits: u64) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        place
    })
}

/// Whether a sphere may be visible in some rows of a picture, so that a scene can be read
/// without the others; see [`Scene::read_kept`](crate::scene::Scene::read_kept). True for every
/// sphere that is visible there in the exact picture, though perhaps not for one that a float
/// method shows there by mistake.
pub fn may_show(
    viewport: Viewport,
    size: ImageSize,
    rows: Range<u32>,
) -> impl Fn(&Sphere) -> bool + Sync {
    let grid = Grid::new(Camera::new(viewport, size));
    move |sphere| {
        let [x, y, z] = sphere.centre;
        let spheres = EightSpheres::of([[x, y, z, sphere.radius]].into_iter());
        let boxes = Boxes::new(&grid, &spheres);
        boxes.visible & 1 == 1 && boxes.top[0] < rows.end && boxes.bottom[0] >= rows.start
    }
}

/// A scene prepared for exact drawing at one size.
#[derive(Debug)]
pub(crate) struct Engine<'scene> {
    scene: &'scene Scene,
    grid: Grid,
    bins: Bins,
    bounds: Bounds,
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
        let Tuning { tile, bounds } = tuning;
        assert!(
            tile.is_power_of_two() && (8..=64).contains(&tile),
            "a tile of {tile} x {tile}"
        );
        let mut grid = Grid::new(camera);
        grid.scale = scale_of(&scene.spheres, &grid);
        Self {
            scene,
            bins: Bins::new(&scene.spheres, &grid, tile, bounds, &workspace),
            grid,
            bounds,
            workspace,
        }
    }

    pub(crate) fn into_workspace(self) -> Workspace {
        self.bins.return_to(&self.workspace);
        self.workspace
    }

    /// Rows of the bands the engine draws: a row of tiles.
    pub(crate) fn band_rows(&self) -> u32 {
        self.bins.side()
    }
}

/// The number of spheres in the sample that determines the scale.
const SCALE_SAMPLE: usize = 255;

/// A power of two by which an ordinary inverse depth becomes about 1. It comes from the median
/// of a sample, which a few unusual spheres do not change.
fn scale_of(spheres: &Spheres, grid: &Grid) -> f64 {
    let step = (spheres.len() / SCALE_SAMPLE).max(1);
    let sample: Vec<[f32; 4]> = (0..spheres.len())
        .step_by(step)
        .map(|at| {
            let Sphere { centre, radius, .. } = spheres.get(at);
            [centre[0], centre[1], centre[2], radius]
        })
        .collect();
    let mut uppers = Vec::with_capacity(sample.len());
    for eight in sample.chunks(LANES) {
        let boxes = Boxes::new(grid, &EightSpheres::of(eight.iter().copied()));
        let visible = (0..eight.len()).filter(|lane| boxes.visible >> lane & 1 == 1);
        uppers.extend(visible.map(|lane| boxes.upper[lane]));
    }
    let middle = uppers.len() / 2;
    if uppers.is_empty() {
        return 1.0;
    }
    let (_, &mut median, _) = uppers.select_nth_unstable_by(middle, f32::total_cmp);
    power_of_two_below(median.clamp(f32::MIN_POSITIVE, f32::MAX)).recip()
}

/// The greatest power of two that is not above a positive normal float.
fn power_of_two_below(value: f32) -> f64 {
    f64::from(f32::from_bits(value.to_bits() & 0xff << 23))
}
