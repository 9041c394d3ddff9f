//! Advice on words that do not fit: the mistakes that people and their programs make, and
//! what to write instead.

use super::{
    excerpt::{LONGEST_QUOTE, quoted},
    grammar::is_keyword,
    number,
    text::word_end,
};

pub(super) const COMMENT_HELP: &str = "a comment begins with #";

const BRACKETS: [char; 8] = ['(', ')', '[', ']', '{', '}', '<', '>'];

const SEPARATORS: [char; 2] = [',', ';'];

/// A mistake in a word that must be a number.
struct Mistake {
    advice: &'static str,
    /// Nothing if the word does not have this mistake, else what follows the advice.
    find: fn(&str) -> Option<String>,
}

/// The advice is on the first mistake of this table that a word has, so special mistakes
/// stand before general ones. Each row has its test in `advice/tests.rs`.
const MISTAKES: [Mistake; 27] = [
    row(COMMENT_HELP, |text| {
        alone(is_foreign_comment(text.as_bytes()))
    }),
    row("write the sign and its number in one word", |text| {
        alone(matches!(text, "+" | "-"))
    }),
    row("a number has one sign", |text| {
        alone(text.starts_with(['+', '-']) && is_number(&text[1..]))
    }),
    row("this has a typographic minus sign: write -", |text| {
        alone(is_number_with(text, &['\u{2212}'], "-"))
    }),
    row("numbers must be finite", |text| alone(is_not_finite(text))),
    row("write the exponent with e", exponent),
    row(
        "Fortran writes asterisks where a number is wider than its field: \
         write the file again with wider fields",
        |text| alone(text.contains("**") || text == "*"),
    ),
    row(
        "in Fortran this stands for equal values; write each of them",
        repeated_value,
    ),
    row(
        "write the value without its Python type, as print(*values) does",
        |text| {
            let value = python_value(text).filter(|value| is_number(value))?;
            Some(then_write(value))
        },
    ),
    row("numbers must be finite", |text| {
        alone(python_value(text).is_some_and(is_not_finite))
    }),
    row("write it with a point instead of the comma", |text| {
        alone(text.len() > LONGEST_QUOTE && with_point(text).is_some())
    }),
    row("write it with a point", |text| {
        Some(then_write(&with_point(text)?))
    }),
    row(
        "separate numbers by blanks alone, without brackets",
        |text| alone(are_separated(text) && text.contains(BRACKETS)),
    ),
    row("separate numbers by blanks alone", |text| {
        alone(are_separated(text))
    }),
    row("this has a letter O where a digit 0 belongs", |text| {
        alone(is_number_with(text, &['O', 'o'], "0"))
    }),
    row("this has a letter l or I where a digit 1 belongs", |text| {
        alone(is_number_with(text, &['l', 'I'], "1"))
    }),
    row("write numbers in decimal", |text| {
        let unsigned = text.trim_start_matches(['+', '-']);
        alone(unsigned.starts_with("0x") || unsigned.starts_with("0X"))
    }),
    row("write numbers without underscores", |text| {
        alone(is_number_with(text, &['_'], ""))
    }),
    row("this has a no-break space: write a plain blank", |text| {
        alone(text.contains('\u{a0}'))
    }),
    row("write fractions in decimal", |text| {
        let parts = text.split_once('/');
        alone(parts.is_some_and(|(a, b)| is_number(a) && is_number(b)))
    }),
    row("write numbers without quotes", |text| {
        alone(is_number(text.trim_matches(['"', '\''])))
    }),
    row("write numbers without brackets", |text| {
        alone(is_number(text.trim_matches(BRACKETS)))
    }),
    row("write numbers without a suffix", |text| {
        alone(is_number(text.trim_end_matches(['f', 'F', '%'])))
    }),
    row("put a blank between the numbers", number_or_exponent),
    row("put a blank between the numbers", |text| {
        Some(then_write(&separated_by_signs(text)?))
    }),
    row("the exponent has no digits", |text| {
        alone(text.ends_with(['e', 'E', '+', '-']) && is_number(&format!("{text}0")))
    }),
    row(
        "a number has at most one point; between two numbers, put a blank",
        |text| alone(text.matches('.').count() > 1),
    ),
];

const fn row(advice: &'static str, find: fn(&str) -> Option<String>) -> Mistake {
    Mistake { advice, find }
}

/// Advice that stands alone, if the word has the mistake.
fn alone(has_mistake: bool) -> Option<String> {
    has_mistake.then(String::new)
}

/// The end of advice on what to write, unless that is too long to show.
fn then_write(mended: &str) -> String {
    if mended.len() > LONGEST_QUOTE {
        String::new()
    } else {
        format!(": {mended}")
    }
}

/// What to write instead of a word that must be a number, if its mistake is known.
pub(super) fn for_number(word: &[u8]) -> Option<String> {
    if let Some(help) = for_bytes(word) {
        return Some(help.to_owned());
    }
    let text = str::from_utf8(word).ok()?;
    MISTAKES.iter().find_map(|Mistake { advice, find }| {
        let rest = find(text)?;
        Some(format!("{advice}{rest}"))
    })
}

/// A kind of bytes that a scene may have only in comments.
struct Foreign {
    help: &'static str,
    are_in: fn(&[u8]) -> bool,
}

/// The advice is on the first kind of this table that a word has. Each row has its test in
/// `advice/tests.rs`.
const FOREIGN_BYTES: [Foreign; 4] = [
    Foreign {
        help: "the file holds NUL bytes: is it a text, and not in UTF-16?",
        are_in: |word| word.contains(&0),
    },
    Foreign {
        help: "the file holds bytes that are not UTF-8: is it a text?",
        are_in: |word| str::from_utf8(word).is_err(),
    },
    Foreign {
        help: "the file holds control characters: is it a text?",
        are_in: |word| word.iter().any(u8::is_ascii_control),
    },
    Foreign {
        help: "a byte order mark may stand only once, as the first bytes of the file: remove this one",
        are_in: |word| word.starts_with(b"\xef\xbb\xbf"),
    },
];

fn for_bytes(word: &[u8]) -> Option<&'static str> {
    let found = FOREIGN_BYTES.iter().find(|foreign| (foreign.are_in)(word));
    found.map(|foreign| foreign.help)
}

/// The kind of a word that stands in the place of a keyword or behind the last sphere.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WordKind {
    /// The beginning of a comment in another language.
    ForeignComment,
    Number,
    Keyword,
    /// Bytes that a scene may have only in comments, with advice.
    NotText(&'static str),
    Other,
}

impl WordKind {
    pub(super) fn of(word: &[u8]) -> Self {
        if is_foreign_comment(word) {
            Self::ForeignComment
        } else if str::from_utf8(word).is_ok_and(is_number) {
            Self::Number
        } else if is_keyword(word) {
            Self::Keyword
        } else {
            for_bytes(word).map_or(Self::Other, Self::NotText)
        }
    }
}

fn is_foreign_comment(word: &[u8]) -> bool {
    let begins = [&b"//"[..], b"/*", b";", b"%", b"!"];
    word == b"--" || begins.iter().any(|begin| word.starts_with(begin))
}

/// Whether a keyword is followed, without a blank, by what was meant to be a number.
pub(super) fn goes_on_with_number(rest: &[u8]) -> bool {
    rest.first()
        .is_some_and(|byte| byte.is_ascii_digit() || b"+-.*".contains(byte))
}

/// Advice on `1.#INF`, `-1.#IND` and `1.#QNAN` of Microsoft's C library. Only
/// `word` of it is read, because `rest`, which follows, begins a comment.
pub(super) fn for_not_finite(word: &[u8], rest: &[u8]) -> Option<String> {
    /// Of `1.#QNAN00` and the like.
    const LONGEST_NAME: usize = 12;
    let name = rest.strip_prefix(b"#")?;
    let letters = name.iter().take_while(|byte| byte.is_ascii_alphanumeric());
    let name = &name[..letters.count().min(LONGEST_NAME)];
    let known = [&b"INF"[..], b"IND", b"QNAN", b"SNAN", b"J"];
    if !word.ends_with(b".")
        || !str::from_utf8(word).is_ok_and(is_number)
        || !known.iter().any(|begin| name.starts_with(begin))
    {
        return None;
    }
    let written = [word, b"#", name].concat();
    Some(format!(
        "a # begins a comment, so that of {} only {} was read: numbers must be finite",
        quoted(&written),
        quoted(word),
    ))
}

/// As [`for_not_finite`], where the line begins with the word that does not fit. Its
/// first bytes are enough.
pub(super) fn for_line(line: &[u8]) -> Option<String> {
    let (word, rest) = line.split_at(word_end(line, 0));
    for_not_finite(word, rest)
}

fn is_number(text: &str) -> bool {
    number::parse(text).is_ok()
}

/// Whether a word has some of these characters, and is a number if they are replaced.
fn is_number_with(text: &str, wrong: &[char], right: &str) -> bool {
    text.contains(wrong) && is_number(&text.replace(wrong, right))
}

fn is_not_finite(text: &str) -> bool {
    let lower = text.to_ascii_lowercase();
    let unsigned = lower.trim_start_matches(['+', '-']);
    unsigned.starts_with("nan") || unsigned.starts_with("inf")
}

/// `1d5` of Fortran, `1.5*^-7` of Mathematica, `1.5*10^-7` of people.
fn exponent(text: &str) -> Option<String> {
    ["*^", "*10^", "x10^", "\u{d7}10^", "*10**", "d", "D"]
        .into_iter()
        .filter(|exponent| text.contains(exponent))
        .map(|exponent| text.replace(exponent, "e"))
        .find(|mended| is_number(mended))
        .map(|mended| then_write(&mended))
}

/// `3*0.5` of Fortran, which stands for 0.5 three times.
fn repeated_value(text: &str) -> Option<String> {
    let (count, value) = text.split_once('*')?;
    let is_repeated = number::parse_integer(count)? > 0 && is_number(value);
    is_repeated.then(|| then_write(value))
}

/// The value in `np.float64(0.1)` or `Decimal('0.1')`, brackets of a list around it left
/// out.
fn python_value(text: &str) -> Option<&str> {
    let (name, value) = text.rsplit_once('(')?;
    let has_name = name.ends_with(|c: char| c.is_ascii_alphanumeric());
    has_name.then(|| value.trim_matches(|c| "[]),'\"".contains(c)))
}

/// The number with a point that was written with a comma.
fn with_point(text: &str) -> Option<String> {
    let mended = text.replace(',', ".");
    let is_it = text.matches(',').count() == 1 && !text.ends_with(',') && is_number(&mended);
    is_it.then_some(mended)
}

/// Whether a word is numbers with commas or semicolons between them.
fn are_separated(text: &str) -> bool {
    let inner = text.trim_matches(BRACKETS).trim_matches(SEPARATORS);
    text.contains(SEPARATORS) && inner.split(SEPARATORS).all(is_number)
}

/// Numbers of fixed columns that fill their columns, `-7.-1`, with blanks between them.
fn separated_by_signs(text: &str) -> Option<String> {
    let mut separated = String::with_capacity(text.len() + 1);
    let mut before = None;
    for character in text.chars() {
        if matches!(character, '+' | '-') && !matches!(before, None | Some('e' | 'E')) {
            separated.push(' ');
        }
        separated.push(character);
        before = Some(character);
    }
    let are_numbers = separated.contains(' ') && separated.split(' ').all(is_number);
    are_numbers.then_some(separated)
}

/// `0.123-103`: two numbers, or one whose exponent Fortran wrote without its letter, as it
/// does if the exponent has three digits.
fn number_or_exponent(text: &str) -> Option<String> {
    let separated = separated_by_signs(text)?;
    let (number, exponent) = separated.split_once(' ')?;
    let digits = &exponent.as_bytes()[1..];
    if !number.contains('.') || digits.len() != 3 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let numbers = then_write(&separated);
    let one = then_write(&format!("{number}e{exponent}"));
    Some(format!(
        "{numbers}; or, if this is one number of Fortran, write its exponent with e{one}"
    ))
}

#[cfg(test)]
mod tests;
