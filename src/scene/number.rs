//! Decimal text to the nearest `f32`, rounded once.
//!
//! An ordinary number has at most 15 digits and no exponent. The algorithm:
//!
//! ```text
//! mantissa, power = 0, 1                         // f64
//! for each digit:
//!     mantissa = 10 * mantissa + digit           // exact: below 2^53
//!     if it is behind the point: power *= 10     // exact: up to 10^15
//! value = mantissa / power                       // rounded once: the nearest f64
//! if value is halfway between two f32: ask the standard library
//! return value as f32, with the sign             // rounded again
//! ```
//!
//! The division is that of Clinger (How to Read Floating Point Numbers Accurately,
//! 1990). Rounding to `f32` afterwards gives the `f32` nearest to the text: rounding
//! keeps the order, so that it never crosses the point halfway between two `f32`. It can
//! land on that point from either side, and only there a second rounding can be wrong.
//!
//! [`Span`] computes this for the four numbers of a sphere at once. It departs from the
//! algorithm above in three ways:
//!
//! 1. The ends of all words in 64 bytes are found first, as bits of a word of 64 bits.
//!    No number waits for the end of the number before it.
//! 2. A shuffle moves the digits of a number to the end of a vector of 16 bytes and
//!    leaves out the point. Pairs, fours and eights of digits are then added up in lanes.
//! 3. The powers of ten come from a table.
//!
//! All other numbers are read by the standard library, which is correctly rounded.

use wide::{f64x4, i8x32, i16x8, i16x16, u8x16, u64x4};

/// Why a word is not a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// It is not decimal with optional sign, fraction and exponent.
    Malformed,
    /// It is, and rounds to something beyond the largest `f32`.
    TooLarge,
}

/// The `f32` nearest to a whole word.
pub(super) fn parse(word: &str) -> Result<f32, Refusal> {
    match word.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        // The standard library also takes the names of infinity and NaN.
        Ok(_) if word.contains(|c: char| c.is_ascii_digit()) => Err(Refusal::TooLarge),
        _ => Err(Refusal::Malformed),
    }
}

/// Whether a number that `parse` takes is zero as written, not by rounding.
pub(super) fn is_zero_as_written(word: &str) -> bool {
    let mantissa = word.split(['e', 'E']).next().unwrap_or_default();
    !mantissa.contains(|c| matches!(c, '1'..='9'))
}

/// The integer that a whole word of digits with an optional sign is; one too
/// large for `i64` becomes the largest of its sign.
pub(super) fn parse_integer(word: &str) -> Option<i64> {
    let (sign, digits) = match word.as_bytes() {
        [b'-', digits @ ..] => (-1, digits),
        [b'+', digits @ ..] | digits => (1, digits),
    };
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let append = |integer: i64, digit: &u8| {
        let digit = i64::from(digit - b'0');
        integer.saturating_mul(10).saturating_add(digit)
    };
    Some(sign * digits.iter().fold(0, append))
}

/// The bytes of a span.
pub(super) const SPAN: usize = 64;

/// A piece of text, and for each kind of byte a set of its places, the first in the
/// lowest bit.
pub(super) struct Span<'a> {
    /// Sixteen more, so that a vector of 16 can be loaded at any place.
    bytes: &'a [u8; SPAN + 16],
    pub(super) blanks: u64,
    points: u64,
    /// All bytes that are not digits.
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
            // Shifted so that the wanted bytes are at one end of the range of `i8`.
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

    /// The numbers that four words are, if all are ordinary. Each word has
    /// `start < end < SPAN`; they are in order, with only blanks between them.
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
            ordinary &= (1..=MAX_DIGITS).contains(&count);
            digits[number] = self.digits(first, whole, count);
            signs[number] = u32::from(negative) << 31;
            fractions[number] = fraction;
        }
        // The words hold no sign and no point besides those that were found.
        let in_words = (bit(words[3].1) - bit(words[0].0)) & !self.blanks;
        if !ordinary || self.others & in_words != expected & in_words {
            return None;
        }
        let [a, b] = [[digits[0], digits[1]], [digits[2], digits[3]]].map(eights_of_digits);
        let high = f64x4::new([a[0], a[2], b[0], b[2]].map(f64::from));
        let low = f64x4::new([a[1], a[3], b[1], b[3]].map(f64::from));
        // Below 2^53, so exact.
        let mantissa = high * f64x4::splat(1e8) + low;
        let powers = f64x4::new(fractions.map(|fraction| POWERS[fraction % (MAX_DIGITS + 1)]));
        let values = mantissa / powers;
        let lost = bytemuck::cast::<_, u64x4>(values) & u64x4::splat(LOST);
        if lost.simd_eq(u64x4::splat(HALFWAY)).any() {
            return None;
        }
        // All of these are zero or normal, and finite: see `MAX_DIGITS`.
        let magnitudes = values.to_array().map(|value| (value as f32).to_bits());
        Some(std::array::from_fn(|number| {
            f32::from_bits(magnitudes[number] | signs[number])
        }))
    }

    /// The values of `count` digits, at most 15, at the end of a vector, with zeros before
    /// them. They begin at `first`; the byte after `whole` of them is a point, left out.
    #[inline(always)]
    fn digits(&self, first: usize, whole: usize, count: usize) -> u8x16 {
        let bytes: Option<&[u8; 16]> = self.bytes[first % SPAN..].first_chunk();
        let values = u8x16::new(bytes.map_or([0; 16], |bytes| *bytes)) ^ u8x16::splat(b'0');
        values.shuffle(u8x16::new(DIGITS_LAST[whole % 16][count % 16]))
    }

    /// The integer that the bytes from `start` to `end` are, if it is at most 255 and has
    /// at most 3 digits. `start < end < SPAN`.
    #[inline(always)]
    pub(super) fn integer(&self, start: usize, end: usize) -> Option<u8> {
        let count = end - start;
        if self.others & (bit(end) - bit(start)) != 0 || count > 3 {
            return None;
        }
        let bytes = self.bytes[start % SPAN..].first_chunk();
        let bytes = bytes.map_or(0, |bytes| u32::from_le_bytes(*bytes));
        // Now the upper three bytes are hundreds, tens and ones, zero where there is none.
        let digits = (bytes ^ u32::from_le_bytes([b'0'; 4])) << (32 - 8 * count);
        let hundreds = digits >> 8 & 0xff;
        let rest = ((digits >> 16) * (10 * 0x100 + 1)) >> 8 & 0xff;
        u8::try_from(100 * hundreds + rest).ok()
    }
}

/// Upper bound of the digits of an ordinary number. So many are exact in `f64`. A number
/// from 1 to 10^15 divided by up to 10^15 is a normal `f32`.
const MAX_DIGITS: usize = 15;

/// For each number of digits before the point and of all digits: the byte that a shuffle
/// moves to each place. 0x80 makes it a zero.
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

/// The values of two times two groups of eight digits.
#[inline(always)]
fn eights_of_digits(digits: [u8x16; 2]) -> [i32; 4] {
    let pairs = pairs_of_digits(bytemuck::cast(digits), i16::from_ne_bytes(TENS_AND_ONES));
    let weights = |high: i16| i16x16::new(std::array::from_fn(|lane| [high, 1][lane % 2]));
    let fours = i16x8::from_i32x8_saturate(pairs.dot(weights(100)));
    let weights = i16x8::new(std::array::from_fn(|lane| [10_000, 1][lane % 2]));
    fours.dot(weights).to_array()
}

/// The weights of two digits, in the order in which they are in memory.
const TENS_AND_ONES: [u8; 2] = [1, 10];

/// The value of the two digits in each lane, tens before ones in memory. The high byte of
/// the product is the sum of tens times 10 and ones times 1, in either byte order: digits
/// and weights have the same order.
#[inline(always)]
fn pairs_of_digits(digits: i16x16, weights: i16) -> i16x16 {
    (digits * i16x16::splat(weights)) >> 8_i32
}

#[inline(always)]
fn bit(place: usize) -> u64 {
    1 << (place % SPAN)
}

/// The bits of an `f64` that an `f32` has no room for, and their value halfway between
/// two `f32`.
const LOST: u64 = (1 << 29) - 1;
const HALFWAY: u64 = 1 << 28;

/// The powers of ten that a number is divided by; all are exact in `f64`.
const POWERS: [f64; MAX_DIGITS + 1] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
];

#[cfg(test)]
mod tests;
