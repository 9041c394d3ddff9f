//! The decisions of doubles, against integers.

use super::{Candidate, Rung, Seen, Sighted, decide};
use crate::{
    camera::{Camera, ImageSize},
    exact::trials::{Random, each_trial, sphere},
    methods::NONE,
    scene::Viewport,
};

/// Spheres that nearly coincide with the trial's, and others.
fn rival(lengths: [f32; 4], random: &mut Random) -> [f32; 4] {
    let mut rival = lengths;
    match random.below(4) {
        0 => {}
        1 => {
            let length = &mut rival[random.below(4) as usize];
            *length = if random.below(2) == 0 {
                length.next_up()
            } else {
                length.next_down()
            };
        }
        2 => {
            // The same outline, nearer or farther by a power of two.
            let factor = [0.5, 2.0, 1.0][random.below(3) as usize];
            rival = rival.map(|length| length * factor);
        }
        _ => {
            for length in &mut rival {
                *length *= random.between(0.999_999, 1.000_001) as f32;
            }
        }
    }
    let usable = rival.iter().all(|length| length.is_finite()) && rival[3] > 0.0;
    if usable { rival } else { lengths }
}

#[test]
fn every_rung_sees_the_sphere_that_integers_see() {
    let mut rungs = [0; 2];
    each_trial(60_000, |trial, random| {
        let count = 1 + random.below(11) as u32;
        let mut candidates: Vec<Candidate> = (0..count)
            .map(|index| {
                let lengths = if random.below(5) == 0 {
                    let other = sphere(random, &trial.camera, trial.column, trial.row);
                    let [x, y, z] = other.centre;
                    [x, y, z, other.radius]
                } else {
                    rival(trial.lengths(), random)
                };
                (index as Seen, lengths)
            })
            .collect();
        let at = random.below(u64::from(count)) as usize;
        candidates[at].1 = trial.lengths();
        candidates.rotate_left(random.below(u64::from(count)) as usize);
        let pixel = (trial.column, trial.row);
        let (exact, _) = decide(&trial.camera, pixel, &candidates, false);
        let (seen, rung) = decide(&trial.camera, pixel, &candidates, true);
        rungs[match rung {
            Rung::Doubles => 0,
            Rung::Integers => 1,
        }] += 1;
        if seen == exact {
            Ok(())
        } else {
            Err(format!(
                "{seen} by {rung:?} instead of {exact} of {candidates:?}"
            ))
        }
    });
    assert!(rungs.iter().all(|&count| count > 100), "only {rungs:?}");
}

/// A camera with so narrow a view and so many pixels that neighbouring pixels differ only in
/// the last digits of doubles.
fn fine_camera(random: &mut Random) -> Camera {
    let side = (1 << 30) - 1 - 2 * random.below(1 << 20) as u32;
    let narrow = random.power(2.0, -22.0, -15.0) as f32;
    let viewport = Viewport {
        width: narrow,
        height: narrow,
        distance: random.between(0.5, 2.0) as f32,
    };
    Camera::new(viewport, ImageSize::of_sides(side, side))
}

/// Two spheres that meet at the middle of the view, or one that its ray touches, as nearly as
/// floats can represent; or mirror images, which are equally near in the whole middle column.
fn close_call(random: &mut Random, mirrored: bool) -> Vec<[f32; 4]> {
    let depth = random.power(10.0, -1.0, 3.0);
    let mut through = |grazed: bool| {
        let radius = depth * random.power(10.0, -2.0, 1.0);
        let angle = random.between(0.0, std::f64::consts::TAU);
        let tilt = if grazed {
            1.0
        } else {
            random.between(0.05, 0.95)
        };
        let across = radius * tilt;
        let along = radius * (1.0 - tilt * tilt).sqrt();
        [
            across * angle.cos(),
            across * angle.sin(),
            depth + along,
            radius,
        ]
        .map(|length| length as f32)
    };
    if mirrored {
        let [x, y, z, r] = through(false);
        vec![[x, y, z, r], [-x, y, z, r]]
    } else if depth > 10.0 {
        vec![through(false), through(false)]
    } else {
        vec![through(true)]
    }
}

/// Finds by bisection two neighbouring columns in which integers see different spheres.
fn change(camera: &Camera, row: u32, spheres: &[Candidate]) -> Option<u32> {
    let seen = |column| decide(camera, (column, row), spheres, false).0;
    let (mut low, mut high) = (0, camera.size().width() - 1);
    let (first, last) = (seen(low), seen(high));
    if first == last {
        return None;
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if seen(middle) == first {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(low)
}

/// Thousands of close calls are left to integers.
#[test]
fn close_calls_are_decided_as_integers_decide_them() {
    let mut rungs = [0; 2];
    for number in 0..6_000 {
        let random = &mut Random::new(number);
        let camera = fine_camera(random);
        let mirrored = number % 3 == 0;
        let lengths = close_call(random, mirrored);
        let spheres: Vec<Candidate> = (0..).zip(lengths).collect();
        let side = camera.size().width();
        let row = random.below(u64::from(side)) as u32;
        let columns = if mirrored {
            vec![side / 2]
        } else if let Some(column) = change(&camera, row, &spheres) {
            (column.saturating_sub(1)..=(column + 2).min(side - 1)).collect()
        } else {
            continue;
        };
        for column in columns {
            let decided = |trusted| decide(&camera, (column, row), &spheres, trusted);
            let (exact, _) = decided(false);
            let (seen, rung) = decided(true);
            rungs[match rung {
                Rung::Doubles => 0,
                Rung::Integers => 1,
            }] += 1;
            assert_eq!(
                seen, exact,
                "{number}: ({column}, {row}) by {rung:?}, {spheres:?}"
            );
        }
    }
    assert!(rungs[0] > 2_000 && rungs[1] > 3_500, "only {rungs:?}");
}

/// The camera whose middle pixel looks along the z axis.
fn middle() -> (Camera, (u32, u32)) {
    let viewport = Viewport {
        width: 1.0,
        height: 1.0,
        distance: 1.0,
    };
    let size = ImageSize::new(3, 3).expect("a size with pixels");
    (Camera::new(viewport, size), (1, 1))
}

#[test]
fn of_equal_depths_the_first_of_the_file_is_seen() {
    let (camera, pixel) = middle();
    // Copies, and spheres that touch in one point.
    for spheres in [
        [[0.0, 0.0, 5.0, 1.0], [0.0, 0.0, 5.0, 1.0]],
        [[0.0, 0.0, 5.0, 1.0], [0.0, 0.0, 6.0, 2.0]],
    ] {
        for trusted in [false, true] {
            for turn in 0..2 {
                let mut candidates: Vec<Candidate> = vec![(7, spheres[0]), (9, spheres[1])];
                candidates.rotate_left(turn);
                let (seen, _) = decide(&camera, pixel, &candidates, trusted);
                assert_eq!(seen, 7, "{spheres:?}, turn {turn}, {trusted}");
            }
        }
    }
}

#[test]
fn a_ray_along_the_surface_that_the_camera_is_on_meets_nothing() {
    let (camera, pixel) = middle();
    for trusted in [false, true] {
        let around = (1, [0.0, 5.0, 0.0, 5.0]);
        let candidates: Vec<Candidate> = vec![around, (2, [0.0, 0.0, 10.0, 1.0])];
        let (seen, _) = decide(&camera, pixel, &candidates, trusted);
        assert_eq!(seen, 2, "trusted: {trusted}");
    }
}

/// However close they are, and in whatever order; copies of the nearest need integers.
#[test]
fn spheres_that_nearly_coincide_are_told_apart_in_doubles() {
    let (camera, pixel) = middle();
    for exponent in [10, 40, 70, 100, 140] {
        let apart = 2_f64.powi(-exponent) as f32;
        for count in 2..20 {
            // The middle ray is along the axis; these move away from it, and so do their front sides.
            let sphere = |at: u32| (at, [(at + 1) as f32 * apart, 0.0, 10.0, 3.0]);
            let mut candidates: Vec<Candidate> = (0..count).map(sphere).collect();
            for turn in 0..count as usize {
                candidates.rotate_left(turn);
                let decided = decide(&camera, pixel, &candidates, true);
                assert_eq!(decided, (0, Rung::Doubles), "2^-{exponent}, {count}");
            }
            candidates.push((99, sphere(0).1));
            let decided = decide(&camera, pixel, &candidates, true);
            assert_eq!(decided, (0, Rung::Integers), "2^-{exponent}, {count}");
            let mut ray = Sighted::new(&camera, pixel, &candidates);
            ray.drop_hidden();
            ray.drop_behind_leader(&candidates);
            assert_eq!(ray.left(&candidates).len(), 2);
        }
    }
}

#[test]
fn what_no_ray_comes_near_is_settled_in_doubles() {
    let (camera, pixel) = middle();
    let (beside, behind) = ((3, [50.0, 0.0, 60.0, 1.0]), (4, [50.0, 0.0, -60.0, 1.0]));
    for count in 0..20 {
        let mut candidates: Vec<Candidate> = vec![[beside, behind][count % 2]; count];
        let decided = decide(&camera, pixel, &candidates, true);
        assert_eq!(decided, (NONE, Rung::Doubles), "{count}");
        candidates.push((5, [0.0, 0.0, 60.0, 1.0]));
        let decided = decide(&camera, pixel, &candidates, true);
        assert_eq!(decided, (5, Rung::Doubles), "{count}");
    }
}
