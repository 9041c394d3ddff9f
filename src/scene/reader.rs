//! A scene from a source of text.
//!
//! The text is read in [`windows`](super::windows). In each window the
//! [`chunks`] read the spheres, while the next window is being filled.
//! Where they can't, the [`parser`](super::parser) reads the window and finds the first
//! error; [`position`](super::position) gives its line and its column.

use std::io::Read;

use super::{
    Scene, SceneError, Viewport, advice, chunks,
    excerpt::Excerpt,
    grammar::SHORTEST_SPHERE,
    parser::{Fault, FaultPlace, Parser, Until},
    position::Position,
    text::count,
    windows::{Sizes, Window},
};
use crate::spheres::Sphere;

/// Reads a scene from a source of text, which may be `size` bytes long.
///
/// If there is a `size`, memory for all spheres is reserved that so long a text can hold.
/// `make_filter` makes, for the viewport of the scene, the filter of spheres to keep.
pub(super) fn read<K>(
    source: &mut (impl Read + Send),
    size: Option<u64>,
    sizes: Sizes,
    make_filter: impl FnOnce(Viewport) -> K,
) -> Result<Scene, SceneError>
where
    K: Fn(&Sphere) -> bool + Sync,
{
    let mut reader = Reader::new(size, sizes, make_filter);
    let mut window = Window::first(source, sizes.first)?;
    let mut next = Window::default();
    let mut size_of_next = 0;
    while !window.is_last {
        let in_parallel = window.text().len() >= sizes.parallel;
        if size_of_next == 0 {
            size_of_next = sizes.window;
        } else if size_of_next == sizes.window && in_parallel {
            size_of_next *= rayon::current_num_threads().clamp(1, Sizes::MAX_THREADS);
        }
        next.follow(&window);
        let mut filled = Ok(());
        let mut parsed = Ok(());
        if in_parallel {
            rayon::in_place_scope(|scope| {
                scope.spawn(|_| filled = next.fill(source, size_of_next));
                parsed = reader.parse(&window);
            });
        } else {
            filled = next.fill(source, size_of_next);
            parsed = reader.parse(&window);
        }
        if let Err(fault) = parsed {
            if filled.is_ok() {
                next.complete_line(&window, source);
            }
            return Err(reader.refuse(fault, &window, next.text_after(&window)));
        }
        filled?;
        std::mem::swap(&mut window, &mut next);
    }
    match reader.parse(&window) {
        Ok(()) => reader.finish(&window),
        Err(fault) => Err(reader.refuse(fault, &window, &[])),
    }
}

/// A scene being read.
struct Reader<M, K> {
    parser: Parser,
    /// Where the window begins that is being parsed.
    position: Position,
    sizes: Sizes,
    /// Bytes of the source, if they are known.
    size: Option<u64>,
    make_filter: Option<M>,
    filter: Option<K>,
}

impl<M, K> Reader<M, K>
where
    M: FnOnce(Viewport) -> K,
    K: Fn(&Sphere) -> bool + Sync,
{
    fn new(size: Option<u64>, sizes: Sizes, make_filter: M) -> Self {
        Self {
            parser: Parser::new(),
            position: Position::START,
            sizes,
            size,
            make_filter: Some(make_filter),
            filter: None,
        }
    }

    /// Parses a window, the one behind the last that was parsed.
    fn parse(&mut self, window: &Window) -> Result<(), Fault> {
        let begins_in_comment = self.parser.is_in_comment();
        let at = self.parse_words(window, window.begin, Until::Sphere)?;
        let mut line_feeds = count(&window.bytes[window.begin..at], b'\n');
        if self.parser.is_before_sphere() {
            line_feeds += self.parse_spheres(window, at)?;
        }
        self.position
            .step_over(window, line_feeds, begins_in_comment);
        Ok(())
    }

    /// Parses the rest of a window, where a sphere may begin, and counts its line feeds.
    fn parse_spheres(&mut self, window: &Window, at: usize) -> Result<u64, Fault> {
        if let Some(make_filter) = self.make_filter.take() {
            self.filter = Some(make_filter(self.parser.viewport));
            self.reserve();
        }
        let text = &window.bytes[at..window.end];
        if text.len() >= self.sizes.fast
            && let Some(filter) = &self.filter
            && let Parser { spheres, left, .. } = &mut self.parser
            && let Some(read) = chunks::read(text, spheres, *left, self.sizes, filter)
        {
            self.parser.pass_spheres(read.spheres, read.ends_in_comment);
            return Ok(read.line_feeds);
        }
        self.parse_words(window, at, Until::End)?;
        Ok(count(text, b'\n'))
    }

    fn parse_words(&mut self, window: &Window, at: usize, until: Until) -> Result<usize, Fault> {
        let (text, end) = (&window.bytes, window.end);
        match &self.filter {
            Some(filter) => self.parser.parse(text, at, end, until, filter),
            None => self.parser.parse(text, at, end, until, &|_| true),
        }
    }

    /// Reserves memory for as many spheres as the text can hold. If there is too little
    /// memory, reading goes on: the text may hold fewer spheres.
    fn reserve(&mut self) {
        let Some(size) = self.size else {
            return;
        };
        let max_spheres = size.div_ceil(SHORTEST_SPHERE).min(self.parser.left.into());
        if let Ok(max_spheres) = usize::try_from(max_spheres) {
            let _ = self.parser.spheres.try_reserve_exact(max_spheres);
        }
    }

    /// The refusal of a fault in `window`, with its line. `more` follows what has been read
    /// with the window.
    fn refuse(self, fault: Fault, window: &Window, more: &[u8]) -> SceneError {
        let Fault {
            place,
            kind,
            message,
            mut help,
        } = fault;
        let place = match place {
            FaultPlace::Nowhere => None,
            FaultPlace::End => Some(self.position.end_of_last_word()),
            FaultPlace::At(at) => {
                let after = [&window.bytes[at..window.filled], more].concat();
                let line = after.split(|&byte| byte == b'\n').next();
                let line = line.unwrap_or_default();
                // Wherever the text is cut, so much of the line is in memory.
                let known = &line[..line.len().min(Excerpt::REACH)];
                help = advice::for_line(known).or(help);
                Some(self.position.place(window, at, line))
            }
        };
        SceneError::new(place, kind, message, help)
    }

    /// The scene, if it is complete with `window`, the last one.
    fn finish(self, window: &Window) -> Result<Scene, SceneError> {
        let (is_blank, is_empty) = (self.position.is_blank(), self.position.is_empty());
        if let Err(fault) = self.parser.finish(is_blank, is_empty) {
            return Err(self.refuse(fault, window, &[]));
        }
        Ok(Scene {
            viewport: self.parser.viewport,
            background: self.parser.background,
            spheres: self.parser.spheres,
        })
    }
}

#[cfg(test)]
mod tests;
