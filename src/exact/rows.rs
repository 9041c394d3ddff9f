//! Bands without contested pixels are painted in whole rows, from far to near.
//!
//! If there are no small spheres, and the inverse depths of spheres whose boxes overlap do not
//! overlap, a row is determined by the spans of its spheres. That costs one run for each row and
//! sphere instead of one for each row, sphere and tile.

use wide::f64x8;

use super::{
    bins::{FEW_SPHERES, Large, are_apart},
    grid::{EightSpheres, Grid, SIDE},
    outline::{Outline, Placement},
    paint::Pattern,
    tuning::Bounds,
};
use crate::{camera::BYTES_PER_PIXEL, spheres::LANES};

/// With more columns than this, the number of a column may not be exact in a float.
pub(super) const MAX_COLUMNS: u32 = 1 << 20;

/// The rows of a band that are drawn now: the first row of its tiles, and rows from there.
#[derive(Clone, Copy, Debug)]
pub(super) struct BandRows {
    pub(super) origin: u32,
    pub(super) first: usize,
    pub(super) last: usize,
}

/// The outlines of a band, whose tiles begin at a row, are around the middle row of the tiles.
fn placement(origin: u32) -> Placement {
    let half = (SIDE / 2) as f64;
    Placement {
        rows: f64x8::splat(f64::from(origin) + half),
        down: f64x8::splat(half + LANES as f64),
        column: 0,
        row: origin,
    }
}

/// The outlines of the spheres of a band, nearest first, if no pixel in it is contested.
pub(super) fn undisputed(grid: &Grid, rows: BandRows, large: &[&Large]) -> Option<Vec<Outline>> {
    if large.len() > FEW_SPHERES || grid.camera().size().width() > MAX_COLUMNS {
        return None;
    }
    let placement = placement(rows.origin);
    let mut outlines = Vec::with_capacity(large.len().next_multiple_of(LANES));
    for eight in large.chunks(LANES) {
        let spheres = EightSpheres::of(eight.iter().map(|large| large.sphere));
        let outlines_of_eight = Outline::eight(grid, &placement, &spheres, Bounds::Proven);
        outlines.extend_from_slice(&outlines_of_eight[..eight.len()]);
    }
    let before_all_behind = |(at, near): (usize, &Outline)| {
        near.has_spans()
            && large[at + 1..]
                .iter()
                .all(|far| near.lower > far.upper || are_apart(far.sides, large[at].sides))
    };
    let clear = outlines.iter().enumerate().all(before_all_behind);
    clear.then_some(outlines)
}

/// Paints a sphere in the rows of a band, and collects the pixels that are too close to its
/// outline, as columns and rows of the picture.
pub(super) fn paint(
    outline: &Outline,
    large: &Large,
    rows: BandRows,
    bytes: &mut [u8],
    row_bytes: usize,
    doubtful: &mut Vec<(u32, u32)>,
) {
    let BandRows {
        origin,
        first,
        last,
    } = rows;
    let width = row_bytes / BYTES_PER_PIXEL;
    let pattern = Pattern::new(large.colour);
    let [_, _, top, bottom] = large.sides;
    let top = (top.saturating_sub(origin) as usize).max(first);
    let bottom = ((bottom - origin) as usize).min(last - 1);
    for octet in top / LANES..bottom / LANES + 1 {
        let [inner, outer] = outline.spans(octet * LANES, width);
        for lane in 0..LANES {
            let row = octet * LANES + lane;
            let (inner, outer) = (&inner[lane], &outer[lane]);
            if outer.is_empty() || row < top || row > bottom {
                continue;
            }
            let line = &mut bytes[(row - first) * row_bytes..][..row_bytes];
            pattern.paint(line, outer.start, outer.end);
            if inner != outer {
                let columns = outer.clone().filter(|column| !inner.contains(column));
                doubtful.extend(columns.map(|column| (column as u32, origin + row as u32)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{SIDE, placement};

    /// `|q| <= 40` is what theorem 8 says.
    #[test]
    fn every_row_of_a_band_is_within_its_placement() {
        for origin in [0, 64, 1 << 20, u32::MAX - 63] {
            let placement = placement(origin);
            let of = |lanes: wide::f64x8| lanes.to_array()[0];
            assert_eq!((placement.column, placement.row), (0, origin));
            let down = of(placement.down);
            assert!(down <= 40.0);
            for row in 0..SIDE as u32 {
                let q = f64::from(origin) + f64::from(row) - of(placement.rows);
                assert!(q.abs() <= down, "row {row}: {q}");
            }
        }
    }
}
