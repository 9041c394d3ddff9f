//! Tiles of many spheres: packets for every pixel.
//!
//! Where boxes are small and lie side by side, spheres are met in file order, straight
//! from the bins. Where much lies behind others they are met nearest first, and a sphere
//! that is farther than all leaders of its box is left out.

use std::ops::ControlFlow;

use wide::f32x8;

use super::{
    Bounds,
    bins::{Bins, Record},
    coverage::{Tile, eight},
    decide::Candidate,
    depths::Depths,
    grid::{EightSpheres, Grid},
    packet::{Meeting, PixelRow, SIDE},
    paint::colour_lane,
    set_bits,
};
use crate::spheres::{LANES, Rgb};

/// Boxes that would cover a tile so many times are worth ordering, if on the average
/// they are of so many pixels.
const DEEP: usize = 8;
const LABORIOUS: usize = 16;

/// Of so many spheres one is asked for its box.
const SAMPLE: usize = 16;

/// So many open pixels in a tile are no accident: some spheres may be equal.
const MANY_OPEN: u32 = 64;

/// After so many packets, those of a whole tile, and again after each quarter more, it
/// is asked what the spheres before hide.
const FIRST_FLOORS: u64 = (SIDE * BLOCKS) as u64;

/// Blocks of 8 x 8 pixels along the side of the largest tile: a tile's blocks are the
/// bits of a `u64`.
const BLOCKS: usize = SIDE / LANES;

/// A tile of many spheres.
pub(super) struct CrowdedTile<'a> {
    pub(super) grid: &'a Grid,
    pub(super) bins: &'a Bins,
    pub(super) bounds: Bounds,
    pub(super) background: Rgb,
    pub(super) tile: Tile,
}

impl<'a> CrowdedTile<'a> {
    /// The small spheres that may be nearer than `floor`, in file order.
    fn small(&self, floor: f32) -> impl Iterator<Item = &'a Record> + Clone {
        let tile = self.tile;
        self.runs()
            .flatten()
            .filter(move |record| record.upper >= floor && !tile.is_beside(record))
    }

    fn runs(&self) -> impl Iterator<Item = &'a [Record]> + Clone {
        let side = self.bins.side();
        let (column, row) = (self.tile.column / side, self.tile.row / side);
        self.bins.records(column, row)
    }
}

/// Room for the spheres of a tile.
#[derive(Debug, Default)]
pub(super) struct Crowd {
    /// What was met in the tile, all of it in one place, and the boxes of that.
    met: Vec<Record>,
    boxes: Vec<[u8; 4]>,
    sorted: Vec<Record>,
    keys: Vec<u64>,
    hidden: Hidden,
}

/// What is known to be hidden while the spheres of a tile are met.
#[derive(Debug, Default)]
struct Hidden {
    /// Behind this, all over the tile.
    floor: f32,
    /// Behind this, in each block, if that was asked.
    floors: Option<[f32; BLOCKS * BLOCKS]>,
    /// Packets met.
    met: u64,
    next_floors: u64,
    last: Option<Record>,
}

impl Crowd {
    /// Meets all spheres of a tile, of whose pixels only the background is known. Returns in
    /// how many packets.
    pub(super) fn meet(
        &mut self,
        crowded: &CrowdedTile<'_>,
        large: &mut Vec<Record>,
        pixels: &mut [PixelRow],
    ) -> u64 {
        let floor = self.refine(crowded, large);
        let deep = is_deep(crowded, large, floor) || has_copies(crowded, floor);
        if crowded.bounds == Bounds::Ignored {
            self.meet_all::<false>(crowded, large, floor, deep, pixels);
            return self.hidden.met;
        }
        self.meet_all::<true>(crowded, large, floor, deep, pixels);
        let met = self.hidden.met;
        if deep || count_open(&crowded.tile, pixels) <= MANY_OPEN {
            return met;
        }
        let background = colour_lane(crowded.background);
        for row in &mut pixels[crowded.tile.first..crowded.tile.last] {
            row.clear(background);
        }
        self.meet_all::<true>(crowded, large, floor, true, pixels);
        met + self.hidden.met
    }

    /// The spheres that were met and may be seen in a pixel.
    pub(super) fn gather(&self, column: usize, row: usize, candidates: &mut Vec<Candidate>) {
        let (column, row) = (column as u8, row as u8);
        let holds = |&[left, right, top, bottom]: &[u8; 4]| {
            (left <= column) & (column <= right) & (top <= row) & (row <= bottom)
        };
        candidates.clear();
        let boxes = self.boxes.chunks(4 * LANES);
        for (boxes, records) in boxes.zip(self.met.chunks(4 * LANES)) {
            // Most boxes don't hold the pixel: many are asked at a time.
            if boxes.iter().fold(false, |any, sides| any | holds(sides)) {
                let holding = boxes.iter().zip(records);
                let holding = holding.filter(|(sides, _)| holds(sides));
                candidates.extend(holding.map(|(_, record)| record.candidate()));
            }
        }
    }

    /// Gives large spheres the bounds of their inverse depths in this tile, and drops those
    /// that are hidden in it. Returns the inverse depth behind which all is hidden.
    fn refine(&self, crowded: &CrowdedTile<'_>, large: &mut Vec<Record>) -> f32 {
        let mut floor = f32::NEG_INFINITY;
        if crowded.bounds != Bounds::Proven {
            return floor;
        }
        let tile = &crowded.tile;
        for chunk in large.chunks_mut(LANES) {
            let records = eight(chunk);
            let spheres = EightSpheres::of(records.iter().map(|record| record.sphere));
            let depths = Depths::new(crowded.grid, &tile.rectangles(&records), &spheres);
            let ranges = depths.ranges([0.0; LANES], records.map(|record| record.upper));
            for (lane, record) in chunk.iter_mut().enumerate() {
                record.upper = ranges.upper[lane];
                if ranges.covered >> lane & 1 == 1 && tile.is_all_of(record) {
                    floor = floor.max(ranges.lower[lane]);
                }
            }
        }
        large.retain(|record| record.upper >= floor.max(0.0) && !tile.is_beside(record));
        floor
    }

    /// All spheres of the tile, if `sorted` the nearest first and each only in the blocks
    /// where it isn't hidden.
    fn meet_all<const PROVEN: bool>(
        &mut self,
        crowded: &CrowdedTile<'_>,
        large: &[Record],
        floor: f32,
        sorted: bool,
        pixels: &mut [PixelRow],
    ) {
        self.met.clear();
        self.boxes.clear();
        self.hidden = Hidden {
            floor,
            next_floors: FIRST_FLOORS,
            ..Hidden::default()
        };
        let all = large.iter().chain(crowded.small(floor));
        if sorted {
            let mut records = std::mem::take(&mut self.sorted);
            records.clear();
            records.extend(all);
            let mut keys = std::mem::take(&mut self.keys);
            nearest_first(&records, &mut keys);
            let nearest_first = keys.iter().map(|&key| &records[place(key)]);
            in_eights(nearest_first, |eight| {
                self.meet_eight::<PROVEN, true>(crowded, eight, pixels)
            });
            self.sorted = records;
            self.keys = keys;
        } else {
            in_eights(all, |eight| {
                self.meet_eight::<PROVEN, false>(crowded, eight, pixels)
            });
        }
    }

    /// Meets up to eight spheres; if they are `SORTED`, what is hidden by those before
    /// is left out. Breaks if all that follow are hidden.
    #[inline]
    fn meet_eight<const PROVEN: bool, const SORTED: bool>(
        &mut self,
        crowded: &CrowdedTile<'_>,
        records: &[Record],
        pixels: &mut [PixelRow],
    ) -> ControlFlow<()> {
        if SORTED && records[0].upper < self.hidden.floor {
            return ControlFlow::Break(());
        }
        let spheres = EightSpheres::of(records.iter().map(|record| record.sphere));
        let rectangles = crowded.tile.rectangles(&eight(records));
        let depths = Depths::new(crowded.grid, &rectangles, &spheres).to_floats(crowded.bounds);
        if !SORTED {
            self.met.extend_from_slice(records);
            self.boxes.extend(records.iter().map(Record::sides));
        }
        for (lane, record) in records.iter().enumerate() {
            let mut open = u64::MAX;
            if SORTED {
                // Of equal spheres the first of the file is seen; they sort together.
                if self.hidden.last.is_some_and(|last| last.is_equal(record)) {
                    continue;
                }
                self.hidden.last = Some(*record);
                self.met.push(*record);
                self.boxes.push(record.sides());
                if let Some(floors) = &self.hidden.floors {
                    let seen = |&block: &usize| record.upper >= floors[block];
                    open = set_bits(blocks_of(record))
                        .filter(seen)
                        .fold(0, |open, block| open | 1 << block);
                }
            }
            let meeting = Meeting {
                depths: &depths,
                lane,
                colour: colour_lane(record.colour),
                record,
            };
            let tile = &crowded.tile;
            self.hidden.met += if open == 0 {
                0
            } else if depths.known >> lane & 1 == 0 {
                {
                    let at = (tile.column, tile.row);
                    meeting.in_doubles(pixels, crowded.grid, at, crowded.bounds, |_| u64::MAX)
                }
            } else if record.is_narrow() {
                meeting.narrow::<PROVEN>(pixels)
            } else if open == u64::MAX {
                let [left, right, top, bottom] = record.sides().map(usize::from);
                meeting.wide::<PROVEN>(pixels, (left, right + 1), (top, bottom + 1))
            } else {
                meet_blocks::<PROVEN>(&meeting, pixels, open)
            };
            if PROVEN && SORTED && self.hidden.met >= self.hidden.next_floors {
                self.hidden.ask(tile, pixels);
            }
        }
        ControlFlow::Continue(())
    }
}

/// Whether the boxes of a tile lie so deep that an order pays, by a sample of them.
fn is_deep(crowded: &CrowdedTile<'_>, large: &[Record], floor: f32) -> bool {
    let sample = crowded.runs().flat_map(|run| run.iter().step_by(SAMPLE));
    let sample = sample.filter(|record| record.upper >= floor);
    let sum = |(count, area), record: &Record| (count + 1, area + record.area());
    let (count, area) = sample.fold((0, 0), sum);
    let large_area = large.iter().map(Record::area).sum::<usize>();
    let overdraw = area * SAMPLE + large_area;
    let laborious = area + large_area >= LABORIOUS * (count + large.len());
    laborious && overdraw >= DEEP * SIDE * SIDE
}

/// Whether the first of the small spheres comes again: then others may, too, and only an
/// order tells copies apart quickly.
fn has_copies(crowded: &CrowdedTile<'_>, floor: f32) -> bool {
    let mut small = crowded.small(floor);
    let first = small.next();
    first.is_some_and(|first| small.any(|record| record.is_equal(first)))
}

fn count_open(tile: &Tile, pixels: &[PixelRow]) -> u32 {
    let open = |row: &PixelRow| {
        let packets = (0..tile.width).step_by(LANES);
        packets
            .map(|first| row.open(first).count_ones())
            .sum::<u32>()
    };
    pixels[tile.first..tile.last].iter().map(open).sum()
}

/// Meets a sphere in some blocks of its box, and perhaps beside them.
fn meet_blocks<const PROVEN: bool>(
    meeting: &Meeting<'_>,
    pixels: &mut [PixelRow],
    blocks: u64,
) -> u64 {
    let [left, right, top, bottom] = meeting.record.sides().map(usize::from);
    let mut met = 0;
    for down in top / LANES..bottom / LANES + 1 {
        let in_row = blocks >> (down * BLOCKS) & 0xff;
        if in_row == 0 {
            continue;
        }
        let from = left.max(in_row.trailing_zeros() as usize * LANES);
        let to = (right + 1).min((64 - in_row.leading_zeros() as usize) * LANES);
        let rows = (top.max(down * LANES), (bottom + 1).min((down + 1) * LANES));
        met += meeting.wide::<PROVEN>(pixels, (from, to), rows);
    }
    met
}

impl Hidden {
    /// Asks what the leaders of each block hide.
    fn ask(&mut self, tile: &Tile, pixels: &[PixelRow]) {
        self.next_floors = self.met + (self.met / 4).max(FIRST_FLOORS);
        let mut floors = [f32::INFINITY; BLOCKS * BLOCKS];
        let mut least = f32::INFINITY;
        for row in tile.first / LANES..tile.last.div_ceil(LANES) {
            let rows = &pixels[(row * LANES).max(tile.first)..((row + 1) * LANES).min(tile.last)];
            for column in 0..tile.width.div_ceil(LANES) {
                let floor = rows
                    .iter()
                    .map(|row| row.floor(column * LANES))
                    .fold(f32x8::splat(f32::INFINITY), f32x8::fast_min);
                let floor = floor.to_array().into_iter().fold(f32::INFINITY, f32::min);
                floors[row * BLOCKS + column] = floor;
                least = least.min(floor);
            }
        }
        self.floor = self.floor.max(least);
        self.floors = Some(floors);
    }
}

/// Visits records eight at a time, the last time maybe fewer.
#[inline]
fn in_eights<'a>(
    mut records: impl Iterator<Item = &'a Record>,
    mut visit: impl FnMut(&[Record]) -> ControlFlow<()>,
) {
    let mut eight = [Record::default(); LANES];
    let mut count = 0;
    let flow = records.try_for_each(|record| {
        eight[count] = *record;
        count = (count + 1) % LANES;
        if count == 0 {
            visit(&eight)
        } else {
            ControlFlow::Continue(())
        }
    });
    if flow.is_continue() && count > 0 {
        let _ = visit(&eight[..count]);
    }
}

/// Which record a key is of.
fn place(key: u64) -> usize {
    key as u32 as usize
}

/// Keys of records, the nearest first; equal spheres stand together, the first of the
/// file before the others.
fn nearest_first(records: &[Record], keys: &mut Vec<u64>) {
    keys.clear();
    // Depths are not negative, so their bits are ordered as they are.
    let key = |(at, record): (u64, &Record)| u64::from(!record.upper.to_bits()) << 32 | at;
    keys.extend((0..).zip(records).map(key));
    keys.sort_unstable();
    // Only those that are equally near can be equal.
    let alike = |a: &u64, b: &u64| a >> 32 == b >> 32;
    for alike in keys.chunk_by_mut(alike) {
        if alike.len() > 1 {
            alike.sort_unstable_by(|&a, &b| records[place(a)].cmp_spheres(&records[place(b)]));
        }
    }
}

/// The blocks of a sphere's box.
#[inline]
fn blocks_of(record: &Record) -> u64 {
    let side = LANES as u8;
    let (left, right) = (record.left / side, record.right / side);
    let (top, bottom) = (record.top / side, record.bottom / side);
    // Rows as bytes of ones, columns as the same bits in each of them.
    let rows = (u64::MAX << (8 * top)) & (u64::MAX >> (56 - 8 * bottom));
    let columns = (0xff_u64 << left) & (0xff >> (7 - right));
    rows & columns.wrapping_mul(0x0101_0101_0101_0101)
}
