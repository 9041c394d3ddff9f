//! The box of pixels in which a sphere may be visible, and an upper bound of its inverse depth: of
//! eight spheres in floats, or of one in doubles.

use std::ops::Range;

use wide::{f32x8, u32x8};

use super::{
    bits::set_bits,
    bounds::{BESIDE_BOUND, BOX_BOUND, FLOAT_BOX_BOUND, FLOAT_UPPER_BOUND},
    grid::{Grid, float_above},
    kernels::{before, nearest_beside, touching, touching_beside},
    sight::power,
};
use crate::spheres::{LANES, Sphere, double};

#[cfg(test)]
mod tests;

/// The box of a sphere that may be visible.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelBox {
    /// First and last column, first and last row, within the picture.
    pub(super) sides: [u32; 4],
    /// The upper bound of the inverse depth of every hit.
    pub(super) upper: f32,
}

/// The boxes of eight spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Boxes {
    /// A mask of the lanes that may be visible in the picture.
    pub(super) visible: u32,
    /// As in [`PixelBox`].
    pub(super) sides: [[u32; LANES]; 4],
    pub(super) upper: [f32; LANES],
}

impl PixelBox {
    /// The box of a sphere; `None` if it is not visible in the picture. No point of it is nearer than
    /// `z = Cz - r`, or than the sphere is to the camera.
    pub(super) fn new(grid: &Grid, sphere: &Sphere) -> Option<Self> {
        let [x, y, z] = sphere.centre.map(double);
        let r = double(sphere.radius);
        if z <= -r {
            return None;
        }
        let size = grid.camera().size();
        let [left, right] = ends([x, z, r], grid.x_axis.scale, size.width())?;
        // Row numbers increase as Y decreases.
        let [top, bottom] = ends([-y, z, r], grid.y_axis.scale, size.height())?;
        let nearest = if z > r {
            let [_, far, _, inverse] = before(z, r);
            far * inverse
        } else {
            let lengths = [x, y, z, r];
            nearest_beside(grid.reach, lengths, power(lengths).abs()) * (1.0 + BESIDE_BOUND)
        };
        Some(Self {
            sides: [left, right, top, bottom],
            upper: float_above(nearest * grid.scale),
        })
    }
}

/// First and last column of a sphere with `Cz > -r`, `Cx` being `across`; the same for rows. The planes
/// through the y axis that touch it are at
///
/// ```text
/// X = (Cx Cz -+ r sqrt(Cx^2 + q))/q     q = (Cz - r)(Cz + r)
/// ```
///
/// if `q > 0`; else see [`first_beside`]. (Theorem 1.)
fn ends([across, z, r]: [f64; 3], scale: f64, side: u32) -> Option<[u32; 2]> {
    let last = f64::from(side - 1);
    let [first, end] = if z > r {
        let [_, _, q, inverse] = before(z, r);
        let [low, high] = touching(across, [z, r, q], scale * inverse);
        let slack = BOX_BOUND * (low.abs().max(high.abs()) + f64::from(side));
        [0.5 * last + (low - slack), 0.5 * last + (high + slack)]
    } else {
        let first = first_beside([across.abs(), z, r], scale, side);
        if across > 0.0 {
            [first, last]
        } else {
            [0.0, last - first]
        }
    };
    // Clamped to the picture, so that the conversions are exact.
    let (first, end) = (first.ceil().max(0.0), end.floor().min(last));
    (first <= end).then_some([first as u32, end as u32])
}

/// Where the columns of a sphere with `-r < Cz <= r` and `Cx >= 0` begin, as a real number. With
/// `q = (Cz - r)(Cz + r) <= 0` and `w = Cx^2 + q`, the outline is everywhere for `w <= 0`, else beyond
/// the plane through the y axis that touches the sphere before the camera (theorem 1):
///
/// ```text
/// X >= (Cx - r)(Cx + r)/(Cx Cz + r sqrt w)      Cz >= 0
///    = (Cx Cz - r sqrt w)/q                     Cz < 0
/// ```
fn first_beside([across, z, r]: [f64; 3], scale: f64, side: u32) -> f64 {
    let w = power([across, 0.0, z, r]);
    if w <= 0.0 {
        return 0.0;
    }
    let [ahead, back] = touching_beside([across, z, r], w);
    let slope = if z >= 0.0 { ahead } else { back };
    let pixels = slope * scale;
    let slack = BOX_BOUND * (pixels.abs() + f64::from(side));
    0.5 * f64::from(side - 1) + pixels - slack
}

/// Boxes are computed in floats if, times [`float_unit`], coordinates are no greater than the end of this
/// range, and `Cz - r` is no smaller than its start. Then no float overflows, and what underflows is far
/// below the slack.
const FLOAT_RANGE: Range<f32> = 1.0 / (1 << 20) as f32..(1 << 20) as f32;

/// And if pixels per unit are in this range.
const FLOAT_SCALES: Range<f64> = 1.0 / (1 << 24) as f64..(1 << 24) as f64;

/// The power of two by which lengths are multiplied so that `1/z` is the scaled inverse depth; `None` if
/// boxes may not be computed in floats.
pub(super) fn float_unit(grid: &Grid) -> Option<f32> {
    let size = grid.camera().size();
    let scales = [grid.x_axis.scale, grid.y_axis.scale];
    let fit = scales.iter().all(|scale| FLOAT_SCALES.contains(scale))
        && f64::from(size.width().max(size.height())) < f64::from(FLOAT_RANGE.end);
    let unit = grid.scale.recip() as f32;
    (fit && unit.is_normal()).then_some(unit)
}

impl Boxes {
    /// The boxes of eight spheres, in floats where these will do; some of those boxes are a pixel
    /// wider. `unit` is that of [`float_unit`]. A sphere's box does not depend on the other lanes: copies
    /// must have equal boxes.
    #[inline(always)]
    pub(super) fn new(grid: &Grid, components: [f32x8; 4], unit: Option<f32>) -> Self {
        let ([x, y, z, r], unit_lanes) = (components, f32x8::splat(unit.unwrap_or(0.0)));
        let lengths = [
            x * unit_lanes,
            y * unit_lanes,
            z * unit_lanes,
            r * unit_lanes,
        ];
        let in_range = if unit.is_some() { in_range(lengths) } else { 0 };
        if in_range == 0xff {
            Self::in_floats(grid, lengths)
        } else {
            Self::some_in_doubles(grid, components, lengths, in_range)
        }
    }

    #[cold]
    fn some_in_doubles(
        grid: &Grid,
        components: [f32x8; 4],
        lengths: [f32x8; 4],
        in_range: u32,
    ) -> Self {
        let mut boxes = Self::in_floats(grid, lengths);
        boxes.visible &= in_range;
        for lane in set_bits(u64::from(!in_range & 0xff)) {
            let [x, y, z, radius] = components.map(|lanes| lanes.as_array()[lane]);
            let sphere = Sphere {
                centre: [x, y, z],
                radius,
                colour: [0; 3],
            };
            if let Some(PixelBox { sides, upper }) = PixelBox::new(grid, &sphere) {
                boxes.visible |= 1 << lane;
                for (side, end) in boxes.sides.iter_mut().zip(sides) {
                    side[lane] = end;
                }
                boxes.upper[lane] = upper;
            }
        }
        boxes
    }

    /// The boxes of spheres before the camera, by the formula of [`ends`].
    #[inline(always)]
    fn in_floats(grid: &Grid, [x, y, z, r]: [f32x8; 4]) -> Self {
        let constant = |value: f64| f32x8::splat(value as f32);
        let size = grid.camera().size();
        let [near, far, q, inverse] = before(z, r);
        let zero = constant(0.0);
        let ends = |centre: f32x8, scale: f64, side: u32| {
            let [low, high] = touching(centre, [z, r, q], constant(scale) * inverse);
            let greater = low.abs().fast_max(high.abs());
            let slack = constant(FLOAT_BOX_BOUND) * (greater + constant(f64::from(side)));
            (low - slack, high + slack)
        };
        let (low, high) = ends(x, grid.x_axis.scale, size.width());
        let middle = constant(grid.x_axis.middle);
        let (left, right) = ((middle + low).ceil(), (middle + high).floor());
        let (low, high) = ends(y, grid.y_axis.scale, size.height());
        let middle = constant(grid.y_axis.middle);
        let (top, bottom) = ((middle - high).ceil(), (middle - low).floor());

        let last_column = constant(f64::from(size.width() - 1));
        let last_row = constant(f64::from(size.height() - 1));
        let met = left.simd_le(right)
            & top.simd_le(bottom)
            & right.simd_ge(zero)
            & left.simd_le(last_column)
            & bottom.simd_ge(zero)
            & top.simd_le(last_row);
        // NaN becomes 0, in lanes that are not used.
        let clamped = |end: f32x8, last: f32x8| {
            let end = end.simd_gt(zero).select(end, zero);
            whole(end.simd_lt(last).select(end, last))
        };
        let upper = far * inverse * constant(1.0 + FLOAT_UPPER_BOUND);
        Self {
            visible: (near.simd_gt(zero) & met).to_bitmask(),
            sides: [
                clamped(left, last_column),
                clamped(right, last_column),
                clamped(top, last_row),
                clamped(bottom, last_row),
            ],
            upper: upper.to_array(),
        }
    }
}

/// Converts whole numbers from 0 to `2^23 - 1`: added to `2^23`, they are the low bits.
#[inline]
fn whole(lanes: f32x8) -> [u32; LANES] {
    let bits: u32x8 = bytemuck::cast(lanes + f32x8::splat(8_388_608.0));
    (bits & u32x8::splat(0x7f_ffff)).to_array()
}

/// The spheres in the range of floats.
#[inline]
fn in_range([x, y, z, r]: [f32x8; 4]) -> u32 {
    let [nearest, farthest] = [FLOAT_RANGE.start, FLOAT_RANGE.end].map(f32x8::splat);
    let within = x.abs().simd_le(farthest) & y.abs().simd_le(farthest) & z.simd_le(farthest);
    (within & (z - r).simd_ge(nearest)).to_bitmask()
}
