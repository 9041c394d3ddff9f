//! Whole images from and to streams of bytes.

use std::{
    fs::File,
    io::{self, Write},
    ops::Range,
    path::Path,
};

use super::{
    errors::{ImageError, OPEN, READ, refused},
    format::{check_picture, groups, header, offset},
    system,
};
use crate::camera::ImageSize;

/// Bytes of the buffer of a stream.
pub(super) const BUFFER_BYTES: usize = 16 << 20;

/// Reads the pixels of `rows` from the picture at `path`, a group at a time.
///
/// # Errors
///
/// If the file can't be read or is not a picture of this size, or at the first
/// error of `look`.
pub fn read_rows<E: From<ImageError>>(
    path: &Path,
    size: ImageSize,
    rows: Range<u32>,
    mut look: impl FnMut(Range<u32>, &[u8]) -> Result<(), E>,
) -> Result<(), E> {
    let file = File::open(path).map_err(refused(path, OPEN))?;
    check_picture(&file, path, size)?;
    let mut buffer = Vec::new();
    for group in groups(size, rows, BUFFER_BYTES) {
        buffer.resize(group.len() * size.row_bytes(), 0);
        system::read_at(&file, &mut buffer, offset(size, group.start))
            .map_err(refused(path, READ))?;
        look(group, &buffer)?;
    }
    Ok(())
}

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
    stream.write_all(header(size).as_bytes())?;
    let mut buffer = Vec::new();
    for group in groups(size, 0..size.height(), BUFFER_BYTES) {
        buffer.resize(group.len() * size.row_bytes(), 0);
        draw(group, &mut buffer);
        stream.write_all(&buffer)?;
    }
    stream.flush()
}
