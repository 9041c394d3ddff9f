//! Bands: a row of tiles, painted far to near.
//!
//! In a row a sphere is seen between two columns, so it is painted as a run of
//! bytes and no pixel is looked at. That is right wherever all that is painted
//! later is nearer, which depths of whole spheres tell: for every block of 8 x 8
//! pixels the band keeps the nearest depth painted there, and a sphere whose
//! farthest one is not nearer makes the block *contested*. Contested blocks, and
//! tiles with a crowd of spheres, go to the [packets](super::packet).

use std::ops::Range;

use wide::f64x8;

use super::{
    Bounds, Counts, Engine,
    bins::{Large, Record},
    conic::{Ends, Lanes, Outline, Shape, float_below},
    decide::{Ray, decide},
    packet::{
        BLOCK, BLOCKS, Contest, Depths, Tile, block_bit, blocks_of, blocks_of_box, colour_of,
    },
    set_bits,
};
use crate::{
    camera::BYTES_PER_PIXEL,
    spheres::{LANES, Rgb},
};

/// Rows of the largest tile.
const ROWS: usize = BLOCK * BLOCKS;

/// With more large spheres than this in a band, packets do all of it.
const CROWD_OF_LARGE: usize = 64;

/// With more small spheres than this in a tile, packets do all of it.
const CROWD_OF_SMALL: usize = 32;

/// Room for one band at a time.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    rows: Rows,
    painted: Vec<Painted>,
    blocks: Vec<Block>,
    contested: Vec<u64>,
    /// Pixels at the very end of a row's run.
    doubtful: Vec<(u32, u32)>,
    records: Vec<Record>,
    depths: Depths,
}

/// `Y` and `Y^2 + 1` of a band's rows, and of some below it.
#[derive(Debug)]
struct Rows {
    y: [f64; ROWS + LANES],
    squared: [f64; ROWS + LANES],
}

impl Default for Rows {
    fn default() -> Self {
        Self {
            y: [0.0; ROWS + LANES],
            squared: [0.0; ROWS + LANES],
        }
    }
}

impl Rows {
    fn eight(&self, first: usize) -> (f64x8, f64x8) {
        let eight = |all: &[f64]| f64x8::new(std::array::from_fn(|lane| all[first + lane]));
        (eight(&self.y), eight(&self.squared))
    }
}

/// A large sphere in a band: in each row it is seen in `start..end`.
#[derive(Clone, Debug)]
struct Painted {
    shape: Shape,
    least: f32,
    most: f32,
    pattern: Pattern,
    start: [u32; ROWS],
    end: [u32; ROWS],
}

/// What is known of a block of pixels that are painted.
#[derive(Clone, Copy, Debug)]
struct Block {
    /// Nothing in it is nearer.
    most: f32,
    /// Everything in it is at least as near.
    least: f32,
}

const UNPAINTED: Block = Block {
    most: f32::NEG_INFINITY,
    least: f32::NEG_INFINITY,
};

impl Engine<'_> {
    /// Colours a band: some rows of one row of tiles.
    pub(crate) fn draw_band(
        &self,
        rows: Range<u32>,
        bytes: &mut [u8],
        scratch: &mut Scratch,
    ) -> Counts {
        Band::new(self, rows, bytes, scratch).draw()
    }
}

struct Band<'a> {
    engine: &'a Engine<'a>,
    bytes: &'a mut [u8],
    row_bytes: usize,
    scratch: &'a mut Scratch,
    /// The first row of its tiles.
    origin: u32,
    /// Its rows, from there.
    first: usize,
    last: usize,
    /// Side of a tile.
    side: u32,
    columns: u32,
    counts: Counts,
}

impl<'a> Band<'a> {
    fn new(
        engine: &'a Engine<'a>,
        rows: Range<u32>,
        bytes: &'a mut [u8],
        scratch: &'a mut Scratch,
    ) -> Self {
        let size = engine.grid.camera().size();
        let side = engine.bins.side();
        let origin = rows.start - rows.start % side;
        Self {
            engine,
            bytes,
            row_bytes: size.row_bytes(),
            scratch,
            origin,
            first: (rows.start - origin) as usize,
            last: (rows.end - origin) as usize,
            side,
            columns: size.width(),
            counts: Counts::default(),
        }
    }

    fn draw(mut self) -> Counts {
        let (from, to) = (
            self.origin + self.first as u32,
            self.origin + (self.last - 1) as u32,
        );
        let engine = self.engine;
        let large = engine.bins.large.iter();
        let large: Vec<&Large> = large
            .filter(|large| large.top <= to && large.bottom >= from)
            .collect();
        let crowded = large.len() > CROWD_OF_LARGE;

        self.scratch.contested.clear();
        let tiles = self.columns.div_ceil(self.side) as usize;
        self.scratch
            .contested
            .resize(tiles, if crowded { u64::MAX } else { 0 });
        self.scratch.painted.clear();
        self.scratch.doubtful.clear();
        if !(large.is_empty() && engine.bins.none_small()) {
            for at in 0..ROWS + LANES {
                let row = i64::from(self.origin) + at as i64;
                (self.scratch.rows.y[at], self.scratch.rows.squared[at]) = engine.grid.row(row);
            }
        }
        if !crowded {
            self.outline(&large);
        }
        self.paint_rows();
        let disputed = crowded || !self.undisputed(&large);
        if disputed && !crowded {
            self.contest(&large);
        }
        if disputed {
            for tile in 0..tiles as u32 {
                self.draw_tile(tile, &large);
            }
        }
        self.settle_doubtful(&large);

        let pixels = (self.last - self.first) as u64 * u64::from(self.columns);
        let Counts {
            packets,
            doubles,
            integers,
            ..
        } = self.counts;
        self.counts.rectangles = pixels - packets - doubles - integers;
        self.counts
    }

    /// Where each row sees each large sphere.
    fn outline(&mut self, large: &[&Large]) {
        let engine = self.engine;
        for eight in large.chunks(LANES) {
            let lanes = Lanes::of(eight.iter().map(|large| large.sphere));
            let outlines = Outline::eight(&engine.grid, &lanes, engine.bounds);
            for (outline, large) in outlines.iter().zip(eight) {
                let mut painted = Painted {
                    shape: outline.shape,
                    least: outline.least,
                    most: large.most,
                    pattern: pattern(large.colour),
                    start: [0; ROWS],
                    end: [if outline.shape == Shape::Everywhere {
                        self.columns
                    } else {
                        0
                    }; ROWS],
                };
                if outline.shape == Shape::Convex {
                    let first =
                        large.top.saturating_sub(self.origin).max(self.first as u32) as usize;
                    let last = (large.bottom - self.origin).min(self.last as u32 - 1) as usize;
                    for row in (first / LANES * LANES..=last).step_by(LANES) {
                        let (y, squared) = self.scratch.rows.eight(row);
                        let ends = outline.ends(y, squared, 0, self.columns);
                        painted.start[row..row + LANES].copy_from_slice(&ends.start);
                        painted.end[row..row + LANES].copy_from_slice(&ends.end);
                        self.counts.tests += LANES as u64;
                        if !ends.settled() {
                            self.doubt(&ends, row, self.first..self.last);
                        }
                    }
                }
                self.scratch.painted.push(painted);
            }
        }
    }

    fn doubt(&mut self, ends: &Ends, first: usize, rows: Range<usize>) {
        for lane in 0..LANES {
            if !rows.contains(&(first + lane)) {
                continue;
            }
            let row = self.origin + (first + lane) as u32;
            let sure = ends.start[lane]..ends.end[lane];
            let columns = ends.outer_start[lane]..ends.outer_end[lane];
            let doubtful = columns.filter(|column| !sure.contains(column));
            self.scratch
                .doubtful
                .extend(doubtful.map(|column| (column, row)));
        }
    }

    /// The background, and over it the large spheres, far to near.
    fn paint_rows(&mut self) {
        let background = pattern(self.engine.scene.background);
        for (row, line) in (self.first..self.last).zip(self.bytes.chunks_exact_mut(self.row_bytes))
        {
            // All of it: filling brings lines into the cache that painting would have to
            // read first.
            paint(line, &background);
            for painted in self.scratch.painted.iter().rev() {
                let (start, end) = (painted.start[row], painted.end[row]);
                if start < end {
                    paint(run(line, start, end), &painted.pattern);
                }
            }
        }
    }

    /// Whether nothing has to be known of blocks: no small spheres, and none of the
    /// large ones, which are sorted nearest first, may be nearer than one before it
    /// where their boxes meet.
    fn undisputed(&self, large: &[&Large]) -> bool {
        let clear = |(at, near): (usize, &Painted)| {
            near.shape != Shape::Unknown
                && (at + 1..large.len()).all(|other| {
                    let (a, b) = (large[at], large[other]);
                    near.least > self.scratch.painted[other].most
                        || a.left > b.right
                        || b.left > a.right
                        || a.top > b.bottom
                        || b.top > a.bottom
                })
        };
        self.engine.bins.none_small() && self.scratch.painted.iter().enumerate().all(clear)
    }

    /// The depths of the blocks that large spheres are painted in, far to near, and
    /// those where one isn't nearer than all that was painted before.
    fn contest(&mut self, large: &[&Large]) {
        let across = (self.columns as usize).div_ceil(BLOCK);
        self.scratch.blocks.clear();
        self.scratch
            .blocks
            .resize(across * self.last.div_ceil(BLOCK), UNPAINTED);
        let Scratch {
            painted,
            blocks,
            contested,
            ..
        } = &mut *self.scratch;
        let tile_blocks = self.side as usize / BLOCK;
        let mut contest = |column: usize, down: usize| {
            contested[column / tile_blocks] |= block_bit(column % tile_blocks, down);
        };
        for (painted, large) in painted.iter().zip(large).rev() {
            for down in self.first / BLOCK..=(self.last - 1) / BLOCK {
                let rows = self.first.max(down * BLOCK)..self.last.min((down + 1) * BLOCK);
                if painted.shape == Shape::Unknown {
                    let top = self.origin as usize + rows.start;
                    let bottom = self.origin as usize + rows.end - 1;
                    if large.top as usize <= bottom && large.bottom as usize >= top {
                        for column in large.left as usize / BLOCK..=large.right as usize / BLOCK {
                            contest(column, down);
                        }
                    }
                    continue;
                }
                let mut touched = (u32::MAX, 0);
                let mut covered = (0, u32::MAX);
                for row in rows {
                    let (start, end) = (painted.start[row], painted.end[row]);
                    if start < end {
                        touched = (touched.0.min(start), touched.1.max(end));
                    }
                    covered = (covered.0.max(start), covered.1.min(end));
                }
                if touched.0 >= touched.1 {
                    continue;
                }
                let first_covered = (covered.0 as usize).div_ceil(BLOCK);
                let last_covered = if covered.1 == self.columns {
                    across
                } else {
                    covered.1 as usize / BLOCK
                };
                let touched = touched.0 as usize / BLOCK..(touched.1 as usize).div_ceil(BLOCK);
                for column in touched {
                    let block = &mut blocks[down * across + column];
                    if painted.least <= block.most {
                        contest(column, down);
                    }
                    block.most = block.most.max(painted.most);
                    if (first_covered..last_covered).contains(&column) {
                        block.least = block.least.max(painted.least);
                    }
                }
            }
        }
    }

    /// Paints the small spheres of a tile, far to near; what is contested is left
    /// to packets.
    fn draw_tile(&mut self, column: u32, large: &[&Large]) {
        let engine = self.engine;
        let row = self.origin / self.side;
        let mut runs = engine.bins.records(column, row);
        let none_small = runs.all(<[Record]>::is_empty);
        let mut contested = self.scratch.contested[column as usize];
        if none_small && contested == 0 {
            return;
        }
        let tile = Tile {
            column: column * self.side,
            row: self.origin,
            width: self.side.min(self.columns - column * self.side) as usize,
            height: self.last,
            first: self.first,
            last: self.last,
            side: self.side,
        };
        let all = blocks_of(tile.width, tile.height);

        let floor = if none_small {
            f32::NEG_INFINITY
        } else {
            self.floor(&tile, large)
        };
        let small = engine.bins.nearer(column, row, floor);
        if small.clone().nth(CROWD_OF_SMALL).is_some() {
            contested = all;
        } else if contested & all != all {
            self.scratch.records.clear();
            self.scratch.records.extend(small);
            contested |= self.paint_small(&tile);
        }
        contested &= all;
        self.scratch.contested[column as usize] = contested;
        if contested == 0 {
            return;
        }
        let (right, bottom) = (
            tile.column + tile.width as u32 - 1,
            tile.row + tile.height as u32 - 1,
        );
        let touching = large.iter().filter(|large| {
            large.left <= right
                && large.right >= tile.column
                && large.top <= bottom
                && large.bottom >= tile.row
        });
        let records = &mut self.scratch.records;
        records.clear();
        records.extend(touching.map(|large| large.record(tile.column, tile.row, self.side)));
        let contest = Contest {
            scene: engine.scene,
            grid: &engine.grid,
            bins: &engine.bins,
            bounds: engine.bounds,
            scale: engine.scale,
            tile,
            blocks: contested,
            floor,
            large: records,
        };
        let depths = &mut self.scratch.depths;
        depths.settle(&contest, self.bytes, self.row_bytes, &mut self.counts);
    }

    /// What is farther than this is hidden all over the tile, by one large sphere.
    fn floor(&self, tile: &Tile, large: &[&Large]) -> f32 {
        if self.engine.bounds != Bounds::Proven {
            return f32::NEG_INFINITY;
        }
        let (first, last) = (tile.column, tile.column + tile.width as u32);
        let covers = |painted: &Painted| {
            painted.shape == Shape::Convex
                && (tile.first..tile.last)
                    .all(|row| painted.start[row] <= first && painted.end[row] >= last)
        };
        let Some(at) = self.scratch.painted.iter().position(covers) else {
            return f32::NEG_INFINITY;
        };
        // 1/z is concave over what is seen of a sphere: least at a corner.
        let grid = &self.engine.grid;
        let (_, sphere) = large[at].candidate();
        let rows = [
            tile.row + tile.first as u32,
            tile.row + tile.last as u32 - 1,
        ];
        let corners = rows
            .into_iter()
            .flat_map(|row| [first, last - 1].map(|column| (column, row)));
        let least = corners
            .map(|(column, row)| Ray::new(grid.camera(), column, row).least_inverse_z(&sphere));
        float_below(least.fold(f64::INFINITY, f64::min))
    }

    /// Paints the records gathered, and returns the blocks that are contested.
    fn paint_small(&mut self, tile: &Tile) -> u64 {
        let engine = self.engine;
        let mut records = std::mem::take(&mut self.scratch.records);
        // Packets take equal spheres to be in the order of the file.
        records.sort_unstable_by(|a, b| a.most.total_cmp(&b.most).then(a.index.cmp(&b.index)));
        let across = (self.columns as usize).div_ceil(BLOCK);
        let origin = tile.column as usize / BLOCK;
        let mut contested = 0;
        for eight in records.chunks(LANES) {
            let lanes = Lanes::of(eight.iter().map(|record| record.sphere));
            let outlines = Outline::eight(&engine.grid, &lanes, engine.bounds);
            for (outline, record) in outlines.iter().zip(eight) {
                let top = usize::from(record.top).max(tile.first);
                let bottom = usize::from(record.bottom).min(tile.last - 1);
                if top > bottom {
                    continue;
                }
                let touched = blocks_of_box(&Record {
                    top: top as u8,
                    bottom: bottom as u8,
                    ..*record
                });
                let place = |block: usize| block / BLOCKS * across + origin + block % BLOCKS;
                let (mut free, mut hidden) = (0, 0);
                for at in set_bits(touched) {
                    let block = &self.scratch.blocks[place(at)];
                    if outline.least > block.most {
                        free |= 1 << at;
                    } else if record.most < block.least {
                        hidden |= 1 << at;
                    }
                }
                let others = touched & !(free | hidden);
                if outline.shape != Shape::Convex {
                    contested |= touched;
                    continue;
                }
                // Where it is hidden, painting it is wrong as well.
                if free & !contested == 0 {
                    contested |= others;
                    continue;
                }
                contested |= others | hidden;
                for at in set_bits(touched) {
                    let block = &mut self.scratch.blocks[place(at)];
                    block.most = block.most.max(record.most);
                }
                self.paint_sphere(tile, outline, record, top, bottom);
            }
        }
        self.scratch.records = records;
        contested
    }

    fn paint_sphere(
        &mut self,
        tile: &Tile,
        outline: &Outline,
        record: &Record,
        top: usize,
        bottom: usize,
    ) {
        let pattern = pattern(record.colour);
        let (first, last) = (tile.column, tile.column + tile.width as u32);
        for row in (top..=bottom).step_by(LANES) {
            let (y, squared) = self.scratch.rows.eight(row);
            let ends = outline.ends(y, squared, first, last);
            let rows = LANES.min(bottom + 1 - row);
            self.counts.tests += rows as u64;
            if !ends.settled() {
                self.doubt(&ends, row, top..bottom + 1);
            }
            let lines =
                self.bytes[(row - self.first) * self.row_bytes..].chunks_exact_mut(self.row_bytes);
            for (lane, line) in lines.enumerate().take(rows) {
                let (start, end) = (ends.start[lane], ends.end[lane]);
                if start < end {
                    paint(run(line, start, end), &pattern);
                }
            }
        }
    }

    /// The pixels that an outline passes so closely that doubles can't say.
    fn settle_doubtful(&mut self, large: &[&Large]) {
        let engine = self.engine;
        // Outlines of several spheres may pass one pixel: it is settled, and counted, once.
        self.scratch.doubtful.sort_unstable();
        self.scratch.doubtful.dedup();
        for &(column, row) in &self.scratch.doubtful {
            let (within, down) = (column % self.side, row - self.origin);
            let block = block_bit(within as usize / BLOCK, down as usize / BLOCK);
            if self.scratch.contested[(column / self.side) as usize] & block != 0 {
                continue;
            }
            let records = engine.bins.records(column / self.side, row / self.side);
            let small = records.flatten().map(Record::candidate);
            let candidates = large.iter().map(|large| large.candidate()).chain(small);
            let (seen, rung) = decide(engine.grid.camera(), (column, row), candidates, true);
            self.counts.settled_by(rung);
            let line =
                &mut self.bytes[(down as usize - self.first) * self.row_bytes..][..self.row_bytes];
            run(line, column, column + 1).copy_from_slice(&colour_of(engine.scene, seen));
        }
    }
}

/// The bytes of some columns of a row.
fn run(line: &mut [u8], start: u32, end: u32) -> &mut [u8] {
    &mut line[start as usize * BYTES_PER_PIXEL..end as usize * BYTES_PER_PIXEL]
}

/// A cache line: what memory is written by.
const LINE: usize = 64;

/// The fewest lines that hold whole pixels.
const LINES: usize = LINE * BYTES_PER_PIXEL;

/// A colour again and again, for as many bytes as are copied at a time, from the
/// first byte of a pixel or from another.
type Pattern = [u8; LINES + BYTES_PER_PIXEL];

fn pattern(colour: Rgb) -> Pattern {
    let mut pattern = [0; LINES + BYTES_PER_PIXEL];
    for pixel in pattern.as_chunks_mut().0 {
        *pixel = colour;
    }
    pattern
}

/// Fills a run of whole pixels, the last piece over the one before.
#[inline]
fn paint(run: &mut [u8], pattern: &Pattern) {
    /// From here on, filling with one byte is faster.
    const LONG: usize = 512;
    if run.len() >= LONG && pattern[0] == pattern[1] && pattern[1] == pattern[2] {
        run.fill(pattern[0]);
    } else if run.len() >= LINES {
        // Whole lines, but for the ends.
        pieces::<LINE>(&mut run[..LINE], pattern);
        let first = run.as_ptr().align_offset(LINE).min(LINE);
        let lines = &pattern[first % BYTES_PER_PIXEL..][..LINES];
        for bytes in run[first..].chunks_exact_mut(LINES) {
            bytes.copy_from_slice(lines);
        }
        let last = run.len() - LINES;
        run[last..].copy_from_slice(&pattern[..LINES]);
    } else if run.len() >= 24 {
        pieces::<24>(run, pattern);
    } else if run.len() >= 12 {
        pieces::<12>(run, pattern);
    } else {
        pieces::<3>(run, pattern);
    }
}

#[inline(always)]
fn pieces<const N: usize>(run: &mut [u8], pattern: &Pattern) {
    let (piece, _) = pattern.as_chunks::<N>();
    let (pieces, rest) = run.as_chunks_mut::<N>();
    for bytes in pieces {
        *bytes = piece[0];
    }
    if !rest.is_empty() {
        let last = run.len() - N;
        run[last..].copy_from_slice(&piece[0]);
    }
}
