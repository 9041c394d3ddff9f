//! The formulas whose roundings are counted, each written once: the engine evaluates them
//! in lanes, and the tests of [`bounds`](super::bounds) with a number that records them.

use std::ops::{Add, Div, Mul, Neg, Sub};

use wide::{f32x8, f64x8};

use super::bounds::{
    SIGHT_CROSS, SIGHT_DOT, SIGHT_QUOTIENT, SIGHT_SQUARED_CROSS, SIGHT_SQUARED_RADIUS,
    SURFACE_QUOTIENT,
};

/// The numbers that a formula is evaluated with. A fused operation rounds once, or twice where the
/// machine has none; no bound depends on which.
pub(super) trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// A number that the format holds.
    fn constant(value: f64) -> Self;
    /// `self a + b`
    fn times_plus(self, a: Self, b: Self) -> Self;
    /// `self a - b`
    fn times_minus(self, a: Self, b: Self) -> Self;
    /// `b - self a`
    fn times_from(self, a: Self, b: Self) -> Self;
    fn root(self) -> Self;
    fn abs(self) -> Self;
    /// The number, or zero where it is negative.
    fn positive_part(self) -> Self;

    /// `self + other` as its rounded sum and the rounding error, exactly (Knuth).
    #[inline(always)]
    fn two_sum(self, other: Self) -> (Self, Self) {
        let sum = self + other;
        let virtual_other = sum - self;
        let virtual_self = sum - virtual_other;
        (sum, (self - virtual_self) + (other - virtual_other))
    }
}

macro_rules! lanes {
    ($lanes:ty, $lane:ty) => {
        impl Number for $lanes {
            #[inline(always)]
            fn constant(value: f64) -> Self {
                Self::splat(value as $lane)
            }

            #[inline(always)]
            fn times_plus(self, a: Self, b: Self) -> Self {
                self.mul_add(a, b)
            }

            #[inline(always)]
            fn times_minus(self, a: Self, b: Self) -> Self {
                self.mul_sub(a, b)
            }

            #[inline(always)]
            fn times_from(self, a: Self, b: Self) -> Self {
                self.mul_neg_add(a, b)
            }

            #[inline(always)]
            fn root(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn positive_part(self) -> Self {
                self.fast_max(Self::ZERO)
            }
        }
    };
}

lanes!(f64x8, f64);
lanes!(f32x8, f32);

impl Number for f64 {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn times_plus(self, a: Self, b: Self) -> Self {
        self * a + b
    }

    #[inline(always)]
    fn times_minus(self, a: Self, b: Self) -> Self {
        self * a - b
    }

    #[inline(always)]
    fn times_from(self, a: Self, b: Self) -> Self {
        b - self * a
    }

    #[inline(always)]
    fn root(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn abs(self) -> Self {
        self.abs()
    }

    #[inline(always)]
    fn positive_part(self) -> Self {
        self.max(0.0)
    }
}

/// `(d2 x + d1) x + d0`
#[inline(always)]
pub(super) fn quadratic<N: Number>([d0, d1, d2]: [N; 3], x: N) -> N {
    d2.times_plus(x, d1).times_plus(x, d0)
}

/// Terms of `d` and of `b` in a column `p` from the middle: `d0`, `d1`, `d2` and `b0`, `b1`.
#[inline(always)]
pub(super) fn in_column<N: Number>(
    [d00, d10, d01, d20, d11, d02]: [N; 6],
    [b00, b10, b01]: [N; 3],
    p: N,
) -> ([N; 3], [N; 2]) {
    (
        [quadratic([d00, d10, d20], p), d11.times_plus(p, d01), d02],
        [b10.times_plus(p, b00), b01],
    )
}

/// `d` and `b` in a row `q` from the middle.
#[inline(always)]
pub(super) fn in_row<N: Number>(d: [N; 3], [b0, b1]: [N; 2], q: N) -> [N; 2] {
    [quadratic(d, q), b1.times_plus(q, b0)]
}

/// `A = V.V` of the ray `V = (X, Y, 1)`
#[inline(always)]
pub(super) fn squared_ray<N: Number>([x, y]: [N; 2]) -> N {
    x.times_plus(x, y.times_plus(y, N::constant(1.0)))
}

/// `B = C.V` of the ray `V = (X, Y, 1)`
#[inline(always)]
pub(super) fn dot<N: Number>([x, y, z]: [N; 3], [ray_x, ray_y]: [N; 2]) -> N {
    x.times_plus(ray_x, y.times_plus(ray_y, z))
}

/// Bounds of the inverse depth of a sphere on whose surface the camera is, in floats: `A g/(2 B)`, with
/// `b = B/r`, which is above its `bound`, and `half = g/(2 r)`.
#[inline(always)]
pub(super) fn on_the_surface<N: Number>(a: N, b: N, bound: N, half: N) -> [N; 2] {
    let (below, above) = (1.0 - SURFACE_QUOTIENT, 1.0 + SURFACE_QUOTIENT);
    [
        a * half / (b + bound) * N::constant(below),
        a * half / (b - bound) * N::constant(above),
    ]
}

/// A sphere `(x, y, z)`, `r`, and the ray through the middle of a rectangle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Middle<N> {
    pub(super) x: N,
    pub(super) y: N,
    pub(super) z: N,
    pub(super) squared_radius: N,
    pub(super) x0: N,
    pub(super) y0: N,
}

impl<N: Number> Middle<N> {
    /// `Cy^2 + Cz^2`, and `k`, which is `r^2` less.
    #[inline(always)]
    pub(super) fn k(&self) -> [N; 2] {
        let yz = self.y.times_plus(self.y, self.z * self.z);
        [yz, yz - self.squared_radius]
    }

    /// `N0 = C x V0`
    #[inline(always)]
    pub(super) fn normal(&self) -> [N; 3] {
        let &Self {
            x, y, z, x0, y0, ..
        } = self;
        [
            z.times_from(y0, y),
            z.times_minus(x0, x),
            x.times_minus(y0, y * x0),
        ]
    }

    /// `d00`, `d10`, `d01`, `d20`, `d11`, `d02` of [`Depths::new`](super::depths::Depths),
    /// but for their scale; `dx` and `dy` are the steps from pixel to pixel.
    #[inline(always)]
    pub(super) fn coefficients(&self, [n_x, n_y, n_z]: [N; 3], k: N, [dx, dy]: [N; 2]) -> [N; 6] {
        let &Self {
            x,
            y,
            z,
            squared_radius,
            x0,
            y0,
        } = self;
        let xz = x.times_plus(x, z * z);
        let a0 = squared_ray([x0, y0]);
        let nn = n_x.times_plus(n_x, n_y.times_plus(n_y, n_z * n_z));
        let twice = N::constant(2.0);
        [
            squared_radius.times_minus(a0, nn),
            n_z.times_plus(y, n_y.times_from(z, squared_radius * x0)) * (twice * dx),
            n_x.times_plus(z, n_z.times_from(x, squared_radius * y0)) * (twice * dy),
            k * -(dx * dx),
            x * y * (twice * dx * dy),
            (squared_radius - xz) * (dy * dy),
        ]
    }

    /// `B0 = C.V0`
    #[inline(always)]
    pub(super) fn dot(&self) -> N {
        dot([self.x, self.y, self.z], [self.x0, self.y0])
    }
}

/// The terms of `c' - c` of two spheres, and their sum.
#[inline(always)]
pub(super) fn power_difference<N: Number>(sphere: [N; 4], other: [N; 4]) -> ([N; 4], N) {
    let square = |at: usize| (other[at] - sphere[at]) * (other[at] + sphere[at]);
    let [x, y, z, r] = [square(0), square(1), square(2), -square(3)];
    ([x, y, z, r], x + y + z + r)
}

/// `f = (c' - c) s - 2 (C' - C).V` of two spheres and an inverse depth `s`, in units of `V`. Before it
/// `c' - c`, the sum of the magnitudes of its terms, and that of the other product.
#[inline(always)]
pub(super) fn difference_at<N: Number>(
    sphere: [N; 4],
    other: [N; 4],
    v: [N; 3],
    s: N,
) -> ([N; 3], N) {
    let ([x, y, z, r], power) = power_difference(sphere, other);
    let power_terms = x.abs() + y.abs() + z.abs() + r.abs();
    let along = |axis: usize| (other[axis] - sphere[axis]) * v[axis];
    let [x, y, z] = [along(0), along(1), along(2)];
    let two = N::constant(2.0);
    let along_terms = (x.abs() + y.abs() + z.abs()) * two;
    (
        [power, power_terms, along_terms],
        power * s - (x + y + z) * two,
    )
}

/// `l` around the middle of a rectangle: `scale (other - tested).V - b`.
#[inline(always)]
pub(super) fn radical_plane<N: Number>(
    tested: [N; 4],
    other: [N; 4],
    scale: N,
    [x0, y0, dx, dy]: [N; 4],
    [b00, b10, b01]: [N; 3],
) -> [N; 3] {
    let along = |axis: usize| (other[axis] - tested[axis]) * scale;
    let [x, y, z] = [along(0), along(1), along(2)];
    [
        x.times_plus(x0, y.times_plus(y0, z)) - b00,
        x.times_minus(dx, b10),
        y.times_minus(dy, b01),
    ]
}

/// The scale of inverse depths over `c`, and its square.
#[inline(always)]
pub(super) fn over_power<N: Number>(scale: N, c: N) -> [N; 2] {
    let scale = scale / c;
    [scale, scale * scale]
}

/// A sphere `(.., y, z)`, `r`, and the row of `q = 0`.
#[derive(Clone, Copy, Debug)]
pub(super) struct MiddleRow<N> {
    pub(super) y: N,
    pub(super) z: N,
    pub(super) r: N,
    pub(super) y0: N,
    /// The step from row to row.
    pub(super) dy: N,
}

impl<N: Number> MiddleRow<N> {
    /// `N0` and `N1`
    #[inline(always)]
    pub(super) fn normal(&self) -> [N; 2] {
        [self.y - self.z * self.y0, self.z * self.dy]
    }

    /// `e0`, `e1` and `e2` of [`outline`](super::outline), `factor` being
    /// `c h h`.
    #[inline(always)]
    pub(super) fn coefficients(&self, [n0, n1]: [N; 2], factor: N) -> [N; 3] {
        let &Self { z, r, y0, dy, .. } = self;
        let squared_radius = r * r;
        let a0 = y0.times_plus(y0, N::constant(1.0));
        [
            factor * (squared_radius * a0 - n0 * n0),
            -(factor * N::constant(2.0)) * (n0 * n1 + squared_radius * (y0 * dy)),
            factor * (dy * dy) * ((r - z) * (r + z)),
        ]
    }

    /// `rising` and `level`: `m = rising q + level`.
    #[inline(always)]
    pub(super) fn ahead(&self) -> [N; 2] {
        [-(self.y * self.dy), self.y.times_plus(self.y0, self.z)]
    }
}

/// `h = scale/k`, and `c h h`, in an order in which no intermediate product underflows.
#[inline(always)]
pub(super) fn row_factor<N: Number>(scale: N, c: N, k: N) -> [N; 2] {
    let h = scale / k;
    [h, c * h * h]
}

/// `m0` and `m1` of [`outline`](super::outline), with `hx = h Cx`.
#[inline(always)]
pub(super) fn row_middle<N: Number>(middle: N, hx: N, [rising, level]: [N; 2]) -> [N; 2] {
    [middle + hx * level, hx * rising]
}

/// `q = (Cz - r)(Cz + r)`, its factors and its inverse.
#[inline(always)]
pub(super) fn before<N: Number>(z: N, r: N) -> [N; 4] {
    let (near, far) = (z - r, z + r);
    let q = near * far;
    [near, far, q, N::constant(1.0) / q]
}

/// Where planes through an axis touch a sphere in front of the camera, in pixels from the middle;
/// `scale` is pixels per unit over `q`.
#[inline(always)]
pub(super) fn touching<N: Number>(centre: N, [z, r, q]: [N; 3], scale: N) -> [N; 2] {
    let product = centre * z;
    let root = r * (centre * centre + q).root();
    [(product - root) * scale, (product + root) * scale]
}

/// The slope of the plane that touches a sphere beside the camera, with `x = |Cx|` and `w` the
/// power of the camera in the plane `y = 0`: of `Cz >= 0`, and of `Cz < 0`.
#[inline(always)]
pub(super) fn touching_beside<N: Number>([x, z, r]: [N; 3], w: N) -> [N; 2] {
    let root = r * w.root();
    [
        (x - r) * (x + r) / (x * z + root),
        (x * z - root) / ((z - r) * (z + r)),
    ]
}

/// No hit of a sphere before the camera is farther: the inverse depth of the farthest point
/// that is seen, `|C|^2/(sqrt c (sqrt c Cz + r |(Cx, Cy)|))`.
#[inline(always)]
pub(super) fn farthest<N: Number>([x, y, z, r]: [N; 4], yz: N, c: N) -> N {
    let across = (x * x + y * y).root();
    let c_root = c.root();
    (x * x + yz) / (c_root * (c_root * z + r * across))
}

/// No hit of a sphere beside the camera is nearer: the surface is at least
/// `||C| - r| = |c|/(|C| + r)` away, and a ray reaches `z = 1` within `reach`.
#[inline(always)]
pub(super) fn nearest_beside<N: Number>(reach: N, [x, y, z, r]: [N; 4], c: N) -> N {
    reach * ((x * x + y * y + z * z).root() + r) / c
}

/// `x` or `y` of a ray that is not moved to distance 1.
#[inline(always)]
pub(super) fn component<N: Number>(extent: N, numerator: N, denominator: N) -> N {
    extent * numerator / denominator
}

/// `A = V.V`
#[inline(always)]
pub(super) fn squared_length<N: Number>([x, y, z]: [N; 3]) -> N {
    x * x + y * y + z * z
}

/// `B`, and its bounds.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ahead<N> {
    pub(super) value: N,
    pub(super) lower: N,
    pub(super) upper: N,
}

impl<N: Number> Ahead<N> {
    #[inline(always)]
    fn new([cx, cy, cz]: [N; 3], [x, y, z]: [N; 3]) -> Self {
        let [x, y, z] = [cx * x, cy * y, cz * z];
        let value = x + y + z;
        let bound = N::constant(SIGHT_DOT) * (x.abs() + y.abs() + z.abs());
        Self {
            value,
            lower: value - bound,
            upper: value + bound,
        }
    }
}

/// `D`, and its bound.
#[derive(Clone, Copy, Debug)]
pub(super) struct Discriminant<N> {
    pub(super) value: N,
    pub(super) bound: N,
}

impl<N: Number> Discriminant<N> {
    #[inline(always)]
    fn new([cx, cy, cz, r]: [N; 4], [x, y, z]: [N; 3], a: N) -> Self {
        let two = N::constant(2.0);
        let (mut squared_cross, mut cross_bound) = (N::constant(0.0), N::constant(0.0));
        for (p, q) in [(cy * z, cz * y), (cz * x, cx * z), (cx * y, cy * x)] {
            let n = p - q;
            let bound = N::constant(SIGHT_CROSS) * (p.abs() + q.abs());
            squared_cross = squared_cross + n * n;
            cross_bound = cross_bound + (two * n.abs() + bound) * bound;
        }
        let squared_radius = r * r * a;
        Self {
            value: squared_radius - squared_cross,
            bound: N::constant(SIGHT_SQUARED_RADIUS) * squared_radius
                + N::constant(SIGHT_SQUARED_CROSS) * squared_cross
                + cross_bound,
        }
    }
}

/// What a ray has to do with a sphere, with bounds of what is rounded; and from these the bounds of
/// its inverse depth, in units of `V` (theorem 6).
#[derive(Clone, Copy, Debug)]
pub(super) struct Sight<N> {
    pub(super) b: Ahead<N>,
    pub(super) d: Discriminant<N>,
    /// The bounds of the root of `D`.
    pub(super) root_lower: N,
    pub(super) root_upper: N,
}

impl<N: Number> Sight<N> {
    #[inline(always)]
    pub(super) fn new([x, y, z, r]: [N; 4], v: [N; 3], a: N) -> Self {
        let d = Discriminant::new([x, y, z, r], v, a);
        Self {
            b: Ahead::new([x, y, z], v),
            d,
            root_lower: (d.value - d.bound).positive_part().root(),
            root_upper: (d.value + d.bound).positive_part().root(),
        }
    }

    /// `(B + sqrt D)/c`
    #[inline(always)]
    pub(super) fn seen_from_outside(&self, c: N) -> [N; 2] {
        let lower = (self.b.lower + self.root_lower) / c;
        outward([lower, (self.b.upper + self.root_upper) / c])
    }

    /// `A/(sqrt D + B)`; no upper bound where the sum may not be above 0.
    #[inline(always)]
    pub(super) fn seen_ahead_from_inside(&self, a: N) -> [N; 2] {
        let lower = a / (self.root_upper + self.b.upper);
        outward([lower, a / (self.root_lower + self.b.lower)])
    }

    /// `(sqrt D - B)/-c`
    #[inline(always)]
    pub(super) fn seen_back_from_inside(&self, c: N) -> [N; 2] {
        let lower = (self.root_lower - self.b.upper) / -c;
        outward([lower, (self.root_upper - self.b.lower) / -c])
    }

    /// `A/2B`
    #[inline(always)]
    pub(super) fn seen_from_the_surface(&self, a: N) -> [N; 2] {
        let two = N::constant(2.0);
        outward([a / (two * self.b.upper), a / (two * self.b.lower)])
    }
}

/// Bounds of an inverse depth, moved outward by the roundings of their last operations.
#[inline(always)]
fn outward<N: Number>([lower, upper]: [N; 2]) -> [N; 2] {
    let constant = N::constant;
    [
        lower * constant(1.0 - SIGHT_QUOTIENT),
        upper * constant(1.0 + SIGHT_QUOTIENT),
    ]
}
