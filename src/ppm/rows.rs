//! Rows of a file: mapped a window at a time or, where that is not safe, written.

use std::{
    fs::File,
    ops::Range,
    path::{Path, PathBuf},
};

use super::{
    errors::{ImageError, RESERVE, WRITE, refused},
    format::{file_bytes, groups, offset},
    map::map,
    stream::BUFFER_BYTES,
    system,
};
use crate::{camera::ImageSize, pages::HUGE_PAGE};

/// Bytes of a mapping: so many that mapping takes no noticeable time, and few compared
/// with the memory of any machine.
const WINDOW_BYTES: usize = 64 << 20;

/// A file of reserved blocks, and how its rows are written.
#[derive(Debug)]
pub(super) struct Rows {
    pub(super) file: File,
    pub(super) path: PathBuf,
    pub(super) size: ImageSize,
    /// Whether rows are mapped; otherwise they are written.
    pub(super) mapped: bool,
    /// Whether this process draws the whole file, so that bytes around a group of rows
    /// may be mapped with it.
    pub(super) whole: bool,
}

impl Rows {
    /// The rows of a file of this size, after reserving every block of it.
    pub(super) fn reserve(
        file: File,
        path: &Path,
        size: ImageSize,
        whole: bool,
    ) -> Result<Self, ImageError> {
        let mapped = system::reserve(&file, file_bytes(size)).map_err(refused(path, RESERVE))?;
        Ok(Self {
            file,
            path: path.to_owned(),
            size,
            mapped,
            whole,
        })
    }

    pub(super) fn draw<E: From<ImageError>>(
        &self,
        rows: Range<u32>,
        mut draw: impl FnMut(Range<u32>, &mut [u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let height = self.size.height();
        assert!(rows.end <= height, "rows {rows:?} of an image of {height}");
        let mut buffer = Vec::new();
        let bytes = if self.mapped {
            WINDOW_BYTES
        } else {
            BUFFER_BYTES
        };
        for group in groups(self.size, rows, bytes) {
            let start = offset(self.size, group.start);
            let length = group.len() * self.size.row_bytes();
            if self.mapped {
                let window = self.window(start, length);
                let before = (start - window.start) as usize;
                let mut window = map(&self.file, window).map_err(refused(&self.path, "map it"))?;
                draw(group, &mut window[before..before + length])?;
            } else {
                buffer.resize(length, 0);
                draw(group, &mut buffer)?;
                system::write_at(&self.file, &buffer, start).map_err(refused(&self.path, WRITE))?;
            }
        }
        Ok(())
    }

    /// The bytes of the file that are mapped to draw so many from `start` on.
    fn window(&self, start: u64, length: usize) -> Range<u64> {
        let end = start + length as u64;
        if !self.whole {
            return start..end;
        }
        // Where a window ends within a huge page, the kernel faults that page in by small
        // pages, and goes through all of the huge one each time.
        let first = start - start % HUGE_PAGE as u64;
        let last = end.next_multiple_of(HUGE_PAGE as u64);
        first..last.min(file_bytes(self.size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bytes of other processes are not mapped. Those of one's own are in whole huge pages.
    #[test]
    fn a_window_holds_its_rows_and_only_bytes_that_may_be_mapped() -> std::io::Result<()> {
        let size = ImageSize::new(2000, 3000).expect("a size with pixels");
        let huge_page = HUGE_PAGE as u64;
        let mut rows = Rows {
            file: tempfile::tempfile()?,
            path: PathBuf::new(),
            size,
            mapped: true,
            whole: false,
        };
        for first in [0, 1, 500, 2990] {
            let (start, length) = (offset(size, first), 10 * size.row_bytes());
            let end = start + length as u64;
            rows.whole = false;
            assert_eq!(rows.window(start, length), start..end);
            rows.whole = true;
            let window = rows.window(start, length);
            assert_eq!(window.start, start / huge_page * huge_page);
            let last_page = end.div_ceil(huge_page) * huge_page;
            assert_eq!(window.end, last_page.min(file_bytes(size)));
        }
        Ok(())
    }
}
