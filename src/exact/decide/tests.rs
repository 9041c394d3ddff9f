//! The bounds of doubles, against dyadic rationals.

use super::{Ray, Sight, U, power_of_camera};
use crate::exact::trials::{Dyadic, dyadic, each_trial};

#[test]
fn the_power_of_the_camera_has_the_right_sign_and_seven_roundings() {
    each_trial(200_000, |trial, _| {
        let exact = trial.truth().c;
        let rounded = power_of_camera(&trial.sphere);
        let error = dyadic(rounded) - &exact;
        let zero = Dyadic::ZERO;
        let bound = dyadic(7.0 * U) * &exact;
        let right = (rounded > 0.0) == (exact > zero) && (rounded < 0.0) == (exact < zero);
        let close = &error * &error <= &bound * &bound;
        if right && close {
            Ok(())
        } else {
            Err(format!("{:016x} for {exact}", rounded.to_bits()))
        }
    });
}

#[test]
fn a_sight_holds_the_exact_inverse_depth() {
    each_trial(200_000, |trial, _| {
        let truth = trial.truth();
        let ray = Ray::new(&trial.camera, trial.column, trial.row);
        let sight = ray.sight(&trial.sphere);
        // Of a sight, inverse depth is in units of V: s = vz/z.
        let unit = trial.camera.z_double();
        let right = match sight {
            Sight::Missed => !truth.hit(),
            Sight::Doubtful { most } => !truth.hit() || truth.at_most(most, unit),
            Sight::Met { least, most } => {
                truth.hit() && truth.at_least(least, unit) && truth.at_most(most, unit)
            }
        };
        let least = ray.least_inverse_z(&trial.sphere);
        let right = right && (least == f64::NEG_INFINITY || truth.at_least(least, 1.0));
        if right {
            Ok(())
        } else {
            Err(format!("{sight:?}, 1/z >= {:016x}", least.to_bits()))
        }
    });
}
