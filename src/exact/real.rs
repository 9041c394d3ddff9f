//! Real numbers in lanes: doubles, and double-doubles for what doubles can't tell.

use std::ops::{Add, Div, Mul, Sub};

use wide::f64x8;

use super::{
    bounds::{U, U_DOUBLE_DOUBLE},
    grid::splat,
};

#[cfg(test)]
mod tests;

/// Eight numbers of one arithmetic. Each operation rounds by at most [`Self::ROUNDOFF`]
/// of its result.
pub(super) trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Unit roundoff.
    const ROUNDOFF: f64;

    /// Doubles as they are.
    fn of(doubles: f64x8) -> Self;
    /// The sum of a double and a much smaller one.
    fn of_sum(doubles: f64x8, rest: f64x8) -> Self;
    /// Of numbers that are not negative.
    fn sqrt(self) -> Self;
    /// Lanes that are greater than those of `other`; none where one is not a number.
    fn exceeds(self, other: Self) -> f64x8;
    /// The lanes of `self` where `mask` is set, else those of `other`.
    fn where_or(self, mask: f64x8, other: Self) -> Self;

    /// The greatest lane, in every lane.
    fn greatest(self) -> Self;

    fn splat(value: f64) -> Self {
        Self::of(splat(value))
    }

    fn abs(self) -> Self {
        let zero = Self::splat(0.0);
        (zero - self).where_or(zero.exceeds(self), self)
    }

    /// Zero where it is negative.
    fn positive_part(self) -> Self {
        let zero = Self::splat(0.0);
        zero.where_or(zero.exceeds(self), self)
    }
}

impl Real for f64x8 {
    const ROUNDOFF: f64 = U;

    fn of(doubles: f64x8) -> Self {
        doubles
    }

    fn of_sum(doubles: f64x8, rest: f64x8) -> Self {
        doubles + rest
    }

    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    fn exceeds(self, other: Self) -> f64x8 {
        self.simd_gt(other)
    }

    fn where_or(self, mask: f64x8, other: Self) -> Self {
        mask.select(self, other)
    }

    fn greatest(self) -> Self {
        splat(
            self.to_array()
                .into_iter()
                .fold(f64::NEG_INFINITY, f64::max),
        )
    }
}

/// The sum of two doubles, of which the second is at most half a unit in the last
/// place of the first (theorem 6). The operations are those of Joldes, Muller and Popescu (2017),
/// the root that of Lefevre and others (2023): see [`U_DOUBLE_DOUBLE`].
#[derive(Clone, Copy, Debug)]
pub(super) struct DoubleDouble {
    high: f64x8,
    low: f64x8,
}

/// `a + b` as its rounded sum and the rounding error, exactly (Knuth).
pub(super) fn two_sum<T>(a: T, b: T) -> (T, T)
where
    T: Copy + Add<Output = T> + Sub<Output = T>,
{
    let sum = a + b;
    let virtual_b = sum - a;
    let virtual_a = sum - virtual_b;
    (sum, (a - virtual_a) + (b - virtual_b))
}

/// As [`two_sum`], for `|a| >= |b|` or `a = 0` (Dekker).
fn fast_two_sum(a: f64x8, b: f64x8) -> DoubleDouble {
    let high = a + b;
    DoubleDouble {
        high,
        low: b - (high - a),
    }
}

/// The upper and the lower half of the digits (Veltkamp); for `|a| < 2^996`.
fn split(a: f64x8) -> (f64x8, f64x8) {
    let c = splat(134_217_729.0) * a;
    let high = c - (c - a);
    (high, a - high)
}

/// `a b` as its rounded product and the rounding error, exactly (Dekker), unless that
/// underflows.
fn two_product(a: f64x8, b: f64x8) -> (f64x8, f64x8) {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    let rest = a_high * b_high - product + a_high * b_low + a_low * b_high;
    (product, rest + a_low * b_low)
}

#[cfg(test)]
impl DoubleDouble {
    /// What it is the sum of.
    pub(super) fn parts(self) -> [f64x8; 2] {
        [self.high, self.low]
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, rest) = two_sum(self.high, other.high);
        let (low, last) = two_sum(self.low, other.low);
        let sum = fast_two_sum(high, rest + low);
        fast_two_sum(sum.high, last + sum.low)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + Self {
            high: -other.high,
            low: -other.low,
        }
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (high, rest) = two_product(self.high, other.high);
        let crossed = self.high * other.low + self.low * other.high;
        fast_two_sum(high, rest + crossed)
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

impl Real for DoubleDouble {
    const ROUNDOFF: f64 = U_DOUBLE_DOUBLE;

    fn of(doubles: f64x8) -> Self {
        Self {
            high: doubles,
            low: splat(0.0),
        }
    }

    fn of_sum(doubles: f64x8, rest: f64x8) -> Self {
        fast_two_sum(doubles, rest)
    }

    fn sqrt(self) -> Self {
        let root = self.high.sqrt();
        let (square, rest) = two_product(root, root);
        let rest = ((self.high - square) - rest) + self.low;
        let low = rest / (root + root);
        let zero = splat(0.0);
        fast_two_sum(root, root.simd_gt(zero).select(low, zero))
    }

    fn exceeds(self, other: Self) -> f64x8 {
        let equal = self.high.simd_eq(other.high) & self.low.simd_gt(other.low);
        self.high.simd_gt(other.high) | equal
    }

    fn where_or(self, mask: f64x8, other: Self) -> Self {
        Self {
            high: mask.select(self.high, other.high),
            low: mask.select(self.low, other.low),
        }
    }

    fn greatest(self) -> Self {
        let lanes = self.high.to_array().into_iter().zip(self.low.to_array());
        let (high, low) = lanes.fold((f64::NEG_INFINITY, 0.0), |greatest, lane| {
            if lane > greatest { lane } else { greatest }
        });
        Self {
            high: splat(high),
            low: splat(low),
        }
    }
}
