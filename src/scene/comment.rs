//! Comments amid numbers that were not meant as comments, like `#ff0000` or `1.#INF`.

use super::{
    advice,
    excerpt::{LONGEST_QUOTE, quoted},
    text::is_blank,
};

/// The beginning of a comment, as much of it as a message may need.
#[derive(Debug)]
pub(super) struct Comment {
    /// The word that ends where the comment begins. May be empty.
    word_before: Vec<u8>,
    /// Its bytes behind the `#`, up to a blank.
    begin: Vec<u8>,
    is_complete: bool,
    /// Whether a colour was expected.
    is_colour: bool,
}

impl Comment {
    /// A comment that begins at the end of the text `before`.
    pub(super) fn after(before: &[u8], is_colour: bool) -> Self {
        let near = &before[before.len().saturating_sub(LONGEST_QUOTE / 2)..];
        let word = near.rsplit(|&byte| is_blank(byte)).next();
        Self {
            word_before: word.unwrap_or_default().to_vec(),
            begin: Vec::new(),
            is_complete: false,
            is_colour,
        }
    }

    /// Takes the next byte of the comment, or the line feed that ends it.
    pub(super) fn take(&mut self, byte: u8) {
        self.is_complete |= is_blank(byte) || self.begin.len() == LONGEST_QUOTE / 2;
        if !self.is_complete {
            self.begin.push(byte);
        }
    }

    /// What to write instead, if this was not meant as a comment.
    pub(super) fn help(&self) -> Option<String> {
        let begin = [b"#", &self.begin[..]].concat();
        if let Some(help) = advice::for_not_finite(&self.word_before, &begin) {
            return Some(help);
        }
        let [red, green, blue] = web_colour(&self.begin).filter(|_| self.is_colour)?;
        Some(format!(
            "a # begins a comment, so that {} was not read: write {red} {green} {blue}",
            quoted(&begin),
        ))
    }
}

/// The colour that digits behind a `#` mean on the web: `f00`, `ff0000`, or `ff0000ff`,
/// whose last two digits are the opacity.
fn web_colour(digits: &[u8]) -> Option<[u8; 3]> {
    let text = str::from_utf8(digits).ok()?;
    if !digits.iter().all(u8::is_ascii_hexdigit) {
        return None;
    }
    let channel = |from: usize, to: usize| u8::from_str_radix(&text[from..to], 16).ok();
    match digits.len() {
        3 => Some([
            channel(0, 1)? * 0x11,
            channel(1, 2)? * 0x11,
            channel(2, 3)? * 0x11,
        ]),
        6 | 8 => Some([channel(0, 2)?, channel(2, 4)?, channel(4, 6)?]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_some_of_a_comment_and_of_the_word_before_it_is_kept() {
        let comment_of = |text: &[u8]| {
            let mut comment = Comment::after(b"1.5", true);
            text.iter().for_each(|&byte| comment.take(byte));
            comment.begin
        };
        assert_eq!(comment_of(b"f00 f00\nfff\n"), b"f00");
        assert_eq!(comment_of(b"\nf00\n"), b"");
        let long = [b'f'; 1000];
        let longest = &long[..LONGEST_QUOTE / 2];
        assert_eq!(comment_of(&long), longest);
        assert_eq!(Comment::after(&long, true).word_before, longest);
    }
}
