//! The picture that is judged.

use std::{
    fs::{self, File, OpenOptions},
    io::{self, BufReader, Read},
    path::Path,
};

use sfera::{camera::ImageSize, ppm::Picture};

use crate::cli::{
    failure::{Failure, STANDARD_INPUT, read_failed},
    output::open_waiting,
    png, system,
};

/// A picture that is read row by row from the top.
pub(super) enum Found {
    File(Picture<BufReader<File>>),
    Stream(Picture<BufReader<Box<dyn Read>>>),
    Png(Box<png::Picture>),
}

impl Found {
    /// Opens a file, a pipe, or standard input for `-`, and skips to `row`.
    pub(super) fn open(path: &Path, size: ImageSize, row: u32) -> Result<Self, Failure> {
        if system::is_pipe(path) {
            let file = open_waiting(path, OpenOptions::new().read(true), "write it")
                .map_err(|error| read_failed(path, error))?;
            return Self::stream(Box::new(file), path, size, row);
        }
        if path != Path::new("-") {
            if is_png(path) {
                return Ok(Self::Png(Box::new(png::Picture::open(path, size, row)?)));
            }
            return Ok(Self::File(Picture::open(path, size, row)?));
        }
        Self::stream(Box::new(io::stdin()), STANDARD_INPUT.as_ref(), size, row)
    }

    fn stream(
        stream: Box<dyn Read>,
        name: &Path,
        size: ImageSize,
        row: u32,
    ) -> Result<Self, Failure> {
        let mut picture = Picture::new(BufReader::new(stream), name, size)?;
        picture.skip(row)?;
        Ok(Self::Stream(picture))
    }

    pub(super) fn read(&mut self, pixels: &mut [u8]) -> Result<(), Failure> {
        match self {
            Self::File(picture) => picture.read(pixels)?,
            Self::Stream(picture) => picture.read(pixels)?,
            Self::Png(picture) => picture.read(pixels)?,
        }
        Ok(())
    }

    /// Checks that nothing follows the last row.
    pub(super) fn finish(self) -> Result<(), Failure> {
        match self {
            Self::File(picture) => picture.finish()?,
            Self::Stream(picture) => picture.finish()?,
            Self::Png(picture) => picture.finish()?,
        }
        Ok(())
    }
}

/// Whether a file, whatever its name, is a PNG. Nothing is read from a pipe.
fn is_png(path: &Path) -> bool {
    let mut begin = [0; png::SIGNATURE.len()];
    fs::metadata(path).is_ok_and(|metadata| metadata.is_file())
        && File::open(path).is_ok_and(|mut file| file.read_exact(&mut begin).is_ok())
        && begin == png::SIGNATURE
}
