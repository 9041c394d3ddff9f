//! The definition of the picture: one pixel at a time, in integers.
//!
//! It tests every sphere for every pixel, without lanes, tiles, bounds or threads. It is slow,
//! and every other method is compared with it. Nothing is rounded, so no epsilon is needed.
//!
//! # The definition
//!
//! The ray of a pixel is `t V`, `t > 0`, with `V` by the rule of [`camera`](crate::camera).
//! For a sphere of centre `C` and radius `r` write
//!
//! ```text
//! A = V.V    B = C.V    c = C.C - r^2    D = B^2 - A c
//! ```
//!
//! The ray meets it at `t = 1/s`, where `c s^2 - 2 B s + A = 0`. The visible hit is
//!
//! ```text
//! c > 0, camera outside:         exists iff D >= 0 and B > 0    s = ( B + sqrt D)/c
//! c < 0, camera inside:          exists always                  s = (-B + sqrt D)/-c
//! c = 0, camera on the surface:  exists iff B > 0               s = A/2B
//! ```
//!
//! and the pixel shows the sphere of the greatest inverse depth `s`; of equal ones, the first
//! of the file.
//!
//! # Why integers are enough
//!
//! A float is an integer times a power of two. All lengths of the spheres times one
//! power of two are integers, and so is `V` times another and times `4 (W-1)(H-1)`,
//! the denominators of the pixel rule. Neither scaling moves a ray or reorders its hits:
//! both multiply every `s` of a pixel by the same positive number.

use std::cmp::Ordering;

use dashu::{
    base::{Abs, BitTest, Sign, SquareRoot},
    integer::IBig,
};

use crate::{
    camera::{Camera, ImageSize},
    scene::Scene,
    spheres::Sphere,
};

#[cfg(test)]
mod tests;

/// A scene at one image size, in integers.
#[derive(Clone, Debug)]
pub struct Reference {
    camera: Camera,
    viewport: [IBig; 3],
    spheres: Vec<IntegerSphere>,
}

/// A sphere, with every length multiplied by the scene's power of two.
#[derive(Clone, Debug)]
struct IntegerSphere {
    /// `C`.
    centre: [IBig; 3],
    /// `c = C.C - r^2`: its sign says on which side of the surface the camera is.
    power: IBig,
}

/// The inverse depth `(p + sqrt d)/q` of a hit, `d >= 0`, `q > 0`.
#[derive(Clone, Debug)]
struct InverseDepth {
    p: IBig,
    d: IBig,
    q: IBig,
}

impl Reference {
    /// The reference of `scene` as an image of `size`.
    #[must_use]
    pub fn new(scene: &Scene, size: ImageSize) -> Self {
        let viewport = &scene.viewport;
        let viewport = [viewport.width, viewport.height, viewport.distance];
        let unit = common_exponent(viewport);
        let viewport = viewport.map(|length| in_units(length, unit));

        let lengths = |sphere: Sphere| {
            let [x, y, z] = sphere.centre;
            [x, y, z, sphere.radius]
        };
        let unit = common_exponent(scene.spheres.iter().flat_map(lengths));
        let spheres = scene.spheres.iter().map(|sphere| {
            let centre = sphere.centre.map(|length| in_units(length, unit));
            let radius = in_units(sphere.radius, unit);
            let power = dot(&centre, &centre) - &radius * &radius;
            IntegerSphere { centre, power }
        });
        Self {
            camera: Camera::new(scene.viewport, size),
            viewport,
            spheres: spheres.collect(),
        }
    }

    /// The index of the sphere that pixel (`column`, `row`) shows; `None` is the background.
    #[must_use]
    pub fn seen(&self, column: u32, row: u32) -> Option<usize> {
        let ray = self.ray(column, row);
        let mut nearest: Option<(usize, InverseDepth)> = None;
        for (index, sphere) in self.spheres.iter().enumerate() {
            let Some(hit) = sphere.hit(&ray) else {
                continue;
            };
            let nearer = nearest
                .as_ref()
                .is_none_or(|(_, best)| hit.compare(best) == Ordering::Greater);
            if nearer {
                nearest = Some((index, hit));
            }
        }
        nearest.map(|(index, _)| index)
    }

    /// The outline of a sphere near a pixel, if it has one in front of the camera.
    pub(crate) fn outline(&self, sphere: usize, (column, row): (u32, u32)) -> Option<Outline> {
        let IntegerSphere { centre, power } = &self.spheres[sphere];
        let ray = self.ray(column, row);
        if sign(power) != Ordering::Greater || sign(&dot(centre, &ray)) != Ordering::Greater {
            return None;
        }
        // D = V.V by the form (C.U)(C.V) - c U.V.
        let form =
            |u: &[IBig; 3], v: &[IBig; 3]| dot(centre, u) * dot(centre, v) - power * dot(u, v);
        let [across, down] = self.steps();
        let gradient = [2 * form(&ray, &across), 2 * form(&ray, &down)];
        let curvature = [
            form(&across, &across),
            form(&across, &down),
            form(&down, &down),
        ];
        // As c > 0, not all of them are zero.
        let unit = gradient.iter().chain(&curvature).map(Abs::abs).max()?;
        Some(Outline {
            value: quotient(&form(&ray, &ray), &unit),
            gradient: gradient.map(|value| quotient(&value, &unit)),
            curvature: curvature.map(|value| quotient(&value, &unit)),
        })
    }

    /// How much farther the second of two spheres is than the first, relative to the distance
    /// of the first, if the ray of the pixel meets both.
    pub(crate) fn gap(
        &self,
        [first, second]: [usize; 2],
        (column, row): (u32, u32),
    ) -> Option<f64> {
        /// Fractional bits of roots.
        const FINE: usize = 256;
        let ray = self.ray(column, row);
        let first = self.spheres[first].hit(&ray)?;
        let second = self.spheres[second].hit(&ray)?;
        let root = |d: &IBig| IBig::from((d << (2 * FINE)).sqrt());
        // 1 - s2/s1, all times 2^FINE.
        let p = (&first.p * &second.q - &second.p * &first.q) << FINE;
        let u = root(&(&second.q * &second.q * &first.d));
        let w = root(&(&first.q * &first.q * &second.d));
        let whole = ((&first.p * &second.q) << FINE) + &u;
        Some(quotient(&(p + u - w), &whole))
    }

    /// The change of `V` from a pixel to the next one to the right, and down. A single column
    /// or row is as wide as the viewport.
    fn steps(&self) -> [[IBig; 3]; 2] {
        let (_, x_denominator) = self.camera.x_ratio(0);
        let (_, y_denominator) = self.camera.y_ratio(0);
        let [width, height, _] = &self.viewport;
        let step = |denominator: i64| if denominator == 1 { 1 } else { 2 };
        [
            [
                width * step(x_denominator) * y_denominator,
                IBig::ZERO,
                IBig::ZERO,
            ],
            [
                IBig::ZERO,
                -height * step(y_denominator) * x_denominator,
                IBig::ZERO,
            ],
        ]
    }

    /// `V`, times the viewport's power of two and the denominators of both ratios.
    fn ray(&self, column: u32, row: u32) -> [IBig; 3] {
        let (x, x_denominator) = self.camera.x_ratio(column);
        let (y, y_denominator) = self.camera.y_ratio(row);
        let [width, height, distance] = &self.viewport;
        [
            width * x * y_denominator,
            height * y * x_denominator,
            distance * x_denominator * y_denominator,
        ]
    }
}

impl IntegerSphere {
    /// The visible hit of this sphere along `ray`.
    fn hit(&self, ray: &[IBig; 3]) -> Option<InverseDepth> {
        let a = dot(ray, ray);
        let b = dot(&self.centre, ray);
        let c = self.power.clone();
        let d = &b * &b - &a * &c;
        match sign(&c) {
            Ordering::Greater => {
                let exists = d >= IBig::ZERO && b > IBig::ZERO;
                exists.then_some(InverseDepth { p: b, d, q: c })
            }
            Ordering::Less => Some(InverseDepth { p: -b, d, q: -c }),
            Ordering::Equal => {
                let exists = b > IBig::ZERO;
                exists.then(|| InverseDepth {
                    p: a,
                    d: IBig::ZERO,
                    q: 2 * b,
                })
            }
        }
    }
}

/// `D` near a pixel as a polynomial in pixels: its value, its slopes across and down, and the
/// coefficients of both squares and of the product.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    pub(crate) value: f64,
    pub(crate) gradient: [f64; 2],
    pub(crate) curvature: [f64; 3],
}

impl Outline {
    /// Pixels to where `D` is zero, in the direction in which it changes fastest.
    pub(crate) fn distance(self) -> f64 {
        if self.value == 0.0 {
            return 0.0;
        }
        let [across, down] = self.gradient;
        let [along, mixed, upright] = self.curvature;
        let slope = across.hypot(down);
        let (x, y) = if slope > 0.0 {
            (across / slope, down / slope)
        } else {
            (1.0, 0.0)
        };
        let curvature = along * x * x + 2.0 * mixed * x * y + upright * y * y;
        let discriminant = slope * slope - 4.0 * curvature * self.value;
        // Where the line meets no outline, the distance by the tangent.
        let root = discriminant.max(0.0).sqrt();
        2.0 * self.value.abs() / (slope + root)
    }
}

impl InverseDepth {
    /// Both sides are multiplied by `q1 q2 > 0`, which removes the quotients:
    /// `p1 q2 + sqrt(q2^2 d1)` against `p2 q1 + sqrt(q1^2 d2)`.
    fn compare(&self, other: &Self) -> Ordering {
        let p = &self.p * &other.q - &other.p * &self.q;
        let u = &other.q * &other.q * &self.d;
        let w = &self.q * &self.q * &other.d;
        sign_with_two_roots(&p, &u, &w)
    }
}

/// The sign of `p + sqrt u - sqrt w`, `u >= 0`, `w >= 0`.
fn sign_with_two_roots(p: &IBig, u: &IBig, w: &IBig) -> Ordering {
    if *p < IBig::ZERO {
        return sign_with_two_roots(&-p, w, u).reverse();
    }
    // p + sqrt u >= 0 and sqrt w >= 0 compare as their squares do:
    // p^2 + u + 2 p sqrt u against w.
    let p_squared = p * p;
    let rest = &p_squared + u - w;
    sign_with_root(&rest, &(4 * p_squared * u))
}

/// The sign of `m + sqrt n`, `n >= 0`.
fn sign_with_root(m: &IBig, n: &IBig) -> Ordering {
    if *m < IBig::ZERO {
        n.cmp(&(m * m))
    } else {
        sign(&(m + n))
    }
}

/// The double nearest to `n/d`, or next to it.
fn quotient(n: &IBig, d: &IBig) -> f64 {
    /// More bits than a double has.
    const BITS: isize = 64;
    let shift = d.bit_len() as isize - n.bit_len() as isize + BITS;
    let whole = if shift >= 0 {
        (n << shift as usize) / d
    } else {
        n / (d << -shift as usize)
    };
    whole.to_f64().value() * f64::powi(2.0, -shift as i32)
}

fn sign(value: &IBig) -> Ordering {
    value.cmp(&IBig::ZERO)
}

fn dot([ax, ay, az]: &[IBig; 3], [bx, by, bz]: &[IBig; 3]) -> IBig {
    ax * bx + ay * by + az * bz
}

/// The largest `e` for which every length is an integer times `2^e`; 0 if all are zero.
fn common_exponent(lengths: impl IntoIterator<Item = f32>) -> i32 {
    lengths
        .into_iter()
        .filter(|&length| length != 0.0)
        .map(|length| {
            let (magnitude, exponent) = parts(length);
            exponent + magnitude.trailing_zeros() as i32
        })
        .min()
        .unwrap_or(0)
}

/// `length / 2^unit`, which the caller knows to be an integer.
fn in_units(length: f32, unit: i32) -> IBig {
    let (magnitude, exponent) = parts(length);
    let sign = Sign::from(length < 0.0);
    let magnitude = sign * IBig::from(magnitude);
    let shift = exponent - unit;
    if shift >= 0 {
        magnitude << shift as usize
    } else {
        magnitude >> -shift as usize
    }
}

/// `(m, e)` with `|length| = m 2^e`, exactly.
fn parts(length: f32) -> (u32, i32) {
    const FRACTION_BITS: i32 = f32::MANTISSA_DIGITS as i32 - 1;
    const SMALLEST: i32 = f32::MIN_EXP - 1 - FRACTION_BITS;
    let bits = length.to_bits();
    let fraction = bits & ((1 << FRACTION_BITS) - 1);
    let biased = (bits >> FRACTION_BITS & 0xff) as i32;
    if biased == 0 {
        (fraction, SMALLEST)
    } else {
        (fraction + (1 << FRACTION_BITS), SMALLEST + biased - 1)
    }
}
