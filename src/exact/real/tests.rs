//! Double-doubles, against dyadic rationals.

use super::{DoubleDouble, Real, f64x8, splat};
use crate::exact::{
    bounds::U_DOUBLE_DOUBLE,
    trials::{Dyadic, Random, dyadic},
};

fn any(random: &mut Random) -> DoubleDouble {
    let high = random.between(1.0, 2.0) * random.power(2.0, -20.0, 20.0).log2().round().exp2();
    let share = [0.0, 1.0, 0.5, random.between(0.0, 1.0)][random.below(4) as usize];
    let sign = |random: &mut Random| if random.below(2) == 0 { 1.0 } else { -1.0 };
    // Up to half a unit in the last place.
    let low = share * sign(random) * high.log2().floor().exp2() * f64::EPSILON * 0.5;
    let high = high * sign(random);
    DoubleDouble::of_sum(splat(high), splat(low * random.power(2.0, -8.0, 0.0)))
}

fn exactly(value: DoubleDouble) -> Dyadic {
    let [high, low] = value.parts().map(|part| part.to_array()[0]);
    dyadic(high) + dyadic(low)
}

/// `|error| <= share U_DOUBLE_DOUBLE |exact|`
fn close(error: &Dyadic, exact: &Dyadic, share: f64) -> bool {
    let bound = dyadic(share * U_DOUBLE_DOUBLE) * exact;
    error * error <= &bound * &bound
}

#[test]
fn each_operation_rounds_no_more_than_the_literature_says() {
    for number in 0..100_000 {
        let random = &mut Random::new(number);
        let (a, b) = (any(random), any(random));
        let (x, y) = (exactly(a), exactly(b));
        let check =
            |what: &str, right: bool| assert!(right, "trial {number}: {what} of {a:?} {b:?}");
        check(
            "sum",
            close(&(exactly(a + b) - (&x + &y)), &(&x + &y), 3.1 / 16.0),
        );
        check(
            "difference",
            close(&(exactly(a - b) - (&x - &y)), &(&x - &y), 3.1 / 16.0),
        );
        check(
            "product",
            close(&(exactly(a * b) - &x * &y), &(&x * &y), 7.1 / 16.0),
        );
        // q = x/y (1 + e): q y - x = e x.
        check(
            "quotient",
            close(&(exactly(a / b) * &y - &x), &x, 14.1 / 16.0),
        );
        // root^2 = x (1 + e)^2
        let root = exactly(a.abs().sqrt());
        let x = exactly(a.abs());
        check("root", close(&(&root * &root - &x), &x, 2.0 * 3.2 / 16.0));
    }
}

#[test]
fn comparisons_and_choices() {
    let of = |high: f64, low: f64| DoubleDouble::of_sum(splat(high), splat(low));
    let tiny = 1e-20;
    let bits = |mask: f64x8| mask.to_bitmask();
    assert_eq!(bits(of(1.0, tiny).exceeds(of(1.0, 0.0))), 0xff);
    assert_eq!(bits(of(1.0, 0.0).exceeds(of(1.0, tiny))), 0);
    assert_eq!(bits(of(1.0, tiny).exceeds(of(1.0, tiny))), 0);
    assert_eq!(bits(of(2.0, -tiny).exceeds(of(1.0, tiny))), 0xff);
    let same = |a: DoubleDouble, b: DoubleDouble| exactly(a) == exactly(b);
    assert!(same(of(-1.0, tiny).abs(), of(1.0, -tiny)));
    assert!(same(of(-1.0, tiny).positive_part(), of(0.0, 0.0)));
    assert!(same(of(1.0, tiny).positive_part(), of(1.0, tiny)));
    let lanes = |step: f64| f64x8::new(std::array::from_fn(|lane| lane as f64 * step));
    let mixed = DoubleDouble::of_sum(splat(1.0), lanes(tiny));
    assert!(same(mixed.greatest(), of(1.0, 7.0 * tiny)));
    assert_eq!(lanes(-1.0).greatest().to_array(), [0.0; 8]);
}
