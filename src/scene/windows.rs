//! The text, read from its source in windows that split no word.

use std::io::{self, Read};

use super::{
    error::SceneError,
    excerpt::Excerpt,
    grammar::SPHERE_LETTER,
    text::{MAX_WORD, ends_word, is_blank},
};

/// How much is read and parsed at a time, in bytes.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// The first window. A shorter scene is read at once.
    pub first: usize,
    /// Each other window, for each thread.
    pub window: usize,
    /// What a thread parses at a time.
    pub chunk: usize,
    /// The smallest window that is parsed by several threads.
    pub parallel: usize,
    /// The smallest piece that is parsed in chunks, not word by word.
    pub fast: usize,
}

impl Sizes {
    /// The fastest, as measured.
    pub const USUAL: Self = Self {
        first: 1 << 14,
        window: 1 << 19,
        chunk: 1 << 15,
        parallel: 1 << 18,
        fast: 1 << 8,
    };
    /// Upper bound of the threads that windows grow for.
    pub(super) const MAX_THREADS: usize = 16;
}

/// What some editors write at the beginning of a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// A piece of the text that begins and ends between two words.
///
/// `bytes` holds some text before it, for messages; then the piece, from `begin` to
/// `end`; then what has been read after it, up to `filled`.
#[derive(Default)]
pub(super) struct Window {
    pub(super) bytes: Vec<u8>,
    pub(super) begin: usize,
    pub(super) end: usize,
    pub(super) filled: usize,
    /// Whether the source ends with this window.
    pub(super) is_last: bool,
}

impl Window {
    /// The first window of a source, without a byte order mark. Lines and columns are
    /// counted from behind the mark.
    pub(super) fn first(source: &mut impl Read, count: usize) -> Result<Self, SceneError> {
        let mut window = Self::default();
        let mark = BYTE_ORDER_MARK.len();
        window.fill(source, count.max(mark))?;
        if window.bytes[..window.filled].starts_with(BYTE_ORDER_MARK) {
            window.bytes.copy_within(mark..window.filled, 0);
            window.filled -= mark;
            window.end = window.end.saturating_sub(mark);
        }
        Ok(window)
    }

    /// The piece.
    pub(super) fn text(&self) -> &[u8] {
        &self.bytes[self.begin..self.end]
    }

    /// Empties this window and begins it with what `before` has read after its end.
    pub(super) fn follow(&mut self, before: &Self) {
        let kept = before.end.saturating_sub(Excerpt::REACH);
        let kept = &before.bytes[kept..before.filled];
        self.make_room(kept.len());
        self.bytes[..kept.len()].copy_from_slice(kept);
        self.filled = kept.len();
        self.begin = kept.len() - before.read_after_end();
        self.end = self.begin;
        self.is_last = false;
    }

    fn make_room(&mut self, bytes: usize) {
        self.bytes.resize(self.bytes.len().max(bytes), 0);
    }

    fn read_after_end(&self) -> usize {
        self.filled - self.end
    }

    /// Reads `count` bytes, or fewer if the source ends, and sets the end of the piece.
    pub(super) fn fill(&mut self, source: &mut impl Read, count: usize) -> Result<(), SceneError> {
        let full = self.filled + count;
        self.make_room(full);
        while self.filled < full {
            match source.read(&mut self.bytes[self.filled..full]) {
                Ok(0) => {
                    self.is_last = true;
                    break;
                }
                Ok(read) => self.filled += read,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(SceneError::unreadable(error)),
            }
        }
        self.end = if self.is_last {
            self.filled
        } else {
            self.begin + cut(&self.bytes[self.begin..self.filled])
        };
        Ok(())
    }

    /// Reads on until a message can show the line that `before` ends in. A failure to
    /// read is ignored: the message then shows less.
    pub(super) fn complete_line(&mut self, before: &Self, source: &mut impl Read) {
        while !self.is_last && self.text_after(before).len() <= Excerpt::REACH {
            if self.fill(source, Excerpt::REACH).is_err() {
                break;
            }
        }
    }

    /// What has been read since the window `before` was filled.
    pub(super) fn text_after(&self, before: &Self) -> &[u8] {
        &self.bytes[self.begin + before.read_after_end()..self.filled]
    }
}

/// Where to end a piece of a text that goes on: where a sphere begins, if possible one
/// that begins a line, or else between two words.
fn cut(text: &[u8]) -> usize {
    /// How far back to look for a sphere.
    const NEAR: usize = 1 << 14;
    let near = text.len() - text.len().min(NEAR);
    let end = &text[near..];
    if let Some(start) = last_sphere_in_line(end).or_else(|| last_sphere(end)) {
        return near + start;
    }
    if let Some(blank) = text.iter().rposition(|&byte| is_blank(byte)) {
        return blank + 1;
    }
    // One word, perhaps with a comment. The parser refuses words longer than this.
    if text.len() > MAX_WORD || text.iter().any(|&byte| ends_word(byte)) {
        return text.len();
    }
    0
}

/// The beginning of the last sphere that begins a line.
fn last_sphere_in_line(text: &[u8]) -> Option<usize> {
    let mut end = text.len();
    while let Some(line_feed) = text[..end].iter().rposition(|&byte| byte == b'\n') {
        if let Some(start) = sphere_in_line(text, line_feed + 1) {
            return Some(start);
        }
        end = line_feed;
    }
    None
}

/// The beginning of the last sphere, wherever it stands in its line. It may be in a comment.
fn last_sphere(text: &[u8]) -> Option<usize> {
    let is_sphere = |word: &[u8]| matches!(word, &[before, SPHERE_LETTER, after] if is_blank(before) && is_blank(after));
    text.windows(3)
        .rposition(is_sphere)
        .map(|before| before + 1)
}

/// The beginning of the first sphere at or after `from` that begins a line.
pub(super) fn next_sphere_in_line(text: &[u8], mut from: usize) -> Option<usize> {
    while let Some(length) = text.get(from..)?.iter().position(|&byte| byte == b'\n') {
        from += length + 1;
        if let Some(start) = sphere_in_line(text, from) {
            return Some(start);
        }
    }
    None
}

/// The beginning of the sphere that begins the line at `at`, if one does.
fn sphere_in_line(text: &[u8], at: usize) -> Option<usize> {
    let line = &text[at..];
    let indent = line
        .iter()
        .position(|&byte| byte == b'\n' || !is_blank(byte))?;
    (line[indent] == SPHERE_LETTER && is_blank(*line.get(indent + 1)?)).then_some(at + indent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piece_ends_before_a_sphere_or_between_words() {
        for (text, end) in [
            ("S 1 2\n S 3", "S 1 2\n "),
            ("S 1 2\nS", "S 1 2\n"),
            ("S 1\nS 2\n3 4", "S 1\n"),
            ("S 1 2 S 3 4 S", "S 1 2 "),
            ("S 1\nx S 2", "S 1\nx "),
            ("S 1\nS 2 # S 3", "S 1\n"),
            ("S 1\n\t S 2 # S 3\n", "S 1\n\t "),
            ("S 1\n\nS 2", "S 1\n\n"),
            ("S 1\nxS 2", "S 1\nxS "),
            ("VP 1.2", "VP "),
            ("VP ", "VP "),
            ("word", ""),
            ("word#comment", "word#comment"),
            ("", ""),
        ] {
            assert_eq!(&text[..cut(text.as_bytes())], end, "{text:?}");
        }
        let long = |length| vec![b'x'; length];
        assert_eq!(cut(&long(MAX_WORD)), 0);
        assert_eq!(cut(&long(MAX_WORD + 1)), MAX_WORD + 1);
    }

    #[test]
    fn windows_hold_the_whole_text_once() {
        let text = "\u{feff}VP 1 1 1 BG 0 0 0 OBJ_N 2\nS 0 0 5 1 9 9 9\nS 0 0 6 1 9 9 9 # end";
        let source = &mut text.as_bytes();
        let mut window = Window::first(source, 5).expect("text");
        let mut read = window.text().to_vec();
        let mut next = Window::default();
        while !window.is_last {
            next.follow(&window);
            next.fill(source, 7).expect("text");
            std::mem::swap(&mut window, &mut next);
            assert!(read.ends_with(&window.bytes[..window.begin]));
            read.extend_from_slice(window.text());
        }
        assert_eq!(read, text.trim_start_matches('\u{feff}').as_bytes());
    }

    /// However long the text is, a window holds what was asked for, and before it what the
    /// window before did not end with and what messages may need.
    #[test]
    fn windows_stay_small() {
        const ASKED: usize = 100;
        let sphere = "S 0 0 5 1 9 9 9\n";
        let text = sphere.repeat(1000);
        let source = &mut text.as_bytes();
        let mut window = Window::first(source, ASKED).expect("text");
        let mut next = Window::default();
        while !window.is_last {
            next.follow(&window);
            next.fill(source, ASKED).expect("text");
            std::mem::swap(&mut window, &mut next);
            let most = Excerpt::REACH + sphere.len() + ASKED;
            assert!(window.bytes.len() <= most, "{}", window.bytes.len());
        }
    }

    #[test]
    fn a_source_that_fails_is_unreadable() {
        struct Failing;
        impl Read for Failing {
            fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
                Err(io::ErrorKind::Other.into())
            }
        }
        let Err(error) = Window::first(&mut Failing, 10) else {
            panic!("text from nowhere");
        };
        assert!(error.to_string().contains("can't read the scene"));
    }
}
