//! The scene text, word by word: the judge of what is a scene and what is not.
//!
//! Simple rather than fast. It remembers between two pieces of text all that
//! matters, so that a text may be cut between any two words, and inside a
//! comment.

use std::collections::TryReserveError;

use super::{
    Viewport,
    advice::{self, COMMENT_HELP},
    error::{LONGEST_QUOTE, SceneErrorKind as Kind, foreign, quoted, quoted_beginning},
    number::{self, MAX_WORD, Refusal, is_blank, word_end},
};
use crate::spheres::{Rgb, Sphere, Spheres};

/// What a word must be.
#[derive(Clone, Copy)]
enum Item {
    Keyword(&'static str),
    /// A number greater than zero.
    Length(&'static str),
    Coordinate(&'static str),
    Colour(&'static str),
    Count,
}

/// What stands before the spheres.
const HEADER: [Item; 10] = [
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

/// One sphere.
const SPHERE: [Item; 8] = [
    Item::Keyword("S"),
    Item::Coordinate("x"),
    Item::Coordinate("y"),
    Item::Coordinate("z"),
    Item::Length("radius"),
    Item::Colour("red"),
    Item::Colour("green"),
    Item::Colour("blue"),
];

/// In both tables lengths begin at the second word and colours at the sixth.
const FIRST_LENGTH: usize = 1;
const FIRST_COLOUR: usize = 5;

const VP_HELP: &str = "VP takes 3 numbers: VP width height distance";
const BG_HELP: &str = "BG takes 3 integers: BG red green blue";
const COUNT_HELP: &str = "OBJ_N takes one integer, the number of spheres that follow";
const HEADER_HELP: &str =
    "a scene begins: VP width height distance, BG red green blue, OBJ_N number-of-spheres";
const SPHERE_HELP: &str = "a sphere is: S x y z radius red green blue";

/// What is wrong, and where in the text at hand.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) place: FaultPlace,
    pub(super) kind: Kind,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum FaultPlace {
    /// At this byte of the text at hand.
    At(usize),
    /// Behind the last word of the file.
    End,
    /// Nowhere in particular.
    Nowhere,
}

/// How far [`Parser::judge`] goes.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Until {
    /// To the first place between two words where a sphere may begin.
    Sphere,
    End,
}

/// Everything read so far.
#[derive(Debug)]
pub(super) struct Parser {
    pub(super) viewport: Viewport,
    pub(super) background: Rgb,
    pub(super) spheres: Spheres,
    /// Spheres that the file has yet to bring.
    pub(super) left: u32,
    claimed: u32,
    /// Index into the header, then into a sphere, of the word expected.
    word: usize,
    in_spheres: bool,
    lengths: [f32; 4],
    colour: Rgb,
    pub(super) in_comment: bool,
    /// Whether the last byte of a comment so far is a carriage return.
    after_return: bool,
    /// Whether a comment before the spheres holds a carriage return that is not
    /// part of a line end.
    return_in_comment: bool,
    /// The first comment amid the numbers that are being read.
    amid: Option<Comment>,
}

/// The beginning of a comment, as far as a message may need it.
#[derive(Debug, Default)]
struct Comment {
    /// The word that ends where the comment begins.
    glued_to: Vec<u8>,
    /// Its bytes behind the `#`, up to a blank.
    begin: Vec<u8>,
    is_complete: bool,
    /// Whether a colour was expected.
    is_colour: bool,
}

impl Comment {
    fn take(&mut self, byte: u8) {
        self.is_complete |= is_blank(byte) || self.begin.len() == LONGEST_QUOTE / 2;
        if !self.is_complete {
            self.begin.push(byte);
        }
    }

    /// Words that people write and do not mean as a comment.
    fn help(&self) -> Option<String> {
        let begin = [b"#", &self.begin[..]].concat();
        if let Some(help) = advice::for_not_finite(&self.glued_to, &begin) {
            return Some(help);
        }
        let [red, green, blue] = advice::web_colour(&self.begin).filter(|_| self.is_colour)?;
        Some(format!(
            "a # begins a comment, so that {} was not read: write {red} {green} {blue}",
            quoted(&begin),
        ))
    }
}

impl Parser {
    pub(super) fn new() -> Self {
        Self {
            viewport: Viewport {
                width: 1.0,
                height: 1.0,
                distance: 1.0,
            },
            background: [0; 3],
            spheres: Spheres::default(),
            left: 0,
            claimed: 0,
            word: 0,
            in_spheres: false,
            lengths: [0.0; 4],
            colour: [0; 3],
            in_comment: false,
            after_return: false,
            return_in_comment: false,
            amid: None,
        }
    }

    /// Whether the next word, if any, begins a sphere.
    pub(super) fn is_before_sphere(&self) -> bool {
        self.in_spheres && self.word == 0 && !self.in_comment
    }

    /// Reads `text[at..to]`, which holds whole words, and says how far it came.
    pub(super) fn judge(
        &mut self,
        text: &[u8],
        mut at: usize,
        to: usize,
        until: Until,
        keep: &dyn Fn(&Sphere) -> bool,
    ) -> Result<usize, Fault> {
        loop {
            if until == Until::Sphere && self.is_before_sphere() {
                return Ok(at);
            }
            at = self.skip_blanks(text, at, to);
            if at == to {
                return Ok(at);
            }
            let end = word_end(&text[..to], at);
            self.take(&text[at..end], keep).map_err(|refusal| Fault {
                place: match refusal.kind {
                    Kind::Memory => FaultPlace::Nowhere,
                    _ => FaultPlace::At(at),
                },
                ..refusal
            })?;
            at = end;
        }
    }

    fn skip_blanks(&mut self, text: &[u8], mut at: usize, to: usize) -> usize {
        while at < to {
            let byte = text[at];
            if self.in_comment {
                if byte == b'\n' {
                    self.in_comment = false;
                } else if self.after_return && !self.in_spheres {
                    self.return_in_comment = true;
                }
                self.after_return = byte == b'\r';
                if let Some(comment) = &mut self.amid {
                    comment.take(byte);
                }
            } else if byte == b'#' {
                self.in_comment = true;
                self.after_return = false;
                self.begin_comment(&text[..at]);
            } else if !is_blank(byte) {
                break;
            }
            at += 1;
        }
        at
    }

    /// Remembers a comment where a number is expected. `before` is the text that it
    /// ends.
    fn begin_comment(&mut self, before: &[u8]) {
        let item = self.items()[self.word];
        if let Some(comment) = &mut self.amid {
            comment.is_complete = true;
        } else if !matches!(item, Item::Keyword(_)) {
            let near = &before[before.len().saturating_sub(LONGEST_QUOTE / 2)..];
            let glued_to = near.rsplit(|&byte| is_blank(byte)).next();
            self.amid = Some(Comment {
                glued_to: glued_to.unwrap_or_default().to_vec(),
                is_colour: matches!(item, Item::Colour(_)),
                ..Comment::default()
            });
        }
    }

    fn take(&mut self, word: &[u8], keep: &dyn Fn(&Sphere) -> bool) -> Result<(), Fault> {
        if word.len() > MAX_WORD {
            return Err(self.too_long(word));
        }
        if self.in_spheres && self.left == 0 {
            return Err(self.trailing(word));
        }
        let items = self.items();
        let item = items[self.word];
        match item {
            Item::Keyword(keyword) => {
                if word != keyword.as_bytes() {
                    return Err(self.not_keyword(keyword, word));
                }
            }
            Item::Length(_) | Item::Coordinate(_) => {
                self.lengths[self.word - FIRST_LENGTH] = self.number(item, word)?;
            }
            Item::Colour(_) => {
                let value = self.integer(item, word)?;
                let Ok(value) = u8::try_from(value) else {
                    return Err(self.out_of_range(item, word));
                };
                self.colour[self.word - FIRST_COLOUR] = value;
            }
            Item::Count => {
                let value = self.integer(item, word)?;
                let Ok(value) = u32::try_from(value) else {
                    return Err(self.out_of_range(item, word));
                };
                self.claimed = value;
                self.left = value;
            }
        }
        self.word += 1;
        if matches!(items.get(self.word), None | Some(Item::Keyword(_))) {
            self.amid = None;
        }
        if self.word == items.len() {
            self.finish_item(keep).map_err(|_| self.no_memory())?;
        }
        Ok(())
    }

    fn finish_item(&mut self, keep: &dyn Fn(&Sphere) -> bool) -> Result<(), TryReserveError> {
        self.word = 0;
        let [x, y, z, radius] = self.lengths;
        if !self.in_spheres {
            self.in_spheres = true;
            self.background = self.colour;
            self.viewport = Viewport {
                width: x,
                height: y,
                distance: z,
            };
            return Ok(());
        }
        self.left -= 1;
        let sphere = Sphere {
            centre: [x, y, z],
            radius,
            colour: self.colour,
        };
        if keep(&sphere) {
            self.spheres.try_grow(1)?.set(0, sphere);
        }
        Ok(())
    }

    fn number(&self, item: Item, word: &[u8]) -> Result<f32, Fault> {
        let number = match number::parse(word) {
            Ok(number) => number,
            Err(refusal) => {
                let kind = match refusal {
                    Refusal::Malformed => Kind::Number,
                    Refusal::TooLarge => Kind::TooLarge,
                };
                let help = match refusal {
                    Refusal::Malformed => self.help_with_number(word),
                    Refusal::TooLarge => Some(format!(
                        "the largest number that a 32-bit float can hold is {:e}",
                        f32::MAX
                    )),
                };
                return Err(self.expected(kind, item, word, help));
            }
        };
        if matches!(item, Item::Coordinate(_)) || number > 0.0 {
            return Ok(number);
        }
        let help = if number < 0.0 || number::is_zero_as_written(word) {
            Some(self.help_with_length(number, word))
        } else if word.starts_with(b"-") {
            Some("it rounds to 0 as a 32-bit float".to_owned())
        } else {
            Some(format!(
                "it is so small that it rounds to 0 as a 32-bit float; the smallest number that does not is {:e}",
                f32::from_bits(1)
            ))
        };
        Err(self.expected(Kind::NotPositive, item, word, help))
    }

    /// What to do about a length that is negative or zero.
    fn help_with_length(&self, number: f32, word: &[u8]) -> String {
        let positive = word.strip_prefix(b"-").unwrap_or_default();
        let write = match str::from_utf8(positive) {
            Ok(positive) if number < 0.0 && positive.len() <= LONGEST_QUOTE => {
                format!("write {positive}")
            }
            _ if number < 0.0 => "write it without the sign".to_owned(),
            _ if self.in_spheres => "give it a radius".to_owned(),
            _ => return "a usual viewport is VP 1 1 1".to_owned(),
        };
        if self.in_spheres {
            let fewer = self.claimed - 1;
            format!("{write}, or remove the sphere and lower OBJ_N to {fewer}")
        } else {
            write
        }
    }

    fn integer(&self, item: Item, word: &[u8]) -> Result<i64, Fault> {
        number::parse_integer(word).ok_or_else(|| {
            let text = String::from_utf8_lossy(word);
            let help = match number::parse(word) {
                Ok(0.0..=1.0) if matches!(item, Item::Colour(_)) => {
                    Some("colours run from 0 to 255, without fractions".to_owned())
                }
                Ok(_) => Some("write it without a fraction or an exponent".to_owned()),
                Err(_) if number::parse_integer(text.replace(',', "").as_bytes()).is_some() => {
                    Some("write it without commas".to_owned())
                }
                Err(_) => self.help_with_number(word),
            };
            self.expected(Kind::Integer, item, word, help)
        })
    }

    /// What stands at the end of the file, if that is no place to end.
    pub(super) fn finish(&self, is_blank: bool, is_empty: bool) -> Result<(), Fault> {
        if self.in_spheres && self.left == 0 {
            return Ok(());
        }
        let fault = |kind, message, help: Option<String>| Fault {
            place: FaultPlace::End,
            kind,
            message,
            help: if self.return_in_comment {
                Some(
                    "a comment goes on past a lone carriage return: end lines with a line feed"
                        .to_owned(),
                )
            } else {
                help
            },
        };
        if is_blank {
            let what = if is_empty {
                "the file is empty"
            } else {
                "the file holds nothing but blanks and comments"
            };
            let message = format!("expected VP, the viewport, but {what}");
            let help = "the smallest scene is: VP 1 1 1 BG 0 0 0 OBJ_N 0";
            return Err(fault(Kind::Empty, message, Some(help.to_owned())));
        }
        if self.in_spheres && self.word == 0 {
            let read = self.claimed - self.left;
            let message = format!(
                "OBJ_N says {}, but the file ends after {read}",
                spheres(self.claimed)
            );
            let help = format!("add {}, or lower OBJ_N to {read}", spheres(self.left));
            return Err(fault(Kind::TooFewSpheres, message, Some(help)));
        }
        let expected = self.describe(self.items()[self.word]);
        let message = format!("expected {expected}, but the file ends");
        Err(fault(Kind::Incomplete, message, self.help_with_order()))
    }

    /// A word that is expected, in words.
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
                format!("{keyword}, the beginning of {owner} of {}", self.claimed)
            }
            Item::Length(name) => format!("the {name} of {owner}, a number greater than 0"),
            Item::Coordinate(name) => format!("the {name} of {owner}, a decimal number"),
            Item::Colour(name) => format!("the {name} of {owner}, an integer from 0 to 255"),
            Item::Count => format!("the number of spheres, an integer from 0 to {}", u32::MAX),
        }
    }

    fn describe_end(&self) -> String {
        if self.claimed == 0 {
            "the end of the file after OBJ_N 0".to_owned()
        } else {
            format!(
                "the end of the file after the last of {}",
                spheres(self.claimed)
            )
        }
    }

    fn items(&self) -> &'static [Item] {
        if self.in_spheres { &SPHERE } else { &HEADER }
    }

    /// The sphere that is being read, from 1.
    fn sphere_number(&self) -> u64 {
        u64::from(self.claimed - self.left) + 1
    }

    fn expected(&self, kind: Kind, item: Item, word: &[u8], help: Option<String>) -> Fault {
        let message = format!("expected {}, found {}", self.describe(item), quoted(word));
        fault(kind, message, help)
    }

    fn out_of_range(&self, item: Item, word: &[u8]) -> Fault {
        self.expected(Kind::OutOfRange, item, word, None)
    }

    /// Shows no more of the word than is sure to be at hand.
    fn too_long(&self, word: &[u8]) -> Fault {
        if let Some(fault) = self.not_a_scene(word) {
            return fault;
        }
        let expected = if self.in_spheres && self.left == 0 {
            self.describe_end()
        } else {
            self.describe(self.items()[self.word])
        };
        let message = format!(
            "expected {expected}, found a word of more than {MAX_WORD} bytes, {}",
            quoted_beginning(word)
        );
        let help = "no word of a scene needs more bytes than that";
        fault(Kind::WordTooLong, message, Some(help.to_owned()))
    }

    /// A file of another kind.
    fn not_a_scene(&self, word: &[u8]) -> Option<Fault> {
        if self.in_spheres || self.word != 0 {
            return None;
        }
        let (name, help) = foreign(word)?;
        let message = format!("expected a scene, found {name}");
        Some(fault(Kind::NotAScene, message, Some(help.to_owned())))
    }

    fn no_memory(&self) -> Fault {
        Fault {
            place: FaultPlace::Nowhere,
            kind: Kind::Memory,
            message: format!("not enough memory for {}", spheres(self.claimed)),
            help: None,
        }
    }

    fn not_keyword(&self, keyword: &'static str, word: &[u8]) -> Fault {
        if let Some(fault) = self.not_a_scene(word) {
            return fault;
        }
        let glued = word.strip_prefix(keyword.as_bytes());
        let help = if word.eq_ignore_ascii_case(keyword.as_bytes()) {
            Some(format!("write {keyword} in capital letters"))
        } else if glued.is_some_and(advice::goes_on_with_number) {
            Some(format!("put a blank after {keyword}"))
        } else if advice::is_foreign_comment(word) {
            Some(COMMENT_HELP.to_owned())
        } else if number::parse(word).is_ok() {
            match keyword {
                "BG" => Some(VP_HELP.to_owned()),
                "OBJ_N" => Some(format!("{BG_HELP}; then comes OBJ_N number-of-spheres")),
                "S" if self.sphere_number() == 1 => Some(COUNT_HELP.to_owned()),
                "S" => Some(self.sphere_has_all()),
                _ => Some(HEADER_HELP.to_owned()),
            }
        } else if is_keyword(word) {
            Some("VP, BG and OBJ_N stand once each, in this order, then the spheres".to_owned())
        } else {
            advice::for_bytes(word).or_else(|| {
                Some(
                    if self.in_spheres {
                        SPHERE_HELP
                    } else {
                        HEADER_HELP
                    }
                    .to_owned(),
                )
            })
        };
        self.expected(Kind::Keyword, Item::Keyword(keyword), word, help)
    }

    fn sphere_has_all(&self) -> String {
        format!(
            "sphere {} has all of its 7 numbers: S x y z radius red green blue",
            self.sphere_number() - 1
        )
    }

    fn trailing(&self, word: &[u8]) -> Fault {
        if word == b"S" {
            let message = format!(
                "OBJ_N says {}, but another one follows",
                spheres(self.claimed)
            );
            let help = if self.claimed == 0 {
                "raise OBJ_N, or remove the spheres".to_owned()
            } else {
                format!(
                    "raise OBJ_N, or remove what follows sphere {}",
                    self.claimed
                )
            };
            return fault(Kind::TooManySpheres, message, Some(help));
        }
        let message = format!("expected {}, found {}", self.describe_end(), quoted(word));
        let help = if advice::is_foreign_comment(word) {
            COMMENT_HELP.to_owned()
        } else if number::parse(word).is_ok() {
            if self.claimed == 0 {
                COUNT_HELP.to_owned()
            } else {
                self.sphere_has_all()
            }
        } else if is_keyword(word) {
            "a file holds one scene".to_owned()
        } else {
            advice::for_bytes(word).unwrap_or_else(|| "remove it, or put # before it".to_owned())
        };
        fault(Kind::Trailing, message, Some(help))
    }

    /// What belongs together where a word is missing.
    fn help_with_order(&self) -> Option<String> {
        if let Some(help) = self.amid.as_ref().and_then(Comment::help) {
            return Some(help);
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
        if self.amid.is_some() {
            help.push_str("; what follows a # is a comment");
        }
        Some(help)
    }

    fn help_with_number(&self, word: &[u8]) -> Option<String> {
        if is_keyword(word) {
            return self.help_with_order();
        }
        advice::for_number(word)
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

fn is_keyword(word: &[u8]) -> bool {
    matches!(word, b"VP" | b"BG" | b"OBJ_N" | b"S")
}

fn spheres(count: u32) -> String {
    format!("{count} sphere{}", if count == 1 { "" } else { "s" })
}
