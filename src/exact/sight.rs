//! The intersection of rays and spheres, in eight lanes and in any arithmetic, with a running
//! bound of the rounding errors.
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
    bounds::{
        CANCELLATION_LIMIT, SIGHT_ALONG, SIGHT_CROSS, SIGHT_DOT, SIGHT_POWER, SIGHT_QUOTIENT,
        SIGHT_SQUARED_CROSS, SIGHT_SQUARED_RADIUS,
    },
    grid::{EightSpheres, splat},
    kernels::{Number, difference_at},
    real::Real,
};
use crate::{
    camera::Camera,
    spheres::{LANES, Sphere, double},
};

#[cfg(test)]
mod tests;

/// Bounds of the inverse depths at which eight rays hit eight spheres, in units of `V`. The
/// upper bound is minus infinity if the sphere is certainly missed, and the lower bound is
/// minus infinity if it is not certainly hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sights<N> {
    pub(super) lower: N,
    pub(super) upper: N,
}

/// Eight rays `V`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays<N> {
    x: N,
    y: N,
    z: N,
    /// `A = V.V`
    a: N,
}

/// Eight spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Targets<N> {
    centre: [N; 3],
    radius: N,
    /// `c`, within 7 roundings; its sign is exact, zero included.
    power: N,
}

impl<N: Real> Rays<N> {
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
        let of = |extent: f32, numerator: f64x8, unit: i64| {
            N::splat(f64::from(extent)) * N::of(numerator) / N::splat(unit as f64)
        };
        let x = of(viewport.width, x, x_unit);
        let y = of(viewport.height, splat(y as f64), y_unit);
        let z = N::splat(double(viewport.distance));
        Self {
            x,
            y,
            z,
            a: x * x + y * y + z * z,
        }
    }
}

impl<N: Real> Targets<N> {
    /// Up to eight spheres, each as centre and radius; the last one fills the rest.
    pub(super) fn of(spheres: impl Iterator<Item = [f32; 4]>) -> Self {
        let mut spheres = spheres.fuse();
        let mut last = [0.0, 0.0, 1.0, 0.5];
        let eight: [[f32; 4]; LANES] = std::array::from_fn(|_| {
            last = spheres.next().unwrap_or(last);
            last
        });
        let component = |at: usize| f64x8::new(eight.map(|sphere| double(sphere[at])));
        let lengths = [component(0), component(1), component(2), component(3)];
        let (power, rest) = power(lengths);
        let [x, y, z, radius] = lengths.map(N::of);
        Self {
            centre: [x, y, z],
            radius,
            power: N::of_sum(power, rest),
        }
    }

    /// Whether the camera is on the surface of all of them.
    pub(super) fn are_touched(&self) -> bool {
        let zero = N::splat(0.0);
        (self.power.exceeds(zero) | zero.exceeds(self.power)).to_bitmask() == 0
    }
}

/// `B = C.V`, and its bounds.
#[derive(Clone, Copy)]
struct Ahead<N> {
    value: N,
    lower: N,
    upper: N,
}

impl<N: Real> Ahead<N> {
    fn new(rays: &Rays<N>, targets: &Targets<N>) -> Self {
        let [cx, cy, cz] = targets.centre;
        let [x, y, z] = [cx * rays.x, cy * rays.y, cz * rays.z];
        let value = x + y + z;
        let bound = units::<N>(SIGHT_DOT) * (x.abs() + y.abs() + z.abs());
        Self {
            value,
            lower: value - bound,
            upper: value + bound,
        }
    }
}

/// `D`, its bound, and the bounds of its root.
#[derive(Clone, Copy)]
struct Discriminant<N> {
    value: N,
    bound: N,
    root_lower: N,
    root_upper: N,
}

impl<N: Real> Discriminant<N> {
    fn new(&Rays { x, y, z, a }: &Rays<N>, targets: &Targets<N>) -> Self {
        let [cx, cy, cz] = targets.centre;
        let (zero, two) = (N::splat(0.0), N::splat(2.0));
        let (mut squared_cross, mut cross_bound) = (zero, zero);
        for (p, q) in [(cy * z, cz * y), (cz * x, cx * z), (cx * y, cy * x)] {
            let n = p - q;
            let bound = units::<N>(SIGHT_CROSS) * (p.abs() + q.abs());
            squared_cross = squared_cross + n * n;
            cross_bound = cross_bound + (two * n.abs() + bound) * bound;
        }
        let squared_radius = targets.radius * targets.radius * a;
        let value = squared_radius - squared_cross;
        let bound = units::<N>(SIGHT_SQUARED_RADIUS) * squared_radius
            + units::<N>(SIGHT_SQUARED_CROSS) * squared_cross
            + cross_bound;
        Self {
            value,
            bound,
            root_lower: (value - bound).positive_part().sqrt(),
            root_upper: (value + bound).positive_part().sqrt(),
        }
    }
}

/// So many roundings.
fn units<N: Real>(count: f64) -> N {
    N::splat(count * N::ROUNDOFF)
}

/// Below and above an inverse depth by the roundings of its last operations.
fn down<N: Real>(s: N) -> N {
    s * (N::splat(1.0) - units::<N>(SIGHT_QUOTIENT))
}

fn up<N: Real>(s: N) -> N {
    s * (N::splat(1.0) + units::<N>(SIGHT_QUOTIENT))
}

impl<N: Real> Sights<N> {
    /// Theorem 6 of the proof.
    pub(super) fn new(rays: &Rays<N>, targets: &Targets<N>) -> Self {
        let (c, zero) = (targets.power, N::splat(0.0));
        let (outside, inside) = (c.exceeds(zero), zero.exceeds(c));
        let b = Ahead::new(rays, targets);
        let d = Discriminant::new(rays, targets);
        if outside.to_bitmask() == 0xff {
            return Self::from_outside(c, b, d);
        }
        let surface = Self::from_the_surface(rays.a, b);
        let within = Self::from_inside(rays.a, c, b, d).where_or(inside, surface);
        Self::from_outside(c, b, d).where_or(outside, within)
    }

    /// Where `c > 0`.
    fn from_outside(c: N, b: Ahead<N>, d: Discriminant<N>) -> Self {
        let (zero, none) = (N::splat(0.0), N::splat(f64::NEG_INFINITY));
        let met = d.value.exceeds(d.bound) & b.lower.exceeds(zero);
        let missed = (zero - d.bound).exceeds(d.value) | zero.exceeds(b.upper);
        Self {
            lower: down((b.lower + d.root_lower) / c).where_or(met, none),
            upper: none.where_or(missed, up((b.upper + d.root_upper) / c)),
        }
    }

    /// Where `c < 0`: of two equal formulas, the one without cancellation.
    fn from_inside(a: N, c: N, b: Ahead<N>, d: Discriminant<N>) -> Self {
        let (zero, infinite) = (N::splat(0.0), N::splat(f64::INFINITY));
        let inner = zero - c;
        let below = d.root_lower + b.lower;
        let ahead = Self {
            lower: down(a / (d.root_upper + b.upper)),
            upper: up(a / below).where_or(below.exceeds(zero), infinite),
        };
        let back = Self {
            lower: down((d.root_lower - b.upper) / inner),
            upper: up((d.root_upper - b.lower) / inner),
        };
        back.where_or(zero.exceeds(b.value), ahead)
    }

    /// Where `c = 0`.
    fn from_the_surface(a: N, b: Ahead<N>) -> Self {
        let (zero, two) = (N::splat(0.0), N::splat(2.0));
        let (none, infinite) = (N::splat(f64::NEG_INFINITY), N::splat(f64::INFINITY));
        let met = b.lower.exceeds(zero);
        Self {
            lower: down(a / (two * b.upper)).where_or(met, none),
            upper: up(a / (two * b.lower))
                .where_or(met, none.where_or(zero.exceeds(b.upper), infinite)),
        }
    }

    fn where_or(self, mask: f64x8, other: Self) -> Self {
        Self {
            lower: self.lower.where_or(mask, other.lower),
            upper: self.upper.where_or(mask, other.upper),
        }
    }

    /// The lanes that are surely hit.
    pub(super) fn hit(&self) -> u32 {
        self.lower.exceeds(N::splat(f64::NEG_INFINITY)).to_bitmask()
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
    pub(super) fn new(
        rays: &Rays<f64x8>,
        [first, second]: [(&Targets<f64x8>, &Sights<f64x8>); 2],
    ) -> Self {
        let lengths = |targets: &Targets<f64x8>| {
            let [x, y, z] = targets.centre;
            [x, y, z, targets.radius]
        };
        let (upper, other_upper) = (first.1.upper, second.1.upper);
        let upper = upper.where_or(upper.exceeds(other_upper), other_upper);
        let (lower, other_lower) = (first.1.lower, second.1.lower);
        let lower = lower.where_or(other_lower.exceeds(lower), other_lower);
        let ([power, power_terms, along_terms], apart) = difference_at(
            lengths(first.0),
            lengths(second.0),
            [rays.x, rays.y, rays.z],
            upper,
            f64x8::abs,
        );
        let bound = units::<f64x8>(SIGHT_POWER) * power_terms * upper
            + units::<f64x8>(SIGHT_ALONG) * along_terms
            + power.abs() * (upper - lower);
        let zero = splat(0.0);
        let outside = first.0.power.exceeds(zero) & second.0.power.exceeds(zero);
        let outside = outside.to_bitmask();
        let above = apart.exceeds(bound).to_bitmask();
        let below = (-bound).exceeds(apart).to_bitmask();
        Self {
            first: above & outside | below & !outside,
            second: below & outside | above & !outside,
            apart: apart.abs(),
        }
    }
}

/// `c = C.C - r^2`, the power of the camera with respect to the sphere. Its sign is exact,
/// zero included, and its relative error is at most 7 U.
pub(super) fn power_of_camera(sphere: &Sphere) -> f64 {
    let [x, y, z] = sphere.centre.map(double);
    power([x, y, z, double(sphere.radius)]).0
}

/// [`power_of_camera`] of eight spheres, whose `yz = Cy^2 + Cz^2` and `k = yz - r^2` are given. Where
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
    sure.select(powers, power([x, y, z, r]).0)
}

/// `c` of lengths that are floats, as a double and its rounding error, which together have twice
/// the digits.
///
/// The squares are exact in doubles. Their sum is kept as an expansion of doubles that do not
/// overlap, whose largest component has the sign (J. Shewchuk,
/// Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
/// Predicates, 1997, section 2.4, Grow-Expansion).
fn power<N: Number>(lengths: [N; 4]) -> (N, N) {
    let [x, y, z, r] = lengths.map(|length| length * length);
    let zero = N::constant(0.0);
    let mut expansion = [zero; 5];
    for (length, term) in [x, y, z, -r].into_iter().enumerate() {
        grow(&mut expansion, length, term);
    }
    let sum = |expansion: [N; 5]| expansion.into_iter().fold(zero, |sum, term| sum + term);
    let power = sum(expansion);
    grow(&mut expansion, 4, -power);
    (power, sum(expansion))
}

/// Adds a term to an expansion of `length` components.
#[inline(always)]
fn grow<N: Number>(expansion: &mut [N; 5], length: usize, term: N) {
    let mut sum = term;
    for component in &mut expansion[..length] {
        (sum, *component) = sum.two_sum(*component);
    }
    expansion[length] = sum;
}
