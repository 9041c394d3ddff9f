//! Decimal text to the nearest `f32`, rounded once.
//!
//! An ordinary number is a whole number of at most 53 bits times a power of
//! ten that is exact in `f64`: one multiplication or division then gives the
//! `f64` nearest to the text (Clinger, How to Read Floating Point Numbers
//! Accurately, 1990). Rounding that to `f32` rounds a second time, which is
//! harmless unless the `f64` stands exactly halfway between two floats:
//! rounding never crosses the halfway point, but it may land on it from either
//! side. A whole number of 64 bits is rounded once more, and then the `f64` must
//! not stand close to halfway either. Those, and everything else that is not
//! ordinary, go to the standard library, which is correctly rounded.

use wide::{f64x4, i8x32, i16x8, i16x16, u8x16, u64x4};

/// What stands between words.
#[inline(always)]
pub(super) const fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t'..=b'\r')
}

/// Whether a word ends before this byte.
#[inline(always)]
pub(super) const fn ends_word(byte: u8) -> bool {
    is_blank(byte) || byte == b'#'
}

/// Bytes of the longest word that is read, far more than any number needs: a
/// word can then never make the reader hold a whole file.
pub(super) const MAX_WORD: usize = 1 << 16;

/// Why a word is not a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// It is not decimal with optional sign, fraction and exponent.
    Malformed,
    /// It is, and rounds to something beyond the largest `f32`.
    TooLarge,
}

/// The `f32` nearest to a whole word.
pub(super) fn parse(word: &[u8]) -> Result<f32, Refusal> {
    let decimal = Decimal::scan(word).ok_or(Refusal::Malformed)?;
    if let Some(magnitude) = decimal.ordinary() {
        return Ok(with_sign(magnitude, decimal.negative));
    }
    let word = str::from_utf8(word).map_err(|_| Refusal::Malformed)?;
    match word.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(Refusal::TooLarge),
        Err(_) => Err(Refusal::Malformed),
    }
}

/// Whether a number that `parse` takes is zero as written, not by rounding.
pub(super) fn is_zero_as_written(word: &[u8]) -> bool {
    word.iter()
        .take_while(|byte| !matches!(byte, b'e' | b'E'))
        .all(|byte| !matches!(byte, b'1'..=b'9'))
}

/// The integer that a whole word of digits with an optional sign is; one too
/// large for `i64` becomes the largest of its sign.
pub(super) fn parse_integer(word: &[u8]) -> Option<i64> {
    let (negative, digits) = split_sign(word);
    if digits.is_empty() {
        return None;
    }
    let mut magnitude = 0_i64;
    for &digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        magnitude = magnitude
            .saturating_mul(10)
            .saturating_add(i64::from(digit - b'0'));
    }
    Some(if negative { -magnitude } else { magnitude })
}

/// The number at `at` and where its word ends; nothing if it is refused.
pub(super) fn take(text: &[u8], at: usize) -> Option<(f32, usize)> {
    let word = short_word(text, at)?;
    Some((parse(word).ok()?, at + word.len()))
}

/// The integer in `0..=255` at `at` and where its word ends; nothing if it is
/// refused.
pub(super) fn take_byte(text: &[u8], at: usize) -> Option<(u8, usize)> {
    let word = short_word(text, at)?;
    let value = parse_integer(word)?;
    Some((u8::try_from(value).ok()?, at + word.len()))
}

fn short_word(text: &[u8], at: usize) -> Option<&[u8]> {
    let word = &text[at..word_end(text, at)];
    (word.len() <= MAX_WORD).then_some(word)
}

/// Bytes in which the words are found at once.
pub(super) const SPAN: usize = 64;

/// A piece of text, the kinds of its bytes as one bit each, the first lowest.
///
/// With the ends of all words known beforehand no word waits for the one before it.
pub(super) struct Span<'a> {
    /// More, so that sixteen can be loaded anywhere.
    bytes: &'a [u8; SPAN + 16],
    pub(super) blanks: u64,
    points: u64,
    /// All that are not digits.
    others: u64,
}

impl<'a> Span<'a> {
    #[inline(always)]
    pub(super) fn new(text: &'a [u8]) -> Option<Self> {
        let bytes: &[u8; SPAN + 16] = text.first_chunk()?;
        let (halves, _) = bytes.as_chunks::<32>();
        let mut span = Self {
            bytes,
            blanks: 0,
            points: 0,
            others: 0,
        };
        for (half, bytes) in halves.iter().enumerate() {
            let bytes: i8x32 = bytemuck::cast(*bytes);
            let set = |lanes: i8x32| u64::from(lanes.to_bitmask()) << (32 * half);
            // Moved so that the bytes wanted are at an end of the range of `i8`.
            let from_tab = bytes + i8x32::splat(i8::MIN.wrapping_sub(b'\t' as i8));
            let from_zero = bytes + i8x32::splat(i8::MIN.wrapping_sub(b'0' as i8));
            span.blanks |= set(from_tab.simd_lt(i8x32::splat(i8::MIN + 5)));
            span.blanks |= set(bytes.simd_eq(i8x32::splat(b' ' as i8)));
            span.points |= set(bytes.simd_eq(i8x32::splat(b'.' as i8)));
            span.others |= set(from_zero.simd_gt(i8x32::splat(i8::MIN + 9)));
        }
        Some(span)
    }

    /// The byte at a place below [`SPAN`].
    #[inline(always)]
    pub(super) fn byte(&self, at: usize) -> u8 {
        self.bytes[at % SPAN]
    }

    /// The numbers that four words are, `start < end < SPAN`, one after the other with
    /// only blanks between, if each is at most 15 digits and a point.
    #[inline(always)]
    pub(super) fn numbers(&self, words: [(usize, usize); 4]) -> Option<[f32; 4]> {
        let mut ordinary = true;
        let mut expected = 0;
        let (mut signs, mut fractions) = ([0; 4], [0; 4]);
        let mut digits = [u8x16::splat(0); 4];
        for (number, (start, end)) in words.into_iter().enumerate() {
            let negative = self.byte(start) == b'-';
            let first = start + usize::from(negative);
            let point = ((self.points | bit(end)) & (u64::MAX << start)).trailing_zeros() as usize;
            expected |= u64::from(negative) << start | bit(point);
            let (whole, fraction) = (point - first, (end - point).saturating_sub(1));
            let count = whole + fraction;
            ordinary &= (1..=MOST_DIGITS).contains(&count);
            digits[number] = self.digits(first, whole, count);
            signs[number] = u32::from(negative) << 31;
            fractions[number] = fraction;
        }
        // No sign and no point but those.
        let inked = (bit(words[3].1) - bit(words[0].0)) & !self.blanks;
        if !ordinary || self.others & inked != expected & inked {
            return None;
        }
        let [a, b] = [[digits[0], digits[1]], [digits[2], digits[3]]].map(eights_of_digits);
        let high = f64x4::new([a[0], a[2], b[0], b[2]].map(f64::from));
        let low = f64x4::new([a[1], a[3], b[1], b[3]].map(f64::from));
        // Below 2^53, so exact.
        let mantissa = high * f64x4::splat(1e8) + low;
        let powers = f64x4::new(fractions.map(|fraction| POWERS[fraction % (MOST_DIGITS + 1)]));
        let values = mantissa / powers;
        let lost = bytemuck::cast::<_, u64x4>(values) & u64x4::splat(LOST);
        if lost.simd_eq(u64x4::splat(HALFWAY)).any() {
            return None;
        }
        // Neither below the normal floats nor above the finite ones.
        let magnitudes = values.to_array().map(|value| (value as f32).to_bits());
        Some(std::array::from_fn(|number| {
            f32::from_bits(magnitudes[number] | signs[number])
        }))
    }

    /// The values of `count` digits, the last of them last, zeros before them: at most
    /// 15 from `first`, a point after `whole` of them left out.
    #[inline(always)]
    fn digits(&self, first: usize, whole: usize, count: usize) -> u8x16 {
        let bytes: Option<&[u8; 16]> = self.bytes[first % SPAN..].first_chunk();
        let values = u8x16::new(bytes.map_or([0; 16], |bytes| *bytes)) ^ u8x16::splat(b'0');
        values.shuffle(u8x16::new(DIGITS_LAST[whole % 16][count % 16]))
    }

    /// The integer that the bytes from `start` to `end` are, `start < end < SPAN`,
    /// if it is at most 255, in at most 3 digits.
    #[inline(always)]
    pub(super) fn integer(&self, start: usize, end: usize) -> Option<u8> {
        let count = end - start;
        if self.others & (bit(end) - bit(start)) != 0 || count > 3 {
            return None;
        }
        let bytes = self.bytes[start % SPAN..].first_chunk();
        let bytes = bytes.map_or(0, |bytes| u32::from_le_bytes(*bytes));
        // Zeros move in before the digits: hundreds, tens, ones from the second byte on.
        let digits = (bytes ^ u32::from_le_bytes([b'0'; 4])) << (32 - 8 * count);
        let hundreds = digits >> 8 & 0xff;
        let rest = ((digits >> 16) * (10 * 0x100 + 1)) >> 8 & 0xff;
        u8::try_from(100 * hundreds + rest).ok()
    }
}

/// The most digits of a number that a span reads: they are exact in `f64`, and any power of ten
/// that such a number is divided by keeps it among the normal floats.
const MOST_DIGITS: usize = 15;

/// Which byte of a number comes to which place, by its digits before the point and by
/// all of them; where no digit comes, what no shuffle takes.
static DIGITS_LAST: [[[u8; 16]; 16]; 16] = {
    let mut places = [[[0x80; 16]; 16]; 16];
    let mut number = 0;
    while number < 16 * 16 * 16 {
        let (whole, count, digit) = (number / 256, number / 16 % 16, number % 16);
        if digit < count {
            places[whole][count][16 - count + digit] = (digit + (digit >= whole) as usize) as u8;
        }
        number += 1;
    }
    places
};

/// What two times two times eight digits mean.
#[inline(always)]
fn eights_of_digits(digits: [u8x16; 2]) -> [i32; 4] {
    let pairs = pairs_of_digits(bytemuck::cast(digits), i16::from_ne_bytes(TENS_AND_ONES));
    let weights = |high: i16| i16x16::new(std::array::from_fn(|lane| [high, 1][lane % 2]));
    let fours = i16x8::from_i32x8_saturate(pairs.dot(weights(100)));
    let weights = i16x8::new(std::array::from_fn(|lane| [10_000, 1][lane % 2]));
    fours.dot(weights).to_array()
}

/// In bytes that are read in the byte order of the digits.
const TENS_AND_ONES: [u8; 2] = [1, 10];

/// What the two digits in each lane mean, tens before ones in memory. In the high byte
/// of the product meet the tens times 10 and the ones times 1, whichever of them is the
/// low byte of the lane and so of the weights.
#[inline(always)]
fn pairs_of_digits(digits: i16x16, weights: i16) -> i16x16 {
    (digits * i16x16::splat(weights)) >> 8_i32
}

#[inline(always)]
fn bit(place: usize) -> u64 {
    1 << (place % SPAN)
}

/// Where the word at `at` ends.
pub(super) fn word_end(text: &[u8], at: usize) -> usize {
    let length = text[at..].iter().position(|&byte| ends_word(byte));
    length.map_or(text.len(), |length| at + length)
}

/// A decimal number in its parts: `mantissa * 10^exponent`.
struct Decimal {
    negative: bool,
    /// Nothing if there are more than 19 digits, leading zeros not counted.
    mantissa: Option<u64>,
    exponent: i64,
}

impl Decimal {
    fn scan(word: &[u8]) -> Option<Self> {
        let (negative, digits) = split_sign(word);
        let (mut mantissa, mut significant) = (0_u64, 0_usize);
        let mut exponent = 0_i64;
        let mut any_digit = false;
        let mut in_fraction = false;
        let mut bytes = digits.iter();
        while let Some(&byte) = bytes.next() {
            match byte {
                b'0'..=b'9' => {
                    any_digit = true;
                    mantissa = mantissa
                        .wrapping_mul(10)
                        .wrapping_add(u64::from(byte - b'0'));
                    significant += usize::from(mantissa != 0 || significant > 0);
                    exponent -= i64::from(in_fraction);
                }
                b'.' if !in_fraction => in_fraction = true,
                b'e' | b'E' if any_digit => {
                    exponent = exponent.saturating_add(parse_integer(bytes.as_slice())?);
                    break;
                }
                _ => return None,
            }
        }
        any_digit.then_some(Self {
            negative,
            mantissa: (significant <= 19).then_some(mantissa),
            exponent,
        })
    }

    /// The nearest `f32`, if one rounding to `f64` leaves no doubt of it.
    fn ordinary(&self) -> Option<f32> {
        let mantissa = self.mantissa?;
        let power = *POWERS.get(usize::try_from(self.exponent.unsigned_abs()).ok()?)?;
        let value = if self.exponent < 0 {
            mantissa as f64 / power
        } else {
            mantissa as f64 * power
        };
        // A long mantissa is rounded as well: both roundings are 1.5 units at most.
        let doubt = if mantissa > MAX_MANTISSA { 2 } else { 0 };
        round_again(value, doubt)
    }
}

fn split_sign(word: &[u8]) -> (bool, &[u8]) {
    match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    }
}

/// The bits of an `f64` that an `f32` has no room for, and half of that.
const LOST: u64 = (1 << 29) - 1;
const HALFWAY: u64 = 1 << 28;

/// The `f32` nearest to a real number, given an `f64` that is the nearest to it or wrong
/// by no more than `doubt` units in the last place; nothing where that can't be told, or
/// at the ends of the range.
fn round_again(value: f64, doubt: u64) -> Option<f32> {
    const NORMAL: std::ops::RangeInclusive<f64> = f32::MIN_POSITIVE as f64..=f32::MAX as f64;
    if (value.to_bits() & LOST).abs_diff(HALFWAY) <= doubt {
        return None;
    }
    if !NORMAL.contains(&value) && value != 0.0 {
        return None;
    }
    Some(value as f32)
}

#[inline(always)]
fn with_sign(magnitude: f32, negative: bool) -> f32 {
    f32::from_bits(magnitude.to_bits() | u32::from(negative) << 31)
}

/// Whole numbers up to this are exact in `f64`.
const MAX_MANTISSA: u64 = 1 << f64::MANTISSA_DIGITS;

/// The powers of ten that are exact in `f64`.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17, 1e18, 1e19, 1e20, 1e21, 1e22,
];

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Both ways through this module, and the standard library, on one word.
    fn check(word: &str) {
        let standard: f32 = word.parse().expect("a number");
        let expected = standard.is_finite().then_some(standard.to_bits());
        let parsed = parse(word.as_bytes());
        assert_eq!(parsed.ok().map(f32::to_bits), expected, "{word}");
        assert_eq!(parsed.is_err(), parsed == Err(Refusal::TooLarge), "{word}");
        for after in ["", " ", "\n0123456789abcdef", "#5", " 0.1 0.2 0.3 0.4 0.5"] {
            let taken = take(format!("{word}{after}").as_bytes(), 0);
            let expected = expected.map(|bits| (bits, word.len()));
            assert_eq!(
                taken.map(|(number, end)| (number.to_bits(), end)),
                expected,
                "{word}{after}"
            );
        }
        // The quick way may pass, but must not be wrong.
        for before in ["", " S 1"] {
            if let (Some(number), _) = quickly(before, word) {
                assert_eq!(Some(number.to_bits()), expected, "{word}");
            }
        }
    }

    /// What a span makes of a word, as a number and as an integer, among numbers that
    /// it reads.
    fn quickly(before: &str, word: &str) -> (Option<f32>, Option<u8>) {
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

    /// `SplitMix64`.
    fn random(state: &mut u64) -> u64 {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = *state;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
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

    #[test]
    fn floats_of_every_size_come_back_in_every_notation() {
        for trial in 0..400_000 {
            let number = f32::from_bits(random(&mut { trial }) as u32);
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
    fn ordinary_words_go_the_quick_way_and_no_others() {
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
            let found = quickly(" S ", word).0.map(f32::to_bits);
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
        ];
        for word in others {
            assert_eq!(quickly(" S ", word).0, None, "{word}");
        }
    }

    #[test]
    fn halfway_points_and_their_neighbours_round_as_they_should() {
        for trial in 0..100_000 {
            let seed = random(&mut { trial });
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
            assert_eq!(parse(word.as_bytes()), Err(Refusal::Malformed), "{word}");
            if !word.contains(' ') {
                assert_eq!(take(word.as_bytes(), 0), None, "{word}");
                assert_eq!(quickly("", word), (None, None), "{word}");
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
            assert_eq!(parse_integer(word.as_bytes()), integer, "{word}");
            let byte = integer.and_then(|integer| u8::try_from(integer).ok());
            for after in ["", " ", "\n12345678", "#12345678"] {
                let taken = take_byte(format!("{word}{after}").as_bytes(), 0);
                assert_eq!(taken, byte.map(|byte| (byte, word.len())), "{word}{after}");
            }
            if let (_, Some(found)) = quickly("S ", word) {
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
            prop_assert_eq!(parse(word.as_bytes()).ok(), standard);
        }
    }
}
