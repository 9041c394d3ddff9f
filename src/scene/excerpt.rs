//! Pieces of the text as messages show them: printable, and never long.

use crate::name::printable;

/// A piece of a line in printable text, and the number of characters before the place
/// that it is shown for.
#[derive(Debug)]
pub(super) struct Excerpt {
    pub(super) text: String,
    pub(super) caret: usize,
}

impl Excerpt {
    /// How many bytes of a line are shown at most. With the margin they fit in a terminal.
    pub(super) const REACH: usize = 72;

    /// The line around a place: `before` and `after` are the bytes of the line
    /// on either side, at least one more than [`REACH`](Self::REACH) of them if
    /// there are so many.
    pub(super) fn new(before: &[u8], after: &[u8]) -> Self {
        /// Bytes after the place that are shown rather than those before it.
        const AHEAD: usize = Excerpt::REACH / 3;
        const ELLIPSIS: &str = "...";
        // A longer line may be cut here: then a carriage return does not end it.
        let after = match after.strip_suffix(b"\r") {
            Some(line) if after.len() <= Self::REACH => line,
            _ => after,
        };
        let shown_before = before.len().min(Self::REACH - after.len().min(AHEAD));
        let shown_after = after.len().min(Self::REACH - shown_before);

        let mut text = String::new();
        if shown_before < before.len() {
            text.push_str(ELLIPSIS);
        }
        text.push_str(&printable(&before[before.len() - shown_before..]));
        let caret = text.chars().count();
        if shown_after < after.len() {
            text.push_str(&printable(without_broken_end(&after[..shown_after])));
            text.push_str(ELLIPSIS);
        } else {
            text.push_str(&printable(after.trim_ascii_end()));
        }
        Self { text, caret }
    }
}

/// Removes the beginning of a character whose rest is cut off.
fn without_broken_end(bytes: &[u8]) -> &[u8] {
    match str::from_utf8(bytes) {
        Err(error) if error.error_len().is_none() => &bytes[..error.valid_up_to()],
        _ => bytes,
    }
}

/// How many bytes of a word a message quotes at most.
pub(super) const LONGEST_QUOTE: usize = 40;

/// A word in quotes, shortened if it is long.
pub(super) fn quoted(word: &[u8]) -> String {
    if word.len() > LONGEST_QUOTE {
        format!("{}, {} bytes", quoted_beginning(word), word.len())
    } else {
        format!("\"{}\"", printable(word))
    }
}

/// The beginning of a long word in quotes.
pub(super) fn quoted_beginning(word: &[u8]) -> String {
    let begin = &word[..word.len().min(LONGEST_QUOTE)];
    format!("\"{}...\"", printable(without_broken_end(begin)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The excerpt as it is shown, with a caret before the place.
    fn shown(before: &str, after: &str) -> String {
        let Excerpt { mut text, caret } = Excerpt::new(before.as_bytes(), after.as_bytes());
        let place = text
            .char_indices()
            .nth(caret)
            .map_or(text.len(), |(at, _)| at);
        text.insert(place, '^');
        text
    }

    #[test]
    fn a_line_that_fits_is_shown_whole() {
        assert_eq!(shown("S 1 ", "x 2 "), "S 1 ^x 2");
        assert_eq!(shown("\tS\x0b", "x\r"), " S\\x0b^x");
        assert_eq!(shown("", ""), "^");
    }

    #[test]
    fn a_long_line_is_cut_on_either_side() {
        let long = "0123456789".repeat(20);
        let message = shown(&long, &long);
        assert!(message.starts_with("...23456789"), "{message}");
        assert!(
            message.ends_with("0123456789^012345678901234567890123..."),
            "{message}"
        );
        assert_eq!(message.len(), Excerpt::REACH + "...^...".len());
        // A character that the cut would split is left out.
        assert!(
            shown(&long, &"\u{20ac}".repeat(30))
                .ends_with("9^\u{20ac}\u{20ac}\u{20ac}\u{20ac}\u{20ac}\u{20ac}\u{20ac}\u{20ac}...")
        );
        assert!(
            shown(&long, &format!("0{}", "\u{20ac}".repeat(30)))
                .ends_with("^0\u{20ac}\u{20ac}\u{20ac}\u{20ac}\u{20ac}\u{20ac}\u{20ac}...")
        );
    }

    #[test]
    fn bytes_that_are_no_text_hide_nothing_behind_them() {
        let long = [b"\xff".as_slice(), &b"0123456789".repeat(20)].concat();
        let Excerpt { text, .. } = Excerpt::new(b"", &long);
        assert!(text.contains("0123456789"), "{text}");
    }

    #[test]
    fn a_quotation_is_short_and_says_how_long_the_word_is() {
        assert_eq!(quoted(b"a\0b"), "\"a\\x00b\"");
        assert_eq!(quoted(&[b'x'; 40]), format!("\"{}\"", "x".repeat(40)));
        assert_eq!(
            quoted(&[b'x'; 41]),
            format!("\"{}...\", 41 bytes", "x".repeat(40))
        );
    }
}
