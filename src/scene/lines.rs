//! Where in its text a sphere stands.

use std::io::{self, BufRead};

use super::number::is_blank;

/// The lines, from 1, on which some spheres of a scene begin; `spheres` are their
/// places in the file, in rising order. A sphere that is not there has none.
///
/// The text is read again for that: a scene does not remember its lines.
///
/// ```
/// let text = b"VP 1 1 1\nBG 0 0 0\nOBJ_N 2 # S\nS 0 0 5 1 1 1 1\nS 0 0 9 1 2 2 2\n";
/// let lines = sfera::scene::lines_of_spheres(&mut text.as_slice(), &[1, 7])?;
/// assert_eq!(lines, [Some(5), None]);
/// # Ok::<(), std::io::Error>(())
/// ```
///
/// # Errors
///
/// If the text can't be read.
pub fn lines_of_spheres(
    text: &mut impl BufRead,
    spheres: &[usize],
) -> io::Result<Vec<Option<u64>>> {
    let mut lines = Vec::with_capacity(spheres.len());
    let mut place = Place::default();
    let mut found = 0;
    while lines.len() < spheres.len() {
        let bytes = text.fill_buf()?;
        if bytes.is_empty() {
            break;
        }
        for &byte in bytes {
            let line = place.line;
            if !place.take(byte) {
                continue;
            }
            if spheres.get(lines.len()) == Some(&found) {
                lines.push(Some(line));
            }
            found += 1;
        }
        let length = bytes.len();
        text.consume(length);
    }
    lines.resize(spheres.len(), None);
    Ok(lines)
}

/// A place in the text of a scene.
struct Place {
    line: u64,
    in_comment: bool,
    /// Bytes of the word so far, and whether they are an S.
    length: usize,
    is_s: bool,
}

impl Default for Place {
    fn default() -> Self {
        Self {
            line: 1,
            in_comment: false,
            length: 0,
            is_s: false,
        }
    }
}

impl Place {
    /// Goes on by a byte, and says whether it ends the word S.
    fn take(&mut self, byte: u8) -> bool {
        let ends_sphere_word = !self.in_comment && self.length == 1 && self.is_s;
        if byte == b'\n' {
            self.line += 1;
            self.in_comment = false;
        }
        if self.in_comment || is_blank(byte) || byte == b'#' {
            self.in_comment |= byte == b'#';
            self.length = 0;
            return ends_sphere_word;
        }
        self.is_s = self.length == 0 && byte == b'S';
        self.length += 1;
        false
    }
}
