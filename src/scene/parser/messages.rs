//! What the parser says of a text that is not a scene.

use super::{Fault, FaultPlace, Parser};
use crate::scene::{
    advice::{self, COMMENT_HELP, WordKind},
    comment::Comment,
    error::SceneErrorKind as Kind,
    excerpt::{LONGEST_QUOTE, quoted, quoted_beginning},
    foreign,
    grammar::{Item, Mismatch, is_keyword},
    number,
    text::MAX_WORD,
};

const VP_HELP: &str = "VP takes 3 numbers: VP width height distance";
const BG_HELP: &str = "BG takes 3 integers: BG red green blue";
const COUNT_HELP: &str = "OBJ_N takes one integer, the number of spheres that follow";
const HEADER_HELP: &str =
    "a scene begins: VP width height distance, BG red green blue, OBJ_N number-of-spheres";
const SPHERE_HELP: &str = "a sphere is: S x y z radius red green blue";

/// A word that does not fit.
impl Parser {
    /// Only a part of the word may be in memory, so that no more of it is shown.
    pub(super) fn too_long(&self, word: &[u8]) -> Fault {
        if let Some(fault) = self.not_a_scene(word) {
            return fault;
        }
        let expected = if self.is_complete() {
            self.describe_end()
        } else {
            self.describe(self.expected())
        };
        let message = format!(
            "expected {expected}, found a word of more than {MAX_WORD} bytes, {}",
            quoted_beginning(word)
        );
        let help = "no word of a scene needs more bytes than that";
        fault(Kind::WordTooLong, message, Some(help.to_owned()))
    }

    /// A file of another kind, if this is its first word.
    fn not_a_scene(&self, word: &[u8]) -> Option<Fault> {
        if self.in_spheres || self.word != 0 {
            return None;
        }
        let (name, help) = foreign::kind(word)?;
        let message = format!("expected a scene, found {name}");
        Some(fault(Kind::NotAScene, message, Some(help.to_owned())))
    }

    pub(super) fn mismatch(&self, mismatch: Mismatch, item: Item, word: &[u8]) -> Fault {
        let (kind, help) = match mismatch {
            Mismatch::Keyword(keyword) => {
                if let Some(fault) = self.not_a_scene(word) {
                    return fault;
                }
                (Kind::Keyword, Some(self.help_with_keyword(keyword, word)))
            }
            Mismatch::NotANumber => (Kind::Number, self.help_with_number(word)),
            Mismatch::TooLarge => {
                let largest = f32::MAX;
                let help =
                    format!("the largest number that a 32-bit float can hold is {largest:e}");
                (Kind::TooLarge, Some(help))
            }
            Mismatch::NotPositive(number) => {
                (Kind::NotPositive, Some(self.help_with_length(number, word)))
            }
            Mismatch::NotAnInteger => (Kind::Integer, self.help_with_integer(item, word)),
            Mismatch::OutOfRange => (Kind::OutOfRange, None),
        };
        let message = format!("expected {}, found {}", self.describe(item), quoted(word));
        fault(kind, message, help)
    }

    fn help_with_keyword(&self, keyword: &str, word: &[u8]) -> String {
        if word.eq_ignore_ascii_case(keyword.as_bytes()) {
            return format!("write {keyword} in capital letters");
        }
        let rest = word.strip_prefix(keyword.as_bytes());
        if rest.is_some_and(advice::goes_on_with_number) {
            return format!("put a blank after {keyword}");
        }
        let help = match WordKind::of(word) {
            WordKind::ForeignComment => COMMENT_HELP,
            WordKind::Number => match keyword {
                "BG" => VP_HELP,
                "OBJ_N" => return format!("{BG_HELP}; then comes OBJ_N number-of-spheres"),
                "S" if self.sphere_number() == 1 => COUNT_HELP,
                "S" => return self.sphere_has_all(),
                _ => HEADER_HELP,
            },
            WordKind::Keyword => {
                "VP, BG and OBJ_N stand once each, in this order, then the spheres"
            }
            WordKind::NotText(help) => help,
            WordKind::Other if self.in_spheres => SPHERE_HELP,
            WordKind::Other => HEADER_HELP,
        };
        help.to_owned()
    }

    fn help_with_number(&self, word: &[u8]) -> Option<String> {
        if is_keyword(word) {
            return Some(self.help_with_missing_words());
        }
        advice::for_number(word)
    }

    fn help_with_integer(&self, item: Item, word: &[u8]) -> Option<String> {
        let text = str::from_utf8(word).unwrap_or_default();
        let help = match number::parse(text) {
            Ok(0.0..=1.0) if matches!(item, Item::Colour(_)) => {
                "colours run from 0 to 255, without fractions"
            }
            Ok(_) => "write it without a fraction or an exponent",
            Err(_) if number::parse_integer(&text.replace(',', "")).is_some() => {
                "write it without commas"
            }
            Err(_) => return self.help_with_number(word),
        };
        Some(help.to_owned())
    }

    /// What to do about a length that is not greater than zero.
    fn help_with_length(&self, number: f32, word: &[u8]) -> String {
        // It was read as a number, so that it is text.
        let word = str::from_utf8(word).unwrap_or_default();
        if number == 0.0 && !number::is_zero_as_written(word) {
            if word.starts_with('-') {
                return "it rounds to 0 as a 32-bit float".to_owned();
            }
            let smallest = f32::from_bits(1);
            return format!(
                "it is so small that it rounds to 0 as a 32-bit float; the smallest number that does not is {smallest:e}",
            );
        }
        let write = match word.strip_prefix('-') {
            Some(positive) if number < 0.0 && positive.len() <= LONGEST_QUOTE => {
                format!("write {positive}")
            }
            _ if number < 0.0 => "write it without the sign".to_owned(),
            _ if self.in_spheres => "give it a radius".to_owned(),
            _ => return "a usual viewport is VP 1 1 1".to_owned(),
        };
        if self.in_spheres {
            let fewer = self.announced - 1;
            format!("{write}, or remove the sphere and lower OBJ_N to {fewer}")
        } else {
            write
        }
    }

    /// Which words belong together, where some of them are missing.
    fn help_with_missing_words(&self) -> String {
        if let Some(help) = self.comment.as_ref().and_then(Comment::help) {
            return help;
        }
        let mut help = if self.in_spheres {
            let found = match self.word - 1 {
                0 => "none".to_owned(),
                found => format!("only {found}"),
            };
            format!(
                "sphere {} has {found} of its 7 numbers: S x y z radius red green blue",
                self.sphere_number()
            )
        } else {
            match self.word {
                0..=3 => VP_HELP,
                5..=7 => BG_HELP,
                9 => COUNT_HELP,
                _ => "VP, BG and OBJ_N come first, in this order, then the spheres",
            }
            .to_owned()
        };
        if self.comment.is_some() {
            help.push_str("; what follows a # is a comment");
        }
        help
    }

    /// A word behind the last sphere.
    pub(super) fn trailing(&self, word: &[u8]) -> Fault {
        let announced = spheres(self.announced);
        if word == b"S" {
            let message = format!("OBJ_N says {announced}, but another one follows");
            let help = match self.announced {
                0 => "raise OBJ_N, or remove the spheres".to_owned(),
                last => format!("raise OBJ_N, or remove what follows sphere {last}"),
            };
            return fault(Kind::TooManySpheres, message, Some(help));
        }
        let message = format!("expected {}, found {}", self.describe_end(), quoted(word));
        let help = match WordKind::of(word) {
            WordKind::ForeignComment => COMMENT_HELP.to_owned(),
            WordKind::Number if self.announced == 0 => COUNT_HELP.to_owned(),
            WordKind::Number => self.sphere_has_all(),
            WordKind::Keyword => "a file holds one scene".to_owned(),
            WordKind::NotText(help) => help.to_owned(),
            WordKind::Other => "remove it, or put # before it".to_owned(),
        };
        fault(Kind::Trailing, message, Some(help))
    }

    fn sphere_has_all(&self) -> String {
        format!(
            "sphere {} has all of its 7 numbers: S x y z radius red green blue",
            self.sphere_number() - 1
        )
    }

    pub(super) fn no_memory(&self) -> Fault {
        let message = format!("not enough memory for {}", spheres(self.announced));
        fault(Kind::Memory, message, None)
    }
}

/// The end of the file.
impl Parser {
    /// The fault of a file that ends here, if it may not. `is_empty` says that it holds no
    /// byte, `is_blank` that it holds no word.
    pub(in crate::scene) fn finish(&self, is_blank: bool, is_empty: bool) -> Result<(), Fault> {
        if self.is_complete() {
            return Ok(());
        }
        let (kind, message, help) = if is_blank {
            let found = if is_empty {
                "the file is empty"
            } else {
                "the file holds nothing but blanks and comments"
            };
            let message = format!("expected VP, the viewport, but {found}");
            let help = "the smallest scene is: VP 1 1 1 BG 0 0 0 OBJ_N 0";
            (Kind::Empty, message, help.to_owned())
        } else if self.in_spheres && self.word == 0 {
            let (announced, read) = (spheres(self.announced), self.announced - self.left);
            let message = format!("OBJ_N says {announced}, but the file ends after {read}");
            let help = format!("add {}, or lower OBJ_N to {read}", spheres(self.left));
            (Kind::TooFewSpheres, message, help)
        } else {
            let expected = self.describe(self.expected());
            let message = format!("expected {expected}, but the file ends");
            (Kind::Incomplete, message, self.help_with_missing_words())
        };
        let help = if self.return_in_comment {
            "a comment goes on past a lone carriage return: end lines with a line feed".to_owned()
        } else {
            help
        };
        Err(Fault {
            place: FaultPlace::End,
            ..fault(kind, message, Some(help))
        })
    }
}

/// What is expected.
impl Parser {
    fn describe(&self, item: Item) -> String {
        let owner = match self.word {
            _ if self.in_spheres => format!("sphere {}", self.sphere_number()),
            0..=3 => "the viewport".to_owned(),
            _ => "the background".to_owned(),
        };
        match item {
            Item::Keyword("VP") => "VP, the viewport".to_owned(),
            Item::Keyword("BG") => "BG, the background".to_owned(),
            Item::Keyword("OBJ_N") => "OBJ_N, the number of spheres".to_owned(),
            Item::Keyword(keyword) => {
                format!("{keyword}, the beginning of {owner} of {}", self.announced)
            }
            Item::Length(name) => format!("the {name} of {owner}, a number greater than 0"),
            Item::Coordinate(name) => format!("the {name} of {owner}, a decimal number"),
            Item::Colour(name) => format!("the {name} of {owner}, an integer from 0 to 255"),
            Item::Count => format!("the number of spheres, an integer from 0 to {}", u32::MAX),
        }
    }

    fn describe_end(&self) -> String {
        if self.announced == 0 {
            "the end of the file after OBJ_N 0".to_owned()
        } else {
            let announced = spheres(self.announced);
            format!("the end of the file after the last of {announced}")
        }
    }

    /// The sphere that is being read, from 1.
    fn sphere_number(&self) -> u64 {
        u64::from(self.announced - self.left) + 1
    }
}

fn fault(kind: Kind, message: String, help: Option<String>) -> Fault {
    Fault {
        place: FaultPlace::Nowhere,
        kind,
        message,
        help,
    }
}

fn spheres(count: u32) -> String {
    format!("{count} sphere{}", if count == 1 { "" } else { "s" })
}
