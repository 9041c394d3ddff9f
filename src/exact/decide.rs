//! The last rungs: one pixel at a time, in doubles with a running error bound,
//! and in [`integers`](super::integers) where that bound can't tell.
//!
//! ```text
//! N = C x V        D = r^2 A - N.N     (= B^2 - A c, by Lagrange's identity)
//! B = C.V          A = V.V             c = C.C - r^2
//! ```
//!
//! The cross product is the form of `D` without the great cancellation: its
//! error is relative to `|C||V| |N|`, where `B^2 - A c` loses `|C|^2 |V|^2`.
//! For `|C|/r = 10^6` that is `10^-10` of `r^2` instead of `10^-4`.
//!
//! Squares and fourth powers of floats are normal doubles (`2^-596` to `2^520`),
//! so the relative bounds below need no term for underflow.

#[cfg(test)]
mod tests;

use crate::{
    camera::Camera,
    exact::integers,
    methods::{NONE, Seen},
    spheres::Sphere,
};

/// Unit roundoff of doubles.
pub(super) const U: f64 = f64::EPSILON / 2.0;

// Bounds in units of U, first order; each is rounded up by one or more, which
// covers the products of roundings (of relative size U) and the few roundings
// made in computing the bound itself. The inputs: x and y carry 2 roundings, z
// and the sphere none. Source of the method: N. Higham, Accuracy and Stability
// of Numerical Algorithms, 2nd ed., 2002, ch. 3.

/// `|Nx - N~x| <= CROSS_BOUND (|cy z| + |cz y|)` and so on round: 2 of a
/// coordinate, 1 of the product, 1 of the difference.
const CROSS_BOUND: f64 = 5.0 * U;

/// `r^2 A`: 4 of a squared coordinate, 1 of the square, 2 of the sums, 1 of the
/// product, and 1 for its share of the rounding of `D`.
const SQUARED_RADIUS_BOUND: f64 = 10.0 * U;

/// `N.N` from the computed `N`: 1 of the square, 2 of the sums, and 1 for its
/// share of the rounding of `D`.
const SQUARED_CROSS_BOUND: f64 = 5.0 * U;

/// `B`: 2 of a coordinate, 1 of the product, 2 of the sums.
const DOT_BOUND: f64 = 6.0 * U;

/// A quotient of a sum with a root, of values that are bounds already: 1 of each
/// difference with its bound, 1 of the root, 1 of the sum, 1 of the quotient, 7
/// of `c` or of `A`.
const QUOTIENT_BOUND: f64 = 20.0 * U;

/// Which rung settled a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rung {
    Doubles,
    Integers,
}

/// What doubles can say of a ray and a sphere: bounds of its inverse depth.
#[derive(Clone, Copy, Debug)]
enum Sight {
    Missed,
    /// Met or missed; if met, not nearer than `most`.
    Doubtful {
        most: f64,
    },
    Met {
        least: f64,
        most: f64,
    },
}

impl Sight {
    fn least(self) -> f64 {
        if let Self::Met { least, .. } = self {
            least
        } else {
            f64::NEG_INFINITY
        }
    }

    fn most(self) -> f64 {
        match self {
            Self::Missed => f64::NEG_INFINITY,
            Self::Doubtful { most } | Self::Met { most, .. } => most,
        }
    }
}

/// The sphere that pixel `(column, row)` sees, of `candidates` in any order, each
/// with its place in the file. `trusted` is false where every bound of the doubles
/// is to refuse.
pub(super) fn decide(
    camera: &Camera,
    (column, row): (u32, u32),
    candidates: impl Iterator<Item = (Seen, Sphere)> + Clone,
    trusted: bool,
) -> (Seen, Rung) {
    let ray = Ray::new(camera, column, row);
    let sight = |sphere: &Sphere| {
        if trusted {
            ray.sight(sphere)
        } else {
            Sight::Doubtful {
                most: f64::INFINITY,
            }
        }
    };
    let mut leader = NONE;
    let mut least = f64::NEG_INFINITY;
    let mut leader_most = f64::NEG_INFINITY;
    let mut rival_most = f64::NEG_INFINITY;
    for (index, sphere) in candidates.clone() {
        let sight = sight(&sphere);
        if sight.least() > least {
            rival_most = rival_most.max(leader_most);
            (leader, least, leader_most) = (index, sight.least(), sight.most());
        } else {
            rival_most = rival_most.max(sight.most());
        }
    }
    if least > rival_most || (leader == NONE && rival_most == f64::NEG_INFINITY) {
        return (leader, Rung::Doubles);
    }

    let exact_ray = integers::Ray::new(camera, column, row);
    let mut nearest: Option<(Seen, integers::InverseDepth)> = None;
    for (index, sphere) in candidates {
        let sight = sight(&sphere);
        if sight.most() < least || matches!(sight, Sight::Missed) {
            continue;
        }
        let Some(depth) = exact_ray.meet(&sphere) else {
            continue;
        };
        let wins = nearest.as_ref().is_none_or(|(best, best_depth)| {
            depth.cmp(best_depth).then_with(|| best.cmp(&index)).is_gt()
        });
        if wins {
            nearest = Some((index, depth));
        }
    }
    (nearest.map_or(NONE, |(index, _)| index), Rung::Integers)
}

/// The ray of a pixel in doubles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ray {
    x: f64,
    y: f64,
    z: f64,
    /// `A = V.V`
    a: f64,
}

impl Ray {
    pub(super) fn new(camera: &Camera, column: u32, row: u32) -> Self {
        let (x, y, z) = (
            camera.x_double(column),
            camera.y_double(row),
            camera.z_double(),
        );
        Self {
            x,
            y,
            z,
            a: x * x + y * y + z * z,
        }
    }

    /// `1/z` of the sphere's hit is not less than this.
    pub(super) fn least_inverse_z(&self, sphere: &Sphere) -> f64 {
        self.sight(sphere).least() / self.z * (1.0 - 4.0 * U)
    }

    fn sight(&self, sphere: &Sphere) -> Sight {
        let &Self { x, y, z, a } = self;
        let [cx, cy, cz] = sphere.centre.map(f64::from);
        let r = f64::from(sphere.radius);
        let c = power_of_camera(sphere);

        let (b0, b1, b2) = (cx * x, cy * y, cz * z);
        let b = b0 + b1 + b2;
        let b_error = DOT_BOUND * (b0.abs() + b1.abs() + b2.abs());

        let mut squared_cross = 0.0;
        let mut cross_error = 0.0;
        for (p, q) in [(cy * z, cz * y), (cz * x, cx * z), (cx * y, cy * x)] {
            let n = p - q;
            let error = CROSS_BOUND * (p.abs() + q.abs());
            squared_cross += n * n;
            cross_error += (2.0 * n.abs() + error) * error;
        }
        let r_squared_a = r * r * a;
        let d = r_squared_a - squared_cross;
        let d_error =
            SQUARED_RADIUS_BOUND * r_squared_a + SQUARED_CROSS_BOUND * squared_cross + cross_error;

        let (b_least, b_most) = (b - b_error, b + b_error);
        let root_least = (d - d_error).max(0.0).sqrt();
        let root_most = (d + d_error).max(0.0).sqrt();
        let down = |s: f64| s * (1.0 - QUOTIENT_BOUND);
        let up = |s: f64| s * (1.0 + QUOTIENT_BOUND);
        if c > 0.0 {
            if d < -d_error || b_most < 0.0 {
                Sight::Missed
            } else if d > d_error && b_least > 0.0 {
                Sight::Met {
                    least: down((b_least + root_least) / c),
                    most: up((b_most + root_most) / c),
                }
            } else {
                Sight::Doubtful {
                    most: up((b_most + root_most) / c),
                }
            }
        } else if c < 0.0 {
            // Of the two equal forms, the one that adds.
            if b < 0.0 {
                Sight::Met {
                    least: down((root_least - b_most) / -c),
                    most: up((root_most - b_least) / -c),
                }
            } else {
                let below = root_least + b_least;
                Sight::Met {
                    least: down(a / (root_most + b_most)),
                    most: if below > 0.0 {
                        up(a / below)
                    } else {
                        f64::INFINITY
                    },
                }
            }
        } else if b_least > 0.0 {
            Sight::Met {
                least: down(a / (2.0 * b_most)),
                most: up(a / (2.0 * b_least)),
            }
        } else if b_most < 0.0 {
            Sight::Missed
        } else {
            Sight::Doubtful {
                most: f64::INFINITY,
            }
        }
    }
}

/// `c = C.C - r^2`, the power of the camera with respect to the sphere: its sign
/// is right, zero is zero, and its relative error is at most 7 U.
///
/// The squares are exact doubles; their sum is kept as an expansion of doubles
/// that don't overlap, whose largest component carries the sign (J. Shewchuk,
/// Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
/// Predicates, 1997, section 2.4, Grow-Expansion).
pub(super) fn power_of_camera(sphere: &Sphere) -> f64 {
    let [x, y, z] = sphere
        .centre
        .map(|component| f64::from(component) * f64::from(component));
    let r = -(f64::from(sphere.radius) * f64::from(sphere.radius));
    let plain = x + y + z + r;
    // Three roundings of at most the sum of magnitudes, which is at most twice
    // the result: 6 U.
    if plain.abs() >= 0.5 * (x + y + z - r) {
        return plain;
    }
    let mut expansion = [0.0; 4];
    for (length, term) in [x, y, z, r].into_iter().enumerate() {
        let mut sum = term;
        for component in &mut expansion[..length] {
            (sum, *component) = two_sum(sum, *component);
        }
        expansion[length] = sum;
    }
    expansion.into_iter().sum()
}

/// `a + b` as its rounded sum and the rounding error, exactly (Knuth).
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let virtual_b = sum - a;
    let virtual_a = sum - virtual_b;
    (sum, (a - virtual_a) + (b - virtual_b))
}
