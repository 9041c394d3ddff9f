//! Writes whole images to streams of bytes.

use std::{
    io::{self, Write},
    ops::Range,
};

use super::format::{groups, header};
use crate::camera::ImageSize;

/// Bytes of the buffer of rows.
pub(super) const BUFFER_BYTES: usize = 16 << 20;

/// Writes a whole image to a stream, a group of rows at a time.
///
/// ```
/// use sfera::{camera::ImageSize, ppm};
///
/// let mut stream = Vec::new();
/// ppm::write_image(&mut stream, ImageSize::new(2, 1)?, |_rows, pixels| pixels.fill(9))?;
/// assert_eq!(stream, b"P6\n2 1\n255\n\t\t\t\t\t\t");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// If the stream can't be written.
pub fn write_image(
    stream: &mut impl Write,
    size: ImageSize,
    mut draw: impl FnMut(Range<u32>, &mut [u8]),
) -> io::Result<()> {
    try_write_image(stream, size, |rows, pixels| {
        draw(rows, pixels);
        Ok(())
    })
}

/// Like [`write_image`], and ends with the first error of `draw`.
///
/// # Errors
///
/// If the stream can't be written, or `draw` fails.
pub fn try_write_image<E: From<io::Error>>(
    stream: &mut impl Write,
    size: ImageSize,
    mut draw: impl FnMut(Range<u32>, &mut [u8]) -> Result<(), E>,
) -> Result<(), E> {
    stream.write_all(header(size).as_bytes())?;
    let mut buffer = Vec::new();
    for group in groups(size, 0..size.height(), BUFFER_BYTES) {
        buffer.resize(group.len() * size.row_bytes(), 0);
        draw(group, &mut buffer)?;
        stream.write_all(&buffer)?;
    }
    Ok(stream.flush()?)
}
