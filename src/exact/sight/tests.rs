//! Intersections in doubles and in double-doubles, against dyadic rationals.

use super::{Rays, Sights, Targets, power, power_of_camera};
use crate::exact::{
    bounds::{U, U_DOUBLE_DOUBLE},
    real::{DoubleDouble, Real},
    trials::{Dyadic, Trial, Truth, dyadic, each_trial},
};
use wide::f64x8;

#[test]
fn the_power_of_the_camera_has_the_right_sign_and_seven_roundings() {
    each_trial(100_000, |trial, _| {
        let exact = trial.truth().c;
        let (rounded, rest) = power(trial.lengths().map(f64::from));
        let zero = Dyadic::ZERO;
        let right = rounded == power_of_camera(&trial.sphere)
            && (rounded > 0.0) == (exact > zero)
            && (rounded < 0.0) == (exact < zero);
        let close = |value: Dyadic, share: f64| {
            let (error, bound) = (value - &exact, dyadic(share) * &exact);
            &error * &error <= &bound * &bound
        };
        let sum = dyadic(rounded) + dyadic(rest);
        if right && close(dyadic(rounded), 7.0 * U) && close(sum, 7.0 * U_DOUBLE_DOUBLE) {
            Ok(())
        } else {
            Err(format!("{:016x} + {rest:e} for {exact}", rounded.to_bits()))
        }
    });
}

/// Checks an intersection. Returns whether it is met, in doubt, or missed.
fn judge<N: Real>(
    trial: &Trial,
    sights: &Sights<N>,
    lane: usize,
    exactly: impl Fn(N, usize) -> Option<Dyadic>,
) -> Result<usize, String> {
    let truth = trial.truth();
    // Here the inverse depth is in units of V: s = vz/z.
    let unit = trial.camera.z_double();
    let minus_infinity = |value: N| {
        let lanes = N::splat(f64::MIN).exceeds(value).to_bitmask();
        lanes >> lane & 1 == 1
    };
    let (lower, upper) = (sights.lower, sights.upper);
    if minus_infinity(upper) {
        return if truth.hit() {
            Err("missed, but hit".into())
        } else {
            Ok(2)
        };
    }
    let above = exactly(upper, lane);
    if truth.hit() && above.is_some_and(|above| !truth.at_most_dyadic(&above, unit)) {
        return Err("nearer than the upper bound".into());
    }
    if minus_infinity(lower) {
        return Ok(1);
    }
    let below = exactly(lower, lane).ok_or("a lower bound of infinity")?;
    if truth.hit() && truth.at_least_dyadic(&below, unit) {
        Ok(0)
    } else {
        Err(format!(
            "farther than the lower bound, hit: {}",
            truth.hit()
        ))
    }
}

/// How many are met, in doubt, and missed; and of those that are seen from inside, ahead and back, how
/// many are known to a millionth.
fn check<N: Real>(
    count: u64,
    exactly: impl Fn(N, usize) -> Option<Dyadic> + Copy,
) -> ([u64; 3], [u64; 2]) {
    let (mut kinds, mut sharp) = ([0; 3], [0; 2]);
    each_trial(count, |trial, random| {
        let targets = Targets::<N>::of(std::iter::once(trial.lengths()));
        let (rays, lane) = if random.below(2) == 0 {
            (Rays::of_pixel(&trial.camera, trial.column, trial.row), 0)
        } else {
            let before = (random.below(8) as u32).min(trial.column);
            let rays = Rays::of_row(&trial.camera, trial.column - before, trial.row);
            (rays, before as usize)
        };
        let sights = Sights::new(&rays, &targets);
        kinds[judge(trial, &sights, lane, exactly)?] += 1;
        let Truth { b, c, .. } = trial.truth();
        if c < Dyadic::ZERO {
            let bounds = [exactly(sights.lower, lane), exactly(sights.upper, lane)];
            if let [Some(lower), Some(upper)] = bounds
                && dyadic(1e6) * (&upper - lower) < upper
            {
                sharp[usize::from(b < Dyadic::ZERO)] += 1;
            }
        }
        Ok(())
    });
    (kinds, sharp)
}

fn double(value: f64) -> Option<Dyadic> {
    value.is_finite().then(|| dyadic(value))
}

#[test]
fn sights_in_doubles_hold_the_exact_inverse_depth() {
    let (kinds, sharp) = check::<f64x8>(150_000, |lanes, lane| double(lanes.to_array()[lane]));
    let enough = kinds[0] > 30_000 && kinds[1] > 500 && kinds[2] > 30_000;
    assert!(enough, "only {kinds:?}");
    let enough = sharp[0] > 14_000 && sharp[1] > 10_000;
    assert!(enough, "only {sharp:?} are sharp");
}

#[test]
fn sights_in_double_doubles_hold_the_exact_inverse_depth() {
    let (kinds, sharp) = check::<DoubleDouble>(60_000, |lanes, lane| {
        let [high, low] = lanes.parts().map(|part| part.to_array()[lane]);
        Some(double(high)? + double(low)?)
    });
    let enough = kinds[0] > 10_000 && kinds[1] > 30 && kinds[2] > 10_000;
    assert!(enough, "only {kinds:?}");
    let enough = sharp[0] > 5_500 && sharp[1] > 4_000;
    assert!(enough, "only {sharp:?} are sharp");
}
