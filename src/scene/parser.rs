//! The parser: reads a scene word by word, and says what is wrong with the first word
//! that does not fit.
//!
//! It is simple rather than fast; [`chunks`](super::chunks) is fast, and leaves to the
//! parser what it can't read. The parser keeps its state between two pieces of text, so
//! that a text may be cut between any two words and inside a comment.

mod messages;

use std::collections::TryReserveError;

use super::{
    Viewport,
    comment::Comment,
    error::SceneErrorKind,
    grammar::{HEADER, Item, SPHERE, Values},
    text::{Gap, MAX_WORD, word_end},
};
use crate::spheres::{Rgb, Sphere, Spheres};

/// What is wrong, and where.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) place: FaultPlace,
    pub(super) kind: SceneErrorKind,
    pub(super) message: String,
    pub(super) help: Option<String>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum FaultPlace {
    /// At this byte of the piece of text.
    At(usize),
    /// Behind the last word of the file.
    End,
    /// The fault is not in the text.
    Nowhere,
}

/// How far [`Parser::parse`] goes.
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
    /// Spheres that are still to be read.
    pub(super) left: u32,
    /// Spheres that `OBJ_N` announces.
    announced: u32,
    /// Whether the header has been read.
    in_spheres: bool,
    /// Index of the expected word in the header or in a sphere.
    word: usize,
    values: Values,
    gap: Gap,
    /// The first comment before the expected word and after a keyword.
    comment: Option<Comment>,
    /// Whether the last byte of a comment so far is a carriage return.
    after_return: bool,
    /// Whether a comment in the header holds a carriage return that is not part of a
    /// line end.
    return_in_comment: bool,
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
            announced: 0,
            in_spheres: false,
            word: 0,
            values: Values::default(),
            gap: Gap::default(),
            comment: None,
            after_return: false,
            return_in_comment: false,
        }
    }

    pub(super) fn is_in_comment(&self) -> bool {
        self.gap.in_comment
    }

    /// Whether the next word, if any, begins a sphere.
    pub(super) fn is_before_sphere(&self) -> bool {
        self.in_spheres && self.word == 0 && !self.gap.in_comment
    }

    /// Whether all words of the scene have been read.
    fn is_complete(&self) -> bool {
        self.in_spheres && self.left == 0
    }

    fn items(&self) -> &'static [Item] {
        if self.in_spheres { &SPHERE } else { &HEADER }
    }

    fn expected(&self) -> Item {
        self.items()[self.word]
    }

    /// Notes that `count` spheres have been read by other means.
    pub(super) fn pass_spheres(&mut self, count: u32, ends_in_comment: bool) {
        self.left -= count;
        self.gap.in_comment = ends_in_comment;
    }

    /// Reads `text[at..to]`, which holds whole words, and returns how far it came.
    pub(super) fn parse(
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
            at = self.skip_gap(text, at, to);
            if at == to {
                return Ok(at);
            }
            let end = word_end(&text[..to], at);
            self.take(&text[at..end], keep).map_err(|fault| Fault {
                place: match fault.kind {
                    SceneErrorKind::Memory => FaultPlace::Nowhere,
                    _ => FaultPlace::At(at),
                },
                ..fault
            })?;
            at = end;
        }
    }

    /// Skips blanks and comments, and keeps of a comment what a message may need.
    fn skip_gap(&mut self, text: &[u8], mut at: usize, to: usize) -> usize {
        while at < to {
            let was_in_comment = self.gap.in_comment;
            if !self.gap.takes(text[at]) {
                break;
            }
            if was_in_comment {
                self.take_of_comment(text[at]);
            } else if self.gap.in_comment {
                self.begin_comment(&text[..at]);
            }
            at += 1;
        }
        at
    }

    fn begin_comment(&mut self, before: &[u8]) {
        self.after_return = false;
        if self.comment.is_none() && !matches!(self.expected(), Item::Keyword(_)) {
            let is_colour = matches!(self.expected(), Item::Colour(_));
            self.comment = Some(Comment::after(before, is_colour));
        }
    }

    fn take_of_comment(&mut self, byte: u8) {
        self.return_in_comment |= self.after_return && byte != b'\n' && !self.in_spheres;
        self.after_return = byte == b'\r';
        if let Some(comment) = &mut self.comment {
            comment.take(byte);
        }
    }

    fn take(&mut self, word: &[u8], keep: &dyn Fn(&Sphere) -> bool) -> Result<(), Fault> {
        if word.len() > MAX_WORD {
            return Err(self.too_long(word));
        }
        if self.is_complete() {
            return Err(self.trailing(word));
        }
        let items = self.items();
        let item = items[self.word];
        // What is not UTF-8 fits nowhere, and neither does an empty word.
        let text = str::from_utf8(word).unwrap_or_default();
        if let Err(mismatch) = self.values.take(item, self.word, text) {
            return Err(self.mismatch(mismatch, item, word));
        }
        self.word += 1;
        if matches!(items.get(self.word), None | Some(Item::Keyword(_))) {
            self.comment = None;
        }
        if self.word == items.len() {
            self.word = 0;
            if self.in_spheres {
                self.finish_sphere(keep).map_err(|_| self.no_memory())?;
            } else {
                self.finish_header();
            }
        }
        Ok(())
    }

    fn finish_header(&mut self) {
        let [width, height, distance, _] = self.values.numbers;
        self.viewport = Viewport {
            width,
            height,
            distance,
        };
        self.background = self.values.colour;
        self.announced = self.values.count;
        self.left = self.announced;
        self.in_spheres = true;
    }

    fn finish_sphere(&mut self, keep: &dyn Fn(&Sphere) -> bool) -> Result<(), TryReserveError> {
        self.left -= 1;
        let sphere = self.values.sphere();
        if keep(&sphere) {
            self.spheres.try_grow(1)?.set(0, sphere);
        }
        Ok(())
    }
}
