//! The mapped PPM: reserve, map, publish.

use std::{fs::File, io, path::Path};

use crate::camera::ImageSize;

/// The header of a binary PPM of this size.
#[must_use]
pub fn header(size: ImageSize) -> String {
    format!("P6\n{} {}\n255\n", size.width(), size.height())
}

/// An image file being drawn through a memory map.
#[derive(Debug)]
pub struct MappedImage {
    map: memmap2::MmapMut,
    header: usize,
    file: tempfile::NamedTempFile,
    target: std::path::PathBuf,
}

impl MappedImage {
    /// Reserves the blocks of an image that is to appear at `target`.
    ///
    /// # Errors
    ///
    /// If the file can't be made, reserved or mapped.
    pub fn create(target: &Path, size: ImageSize) -> io::Result<Self> {
        let folder = target
            .parent()
            .filter(|p| !p.as_os_str().is_empty())
            .unwrap_or(Path::new("."));
        let file = tempfile::NamedTempFile::new_in(folder)?;
        let header = header(size);
        let bytes = header.len() + size.pixel_bytes();
        rustix::fs::fallocate(
            file.as_file(),
            rustix::fs::FallocateFlags::empty(),
            0,
            bytes as u64,
        )?;
        let mut map = map(file.as_file())?;
        map[..header.len()].copy_from_slice(header.as_bytes());
        Ok(Self {
            map,
            header: header.len(),
            file,
            target: target.to_owned(),
        })
    }

    /// The pixels, 3 bytes each, rows from the top.
    pub fn pixels_mut(&mut self) -> &mut [u8] {
        &mut self.map[self.header..]
    }

    /// Makes the finished image appear under its name, in one step.
    ///
    /// # Errors
    ///
    /// If the file can't be renamed.
    pub fn publish(self) -> io::Result<()> {
        self.file.persist(&self.target)?;
        Ok(())
    }
}

#[expect(unsafe_code, reason = "a mapped image is what this module is for")]
fn map(file: &File) -> io::Result<memmap2::MmapMut> {
    // SAFETY: temporary file of our own; only another process that truncates it could fault the map.
    unsafe { memmap2::MmapMut::map_mut(file) }
}
