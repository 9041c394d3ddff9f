//! `geometric`, f32: the stable form of the quadratic formula.
//!
//! ```text
//! d = V/|V|
//! b = C.d                      the foot of the perpendicular, from the camera
//! l = C - b d                  from the foot to the centre
//! D = r^2 - l.l                no difference of large squares
//! q = b + sign(b) sqrt D       no difference of near equals
//! t0 = c/q,  t1 = q            c = C.C - r^2; the roots are t0 t1 = c
//! ```
//!
//! Source: E. Haines, J. Guenther, T. Akenine-Moeller, Precision Improvements
//! for Ray/Sphere Intersection, Ray Tracing Gems, 2019, ch. 7.

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
        let b = cx * dx + cy * dy + cz * dz;
        let (lx, ly, lz) = (cx - b * dx, cy - b * dy, cz - b * dz);
        let squared_radius = radius * radius;
        let discriminant = squared_radius - (lx * lx + ly * ly + lz * lz);
        if discriminant >= 0.0 {
            let root = discriminant.sqrt();
            let c = (cx * cx + cy * cy + cz * cz) - squared_radius;
            let q = if b >= 0.0 { b + root } else { b - root };
            let other = c / q;
            let near = if other < q { other } else { q };
            let far = if other < q { q } else { other };
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
    let length = (x * x + y * y + z * z).sqrt();
    let (dx, dy, dz) = (x / length, y / length, z / length);
    let mut nearest = f32x8::splat(f32::INFINITY);
    let mut seen = index_lanes(NONE as usize);
    for index in 0..spheres.len() {
        let cx = f32x8::splat(spheres.x()[index]);
        let cy = f32x8::splat(spheres.y()[index]);
        let cz = f32x8::splat(spheres.z()[index]);
        let radius = f32x8::splat(spheres.radius()[index]);
        let b = cx * dx + cy * dy + cz * dz;
        let (lx, ly, lz) = (cx - b * dx, cy - b * dy, cz - b * dz);
        let squared_radius = radius * radius;
        let discriminant = squared_radius - (lx * lx + ly * ly + lz * lz);
        let crossed = discriminant.simd_ge(zero);
        if !crossed.any() {
            continue;
        }
        let root = discriminant.sqrt();
        let c = (cx * cx + cy * cy + cz * cz) - squared_radius;
        let q = b.simd_ge(zero).select(b + root, b - root);
        let other = c / q;
        let ordered = other.simd_lt(q);
        let near = ordered.select(other, q);
        let far = ordered.select(q, other);
        let t = near.simd_gt(zero).select(near, far);
        let nearer = crossed & t.simd_gt(zero) & t.simd_lt(nearest);
        nearest = nearer.select(t, nearest);
        seen = nearer.select(index_lanes(index), seen);
    }
    bytemuck::cast(seen)
}
