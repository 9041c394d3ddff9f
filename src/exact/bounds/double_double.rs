//! Double-doubles, with twice the digits of doubles: the exact values of the search.
//!
//! M. Joldes, J.-M. Muller, V. Popescu: Tight and Rigorous Error Bounds for Basic Building Blocks of
//! Double-Word Arithmetic, 2017: their sum, product and quotient, without fused operations.

use std::ops::{Add, Div, Mul, Neg, Sub};

use wide::f64x8;

use super::U;
use crate::exact::{
    kernels::Number,
    trials::{Dyadic, Random, dyadic},
};

/// The sum of two doubles, of which the second is at most half a unit in the last place of the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct DoubleDouble {
    pub(super) high: f64x8,
    pub(super) low: f64x8,
}

/// `a + b` and its rounding error, for `|a| >= |b|` or `a = 0` (Dekker).
fn fast_two_sum(a: f64x8, b: f64x8) -> DoubleDouble {
    let high = a + b;
    DoubleDouble {
        high,
        low: b - (high - a),
    }
}

/// The upper and the lower half of the digits of a double below `2^996` (Veltkamp).
fn halves(of: f64x8) -> [f64x8; 2] {
    let shifted = f64x8::splat(134_217_729.0) * of;
    let high = shifted - (shifted - of);
    [high, of - high]
}

/// `a b` and its rounding error (Dekker), unless that underflows.
fn two_product(a: f64x8, b: f64x8) -> (f64x8, f64x8) {
    let product = a * b;
    let ([a, a_low], [b, b_low]) = (halves(a), halves(b));
    let rest = a * b - product + a * b_low + a_low * b;
    (product, rest + a_low * b_low)
}

impl DoubleDouble {
    pub(super) fn new(high: f64x8) -> Self {
        Self {
            high,
            low: f64x8::ZERO,
        }
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, rest) = self.high.two_sum(other.high);
        let (low, last) = self.low.two_sum(other.low);
        let sum = fast_two_sum(high, rest + low);
        fast_two_sum(sum.high, last + sum.low)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (high, rest) = two_product(self.high, other.high);
        fast_two_sum(high, rest + (self.high * other.low + self.low * other.high))
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let (high, rest) = two_product(first, other.high);
        let product = fast_two_sum(high, rest + first * other.low);
        let rest = (self.high - product.high) + (self.low - product.low);
        fast_two_sum(first, rest / other.high)
    }
}

impl Number for DoubleDouble {
    fn constant(value: f64) -> Self {
        Self::new(f64x8::splat(value))
    }

    fn times_plus(self, a: Self, b: Self) -> Self {
        self * a + b
    }

    fn times_minus(self, a: Self, b: Self) -> Self {
        self * a - b
    }

    fn times_from(self, a: Self, b: Self) -> Self {
        b - self * a
    }

    fn root(self) -> Self {
        let root = self.high.sqrt();
        let (square, rest) = two_product(root, root);
        let rest = (((self.high - square) - rest) + self.low) / (root + root);
        fast_two_sum(root, root.simd_gt(f64x8::ZERO).select(rest, f64x8::ZERO))
    }

    fn abs(self) -> Self {
        let negative = self.high.simd_lt(f64x8::ZERO);
        Self {
            high: negative.select(-self.high, self.high),
            low: negative.select(-self.low, self.low),
        }
    }

    fn positive_part(self) -> Self {
        let positive = self.high.simd_gt(f64x8::ZERO);
        Self {
            high: positive.select(self.high, f64x8::ZERO),
            low: positive.select(self.low, f64x8::ZERO),
        }
    }
}

fn any(random: &mut Random) -> DoubleDouble {
    let high = random.between(1.0, 2.0) * random.power(2.0, -20.0, 20.0).log2().round().exp2();
    let share = [0.0, 1.0, 0.5, random.between(0.0, 1.0)][random.below(4) as usize];
    let sign = |random: &mut Random| if random.below(2) == 0 { 1.0 } else { -1.0 };
    // Up to half a unit in the last place.
    let low = share * sign(random) * high.log2().floor().exp2() * U;
    let low = low * random.power(2.0, -8.0, 0.0);
    fast_two_sum(f64x8::splat(high * sign(random)), f64x8::splat(low))
}

fn exactly(value: DoubleDouble) -> Dyadic {
    let [high, low] = [value.high, value.low].map(|part| part.to_array()[0]);
    dyadic(high) + dyadic(low)
}

/// The search compares with these numbers errors that are 10^13 times greater.
#[test]
fn each_operation_is_wrong_by_less_than_16_squared_units() {
    let close = |error: &Dyadic, exact: &Dyadic, times: f64| {
        let bound = dyadic(times * 16.0 * U * U) * exact;
        error * error <= &bound * &bound
    };
    for number in 0..100_000 {
        let random = &mut Random::new(number);
        let (a, b) = (any(random), any(random));
        let (x, y) = (exactly(a), exactly(b));
        let check = |what: &str, right: bool| assert!(right, "{number}: {what} of {a:?} {b:?}");
        let sum = &x + &y;
        check("sum", close(&(exactly(a + b) - &sum), &sum, 1.0));
        let difference = &x - &y;
        check(
            "difference",
            close(&(exactly(a - b) - &difference), &difference, 1.0),
        );
        let product = &x * &y;
        check(
            "product",
            close(&(exactly(a * b) - &product), &product, 1.0),
        );
        // q = x/y (1 + e): q y - x = e x.
        check("quotient", close(&(exactly(a / b) * &y - &x), &x, 1.0));
        // root^2 = x (1 + e)^2
        let (root, x) = (exactly(a.abs().root()), exactly(a.abs()));
        check("root", close(&(&root * &root - &x), &x, 2.0));
    }
}
