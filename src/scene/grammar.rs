//! The grammar of a scene: which words stand where, and which values they may have.

use super::number::{self, Refusal};
use crate::spheres::{Rgb, Sphere};

/// What a word must be. The names are those that messages give it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Item {
    Keyword(&'static str),
    /// A number greater than zero.
    Length(&'static str),
    Coordinate(&'static str),
    Colour(&'static str),
    /// How many spheres follow.
    Count,
}

/// The words before the spheres.
pub(super) const HEADER: [Item; 10] = [
    Item::Keyword("VP"),
    Item::Length("width"),
    Item::Length("height"),
    Item::Length("distance"),
    Item::Keyword("BG"),
    Item::Colour("red"),
    Item::Colour("green"),
    Item::Colour("blue"),
    Item::Keyword("OBJ_N"),
    Item::Count,
];

/// The words of a sphere.
pub(super) const SPHERE: [Item; 8] = [
    Item::Keyword("S"),
    Item::Coordinate("x"),
    Item::Coordinate("y"),
    Item::Coordinate("z"),
    Item::Length("radius"),
    Item::Colour("red"),
    Item::Colour("green"),
    Item::Colour("blue"),
];

/// In both tables numbers begin at the second word and colours at the sixth.
const FIRST_NUMBER: usize = 1;
const FIRST_COLOUR: usize = 5;

/// The letter that begins a sphere.
pub(super) const SPHERE_LETTER: u8 = b'S';

/// Bytes of the shortest sphere, `S 0 0 0 1 0 0 0` and a line feed.
pub(super) const SHORTEST_SPHERE: u64 = 16;

/// The values of the words of one table, as far as they have been read.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Values {
    pub(super) numbers: [f32; 4],
    pub(super) colour: Rgb,
    pub(super) count: u32,
}

/// Why a word does not fit the grammar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mismatch {
    /// It is another word than the keyword.
    Keyword(&'static str),
    NotANumber,
    TooLarge,
    /// A length that is this number.
    NotPositive(f32),
    NotAnInteger,
    OutOfRange,
}

impl From<Refusal> for Mismatch {
    fn from(refusal: Refusal) -> Self {
        match refusal {
            Refusal::Malformed => Self::NotANumber,
            Refusal::TooLarge => Self::TooLarge,
        }
    }
}

impl Values {
    /// Takes the word that stands at `place` of a table, where it has `item`.
    #[inline(always)]
    pub(super) fn take(&mut self, item: Item, place: usize, word: &str) -> Result<(), Mismatch> {
        match item {
            Item::Keyword(keyword) => {
                if word != keyword {
                    return Err(Mismatch::Keyword(keyword));
                }
            }
            Item::Length(_) | Item::Coordinate(_) => {
                let number = number::parse(word)?;
                if !item.admits(number) {
                    return Err(Mismatch::NotPositive(number));
                }
                self.numbers[place - FIRST_NUMBER] = number;
            }
            Item::Colour(_) => self.colour[place - FIRST_COLOUR] = integer(word)?,
            Item::Count => self.count = integer(word)?,
        }
        Ok(())
    }

    /// The sphere that these values are.
    #[inline(always)]
    pub(super) fn sphere(&self) -> Sphere {
        let [x, y, z, radius] = self.numbers;
        Sphere {
            centre: [x, y, z],
            radius,
            colour: self.colour,
        }
    }

    /// Whether the numbers of a sphere are those that its words admit.
    #[inline(always)]
    pub(super) fn are_of_a_sphere(&self) -> bool {
        let items = SPHERE[FIRST_NUMBER..].iter();
        items
            .zip(self.numbers)
            .all(|(item, number)| item.admits(number))
    }
}

impl Item {
    /// Whether a number is in the range of this item.
    #[inline(always)]
    fn admits(self, number: f32) -> bool {
        !matches!(self, Self::Length(_)) || number > 0.0
    }
}

fn integer<T: TryFrom<i64>>(word: &str) -> Result<T, Mismatch> {
    let integer = number::parse_integer(word).ok_or(Mismatch::NotAnInteger)?;
    T::try_from(integer).map_err(|_| Mismatch::OutOfRange)
}

/// Whether a word is a keyword of a scene.
pub(super) fn is_keyword(word: &[u8]) -> bool {
    let is_it = |item: &Item| matches!(item, Item::Keyword(keyword) if keyword.as_bytes() == word);
    HEADER.iter().chain(&SPHERE).any(is_it)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The chunks count spheres by their letter, and reserve memory by their length.
    #[test]
    fn the_letter_and_the_length_of_a_sphere_are_those_of_the_grammar() {
        let begins = |item: &Item| matches!(item, Item::Keyword(keyword) if keyword.as_bytes() == [SPHERE_LETTER]);
        assert!(begins(&SPHERE[0]));
        assert!(!SPHERE[1..].iter().any(begins));
        // A letter or a digit each, and a byte between two words.
        assert_eq!(SHORTEST_SPHERE, 2 * SPHERE.len() as u64);
    }

    #[test]
    fn each_item_admits_what_it_should() {
        let take = |item, place, word: &str| {
            let mut values = Values::default();
            values.take(item, place, word).map(|()| values)
        };
        let (length, coordinate, red) = (SPHERE[4], SPHERE[1], SPHERE[5]);
        for (item, place, word, mismatch) in [
            (SPHERE[0], 0, "s", Mismatch::Keyword("S")),
            (SPHERE[0], 0, "S1", Mismatch::Keyword("S")),
            (coordinate, 1, "x", Mismatch::NotANumber),
            (coordinate, 1, "1e39", Mismatch::TooLarge),
            (length, 4, "0", Mismatch::NotPositive(0.0)),
            (length, 4, "-1", Mismatch::NotPositive(-1.0)),
            (length, 4, "1e-46", Mismatch::NotPositive(0.0)),
            (red, 5, "1.0", Mismatch::NotAnInteger),
            (red, 5, "256", Mismatch::OutOfRange),
            (red, 5, "-1", Mismatch::OutOfRange),
            (Item::Count, 9, "4294967296", Mismatch::OutOfRange),
            (Item::Count, 9, "x", Mismatch::NotAnInteger),
        ] {
            assert_eq!(take(item, place, word).err(), Some(mismatch), "{word}");
        }
        let number = |place: usize, word| take(SPHERE[place], place, word).expect("a number");
        assert_eq!(number(1, "-1").numbers, [-1.0, 0.0, 0.0, 0.0]);
        assert_eq!(number(3, "0").numbers, [0.0; 4]);
        assert_eq!(number(4, "1e-45").numbers, [0.0, 0.0, 0.0, 1e-45]);
        assert_eq!(number(7, "255").colour, [0, 0, 255]);
        let count = take(Item::Count, 9, "4294967295").expect("a count");
        assert_eq!(count.count, u32::MAX);
    }
}
