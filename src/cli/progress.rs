//! A progress bar on terminals, for pictures that take a while.

use std::{
    fmt::Write,
    io::{IsTerminal, stderr},
    sync::{
        OnceLock,
        atomic::{AtomicU64, Ordering},
    },
    time::{Duration, Instant},
};

use indicatif::{HumanCount, ProgressBar, ProgressState, ProgressStyle};
use sfera::camera::ImageSize;

use super::signals;

/// How long drawing takes before the bar appears.
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

    /// Records that `rows` more are drawn.
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
        // At most 80 columns: the bar fills what the figures leave.
        let style =
            ProgressStyle::with_template("{wide_bar} {percent:>3} %  {pixels}, {rate}, {eta} left");
        let bar = ProgressBar::new(self.pixels).with_elapsed(self.start.elapsed());
        signals::bar(true);
        match style {
            Ok(style) => bar.with_style(
                style
                    .with_key("pixels", |state: &ProgressState, text: &mut dyn Write| {
                        let (drawn, all) = (state.pos(), state.len().unwrap_or(0));
                        let _ = write!(text, "{} of {} pixels", short(drawn), short(all));
                    })
                    .with_key("rate", |state: &ProgressState, text: &mut dyn Write| {
                        let _ = write!(text, "{:.1} million/s", state.per_sec() / 1e6);
                    }),
            ),
            Err(_) => bar,
        }
    }

    pub(crate) fn finish(&self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
            signals::bar(false);
        }
    }
}

/// A number of pixels in few columns.
fn short(pixels: u64) -> String {
    match pixels {
        0..10_000_000_000 => HumanCount(pixels).to_string(),
        _ => format!("{:.3e}", pixels as f64),
    }
}
