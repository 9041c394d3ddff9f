//! What is known of a scene before the first pixel: its grid and its bins.

use std::ops::Range;

use super::{
    bins::{Bins, Room},
    boxes::PixelBox,
    grid::Grid,
    tuning::{Bounds, Tuning},
};
use crate::{
    camera::{Camera, ImageSize},
    scene::{Scene, Viewport},
    spheres::{Sphere, Spheres},
};

/// A scene prepared for exact drawing at one size.
#[derive(Debug)]
pub(super) struct Prepared<'scene> {
    pub(super) scene: &'scene Scene,
    pub(super) grid: Grid,
    pub(super) bins: Bins,
    pub(super) bounds: Bounds,
}

impl<'scene> Prepared<'scene> {
    /// # Panics
    ///
    /// If the tile's side is not 8, 16, 32 or 64.
    pub(super) fn new(scene: &'scene Scene, camera: Camera, tuning: Tuning, room: &Room) -> Self {
        let Tuning { tile, bounds } = tuning;
        assert!(
            tile.is_power_of_two() && (8..=64).contains(&tile),
            "a tile of {tile} x {tile}"
        );
        let mut grid = Grid::new(camera);
        grid.scale = scale_of(&scene.spheres, &grid);
        Self {
            scene,
            bins: Bins::new(&scene.spheres, &grid, tile, bounds, room),
            grid,
            bounds,
        }
    }
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
        PixelBox::new(&grid, sphere).is_some_and(|PixelBox { sides, .. }| {
            let [_, _, top, bottom] = sides;
            top < rows.end && bottom >= rows.start
        })
    }
}

/// The number of spheres in the sample that determines the scale.
const SCALE_SAMPLE: usize = 255;

/// A power of two by which an ordinary inverse depth becomes about 1. It comes from the median
/// of a sample, which a few unusual spheres do not change. If the camera almost touches a sphere,
/// its greatest inverse depth is far from ordinary; the inverse of its radius, if less, is taken instead.
fn scale_of(spheres: &Spheres, grid: &Grid) -> f64 {
    let step = (spheres.len() / SCALE_SAMPLE).max(1);
    let sample = (0..spheres.len()).step_by(step).map(|at| spheres.get(at));
    let inverse_depth = |sphere: Sphere| {
        let upper = PixelBox::new(grid, &sphere)?.upper;
        Some(upper.min(sphere.radius.recip()))
    };
    let mut inverse_depths: Vec<f32> = sample.filter_map(inverse_depth).collect();
    let middle = inverse_depths.len() / 2;
    if inverse_depths.is_empty() {
        return 1.0;
    }
    let (_, &mut median, _) = inverse_depths.select_nth_unstable_by(middle, f32::total_cmp);
    power_of_two_below(median.clamp(f32::MIN_POSITIVE, f32::MAX)).recip()
}

/// The greatest power of two that is not above a positive normal float.
pub(super) fn power_of_two_below(value: f32) -> f64 {
    f64::from(f32::from_bits(value.to_bits() & 0xff << 23))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neither some unusual spheres nor invisible ones change the scale, wherever they are in the file.
    #[test]
    fn the_scale_is_that_of_ordinary_spheres() {
        let size = ImageSize::new(64, 64).expect("a size");
        let viewport = Viewport::new(1.0, 1.0, 1.0).expect("a viewport");
        let grid = Grid::new(Camera::new(viewport, size));
        let sphere = |z: f32| Sphere {
            centre: [0.0, 0.0, z],
            radius: 1.0,
            colour: [0; 3],
        };
        let (ordinary, near, behind) = (sphere(101.0), sphere(1.0 + 1e-3), sphere(-9.0));
        let (touched, almost) = (sphere(1.0), sphere(1.0 + 1e-6));
        let scale = |count: usize, of: &dyn Fn(usize) -> Sphere| {
            let spheres: Spheres = (0..count).map(of).collect();
            scale_of(&spheres, &grid)
        };
        for count in [1, 8, 255, 300, 600, 5000] {
            // A hundredth, times 128.
            assert_eq!(scale(count, &|_| ordinary), 128.0, "{count}");
            // Of radius 1.
            assert_eq!(scale(count, &|_| touched), 1.0, "{count}");
            assert_eq!(scale(count, &|_| almost), 1.0, "{count}");
        }
        for every in 3..100 {
            let some = |other: Sphere| {
                move |at: usize| {
                    if at.is_multiple_of(every) {
                        other
                    } else {
                        ordinary
                    }
                }
            };
            assert_eq!(scale(300, &some(near)), 128.0, "every {every}");
            assert_eq!(scale(300, &some(behind)), 128.0, "every {every}");
        }
        assert_eq!(scale_of(&Spheres::default(), &grid), 1.0);
    }
}
