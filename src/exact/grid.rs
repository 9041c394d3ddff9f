//! The pixel grid on the viewport at distance 1, and spheres eight at a time.
//!
//! The viewport is moved to distance 1, so a ray is `V = (X, Y, 1)` and the inverse depth of a
//! hit is `1/z`, for any distance of the viewport. The engine multiplies
//! every inverse depth by [`Grid::scale`], a power of two that makes those of an
//! ordinary sphere of the scene about 1. In the code of the engine, *inverse depth* means
//! the scaled one.

use wide::f64x8;

use super::bounds::{REACH_BOUND, TO_FLOAT};
use crate::{
    camera::{Axis, Camera},
    spheres::{LANES, double},
};

/// The greatest side of a tile, in pixels.
pub(super) const SIDE: usize = 64;

/// The lanes of a packet, in pixels from its first.
pub(super) const STEPS: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// The pixel grid on the viewport at distance 1.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    camera: Camera,
    pub(super) x_axis: Axis,
    pub(super) y_axis: Axis,
    /// The upper bound of `|V|` in the picture.
    pub(super) reach: f64,
    /// A power of two: inverse depths times this are about 1.
    pub(super) scale: f64,
}

impl Grid {
    /// With a scale of 1.
    pub(super) fn new(camera: Camera) -> Self {
        const UP: f64 = 1.0 + REACH_BOUND;
        let x_upper = 0.5 * camera.x_extent() * UP;
        let y_upper = 0.5 * camera.y_extent() * UP;
        Self {
            camera,
            x_axis: camera.x_axis(),
            y_axis: camera.y_axis(),
            reach: (x_upper * x_upper + y_upper * y_upper + 1.0).sqrt() * UP,
            scale: 1.0,
        }
    }

    pub(super) fn camera(&self) -> &Camera {
        &self.camera
    }
}

/// Eight spheres in doubles.
#[derive(Clone, Copy, Debug)]
pub(super) struct EightSpheres {
    pub(super) x: f64x8,
    pub(super) y: f64x8,
    pub(super) z: f64x8,
    pub(super) r: f64x8,
}

impl EightSpheres {
    #[inline]
    pub(super) fn new([x, y, z, r]: [[f32; LANES]; 4]) -> Self {
        let doubles = |floats: [f32; LANES]| f64x8::new(floats.map(double));
        Self {
            x: doubles(x),
            y: doubles(y),
            z: doubles(z),
            r: doubles(r),
        }
    }

    /// Up to eight spheres, each as centre and radius; the last one fills the rest.
    #[inline]
    pub(super) fn of(spheres: impl Iterator<Item = [f32; 4]>) -> Self {
        let mut components = [[0.0; LANES]; 4];
        let mut last = [0.0, 0.0, 1.0, 0.5];
        let mut spheres = spheres.fuse();
        for lane in 0..LANES {
            last = spheres.next().unwrap_or(last);
            for (component, length) in components.iter_mut().zip(last) {
                component[lane] = length;
            }
        }
        Self::new(components)
    }

    /// The lanes that are equal to a sphere; minus zero is zero.
    #[inline]
    pub(super) fn equal(&self, sphere: &[f32; 4]) -> u32 {
        let [x, y, z, r] = sphere.map(|length| splat(f64::from(length)));
        let centre = self.x.simd_eq(x) & self.y.simd_eq(y) & self.z.simd_eq(z);
        (centre & self.r.simd_eq(r)).to_bitmask()
    }
}

#[inline]
pub(super) fn splat(value: f64) -> f64x8 {
    f64x8::splat(value)
}

/// A float above `value`, which is `>= 0` and of any magnitude: conversion rounds
/// by `2^-24` of it, or by `2^-150`. Of a negative value, which says that there is no hit, it is at most
/// the least float above 0, and may be below the value.
#[inline]
pub(super) fn float_above(value: f64) -> f32 {
    (value * (1.0 + TO_FLOAT) + f64::from(f32::from_bits(1))) as f32
}

/// A float below `value`, likewise, but not below 0.
#[inline]
pub(super) fn float_below(value: f64) -> f32 {
    let below = (value * (1.0 - TO_FLOAT) - f64::from(f32::from_bits(1))) as f32;
    // NaN gives 0. Unlike `max`, this becomes one instruction for all lanes.
    if below > 0.0 { below } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::EightSpheres;

    /// Of spheres that differ in one number, or in the sign of a zero.
    #[test]
    fn only_the_same_sphere_is_equal() {
        let sphere = [0.0, 2.0, 3.0, 0.5];
        let mut others = [sphere; 6];
        for (place, other) in others.iter_mut().take(4).enumerate() {
            other[place] += 1.0;
        }
        others[4][0] = -0.0;
        let eight = EightSpheres::of(others.into_iter());
        assert_eq!(eight.equal(&sphere), 0b1111_0000);
    }
}
