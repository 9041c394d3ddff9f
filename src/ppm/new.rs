//! A new image, which appears whole under its name.

use std::{ops::Range, path::Path};

use super::{
    errors::{ImageError, WRITE, refused},
    event::Watch,
    format::header,
    new_file::{Becoming, NewFile},
    rows::Rows,
    system,
};
use crate::camera::ImageSize;

/// A new image: a file without a name until it is complete.
///
/// ```
/// use sfera::{camera::ImageSize, ppm::MappedImage, render::{Method, Renderer}, scene::Scene};
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("ball.ppm");
/// let scene = Scene::parse(b"VP 1 1 1 BG 255 255 255 OBJ_N 1 S 0 0 5 1 200 0 0")?;
/// let size = ImageSize::new(64, 48)?;
/// let renderer = Renderer::new(&scene, size, Method::Exact);
///
/// let mut image = MappedImage::create(&path, size)?;
/// image.draw(|rows, pixels| {
///     renderer.draw(rows, pixels);
/// })?;
/// assert!(!path.exists());
/// image.publish()?;
/// assert!(std::fs::read(&path)?.starts_with(b"P6\n64 48\n255\n"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct MappedImage {
    rows: Rows,
    becoming: Becoming,
}

impl MappedImage {
    /// Reserves the blocks of an image that is to appear at `path`. If `path` is a symbolic
    /// link, its target will be made or replaced.
    ///
    /// # Errors
    ///
    /// If the image can't be made or replaced there, or there is no room.
    pub fn create(path: impl AsRef<Path>, size: ImageSize) -> Result<Self, ImageError> {
        Self::create_watched(path, size, |_| ())
    }

    /// Like [`create`](Self::create), and calls `watch` with each temporary name of the
    /// file. It has one where the file system has no files without a name, or while it
    /// replaces another file.
    ///
    /// # Errors
    ///
    /// If the image can't be made or replaced there, or there is no room.
    pub fn create_watched(
        path: impl AsRef<Path>,
        size: ImageSize,
        watch: Watch,
    ) -> Result<Self, ImageError> {
        let NewFile { file, becoming } = NewFile::create_watched(path, watch)?;
        Ok(Self {
            rows: Rows::reserve(file, &becoming.target.path, size, true)?,
            becoming,
        })
    }

    /// Calls `draw` with each group of rows and the bytes of their pixels, until all are drawn.
    ///
    /// # Errors
    ///
    /// If the file can't be mapped or written.
    pub fn draw(&mut self, mut draw: impl FnMut(Range<u32>, &mut [u8])) -> Result<(), ImageError> {
        self.try_draw(|rows, pixels| {
            draw(rows, pixels);
            Ok(())
        })
    }

    /// Like [`draw`](Self::draw), and ends with the first error of `draw`. The image must
    /// not be published then.
    ///
    /// # Errors
    ///
    /// If the file can't be mapped or written, or `draw` fails.
    pub fn try_draw<E: From<ImageError>>(
        &mut self,
        draw: impl FnMut(Range<u32>, &mut [u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.rows.draw(0..self.rows.size.height(), draw)
    }

    /// Waits until the disk can no longer refuse what was drawn. That takes time only if
    /// it is not a local disk. [`publish`](Self::publish) does so first.
    ///
    /// # Errors
    ///
    /// If the disk refused it.
    pub fn settle(&self) -> Result<(), ImageError> {
        let Rows { file, path, .. } = &self.rows;
        system::settle(file).map_err(refused(path, WRITE))
    }

    /// Makes the image appear under its name, in one step. It replaces an existing file
    /// and takes over its permissions.
    ///
    /// # Errors
    ///
    /// If the file can't be given its name, or something has got that name meanwhile that
    /// must not be replaced. Whatever has the name is left untouched.
    pub fn publish(self) -> Result<(), ImageError> {
        let Rows {
            file, path, size, ..
        } = self.rows;
        // The header comes last: written first, its small page would prevent a huge page
        // at the beginning of the file.
        system::write_at(&file, header(size).as_bytes(), 0).map_err(refused(&path, WRITE))?;
        let becoming = self.becoming;
        NewFile { file, becoming }.publish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ppm::Picture;

    /// On a file system that is not a local one, as `/proc`.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_refusal_at_the_end_is_known_before_the_image_is_published()
    -> Result<(), Box<dyn std::error::Error>> {
        use rustix::fs::{Mode, OFlags, open};
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("image.ppm");
        let mut image = MappedImage::create(&path, ImageSize::new(2, 1)?)?;
        image.settle()?;
        // A file that can't be written, so that none of it can be sent.
        image.rows.file = open("/proc/version", OFlags::PATH, Mode::empty())?.into();
        assert!(image.settle().is_err());
        Ok(())
    }

    /// Windows begin anywhere in the file, not only at the boundaries of pages.
    #[test]
    fn windows_join_without_a_seam() -> Result<(), Box<dyn std::error::Error>> {
        let folder = tempfile::tempdir()?;
        let path = folder.path().join("image.ppm");
        // A window and a piece of another.
        let size = ImageSize::new(8191, 3000)?;
        let mut image = MappedImage::create(&path, size)?;
        let mut windows = 0;
        image.draw(|rows, pixels| {
            windows += 1;
            for (row, bytes) in rows.zip(pixels.chunks_exact_mut(size.row_bytes())) {
                bytes.fill(row as u8);
            }
        })?;
        image.publish()?;
        assert_eq!(windows, 2);
        let mut picture = Picture::open(&path, size, 0)?;
        let mut bytes = vec![0; size.row_bytes()];
        for row in 0..size.height() {
            picture.read(&mut bytes)?;
            assert!(bytes.iter().all(|&byte| byte == row as u8), "row {row}");
        }
        picture.finish()?;
        Ok(())
    }
}
