//! The layout of the file, and whether a file has it.

use std::{fs::File, ops::Range, path::Path};

use super::{
    errors::{ImageError, READ, refused},
    system,
};
use crate::camera::ImageSize;

/// The header of a binary PPM of this size.
#[must_use]
pub fn header(size: ImageSize) -> String {
    format!("P6\n{} {}\n255\n", size.width(), size.height())
}

/// Bytes of the whole file.
pub(super) fn file_bytes(size: ImageSize) -> u64 {
    (header(size).len() + size.pixel_bytes()) as u64
}

/// The offset of the pixels of a row in the file.
pub(super) fn offset(size: ImageSize, row: u32) -> u64 {
    header(size).len() as u64 + u64::from(row) * size.row_bytes() as u64
}

/// A number of rows that tiles of every size divide.
const WHOLE_TILES: usize = 64;

/// Splits `rows` evenly into groups of at most `bytes` and at least one row. Where groups
/// are large enough, they consist of whole rows of tiles.
pub(super) fn groups(
    size: ImageSize,
    rows: Range<u32>,
    bytes: usize,
) -> impl Iterator<Item = Range<u32>> {
    let upper = (bytes / size.row_bytes()).max(1);
    let count = rows.len().div_ceil(upper).max(1);
    let mut each = rows.len().div_ceil(count).max(1);
    if count > 1 && upper >= WHOLE_TILES {
        each = each
            .next_multiple_of(WHOLE_TILES)
            .min(upper - upper % WHOLE_TILES);
    }
    rows.clone()
        .step_by(each)
        .map(move |first| first..first.saturating_add(each as u32).min(rows.end))
}

/// Checks by length and header that a file is a picture of this size.
pub(super) fn check_picture(file: &File, path: &Path, size: ImageSize) -> Result<(), ImageError> {
    let other = |found: String| ImageError::OtherPicture {
        path: path.to_owned(),
        size,
        found,
    };
    let metadata = file.metadata().map_err(refused(path, "ask its size"))?;
    if !metadata.is_file() {
        return Err(ImageError::NotAFile {
            path: path.to_owned(),
        });
    }
    let (length, expected) = (metadata.len(), file_bytes(size));
    if length != expected {
        return Err(other(format!("{length} bytes instead of {expected}")));
    }
    let header = header(size);
    let mut start = vec![0; header.len()];
    system::read_at(file, &mut start, 0).map_err(refused(path, READ))?;
    if start != header.as_bytes() {
        return Err(other(format!(
            "it begins \"{}\" instead of \"{}\"",
            start.escape_ascii(),
            header.as_bytes().escape_ascii()
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn size(width: u32, height: u32) -> ImageSize {
        ImageSize::new(width, height).expect("a size with pixels")
    }

    #[test]
    fn groups_hold_each_row_once_and_fit() {
        for (width, height) in [
            (1, 1),
            (1, 5000),
            (5000, 1),
            (640, 480),
            (99, 1031),
            (4000, 3),
        ] {
            let size = size(width, height);
            for bytes in [1, 3, 1000, 64 * size.row_bytes(), 200_000, usize::MAX] {
                let mut next = 0;
                for group in groups(size, 0..height, bytes) {
                    assert_eq!(group.start, next);
                    assert!(group.len() == 1 || group.len() * size.row_bytes() <= bytes);
                    next = group.end;
                }
                assert_eq!(next, height, "{width} x {height} by {bytes}");
            }
        }
        assert_eq!(groups(size(4, 4), 2..3, 1).last(), Some(2..3));
    }

    #[test]
    fn groups_of_a_large_picture_consist_of_whole_rows_of_tiles() {
        let size = size(100, 1000);
        for rows in [64, 65, 127, 128, 200, 500, 999] {
            let groups: Vec<_> = groups(size, 0..1000, rows * size.row_bytes()).collect();
            let (last, others) = groups.split_last().expect("a group");
            assert!(others.iter().all(|group| group.len() % WHOLE_TILES == 0));
            assert!(last.len() <= groups[0].len());
        }
        // Without need for several groups there is one, and small ones are even.
        for bytes in [127 * size.row_bytes(), usize::MAX] {
            assert_eq!(groups(size, 0..100, bytes).next(), Some(0..100));
        }
        let lengths: Vec<_> = groups(size, 0..100, 40 * size.row_bytes())
            .map(|group| group.len())
            .collect();
        assert_eq!(lengths, [34, 34, 32]);
    }

    #[test]
    fn the_last_possible_row_is_in_a_group() {
        let size = ImageSize::of_sides(1, u32::MAX);
        let last = groups(size, u32::MAX - 5..u32::MAX, 6).last();
        assert_eq!(last.map(|group| group.end), Some(u32::MAX));
        assert_eq!(
            offset(size, u32::MAX - 1),
            20 + 3 * (u64::from(u32::MAX) - 1)
        );
    }
}
