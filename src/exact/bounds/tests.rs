//! The roundings of each kernel, counted by machine for each term of it.
//!
//! A kernel is stated once over [`Number`] and evaluated with [`Terms`]: polynomials
//! whose every term carries how many factors `1 + d`, `|d| <= u`, it is wrong by at most
//! (Higham, chapter 3). A sum adds one to all terms, a product adds the counts and one, a
//! fused multiply-add one where two operations add two. Both ways are counted, and the
//! constant has to be at least one unit above the greater one: `n` roundings are no more
//! than `n u/(1 - n u) < (n + 1) u`. It may be above by a stated number of units, fewer
//! than would let its half pass.
//!
//! The kernels are restated here in the engine's order of operations; that they are the
//! engine's is for the reader to compare.
//!
//! Roots, quotients of intervals and case splits are no polynomials: a root halves what is
//! under it and rounds once, which is counted here by hand ([`Terms::root`]), and what
//! follows from signs is left to the proof.
//! What is not counted at all:
//!
//! - `BOX_BOUND` has fewer than 64 roundings and is 256 units, since a pixel more or less
//!   in a box costs nothing: its half is as sound as itself.
//! - `GREATEST_SLACK`, `CLEAR_SHARE` and `GREATEST` choose between ways that are all
//!   sound; any positive value is, of `GREATEST` any up to this one.
//! - `LEAST_BOUND` is absolute: see its comment.

use std::collections::BTreeMap;

use super::*;

/// What a kernel is evaluated with.
trait Number: Clone {
    fn plus(&self, other: &Self) -> Self;
    fn minus(&self, other: &Self) -> Self;
    fn times(&self, other: &Self) -> Self;
    /// `self a + b`, rounded once or twice.
    fn times_plus(&self, a: &Self, b: &Self) -> Self;
}

/// The terms of a polynomial, by the sorted names of their factors, and the roundings of
/// each.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Terms {
    terms: BTreeMap<Vec<&'static str>, u32>,
    fused: bool,
}

impl Terms {
    /// A number that is known within so many roundings.
    fn of(name: &'static str, roundings: u32, fused: bool) -> Self {
        let terms = BTreeMap::from([(vec![name], roundings)]);
        Self { terms, fused }
    }

    /// The same, of products that doubles hold exactly: squares of floats.
    fn exact_product(&self, other: &Self) -> Self {
        let mut product = Self {
            terms: BTreeMap::new(),
            fused: self.fused,
        };
        for (left, count) in &self.terms {
            for (right, more) in &other.terms {
                let mut names = [left.as_slice(), right].concat();
                names.sort_unstable();
                let greatest = product.terms.entry(names).or_default();
                *greatest = (*greatest).max(count + more);
            }
        }
        product
    }

    fn exact_sum(&self, other: &Self) -> Self {
        let mut sum = self.clone();
        for (names, count) in &other.terms {
            let greatest = sum.terms.entry(names.clone()).or_default();
            *greatest = (*greatest).max(*count);
        }
        sum
    }

    fn rounded(mut self) -> Self {
        for count in self.terms.values_mut() {
            *count += 1;
        }
        self
    }

    /// The greatest count.
    fn roundings(&self) -> u32 {
        self.terms.values().copied().max().expect("a term")
    }

    /// `self / other`, of an `other` that is one number.
    fn over(&self, other: &Self) -> Self {
        self.times(other)
    }

    /// The square root of one number: `sqrt(1 + d)` is nearer to 1 than `1 + d`.
    fn root(&self) -> Self {
        let half = |count: &u32| count.div_ceil(2);
        let terms = self
            .terms
            .iter()
            .map(|(names, count)| (names.clone(), half(count)));
        let halved = Self {
            terms: terms.collect(),
            fused: self.fused,
        };
        halved.rounded()
    }
}

impl Number for Terms {
    fn plus(&self, other: &Self) -> Self {
        self.exact_sum(other).rounded()
    }

    fn minus(&self, other: &Self) -> Self {
        self.plus(other)
    }

    fn times(&self, other: &Self) -> Self {
        self.exact_product(other).rounded()
    }

    fn times_plus(&self, a: &Self, b: &Self) -> Self {
        if self.fused {
            self.exact_product(a).plus(b)
        } else {
            self.times(a).plus(b)
        }
    }
}

/// Fused and unfused.
fn greatest(count: impl Fn(bool) -> u32) -> u32 {
    count(false).max(count(true))
}

fn assert_counted(name: &str, constant: f64, unit: f64, derived: u32, slack: u32) {
    let units = constant / unit;
    let least = f64::from(derived + 1);
    let most = least + f64::from(slack);
    assert!(
        (least..=most).contains(&units),
        "{name} is {units} units; {derived} roundings need {least}, and {most} is enough"
    );
    assert!(units / 2.0 < least, "half of {name} would pass");
}

/// The floats of a sphere, exact; a coordinate of a ray, 3 roundings; a step, 2.
fn atoms(fused: bool) -> impl Fn(&'static str, u32) -> Terms {
    move |name, roundings| Terms::of(name, roundings, fused)
}

/// A part of `N`: `a b - c d`.
fn cross<N: Number>(negated: &N, by: &N, from: &N) -> N {
    negated.times_plus(by, from)
}

/// `(d2 x + d1) x + d0`
fn quadratic<N: Number>([d0, d1, d2]: [&N; 3], x: &N) -> N {
    d2.times_plus(x, d1).times_plus(x, d0)
}

#[test]
fn parts_of_the_normal() {
    let derived = greatest(|fused| {
        let atom = atoms(fused);
        let (x, y, z) = (atom("Cx", 0), atom("Cy", 0), atom("Cz", 0));
        let (x0, y0) = (atom("X", 3), atom("Y", 3));
        let n_x = cross(&z, &y0, &y);
        let n_y = cross(&z, &x0, &x);
        let n_z = cross(&x, &y0, &y.times(&x0));
        [n_x, n_y, n_z]
            .map(|n| n.roundings())
            .into_iter()
            .max()
            .expect("three")
    });
    assert_counted("CROSS_BOUND", CROSS_BOUND, U, derived, 0);
}

/// From the computed `N`, whose own error is the other part of the bound.
#[test]
fn coefficients_of_depths() {
    let derived = greatest(|fused| {
        let atom = atoms(fused);
        let (x, y, z, r) = (atom("Cx", 0), atom("Cy", 0), atom("Cz", 0), atom("r", 0));
        let (x0, y0, one) = (atom("X", 3), atom("Y", 3), atom("1", 0));
        let (dx, dy) = (atom("dX", 2), atom("dY", 2));
        let (n_x, n_y, n_z) = (atom("Nx", 0), atom("Ny", 0), atom("Nz", 0));
        let squared_radius = r.exact_product(&r);
        let yz = y.times_plus(&y, &z.exact_product(&z));
        let xz = x.times_plus(&x, &z.exact_product(&z));
        let k = yz.minus(&squared_radius);
        let a0 = x0.times_plus(&x0, &y0.times_plus(&y0, &one));
        let nn = n_x.times_plus(&n_x, &n_y.times_plus(&n_y, &n_z.times(&n_z)));
        let d00 = squared_radius.times_plus(&a0, &nn);
        let d10 = n_z
            .times_plus(&y, &n_y.times_plus(&z, &squared_radius.times(&x0)))
            .times(&dx);
        let d01 = n_x
            .times_plus(&z, &n_z.times_plus(&x, &squared_radius.times(&y0)))
            .times(&dy);
        let d20 = k.times(&dx.times(&dx));
        let d02 = squared_radius.minus(&xz).times(&dy.times(&dy));
        let d11 = x.times(&y).times(&dx.times(&dy));
        let scale = atom("1/c", 0).rounded();
        let squared_scale = scale.times(&scale);
        let scaled = [d00, d10, d01, d20, d02, d11].map(|d| d.times(&squared_scale));
        scaled
            .map(|d| d.roundings())
            .into_iter()
            .max()
            .expect("six")
    });
    assert_counted("COEFFICIENT_BOUND", COEFFICIENT_BOUND, U, derived, 0);
}

#[test]
fn depths_in_floats() {
    let d = |fused: bool| {
        let [d00, d10, d01, d20, d11, d02] =
            ["d00", "d10", "d01", "d20", "d11", "d02"].map(|name| Terms::of(name, 1, fused));
        let (p, q) = (Terms::of("p", 0, fused), Terms::of("q", 0, fused));
        let d0 = quadratic([&d00, &d10, &d20], &p);
        let d1 = d11.times_plus(&p, &d01);
        quadratic([&d0, &d1, &d02], &q)
    };
    // Taking away the bound rounds as well. `c` is a share of a unit: see below.
    let derived = greatest(|fused| d(fused).rounded().roundings());
    assert_counted("D_BOUND", D_BOUND, U32, derived, 1);
    let b = |fused: bool| {
        let [b00, b10, b01] = ["b00", "b10", "b01"].map(|name| Terms::of(name, 1, fused));
        let (p, q) = (Terms::of("p", 0, fused), Terms::of("q", 0, fused));
        b01.times_plus(&q, &b10.times_plus(&p, &b00))
    };
    let derived = greatest(|fused| b(fused).roundings());
    assert_counted("B_BOUND", B_BOUND, U32, derived, 1);
    // (b - spread) + sqrt(d - d_spread), and (b + sqrt d) - spread: of the parts.
    let (b, d) = (Terms::of("b", 0, false), Terms::of("d", 0, false));
    let spread = Terms::of("spread", 0, false);
    let lower = b.minus(&spread).plus(&d.rounded().root());
    let clear = b.plus(&Terms::of("d", 0, false).root()).minus(&spread);
    let derived = lower.roundings().max(clear.roundings());
    assert_counted("SUM_OF_PARTS_BOUND", SUM_OF_PARTS_BOUND, U32, derived, 0);
}

#[test]
fn planes_of_depths() {
    let derived = greatest(|fused| {
        let atom = atoms(fused);
        let (x, y, z) = (atom("Cx", 0), atom("Cy", 0), atom("Cz", 0));
        let (x0, y0) = (atom("X", 3), atom("Y", 3));
        let b00 = x.times_plus(&x0, &y.times_plus(&y0, &z));
        // The scale is a power of two.
        let scale = atom("1/c", 0).rounded();
        b00.times(&scale).roundings()
    });
    assert_counted("PLANE_BOUND", PLANE_BOUND, U, derived, 0);
}

#[test]
fn rows_in_doubles() {
    let level = |fused: bool| {
        let atom = atoms(fused);
        atom("Cy", 0).times_plus(&atom("Y", 3), &atom("Cz", 0))
    };
    let h = |fused: bool| Terms::of("scale", 2, fused).over(&Terms::of("1/k", 0, fused));
    let rising = |fused: bool| {
        let step = Terms::of("dY", 2, fused);
        let rising = Terms::of("Cy", 0, fused).times(&step);
        rising.times(&Terms::of("q", 0, fused)).plus(&level(fused))
    };
    let derived = greatest(|fused| rising(fused).roundings());
    assert_counted("ROW_BOUND", ROW_BOUND, U, derived, 0);
    let derived = greatest(|fused| {
        let lean = h(fused).times(&Terms::of("Cx", 0, fused));
        let m0 = lean
            .times(&level(fused))
            .plus(&Terms::of("middle", 0, fused));
        let dy = Terms::of("dY", 2, fused);
        let m1 = lean.times(&Terms::of("Cy", 0, fused).times(&dy));
        m0.roundings().max(m1.roundings())
    });
    assert_counted("MIDDLE_BOUND", MIDDLE_BOUND, U, derived, 4);
    let derived = greatest(|fused| {
        let power = Terms::of("c", 7, fused);
        power.times(&h(fused).times(&h(fused))).roundings()
    });
    assert_counted("FACTOR_BOUND", FACTOR_BOUND, U, derived, 0);
}

#[test]
fn rows_in_floats() {
    let e = |fused: bool| {
        let [e0, e1, e2] = ["e0", "e1", "e2"].map(|name| Terms::of(name, 1, fused));
        quadratic([&e0, &e1, &e2], &Terms::of("q", 0, fused))
    };
    let derived = greatest(|fused| e(fused).rounded().roundings());
    assert_counted("ROW_SQUARE_BOUND", ROW_SQUARE_BOUND, U32, derived, 1);
    let derived = greatest(|fused| {
        let [m0, m1] = ["m0", "m1"].map(|name| Terms::of(name, 1, fused));
        let middle = m1.times_plus(&Terms::of("q", 0, fused), &m0);
        let low = middle.minus(&Terms::of("slack", 0, fused));
        low.minus(&Terms::of("e", 0, fused).root()).roundings()
    });
    assert_counted("ROW_END_BOUND", ROW_END_BOUND, U32, derived, 2);
}

/// In units of the arithmetic's own roundoff; squares of floats are exact in both.
#[test]
fn sights() {
    let atom = |name, roundings| Terms::of(name, roundings, false);
    let (cx, cy, cz, r) = (atom("Cx", 0), atom("Cy", 0), atom("Cz", 0), atom("r", 0));
    let (x, y, z) = (atom("x", 2), atom("y", 2), atom("z", 0));
    let n = cx.times(&y).minus(&cy.times(&x));
    assert_counted("SIGHT_CROSS", SIGHT_CROSS, 1.0, n.roundings(), 0);
    let b = cx.times(&x).plus(&cy.times(&y)).plus(&cz.times(&z));
    assert_counted("SIGHT_DOT", SIGHT_DOT, 1.0, b.roundings(), 0);
    let a = x.times(&x).plus(&y.times(&y)).plus(&z.times(&z));
    let part = r.exact_product(&r).times(&a).rounded();
    assert_counted(
        "SIGHT_SQUARED_RADIUS",
        SIGHT_SQUARED_RADIUS,
        1.0,
        part.roundings(),
        0,
    );
    let [n_x, n_y, n_z] = ["Nx", "Ny", "Nz"].map(|name| atom(name, 0));
    // The first square is added to nothing.
    let squared = n_x
        .times(&n_x)
        .plus(&n_y.times(&n_y))
        .plus(&n_z.times(&n_z));
    let part = squared.rounded();
    assert_counted(
        "SIGHT_SQUARED_CROSS",
        SIGHT_SQUARED_CROSS,
        1.0,
        part.roundings(),
        0,
    );
    // From the bounds of b and d on: (b - b_bound + sqrt(d - d_bound))/c and its own share.
    let root = atom("d", 0).rounded().root();
    let sum = atom("b", 0).rounded().plus(&root);
    let quotient = sum.over(&atom("1/c", 7));
    let share = atom("1", 0).rounded();
    let lower = quotient.times(&share);
    assert_counted("SIGHT_QUOTIENT", SIGHT_QUOTIENT, 1.0, lower.roundings(), 7);
}

/// `k` loses two units of `yz`; where it is used, `k > LEAST_SHARE yz` is left, so it is
/// within `2^-32` of itself, as the bounds of floats take it to be.
#[test]
fn what_cancels_is_less_than_a_share_of_a_float() {
    let derived = greatest(|fused| {
        let atom = atoms(fused);
        let (y, z, r) = (atom("Cy", 0), atom("Cz", 0), atom("r", 0));
        let yz = y.exact_product(&y).plus(&z.exact_product(&z));
        yz.minus(&r.exact_product(&r)).roundings()
    });
    let derived = f64::from(derived);
    assert!(derived * U / LEAST_SHARE <= (-32.0_f64).exp2());
    // And no more is asked of k than that.
    assert!(2.0 * derived * U / LEAST_SHARE > (-32.0_f64).exp2());
}

#[test]
fn double_doubles_round_by_no_more_than_a_quotient() {
    // Of the operations in its table, with terms in U^3.
    let greatest = 15.0 * U * U;
    assert!((greatest..=greatest + U * U).contains(&U_DOUBLE_DOUBLE));
}

/// Half of the distance from 1 to the number after it.
#[test]
fn units_are_those_of_the_formats() {
    assert_eq!(1.0_f64.next_up() - 1.0, 2.0 * U);
    assert_eq!(f64::from(1.0_f32.next_up() - 1.0), 2.0 * U32);
}
