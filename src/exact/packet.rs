//! Packets: eight pixels of a row against one sphere after another, each inverse depth
//! an interval.
//!
//! ```text
//! upper = b + sqrt d                          NaN: surely missed
//! lower = b - spread + sqrt(d - d_spread)     NaN: not surely hit
//! ```
//!
//! Per pixel it is enough to keep the leader, the sphere of the greatest `lower`,
//! and the greatest `upper` among its rivals: the leader is seen if its `lower` is
//! above that. The background leads with 0, and what lies behind the camera is
//! negative. A comparison with NaN is false, so a miss changes nothing and a
//! doubtful hit never leads. What is left open goes to [`decide`](super::decide).

use wide::{f32x8, f64x8};

use super::{
    Bounds,
    bins::Record,
    bounds::U,
    depths::FloatDepths,
    grid::{Grid, float_above, float_below},
    paint::put_eight,
    sight::{Rays, Sights, Targets},
};
use crate::{camera::BYTES_PER_PIXEL, spheres::LANES};

#[cfg(test)]
mod tests;

/// Pixels of a row of the largest tile.
pub(super) const SIDE: usize = 64;

/// What is known of the pixels of a row. A packet may begin anywhere in it, so
/// there is room for one that begins at the last pixel.
#[derive(Clone, Debug)]
pub(super) struct PixelRow {
    lower: [f32; SIDE + LANES],
    upper: [f32; SIDE + LANES],
    /// The greatest `upper` of all but the leader.
    rival: [f32; SIDE + LANES],
    /// The leader's colour, in the bits.
    colour: [f32; SIDE + LANES],
}

/// The packet that begins at a pixel of a row.
#[inline(always)]
fn packet(of: &[f32; SIDE + LANES], first: usize) -> f32x8 {
    let first = first % SIDE;
    f32x8::new(std::array::from_fn(|lane| of[first + lane]))
}

#[inline(always)]
fn put(of: &mut [f32; SIDE + LANES], first: usize, lanes: f32x8) {
    let first = first % SIDE;
    of[first..first + LANES].copy_from_slice(lanes.as_array());
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
    /// [`FloatDepths::clear`] and `clear_spread` if `CLEAR`, else `d_spread` and `spread`.
    d_spread: f32x8,
    spread: f32x8,
    colour: f32x8,
}

impl Terms {
    /// Of columns `p` from the middle of the rectangle.
    #[inline(always)]
    fn new<const CLEAR: bool>(depths: &FloatDepths, lane: usize, p: f32x8, colour: f32) -> Self {
        let splat = |of: &[f32; LANES]| f32x8::splat(of[lane]);
        let (d_spread, spread) = if CLEAR {
            (&depths.clear, &depths.clear_spread)
        } else {
            (&depths.d_spread, &depths.spread)
        };
        let quadratic = splat(&depths.d20).mul_add(p, splat(&depths.d10));
        Self {
            d0: quadratic.mul_add(p, splat(&depths.d00)),
            d1: splat(&depths.d11).mul_add(p, splat(&depths.d01)),
            d2: splat(&depths.d02),
            b0: splat(&depths.b10).mul_add(p, splat(&depths.b00)),
            b1: splat(&depths.b01),
            d_spread: splat(d_spread),
            spread: splat(spread),
            colour: f32x8::splat(colour),
        }
    }
}

impl PixelRow {
    /// Only the background is known, by its colour lane.
    pub(super) fn new(background: f32) -> Self {
        Self {
            lower: [0.0; SIDE + LANES],
            upper: [f32::NEG_INFINITY; SIDE + LANES],
            rival: [f32::NEG_INFINITY; SIDE + LANES],
            colour: [background; SIDE + LANES],
        }
    }

    /// As [`new`](Self::new).
    pub(super) fn clear(&mut self, background: f32) {
        self.lower.fill(0.0);
        self.upper.fill(f32::NEG_INFINITY);
        self.rival.fill(f32::NEG_INFINITY);
        self.colour.fill(background);
    }

    /// Meets a sphere in the packet at `first`, `q` rows from the middle of its rectangle.
    #[inline(always)]
    fn meet<const PROVEN: bool, const CLEAR: bool>(
        &mut self,
        terms: &Terms,
        first: usize,
        q: f32x8,
    ) {
        let d = terms.d2.mul_add(q, terms.d1).mul_add(q, terms.d0);
        let b = terms.b1.mul_add(q, terms.b0);
        let upper = b + d.sqrt();
        if !PROVEN {
            let leader = packet(&self.lower, first);
            let leads = upper.simd_gt(leader);
            let colour = packet(&self.colour, first);
            put(&mut self.lower, first, leads.select(upper, leader));
            put(&mut self.colour, first, leads.select(terms.colour, colour));
            return;
        }
        let leader = packet(&self.lower, first);
        if CLEAR {
            let lower = upper - terms.spread;
            let leads = lower.simd_gt(leader) & d.simd_gt(terms.d_spread);
            self.update(first, lower, upper, leads, terms.colour);
        } else {
            let lower = (b - terms.spread) + (d - terms.d_spread).sqrt();
            self.update(first, lower, upper, lower.simd_gt(leader), terms.colour);
        }
    }

    /// Takes a sphere's bounds in; it leads where `leads` is set.
    #[inline(always)]
    fn update(&mut self, first: usize, lower: f32x8, upper: f32x8, leads: f32x8, colour: f32x8) {
        let leader_upper = packet(&self.upper, first);
        let rival = packet(&self.rival, first);
        let loser = leads.select(leader_upper, upper);
        let rival = loser.simd_gt(rival).select(loser, rival);
        put(&mut self.rival, first, rival);
        put(&mut self.upper, first, leads.select(upper, leader_upper));
        let leader = packet(&self.lower, first);
        put(&mut self.lower, first, leads.select(lower, leader));
        let old = packet(&self.colour, first);
        put(&mut self.colour, first, leads.select(colour, old));
    }

    /// The lanes of a packet that no interval settles.
    #[inline(always)]
    pub(super) fn open(&self, first: usize) -> u32 {
        let (lower, rival) = (packet(&self.lower, first), packet(&self.rival, first));
        !lower.simd_gt(rival).to_bitmask() & 0xff
    }

    /// The pixels that no interval settles, of `width` pixels.
    #[inline]
    pub(super) fn all_open(&self, width: usize) -> u64 {
        let packets = (0..SIDE).step_by(LANES);
        let open = packets.fold(0, |open, first| open | u64::from(self.open(first)) << first);
        open & u64::MAX >> (SIDE - width)
    }

    /// Writes the colours of the first pixels of the row to all of `line`.
    #[inline]
    pub(super) fn put(&self, line: &mut [u8]) {
        let mut rest = line;
        for first in (0..SIDE).step_by(LANES) {
            put_eight(rest, self.colours(first));
            let Some((_, more)) = rest.split_at_mut_checked(LANES * BYTES_PER_PIXEL) else {
                return;
            };
            rest = more;
        }
    }

    /// The leaders' colour lanes.
    #[inline(always)]
    pub(super) fn colours(&self, first: usize) -> f32x8 {
        packet(&self.colour, first)
    }

    /// The least `lower` of eight pixels.
    pub(super) fn floor(&self, first: usize) -> f32x8 {
        packet(&self.lower, first)
    }
}

/// A sphere to be met: a lane of [`FloatDepths`], its colour lane, and its box.
pub(super) struct Meeting<'a> {
    pub(super) depths: &'a FloatDepths,
    pub(super) lane: usize,
    pub(super) colour: f32,
    pub(super) record: &'a Record,
}

impl Meeting<'_> {
    /// Meets a sphere of at most eight columns in one packet a row, wherever its box
    /// begins: what is met beside it is a miss. Returns in how many packets.
    #[inline(always)]
    pub(super) fn narrow<const PROVEN: bool>(&self, rows: &mut [PixelRow]) -> u64 {
        let [left, _, top, bottom] = self.record.sides().map(usize::from);
        self.column::<PROVEN>(rows, left, (top, bottom + 1));
        (bottom + 1 - top) as u64
    }

    /// Meets a sphere in the packets that begin at column `first` of its rows `top..bottom`.
    #[inline(always)]
    fn column<const PROVEN: bool>(
        &self,
        rows: &mut [PixelRow],
        first: usize,
        (top, bottom): (usize, usize),
    ) {
        let &Self {
            depths,
            lane,
            colour,
            record,
        } = self;
        let [left, _, box_top, _] = record.sides().map(usize::from);
        let p = f32x8::splat((first - left) as f32 + depths.p[lane]);
        let terms = Terms::new::<true>(depths, lane, f32x8::new(STEPS) + p, colour);
        let mut q = f32x8::splat((top - box_top) as f32 + depths.q[lane]);
        for row in &mut rows[top..bottom] {
            row.meet::<PROVEN, true>(&terms, first, q);
            q += f32x8::splat(1.0);
        }
    }

    /// Meets a sphere in columns `from..to` of its rows `top..bottom`, and perhaps beside
    /// them. Returns in how many packets.
    pub(super) fn wide<const PROVEN: bool>(
        &self,
        rows: &mut [PixelRow],
        (from, to): (usize, usize),
        (top, bottom): (usize, usize),
    ) -> u64 {
        let mut met = 0;
        for first in (from..to).step_by(LANES) {
            self.column::<PROVEN>(rows, first, (top, bottom));
            met += (bottom - top) as u64;
        }
        met
    }

    /// Meets a sphere in those columns of each row that have a bit in `wanted`, and perhaps
    /// beside them.
    pub(super) fn masked<const PROVEN: bool>(
        &self,
        rows: &mut [PixelRow],
        wanted: impl Fn(usize) -> u64,
    ) -> u64 {
        let &Self {
            depths,
            lane,
            colour,
            record,
        } = self;
        let [left, right, top, bottom] = record.sides().map(usize::from);
        let mut met = 0;
        for first in (left..right + 1).step_by(LANES) {
            let p = f32x8::splat((first - left) as f32 + depths.p[lane]);
            let terms = Terms::new::<false>(depths, lane, f32x8::new(STEPS) + p, colour);
            let bits = 0xff << first;
            for (row, pixels) in (top..).zip(&mut rows[top..bottom + 1]) {
                if wanted(row) & bits == 0 {
                    continue;
                }
                let q = f32x8::splat((row - top) as f32 + depths.q[lane]);
                pixels.meet::<PROVEN, false>(&terms, first, q);
                met += 1;
            }
        }
        met
    }

    /// As [`masked`](Self::masked), in doubles, a sphere whose depths floats can't hold, in
    /// the tile at `(column, row)`.
    #[cold]
    pub(super) fn in_doubles(
        &self,
        rows: &mut [PixelRow],
        grid: &Grid,
        (column, row): (u32, u32),
        bounds: Bounds,
        wanted: impl Fn(usize) -> u64,
    ) -> u64 {
        let [left, right, top, bottom] = self.record.sides();
        let targets = Targets::<f64x8>::of(std::iter::once(self.record.sphere));
        let colour = f32x8::splat(self.colour);
        let scale = grid.scale / grid.camera().z_double();
        let mut met = 0;
        for line in top..=bottom {
            for first in (left..=right).step_by(LANES) {
                if wanted(usize::from(line)) & 0xff << first == 0 {
                    continue;
                }
                let at = (column + u32::from(first), row + u32::from(line));
                let rays = Rays::<f64x8>::of_row(grid.camera(), at.0, at.1);
                let sights = Sights::new(&rays, &targets);
                let below = |lower: f64| float_below(lower * scale * (1.0 - 4.0 * U));
                let above = |upper: f64| float_above(upper * scale * (1.0 + 4.0 * U));
                let (mut lower, mut upper) = (
                    f32x8::new(sights.lower.to_array().map(below)),
                    f32x8::new(sights.upper.to_array().map(above)),
                );
                if bounds == Bounds::Refused {
                    (lower, upper) = (f32x8::splat(0.0), f32x8::splat(f32::INFINITY));
                }
                let pixels = &mut rows[usize::from(line)];
                let leads = lower.simd_gt(packet(&pixels.lower, usize::from(first)));
                pixels.update(usize::from(first), lower, upper, leads, colour);
                met += 1;
            }
        }
        met
    }
}

const STEPS: [f32; LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
