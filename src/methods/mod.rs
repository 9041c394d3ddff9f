//! The float methods, one file for each: the formula as a comment, its scalar form and its
//! packet form. They test every sphere for every pixel and cull nothing. The speed and the
//! accuracy of the engine are compared with theirs.
//!
//! Both forms of a method perform the same IEEE operations in the same order on
//! each pixel (`+ - * / sqrt`, comparisons, select), so their bytes agree.

use wide::{f32x8, f64x4};

pub mod double;
pub mod geometric;
pub mod textbook;

/// The index of the visible sphere, or [`NONE`].
pub(crate) type Seen = u32;

/// No sphere is visible: background.
pub(crate) const NONE: Seen = u32::MAX;

/// Indices of spheres in the bits of float lanes, so that they are selected with the same masks
/// as distances.
fn index_lanes(index: usize) -> f32x8 {
    f32x8::splat(f32::from_bits(index as Seen))
}

/// Like [`index_lanes`], for packets of doubles.
fn index_double_lanes(index: usize) -> f64x4 {
    f64x4::splat(f64::from_bits(index as u64))
}
