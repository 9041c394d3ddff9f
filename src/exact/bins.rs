//! Boxes to candidates: which spheres each tile has to look at.
//!
//! Small spheres are sorted by tile, in two passes over each run of spheres
//! (count, then scatter), runs in parallel and each with a table of its own, so
//! that no two threads write to one place. A sphere that would go to many tiles
//! is large instead: one record for the whole picture, nearest first.

use rayon::prelude::*;

use super::{
    Bounds,
    conic::{Extents, Grid, Lanes},
};
use crate::{
    methods::Seen,
    spheres::{LANES, Rgb, Sphere, Spheres},
};

/// A sphere in a tile: half a cache line.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Record {
    /// Centre and radius.
    pub(super) sphere: [f32; 4],
    /// No hit has a greater inverse depth.
    pub(super) most: f32,
    /// Its place in the file.
    pub(super) index: u32,
    pub(super) colour: Rgb,
    /// First and last column and row within the tile.
    pub(super) left: u8,
    pub(super) right: u8,
    pub(super) top: u8,
    pub(super) bottom: u8,
}

/// A sphere of many tiles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Large {
    pub(super) sphere: [f32; 4],
    pub(super) most: f32,
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

/// Of so few spheres all are large: whole rows are painted faster than tiles.
const FEW_SPHERES: usize = 64;

/// With more tiles than this, some trillion pixels, no table of them is made: all
/// spheres are large. Rows of such a picture can be drawn, if slowly, in little memory.
const MOST_TABLE: usize = 1 << 28;

/// Spheres of a run, at least: enough to be worth a task, few enough to stay in a cache.
const RUN: usize = 1 << 17;

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
    greatest: f32,
    starts: Vec<u32>,
    records: Vec<Record>,
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
        let run = RUN.max(tiles.count().min(MOST_TABLE));
        let run = run.next_multiple_of(LANES);
        let all_large =
            spheres.len() <= FEW_SPHERES || tiles.count() > MOST_TABLE || bounds == Bounds::Refused;
        let filled = |first: usize| {
            let last = (first + run).min(spheres.len());
            Run::fill(spheres, first..last, grid, tiles, all_large)
        };
        let firsts: Vec<usize> = (0..spheres.len()).step_by(run).collect();
        let filled: Vec<_> = if firsts.len() <= 1 {
            firsts.into_iter().map(filled).collect()
        } else {
            firsts.into_par_iter().map(filled).collect()
        };
        let mut runs = Vec::with_capacity(filled.len());
        let mut large = Vec::new();
        for (run, larges) in filled {
            if !run.records.is_empty() {
                runs.push(run);
            }
            large.extend(larges);
        }
        large.par_sort_unstable_by(|a: &Large, b: &Large| {
            let nearest = b.most.total_cmp(&a.most);
            // Zeros of either sign are equal.
            let bits = |large: &Large| large.sphere.map(|component| (component + 0.0).to_bits());
            let equal = || bits(a).cmp(&bits(b));
            nearest.then_with(equal).then(a.index.cmp(&b.index))
        });
        large.dedup_by(|later, first| later.sphere == first.sphere);
        Self { tiles, runs, large }
    }

    /// The greatest finite inverse depth of any sphere.
    pub(super) fn greatest(&self) -> f32 {
        let runs = self.runs.iter().map(|run| run.greatest);
        greatest(&self.large).max(runs.fold(0.0, f32::max))
    }

    /// The small spheres of a tile, by its column and row.
    pub(super) fn records(&self, column: u32, row: u32) -> impl Iterator<Item = &[Record]> + Clone {
        let at = row as usize * self.tiles.columns + column as usize;
        self.runs
            .iter()
            .map(move |run| &run.records[run.starts[at] as usize..run.starts[at + 1] as usize])
    }

    /// Side of a tile in pixels.
    pub(super) fn side(&self) -> u32 {
        self.tiles.side()
    }

    /// Whether no tile has small spheres.
    pub(super) fn none_small(&self) -> bool {
        self.runs.is_empty()
    }
}

impl Run {
    fn fill(
        spheres: &Spheres,
        range: std::ops::Range<usize>,
        grid: &Grid,
        tiles: Tiles,
        all_large: bool,
    ) -> (Self, Vec<Large>) {
        let mut small = Vec::new();
        let mut large = Vec::new();
        let mut starts = Vec::new();
        let components = [spheres.x(), spheres.y(), spheres.z(), spheres.radius()];
        for first in range.clone().step_by(LANES) {
            let eight =
                |component: &[f32]| -> [f32; LANES] { std::array::from_fn(|lane| component[lane]) };
            let [x, y, z, r] = components.map(|all| eight(&all[first..first + LANES]));
            let extents = Extents::new(grid, &Lanes::new(x, y, z, r));
            let mut visible = extents.visible;
            while visible != 0 {
                let lane = visible.trailing_zeros() as usize;
                visible &= visible - 1;
                if first + lane >= range.end {
                    break;
                }
                let placed = Large {
                    sphere: [x[lane], y[lane], z[lane], r[lane]],
                    most: extents.most[lane],
                    index: (first + lane) as u32,
                    colour: spheres.colour()[first + lane],
                    left: extents.left[lane],
                    right: extents.right[lane],
                    top: extents.top[lane],
                    bottom: extents.bottom[lane],
                };
                let shift = tiles.shift;
                let across = u64::from((placed.right >> shift) - (placed.left >> shift)) + 1;
                let down = u64::from((placed.bottom >> shift) - (placed.top >> shift)) + 1;
                if all_large || across.saturating_mul(down) > MOST_TILES {
                    large.push(placed);
                    continue;
                }
                if starts.is_empty() {
                    starts = vec![0_u32; tiles.count() + 1];
                }
                placed.each_tile(tiles, |at, _, _| starts[at] += 1);
                small.push(placed);
            }
        }
        let mut total = 0;
        for start in &mut starts {
            total += std::mem::replace(start, total);
        }
        let mut records = vec![Record::default(); total as usize];
        for placed in &small {
            placed.each_tile(tiles, |at, column, row| {
                let (x, y) = (column << tiles.shift, row << tiles.shift);
                records[starts[at] as usize] = placed.record(x, y, tiles.side());
                starts[at] += 1;
            });
        }
        // Each start has moved to where the next one was.
        if !starts.is_empty() {
            starts.rotate_right(1);
            starts[0] = 0;
        }
        let run = Self {
            greatest: greatest(&small),
            starts,
            records,
        };
        (run, large)
    }
}

fn greatest(placed: &[Large]) -> f32 {
    let most = placed.iter().map(|placed| placed.most);
    most.filter(|most| most.is_finite()).fold(0.0, f32::max)
}

impl Record {
    /// The sphere, by its place in the file.
    pub(super) fn candidate(&self) -> (Seen, Sphere) {
        candidate(self.index, self.sphere, self.colour)
    }
}

fn candidate(index: u32, [x, y, z, radius]: [f32; 4], colour: Rgb) -> (Seen, Sphere) {
    let sphere = Sphere {
        centre: [x, y, z],
        radius,
        colour,
    };
    (index, sphere)
}

impl Large {
    /// The sphere, by its place in the file.
    pub(super) fn candidate(&self) -> (Seen, Sphere) {
        candidate(self.index, self.sphere, self.colour)
    }

    /// Visits the tiles of its box: place in the table, column, row.
    #[inline]
    fn each_tile(&self, tiles: Tiles, mut visit: impl FnMut(usize, u32, u32)) {
        let (left, right) = (self.left >> tiles.shift, self.right >> tiles.shift);
        let (top, bottom) = (self.top >> tiles.shift, self.bottom >> tiles.shift);
        for row in top..bottom + 1 {
            let first = row as usize * tiles.columns;
            for column in left..right + 1 {
                visit(first + column as usize, column, row);
            }
        }
    }

    /// The part of it in the tile at `(x, y)`.
    pub(super) fn record(&self, x: u32, y: u32, side: u32) -> Record {
        let within = |at: u32, origin: u32| at.saturating_sub(origin).min(side - 1) as u8;
        Record {
            sphere: self.sphere,
            most: self.most,
            index: self.index,
            colour: self.colour,
            left: within(self.left, x),
            right: within(self.right, x),
            top: within(self.top, y),
            bottom: within(self.bottom, y),
        }
    }
}
