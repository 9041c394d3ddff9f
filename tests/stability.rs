//! Where methods hold and where they fail.
//!
//! Every figure is the number of wrong pixels against the exact picture, of
//! [`SEEDS`] scenes a difficulty. What is pinned is what theory predicts; that a
//! method fails where it must is as much a promise as that it holds where it can.
//! `u` is the unit roundoff of a method, 6e-8 in floats and 1e-16 in doubles.

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

/// A family measured: wrong pixels of each method at each difficulty.
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
    /// Wrong pixels of a method at the difficulties that `chosen` picks.
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

    /// Not a pixel is wrong.
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

    /// Pixels are wrong at every difficulty chosen.
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

    /// More than a quarter of the picture is wrong at every difficulty chosen.
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

/// `D = b^2 - 4ac` of unit `V` is off by `u |C|^2`, a share `u (|C|/r)^2` of `r^2`:
/// nothing is left of it at `|C|/r = u^(-1/2)`, which is 4,096 in floats and 1e8 in
/// doubles. `r^2 - |C - (C.V)V|^2` is off by a share `u |C|/r` only.
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

/// `c = C.C - r^2` is off by `u r^2`, and the surface by `u r` of its distance.
#[test]
fn huge_spheres_outgrow_floats() {
    let huge = measured("huge");
    huge.holds(&[TEXTBOOK, GEOMETRIC], |radius| radius <= 1e3);
    huge.fails(&[TEXTBOOK, GEOMETRIC], |radius| radius >= 1e5);
    huge.holds(&[DOUBLE], |_| true);
}

/// Depths are off by some `u` of the distance: gaps above that are seen.
#[test]
fn shells_closer_than_roundoff_are_confused() {
    let shells = measured("shells");
    shells.holds(&[TEXTBOOK, GEOMETRIC], |gap| gap >= 1e-6);
    shells.fails(&[TEXTBOOK, GEOMETRIC], |gap| gap <= 1e-7);
    shells.holds(&[DOUBLE], |_| true);
}

/// At the seam depths are equal; its width is `u` over the gap.
#[test]
fn seams_blur_as_spheres_draw_together() {
    let seams = measured("interpenetrating");
    seams.holds(&[TEXTBOOK, GEOMETRIC], |shift| shift >= 1e-3);
    seams.fails(&[TEXTBOOK, GEOMETRIC], |shift| shift <= 1e-5);
    seams.holds(&[DOUBLE], |_| true);
}

/// Equal spheres have equal depths however they are rounded.
#[test]
fn of_equal_spheres_every_method_shows_the_first() {
    measured("equal").holds(&MEASURED, |_| true);
}

/// `D = 0`: the sign of a rounded `D` is a matter of luck in any precision.
#[test]
fn exact_tangents_need_exact_arithmetic() {
    measured("tangent").fails(&MEASURED, |_| true);
}

/// `D` is a share `2 gap` of `r^2`, against an error of `u (|C|/r)^2 = 100 u`.
#[test]
fn almost_tangents_need_more_digits_the_closer_they_are() {
    let almost = measured("almost tangent");
    almost.holds(&[TEXTBOOK], |gap| gap >= 1e-3);
    almost.fails(&[TEXTBOOK], |gap| gap <= 1e-5);
    almost.fails(&[GEOMETRIC], |gap| gap <= 1e-7);
    almost.holds(&[DOUBLE], |_| true);
}

/// The near wall is at `gap r`, off by `u r`.
#[test]
fn a_wall_before_the_camera_needs_digits() {
    let inside = measured("inside");
    inside.holds(&[TEXTBOOK, GEOMETRIC], |gap| gap >= 1e-3);
    inside.fails(&[TEXTBOOK, GEOMETRIC], |gap| gap <= 1e-5);
    inside.holds(&[DOUBLE], |_| true);
}

/// `c = 0`: the near root is 0, and is taken for a hit if it comes out above 0.
#[test]
fn a_camera_on_the_surface_needs_exact_arithmetic() {
    let surface = measured("on the surface");
    surface.fails(&MEASURED, |_| true);
    // Squares of radii above 2^12 aren't floats, so c is no longer 0 itself.
    let far_above = surface.wrong(TEXTBOOK, |radius| radius >= 1e4);
    let below = surface.wrong(TEXTBOOK, |radius| radius <= 1e2);
    assert!(far_above.iter().min() > below.iter().max());
}

/// As for shells, but the difference is taken of walls as far as the radius.
#[test]
fn concentric_walls_closer_than_roundoff_are_confused() {
    let walls = measured("concentric");
    walls.holds(&[TEXTBOOK, GEOMETRIC], |gap| gap >= 1e-2);
    walls.fails(&[TEXTBOOK, GEOMETRIC], |gap| gap <= 1e-4);
    walls.holds(&[DOUBLE], |_| true);
}

/// As for a wall seen from inside, from the other side.
#[test]
fn a_surface_beside_the_camera_needs_digits() {
    let beside = measured("beside");
    beside.holds(&[TEXTBOOK, GEOMETRIC], |gap| gap >= 1e-2);
    beside.fails(&[TEXTBOOK, GEOMETRIC], |gap| gap <= 1e-4);
    beside.holds(&[DOUBLE], |_| true);
}

/// Squares of lengths overflow floats above 2^64, and vanish below 2^-75.
/// The squares of the largest and smallest floats are ordinary doubles.
#[test]
fn scale_matters_only_to_floats_and_only_where_squares_overflow_or_vanish() {
    let scale = measured("scale");
    let ordinary = |factor: f64| factor.log2().abs() <= 60.0;
    scale.holds(&[TEXTBOOK, GEOMETRIC], ordinary);
    scale.breaks_down(&[TEXTBOOK, GEOMETRIC], |factor| !ordinary(factor));
    scale.holds(&[DOUBLE], |_| true);
}

/// Nothing is hard here but the number of edges: some pixel is close to one.
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

/// Equal depths are equal in any precision, wherever the copies are in the file.
#[test]
fn of_copies_apart_every_method_shows_the_first() {
    measured("copies").holds(&MEASURED, |_| true);
}

/// Depths differ by a share of about the shift.
#[test]
fn near_ties_are_ties_to_those_who_round() {
    let near = measured("near ties");
    near.fails(&[TEXTBOOK, GEOMETRIC], |_| true);
    near.holds(&[DOUBLE], |shift| shift >= 1e-8);
    near.fails(&[DOUBLE], |shift| shift <= 1e-16);
}

/// A camera among spheres, in front of a floor, before a frustum full of them: not hard,
/// but for a pixel here and there.
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
