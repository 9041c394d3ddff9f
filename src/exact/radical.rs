//! Which of two spheres is nearer, pixel by pixel, from the plane in which both have the same
//! power: their radical plane.
//!
//! On one side of the plane the power of the first sphere is less, so what is inside the second
//! sphere is inside the first one too, and the other way round on the other side. So for a ray that
//! hits both it is enough to know on which side one of the hits is (theorem 10). A ray meets the
//! plane at
//!
//! ```text
//! 1/z = 2 (C' - C).V/(c' - c)
//! ```
//!
//! if `C`, `c` are those of the tested sphere and `C'`, `c'` those of the other one. With `d`, `b` of
//! [`depths`](super::depths) for the tested sphere, its hit is before the plane where
//!
//! ```text
//! d - l |l| > 0       l = 2 (C' - C).V/(c' - c) - b
//! ```
//!
//! and there that sphere is nearer, but for one case: if the camera is in or on both spheres, and the
//! tested one has less power, it is nearer behind the plane.

use wide::f32x8;

use super::{
    bins::Record,
    bounds::{
        CANCELLATION_LIMIT, DIFFERENCE_BOUND, GREATEST_SIDE, PLANE_ROUNDINGS, PLANE_SIDE_BOUND,
        PLANE_TERMS_BOUND, POWERS_CANCELLATION_LIMIT, SIDE_BOUND, U, UNDERFLOW_BOUND,
    },
    depths::SphereDepths,
    grid::{Grid, SIDE, STEPS, float_above},
    kernels::{in_column, in_row, power_difference, radical_plane},
    tuning::Bounds,
};
use crate::spheres::LANES;

#[cfg(test)]
mod tests;

/// The pixels that the boxes of two records have in common: first and last column, first and last
/// row.
pub(super) fn common_sides(a: &Record, b: &Record) -> Option<[usize; 4]> {
    let ([left, right, top, bottom], other) = (a.sides, b.sides);
    let sides = [
        left.max(other[0]),
        right.min(other[1]),
        top.max(other[2]),
        bottom.min(other[3]),
    ];
    let [left, right, top, bottom] = sides;
    (left <= right && top <= bottom).then(|| sides.map(usize::from))
}

/// Which of two spheres is nearer in the pixels of a region in which both are hit.
#[derive(Clone, Copy, Debug)]
pub(super) enum Nearer {
    First,
    Second,
    Varies(Seam),
    Unknown,
}

/// `d` and `l` in floats: where two spheres change places.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seam {
    /// Whether the first sphere is nearer where `d - l |l| > 0`.
    above_is_first: bool,
    region: [usize; 4],
    d: [f32; 6],
    l: [f32; 3],
    /// The column and the row of the tile in which `p = q = 0`.
    column: f32,
    row: f32,
    /// The error bound of `d - l |l|`.
    bound: f32,
}

/// Columns of each row in which the first sphere is certainly nearer, and the second one, if both
/// are hit.
#[derive(Debug)]
pub(super) struct NearerColumns {
    pub(super) first: [u64; SIDE],
    pub(super) second: [u64; SIDE],
}

impl Default for NearerColumns {
    fn default() -> Self {
        Self {
            first: [0; SIDE],
            second: [0; SIDE],
        }
    }
}

/// Compares two spheres in a region that lies within the boxes of both.
pub(super) fn compare(
    grid: &Grid,
    bounds: Bounds,
    region: [usize; 4],
    first: &SphereDepths,
    second: &SphereDepths,
) -> Nearer {
    let PowerBetween {
        difference,
        limit,
        error,
    } = PowerBetween::new(first, second);
    let Choice {
        tests_first,
        tests_less,
        both_outside,
    } = Choice::new(first, second, difference);
    let (tested, other, power) = if tests_first {
        (first, second, difference)
    } else {
        (second, first, -difference)
    };
    let on_both = first.power == 0.0 && second.power == 0.0;
    let flat;
    let (mut depths, mut plane, above_is_tested) = if power.abs() > limit && tested.known {
        let plane = Plane::new(grid, tested, other, power, error / power.abs());
        (tested, plane, both_outside || !tests_less)
    } else if on_both || tested.known && other.known {
        let most = if on_both { 0.0 } else { 2.0 * limit };
        flat = tested.without_depths();
        (
            &flat,
            Plane::through_camera(grid, tested, other, both_outside, most),
            true,
        )
    } else {
        return Nearer::Unknown;
    };
    let in_unit;
    if plane.terms() > GREATEST_SIDE {
        let unit = unit_of(plane.terms());
        in_unit = depths.times(unit);
        (depths, plane) = (&in_unit, plane.times(unit));
    }
    let mut side = Side::new(grid, depths, other, &plane);
    match bounds {
        Bounds::Proven => {}
        Bounds::Ignored => (side.l_bound, side.bound) = (0.0, 0.0),
        Bounds::Refused => return Nearer::Unknown,
    }
    side.nearer(region, tests_first == above_is_tested)
}

/// The power of the second sphere less that of the first: from the spheres, or, where that cancels
/// less, from both powers.
struct PowerBetween {
    difference: f64,
    /// Beyond this the difference has the right sign and is wrong by at most `2^-27` of itself; within
    /// it the real one is below twice the limit.
    limit: f64,
    /// What the difference may be wrong by; less than `2^-27` of itself where little cancels.
    error: f64,
}

impl PowerBetween {
    fn new(first: &SphereDepths, second: &SphereDepths) -> Self {
        let (terms, difference) = power_difference(first.sphere, second.sphere);
        let terms = terms.iter().map(|term| term.abs()).sum::<f64>();
        let powers = first.power.abs() + second.power.abs();
        if powers * POWERS_CANCELLATION_LIMIT < terms * CANCELLATION_LIMIT {
            Self {
                difference: second.power - first.power,
                limit: powers * POWERS_CANCELLATION_LIMIT,
                error: first.power_error() + second.power_error() + powers * U,
            }
        } else {
            Self {
                difference,
                limit: terms * CANCELLATION_LIMIT,
                error: terms * DIFFERENCE_BOUND,
            }
        }
    }
}

/// Which of two spheres is tested.
struct Choice {
    tests_first: bool,
    /// Whether it is the one of less power.
    tests_less: bool,
    /// Whether the camera is outside both.
    both_outside: bool,
}

impl Choice {
    /// `difference` is the power of the second sphere less that of the first.
    fn new(first: &SphereDepths, second: &SphereDepths, difference: f64) -> Self {
        // The signs of the powers are exact; that of their difference need not be.
        let outside = [first, second].map(|sphere| sphere.power > 0.0);
        let first_is_less = if outside[0] == outside[1] {
            difference > 0.0
        } else {
            outside[1]
        };
        let greater = if first_is_less { second } else { first };
        // Of two that the camera is in or on, either will do.
        let tests_less = outside == [true, true] || outside == [false, false] && !greater.known;
        Self {
            tests_first: first_is_less == tests_less,
            tests_less,
            both_outside: outside == [true, true],
        }
    }
}

/// The greatest power of two by which `terms` becomes at most [`GREATEST_SIDE`]. Powers of two
/// change no sign.
#[cold]
fn unit_of(terms: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    f64::from_bits((GREATEST_SIDE / terms).to_bits() & EXPONENT)
}

/// What `l` is computed from, but for the spheres.
struct Plane {
    /// `2 g/(c' - c)`
    scale: f64,
    /// What `c' - c` is wrong by, of itself.
    error: f64,
    /// The sums of the magnitudes of the terms of the plane, and of `b`.
    of_plane: f64,
    of_b: f64,
    /// What `l` may be wrong by, but for its terms.
    more: f64,
}

impl Plane {
    /// `power` is `c' - c`, wrong by `error` of itself.
    fn new(
        grid: &Grid,
        tested: &SphereDepths,
        other: &SphereDepths,
        power: f64,
        error: f64,
    ) -> Self {
        let scale = 2.0 * grid.scale / power;
        let apart = |axis: usize| (other.sphere[axis] - tested.sphere[axis]).abs();
        let x_upper = tested.x0.abs() + tested.across * grid.x_axis.step.abs();
        let y_upper = tested.y0.abs() + tested.down * grid.y_axis.step.abs();
        let terms = apart(0) * x_upper + apart(1) * y_upper + apart(2);
        Self {
            scale,
            error,
            of_plane: scale.abs() * terms,
            of_b: tested.b_terms,
            more: 0.0,
        }
    }

    /// If the camera is nearly in the plane, the direction of the ray decides. `c' - c` is at most
    /// `most`.
    fn through_camera(
        grid: &Grid,
        tested: &SphereDepths,
        other: &SphereDepths,
        both_outside: bool,
        most: f64,
    ) -> Self {
        let unit = grid.scale * grid.scale;
        let power = if both_outside { unit } else { -unit };
        let more = if most == 0.0 {
            0.0
        } else {
            most / unit * tested.upper().max(other.upper())
        };
        Self {
            more,
            of_b: 0.0,
            ..Self::new(grid, tested, other, power, 0.0)
        }
    }

    fn terms(&self) -> f64 {
        self.of_plane + self.of_b
    }

    fn times(&self, unit: f64) -> Self {
        Self {
            scale: self.scale * unit,
            error: self.error,
            of_plane: self.of_plane * unit,
            of_b: self.of_b * unit,
            more: self.more * unit,
        }
    }

    /// What the terms of `l` may be wrong by, where that is less than what is always enough.
    #[cold]
    fn error_of_terms(&self, tested: &SphereDepths) -> f64 {
        let of_power = tested.power_error() / tested.power.abs();
        self.error * self.of_plane + of_power * self.of_b + PLANE_ROUNDINGS * self.terms()
    }
}

/// On which side of the radical plane the tested sphere is hit: `d` and `l` in doubles.
struct Side<'a> {
    depths: &'a SphereDepths,
    l: [f64; 3],
    /// The error bound of `l` evaluated in floats.
    l_bound: f64,
    /// The error bound of `d - l |l|` evaluated in floats.
    bound: f64,
}

impl<'a> Side<'a> {
    fn new(grid: &Grid, depths: &'a SphereDepths, other: &SphereDepths, plane: &Plane) -> Self {
        let place = [depths.x0, depths.y0, grid.x_axis.step, -grid.y_axis.step];
        let l = radical_plane(depths.sphere, other.sphere, plane.scale, place, depths.b);
        let l_upper = l[0].abs() + depths.across * l[1].abs() + depths.down * l[2].abs();
        let in_floats = PLANE_SIDE_BOUND * l_upper;
        let mut of_terms = PLANE_TERMS_BOUND * plane.terms();
        if of_terms > in_floats && depths.power != 0.0 {
            of_terms = of_terms.min(plane.error_of_terms(depths));
        }
        let l_bound = in_floats + of_terms + UNDERFLOW_BOUND + plane.more;
        let l_upper = l_upper + l_bound;
        let squares = 2.0 * l_bound + SIDE_BOUND * l_upper;
        Self {
            depths,
            l,
            l_bound,
            bound: depths.d_bound + squares * l_upper + UNDERFLOW_BOUND,
        }
    }

    /// Which sphere is nearer in a region; where `d - l |l| > 0` it is the first or the second.
    fn nearer(&self, region: [usize; 4], above_is_first: bool) -> Nearer {
        let Self {
            depths,
            l,
            l_bound,
            bound,
        } = self;
        let (above, below) = if above_is_first {
            (Nearer::First, Nearer::Second)
        } else {
            (Nearer::Second, Nearer::First)
        };
        let half = |from: usize, to: usize, origin: f64| {
            let (from, to) = (from as f64 - origin, to as f64 - origin);
            [0.5 * (from + to), 0.5 * (to - from)]
        };
        let [left, right, top, bottom] = region;
        let [p, across] = half(left, right, depths.column);
        let [q, down] = half(top, bottom, depths.row);
        let middle = l[0] + l[1] * p + l[2] * q;
        let span = (l[1] * across).abs() + (l[2] * down).abs() + 2.0 * l_bound;
        let (lower, upper) = (middle - span, middle + span);
        if upper < 0.0 {
            return above;
        }
        let [least, greatest] = depths.range_of_d([p, across], [q, down]);
        if upper * upper < least {
            return above;
        }
        if lower > 0.0 && lower * lower > greatest {
            return below;
        }
        let float = |value: f64| value as f32;
        Nearer::Varies(Seam {
            above_is_first,
            region,
            d: depths.d.map(float),
            l: l.map(float),
            column: float(depths.column),
            row: float(depths.row),
            bound: float_above(*bound),
        })
    }
}

impl Seam {
    /// The columns of the region in which either sphere is nearer, and up to seven beyond it; none in
    /// other rows of its groups of eight.
    #[inline]
    pub(super) fn columns(&self, nearer: &mut NearerColumns) {
        let [left, right, top, bottom] = self.region;
        let octets = top / LANES * LANES..(bottom / LANES + 1) * LANES;
        nearer.first[octets.clone()].fill(0);
        nearer.second[octets].fill(0);
        let [first, second] = if self.above_is_first {
            [&mut nearer.first, &mut nearer.second]
        } else {
            [&mut nearer.second, &mut nearer.first]
        };
        let (first, second) = (&mut first[top..bottom + 1], &mut second[top..bottom + 1]);
        let bound = f32x8::splat(self.bound);
        for column in (left..right + 1).step_by(LANES) {
            let p = f32x8::new(STEPS) + f32x8::splat(column as f32 - self.column);
            let (d, l) = in_column(self.d.map(f32x8::splat), self.l.map(f32x8::splat), p);
            let mut q = f32x8::splat(top as f32 - self.row);
            for (first, second) in first.iter_mut().zip(&mut *second) {
                let [d, l] = in_row(d, l, q);
                let side = d - l * l.abs();
                *first |= u64::from(side.simd_gt(bound).to_bitmask()) << column;
                *second |= u64::from(side.simd_lt(-bound).to_bitmask()) << column;
                q += f32x8::splat(1.0);
            }
        }
    }
}
