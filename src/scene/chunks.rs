//! Fast reading of many spheres: chunks of text are parsed in parallel, each into its
//! place in the structure of arrays.
//!
//! The spheres of all chunks are counted first, which gives the place of each chunk. A
//! chunk that does not hold as many well-formed spheres as were counted is not read at
//! all: the [`parser`](super::parser) then says what is wrong.

use rayon::prelude::*;

use super::{
    grammar::{SPHERE, SPHERE_LETTER, Values},
    number::{SPAN, Span},
    text::{COMMENT, Gap, MAX_WORD, count, word_end},
    windows::{Sizes, next_sphere_in_line},
};
use crate::spheres::{Slots, Sphere, Spheres};

/// What a text that was read contains.
pub(super) struct Read {
    /// Spheres, those that were not kept included.
    pub(super) spheres: u32,
    pub(super) line_feeds: u64,
    pub(super) ends_in_comment: bool,
}

/// Appends the spheres of a text that begins between two of them, except those that
/// `filter` does not keep. Appends nothing if the text is not spheres alone, or if there
/// are more than `max_spheres`.
pub(super) fn read<K>(
    text: &[u8],
    spheres: &mut Spheres,
    max_spheres: u32,
    sizes: Sizes,
    filter: &K,
) -> Option<Read>
where
    K: Fn(&Sphere) -> bool + Sync,
{
    let in_parallel = text.len() >= sizes.parallel;
    let chunks = if in_parallel {
        split(text, sizes.chunk)
    } else {
        vec![text]
    };
    let counts: Vec<Counts> = if in_parallel {
        chunks.par_iter().map(|chunk| Counts::of(chunk)).collect()
    } else {
        chunks.iter().map(|chunk| Counts::of(chunk)).collect()
    };
    let total: usize = counts.iter().map(|counts| counts.spheres).sum();
    let read = u32::try_from(total)
        .ok()
        .filter(|&read| read <= max_spheres)?;

    let before = spheres.len();
    let mut slots = spheres.try_grow(total).ok()?;
    let mut tasks = Vec::with_capacity(chunks.len());
    for (chunk, counts) in chunks.into_iter().zip(&counts) {
        let (chunk_slots, rest) = slots.split_at(counts.spheres);
        tasks.push((chunk, chunk_slots));
        slots = rest;
    }
    let parse = |(chunk, slots)| parse_chunk(chunk, slots, filter);
    let parsed: Option<Vec<Parsed>> = if in_parallel {
        tasks.into_par_iter().map(parse).collect()
    } else {
        tasks.into_iter().map(parse).collect()
    };
    let Some(parsed) = parsed else {
        spheres.truncate(before);
        return None;
    };

    // Close the gaps of spheres that were not kept.
    let (mut from, mut to) = (before, before);
    for (counts, &Parsed { kept, .. }) in counts.iter().zip(&parsed) {
        if from != to {
            spheres.copy_within(from..from + kept, to);
        }
        from += counts.spheres;
        to += kept;
    }
    spheres.truncate(to);
    Some(Read {
        spheres: read,
        line_feeds: counts.iter().map(|counts| counts.line_feeds).sum(),
        ends_in_comment: parsed.last().is_some_and(|last| last.ends_in_comment),
    })
}

/// Chunks of about `size` bytes. All but the first begin with a sphere.
fn split(mut text: &[u8], size: usize) -> Vec<&[u8]> {
    let mut chunks = Vec::with_capacity(text.len() / size.max(1) + 1);
    while let Some(start) = next_sphere_in_line(text, size) {
        let (chunk, rest) = text.split_at(start);
        chunks.push(chunk);
        text = rest;
    }
    chunks.push(text);
    chunks
}

/// The counts of a chunk, right if it is well-formed.
#[derive(Clone, Copy)]
struct Counts {
    spheres: usize,
    line_feeds: u64,
}

impl Counts {
    /// A well-formed chunk has a letter `S` for each sphere, and no other outside comments.
    fn of(chunk: &[u8]) -> Self {
        let spheres = if count(chunk, COMMENT) > 0 {
            let mut gap = Gap::default();
            let is_letter = |&&byte: &&u8| !gap.takes(byte) && byte == SPHERE_LETTER;
            chunk.iter().filter(is_letter).count()
        } else {
            usize::try_from(count(chunk, SPHERE_LETTER)).unwrap_or(usize::MAX)
        };
        Self {
            spheres,
            line_feeds: count(chunk, b'\n'),
        }
    }
}

struct Parsed {
    /// Spheres that were kept.
    kept: usize,
    ends_in_comment: bool,
}

/// Parses a chunk into the first of its slots, of which there is one for each sphere.
/// Returns nothing if the chunk does not hold exactly these spheres.
fn parse_chunk(
    text: &[u8],
    mut slots: Slots<'_>,
    filter: &impl Fn(&Sphere) -> bool,
) -> Option<Parsed> {
    let count = slots.len();
    let mut kept = 0;
    let mut keep = |sphere: Sphere| {
        if filter(&sphere) {
            slots.set(kept, sphere);
            kept += 1;
        }
    };
    let mut gap = Gap::default();
    let mut at = gap.skip(text, 0);
    // The text from the first sphere on that is not ordinary.
    let mut rest = None;
    for _ in 0..count {
        // One function for both kinds of spheres would be slower: it would return its result
        // in memory.
        let span = Span::new(text.get(at..)?);
        if let Some((sphere, length)) = span.as_ref().and_then(ordinary_sphere) {
            keep(sphere);
            at += length;
            if text[at] != SPHERE_LETTER {
                gap = Gap::default();
                at = gap.skip(text, at);
            }
        } else {
            // Checked as UTF-8 at once: for each number alone that takes as long as to read it.
            let (begin, rest) = match rest {
                Some(rest) => rest,
                None => *rest.insert((at, str::from_utf8(&text[at..]).ok()?)),
            };
            let (sphere, next, gap_before_next) = any_sphere(rest, at - begin)?;
            keep(sphere);
            (at, gap) = (begin + next, gap_before_next);
        }
    }
    (at == text.len()).then_some(Parsed {
        kept,
        ends_in_comment: gap.in_comment,
    })
}

/// The sphere that a span begins with, and where the blanks after it end, or the span. The
/// sphere must be ordinary: blanks between its words, no exponents, few digits.
#[inline(always)]
fn ordinary_sphere(span: &Span<'_>) -> Option<(Sphere, usize)> {
    let mut starts = !span.blanks & (span.blanks << 1);
    let mut ends = span.blanks & !(span.blanks << 1);
    if span.byte(0) != SPHERE_LETTER || ends.trailing_zeros() != 1 {
        return None;
    }
    let words: [(usize, usize); SPHERE.len() - 1] = std::array::from_fn(|_| {
        ends &= ends.wrapping_sub(1);
        let word = (
            starts.trailing_zeros() as usize,
            ends.trailing_zeros() as usize,
        );
        starts &= starts.wrapping_sub(1);
        word
    });
    let [x, y, z, radius, red, green, blue] = words;
    // If the last word ends within the span, so do those before it.
    let (_, end) = blue;
    if end >= SPAN {
        return None;
    }
    // If no word begins behind it, there are only blanks up to the end of the span.
    let next = starts.trailing_zeros() as usize;
    let integer = |(start, end)| span.integer(start, end);
    let values = Values {
        numbers: span.numbers([x, y, z, radius])?,
        colour: [integer(red)?, integer(green)?, integer(blue)?],
        count: 0,
    };
    values.are_of_a_sphere().then(|| (values.sphere(), next))
}

/// The sphere at `at`, where the next word begins or the text ends, and the gap before that.
#[inline(never)]
fn any_sphere(text: &str, at: usize) -> Option<(Sphere, usize, Gap)> {
    let mut values = Values::default();
    let mut gap = Gap::default();
    let mut start = at;
    for (place, item) in SPHERE.into_iter().enumerate() {
        let end = word_end(text.as_bytes(), start);
        let word = text.get(start..end)?;
        if word.len() > MAX_WORD {
            return None;
        }
        values.take(item, place, word).ok()?;
        start = gap.skip(text.as_bytes(), end);
    }
    Some((values.sphere(), start, gap))
}

#[cfg(test)]
mod tests;
