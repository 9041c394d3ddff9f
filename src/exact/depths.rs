//! Inverse depths of eight spheres in as many rectangles of pixels, as polynomials with an
//! error bound.
//!
//! ```text
//! 1/z = B/c + sqrt(D/c^2)         A = V.V     B = C.V     c = C.C - r^2
//! D = r^2 A - N.N                 N = C x V               (Lagrange's identity)
//! ```
//!
//! for a camera outside or inside the sphere. With `p`, `q` columns and rows from the middle of
//! the rectangle,
//!
//! ```text
//! d = d00 + d10 p + d01 q + d20 p^2 + d11 p q + d02 q^2
//! b = b00 + b10 p + b01 q
//! ```
//!
//! are `D/c^2` and `B/c`. A bound is relative to the greatest value in the rectangle, so
//! the sharpest bounds are those of a rectangle that is as small as the sphere.

use wide::f64x8;

use super::{
    bounds::{
        B_BOUND, COEFFICIENT_BOUND, CROSS_BOUND, D_BOUND, DEPTH_INFLATION, OVERFLOW_LIMIT,
        PLANE_BOUND, POWER_BOUND, SUM_OF_PARTS_BOUND, SURE_SHARE, UNDERFLOW_BOUND,
    },
    grid::{EightSpheres, Grid, float_above, float_below, splat},
    kernels::{Middle, over_power},
    sight::powers_of_camera,
    tuning::Bounds,
};
use crate::spheres::LANES;

#[cfg(test)]
mod tests;

/// Eight rectangles of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rectangles {
    /// The pixels of `p = q = 0`; they may lie outside the picture.
    pub(super) columns: f64x8,
    pub(super) rows: f64x8,
    /// `|p| <= across`, `|q| <= down`.
    pub(super) across: f64x8,
    pub(super) down: f64x8,
}

/// `d` and `b` of eight spheres in doubles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Depths {
    around: Rectangles,
    /// `X` and `Y` where `p = q = 0`.
    middle: [f64x8; 2],
    /// `d00`, `d10`, `d01`, `d20`, `d11`, `d02`, and `b00`, `b10`, `b01`.
    d: [f64x8; 6],
    b: [f64x8; 3],
    /// The error bound of `d` evaluated in floats, anywhere in the rectangle.
    d_bound: f64x8,
    /// The error bound of `b + sqrt d`, without the error of `d`.
    bound: f64x8,
    /// The upper bound of `d` in the rectangle, its error included.
    d_upper: f64x8,
    /// The upper bound of `|b - b00|`.
    b_linear: f64x8,
    /// The sum of the magnitudes of the terms of `b`.
    b_terms: f64x8,
    /// Lanes whose polynomials are valid.
    known: f64x8,
    /// `c`; its sign is exact.
    power: f64x8,
}

/// [`Depths`] of one sphere.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphereDepths {
    /// Centre and radius.
    pub(super) sphere: [f64; 4],
    /// `|p| <= across`, `|q| <= down`.
    pub(super) across: f64,
    pub(super) down: f64,
    /// The column and the row of the tile, and `X` and `Y`, in which `p = q = 0`.
    pub(super) column: f64,
    pub(super) row: f64,
    pub(super) x0: f64,
    pub(super) y0: f64,
    /// `d00`, `d10`, `d01`, `d20`, `d11`, `d02`, and `b00`, `b10`, `b01`.
    pub(super) d: [f64; 6],
    pub(super) b: [f64; 3],
    /// The error bound of `d` evaluated in floats.
    pub(super) d_bound: f64,
    /// The upper bound of `d`, its error included.
    pub(super) d_upper: f64,
    /// The sum of the magnitudes of the terms of `b`.
    pub(super) b_terms: f64,
    /// Whether the polynomials are valid.
    pub(super) known: bool,
    /// `c`; its sign is exact.
    pub(super) power: f64,
}

impl SphereDepths {
    /// The upper bound of the inverse depth.
    pub(super) fn upper(&self) -> f64 {
        self.b_terms + self.d_upper.sqrt()
    }

    /// What `c` may be wrong by.
    pub(super) fn power_error(&self) -> f64 {
        let [_, y, z, _] = self.sphere;
        POWER_BOUND * (self.power.abs() + 2.0 * (y * y + z * z))
    }

    /// The lower and the upper bound of `d` in a part of the rectangle, its error included; the part
    /// is given by the middle and half of the length of its columns, and of its rows.
    pub(super) fn range_of_d(&self, [p, across]: [f64; 2], [q, down]: [f64; 2]) -> [f64; 2] {
        let [d00, d10, d01, d20, d11, d02] = self.d;
        let middle = d00 + (d10 + d20 * p + d11 * q) * p + (d01 + d02 * q) * q;
        let slopes = [d10 + 2.0 * d20 * p + d11 * q, d01 + 2.0 * d02 * q + d11 * p];
        let linear = slopes[0].abs() * across + slopes[1].abs() * down;
        let bulge = d20.abs() * across * across + (d11.abs() * across + d02.abs() * down) * down;
        let span = linear + bulge + 2.0 * self.d_bound;
        [middle - span, middle + span]
    }

    /// With `b` times `unit`, and `d` times its square.
    pub(super) fn times(&self, unit: f64) -> Self {
        let square = |d: f64| d * unit * unit;
        Self {
            d: self.d.map(square),
            b: self.b.map(|b| b * unit),
            d_bound: square(self.d_bound),
            d_upper: square(self.d_upper),
            b_terms: self.b_terms * unit,
            ..*self
        }
    }

    /// With `d` and `b` of 0.
    pub(super) fn without_depths(&self) -> Self {
        Self {
            d: [0.0; 6],
            b: [0.0; 3],
            d_bound: 0.0,
            d_upper: 0.0,
            b_terms: 0.0,
            ..*self
        }
    }
}

/// The inverse depths of eight spheres in floats: with `p`, `q` as in [`Depths`],
///
/// ```text
/// 1/z <= b + sqrt d                no hit if d < 0
/// 1/z >= b - spread + sqrt d       and a hit, if d > d_sure
/// ```
///
/// There is no lower bound for a ray that nearly touches the outline.
#[derive(Clone, Copy, Debug)]
pub(super) struct FloatDepths {
    /// Lanes whose polynomials are valid; the bounds of the others are infinite.
    pub(super) known: u32,
    /// The least `p` and `q`: `-across` and `-down`.
    pub(super) p: [f32; LANES],
    pub(super) q: [f32; LANES],
    /// `d00`, `d10`, `d01`, `d20`, `d11`, `d02`, and `b00`, `b10`, `b01`.
    pub(super) d: [[f32; LANES]; 6],
    pub(super) b: [[f32; LANES]; 3],
    pub(super) d_sure: [f32; LANES],
    pub(super) spread: [f32; LANES],
}

/// Bounds of the inverse depths of eight spheres, each in a rectangle of its own.
#[derive(Clone, Copy, Debug)]
pub(super) struct DepthRanges {
    /// Lanes whose sphere is hit in every pixel.
    pub(super) covered: u32,
    /// The lower bound of these lanes.
    pub(super) lower: [f32; LANES],
    /// The upper bound of the inverse depth of every hit; negative only if there is no hit.
    pub(super) upper: [f32; LANES],
}

impl Depths {
    /// ```text
    /// N   = N0 + p Np + q Nq      Np = dX (0, Cz, -Cy)      Nq = dY (-Cz, 0, Cx)
    /// d00 = r^2 A0 - N0.N0
    /// d10 = 2 (r^2 X0 dX - N0.Np)           d01 = 2 (r^2 Y0 dY - N0.Nq)
    /// d20 = r^2 dX^2 - Np.Np    d11 = -2 Np.Nq     d02 = r^2 dY^2 - Nq.Nq
    /// ```
    ///
    /// Let `n` be the greatest sum of the magnitudes of the components of `N` in the
    /// rectangle, `a` the greatest `A`, and `h` the sum of the error bounds of the components
    /// of `N0`. The error of the coefficients contributes at most
    /// `COEFFICIENT_BOUND (r^2 a + n^2) + (2 n + h) h` to `D` anywhere in it (theorem 3).
    #[inline(always)]
    pub(super) fn new(grid: &Grid, around: &Rectangles, spheres: &EightSpheres) -> Self {
        let &EightSpheres { x, y, z, r } = spheres;
        let middle = Middle {
            x,
            y,
            z,
            squared_radius: r * r,
            x0: grid.x_axis.x(around.columns),
            y0: grid.y_axis.y(around.rows),
        };
        let (dx, dy) = (grid.x_axis.step, -grid.y_axis.step);
        let (s, t, zero) = (around.across, around.down, splat(0.0));
        let [yz, k] = middle.k();
        let normal = middle.normal();
        let coefficients = middle.coefficients(normal, k, [dx, dy].map(splat));
        let planes = [middle.dot(), x * splat(dx), y * splat(dy)];
        let spans = [s * splat(dx.abs()), t * splat(dy.abs())];
        let d_bound = coefficients_bound(&middle, normal, spans);

        let c = powers_of_camera(spheres, yz, k);
        let [scale, squared_scale] = over_power(splat(grid.scale), c);
        let d = coefficients.map(|value| value * squared_scale);
        let b = planes.map(|value| value * scale);
        let d_bound = d_bound * squared_scale;

        let ([d00, d10, d01, d20, d11, d02], [b00, b10, b01]) = (d, b);
        let (ss, st, tt) = (s * s, s * t, t * t);
        let d_linear = s.mul_add(d10.abs(), t.mul_add(d01.abs(), st * d11.abs()));
        let d_terms = d00.abs() + ss.mul_add(d20.abs(), tt.mul_add(d02.abs(), d_linear));
        let b_linear = s.mul_add(b10.abs(), t * b01.abs());
        let b_upper = b00.abs() + b_linear;
        let b_terms = x
            .abs()
            .mul_add(middle.x0.abs(), y.abs().mul_add(middle.y0.abs(), z.abs()));
        let b_terms = b_terms.mul_add(scale.abs(), b_linear);
        // Covers the rounding errors of the bounds themselves.
        let up = splat(1.0 + DEPTH_INFLATION);
        let d_bound = splat(D_BOUND)
            .mul_add(d_terms, d_bound)
            .mul_add(up, splat(UNDERFLOW_BOUND));
        let bulge = ss.mul_add(d20.fast_max(zero), tt.mul_add(d02.fast_max(zero), d_linear));
        let highest = d00 + bulge;
        let d_upper = highest.fast_max(zero) + splat(2.0) * d_bound;
        let b_bound = splat(B_BOUND).mul_add(b_upper, splat(PLANE_BOUND) * b_terms);
        let parts = splat(SUM_OF_PARTS_BOUND).mul_add(b_upper + d_upper.sqrt(), b_bound);
        let bound = parts.mul_add(up, splat(UNDERFLOW_BOUND));

        // Where B < 0, B + sqrt D is negative, which no packet takes for a hit (theorem 4).
        let (outside, inside) = (c.simd_gt(zero), c.simd_lt(zero));
        let greatest = splat(OVERFLOW_LIMIT);
        let finite = (d_terms + d_bound).simd_lt(greatest) & (b_upper + bound).simd_lt(greatest);
        Self {
            around: *around,
            middle: [middle.x0, middle.y0],
            d,
            b,
            d_bound,
            bound,
            d_upper,
            b_linear,
            b_terms,
            known: (outside | inside) & finite,
            power: c,
        }
    }
}

/// What the coefficients of `D`, not scaled, make it wrong by anywhere in rectangles of these spans of
/// `X` and `Y`.
#[inline(always)]
fn coefficients_bound(
    middle: &Middle<f64x8>,
    normal: [f64x8; 3],
    [x_span, y_span]: [f64x8; 2],
) -> f64x8 {
    let [x, y, z] = [middle.x, middle.y, middle.z].map(f64x8::abs);
    let (x0, y0) = (middle.x0.abs(), middle.y0.abs());
    let (x_upper, y_upper) = (x0 + x_span, y0 + y_span);
    let a_upper = x_upper.mul_add(x_upper, y_upper.mul_add(y_upper, splat(1.0)));
    let [n_x, n_y, n_z] = normal.map(f64x8::abs);
    let n_upper = (y + z).mul_add(x_span, (x + z).mul_add(y_span, n_x + n_y + n_z));
    let terms = x0.mul_add(y + z, y0.mul_add(x + z, x + y));
    let h = splat(CROSS_BOUND) * terms;
    let squares = middle.squared_radius.mul_add(a_upper, n_upper * n_upper);
    let errors = n_upper.mul_add(splat(2.0), h);
    errors.mul_add(h, splat(COEFFICIENT_BOUND) * squares)
}

impl Depths {
    /// The depths of the sphere in a lane, in a tile that begins at a column and a row.
    #[inline]
    pub(super) fn of_sphere(
        &self,
        lane: usize,
        spheres: &EightSpheres,
        (column, row): (u32, u32),
        bounds: Bounds,
    ) -> SphereDepths {
        let of = |lanes: &f64x8| lanes.as_array()[lane];
        let around = &self.around;
        SphereDepths {
            sphere: [&spheres.x, &spheres.y, &spheres.z, &spheres.r].map(of),
            across: of(&around.across),
            down: of(&around.down),
            column: of(&around.columns) - f64::from(column),
            row: of(&around.rows) - f64::from(row),
            x0: of(&self.middle[0]),
            y0: of(&self.middle[1]),
            d: self.d.map(|lanes| of(&lanes)),
            b: self.b.map(|lanes| of(&lanes)),
            d_bound: of(&self.d_bound),
            d_upper: of(&self.d_upper),
            b_terms: of(&self.b_terms),
            known: of(&self.known).to_bits() != 0 && bounds != Bounds::Refused,
            power: of(&self.power),
        }
    }
}

impl Depths {
    /// With `e` the bound of `d`: since `sqrt(d - 2 e) >= sqrt d - 2 e/sqrt d` for `d >= 2 e`,
    /// and with `f` that of `b + sqrt d` (theorem 4),
    ///
    /// ```text
    /// d_sure = max(SURE_SHARE d_upper, 2 e)
    /// spread = 2 f + 2 e/sqrt(SURE_SHARE d_upper)
    /// ```
    #[inline]
    pub(super) fn to_floats(self, bounds: Bounds) -> FloatDepths {
        let zero = splat(0.0);
        let known = if bounds == Bounds::Refused {
            zero
        } else {
            self.known
        };
        let (d_bound, bound) = if bounds == Bounds::Ignored {
            (zero, zero)
        } else {
            (self.d_bound, self.bound)
        };
        let d_spread = splat(2.0) * d_bound;
        let d_sure = (splat(SURE_SHARE) * self.d_upper).fast_max(d_spread);
        let least_root = splat(SURE_SHARE.sqrt()) * self.d_upper.sqrt();
        let spread = splat(2.0) * bound + d_spread / least_root;
        let unbounded = splat(f64::INFINITY);
        let float = |value: f64| value as f32;
        let floats = |value: f64x8| known.select(value, zero).to_array().map(float);
        let above = |value: f64x8| known.select(value, unbounded).to_array().map(float_above);
        let (mut d, mut b) = (self.d, self.b);
        d[0] += d_bound;
        b[0] += bound;
        FloatDepths {
            known: known.to_bitmask(),
            p: (-self.around.across).to_array().map(float),
            q: (-self.around.down).to_array().map(float),
            d: d.map(floats),
            b: b.map(floats),
            d_sure: above(d_sure),
            spread: above(spread),
        }
    }

    /// Bounds of the inverse depths in the rectangles.
    ///
    /// If the camera is outside the sphere, the visible region is convex and `1/z` is concave in it:
    /// its least value is at a corner of the rectangle. From inside, every pixel sees the far wall.
    /// (Theorem 5.)
    pub(super) fn ranges(&self) -> DepthRanges {
        let zero = splat(0.0);
        let &Self { d, b, d_bound, .. } = self;
        let ([d00, d10, d01, d20, d11, d02], [b00, b10, b01]) = (d, b);
        let (s, t) = (self.around.across, self.around.down);
        let outside = self.power.simd_gt(zero);
        let mut corners = splat(f64::INFINITY);
        let mut covered = outside;
        for (p, q) in [(s, t), (s, -t), (-s, t), (-s, -t)] {
            let d = d00 + d10 * p + d01 * q + d20 * (p * p) + d11 * (p * q) + d02 * (q * q);
            let b = b00 + b10 * p + b01 * q;
            covered = covered & d.simd_gt(d_bound) & b.simd_gt(self.bound);
            corners = corners.fast_min(b + (d - d_bound).fast_max(zero).sqrt());
        }
        let linear = s * d10.abs() + t * d01.abs();
        let span = linear + s * s * d20.abs() + t * t * d02.abs() + s * t * d11.abs();
        let least_root = (d00 - span - d_bound).fast_max(zero).sqrt();
        let inside = b00 - self.b_linear + least_root;
        let lower = outside.select(corners, inside) - self.bound;
        let upper = b00 + self.b_linear + self.d_upper.sqrt() + self.bound;
        let upper = self.known.select(upper, splat(f64::INFINITY));
        DepthRanges {
            covered: (outside.select(covered, self.known) & self.known).to_bitmask(),
            lower: lower.to_array().map(float_below),
            upper: upper.to_array().map(float_above),
        }
    }
}
