//! The rule from pixels to rays, in each of its forms.
//!
//! Pixel `(i, j)`, column from the left and row from the top, of an image of
//! `W x H` looks along `V = (x, y, z)`:
//!
//! ```text
//! x = vx (i/(W-1) - 1/2)    vx, vy: width and height of the viewport
//! y = vy (1/2 - j/(H-1))    vz: its distance
//! z = vz                    W = 1: x = 0;  H = 1: y = 0
//! ```
//!
//! +y is up: row 0 looks through the upper edge. Positions come from the pixel
//! index, never by stepping, so bands and tiles are independent.

use std::fmt;

use wide::{f32x8, f64x4, f64x8};

use crate::{
    scene::Viewport,
    spheres::{LANES, double},
};

/// Lanes of a packet of doubles: half a packet of floats.
pub(crate) const DOUBLE_LANES: usize = 4;

/// Bytes of a pixel: red, green, blue.
pub const BYTES_PER_PIXEL: usize = 3;

/// Width and height of an image in pixels, checked once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageSize {
    width: u32,
    height: u32,
}

/// Why a width and height are refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SizeError {
    /// Width or height is zero.
    #[error("an image needs at least one row and one column, not {width} x {height}")]
    Empty {
        /// The width asked for.
        width: u32,
        /// The height asked for.
        height: u32,
    },
    /// The bytes of the pixels can't be addressed.
    #[error("{width} x {height} pixels are more bytes than this machine can address")]
    TooLarge {
        /// The width asked for.
        width: u32,
        /// The height asked for.
        height: u32,
    },
}

/// Width x height, as in `1920 x 1080`.
impl fmt::Display for ImageSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {}", self.width, self.height)
    }
}

impl ImageSize {
    /// The size of an image of `width` columns and `height` rows.
    ///
    /// # Errors
    ///
    /// If a side is zero, or header and pixels together pass `isize::MAX` bytes.
    pub fn new(width: u32, height: u32) -> Result<Self, SizeError> {
        if width == 0 || height == 0 {
            return Err(SizeError::Empty { width, height });
        }
        let bytes = u128::from(width) * u128::from(height) * BYTES_PER_PIXEL as u128;
        if bytes > (isize::MAX as u128) - Self::HEADER_ROOM {
            return Err(SizeError::TooLarge { width, height });
        }
        Ok(Self { width, height })
    }

    /// A size whose pixels perhaps can't be addressed: formulas know sides and no bytes,
    /// and their tests ask the same on every machine.
    #[cfg(test)]
    pub(crate) fn of_sides(width: u32, height: u32) -> Self {
        assert!(width > 0 && height > 0, "{width} x {height}");
        Self { width, height }
    }

    /// More bytes than any header of a PPM has.
    const HEADER_ROOM: u128 = 64;

    /// Columns.
    #[must_use]
    pub fn width(self) -> u32 {
        self.width
    }

    /// Rows.
    #[must_use]
    pub fn height(self) -> u32 {
        self.height
    }

    /// Pixels.
    #[must_use]
    pub fn pixels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Bytes of one row.
    #[must_use]
    pub fn row_bytes(self) -> usize {
        self.width as usize * BYTES_PER_PIXEL
    }

    /// Bytes of all pixels.
    #[must_use]
    pub fn pixel_bytes(self) -> usize {
        self.row_bytes() * self.height as usize
    }
}

/// The rule from pixels to rays for one viewport and one image size.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    viewport: Viewport,
    size: ImageSize,
    /// Width, height and distance of the viewport times a power of two that brings the
    /// largest of them into [1, 2): the same direction, and its square neither overflows
    /// nor vanishes.
    unit_viewport: [f32; 3],
}

impl Camera {
    /// The camera that sees `viewport` as an image of `size`.
    #[must_use]
    pub fn new(viewport: Viewport, size: ImageSize) -> Self {
        let lengths = [viewport.width, viewport.height, viewport.distance];
        let largest = lengths.into_iter().fold(0.0, f32::max);
        let scale = power_of_two(-exponent(f64::from(largest)));
        Self {
            viewport,
            size,
            unit_viewport: lengths.map(|length| (f64::from(length) * scale) as f32),
        }
    }

    /// The image's size.
    #[must_use]
    pub fn size(&self) -> ImageSize {
        self.size
    }

    /// The viewport of the scene.
    #[must_use]
    pub fn viewport(&self) -> Viewport {
        self.viewport
    }

    // Exact: numerators and denominators of x/vx and y/vy.

    /// `(n, d)` with `x = vx n/d`, exactly: `n = 2i - (W-1)`, `d = 2(W-1)`.
    #[must_use]
    pub fn x_ratio(&self, column: u32) -> (i64, i64) {
        let last = i64::from(self.size.width) - 1;
        if last == 0 {
            (0, 1)
        } else {
            (2 * i64::from(column) - last, 2 * last)
        }
    }

    /// `(n, d)` with `y = vy n/d`, exactly: `n = (H-1) - 2j`, `d = 2(H-1)`.
    #[must_use]
    pub fn y_ratio(&self, row: u32) -> (i64, i64) {
        let last = i64::from(self.size.height) - 1;
        if last == 0 {
            (0, 1)
        } else {
            (last - 2 * i64::from(row), 2 * last)
        }
    }

    // f64: n and d are exact; vx n and the division round once each.

    /// `x` of a column in doubles, within two roundings.
    #[must_use]
    pub fn x_double(&self, column: u32) -> f64 {
        let (n, d) = self.x_ratio(column);
        f64::from(self.viewport.width) * n as f64 / d as f64
    }

    /// `y` of a row in doubles, within two roundings.
    #[must_use]
    pub fn y_double(&self, row: u32) -> f64 {
        let (n, d) = self.y_ratio(row);
        f64::from(self.viewport.height) * n as f64 / d as f64
    }

    /// `z` of every ray in doubles, exact.
    #[must_use]
    pub fn z_double(&self) -> f64 {
        double(self.viewport.distance)
    }

    /// `x` of columns `first..first + 4` in doubles, lane by lane
    /// [`x_double`](Self::x_double).
    pub(crate) fn x_doubles(&self, first: u32) -> f64x4 {
        f64x4::new(std::array::from_fn(|lane| {
            self.x_double(first.saturating_add(lane as u32))
        }))
    }

    // f64, for the viewport moved to distance 1, as the engine uses it.

    /// Width of the viewport at distance 1, within one rounding.
    pub(crate) fn x_extent(&self) -> f64 {
        f64::from(self.viewport.width) / f64::from(self.viewport.distance)
    }

    /// Height of the viewport at distance 1, within one rounding.
    pub(crate) fn y_extent(&self) -> f64 {
        f64::from(self.viewport.height) / f64::from(self.viewport.distance)
    }

    /// The columns at distance 1: column `i` looks through `X = (i - middle) step`.
    pub(crate) fn x_axis(&self) -> Axis {
        Axis::new(self.size.width, self.x_extent())
    }

    /// The rows at distance 1: row `j` looks through `Y = (middle - j) step`.
    pub(crate) fn y_axis(&self) -> Axis {
        Axis::new(self.size.height, self.y_extent())
    }

    // f32, as in textbooks: first the fraction.

    /// `x` of a column in floats, of the unit viewport.
    #[must_use]
    pub fn x_float(&self, column: u32) -> f32 {
        let last = self.size.width - 1;
        let fraction = if last == 0 {
            0.5
        } else {
            column as f32 / last as f32
        };
        self.unit_viewport[0] * (fraction - 0.5)
    }

    /// `y` of a row in floats, of the unit viewport.
    #[must_use]
    pub fn y_float(&self, row: u32) -> f32 {
        let last = self.size.height - 1;
        let fraction = if last == 0 {
            0.5
        } else {
            row as f32 / last as f32
        };
        self.unit_viewport[1] * (0.5 - fraction)
    }

    /// `z` of every ray in floats, of the unit viewport.
    #[must_use]
    pub fn z_float(&self) -> f32 {
        self.unit_viewport[2]
    }

    /// `x` of columns `first..first + 8` in floats, lane by lane
    /// [`x_float`](Self::x_float).
    pub(crate) fn x_floats(&self, first: u32) -> f32x8 {
        let last = self.size.width - 1;
        if last == 0 {
            return f32x8::ZERO;
        }
        let column: [f32; LANES] =
            std::array::from_fn(|lane| first.saturating_add(lane as u32) as f32);
        let fraction = f32x8::new(column) / f32x8::splat(last as f32);
        f32x8::splat(self.unit_viewport[0]) * (fraction - f32x8::splat(0.5))
    }
}

/// The pixels along a side of the viewport at distance 1.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    /// Pixels per unit, within 2 roundings.
    pub(crate) scale: f64,
    /// Units per pixel, within 2 roundings.
    pub(crate) step: f64,
    /// The place of 0 among the pixels, exact.
    pub(crate) middle: f64,
}

impl Axis {
    /// A side of one pixel shows 0, so its scale is arbitrary.
    fn new(side: u32, extent: f64) -> Self {
        let last = f64::from(side - 1);
        let (scale, step) = if last == 0.0 {
            (1.0 / extent, 0.0)
        } else {
            (last / extent, extent / last)
        };
        Self {
            scale,
            step,
            middle: 0.5 * last,
        }
    }

    /// `X` of columns, within 3 roundings.
    #[inline]
    pub(crate) fn x(&self, columns: f64x8) -> f64x8 {
        (columns - f64x8::splat(self.middle)) * f64x8::splat(self.step)
    }

    /// `Y` of rows, within 3 roundings.
    #[inline]
    pub(crate) fn y(&self, rows: f64x8) -> f64x8 {
        (f64x8::splat(self.middle) - rows) * f64x8::splat(self.step)
    }
}

/// The `e` of `2^e <= value < 2^(e+1)`, for a normal positive double.
fn exponent(value: f64) -> i32 {
    ((value.to_bits() >> 52) & 0x7ff) as i32 - 1023
}

/// `2^exponent`, exactly, for exponents of normal doubles.
pub(crate) const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((exponent + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests;
