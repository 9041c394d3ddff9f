//! The intersection of rays and spheres in doubles, in eight lanes, with a running bound of the
//! rounding errors.
//!
//! ```text
//! N = C x V        D = r^2 A - N.N     (= B^2 - A c, by Lagrange's identity)
//! B = C.V          A = V.V             c = C.C - r^2
//! ```
//!
//! The cross product avoids most of the cancellation in `D`: its error is relative to
//! `|C||V| |N|`, and that of `B^2 - A c` to `|C|^2 |V|^2`. For `|C|/r = 10^6` that is `10^-10`
//! of `r^2` instead of `10^-4`.
//!
//! Lanes are rays or spheres: eight pixels of a row and one sphere, or one pixel and eight
//! spheres.

use wide::f64x8;

use super::{
    bounds::{CANCELLATION_LIMIT, SIGHT_ALONG, SIGHT_POWER},
    grid::{EightSpheres, splat},
    kernels::{Number, Sight, component, difference_at, squared_length},
};
use crate::{camera::Camera, spheres::double};

#[cfg(test)]
mod tests;

/// Bounds of the inverse depths at which eight rays hit eight spheres, in units of `V`. The
/// upper bound is minus infinity if the sphere is certainly missed, and the lower bound is
/// minus infinity if it is not certainly hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sights {
    pub(super) lower: f64x8,
    pub(super) upper: f64x8,
}

/// Eight rays `V`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays {
    v: [f64x8; 3],
    /// `A = V.V`
    a: f64x8,
}

/// Eight spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Targets {
    spheres: EightSpheres,
    /// `c`, within 7 roundings; its sign is exact, zero included.
    power: f64x8,
}

impl Rays {
    /// The ray of pixel `(column, row)` in every lane, `x` and `y` within two roundings.
    pub(super) fn of_pixel(camera: &Camera, column: u32, row: u32) -> Self {
        let (x, x_unit) = camera.x_ratio(column);
        Self::new(camera, splat(x as f64), x_unit, row)
    }

    /// The rays of pixels `column..column + 8` of a row.
    pub(super) fn of_row(camera: &Camera, column: u32, row: u32) -> Self {
        let lanes = std::array::from_fn(|lane| column.saturating_add(lane as u32));
        let x = lanes.map(|column| camera.x_ratio(column).0 as f64);
        Self::new(camera, f64x8::new(x), camera.x_ratio(column).1, row)
    }

    fn new(camera: &Camera, x: f64x8, x_unit: i64, row: u32) -> Self {
        let viewport = camera.viewport();
        let (y, y_unit) = camera.y_ratio(row);
        let extents = [viewport.width, viewport.height, viewport.distance];
        let [width, height, z] = extents.map(|extent| splat(double(extent)));
        let v = [
            component(width, x, splat(x_unit as f64)),
            component(height, splat(y as f64), splat(y_unit as f64)),
            z,
        ];
        Self {
            v,
            a: squared_length(v),
        }
    }
}

impl Targets {
    /// Up to eight spheres, each as centre and radius; the last one fills the rest.
    pub(super) fn of(spheres: impl Iterator<Item = [f32; 4]>) -> Self {
        let spheres = EightSpheres::of(spheres);
        let EightSpheres { x, y, z, r } = spheres;
        Self {
            spheres,
            power: power([x, y, z, r]),
        }
    }

    /// Whether the camera is on the surface of all of them.
    pub(super) fn are_touched(&self) -> bool {
        let zero = splat(0.0);
        (self.power.simd_gt(zero) | zero.simd_gt(self.power)).to_bitmask() == 0
    }
}

impl Sights {
    /// Theorem 6 of the proof.
    pub(super) fn new(rays: &Rays, targets: &Targets) -> Self {
        let EightSpheres { x, y, z, r } = targets.spheres;
        let (c, zero) = (targets.power, splat(0.0));
        let sight = Sight::new([x, y, z, r], rays.v, rays.a);
        let outside = c.simd_gt(zero);
        let from_outside = Self::from_outside(&sight, c);
        if outside.to_bitmask() == 0xff {
            return from_outside;
        }
        let inside = Self::from_inside(&sight, rays.a, c);
        let others = inside.where_or(c.simd_lt(zero), Self::from_the_surface(&sight, rays.a));
        from_outside.where_or(outside, others)
    }

    /// Where `c > 0`.
    fn from_outside(sight: &Sight<f64x8>, c: f64x8) -> Self {
        let (zero, none) = (splat(0.0), splat(f64::NEG_INFINITY));
        let Sight { b, d, .. } = sight;
        let met = d.value.simd_gt(d.bound) & b.lower.simd_gt(zero);
        let missed = d.value.simd_lt(-d.bound) | b.upper.simd_lt(zero);
        let [lower, upper] = sight.seen_from_outside(c);
        Self {
            lower: met.select(lower, none),
            upper: missed.select(none, upper),
        }
    }

    /// Where `c < 0`: of two equal formulas, the one without cancellation.
    fn from_inside(sight: &Sight<f64x8>, a: f64x8, c: f64x8) -> Self {
        let zero = splat(0.0);
        let [lower, upper] = sight.seen_ahead_from_inside(a);
        let is_ahead = (sight.root_lower + sight.b.lower).simd_gt(zero);
        let ahead = Self {
            lower,
            upper: is_ahead.select(upper, splat(f64::INFINITY)),
        };
        let [lower, upper] = sight.seen_back_from_inside(c);
        Self { lower, upper }.where_or(sight.b.value.simd_lt(zero), ahead)
    }

    /// Where `c = 0`.
    fn from_the_surface(sight: &Sight<f64x8>, a: f64x8) -> Self {
        let (none, infinite) = (splat(f64::NEG_INFINITY), splat(f64::INFINITY));
        let met = sight.b.lower.simd_gt(splat(0.0));
        let missed = sight.b.upper.simd_lt(splat(0.0));
        let [lower, upper] = sight.seen_from_the_surface(a);
        Self {
            lower: met.select(lower, none),
            upper: met.select(upper, missed.select(none, infinite)),
        }
    }

    fn where_or(self, mask: f64x8, other: Self) -> Self {
        Self {
            lower: mask.select(self.lower, other.lower),
            upper: mask.select(self.upper, other.upper),
        }
    }

    /// The lanes that are surely hit.
    pub(super) fn hit(&self) -> u32 {
        self.lower.simd_gt(splat(f64::NEG_INFINITY)).to_bitmask()
    }
}

/// Spheres that are told apart by their powers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    /// Lanes in which the first of two spheres is nearer, and in which the second is.
    pub(super) first: u32,
    pub(super) second: u32,
    /// In these, the greater the farther the hits are from where both spheres would be equally near.
    pub(super) apart: f64x8,
}

impl Order {
    /// Compares spheres, lane by lane, whose `sights` along the same rays are given. The sign of
    ///
    /// ```text
    /// f = (c' - c) s - 2 (C' - C).V
    /// ```
    ///
    /// with `s` of either hit says on which side of their radical plane the hits are. (Theorem 11.)
    pub(super) fn new(rays: &Rays, [first, second]: [(&Targets, &Sights); 2]) -> Self {
        let lengths = |&EightSpheres { x, y, z, r }: &EightSpheres| [x, y, z, r];
        let upper = first.1.upper.fast_max(second.1.upper);
        let lower = first.1.lower.fast_min(second.1.lower);
        let ([power, power_terms, along_terms], apart) = difference_at(
            lengths(&first.0.spheres),
            lengths(&second.0.spheres),
            rays.v,
            upper,
        );
        let bound = splat(SIGHT_POWER) * power_terms * upper
            + splat(SIGHT_ALONG) * along_terms
            + power.abs() * (upper - lower);
        let zero = splat(0.0);
        let outside = first.0.power.simd_gt(zero) & second.0.power.simd_gt(zero);
        let outside = outside.to_bitmask();
        let above = apart.simd_gt(bound).to_bitmask();
        let below = (-bound).simd_gt(apart).to_bitmask();
        Self {
            first: above & outside | below & !outside,
            second: below & outside | above & !outside,
            apart: apart.abs(),
        }
    }
}

/// [`power`] of eight spheres, whose `yz = Cy^2 + Cz^2` and `k = yz - r^2` are given. Where
/// enough of `k` is left, `Cx^2 + k` is a sum of positive terms; its relative error is below
/// `2^-32`.
#[inline]
pub(super) fn powers_of_camera(spheres: &EightSpheres, yz: f64x8, k: f64x8) -> f64x8 {
    let sure = k.simd_gt(splat(CANCELLATION_LIMIT) * yz);
    let powers = spheres.x.mul_add(spheres.x, k);
    if sure.to_bitmask() == 0xff {
        return powers;
    }
    let &EightSpheres { x, y, z, r } = spheres;
    sure.select(powers, power([x, y, z, r]))
}

/// `c = C.C - r^2`, the power of the camera with respect to a sphere, of lengths that are floats. Its sign
/// is exact, zero included, and its relative error is at most 7 U.
///
/// The squares are exact in doubles. Their sum is kept as an expansion of doubles that do not
/// overlap, whose largest component has the sign (J. Shewchuk,
/// Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
/// Predicates, 1997, section 2.4, Grow-Expansion).
pub(super) fn power<N: Number>(lengths: [N; 4]) -> N {
    let [x, y, z, r] = lengths.map(|length| length * length);
    let zero = N::constant(0.0);
    let mut expansion = [zero; 4];
    for (length, term) in [x, y, z, -r].into_iter().enumerate() {
        grow(&mut expansion, length, term);
    }
    expansion.into_iter().fold(zero, |sum, term| sum + term)
}

/// Adds a term to an expansion of `length` components.
#[inline(always)]
fn grow<N: Number>(expansion: &mut [N; 4], length: usize, term: N) {
    let mut sum = term;
    for component in &mut expansion[..length] {
        (sum, *component) = sum.two_sum(*component);
    }
    expansion[length] = sum;
}
