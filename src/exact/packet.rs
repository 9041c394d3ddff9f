//! The packets: eight pixels of a row against one sphere after another, each
//! depth an interval.
//!
//! ```text
//! most  = b + sqrt d                          NaN: surely missed
//! least = b - spread + sqrt(d - d_spread)     NaN: not surely hit
//! ```
//!
//! Per pixel it is enough to keep the leader, the sphere of the greatest `least`,
//! and the greatest `most` among its rivals: the leader is seen if its `least` is
//! above that. A comparison with NaN is false, so a miss changes nothing and a
//! doubtful hit never leads; what would overflow has bounds of infinity, so it
//! rivals everything. What is left open goes to [`decide`](super::decide).

#[cfg(test)]
mod tests;

use std::ops::ControlFlow;

use wide::{f32x8, f64x8};

use super::{
    Bounds, Counts,
    bins::{Bins, Record},
    conic::{Around, Grid, Lanes, Local},
    decide::{Rung, decide},
    set_bits,
};
use crate::{
    camera::BYTES_PER_PIXEL,
    methods::{NONE, Seen},
    scene::Scene,
    spheres::{LANES, Rgb},
};

/// Rows and columns of a block.
pub(super) const BLOCK: usize = LANES;

/// Blocks along the side of the largest tile: a tile's blocks are the bits of a `u64`.
pub(super) const BLOCKS: usize = 8;

/// The bit of a block in a tile.
pub(super) fn block_bit(column: usize, row: usize) -> u64 {
    1 << (row * BLOCKS + column)
}

/// The blocks of a tile that is `width` by `height` pixels.
pub(super) fn blocks_of(width: usize, height: usize) -> u64 {
    let row = (1_u64 << width.div_ceil(BLOCK)) - 1;
    (0..height.div_ceil(BLOCK)).fold(0, |blocks, at| blocks | row << (at * BLOCKS))
}

/// Pixels of a row of the largest tile.
const SIDE: usize = BLOCK * BLOCKS;

/// What is known of the pixels of a row. A packet may begin anywhere in it, so
/// there is room for one that begins at the last pixel.
#[derive(Clone, Debug)]
struct Row {
    least: [f32; SIDE + LANES],
    most: [f32; SIDE + LANES],
    /// The greatest `most` of all but the leader.
    rival: [f32; SIDE + LANES],
    /// The leader's colour, in the bits.
    colour: [f32; SIDE + LANES],
}

const EMPTY: Row = Row {
    least: [f32::NEG_INFINITY; SIDE + LANES],
    most: [f32::NEG_INFINITY; SIDE + LANES],
    rival: [f32::NEG_INFINITY; SIDE + LANES],
    colour: [0.0; SIDE + LANES],
};

/// The packet that begins at a pixel of a row.
#[inline(always)]
fn packet(of: &[f32; SIDE + LANES], first: usize) -> f32x8 {
    let first = first % SIDE;
    f32x8::new(std::array::from_fn(|lane| of[first + lane]))
}

#[inline(always)]
fn packet_mut(of: &mut [f32; SIDE + LANES], first: usize) -> &mut [f32] {
    let first = first % SIDE;
    &mut of[first..first + LANES]
}

/// A sphere's terms in the columns of a packet; what is left is a matter of the row,
///
/// ```text
/// d = (d2 q + d1) q + d0     b = b1 q + b0
/// ```
#[derive(Clone, Copy, Debug)]
struct Terms {
    d0: f32x8,
    d1: f32x8,
    d2: f32x8,
    b0: f32x8,
    b1: f32x8,
    /// If `CLEAR`, [`Local::clear`] and [`Local::clear_spread`].
    d_spread: f32x8,
    spread: f32x8,
    colour: f32x8,
}

impl Terms {
    /// Of columns `p` from where `local` is.
    #[inline(always)]
    fn new<const CLEAR: bool>(local: &Local, colour: f32, lane: usize, p: f32x8) -> Self {
        let splat = |of: &[f32; LANES]| f32x8::splat(of[lane]);
        let (d_spread, spread) = if CLEAR {
            (&local.clear, &local.clear_spread)
        } else {
            (&local.d_spread, &local.spread)
        };
        let quadratic = splat(&local.d20).mul_add(p, splat(&local.d10));
        Self {
            d0: quadratic.mul_add(p, splat(&local.d00)),
            d1: splat(&local.d11).mul_add(p, splat(&local.d01)),
            d2: splat(&local.d02),
            b0: splat(&local.b10).mul_add(p, splat(&local.b00)),
            b1: splat(&local.b01),
            d_spread: splat(d_spread),
            spread: splat(spread),
            colour: f32x8::splat(colour),
        }
    }
}

impl Row {
    /// Nothing is known of the pixels of a block.
    fn clear(&mut self, first: usize, background: f32) {
        packet_mut(&mut self.least, first).fill(f32::NEG_INFINITY);
        packet_mut(&mut self.most, first).fill(f32::NEG_INFINITY);
        packet_mut(&mut self.rival, first).fill(f32::NEG_INFINITY);
        packet_mut(&mut self.colour, first).fill(background);
    }

    /// Meets a sphere in the packet at `first`, `q` rows from where its terms are.
    #[inline(always)]
    fn meet<const PROVEN: bool, const CLEAR: bool>(
        &mut self,
        terms: &Terms,
        first: usize,
        q: f32x8,
    ) {
        let d = terms.d2.mul_add(q, terms.d1).mul_add(q, terms.d0);
        let b = terms.b1.mul_add(q, terms.b0);
        let most = b + d.sqrt();
        let leader = packet(&self.least, first);
        let colour = packet(&self.colour, first);
        let (least, leads) = if !PROVEN {
            (most, most.simd_gt(leader))
        } else if CLEAR {
            let least = most - terms.spread;
            (least, least.simd_gt(leader) & d.simd_gt(terms.d_spread))
        } else {
            let least = (b - terms.spread) + (d - terms.d_spread).sqrt();
            (least, least.simd_gt(leader))
        };
        if PROVEN {
            let leader_most = packet(&self.most, first);
            let rival = packet(&self.rival, first);
            let loser = leads.select(leader_most, most);
            let rival = loser.simd_gt(rival).select(loser, rival);
            let leader_most = leads.select(most, leader_most);
            packet_mut(&mut self.rival, first).copy_from_slice(rival.as_array());
            packet_mut(&mut self.most, first).copy_from_slice(leader_most.as_array());
        }
        let leader = leads.select(least, leader);
        let colour = leads.select(terms.colour, colour);
        packet_mut(&mut self.least, first).copy_from_slice(leader.as_array());
        packet_mut(&mut self.colour, first).copy_from_slice(colour.as_array());
    }

    /// The lanes of a packet that no interval settles.
    #[inline]
    fn open(&self, first: usize) -> u32 {
        let rival = packet(&self.rival, first);
        let rivalled = rival.simd_gt(f32x8::splat(f32::NEG_INFINITY));
        let least = packet(&self.least, first);
        !least.simd_gt(rival).to_bitmask() & rivalled.to_bitmask()
    }
}

fn bits(colour: Rgb) -> f32 {
    let [red, green, blue] = colour;
    f32::from_bits(u32::from_le_bytes([red, green, blue, 0]))
}

/// The bytes of eight pixels.
#[inline]
fn rgb(colours: f32x8) -> [[u8; 8]; BYTES_PER_PIXEL] {
    let colours: [u32; LANES] = bytemuck::cast(colours);
    let [a, b, c, d, e, f, g, h] = colours.map(u64::from);
    bytemuck::cast([
        (a | b << 24 | c << 48).to_le(),
        (c >> 16 | d << 8 | e << 32 | f << 56).to_le(),
        (f >> 8 | g << 16 | h << 40).to_le(),
    ])
}

/// A tile to be drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    /// Its first column and row in the picture.
    pub(super) column: u32,
    pub(super) row: u32,
    /// Pixels across and down, up to `side` each: cut by the picture's edges.
    pub(super) width: usize,
    pub(super) height: usize,
    /// Its rows that are drawn now.
    pub(super) first: usize,
    pub(super) last: usize,
    pub(super) side: u32,
}

impl Tile {
    /// Its column and row among the tiles.
    fn place(&self) -> (u32, u32) {
        (self.column / self.side, self.row / self.side)
    }

    /// Whether a box is all of it.
    fn is_all_of(&self, record: &Record) -> bool {
        record.left == 0
            && usize::from(record.right) + 1 >= self.width
            && usize::from(record.top) <= self.first
            && usize::from(record.bottom) + 1 >= self.last
    }
}

/// Blocks of a tile that are contested, and the spheres that may be seen in them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contest<'a> {
    pub(super) scene: &'a Scene,
    pub(super) grid: &'a Grid,
    pub(super) bins: &'a Bins,
    pub(super) bounds: Bounds,
    /// See [`Around::scale`].
    pub(super) scale: f64,
    pub(super) tile: Tile,
    pub(super) blocks: u64,
    /// Small spheres with less inverse depth are hidden.
    pub(super) floor: f32,
    pub(super) large: &'a [Record],
}

impl<'a> Contest<'a> {
    /// The small spheres, in file order.
    fn small(&self) -> impl Iterator<Item = &'a Record> + Clone {
        let (column, row) = self.tile.place();
        self.bins.nearer(column, row, self.floor)
    }

    fn touches(&self, record: &Record) -> bool {
        self.blocks == u64::MAX || blocks_of_box(record) & self.blocks != 0
    }
}

/// Room for the packets of one tile at a time.
#[derive(Debug, Default)]
pub(super) struct Depths {
    rows: Vec<Row>,
    /// What was met in the tile, all of it in one place.
    candidates: Vec<Record>,
    /// First and last column and row of each candidate.
    boxes: Vec<[u8; 4]>,
    sorted: Vec<Record>,
    order: Order,
}

/// What is known to be hidden while the spheres of a tile are met.
#[derive(Debug)]
struct Hidden {
    /// All over the tile.
    floor: f32,
    /// In each block, if that was asked.
    floors: Option<[f32; BLOCKS * BLOCKS]>,
    met: u64,
    next_floors: u64,
    equal: Option<[f32; 4]>,
}

impl Depths {
    /// Settles a contest. `bytes` are the rows `tile.first..tile.last`, of `row_bytes`
    /// each.
    pub(super) fn settle(
        &mut self,
        contest: &Contest<'_>,
        bytes: &mut [u8],
        row_bytes: usize,
        counts: &mut Counts,
    ) {
        // Large spheres are in order as they are. Small ones are ordered if much lies behind
        // others and each of them is some work; and equal ones are, since only an order tells
        // them apart quickly.
        let box_of = |record: &Record| {
            let (across, down) = (record.right - record.left, record.bottom - record.top);
            (u64::from(across) + 1) * (u64::from(down) + 1)
        };
        let (column, row) = contest.tile.place();
        let runs = contest.bins.records(column, row);
        let sample = runs.flat_map(|run| run.iter().step_by(SAMPLE));
        let sample = sample.filter(|record| record.most >= contest.floor);
        let sum = |(count, area), record| (count + 1, area + box_of(record));
        let (count, area) = sample.fold((0, 0), sum);
        let overdraw = area * SAMPLE as u64 + contest.large.iter().map(box_of).sum::<u64>();
        let small = count > 0;
        let deep = small && area >= LABORIOUS * count && overdraw >= DEEP * (SIDE * SIDE) as u64;
        match contest.bounds {
            Bounds::Ignored => self.meet_all::<false>(contest, deep, counts),
            _ => {
                self.meet_all::<true>(contest, deep, counts);
                if !deep && small && self.count_open(contest) > MANY_OPEN {
                    self.meet_all::<true>(contest, true, counts);
                }
            }
        }
        let tile = &contest.tile;
        for row in tile.first..tile.last {
            let in_row = contest.blocks >> (row / BLOCK * BLOCKS) & 0xff;
            let line = &mut bytes[(row - tile.first) * row_bytes..][..row_bytes];
            for block in set_bits(in_row) {
                let first = block * BLOCK;
                let packets = &self.rows[row];
                let lanes = BLOCK.min(tile.width - first);
                let at = (tile.column as usize + first) * BYTES_PER_PIXEL;
                let line = &mut line[at..at + lanes * BYTES_PER_PIXEL];
                let rgb = rgb(packet(&packets.colour, first));
                match line.as_chunks_mut().0 {
                    [a, b, c] => [*a, *b, *c] = rgb,
                    _ => line.copy_from_slice(&rgb.as_flattened()[..lanes * BYTES_PER_PIXEL]),
                }
                counts.packets += lanes as u64;
                if contest.bounds == Bounds::Ignored {
                    continue;
                }
                let open = packets.open(first) & ((1 << lanes) - 1);
                for lane in set_bits(u64::from(open)) {
                    let (seen, rung) = self.decide(contest, first + lane, row);
                    counts.packets -= 1;
                    counts.settled_by(rung);
                    let colour = colour_of(contest.scene, seen);
                    line[lane * BYTES_PER_PIXEL..][..BYTES_PER_PIXEL].copy_from_slice(&colour);
                }
            }
        }
    }

    fn count_open(&self, contest: &Contest<'_>) -> u32 {
        let open = set_bits(contest.blocks).map(|block| {
            let (first, rows) = columns_and_rows(block);
            let rows = self.rows[rows].iter();
            rows.map(|row| row.open(first).count_ones()).sum::<u32>()
        });
        open.sum()
    }

    fn decide(&self, contest: &Contest<'_>, column: usize, row: usize) -> (Seen, Rung) {
        let tile = &contest.tile;
        let at = (tile.column + column as u32, tile.row + row as u32);
        let (column, row) = (column as u8, row as u8);
        let holds = |&[left, right, top, bottom]: &[u8; 4]| {
            (left <= column) & (column <= right) & (top <= row) & (row <= bottom)
        };
        let boxes = self.boxes.chunks(4 * LANES);
        let mut near = Vec::new();
        for (boxes, candidates) in boxes.zip(self.candidates.chunks(4 * LANES)) {
            // Most boxes don't hold the pixel: many are asked at a time.
            if boxes.iter().fold(false, |any, sides| any | holds(sides)) {
                let holding = boxes.iter().zip(candidates);
                let holding = holding.filter(|(sides, _)| holds(sides));
                near.extend(holding.map(|(_, record)| record.candidate()));
            }
        }
        let trusted = contest.bounds != Bounds::Refused;
        decide(contest.grid.camera(), at, near.iter().copied(), trusted)
    }

    /// All candidates of the tile, if `sorted` the nearest first and each only in the
    /// blocks where it isn't hidden.
    fn meet_all<const PROVEN: bool>(
        &mut self,
        contest: &Contest<'_>,
        sorted: bool,
        counts: &mut Counts,
    ) {
        self.rows.resize(SIDE, EMPTY);
        let background = bits(contest.scene.background);
        for block in set_bits(contest.blocks) {
            let (first, rows) = columns_and_rows(block);
            for row in &mut self.rows[rows] {
                row.clear(first, background);
            }
        }
        self.candidates.clear();
        self.boxes.clear();
        let mut hidden = Hidden {
            floor: f32::NEG_INFINITY,
            floors: None,
            met: 0,
            next_floors: FIRST_FLOORS,
            equal: None,
        };
        if sorted {
            let mut records = std::mem::take(&mut self.sorted);
            let mut order = std::mem::take(&mut self.order);
            records.clear();
            records.extend(contest.small().chain(contest.large));
            records.retain(|record| contest.touches(record));
            let nearest_first = order.nearest_first(&records).iter();
            let nearest_first = nearest_first.map(|&key| &records[place(key)]);
            in_eights(nearest_first, |eight| {
                self.meet_eight::<PROVEN, true>(contest, eight, &mut hidden)
            });
            self.sorted = records;
            self.order = order;
        } else {
            let touching = |record: &&Record| contest.touches(record);
            in_eights(contest.large.iter().filter(touching), |eight| {
                self.meet_eight::<PROVEN, true>(contest, eight, &mut hidden)
            });
            in_eights(contest.small().filter(touching), |eight| {
                self.meet_eight::<PROVEN, false>(contest, eight, &mut hidden)
            });
        }
        counts.tests += hidden.met;
    }

    /// Meets up to eight spheres; if they are `SORTED`, what is hidden by those before
    /// is left out, and it is asked what they hide themselves. Breaks if all that
    /// follow are hidden.
    #[inline]
    fn meet_eight<const PROVEN: bool, const SORTED: bool>(
        &mut self,
        contest: &Contest<'_>,
        records: &[Record],
        hidden: &mut Hidden,
    ) -> ControlFlow<()> {
        if SORTED && f64::from(records[0].most) * contest.scale < f64::from(hidden.floor) {
            return ControlFlow::Break(());
        }
        let eight: [&Record; LANES] =
            std::array::from_fn(|lane| &records[lane.min(records.len() - 1)]);

        let tile = &contest.tile;
        let of = |side: fn(&Record) -> u8| f64x8::new(eight.map(|record| f64::from(side(record))));
        let half = |first: f64x8, last: f64x8, more: f64| {
            ((last - first + f64x8::splat(more)) * f64x8::splat(0.5)).floor()
        };
        let (left, top) = (of(|record| record.left), of(|record| record.top));
        // A packet may reach seven columns beyond the box; and one row at least, so that
        // every coefficient is bounded.
        let across = half(left, of(|record| record.right), LANES as f64);
        let down = half(top, of(|record| record.bottom), 2.0);
        let around = Around {
            columns: left + across + f64x8::splat(f64::from(tile.column)),
            rows: top + down + f64x8::splat(f64::from(tile.row)),
            across,
            down,
            scale: contest.scale,
        };
        let lanes = Lanes::of(eight.iter().map(|record| record.sphere));
        let most = eight.map(|record| record.most);
        let local = Local::new::<SORTED>(contest.grid, &around, &lanes, most, contest.bounds);
        if !SORTED {
            self.candidates.extend_from_slice(records);
            self.boxes.extend(records.iter().map(Record::sides));
        }
        for (lane, record) in records.iter().enumerate() {
            if local.most[lane] < hidden.floor.max(0.0) {
                continue;
            }
            let colour = bits(record.colour);
            let mut open = contest.blocks;
            if SORTED {
                // Of equal spheres the first of the file is seen; they sort together.
                if hidden.equal == Some(record.sphere) {
                    continue;
                }
                hidden.equal = Some(record.sphere);
                if tile.is_all_of(record) {
                    hidden.floor = hidden.floor.max(local.least[lane]);
                }
                self.candidates.push(*record);
                self.boxes.push(record.sides());
                if let Some(floors) = &hidden.floors {
                    let seen = |&block: &usize| local.most[lane] >= floors[block];
                    open = set_bits(open & blocks_of_box(record))
                        .filter(seen)
                        .fold(0, |open, block| open | 1 << block);
                }
            }
            hidden.met += if open == 0 {
                0
            } else if record.is_narrow() {
                self.meet_narrow::<PROVEN>(&local, lane, colour, record)
            } else {
                let blocks = open & blocks_of_box(record);
                self.meet_wide::<PROVEN>(&local, lane, colour, record, blocks)
            };
            if PROVEN && SORTED && hidden.met >= hidden.next_floors {
                hidden.next_floors = hidden.met + (hidden.met / 4).max(FIRST_FLOORS);
                let mut floors = [f32::NEG_INFINITY; BLOCKS * BLOCKS];
                let mut least = f32::INFINITY;
                for block in set_bits(contest.blocks) {
                    floors[block] = self.floor(block);
                    least = least.min(floors[block]);
                }
                hidden.floor = hidden.floor.max(least);
                hidden.floors = Some(floors);
            }
        }
        ControlFlow::Continue(())
    }

    /// Meets a sphere in one packet a row, wherever its box begins: what is met beside
    /// it is a miss. Returns in how many packets.
    #[inline(always)]
    fn meet_narrow<const PROVEN: bool>(
        &mut self,
        local: &Local,
        lane: usize,
        colour: f32,
        record: &Record,
    ) -> u64 {
        let [left, _, top, bottom] = record.sides().map(usize::from);
        let p = f32x8::new(STEPS) + f32x8::splat(local.p[lane]);
        let terms = Terms::new::<true>(local, colour, lane, p);
        let mut q = f32x8::splat(local.q[lane]);
        for packets in &mut self.rows[top..bottom + 1] {
            packets.meet::<PROVEN, true>(&terms, left, q);
            q += f32x8::splat(1.0);
        }
        (bottom + 1 - top) as u64
    }

    /// Meets a sphere in some blocks of its box, and perhaps beside them.
    fn meet_wide<const PROVEN: bool>(
        &mut self,
        local: &Local,
        lane: usize,
        colour: f32,
        record: &Record,
        blocks: u64,
    ) -> u64 {
        let [left, right, top, bottom] = record.sides().map(usize::from);
        let mut met = 0;
        for down in top / BLOCK..bottom / BLOCK + 1 {
            let in_row = blocks >> (down * BLOCKS) & 0xff;
            if in_row == 0 {
                continue;
            }
            let from = left.max(in_row.trailing_zeros() as usize * BLOCK);
            let to = right.min((63 - in_row.leading_zeros() as usize) * BLOCK + BLOCK - 1);
            let origin = down * BLOCK;
            let rows = top.max(origin)..(bottom + 1).min(origin + BLOCK);
            for first in (from..to + 1).step_by(LANES) {
                let p = f32x8::splat((first - left) as f32 + local.p[lane]);
                let terms = Terms::new::<false>(local, colour, lane, f32x8::new(STEPS) + p);
                let mut q = f32x8::splat((rows.start - top) as f32 + local.q[lane]);
                for packets in &mut self.rows[rows.clone()] {
                    packets.meet::<PROVEN, false>(&terms, first, q);
                    q += f32x8::splat(1.0);
                }
                met += rows.len() as u64;
            }
        }
        met
    }

    /// The least depth of any leader of a block.
    fn floor(&self, block: usize) -> f32 {
        let (first, rows) = columns_and_rows(block);
        let least = self.rows[rows].iter().map(|row| packet(&row.least, first));
        let least = least.fold(f32x8::splat(f32::INFINITY), f32x8::fast_min);
        least.to_array().into_iter().fold(f32::INFINITY, f32::min)
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

/// The first column of a block, and its rows.
fn columns_and_rows(block: usize) -> (usize, std::ops::Range<usize>) {
    let row = block / BLOCKS * BLOCK;
    (block % BLOCKS * BLOCK, row..row + BLOCK)
}

/// Boxes that would cover a tile so many times are worth ordering, if on the average
/// they are of so many pixels.
const DEEP: u64 = 8;
const LABORIOUS: u64 = 16;

/// Of so many small spheres one is asked for its box.
const SAMPLE: usize = 16;

/// So many open pixels in a tile are no accident: some spheres may be equal.
const MANY_OPEN: u32 = 64;

/// After so many packets, those of a whole tile, and again after each quarter more, it
/// is asked what the spheres before hide.
const FIRST_FLOORS: u64 = (SIDE * BLOCKS) as u64;

const STEPS: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

pub(super) fn colour_of(scene: &Scene, seen: Seen) -> Rgb {
    match seen {
        NONE => scene.background,
        _ => scene.spheres.colour()[seen as usize],
    }
}

/// Room for ordering.
#[derive(Debug, Default)]
struct Order {
    keys: Vec<u64>,
    starts: Vec<u32>,
    sorted: Vec<u64>,
}

/// Which record a key is of.
fn place(key: u64) -> usize {
    key as u32 as usize
}

impl Order {
    /// Keys of records, the nearest first, and of those that are equally near in the
    /// order they have.
    fn nearest_first(&mut self, records: &[Record]) -> &[u64] {
        let Self {
            keys,
            starts,
            sorted,
        } = self;
        keys.clear();
        // Depths are not negative, so their bits are ordered as they are.
        let key = |(at, record): (u64, &Record)| u64::from(!record.most.to_bits()) << 32 | at;
        keys.extend((0..).zip(records).map(key));
        if keys.is_sorted() {
            return keys;
        }
        let ends = |(low, high): (u64, u64), &key: &u64| (low.min(key), high.max(key));
        let (low, high) = keys.iter().fold((u64::MAX, 0), ends);
        // Into as many buckets of like depth as there are keys, and each by itself.
        let bits = keys.len().ilog2().clamp(4, 12);
        let shift = (64 - (high - low).leading_zeros()).saturating_sub(bits);
        let bucket = |key: u64| ((key - low) >> shift) as usize;
        starts.clear();
        starts.resize((1 << bits) + 1, 0);
        for &key in &*keys {
            starts[bucket(key)] += 1;
        }
        let mut total = 0;
        for start in &mut *starts {
            total += std::mem::replace(start, total);
        }
        sorted.resize(keys.len(), 0);
        for &key in &*keys {
            let start = &mut starts[bucket(key)];
            sorted[*start as usize] = key;
            *start += 1;
        }
        let mut first = 0;
        for &last in &*starts {
            if last > first + 1 {
                sorted[first as usize..last as usize].sort_unstable();
            }
            first = last;
        }
        sorted
    }
}

/// The blocks of a sphere's box.
#[inline]
pub(super) fn blocks_of_box(record: &Record) -> u64 {
    let side = BLOCK as u8;
    let (left, right) = (record.left / side, record.right / side);
    let (top, bottom) = (record.top / side, record.bottom / side);
    // Rows as bytes of ones, columns as the same bits in each of them.
    let rows = (u64::MAX << (8 * top)) & (u64::MAX >> (56 - 8 * bottom));
    let columns = (0xff_u64 << left) & (0xff >> (7 - right));
    rows & columns.wrapping_mul(0x0101_0101_0101_0101)
}
