//! The box of pixels in which a sphere may be visible, and an upper bound of its inverse depth,
//! for eight spheres at a time.

use wide::f64x8;

use super::{
    bounds::{BESIDE_BOUND, BOX_BOUND},
    grid::{EightSpheres, Grid, float_above, splat},
    kernels::{before, nearest_beside, touching, touching_beside},
    set_bits,
    sight::power_of_camera,
};
use crate::spheres::{LANES, Sphere};

#[cfg(test)]
mod tests;

/// The boxes of eight spheres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Boxes {
    /// A mask of the lanes that may be visible in the picture.
    pub(super) visible: u32,
    /// First and last column and row, within the picture.
    pub(super) left: [u32; LANES],
    pub(super) right: [u32; LANES],
    pub(super) top: [u32; LANES],
    pub(super) bottom: [u32; LANES],
    /// The upper bound of the inverse depth of every hit.
    pub(super) upper: [f32; LANES],
}

/// Converts whole numbers from 0 to `2^32 - 1`: after adding `2^52` they are in the low bits.
#[inline]
fn whole(lanes: f64x8) -> [u32; LANES] {
    let bits: [u64; LANES] = bytemuck::cast(lanes + splat(f64::from_bits(0x433 << 52)));
    bits.map(|bits| bits as u32)
}

impl Boxes {
    /// ```text
    /// X = (Cx Cz -+ r sqrt(Cx^2 + q))/q     q = (Cz - r)(Cz + r) > 0
    /// ```
    ///
    /// are the planes through the y axis that touch the sphere, and likewise for `Y`. No point
    /// of it is nearer than `z = Cz - r`. Where `Cz <= r` the outline is not an ellipse: see
    /// [`Self::set_beside`]. (Theorem 1.)
    #[inline]
    pub(super) fn new(grid: &Grid, spheres: &EightSpheres) -> Self {
        let &EightSpheres { x, y, z, r } = spheres;
        let size = grid.camera().size();
        let [near, far, q, inverse] = before(z, r);
        let before = near.simd_gt(splat(0.0));
        let behind = far.simd_le(splat(0.0));

        let ends = |centre: f64x8, scale: f64, side: u32| {
            let [low, high] = touching(centre, [z, r, q], splat(scale) * inverse);
            let slack =
                splat(BOX_BOUND) * (low.abs().fast_max(high.abs()) + splat(f64::from(side)));
            (low - slack, high + slack)
        };
        let (low, high) = ends(x, grid.x_axis.scale, size.width());
        let middle = splat(grid.x_axis.middle);
        let (left, right) = ((middle + low).ceil(), (middle + high).floor());
        let (low, high) = ends(y, grid.y_axis.scale, size.height());
        let middle = splat(grid.y_axis.middle);
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
        // NaN becomes 0, in lanes that are not used.
        let clamped = |end: f64x8, last: f64x8| {
            let end = end.simd_gt(zero).select(end, zero);
            whole(end.simd_lt(last).select(end, last))
        };
        let mut boxes = Self {
            visible: (before & met).to_bitmask(),
            left: clamped(left, last_column),
            right: clamped(right, last_column),
            top: clamped(top, last_row),
            bottom: clamped(bottom, last_row),
            upper: (far * inverse * splat(grid.scale))
                .to_array()
                .map(float_above),
        };
        let beside = !(before | behind).to_bitmask() & 0xff;
        for lane in set_bits(u64::from(beside)) {
            boxes.set_beside(lane, grid, &spheres.sphere(lane));
        }
        boxes
    }

    /// Sets the box of a sphere that reaches the plane `z = 0`. Its outline is a branch of a
    /// hyperbola or a parabola, or there is none because the camera is inside.
    #[cold]
    fn set_beside(&mut self, lane: usize, grid: &Grid, sphere: &Sphere) {
        let size = grid.camera().size();
        let [x, y, _] = sphere.centre;
        let columns = ends_beside(sphere, x, grid.x_axis.scale, size.width());
        // Row numbers increase as Y decreases.
        let rows = ends_beside(sphere, -y, grid.y_axis.scale, size.height());
        if let (Some((left, right)), Some((top, bottom))) = (columns, rows) {
            self.visible |= 1 << lane;
            (self.left[lane], self.right[lane]) = (left, right);
            (self.top[lane], self.bottom[lane]) = (top, bottom);
            self.upper[lane] = upper_beside(grid, sphere);
        }
    }
}

/// The first and the last column of a sphere with `-r < Cz <= r` and `Cx = across`, or likewise
/// of rows. Let `q = (Cz - r)(Cz + r) <= 0` and `w = Cx^2 + q`. For `w <= 0` the sphere covers
/// all columns, else those beyond the plane through the y axis that touches the sphere in front
/// of the camera (`exact::proof`, theorem 1):
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
    let (x, z, r) = (
        f64::from(across.abs()),
        f64::from(centre[2]),
        f64::from(radius),
    );
    let [ahead, back] = touching_beside([x, z, r], w);
    let slope = if z >= 0.0 { ahead } else { back };
    let pixels = slope * scale;
    let slack = BOX_BOUND * (pixels.abs() + f64::from(side));
    let middle = 0.5 * f64::from(last);
    // NaN, from a plane at infinity, gives no bound.
    let first = (middle + pixels - slack).ceil().max(0.0);
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

/// No hit has a greater inverse depth.
fn upper_beside(grid: &Grid, sphere: &Sphere) -> f32 {
    let [x, y, z] = sphere.centre.map(f64::from);
    let lengths = [x, y, z, f64::from(sphere.radius)];
    let nearest = nearest_beside(grid.reach, lengths, power_of_camera(sphere).abs());
    let upper = nearest * (1.0 + BESIDE_BOUND);
    float_above(upper * grid.scale)
}
