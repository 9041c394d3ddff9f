//! `double`, f64: the formula of [`textbook`](super::textbook) in doubles.
//!
//! The squares of the largest and smallest floats are ordinary doubles, so nothing overflows
//! or underflows. With 53 bits, cancellation matters only at greater distances.

use wide::f64x4;

use super::{NONE, Seen, index_double_lanes};
use crate::{
    camera::DOUBLE_LANES,
    spheres::{Spheres, double},
};

/// The nearest sphere along `(x, y, z)`.
pub(crate) fn scalar(spheres: &Spheres, [x, y, z]: [f64; 3]) -> Seen {
    let length = (x * x + y * y + z * z).sqrt();
    let (dx, dy, dz) = (x / length, y / length, z / length);
    let mut nearest = f64::INFINITY;
    let mut seen = NONE;
    for index in 0..spheres.len() {
        let cx = double(spheres.x()[index]);
        let cy = double(spheres.y()[index]);
        let cz = double(spheres.z()[index]);
        let radius = double(spheres.radius()[index]);
        let b = -2.0 * (dx * cx + dy * cy + dz * cz);
        let c = (cx * cx + cy * cy + cz * cz) - radius * radius;
        let discriminant = b * b - 4.0 * c;
        if discriminant >= 0.0 {
            let root = discriminant.sqrt();
            let near = (-b - root) * 0.5;
            let far = (-b + root) * 0.5;
            let t = if near > 0.0 { near } else { far };
            if t > 0.0 && t < nearest {
                nearest = t;
                seen = index as Seen;
            }
        }
    }
    seen
}

/// [`scalar`] on 4 rays of a row.
pub(crate) fn packet(spheres: &Spheres, x: f64x4, y: f64, z: f64) -> [Seen; DOUBLE_LANES] {
    let (y, z) = (f64x4::splat(y), f64x4::splat(z));
    let zero = f64x4::ZERO;
    let half = f64x4::splat(0.5);
    let length = (x * x + y * y + z * z).sqrt();
    let (dx, dy, dz) = (x / length, y / length, z / length);
    let mut nearest = f64x4::splat(f64::INFINITY);
    let mut seen = index_double_lanes(NONE as usize);
    for index in 0..spheres.len() {
        let cx = f64x4::splat(double(spheres.x()[index]));
        let cy = f64x4::splat(double(spheres.y()[index]));
        let cz = f64x4::splat(double(spheres.z()[index]));
        let radius = f64x4::splat(double(spheres.radius()[index]));
        let b = f64x4::splat(-2.0) * (dx * cx + dy * cy + dz * cz);
        let c = (cx * cx + cy * cy + cz * cz) - radius * radius;
        let discriminant = b * b - f64x4::splat(4.0) * c;
        let crossed = discriminant.simd_ge(zero);
        if !crossed.any() {
            continue;
        }
        let root = discriminant.sqrt();
        let near = (-b - root) * half;
        let far = (-b + root) * half;
        let t = near.simd_gt(zero).select(near, far);
        let nearer = crossed & t.simd_gt(zero) & t.simd_lt(nearest);
        nearest = nearer.select(t, nearest);
        seen = nearer.select(index_double_lanes(index), seen);
    }
    bytemuck::cast::<f64x4, [u64; DOUBLE_LANES]>(seen).map(|lane| lane as Seen)
}
