//! The lanes and the standard library read the same numbers.

use proptest::prelude::*;

use super::*;
use crate::random::Random;

/// Checks the parser and the lanes against the standard library on one word.
fn check(word: &str) {
    let standard: f32 = word.parse().expect("a number");
    let expected = standard.is_finite().then_some(standard.to_bits());
    let parsed = parse(word);
    assert_eq!(parsed.ok().map(f32::to_bits), expected, "{word}");
    assert_eq!(parsed.is_err(), parsed == Err(Refusal::TooLarge), "{word}");
    // The lanes may refuse a word, but must not be wrong.
    for before in ["", " S 1"] {
        if let (Some(number), _) = by_lanes(before, word) {
            assert_eq!(Some(number.to_bits()), expected, "{word}");
        }
    }
}

/// The word as a number and as an integer, read by a span among other numbers.
fn by_lanes(before: &str, word: &str) -> (Option<f32>, Option<u8>) {
    let number = word.len() % 4;
    let before = format!("{before}{}", "1.5 ".repeat(number));
    let text = format!("{before}{word}{}", " 1.5".repeat(SPAN));
    let span = Span::new(text.as_bytes()).expect("enough text");
    let (start, end) = (before.len(), before.len() + word.len());
    if word.is_empty() || end + 4 * (3 - number) >= SPAN {
        return (None, None);
    }
    let others = |at: usize| {
        let start = if at < number {
            start - 4 * (number - at)
        } else {
            end + 4 * (at - number) - 3
        };
        (start, start + 3)
    };
    let words = std::array::from_fn(|at| {
        if at == number {
            (start, end)
        } else {
            others(at)
        }
    });
    let numbers = span.numbers(words);
    if let Some(numbers) = numbers {
        let right = |(at, &other): (usize, &f32)| at == number || other == 1.5;
        assert!(numbers.iter().enumerate().all(right), "{word} {numbers:?}");
    }
    (
        numbers.map(|numbers| numbers[number]),
        span.integer(start, end),
    )
}

/// Every pair of digits, on a machine of either byte order.
#[test]
fn two_digits_in_a_lane_in_both_byte_orders() {
    for (tens, ones) in (0..10).flat_map(|tens| (0..10).map(move |ones| (tens, ones))) {
        let digits = [tens, ones];
        let orders = [i16::from_le_bytes, i16::from_be_bytes];
        for lane_of in orders {
            let lanes = i16x16::splat(lane_of(digits));
            let pairs = pairs_of_digits(lanes, lane_of(TENS_AND_ONES));
            let meant = i16::from(10 * tens + ones);
            assert_eq!(pairs.to_array(), [meant; 16], "{tens}{ones}");
        }
    }
}

/// Every byte at every place, on a machine of either byte order.
#[test]
fn each_bit_of_a_span_is_that_of_its_byte() {
    for byte in 0..=u8::MAX {
        for at in 0..SPAN {
            let mut text = [b'0'; SPAN + 16];
            text[at] = byte;
            let span = Span::new(&text).expect("enough text");
            let bit_if = |is: bool| u64::from(is) << at;
            let (blank, digit) = (matches!(byte, b' ' | b'\t'..=b'\r'), byte.is_ascii_digit());
            assert_eq!(span.blanks, bit_if(blank), "{byte} at {at}");
            assert_eq!(span.points, bit_if(byte == b'.'), "{byte} at {at}");
            assert_eq!(span.others, bit_if(!digit), "{byte} at {at}");
        }
    }
}

/// Every integer of one to three digits, on a machine of either byte order.
#[test]
fn integers_of_a_span_are_those_of_its_digits() {
    for integer in 0_u32..1_000 {
        for width in 1..=3 {
            let word = format!("{integer:0width$}");
            let (_, found) = by_lanes(" S ", &word);
            assert_eq!(found, u8::try_from(integer).ok(), "{word}");
        }
    }
}

/// Each digit at each place of the longest word, on a machine of either byte order.
#[test]
fn digits_come_to_their_places() {
    let mut read = 0;
    for place in 0..MAX_DIGITS {
        for digit in b'1'..=b'9' {
            let mut word = [b'0'; MAX_DIGITS];
            word[place] = digit;
            let word = String::from_utf8(word.to_vec()).expect("digits");
            let number: f32 = word.parse().expect("a number");
            // The lanes refuse what lies halfway between two floats.
            if let (Some(found), _) = by_lanes("", &word) {
                assert_eq!(found, number, "{word}");
                read += 1;
            }
        }
    }
    assert!(read > 100, "only {read} numbers");
}

#[test]
fn floats_of_every_size_come_back_in_every_notation() {
    for trial in 0..400_000 {
        let number = f32::from_bits(Random::new(trial).bits() as u32);
        if !number.is_finite() {
            continue;
        }
        check(&format!("{number:e}"));
        if (1e-12..1e20).contains(&number.abs()) {
            check(&format!("{number}"));
            check(&format!("{number:.9}"));
        }
    }
}

#[test]
fn ordinary_words_are_read_by_the_lanes_and_no_others() {
    let ordinary = [
        "0",
        "-0",
        "7",
        "-1",
        "1.5",
        ".5",
        "5.",
        "-.5",
        "-12.25",
        "0.0123456789",
        "12345678.9",
        "123456789012345",
        "-12345678901234.5",
        ".000000000000001",
        "999999999999999",
    ];
    for word in ordinary {
        let number: f32 = word.parse().expect("a number");
        let found = by_lanes(" S ", word).0.map(f32::to_bits);
        assert_eq!(found, Some(number.to_bits()), "{word}");
    }
    let others = [
        "-",
        ".",
        "-.",
        "--1",
        "-+1",
        "+1",
        "1-",
        "1-1",
        "1.2.3",
        "1..2",
        ".-1",
        "1e5",
        "1#",
        "x",
        "1234567890123456",
        ".0000000000000001",
        // Halfway between two floats.
        "16777217",
        "-33554434",
        "0.500000029802322387695",
    ];
    for word in others {
        assert_eq!(by_lanes(" S ", word).0, None, "{word}");
    }
}

#[test]
fn halfway_points_and_their_neighbours_round_as_they_should() {
    for trial in 0..100_000 {
        let seed = Random::new(trial).bits();
        let low = f32::from_bits(seed as u32 & 0x7fff_ffff);
        let high = low.next_up();
        if !high.is_finite() {
            continue;
        }
        let halfway = f64::midpoint(f64::from(low), f64::from(high));
        // All digits of it, then the last digit changed at the far end.
        let exact = format!("{halfway:.160}");
        if (1e-20..1e20).contains(&halfway) {
            check(&exact);
            check(&format!("{exact}1"));
            check(exact.trim_end_matches('0'));
            check(&format!("{}49999", &exact[..exact.len() - 1]));
        }
        for digits in 6..=20 {
            check(&format!("{halfway:.digits$e}"));
        }
        for near in [halfway, halfway.next_up(), halfway.next_down()] {
            check(&format!("{near}"));
            check(&format!("{near:e}"));
        }
    }
}

#[test]
fn the_ends_of_the_range() {
    for word in [
        "3.4028234663852886e38",
        "3.4028235677973366e38",
        "3.4028235677973365e38",
        "3.4028235677973367e38",
        "340282350000000000000000000000000000000",
        "340282356779733661637539395458142568447",
        "340282356779733661637539395458142568448",
        "1e38",
        "1e39",
        "1e99999999999999999999999",
        "-1e39",
        "1e-99999999999999999999999",
        "0e99999999999999999999999",
        "0.0",
        "-0.0",
        "-0",
        "00000000000000000000000000000000001",
        "1.17549435e-38",
        "1.17549421e-38",
        "1.4e-45",
        "7.006492321624085e-46",
        "7.006492321624086e-46",
        "7e-46",
        "9007199254740991",
        "9007199254740992",
        "9007199254740993",
        "16777217",
        "16777216.999999999999999",
        "16777217.000000000000000000001",
        "1.",
        ".5",
        "+3",
        "1e5",
        "1E+5",
        "1.e-5",
        "+.5e1",
        "12345678",
        "1234567.12345678",
        "1234567.123456781234567",
        "0.12345678123456781",
        "0.1234567812345678123456781234567812345678",
    ] {
        check(word);
    }
}

#[test]
fn what_is_not_decimal_is_malformed() {
    for word in [
        "",
        "+",
        "-",
        ".",
        "+.",
        "e5",
        ".e5",
        "1e",
        "1e+",
        "1e5.0",
        "1.2.3",
        "--1",
        "+-1",
        "0x10",
        "0x1p3",
        "nan",
        "inf",
        "-inf",
        "infinity",
        "NaN",
        "1,5",
        "1_000",
        "1f",
        "1d5",
        "1e5e5",
        "O.5",
        "1 2",
        "1\0",
        "\u{2212}1",
        "1/2",
        "5%",
    ] {
        assert_eq!(parse(word), Err(Refusal::Malformed), "{word}");
        if !word.contains(' ') {
            assert_eq!(by_lanes("", word), (None, None), "{word}");
        }
    }
}

#[test]
fn integers() {
    for (word, integer) in [
        ("0", Some(0)),
        ("-0", Some(0)),
        ("+255", Some(255)),
        ("256", Some(256)),
        ("-1", Some(-1)),
        ("0000000000000000000000000000000255", Some(255)),
        ("99999999999999999999999999999999", Some(i64::MAX)),
        ("-99999999999999999999999999999999", Some(-i64::MAX)),
        ("", None),
        ("-", None),
        ("1.0", None),
        ("1e2", None),
        ("0x1", None),
        ("١", None),
    ] {
        assert_eq!(parse_integer(word), integer, "{word}");
        let byte = integer.and_then(|integer| u8::try_from(integer).ok());
        if let (_, Some(found)) = by_lanes("S ", word) {
            assert_eq!(Some(found), byte, "{word}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn any_decimal_text(word in "[+-]?([0-9]{1,25}\\.?[0-9]{0,25}|\\.[0-9]{1,25})([eE][+-]?[0-9]{1,2})?") {
        check(&word);
    }

    #[test]
    fn any_text_at_all(word in "[-+.eE0-9x,]{1,12}") {
        let standard = word.parse::<f32>().ok().filter(|number| number.is_finite());
        prop_assert_eq!(parse(&word).ok(), standard);
    }
}
