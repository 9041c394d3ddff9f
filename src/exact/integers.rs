//! The last stage: dyadic rationals of unlimited precision, which decide every pixel.
//!
//! Floats are dyadic rationals, and so is `V` times `2(W-1)(H-1)`. So `A`, `B`, `c` and `D` are
//! sums and products of dyadics, which are exact without rounding or
//! division. (Theorem 7 of the [`proof`](super::proof).)
//!
//! This and the [`reference`](mod@crate::reference) are tests of each other, so they share no code, not
//! even to take a float apart. The tests of all other stages compare with this module.

use std::cmp::Ordering;

use dashu::float::FBig;

use crate::{camera::Camera, spheres::Sphere};

pub(super) type Dyadic = FBig;

/// An exact inverse depth `(p + sqrt d)/q`, with `q > 0` and `d >= 0`.
#[derive(Clone, Debug)]
pub(super) struct InverseDepth {
    p: Dyadic,
    d: Dyadic,
    q: Dyadic,
}

/// The ray of a pixel, scaled so that its components are dyadic.
#[derive(Debug)]
pub(super) struct Ray {
    v: [Dyadic; 3],
    /// `A = V.V`
    a: Dyadic,
}

/// What a ray has to do with a sphere: `B = C.V`, `c = C.C - r^2`, `D = B^2 - A c`.
#[derive(Clone, Debug)]
pub(super) struct Terms {
    pub(super) b: Dyadic,
    pub(super) c: Dyadic,
    pub(super) d: Dyadic,
}

impl Ray {
    pub(super) fn new(camera: &Camera, column: u32, row: u32) -> Self {
        let viewport = camera.viewport();
        let (x, x_unit) = camera.x_ratio(column);
        let (y, y_unit) = camera.y_ratio(row);
        let v = [
            dyadic(viewport.width) * whole(x) * whole(y_unit),
            dyadic(viewport.height) * whole(y) * whole(x_unit),
            dyadic(viewport.distance) * whole(x_unit) * whole(y_unit),
        ];
        Self::along(v)
    }

    /// The ray `t v`, `t > 0`.
    pub(super) fn along(v: [Dyadic; 3]) -> Self {
        let a = dot(&v, &v);
        Self { v, a }
    }

    pub(super) fn terms(&self, sphere: &Sphere) -> Terms {
        let centre = sphere.centre.map(dyadic);
        let radius = dyadic(sphere.radius);
        let b = dot(&centre, &self.v);
        let c = dot(&centre, &centre) - &radius * &radius;
        let d = &b * &b - &self.a * &c;
        Terms { b, c, d }
    }

    /// The inverse depth at which the ray meets the visible surface of the sphere, if it does.
    pub(super) fn meet(&self, sphere: &Sphere) -> Option<InverseDepth> {
        let Terms { b, c, d } = self.terms(sphere);
        let zero = Dyadic::ZERO;
        match c.cmp(&zero) {
            // s = (B + sqrt D)/c
            Ordering::Greater => (b > zero && d >= zero).then_some(InverseDepth { p: b, d, q: c }),
            // s = A/(B + sqrt D) = (-B + sqrt D)/-c
            Ordering::Less => Some(InverseDepth { p: -b, d, q: -c }),
            // s = A/(2B)
            Ordering::Equal => (b > zero).then(|| InverseDepth {
                p: self.a.clone(),
                d: zero,
                q: &b + &b,
            }),
        }
    }
}

impl InverseDepth {
    /// `p/q`, `q > 0`
    #[cfg(test)]
    pub(super) fn ratio(p: Dyadic, q: Dyadic) -> Self {
        let d = Dyadic::ZERO;
        Self { p, d, q }
    }

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
        if k >= Dyadic::ZERO {
            cmp_shifted_root(square, &l, &m)
        } else {
            cmp_shifted_root(square, &m, &l).reverse()
        }
    }
}

/// Compares `k + sqrt l` with `sqrt m`, for `k, l, m >= 0`, by the square of `k`. Squaring both sides
/// compares `2k sqrt l` with `m - l - k^2`; if that is not negative, both are squared again.
fn cmp_shifted_root(square: Dyadic, l: &Dyadic, m: &Dyadic) -> Ordering {
    let rest = m - l - &square;
    if rest < Dyadic::ZERO {
        return Ordering::Greater;
    }
    (whole(4) * square * l).cmp(&(&rest * &rest))
}

fn dot(a: &[Dyadic; 3], b: &[Dyadic; 3]) -> Dyadic {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

/// The exact value of a float, at unlimited precision.
fn dyadic(value: f32) -> Dyadic {
    let bits = value.to_bits();
    let exponent = (bits >> 23 & 0xff) as isize;
    let fraction = i64::from(bits & 0x7f_ffff);
    // Subnormals lack the implied bit and share the smallest normal exponent.
    let significand = if exponent == 0 {
        fraction
    } else {
        fraction + (1 << 23)
    };
    let signed = if value.is_sign_negative() {
        -significand
    } else {
        significand
    };
    Dyadic::from_parts(signed.into(), exponent.max(1) - 150)
        .with_precision(0)
        .value()
}

fn whole(value: i64) -> Dyadic {
    Dyadic::from_parts(value.into(), 0)
        .with_precision(0)
        .value()
}
