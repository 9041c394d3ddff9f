//! Intersections in doubles, against dyadic rationals.

use super::{Order, Rays, Sights, Targets, power};
use crate::exact::{
    bounds::U,
    integers,
    trials::{Dyadic, Trial, Truth, dyadic, each_trial, partner},
};
use crate::{
    camera::{Camera, ImageSize},
    scene::Viewport,
};
use std::cmp::Ordering;

#[test]
fn the_power_of_the_camera_has_the_right_sign_and_seven_roundings() {
    each_trial(100_000, |trial, _| {
        let exact = trial.truth().c;
        let rounded = power(trial.lengths().map(f64::from));
        let zero = Dyadic::ZERO;
        let right = (rounded > 0.0) == (exact > zero) && (rounded < 0.0) == (exact < zero);
        let (error, bound) = (dyadic(rounded) - &exact, dyadic(7.0 * U) * &exact);
        if right && &error * &error <= &bound * &bound {
            Ok(())
        } else {
            Err(format!("{:016x} for {exact}", rounded.to_bits()))
        }
    });
}

/// Checks an intersection. Returns whether it is met, in doubt, or missed.
fn judge(trial: &Trial, sights: &Sights, lane: usize) -> Result<usize, String> {
    let truth = trial.truth();
    // Here the inverse depth is in units of V: s = vz/z.
    let unit = trial.camera.z_double();
    let [lower, upper] = [sights.lower, sights.upper].map(|bound| bound.to_array()[lane]);
    if upper == f64::NEG_INFINITY {
        return if truth.hit() {
            Err("missed, but hit".into())
        } else {
            Ok(2)
        };
    }
    if truth.hit() && !truth.at_most(upper, unit) {
        return Err("nearer than the upper bound".into());
    }
    if lower == f64::NEG_INFINITY {
        return Ok(1);
    }
    if !lower.is_finite() {
        return Err(format!("a lower bound of {lower}"));
    }
    if truth.hit() && truth.at_least(lower, unit) {
        Ok(0)
    } else {
        Err(format!(
            "farther than the lower bound, hit: {}",
            truth.hit()
        ))
    }
}

/// And are in doubt in few of the pixels, and sharp where they are seen from inside, ahead and back.
#[test]
fn sights_hold_the_exact_inverse_depth() {
    let (mut kinds, mut sharp) = ([0; 3], [0; 2]);
    each_trial(150_000, |trial, random| {
        let targets = Targets::of(std::iter::once(trial.lengths()));
        let (rays, lane) = if random.below(2) == 0 {
            (Rays::of_pixel(&trial.camera, trial.column, trial.row), 0)
        } else {
            let before = (random.below(8) as u32).min(trial.column);
            let rays = Rays::of_row(&trial.camera, trial.column - before, trial.row);
            (rays, before as usize)
        };
        let sights = Sights::new(&rays, &targets);
        kinds[judge(trial, &sights, lane)?] += 1;
        let Truth { b, c, .. } = trial.truth();
        let [lower, upper] = [sights.lower, sights.upper].map(|bound| bound.to_array()[lane]);
        if c < Dyadic::ZERO && upper < f64::INFINITY && 1e6 * (upper - lower) < upper {
            sharp[usize::from(b < Dyadic::ZERO)] += 1;
        }
        Ok(())
    });
    let enough = kinds[0] > 30_000 && kinds[1] > 500 && kinds[2] > 30_000;
    assert!(enough, "only {kinds:?}");
    let enough = sharp[0] > 14_000 && sharp[1] > 10_000;
    assert!(enough, "only {sharp:?} are sharp");
}

/// And no order is given to spheres that are not both surely hit.
#[test]
fn the_order_of_two_spheres_is_that_of_their_hits() {
    // By where the camera is: outside both, in or on one, in or on both.
    let (mut told, mut untold) = ([[0; 2]; 3], 0);
    each_trial(60_000, |trial, random| {
        let spheres = [trial.sphere, partner(trial, random)];
        let lengths = spheres.map(|sphere| {
            let [x, y, z] = sphere.centre;
            [x, y, z, sphere.radius]
        });
        let usable = |of: &[f32; 4]| of.iter().all(|length| length.is_finite()) && of[3] > 0.0;
        if !lengths.iter().all(usable) {
            return Ok(());
        }
        let rays = Rays::of_pixel(&trial.camera, trial.column, trial.row);
        let targets = lengths.map(|lengths| Targets::of(std::iter::once(lengths)));
        let sights = targets.map(|targets| Sights::new(&rays, &targets));
        let of = |at: usize| (&targets[at], &sights[at]);
        let order = Order::new(&rays, [of(0), of(1)]);
        if Order::new(&rays, [of(1), of(0)]).first != order.second {
            return Err("another order of the exchanged spheres".into());
        }
        let pixel = (trial.column, trial.row);
        let hits: Vec<_> = integers::hits(&trial.camera, pixel, lengths.into_iter()).collect();
        let said = match (order.first, order.second) {
            (0xff, 0) => Ordering::Greater,
            (0, 0xff) => Ordering::Less,
            (0, 0) => {
                untold += u64::from(hits.iter().all(Option::is_some));
                return Ok(());
            }
            other => return Err(format!("{other:x?} of eight copies")),
        };
        let [Some(first), Some(second)] = &hits[..] else {
            return Err("an order of spheres that are not hit".into());
        };
        let within = lengths.iter().filter(|of| power(of.map(f64::from)) <= 0.0);
        told[within.count()][usize::from(said == Ordering::Less)] += 1;
        if first.cmp(second) == said {
            Ok(())
        } else {
            Err(format!("{said:?} is said of {lengths:?}"))
        }
    });
    let enough = told.as_flattened().iter().all(|&count| count > 500);
    assert!(enough && untold > 100, "only {told:?}, {untold} untold");
}

/// The numerators of the pixels of a picture at which `x/y` is that of the viewport, but for a part of
/// `steps` in the product of both sides; `None` if they are not in the picture.
fn beside_the_diagonal(sides: [i64; 2], steps: i64) -> Option<[u32; 2]> {
    let [p, q] = sides.map(|side| side - 1);
    // Extended Euclid: `p u + q v = 1`.
    let (mut rests, mut factors) = ([p, q], [0, 1]);
    while rests[1] != 0 {
        let times = rests[0] / rests[1];
        rests = [rests[1], rests[0] - times * rests[1]];
        factors = [factors[1], factors[0] - times * factors[1]];
    }
    assert_eq!(rests[0], 1, "{p} and {q} have a common factor");
    // `x q - y p = steps`, with `x` and `y` as odd as `p` and `q`.
    let x = (i128::from(factors[0]) * i128::from(steps)).rem_euclid(2 * i128::from(p)) as i64 - p;
    let x = if x % 2 == 0 { x + p } else { x };
    let y = (i128::from(x) * i128::from(q) - i128::from(steps)) / i128::from(p);
    let pixel = [(x + p) / 2, (q - i64::try_from(y).ok()?) / 2];
    let within = |at: usize| (0..sides[at]).contains(&pixel[at]);
    (within(0) && within(1)).then(|| pixel.map(|at| at as u32))
}

/// Of two spheres that are mirror images at the diagonal of the view, where rays are so near it that
/// doubles cannot tell on which side they are.
#[test]
fn no_order_is_known_where_the_rounding_of_rays_decides() {
    let (mut told, mut untold) = (0, 0);
    for steps in (-4_000..4_000).step_by(2) {
        let sides = [(1 << 31) + 12, (1 << 30) + 4 + 2 * (steps & 31)];
        let coprime = |[mut a, mut b]: [i64; 2]| {
            while b != 0 {
                (a, b) = (b, a % b);
            }
            a == 1
        };
        if !coprime(sides.map(|side| side - 1)) {
            continue;
        }
        let Some([column, row]) = beside_the_diagonal(sides, steps) else {
            continue;
        };
        let viewport = Viewport {
            width: 1.3,
            height: 1.3,
            distance: 1.0,
        };
        let camera = Camera::new(
            viewport,
            ImageSize::of_sides(sides[0] as u32, sides[1] as u32),
        );
        let lengths = [[1.0, -1.0, 10.0, 9.0], [-1.0, 1.0, 10.0, 9.0]];
        let rays = Rays::of_pixel(&camera, column, row);
        let targets = lengths.map(|lengths| Targets::of(std::iter::once(lengths)));
        let sights = targets.map(|targets| Sights::new(&rays, &targets));
        let order = Order::new(
            &rays,
            [(&targets[0], &sights[0]), (&targets[1], &sights[1])],
        );
        let hits: Vec<_> = integers::hits(&camera, (column, row), lengths.into_iter()).collect();
        let [Some(first), Some(second)] = &hits[..] else {
            panic!("no hit");
        };
        match (order.first, order.second) {
            (0, 0) => untold += 1,
            said => {
                told += 1;
                let right = if said.0 != 0 {
                    Ordering::Greater
                } else {
                    Ordering::Less
                };
                assert_eq!(first.cmp(second), right, "{steps}: ({column}, {row})");
            }
        }
    }
    assert!(untold > 500, "only {untold}, {told} told");
}
