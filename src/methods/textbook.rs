//! `textbook`, f32: the quadratic formula of textbooks.
//!
//! ```text
//! d = V/|V|
//! b = -2 d.C      c = C.C - r^2      (a = d.d = 1)
//! D = b^2 - 4c
//! t = (-b - sqrt D)/2, or (-b + sqrt D)/2 if that is not in front
//! ```
//!
//! Source: A. Glassner (ed.), An Introduction to Ray Tracing, 1989, ch. 2.

use wide::f32x8;

use super::{NONE, Seen, index_lanes};
use crate::spheres::{LANES, Spheres};

/// The nearest sphere along `(x, y, z)`.
pub(crate) fn scalar(spheres: &Spheres, [x, y, z]: [f32; 3]) -> Seen {
    let length = (x * x + y * y + z * z).sqrt();
    let (dx, dy, dz) = (x / length, y / length, z / length);
    let mut nearest = f32::INFINITY;
    let mut seen = NONE;
    for index in 0..spheres.len() {
        let (cx, cy, cz) = (spheres.x()[index], spheres.y()[index], spheres.z()[index]);
        let radius = spheres.radius()[index];
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

/// [`scalar`] on 8 rays of a row.
pub(crate) fn packet(spheres: &Spheres, x: f32x8, y: f32, z: f32) -> [Seen; LANES] {
    let (y, z) = (f32x8::splat(y), f32x8::splat(z));
    let zero = f32x8::ZERO;
    let half = f32x8::splat(0.5);
    let length = (x * x + y * y + z * z).sqrt();
    let (dx, dy, dz) = (x / length, y / length, z / length);
    let mut nearest = f32x8::splat(f32::INFINITY);
    let mut seen = index_lanes(NONE as usize);
    for index in 0..spheres.len() {
        let cx = f32x8::splat(spheres.x()[index]);
        let cy = f32x8::splat(spheres.y()[index]);
        let cz = f32x8::splat(spheres.z()[index]);
        let radius = f32x8::splat(spheres.radius()[index]);
        let b = f32x8::splat(-2.0) * (dx * cx + dy * cy + dz * cz);
        let c = (cx * cx + cy * cy + cz * cz) - radius * radius;
        let discriminant = b * b - f32x8::splat(4.0) * c;
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
        seen = nearer.select(index_lanes(index), seen);
    }
    bytemuck::cast(seen)
}
