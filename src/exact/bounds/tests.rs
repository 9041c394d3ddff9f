//! The roundings of each formula, counted by machine for each term of it.
//!
//! The engine's own formulas ([`kernels`](crate::exact::kernels)) are evaluated with [`Traced`]: a
//! polynomial's every term carries how many factors `1 + d`, `|d| <= u`, it is wrong by at most
//! (Higham, chapter 3). A sum adds one to all terms, a product adds the counts and one, a
//! fused multiply-add one where two operations add two. Both ways are counted, and the
//! constant has to be at least one unit above the greater one: `n` roundings are no more
//! than `n u/(1 - n u) < (n + 1) u`. It may be above by a stated number of units, fewer
//! than would let its half pass.
//!
//! A test of packets holds what they do with these polynomials to the same bits.
//!
//! Roots, quotients of intervals and case splits are no polynomials: a root halves what is
//! under it and rounds once, a divisor is a sum of terms of one sign, and what follows from
//! signs is left to the proof.

use std::collections::BTreeMap;

use super::{
    trace::{Counter, Traced},
    *,
};
use crate::{
    exact::{
        grid::SIDE,
        kernels::{
            Ahead, Discriminant, Middle, MiddleRow, Number, Sight, before, component,
            difference_at, dot, farthest, in_column, in_row, nearest_beside, on_the_surface,
            over_power, power_difference, quadratic, radical_plane, row_factor, row_middle,
            squared_length, squared_ray, touching, touching_beside,
        },
    },
    spheres::LANES,
};

/// The greater count of both ways.
fn greatest(of: &[Traced], given: &[(Traced, &'static str, u32)]) -> u32 {
    let count = |fused| {
        let counter = Counter::new(fused).given(given);
        of.iter().map(|&of| counter.terms(of).roundings()).max()
    };
    count(false).max(count(true)).expect("numbers")
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

fn assert_least(name: &str, constant: f64, derived: f64) {
    assert!(
        derived <= constant,
        "{name} is {constant:e}, {derived:e} is needed"
    );
    assert!(constant / 2.0 < derived, "half of {name} would pass");
}

#[test]
fn ends_of_boxes() {
    let (x, z, r) = (Traced::float("Cx"), Traced::float("Cz"), Traced::float("r"));
    let [middle, slack] = ["middle", "slack"].map(|name| Traced::rounded(name, 0));
    let scale = Traced::rounded("scale", 2);
    let [_, _, q, inverse] = before(z, r);
    let ends = touching(x, [z, r, q], scale * inverse);
    let ends = ends.map(|end| middle + (end - slack));
    let beside = touching_beside([x, z, r], Traced::rounded("w", 7));
    let beside = beside.map(|slope| middle + slope * scale - slack);
    let derived = greatest(&[ends, beside].concat(), &[]);
    assert_counted("BOX_BOUND", BOX_BOUND, U, derived, 3);
}

#[test]
fn what_is_nearest() {
    let [x, y, z, r] = ["Cx", "Cy", "Cz", "r"].map(Traced::float);
    let up = Traced::rounded("up", 0);
    let [side, other] = ["side", "other"].map(|name| Traced::rounded(name, 0));
    let corner = (side * side + other * other + Traced::constant(1.0)).root() * up;
    assert_counted("REACH_BOUND", REACH_BOUND, U, greatest(&[corner], &[]), 1);
    let reach = Traced::rounded("reach", 0);
    let nearest = nearest_beside(reach, [x, y, z, r], Traced::rounded("c", 7)) * up;
    assert_counted(
        "BESIDE_BOUND",
        BESIDE_BOUND,
        U,
        greatest(&[nearest], &[]),
        2,
    );
}

/// What is within `2^-32`, as `c` of an outline is.
const NEARLY: f64 = 1.0 / (1_u64 << 32) as f64;

#[test]
fn conversions_to_floats() {
    let [x, y, z, r] = ["Cx", "Cy", "Cz", "r"].map(Traced::float);
    let [_, far, _, inverse] = before(z, r);
    let [yz, _] = middle().k();
    let farthest = farthest([x, y, z, r], yz, Traced::rounded("c", 0));
    let doubles = greatest(&[far * inverse, farthest], &[]);
    assert!(doubles < 98, "{doubles} roundings of doubles");
    // The root of `c` stands in it twice.
    let needed = U32 + 100.0 * U + 2.0 * NEARLY;
    assert!((needed..2.0 * needed).contains(&TO_FLOAT));
}

/// `C/r`, `X` and `Y` as floats, of doubles that have few roundings themselves.
#[test]
fn inverse_depths_from_the_surface() {
    let rounded = |name| Traced::rounded(name, 1);
    let ray = ["X", "Y"].map(rounded);
    let b = dot(["Cx/r", "Cy/r", "Cz/r"].map(rounded), ray);
    assert_counted("SURFACE_BOUND", SURFACE_BOUND, U32, greatest(&[b], &[]), 0);
    let a = squared_ray(ray);
    let bound = Traced::rounded("bound", 0);
    let b = Traced::rounded("b", 0);
    let depths = on_the_surface(a, b, bound, rounded("g/2r"));
    let derived = greatest(&depths, &[]);
    assert_counted("SURFACE_QUOTIENT", SURFACE_QUOTIENT, U32, derived, 1);
}

/// A factor `1 + bound` that is no number of its format is not the one that was counted.
#[test]
fn factors_are_exact() {
    for bound in [REACH_BOUND, BESIDE_BOUND, TO_FLOAT, SIGHT_QUOTIENT] {
        assert_eq!([1.0 + bound - 1.0, 1.0 - (1.0 - bound)], [bound; 2]);
    }
    for bound in [FLOAT_UPPER_BOUND, SURFACE_QUOTIENT] {
        let factors = [1.0 + bound, 1.0 - bound];
        assert_eq!(factors.map(|factor| f64::from(factor as f32)), factors);
    }
    for bound in [ROW_INFLATION, DEPTH_INFLATION] {
        assert_eq!(1.0 + bound - 1.0, bound);
    }
}

/// In floats products of the scene's numbers are rounded, too.
#[test]
fn ends_of_boxes_in_floats() {
    let [x, z, r] = ["Cx", "Cz", "r"].map(|name| Traced::rounded(name, 0));
    let [middle, slack] = ["middle", "slack"].map(|name| Traced::rounded(name, 0));
    // Two roundings of doubles and one of floats.
    let scale = Traced::rounded("scale", 2);
    let [_, far, q, inverse] = before(z, r);
    let ends = touching(x, [z, r, q], scale * inverse);
    let ends = ends.map(|end| middle + (end - slack));
    let derived = greatest(&ends, &[]);
    assert_counted("FLOAT_BOX_BOUND", FLOAT_BOX_BOUND, U32, derived, 4);
    // The grid's scale is a power of two.
    let upper = far * inverse * Traced::constant(2.0) * Traced::rounded("up", 0);
    let derived = greatest(&[upper], &[]);
    assert_counted("FLOAT_UPPER_BOUND", FLOAT_UPPER_BOUND, U32, derived, 0);
}

/// Floats of the scene; coordinates of a ray, 3 roundings each.
pub(super) fn middle() -> Middle<Traced> {
    let r = Traced::float("r");
    Middle {
        x: Traced::float("Cx"),
        y: Traced::float("Cy"),
        z: Traced::float("Cz"),
        squared_radius: r * r,
        x0: Traced::rounded("X", 3),
        y0: Traced::rounded("Y", 3),
    }
}

pub(super) fn middle_row() -> MiddleRow<Traced> {
    MiddleRow {
        y: Traced::float("Cy"),
        z: Traced::float("Cz"),
        r: Traced::float("r"),
        y0: Traced::rounded("Y", 3),
        dy: Traced::rounded("dY", 2),
    }
}

#[test]
fn parts_of_the_normal() {
    let derived = greatest(&middle().normal(), &[]);
    let of_row = greatest(&middle_row().normal()[..1], &[]);
    assert_counted("CROSS_BOUND", CROSS_BOUND, U, derived.max(of_row), 0);
}

/// From the computed `N`, whose own error is the other part of the bound.
#[test]
fn coefficients_of_depths() {
    let middle = middle();
    let normal @ [n_x, n_y, n_z] = middle.normal();
    let given = [(n_x, "Nx", 0), (n_y, "Ny", 0), (n_z, "Nz", 0)];
    let steps = ["dX", "dY"].map(|name| Traced::rounded(name, 2));
    let [_, k] = middle.k();
    let coefficients = middle.coefficients(normal, k, steps);
    // What `c` is wrong by is extra. The scale is a power of two.
    let [_, squared_scale] = over_power(Traced::constant(1.0), Traced::rounded("c", 0));
    let scaled = coefficients.map(|of| of * squared_scale);
    let derived = greatest(&scaled, &given);
    let row = middle_row();
    let normal @ [n0, _] = row.normal();
    let of_row = row.coefficients(normal, Traced::constant(1.0));
    let of_row = greatest(&of_row, &[(n0, "N0", 0)]);
    assert!(of_row <= derived, "{of_row} in a row");
    assert_counted("COEFFICIENT_BOUND", COEFFICIENT_BOUND, U, derived, 0);
}

#[test]
fn depths_in_floats() {
    let d = ["d00", "d10", "d01", "d20", "d11", "d02"].map(|name| Traced::rounded(name, 1));
    let b = ["b00", "b10", "b01"].map(|name| Traced::rounded(name, 1));
    let (p, q) = (Traced::rounded("p", 0), Traced::rounded("q", 0));
    let (d, b) = in_column(d, b, p);
    let [d, b] = in_row(d, b, q);
    let spread = Traced::rounded("spread", 0);
    // Taking away the bound rounds as well. `c` is a share of a unit: see below.
    let derived = greatest(&[d - spread], &[]);
    assert_counted("D_BOUND", D_BOUND, U32, derived, 1);
    let derived = greatest(&[b], &[]);
    assert_counted("B_BOUND", B_BOUND, U32, derived, 1);
    // (b + sqrt d) - spread: of the parts.
    let lower = (b + Traced::rounded("root", 1)) - spread;
    let derived = greatest(&[lower], &[(b, "b", 0)]);
    assert_counted("SUM_OF_PARTS_BOUND", SUM_OF_PARTS_BOUND, U32, derived, 0);
    // A bound is part of `d00` or of `b00`, and its spread is twice as great.
    let twice = |of: Traced, part: &str| {
        let [part, spread] = [part, "spread"].map(|name| count_of(of, name));
        part + 2 * spread
    };
    let lower = (b + Traced::rounded("root", 0)) - spread;
    let derived = twice(lower, "b00").max(twice(d - spread, "d00"));
    assert_counted("DEPTH_INFLATION", DEPTH_INFLATION, U32, derived, 0);
}

/// The roundings of the term that is this input alone.
fn count_of(of: Traced, name: &str) -> u32 {
    let count = |fused| Counter::new(fused).terms(of).terms[&vec![name.to_string()]];
    count(false).max(count(true))
}

#[test]
fn planes_of_depths() {
    // The scale is a power of two.
    let [scale, _] = over_power(Traced::constant(1.0), Traced::rounded("c", 0));
    let derived = greatest(&[middle().dot() * scale], &[]);
    assert_counted("PLANE_BOUND", PLANE_BOUND, U, derived, 0);
}

/// Of spheres that are not equal.
#[test]
fn radical_planes() {
    let [tested, other] = [["x", "y", "z", "r"], ["x'", "y'", "z'", "r'"]];
    let [tested, other] = [tested, other].map(|names| names.map(Traced::float));
    let (_, difference) = power_difference(tested, other);
    let roundings = greatest(&[difference], &[]);
    assert_counted("DIFFERENCE_BOUND", DIFFERENCE_BOUND, U, roundings, 1);
    let of_terms = f64::from(roundings + 1) * U / CANCELLATION_LIMIT;
    let of_powers = 2_f64.powi(-32) / POWERS_CANCELLATION_LIMIT;

    let b = ["b00", "b10", "b01"].map(|name| Traced::rounded(name, 0));
    let ray = [("X", 3), ("Y", 3), ("dX", 2), ("dY", 2)];
    let ray = ray.map(|(name, roundings)| Traced::rounded(name, roundings));
    let power = Traced::rounded("c' - c", 0);
    let plane = radical_plane(tested, other, Traced::constant(2.0) / power, ray, b);
    // `b` has its roundings already, and is wrong by what `c` is.
    let roundings = greatest(&plane, &[]).max(9);
    assert_counted("PLANE_ROUNDINGS", PLANE_ROUNDINGS, U, roundings, 1);
    let roundings = f64::from(roundings + 1) * U;
    let derived = of_terms.max(of_powers) + 2_f64.powi(-32) + roundings;
    assert_least("PLANE_TERMS_BOUND", PLANE_TERMS_BOUND, derived);

    let d = ["d00", "d10", "d01", "d20", "d11", "d02"].map(|name| Traced::rounded(name, 1));
    let l = ["l00", "l10", "l01"].map(|name| Traced::rounded(name, 1));
    let (d, l) = in_column(d, l, Traced::rounded("p", 0));
    let [d, l] = in_row(d, l, Traced::rounded("q", 0));
    let derived = greatest(&[l], &[]);
    assert_counted("PLANE_SIDE_BOUND", PLANE_SIDE_BOUND, U32, derived, 1);
    let side = d - l * l;
    let derived = greatest(&[side], &[(d, "d", 0), (l, "l", 0)]);
    assert_counted("SIDE_BOUND", SIDE_BOUND, U32, derived, 0);
    // The difference is the last rounding of `d`.
    assert!(f64::from(greatest(&[d - Traced::rounded("l l", 0)], &[]) + 1) <= D_BOUND / U32);
}

#[test]
fn rows_in_doubles() {
    let [rising, level] = middle_row().ahead();
    let ahead = rising * Traced::rounded("q", 0) + level;
    let derived = greatest(&[ahead], &[]);
    assert_counted("ROW_BOUND", ROW_BOUND, U, derived, 0);
    // What `k` is wrong by is extra.
    let scale = Traced::rounded("scale", 2);
    let [h, factor] = row_factor(scale, Traced::rounded("c", 7), Traced::rounded("k", 0));
    let hx = h * Traced::float("Cx");
    let middle = row_middle(Traced::rounded("middle", 0), hx, [rising, level]);
    let derived = greatest(&middle, &[]);
    assert_counted("MIDDLE_BOUND", MIDDLE_BOUND, U, derived, 4);
    let derived = greatest(&[factor], &[]);
    assert_counted("FACTOR_BOUND", FACTOR_BOUND, U, derived, 0);
}

#[test]
fn what_k_is_wrong_by() {
    let [yz, k] = middle().k();
    assert_eq!(K_SQUARES_BOUND, f64::from(greatest(&[yz], &[])) * U);
    let derived = greatest(&[k], &[(yz, "yz", 0)]);
    assert_counted("K_BOUND", K_BOUND, U, derived, 0);
    // As many roundings of `k` more make so many times as many of the factor.
    let factor = |roundings: u32| {
        let k = Traced::rounded("k", roundings);
        let x = Traced::float("Cx");
        let [_, factor] = row_factor(Traced::rounded("scale", 2), x.times_plus(x, k), k);
        greatest(&[factor], &[])
    };
    let derived = (factor(100) - factor(0)) / 100;
    assert_counted("FACTOR_ERRORS_OF_K", FACTOR_ERRORS_OF_K, 1.0, derived, 0);
}

#[test]
fn rows_in_floats() {
    let q = Traced::rounded("q", 0);
    let e = quadratic(["e0", "e1", "e2"].map(|name| Traced::rounded(name, 1)), q);
    let bound = Traced::rounded("bound", 0);
    let derived = greatest(&[e - bound], &[]);
    assert_counted("ROW_SQUARE_BOUND", ROW_SQUARE_BOUND, U32, derived, 1);
    let middle = Traced::rounded("m1", 1).times_plus(q, Traced::rounded("m0", 1));
    let root = (e - bound).root();
    let low = (middle - Traced::rounded("slack", 0)) - root;
    let derived = greatest(&[low], &[(e - bound, "e", 0), (root, "root", 1)]);
    assert_counted("ROW_END_BOUND", ROW_END_BOUND, U32, derived, 2);
    // The bounds as floats.
    let [slack, bound] = ["slack", "bound"].map(|name| Traced::rounded(name, 1));
    let low = (middle - slack) - Traced::rounded("root", 0);
    let derived = count_of(low, "slack").max(count_of(e - bound, "bound"));
    assert_counted("ROW_INFLATION", ROW_INFLATION, U32, derived, 0);
}

/// A ray and a sphere.
pub(super) fn sight() -> Sight<Traced> {
    let v = [
        Traced::rounded("x", 2),
        Traced::rounded("y", 2),
        Traced::float("z"),
    ];
    let sphere = ["Cx", "Cy", "Cz", "r"].map(Traced::float);
    Sight::new(sphere, v, squared_length(v))
}

/// `c`, and `A` where it is no more than a divisor or a dividend.
pub(super) fn power() -> Traced {
    Traced::rounded("c", 7)
}

pub(super) fn squared_ray_of_sight() -> Traced {
    Traced::rounded("A", 7)
}

/// The numbers on the way to the lower bound of a sphere that is seen from outside.
pub(super) struct OnTheWay {
    pub(super) lower: Traced,
    b: Traced,
    b_bound: Traced,
    d: Traced,
    pub(super) squared_radius: Traced,
    pub(super) squared_cross: Traced,
    pub(super) normal: [Traced; 3],
}

impl OnTheWay {
    pub(super) fn find() -> Self {
        let [lower, _] = sight().seen_from_outside(power());
        let [quotient, _] = lower.operands();
        let [sum, _] = quotient.operands();
        let bounds = Self::bounds_of(sum.operands());
        let [b, b_bound, d, _] = [0, 1, 2, 3].map(|at: usize| bounds[at].0);
        let [squared_radius, squared_cross] = d.operands();
        let [two, z] = squared_cross.operands();
        let [one, y] = two.operands();
        let [zero, x] = one.operands();
        assert_eq!(zero.constant_value(), Some(0.0));
        let normal = [x, y, z].map(|square| square.operands()[0]);
        Self {
            lower,
            b,
            b_bound,
            d,
            squared_radius,
            squared_cross,
            normal,
        }
    }

    /// `b`, `d` and their bounds, of the bound of `b` and of the root that a quotient sums.
    pub(super) fn bounds_of([b_end, root]: [Traced; 2]) -> Vec<(Traced, &'static str, u32)> {
        let [b, b_bound] = b_end.operands();
        let [d, d_bound] = root.square().operands();
        vec![
            (b, "b", 0),
            (b_bound, "b_bound", 0),
            (d, "d", 0),
            (d_bound, "d_bound", 0),
        ]
    }

    pub(super) fn bounds(&self) -> Vec<(Traced, &'static str, u32)> {
        let [quotient, _] = self.lower.operands();
        Self::bounds_of(quotient.operands()[0].operands())
    }
}

#[test]
fn sights() {
    let [numerator, denominator] = ["m", "n"].map(|name| Traced::rounded(name, 0));
    let x = component(Traced::float("w"), numerator, denominator);
    assert_eq!(greatest(&[x], &[]), 2);
    assert_eq!(
        greatest(
            &[squared_length(
                ["x", "y", "z"].map(|name| Traced::rounded(name, 2))
            )],
            &[]
        ),
        7
    );
    let way = OnTheWay::find();
    let counted = |name: &str, constant: f64, derived: u32, slack: u32| {
        assert_counted(name, constant, U, derived, slack);
    };
    counted("SIGHT_CROSS", SIGHT_CROSS, greatest(&way.normal, &[]), 0);
    counted("SIGHT_DOT", SIGHT_DOT, greatest(&[way.b], &[]), 0);
    // Each with its share of the difference.
    let [n_x, n_y, n_z] = way.normal;
    let normal = [(n_x, "Nx", 0), (n_y, "Ny", 0), (n_z, "Nz", 0)];
    let radius = greatest(&[way.squared_radius], &normal) + 1;
    counted("SIGHT_SQUARED_RADIUS", SIGHT_SQUARED_RADIUS, radius, 0);
    let cross = greatest(&[way.squared_cross], &normal) + 1;
    counted("SIGHT_SQUARED_CROSS", SIGHT_SQUARED_CROSS, cross, 0);
    assert_eq!(greatest(&[way.d], &normal), radius.max(cross));
    // From the bounds of b and d on: (b - b_bound + sqrt(d - d_bound))/c and its own share.
    let derived = greatest(&[way.lower], &way.bounds());
    counted("SIGHT_QUOTIENT", SIGHT_QUOTIENT, derived, 7);
}

#[test]
fn powers_of_hits() {
    let [first, second] = [["x", "y", "z", "r"], ["x'", "y'", "z'", "r'"]];
    let [first, second] = [first, second].map(|names| names.map(Traced::float));
    let v = [("Vx", 2), ("Vy", 2), ("Vz", 0)];
    let v = v.map(|(name, roundings)| Traced::rounded(name, roundings));
    let [lower, upper] = ["lower", "upper"].map(|name| Traced::rounded(name, 0));
    let ([power, ..], f) = difference_at(first, second, v, upper);
    let [product, along] = f.operands();
    // Each with its share of the difference; the other part of the bound is summed with two more.
    let of_width = greatest(&[power.magnitude() * (upper - lower)], &[]) + 2;
    let derived = greatest(&[product], &[]) + 1 + of_width;
    assert_counted("SIGHT_POWER", SIGHT_POWER, U, derived, 1);
    let derived = greatest(&[along], &[]) + 1;
    assert_counted("SIGHT_ALONG", SIGHT_ALONG, U, derived, 0);
}

/// Each bound of an inverse depth has the ends of `B` and of the root on its side.
#[test]
fn bounds_of_inverse_depths_have_the_ends_on_their_side() {
    let (lower, upper) = (-4.0, -2.0);
    let sight = Sight {
        b: Ahead {
            value: -3.0,
            lower,
            upper,
        },
        d: Discriminant {
            value: 36.0,
            bound: 11.0,
        },
        root_lower: 5.0,
        root_upper: 7.0,
    };
    for (bounds, expected) in [
        (sight.seen_from_outside(2.0), [0.5, 2.5]),
        (sight.seen_ahead_from_inside(10.0), [2.0, 10.0]),
        (sight.seen_back_from_inside(-2.0), [3.5, 5.5]),
        (sight.seen_from_the_surface(-8.0), [2.0, 1.0]),
    ] {
        let factors = [1.0 - SIGHT_QUOTIENT, 1.0 + SIGHT_QUOTIENT];
        assert_eq!(bounds, [0, 1].map(|at: usize| expected[at] * factors[at]));
    }
}

/// The bound of `B` has every term that `B` has.
#[test]
fn bounds_of_sights_have_all_terms() {
    let way = OnTheWay::find();
    let counter = Counter::new(false);
    let [units, terms] = way.b_bound.operands();
    assert_eq!(units.constant_value(), Some(SIGHT_DOT));
    let names = |of: Traced| counter.terms(of).terms.into_keys().collect::<Vec<_>>();
    assert_eq!(names(way.b), names(terms));
}

/// `k` loses two units of `yz`; where it is used, `k > CANCELLATION_LIMIT yz` is left, so it is
/// within `2^-32` of itself, as the bounds of floats take it to be.
#[test]
fn what_cancels_is_less_than_a_share_of_a_float() {
    let [_, k] = middle().k();
    let x = Traced::float("Cx");
    let exactly = 7;
    let derived = greatest(&[x.times_plus(x, k)], &[]).max(exactly);
    assert_counted("POWER_BOUND", POWER_BOUND, U, derived, 0);
    let derived = f64::from(greatest(&[k], &[]));
    assert!(derived * U / CANCELLATION_LIMIT <= NEARLY);
    // And no more is asked of k than that.
    assert!(2.0 * derived * U / CANCELLATION_LIMIT > NEARLY);
}

/// Of coefficients that are rounded to floats, with the greatest `p` and `q` of a tile.
#[test]
fn what_underflows_is_less_than_the_least_bound() {
    let unit = (-150.0_f64).exp2();
    let most = f64::from(SIDE as u32) / 2.0 + LANES as f64 + 1.0;
    let greatest = BTreeMap::from([("p", most), ("q", most)]);
    let d = ["d00", "d10", "d01", "d20", "d11", "d02"].map(|name| Traced::rounded(name, 1));
    let b = ["b00", "b10", "b01"].map(|name| Traced::rounded(name, 1));
    let (p, q) = (Traced::rounded("p", 0), Traced::rounded("q", 0));
    let (d, b) = in_column(d, b, p);
    let [d, b] = in_row(d, b, q);
    let e = quadratic(["e0", "e1", "e2"].map(|name| Traced::rounded(name, 1)), q);
    let lost = [d, b, e].map(|of| of.lost_units(&greatest));
    let most = lost.into_iter().fold(0.0, f64::max);
    // One unit more for a bound that is itself rounded to a float, and one for doubles.
    assert!((most + 2.0) * unit < UNDERFLOW_BOUND, "{lost:?}");
    assert!(most * unit > UNDERFLOW_BOUND / 2.0, "{lost:?}");
}

/// A power of 4 has an exact root.
#[test]
fn the_root_of_the_sure_share_is_exact() {
    let fraction = |value: f64| value.to_bits() << 12;
    assert_eq!([SURE_SHARE, SURE_SHARE.sqrt()].map(fraction), [0, 0]);
}

/// Half of the distance from 1 to the number after it.
#[test]
fn units_are_those_of_the_formats() {
    assert_eq!(1.0_f64.next_up() - 1.0, 2.0 * U);
    assert_eq!(f64::from(1.0_f32.next_up() - 1.0), 2.0 * U32);
}

/// On whole numbers, of which nothing is rounded.
#[test]
fn every_number_has_the_operations_that_are_counted() {
    fn results<N: Number>() -> [N; 4] {
        let [two, three, five] = [2.0, 3.0, 5.0].map(N::constant);
        [
            two.times_plus(three, five),
            two.times_minus(three, five),
            two.times_from(three, five),
            N::constant(49.0).root(),
        ]
    }
    let expected = [11.0, 1.0, -1.0, 7.0];
    assert_eq!(results::<f64>(), expected);
    assert_eq!(results::<wide::f64x8>(), expected.map(wide::f64x8::splat));
    assert_eq!(
        results::<wide::f32x8>(),
        expected.map(|value| wide::f32x8::splat(value as f32))
    );
    assert_eq!(results::<Traced>().map(Traced::value), expected);
}
