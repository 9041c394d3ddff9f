//! Counts the wrong pixels, and keeps some of them.

use std::ops::Range;

use sfera::{
    camera::{BYTES_PER_PIXEL, ImageSize},
    spheres::Rgb,
};

/// A wrong pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Wrong {
    /// Column and row.
    pub(super) pixel: (u32, u32),
    pub(super) found: Rgb,
    pub(super) right: Rgb,
}

/// The counts, and the wrong pixels that are kept while a picture is compared. Its memory is
/// bounded.
#[derive(Debug)]
pub(super) struct Tally {
    size: ImageSize,
    pub(super) wrong: u64,
    pub(super) rows: Ranges,
    pub(super) first: Vec<Wrong>,
    spread: Spread,
    pub(super) sample: Sample,
}

impl Tally {
    /// How many wrong pixels are shown.
    const SHOWN: usize = 10;

    pub(super) fn new(size: ImageSize, rows: Range<u32>) -> Self {
        Self {
            size,
            wrong: 0,
            rows: Ranges::default(),
            first: Vec::new(),
            spread: Spread::default(),
            sample: Sample::new(size, rows),
        }
    }

    /// Compares the pixels `found` in some rows with the `right` ones.
    pub(super) fn compare(&mut self, rows: Range<u32>, found: &[u8], right: &[u8]) {
        let row_bytes = self.size.row_bytes();
        let lines = found
            .chunks_exact(row_bytes)
            .zip(right.chunks_exact(row_bytes));
        for (row, (found, right)) in rows.zip(lines) {
            self.sample.offer(row, found);
            if found != right {
                self.rows.push(row);
                self.compare_row(row, found, right);
            }
        }
    }

    fn compare_row(&mut self, row: u32, found: &[u8], right: &[u8]) {
        let (found, _) = found.as_chunks::<BYTES_PER_PIXEL>();
        let (right, _) = right.as_chunks::<BYTES_PER_PIXEL>();
        for (column, (&found, &right)) in (0..).zip(found.iter().zip(right)) {
            if found == right {
                continue;
            }
            let wrong = Wrong {
                pixel: (column, row),
                found,
                right,
            };
            if self.first.len() < Self::SHOWN {
                self.first.push(wrong);
            }
            self.spread.offer(self.wrong, wrong);
            self.wrong += 1;
        }
    }

    /// At most `limit` wrong pixels, evenly chosen from all of them.
    pub(super) fn spread(&self, limit: usize) -> Vec<Wrong> {
        let kept = &self.spread.kept;
        let step = kept.len().div_ceil(limit.max(1)).max(1);
        kept.iter().step_by(step).copied().collect()
    }
}

/// Every `2^n`th wrong pixel, with the least `n` for which there are at most [`LIMIT`](Self::LIMIT).
#[derive(Debug, Default)]
struct Spread {
    kept: Vec<Wrong>,
    step: u64,
}

impl Spread {
    const LIMIT: usize = 1 << 14;

    fn offer(&mut self, number: u64, wrong: Wrong) {
        self.step = self.step.max(1);
        if !number.is_multiple_of(self.step) {
            return;
        }
        if self.kept.len() == Self::LIMIT {
            let mut index = 0;
            self.kept.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.step *= 2;
            if !number.is_multiple_of(self.step) {
                return;
            }
        }
        self.kept.push(wrong);
    }
}

/// Blocks of rows of the picture, on which explanations are tried.
#[derive(Debug)]
pub(super) struct Sample {
    /// The first row that is compared.
    start: u32,
    block: u32,
    /// One of this many blocks is kept.
    step: u32,
    /// Rows and their pixels; neighbouring blocks are joined.
    pub(super) pieces: Vec<(Range<u32>, Vec<u8>)>,
}

impl Sample {
    const PIXELS: u64 = 1 << 20;
    const BLOCK: u32 = 16;

    fn new(size: ImageSize, rows: Range<u32>) -> Self {
        let width = u64::from(size.width());
        // A picture with very long rows has no blocks.
        let block = (Self::PIXELS / width).min(Self::BLOCK.into()) as u32;
        let step = (width * rows.len() as u64).div_ceil(Self::PIXELS);
        Self {
            start: rows.start,
            block,
            step: u32::try_from(step).unwrap_or(u32::MAX),
            pieces: Vec::new(),
        }
    }

    fn offer(&mut self, row: u32, found: &[u8]) {
        let Some(block) = (row - self.start).checked_div(self.block) else {
            return;
        };
        if !block.is_multiple_of(self.step) {
            return;
        }
        match self.pieces.last_mut().filter(|(rows, _)| rows.end == row) {
            Some((rows, pixels)) => {
                rows.end += 1;
                pixels.extend_from_slice(found);
            }
            None => self.pieces.push((row..row + 1, found.to_vec())),
        }
    }

    pub(super) fn pixels(&self) -> u64 {
        let bytes: usize = self.pieces.iter().map(|(_, pixels)| pixels.len()).sum();
        (bytes / BYTES_PER_PIXEL) as u64
    }
}

/// Ranges of rows, in ascending order.
#[derive(Debug, Default)]
pub(super) struct Ranges {
    ranges: Vec<Range<u32>>,
    pub(super) rows: u32,
}

impl Ranges {
    /// How many ranges a message shows.
    const SHOWN: usize = 50;

    fn push(&mut self, row: u32) {
        self.rows += 1;
        if let Some(last) = self.ranges.last_mut().filter(|last| last.end == row) {
            last.end += 1;
        } else if self.ranges.len() <= Self::SHOWN {
            // One more than is shown, so that it is known whether there are more.
            self.ranges.push(row..row + 1);
        }
    }

    /// The ranges that are shown, and whether these are all.
    pub(super) fn shown(&self) -> (&[Range<u32>], bool) {
        let shown = self.ranges.len().min(Self::SHOWN);
        (&self.ranges[..shown], shown == self.ranges.len())
    }

    pub(super) fn words(&self) -> String {
        let (shown, all) = self.shown();
        let mut words: Vec<String> = shown
            .iter()
            .map(|range| format!("{}..{}", range.start, range.end))
            .collect();
        if !all {
            words.push("and more".into());
        }
        words.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrong(number: u64) -> Wrong {
        Wrong {
            pixel: (number as u32, 0),
            found: [0; 3],
            right: [1; 3],
        }
    }

    #[test]
    fn few_wrong_pixels_are_kept_and_they_come_from_all_of_them() {
        for count in [0, 1, 16_384, 16_385, 100_000, 1_000_000] {
            let mut spread = Spread::default();
            (0..count).for_each(|number| spread.offer(number, wrong(number)));
            let kept = &spread.kept;
            assert!(kept.len() <= Spread::LIMIT && kept.len() as u64 >= count.min(8192));
            let step = count.div_ceil(Spread::LIMIT as u64).next_power_of_two();
            for (index, pixel) in kept.iter().enumerate() {
                assert_eq!(*pixel, wrong(index as u64 * step), "{count}");
            }
        }
    }

    #[test]
    fn a_sample_is_blocks_of_rows_from_the_whole_picture() {
        let size = ImageSize::new(2048, 3000).expect("a size with pixels");
        let mut tally = Tally::new(size, 40..3000);
        let row = vec![0; size.row_bytes()];
        for first in (40..3000).step_by(37) {
            let rows = first..(first + 37).min(3000);
            let pixels = row.repeat(rows.len());
            tally.compare(rows, &pixels, &pixels);
        }
        let sample = &tally.sample;
        assert!((1 << 19..=(1 << 20) + 16 * 2048).contains(&sample.pixels()));
        for (index, (rows, pixels)) in sample.pieces.iter().enumerate() {
            let start = 40 + index as u32 * 16 * 6;
            assert_eq!(*rows, start..(start + 16).min(3000));
            assert_eq!(pixels.len(), rows.len() * size.row_bytes());
        }
        assert_eq!(sample.pieces.len(), 31);
        assert_eq!((tally.wrong, tally.first.len()), (0, 0));
    }
}
