//! Tiles of few spheres: the columns that each sphere covers in each row, as masks of 64 bits.
//!
//! Spheres are processed from far to near. Where a sphere certainly covers a pixel and is nearer
//! than all spheres before it, it is visible. Pixels in which the intervals of two spheres
//! overlap, and pixels too close to an outline, are *contested*, which is a mask too.

use wide::f64x8;

use super::{
    bins::{EightRecords, Record},
    depths::{Depths, Rectangles},
    grid::{Grid, SIDE},
    outline::{EightRows, Outline, Placement},
    tuning::Bounds,
};
use crate::spheres::LANES;

#[cfg(test)]
mod tests;

/// For spheres with at least this many pixels in a tile, bounds within the tile are worthwhile.
const REFINED: usize = 512;

/// Eight rows of a tile.
pub(super) const OCTETS: usize = SIDE / LANES;

/// A bit for each pixel of a tile.
pub(super) type Mask = [[u64; LANES]; OCTETS];

/// A sphere in a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Covering {
    pub(super) record: Record,
    /// The lower and the upper bound of the inverse depth of every hit in its box.
    lower: f32,
    upper: f32,
    /// The index of its first octet among those of all spheres.
    rows: usize,
}

impl Covering {
    pub(super) fn first_octet(&self) -> usize {
        usize::from(self.record.top) / LANES
    }

    fn last_octet(&self) -> usize {
        usize::from(self.record.bottom) / LANES
    }

    fn octets(&self) -> std::ops::Range<usize> {
        self.first_octet()..self.last_octet() + 1
    }
}

/// The part of a tile that is drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tile {
    /// Its first column and row in the picture.
    pub(super) column: u32,
    pub(super) row: u32,
    /// The number of columns within the picture.
    pub(super) width: usize,
    /// Rows that are drawn now.
    pub(super) first: usize,
    pub(super) last: usize,
}

impl Tile {
    /// The column and the row in the picture of one of its pixels.
    pub(super) fn pixel(&self, column: usize, row: usize) -> (u32, u32) {
        (self.column + column as u32, self.row + row as u32)
    }

    /// Whether a record has no pixel in the part of the tile that is drawn now.
    pub(super) fn is_beside(&self, record: &Record) -> bool {
        usize::from(record.bottom) < self.first || usize::from(record.top) >= self.last
    }

    /// Whether a box is the whole part of the tile that is drawn now.
    pub(super) fn is_all_of(&self, record: &Record) -> bool {
        record.left == 0
            && usize::from(record.right) + 1 >= self.width
            && usize::from(record.top) <= self.first
            && usize::from(record.bottom) + 1 >= self.last
    }

    /// Rectangles around the boxes of up to eight records. They have seven more columns, since a
    /// packet may extend beyond the box, and at least one row, so that every coefficient is
    /// bounded.
    #[inline]
    pub(super) fn rectangles(&self, records: &EightRecords) -> Rectangles {
        let half = |first: f64x8, last: f64x8, more: f64| {
            ((last - first + f64x8::splat(more)) * f64x8::splat(0.5)).floor()
        };
        let boxes = &records.boxes;
        let (left, top) = (boxes.left(), boxes.top());
        let across = half(left, boxes.right(), LANES as f64);
        let down = half(top, boxes.bottom(), 2.0);
        Rectangles {
            columns: left + across + f64x8::splat(f64::from(self.column)),
            rows: top + down + f64x8::splat(f64::from(self.row)),
            across,
            down,
        }
    }
}

/// The spheres of a tile of few spheres, and what they cover.
#[derive(Debug, Default)]
pub(super) struct Coverage {
    pub(super) spheres: Vec<Covering>,
    /// The octets of all spheres' boxes, one sphere after another.
    rows: Vec<EightRows>,
    /// The first column that a row may cover, and the one after the last; in the same order.
    ends: Vec<[u8; 2]>,
    keys: Vec<u64>,
    /// The indices of the spheres that are not hidden, from far to near.
    pub(super) order: Vec<usize>,
    /// Whether the first in the order covers the whole tile.
    pub(super) closed: bool,
    pub(super) contested: Mask,
    pub(super) any_contested: bool,
    /// The spheres whose intervals overlap that of the current sphere.
    overlap: Mask,
}

impl Coverage {
    /// Finds the pixels of the tile that each record covers, and those that are contested.
    pub(super) fn find(&mut self, grid: &Grid, tile: &Tile, records: &[Record], bounds: Bounds) {
        self.spheres.clear();
        self.rows.clear();
        self.ends.clear();
        for eight in records.chunks(LANES) {
            self.outline(grid, tile, eight, bounds);
        }
        self.sort();
        if bounds == Bounds::Proven && self.overlap() {
            self.refine(grid, tile);
            self.sort();
        }
        self.drop_hidden(tile);
        self.contest();
    }

    fn outline(&mut self, grid: &Grid, tile: &Tile, records: &[Record], bounds: Bounds) {
        let eight = EightRecords::of(records);
        let rectangles = tile.rectangles(&eight);
        let placement = Placement {
            rows: rectangles.rows,
            // An octet may extend seven rows beyond the box on either side.
            down: rectangles.down + f64x8::splat(LANES as f64),
            column: tile.column,
            row: tile.row,
        };
        let outlines = Outline::eight(grid, &placement, &eight.spheres, bounds);
        for (outline, record) in outlines.iter().zip(records) {
            let covering = Covering {
                record: *record,
                lower: outline.lower,
                upper: record.upper,
                rows: self.rows.len(),
            };
            outline.rows(covering.octets(), tile.width, record, &mut self.rows);
            self.spheres.push(covering);
        }
        let new = self.rows[self.ends.len() / LANES..].iter();
        self.ends.extend(new.flat_map(|rows| rows.ends));
    }

    /// The rows of a sphere's box, from its first octet on.
    pub(super) fn rows_of(&self, covering: &Covering) -> &[EightRows] {
        &self.rows[covering.rows..][..covering.octets().len()]
    }

    /// The first column that a sphere may cover, and the one after the last, in rows of its box.
    pub(super) fn ends_of(&self, covering: &Covering, rows: std::ops::Range<usize>) -> &[[u8; 2]] {
        let first = covering.rows * LANES + rows.start - covering.first_octet() * LANES;
        &self.ends[first..first + rows.len()]
    }

    /// The columns of a row in its box that a sphere may cover.
    pub(super) fn outer(&self, covering: &Covering, row: usize) -> u64 {
        self.rows_of(covering)[row / LANES - covering.first_octet()].outer[row % LANES]
    }

    /// Whether a sphere may be visible in a pixel.
    pub(super) fn may_cover(&self, covering: &Covering, column: usize, row: usize) -> bool {
        covering.octets().contains(&(row / LANES)) && self.outer(covering, row) >> column & 1 == 1
    }

    /// Whether a sphere may be visible in a contested pixel.
    pub(super) fn is_contested(&self, covering: &Covering) -> bool {
        let contested = &self.contested[covering.octets()];
        contested
            .iter()
            .zip(self.rows_of(covering))
            .any(|(contested, rows)| {
                let both = contested.iter().zip(rows.outer);
                both.fold(0, |any, (contested, outer)| any | contested & outer) != 0
            })
    }

    /// The contested pixels in which a sphere may be visible, as rows of the tile.
    pub(super) fn contested_by(&self, covering: &Covering) -> [u64; SIDE] {
        let mut both = [0; SIDE];
        let octets = both.as_chunks_mut::<LANES>().0[covering.octets()].iter_mut();
        let contested = &self.contested[covering.octets()];
        for ((both, contested), rows) in octets.zip(contested).zip(self.rows_of(covering)) {
            *both = std::array::from_fn(|line| contested[line] & rows.outer[line]);
        }
        both
    }

    /// Sorts from far to near; of equal spheres the first of the file stays.
    fn sort(&mut self) {
        let spheres = &self.spheres;
        self.keys.clear();
        // Missed spheres are negative, and first; the bits of the others are in their order.
        let key = |(at, covering): (u64, &Covering)| {
            u64::from(covering.upper.max(0.0).to_bits()) << 32 | at
        };
        self.keys.extend((0..).zip(spheres).map(key));
        self.keys.sort_unstable();
        // Equal spheres have equal bounds, so only neighbours with equal bounds are compared.
        let alike = |a: &u64, b: &u64| a >> 32 == b >> 32;
        let place = |key: u64| key as u32 as usize;
        let record = |key: u64| &spheres[place(key)].record;
        if self.keys.windows(2).any(|pair| alike(&pair[0], &pair[1])) {
            for alike in self.keys.chunk_by_mut(alike) {
                alike.sort_unstable_by(|&a, &b| record(a).cmp_spheres(record(b)));
            }
            self.keys
                .dedup_by(|later, first| record(*later).is_equal(record(*first)));
        }
        self.order.clear();
        self.order.extend(self.keys.iter().map(|&key| place(key)));
    }

    /// Whether the intervals of any two spheres overlap.
    fn overlap(&self) -> bool {
        self.order
            .windows(2)
            .any(|pair| self.spheres[pair[0]].upper >= self.spheres[pair[1]].lower)
    }

    /// Computes bounds of the inverse depths in the boxes instead of those of whole spheres, for
    /// spheres with many pixels. Small ones have nearly all of their pixels here.
    fn refine(&mut self, grid: &Grid, tile: &Tile) {
        let large = |&at: &usize| self.spheres[at].record.area() >= REFINED;
        let places: Vec<usize> = (0..self.spheres.len()).filter(large).collect();
        for places in places.chunks(LANES) {
            let last = places.len() - 1;
            let of = |lane: usize| &self.spheres[places[lane.min(last)]];
            let eight = EightRecords::new(&std::array::from_fn(|lane| of(lane).record));
            let depths = Depths::new(grid, &tile.rectangles(&eight), &eight.spheres);
            let lower = std::array::from_fn(|lane| of(lane).lower);
            let upper = std::array::from_fn(|lane| of(lane).upper);
            let ranges = depths.ranges(lower, upper);
            for (lane, &at) in places.iter().enumerate() {
                let covering = &mut self.spheres[at];
                (covering.lower, covering.upper) = (ranges.lower[lane], ranges.upper[lane]);
            }
        }
    }

    /// Drops the spheres behind one that covers the whole tile.
    fn drop_hidden(&mut self, tile: &Tile) {
        let full = u64::MAX >> (SIDE - tile.width);
        let covers = |covering: &Covering| {
            let rows = self.rows_of(covering);
            let first = covering.first_octet();
            tile.is_all_of(&covering.record)
                && (tile.first..tile.last)
                    .all(|row| rows[row / LANES - first].inner[row % LANES] == full)
        };
        let spheres = &self.spheres;
        let Some(at) = self.order.iter().rposition(|&at| covers(&spheres[at])) else {
            self.closed = false;
            return;
        };
        let lower = spheres[self.order[at]].lower;
        let hidden = self.order.partition_point(|&at| spheres[at].upper < lower);
        self.closed = hidden >= at;
        self.order.drain(..hidden.min(at));
    }

    fn contest(&mut self) {
        self.contested = [[0; LANES]; OCTETS];
        let mut any = 0;
        for (place, &at) in self.order.iter().enumerate() {
            let near = &self.spheres[at];
            let octets = near.octets();
            self.overlap[octets.clone()].fill([0; LANES]);
            for &far in self.order[..place].iter().rev() {
                let far = &self.spheres[far];
                if far.upper < near.lower {
                    break;
                }
                if far.record.is_apart(&near.record) {
                    continue;
                }
                let both = octets.start.max(far.first_octet())..octets.end.min(far.octets().end);
                let rows = &self.rows[far.rows + both.start - far.first_octet()..];
                for (overlap, rows) in self.overlap[both].iter_mut().zip(rows) {
                    for (all, outer) in overlap.iter_mut().zip(rows.outer) {
                        *all |= outer;
                    }
                }
            }
            let rows = &self.rows[near.rows..];
            for (octet, rows) in octets.zip(rows) {
                let (contested, overlap) = (&mut self.contested[octet], &self.overlap[octet]);
                for lane in 0..LANES {
                    let (inner, outer) = (rows.inner[lane], rows.outer[lane]);
                    contested[lane] = contested[lane] & !inner | outer & (!inner | overlap[lane]);
                    any |= contested[lane];
                }
            }
        }
        self.any_contested = any != 0;
    }
}
