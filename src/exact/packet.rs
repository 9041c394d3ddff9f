//! Packets: eight pixels of a row are intersected with one sphere after another. Each inverse
//! depth is an interval.
//!
//! ```text
//! upper = b + sqrt d             NaN: certainly missed
//! lower = upper - spread         where d > d_sure; else not certainly hit
//! ```
//!
//! For each pixel it is enough to keep two spheres' bounds: those of the leader, which of the
//! spheres that are certainly hit has the greatest `upper`, and the greatest `upper` of all
//! others, its rivals. The leader is visible if its `lower` is above that. The background leads
//! with 0, and hits behind the camera are negative. A comparison with NaN is false, so a miss
//! changes nothing and an uncertain hit never leads. Undecided pixels go to
//! [`decide`](super::decide).
//!
//! Instead of the leader's `lower`, the width `upper - lower` is kept, rounded up to a power of
//! two: its exponent is the fourth byte of the colour.

use std::ops::Range;

use bytemuck::Pod;
use wide::{f32x8, f64x8, u32x8};

use super::{
    bins::{EightBoxes, EightRecords, Record},
    bounds::{SURFACE_BOUND, UNDERFLOW_BOUND},
    depths::FloatDepths,
    grid::{Grid, SIDE, STEPS, float_above, float_below, splat},
    kernels::{dot, in_column, in_row, on_the_surface, squared_ray},
    paint::colour_lane,
    sight::{Rays, Sights, Targets},
    tuning::Bounds,
};
use crate::spheres::{LANES, double};

#[cfg(test)]
mod tests;

/// The leaders and rivals of the pixels of a row. A packet may begin anywhere in it, so there is
/// room for one that begins at the last pixel. Most begin at a multiple of eight pixels: there a
/// store takes half of the time or less.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(super) struct PixelRow {
    /// The `upper` of the leader.
    upper: [f32; SIDE + LANES],
    /// The greatest `upper` of all but the leader.
    rival: [f32; SIDE + LANES],
    /// The leader's colour, and the exponent of the width of its interval.
    colour: [u32; SIDE + LANES],
}

/// The packet that begins at a pixel of a row.
#[inline(always)]
fn packet<T: Copy, P: From<[T; LANES]>>(of: &[T; SIDE + LANES], first: usize) -> P {
    let first = first % SIDE;
    P::from(std::array::from_fn(|lane| of[first + lane]))
}

/// Replaces the pixels of a packet whose lanes are set.
#[inline(always)]
fn put_where<T: Pod, P: Pod>(of: &mut [T; SIDE + LANES], first: usize, lanes: f32x8, new: P) {
    let old: [T; LANES] = packet(of, first);
    // The compiler makes masked stores of selections. With AVX-512 these are fast, but those of
    // AVX2 are microcode on many CPUs.
    let merged: [T; LANES] = if cfg!(target_feature = "avx512vl") {
        let [new, old]: [f32x8; 2] = [bytemuck::cast(new), bytemuck::cast(old)];
        bytemuck::cast(lanes.select(new, old))
    } else {
        let lanes: u32x8 = bytemuck::cast(lanes);
        let [new, old]: [u32x8; 2] = [bytemuck::cast(new), bytemuck::cast(old)];
        bytemuck::cast(new & lanes | old & !lanes)
    };
    let first = first % SIDE;
    of[first..first + LANES].copy_from_slice(&merged);
}

/// The exponents of powers of two above some widths, none of which is negative, as the fourth
/// bytes of colours. Above the greatest float the power is infinity.
#[inline(always)]
fn exponents(widths: f32x8) -> u32x8 {
    let bits: u32x8 = bytemuck::cast(widths);
    let exponents = ((bits >> 23_u32) + u32x8::splat(1)).min(u32x8::splat(0xff)) << 24_u32;
    u32x8::new(exponents.to_array().map(u32::to_le))
}

/// The widths whose exponents are in these colours.
#[inline(always)]
fn widths(colours: u32x8) -> f32x8 {
    let colours = u32x8::new(colours.to_array().map(u32::from_le));
    bytemuck::cast((colours >> 24_u32) << 23_u32)
}

/// The terms of a sphere in the columns of a packet, which leave polynomials of the row,
///
/// ```text
/// d = (d2 q + d1) q + d0     b = b1 q + b0
/// ```
#[derive(Clone, Copy, Debug)]
struct Terms {
    d: [f32x8; 3],
    b: [f32x8; 2],
    d_sure: f32x8,
    /// With the exponent of the spread.
    colour: u32x8,
}

impl Terms {
    /// The terms of the columns `p` from the middle of the rectangle.
    #[inline(always)]
    fn new(depths: &FloatDepths, lane: usize, p: f32x8, colour: u32) -> Self {
        let splat = |of: &[f32; LANES]| f32x8::splat(of[lane]);
        let (d, b) = in_column(
            depths.d.each_ref().map(splat),
            depths.b.each_ref().map(splat),
            p,
        );
        Self {
            d,
            b,
            d_sure: splat(&depths.d_sure),
            colour: u32x8::splat(colour),
        }
    }
}

/// `a > b`, as lanes.
#[inline(always)]
fn greater(a: f32x8, b: f32x8) -> f32x8 {
    // With AVX-512 lanes are bits, and this is one instruction. `simd_gt` makes three.
    if cfg!(target_feature = "avx512vl") {
        let (a, b) = (a.to_array(), b.to_array());
        let lane = |lane: usize| if a[lane] > b[lane] { u32::MAX } else { 0 };
        bytemuck::cast(std::array::from_fn::<u32, LANES, _>(lane))
    } else {
        a.simd_gt(b)
    }
}

impl PixelRow {
    /// Pixels that hold only the background, given by its colour lane.
    pub(super) fn new(background: u32) -> Self {
        Self {
            upper: [0.0; SIDE + LANES],
            rival: [f32::NEG_INFINITY; SIDE + LANES],
            colour: [background; SIDE + LANES],
        }
    }

    /// Resets the pixels, like [`new`](Self::new).
    pub(super) fn clear(&mut self, background: u32) {
        self.upper.fill(0.0);
        self.rival.fill(f32::NEG_INFINITY);
        self.colour.fill(background);
    }

    /// Meets a sphere in the packet at `first`, `q` rows from the middle of its rectangle.
    #[inline(always)]
    fn meet<const PROVEN: bool>(&mut self, terms: &Terms, first: usize, q: f32x8) {
        let [d, b] = in_row(terms.d, terms.b, q);
        let upper = b + d.sqrt();
        let leader: f32x8 = packet(&self.upper, first);
        let leads = greater(upper, leader);
        if PROVEN {
            self.update(first, upper, leads & greater(d, terms.d_sure), terms.colour);
        } else {
            self.lead(first, upper, leads, terms.colour);
        }
    }

    /// Adds the bounds of a sphere; it leads where `leads` is set.
    #[inline(always)]
    fn update(&mut self, first: usize, upper: f32x8, leads: f32x8, colour: u32x8) {
        let rival: f32x8 = packet(&self.rival, first);
        let loser = leads.select(packet(&self.upper, first), upper);
        put_where(&mut self.rival, first, greater(loser, rival), loser);
        self.lead(first, upper, leads, colour);
    }

    #[inline(always)]
    fn lead(&mut self, first: usize, upper: f32x8, leads: f32x8, colour: u32x8) {
        put_where(&mut self.upper, first, leads, upper);
        put_where(&mut self.colour, first, leads, colour);
    }

    /// An inverse depth behind which no sphere is visible in eight pixels; never NaN.
    #[inline(always)]
    pub(super) fn lower(&self, first: usize) -> f32x8 {
        let lower = packet::<_, f32x8>(&self.upper, first) - widths(self.colours(first));
        // Infinity minus infinity is NaN and gives no bound.
        let number = lower.simd_eq(lower);
        number.select(lower, f32x8::splat(f32::NEG_INFINITY))
    }

    /// A mask of the pixels of a packet that intervals leave undecided.
    #[inline(always)]
    pub(super) fn undecided_lanes(&self, first: usize) -> u32 {
        let rival: f32x8 = packet(&self.rival, first);
        !self.lower(first).simd_gt(rival).to_bitmask() & 0xff
    }

    /// The leaders' colour lanes.
    #[inline(always)]
    pub(super) fn colours(&self, first: usize) -> u32x8 {
        packet(&self.colour, first)
    }
}

/// Eight spheres to meet: their inverse depths, colours and boxes.
#[derive(Debug)]
pub(super) struct Meetings<'a> {
    pub(super) depths: &'a FloatDepths,
    packets: EightBoxes,
    /// With the exponents of the spreads.
    colours: [u32; LANES],
}

impl<'a> Meetings<'a> {
    #[inline]
    pub(super) fn new(depths: &'a FloatDepths, records: &EightRecords) -> Self {
        let widths = exponents(f32x8::new(depths.spread));
        Self {
            depths,
            packets: records.boxes.packets(),
            colours: (records.colours | widths).to_array(),
        }
    }

    /// The first and the last column and row of the packets of a sphere.
    pub(super) fn packets(&self, lane: usize) -> [usize; 4] {
        self.packets.sides(lane)
    }

    /// Meets a sphere in all packets of its box. Returns the number of packets.
    #[inline(always)]
    pub(super) fn whole<const PROVEN: bool>(&self, lane: usize, rows: &mut [PixelRow]) -> u64 {
        let [left, right, top, bottom] = self.packets(lane);
        self.part::<PROVEN>(lane, rows, (left, right + 1), (top, bottom + 1))
    }

    /// Meets a sphere in some of its packets: those of columns `from..to`, in rows `top..bottom`.
    /// Returns the number of packets.
    #[inline(always)]
    pub(super) fn part<const PROVEN: bool>(
        &self,
        lane: usize,
        rows: &mut [PixelRow],
        (from, to): (usize, usize),
        (top, bottom): (usize, usize),
    ) -> u64 {
        let [left, _, first_row, _] = self.packets(lane);
        let mut first = from;
        while first < to {
            let terms = self.terms(lane, first - left);
            let mut q = f32x8::splat((top - first_row) as f32 + self.depths.q[lane]);
            for row in &mut rows[top..bottom] {
                row.meet::<PROVEN>(&terms, first, q);
                q += f32x8::splat(1.0);
            }
            first += LANES;
        }
        ((to - from) / LANES * (bottom - top)) as u64
    }

    /// The terms of the packet that begins `right` columns from the first one.
    #[inline(always)]
    fn terms(&self, lane: usize, right: usize) -> Terms {
        let p = f32x8::splat(right as f32 + self.depths.p[lane]);
        let p = f32x8::new(STEPS) + p;
        Terms::new(self.depths, lane, p, self.colours[lane])
    }

    /// Meets a sphere in those pixels of its box that have a bit in `wanted`, and perhaps in
    /// pixels beside them. Returns the number of packets.
    pub(super) fn masked<const PROVEN: bool>(
        &self,
        lane: usize,
        rows: &mut [PixelRow],
        wanted: &[u64; SIDE],
    ) -> u64 {
        let [left, right, top, bottom] = self.packets(lane);
        let wanted = &wanted[top..bottom + 1];
        let columns = wanted.iter().fold(0, |columns, row| columns | row);
        let mut met = 0;
        for first in (left..right + 1).step_by(LANES) {
            let bits = 0xff << first;
            if columns & bits == 0 {
                continue;
            }
            let terms = self.terms(lane, first - left);
            let rows = rows[top..].iter_mut().zip(wanted).enumerate();
            for (down, (pixels, wanted)) in rows {
                if wanted & bits != 0 {
                    let q = f32x8::splat(down as f32 + self.depths.q[lane]);
                    pixels.meet::<PROVEN>(&terms, first, q);
                    met += 1;
                }
            }
        }
        met
    }
}

/// A sphere that has no polynomials in floats, in a tile. Its inverse depths are beyond floats, and it is
/// met in doubles; or the camera is on its surface, and it is met by [`Surface`] where floats will do.
pub(super) struct InDoubles<'a> {
    grid: &'a Grid,
    bounds: Bounds,
    /// The tile's first column and row.
    corner: (u32, u32),
    record: &'a Record,
}

impl<'a> InDoubles<'a> {
    pub(super) fn new(
        grid: &'a Grid,
        bounds: Bounds,
        corner: (u32, u32),
        record: &'a Record,
    ) -> Self {
        Self {
            grid,
            bounds,
            corner,
            record,
        }
    }

    /// Meets the sphere in those pixels of its box that have a bit in `wanted`, and perhaps in
    /// pixels beside them. Returns the number of packets.
    pub(super) fn meet(&self, rows: &mut [PixelRow], wanted: &[u64; SIDE]) -> u64 {
        if self.bounds == Bounds::Refused {
            let anything = (f32x8::splat(0.0), f32x8::splat(f32::INFINITY));
            return self.meet_each(rows, wanted, |_| move |_| anything);
        }
        let targets = Targets::of(std::iter::once(self.record.sphere));
        if targets.are_touched()
            && let Some(surface) = Surface::new(self.grid, self.record.sphere)
        {
            return self.meet_each(rows, wanted, |column| surface.intervals(column));
        }
        // The factor from inverse depths of a ray through the viewport to those of the grid.
        let scale = splat(self.grid.scale / self.grid.camera().z_double());
        self.meet_each(rows, wanted, |column| {
            let targets = &targets;
            move |row| {
                let rays = Rays::of_row(self.grid.camera(), column, row);
                let sights = Sights::new(&rays, targets);
                interval(sights.lower * scale, sights.upper * scale)
            }
        })
    }

    /// Meets it in packets, each with the bounds of its inverse depths in the eight pixels from a
    /// column and a row of the picture on.
    #[inline(always)]
    fn meet_each<Row: Fn(u32) -> (f32x8, f32x8)>(
        &self,
        rows: &mut [PixelRow],
        wanted: &[u64; SIDE],
        bounds: impl Fn(u32) -> Row,
    ) -> u64 {
        let packets = EightRecords::of(std::slice::from_ref(self.record))
            .boxes
            .packets();
        let [left, right, top, bottom] = packets.sides(0);
        let colour = u32x8::splat(colour_lane(self.record.colour));
        let mut met = 0;
        for first in (left..right + 1).step_by(LANES) {
            let bounds = bounds(self.corner.0 + first as u32);
            for row in top..bottom + 1 {
                if wanted[row] & 0xff << first == 0 {
                    continue;
                }
                let (lower, upper) = bounds(self.corner.1 + row as u32);
                let pixels = &mut rows[row];
                let leader: f32x8 = packet(&pixels.upper, first);
                let leads = greater(upper, leader);
                pixels.update(first, upper, leads, colour | exponents(upper - lower));
                met += 1;
            }
        }
        met
    }
}

/// Floats below and above bounds in doubles.
#[inline(always)]
fn interval(lower: f64x8, upper: f64x8) -> (f32x8, f32x8) {
    (
        f32x8::new(lower.to_array().map(float_below)),
        f32x8::new(upper.to_array().map(float_above)),
    )
}

/// A sphere on whose surface the camera is, in floats.
struct Surface<'a> {
    grid: &'a Grid,
    /// `C/r`
    centre: [f32x8; 3],
    /// The error bound of `B/r`.
    bound: f32x8,
    /// `g/(2 r)`
    half: f32x8,
}

/// The greatest `|V|` for which floats are used, and what `g/(2 r)` may be. A choice, not an error.
const SURFACE_REACH: f64 = 1024.0;
const SURFACE_SCALES: Range<f64> = 1.0 / (1_u64 << 60) as f64..(1_u64 << 60) as f64;

impl<'a> Surface<'a> {
    /// `None` if floats can't be used.
    fn new(grid: &'a Grid, [x, y, z, r]: [f32; 4]) -> Option<Self> {
        let half = 0.5 * grid.scale / double(r);
        if grid.reach > SURFACE_REACH || !SURFACE_SCALES.contains(&half) {
            return None;
        }
        let centre = [x, y, z].map(|length| double(length) / double(r));
        // No ray has a greater `|X|` or `|Y|` than that of the first pixel.
        let first = splat(0.0);
        let corner = [grid.x_axis.x(first), grid.y_axis.y(first)];
        let corner = corner.map(|axis| axis.abs().to_array()[0]);
        let terms = dot(centre.map(f64::abs), corner);
        Some(Self {
            grid,
            centre: centre.map(|length| f32x8::splat(length as f32)),
            bound: f32x8::splat(float_above(SURFACE_BOUND * terms + UNDERFLOW_BOUND)),
            half: f32x8::splat(half as f32),
        })
    }

    /// The bounds in the eight pixels from a column on, by the row.
    ///
    /// ```text
    /// 1/z = A/(2 B)      B > 0; else there is no hit
    /// ```
    ///
    /// Of a hit in doubt they are 0 and infinity. (Theorem 4.)
    #[inline(always)]
    fn intervals(&self, column: u32) -> impl Fn(u32) -> (f32x8, f32x8) {
        let float = |value: f64| value as f32;
        let columns = splat(f64::from(column)) + f64x8::new(STEPS.map(f64::from));
        let x = f32x8::new(self.grid.x_axis.x(columns).to_array().map(float));
        move |row| {
            let y = self.grid.y_axis.y(splat(f64::from(row)));
            let ray = [x, f32x8::new(y.to_array().map(float))];
            let b = dot(self.centre, ray);
            let [lower, upper] = on_the_surface(squared_ray(ray), b, self.bound, self.half);
            let hit = b.simd_gt(self.bound);
            // Minus infinity where B is certainly negative.
            let sign = (b + self.bound) & f32x8::splat(-0.0);
            let in_doubt = sign | f32x8::splat(f32::INFINITY);
            (hit.select(lower, f32x8::ZERO), hit.select(upper, in_doubt))
        }
    }
}
