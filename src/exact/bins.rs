//! From boxes to candidates: the spheres that each tile must test.
//!
//! Small spheres are sorted by tile, in two passes over each run of spheres: count, then
//! scatter. Runs are processed in parallel, each with a table of its own, so that no two
//! threads write to the same place. A sphere whose box meets many tiles is *large*: it has one
//! record for the whole picture, and the large ones are sorted nearest first.

use std::cmp::Ordering;

use bytemuck::{Pod, Zeroable};
use memmap2::MmapMut;
use rayon::prelude::*;
use wide::{f32x8, f64x8, i32x8, u8x32, u32x8};

use super::{
    bits::set_bits,
    boxes::Boxes,
    grid::{EightSpheres, Grid},
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
    /// First and last column and row within the tile.
    pub(super) left: u8,
    pub(super) right: u8,
    pub(super) top: u8,
    pub(super) bottom: u8,
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
    /// First and last column and row within the picture.
    pub(super) left: u32,
    pub(super) right: u32,
    pub(super) top: u32,
    pub(super) bottom: u32,
}

/// A sphere whose box meets more tiles than this is large, which bounds the memory of the bins.
/// A sphere that covers a tile extends beyond it on all sides, so it is large.
const MAX_TILES: u64 = 4;

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
    placements: Pool<Placements>,
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

/// The tiles of the spheres of a run, between the two passes.
#[derive(Debug, Default)]
struct Placements {
    eights: Vec<Placed>,
    /// The spheres that go to several tiles.
    several: Vec<Large>,
}

/// The tiles of eight spheres.
#[derive(Debug)]
struct Placed {
    /// Masks of the lanes that go to one tile, and of those that go to several.
    one: u32,
    several: u32,
    /// For the lanes that go to one tile: the tile, the boxes in it as in a record, and the
    /// greatest inverse depth.
    tile: [u32; LANES],
    sides: [u32; LANES],
    upper: [f32; LANES],
}

impl Run {
    /// Sorts a range of spheres by tile. Returns the large ones.
    fn fill(
        &mut self,
        spheres: &Spheres,
        range: std::ops::Range<usize>,
        grid: &Grid,
        tiles: Tiles,
        all_large: bool,
        Placements { eights, several }: &mut Placements,
    ) -> Vec<Large> {
        eights.clear();
        several.clear();
        let mut large = Vec::new();
        let starts = &mut self.starts;
        starts.clear();
        starts.resize(if all_large { 0 } else { tiles.count() + 1 }, 0);
        let fit_floats = Boxes::fit_floats(grid);
        for first in range.clone().step_by(LANES) {
            let [x, y, z, r] = components(spheres, first);
            let mut boxes = Boxes::of_floats(grid, [x, y, z, r], fit_floats);
            if range.end - first < LANES {
                boxes.visible &= (1 << (range.end - first)) - 1;
            }
            let (tile, sides, one) = if all_large {
                ([0; LANES], [0; LANES], 0)
            } else {
                tiles.of_eight(&boxes)
            };
            let mut eight = Placed {
                one: one & boxes.visible,
                several: 0,
                tile,
                sides,
                upper: boxes.upper,
            };
            for lane in set_bits(u64::from(eight.one)) {
                starts[tile[lane] as usize] += 1;
            }
            for lane in set_bits(u64::from(boxes.visible & !one)) {
                let index = first + lane;
                let sphere = Large {
                    sphere: [x[lane], y[lane], z[lane], r[lane]],
                    upper: boxes.upper[lane],
                    index: index as u32,
                    colour: spheres.colour()[index],
                    left: boxes.left[lane],
                    right: boxes.right[lane],
                    top: boxes.top[lane],
                    bottom: boxes.bottom[lane],
                };
                let covered = tiles.of(&sphere);
                if all_large || covered.count() > MAX_TILES {
                    large.push(sphere);
                } else {
                    eight.several |= 1 << lane;
                    several.push(sphere);
                    covered.each(tiles, |at, _, _| starts[at] += 1);
                }
            }
            if !all_large {
                eights.push(eight);
            }
        }
        let mut total = 0;
        for start in &mut *starts {
            total += std::mem::replace(start, total);
        }
        if total == 0 {
            starts.clear();
        }
        self.records.reserve(total as usize);
        let records = self.records.all_mut();
        let mut several = several.iter();
        for (first, placed) in range.step_by(LANES).zip(&*eights) {
            if placed.one | placed.several == 0 {
                continue;
            }
            let eight = records_of(spheres, first, placed);
            for lane in set_bits(u64::from(placed.one | placed.several)) {
                if placed.one >> lane & 1 == 1 {
                    let start = &mut starts[placed.tile[lane] as usize];
                    records[*start as usize] = eight[lane];
                    *start += 1;
                } else if let Some(sphere) = several.next() {
                    tiles.of(sphere).each(tiles, |at, column, row| {
                        let (x, y) = (column << tiles.shift, row << tiles.shift);
                        records[starts[at] as usize] = sphere.record(x, y, tiles.side());
                        starts[at] += 1;
                    });
                }
            }
        }
        // Each start has moved to the position of the next one.
        if !starts.is_empty() {
            starts.rotate_right(1);
            starts[0] = 0;
        }
        large
    }
}

/// The components of eight spheres; the arrays are padded beyond the last one.
#[inline]
fn components(spheres: &Spheres, first: usize) -> [[f32; LANES]; 4] {
    [spheres.x(), spheres.y(), spheres.z(), spheres.radius()].map(|all| {
        let all = &all[first..first + LANES];
        std::array::from_fn(|lane| all[lane])
    })
}

/// Records of eight spheres, for those lanes that go to one tile.
#[inline]
fn records_of(spheres: &Spheres, first: usize, placed: &Placed) -> [Record; LANES] {
    let [x, y, z, r] = components(spheres, first).map(f32x8::new);
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
        words(placed.sides.map(u32::to_le)),
    );
    bytemuck::cast(f32x8::transpose([x, y, z, r, upper, index, colours, sides]))
}

/// The tiles of a box: the first and the last column and row of tiles.
#[derive(Clone, Copy, Debug)]
struct Covered {
    left: u32,
    right: u32,
    top: u32,
    bottom: u32,
}

impl Tiles {
    #[inline]
    fn of(self, sphere: &Large) -> Covered {
        Covered {
            left: sphere.left >> self.shift,
            right: sphere.right >> self.shift,
            top: sphere.top >> self.shift,
            bottom: sphere.bottom >> self.shift,
        }
    }

    /// The tiles of the first pixels of eight boxes, the boxes within them as the sides of a
    /// record, and a mask of the boxes that are within one tile.
    #[inline]
    fn of_eight(self, boxes: &Boxes) -> ([u32; LANES], [u32; LANES], u32) {
        let Boxes {
            left,
            right,
            top,
            bottom,
            ..
        } = boxes;
        let tile = |x: u32, y: u32| (y >> self.shift) * self.columns as u32 + (x >> self.shift);
        let first = std::array::from_fn(|lane| tile(left[lane], top[lane]));
        let last = std::array::from_fn(|lane| tile(right[lane], bottom[lane]));
        let within = self.side() - 1;
        let sides = std::array::from_fn(|lane| {
            let [left, right, top, bottom] =
                [left, right, top, bottom].map(|side| side[lane] & within);
            left | right << 8 | top << 16 | bottom << 24
        });
        let one = u32x8::new(first).simd_eq(u32x8::new(last)).to_bitmask();
        (first, sides, one)
    }
}

impl Covered {
    #[inline]
    fn count(self) -> u64 {
        let across = u64::from(self.right - self.left) + 1;
        let down = u64::from(self.bottom - self.top) + 1;
        across.saturating_mul(down)
    }

    /// Calls a function with the index in the table, the column and the row of each tile.
    #[inline]
    fn each(self, tiles: Tiles, mut visit: impl FnMut(usize, u32, u32)) {
        let mut row = self.top;
        loop {
            let first = row as usize * tiles.columns;
            let mut column = self.left;
            loop {
                visit(first + column as usize, column, row);
                if column == self.right {
                    break;
                }
                column += 1;
            }
            if row == self.bottom {
                break;
            }
            row += 1;
        }
    }
}

impl EightRecords {
    /// Up to eight records; the last one fills the rest.
    #[inline]
    pub(super) fn of(records: &[Record]) -> Self {
        match records.first_chunk() {
            Some(eight) => Self::new(eight),
            None => Self::from_fn(records.len(), |at| records[at]),
        }
    }

    /// Up to eight records by their numbers; the last one fills the rest.
    #[inline]
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
    fn side(self, place: u32) -> f64x8 {
        let side = self.0 >> (8 * place) & u32x8::splat(0xff);
        f64x8::from(bytemuck::cast::<_, i32x8>(side))
    }

    pub(super) fn left(self) -> f64x8 {
        self.side(0)
    }

    pub(super) fn right(self) -> f64x8 {
        self.side(1)
    }

    pub(super) fn top(self) -> f64x8 {
        self.side(2)
    }

    pub(super) fn bottom(self) -> f64x8 {
        self.side(3)
    }

    /// The first and the last column and row of one box.
    #[inline]
    pub(super) fn sides(&self, lane: usize) -> [usize; 4] {
        self.0.as_array()[lane].to_le_bytes().map(usize::from)
    }

    /// A mask of the boxes that are neither wider nor higher than a packet is wide.
    #[inline]
    pub(super) fn narrow(self) -> u32 {
        let bytes = u32x8::splat(0x00ff_00ff);
        let spans = (self.0 >> 8_u32 & bytes) - (self.0 & bytes);
        let beyond = spans & u32x8::splat(0x00f8_00f8);
        beyond.simd_eq(u32x8::splat(0)).to_bitmask()
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
    /// First and last column and row within the tile.
    pub(super) fn sides(&self) -> [u8; 4] {
        [self.left, self.right, self.top, self.bottom]
    }

    /// The number of pixels in its box.
    pub(super) fn area(&self) -> usize {
        (usize::from(self.right - self.left) + 1) * (usize::from(self.bottom - self.top) + 1)
    }

    /// Whether its box is neither wider nor higher than a packet is wide.
    pub(super) fn is_narrow(&self) -> bool {
        usize::from(self.right - self.left) < LANES && usize::from(self.bottom - self.top) < LANES
    }

    /// The index of the sphere.
    pub(super) fn candidate(&self) -> Candidate {
        (self.index, self.sphere)
    }

    /// Whether it is the same sphere; minus zero is zero.
    pub(super) fn is_equal(&self, other: &Self) -> bool {
        self.sphere == other.sphere
    }

    /// An order in which equal spheres are adjacent, the first of the file before the others.
    pub(super) fn cmp_spheres(&self, other: &Self) -> Ordering {
        cmp_spheres(&self.sphere, &other.sphere).then(self.index.cmp(&other.index))
    }
}

/// Whether two boxes, each as first and last column and row, have no pixel in common.
fn are_apart<T: PartialOrd>(a: [T; 4], b: [T; 4]) -> bool {
    let ([left, right, top, bottom], other) = (a, b);
    left > other[1] || other[0] > right || top > other[3] || other[2] > bottom
}

/// An order of spheres in which spheres of equal numbers are equal.
fn cmp_spheres(a: &[f32; 4], b: &[f32; 4]) -> Ordering {
    // Adding zero turns minus zero into zero.
    let bits = |sphere: &[f32; 4]| sphere.map(|length| (length + 0.0).to_bits());
    bits(a).cmp(&bits(b))
}

impl Large {
    /// Whether the boxes have no pixel in common.
    pub(super) fn is_apart(&self, other: &Self) -> bool {
        self.is_beside(other.sides())
    }

    /// Whether its box has no pixel in common with another one, given as first and last column
    /// and row in the picture.
    pub(super) fn is_beside(&self, sides: [u32; 4]) -> bool {
        are_apart(self.sides(), sides)
    }

    fn sides(&self) -> [u32; 4] {
        [self.left, self.right, self.top, self.bottom]
    }

    /// The part of it that is in the tile at `(x, y)`.
    #[inline]
    pub(super) fn record(&self, x: u32, y: u32, side: u32) -> Record {
        let within = |at: u32, origin: u32| at.saturating_sub(origin).min(side - 1) as u8;
        Record {
            sphere: self.sphere,
            upper: self.upper,
            index: self.index,
            colour: self.colour,
            left: within(self.left, x),
            right: within(self.right, x),
            top: within(self.top, y),
            bottom: within(self.bottom, y),
            unused: 0,
        }
    }
}
