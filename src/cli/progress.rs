//! A progress bar, for pictures that take a while and people who watch.

use std::{
    io::{IsTerminal, stderr},
    sync::{
        OnceLock,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use indicatif::{ProgressBar, ProgressStyle};
use sfera::camera::ImageSize;

/// How long a picture may take before it shows.
const PATIENCE: Duration = Duration::from_millis(500);

#[derive(Debug)]
pub(crate) struct Progress {
    watched: bool,
    start: Instant,
    pixels: u64,
    row: u64,
    drawn: AtomicU64,
    bar: OnceLock<ProgressBar>,
}

impl Progress {
    pub(crate) fn new(size: ImageSize, rows: usize, quiet: bool) -> Self {
        let row = u64::from(size.width());
        Self {
            watched: !quiet && stderr().is_terminal(),
            start: Instant::now(),
            pixels: row * rows as u64,
            row,
            drawn: AtomicU64::new(0),
            bar: OnceLock::new(),
        }
    }

    /// Tells of `rows` more.
    pub(crate) fn advance(&self, rows: u32) {
        if !self.watched {
            return;
        }
        let more = u64::from(rows) * self.row;
        let drawn = self.drawn.fetch_add(more, Ordering::Relaxed) + more;
        if self.start.elapsed() < PATIENCE {
            return;
        }
        self.bar.get_or_init(|| self.begin()).set_position(drawn);
    }

    fn begin(&self) -> ProgressBar {
        let style = ProgressStyle::with_template(
            "{bar:40} {percent:>3} %  {human_pos} of {human_len} pixels, {per_sec}, {eta} left",
        );
        let bar = ProgressBar::new(self.pixels).with_elapsed(self.start.elapsed());
        match style {
            Ok(style) => bar.with_style(style),
            Err(_) => bar,
        }
    }

    pub(crate) fn finish(&self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}
