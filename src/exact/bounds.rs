//! Every constant of every error bound of the engine, each with its table of
//! roundings; the theorems that use them are in the [`proof`](super::proof).
//!
//! `U` counts roundings of doubles, `U32` of floats. A product of `n` factors
//! `1 + d` with `|d| <= u` differs from 1 by at most `n u/(1 - n u)` (Higham,
//! Accuracy and Stability of Numerical Algorithms, 2nd ed., 2002, lemma 3.1). So each
//! constant is one unit or more above the number of its roundings, which also pays for
//! evaluating the bound itself. A fused multiply-add rounds once where a product and a
//! sum round twice; the tables count twice.

#[cfg(test)]
mod double_double;
#[cfg(test)]
mod gappa;
#[cfg(test)]
mod search;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod trace;

/// Unit roundoff of doubles.
pub(super) const U: f64 = f64::EPSILON / 2.0;

/// Unit roundoff of floats.
pub(super) const U32: f64 = f32::EPSILON as f64 / 2.0;

/// What is added to a double so that it is above as a float, of itself.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | to a float | 1 | 1 |
/// | the factor, the sum, and less than 98 before: of doubles | `2^-22` | `1 + 2^-22` |
/// | `c` of the farthest visible point, `2^-31` | `2^-7` | below `1 + 2^-6` |
/// | to spare | above `1 - 2^-6` | 2 |
pub(super) const TO_FLOAT: f64 = 2.0 * U32;

/// Half of the viewport's sides at distance 1 (a quotient, a factor: 2), and from these `|V|` at a
/// corner of the picture.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the square, two sums | 3 | 3 |
/// | the root: half of it, and its own | 1 | 3 |
/// | the factor itself | 1 | 4 |
/// | to spare; 1 more, since `1 + 5 U` is no double | 2 | 6 |
pub(super) const REACH_BOUND: f64 = 6.0 * U;

/// Inverse depths of a sphere beside the camera.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the squares, exact, two sums, halved under the root, the root | 2 | 2 |
/// | the sum with `r`, the product with the reach | 2 | 4 |
/// | `c` 7, the quotient, the factor | 9 | 13 |
/// | to spare | 3 | 16 |
pub(super) const BESIDE_BOUND: f64 = 16.0 * U;

// Boxes: theorem 1.

/// Ends of a box, of the greater of their distances from the middle and the picture's
/// side.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | beside the camera: `(|Cx| - r)(|Cx| + r)` | 3 | 3 |
/// | the sum below it: `w` under the root 7/2, root 1, product 1, sum 1 | 7 | 10 |
/// | their quotient | 1 | 11 |
/// | pixels per unit 2, their product | 3 | 14 |
/// | the slack, the middle | 2 | 16 |
/// | to spare | 4 | 20 |
///
/// Before the camera: numerator 5 (`q` 3, the sum under the root 1, both halved, root 1, product
/// 1, sum 1), `1/q` 4, pixels per unit 2, two products, the slack, the middle: 15.
pub(super) const BOX_BOUND: f64 = 20.0 * U;

/// The same in floats, of spheres before the camera.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | numerator: `q` 3, `Cx^2` 1, their sum 1, halved by the root, root 1, product 1, sum 1 | 5 | 5 |
/// | `1/q` 4, pixels per unit 1 and less than 1, their product | 7 | 12 |
/// | the product with the numerator | 1 | 13 |
/// | the slack, the middle | 2 | 15 |
/// | to spare | 5 | 20 |
pub(super) const FLOAT_BOX_BOUND: f64 = 20.0 * U32;

/// Inverse depths in floats, of spheres before the camera.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `Cz + r` 1, `1/q` 4, their product | 6 | 6 |
/// | the factor itself | 1 | 7 |
/// | to spare | 1 | 8 |
pub(super) const FLOAT_UPPER_BOUND: f64 = 8.0 * U32;

// Outlines: theorem 2.

/// Of `k = Cy^2 + Cz^2 - r^2`, if less than this share of `Cy^2 + Cz^2` is left, too
/// much has cancelled for `k` to be used. A choice, not an error.
pub(super) const CANCELLATION_LIMIT: f64 = 1.0 / (1 << 20) as f64;

/// Where the ends of rows are known worse than this, in pixels, packets are better. A
/// choice, not an error.
pub(super) const SLACK_LIMIT: f64 = 1.0 / 4.0;

/// `k` from the computed `Cy^2 + Cz^2`, of `k`.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the difference with `r^2`, which is exact | 1 | 1 |
/// | to spare | 1 | 2 |
pub(super) const K_BOUND: f64 = 2.0 * U;

/// `Cy^2 + Cz^2`, of itself: the squares are exact, so the sum rounds once. The spare unit of
/// [`K_BOUND`] pays for evaluating this bound.
pub(super) const K_SQUARES_BOUND: f64 = U;

/// The factor `c h h` of `E`: how many times what `k` is wrong by.
///
/// | term | times | sum |
/// | --- | --- | --- |
/// | `c = Cx^2 + k`, both positive | 1 | 1 |
/// | `h` twice | 2 | 3 |
/// | products of errors, and to spare | 1 | 4 |
pub(super) const FACTOR_ERRORS_OF_K: f64 = 4.0;

/// `m = rising q + level` of a row, of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `Y0` | 3 | 3 |
/// | its product with `Cy`, the sum with `Cz` | 2 | 5 |
/// | the sum with `rising q` | 1 | 6 |
/// | to spare | 1 | 7 |
pub(super) const ROW_BOUND: f64 = 7.0 * U;

/// The middle of a row in doubles, of its terms; what `k` is wrong by is extra.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | pixels per unit 2, over `k` 1 | 3 | 3 |
/// | product with `Cx` | 1 | 4 |
/// | `Cy Y0 + Cz`: see [`ROW_BOUND`] | 5 | 9 |
/// | their product, the sum with the middle of the picture | 2 | 11 |
/// | to spare | 5 | 16 |
pub(super) const MIDDLE_BOUND: f64 = 16.0 * U;

/// The factor `c h h` of `E`; what `k` is wrong by is extra ([`FACTOR_ERRORS_OF_K`]).
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `c`, exactly summed (or 1 and once the error of `k`) | 7 | 7 |
/// | `h` twice: see [`MIDDLE_BOUND`] | 6 | 13 |
/// | two products | 2 | 15 |
/// | to spare | 1 | 16 |
pub(super) const FACTOR_BOUND: f64 = 16.0 * U;

/// `E` of a row in floats, of the sum of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the coefficient | 1 | 1 |
/// | `(e2 q + e1) q + e0` | 4 | 5 |
/// | the bound taken away or added | 1 | 6 |
/// | to spare | 2 | 8 |
pub(super) const ROW_SQUARE_BOUND: f64 = 8.0 * U32;

/// An end of a row in floats, of the sum of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the coefficient of the middle | 1 | 1 |
/// | `m1 q + m0` | 2 | 3 |
/// | the slack | 1 | 4 |
/// | the sum with the root | 1 | 5 |
/// | to spare | 3 | 8 |
///
/// The root has 2, its own and that of the sum with it.
pub(super) const ROW_END_BOUND: f64 = 8.0 * U32;

/// The share by which the bounds of a row are increased: how often they themselves are rounded.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the slack as a float | 1 | 1 |
/// | the middle less the slack, the sum with the root | 2 | 3 |
/// | to spare | 1 | 4 |
///
/// The bound of `E` has 2: as a float, and the difference with it.
pub(super) const ROW_INFLATION: f64 = 4.0 * U32;

/// Added to the sum of magnitudes of [`ROW_END_BOUND`], in pixels, so that the slack is above
/// what underflows in the middle. A choice, not an error: any normal float is enough.
pub(super) const MIN_SIDES: f64 = 64.0;

// Inverse depths around a rectangle: theorem 3.

/// The parts of `N0`, of the magnitudes of their terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `X0` or `Y0` | 3 | 3 |
/// | the product, the difference | 2 | 5 |
/// | to spare | 1 | 6 |
pub(super) const CROSS_BOUND: f64 = 6.0 * U;

/// Coefficients of `D` and of `E`, of all their terms, given the computed `N0`. The
/// greatest is that of `r^2 Y0^2`:
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `Y0` twice | 6 | 6 |
/// | its square, the sums of `A0` | 3 | 9 |
/// | times `r^2`, less `N0.N0` | 2 | 11 |
/// | the scale: quotient twice, square, product | 4 | 15 |
/// | to spare | 1 | 16 |
///
/// The others: `r^2 X0 dX` 13, `N0.Np` 10, `dX^2` 12, `dX dY` 10, `N0.N0` 8; of `E`
/// at most 11.
pub(super) const COEFFICIENT_BOUND: f64 = 16.0 * U;

/// `D` in floats, of the sum of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the coefficient | 1 | 1 |
/// | `(d02 q + (d11 p + d01)) q + ((d20 p + d10) p + d00)` | 5 | 6 |
/// | the bound taken away | 1 | 7 |
/// | `c`, wrong by `2^-32`, twice: `2^-7` of a rounding; and to spare | 1 | 8 |
pub(super) const D_BOUND: f64 = 8.0 * U32;

/// `B` in floats, of the sum of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the coefficient | 1 | 1 |
/// | `b01 q + (b10 p + b00)` | 3 | 4 |
/// | `c`, wrong by `2^-32`: `2^-8` of a rounding; and to spare | 2 | 6 |
pub(super) const B_BOUND: f64 = 6.0 * U32;

/// `B` in doubles, of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `Y0` | 3 | 3 |
/// | the product with `Cy`, two sums | 3 | 6 |
/// | the scale: quotient, product | 2 | 8 |
/// | to spare | 1 | 9 |
pub(super) const PLANE_BOUND: f64 = 9.0 * U;

/// From `b` and `d` to the inverse depth, of the magnitudes of `b` and of the root.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the root | 1 | 1 |
/// | the sum of both | 1 | 2 |
/// | the spread taken away | 1 | 3 |
/// | to spare | 1 | 4 |
pub(super) const SUM_OF_PARTS_BOUND: f64 = 4.0 * U32;

/// The share by which the bounds of `D` and of `B` are increased: how often they themselves are
/// rounded, as part of a coefficient and twice as great as the spread.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the bound of `B` in `b00`: as a float | 1 | 1 |
/// | `b01 q + (b10 p + b00)` | 2 | 3 |
/// | the sum with the root, the spread taken away | 2 | 5 |
/// | the spread, twice the bound: taken away | 2 | 7 |
/// | to spare | 1 | 8 |
///
/// The bound of `D` has 6.
pub(super) const DEPTH_INFLATION: f64 = 8.0 * U32;

/// `B/r` in floats of a sphere on whose surface the camera is, of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `C/r` | 1 | 1 |
/// | `X` or `Y` | 1 | 2 |
/// | the product, two sums | 3 | 5 |
/// | of doubles, and to spare | 1 | 6 |
pub(super) const SURFACE_BOUND: f64 = 6.0 * U32;

/// The inverse depth of its hit in floats.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `A`: `X` or `Y` twice, the square, two sums | 5 | 5 |
/// | the sum of `B/r` and its bound, the quotient | 2 | 7 |
/// | `g/(2 r)`, the product | 2 | 9 |
/// | the factor itself | 1 | 10 |
/// | of doubles, and to spare | 2 | 12 |
pub(super) const SURFACE_QUOTIENT: f64 = 12.0 * U32;

// Radical planes: theorem 10.

/// Of `c' - c`, if less than this share of `|c| + |c'|` is left, too much has cancelled for the
/// difference of both to be used. A choice, not an error.
pub(super) const POWERS_CANCELLATION_LIMIT: f64 = 1.0 / 32.0;

/// `l` in floats, of the sum of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the coefficient | 1 | 1 |
/// | `l01 q + (l10 p + l00)` | 3 | 4 |
/// | to spare | 2 | 6 |
pub(super) const PLANE_SIDE_BOUND: f64 = 6.0 * U32;

/// `l` in doubles, of the magnitudes of the terms of the plane and of `b`.
///
/// | term | error | sum in `2^-32` |
/// | --- | --- | --- |
/// | `c' - c`: 6 roundings, and 1, of terms of which [`CANCELLATION_LIMIT`] is left | `2^-30` | |
/// | or both wrong by `2^-32`, and [`POWERS_CANCELLATION_LIMIT`] is left | `2^-27` | 32 |
/// | `c`, in `b` | `2^-32` | 33 |
/// | 10 roundings of doubles, and 1 to spare | `2^-49` | 33 |
/// | to spare | | 64 |
pub(super) const PLANE_TERMS_BOUND: f64 = 1.0 / (1 << 26) as f64;

/// `c' - c` from the spheres, of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | two differences or sums, the product, three sums | 6 | 6 |
/// | to spare | 2 | 8 |
pub(super) const DIFFERENCE_BOUND: f64 = 8.0 * U;

/// `c` as depths have it, of `|c| + 2 (Cy^2 + Cz^2)`. It is computed in one of two ways.
///
/// | term | roundings |
/// | --- | --- |
/// | the sum of the squares, which are exact | 3 |
/// | or their expansion (theorem 6), of `c` itself | 7 |
/// | the greater one, and 1 to spare | 8 |
pub(super) const POWER_BOUND: f64 = 8.0 * U;

/// `l` in doubles, of the magnitudes of its terms, but for what `c' - c` and `c` are wrong by.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `X0` or `Y0` 3, the scale 1, two products, `C' - C`, two sums, the difference | 10 | 10 |
/// | to spare | 2 | 12 |
pub(super) const PLANE_ROUNDINGS: f64 = 12.0 * U;

/// `d - l |l|` in floats, of the square of the upper bound of `|l|`; that of `d` is the
/// last one of [`D_BOUND`].
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the square | 1 | 1 |
/// | the difference | 1 | 2 |
/// | to spare | 1 | 3 |
pub(super) const SIDE_BOUND: f64 = 3.0 * U32;

/// The greatest sum of the magnitudes of the terms of `l` in floats, so that no square overflows. A
/// choice, not an error: beyond it another unit is taken.
pub(super) const GREATEST_SIDE: f64 = (1_u64 << 60) as f64;

/// What operations that underflow can lose, which is relative to nothing. In units of half the
/// spacing of subnormals, `2^-150`, with `|p|` and `|q|` at most 41:
///
/// | term | units | sum |
/// | --- | --- | --- |
/// | `(d20 p + d10) p + d00`: a unit for each coefficient and each product | 1765 | 1765 |
/// | `(d02 q + (d11 p + d01)) q` | 3486 | 5251 |
/// | to spare; of it less than 1 for what doubles lose | 2941 | 8192 |
///
/// `E` has 1765, `B` 85, `B/r` from a surface less than 2048 (theorem 4).
pub(super) const UNDERFLOW_BOUND: f64 = 1.0 / (1_u128 << 127) as f64 / 1024.0;

/// The part of the greatest `D` from which on an outline is not grazed. A choice, not
/// an error; a power of 4, so that its root is exact.
pub(super) const SURE_SHARE: f64 = 1.0 / 16384.0;

/// Beyond this, some intermediate float might overflow. A choice, not an error: a
/// float holds `2^127`.
pub(super) const OVERFLOW_LIMIT: f64 = (1_u128 << 100) as f64;

// Pixels one by one: theorem 6. Squares of floats are exact in doubles.

/// The parts of `N`, of the magnitudes of their terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `x` or `y` | 2 | 2 |
/// | the product, the difference | 2 | 4 |
/// | to spare | 1 | 5 |
pub(super) const SIGHT_CROSS: f64 = 5.0 * U;

/// `r^2 A`.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `x` twice | 4 | 4 |
/// | its square, two sums | 3 | 7 |
/// | times `r^2` | 1 | 8 |
/// | its share of the difference `D` | 1 | 9 |
/// | to spare | 1 | 10 |
pub(super) const SIGHT_SQUARED_RADIUS: f64 = 10.0 * U;

/// `N.N` from the computed `N`.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | the square, two sums | 3 | 3 |
/// | its share of the difference `D` | 1 | 4 |
/// | to spare | 1 | 5 |
pub(super) const SIGHT_SQUARED_CROSS: f64 = 5.0 * U;

/// `B`, of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `x` or `y` | 2 | 2 |
/// | the product, two sums | 3 | 5 |
/// | to spare, which theorem 6 needs where `B` cancels with the root | 1 | 6 |
pub(super) const SIGHT_DOT: f64 = 6.0 * U;

/// `(c' - c) s` of two spheres, of the magnitudes of the terms of `c' - c`, times the upper bound of
/// `s`.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | two differences or sums, the product, three sums | 6 | 6 |
/// | the product with `s`, its share of the difference | 2 | 8 |
/// | the part for the width of the bounds of `s`: `c' - c`, a difference, a product, two sums | 10 | 18 |
/// | to spare | 2 | 20 |
pub(super) const SIGHT_POWER: f64 = 20.0 * U;

/// `2 (C' - C).V`, of the magnitudes of its terms.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `x` or `y` | 2 | 2 |
/// | `C' - C`, the product, two sums | 4 | 6 |
/// | its share of the difference | 1 | 7 |
/// | to spare | 1 | 8 |
pub(super) const SIGHT_ALONG: f64 = 8.0 * U;

/// A quotient of `c` or `A` and of a sum with a root, of values that are bounds already.
///
/// | term | roundings | sum |
/// | --- | --- | --- |
/// | `c` or `A` | 7 | 7 |
/// | the difference with a bound 1 (or 1/2 under the root), the root 1 | 1.5 | 8.5 |
/// | the sum, the quotient | 2 | 10.5 |
/// | the factor itself | 1 | 11.5 |
/// | where the sum cancels (theorem 6) | 4 | 15.5 |
/// | to spare | 4.5 | 20 |
pub(super) const SIGHT_QUOTIENT: f64 = 20.0 * U;
