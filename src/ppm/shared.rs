//! An image of which some rows are drawn in place.

use std::{
    fs::{File, OpenOptions, TryLockError},
    io,
    ops::Range,
    path::Path,
    thread,
    time::{Duration, Instant},
};

use super::{
    draft::Draft,
    errors::{ImageError, OPEN, RESERVE, WRITE, refused},
    format::{check_picture, file_bytes, header},
    rows::Rows,
    system,
    target::{folder_of, follow, may_replace},
};
use crate::camera::ImageSize;

/// An image of which some rows are drawn in place, by any number of processes
/// in any order.
///
/// ```
/// use sfera::{camera::ImageSize, ppm::{Picture, SharedImage}};
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("halves.ppm");
/// let size = ImageSize::new(2, 2)?;
/// for (rows, colour) in [(1..2, 30), (0..1, 10)] {
///     SharedImage::open(&path, size)?.draw(rows, |_, pixels| pixels.fill(colour))?;
/// }
/// let mut pixels = [0; 12];
/// Picture::open(&path, size, 0)?.read(&mut pixels)?;
/// assert_eq!(pixels, [10, 10, 10, 10, 10, 10, 30, 30, 30, 30, 30, 30]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct SharedImage {
    rows: Rows,
}

impl SharedImage {
    /// Opens the picture of this size at `path`; makes and reserves a black one
    /// where there is none. Of several processes that find none, one makes it.
    ///
    /// # Errors
    ///
    /// If there is something else at `path`, or no room.
    pub fn open(path: &Path, size: ImageSize) -> Result<Self, ImageError> {
        let target = follow(path)?;
        may_replace(&target)?;
        let open = || OpenOptions::new().read(true).write(true).open(&target);
        let opened = match open() {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Self::make(&target, size)?;
                open()
            }
            opened => opened,
        };
        let file = opened.map_err(refused(&target, OPEN))?;
        check_picture(&file, &target, size)?;
        // It may have come from elsewhere and have holes.
        system::fill_holes(&file, file_bytes(size)).map_err(refused(&target, RESERVE))?;
        let mapped = system::shares_pages(&file);
        Ok(Self {
            rows: Rows {
                file,
                path: target,
                size,
                mapped,
                whole: false,
            },
        })
    }

    /// Makes a black picture appear whole at `path`, unless something else
    /// does meanwhile.
    fn make(path: &Path, size: ImageSize) -> Result<(), ImageError> {
        let _turn = turn_to_make(path);
        if path.exists() {
            return Ok(());
        }
        let (file, draft) = Draft::create(path)?;
        system::reserve(&file, file_bytes(size)).map_err(refused(path, RESERVE))?;
        system::write_at(&file, header(size).as_bytes(), 0).map_err(refused(path, WRITE))?;
        draft.publish_if_absent(&file, path)
    }

    /// Hands `rows` to `draw`, a group at a time, with the bytes of their pixels.
    ///
    /// # Errors
    ///
    /// If the file can't be mapped or written.
    pub fn draw(
        &mut self,
        rows: Range<u32>,
        draw: impl FnMut(Range<u32>, &mut [u8]),
    ) -> Result<(), ImageError> {
        self.rows.draw(rows, draw)
    }
}

/// A lock on the directory while a shared image is made in it, so that many
/// processes that start together don't each reserve a whole picture. It only
/// saves room: without it, or after waiting too long, nothing goes wrong.
fn turn_to_make(path: &Path) -> Option<File> {
    const PATIENCE: Duration = Duration::from_secs(10);
    let folder = File::open(folder_of(path)).ok()?;
    let start = Instant::now();
    loop {
        match folder.try_lock() {
            Ok(()) => return Some(folder),
            Err(TryLockError::WouldBlock) if start.elapsed() < PATIENCE && !path.exists() => {
                thread::sleep(Duration::from_millis(2));
            }
            Err(_) => return None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As on a network file system, where rows are written and not mapped.
    #[test]
    fn written_rows_are_the_bytes_of_mapped_ones() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let size = ImageSize::new(7, 5)?;
        let bytes = [true, false].map(|mapped| {
            let path = folder.path().join(format!("{mapped}.ppm"));
            let mut image = SharedImage::open(&path, size)?;
            image.rows.mapped = mapped;
            image.draw(1..4, |rows, pixels| pixels.fill(rows.start as u8 + 1))?;
            std::fs::read(&path).map_err(refused(&path, "read it"))
        });
        let [mapped, written] = bytes;
        assert_eq!(mapped?, written?);
        Ok(())
    }
}
