//! The box of pixels in which a sphere may be visible, and an upper bound of its inverse depth,
//! for eight spheres at a time.

use std::ops::Range;

use wide::{f32x8, f64x8, u32x8};

use super::{
    bits::set_bits,
    bounds::{BESIDE_BOUND, BOX_BOUND, FLOAT_BOX_BOUND, FLOAT_UPPER_BOUND},
    grid::{EightSpheres, Grid, float_above, splat},
    kernels::{before, nearest_beside, touching, touching_beside},
    sight::power_of_camera,
};
use crate::spheres::{LANES, Sphere, double};

#[cfg(test)]
mod tests;

/// The boxes of eight spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Boxes {
    /// A mask of the lanes that may be visible in the picture.
    pub(super) visible: u32,
    /// First and last column, first and last row, within the picture.
    pub(super) sides: [[u32; LANES]; 4],
    /// The upper bound of the inverse depth of every hit.
    pub(super) upper: [f32; LANES],
}

/// Converts whole numbers from 0 to `2^32 - 1`: after adding `2^52` they are in the low bits.
#[inline]
fn whole(lanes: f64x8) -> [u32; LANES] {
    let bits: [u64; LANES] = bytemuck::cast(lanes + splat(f64::from_bits(0x433 << 52)));
    bits.map(|bits| bits as u32)
}

/// Whole numbers from 0 to `2^23 - 1`: added to `2^23`, they are the low bits.
#[inline]
fn whole_floats(lanes: f32x8) -> [u32; LANES] {
    let bits: u32x8 = bytemuck::cast(lanes + f32x8::splat(8_388_608.0));
    (bits & u32x8::splat(0x7f_ffff)).to_array()
}

fn above(lanes: f64x8) -> [f32; LANES] {
    lanes.to_array().map(float_above)
}

fn above_floats(lanes: f32x8) -> [f32; LANES] {
    (lanes * f32x8::splat((1.0 + FLOAT_UPPER_BOUND) as f32)).to_array()
}

/// Boxes are computed in floats if coordinates are no greater than the end of this range, the
/// distance in front of the camera plane is no smaller than its start, and a picture's sides
/// and scales are as [`Boxes::fit_floats`] says. Then no float overflows, and what underflows is
/// far below the slack.
const FLOAT_RANGE: Range<f32> = 1.0 / (1 << 20) as f32..(1 << 20) as f32;
const FLOAT_SCALES: Range<f64> = 1.0 / (1 << 24) as f64..(1 << 24) as f64;

/// Boxes of spheres before the camera, in lanes of doubles or of floats, and the lanes that
/// are before it or behind it.
macro_rules! boxes_before {
    ($name:ident, $lanes:ty, $lane:ty, $bound:expr, $whole:ident, $above:ident) => {
        /// ```text
        /// X = (Cx Cz -+ r sqrt(Cx^2 + q))/q     q = (Cz - r)(Cz + r) > 0
        /// ```
        ///
        /// are the planes through the y axis that touch the sphere, and likewise for `Y`. No point
        /// of it is nearer than `z = Cz - r`. (Theorem 1.)
        #[inline(always)]
        fn $name(grid: &Grid, [x, y, z, r]: [$lanes; 4]) -> (Self, u32) {
            let constant = |value: f64| <$lanes>::splat(value as $lane);
            let size = grid.camera().size();
            let [near, far, q, inverse] = before(z, r);
            let zero = constant(0.0);
            let before = near.simd_gt(zero);
            let behind = far.simd_le(zero);

            let ends = |centre: $lanes, scale: f64, side: u32| {
                let [low, high] = touching(centre, [z, r, q], constant(scale) * inverse);
                let greater = low.abs().fast_max(high.abs());
                let slack = constant($bound) * (greater + constant(f64::from(side)));
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
            let clamped = |end: $lanes, last: $lanes| {
                let end = end.simd_gt(zero).select(end, zero);
                $whole(end.simd_lt(last).select(end, last))
            };
            let boxes = Self {
                visible: (before & met).to_bitmask(),
                sides: [
                    clamped(left, last_column),
                    clamped(right, last_column),
                    clamped(top, last_row),
                    clamped(bottom, last_row),
                ],
                upper: $above(far * inverse * constant(grid.scale)),
            };
            (boxes, (before | behind).to_bitmask())
        }
    };
}

impl Boxes {
    boxes_before!(in_doubles, f64x8, f64, BOX_BOUND, whole, above);
    boxes_before!(
        in_floats,
        f32x8,
        f32,
        FLOAT_BOX_BOUND,
        whole_floats,
        above_floats
    );

    /// The boxes of eight spheres. Where `Cz <= r` the outline is not an ellipse: see
    /// [`Self::set_beside`].
    #[inline]
    pub(super) fn new(grid: &Grid, spheres: &EightSpheres) -> Self {
        let &EightSpheres { x, y, z, r } = spheres;
        let (mut boxes, known) = Self::in_doubles(grid, [x, y, z, r]);
        for lane in set_bits(u64::from(!known & 0xff)) {
            boxes.set_beside(lane, grid, &spheres.sphere(lane));
        }
        boxes
    }

    /// Like [`new`](Self::new), and faster where floats will do; some boxes are a pixel wider.
    /// `fit` is what [`Self::fit_floats`] says. A sphere's box does not depend on the other
    /// lanes: copies must have equal boxes.
    #[inline]
    pub(super) fn of_floats(grid: &Grid, components: [[f32; LANES]; 4], fit: bool) -> Self {
        let floats = components.map(f32x8::new);
        let in_range = if fit { in_range(floats) } else { 0 };
        if in_range == ALL {
            return Self::in_floats(grid, floats).0;
        }
        let mut boxes = Self::new(grid, &EightSpheres::new(components));
        if in_range != 0 {
            boxes.replace(&Self::in_floats(grid, floats).0, in_range);
        }
        boxes
    }

    /// Takes some lanes from others.
    fn replace(&mut self, others: &Self, lanes: u32) {
        self.visible = self.visible & !lanes | others.visible & lanes;
        for lane in set_bits(u64::from(lanes)) {
            for (side, other) in self.sides.iter_mut().zip(&others.sides) {
                side[lane] = other[lane];
            }
            self.upper[lane] = others.upper[lane];
        }
    }

    /// Whether a picture's scales can be used in floats.
    pub(super) fn fit_floats(grid: &Grid) -> bool {
        let size = grid.camera().size();
        let scales = [grid.x_axis.scale, grid.y_axis.scale, grid.scale];
        scales.iter().all(|scale| FLOAT_SCALES.contains(scale))
            && f64::from(size.width().max(size.height())) < f64::from(FLOAT_RANGE.end)
    }

    /// A sphere that reaches the plane `z = 0`: its outline is a branch of a hyperbola
    /// or a parabola, or there is none since the camera is inside.
    #[cold]
    fn set_beside(&mut self, lane: usize, grid: &Grid, sphere: &Sphere) {
        let size = grid.camera().size();
        let [x, y, _] = sphere.centre;
        let columns = ends_beside(sphere, x, grid.x_axis.scale, size.width());
        // Row numbers increase as Y decreases.
        let rows = ends_beside(sphere, -y, grid.y_axis.scale, size.height());
        if let (Some((left, right)), Some((top, bottom))) = (columns, rows) {
            self.visible |= 1 << lane;
            for (side, end) in self.sides.iter_mut().zip([left, right, top, bottom]) {
                side[lane] = end;
            }
            self.upper[lane] = upper_beside(grid, sphere);
        }
    }
}

/// All lanes.
const ALL: u32 = 0xff;

/// The spheres in the range of floats, or behind the camera.
#[inline]
fn in_range([x, y, z, r]: [f32x8; 4]) -> u32 {
    let [nearest, farthest] = [FLOAT_RANGE.start, FLOAT_RANGE.end].map(f32x8::splat);
    let within = x.abs().simd_le(farthest) & y.abs().simd_le(farthest) & z.simd_le(farthest);
    let before = (z - r).simd_ge(nearest);
    let behind = (z + r).simd_le(f32x8::splat(0.0));
    (within & before | behind).to_bitmask()
}

/// First and last column of a sphere with `-r < Cz <= r`, `Cx` being `across`; the
/// same for rows. With `q = (Cz - r)(Cz + r) <= 0` and `w = Cx^2 + q`, the outline is
/// everywhere for `w <= 0`, else beyond the plane through the y axis that touches the
/// sphere before the camera (`exact::proof`, theorem 1):
///
/// ```text
/// |X| >= (|Cx| - r)(|Cx| + r)/(|Cx| Cz + r sqrt w)      Cz >= 0
///      = (|Cx| Cz - r sqrt w)/q                         Cz < 0
/// ```
fn ends_beside(sphere: &Sphere, across: f32, scale: f64, side: u32) -> Option<(u32, u32)> {
    let last = side - 1;
    let Sphere { centre, radius, .. } = *sphere;
    let flat = Sphere {
        centre: [across, 0.0, centre[2]],
        ..*sphere
    };
    let w = power_of_camera(&flat);
    if w <= 0.0 {
        return Some((0, last));
    }
    let lengths = [across.abs(), centre[2], radius].map(double);
    // NaN, from a plane at infinity, gives no bound.
    let first = first_beside(lengths, w, scale, side).ceil().max(0.0);
    if first > f64::from(last) {
        return None;
    }
    let first = first as u32;
    Some(if across > 0.0 {
        (first, last)
    } else {
        (0, last - first)
    })
}

/// The end of the columns of a sphere with `-r < Cz <= r` to the right of the middle, as a real number;
/// `w` is above 0.
fn first_beside([x, z, r]: [f64; 3], w: f64, scale: f64, side: u32) -> f64 {
    let [ahead, back] = touching_beside([x, z, r], w);
    let slope = if z >= 0.0 { ahead } else { back };
    let pixels = slope * scale;
    let slack = BOX_BOUND * (pixels.abs() + f64::from(side));
    0.5 * f64::from(side - 1) + pixels - slack
}

/// No hit has a greater inverse depth.
fn upper_beside(grid: &Grid, sphere: &Sphere) -> f32 {
    let [x, y, z] = sphere.centre.map(double);
    let lengths = [x, y, z, double(sphere.radius)];
    let nearest = nearest_beside(grid.reach, lengths, power_of_camera(sphere).abs());
    let upper = nearest * (1.0 + BESIDE_BOUND);
    float_above(upper * grid.scale)
}
