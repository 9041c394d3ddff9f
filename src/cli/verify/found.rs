//! The picture that is judged.

use std::{
    fs::File,
    io::{self, BufReader, Read},
    path::Path,
};

use sfera::{camera::ImageSize, ppm::Picture};

use crate::cli::{Failure, STANDARD_INPUT};

/// A picture that gives its rows from the top.
pub(super) enum Found {
    File(Picture<BufReader<File>>),
    Stream(Picture<BufReader<Box<dyn Read>>>),
}

impl Found {
    /// Opens a file, a pipe, or standard input for `-`, and goes to `row`.
    pub(super) fn open(path: &Path, size: ImageSize, row: u32) -> Result<Self, Failure> {
        if path != Path::new("-") {
            return Ok(Self::File(Picture::open(path, size, row)?));
        }
        let stdin: Box<dyn Read> = Box::new(io::stdin());
        let mut picture = Picture::new(BufReader::new(stdin), STANDARD_INPUT.as_ref(), size)?;
        picture.pass_over(row)?;
        Ok(Self::Stream(picture))
    }

    pub(super) fn read(&mut self, pixels: &mut [u8]) -> Result<(), Failure> {
        Ok(match self {
            Self::File(picture) => picture.read(pixels),
            Self::Stream(picture) => picture.read(pixels),
        }?)
    }

    /// That nothing follows the last row.
    pub(super) fn finish(self) -> Result<(), Failure> {
        Ok(match self {
            Self::File(picture) => picture.finish(),
            Self::Stream(picture) => picture.finish(),
        }?)
    }
}
