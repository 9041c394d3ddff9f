//! The lines on which spheres begin.

use std::io::{self, BufRead};

use super::{grammar::SPHERE_LETTER, text::Gap};

/// The lines, from 1, on which some spheres of a scene begin. `spheres` are their indices
/// in the file, in rising order. A sphere that the file does not have has no line.
///
/// A scene does not hold its lines: the text is read again for them.
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
    let mut follower = Follower::default();
    let mut found = 0;
    while lines.len() < spheres.len() {
        let bytes = text.fill_buf()?;
        if bytes.is_empty() {
            break;
        }
        for &byte in bytes {
            let line = follower.line_feeds + 1;
            if !follower.take(byte) {
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

/// Follows a text byte by byte.
#[derive(Default)]
struct Follower {
    line_feeds: u64,
    gap: Gap,
    /// Bytes of the word so far, and the first of them.
    length: usize,
    first: u8,
}

impl Follower {
    /// Takes the next byte, and returns whether it ends the word that begins a sphere.
    fn take(&mut self, byte: u8) -> bool {
        self.line_feeds += u64::from(byte == b'\n');
        if self.gap.takes(byte) {
            let ends_word = self.length == 1 && self.first == SPHERE_LETTER;
            self.length = 0;
            return ends_word;
        }
        if self.length == 0 {
            self.first = byte;
        }
        self.length += 1;
        false
    }
}

#[cfg(test)]
mod tests {
    use std::io::BufReader;

    use super::*;

    #[test]
    fn spheres_are_on_the_lines_of_their_letters() {
        let text = b"VP 1 1 1 # S\nBG 0 0 0\nOBJ_N 3\n\n  S 0 0 5 1 1 1 1 S#S\n0 SS xS Sx\nS\tS\nS";
        let expected = [Some(5), Some(5), Some(7), Some(7), None, None];
        for capacity in [1, 7, 1000] {
            let lines = |spheres: &[usize]| {
                let mut text = BufReader::with_capacity(capacity, &text[..]);
                lines_of_spheres(&mut text, spheres).expect("text in memory")
            };
            assert_eq!(lines(&[0, 1, 2, 3, 4, 9]), expected);
            assert_eq!(lines(&[1, 3, 4]), [expected[1], expected[3], None]);
            assert_eq!(lines(&[]), []);
        }
    }

    #[test]
    fn text_behind_the_last_of_the_spheres_is_not_read() {
        let mut text = BufReader::with_capacity(4, &b"S 1\nS 2\nS 3\n"[..]);
        let lines = lines_of_spheres(&mut text, &[0]).expect("text in memory");
        assert_eq!(lines, [Some(1)]);
        assert_eq!(text.buffer(), b"");
        assert_eq!(text.get_ref(), b"S 2\nS 3\n");
    }
}
