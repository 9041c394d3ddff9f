//! What would mend a word that is not a number: the mistakes that people and
//! their programs make, and what to write instead.

use super::{
    error::{LONGEST_QUOTE, quoted},
    number,
};

pub(super) const COMMENT_HELP: &str = "a comment begins with #";

const BRACKETS: [char; 8] = ['(', ')', '[', ']', '{', '}', '<', '>'];

/// A mistake: what would mend a word in which it was made.
type Mistake = fn(&str) -> Option<String>;

/// The more particular mistakes come first.
const MISTAKES: [Mistake; 12] = [
    foreign_comment,
    sign,
    not_finite,
    exponent,
    fortran,
    python,
    comma,
    separators,
    letter,
    decoration,
    glued_numbers,
    digits,
];

/// What would mend a word that is not a number, if its mistake is known.
pub(super) fn for_number(word: &[u8]) -> Option<String> {
    for_bytes(word).or_else(|| {
        let text = str::from_utf8(word).ok()?;
        MISTAKES.iter().find_map(|mistake| mistake(text))
    })
}

/// What to do about bytes that no scene has outside comments.
pub(super) fn for_bytes(word: &[u8]) -> Option<String> {
    const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
    let help = if word.contains(&0) {
        "the file holds NUL bytes: is it a text, and not in UTF-16?"
    } else if str::from_utf8(word).is_err() {
        "the file holds bytes that are not UTF-8: is it a text?"
    } else if word.iter().any(u8::is_ascii_control) {
        "the file holds control characters: is it a text?"
    } else if word.starts_with(BYTE_ORDER_MARK) {
        "a byte order mark may stand only once, as the first bytes of the file: remove this one"
    } else {
        return None;
    };
    Some(help.to_owned())
}

pub(super) fn is_foreign_comment(word: &[u8]) -> bool {
    let begins = [&b"//"[..], b"/*", b";", b"%", b"!"];
    word == b"--" || begins.iter().any(|begin| word.starts_with(begin))
}

/// What to do about `1.#INF`, `-1.#IND` and `1.#QNAN` of Microsoft's C library, of
/// which only `word` is read: `rest` follows it.
pub(super) fn for_not_finite(word: &[u8], rest: &[u8]) -> Option<String> {
    /// Of `1.#QNAN00` and the like.
    const LONGEST_NAME: usize = 12;
    let name = rest.strip_prefix(b"#")?;
    let letters = name.iter().take_while(|byte| byte.is_ascii_alphanumeric());
    let name = &name[..letters.count().min(LONGEST_NAME)];
    let known = [&b"INF"[..], b"IND", b"QNAN", b"SNAN", b"J"];
    if !word.ends_with(b".")
        || number::parse(word).is_err()
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

/// As [`for_not_finite`], of the line from the word that is wrong on, or its first
/// bytes.
pub(super) fn for_line(line: &[u8]) -> Option<String> {
    let (word, rest) = line.split_at(number::word_end(line, 0));
    for_not_finite(word, rest)
}

/// Whether a word that begins with a keyword goes on with what was meant to be
/// a number.
pub(super) fn goes_on_with_number(rest: &[u8]) -> bool {
    rest.first()
        .is_some_and(|byte| byte.is_ascii_digit() || b"+-.*".contains(byte))
}

/// The colour that digits behind a `#` mean on the web: `f00`, `ff0000`, or
/// `ff0000ff`, whose last two are the opacity.
pub(super) fn web_colour(digits: &[u8]) -> Option<[u8; 3]> {
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

fn is_number(text: &str) -> bool {
    number::parse(text.as_bytes()).is_ok()
}

/// Advice that ends in what to write, unless that is too long to show.
fn write(advice: &str, mended: &str) -> String {
    if mended.len() > LONGEST_QUOTE {
        advice.to_owned()
    } else {
        format!("{advice}: {mended}")
    }
}

fn foreign_comment(text: &str) -> Option<String> {
    is_foreign_comment(text.as_bytes()).then(|| COMMENT_HELP.to_owned())
}

fn sign(text: &str) -> Option<String> {
    let help = if matches!(text, "+" | "-") {
        "write the sign and its number in one word"
    } else if text.starts_with(['+', '-']) && is_number(&text[1..]) {
        "a number has one sign"
    } else if text.contains('\u{2212}') && is_number(&text.replace('\u{2212}', "-")) {
        "this has a typographic minus sign: write -"
    } else {
        return None;
    };
    Some(help.to_owned())
}

fn not_finite(text: &str) -> Option<String> {
    let lower = text.to_ascii_lowercase();
    let unsigned = lower.trim_start_matches(['+', '-']);
    let not_finite = unsigned.starts_with("nan") || unsigned.starts_with("inf");
    not_finite.then(|| "numbers must be finite".to_owned())
}

/// `1d5` of Fortran, `1.5*^-7` of Mathematica, `1.5*10^-7` of people.
fn exponent(text: &str) -> Option<String> {
    ["*^", "*10^", "x10^", "\u{d7}10^", "*10**", "d", "D"]
        .into_iter()
        .filter(|exponent| text.contains(exponent))
        .map(|exponent| text.replace(exponent, "e"))
        .find(|mended| is_number(mended))
        .map(|mended| write("write the exponent with e", &mended))
}

/// A number too wide for its field, and equal values in short.
fn fortran(text: &str) -> Option<String> {
    if text.contains("**") || text == "*" {
        return Some(
            "Fortran writes asterisks where a number is wider than its field: \
             write the file again with wider fields"
                .to_owned(),
        );
    }
    let (count, value) = text.split_once('*')?;
    let short = number::parse_integer(count.as_bytes())? > 0 && is_number(value);
    short.then(|| {
        write(
            "in Fortran this stands for equal values; write each of them",
            value,
        )
    })
}

/// `np.float64(0.1)`, `Decimal('0.1')`, the beginning and the end of `[0.1, 0.2]`.
fn python(text: &str) -> Option<String> {
    let (name, value) = text.rsplit_once('(')?;
    let value = value.trim_matches(|c| "[]),'\"".contains(c));
    if !name.ends_with(|c: char| c.is_ascii_alphanumeric()) {
        return None;
    }
    if !is_number(value) {
        return not_finite(value);
    }
    let advice = "write the value without its Python type, as print(*values) does";
    Some(write(advice, value))
}

fn comma(text: &str) -> Option<String> {
    let mended = text.replace(',', ".");
    if text.matches(',').count() != 1 || text.ends_with(',') || !is_number(&mended) {
        return None;
    }
    Some(if text.len() > LONGEST_QUOTE {
        "write it with a point instead of the comma".to_owned()
    } else {
        format!("write it with a point: {mended}")
    })
}

fn separators(text: &str) -> Option<String> {
    let separators = [',', ';'];
    let inner = text.trim_matches(BRACKETS).trim_matches(separators);
    if !text.contains(separators) || !inner.split(separators).all(is_number) {
        return None;
    }
    let help = if text.contains(BRACKETS) {
        "separate numbers by blanks alone, without brackets"
    } else {
        "separate numbers by blanks alone"
    };
    Some(help.to_owned())
}

fn letter(text: &str) -> Option<String> {
    let help = if text.contains(['O', 'o']) && is_number(&text.replace(['O', 'o'], "0")) {
        "this has a letter O where a digit 0 belongs"
    } else if text.contains(['l', 'I']) && is_number(&text.replace(['l', 'I'], "1")) {
        "this has a letter l or I where a digit 1 belongs"
    } else {
        return None;
    };
    Some(help.to_owned())
}

/// What stands around a number or between its digits.
fn decoration(text: &str) -> Option<String> {
    let unsigned = text.trim_start_matches(['+', '-']);
    let help = if unsigned.starts_with("0x") || unsigned.starts_with("0X") {
        "write numbers in decimal"
    } else if text.contains('_') && is_number(&text.replace('_', "")) {
        "write numbers without underscores"
    } else if text.contains('\u{a0}') {
        "this has a no-break space: write a plain blank"
    } else if text
        .split_once('/')
        .is_some_and(|(a, b)| is_number(a) && is_number(b))
    {
        "write fractions in decimal"
    } else if is_number(text.trim_matches(['"', '\''])) {
        "write numbers without quotes"
    } else if is_number(text.trim_matches(BRACKETS)) {
        "write numbers without brackets"
    } else if is_number(text.trim_end_matches(['f', 'F', '%'])) {
        "write numbers without a suffix"
    } else {
        return None;
    };
    Some(help.to_owned())
}

/// Numbers of fixed columns that fill them, `-7.-1`, which may also be one
/// number whose exponent Fortran wrote without its letter, `0.123-103`.
fn glued_numbers(text: &str) -> Option<String> {
    let mut blanks = String::with_capacity(text.len() + 1);
    let mut before = None;
    for character in text.chars() {
        if matches!(character, '+' | '-') && !matches!(before, None | Some('e' | 'E')) {
            blanks.push(' ');
        }
        blanks.push(character);
        before = Some(character);
    }
    let numbers: Vec<&str> = blanks.split(' ').collect();
    if numbers.len() < 2 || !numbers.iter().all(|number| is_number(number)) {
        return None;
    }
    let help = write("put a blank between the numbers", &blanks);
    let [number, exponent] = numbers[..] else {
        return Some(help);
    };
    // Fortran leaves the letter out where the exponent has three digits.
    let digits = exponent[1..].bytes();
    if number.contains('.') && digits.len() == 3 && digits.into_iter().all(|b| b.is_ascii_digit()) {
        let advice = "; or, if this is one number of Fortran, write its exponent with e";
        return Some(help + &write(advice, &format!("{number}e{exponent}")));
    }
    Some(help)
}

fn digits(text: &str) -> Option<String> {
    let help = if text.ends_with(['e', 'E', '+', '-']) && is_number(&format!("{text}0")) {
        "the exponent has no digits"
    } else if text.matches('.').count() > 1 {
        "a number has at most one point; between two numbers, put a blank"
    } else {
        return None;
    };
    Some(help.to_owned())
}
