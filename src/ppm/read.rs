//! Reads an existing picture from the top, whichever program wrote it.

use std::{
    fs::File,
    io::{self, BufRead, BufReader, Read},
    ops::Range,
    path::{Path, PathBuf},
};

use super::{
    errors::{ImageError, OPEN, READ, refused},
    format::groups,
    stream::BUFFER_BYTES,
};
use crate::camera::ImageSize;

/// Splits `rows` into groups that are large enough to be read and drawn at a time, and
/// take little memory.
pub fn row_groups(size: ImageSize, rows: Range<u32>) -> impl Iterator<Item = Range<u32>> {
    groups(size, rows, BUFFER_BYTES)
}

/// The pixels of a binary PPM, from a file or a stream.
///
/// The header may have any form that the format allows: white space and comments between
/// its numbers, on one line or several, with any line ends.
///
/// ```
/// use sfera::{camera::ImageSize, ppm::Picture};
///
/// let stream = b"P6 # by hand\r\n2 1 255 \t\t\t\t\t\t".as_slice();
/// let mut picture = Picture::new(stream, "a string", ImageSize::new(2, 1)?)?;
/// let mut pixels = [0; 6];
/// picture.read(&mut pixels)?;
/// picture.finish()?;
/// assert_eq!(pixels, [9; 6]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Picture<R> {
    source: R,
    path: PathBuf,
    size: ImageSize,
    /// Bytes of pixels that have been read or skipped.
    taken: u64,
}

impl Picture<BufReader<File>> {
    /// Opens the picture of this size at `path`, which may be a pipe, and skips to `row`.
    ///
    /// # Errors
    ///
    /// If it can't be read or is not a binary PPM of this size.
    pub fn open(path: impl AsRef<Path>, size: ImageSize, row: u32) -> Result<Self, ImageError> {
        let path = path.as_ref();
        let file = File::open(path).map_err(refused(path, OPEN))?;
        let metadata = file.metadata().map_err(refused(path, "ask its size"))?;
        if metadata.is_dir() {
            let path = path.to_owned();
            return Err(ImageError::Directory { path });
        }
        let length = metadata.is_file().then_some(metadata.len());
        let mut picture = Self::of_length(BufReader::new(file), path, size, length)?;
        let before = u64::from(row) * size.row_bytes() as u64;
        // Where seeking is impossible, the rows before are read.
        let sought = length.is_some()
            && i64::try_from(before)
                .is_ok_and(|before| picture.source.seek_relative(before).is_ok());
        if sought {
            picture.taken = before;
        } else {
            picture.skip(row)?;
        }
        Ok(picture)
    }
}

impl<R: BufRead> Picture<R> {
    /// Reads the header of the picture of this size from `source`. Messages call it `name`.
    ///
    /// # Errors
    ///
    /// If it can't be read or is not a binary PPM of this size.
    pub fn new(source: R, name: impl AsRef<Path>, size: ImageSize) -> Result<Self, ImageError> {
        Self::of_length(source, name.as_ref(), size, None)
    }

    fn of_length(
        source: R,
        name: &Path,
        size: ImageSize,
        length: Option<u64>,
    ) -> Result<Self, ImageError> {
        let mut header = Header {
            source,
            path: name,
            taken: 0,
        };
        header.read(size, length)?;
        let Header { source, taken, .. } = header;
        let picture = Self {
            source,
            path: name.to_owned(),
            size,
            taken: 0,
        };
        let expected = size.pixel_bytes() as u64;
        match length.map(|length| length.saturating_sub(taken)) {
            Some(found) if found < expected => Err(picture.short(found)),
            Some(found) if found > expected => Err(picture.long()),
            _ => Ok(picture),
        }
    }

    /// Reads the next pixels.
    ///
    /// # Errors
    ///
    /// If the picture can't be read or ends too early.
    pub fn read(&mut self, pixels: &mut [u8]) -> Result<(), ImageError> {
        let mut filled = 0;
        while filled < pixels.len() {
            match self.source.read(&mut pixels[filled..]) {
                Ok(0) => return Err(self.short(self.taken)),
                Ok(count) => {
                    filled += count;
                    self.taken += count as u64;
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(refused(&self.path, READ)(error)),
            }
        }
        Ok(())
    }

    /// Skips the next rows.
    ///
    /// # Errors
    ///
    /// If the picture can't be read or ends too early.
    pub fn skip(&mut self, rows: u32) -> Result<(), ImageError> {
        let bytes = u64::from(rows) * self.size.row_bytes() as u64;
        let passed = io::copy(&mut self.source.by_ref().take(bytes), &mut io::sink())
            .map_err(refused(&self.path, READ))?;
        self.taken += passed;
        if passed < bytes {
            return Err(self.short(self.taken));
        }
        Ok(())
    }

    /// Checks that the picture ends with its last row, if that has been read.
    ///
    /// # Errors
    ///
    /// If it can't be read, or if more follows.
    pub fn finish(mut self) -> Result<(), ImageError> {
        if self.taken < self.size.pixel_bytes() as u64 {
            return Ok(());
        }
        match peek(&mut self.source).map_err(refused(&self.path, READ))? {
            None => Ok(()),
            Some(_) => Err(self.long()),
        }
    }

    fn short(&self, found: u64) -> ImageError {
        let expected = self.size.pixel_bytes() as u64;
        unlike(
            &self.path,
            format!(
                "this picture ends in row {}: its pixels are {found} bytes instead of {expected}; \
                 write it again",
                found / self.size.row_bytes() as u64
            ),
        )
    }

    fn long(&self) -> ImageError {
        unlike(
            &self.path,
            format!(
                "data follows the {} bytes of the pixels; a picture is written in binary mode (\"wb\"), \
                 where no line feed becomes two bytes, and has 3 bytes a pixel",
                self.size.pixel_bytes()
            ),
        )
    }
}

fn unlike(path: &Path, problem: String) -> ImageError {
    ImageError::Unlike {
        path: path.to_owned(),
        problem,
    }
}

/// The next byte, without consuming it.
fn peek(source: &mut impl BufRead) -> io::Result<Option<u8>> {
    loop {
        match source.fill_buf() {
            Ok(bytes) => return Ok(bytes.first().copied()),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
}

/// A header being read: `P6`, width, height and 255, each followed by white space, the
/// last by exactly one character. A `#` starts a comment to the end of the line; a comment
/// counts as its line end.
struct Header<'a, R> {
    source: R,
    path: &'a Path,
    taken: u64,
}

impl<R: BufRead> Header<'_, R> {
    fn read(&mut self, size: ImageSize, length: Option<u64>) -> Result<(), ImageError> {
        let magic = [self.next()?, self.next()?];
        if magic != [Some(b'P'), Some(b'6')] {
            return Err(unlike(self.path, foreign(magic)));
        }
        let width = self.number("the width")?.0;
        let height = self.number("the height")?.0;
        let (depth, end) = self.number("the greatest value")?;
        if (width, height) != (size.width().into(), size.height().into()) {
            return Err(unlike(
                self.path,
                format!(
                    "this is not a {} x {} picture but one of {width} x {height}; \
                     give that size, or name another picture",
                    size.width(),
                    size.height()
                ),
            ));
        }
        if depth != 255 {
            return Err(unlike(
                self.path,
                format!(
                    "the values of this picture run to {depth} instead of 255; \
                     write it with one byte a channel, or convert it with pnmdepth 255"
                ),
            ));
        }
        // CR and LF are one line end, unless the length of the file says that the LF is
        // the first byte of the pixels.
        let pixels = size.pixel_bytes() as u64;
        let is_pixel = length.is_some_and(|length| length == self.taken + pixels);
        if end == b'\r' && self.peek()? == Some(b'\n') && !is_pixel {
            self.next()?;
        }
        Ok(())
    }

    /// A number and the white space character after it.
    fn number(&mut self, what: &str) -> Result<(u64, u8), ImageError> {
        let mut byte = self.after_comment()?;
        while byte.is_some_and(is_white_space) {
            byte = self.after_comment()?;
        }
        let mut value = 0_u64;
        while let Some(digit) = byte.filter(u8::is_ascii_digit) {
            value = value
                .saturating_mul(10)
                .saturating_add(u64::from(digit - b'0'));
            byte = self.after_comment()?;
        }
        match byte.filter(|&end| is_white_space(end)) {
            Some(end) => Ok((value, end)),
            None => Err(self.broken(what, byte)),
        }
    }

    fn broken(&self, expected: &str, found: Option<u8>) -> ImageError {
        let found = found.map_or_else(
            || "it ends".to_owned(),
            |byte| format!("\"{}\" was found", byte.escape_ascii()),
        );
        unlike(
            self.path,
            format!(
                "{expected} is missing in the header of this picture: {found}; \
                 a header is P6, width, height and 255 with white space between"
            ),
        )
    }

    /// The next byte; for a comment, its line end.
    fn after_comment(&mut self) -> Result<Option<u8>, ImageError> {
        let mut byte = self.next()?;
        if byte == Some(b'#') {
            while !matches!(byte, None | Some(b'\n' | b'\r')) {
                byte = self.next()?;
            }
        }
        Ok(byte)
    }

    fn next(&mut self) -> Result<Option<u8>, ImageError> {
        let byte = self.peek()?;
        if byte.is_some() {
            self.source.consume(1);
            self.taken += 1;
        }
        Ok(byte)
    }

    fn peek(&mut self) -> Result<Option<u8>, ImageError> {
        peek(&mut self.source).map_err(refused(self.path, READ))
    }
}

/// White space as `isspace` of C defines it.
fn is_white_space(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t'..=b'\r')
}

/// The message for a file that begins with these two bytes instead of `P6`.
fn foreign(magic: [Option<u8>; 2]) -> String {
    let (found, remedy) = match &magic.map(Option::unwrap_or_default) {
        _ if magic == [None, None] => ("an empty file", "write the picture again"),
        b"P3" => ("a PPM in text", "convert it with pnmtopnm"),
        b"P1" | b"P2" | b"P4" | b"P5" => ("a picture without colour", "write it as P6, in colour"),
        b"P7" => ("a PAM", "convert it with pamtopnm"),
        b"\x89P" => ("a PNG", "convert it with pngtopnm"),
        b"\xff\xd8" => ("a JPEG, whose colours are not exact", "write a PPM"),
        b"BM" => ("a BMP", "convert it with bmptopnm"),
        b"GI" => ("a GIF", "convert it with giftopnm"),
        b"II" | b"MM" => ("a TIFF", "convert it with tifftopnm"),
        b"VP" => ("a scene", "name the picture second"),
        _ => ("something else", "write the picture as P6"),
    };
    format!("this is {found}, not a binary PPM; {remedy}")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn size(width: u32, height: u32) -> ImageSize {
        ImageSize::new(width, height).expect("a size with pixels")
    }

    /// What is read from a stream and from a file of these bytes.
    fn read(bytes: &[u8], size: ImageSize) -> [Result<Vec<u8>, String>; 2] {
        fn all<R: BufRead>(
            picture: Result<Picture<R>, ImageError>,
            size: ImageSize,
        ) -> Result<Vec<u8>, String> {
            let read = || {
                let mut picture = picture?;
                let mut pixels = vec![0; size.pixel_bytes()];
                picture.read(&mut pixels)?;
                picture.finish()?;
                Ok(pixels)
            };
            read().map_err(|error: ImageError| error.to_string())
        }
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("picture");
        std::fs::write(&path, bytes).expect("a file");
        // A stream that delivers one byte at a time.
        let stream = BufReader::with_capacity(1, bytes);
        [
            all(Picture::new(stream, &path, size), size),
            all(Picture::open(&path, size, 0), size),
        ]
    }

    #[test]
    fn every_form_of_header_is_read() {
        let pixels: Vec<u8> = (0..12).collect();
        for header in [
            "P6\n2 2\n255\n",
            "P6 2 2 255 ",
            "P6\r\n2 2\r\n255\r\n",
            "P6\n# CREATOR: GIMP\n2 2\n255\n",
            "P6 # one\n#two\n 2#three\n \t2 # four\r255\n",
            "P6\n\n   2\n\n2\n\n255\n",
            "P6\x0b2\x0c2\t255\t",
            "P6\n002 2\n0255\n",
            "P6\n2 2\n255#no blank needed\n",
            "P6\n2 2\n255\r",
        ] {
            let bytes = [header.as_bytes(), &pixels].concat();
            for read in read(&bytes, size(2, 2)) {
                assert_eq!(read.as_ref(), Ok(&pixels), "{header:?}");
            }
        }
    }

    /// A first pixel that looks like the end of a line.
    #[test]
    fn the_length_of_a_file_says_where_its_pixels_begin() {
        let pixels = *b"\n\n\n";
        for header in ["P6 1 1 255\r", "P6 1 1 255\n", "P6 1 1 255\r\n"] {
            let [_, file] = read(&[header.as_bytes(), &pixels].concat(), size(1, 1));
            assert_eq!(file, Ok(pixels.to_vec()), "{header:?}");
        }
    }

    #[test]
    fn what_is_not_the_picture_is_refused_with_advice() {
        for (bytes, words) in [
            ("", "an empty file"),
            ("P", "not a binary PPM"),
            ("P3\n1 1\n255\n1 2 3\n", "pnmtopnm"),
            ("P5\n1 1\n255\nx", "without colour"),
            ("\u{89}PNG\r\n", "something else"),
            ("VP 1 1 1", "a scene"),
            (
                "P6\n1 2\n255\nabcabc",
                "not a 1 x 1 picture but one of 1 x 2",
            ),
            (
                "P6\n1 99999999999999999999 255\nabc",
                "18446744073709551615",
            ),
            ("P6\n1 1\n65535\nabcabc", "pnmdepth 255"),
            ("P6\n1 1\n", "the greatest value is missing"),
            ("P6\n1\n", "the height is missing"),
            ("P6\n1 x\n255\nabc", "\"x\" was found"),
            ("P6\n1 1\n255xabc", "\"x\" was found"),
            ("P6\n1 -1\n255\nabc", "\"-\" was found"),
            ("P6\n1 1\n255", "it ends"),
            ("P6\n1 1\n255\nab", "2 bytes instead of 3"),
            ("P6\n1 1\n255\nabcd", "binary mode"),
            (
                "P6\n1 1\n255 # not in a header any more\nabc",
                "binary mode",
            ),
        ] {
            for read in read(bytes.as_bytes(), size(1, 1)) {
                let message = read.expect_err(bytes);
                assert!(message.contains(words), "{bytes:?}: {message}");
            }
        }
    }

    #[test]
    fn what_is_there_instead_is_named_by_its_first_bytes() {
        for (bytes, word) in [
            (b"P1".as_slice(), "without colour"),
            (b"P2", "without colour"),
            (b"P4", "without colour"),
            (b"P7", "a PAM"),
            (b"\x89PNG", "a PNG"),
            (b"\xff\xd8\xff", "a JPEG"),
            (b"BM", "a BMP"),
            (b"GIF89a", "a GIF"),
            (b"II*", "a TIFF"),
            (b"MM", "a TIFF"),
            (b"\0\0", "something else"),
        ] {
            for read in read(bytes, size(1, 1)) {
                let message = read.expect_err("a picture of another kind");
                assert!(message.contains(word), "{bytes:?}: {message}");
            }
        }
    }

    fn assert_rest<R: BufRead>(mut picture: Picture<R>, expected: &[u8]) {
        let mut rest = vec![0; expected.len()];
        picture.read(&mut rest).expect("the other rows");
        assert_eq!(rest, expected);
        let error = picture.read(&mut [0]).expect_err("nothing more");
        let message = error.to_string();
        assert!(message.contains("18 bytes instead of 18"), "{message}");
    }

    #[test]
    fn rows_are_read_from_any_row_on_and_counted() {
        let size = size(2, 3);
        let pixels: Vec<u8> = (0..18).collect();
        let bytes = [b"P6 2 3 255\n".as_slice(), &pixels].concat();
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("picture");
        std::fs::write(&path, &bytes).expect("a file");
        for row in 0..=3 {
            let file = Picture::open(&path, size, row).expect("a picture");
            let mut stream = Picture::new(&bytes[..], &path, size).expect("a picture");
            stream.skip(row).expect("so many rows");
            let from = row as usize * size.row_bytes();
            assert_rest(file, &pixels[from..]);
            assert_rest(stream, &pixels[from..]);
        }
        for length in [bytes.len() - 1, bytes.len() + 1] {
            let mut other = bytes.clone();
            other.resize(length, 0);
            std::fs::write(&path, &other).expect("a file");
            assert!(Picture::open(&path, size, 0).is_err(), "{length} bytes");
        }
        let mut stream = Picture::new(&bytes[..23], &path, size).expect("a picture");
        let message = stream.skip(3).expect_err("two rows").to_string();
        assert!(
            message.contains("ends in row 2: its pixels are 12 bytes instead of 18"),
            "{message}"
        );
    }

    /// A source that is interrupted before every byte, and in the end fails.
    struct Interrupted<'a> {
        bytes: &'a [u8],
        now: bool,
    }

    impl Read for Interrupted<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            self.now = !self.now;
            if self.now {
                return Err(io::ErrorKind::Interrupted.into());
            }
            match self.bytes.split_off_first() {
                Some(&byte) => {
                    buffer[0] = byte;
                    Ok(1)
                }
                None => Err(io::ErrorKind::ConnectionReset.into()),
            }
        }
    }

    #[test]
    fn an_interrupted_source_is_read_on_and_one_that_fails_is_reported() {
        let size = size(1, 2);
        let open = |bytes| {
            let source = Interrupted { bytes, now: false };
            Picture::new(BufReader::with_capacity(1, source), "a pipe", size)
        };
        let mut pixels = [0; 6];
        let mut picture = open(b"P6 1 2 255 abcdef").expect("a header");
        picture.read(&mut pixels).expect("pixels");
        assert_eq!(&pixels, b"abcdef");
        assert!(picture.finish().is_err());

        assert!(open(b"P6 1 2 25").is_err());
        let mut picture = open(b"P6 1 2 255 abcde").expect("a header");
        assert!(picture.read(&mut pixels).is_err());
        let mut picture = open(b"P6 1 2 255 abcde").expect("a header");
        assert!(picture.skip(2).is_err());
    }

    #[test]
    fn groups_of_rows_are_large_but_take_little_memory() {
        let mut small = row_groups(size(200, 300), 1..300);
        assert_eq!((small.next(), small.next()), (Some(1..300), None));
        let size = size(20_000, 1000);
        let large: Vec<_> = row_groups(size, 0..1000).collect();
        assert_eq!(large.first().map(|group| group.start), Some(0));
        assert_eq!(large.last().map(|group| group.end), Some(1000));
        assert!(large.windows(2).all(|pair| pair[0].end == pair[1].start));
        let most = large.iter().map(ExactSizeIterator::len).max();
        let most = most.expect("groups") * size.row_bytes();
        assert!((BUFFER_BYTES / 2..=BUFFER_BYTES).contains(&most), "{most}");
    }

    #[test]
    fn what_follows_the_last_row_is_refused_once_that_is_read() {
        let bytes = b"P6 1 2 255\nabcdefg";
        let size = size(1, 2);
        for rows in 0..=2 {
            let mut picture = Picture::new(&bytes[..], "a string", size).expect("a picture");
            picture.skip(rows).expect("so many rows");
            assert_eq!(picture.finish().is_err(), rows == 2);
        }
    }

    proptest! {
        /// For any bytes, a stream and a file give the same picture or both an error,
        /// except where the first pixel looks like a line end.
        #[test]
        fn any_bytes_are_a_picture_or_a_message(
            bytes in "P6[ #\\n\\t1]{1,4}[ 12]{1,3}\\s[0-9 ]{1,5}#?[a-z\\n \\r]{0,9}",
        ) {
            let [stream, file] = read(bytes.as_bytes(), size(1, 2));
            prop_assert!(stream.is_ok() == file.is_ok() || bytes.contains("\r\n"));
            if let (Ok(stream), Ok(file)) = (&stream, &file) {
                prop_assert!(stream == file || bytes.contains("\r\n"));
            }
        }

        #[test]
        fn no_bytes_cause_a_panic(mut bytes in prop::collection::vec(any::<u8>(), 0..40)) {
            for begin in [b"P6".as_slice(), b"P6 1 2 255", b""] {
                bytes.splice(..bytes.len().min(begin.len()), begin.iter().copied());
                let _ = read(&bytes, size(1, 2));
            }
        }
    }
}
