//! Real numbers in lanes: doubles, and double-doubles for what doubles can't decide.

use std::ops::{Add, Div, Mul, Sub};

use wide::f64x8;

use super::{
    bounds::{U, U_DOUBLE_DOUBLE},
    grid::splat,
    kernels::Number,
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

    /// Exactly these doubles.
    fn of(doubles: f64x8) -> Self;
    /// A double and the rest of a number, of which this arithmetic may hold only the double.
    fn of_sum(doubles: f64x8, rest: f64x8) -> Self;
    /// The square root of numbers that are not negative.
    fn sqrt(self) -> Self;
    /// A mask of the lanes that are greater than those of `other`; clear where one is NaN.
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

    /// The number, or zero where it is negative.
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

    fn of_sum(doubles: f64x8, _: f64x8) -> Self {
        doubles
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
/// place of the first. What the operations round is proven with theorem 6.
#[derive(Clone, Copy, Debug)]
pub(super) struct DoubleDouble<T = f64x8> {
    high: T,
    low: T,
}

impl<T> From<(T, T)> for DoubleDouble<T> {
    fn from((high, low): (T, T)) -> Self {
        Self { high, low }
    }
}

#[cfg(test)]
impl<T> DoubleDouble<T> {
    /// Its two parts.
    pub(super) fn parts(self) -> [T; 2] {
        [self.high, self.low]
    }
}

impl<T: Number> Add for DoubleDouble<T> {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, rest) = self.high.two_sum(other.high);
        let (low, last) = self.low.two_sum(other.low);
        let (high, low) = high.fast_two_sum(rest + low);
        high.fast_two_sum(last + low).into()
    }
}

impl<T: Number> Sub for DoubleDouble<T> {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + Self {
            high: -other.high,
            low: -other.low,
        }
    }
}

impl<T: Number> Mul for DoubleDouble<T> {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let (high, rest) = self.high.two_product(other.high);
        let crossed = self.high * other.low + self.low * other.high;
        high.fast_two_sum(rest + crossed).into()
    }
}

impl<T: Number> Div for DoubleDouble<T> {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        let (high, rest) = first.two_product(other.high);
        let (high, low) = high.fast_two_sum(rest + first * other.low);
        let rest = (self.high - high) + (self.low - low);
        first.fast_two_sum(rest / other.high).into()
    }
}

impl<T: Number> DoubleDouble<T> {
    /// The root of the high part, and the correction of that root; the correction for 0 is NaN.
    fn root_and_rest(self) -> [T; 2] {
        let root = self.high.root();
        let (square, rest) = root.two_product(root);
        let rest = ((self.high - square) - rest) + self.low;
        [root, rest / (root + root)]
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
        doubles.fast_two_sum(rest).into()
    }

    fn sqrt(self) -> Self {
        let [root, rest] = self.root_and_rest();
        let zero = splat(0.0);
        root.fast_two_sum(root.simd_gt(zero).select(rest, zero))
            .into()
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
