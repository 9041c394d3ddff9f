//! Tiles of many spheres, drawn by packets for every pixel. The contested pixels of tiles of few spheres
//! are met here, too.
//!
//! Where boxes are small and overlap little, spheres are met in file order, directly from the
//! bins. Where many lie behind others they are met nearest first, and a sphere that is farther
//! than all leaders in its box is skipped.

use std::ops::ControlFlow;

use wide::f32x8;

use super::{
    bins::{Candidate, EightBoxes, EightRecords, Record, sort_far_to_near},
    bits::set_bits,
    coverage::{Coverage, Tile},
    depths::{DepthRanges, Depths, FloatDepths},
    grid::SIDE,
    packet::{InDoubles, Meetings, PixelRow},
    prepared::Prepared,
    tuning::Bounds,
};
use crate::spheres::LANES;

#[cfg(test)]
mod tests;

/// Spheres are worth sorting if their boxes would cover the tile this many times, and have on
/// average this many pixels.
const DEEP: usize = 8;
const LABORIOUS: usize = 16;

/// One of this many spheres is in the sample of boxes.
const SAMPLE: usize = 16;

/// This many undecided pixels in a tile suggest that some spheres are equal.
const MANY_UNDECIDED: usize = 64;

/// After this many packets, those of a whole tile, and again after each further quarter, the
/// inverse depths behind which spheres are hidden are updated.
const FIRST_FLOORS: u64 = (SIDE * BLOCKS) as u64;

/// Blocks of 8 x 8 pixels along the side of the largest tile. The blocks of a tile are the bits
/// of a `u64`.
const BLOCKS: usize = SIDE / LANES;

/// A pixel of a tile that packets left undecided.
#[derive(Clone, Copy, Debug)]
pub(super) struct UndecidedPixel {
    pub(super) column: u8,
    pub(super) row: u8,
    /// The lower bound of the inverse depth of the visible sphere.
    pub(super) lower: f32,
}

/// A tile, and the scene that it is a part of.
pub(super) struct PreparedTile<'a> {
    pub(super) prepared: &'a Prepared<'a>,
    pub(super) tile: Tile,
}

impl PreparedTile<'_> {
    /// Appends the small spheres that may be nearer than `floor`, in file order.
    fn append_small(&self, floor: f32, records: &mut Vec<Record>) {
        let side = self.prepared.bins.side();
        let (column, row) = (self.tile.column / side, self.tile.row / side);
        let whole = self.tile.first == 0 && self.tile.last == side as usize;
        for run in self.prepared.bins.records(column, row) {
            if whole && floor == f32::NEG_INFINITY {
                records.extend_from_slice(run);
            } else {
                let seen = |record: &&Record| record.upper >= floor && !self.tile.is_beside(record);
                records.extend(run.iter().filter(seen));
            }
        }
    }
}

/// Memory for the spheres of a tile.
#[derive(Debug, Default)]
pub(super) struct Crowd {
    /// The spheres of the tile.
    records: Vec<Record>,
    /// The boxes of the spheres that were met.
    boxes: Vec<EightBoxes>,
    sorted: Vec<Record>,
    places: Vec<u64>,
    hidden: Hidden,
}

/// The inverse depths behind which everything is hidden.
#[derive(Debug, Default)]
struct Hidden {
    /// In the whole tile.
    floor: f32,
    /// In each block, if that has been computed.
    floors: Option<[f32; BLOCKS * BLOCKS]>,
    /// The number of packets so far.
    met: u64,
    next_floors: u64,
    /// Whether the first sphere occurs again. Then others may too, and sorting is the fastest
    /// way to find copies.
    copied: bool,
}

impl Crowd {
    /// Gathers the spheres of a tile, the `large` ones and the small ones. Returns whether they
    /// are worth sorting.
    pub(super) fn gather(&mut self, crowded: &PreparedTile<'_>, large: &mut Vec<Record>) -> bool {
        let floor = refine(crowded, large);
        self.records.clear();
        self.records.extend_from_slice(large);
        crowded.append_small(floor, &mut self.records);
        self.is_deep(large.len())
    }

    /// Meets the spheres of a tile whose pixels hold only the background; if `sorted`, the
    /// nearest first. Returns the number of packets.
    pub(super) fn meet(
        &mut self,
        crowded: &PreparedTile<'_>,
        sorted: bool,
        pixels: &mut [PixelRow],
    ) -> u64 {
        if crowded.prepared.bounds == Bounds::Ignored {
            self.meet_all::<false>(crowded, sorted, pixels);
        } else {
            self.meet_all::<true>(crowded, sorted, pixels);
        }
        self.hidden.met
    }

    /// Meets the spheres of a tile of few spheres in its contested pixels, which hold only the
    /// background. Returns the number of packets.
    pub(super) fn meet_contested(
        &mut self,
        tile: &PreparedTile<'_>,
        coverage: &Coverage,
        pixels: &mut [PixelRow],
    ) -> u64 {
        let sphere = |place: &u64| &coverage.spheres[*place as usize];
        let order = coverage.order.iter().map(|&at| at as u64);
        self.places.clear();
        self.places
            .extend(order.filter(|place| coverage.is_contested(sphere(place))));
        self.records.clear();
        self.records
            .extend(self.places.iter().map(|place| sphere(place).record));
        self.boxes.clear();
        let mut met = 0;
        for (records, places) in self.records.chunks(LANES).zip(self.places.chunks(LANES)) {
            let eight = EightRecords::of(records);
            let depths = tile.depths(&eight);
            let meetings = Meetings::new(&depths, &eight);
            self.boxes.push(eight.boxes);
            for (lane, place) in places.iter().enumerate() {
                let wanted = coverage.contested_by(sphere(place));
                met += tile.meet_masked(&meetings, lane, &records[lane], pixels, &wanted);
            }
        }
        met
    }

    /// Whether copies leave so many pixels undecided that the spheres should be sorted.
    pub(super) fn may_hold_copies(&self, undecided: usize) -> bool {
        self.hidden.copied || undecided > MANY_UNDECIDED
    }

    /// Whether the boxes of a tile overlap so much that sorting is worthwhile, by the large
    /// spheres and a sample of the others.
    fn is_deep(&self, large: usize) -> bool {
        let (large, small) = self.records.split_at(large);
        let sample = small.iter().step_by(SAMPLE);
        let count = sample.len() + large.len();
        let sample = sample.map(Record::area).sum::<usize>();
        let large = large.iter().map(Record::area).sum::<usize>();
        sample + large >= LABORIOUS * count && sample * SAMPLE + large >= DEEP * SIDE * SIDE
    }

    /// The spheres that may be visible in an undecided pixel.
    pub(super) fn candidates(&self, pixel: &UndecidedPixel, candidates: &mut Vec<Candidate>) {
        candidates.clear();
        for (boxes, records) in self.boxes.iter().zip(self.records.chunks(LANES)) {
            for lane in set_bits(u64::from(boxes.holding(pixel.column, pixel.row))) {
                // A shorter chunk is filled with its last record.
                if let Some(record) = records.get(lane)
                    && record.upper >= pixel.lower
                {
                    candidates.push(record.candidate());
                }
            }
        }
    }

    /// Meets all spheres of the tile; if `sorted`, the nearest first and each only in the
    /// blocks where it isn't hidden.
    fn meet_all<const PROVEN: bool>(
        &mut self,
        crowded: &PreparedTile<'_>,
        sorted: bool,
        pixels: &mut [PixelRow],
    ) {
        self.boxes.clear();
        // What one large sphere hides in the whole tile has not been gathered.
        self.hidden = Hidden {
            next_floors: FIRST_FLOORS,
            ..Hidden::default()
        };
        if sorted {
            self.sort();
        }
        let records = std::mem::take(&mut self.records);
        for eight in records.chunks(LANES) {
            let flow = if sorted {
                self.meet_sorted::<PROVEN>(crowded, eight, pixels)
            } else {
                self.meet_unsorted::<PROVEN>(crowded, eight, &records[0], pixels)
            };
            if flow.is_break() {
                break;
            }
        }
        self.records = records;
    }

    /// Sorts the spheres, the nearest first; of equal ones the first of the file stays.
    fn sort(&mut self) {
        let records = &self.records;
        sort_far_to_near(records.len(), |at| &records[at], &mut self.places);
        self.sorted.clear();
        let places = self.places.iter().rev();
        self.sorted
            .extend(places.map(|&place| records[place as usize]));
        std::mem::swap(&mut self.records, &mut self.sorted);
    }

    /// Meets up to eight spheres. Breaks if a copy of the first sphere of the tile is among
    /// them.
    #[inline]
    fn meet_unsorted<const PROVEN: bool>(
        &mut self,
        crowded: &PreparedTile<'_>,
        records: &[Record],
        first: &Record,
        pixels: &mut [PixelRow],
    ) -> ControlFlow<()> {
        let eight = EightRecords::of(records);
        let within = u32::MAX >> (u32::BITS - records.len() as u32);
        let copies = eight.spheres.equal(&first.sphere) & within;
        if PROVEN && copies.count_ones() > u32::from(self.boxes.is_empty()) {
            self.hidden.copied = true;
            return ControlFlow::Break(());
        }
        let depths = crowded.depths(&eight);
        let meetings = Meetings::new(&depths, &eight);
        self.boxes.push(eight.boxes);
        if depths.known & within == within {
            for lane in 0..records.len() {
                self.hidden.met += meetings.whole::<PROVEN>(lane, pixels);
            }
            return ControlFlow::Continue(());
        }
        for (lane, record) in records.iter().enumerate() {
            self.hidden.met += crowded.meet::<PROVEN>(&meetings, lane, record, pixels);
        }
        ControlFlow::Continue(())
    }

    /// Meets up to eight spheres where those before do not hide them. Breaks if all that follow
    /// are hidden.
    #[inline]
    fn meet_sorted<const PROVEN: bool>(
        &mut self,
        crowded: &PreparedTile<'_>,
        records: &[Record],
        pixels: &mut [PixelRow],
    ) -> ControlFlow<()> {
        if records[0].upper < self.hidden.floor {
            return ControlFlow::Break(());
        }
        let eight = EightRecords::of(records);
        let depths = crowded.depths(&eight);
        let meetings = Meetings::new(&depths, &eight);
        self.boxes.push(eight.boxes);
        for (lane, record) in records.iter().enumerate() {
            let visible = self.hidden.visible_blocks(record);
            self.hidden.met += if visible == 0 {
                0
            } else if visible == u64::MAX || record.is_narrow() || depths.known >> lane & 1 == 0 {
                crowded.meet::<PROVEN>(&meetings, lane, record, pixels)
            } else {
                meet_blocks::<PROVEN>(&meetings, lane, pixels, visible)
            };
            if PROVEN && self.hidden.met >= self.hidden.next_floors {
                self.hidden.ask(&crowded.tile, pixels);
            }
        }
        ControlFlow::Continue(())
    }
}

impl PreparedTile<'_> {
    #[inline]
    pub(super) fn depths(&self, eight: &EightRecords) -> FloatDepths {
        let rectangles = self.tile.rectangles(eight);
        Depths::new(&self.prepared.grid, &rectangles, &eight.spheres)
            .to_floats(self.prepared.bounds)
    }

    /// Meets a sphere in its whole box.
    #[inline]
    fn meet<const PROVEN: bool>(
        &self,
        meetings: &Meetings<'_>,
        lane: usize,
        record: &Record,
        pixels: &mut [PixelRow],
    ) -> u64 {
        if meetings.depths.known >> lane & 1 == 0 {
            self.meet_in_doubles(record, pixels, &[u64::MAX; SIDE])
        } else {
            meetings.whole::<PROVEN>(lane, pixels)
        }
    }

    /// Meets a sphere in those pixels of its box that have a bit in `wanted`, and perhaps in
    /// pixels beside them.
    pub(super) fn meet_masked(
        &self,
        meetings: &Meetings<'_>,
        lane: usize,
        record: &Record,
        pixels: &mut [PixelRow],
        wanted: &[u64; SIDE],
    ) -> u64 {
        if meetings.depths.known >> lane & 1 == 0 {
            self.meet_in_doubles(record, pixels, wanted)
        } else if self.prepared.bounds == Bounds::Ignored {
            meetings.masked::<false>(lane, pixels, wanted)
        } else {
            meetings.masked::<true>(lane, pixels, wanted)
        }
    }

    #[cold]
    fn meet_in_doubles(
        &self,
        record: &Record,
        pixels: &mut [PixelRow],
        wanted: &[u64; SIDE],
    ) -> u64 {
        let corner = (self.tile.column, self.tile.row);
        InDoubles::new(&self.prepared.grid, self.prepared.bounds, corner, record)
            .meet(pixels, wanted)
    }
}

/// Gives large spheres the upper bounds of their inverse depths in this tile, and drops those that
/// are hidden in it. Returns the inverse depth behind which one of them hides everything.
fn refine(crowded: &PreparedTile<'_>, large: &mut Vec<Record>) -> f32 {
    let mut floor = f32::NEG_INFINITY;
    if crowded.prepared.bounds != Bounds::Proven {
        return floor;
    }
    let tile = &crowded.tile;
    for chunk in large.chunks_mut(LANES) {
        let eight = EightRecords::of(chunk);
        let rectangles = tile.rectangles(&eight);
        let depths = Depths::new(&crowded.prepared.grid, &rectangles, &eight.spheres);
        let DepthRanges {
            covered,
            lower,
            upper,
        } = depths.ranges();
        for (lane, record) in chunk.iter_mut().enumerate() {
            record.upper = record.upper.min(upper[lane]);
            if covered >> lane & 1 == 1 && tile.is_all_of(record) {
                floor = floor.max(lower[lane]);
            }
        }
    }
    large.retain(|record| record.upper >= floor.max(0.0) && !tile.is_beside(record));
    floor
}

/// Meets a sphere in some blocks of its box, and perhaps in pixels beside them.
fn meet_blocks<const PROVEN: bool>(
    meetings: &Meetings<'_>,
    lane: usize,
    pixels: &mut [PixelRow],
    blocks: u64,
) -> u64 {
    let [left, right, top, bottom] = meetings.packets(lane);
    let one = right - left < LANES;
    let mut met = 0;
    for down in top / LANES..bottom / LANES + 1 {
        let in_row = blocks >> (down * BLOCKS) & 0xff;
        if in_row == 0 {
            continue;
        }
        let (from, to) = if one {
            (left, right + 1)
        } else {
            let to = 64 - in_row.leading_zeros() as usize;
            (in_row.trailing_zeros() as usize * LANES, to * LANES)
        };
        let rows = (top.max(down * LANES), (bottom + 1).min((down + 1) * LANES));
        met += meetings.part::<PROVEN>(lane, pixels, (from, to), rows);
    }
    met
}

impl Hidden {
    /// The blocks in which a sphere may be visible; all if that has not been computed.
    fn visible_blocks(&self, record: &Record) -> u64 {
        let Some(floors) = &self.floors else {
            return u64::MAX;
        };
        let seen = |&block: &usize| record.upper >= floors[block];
        let blocks = set_bits(blocks_of(record)).filter(seen);
        blocks.fold(0, |visible, block| visible | 1 << block)
    }

    /// Computes the inverse depth behind which the leaders of each block hide everything.
    fn ask(&mut self, tile: &Tile, pixels: &[PixelRow]) {
        self.next_floors = self.met + (self.met / 4).max(FIRST_FLOORS);
        let mut floors = [f32::INFINITY; BLOCKS * BLOCKS];
        let mut lowest = f32::INFINITY;
        for row in tile.first / LANES..tile.last.div_ceil(LANES) {
            let rows = &pixels[(row * LANES).max(tile.first)..((row + 1) * LANES).min(tile.last)];
            for column in 0..tile.width.div_ceil(LANES) {
                let floor = rows
                    .iter()
                    .map(|row| row.lower(column * LANES))
                    .fold(f32x8::splat(f32::INFINITY), f32x8::fast_min);
                let floor = floor.to_array().into_iter().fold(f32::INFINITY, f32::min);
                floors[row * BLOCKS + column] = floor;
                lowest = lowest.min(floor);
            }
        }
        self.floor = self.floor.max(lowest);
        self.floors = Some(floors);
    }
}

/// The blocks of a sphere's box.
#[inline]
fn blocks_of(record: &Record) -> u64 {
    let [left, right, top, bottom] = record.sides.map(|side| side / LANES as u8);
    // Rows are bytes of ones; columns are the same bits in each byte.
    let rows = (u64::MAX << (8 * top)) & (u64::MAX >> (56 - 8 * bottom));
    let columns = (0xff_u64 << left) & (0xff >> (7 - right));
    rows & columns.wrapping_mul(0x0101_0101_0101_0101)
}
