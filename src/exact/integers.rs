//! The last stage: integers of any size, which decide every pixel.
//!
//! Floats are integers times powers of two. The lengths of some spheres, times one power of two, are
//! integers, and so are those of the viewport times another. `V`, times both denominators of the pixel
//! rule, is then made of integers, and so are `A`, `B`, `c` and `D`: nothing is rounded or divided.
//! (Theorem 7 of the [`proof`](super::proof).)
//!
//! This and the [`reference`](mod@crate::reference) are tests of each other, so they share no code but
//! the pixel rule, not even to take a float apart.

use std::cmp::Ordering;

use dashu::integer::IBig;

use super::bins::Candidate;
use crate::{
    camera::Camera,
    methods::{NONE, Seen},
};

/// The sphere that is visible at a pixel, of candidates in any order.
pub(super) fn seen(camera: &Camera, pixel: (u32, u32), candidates: &[Candidate]) -> Seen {
    let hits = hits(camera, pixel, candidates.iter().map(|&(_, sphere)| sphere));
    let mut nearest: Option<(Seen, InverseDepth)> = None;
    for (&(index, _), depth) in candidates.iter().zip(hits) {
        let Some(depth) = depth else {
            continue;
        };
        let wins = nearest.as_ref().is_none_or(|(best, best_depth)| {
            let order = depth.cmp(best_depth).then_with(|| best.cmp(&index));
            order == Ordering::Greater
        });
        if wins {
            nearest = Some((index, depth));
        }
    }
    nearest.map_or(NONE, |(index, _)| index)
}

/// The inverse depths at which the ray of a pixel hits the visible surfaces of some spheres, each given
/// as centre and radius; `None` where it misses.
pub(super) fn hits(
    camera: &Camera,
    (column, row): (u32, u32),
    spheres: impl Iterator<Item = [f32; 4]> + Clone,
) -> impl Iterator<Item = Option<InverseDepth>> {
    let ray = Ray::new(camera, column, row);
    let unit = unit_of(spheres.clone().flatten());
    spheres.map(move |sphere| ray.meet(sphere.map(|length| in_units(length, unit))))
}

/// An exact inverse depth `(p + sqrt d)/q`, with `q > 0` and `d >= 0`.
#[derive(Clone, Debug)]
pub(super) struct InverseDepth {
    p: IBig,
    d: IBig,
    q: IBig,
}

/// The ray of a pixel, scaled so that its components are integers.
#[derive(Debug)]
struct Ray {
    v: [IBig; 3],
    /// `A = V.V`
    a: IBig,
}

impl Ray {
    fn new(camera: &Camera, column: u32, row: u32) -> Self {
        let viewport = camera.viewport();
        let lengths = [viewport.width, viewport.height, viewport.distance];
        let (x, x_unit) = camera.x_ratio(column);
        let (y, y_unit) = camera.y_ratio(row);
        let unit = unit_of(lengths.into_iter());
        let [width, height, distance] = lengths.map(|length| in_units(length, unit));
        let v = [
            width * x * y_unit,
            height * y * x_unit,
            distance * x_unit * y_unit,
        ];
        let a = dot(&v, &v);
        Self { v, a }
    }

    /// The inverse depth at which the ray meets the visible surface of a sphere, if it does.
    fn meet(&self, [x, y, z, radius]: [IBig; 4]) -> Option<InverseDepth> {
        let centre = [x, y, z];
        let b = dot(&centre, &self.v);
        let c = dot(&centre, &centre) - &radius * &radius;
        let d = &b * &b - &self.a * &c;
        match c.cmp(&IBig::ZERO) {
            // s = (B + sqrt D)/c
            Ordering::Greater => {
                (b > IBig::ZERO && d >= IBig::ZERO).then_some(InverseDepth { p: b, d, q: c })
            }
            // s = A/(B + sqrt D) = (-B + sqrt D)/-c
            Ordering::Less => Some(InverseDepth { p: -b, d, q: -c }),
            // s = A/(2B)
            Ordering::Equal => (b > IBig::ZERO).then(|| InverseDepth {
                p: self.a.clone(),
                d: IBig::ZERO,
                q: b * 2,
            }),
        }
    }
}

impl InverseDepth {
    /// Compares two inverse depths; the greater one is nearer to the camera.
    ///
    /// `(p1 + sqrt d1)/q1 - (p2 + sqrt d2)/q2`, times `q1 q2 > 0`, is
    /// `k + sqrt l - sqrt m` with
    ///
    /// ```text
    /// k = p1 q2 - p2 q1      l = q2^2 d1      m = q1^2 d2
    /// ```
    pub(super) fn cmp(&self, other: &Self) -> Ordering {
        let k = &self.p * &other.q - &other.p * &self.q;
        let l = &other.q * &other.q * &self.d;
        let m = &self.q * &self.q * &other.d;
        let square = &k * &k;
        if k >= IBig::ZERO {
            cmp_shifted_root(square, &l, &m)
        } else {
            cmp_shifted_root(square, &m, &l).reverse()
        }
    }
}

/// Compares `k + sqrt l` with `sqrt m`, for `k, l, m >= 0`, by the square of `k`. Squaring both sides
/// compares `2k sqrt l` with `m - l - k^2`; if that is not negative, both are squared again.
fn cmp_shifted_root(square: IBig, l: &IBig, m: &IBig) -> Ordering {
    let rest: IBig = m - l - &square;
    if rest < IBig::ZERO {
        return Ordering::Greater;
    }
    let product: IBig = IBig::from(4) * square * l;
    product.cmp(&(&rest * &rest))
}

fn dot(a: &[IBig; 3], b: &[IBig; 3]) -> IBig {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// A float as an integer and the exponent of a power of two. The exponent is the greatest one, unless
/// the float is zero.
fn integer_of(value: f32) -> (i64, i32) {
    let bits = value.to_bits();
    let exponent = (bits >> 23 & 0xff) as i32;
    let fraction = i64::from(bits & 0x7f_ffff);
    // Subnormals lack the implied bit and share the smallest normal exponent.
    let magnitude = if exponent == 0 {
        fraction
    } else {
        fraction + (1 << 23)
    };
    let twos = magnitude.trailing_zeros() % i64::BITS;
    let integer = magnitude >> twos;
    let signed = if value < 0.0 { -integer } else { integer };
    (signed, exponent.max(1) - 150 + twos as i32)
}

/// The greatest exponent of a power of two of which all lengths are multiples; 0 if all are zero.
fn unit_of(lengths: impl Iterator<Item = f32>) -> i32 {
    let lengths = lengths.filter(|&length| length != 0.0);
    lengths
        .map(|length| integer_of(length).1)
        .min()
        .unwrap_or(0)
}

/// A multiple of `2^unit`, in units of it.
fn in_units(length: f32, unit: i32) -> IBig {
    let (integer, exponent) = integer_of(length);
    // Zero is a multiple of any unit; its exponent may be less.
    let shift = (exponent - unit).max(0) as usize;
    IBig::from(integer) << shift
}

#[cfg(test)]
mod tests {
    use super::{IBig, in_units, unit_of};

    /// Zero is a multiple of any unit.
    #[test]
    fn the_unit_is_the_greatest_of_which_all_lengths_are_multiples() {
        let least = f32::from_bits(1);
        for (lengths, unit) in [
            ([0.0, 12.0], 2),
            ([1.0, -0.75], -2),
            ([least, f32::MAX], -149),
            ([0.0, -0.0], 0),
        ] {
            assert_eq!(unit_of(lengths.into_iter()), unit, "{lengths:?}");
        }
        assert_eq!(in_units(-0.75, -2), IBig::from(-3));
        assert_eq!(in_units(-0.0, 100), IBig::ZERO);
        assert_eq!(in_units(3.0 * least, -149), IBig::from(3));
        assert_eq!(in_units(f32::MAX, -149), IBig::from((1 << 24) - 1) << 253);
    }
}
