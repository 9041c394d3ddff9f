//! Scripts for Gappa, which proves bounds of what formulas round: of the formulas that run,
//! as they are [traced](super::trace), with goals printed from the constants.
//!
//! `make proof` writes them and has them checked. Each is written twice where fused and
//! unfused operations differ. Where a constant is more than half needed, the goal is
//! written again with half of it, and Gappa has to refuse that.
//!
//! Gappa is asked what is relative to one quantity. Numbers of one sign are given as
//! positive ones; a term that is 0 has no error. Underflow is left to the proof: ranges keep
//! away from it.

use std::{
    collections::{BTreeMap, BTreeSet},
    fmt::Write as _,
    fs,
    path::Path,
};

use super::{
    tests::{OnTheWay, middle, middle_row, power, sight, squared_ray_of_sight},
    trace::{Operation, Traced},
    *,
};
use crate::exact::kernels::{before, farthest, row_factor, touching, touching_beside};

/// A script as it grows.
struct Script {
    fused: bool,
    lines: String,
    hypotheses: Vec<String>,
    hints: Vec<String>,
    /// Ranges of exact numbers by their names: from one power of two to another.
    ranges: BTreeMap<&'static str, (i32, i32)>,
    given: BTreeMap<Traced, (&'static str, u32)>,
    /// Numbers that have their names.
    named: BTreeMap<Traced, Pair>,
    inputs: BTreeSet<&'static str>,
}

/// The computed number and the exact one.
type Pair = [String; 2];

/// A double as Gappa reads it, exactly.
fn exactly(value: f64) -> String {
    let (mut fraction, mut exponent) = (value, 0);
    while fraction != fraction.trunc() {
        fraction *= 2.0;
        exponent -= 1;
    }
    format!("{fraction:.0}b{exponent}")
}

impl Script {
    fn new(fused: bool, ranges: &[(&'static str, i32, i32)]) -> Self {
        let ranges = ranges.iter().map(|&(name, low, high)| (name, (low, high)));
        Self {
            fused,
            lines: "@double = float<ieee_64, ne>;\n@single = float<ieee_32, ne>;\n".into(),
            hypotheses: Vec::new(),
            hints: Vec::new(),
            ranges: ranges.collect(),
            given: BTreeMap::new(),
            named: BTreeMap::new(),
            inputs: BTreeSet::new(),
        }
    }

    /// Numbers that are taken as they were computed, or as known within so many roundings.
    fn given(mut self, numbers: &[(Traced, &'static str, u32)]) -> Self {
        let given = numbers.iter();
        self.given
            .extend(given.map(|&(number, name, roundings)| (number, (name, roundings))));
        self
    }

    fn suppose(&mut self, what: String) {
        self.hypotheses.push(what);
    }

    fn suppose_between(&mut self, what: &str, (low, high): (i32, i32)) {
        self.suppose(format!("{what} in [1b{low}, 1b{high}]"));
    }

    fn input(&mut self, name: &'static str, roundings: u32, float: bool) -> Pair {
        let exact = if roundings == 0 {
            name.to_string()
        } else {
            format!("{name}_exact")
        };
        if self.inputs.insert(name) {
            if float {
                writeln!(self.lines, "{name} = single({name}_);").expect("a string");
            }
            if roundings > 0 {
                // n u/(1 - n u) and a little more.
                let bound = exactly(f64::from(roundings) * U * (1.0 + U32));
                self.suppose(format!("{name} -/ {exact} in [-{bound}, {bound}]"));
            }
            if let Some(&range) = self.ranges.get(name) {
                self.suppose_between(&exact, range);
            }
        }
        [name.into(), exact]
    }

    /// Writes the lines that a number is made of.
    fn number(&mut self, of: Traced) -> Pair {
        if let Some(pair) = self.named.get(&of) {
            return pair.clone();
        }
        if let Some(&(name, roundings)) = self.given.get(&of) {
            return self.input(name, roundings, false);
        }
        let operation = of.operation();
        let both = |script: &mut Self, [a, b]: [Traced; 2], sign: &str| {
            let (a, b) = (script.number(a), script.number(b));
            [0, 1].map(|at: usize| format!("({} {sign} {})", a[at], b[at]))
        };
        let [computed, exact] = match operation {
            Operation::Input {
                name,
                roundings,
                float,
            } => return self.input(name, roundings, float),
            Operation::Constant(value) => return [exactly(value), exactly(value)],
            Operation::Negative(of) => {
                return self.number(of).map(|number| format!("(-{number})"));
            }
            Operation::Magnitude(of) => return self.number(of),
            Operation::Sum([zero, of]) if zero.constant_value() == Some(0.0) => {
                return self.number(of);
            }
            Operation::Sum(of) => both(self, of, "+"),
            Operation::Difference(of) => both(self, of, "-"),
            Operation::Product(of) => both(self, of, "*"),
            Operation::Quotient(of) => both(self, of, "/"),
            Operation::Fused([a, b, c], signs) => {
                let product = if self.fused {
                    both(self, [a, b], "*")
                } else {
                    self.rounded_product(a, b)
                };
                let c = self.number(c);
                [0, 1].map(|at: usize| match signs {
                    [true, true] => format!("({} + {})", product[at], c[at]),
                    [true, false] => format!("({} - {})", product[at], c[at]),
                    _ => format!("({} - {})", c[at], product[at]),
                })
            }
            Operation::Root(of) => self.number(of).map(|number| format!("sqrt({number})")),
        };
        let pair = self.name(&format!("double({computed})"), &exact);
        self.named.insert(of, pair.clone());
        pair
    }

    fn rounded_product(&mut self, a: Traced, b: Traced) -> Pair {
        let (a, b) = (self.number(a), self.number(b));
        let computed = format!("double({} * {})", a[0], b[0]);
        self.name(&computed, &format!("({} * {})", a[1], b[1]))
    }

    fn name(&mut self, computed: &str, exact: &str) -> Pair {
        let at = self.lines.lines().count();
        let pair = [format!("t{at}"), format!("t{at}_exact")];
        writeln!(
            self.lines,
            "{} = {computed};\n{} = {exact};",
            pair[0], pair[1]
        )
        .expect("a string");
        pair
    }

    /// The whole script, with a goal.
    fn prove(&self, goal: &str) -> String {
        let Self {
            lines,
            hypotheses,
            hints,
            ..
        } = self;
        let mut script = format!("{lines}{{ {} -> {goal} }}\n", hypotheses.join("\n /\\ "));
        for hint in hints {
            writeln!(script, "{hint};").expect("a string");
        }
        script
    }
}

/// What a sight makes of a quotient, by a share of its units, is not above it, or not below.
fn outward(script: &mut Script, [quotient, exact]: &Pair, sign: f64, share: f64) -> String {
    let factor = exactly(1.0 + sign * share * SIGHT_QUOTIENT);
    let result = format!("double({quotient} * {factor})");
    script.hints.extend([
        format!(
            "{result} / {exact} -> (1 + ({result} - {quotient} * {factor}) / ({quotient} * {factor})) \
             * {factor} * (1 + ({quotient} - {exact}) / {exact}) {{ {exact} <> 0, {quotient} <> 0 }}"
        ),
    ]);
    let range = if sign < 0.0 { "[0.5, 1]" } else { "[1, 2]" };
    script.prove(&format!("{result} / {exact} in {range}"))
}

/// `computed` is within a share of the exact number.
fn within([computed, exact]: &Pair, bound: f64) -> String {
    let bound = exactly(bound);
    format!("{computed} -/ {exact} in [-{bound}, {bound}]")
}

/// Floats of the scene, coordinates of a ray as they are, and at distance 1.
const LENGTHS: [(&str, i32, i32); 4] = [
    ("Cx", -149, 128),
    ("Cy", -149, 128),
    ("Cz", -149, 128),
    ("r", -149, 128),
];
const RAY: [(&str, i32, i32); 2] = [("x", -182, 128), ("y", -182, 128)];
const GRID: [(&str, i32, i32); 4] = [
    ("X", -310, 283),
    ("Y", -310, 283),
    ("dY", -309, 277),
    ("scale", -277, 309),
];

fn ranges(of: &[&[(&'static str, i32, i32)]]) -> Vec<(&'static str, i32, i32)> {
    of.concat()
}

/// A script of one formula, with its bound or a part of it.
type Formula = fn(fused: bool, share: f64) -> String;

/// Of each: whether half of the bound is to be refused.
const FORMULAS: [(&str, Formula, bool); 16] = [
    ("sight-squared-radius", sight_squared_radius, true),
    ("sight-squared-cross", sight_squared_cross, true),
    ("sight-lower-outside", sight_lower_outside, true),
    ("sight-upper-outside", sight_upper_outside, true),
    ("sight-upper-inside", sight_upper_inside, true),
    ("sight-lower-inside-behind", sight_lower_inside_behind, true),
    ("row-factor", factor_of_rows, true),
    ("row-factor-with-k", factor_of_rows_with_k, false),
    ("row-middle", middle_of_rows, true),
    ("normal-x", normal_x, true),
    ("normal-row", normal_of_rows, true),
    ("k", k_of_outlines, true),
    ("box-before", box_before, true),
    ("box-beside-ahead", box_beside_ahead, true),
    ("outline-lower", outline_lower, true),
    ("float-above", above_in_floats, true),
];

fn sight_squared_radius(fused: bool, share: f64) -> String {
    let way = OnTheWay::find();
    let ranges = ranges(&[&LENGTHS, &RAY, &[("z", -149, 128)]]);
    let mut script = Script::new(fused, &ranges);
    let pair = script.number(way.squared_radius);
    // A unit is left for the difference.
    script.prove(&within(&pair, SIGHT_SQUARED_RADIUS * share - U))
}

fn sight_squared_cross(fused: bool, share: f64) -> String {
    let way = OnTheWay::find();
    let [x, y, z] = way.normal;
    let ranges = ["Nx", "Ny", "Nz"].map(|name| (name, -384, 260));
    let mut script = Script::new(fused, &ranges).given(&[(x, "Nx", 0), (y, "Ny", 0), (z, "Nz", 0)]);
    let pair = script.number(way.squared_cross);
    script.prove(&within(&pair, SIGHT_SQUARED_CROSS * share - U))
}

/// A bound of a sight: its quotient, without the factor, from `b`, `d` and their bounds on.
fn quotient_of_sight(script: &mut Script, bound: Traced, inside: bool) -> Pair {
    let [quotient, _] = bound.operands();
    let pair = script.number(quotient);
    let range = if inside { (-298, 258) } else { (-400, 400) };
    for name in ["b", "d"] {
        let less = format!("{name} - {name}_bound");
        let more = format!("{name} + {name}_bound");
        let [text, ..] = [&less, &more]
            .into_iter()
            .filter(|text| script.lines.contains(text.as_str()))
            .collect::<Vec<_>>()[..]
        else {
            panic!("no bound of {name} in {}", script.lines);
        };
        let text = text.clone();
        script.suppose_between(&text, range);
    }
    pair
}

const OF_SIGHTS: [(&str, i32, i32); 2] = [("c", -298, 258), ("A", -298, 258)];

fn sight_lower_outside(fused: bool, share: f64) -> String {
    let way = OnTheWay::find();
    let mut script = Script::new(fused, &OF_SIGHTS).given(&way.bounds());
    let pair = quotient_of_sight(&mut script, way.lower, false);
    outward(&mut script, &pair, -1.0, share)
}

fn sight_upper_outside(fused: bool, share: f64) -> String {
    let [_, upper] = sight().seen_from_outside(power());
    let [quotient, _] = upper.operands();
    let [sum, _] = quotient.operands();
    let given = OnTheWay::bounds_of(sum.operands());
    let mut script = Script::new(fused, &OF_SIGHTS).given(&given);
    let pair = quotient_of_sight(&mut script, upper, false);
    outward(&mut script, &pair, 1.0, share)
}

/// `A/(R + f)` where `f = b - b_bound` is negative, and no more than half of the root.
fn sight_upper_inside(fused: bool, share: f64) -> String {
    let [_, upper] = sight().seen_ahead_from_inside(squared_ray_of_sight());
    let [quotient, _] = upper.operands();
    let [_, sum] = quotient.operands();
    let [root, b_lower] = sum.operands();
    let given = OnTheWay::bounds_of([b_lower, root]);
    let mut script = Script::new(fused, &OF_SIGHTS).given(&given);
    let [[r, r_exact], [f, f_exact]] = [script.number(root), script.number(b_lower)];
    let pair = script.number(quotient);
    script.suppose_between("d - d_bound", (-400, 400));
    script.suppose_between("b_bound - b", (-400, 400));
    let sum_exact = script.number(sum)[1].clone();
    script.suppose_between(&sum_exact, (-400, 400));
    script.suppose(format!("{f_exact} in [-1b400, -1b-400]"));
    script.suppose(format!("{f_exact} / {r_exact} in [-0.5, 0]"));
    script.hints.push(format!(
        "(({r} + {f}) - ({r_exact} + {f_exact})) / ({r_exact} + {f_exact}) -> \
         (({r} - {r_exact}) / {r_exact} + (({f} - {f_exact}) / {f_exact}) * ({f_exact} / {r_exact})) \
         / (1 + {f_exact} / {r_exact}) {{ {r_exact} <> 0, {f_exact} <> 0, {r_exact} + {f_exact} <> 0 }}"
    ));
    outward(&mut script, &pair, 1.0, share)
}

/// `(R - f)/-c` where `B < 0`.
fn sight_lower_inside_behind(fused: bool, share: f64) -> String {
    let [lower, _] = sight().seen_back_from_inside(power());
    let [quotient, _] = lower.operands();
    let [difference, inner] = quotient.operands();
    let [root, b_upper] = difference.operands();
    let mut given = OnTheWay::bounds_of([b_upper, root]);
    given.push((inner, "c", 7));
    let mut script = Script::new(fused, &OF_SIGHTS).given(&given);
    let pair = script.number(quotient);
    script.suppose_between("d - d_bound", (-400, 400));
    script.suppose("b + b_bound in [-1b400, -1b-400]".into());
    outward(&mut script, &pair, -1.0, share)
}

fn row_factors(fused: bool, k_bound: f64) -> (Script, Pair) {
    let (scale, k) = (Traced::rounded("scale", 2), Traced::rounded("k", 0));
    let [_, factor] = row_factor(scale, Traced::rounded("c", 7), k);
    let ranges = ranges(&[&GRID, &[("c", -298, 258), ("k", -298, 258)]]);
    let mut script = Script::new(fused, &ranges);
    if k_bound > 0.0 {
        let bound = exactly(k_bound);
        script.ranges.remove("k");
        script.suppose(format!("k -/ k_exact in [-{bound}, {bound}]"));
        script.suppose_between("k_exact", (-298, 258));
        script.inputs.insert("k");
        script.named.insert(k, ["k".into(), "k_exact".into()]);
    }
    let [once, h] = factor.operands().map(|of| script.number(of)[0].clone());
    let pair = script.number(factor);
    script.suppose_between(&format!("({once} * {h})"), (-1000, 1000));
    (script, pair)
}

fn factor_of_rows(fused: bool, share: f64) -> String {
    let (script, pair) = row_factors(fused, 0.0);
    script.prove(&within(&pair, FACTOR_BOUND * share))
}

/// Four times what `k` is wrong by is added.
fn factor_of_rows_with_k(fused: bool, share: f64) -> String {
    let k_bound = (-32.0_f64).exp2();
    let (script, pair) = row_factors(fused, k_bound);
    script.prove(&within(&pair, (FACTOR_BOUND + 4.0 * k_bound) * share))
}

/// Where `Cy Y` and `Cz` have one sign.
fn middle_of_rows(fused: bool, share: f64) -> String {
    let scale = Traced::rounded("scale", 2);
    let [h, _] = row_factor(scale, Traced::rounded("c", 0), Traced::rounded("k", 0));
    let [_, level] = middle_row().ahead();
    let middle = h * Traced::float("Cx") * level;
    let ranges = ranges(&[&LENGTHS, &GRID, &[("c", -298, 258), ("k", -298, 258)]]);
    let mut script = Script::new(fused, &ranges);
    let pair = script.number(middle);
    // One rounding is that of the sum with the picture's middle.
    script.prove(&within(&pair, MIDDLE_BOUND * share - U))
}

/// `y - z Y`, of the sum `S` of both magnitudes.
fn difference_with_product(
    fused: bool,
    share: f64,
    of: Traced,
    [term, factor, by]: [&'static str; 3],
) -> String {
    let fused = fused && matches!(of.operation(), Operation::Fused(..));
    let mut script = Script::new(fused, &ranges(&[&LENGTHS, &GRID]));
    let [n, exact] = script.number(of);
    // Above underflow, as if nothing were there beyond.
    for what in [
        format!("|{n}|"),
        format!("|{term} - {factor} * {by}|"),
        "S".to_string(),
        format!("({factor} * {by})"),
    ] {
        script.suppose_between(&what, (-700, 700));
    }
    script.suppose(format!("|{term} / S| <= 1"));
    script.suppose(format!("|({factor} * {by}_exact) / S| <= 1"));
    script.suppose(format!("|{exact} / S| <= 1"));
    let line = |name: &str| {
        let start = format!("{name} = double(");
        let line = script.lines.lines().find(|line| line.starts_with(&start));
        let inner = &line.expect("a line")[start.len()..];
        inner[..inner.len() - 2].to_string()
    };
    let before = line(&n);
    script.suppose_between(&format!("|{before}|"), (-700, 700));
    let (product, lost) = if fused {
        (format!("({factor} * {by})"), None)
    } else {
        let product = before
            .trim_matches(['(', ')'])
            .split(" - ")
            .nth(1)
            .expect("a product")
            .to_string();
        let lost = format!("({product} - {factor} * {by}) / S");
        (product, Some(lost))
    };
    let moved = format!("({factor} * {by} - {factor} * {by}_exact) / S");
    let (n_exact, given) = (&exact, "{ S <> 0 }");
    let errors = lost
        .as_ref()
        .map_or(moved.clone(), |lost| format!("({lost} + {moved})"));
    script.hints.extend([
        format!("({n} - {n_exact}) / S -> ({n} - {before}) / S + ({before} - {n_exact}) / S {given}"),
        format!("({n} - {before}) / S -> (({n} - {before}) / {before}) * ({before} / S) {{ S <> 0, {before} <> 0 }}"),
        format!("{before} / S -> {n_exact} / S + ({before} - {n_exact}) / S {given}"),
        format!("({before} - {n_exact}) / S -> -{errors} {given}"),
        format!(
            "{moved} -> (({factor} * {by}_exact) / S) * (({by} - {by}_exact) / {by}_exact) {{ S <> 0, {by}_exact <> 0 }}"
        ),
    ]);
    if let Some(lost) = lost {
        script.hints.push(format!(
            "{lost} -> (({product} - {factor} * {by}) / ({factor} * {by})) * (1 + ({by} - {by}_exact) / {by}_exact) \
             * (({factor} * {by}_exact) / S) {{ S <> 0, {factor} <> 0, {by} <> 0, {by}_exact <> 0 }}"
        ));
    }
    let bound = exactly(CROSS_BOUND * share);
    script.prove(&format!("|({n} - {n_exact}) / S| <= {bound}"))
}

fn normal_x(fused: bool, share: f64) -> String {
    let [n_x, ..] = middle().normal();
    difference_with_product(fused, share, n_x, ["Cy", "Cz", "Y"])
}

fn normal_of_rows(fused: bool, share: f64) -> String {
    let [n0, _] = middle_row().normal();
    difference_with_product(fused, share, n0, ["Cy", "Cz", "Y"])
}

/// `k`, of which a least share of `yz` is left.
fn k_of_outlines(fused: bool, share: f64) -> String {
    let [yz, k] = middle().k();
    let mut script = Script::new(fused, &LENGTHS);
    let [yz, yz_exact] = script.number(yz);
    let [_, square] = k.operands();
    let [square, square_exact] = script.number(square);
    let [k, k_exact] = script.number(k);
    let most = exactly(1.0 / (CANCELLATION_LIMIT * share));
    script.suppose(format!("|{yz} / {k}| <= {most}"));
    script.suppose_between(&format!("|{k}|"), (-700, 700));
    script.suppose_between(&format!("|{yz} - {square}|"), (-700, 700));
    script.hints.extend([
        format!(
            "({k} - {k_exact}) / {k} -> ({k} - ({yz} - {square})) / {k} + ({yz} - {yz_exact}) / {k} \
             - ({square} - {square_exact}) / {k} {{ {k} <> 0 }}"
        ),
        format!(
            "({yz} - {yz_exact}) / {k} -> (({yz} - {yz_exact}) / {yz}) * ({yz} / {k}) {{ {k} <> 0, {yz} <> 0 }}"
        ),
        format!(
            "({yz} - {yz_exact}) / {yz} -> (({yz} - {yz_exact}) / {yz_exact}) \
             / (1 + ({yz} - {yz_exact}) / {yz_exact}) {{ {yz} <> 0, {yz_exact} <> 0 }}"
        ),
        format!(
            "({k} - ({yz} - {square})) / {k} -> (({k} - ({yz} - {square})) / ({yz} - {square})) \
             / (1 + ({k} - ({yz} - {square})) / ({yz} - {square})) {{ {k} <> 0, {yz} - {square} <> 0 }}"
        ),
    ]);
    let bound = exactly((-32.0_f64).exp2());
    script.prove(&format!("|({k} - {k_exact}) / {k}| <= {bound}"))
}

/// The greater end, which does not cancel; 3 units are left for the slack and the middle.
fn box_before(fused: bool, share: f64) -> String {
    let (x, z, r) = (Traced::float("Cx"), Traced::float("Cz"), Traced::float("r"));
    let [near, _, q, inverse] = before(z, r);
    let [_, high] = touching(x, [z, r, q], Traced::rounded("scale", 2) * inverse);
    let mut script = Script::new(fused, &ranges(&[&LENGTHS, &GRID]));
    let _ = script.number(near);
    script.suppose_between("(Cz - r)", (-149, 128));
    let pair = script.number(high);
    script.prove(&within(&pair, BOX_BOUND * share - 3.0 * U))
}

fn box_beside_ahead(fused: bool, share: f64) -> String {
    let (x, z, r) = (Traced::float("Cx"), Traced::float("Cz"), Traced::float("r"));
    let [ahead, _] = touching_beside([x, z, r], Traced::rounded("w", 7));
    let end = ahead * Traced::rounded("scale", 2);
    let ranges = ranges(&[&LENGTHS, &GRID, &[("w", -298, 258)]]);
    let mut script = Script::new(fused, &ranges);
    let pair = script.number(end);
    script.suppose_between("(Cx - r)", (-149, 128));
    script.prove(&within(&pair, BOX_BOUND * share - 3.0 * U))
}

/// With `c` as little known as it may be.
fn outline_lower(fused: bool, share: f64) -> String {
    let [x, y, z, r] = ["Cx", "Cy", "Cz", "r"].map(Traced::float);
    let [yz, _] = middle().k();
    let c = Traced::rounded("c", 0);
    let lower = farthest([x, y, z, r], yz, c);
    let mut script = Script::new(fused, &LENGTHS);
    let bound = exactly((-32.0_f64).exp2());
    script.suppose(format!("c -/ c_exact in [-{bound}, {bound}]"));
    script.suppose_between("c_exact", (-298, 258));
    script.named.insert(c, ["c".into(), "c_exact".into()]);
    let pair = script.number(lower);
    script.prove(&within(&pair, (-31.0_f64).exp2() * share))
}

/// [`float_above`](crate::exact::grid::float_above) is above, of normal floats that are known within
/// 98 roundings of doubles and what `c` of an outline is wrong by.
fn above_in_floats(_fused: bool, share: f64) -> String {
    let up = exactly(1.0 + TO_FLOAT * share);
    let known = exactly((-31.0_f64).exp2() + 100.0 * U);
    format!(
        "@double = float<ieee_64, ne>;\n@single = float<ieee_32, ne>;\n\
         up = {up};\n\
         once = double(value * up);\n\
         sum = once + 1b-149;\n\
         above = double(sum);\n\
         result = single(above);\n\
         {{ value in [1b-126, 1b127] /\\ value -/ exact in [-{known}, {known}] -> (result - exact) / exact >= 0 }}\n\
         (result - exact) / exact -> ((result - value) / value) * (1 + (value - exact) / exact) + (value - exact) / exact {{ value <> 0, exact <> 0 }};\n\
         (result - value) / value -> ((result - above) / above) * (above / value) + (above - value) / value {{ above <> 0, value <> 0 }};\n\
         above / value -> 1 + (above - value) / value {{ value <> 0 }};\n\
         (above - value) / value -> (above - sum) / value + (once - value * up) / value + (up - 1) + 1b-149 / value {{ value <> 0 }};\n\
         (once - value * up) / value -> ((once - value * up) / (value * up)) * up {{ value <> 0 }};\n\
         (above - sum) / value -> ((above - sum) / sum) * (sum / value) {{ value <> 0, sum <> 0 }};\n\
         sum / value -> (once - value * up) / value + up + 1b-149 / value {{ value <> 0 }};\n"
    )
}

/// Writes all scripts to a folder, and to another those that are to be refused.
#[test]
#[ignore = "for `make proof`, which has the scripts checked"]
fn write_the_scripts() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/proof");
    let refused = folder.join("refused");
    fs::create_dir_all(&refused).expect("a folder");
    for (name, formula, bites) in FORMULAS {
        let (unfused, fused) = (formula(false, 1.0), formula(true, 1.0));
        let ways = [("", false), ("-fused", true)];
        for (way, is_fused) in ways.into_iter().take(1 + usize::from(unfused != fused)) {
            let file = format!("{name}{way}.g");
            fs::write(folder.join(&file), formula(is_fused, 1.0)).expect("a script");
            if bites {
                fs::write(refused.join(&file), formula(is_fused, 0.5)).expect("a script");
            }
        }
    }
}
