//! The packets: eight pixels of a row against one sphere after another, each
//! depth an interval.
//!
//! ```text
//! most  = B/c + bound + sqrt(D/c^2 + d_bound)     NaN: surely missed
//! least = B/c - bound + sqrt(D/c^2 - d_bound)     NaN: not surely hit
//! ```
//!
//! Per pixel it is enough to keep the leader, the sphere of the greatest `least`,
//! and the greatest `most` among its rivals: the leader is seen if its `least` is
//! above that. A comparison with NaN is false, so a miss changes nothing and a
//! doubtful hit never leads; what would overflow has bounds of infinity, so it
//! rivals everything. What is left open goes to [`decide`](super::decide).

#[cfg(test)]
mod tests;

use wide::f32x8;

use super::{
    Bounds, Counts,
    bins::Record,
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

/// A sphere's terms in eight rows: those that differ from row to row, and those
/// that don't.
#[derive(Clone, Copy, Debug)]
struct Terms {
    d0: [f32; BLOCK],
    d1: [f32; BLOCK],
    b0: [f32; BLOCK],
    d2: f32x8,
    d_bound: f32x8,
    b1: f32x8,
    bound: f32x8,
    colour: f32x8,
}

impl Terms {
    /// Of rows `q`, `q + 1`, ... from the middle of the tile.
    #[inline(always)]
    fn new(local: &Local, colours: &[f32; LANES], lane: usize, q: f32) -> Self {
        let q = f32x8::splat(q) + f32x8::new(STEPS);
        let splat = |of: &[f32; LANES]| f32x8::splat(of[lane]);
        let quadratic = splat(&local.d02).mul_add(q, splat(&local.d01));
        Self {
            d0: quadratic.mul_add(q, splat(&local.d00)).to_array(),
            d1: splat(&local.d11).mul_add(q, splat(&local.d10)).to_array(),
            b0: splat(&local.b01).mul_add(q, splat(&local.b00)).to_array(),
            d2: splat(&local.d20),
            d_bound: splat(&local.d_bound),
            b1: splat(&local.b10),
            bound: splat(&local.bound),
            colour: splat(colours),
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

    /// Meets a sphere in the packet at `first`, `p` columns from the middle of the tile.
    #[inline(always)]
    fn meet<const PROVEN: bool>(&mut self, terms: &Terms, row: usize, first: usize, p: f32x8) {
        let splat = |of: &[f32; BLOCK]| f32x8::splat(of[row % BLOCK]);
        let d = terms.d2.mul_add(p, splat(&terms.d1));
        let d = d.mul_add(p, splat(&terms.d0));
        let b = terms.b1.mul_add(p, splat(&terms.b0));
        let leader = packet(&self.least, first);
        let colour = packet(&self.colour, first);
        if PROVEN {
            let most = (b + terms.bound) + (d + terms.d_bound).sqrt();
            let least = (b - terms.bound) + (d - terms.d_bound).sqrt();
            let leader_most = packet(&self.most, first);
            let rival = packet(&self.rival, first);
            let leads = least.simd_gt(leader);
            let loser = leads.select(leader_most, most);
            let rival = loser.simd_gt(rival).select(loser, rival);
            let leader = leads.select(least, leader);
            let leader_most = leads.select(most, leader_most);
            let colour = leads.select(terms.colour, colour);
            packet_mut(&mut self.rival, first).copy_from_slice(rival.as_array());
            packet_mut(&mut self.least, first).copy_from_slice(leader.as_array());
            packet_mut(&mut self.most, first).copy_from_slice(leader_most.as_array());
            packet_mut(&mut self.colour, first).copy_from_slice(colour.as_array());
        } else {
            let depth = b + d.sqrt();
            let leads = depth.simd_gt(leader);
            let leader = leads.select(depth, leader);
            let colour = leads.select(terms.colour, colour);
            packet_mut(&mut self.least, first).copy_from_slice(leader.as_array());
            packet_mut(&mut self.colour, first).copy_from_slice(colour.as_array());
        }
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
fn rgb(colours: f32x8) -> [u8; LANES * BYTES_PER_PIXEL] {
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

/// Blocks of a tile that are contested, and the spheres that may be seen in them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contest<'a> {
    pub(super) scene: &'a Scene,
    pub(super) grid: &'a Grid,
    pub(super) bounds: Bounds,
    /// See [`Around::scale`].
    pub(super) scale: f64,
    pub(super) tile: Tile,
    pub(super) blocks: u64,
    /// Small spheres, and then large ones.
    pub(super) records: &'a [Record],
    /// How many are small.
    pub(super) small: usize,
}

/// Room for the packets of one tile at a time.
#[derive(Debug, Default)]
pub(super) struct Depths {
    rows: Vec<Row>,
    /// What was met in the tile, by place among the records.
    candidates: Vec<u32>,
    /// First and last column and row of each candidate.
    boxes: Vec<[u8; 4]>,
    order: Vec<u64>,
    ordering: Order,
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
        // Where little lies behind other spheres, ordering them costs more than it saves,
        // but for equal ones, which only an order tells apart quickly.
        let box_of = |record: &Record| {
            let (across, down) = (record.right - record.left, record.bottom - record.top);
            (u64::from(across) + 1) * (u64::from(down) + 1)
        };
        let overdraw = contest.records.iter().map(box_of).sum::<u64>();
        let shallow = overdraw < SHALLOW * (SIDE * SIDE) as u64;
        match contest.bounds {
            Bounds::Ignored => self.meet_all::<false>(contest, !shallow, counts),
            _ => {
                self.meet_all::<true>(contest, !shallow, counts);
                if shallow && self.count_open(contest) > MANY_OPEN {
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
                match <&mut [u8; LANES * BYTES_PER_PIXEL]>::try_from(&mut *line) {
                    Ok(eight) => *eight = rgb,
                    Err(_) => line.copy_from_slice(&rgb[..lanes * BYTES_PER_PIXEL]),
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
                let holding =
                    holding.map(|(_, &place)| contest.records[place as usize].candidate());
                near.extend(holding);
            }
        }
        let trusted = contest.bounds != Bounds::Refused;
        decide(contest.grid.camera(), at, near.iter().copied(), trusted)
    }

    /// All candidates of the tile, the nearest first, each in the blocks where it
    /// isn't hidden.
    fn meet_all<const PROVEN: bool>(
        &mut self,
        contest: &Contest<'_>,
        sorted: bool,
        counts: &mut Counts,
    ) {
        let &Contest {
            tile,
            blocks,
            records,
            ..
        } = contest;
        let half = tile.side / 2;
        let around = Around {
            column: i64::from(tile.column) + i64::from(half),
            row: i64::from(tile.row) + i64::from(half),
            half: f64::from(half),
            scale: contest.scale,
        };
        self.rows.resize(SIDE, EMPTY);
        let background = bits(contest.scene.background);
        for block in set_bits(blocks) {
            let (first, rows) = columns_and_rows(block);
            for row in &mut self.rows[rows] {
                row.clear(first, background);
            }
        }
        self.candidates.clear();
        self.boxes.clear();
        let mut order = std::mem::take(&mut self.order);
        touching(records, blocks, &mut order);
        if sorted {
            nearest_first(&mut order, &mut self.ordering);
        }

        let mut floors = [f32::NEG_INFINITY; BLOCKS * BLOCKS];
        let mut floor = f32::NEG_INFINITY;
        let mut floors_known = false;
        let (mut met, mut next_floors) = (0, FIRST_FLOORS);
        let mut equal: Option<[f32; 4]> = None;
        for eight in order.chunks(LANES) {
            let place = |lane: usize| eight[lane.min(eight.len() - 1)] as u32 as usize;
            let of: [&Record; LANES] = std::array::from_fn(|lane| &records[place(lane)]);
            if sorted && f64::from(of[0].most) * around.scale < f64::from(floor) {
                break;
            }
            let lanes = Lanes::of(of.into_iter().map(|record| record.sphere));
            let most = of.map(|record| record.most);
            let colours = of.map(|record| bits(record.colour));
            let local = if (0..LANES).any(|lane| place(lane) >= contest.small) {
                Local::new::<true>(contest.grid, &around, &lanes, most, contest.bounds)
            } else {
                Local::new::<false>(contest.grid, &around, &lanes, most, contest.bounds)
            };
            for (lane, record) in of.into_iter().enumerate().take(eight.len()) {
                // Of equal spheres the first of the file is seen; they sort together.
                if local.most[lane] < floor.max(0.0) || equal == Some(record.sphere) {
                    continue;
                }
                equal = Some(record.sphere);
                floor = floor.max(local.least[lane]);
                let sides = [record.left, record.right, record.top, record.bottom];
                self.candidates.push(place(lane) as u32);
                self.boxes.push(sides);
                let mut open = blocks & blocks_of_box(record);
                if floors_known {
                    let seen = |&block: &usize| local.most[lane] >= floors[block];
                    open = set_bits(open)
                        .filter(seen)
                        .fold(0, |open, block| open | 1 << block);
                }
                let terms = |q| Terms::new(&local, &colours, lane, q);
                met += self.meet::<PROVEN>(terms, sides, half as f32, open);
                if PROVEN && met >= next_floors {
                    next_floors = met + (met / 4).max(FIRST_FLOORS);
                    floors_known = true;
                    for block in set_bits(blocks) {
                        floors[block] = self.floor(block);
                    }
                    let least = set_bits(blocks).map(|block| floors[block]);
                    floor = floor.max(least.fold(f32::INFINITY, f32::min));
                }
            }
        }
        counts.tests += met;
        self.order = order;
    }

    /// Meets a sphere in its box, in some blocks and perhaps beside them; returns in
    /// how many packets.
    #[inline]
    fn meet<const PROVEN: bool>(
        &mut self,
        terms: impl Fn(f32) -> Terms,
        [left, right, top, bottom]: [u8; 4],
        half: f32,
        blocks: u64,
    ) -> u64 {
        let [left, right, top, bottom] = [left, right, top, bottom].map(usize::from);
        if blocks == 0 {
            return 0;
        }
        if right - left < LANES && bottom - top < BLOCK {
            // One packet a row, wherever it begins: what it meets besides is a miss.
            let terms = terms(top as f32 - half);
            let p = f32x8::new(STEPS) + f32x8::splat(left as f32 - half);
            for (row, packets) in self.rows[top..bottom + 1].iter_mut().enumerate() {
                packets.meet::<PROVEN>(&terms, row, left, p);
            }
            return (bottom + 1 - top) as u64;
        }
        let mut met = 0;
        for down in top / BLOCK..bottom / BLOCK + 1 {
            let in_row = blocks >> (down * BLOCKS) & 0xff;
            if in_row == 0 {
                continue;
            }
            let left = left.max(in_row.trailing_zeros() as usize * BLOCK);
            let right = right.min((63 - in_row.leading_zeros() as usize) * BLOCK + BLOCK - 1);
            let origin = down * BLOCK;
            let terms = terms(origin as f32 - half);
            let rows = top.max(origin)..(bottom + 1).min(origin + BLOCK);
            for first in (left..right + 1).step_by(LANES) {
                let p = f32x8::new(STEPS) + f32x8::splat(first as f32 - half);
                for (row, packets) in rows.clone().zip(&mut self.rows[rows.clone()]) {
                    packets.meet::<PROVEN>(&terms, row, first, p);
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

/// The first column of a block, and its rows.
fn columns_and_rows(block: usize) -> (usize, std::ops::Range<usize>) {
    let row = block / BLOCKS * BLOCK;
    (block % BLOCKS * BLOCK, row..row + BLOCK)
}

/// Boxes that would cover a tile so many times are worth ordering.
const SHALLOW: u64 = 16;

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

/// The places of `records` that touch `blocks`, as the low halves of keys that are
/// the less the nearer a sphere is, and of those that are equally near by file.
fn touching(records: &[Record], blocks: u64, keys: &mut Vec<u64>) {
    keys.clear();
    let places = (0_u64..).zip(records);
    let touching =
        places.filter(|(_, record)| blocks == u64::MAX || blocks_of_box(record) & blocks != 0);
    // Depths are not negative, so their bits are ordered as they are.
    keys.extend(touching.map(|(at, record)| u64::from(!record.most.to_bits()) << 32 | at));
}

/// Sorts keys.
fn nearest_first(order: &mut Vec<u64>, scratch: &mut Order) {
    if order.is_sorted() {
        return;
    }
    let Order { keys, starts } = scratch;
    std::mem::swap(order, keys);
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
    order.resize(keys.len(), 0);
    for &key in &*keys {
        let start = &mut starts[bucket(key)];
        order[*start as usize] = key;
        *start += 1;
    }
    let mut first = 0;
    for &last in &*starts {
        if last > first + 1 {
            order[first as usize..last as usize].sort_unstable();
        }
        first = last;
    }
}

/// Room for ordering.
#[derive(Debug, Default)]
struct Order {
    keys: Vec<u64>,
    starts: Vec<u32>,
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
