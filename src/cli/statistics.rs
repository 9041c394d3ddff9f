//! `--stats`: how long each phase took, and how pixels were settled.

use std::{
    fmt::Write,
    time::{Duration, Instant},
};

use sfera::render::{Counts, Method};

use super::{
    arguments::{Job, Style},
    messages::tell,
};

/// A stopwatch that records each phase.
#[derive(Debug)]
pub(crate) struct Clock {
    start: Instant,
    last: Instant,
    laps: Vec<(&'static str, Duration)>,
}

impl Clock {
    pub(crate) fn start() -> Self {
        let now = Instant::now();
        Self {
            start: now,
            last: now,
            laps: Vec::with_capacity(4),
        }
    }

    pub(crate) fn lap(&mut self, phase: &'static str) {
        let now = Instant::now();
        self.laps.push((phase, now - self.last));
        self.last = now;
    }

    fn total(&self) -> Duration {
        self.last - self.start
    }

    /// The members of a JSON object: each phase, and the total, in milliseconds.
    pub(crate) fn json(&self) -> String {
        let mut json = String::new();
        for (phase, time) in &self.laps {
            let _ = write!(json, "\"{phase}\":{:.3},", milliseconds(*time));
        }
        let _ = write!(json, "\"total\":{:.3}", milliseconds(self.total()));
        json
    }

    /// Lines of text: each phase, and the total.
    pub(crate) fn text(&self) -> String {
        let total = ("total", self.total());
        let laps = self.laps.iter().chain([&total]);
        laps.map(|&(phase, time)| format!("{phase:<8}{:>12.3} ms\n", milliseconds(time)))
            .collect()
    }
}

/// The statistics of a finished picture.
#[derive(Debug)]
pub(crate) struct Report<'run> {
    pub(crate) job: &'run Job,
    pub(crate) spheres: usize,
    /// The number of threads that drew.
    pub(crate) threads: usize,
    pub(crate) counts: Counts,
    pub(crate) clock: &'run Clock,
}

impl Report<'_> {
    pub(crate) fn print(&self, style: Style) {
        match style {
            Style::Text => tell(format_args!("{}", self.text().trim_end())),
            Style::Json => tell(format_args!("{}", self.json())),
        }
    }

    fn pixels(&self) -> f64 {
        self.job.pixels() as f64
    }

    fn text(&self) -> String {
        let mut text = String::new();
        let total = ("total", self.clock.total());
        for &(phase, time) in self.clock.laps.iter().chain([&total]) {
            let _ = write!(text, "{phase:<8}{:>12.3} ms", milliseconds(time));
            if matches!(phase, "render" | "total") {
                let rate = self.pixels() / time.as_secs_f64() / 1e6;
                let _ = write!(text, "  {rate:.1} million pixels a second");
            }
            text.push('\n');
        }
        if self.job.method() == Method::Exact {
            text.push_str("settled ");
            for (index, (stage, pixels)) in stages(&self.counts).into_iter().enumerate() {
                let comma = if index == 0 { "" } else { ", " };
                let _ = write!(text, "{comma}{pixels} pixels by {stage}");
            }
            let _ = writeln!(text, "; {} spheres tested", self.counts.sphere_tests);
        }
        text
    }

    fn json(&self) -> String {
        let job = self.job;
        let mut json = format!(
            "{{{},\"form\":\"{}\",\"threads\":{},\"milliseconds\":{{",
            json_of_job(job, self.spheres),
            job.method().form().unwrap_or_default(),
            self.threads,
        );
        json += &self.clock.json();
        let _ = write!(
            json,
            "}},\"pixels_per_second\":{:.0}",
            self.pixels() / self.clock.total().as_secs_f64(),
        );
        if job.method() == Method::Exact {
            json.push_str(",\"settled_pixels\":{");
            for (index, (stage, pixels)) in stages(&self.counts).into_iter().enumerate() {
                let comma = if index == 0 { "" } else { "," };
                let _ = write!(json, "{comma}\"{stage}\":{pixels}");
            }
            let _ = write!(json, "}},\"sphere_tests\":{}", self.counts.sphere_tests);
        }
        json.push('}');
        json
    }
}

/// The members of a JSON object that every report begins with: what was asked for.
pub(crate) fn json_of_job(job: &Job, spheres: usize) -> String {
    let (size, rows) = (job.size(), job.rows());
    format!(
        "\"width\":{},\"height\":{},\"rows\":[{},{}],\"spheres\":{spheres},\"method\":\"{}\"",
        size.width(),
        size.height(),
        rows.start,
        rows.end,
        job.method(),
    )
}

/// The stages of the engine, and the pixels that each settled.
fn stages(counts: &Counts) -> [(&'static str, u64); 4] {
    [
        ("runs", counts.pixels_in_runs),
        ("packets", counts.pixels_in_packets),
        ("doubles", counts.pixels_in_doubles),
        ("integers", counts.pixels_in_integers),
    ]
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}
