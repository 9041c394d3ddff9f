//! The outline of a sphere in a tile, row by row, as masks of the columns it covers.
//!
//! In a row, `D` is a quadratic of `X` with the roots
//!
//! ```text
//! X = (Cx m -+ sqrt(c E))/k       k = Cy^2 + Cz^2 - r^2     c = Cx^2 + k
//! m = Cy Y + Cz       E = r^2 (Y^2 + 1) - N^2       N = Cy - Cz Y
//! ```
//!
//! For `k > 0` and `c > 0` the sphere is seen between them in rows with `m > 0` and
//! `E >= 0`, and in no other row. For `k < 0` and `c >= 0` it is seen in every row, from
//! the greater root on if `Cx > 0` and up to the smaller one if `Cx < 0`. (Theorem 2.)
//!
//! In pixels, with `q` rows from the middle of the sphere's box,
//!
//! ```text
//! x = m0 + m1 q -+ sqrt(e0 + e1 q + e2 q^2)
//! ```

use std::ops::Range;

use wide::{f32x8, f64x8, i32x8, u64x8};

use super::{
    bins::Record,
    bounds::{
        CANCELLATION_LIMIT, COEFFICIENT_BOUND, CROSS_BOUND, FACTOR_BOUND, FACTOR_ERRORS_OF_K,
        K_BOUND, K_SQUARES_BOUND, MIDDLE_BOUND, MIN_SIDES, ROW_BOUND, ROW_END_BOUND, ROW_INFLATION,
        ROW_SQUARE_BOUND, SLACK_LIMIT, UNDERFLOW_BOUND,
    },
    grid::{EightSpheres, Grid, STEPS, float_below, splat},
    kernels::{MiddleRow, farthest, quadratic, row_factor, row_middle},
    sight::powers_of_camera,
    tuning::Bounds,
};
use crate::spheres::LANES;

#[cfg(test)]
mod tests;

/// Which columns of a row are within the outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    /// Between two ends.
    Between,
    /// From an end on.
    From,
    /// Up to an end.
    UpTo,
    /// All of them: the camera is inside.
    Everywhere,
    /// All of those in the box.
    Box,
    /// Undecided: any columns.
    Unknown,
}

/// The position of eight outlines in a tile.
pub(super) struct Placement {
    /// The row of `q = 0`.
    pub(super) rows: f64x8,
    /// The upper bound of `|q|`.
    pub(super) down: f64x8,
    /// The tile's first column and row.
    pub(super) column: u32,
    pub(super) row: u32,
}

/// The outline of a sphere in a tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outline {
    shape: Shape,
    /// The lower bound of the inverse depth of every hit.
    pub(super) lower: f32,
    /// The row of `q = 0` in the tile.
    row: f32,
    /// `m0`, `m1`, and `e0`, `e1`, `e2`.
    m: [f32; 2],
    e: [f32; 3],
    /// The error bound of `e`.
    e_bound: f32,
    /// The error bound of the ends of a row, apart from that of `e`, in pixels.
    slack: f32,
    /// `m = rising q + level` in doubles, and its error bound, which is 0 where the sign of
    /// `m` is known to be that of `Cz`.
    rising: f64,
    level: f64,
    m_bound: f64,
}

/// The rows of eight outlines in doubles.
struct Rows {
    middle: MiddleRow<f64x8>,
    /// The upper bound of `|q|`.
    down: f64x8,
    /// `N0` and `N1`.
    normal: [f64x8; 2],
    k: f64x8,
    /// `Cy^2 + Cz^2`
    yz: f64x8,
    /// `c`
    power: f64x8,
    /// `rising` and `level`
    ahead: [f64x8; 2],
    /// `h Cx`
    hx: f64x8,
    /// `c h h`
    factor: f64x8,
    m: [f64x8; 2],
    e: [f64x8; 3],
}

/// The columns that a sphere covers in eight rows, as masks of the tile's columns.
#[derive(Clone, Copy, Debug)]
pub(super) struct EightRows {
    /// Columns that are certainly covered.
    pub(super) inner: [u64; LANES],
    /// Columns that are covered or undecided.
    pub(super) outer: [u64; LANES],
    /// The first column of `outer`, and the one after its last.
    pub(super) ends: [[u8; 2]; LANES],
}

impl Rows {
    /// With `h = scale/k`, `dY` the step of a row, `Y0` the row of `q = 0` and
    /// `N1 = Cz dY`,
    ///
    /// ```text
    /// e0 = c h^2 (r^2 (Y0^2 + 1) - N0^2)        m0 = middle + h Cx (Cy Y0 + Cz)
    /// e1 = -2 c h^2 (N0 N1 + r^2 Y0 dY)         m1 = -h Cx Cy dY
    /// e2 = c h^2 dY^2 (r^2 - Cz^2)
    /// ```
    ///
    /// (`Y` decreases by `dY` from row to row.)
    #[inline(always)]
    fn new(grid: &Grid, placement: &Placement, spheres: &EightSpheres) -> Self {
        let &EightSpheres { x, y, z, r } = spheres;
        let middle = MiddleRow {
            y,
            z,
            r,
            y0: grid.y_axis.y(placement.rows),
            dy: splat(grid.y_axis.step),
        };
        let yz = y * y + z * z;
        let k = yz - r * r;
        let power = powers_of_camera(spheres, yz, k);
        let [h, factor] = row_factor(splat(grid.x_axis.scale), power, k);
        let (normal, ahead, hx) = (middle.normal(), middle.ahead(), h * x);
        let column = splat(grid.x_axis.middle - f64::from(placement.column));
        Self {
            middle,
            down: placement.down,
            normal,
            k,
            yz,
            power,
            ahead,
            hx,
            factor,
            m: row_middle(column, hx, ahead),
            e: middle.coefficients(normal, factor),
        }
    }

    #[inline(always)]
    fn y_upper(&self) -> f64x8 {
        self.middle.y0.abs() + self.down * self.middle.dy
    }

    /// The upper bound of `|m|`.
    #[inline(always)]
    fn level_upper(&self) -> f64x8 {
        let MiddleRow { y, z, .. } = self.middle;
        y.abs() * self.y_upper() + z.abs()
    }

    /// The error bounds of `e` and of the ends of rows, in floats. `middle` is the sum of the magnitudes
    /// of what is in `m0` but for the sphere.
    #[inline(always)]
    fn bounds(&self, middle: f64x8) -> [f64x8; 2] {
        let MiddleRow { y, z, r, y0, .. } = self.middle;
        let ([n0, n1], [m0, m1], [e0, e1, e2]) = (self.normal, self.m, self.e);
        let (t, two) = (self.down, splat(2.0));
        // The rounding errors of E, of its factor and of the middle in doubles.
        let y_upper = self.y_upper();
        let a_upper = y_upper.mul_add(y_upper, splat(1.0));
        let n_upper = n0.abs() + n1.abs() * t;
        let n_bound = splat(CROSS_BOUND) * (y.abs() + z.abs() * y0.abs());
        let squares = (r * r).mul_add(a_upper, n_upper * n_upper);
        let e_bound = (two * n_upper + n_bound) * n_bound + splat(COEFFICIENT_BOUND) * squares;
        let e_upper = e0.abs() + t * (e1.abs() + t * e2.abs());
        let k_bound = splat(K_BOUND) + splat(K_SQUARES_BOUND) * self.yz / self.k.abs();
        let factor_bound = splat(FACTOR_ERRORS_OF_K) * k_bound + splat(FACTOR_BOUND);
        let middle_upper = self.hx.abs() * self.level_upper();
        let middle_bound =
            (k_bound + splat(MIDDLE_BOUND)) * middle_upper + splat(MIDDLE_BOUND) * middle;
        // The rounding errors in floats.
        let up = splat(1.0 + ROW_INFLATION);
        let e_bound =
            self.factor.abs() * e_bound + (factor_bound + splat(ROW_SQUARE_BOUND)) * e_upper;
        let sides = m0.abs() + t * m1.abs() + (e_upper + e_bound).sqrt();
        let slack = (middle_bound + splat(ROW_END_BOUND) * (sides + splat(MIN_SIDES))) * up;
        [e_bound * up + splat(UNDERFLOW_BOUND), slack]
    }
}

impl Outline {
    /// The outlines of eight spheres. The bounds are those of theorem 2.
    pub(super) fn eight(
        grid: &Grid,
        placement: &Placement,
        spheres: &EightSpheres,
        bounds: Bounds,
    ) -> [Self; LANES] {
        let &EightSpheres { x, y, z, r } = spheres;
        let rows = Rows::new(grid, placement, spheres);
        let [e_bound, slack] = rows.bounds(splat(grid.x_axis.middle + f64::from(placement.column)));
        let share = splat(CANCELLATION_LIMIT) * rows.yz;
        let (positive, negative) = (rows.k.simd_gt(share), rows.k.simd_lt(-share));

        // The farthest visible point of the surface is on the circle where rays touch:
        // z = sqrt c (sqrt c Cz + r |(Cx, Cy)|)/|C|^2. The sums have positive terms if
        // Cz > 0; the bound of k is below 2^-32.
        let lower = farthest([x, y, z, r], rows.yz, rows.power);
        let in_front = z.simd_gt(r);
        let lower = (in_front & positive).select(lower * splat(grid.scale), splat(0.0));
        let m_bound = in_front.select(splat(0.0), splat(ROW_BOUND) * rows.level_upper());

        let known = slack.simd_lt(splat(SLACK_LIMIT)) & (positive | negative);
        let known = if bounds == Bounds::Refused {
            0
        } else {
            known.to_bitmask()
        };
        let (positive, power) = (positive.to_bitmask(), rows.power.to_array());
        let (e_bound, slack) = if bounds == Bounds::Ignored {
            (splat(0.0), splat(0.0))
        } else {
            (e_bound, slack)
        };
        let floats = |value: f64x8| value.to_array().map(|value| value as f32);
        let (m, e) = (rows.m.map(floats), rows.e.map(floats));
        let [e_bound, slack] = [e_bound, slack].map(floats);
        let row = floats(placement.rows - splat(f64::from(placement.row)));
        let lower = lower.to_array();
        let [rising, level] = rows.ahead.map(f64x8::to_array);
        let m_bound = m_bound.to_array();
        let x = x.to_array();
        std::array::from_fn(|lane| Self {
            shape: if bounds != Bounds::Refused && power[lane] < 0.0 {
                Shape::Everywhere
            } else if known >> lane & 1 == 0 {
                Shape::Unknown
            } else if positive >> lane & 1 == 1 {
                Shape::Between
            } else if x[lane] > 0.0 {
                Shape::From
            } else {
                Shape::UpTo
            },
            lower: float_below(lower[lane]),
            row: row[lane],
            m: [m[0][lane], m[1][lane]],
            e: [e[0][lane], e[1][lane], e[2][lane]],
            e_bound: e_bound[lane],
            slack: slack[lane],
            rising: rising[lane],
            level: level[lane],
            m_bound: m_bound[lane],
        })
    }

    /// Whether it says nothing of the columns of its box.
    pub(super) fn is_unknown(&self) -> bool {
        self.shape == Shape::Unknown
    }

    /// The outline of a sphere that is hit in every pixel of its box, at no less than `lower`.
    pub(super) fn of_box(self, lower: f32) -> Self {
        Self {
            shape: Shape::Box,
            lower,
            ..self
        }
    }

    /// Appends the columns `0..width` of a tile that the sphere covers in each of its
    /// `octets` of rows; `record` has the box of the sphere.
    #[inline]
    pub(super) fn rows(
        &self,
        octets: Range<usize>,
        width: usize,
        record: &Record,
        rows: &mut Vec<EightRows>,
    ) {
        let in_box = |octet: usize| EightRows::of_box(record, octet * LANES);
        match self.shape {
            Shape::Between if self.m_bound > 0.0 => {
                self.cut_rows::<true>(octets, width, record, rows, Self::between);
            }
            Shape::Between => self.cut_rows::<false>(octets, width, record, rows, Self::between),
            Shape::From => self.cut_rows::<false>(octets, width, record, rows, Self::from),
            Shape::UpTo => self.cut_rows::<false>(octets, width, record, rows, Self::up_to),
            Shape::Everywhere => rows.extend(octets.map(|_| EightRows::all(width))),
            Shape::Box => rows.extend(octets.map(in_box).map(|rows| EightRows {
                inner: rows.outer,
                ..rows
            })),
            Shape::Unknown => rows.extend(octets.map(in_box)),
        }
    }

    /// [`rows`](Self::rows) of a shape that has `ends`; if `AHEAD`, without rows that are not ahead of the
    /// camera.
    #[inline(always)]
    fn cut_rows<const AHEAD: bool>(
        &self,
        octets: Range<usize>,
        width: usize,
        record: &Record,
        rows: &mut Vec<EightRows>,
        ends: impl Fn(&Cut) -> Ends + Copy,
    ) {
        let cut = |octet: usize| {
            let ahead = if AHEAD {
                self.ahead(octet * LANES)
            } else {
                (0xff, 0xff)
            };
            self.cut(octet * LANES, width, ahead, ends)
        };
        let (first, last) = (octets.start, octets.end - 1);
        if first + 1 >= last || record.columns() != (0..width) {
            rows.extend(octets.map(cut));
            return;
        }
        // The covered set is convex: if it has the first and the last rows, it has the whole tile.
        let (above, below, all) = (cut(first), cut(last), EightRows::all(width));
        if above.inner == all.inner && below.inner == all.inner {
            rows.extend(octets.map(|_| all));
        } else {
            rows.push(above);
            rows.extend((first + 1..last).map(cut));
            rows.push(below);
        }
    }
}

/// For eight rows: `e` minus and plus its bound, their roots, and the middle minus and plus
/// its slack.
struct Cut {
    sure: f32x8,
    possible: f32x8,
    inner: f32x8,
    outer: f32x8,
    low: f32x8,
    high: f32x8,
}

/// First and last columns of eight rows, of those certainly covered and of those possibly
/// covered, and masks of the rows that have such columns.
struct Ends {
    inner: (f32x8, f32x8),
    outer: (f32x8, f32x8),
    surely: f32x8,
    possibly: f32x8,
}

/// First and last columns of eight rows, and a mask of the rows that have any.
#[derive(Clone, Copy, PartialEq)]
struct Columns {
    start: i32x8,
    end: i32x8,
    some: i32x8,
}

impl Columns {
    #[inline(always)]
    fn new((start, end): (f32x8, f32x8), rows: f32x8, ahead: u32, width: usize) -> Self {
        let (zero, last) = (f32x8::splat(0.0), f32x8::splat(width as f32 - 1.0));
        let start = start.simd_gt(zero).select(start, zero);
        let end = end.simd_lt(last).select(end, last);
        let mut some: i32x8 = bytemuck::cast(start.simd_le(end) & rows);
        if ahead != 0xff {
            some &= i32x8::new(std::array::from_fn(|lane| -((ahead >> lane & 1) as i32)));
        }
        Self {
            start: start.fast_trunc_int(),
            end: end.fast_trunc_int(),
            some,
        }
    }

    #[inline(always)]
    fn ends(&self) -> [[u8; 2]; LANES] {
        let both = self.start + (self.end + i32x8::splat(1)) * i32x8::splat(256);
        let both = both & self.some;
        both.to_array().map(|both| (both as u16).to_le_bytes())
    }

    fn ranges(&self) -> [Range<usize>; LANES] {
        let end = (self.end + i32x8::splat(1)) & self.some;
        let (start, end) = (self.start.to_array(), end.to_array());
        std::array::from_fn(|lane| {
            let end = end[lane] as usize;
            (start[lane] as usize).min(end)..end
        })
    }

    #[inline(always)]
    fn masks(&self) -> [u64; LANES] {
        // Where a row has no columns the shifts may wrap; those masks are cleared below.
        let wide = |lanes: i32x8| u64x8::new(lanes.to_array().map(|lane| i64::from(lane) as u64));
        let all = u64x8::splat(u64::MAX);
        let first = all << wide(self.start);
        let last = all >> wide(i32x8::splat(63) - self.end);
        (first & last & wide(self.some)).to_array()
    }
}

impl Outline {
    /// Eight rows of a tile, without those that are not certainly, or not possibly, `ahead`.
    #[inline(always)]
    fn cut(
        &self,
        first: usize,
        width: usize,
        ahead: (u32, u32),
        ends: impl Fn(&Cut) -> Ends,
    ) -> EightRows {
        let (inner, outer) = self.columns(first, width, ahead, ends);
        let masks = outer.masks();
        EightRows {
            // Few rows have an undecided end.
            inner: if inner == outer { masks } else { inner.masks() },
            outer: masks,
            ends: outer.ends(),
        }
    }

    /// The columns `0..width` of eight rows: certainly covered, and possibly covered.
    #[inline(always)]
    fn columns(
        &self,
        first: usize,
        width: usize,
        ahead: (u32, u32),
        ends: impl Fn(&Cut) -> Ends,
    ) -> (Columns, Columns) {
        let splat = f32x8::splat;
        let zero = splat(0.0);
        let q = f32x8::new(STEPS) + splat(first as f32 - self.row);
        let e = quadratic(self.e.map(splat), q);
        let middle = splat(self.m[1]).mul_add(q, splat(self.m[0]));
        let root = |e: f32x8| e.simd_gt(zero).select(e, zero).sqrt();
        let (inner, outer) = (e - splat(self.e_bound), e + splat(self.e_bound));
        let ends = ends(&Cut {
            sure: inner,
            possible: outer,
            inner: root(inner),
            outer: root(outer),
            low: middle - splat(self.slack),
            high: middle + splat(self.slack),
        });
        (
            Columns::new(ends.inner, ends.surely, ahead.0, width),
            Columns::new(ends.outer, ends.possibly, ahead.1, width),
        )
    }

    /// Whether [`spans`](Self::spans) may be called.
    pub(super) fn has_spans(&self) -> bool {
        self.shape == Shape::Between && self.m_bound == 0.0
    }

    /// The columns of rows `first..first + 8` of a band of `width` columns, which takes the
    /// place of a tile: certainly covered, and possibly covered.
    pub(super) fn spans(&self, first: usize, width: usize) -> [[Range<usize>; LANES]; 2] {
        let (inner, outer) = self.columns(first, width, (0xff, 0xff), Self::between);
        [inner.ranges(), outer.ranges()]
    }

    #[inline(always)]
    fn between(cut: &Cut) -> Ends {
        let zero = f32x8::splat(0.0);
        Ends {
            inner: ((cut.high - cut.inner).ceil(), (cut.low + cut.inner).floor()),
            outer: ((cut.low - cut.outer).ceil(), (cut.high + cut.outer).floor()),
            surely: cut.sure.simd_gt(zero),
            possibly: cut.possible.simd_ge(zero),
        }
    }

    #[inline(always)]
    fn from(cut: &Cut) -> Ends {
        let (all, far) = (f32x8::splat(f32::from_bits(u32::MAX)), f32x8::splat(FAR));
        Ends {
            inner: ((cut.high + cut.outer).ceil(), far),
            outer: ((cut.low + cut.inner).ceil(), far),
            surely: all,
            possibly: all,
        }
    }

    #[inline(always)]
    fn up_to(cut: &Cut) -> Ends {
        let (all, near) = (f32x8::splat(f32::from_bits(u32::MAX)), f32x8::splat(0.0));
        Ends {
            inner: (near, (cut.low - cut.outer).floor()),
            outer: (near, (cut.high - cut.inner).floor()),
            surely: all,
            possibly: all,
        }
    }

    /// Which of eight rows are certainly in front of the camera, and which possibly.
    fn ahead(&self, first: usize) -> (u32, u32) {
        let q = splat(first as f64 - f64::from(self.row)) + f64x8::new(STEPS.map(f64::from));
        let m = splat(self.rising) * q + splat(self.level);
        let rows = |bound: f64| m.simd_gt(splat(bound)).to_bitmask();
        (rows(self.m_bound), rows(-self.m_bound))
    }
}

/// Beyond the columns of any tile.
const FAR: f32 = 1024.0;

/// The bits of columns before `end`, which is at most 64.
#[inline(always)]
fn below(end: i32) -> u64 {
    if end > 63 { u64::MAX } else { (1 << end) - 1 }
}

impl EightRows {
    /// All columns of a tile.
    fn all(width: usize) -> Self {
        Self {
            inner: [below(width as i32); LANES],
            outer: [below(width as i32); LANES],
            ends: [[0, width as u8]; LANES],
        }
    }

    /// The part of eight rows from `first` on that is in a box, all of it undecided.
    fn of_box(record: &Record, first: usize) -> Self {
        let (columns, rows) = (record.columns(), record.rows());
        let mask = below(columns.end as i32) & !below(columns.start as i32);
        let in_box = |lane: usize| rows.contains(&(first + lane));
        Self {
            inner: [0; LANES],
            outer: std::array::from_fn(|lane| if in_box(lane) { mask } else { 0 }),
            ends: std::array::from_fn(|lane| {
                if in_box(lane) {
                    [columns.start as u8, columns.end as u8]
                } else {
                    [0, 0]
                }
            }),
        }
    }
}
