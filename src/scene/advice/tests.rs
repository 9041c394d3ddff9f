//! A test for each row of the tables.

use super::*;
use crate::scene::Scene;

/// A word with each of the mistakes, in the order of the table, and the advice on it.
const WORDS: [(&str, &str); MISTAKES.len()] = [
    ("//", "a comment begins with #"),
    ("-", "write the sign and its number in one word"),
    ("+-3", "a number has one sign"),
    ("\u{2212}3", "this has a typographic minus sign: write -"),
    ("-NaN", "numbers must be finite"),
    ("1.5*^-7", "write the exponent with e: 1.5e-7"),
    (
        "****",
        "Fortran writes asterisks where a number is wider than its field: \
         write the file again with wider fields",
    ),
    (
        "3*0.5",
        "in Fortran this stands for equal values; write each of them: 0.5",
    ),
    (
        "[np.float64(0.1),",
        "write the value without its Python type, as print(*values) does: 0.1",
    ),
    ("np.float64(nan)", "numbers must be finite"),
    (
        "0,00000000000000000000000000000000000000001",
        "write it with a point instead of the comma",
    ),
    ("0,5", "write it with a point: 0.5"),
    (
        "(1,2,3)",
        "separate numbers by blanks alone, without brackets",
    ),
    ("1;2;3", "separate numbers by blanks alone"),
    ("1O.5", "this has a letter O where a digit 0 belongs"),
    ("l.5", "this has a letter l or I where a digit 1 belongs"),
    ("-0x1F", "write numbers in decimal"),
    ("1_000", "write numbers without underscores"),
    ("1\u{a0}2", "this has a no-break space: write a plain blank"),
    ("1/3", "write fractions in decimal"),
    ("'0.5'", "write numbers without quotes"),
    ("[0.5]", "write numbers without brackets"),
    ("50%", "write numbers without a suffix"),
    (
        "0.123-103",
        "put a blank between the numbers: 0.123 -103; \
         or, if this is one number of Fortran, write its exponent with e: 0.123e-103",
    ),
    ("-7.-1.", "put a blank between the numbers: -7. -1."),
    ("1e+", "the exponent has no digits"),
    (
        "1.2.3",
        "a number has at most one point; between two numbers, put a blank",
    ),
];

/// The advice that a scene with this word as a coordinate is refused with.
fn advice_in_a_scene(word: &[u8]) -> String {
    let text = [b"VP 1 1 1 BG 0 0 0 OBJ_N 1 S ", word, b" 0 5 1 9 9 9"].concat();
    let message = Scene::parse(&text).expect_err("not a scene").to_string();
    let (_, help) = message.split_once("\nhelp: ").expect("advice");
    help.to_owned()
}

#[test]
fn each_mistake_is_found_and_gets_its_advice() {
    for (index, (word, advice)) in WORDS.into_iter().enumerate() {
        let mut rows = MISTAKES.iter();
        let found = rows.position(|mistake| (mistake.find)(word).is_some());
        assert_eq!(found, Some(index), "{word}");
        assert_eq!(advice_in_a_scene(word.as_bytes()), advice, "{word}");
    }
}

#[test]
fn each_kind_of_foreign_bytes_gets_its_advice() {
    let words: [&[u8]; FOREIGN_BYTES.len()] = [b"1\0", b"\xff", b"\x1b[0m", b"\xef\xbb\xbf1"];
    for (index, word) in words.into_iter().enumerate() {
        let found = FOREIGN_BYTES.iter().position(|row| (row.are_in)(word));
        assert_eq!(found, Some(index), "{}", word.escape_ascii());
        assert_eq!(advice_in_a_scene(word), FOREIGN_BYTES[index].help);
    }
}

/// What each row is for, beyond its first example.
#[test]
fn other_words_with_a_mistake_of_the_table() {
    for (word, advice) in [
        ("/*", "a comment begins with #"),
        ("--", "a comment begins with #"),
        ("%5", "a comment begins with #"),
        ("infinity", "numbers must be finite"),
        ("1d5", "write the exponent with e: 1e5"),
        ("1D+5", "write the exponent with e: 1e+5"),
        ("2*10^-3", "write the exponent with e: 2e-3"),
        ("2x10^3", "write the exponent with e: 2e3"),
        ("2\u{d7}10^3", "write the exponent with e: 2e3"),
        ("2*10**3", "write the exponent with e: 2e3"),
        ("1.5,", "separate numbers by blanks alone"),
        ("[1,", "separate numbers by blanks alone, without brackets"),
        ("1,000,000", "separate numbers by blanks alone"),
        ("I", "this has a letter l or I where a digit 1 belongs"),
        ("\"1\"", "write numbers without quotes"),
        ("0.5f", "write numbers without a suffix"),
        ("1-2+3", "put a blank between the numbers: 1 -2 +3"),
        ("1e-5-2", "put a blank between the numbers: 1e-5 -2"),
        ("123-103", "put a blank between the numbers: 123 -103"),
        ("0.1-1034", "put a blank between the numbers: 0.1 -1034"),
        ("1E", "the exponent has no digits"),
        (
            "111111111111111111111.-222222222222222222222.",
            "put a blank between the numbers",
        ),
    ] {
        assert_eq!(advice_in_a_scene(word.as_bytes()), advice, "{word}");
    }
    // What to write is shown if it is not too long.
    let word = format!("0,{}1", "0".repeat(LONGEST_QUOTE - 3));
    let advice = format!("write it with a point: {}", word.replace(',', "."));
    assert_eq!(advice_in_a_scene(word.as_bytes()), advice);
    for word in [
        "x", "0*1", "f", "1,x", "[]", "1_x", "a/b", "1/b", "a/1", "x-1", "e5", "(1",
    ] {
        let known = for_number(word.as_bytes());
        let expected = match word {
            "(1" => Some("write numbers without brackets".to_owned()),
            _ => None,
        };
        assert_eq!(known, expected, "{word}");
    }
}

#[test]
fn words_at_the_place_of_a_keyword_have_a_kind() {
    for (word, kind) in [
        (&b"//"[..], WordKind::ForeignComment),
        (b"--", WordKind::ForeignComment),
        (b"---", WordKind::Other),
        (b"1", WordKind::Number),
        (b"-1e5", WordKind::Number),
        (b"1e39", WordKind::Other),
        (b"VP", WordKind::Keyword),
        (b"BG", WordKind::Keyword),
        (b"OBJ_N", WordKind::Keyword),
        (b"S", WordKind::Keyword),
        (b"s", WordKind::Other),
        (b"\0", WordKind::NotText(FOREIGN_BYTES[0].help)),
    ] {
        assert_eq!(WordKind::of(word), kind, "{}", word.escape_ascii());
    }
}
