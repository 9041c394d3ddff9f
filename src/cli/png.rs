//! PNG, for images whose names end in `.png`.

use std::{
    fs::File,
    io::{self, BufReader, Write},
    ops::Range,
    path::{Path, PathBuf},
};

use png::{
    BitDepth, ColorType, Compression, Decoder, DecodingError, EncodingError, Transformations,
};
use sfera::{
    camera::{BYTES_PER_PIXEL, ImageSize},
    name::shown,
    ppm,
};

use super::failure::Failure;

/// The ending of a name, in lower case.
pub(crate) fn ending(path: &Path) -> Option<String> {
    let ending = path.extension()?.to_str()?;
    Some(ending.to_ascii_lowercase())
}

pub(crate) fn is_name_of_png(path: &Path) -> bool {
    ending(path).is_some_and(|ending| ending == "png")
}

/// The greatest width and height that the format can express.
pub(crate) const LONGEST_SIDE: u32 = i32::MAX as u32;

/// The first bytes of every PNG.
pub(crate) const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Writes a whole image, a group of rows at a time.
pub(crate) fn write<E: From<io::Error>>(
    stream: impl Write,
    size: ImageSize,
    mut draw: impl FnMut(Range<u32>, &mut [u8]) -> Result<(), E>,
) -> Result<(), E> {
    /// Bytes of a chunk of compressed pixels.
    const CHUNK: usize = 1 << 16;
    let mut encoder = png::Encoder::new(stream, size.width(), size.height());
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    let mut writer = encoder.write_header().map_err(unwritten)?;
    let mut pixels = writer.stream_writer_with_size(CHUNK).map_err(unwritten)?;
    let mut buffer = Vec::new();
    for rows in ppm::row_groups(size, 0..size.height()) {
        buffer.resize(rows.len() * size.row_bytes(), 0);
        draw(rows, &mut buffer)?;
        pixels.write_all(&buffer)?;
    }
    pixels.finish().map_err(unwritten)?;
    Ok(writer.finish().map_err(unwritten)?)
}

fn unwritten(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        error => io::Error::other(error),
    }
}

/// Reads a PNG row by row from the top, as red, green and blue.
pub(crate) struct Picture {
    reader: png::Reader<BufReader<File>>,
    path: PathBuf,
    row: Vec<u8>,
    colour: ColorType,
    size: ImageSize,
    left: u32,
}

impl Picture {
    /// Opens the picture of this size and skips to `row`.
    pub(crate) fn open(path: &Path, size: ImageSize, row: u32) -> Result<Self, Failure> {
        let failure = |what: String| Failure::Message(format!("{}: {what}", shown(path)));
        let file = File::open(path).map_err(|error| failure(format!("can't open it: {error}")))?;
        let mut decoder = Decoder::new(BufReader::new(file));
        decoder.set_transformations(Transformations::EXPAND);
        let reader = decoder.read_info().map_err(|error| broken(path, &error))?;
        let info = reader.info();
        let found = (info.width, info.height);
        if found != (size.width(), size.height()) {
            return Err(failure(format!(
                "this is not a {} x {} picture but one of {} x {}; give that size, or name another picture",
                size.width(),
                size.height(),
                found.0,
                found.1
            )));
        }
        let (colour, depth) = reader.output_color_type();
        if info.interlaced || depth != BitDepth::Eight || info.is_animated() {
            return Err(failure(
                "this PNG is interlaced, animated or of 16 bits a channel; write it plainly, with 8 bits".to_owned(),
            ));
        }
        let row_bytes = reader.output_line_size(size.width());
        let mut picture = Self {
            row: vec![0; row_bytes.unwrap_or_default()],
            reader,
            path: path.to_owned(),
            colour,
            size,
            left: size.height(),
        };
        for _ in 0..row {
            picture.next_row()?;
        }
        Ok(picture)
    }

    fn next_row(&mut self) -> Result<(), Failure> {
        match self.reader.read_row(&mut self.row) {
            Ok(Some(_)) => {
                self.left -= 1;
                Ok(())
            }
            Ok(None) => Err(Failure::Message(format!(
                "{}: this picture ends too early; write it again",
                shown(&self.path)
            ))),
            Err(error) => Err(broken(&self.path, &error)),
        }
    }

    /// Reads the pixels of the next rows.
    pub(crate) fn read(&mut self, pixels: &mut [u8]) -> Result<(), Failure> {
        for row in pixels.chunks_exact_mut(self.size.row_bytes()) {
            self.next_row()?;
            let channels = self.colour.samples();
            let (row, _) = row.as_chunks_mut::<BYTES_PER_PIXEL>();
            for (pixel, found) in row.iter_mut().zip(self.row.chunks_exact(channels)) {
                let opaque = match *found {
                    [red, green, blue, ref opacity @ ..] if channels >= BYTES_PER_PIXEL => {
                        *pixel = [red, green, blue];
                        opacity
                    }
                    [grey, ref opacity @ ..] => {
                        *pixel = [grey; BYTES_PER_PIXEL];
                        opacity
                    }
                    [] => &[],
                };
                if opaque.first().is_some_and(|&opacity| opacity != 255) {
                    return Err(Failure::Message(format!(
                        "{}: this picture is transparent; write it without an alpha channel",
                        shown(&self.path)
                    )));
                }
            }
        }
        Ok(())
    }

    /// Checks that the picture is complete, if all of it was read.
    pub(crate) fn finish(mut self) -> Result<(), Failure> {
        if self.left > 0 {
            return Ok(());
        }
        self.reader
            .finish()
            .map_err(|error| broken(&self.path, &error))
    }
}

fn broken(path: &Path, error: &DecodingError) -> Failure {
    Failure::Message(format!(
        "{}: this PNG can't be read: {error}; write it again",
        shown(path)
    ))
}
