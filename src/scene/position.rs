//! Lines and columns.

use super::{
    error::Place,
    excerpt::Excerpt,
    text::{count, last_word_end, line_start},
    windows::Window,
};

/// Where a window begins in the text, and where the last word before it ends.
pub(super) struct Position {
    /// From 1; lines end in line feeds.
    line: u64,
    /// From 1, in bytes.
    column: u64,
    last_word: Option<Place>,
    /// Whether there is no text before the window.
    is_at_start: bool,
}

impl Position {
    pub(super) const START: Self = Self {
        line: 1,
        column: 1,
        last_word: None,
        is_at_start: true,
    };

    /// Moves to the end of a window, in which there are so many line feeds.
    pub(super) fn step_over(&mut self, window: &Window, line_feeds: u64, begins_in_comment: bool) {
        let text = window.text();
        self.is_at_start &= text.is_empty();
        if let Some(end) = last_word_end(text, begins_in_comment) {
            let line_feeds_after = count(&text[end..], b'\n');
            let before = line_before(&window.bytes[..window.begin + end]);
            self.last_word = Some(Place {
                line: self.line + line_feeds - line_feeds_after,
                column: self.column_after(&text[..end]),
                excerpt: Some(Excerpt::new(before, &[])),
            });
        }
        self.column = self.column_after(text);
        self.line += line_feeds;
    }

    /// The column behind a text that begins here.
    fn column_after(&self, text: &[u8]) -> u64 {
        match line_start(text) {
            0 => self.column + text.len() as u64,
            start => (text.len() - start) as u64 + 1,
        }
    }

    /// The place at `window.bytes[at]`, in a window that begins here, with the line that
    /// goes on with `line` there.
    pub(super) fn place(&self, window: &Window, at: usize, line: &[u8]) -> Place {
        let text = &window.bytes[window.begin..at];
        let before = line_before(&window.bytes[..at]);
        Place {
            line: self.line + count(text, b'\n'),
            column: self.column_after(text),
            excerpt: Some(Excerpt::new(before, line)),
        }
    }

    /// Whether there is no word before the window.
    pub(super) fn is_blank(&self) -> bool {
        self.last_word.is_none()
    }

    /// Whether there is nothing before the window.
    pub(super) fn is_empty(&self) -> bool {
        self.is_at_start
    }

    /// The end of the last word, or the beginning of the text.
    pub(super) fn end_of_last_word(self) -> Place {
        self.last_word.unwrap_or(Place {
            line: 1,
            column: 1,
            excerpt: None,
        })
    }
}

/// The line that a text ends in, or its last bytes if it is long.
fn line_before(text: &[u8]) -> &[u8] {
    let near = &text[text.len().saturating_sub(Excerpt::REACH + 1)..];
    &near[line_start(near)..]
}
