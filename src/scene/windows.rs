//! The scene text in windows, each parsed in parallel.
//!
//! A window is cut where a sphere begins and split into chunks that are also
//! cut so. The spheres of all chunks are counted, which tells where in the
//! structure of arrays each chunk belongs; then every chunk is parsed into its
//! place while the next window is being read. Where anything looks odd the
//! window is given to the [`Parser`] instead, which finds what is wrong first.

use std::io::{self, Read};

use rayon::prelude::*;

use super::{
    Scene, SceneError, Viewport, advice,
    error::{Excerpt, Place},
    number::{self, MAX_WORD, SPAN, Span, ends_word, is_blank},
    parser::{Fault, FaultPlace, Parser, Until},
};
use crate::spheres::{Slots, Sphere};

/// How much is taken at a time, in bytes.
#[derive(Clone, Copy, Debug)]
pub struct Sizes {
    /// The first window: a scene no longer than this is read without ado.
    pub first: usize,
    /// Each other window, for each thread.
    pub window: usize,
    /// What a thread parses at a time.
    pub chunk: usize,
    /// The smallest window that is worth waking other threads for.
    pub parallel: usize,
    /// The smallest piece that is worth counting before it is parsed.
    pub fast: usize,
}

impl Sizes {
    /// What is quick, as measured.
    pub const USUAL: Self = Self {
        first: 1 << 14,
        window: 1 << 19,
        chunk: 1 << 15,
        parallel: 1 << 18,
        fast: 1 << 8,
    };
    /// Threads for which windows grow.
    const MOST_THREADS: usize = 16;
}

/// What some editors write at the beginning of a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// No sphere is shorter than `S 0 0 0 1 0 0 0` and a line feed.
const SHORTEST_SPHERE: u64 = 16;

/// Reads a scene from a source of text, which may be `size` bytes long.
///
/// With `size` memory for all spheres is reserved that so long a text can hold.
pub(super) fn read<K>(
    source: &mut (impl Read + Send),
    size: Option<u64>,
    sizes: Sizes,
    kept: impl FnOnce(Viewport) -> K,
) -> Result<Scene, SceneError>
where
    K: Fn(&Sphere) -> bool + Sync,
{
    let mut reader = Reader::new(size, sizes, kept);
    let mut window = Window::default();
    window.fill(source, sizes.first.max(BYTE_ORDER_MARK.len()))?;
    window.drop_byte_order_mark();
    let mut next = Window::default();
    let mut taken = 0;
    while !window.is_last {
        let parallel = window.end - window.begin >= sizes.parallel;
        if taken == 0 {
            taken = sizes.window;
        } else if taken == sizes.window && parallel {
            taken *= rayon::current_num_threads().clamp(1, Sizes::MOST_THREADS);
        }
        next.follow(&window);
        let mut filled = Ok(());
        let mut parsed = Ok(());
        if parallel {
            rayon::in_place_scope(|scope| {
                scope.spawn(|_| filled = next.fill(source, taken));
                parsed = reader.parse(&window);
            });
        } else {
            filled = next.fill(source, taken);
            parsed = reader.parse(&window);
        }
        if let Err(fault) = parsed {
            if filled.is_ok() {
                next.complete_line(&window, source);
            }
            return Err(reader.refuse(fault, &window, next.text(window.carried())));
        }
        filled?;
        reader.step_over(&window);
        std::mem::swap(&mut window, &mut next);
    }
    if let Err(fault) = reader.parse(&window) {
        return Err(reader.refuse(fault, &window, &[]));
    }
    reader.step_over(&window);
    reader.finish(&window)
}

/// A piece of the text, between two of which no word is split.
///
/// `bytes` holds text before it, for messages, then the piece from `begin` to
/// `end`, then what has been read after it, up to `filled`.
#[derive(Default)]
struct Window {
    bytes: Vec<u8>,
    begin: usize,
    end: usize,
    filled: usize,
    is_last: bool,
}

impl Window {
    /// Begins with what `before` has read and not used.
    fn follow(&mut self, before: &Self) {
        let kept = before.end.saturating_sub(Excerpt::REACH + 1);
        let kept = &before.bytes[kept..before.filled];
        if self.bytes.len() < kept.len() {
            self.bytes.resize(kept.len(), 0);
        }
        self.bytes[..kept.len()].copy_from_slice(kept);
        self.filled = kept.len();
        self.begin = kept.len() - before.carried();
        self.end = self.begin;
        self.is_last = false;
    }

    /// Bytes read and not used.
    fn carried(&self) -> usize {
        self.filled - self.end
    }

    /// Reads `count` bytes, or what is left of the source.
    fn fill(&mut self, source: &mut impl Read, count: usize) -> Result<(), SceneError> {
        let full = self.filled + count;
        if self.bytes.len() < full {
            self.bytes.resize(full, 0);
        }
        while self.filled < full {
            match source.read(&mut self.bytes[self.filled..full]) {
                Ok(0) => {
                    self.is_last = true;
                    break;
                }
                Ok(read) => self.filled += read,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(SceneError::unreadable(error)),
            }
        }
        self.end = if self.is_last {
            self.filled
        } else {
            self.begin + cut(&self.bytes[self.begin..self.filled])
        };
        Ok(())
    }

    /// Of the first window: lines and columns are counted from behind the mark.
    fn drop_byte_order_mark(&mut self) {
        let mark = BYTE_ORDER_MARK.len();
        if self.bytes[..self.filled].starts_with(BYTE_ORDER_MARK) {
            self.bytes.copy_within(mark..self.filled, 0);
            self.filled -= mark;
            self.end = self.end.saturating_sub(mark);
        }
    }

    /// Reads on until a message can show the line that goes on from `before`.
    fn complete_line(&mut self, before: &Self, source: &mut impl Read) {
        while !self.is_last && self.text(before.carried()).len() <= Excerpt::REACH {
            let wanted = Excerpt::REACH + 1;
            if self.fill(source, wanted).is_err() {
                break;
            }
        }
    }

    /// What has been read, after the first `known` bytes of the piece.
    fn text(&self, known: usize) -> &[u8] {
        &self.bytes[self.begin + known..self.filled]
    }
}

/// Where to end a piece of a text that goes on: where a sphere begins, or at
/// least where no word is split.
fn cut(text: &[u8]) -> usize {
    /// How far back to look for a sphere.
    const NEAR: usize = 1 << 14;
    let near = text.len() - text.len().min(NEAR);
    if let Some(start) = last_sphere_in_line(&text[near..]) {
        return near + start;
    }
    if let Some(blank) = text.iter().rposition(|&byte| is_blank(byte)) {
        return blank + 1;
    }
    // One word or one comment. The parser gives up on words longer than this.
    if text.len() > MAX_WORD || text.contains(&b'#') {
        return text.len();
    }
    0
}

/// Where the last sphere begins that is the first word of a line.
fn last_sphere_in_line(text: &[u8]) -> Option<usize> {
    let mut end = text.len();
    while let Some(line_feed) = text[..end].iter().rposition(|&byte| byte == b'\n') {
        if let Some(start) = sphere_in_line(text, line_feed + 1) {
            return Some(start);
        }
        end = line_feed;
    }
    None
}

/// Where the first sphere at or after `from` begins that is the first word of
/// a line.
fn next_sphere_in_line(text: &[u8], mut from: usize) -> Option<usize> {
    while let Some(length) = text.get(from..)?.iter().position(|&byte| byte == b'\n') {
        from += length + 1;
        if let Some(start) = sphere_in_line(text, from) {
            return Some(start);
        }
    }
    None
}

/// Where the sphere begins, if the line at `at` begins with one.
fn sphere_in_line(text: &[u8], at: usize) -> Option<usize> {
    let line = &text[at..];
    let indent = line
        .iter()
        .position(|&byte| byte == b'\n' || !is_blank(byte))?;
    (line[indent] == b'S' && is_blank(*line.get(indent + 1)?)).then_some(at + indent)
}

/// A scene being read.
struct Reader<M, K> {
    parser: Parser,
    sizes: Sizes,
    /// Bytes of the source, if they are known and memory may follow them.
    size: Option<u64>,
    make_filter: Option<M>,
    filter: Option<K>,
    /// Of the first byte of the window.
    line: u64,
    column: u64,
    /// Line feeds in the window, once it has been parsed.
    line_feeds: u64,
    /// Whether the window begins within a comment.
    begins_in_comment: bool,
    last_word: Option<Place>,
    is_empty: bool,
}

impl<M, K> Reader<M, K>
where
    M: FnOnce(Viewport) -> K,
    K: Fn(&Sphere) -> bool + Sync,
{
    fn new(size: Option<u64>, sizes: Sizes, make_filter: M) -> Self {
        Self {
            parser: Parser::new(),
            sizes,
            size,
            make_filter: Some(make_filter),
            filter: None,
            line: 1,
            column: 1,
            line_feeds: 0,
            begins_in_comment: false,
            last_word: None,
            is_empty: true,
        }
    }

    fn parse(&mut self, window: &Window) -> Result<(), Fault> {
        let Window {
            bytes, begin, end, ..
        } = window;
        let (begin, end) = (*begin, *end);
        self.begins_in_comment = self.parser.in_comment;
        let at = self.judge(bytes, begin, end, Until::Sphere)?;
        self.line_feeds = count(&bytes[begin..at], b'\n');
        if !self.parser.is_before_sphere() {
            return Ok(());
        }
        if let Some(make_filter) = self.make_filter.take() {
            self.filter = Some(make_filter(self.parser.viewport));
            self.reserve();
        }
        if end - at >= self.sizes.fast
            && let Some(filter) = &self.filter
            && let Some(line_feeds) =
                parse_fast(&mut self.parser, &bytes[at..end], self.sizes, filter)
        {
            self.line_feeds += line_feeds;
            return Ok(());
        }
        self.line_feeds += count(&bytes[at..end], b'\n');
        self.judge(bytes, at, end, Until::End)?;
        Ok(())
    }

    fn judge(&mut self, text: &[u8], at: usize, end: usize, until: Until) -> Result<usize, Fault> {
        match &self.filter {
            Some(filter) => self.parser.judge(text, at, end, until, filter),
            None => self.parser.judge(text, at, end, until, &|_| true),
        }
    }

    /// Reserves memory for as many spheres as the text can hold, if there is so
    /// much: a text may be shorter than it seems.
    fn reserve(&mut self) {
        let Some(size) = self.size else {
            return;
        };
        let most = size.div_ceil(SHORTEST_SPHERE).min(self.parser.left.into());
        if let Ok(most) = usize::try_from(most) {
            let _ = self.parser.spheres.try_reserve_exact(most);
        }
    }

    /// Moves line, column and the last word to the end of a parsed window.
    fn step_over(&mut self, window: &Window) {
        let text = &window.bytes[window.begin..window.end];
        self.is_empty &= text.is_empty();
        if let Some(end) = last_word_end(text, self.begins_in_comment) {
            let end = window.begin + end;
            let after = count(&window.bytes[end..window.end], b'\n');
            let before = line_before(&window.bytes[..end]);
            self.last_word = Some(Place {
                line: self.line + self.line_feeds - after,
                column: self.column_at(window, end),
                excerpt: Some(Excerpt::new(before, &[])),
            });
        }
        self.column = self.column_at(window, window.end);
        self.line += self.line_feeds;
        self.line_feeds = 0;
    }

    fn column_at(&self, window: &Window, at: usize) -> u64 {
        let text = &window.bytes[window.begin..at];
        match text.iter().rposition(|&byte| byte == b'\n') {
            Some(line_feed) => (text.len() - line_feed) as u64,
            None => self.column + text.len() as u64,
        }
    }

    /// What is wrong, with the line it is in. `more` is what follows `window`.
    fn refuse(self, fault: Fault, window: &Window, more: &[u8]) -> SceneError {
        let Fault {
            place,
            kind,
            message,
            mut help,
        } = fault;
        let place = match place {
            FaultPlace::Nowhere => None,
            FaultPlace::End => Some(self.last_word.unwrap_or(Place {
                line: 1,
                column: 1,
                excerpt: None,
            })),
            FaultPlace::At(at) => {
                let before = line_before(&window.bytes[..at]);
                let mut after = window.bytes[at..window.filled].to_vec();
                after.truncate(Excerpt::REACH + 1);
                if after.len() <= Excerpt::REACH && !after.contains(&b'\n') {
                    after.extend_from_slice(more);
                }
                let line = after.split(|&byte| byte == b'\n').next();
                let line = line.unwrap_or_default();
                // No more than is at hand wherever the text is cut.
                let known = &line[..line.len().min(Excerpt::REACH)];
                help = advice::for_line(known).or(help);
                Some(Place {
                    line: self.line + count(&window.bytes[window.begin..at], b'\n'),
                    column: self.column_at(window, at),
                    excerpt: Some(Excerpt::new(before, line)),
                })
            }
        };
        SceneError::new(place, kind, message, help)
    }

    fn finish(self, window: &Window) -> Result<Scene, SceneError> {
        if let Err(fault) = self.parser.finish(self.last_word.is_none(), self.is_empty) {
            return Err(self.refuse(fault, window, &[]));
        }
        Ok(Scene {
            viewport: self.parser.viewport,
            background: self.parser.background,
            spheres: self.parser.spheres,
        })
    }
}

/// Parses a piece of text that begins between two spheres, if all is well with
/// it, and counts its line feeds. Otherwise nothing has happened.
fn parse_fast<K>(parser: &mut Parser, text: &[u8], sizes: Sizes, filter: &K) -> Option<u64>
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
    let left = parser.left.checked_sub(u32::try_from(total).ok()?)?;

    let before = parser.spheres.len();
    let mut slots = parser.spheres.try_grow(total).ok()?;
    let mut tasks = Vec::with_capacity(chunks.len());
    for (chunk, counts) in chunks.into_iter().zip(&counts) {
        let (chunk_slots, rest) = slots.split_at(counts.spheres);
        tasks.push((chunk, chunk_slots));
        slots = rest;
    }
    let parse = |(chunk, slots)| parse_chunk(chunk, slots, filter);
    let kept: Option<Vec<usize>> = if in_parallel {
        tasks.into_par_iter().map(parse).collect()
    } else {
        tasks.into_iter().map(parse).collect()
    };
    let Some(kept) = kept else {
        parser.spheres.truncate(before);
        return None;
    };

    // Close the gaps that dropped spheres leave.
    let (mut from, mut to) = (before, before);
    for (counts, kept) in counts.iter().zip(kept) {
        if from != to {
            parser.spheres.copy_within(from..from + kept, to);
        }
        from += counts.spheres;
        to += kept;
    }
    parser.spheres.truncate(to);
    parser.left = left;
    parser.in_comment = ends_in_comment(text);
    Some(counts.iter().map(|counts| counts.line_feeds).sum())
}

/// Chunks of about `size` bytes that, but for the first, begin where a sphere
/// does.
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

/// What a chunk holds if it is well-formed.
#[derive(Clone, Copy)]
struct Counts {
    spheres: usize,
    line_feeds: u64,
}

impl Counts {
    /// A chunk that is well-formed and has no comment has as many spheres as
    /// letters `S`.
    fn of(chunk: &[u8]) -> Self {
        let spheres = if count(chunk, b'#') > 0 {
            chunk
                .split(|&byte| byte == b'\n')
                .filter_map(|line| line.split(|&byte| byte == b'#').next())
                .map(|words| count(words, b'S'))
                .sum()
        } else {
            count(chunk, b'S')
        };
        Self {
            spheres: usize::try_from(spheres).unwrap_or(usize::MAX),
            line_feeds: count(chunk, b'\n'),
        }
    }
}

/// Parses a chunk into its slots and says how many spheres were kept, which
/// are in the first slots. Nothing if there is anything odd about the chunk.
fn parse_chunk(
    text: &[u8],
    mut slots: Slots<'_>,
    filter: &impl Fn(&Sphere) -> bool,
) -> Option<usize> {
    let count = slots.len();
    let mut kept = 0;
    let mut keep = |sphere: Sphere| {
        if filter(&sphere) {
            slots.set(kept, sphere);
            kept += 1;
        }
    };
    let mut at = skip_blanks(text, 0);
    for _ in 0..count {
        // Kept apart, for the quick way is quicker if it hands over nothing in memory.
        let span = Span::new(text.get(at..)?);
        if let Some((sphere, length)) = span.as_ref().and_then(take_ordinary_sphere) {
            keep(sphere);
            at += length;
            if text[at] == b'#' {
                at = skip_blanks(text, at);
            }
        } else {
            let (sphere, end) = take_any_sphere(text, at)?;
            keep(sphere);
            at = end;
        }
    }
    (at == text.len()).then_some(kept)
}

/// The sphere that a span begins with, and where the word or comment after it
/// begins, if it looks as spheres do.
#[inline(always)]
fn take_ordinary_sphere(span: &Span<'_>) -> Option<(Sphere, usize)> {
    let mut starts = !span.blanks & (span.blanks << 1);
    let mut ends = span.blanks & !(span.blanks << 1);
    if span.byte(0) != b'S' || ends.trailing_zeros() != 1 {
        return None;
    }
    let words: [(usize, usize); 7] = std::array::from_fn(|_| {
        ends &= ends.wrapping_sub(1);
        let word = (
            starts.trailing_zeros() as usize,
            ends.trailing_zeros() as usize,
        );
        starts &= starts.wrapping_sub(1);
        word
    });
    // If the next word begins within the span, all words before it end in it.
    let next = starts.trailing_zeros() as usize;
    if next >= SPAN {
        return None;
    }
    let [x, y, z, radius] = span.numbers([words[0], words[1], words[2], words[3]])?;
    let integer = |word: usize| span.integer(words[word].0, words[word].1);
    let sphere = Sphere {
        centre: [x, y, z],
        radius,
        colour: [integer(4)?, integer(5)?, integer(6)?],
    };
    (radius > 0.0).then_some((sphere, next))
}

#[inline(never)]
fn take_any_sphere(text: &[u8], at: usize) -> Option<(Sphere, usize)> {
    if *text.get(at)? != b'S' {
        return None;
    }
    let at = skip_gap(text, at + 1)?;
    let (x, at) = number::take(text, at)?;
    let at = skip_gap(text, at)?;
    let (y, at) = number::take(text, at)?;
    let at = skip_gap(text, at)?;
    let (z, at) = number::take(text, at)?;
    let at = skip_gap(text, at)?;
    let (radius, at) = number::take(text, at)?;
    let at = skip_gap(text, at)?;
    let (red, at) = number::take_byte(text, at)?;
    let at = skip_gap(text, at)?;
    let (green, at) = number::take_byte(text, at)?;
    let at = skip_gap(text, at)?;
    let (blue, at) = number::take_byte(text, at)?;
    let at = skip_gap(text, at)?;
    let sphere = Sphere {
        centre: [x, y, z],
        radius,
        colour: [red, green, blue],
    };
    (radius > 0.0).then_some((sphere, at))
}

/// Where the next word begins, or the text ends, if no word goes on at `at`.
fn skip_gap(text: &[u8], at: usize) -> Option<usize> {
    match text.get(at) {
        Some(&byte) if !ends_word(byte) => None,
        _ => Some(skip_blanks(text, at)),
    }
}

fn skip_blanks(text: &[u8], mut at: usize) -> usize {
    while let Some(&byte) = text.get(at) {
        if byte == b'#' {
            let length = text[at..].iter().position(|&byte| byte == b'\n');
            at = length.map_or(text.len(), |length| at + length);
        } else if is_blank(byte) {
            at += 1;
        } else {
            break;
        }
    }
    at
}

fn ends_in_comment(text: &[u8]) -> bool {
    let mut line = text.iter().rev().take_while(|&&byte| byte != b'\n');
    line.any(|&byte| byte == b'#')
}

/// Where the last word of a text ends, if it has one.
fn last_word_end(text: &[u8], begins_in_comment: bool) -> Option<usize> {
    let mut end = text.len();
    loop {
        let start = text[..end].iter().rposition(|&byte| byte == b'\n');
        let line = &text[start.map_or(0, |line_feed| line_feed + 1)..end];
        if start.is_none() && begins_in_comment {
            return None;
        }
        let words = line.split(|&byte| byte == b'#').next().unwrap_or_default();
        if let Some(last) = words.iter().rposition(|&byte| !is_blank(byte)) {
            return Some(end - line.len() + last + 1);
        }
        end = start?;
    }
}

/// The line that `text` ends in, or its last bytes if it is long.
fn line_before(text: &[u8]) -> &[u8] {
    let near = &text[text.len().saturating_sub(Excerpt::REACH + 1)..];
    let line_feed = near.iter().rposition(|&byte| byte == b'\n');
    &near[line_feed.map_or(0, |line_feed| line_feed + 1)..]
}

/// How often a byte occurs.
fn count(text: &[u8], wanted: u8) -> u64 {
    /// As many as a sum of single bytes can hold, in whole vectors.
    const RUN: usize = 192;
    text.chunks(RUN)
        .map(|run| {
            let sum: u8 = run.iter().map(|&byte| u8::from(byte == wanted)).sum();
            u64::from(sum)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use std::fmt::Write;

    use proptest::prelude::*;

    use super::*;
    use crate::testing::families::cloud;

    /// The parser alone, word by word, the whole text at once.
    const JUDGE: Sizes = Sizes {
        first: usize::MAX >> 1,
        window: 1,
        chunk: 1,
        parallel: usize::MAX,
        fast: usize::MAX,
    };

    /// A source that gives a few bytes at a time, as a pipe may.
    struct Trickle<'a> {
        text: &'a [u8],
        at_most: usize,
    }

    impl Read for Trickle<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let at_most = self.at_most.min(buffer.len());
            self.text.read(&mut buffer[..at_most])
        }
    }

    /// Everything that a reader can tell of a text, floats by their bits.
    fn outcome(text: &[u8], sizes: Sizes, at_most: usize) -> Result<String, String> {
        // So large a first window would be allocated.
        let sizes = Sizes {
            first: sizes.first.min(text.len() + 1),
            ..sizes
        };
        let source = &mut Trickle { text, at_most };
        let size = Some(text.len() as u64);
        let scene = read(source, size, sizes, |_| |_: &Sphere| true).map_err(|error| {
            let kind = format!("{:?}", error.kind());
            format!("{:?} {:?} {kind}\n{error}", error.line(), error.column())
        })?;
        Ok(format!("{scene:?}"))
    }

    fn agree(text: &[u8], sizes: Sizes, at_most: usize) {
        let expected = outcome(text, JUDGE, usize::MAX);
        let found = outcome(text, sizes, at_most);
        assert_eq!(found, expected, "{sizes:?} {}", text.escape_ascii());
    }

    const TINY: Sizes = Sizes {
        first: 64,
        window: 160,
        chunk: 48,
        parallel: 1,
        fast: 1,
    };

    /// A text in many shapes: indented, broken, with comments, CRLF, exponents;
    /// or, from the sixth seed on, in the plainest.
    fn varied(seed: u64) -> Vec<u8> {
        let scene = cloud(12, seed);
        if seed >= 6 {
            return scene.to_string().into_bytes();
        }
        let mut text = String::from("# A scene.\nVP 1 1\t1\r\nBG 0 1 2 OBJ_N 12 # S\n");
        for (index, sphere) in scene.spheres.iter().enumerate() {
            let [x, y, z] = sphere.centre;
            let (radius, [red, green, blue]) = (sphere.radius, sphere.colour);
            let _ = match (index as u64 + seed) % 6 {
                0 => writeln!(text, "\tS {x:e} {y} {z} {radius:e} {red} {green} {blue}"),
                1 => write!(text, "S\n{x}\n{y}\n{z} {radius}\n{red} {green} {blue}\n\n"),
                2 => write!(text, "S {x} {y} {z} {radius} {red} {green} {blue} "),
                3 => write!(
                    text,
                    "\x0bS {x} {y} {z} {radius} {red} {green} {blue}#S 1\r\n"
                ),
                4 => writeln!(
                    text,
                    "S {x:+} {y} {z}   {radius} # S S\n 0{red} {green} {blue}"
                ),
                _ => writeln!(text, "S {x} {y} {z} {radius} {red} {green} {blue}"),
            };
        }
        text.into_bytes()
    }

    #[test]
    fn windows_of_every_size() {
        for seed in 0..7 {
            let text = varied(seed);
            assert!(outcome(&text, JUDGE, usize::MAX).is_ok());
            let cut_short = &text[..text.len() - 20];
            for size in 1..text.len() + 2 {
                let sizes = Sizes {
                    first: size,
                    window: size,
                    chunk: size.div_ceil(3),
                    ..TINY
                };
                agree(&text, sizes, usize::MAX);
                agree(cut_short, sizes, 1 + size / 2);
            }
        }
    }

    /// What hurts, and what a scene is made of.
    const PIECES: [&[u8]; 30] = [
        b" ",
        b"\n",
        b"\r\n",
        b"\r",
        b"\t",
        b"#",
        b"# S",
        b"S",
        b"S ",
        b"\nS ",
        b"VP",
        b"-",
        b"+",
        b".",
        b"e",
        b"0",
        b"9",
        b",",
        b"256",
        b"1e39",
        b"1e-60",
        b"\0",
        b"\xff",
        b"\xef\xbb\xbf",
        b"\n#\n",
        b"S 0 0 5 1 1 2 3\n",
        b"S 0 0 5 0 1 2 3\n",
        b"0.000000000000000000000000001",
        b"                                                                                     ",
        b"##################################################################################",
    ];

    fn edited(mut text: Vec<u8>, edits: &[(usize, usize, usize)]) -> Vec<u8> {
        for &(place, piece, removed) in edits {
            let place = place % (text.len() + 1);
            let end = (place + removed).min(text.len());
            let piece = PIECES.get(piece).copied().unwrap_or_default();
            text.splice(place..end, piece.iter().copied());
        }
        text
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(6_000))]

        #[test]
        fn a_damaged_text_gives_the_same_in_windows_as_to_the_judge(
            seed in 0_u64..12,
            edits in prop::collection::vec((any::<usize>(), 0..2 * PIECES.len(), 0_usize..4), 0..4),
            first in 1_usize..200,
            window in 1_usize..1_000,
            chunk in 1_usize..600,
            parallel in 1_usize..300,
            at_most in 1_usize..100,
        ) {
            let text = edited(varied(seed), &edits);
            agree(&text, Sizes { first, window, chunk, parallel, fast: 1 }, at_most);
        }

        #[test]
        fn a_filter_drops_what_it_drops_and_keeps_the_order(
            seed in any::<u64>(),
            count in 0_usize..60,
            some in 1_u8..8,
            window in 1_usize..4_000,
            chunk in 1_usize..1_000,
        ) {
            let scene = cloud(count, seed);
            let text = scene.to_string();
            let keep = |sphere: &Sphere| !sphere.colour[0].is_multiple_of(some);
            let sizes = Sizes { window, chunk, ..TINY };
            let kept = read(&mut text.as_bytes(), None, sizes, |_| keep).expect("a scene");
            let expected: Vec<Sphere> = scene.spheres.iter().filter(keep).collect();
            let found: Vec<Sphere> = kept.spheres.iter().collect();
            prop_assert_eq!(&found, &expected);
            let again: crate::spheres::Spheres = expected.into_iter().collect();
            prop_assert_eq!(format!("{again:?}"), format!("{:?}", kept.spheres));
        }
    }

    #[test]
    fn damage_anywhere_in_a_text_of_many_chunks() {
        let sizes = Sizes {
            first: 1 << 8,
            window: 1 << 14,
            chunk: 1 << 10,
            parallel: 1 << 11,
            fast: 1,
        };
        let text = cloud(3_000, 7).to_string().into_bytes();
        agree(&text, sizes, usize::MAX);
        for trial in 0..60_usize {
            let place = trial.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let second = place.rotate_left(17);
            agree(
                &edited(text.clone(), &[(place, trial, trial % 3)]),
                sizes,
                usize::MAX,
            );
            agree(
                &edited(text.clone(), &[(place, trial, 1), (second, trial / 2, 1)]),
                sizes,
                usize::MAX,
            );
        }
    }

    #[test]
    fn words_and_comments_longer_than_windows() {
        let zeros = "0".repeat(MAX_WORD - 2);
        let long = |word: &str| format!("VP 1 1 1 BG 0 0 0 OBJ_N 1 S {word} 0 5 1 0 0 0");
        let comment = "S#".repeat(100_000);
        let texts = [
            long(&format!("0.{zeros}")),
            long(&format!("1.{zeros}0")),
            long(&"9".repeat(300_000)),
            long(&format!("{}1 # {comment}\n", " ".repeat(300_000))),
            long(&format!("1#{comment}\n")),
            long(&format!("1#{comment}")),
            format!("{}{comment}", long("1 #")),
            format!("{}{comment}", long("1")),
            format!("{} {comment}", long("1")),
            format!("{}{}", long("1"), "\n".repeat(200_000)),
            format!("VP 1 1 1 BG 0 0 0 OBJ_N 2{}", "\n".repeat(200_000)),
            comment.clone(),
            format!("#{comment}"),
            "\0".repeat(200_000),
            format!("VP{}", "\n1".repeat(100_000)),
        ];
        for text in texts {
            for window in [777, 1 << 13, 1 << 17] {
                agree(
                    text.as_bytes(),
                    Sizes {
                        window,
                        chunk: 500,
                        ..TINY
                    },
                    usize::MAX,
                );
            }
        }
    }
}
