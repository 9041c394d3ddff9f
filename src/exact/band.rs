//! A band is a row of tiles, drawn tile by tile from the left.

use std::ops::Range;

use super::{
    bins::{Candidate, Large, Record, are_apart},
    bits::{runs, set_bits},
    counts::Counts,
    coverage::{Coverage, Mask, OCTETS, Tile},
    crowd::{Crowd, PreparedTile, UndecidedPixel},
    decide::decide,
    grid::SIDE,
    packet::PixelRow,
    paint::{Pattern, colour_lane, put_eight, put_some},
    prepared::Prepared,
    rows::{self, BandRows},
    tuning::Bounds,
};
use crate::{
    camera::BYTES_PER_PIXEL,
    methods::{NONE, Seen},
    scene::Scene,
    spheres::{LANES, Rgb},
};

/// With more spheres than this, a tile is a crowd: packets draw all of it.
pub(super) const CROWD: usize = 32;

/// So is a tile with more spheres than `SMALL_CROWD` whose boxes have together more than
/// `DEEP_CROWD` times its pixels.
pub(super) const SMALL_CROWD: usize = 12;
const DEEP_CROWD: usize = 7;

/// All pixels of a tile.
const ALL: Mask = [[u64::MAX; LANES]; OCTETS];

/// Memory for drawing one band at a time.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    records: Vec<Record>,
    coverage: Coverage,
    crowd: Crowd,
    pixels: Vec<PixelRow>,
    undecided: Vec<UndecidedPixel>,
    candidates: Vec<Candidate>,
}

/// Draws a band: some rows of one row of tiles.
pub(super) fn draw_band(
    prepared: &Prepared<'_>,
    rows: Range<u32>,
    bytes: &mut [u8],
    scratch: &mut Scratch,
) -> Counts {
    Band::new(prepared, rows, bytes, scratch).draw()
}

struct Band<'a> {
    prepared: &'a Prepared<'a>,
    bytes: &'a mut [u8],
    row_bytes: usize,
    scratch: &'a mut Scratch,
    /// The first row of its tiles in the picture.
    origin: u32,
    /// Its rows, relative to `origin`.
    first: usize,
    last: usize,
    /// The colour lane of the background.
    background: u32,
    counts: Counts,
    /// Columns of one colour that are not painted yet.
    pending: Option<(Rgb, Range<u32>)>,
}

impl<'a> Band<'a> {
    fn new(
        prepared: &'a Prepared<'a>,
        rows: Range<u32>,
        bytes: &'a mut [u8],
        scratch: &'a mut Scratch,
    ) -> Self {
        let side = prepared.bins.side();
        let origin = rows.start - rows.start % side;
        // Pixels are cleared right after they are written, while they are in the cache.
        let background = colour_lane(prepared.scene.background);
        scratch.pixels.resize(SIDE, PixelRow::new(background));
        Self {
            prepared,
            bytes,
            row_bytes: prepared.grid.camera().size().row_bytes(),
            scratch,
            origin,
            first: (rows.start - origin) as usize,
            last: (rows.end - origin) as usize,
            background,
            counts: Counts::default(),
            pending: None,
        }
    }

    fn draw(mut self) -> Counts {
        let (from, to) = (
            self.origin + self.first as u32,
            self.origin + (self.last - 1) as u32,
        );
        let prepared = self.prepared;
        let large = prepared.bins.large.iter();
        let large: Vec<&Large> = large
            .filter(|large| large.sides[2] <= to && large.sides[3] >= from)
            .collect();
        self.paint_background();
        if self.draw_rows(&large) {
            return self.counted();
        }
        let (columns, side) = (prepared.grid.camera().size().width(), prepared.bins.side());
        for column in 0..columns.div_ceil(side) {
            let tile = Tile {
                column: column * side,
                row: self.origin,
                width: side.min(columns - column * side) as usize,
                first: self.first,
                last: self.last,
            };
            self.draw_tile(&tile, &large);
        }
        self.paint_pending();
        self.counted()
    }

    fn counted(mut self) -> Counts {
        let columns = self.row_bytes / BYTES_PER_PIXEL;
        let pixels = ((self.last - self.first) * columns) as u64;
        self.counts.pixels_in_runs = pixels - self.counts.pixels_beyond_runs();
        self.counts
    }

    /// Paints whole rows, if no pixel of the band is contested.
    fn draw_rows(&mut self, large: &[&Large]) -> bool {
        let prepared = self.prepared;
        if prepared.bounds != Bounds::Proven || !prepared.bins.has_none_small() {
            return false;
        }
        let rows = BandRows {
            origin: self.origin,
            first: self.first,
            last: self.last,
        };
        let Some(outlines) = rows::undisputed(&prepared.grid, rows, large) else {
            return false;
        };
        let mut doubtful = Vec::new();
        for (outline, large) in outlines.iter().zip(large).rev() {
            rows::paint(
                outline,
                large,
                rows,
                self.bytes,
                self.row_bytes,
                &mut doubtful,
            );
        }
        self.counts.sphere_tests += large.len() as u64;
        // Several outlines may pass through one pixel; it is decided and counted once.
        doubtful.sort_unstable();
        doubtful.dedup();
        for (column, row) in doubtful {
            let candidates = &mut self.scratch.candidates;
            candidates.clear();
            candidates.extend(large.iter().map(|large| (large.index, large.sphere)));
            self.put_decided((column, row));
        }
        true
    }

    /// Paints all of the band at once, so that later painting finds these lines in the cache.
    /// That is faster even where no background remains.
    fn paint_background(&mut self) {
        let [red, green, blue] = self.prepared.scene.background;
        if red == green && green == blue {
            self.bytes.fill(red);
            return;
        }
        let (first, others) = self.bytes.split_at_mut(self.row_bytes);
        let columns = first.len() / BYTES_PER_PIXEL;
        Pattern::new(self.prepared.scene.background).paint(first, 0, columns);
        for line in others.chunks_exact_mut(self.row_bytes) {
            line.copy_from_slice(first);
        }
    }

    fn draw_tile(&mut self, tile: &Tile, large: &[&Large]) {
        let bins = &self.prepared.bins;
        let side = bins.side();
        let (right, bottom) = (
            tile.column + tile.width as u32 - 1,
            tile.row + tile.last as u32 - 1,
        );
        let sides = [tile.column, right, tile.row, bottom];
        let touching = large.iter().filter(|large| !are_apart(large.sides, sides));
        let records = &mut self.scratch.records;
        records.clear();
        records.extend(touching.map(|large| large.record(tile.column, tile.row, side)));
        let large_count = records.len();
        let small = bins.records(tile.column / side, tile.row / side);
        let count = large_count + bins.count(tile.column / side, tile.row / side);
        if count <= CROWD {
            records.extend(small.flatten().filter(|record| !tile.is_beside(record)));
            if records.is_empty() {
                return;
            }
        }
        let area = || records.iter().map(Record::area).sum::<usize>();
        if count > CROWD || records.len() > SMALL_CROWD && area() > DEEP_CROWD * SIDE * SIDE {
            records.truncate(large_count);
            self.paint_pending();
            self.draw_crowd(tile);
            return;
        }
        let (grid, bounds) = (&self.prepared.grid, self.prepared.bounds);
        self.scratch.coverage.find(grid, tile, records, bounds);
        self.counts.sphere_tests += records.len() as u64;
        self.draw_few(tile);
    }

    /// A tile of one colour.
    fn fill(&mut self, tile: &Tile, colour: Rgb) {
        let end = tile.column + tile.width as u32;
        if let Some((pending, columns)) = &mut self.pending {
            if *pending == colour && columns.end == tile.column {
                columns.end = end;
                return;
            }
            self.paint_pending();
        }
        self.pending = Some((colour, tile.column..end));
    }

    fn paint_pending(&mut self) {
        let Some((colour, columns)) = self.pending.take() else {
            return;
        };
        let pattern = Pattern::new(colour);
        for line in self.bytes.chunks_exact_mut(self.row_bytes) {
            pattern.paint(line, columns.start as usize, columns.end as usize);
        }
    }

    /// Paints the masks of the coverage from far to near, and settles the contested pixels.
    fn draw_few(&mut self, tile: &Tile) {
        let coverage = &self.scratch.coverage;
        if let ([at], true, false) = (
            &coverage.order[..],
            coverage.is_covered,
            coverage.any_contested,
        ) {
            let colour = coverage.spheres[*at].record.colour;
            self.fill(tile, colour);
            return;
        }
        self.paint_pending();
        let first = tile.column as usize;
        let coverage = &self.scratch.coverage;
        for &at in &coverage.order {
            let covering = &coverage.spheres[at];
            let pattern = Pattern::new(covering.record.colour);
            let rows = covering.record.rows();
            let rows = rows.start.max(tile.first)..rows.end.min(tile.last);
            if !covering.in_runs {
                for row in rows {
                    let line =
                        &mut self.bytes[(row - tile.first) * self.row_bytes..][..self.row_bytes];
                    for columns in runs(coverage.outer(covering, row)) {
                        pattern.paint(line, first + columns.start, first + columns.end);
                    }
                }
                continue;
            }
            let ends = coverage.ends_of(covering, rows.clone());
            let lines = self.bytes[(rows.start - tile.first) * self.row_bytes..]
                .chunks_exact_mut(self.row_bytes);
            for (&[start, end], line) in ends.iter().zip(lines) {
                if start < end {
                    pattern.paint(line, first + usize::from(start), first + usize::from(end));
                }
            }
        }
        if coverage.any_contested {
            self.settle_contested(tile);
        }
    }

    /// Settles the contested pixels of a tile of few spheres.
    fn settle_contested(&mut self, tile: &Tile) {
        let prepared_tile = self.prepared_tile(tile);
        let Scratch {
            coverage,
            crowd,
            pixels,
            ..
        } = &mut *self.scratch;
        self.counts.sphere_tests += crowd.meet_contested(&prepared_tile, coverage, pixels);
        let contested = coverage.contested;
        let put = self.put_packets(tile, &contested);
        self.decide_pixels(tile, put);
    }

    fn prepared_tile(&self, tile: &Tile) -> PreparedTile<'a> {
        PreparedTile {
            prepared: self.prepared,
            tile: *tile,
        }
    }

    /// Decides a pixel of the picture among the gathered candidates.
    fn put_decided(&mut self, at: (u32, u32)) {
        let prepared = self.prepared;
        let trusted = prepared.bounds != Bounds::Refused;
        let candidates = &self.scratch.candidates;
        let (seen, rung) = decide(prepared.grid.camera(), at, candidates, trusted);
        self.counts.settled_by(rung);
        let (column, row) = (at.0 as usize, (at.1 - self.origin) as usize - self.first);
        let line = &mut self.bytes[row * self.row_bytes..][..self.row_bytes];
        run(line, column..column + 1).copy_from_slice(&colour_of(prepared.scene, seen));
    }

    /// Draws all pixels of a tile of many spheres by packets; `scratch.records` are the large
    /// spheres.
    fn draw_crowd(&mut self, tile: &Tile) {
        let crowded = self.prepared_tile(tile);
        let Scratch { records, crowd, .. } = &mut *self.scratch;
        let mut sorted = crowd.gather(&crowded, records);
        loop {
            let Scratch { crowd, pixels, .. } = &mut *self.scratch;
            self.counts.sphere_tests += crowd.meet(&crowded, sorted, pixels);
            let put = self.put_packets(tile, &ALL);
            let undecided = self.scratch.undecided.len();
            if sorted || !self.scratch.crowd.may_hold_copies(undecided) {
                self.decide_pixels(tile, put);
                return;
            }
            sorted = true;
        }
    }

    /// Writes the contested pixels of a tile, finds those that are undecided, and clears its packets, row
    /// by row, since a tile is larger than the first-level cache. Returns how many it wrote.
    fn put_packets(&mut self, tile: &Tile, contested: &Mask) -> u64 {
        let ignored = self.prepared.bounds == Bounds::Ignored;
        let Scratch {
            pixels, undecided, ..
        } = &mut *self.scratch;
        undecided.clear();
        let (mut put, full) = (0, u64::MAX >> (SIDE - tile.width));
        for (row, pixels) in pixels.iter_mut().enumerate() {
            let contested = contested[row / LANES][row % LANES];
            if contested == 0 {
                continue;
            }
            // Boxes may extend into rows that are not drawn now.
            if (tile.first..tile.last).contains(&row) {
                let line = &mut self.bytes[(row - tile.first) * self.row_bytes..][..self.row_bytes];
                let line = &mut line[tile.column as usize * BYTES_PER_PIXEL..];
                let columns = if contested == u64::MAX {
                    put_row(&mut line[..tile.width * BYTES_PER_PIXEL], pixels)
                } else {
                    put_some_of_row(line, pixels, contested)
                };
                let columns = if ignored { 0 } else { columns };
                put += u64::from((contested & full).count_ones());
                undecided.extend(set_bits(columns).map(|column| UndecidedPixel {
                    column: column as u8,
                    row: row as u8,
                    lower: pixels.lower(column).as_array()[0],
                }));
            }
            pixels.clear(self.background);
        }
        put
    }

    /// Decides the undecided pixels of a tile, of those that were written.
    fn decide_pixels(&mut self, tile: &Tile, put: u64) {
        let count = self.scratch.undecided.len();
        self.counts.pixels_in_packets += put - count as u64;
        for at in 0..count {
            let Scratch {
                crowd,
                undecided,
                candidates,
                ..
            } = &mut *self.scratch;
            let pixel = undecided[at];
            crowd.candidates(&pixel, candidates);
            self.put_decided(tile.pixel(usize::from(pixel.column), usize::from(pixel.row)));
        }
    }
}

pub(super) fn colour_of(scene: &Scene, seen: Seen) -> Rgb {
    match seen {
        NONE => scene.background,
        _ => scene.spheres.colour()[seen as usize],
    }
}

/// Writes the colours of the first pixels of a row to all of `line`. Returns a mask of the pixels
/// that are undecided.
#[inline]
fn put_row(line: &mut [u8], pixels: &PixelRow) -> u64 {
    // Of a whole tile the compiler knows the number of packets.
    match line.first_chunk_mut::<{ SIDE * BYTES_PER_PIXEL }>() {
        Some(line) => put_each(line, pixels),
        None => put_each(line, pixels),
    }
}

#[inline(always)]
fn put_each(line: &mut [u8], pixels: &PixelRow) -> u64 {
    let width = line.len() / BYTES_PER_PIXEL;
    let mut undecided = 0;
    for first in (0..width).step_by(LANES) {
        put_eight(&mut line[first * BYTES_PER_PIXEL..], pixels.colours(first));
        undecided |= u64::from(pixels.undecided_lanes(first)) << first;
    }
    undecided & u64::MAX >> (SIDE - width)
}

/// Writes the colours of some pixels of a row, given by their bits. Returns a mask of those that are
/// undecided.
fn put_some_of_row(line: &mut [u8], pixels: &PixelRow, mut wanted: u64) -> u64 {
    let mut undecided = 0;
    while wanted != 0 {
        let first = wanted.trailing_zeros() as usize / LANES * LANES;
        let bits = wanted >> first & 0xff;
        wanted &= !(0xff << first);
        let line = &mut line[first * BYTES_PER_PIXEL..];
        if bits == 0xff {
            put_eight(&mut line[..LANES * BYTES_PER_PIXEL], pixels.colours(first));
        } else {
            put_some(line, pixels.colours(first), bits as u32);
        }
        undecided |= (u64::from(pixels.undecided_lanes(first)) & bits) << first;
    }
    undecided
}

/// The bytes of some columns of a row.
fn run(line: &mut [u8], columns: Range<usize>) -> &mut [u8] {
    &mut line[columns.start * BYTES_PER_PIXEL..columns.end * BYTES_PER_PIXEL]
}
