//! From boxes to candidates: the spheres that each tile must test.
//!
//! Small spheres are sorted by tile, in two passes over each run of spheres: count, then
//! scatter. Runs are processed in parallel, each with a table of its own, so that no two
//! threads write to the same place. A sphere whose box meets more than two columns or two rows
//! of tiles is *large*: it has one record for the whole picture, and the large ones are sorted
//! nearest first.

use std::{cmp::Ordering, ops::Range};

use bytemuck::{Pod, Zeroable};
use memmap2::MmapMut;
use rayon::prelude::*;
use wide::{f32x8, u8x32, u32x8};

use super::{
    bits::{lanes_of, set_bits},
    boxes::{Boxes, float_unit},
    grid::{EightSpheres, Grid, SIDE},
    pool::Pool,
    tuning::Bounds,
};
use crate::{
    methods::Seen,
    pages::{HUGE_PAGE, ask_for_huge},
    spheres::{LANES, Rgb, Spheres},
};

#[cfg(test)]
mod tests;

/// A sphere that may be visible: its index in the file, its centre and radius.
pub(super) type Candidate = (Seen, [f32; 4]);

/// A sphere in a tile: half a cache line.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C, align(32))]
pub(super) struct Record {
    /// Centre and radius.
    pub(super) sphere: [f32; 4],
    /// The upper bound of the inverse depth of every hit.
    pub(super) upper: f32,
    /// Its index in the file.
    pub(super) index: u32,
    pub(super) colour: Rgb,
    pub(super) unused: u8,
    /// First and last column, first and last row within the tile.
    pub(super) sides: [u8; 4],
}

/// Eight records, by components.
#[derive(Clone, Copy, Debug)]
pub(super) struct EightRecords {
    pub(super) spheres: EightSpheres,
    /// As lanes of colours.
    pub(super) colours: u32x8,
    pub(super) boxes: EightBoxes,
}

/// The boxes of eight records: each side as a byte, the first side in the lowest one.
#[derive(Clone, Copy, Debug)]
pub(super) struct EightBoxes(u32x8);

/// A sphere and its box in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Large {
    pub(super) sphere: [f32; 4],
    pub(super) upper: f32,
    pub(super) index: u32,
    pub(super) colour: Rgb,
    /// First and last column, first and last row within the picture.
    pub(super) sides: [u32; 4],
}

/// In a scene of at most this many spheres all are large, so that whole rows may be painted.
pub(super) const FEW_SPHERES: usize = 32;

/// If there are more tiles than this for each sphere, and more than [`MIN_TABLE`], there is no
/// table of tiles and all spheres are large. So a few rows of a huge picture take little memory.
const TILES_PER_SPHERE: usize = 64;
pub(super) const MIN_TABLE: usize = 1 << 16;

/// Bounds of the number of spheres in a run: enough to be worth a task, and, if there are
/// enough runs for all threads, so many that the records of a tile are in few places.
const MIN_RUN: usize = 1 << 12;
pub(super) const MAX_RUN: usize = 1 << 17;

/// Runs for each thread, so that no thread waits long for the last one.
const RUNS_PER_THREAD: usize = 3;

/// Memory for bins that is not in use.
#[derive(Debug, Default)]
pub(super) struct Room {
    runs: Pool<Run>,
    placements: Pool<Vec<Placed>>,
}

/// The candidates of every tile.
#[derive(Debug)]
pub(super) struct Bins {
    tiles: Tiles,
    runs: Vec<Run>,
    /// The large spheres, nearest first; of equal ones only the first of the file.
    pub(super) large: Vec<Large>,
}

/// The tiles of the picture.
#[derive(Clone, Copy, Debug)]
struct Tiles {
    /// The binary logarithm of a tile's side.
    shift: u32,
    columns: usize,
    rows: usize,
}

impl Tiles {
    fn side(self) -> u32 {
        1 << self.shift
    }

    fn count(self) -> usize {
        self.columns * self.rows
    }
}

/// The records of a run of spheres: those of tile `t` at `starts[t]..starts[t + 1]`,
/// in file order.
#[derive(Debug, Default)]
struct Run {
    starts: Vec<u32>,
    records: Records,
}

/// Memory for records. If they are many, it is in huge pages where the system has them, since
/// faulting in small pages takes as long as filling them.
#[derive(Debug)]
enum Records {
    Heap(Vec<Record>),
    Mapped(MmapMut),
}

impl Default for Records {
    fn default() -> Self {
        Self::Heap(Vec::new())
    }
}

impl Records {
    fn new(count: usize) -> Self {
        let bytes = count * size_of::<Record>();
        // A map of whole huge pages begins at a huge page.
        if bytes >= HUGE_PAGE
            && let Ok(map) = MmapMut::map_anon(bytes.next_multiple_of(HUGE_PAGE))
        {
            // The last part is in small pages, because clearing a huge page that is partly
            // used costs more.
            ask_for_huge(&map, 0..bytes - bytes % HUGE_PAGE);
            return Self::Mapped(map);
        }
        Self::Heap(vec![Record::default(); count])
    }

    /// Makes room for so many, and some more, so that the next picture's find room, too.
    fn reserve(&mut self, count: usize) {
        if self.all().len() < count {
            *self = Self::default();
            *self = Self::new(count + count / 8);
        }
    }

    fn all(&self) -> &[Record] {
        match self {
            Self::Heap(records) => records,
            Self::Mapped(map) => bytemuck::cast_slice(map),
        }
    }

    fn all_mut(&mut self) -> &mut [Record] {
        match self {
            Self::Heap(records) => records,
            Self::Mapped(map) => bytemuck::cast_slice_mut(map),
        }
    }
}

impl Bins {
    pub(super) fn new(
        spheres: &Spheres,
        grid: &Grid,
        side: u32,
        bounds: Bounds,
        room: &Room,
    ) -> Self {
        let size = grid.camera().size();
        let tiles = Tiles {
            shift: side.ilog2(),
            columns: size.width().div_ceil(side) as usize,
            rows: size.height().div_ceil(side) as usize,
        };
        // Every run has a table of all tiles, which should be a small part of its work.
        let tasks = RUNS_PER_THREAD * rayon::current_num_threads();
        let run = (spheres.len() / tasks).clamp(MIN_RUN, MAX_RUN);
        let max_tiles = (TILES_PER_SPHERE.saturating_mul(spheres.len())).max(MIN_TABLE);
        let all_large =
            spheres.len() <= FEW_SPHERES || tiles.count() > max_tiles || bounds == Bounds::Refused;
        let run = run
            .max(if all_large { 0 } else { tiles.count() })
            .next_multiple_of(LANES);
        let filled = |first: usize| {
            let last = (first + run).min(spheres.len());
            let mut filled = room.runs.take();
            let placements = &mut room.placements.lend();
            let large = filled.fill(spheres, first..last, grid, tiles, all_large, placements);
            (filled, large)
        };
        let filled: Vec<_> = if spheres.len() <= run {
            (0..spheres.len()).step_by(run).map(filled).collect()
        } else {
            let firsts = (0..spheres.len()).into_par_iter().step_by(run);
            firsts.map(filled).collect()
        };
        let mut runs = Vec::with_capacity(filled.len());
        let mut large = Vec::new();
        for (run, larges) in filled {
            if run.starts.is_empty() {
                room.runs.give(run);
            } else {
                runs.push(run);
            }
            large.extend(larges);
        }
        large.par_sort_unstable_by(|a: &Large, b: &Large| {
            let nearest = b.upper.total_cmp(&a.upper);
            let equal = || cmp_spheres(&a.sphere, &b.sphere);
            nearest.then_with(equal).then(a.index.cmp(&b.index))
        });
        large.dedup_by(|later, first| later.sphere == first.sphere);
        Self { tiles, runs, large }
    }

    /// Gives the memory back.
    pub(super) fn return_to(self, room: &Room) {
        for run in self.runs {
            room.runs.give(run);
        }
    }

    /// The small spheres of a tile, by its column and row.
    pub(super) fn records(&self, column: u32, row: u32) -> impl Iterator<Item = &[Record]> + Clone {
        let at = row as usize * self.tiles.columns + column as usize;
        self.runs.iter().map(move |run| {
            &run.records.all()[run.starts[at] as usize..run.starts[at + 1] as usize]
        })
    }

    /// How many small spheres a tile has.
    pub(super) fn count(&self, column: u32, row: u32) -> usize {
        self.records(column, row).map(<[Record]>::len).sum()
    }

    /// Whether no tile has small spheres.
    pub(super) fn has_none_small(&self) -> bool {
        self.runs.is_empty()
    }

    /// Side of a tile in pixels.
    pub(super) fn side(&self) -> u32 {
        self.tiles.side()
    }
}

/// The tiles of eight spheres, between the two passes over a run. The box of a small sphere meets
/// at most two columns and two rows of tiles.
#[derive(Clone, Copy, Debug)]
struct Placed {
    /// A mask of the small spheres that may be visible.
    small: u32,
    /// Of those, masks of the boxes in two columns and in two rows of tiles.
    across: u32,
    down: u32,
    /// The tile of the first pixel of the box.
    tile: [u32; LANES],
    /// Column and row within their tiles of the first and the last pixel, as in a record.
    sides: [u32; LANES],
    /// The greatest inverse depth.
    upper: [f32; LANES],
}

/// The part of a box that is in one tile.
#[derive(Clone, Copy, Debug)]
struct Part {
    tile: usize,
    /// 1; or 0, if there is no such part.
    count: u32,
    /// As in a record.
    sides: u32,
}

impl Run {
    /// Sorts a range of spheres by tile. Returns the large ones.
    fn fill(
        &mut self,
        spheres: &Spheres,
        range: Range<usize>,
        grid: &Grid,
        tiles: Tiles,
        all_large: bool,
        eights: &mut Vec<Placed>,
    ) -> Vec<Large> {
        eights.clear();
        let mut large = Vec::new();
        self.starts.clear();
        self.starts
            .resize(if all_large { 0 } else { tiles.count() + 1 }, 0);
        let unit = float_unit(grid);
        for first in range.clone().step_by(LANES) {
            let components = components(spheres, first);
            // Beyond the last sphere are some behind the camera.
            let boxes = Boxes::new(grid, components, unit);
            let mut small = 0;
            if !all_large {
                let placed = tiles.of_eight(&boxes);
                self.count(&placed, tiles);
                small = placed.small;
                eights.push(placed);
            }
            for lane in set_bits(u64::from(boxes.visible & !small)) {
                let index = first + lane;
                large.push(Large {
                    sphere: components.map(|all| all.as_array()[lane]),
                    upper: boxes.upper[lane],
                    index: index as u32,
                    colour: spheres.colour()[index],
                    sides: boxes.sides.map(|side| side[lane]),
                });
            }
        }
        self.scatter(spheres, range.start, tiles, eights);
        large
    }

    /// Counts the small ones of eight spheres for each of their tiles.
    #[inline]
    fn count(&mut self, placed: &Placed, tiles: Tiles) {
        for lane in 0..LANES {
            self.starts[placed.tile[lane] as usize] += placed.small >> lane & 1;
        }
        for lane in set_bits(u64::from(placed.across | placed.down)) {
            for part in placed.other_parts(lane, tiles) {
                self.starts[part.tile] += part.count;
            }
        }
    }

    /// Writes the records of the small spheres to their tiles.
    fn scatter(&mut self, spheres: &Spheres, first: usize, tiles: Tiles, eights: &[Placed]) {
        let starts = &mut self.starts;
        let mut total = 0;
        for start in &mut *starts {
            total += std::mem::replace(start, total);
        }
        if total == 0 {
            starts.clear();
            return;
        }
        // Parts that do not exist are written to the place behind the last record, so that no
        // branch depends on how many tiles a sphere has.
        self.records.reserve(total as usize + 1);
        let records = self.records.all_mut();
        for (first, placed) in (first..).step_by(LANES).zip(eights) {
            if placed.small == 0 {
                continue;
            }
            let eight = records_of(spheres, first, placed, tiles);
            for lane in 0..LANES {
                let count = placed.small >> lane & 1;
                let start = &mut starts[tiles.or_none(placed.tile[lane], count)];
                records[*start as usize] = eight[lane];
                *start += count;
            }
            for lane in set_bits(u64::from(placed.across | placed.down)) {
                for part in placed.other_parts(lane, tiles) {
                    let start = &mut starts[part.tile];
                    records[*start as usize] = Record {
                        sides: part.sides.to_le_bytes(),
                        ..eight[lane]
                    };
                    *start += part.count;
                }
            }
        }
        // Each start has moved to the position of the next one.
        starts.rotate_right(1);
        starts[0] = 0;
    }
}

impl Placed {
    /// The boxes within the tiles of their first pixels.
    #[inline]
    fn first_sides(&self, tiles: Tiles) -> u32x8 {
        let last = |place: u32| u32x8::splat((tiles.side() - 1) << (8 * place));
        let (across, down) = (lanes_of(self.across), lanes_of(self.down));
        u32x8::new(self.sides) | across & last(1) | down & last(3)
    }

    /// The parts of a sphere's box to the right of its first tile, below it, and below it to the
    /// right.
    #[inline(always)]
    fn other_parts(&self, lane: usize, tiles: Tiles) -> [Part; 3] {
        let (across, down) = (self.across >> lane & 1, self.down >> lane & 1);
        let (first, columns) = (self.tile[lane], tiles.columns as u32);
        let part = |count: u32, step: u32, sides: u32| Part {
            tile: tiles.or_none(first + step, count),
            count,
            sides,
        };
        let sides = self.sides[lane];
        let (no_left, no_top) = (sides & 0xffff_ff00, sides & 0xff00_ffff);
        let last = tiles.side() - 1;
        [
            part(across, 1, no_left | (down * last) << 24),
            part(down, columns, no_top | (across * last) << 8),
            part(across & down, columns + 1, no_left & no_top),
        ]
    }
}

/// The components of eight spheres; the arrays are padded beyond the last one.
#[inline(always)]
fn components(spheres: &Spheres, first: usize) -> [f32x8; 4] {
    let eight = |all: &[f32]| {
        let all = &all[first..first + LANES];
        f32x8::new(std::array::from_fn(|lane| all[lane]))
    };
    [
        eight(spheres.x()),
        eight(spheres.y()),
        eight(spheres.z()),
        eight(spheres.radius()),
    ]
}

/// Records of eight spheres in the tiles of their first pixels.
#[inline]
fn records_of(spheres: &Spheres, first: usize, placed: &Placed, tiles: Tiles) -> [Record; LANES] {
    let [x, y, z, r] = components(spheres, first);
    let colours = &spheres.colour()[first..];
    let mut eight = [[0; 3]; LANES];
    match colours.first_chunk() {
        Some(colours) => eight = *colours,
        None => eight[..colours.len()].copy_from_slice(colours),
    }
    let words = |words: [u32; LANES]| f32x8::new(words.map(f32::from_bits));
    let index = words(std::array::from_fn(|lane| (first + lane) as u32));
    let colours = words(eight.map(|[red, green, blue]| u32::from_ne_bytes([red, green, blue, 0])));
    let (upper, sides) = (
        f32x8::new(placed.upper),
        words(placed.first_sides(tiles).to_array().map(u32::to_le)),
    );
    bytemuck::cast(f32x8::transpose([x, y, z, r, upper, index, colours, sides]))
}

impl Tiles {
    /// A tile if `count` is 1; if it is 0, the one behind the last.
    #[inline(always)]
    fn or_none(self, tile: u32, count: u32) -> usize {
        if count == 1 {
            tile as usize
        } else {
            self.count()
        }
    }

    /// The tiles of eight spheres.
    #[inline]
    fn of_eight(self, boxes: &Boxes) -> Placed {
        let sides = boxes.sides.map(u32x8::new);
        let [left, right, top, bottom] = sides.map(|side| side >> self.shift);
        let (across, down) = (right - left, bottom - top);
        let equal = |steps: u32x8, count: u32| steps.simd_eq(u32x8::splat(count)).to_bitmask();
        let at_most_one = |steps: u32x8| equal(steps, 0) | equal(steps, 1);
        let small = boxes.visible & at_most_one(across) & at_most_one(down);
        let within = u32x8::splat(self.side() - 1);
        let [first, last, highest, lowest] = sides.map(|side| side & within);
        Placed {
            small,
            across: small & equal(across, 1),
            down: small & equal(down, 1),
            tile: (top * u32x8::splat(self.columns as u32) + left).to_array(),
            sides: (first | last << 8_u32 | highest << 16_u32 | lowest << 24_u32).to_array(),
            upper: boxes.upper,
        }
    }
}

impl EightRecords {
    /// Up to eight records; the last one fills the rest.
    #[inline(always)]
    pub(super) fn of(records: &[Record]) -> Self {
        match records.first_chunk() {
            Some(eight) => Self::new(eight),
            None => Self::from_fn(records.len(), |at| records[at]),
        }
    }

    /// Up to eight records by their numbers; the last one fills the rest.
    #[inline(always)]
    pub(super) fn from_fn(count: usize, record: impl Fn(usize) -> Record) -> Self {
        Self::new(&std::array::from_fn(|lane| record(lane.min(count - 1))))
    }

    #[inline]
    pub(super) fn new(records: &[Record; LANES]) -> Self {
        let [x, y, z, r, _, _, colours, sides] = f32x8::transpose(bytemuck::cast(*records));
        let sides: [u32; LANES] = bytemuck::cast(sides);
        Self {
            spheres: EightSpheres::new([x, y, z, r].map(f32x8::to_array)),
            colours: bytemuck::cast(colours),
            boxes: EightBoxes(u32x8::new(sides.map(u32::from_le))),
        }
    }
}

impl EightBoxes {
    /// The first and the last columns and rows.
    #[inline]
    pub(super) fn all_sides(self) -> [u32x8; 4] {
        [0_u32, 8, 16, 24].map(|place| self.0 >> place & u32x8::splat(0xff))
    }

    /// The first and the last column and row of one box.
    #[inline]
    pub(super) fn sides(&self, lane: usize) -> [usize; 4] {
        self.0.as_array()[lane].to_le_bytes().map(usize::from)
    }

    /// The pixels of the packets that meet these boxes. Packets begin at multiples of eight
    /// columns, but for a box that only one packet from its first column on holds.
    #[inline]
    pub(super) fn packets(self) -> Self {
        let last = u32x8::splat(LANES as u32 - 1);
        let octets = u32x8::splat((SIDE - LANES) as u32);
        let (left, right) = (self.0, self.0 >> 8_u32);
        let is_0 = |lanes: u32x8| (lanes & octets).simd_eq(u32x8::splat(0));
        let begins_at_box = is_0(right - left) & !is_0(right ^ left);
        let end = (left + last) & u32x8::splat(0xff);
        let from_box = self.0 & !u32x8::splat(0xff00) | end << 8_u32;
        let aligned = self.0 & !last | last << 8_u32;
        Self(begins_at_box.select(from_box, aligned))
    }

    /// A mask of the boxes that contain a pixel.
    #[inline]
    pub(super) fn holding(self, column: u8, row: u8) -> u32 {
        // With the last column and row complemented, no byte is greater than the pixel's.
        let pixel = u32::from_le_bytes([column, !column, row, !row]);
        let sides = self.0 ^ u32x8::splat(0xff00_ff00);
        let pixel: u8x32 = bytemuck::cast(u32x8::splat(pixel));
        let lesser: u32x8 = bytemuck::cast(bytemuck::cast::<_, u8x32>(sides).min(pixel));
        lesser.simd_eq(sides).to_bitmask()
    }
}

impl Record {
    /// The columns of its box.
    #[inline]
    pub(super) fn columns(&self) -> Range<usize> {
        usize::from(self.sides[0])..usize::from(self.sides[1]) + 1
    }

    /// The rows of its box.
    #[inline]
    pub(super) fn rows(&self) -> Range<usize> {
        usize::from(self.sides[2])..usize::from(self.sides[3]) + 1
    }

    /// The number of pixels in its box.
    pub(super) fn area(&self) -> usize {
        self.columns().len() * self.rows().len()
    }

    /// Whether its box is neither wider nor higher than a packet is wide.
    pub(super) fn is_narrow(&self) -> bool {
        self.columns().len() <= LANES && self.rows().len() <= LANES
    }

    /// The index of the sphere.
    pub(super) fn candidate(&self) -> Candidate {
        (self.index, self.sphere)
    }

    /// Whether it is the same sphere; minus zero is zero.
    fn is_equal(&self, other: &Self) -> bool {
        self.sphere == other.sphere
    }

    /// An order in which equal spheres are adjacent, the first of the file before the others.
    fn cmp_spheres(&self, other: &Self) -> Ordering {
        cmp_spheres(&self.sphere, &other.sphere).then(self.index.cmp(&other.index))
    }
}

/// Whether two boxes, each as first and last column, first and last row, have no pixel in common.
pub(super) fn are_apart<T: PartialOrd>(a: [T; 4], b: [T; 4]) -> bool {
    let ([left, right, top, bottom], other) = (a, b);
    left > other[1] || other[0] > right || top > other[3] || other[2] > bottom
}

/// Sorts the places of records from far to near; of equal spheres only the first of the file is left.
pub(super) fn sort_far_to_near<'a>(
    count: usize,
    record: impl Fn(usize) -> &'a Record,
    places: &mut Vec<u64>,
) {
    places.clear();
    // Inverse depths are not negative, so their bits are ordered as they are.
    let key = |at: usize| u64::from(record(at).upper.to_bits()) << 32 | at as u64;
    places.extend((0..count).map(key));
    places.sort_unstable();
    // Equal spheres have equal bounds, so only neighbours with equal bounds are compared.
    let alike = |a: &u64, b: &u64| a >> 32 == b >> 32;
    if places.windows(2).any(|pair| alike(&pair[0], &pair[1])) {
        let record = |key: &u64| record(*key as u32 as usize);
        for alike in places.chunk_by_mut(alike) {
            alike.sort_unstable_by(|a, b| record(a).cmp_spheres(record(b)));
        }
        places.dedup_by(|later, first| record(later).is_equal(record(first)));
    }
    for place in places {
        *place &= u64::from(u32::MAX);
    }
}

/// An order of spheres in which spheres of equal numbers are equal.
fn cmp_spheres(a: &[f32; 4], b: &[f32; 4]) -> Ordering {
    // Adding zero turns minus zero into zero.
    let bits = |sphere: &[f32; 4]| sphere.map(|length| (length + 0.0).to_bits());
    bits(a).cmp(&bits(b))
}

impl Large {
    /// The part of it that is in the tile at `(x, y)`.
    #[inline]
    pub(super) fn record(&self, x: u32, y: u32, side: u32) -> Record {
        let within = |at: u32, origin: u32| at.saturating_sub(origin).min(side - 1) as u8;
        let [left, right, top, bottom] = self.sides;
        Record {
            sphere: self.sphere,
            upper: self.upper,
            index: self.index,
            colour: self.colour,
            unused: 0,
            sides: [
                within(left, x),
                within(right, x),
                within(top, y),
                within(bottom, y),
            ],
        }
    }
}
