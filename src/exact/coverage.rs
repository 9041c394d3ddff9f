//! Tiles of few spheres: the columns that each sphere covers in each row, as masks of 64 bits.
//!
//! Spheres are processed from far to near, by the upper bounds of their inverse depths. Where the
//! intervals of two spheres overlap, the side of their radical plane shows which one is nearer in
//! each pixel. Where a sphere certainly covers a pixel and is nearer than all spheres before it, it is
//! visible. Pixels too close to an outline, or to where two spheres change places, are *contested*,
//! which is a mask too.

use std::ops::Range;

use wide::{f64x8, i32x8, u32x8};

use super::{
    bins::{EightRecords, Record, sort_far_to_near},
    depths::{DepthRanges, Depths, Rectangles, SphereDepths},
    grid::{Grid, SIDE},
    outline::{EightRows, Outline, Placement},
    radical::{self, Nearer, NearerColumns, common_sides},
    tuning::Bounds,
};
use crate::spheres::LANES;

#[cfg(test)]
mod tests;

/// Eight rows of a tile.
pub(super) const OCTETS: usize = SIDE / LANES;

/// A bit for each pixel of a tile.
pub(super) type Mask = [[u64; LANES]; OCTETS];

/// A sphere in a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Covering {
    pub(super) record: Record,
    /// The lower bound of the inverse depth of every hit in its box.
    lower: f32,
    /// The index of its first octet among those of all spheres.
    rows: usize,
    /// Whether each row of `outer` is one run, which is in `ends`.
    pub(super) in_runs: bool,
}

impl Covering {
    pub(super) fn first_octet(&self) -> usize {
        self.record.rows().start / LANES
    }

    fn octets(&self) -> Range<usize> {
        self.first_octet()..self.record.rows().end.div_ceil(LANES)
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
        record.rows().end <= self.first || record.rows().start >= self.last
    }

    /// Whether a box is the whole part of the tile that is drawn now.
    pub(super) fn is_all_of(&self, record: &Record) -> bool {
        let (columns, rows) = (record.columns(), record.rows());
        columns.start == 0
            && columns.end >= self.width
            && rows.start <= self.first
            && rows.end >= self.last
    }

    /// Rectangles around the packets of up to eight records. They have at least one more row, so
    /// that every coefficient is bounded.
    #[inline]
    pub(super) fn rectangles(&self, records: &EightRecords) -> Rectangles {
        let [left, right, top, bottom] = records.boxes.packets().all_sides();
        let half = |first: u32x8, end: u32x8| (end - first) >> 1_u32;
        let across = half(left, right + u32x8::splat(1));
        let down = half(top, bottom + u32x8::splat(2));
        let double = |lanes: u32x8| f64x8::from(bytemuck::cast::<_, i32x8>(lanes));
        Rectangles {
            columns: double(left + across) + f64x8::splat(f64::from(self.column)),
            rows: double(top + down) + f64x8::splat(f64::from(self.row)),
            across: double(across),
            down: double(down),
        }
    }

    /// The outlines of up to eight records are around the middle rows of their boxes.
    #[inline]
    fn placement(&self, records: &EightRecords) -> Placement {
        let rectangles = self.rectangles(records);
        Placement {
            rows: rectangles.rows,
            // An octet may extend seven rows beyond the box on either side.
            down: rectangles.down + f64x8::splat(LANES as f64),
            column: self.column,
            row: self.row,
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
    places: Vec<u64>,
    /// The indices of the spheres that are not hidden, from far to near.
    pub(super) order: Vec<usize>,
    /// Whether only one sphere is left in the order, and it covers the whole tile.
    pub(super) is_covered: bool,
    pub(super) contested: Mask,
    pub(super) any_contested: bool,
    /// Those of each sphere, if the intervals of any two overlap.
    depths: Vec<SphereDepths>,
    disputes: Disputes,
}

/// How pairs of spheres are compared.
#[derive(Clone, Copy)]
struct Pairs<'a> {
    grid: &'a Grid,
    bounds: Bounds,
}

/// The pixels of a sphere in which spheres that stand before it in the order are nearer.
#[derive(Debug, Default)]
struct Disputes {
    /// Where one certainly is.
    lost: Mask,
    /// Where one may be.
    undecided: Mask,
    nearer: NearerColumns,
}

impl Disputes {
    fn clear(&mut self, octets: Range<usize>) {
        self.lost[octets.clone()].fill([0; LANES]);
        self.undecided[octets].fill([0; LANES]);
    }

    /// Adds another sphere, by its rows in some octets.
    fn add(&mut self, nearer: Nearer, octets: Range<usize>, rows: &[EightRows]) {
        let constant = match nearer {
            Nearer::First => Some((u64::MAX, 0)),
            Nearer::Second => Some((0, u64::MAX)),
            Nearer::Unknown => Some((0, 0)),
            Nearer::Varies(seam) => {
                seam.columns(&mut self.nearer);
                None
            }
        };
        for (octet, other) in octets.zip(rows) {
            for lane in 0..LANES {
                let row = octet * LANES + lane;
                let of_row = (self.nearer.first[row], self.nearer.second[row]);
                let (first, second) = constant.unwrap_or(of_row);
                let lost = second & other.inner[lane];
                self.lost[octet][lane] |= lost;
                self.undecided[octet][lane] |= other.outer[lane] & !first & !lost;
            }
        }
    }

    /// Takes from eight rows of the sphere what is lost. Returns what is undecided.
    fn take_from(&self, octet: usize, rows: &mut EightRows) -> [u64; LANES] {
        let lost = &self.lost[octet];
        rows.inner = std::array::from_fn(|lane| rows.inner[lane] & !lost[lane]);
        rows.outer = std::array::from_fn(|lane| rows.outer[lane] & !lost[lane]);
        self.undecided[octet]
    }
}

/// Replaces an unknown outline by the box of its sphere, if that is hit in all of it.
#[cold]
fn fill_boxes(
    grid: &Grid,
    rectangles: &Rectangles,
    eight: &EightRecords,
    outlines: &mut [Outline; LANES],
) {
    let depths = Depths::new(grid, rectangles, &eight.spheres);
    let DepthRanges { covered, lower, .. } = depths.ranges();
    for (lane, outline) in outlines.iter_mut().enumerate() {
        if outline.is_unknown() && covered >> lane & 1 == 1 {
            *outline = outline.of_box(lower[lane]);
        }
    }
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
        self.depths.clear();
        if self.overlap() {
            self.find_depths(grid, tile, bounds);
        }
        let pairs = Pairs { grid, bounds };
        self.drop_hidden(tile, pairs);
        self.contest(pairs);
    }

    fn outline(&mut self, grid: &Grid, tile: &Tile, records: &[Record], bounds: Bounds) {
        let eight = EightRecords::of(records);
        let placement = tile.placement(&eight);
        let mut outlines = Outline::eight(grid, &placement, &eight.spheres, bounds);
        if bounds == Bounds::Proven && outlines.iter().any(Outline::is_unknown) {
            fill_boxes(grid, &tile.rectangles(&eight), &eight, &mut outlines);
        }
        for (outline, record) in outlines.iter().zip(records) {
            let covering = Covering {
                record: *record,
                lower: outline.lower,
                rows: self.rows.len(),
                in_runs: true,
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
    pub(super) fn ends_of(&self, covering: &Covering, rows: Range<usize>) -> &[[u8; 2]] {
        let first = covering.rows * LANES + rows.start - covering.first_octet() * LANES;
        &self.ends[first..first + rows.len()]
    }

    /// The columns of a row in its box that a sphere may cover.
    pub(super) fn outer(&self, covering: &Covering, row: usize) -> u64 {
        self.rows_of(covering)[row / LANES - covering.first_octet()].outer[row % LANES]
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
        sort_far_to_near(spheres.len(), |at| &spheres[at].record, &mut self.places);
        self.order.clear();
        let places = self.places.iter();
        self.order.extend(places.map(|&place| place as usize));
    }

    /// Whether the intervals of any two spheres overlap.
    fn overlap(&self) -> bool {
        self.order
            .windows(2)
            .any(|pair| self.spheres[pair[0]].record.upper >= self.spheres[pair[1]].lower)
    }

    fn find_depths(&mut self, grid: &Grid, tile: &Tile, bounds: Bounds) {
        let corner = (tile.column, tile.row);
        for covering in self.spheres.chunks(LANES) {
            let eight = EightRecords::from_fn(covering.len(), |at| covering[at].record);
            let depths = Depths::new(grid, &tile.rectangles(&eight), &eight.spheres);
            let of_sphere = |lane| depths.of_sphere(lane, &eight.spheres, corner, bounds);
            self.depths.extend((0..covering.len()).map(of_sphere));
        }
    }

    /// Drops the spheres behind one that covers the whole tile.
    fn drop_hidden(&mut self, tile: &Tile, pairs: Pairs<'_>) {
        let covering = |at: &&usize| self.covers(&self.spheres[**at], tile);
        let in_front = |front: usize, &at: &usize| {
            if matches!(self.nearer(pairs, front, at), Nearer::Second) {
                at
            } else {
                front
            }
        };
        let mut covering = self.order.iter().rev().filter(covering);
        let Some(&nearest) = covering.next() else {
            self.is_covered = false;
            return;
        };
        let front = covering.fold(nearest, in_front);
        let mut order = std::mem::take(&mut self.order);
        order.retain(|&at| at == front || !matches!(self.nearer(pairs, front, at), Nearer::First));
        self.is_covered = order.len() == 1;
        self.order = order;
    }

    /// Whether a sphere covers the whole tile.
    fn covers(&self, covering: &Covering, tile: &Tile) -> bool {
        let full = u64::MAX >> (SIDE - tile.width);
        let drawn = tile.first..tile.last;
        let is_full = |(octet, rows): (usize, &EightRows)| {
            (0..LANES).fold(true, |all, lane| {
                all & (rows.inner[lane] == full || !drawn.contains(&(octet * LANES + lane)))
            })
        };
        tile.is_all_of(&covering.record)
            && covering.octets().zip(self.rows_of(covering)).all(is_full)
    }

    /// Which of two spheres is nearer where both are hit; the first one if that is nowhere.
    fn nearer(&self, pairs: Pairs<'_>, first: usize, second: usize) -> Nearer {
        let (near, far) = (&self.spheres[first], &self.spheres[second]);
        if far.record.upper < near.lower {
            return Nearer::First;
        }
        let Some(region) = common_sides(&near.record, &far.record) else {
            return Nearer::First;
        };
        match (self.depths.get(first), self.depths.get(second)) {
            (Some(near), Some(far)) => {
                radical::compare(pairs.grid, pairs.bounds, region, near, far)
            }
            _ => Nearer::Unknown,
        }
    }

    /// Finds the contested pixels, and takes from every sphere the pixels in which one that
    /// stands before it in the order is nearer.
    fn contest(&mut self, pairs: Pairs<'_>) {
        self.contested = [[0; LANES]; OCTETS];
        let mut any = 0;
        for place in 0..self.order.len() {
            let disputed = self.dispute(pairs, place);
            let near = &mut self.spheres[self.order[place]];
            near.in_runs = !disputed;
            let rows = &mut self.rows[near.rows..];
            for (octet, rows) in near.octets().zip(rows) {
                let undecided = if disputed {
                    self.disputes.take_from(octet, rows)
                } else {
                    [0; LANES]
                };
                let lanes = self.contested[octet].iter_mut().zip(undecided);
                let lanes = lanes.zip(rows.inner).zip(rows.outer);
                for (((contested, undecided), inner), outer) in lanes {
                    *contested = (*contested | outer) & !(inner & !undecided);
                    any |= *contested;
                }
            }
        }
        self.any_contested = any != 0;
    }

    /// Compares a sphere with those before it in the order whose intervals of inverse depth
    /// overlap its own. Returns whether one of them may be nearer anywhere.
    fn dispute(&mut self, pairs: Pairs<'_>, place: usize) -> bool {
        let at = self.order[place];
        let mut disputed = false;
        for before in (0..place).rev() {
            let other = self.order[before];
            let (near, far) = (&self.spheres[at], &self.spheres[other]);
            if far.record.upper < near.lower {
                break;
            }
            let nearer = self.nearer(pairs, at, other);
            if matches!(nearer, Nearer::First) {
                continue;
            }
            if !disputed {
                disputed = true;
                self.disputes.clear(near.octets());
            }
            let (of_near, of_far) = (near.octets(), far.octets());
            let both = of_near.start.max(of_far.start)..of_near.end.min(of_far.end);
            let rows = &self.rows[far.rows + both.start - of_far.start..];
            self.disputes.add(nearer, both, rows);
        }
        disputed
    }
}
