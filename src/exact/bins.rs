//! Boxes to candidates: which spheres each tile has to look at.
//!
//! Small spheres are sorted by tile, in two passes over each run of spheres
//! (count, then scatter), runs in parallel and each with a table of its own, so
//! that no two threads write to one place. A sphere that would go to many tiles
//! is large instead: one record for the whole picture, nearest first.

use std::cmp::Ordering;

use bytemuck::{Pod, Zeroable};
use memmap2::MmapMut;
use rayon::prelude::*;
use wide::{f32x8, u32x8};

use super::{
    Bounds,
    boxes::Boxes,
    decide::Candidate,
    grid::{EightSpheres, Grid},
    set_bits,
};
use crate::{
    pages::{HUGE_PAGE, ask_for_huge},
    spheres::{LANES, Rgb, Spheres},
};

/// A sphere in a tile: half a cache line.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C, align(32))]
pub(super) struct Record {
    /// Centre and radius.
    pub(super) sphere: [f32; 4],
    /// No hit has a greater inverse depth.
    pub(super) upper: f32,
    /// Its place in the file.
    pub(super) index: u32,
    pub(super) colour: Rgb,
    pub(super) unused: u8,
    /// First and last column and row within the tile.
    pub(super) left: u8,
    pub(super) right: u8,
    pub(super) top: u8,
    pub(super) bottom: u8,
}

/// A sphere and its box; kept as it is if it is one of many tiles.
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

/// A sphere of more tiles than this is large; it bounds the memory of the bins. One
/// that covers a tile reaches beyond it on all sides, so it is large.
const MOST_TILES: u64 = 4;

/// Of so few spheres all are large: they may be painted by whole rows.
pub(super) const FEW_SPHERES: usize = 32;

/// With more tiles than this for each sphere, and than [`LEAST_TABLE`], no table of them
/// is made: all spheres are large. So a few rows of a huge picture take little memory.
const TILES_PER_SPHERE: usize = 64;
pub(super) const LEAST_TABLE: usize = 1 << 16;

/// Spheres of a run: enough to be worth a task, and so many, if there are enough for
/// all threads, that a tile's records lie in few places.
const LEAST_RUN: usize = 1 << 12;
pub(super) const MOST_RUN: usize = 1 << 17;

/// Runs for each thread, so that none waits long for the last.
const RUNS_PER_THREAD: usize = 3;

/// The candidates of every tile.
#[derive(Debug)]
pub(super) struct Bins {
    tiles: Tiles,
    runs: Vec<Run>,
    /// Nearest first; of equal spheres only the first of the file.
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

/// Room for records: many of them in huge pages if there are any, since getting
/// small ones takes as long as filling them.
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
        // Maps of whole huge pages begin at one.
        if bytes >= HUGE_PAGE
            && let Ok(map) = MmapMut::map_anon(bytes.next_multiple_of(HUGE_PAGE))
        {
            // What would be in the last one comes in small pages: clearing more than is
            // used costs more.
            ask_for_huge(&map, 0..bytes - bytes % HUGE_PAGE);
            return Self::Mapped(map);
        }
        Self::Heap(vec![Record::default(); count])
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
    pub(super) fn new(spheres: &Spheres, grid: &Grid, side: u32, bounds: Bounds) -> Self {
        let size = grid.camera().size();
        let tiles = Tiles {
            shift: side.ilog2(),
            columns: size.width().div_ceil(side) as usize,
            rows: size.height().div_ceil(side) as usize,
        };
        // Every run has a table of all tiles: it should not be most of its work.
        let tasks = RUNS_PER_THREAD * rayon::current_num_threads();
        let run = (spheres.len() / tasks).clamp(LEAST_RUN, MOST_RUN);
        let most_tiles = (TILES_PER_SPHERE.saturating_mul(spheres.len())).max(LEAST_TABLE);
        let all_large =
            spheres.len() <= FEW_SPHERES || tiles.count() > most_tiles || bounds == Bounds::Refused;
        let run = run
            .max(if all_large { 0 } else { tiles.count() })
            .next_multiple_of(LANES);
        let filled = |placed: &mut Vec<Placed>, first: usize| {
            let last = (first + run).min(spheres.len());
            Run::fill(spheres, first..last, grid, tiles, all_large, placed)
        };
        let firsts: Vec<usize> = (0..spheres.len()).step_by(run).collect();
        let filled: Vec<_> = if firsts.len() <= 1 {
            let placed = &mut Vec::new();
            firsts
                .into_iter()
                .map(|first| filled(placed, first))
                .collect()
        } else {
            firsts.into_par_iter().map_init(Vec::new, filled).collect()
        };
        let mut runs = Vec::with_capacity(filled.len());
        let mut large = Vec::new();
        for (run, larges) in filled {
            if !run.starts.is_empty() {
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

    /// The small spheres of a tile, by its column and row.
    pub(super) fn records(&self, column: u32, row: u32) -> impl Iterator<Item = &[Record]> + Clone {
        let at = row as usize * self.tiles.columns + column as usize;
        self.runs.iter().map(move |run| {
            &run.records.all()[run.starts[at] as usize..run.starts[at + 1] as usize]
        })
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

/// Where eight spheres go, between the two passes.
#[derive(Debug)]
struct Placed {
    /// Which lanes go to one tile, and which to several.
    one: u32,
    several: u32,
    /// The tile of those that go to one, their boxes in it as in a record, and their
    /// greatest inverse depth.
    tile: [u32; LANES],
    sides: [u32; LANES],
    upper: [f32; LANES],
}

impl Run {
    fn fill(
        spheres: &Spheres,
        range: std::ops::Range<usize>,
        grid: &Grid,
        tiles: Tiles,
        all_large: bool,
        placed: &mut Vec<Placed>,
    ) -> (Self, Vec<Large>) {
        placed.clear();
        let (mut large, mut several) = (Vec::new(), Vec::new());
        let mut starts = vec![0_u32; if all_large { 0 } else { tiles.count() + 1 }];
        for first in range.clone().step_by(LANES) {
            let [x, y, z, r] = components(spheres, first);
            let mut boxes = Boxes::new(grid, &EightSpheres::new([x, y, z, r]));
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
                if all_large || covered.count() > MOST_TILES {
                    large.push(sphere);
                } else {
                    eight.several |= 1 << lane;
                    several.push(sphere);
                    covered.each(tiles, |at, _, _| starts[at] += 1);
                }
            }
            if !all_large {
                placed.push(eight);
            }
        }
        let mut total = 0;
        for start in &mut starts {
            total += std::mem::replace(start, total);
        }
        if total == 0 {
            starts.clear();
        }
        let mut store = Records::new(total as usize);
        let records = store.all_mut();
        let mut several = several.iter();
        for (first, placed) in range.step_by(LANES).zip(&*placed) {
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
        // Each start has moved to where the next one was.
        if !starts.is_empty() {
            starts.rotate_right(1);
            starts[0] = 0;
        }
        let run = Self {
            starts,
            records: store,
        };
        (run, large)
    }
}

/// The components of eight spheres; beyond the last one there is room for that.
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

/// The tiles of a box: first and last column and row of them.
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

    /// The tiles of the first pixels of eight boxes, the boxes within them as the sides
    /// of a record, and which of them reach no further.
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

    /// Visits them: place in the table, column, row.
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

impl Record {
    /// First and last column and row within the tile.
    pub(super) fn sides(&self) -> [u8; 4] {
        [self.left, self.right, self.top, self.bottom]
    }

    /// Pixels of its box.
    pub(super) fn area(&self) -> usize {
        (usize::from(self.right - self.left) + 1) * (usize::from(self.bottom - self.top) + 1)
    }

    /// Whether its box is no wider and no higher than a packet is wide.
    pub(super) fn is_narrow(&self) -> bool {
        usize::from(self.right - self.left) < LANES && usize::from(self.bottom - self.top) < LANES
    }

    /// The sphere, by its place in the file.
    pub(super) fn candidate(&self) -> Candidate {
        (self.index, self.sphere)
    }

    /// Whether it is the same sphere; minus zero is zero.
    pub(super) fn is_equal(&self, other: &Self) -> bool {
        self.sphere == other.sphere
    }

    /// An order in which equal spheres stand together, the first of the file before the
    /// others.
    pub(super) fn cmp_spheres(&self, other: &Self) -> Ordering {
        cmp_spheres(&self.sphere, &other.sphere).then(self.index.cmp(&other.index))
    }

    /// Whether no pixel lies in both boxes.
    pub(super) fn is_apart(&self, other: &Self) -> bool {
        are_apart(self.sides(), other.sides())
    }
}

/// Whether two boxes, each as first and last column and row, have no pixel in common.
fn are_apart<T: PartialOrd>(a: [T; 4], b: [T; 4]) -> bool {
    let ([left, right, top, bottom], other) = (a, b);
    left > other[1] || other[0] > right || top > other[3] || other[2] > bottom
}

/// An order of spheres in which those that are equal as numbers are equal.
fn cmp_spheres(a: &[f32; 4], b: &[f32; 4]) -> Ordering {
    // The sum has no minus zero.
    let bits = |sphere: &[f32; 4]| sphere.map(|length| (length + 0.0).to_bits());
    bits(a).cmp(&bits(b))
}

impl Large {
    /// Whether no pixel lies in both boxes.
    pub(super) fn is_apart(&self, other: &Self) -> bool {
        let sides = |large: &Self| [large.left, large.right, large.top, large.bottom];
        are_apart(sides(self), sides(other))
    }

    /// The part of it in the tile at `(x, y)`.
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
