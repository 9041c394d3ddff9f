//! Where methods are right and where they fail.
//!
//! Every figure is the number of wrong pixels compared with the exact picture, of [`SEEDS`]
//! scenes for each difficulty. The tests assert what theory predicts: where a method must
//! fail, and where it must not. `u` is the unit roundoff of a method, 6e-8 in floats and
//! 1e-16 in doubles.

mod common;

use common::{draw, size};
use sfera::{
    render::{
        Form::Packets,
        Method::{self, Exact, Reference},
        differing_pixels,
    },
    scene::Scene,
    testing::families::{FAMILIES, Family},
};

const SEEDS: u64 = 8;

/// Rays through pixel centres are tangent only on this grid or a multiple of it.
const WIDTH: u32 = 65;
const HEIGHT: u32 = 49;

const PIXELS: u64 = (WIDTH * HEIGHT) as u64 * SEEDS;

/// Wrong pixels of each method at each difficulty of a family.
struct Measured {
    family: &'static Family,
    wrong: Vec<[u64; 3]>,
}

const TEXTBOOK: Method = Method::Textbook(Packets);
const GEOMETRIC: Method = Method::Geometric(Packets);
const DOUBLE: Method = Method::Double(Packets);
const MEASURED: [Method; 3] = [TEXTBOOK, GEOMETRIC, DOUBLE];

fn measured(name: &str) -> Measured {
    let family = FAMILIES.iter().find(|family| family.name == name);
    let family = family.expect("a family of this name");
    let size = size(WIDTH, HEIGHT);
    let wrong = |&difficulty: &f64| {
        let mut sums = [0; 3];
        for seed in 0..SEEDS {
            let scene = family.scene(difficulty, seed);
            let exact = draw(&scene, size, Exact);
            for (sum, method) in sums.iter_mut().zip(MEASURED) {
                *sum += differing_pixels(&draw(&scene, size, method), &exact);
            }
        }
        println!("{name:16} {difficulty:9.1e} {sums:6?}");
        sums
    };
    let wrong = family.difficulties.iter().map(wrong).collect();
    Measured { family, wrong }
}

impl Measured {
    /// Wrong pixels of a method at the difficulties that `chosen` selects.
    fn wrong(&self, method: Method, chosen: impl Fn(f64) -> bool) -> Vec<u64> {
        let column = MEASURED.iter().position(|&measured| measured == method);
        let column = column.expect("a float method");
        let difficulties = self.family.difficulties.iter();
        let wrong: Vec<_> = difficulties
            .zip(&self.wrong)
            .filter(|&(&difficulty, _)| chosen(difficulty))
            .map(|(_, wrong)| wrong[column])
            .collect();
        assert!(
            !wrong.is_empty(),
            "no such difficulty of {}",
            self.family.name
        );
        wrong
    }

    /// Asserts that no pixel is wrong.
    fn holds(&self, methods: &[Method], chosen: impl Fn(f64) -> bool) {
        for &method in methods {
            let wrong = self.wrong(method, &chosen);
            assert!(
                wrong.iter().all(|&wrong| wrong == 0),
                "{method} should hold on {}: {wrong:?} wrong",
                self.family.name,
            );
        }
    }

    /// Asserts that some pixels are wrong at every chosen difficulty.
    fn fails(&self, methods: &[Method], chosen: impl Fn(f64) -> bool) {
        for &method in methods {
            let wrong = self.wrong(method, &chosen);
            assert!(
                wrong.iter().all(|&wrong| wrong > 0),
                "{method} should fail on {}: {wrong:?} wrong",
                self.family.name,
            );
        }
    }

    /// Asserts that more than a quarter of the picture is wrong at every chosen difficulty.
    fn breaks_down(&self, methods: &[Method], chosen: impl Fn(f64) -> bool) {
        for &method in methods {
            let wrong = self.wrong(method, &chosen);
            assert!(
                wrong.iter().all(|&wrong| wrong > PIXELS / 4),
                "{method} should break down on {}: {wrong:?} wrong of {PIXELS}",
                self.family.name,
            );
        }
    }
}

#[test]
fn the_example_has_4_wrong_pixels_by_the_textbook_and_none_in_doubles() {
    let scene = Scene::read("scenes/example.txt").expect("the example");
    let size = size(1920, 1080);
    let meaning = draw(&scene, size, Reference);
    let wrong = |method| differing_pixels(&draw(&scene, size, method), &meaning);
    assert_eq!(wrong(TEXTBOOK), 4);
    assert_eq!(wrong(DOUBLE), 0);
    assert_eq!(wrong(Exact), 0);
}

/// `D = b^2 - 4ac` of unit `V` has an error of `u |C|^2`, which is `u (|C|/r)^2` times `r^2`:
/// no digit is right at `|C|/r = u^(-1/2)`, which is 4,096 in floats and 1e8 in doubles.
/// The error of `r^2 - |C - (C.V)V|^2` is only `u |C|/r` times `r^2`.
#[test]
fn far_spheres_need_the_stable_form() {
    let far = measured("far");
    far.holds(&[TEXTBOOK], |distance| distance <= 1e1);
    far.fails(&[TEXTBOOK], |distance| distance >= 1e2);
    far.breaks_down(&[TEXTBOOK], |distance| distance >= 1e4);
    far.holds(&[GEOMETRIC], |distance| distance <= 1e4);
    far.fails(&[GEOMETRIC], |distance| distance >= 1e6);
    far.holds(&[DOUBLE], |distance| distance <= 1e5);
    far.fails(&[DOUBLE], |distance| distance >= 1e7);
}

/// `c = C.C - r^2` has an error of `u r^2`, and the distance of the surface one of `u r`.
#[test]
fn huge_spheres_outgrow_floats() {
    let huge = measured("huge");
    huge.holds(&[TEXTBOOK, GEOMETRIC], |radius| radius <= 1e3);
    huge.fails(&[TEXTBOOK, GEOMETRIC], |radius| radius >= 1e5);
    huge.holds(&[DOUBLE], |_| true);
}

/// The relative error of a distance is some `u`: greater gaps are resolved.
#[test]
fn shells_closer_than_roundoff_are_confused() {
    let shells = measured("shells");
    shells.holds(&[TEXTBOOK, GEOMETRIC], |gap| gap >= 1e-6);
    shells.fails(&[TEXTBOOK, GEOMETRIC], |gap| gap <= 1e-7);
    shells.holds(&[DOUBLE], |_| true);
}

/// At the seam distances are equal; the blurred width is `u` divided by the gap.
#[test]
fn seams_blur_as_spheres_draw_together() {
    let seams = measured("interpenetrating");
    seams.holds(&[TEXTBOOK, GEOMETRIC], |shift| shift >= 1e-3);
    seams.fails(&[TEXTBOOK, GEOMETRIC], |shift| shift <= 1e-5);
    seams.holds(&[DOUBLE], |_| true);
}

/// Equal spheres have equal distances, however these are rounded.
#[test]
fn of_equal_spheres_every_method_shows_the_first() {
    measured("equal").holds(&MEASURED, |_| true);
}

/// `D = 0`: the sign of a rounded `D` is arbitrary in any precision.
#[test]
fn exact_tangents_need_exact_arithmetic() {
    measured("tangent").fails(&MEASURED, |_| true);
}

/// `D` is `2 gap` times `r^2`, with a relative error of `u (|C|/r)^2 = 100 u`.
#[test]
fn almost_tangents_need_more_digits_the_closer_they_are() {
    let almost = measured("almost tangent");
    almost.holds(&[TEXTBOOK], |gap| gap >= 1e-3);
    almost.fails(&[TEXTBOOK], |gap| gap <= 1e-5);
    almost.fails(&[GEOMETRIC], |gap| gap <= 1e-7);
    almost.holds(&[DOUBLE], |_| true);
}

/// The near wall is at `gap r`, with an error of `u r`.
#[test]
fn a_wall_before_the_camera_needs_digits() {
    let inside = measured("inside");
    inside.holds(&[TEXTBOOK, GEOMETRIC], |gap| gap >= 1e-3);
    inside.fails(&[TEXTBOOK, GEOMETRIC], |gap| gap <= 1e-5);
    inside.holds(&[DOUBLE], |_| true);
}

/// `c = 0`: the near root is 0, and counts as a hit if it is rounded to more than 0.
#[test]
fn a_camera_on_the_surface_needs_exact_arithmetic() {
    let surface = measured("on the surface");
    surface.fails(&MEASURED, |_| true);
    // Squares of radii above 2^12 are not floats, so c is no longer 0.
    let far_above = surface.wrong(TEXTBOOK, |radius| radius >= 1e4);
    let below = surface.wrong(TEXTBOOK, |radius| radius <= 1e2);
    assert!(far_above.iter().min() > below.iter().max());
}

/// As for shells, but the distances of the walls are those of the radius.
#[test]
fn concentric_walls_closer_than_roundoff_are_confused() {
    let walls = measured("concentric");
    walls.holds(&[TEXTBOOK, GEOMETRIC], |gap| gap >= 1e-2);
    walls.fails(&[TEXTBOOK, GEOMETRIC], |gap| gap <= 1e-4);
    walls.holds(&[DOUBLE], |_| true);
}

/// As for a wall in front of the camera, but seen from outside the sphere.
#[test]
fn a_surface_beside_the_camera_needs_digits() {
    let beside = measured("beside");
    beside.holds(&[TEXTBOOK, GEOMETRIC], |gap| gap >= 1e-2);
    beside.fails(&[TEXTBOOK, GEOMETRIC], |gap| gap <= 1e-4);
    beside.holds(&[DOUBLE], |_| true);
}

/// Squares of lengths overflow floats above 2^64, and underflow to 0 below 2^-75.
/// The squares of the largest and smallest floats are ordinary doubles.
#[test]
fn scale_matters_only_to_floats_and_only_where_squares_overflow_or_vanish() {
    let scale = measured("scale");
    let ordinary = |factor: f64| factor.log2().abs() <= 60.0;
    scale.holds(&[TEXTBOOK, GEOMETRIC], ordinary);
    scale.breaks_down(&[TEXTBOOK, GEOMETRIC], |factor| !ordinary(factor));
    scale.holds(&[DOUBLE], |_| true);
}

/// Only the number of edges makes these scenes hard: some pixel is close to one.
#[test]
fn ordinary_scenes_cost_the_textbook_a_few_pixels() {
    let mut by_textbook = 0;
    for name in ["lattice", "cloud"] {
        let ordinary = measured(name);
        ordinary.holds(&[GEOMETRIC, DOUBLE], |_| true);
        by_textbook += ordinary.wrong(TEXTBOOK, |_| true).iter().sum::<u64>();
    }
    assert!(
        (1..100).contains(&by_textbook),
        "{by_textbook} wrong pixels"
    );
}

/// Equal distances are equal in any precision, wherever the copies are in the file.
#[test]
fn of_copies_apart_every_method_shows_the_first() {
    measured("copies").holds(&MEASURED, |_| true);
}

/// The relative difference of distances is about the shift.
#[test]
fn near_ties_are_lost_by_rounding() {
    let near = measured("near ties");
    near.fails(&[TEXTBOOK, GEOMETRIC], |_| true);
    near.holds(&[DOUBLE], |shift| shift >= 1e-8);
    near.fails(&[DOUBLE], |shift| shift <= 1e-16);
}

/// A camera among spheres, above a floor, in front of a frustum full of them: easy scenes,
/// except for a few pixels.
#[test]
fn ordinary_views_are_right_in_doubles() {
    for name in [
        "frustum",
        "among",
        "touching the plane",
        "linear in x",
        "linear in y",
        "wide",
        "floor",
    ] {
        measured(name).holds(&[DOUBLE], |_| true);
    }
}
