//! Words, blanks and comments. All rules about them are in this module.

/// Begins a comment, which ends with the line.
pub(super) const COMMENT: u8 = b'#';

/// The longest word that is read, in bytes. No number needs as many, and no word can
/// make the reader hold a whole file.
pub(super) const MAX_WORD: usize = 1 << 16;

/// Whether a byte separates words: the white space of C's `isspace`.
#[inline(always)]
pub(super) const fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t'..=b'\r')
}

/// Whether a word ends before this byte.
#[inline(always)]
pub(super) const fn ends_word(byte: u8) -> bool {
    is_blank(byte) || byte == COMMENT
}

/// The end of the word at `at`.
pub(super) fn word_end(text: &[u8], mut at: usize) -> usize {
    // Eight bytes at a time, as long as all are greater than those that end words.
    while let Some(bytes) = text[at..].first_chunk::<8>()
        && bytes.iter().fold(true, |all, &byte| all & (byte > COMMENT))
    {
        at += bytes.len();
    }
    let length = text[at..].iter().position(|&byte| ends_word(byte));
    length.map_or(text.len(), |length| at + length)
}

/// Distinguishes words from blanks and comments, byte by byte.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gap {
    pub(super) in_comment: bool,
}

impl Gap {
    /// Whether the next byte belongs to a blank or a comment, not to a word.
    #[inline(always)]
    pub(super) fn takes(&mut self, byte: u8) -> bool {
        self.in_comment = (self.in_comment || byte == COMMENT) && byte != b'\n';
        self.in_comment || is_blank(byte)
    }

    /// The beginning of the first word at or after `at`, or the end of the text.
    pub(super) fn skip(&mut self, text: &[u8], mut at: usize) -> usize {
        while let Some(&byte) = text.get(at)
            && self.takes(byte)
        {
            at += 1;
        }
        at
    }
}

/// The end of the last word of a text, if it has one.
pub(super) fn last_word_end(text: &[u8], begins_in_comment: bool) -> Option<usize> {
    let mut end = text.len();
    while end > 0 {
        let start = line_start(&text[..end - 1]);
        let line = &text[start..end];
        let comment = if start == 0 && begins_in_comment {
            0
        } else {
            let comment = line.iter().position(|&byte| byte == COMMENT);
            comment.unwrap_or(line.len())
        };
        let last = line[..comment].iter().rposition(|&byte| !is_blank(byte));
        if let Some(last) = last {
            return Some(start + last + 1);
        }
        end = start;
    }
    None
}

/// The beginning of the line that a text ends in.
pub(super) fn line_start(text: &[u8]) -> usize {
    let line_feed = text.iter().rposition(|&byte| byte == b'\n');
    line_feed.map_or(0, |line_feed| line_feed + 1)
}

/// How often a byte occurs.
pub(super) fn count(text: &[u8], wanted: u8) -> u64 {
    /// The compiler adds whole vectors of single bytes, which hold sums up to 255.
    const RUN: usize = 192;
    text.chunks(RUN)
        .map(|run| {
            let sum: u8 = run.iter().map(|&byte| u8::from(byte == wanted)).sum();
            u64::from(sum)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The words of a text, found with [`Gap`].
    fn words(text: &[u8]) -> Vec<&[u8]> {
        let mut gap = Gap::default();
        let mut words = Vec::new();
        let mut at = gap.skip(text, 0);
        while at < text.len() {
            let end = word_end(text, at);
            words.push(&text[at..end]);
            at = gap.skip(text, end);
        }
        words
    }

    #[test]
    fn blanks_and_comments_separate_words() {
        let text = b" a\tb\x0bc\x0cd\re#f g\n#h #i\r j\nk# l \r\n#\n#";
        let expected: [&[u8]; 6] = [b"a", b"b", b"c", b"d", b"e", b"k"];
        assert_eq!(words(text), expected);
        // Other white space of ASCII and of Unicode is part of a word.
        assert_eq!(words(b"a\x1cb\x85\xa0c").len(), 1);
    }

    #[test]
    fn words_of_any_length_and_bytes_end_before_blanks_and_comments() {
        for byte in 0..=u8::MAX {
            for length in (1..20).filter(|_| !ends_word(byte)) {
                let word = vec![byte; length];
                for behind in ["", "          ", "\nS 1 2 3 4", "##########"] {
                    let text = [&word, behind.as_bytes()].concat();
                    assert_eq!(word_end(&text, 0), length, "{}", text.escape_ascii());
                }
            }
        }
    }

    #[test]
    fn the_last_word_is_found_from_the_end() {
        for text in [
            "",
            " ",
            "\n",
            "#",
            "# a",
            "a",
            "a ",
            " a",
            "a\n\n",
            "a # b",
            "a # b\n",
            "a # b\nc",
            "a # b\nc#",
            "a\n# b\n\n#c\n  ",
            "# a\n# b\n",
            "ab cd\r\n",
            "\n\nS",
        ] {
            let text = text.as_bytes();
            for begins_in_comment in [false, true] {
                let mut gap = Gap {
                    in_comment: begins_in_comment,
                };
                let inked = (0..text.len()).filter(|&at| !gap.takes(text[at]));
                assert_eq!(
                    last_word_end(text, begins_in_comment),
                    inked.last().map(|last| last + 1),
                    "{}",
                    text.escape_ascii()
                );
            }
        }
    }

    #[test]
    fn bytes_are_counted_in_texts_of_every_length() {
        for length in 0..1000 {
            assert_eq!(count(&vec![b'S'; length], b'S'), length as u64);
            assert_eq!(count(&vec![b's'; length], b'S'), 0);
        }
    }
}
