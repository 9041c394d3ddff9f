//! The engine's shortcuts against the meaning: scenes for each of its ways through
//! a picture, at every tile size, on any threads, in any cut.

mod common;

use common::{draw, scene, size};
use sfera::{
    camera::ImageSize,
    render::{Method, differing_pixels},
    scene::Scene,
};

fn wrong(scene: &Scene, size: ImageSize) -> u64 {
    let exact = draw(scene, size, Method::Exact);
    let meaning = draw(scene, size, Method::Reference);
    differing_pixels(&exact, &meaning)
}

/// One after another along the axis, each touching the ray of the only pixel: as
/// many edges are in doubt there as there are spheres.
#[test]
fn a_pixel_in_doubt_for_many_spheres() {
    let spheres: Vec<[f32; 4]> = (0..20)
        .map(|at| [1.0, 0.0, 8.0 + 8.0 * at as f32, 1.0])
        .collect();
    assert_eq!(wrong(&scene([1.0, 1.0, 1.0], &spheres), size(1, 1)), 0);
}

/// Minus zero is zero: the first of two equal spheres is seen.
#[test]
fn equal_but_for_the_sign_of_zero() {
    let first = [-0.0, 0.0, 5.0, 1.0];
    let second = [0.0, -0.0, 5.0, 1.0];
    for spheres in [[first, second], [second, first]] {
        for copies in [1, 40] {
            let spheres = spheres.repeat(copies);
            assert_eq!(wrong(&scene([1.0, 1.0, 1.0], &spheres), size(9, 9)), 0);
        }
    }
}

/// Of equal small spheres in one tile, the first of the file is seen, though a tile
/// sorts them by depth.
#[test]
fn equal_small_spheres_in_any_order() {
    let place = |at: usize| {
        let (column, row) = (at % 6, at / 6);
        [
            column as f32 * 0.08 - 0.2,
            row as f32 * 0.08 - 0.2,
            2.0 + 0.01 * (at * 7 % 36) as f32,
            0.03,
        ]
    };
    for copies in [2, 3] {
        let mut spheres: Vec<[f32; 4]> = (0..30 * copies).map(|at| place(at * 11 % 30)).collect();
        // Out of view, so that there are enough to be sorted by tile.
        spheres.extend((0..64).map(|at| [9.0 + at as f32, 0.0, 4.0, 0.1]));
        let scene = scene([0.6, 0.6, 1.0], &spheres);
        assert_eq!(wrong(&scene, size(64, 64)), 0);
    }
}
