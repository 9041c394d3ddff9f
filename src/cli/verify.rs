//! `--verify`: is what the file says what the method draws?

use std::ops::Range;

use sfera::{
    ppm::{self, ImageError},
    render::Renderer,
};

use super::{Failure, arguments::Job, progress::Progress};

/// Draws the rows again, in memory, and compares them with those of the file.
pub(crate) fn verify(job: &Job, renderer: &Renderer<'_>) -> Result<(), Failure> {
    let (size, rows) = (job.size(), job.rows());
    let progress = Progress::new(size, rows.len(), job.quiet);
    let mut differing = Ranges::default();
    let mut drawn = Vec::new();
    ppm::read_rows(&job.image, size, rows.clone(), |rows, pixels| {
        drawn.resize(pixels.len(), 0);
        renderer.draw(rows.clone(), &mut drawn, &|rows| progress.advance(rows));
        let row_bytes = size.row_bytes();
        for (row, (here, there)) in rows.zip(
            drawn
                .chunks_exact(row_bytes)
                .zip(pixels.chunks_exact(row_bytes)),
        ) {
            if here != there {
                differing.push(row);
            }
        }
        Ok::<(), ImageError>(())
    })?;
    progress.finish();
    if differing.rows == 0 {
        return Ok(());
    }
    Err(Failure::Message(format!(
        "{}: {} of {} rows differ: {}; draw them again with --rows",
        job.image.display(),
        differing.rows,
        rows.len(),
        differing.words()
    )))
}

/// Rows, in the order they come.
#[derive(Debug, Default)]
struct Ranges {
    ranges: Vec<Range<u32>>,
    rows: u32,
}

impl Ranges {
    /// As many ranges as a message can tell.
    const TOLD: usize = 50;

    fn push(&mut self, row: u32) {
        self.rows += 1;
        if let Some(last) = self.ranges.last_mut().filter(|last| last.end == row) {
            last.end += 1;
        } else if self.ranges.len() <= Self::TOLD {
            // One more than is told is enough to know that there are more.
            self.ranges.push(row..row + 1);
        }
    }

    fn words(&self) -> String {
        let told = self.ranges.iter().take(Self::TOLD);
        let mut words: Vec<String> = told
            .map(|range| format!("{}..{}", range.start, range.end))
            .collect();
        if self.ranges.len() > Self::TOLD {
            words.push("and more".into());
        }
        words.join(", ")
    }
}
