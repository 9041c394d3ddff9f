//! The float methods, a file each: the formula as a comment, its scalar form,
//! its packet form. Brute force over all spheres, nothing culled: they are what
//! is measured against, in speed and in accuracy.
//!
//! Both forms of a method perform the same IEEE operations in the same order on
//! each pixel (`+ - * / sqrt`, comparisons, select), so their bytes agree.

use wide::{f32x8, f64x4};

pub mod double;
pub mod geometric;
pub mod textbook;

/// The sphere seen, or [`NONE`].
pub(crate) type Seen = u32;

/// No sphere is seen: background.
pub(crate) const NONE: Seen = u32::MAX;

/// The lanes of a float mask as a bit each, and the sphere index carried in the
/// bits of a float lane: indices are selected with the same masks as depths.
fn index_lanes(index: usize) -> f32x8 {
    f32x8::splat(f32::from_bits(index as Seen))
}

/// As [`index_lanes`], for packets of doubles.
fn index_double_lanes(index: usize) -> f64x4 {
    f64x4::splat(f64::from_bits(index as u64))
}
