//! Spheres as conics on the viewport, eight at a time, every number with a bound.
//!
//! The viewport is moved to distance 1, so a ray is `V = (X, Y, 1)` and the
//! inverse depth of a hit is `1/z`, whatever the viewport's distance. With `C`,
//! `r` of a sphere:
//!
//! ```text
//! A = V.V     B = C.V     N = C x V     c = C.C - r^2
//! D = B^2 - A c = r^2 A - N.N                          (Lagrange's identity)
//! 1/z = B/c + sqrt(D/c^2)                              (camera outside or inside)
//! ```
//!
//! Three things are made of a sphere, each when it is first needed:
//!
//! - [`Extents`]: the box of pixels it can touch, and its greatest inverse depth;
//! - [`Outline`]: where each row enters and leaves it, to a small part of a pixel;
//! - [`Local`]: `D/c^2` and `B/c` as polynomials around its box in a tile, in floats.
//!
//! Bounds are in units of the unit roundoff, first order, rounded up by what
//! covers the products of roundings; the method is that of N. Higham, Accuracy
//! and Stability of Numerical Algorithms, 2nd ed., 2002, ch. 3. Inputs are
//! floats, so their sums of squares neither overflow nor vanish in doubles.

#[cfg(test)]
mod tests;

use wide::f64x8;

use super::{
    Bounds,
    decide::{U, power_of_camera},
    set_bits,
};
use crate::{
    camera::Camera,
    spheres::{LANES, Sphere},
};

/// Unit roundoff of floats.
const U32: f64 = f32::EPSILON as f64 / 2.0;

/// The pixel grid on the viewport at distance 1.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    camera: Camera,
    /// Pixels per unit of `X`, 2 roundings.
    x_scale: f64,
    y_scale: f64,
    /// The column of `X = 0`, exact.
    x_middle: f64,
    y_middle: f64,
    /// Units of `X` per pixel, 2 roundings.
    x_step: f64,
    y_step: f64,
    /// `|Y| <= y_most` in the picture.
    y_most: f64,
    /// `|V| <= reach` in the picture.
    reach: f64,
}

/// An image of one column shows `X = 0`: any scale will do.
fn scale_and_step(side: u32, extent: f64) -> (f64, f64) {
    let last = f64::from(side - 1);
    if last == 0.0 {
        (1.0 / extent, 0.0)
    } else {
        (last / extent, extent / last)
    }
}

impl Grid {
    pub(super) fn new(camera: Camera) -> Self {
        const UP: f64 = 1.0 + 8.0 * U;
        let (width, height) = (camera.size().width(), camera.size().height());
        let (x_scale, x_step) = scale_and_step(width, camera.x_extent());
        let (y_scale, y_step) = scale_and_step(height, camera.y_extent());
        let x_most = 0.5 * camera.x_extent() * UP;
        let y_most = 0.5 * camera.y_extent() * UP;
        Self {
            camera,
            x_scale,
            y_scale,
            x_middle: 0.5 * f64::from(width - 1),
            y_middle: 0.5 * f64::from(height - 1),
            x_step,
            y_step,
            y_most,
            reach: (x_most * x_most + y_most * y_most + 1.0).sqrt() * UP,
        }
    }

    pub(super) fn camera(&self) -> &Camera {
        &self.camera
    }

    /// `X` of columns and `Y` of rows, within 3 roundings.
    fn slopes(&self, columns: f64x8, rows: f64x8) -> (f64x8, f64x8) {
        (
            (columns - splat(self.x_middle)) * splat(self.x_step),
            (splat(self.y_middle) - rows) * splat(self.y_step),
        )
    }

    /// `Y` and `Y^2 + 1` of a row, which may lie outside the picture, within 3 and 8 roundings.
    pub(super) fn row(&self, row: i64) -> (f64, f64) {
        let y = (self.y_middle - row as f64) * self.y_step;
        (y, y * y + 1.0)
    }
}

/// Eight spheres in doubles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lanes {
    x: f64x8,
    y: f64x8,
    z: f64x8,
    r: f64x8,
}

impl Lanes {
    pub(super) fn new(x: [f32; LANES], y: [f32; LANES], z: [f32; LANES], r: [f32; LANES]) -> Self {
        let doubles = |floats: [f32; LANES]| f64x8::new(floats.map(f64::from));
        Self {
            x: doubles(x),
            y: doubles(y),
            z: doubles(z),
            r: doubles(r),
        }
    }

    /// Up to eight spheres; the last one fills the rest.
    pub(super) fn of(spheres: impl Iterator<Item = [f32; 4]>) -> Self {
        let [mut x, mut y, mut z, mut r] = [[0.0; LANES]; 4];
        let mut last = [0.0, 0.0, 1.0, 0.5];
        let mut spheres = spheres.fuse();
        for lane in 0..LANES {
            last = spheres.next().unwrap_or(last);
            [x[lane], y[lane], z[lane], r[lane]] = last;
        }
        Self::new(x, y, z, r)
    }

    fn sphere(&self, lane: usize) -> Sphere {
        let float = |lanes: &f64x8| lanes.as_array()[lane] as f32;
        Sphere {
            centre: [float(&self.x), float(&self.y), float(&self.z)],
            radius: float(&self.r),
            colour: [0; 3],
        }
    }
}

fn splat(value: f64) -> f64x8 {
    f64x8::splat(value)
}

/// Whole numbers from 0 to `2^32 - 1`: added to `2^52`, they are the low bits.
fn whole(lanes: f64x8) -> [u32; LANES] {
    let bits: [u64; LANES] = bytemuck::cast(lanes + splat(f64::from_bits(0x433 << 52)));
    bits.map(|bits| bits as u32)
}

/// A float above `value`, which is `>= 0` and of any magnitude: conversion rounds
/// by `2^-24` of it, or by `2^-150`. What is negative stays so.
#[inline]
fn float_above(value: f64) -> f32 {
    const SMALLEST: f64 = f32::from_bits(1) as f64;
    (value * (1.0 + 3.0 * U32) + SMALLEST) as f32
}

/// As [`float_above`], below, and not below 0.
pub(super) fn float_below(value: f64) -> f32 {
    const SMALLEST: f64 = f32::from_bits(1) as f64;
    ((value * (1.0 - 3.0 * U32) - SMALLEST) as f32).max(0.0)
}

/// Where eight spheres can be seen at all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extents {
    /// Which lanes can show in the picture.
    pub(super) visible: u32,
    /// First and last column and row, within the picture.
    pub(super) left: [u32; LANES],
    pub(super) right: [u32; LANES],
    pub(super) top: [u32; LANES],
    pub(super) bottom: [u32; LANES],
    /// No hit has a greater inverse depth.
    pub(super) most: [f32; LANES],
}

/// The ends of a box carry at most `30 U` of the greater of them and `4 U` of the
/// picture's side: products of sums of positive terms, none of more than 12
/// roundings. A pixel more or less costs next to nothing, so this is rounder.
const BOX_BOUND: f64 = 256.0 * U;

impl Extents {
    /// ```text
    /// X = (Cx Cz -+ r sqrt(Cx^2 + q))/q     q = (Cz - r)(Cz + r) > 0
    /// ```
    ///
    /// are the planes through the y axis that touch the sphere; `Y` likewise. No
    /// point of it is nearer than `z = Cz - r`. Where `Cz <= r` the outline is no
    /// ellipse and may be anywhere.
    #[inline]
    pub(super) fn new(grid: &Grid, spheres: &Lanes) -> Self {
        let &Lanes { x, y, z, r } = spheres;
        let size = grid.camera.size();
        let depth = z - r;
        let before = depth.simd_gt(splat(0.0));
        let behind = (z + r).simd_le(splat(0.0));
        let q = depth * (z + r);
        let inverse = splat(1.0) / q;

        let ends = |centre: f64x8, scale: f64, middle: f64, side: u32| {
            let product = centre * z;
            let root = r * (centre * centre + q).sqrt();
            let scale = splat(scale) * inverse;
            let (low, high) = ((product - root) * scale, (product + root) * scale);
            let slack =
                splat(BOX_BOUND) * (low.abs().fast_max(high.abs()) + splat(f64::from(side)));
            (splat(middle), low - slack, high + slack)
        };
        let (middle, low, high) = ends(x, grid.x_scale, grid.x_middle, size.width());
        let (left, right) = ((middle + low).ceil(), (middle + high).floor());
        let (middle, low, high) = ends(y, grid.y_scale, grid.y_middle, size.height());
        let (top, bottom) = ((middle - high).ceil(), (middle - low).floor());

        let last_column = splat(f64::from(size.width() - 1));
        let last_row = splat(f64::from(size.height() - 1));
        let zero = splat(0.0);
        let met = left.simd_le(right)
            & top.simd_le(bottom)
            & right.simd_ge(zero)
            & left.simd_le(last_column)
            & bottom.simd_ge(zero)
            & top.simd_le(last_row);
        let clamped = |end: f64x8, last: f64x8, beside: f64x8| {
            let within = end.fast_max(zero).fast_min(last);
            whole(before.select(within, beside))
        };
        let visible = (before & met).to_bitmask() | (!(before | behind)).to_bitmask();
        let mut most = ((z + r) * inverse).to_array().map(float_above);
        for lane in set_bits(u64::from(!before.to_bitmask() & visible)) {
            most[lane] = most_beside(grid, &spheres.sphere(lane));
        }
        Self {
            visible,
            left: clamped(left, last_column, zero),
            right: clamped(right, last_column, last_column),
            top: clamped(top, last_row, zero),
            bottom: clamped(bottom, last_row, last_row),
            most,
        }
    }
}

/// The surface is at least `||C| - r| = |c|/(|C| + r)` away, and a ray reaches
/// `z = 1` within [`Grid::reach`].
fn most_beside(grid: &Grid, sphere: &Sphere) -> f32 {
    let [x, y, z] = sphere.centre.map(f64::from);
    let sum = (x * x + y * y + z * z).sqrt() + f64::from(sphere.radius);
    float_above(grid.reach * sum / power_of_camera(sphere).abs() * (1.0 + 32.0 * U))
}

/// How a sphere meets the rows of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    /// In each row between two ends, which [`Outline::ends`] gives.
    Convex,
    /// The camera is inside: in every pixel.
    Everywhere,
    /// Too close a call for doubles: anywhere in its box.
    Unknown,
}

/// The silhouette of a sphere, row by row.
///
/// In a row, `D` is a quadratic of `X` with the roots
///
/// ```text
/// X = (Cx m -+ sqrt(c E))/k       k = Cy^2 + Cz^2 - r^2     c = Cx^2 + k
/// m = Cy Y + Cz       E = r^2 (Y^2 + 1) - N^2       N = Cy - Cz Y
/// ```
///
/// For `k > 0` the camera is outside, `D >= 0` between them, and `B` has the sign
/// of `m` there: between them the sphere is seen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outline {
    pub(super) shape: Shape,
    /// No hit has a smaller inverse depth.
    pub(super) least: f32,
    y: f64,
    z: f64,
    squared_radius: f64,
    middle: f64,
    /// `Cx/k` and `sqrt(c)/k` in pixels.
    lean: f64,
    half: f64,
    /// The ends are within this many pixels.
    slack: f64,
    /// Rows with a smaller `m` are not sure to be before the camera.
    front: f64,
}

/// Below this share of `Cy^2 + Cz^2`, too little is left of `k`.
const LEAST_SHARE: f64 = 1.0 / (1 << 20) as f64;

/// Where ends are worse than this, in pixels, packets are better.
const GREATEST_SLACK: f64 = 1.0 / 16.0;

/// `N`: 3 of `Y`, 1 of the product, 1 of the difference; `m` likewise.
const ROW_BOUND: f64 = 5.0 * U;

/// Parts of the bound of an end, see [`Outline::eight`].
const LEAN_BOUND: f64 = 12.0 * U;
const HALF_BOUND: f64 = 12.0 * U;
const SUM_BOUND: f64 = 4.0 * U;

impl Outline {
    /// The outlines of eight spheres.
    ///
    /// With `M = |Cy| y_most + |Cz|`, `G = sqrt(y_most^2 + 1)` and `n`, the bound of
    /// `N`, an end is wrong by no more than
    ///
    /// ```text
    /// lean m:  5 of m, 3 of the scale over k, 1 of Cx, 1 of the product      LEAN_BOUND |lean| M
    /// half:    3 of the scale over k, 2 of sqrt c, 1, 1 of the root, 1       HALF_BOUND half r G
    /// E:       10 of r^2 (Y^2 + 1), 3 of N^2, and (2 |N| + n) n, where |N| <= r G + n
    ///          (beyond that E < 0, and it is computed as no more than 12 U r^2 G^2)
    ///                               so e = 16 U r^2 G^2 + 4 r G n + 20 n^2   half sqrt e
    /// sums:    2 of all terms                                                SUM_BOUND
    /// ```
    ///
    /// and of `k`, which is wrong by `U (Cy^2 + Cz^2)/k + 2 U` of itself, once in
    /// `lean` and at most 1.5 times in `half`.
    #[inline]
    pub(super) fn eight(grid: &Grid, spheres: &Lanes, bounds: Bounds) -> [Self; LANES] {
        let &Lanes { x, y, z, r } = spheres;
        let yz = y * y + z * z;
        let squared_radius = r * r;
        let k = yz - squared_radius;
        let sure = k.simd_gt(splat(LEAST_SHARE) * yz);
        let k_bound = splat(2.0 * U) + splat(U) * yz / k;
        let c_root = (x * x + k).sqrt();
        let scale = splat(grid.x_scale) / k;
        let (lean, half) = (x * scale, c_root * scale);

        let y_most = splat(grid.y_most);
        let m_most = y.abs() * y_most + z.abs();
        let n_bound = splat(ROW_BOUND) * (y.abs() + z.abs() * y_most);
        let root_most = r * splat((grid.y_most * grid.y_most + 1.0).sqrt());
        let e = splat(16.0 * U) * root_most * root_most
            + splat(4.0) * root_most * n_bound
            + splat(20.0) * n_bound * n_bound;
        let (lean_most, half_most) = (lean.abs() * m_most, half * root_most);
        let slack = half * e.sqrt()
            + (k_bound + splat(LEAN_BOUND)) * lean_most
            + (splat(1.5) * k_bound + splat(HALF_BOUND)) * half_most
            + splat(SUM_BOUND) * (splat(grid.x_middle) + lean_most + half_most);
        // A share of 2^-20 more for the roundings of the bound itself.
        let slack = slack * splat(1.0 + LEAST_SHARE);

        // The farthest point of the surface that is seen lies on the circle where
        // rays touch: z = sqrt c (sqrt c Cz + r |(Cx, Cy)|)/|C|^2. Sums of positive
        // terms if Cz > 0; k's bound is below 2^-32.
        let across = (x * x + y * y).sqrt();
        let least = (x * x + yz) / (c_root * (c_root * z + r * across));
        let least = z.simd_gt(r).select(least, splat(0.0));
        let front = z.simd_gt(r).select(splat(0.0), splat(ROW_BOUND) * m_most);

        let sure = sure.to_bitmask();
        let [slack, lean, half, least, front, squared_radius] =
            [slack, lean, half, least, front, squared_radius].map(f64x8::to_array);
        let (y, z) = (y.to_array(), z.to_array());
        std::array::from_fn(|lane| {
            let shape = if bounds == Bounds::Refused {
                Shape::Unknown
            } else if sure >> lane & 1 == 0 {
                if power_of_camera(&spheres.sphere(lane)) < 0.0 {
                    Shape::Everywhere
                } else {
                    Shape::Unknown
                }
            } else if slack[lane] < GREATEST_SLACK {
                Shape::Convex
            } else {
                Shape::Unknown
            };
            Self {
                shape,
                least: if shape == Shape::Convex {
                    float_below(least[lane] * (1.0 - U32))
                } else {
                    0.0
                },
                y: y[lane],
                z: z[lane],
                squared_radius: squared_radius[lane],
                middle: grid.x_middle,
                lean: lean[lane],
                half: half[lane],
                slack: if bounds == Bounds::Ignored {
                    0.0
                } else {
                    slack[lane]
                },
                front: front[lane],
            }
        })
    }

    /// Where eight rows enter and leave the outline, within `slack`, and their `m`.
    #[inline]
    fn sides(&self, y: f64x8, squared: f64x8) -> (f64x8, f64x8, f64x8) {
        let n = splat(self.y) - splat(self.z) * y;
        let m = splat(self.y) * y + splat(self.z);
        let e = splat(self.squared_radius) * squared - n * n;
        let half = splat(self.half) * e.fast_max(splat(0.0)).sqrt();
        let middle = splat(self.middle) + splat(self.lean) * m;
        (middle - half, middle + half, m)
    }

    /// The columns of `first..last` in which eight rows see the sphere, of rows with
    /// these `Y` and `Y^2 + 1`.
    #[inline]
    pub(super) fn ends(&self, y: f64x8, squared: f64x8, first: u32, last: u32) -> Ends {
        let (left, right, m) = self.sides(y, squared);
        let slack = splat(self.slack);
        let one = splat(1.0);
        let clamped = |end: f64x8| {
            whole(
                end.fast_max(splat(f64::from(first)))
                    .fast_min(splat(f64::from(last))),
            )
        };
        let mut ends = Ends {
            start: clamped((left + slack).ceil()),
            end: clamped((right - slack).floor() + one),
            outer_start: clamped((left - slack).ceil()),
            outer_end: clamped((right + slack).floor() + one),
        };
        if self.front > 0.0 {
            let front = splat(self.front);
            let sure = m.simd_gt(front).to_bitmask();
            let possible = m.simd_ge(-front).to_bitmask();
            for lane in 0..LANES {
                if sure >> lane & 1 == 0 {
                    (ends.start[lane], ends.end[lane]) = (last, last);
                }
                if possible >> lane & 1 == 0 {
                    (ends.outer_start[lane], ends.outer_end[lane]) = (last, last);
                }
            }
        }
        ends
    }
}

/// Columns of eight rows: seen in `start..end`, and nowhere beyond
/// `outer_start..outer_end`; in what lies between, an integer has to say.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    pub(super) start: [u32; LANES],
    pub(super) end: [u32; LANES],
    pub(super) outer_start: [u32; LANES],
    pub(super) outer_end: [u32; LANES],
}

impl Ends {
    /// Whether every column is settled.
    #[inline]
    pub(super) fn settled(&self) -> bool {
        // Empty rows may differ in where they are empty.
        self.start == self.outer_start && self.end == self.outer_end
    }
}

/// Eight rectangles of pixels, and the depths of the scene: what [`Local`] is relative to.
pub(super) struct Around {
    /// The pixels of `p = q = 0`; they may lie outside the picture.
    pub(super) columns: f64x8,
    pub(super) rows: f64x8,
    /// `|p| <= across`, `|q| <= down`.
    pub(super) across: f64x8,
    pub(super) down: f64x8,
    /// A power of two: inverse depths times this are about 1 where they are greatest.
    pub(super) scale: f64,
}

/// Depths of eight spheres around as many pixels, in floats: with `p`, `q` columns and
/// rows from there and `1/z` scaled by [`Around::scale`],
///
/// ```text
/// d = d00 + d10 p + d01 q + d20 p^2 + d11 p q + d02 q^2
/// b = b00 + b10 p + b01 q
///
/// 1/z <= b + sqrt d                               no hit if d < 0
/// 1/z >= b - spread + sqrt(d - d_spread)          a hit if d > d_spread
/// 1/z >= b - clear_spread + sqrt d                and a hit, if d > clear
/// ```
///
/// The last form has one root where the others have two. Where an outline is grazed
/// it says nothing, and it is the wider the larger the sphere is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Local {
    /// The `p` and `q` that are least: `-across` and `-down`.
    pub(super) p: [f32; LANES],
    pub(super) q: [f32; LANES],
    pub(super) d00: [f32; LANES],
    pub(super) d10: [f32; LANES],
    pub(super) d01: [f32; LANES],
    pub(super) d20: [f32; LANES],
    pub(super) d11: [f32; LANES],
    pub(super) d02: [f32; LANES],
    pub(super) d_spread: [f32; LANES],
    pub(super) b00: [f32; LANES],
    pub(super) b10: [f32; LANES],
    pub(super) b01: [f32; LANES],
    pub(super) spread: [f32; LANES],
    pub(super) clear: [f32; LANES],
    pub(super) clear_spread: [f32; LANES],
    /// No hit within the rectangle is nearer; negative if there is none.
    pub(super) most: [f32; LANES],
    /// Every pixel of the rectangle is hit, none farther than this; negative if not so.
    pub(super) least: [f32; LANES],
}

/// `N`: 3 of a coordinate, 1 of the product, 1 of the difference.
const CROSS_BOUND: f64 = 5.0 * U;

/// Coefficients of `D`, of all their terms: 8 of `X^2`, 2 of a step twice over, 1
/// or 2 of products and sums; and the same of `N.N` from the computed `N`.
const COEFFICIENT_BOUND: f64 = 16.0 * U;

/// Evaluating `D` in floats: 1 of each coefficient, 5 of products and sums; 1 more
/// for taking away `d_spread`, 1 for `c`, which is wrong by `2^-32` at most.
const D_BOUND: f64 = 8.0 * U32;

/// Evaluating `B` in floats: 1 of each coefficient, 4 of products and sums; 1 more for `c`.
const B_BOUND: f64 = 6.0 * U32;

/// `B` in doubles: 3 of a coordinate, 1 of the product, 2 of the sums, 2 of the scale over `c`.
const DOT_BOUND: f64 = 8.0 * U;

/// From the parts to the depth: 1 of the root, half of what is under it, 2 of the sums.
/// Where `spread` or `clear_spread` is taken away, one of the sums is that.
const SUM_OF_PARTS_BOUND: f64 = 4.0 * U32;

/// More than 40 floats of the subnormals' spacing times 64 times 64: what
/// roundings can lose that are not relative to anything.
const LEAST_BOUND: f64 = 1.0 / (1_u128 << 127) as f64 / 8.0;

/// The part of the greatest `D` from which on an outline is not grazed: all but a
/// 65536th of its area.
const CLEAR_SHARE: f64 = 1.0 / 65536.0;

/// Beyond this, some intermediate float might overflow.
const GREATEST: f64 = (1_u128 << 100) as f64;

impl Local {
    /// ```text
    /// N   = N0 + p Np + q Nq      Np = dX (0, Cz, -Cy)      Nq = dY (-Cz, 0, Cx)
    /// d00 = r^2 A0 - N0.N0
    /// d10 = 2 (r^2 X0 dX - N0.Np)           d01 = 2 (r^2 Y0 dY - N0.Nq)
    /// d20 = r^2 dX^2 - Np.Np    d11 = -2 Np.Nq     d02 = r^2 dY^2 - Nq.Nq
    /// ```
    ///
    /// With `n` the sum of the parts of `|N|`, greatest in the rectangle, `a` the
    /// greatest `A` and `h` the bound of the parts of `N0`, summed likewise, the
    /// coefficients are wrong by no more than
    /// `COEFFICIENT_BOUND (r^2 a + n^2) + (2 n + h) h` anywhere in it; with what
    /// evaluating them rounds, that is the bound `e` of `D`. So `d00` is made greater by
    /// `e` and `d_spread` is `2 e`, and likewise for `B`. As `sqrt(d - 2 e)` is at least
    /// `sqrt d - 2 e/sqrt d`, and `d` no less than `clear`,
    ///
    /// ```text
    /// clear = max(CLEAR_SHARE top, 2 e)          top: no d is greater
    /// clear_spread = spread + 2 e/sqrt(CLEAR_SHARE top)
    /// ```
    ///
    /// `COVERS`: whether `least` is asked for.
    #[inline]
    pub(super) fn new<const COVERS: bool>(
        grid: &Grid,
        around: &Around,
        spheres: &Lanes,
        most: [f32; LANES],
        bounds: Bounds,
    ) -> Self {
        let &Lanes { x, y, z, r } = spheres;
        let (x0, y0) = grid.slopes(around.columns, around.rows);
        let (dx, dy) = (grid.x_step, -grid.y_step);
        let (s, t) = (around.across, around.down);
        let (zero, one, two) = (splat(0.0), splat(1.0), splat(2.0));
        let unbounded = splat(f64::INFINITY);

        let squared_radius = r * r;
        let yz = y.mul_add(y, z * z);
        let xz = x.mul_add(x, z * z);
        let k = yz - squared_radius;
        let (n_x, n_y, n_z) = (
            z.mul_neg_add(y0, y),
            z.mul_sub(x0, x),
            x.mul_sub(y0, y * x0),
        );
        let a0 = x0.mul_add(x0, y0.mul_add(y0, one));
        let nn = n_x.mul_add(n_x, n_y.mul_add(n_y, n_z * n_z));
        let d00 = squared_radius.mul_sub(a0, nn);
        let d10 = n_z.mul_add(y, n_y.mul_neg_add(z, squared_radius * x0)) * splat(2.0 * dx);
        let d01 = n_x.mul_add(z, n_z.mul_neg_add(x, squared_radius * y0)) * splat(2.0 * dy);
        let d20 = k * splat(-dx * dx);
        let d02 = (squared_radius - xz) * splat(dy * dy);
        let d11 = x * y * splat(2.0 * dx * dy);
        let b00 = x.mul_add(x0, y.mul_add(y0, z));
        let (b10, b01) = (x * splat(dx), y * splat(dy));

        let [x_abs, y_abs, z_abs] = [x.abs(), y.abs(), z.abs()];
        let (x0_abs, y0_abs) = (x0.abs(), y0.abs());
        let (x_step, y_step) = (s * splat(dx.abs()), t * splat(dy.abs()));
        let (x_most, y_most) = (x0_abs + x_step, y0_abs + y_step);
        let a_most = x_most.mul_add(x_most, y_most.mul_add(y_most, one));
        let n_most = n_x.abs() + n_y.abs() + n_z.abs();
        let n_most = (y_abs + z_abs).mul_add(x_step, (x_abs + z_abs).mul_add(y_step, n_most));
        let terms = x0_abs.mul_add(y_abs + z_abs, y0_abs.mul_add(x_abs + z_abs, x_abs + y_abs));
        let h = splat(CROSS_BOUND) * terms;
        let squares = squared_radius.mul_add(a_most, n_most * n_most);
        let d_bound = n_most
            .mul_add(two, h)
            .mul_add(h, splat(COEFFICIENT_BOUND) * squares);

        // c within 2^-32 of itself: where little is left of it, exactly.
        let sure = k.simd_gt(splat(LEAST_SHARE) * yz).to_bitmask();
        let mut c = x.mul_add(x, k);
        if sure != 0xff {
            let mut lanes = c.to_array();
            for lane in set_bits(u64::from(!sure & 0xff)) {
                lanes[lane] = power_of_camera(&spheres.sphere(lane));
            }
            c = f64x8::new(lanes);
        }
        let scale = splat(around.scale) / c;
        let squared_scale = scale * scale;
        let [d00, d10, d01, d20, d11, d02, d_bound] =
            [d00, d10, d01, d20, d11, d02, d_bound].map(|value| value * squared_scale);
        let [b00, b10, b01] = [b00, b10, b01].map(|value| value * scale);

        let (ss, st, tt) = (s * s, s * t, t * t);
        let d_linear = s.mul_add(d10.abs(), t.mul_add(d01.abs(), st * d11.abs()));
        let d_most = d00.abs() + ss.mul_add(d20.abs(), tt.mul_add(d02.abs(), d_linear));
        let b_linear = s.mul_add(b10.abs(), t * b01.abs());
        let b_most = b00.abs() + b_linear;
        let b_terms = x_abs.mul_add(x0_abs, y_abs.mul_add(y0_abs, z_abs));
        let b_terms = b_terms.mul_add(scale.abs(), b_linear);
        // More than the bounds are of themselves: they are evaluated as well.
        let up = splat(1.0 + 32.0 * U32);
        let d_bound = splat(D_BOUND)
            .mul_add(d_most, d_bound)
            .mul_add(up, splat(LEAST_BOUND));
        let bulge = ss.mul_add(d20.fast_max(zero), tt.mul_add(d02.fast_max(zero), d_linear));
        let top = (d00 + bulge).fast_max(zero) + two * d_bound;
        let top_root = top.sqrt();
        let b_bound = splat(B_BOUND).mul_add(b_most, splat(DOT_BOUND) * b_terms);
        let parts = splat(SUM_OF_PARTS_BOUND).mul_add(b_most + top_root, b_bound);
        let bound = parts.mul_add(up, splat(2.0 * LEAST_BOUND));

        // Where the plane B = 0 crosses the rectangle, the sign of B is not the same all over.
        // A camera inside needs no sign; one outside has c > 0.
        let outside = c.simd_gt(zero);
        let one_sided = c.simd_lt(zero) | (b00 - b_linear).simd_gt(b_bound);
        let known = one_sided & d_most.simd_lt(splat(GREATEST)) & b_most.simd_lt(splat(GREATEST));
        let away = outside & (b00 + b_linear).simd_lt(-b_bound);

        let nearest = (b00 + b_linear + top_root + bound) * up;

        let whole_most = f64x8::new(most.map(f64::from)) * splat(around.scale);
        let nearest = nearest.simd_lt(whole_most).select(nearest, whole_most);
        let nearest = away.select(splat(-1.0), known.select(nearest, whole_most));

        let mut farthest = splat(-1.0);
        if COVERS && bounds != Bounds::Refused {
            // The set seen is convex and 1/z concave on it for c > 0 (exact-visibility,
            // facts 3 and 4): a rectangle is hit if its corners are, and least at one.
            let mut hit = outside & known;
            farthest = splat(f64::INFINITY);
            for (p, q) in [(s, t), (s, -t), (-s, t), (-s, -t)] {
                let d = d00 + d10 * p + d01 * q + d20 * ss + d11 * (p * q) + d02 * tt;
                hit &= d.simd_gt(d_bound);
                let root = (d - d_bound).fast_max(zero).sqrt();
                farthest = farthest.fast_min(b00 + b10 * p + b01 * q + root - bound);
            }
            farthest = hit.select(farthest, splat(-1.0));
        }
        let two_d_bound = two * d_bound;
        let clear = (splat(CLEAR_SHARE) * top).fast_max(two_d_bound);
        let clear_spread = two * bound + two_d_bound / (splat(CLEAR_SHARE.sqrt()) * top_root);
        let known = match bounds {
            Bounds::Refused => known & zero,
            Bounds::Proven | Bounds::Ignored => known,
        };
        let [d_bound, bound, clear] =
            [d_bound, bound, clear].map(|value| known.select(value, unbounded));
        let (d_bound, bound, nearest) = match bounds {
            Bounds::Proven => (d_bound, bound, nearest),
            Bounds::Refused => (d_bound, bound, unbounded),
            Bounds::Ignored => (zero, zero, nearest),
        };

        let floats = |value: f64x8| value.to_array().map(|value| value as f32);
        let known_floats = |value: f64x8| floats(known.select(value, zero));
        let above = |value: f64x8| value.to_array().map(float_above);
        Self {
            p: floats(-around.across),
            q: floats(-around.down),
            d00: floats(known.select(d00, zero) + d_bound),
            d10: known_floats(d10),
            d01: known_floats(d01),
            d20: known_floats(d20),
            d11: known_floats(d11),
            d02: known_floats(d02),
            d_spread: above(two * d_bound),
            b00: floats(known.select(b00, zero) + bound),
            b10: known_floats(b10),
            b01: known_floats(b01),
            spread: above(two * bound),
            clear: above(clear),
            clear_spread: above(clear_spread),
            most: above(nearest),
            least: floats(farthest * splat(1.0 - 4.0 * U32) - splat(LEAST_BOUND)),
        }
    }
}
