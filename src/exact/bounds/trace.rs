//! A number that records what is done to it: the engine's own formulas, evaluated with it,
//! leave a graph of operations, in which roundings are counted.

use std::{
    cell::RefCell,
    collections::BTreeMap,
    ops::{Add, Div, Mul, Neg, Sub},
};

use crate::exact::kernels::Number;

/// An operation, of the places of its operands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Operation {
    /// An input, known within so many roundings. Products of two floats are exact in
    /// doubles.
    Input {
        name: &'static str,
        roundings: u32,
        float: bool,
    },
    Constant(f64),
    Sum([Traced; 2]),
    Difference([Traced; 2]),
    Product([Traced; 2]),
    Quotient([Traced; 2]),
    /// `a b + c`, `a b - c` or `c - a b`, rounded once or twice; the signs are those of
    /// `a b` and of `c`.
    Fused([Traced; 3], [bool; 2]),
    Root(Traced),
    Negative(Traced),
    Magnitude(Traced),
}

#[derive(Clone, Copy, Debug)]
struct Node {
    operation: Operation,
    /// What it is for the inputs at hand, to tell which way comparisons go.
    value: f64,
}

thread_local! {
    /// Grows with every operation of a test's thread.
    static NODES: RefCell<Vec<Node>> = const { RefCell::new(Vec::new()) };
}

/// A place in the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Traced(usize);

impl Traced {
    fn new(operation: Operation, value: f64) -> Self {
        NODES.with_borrow_mut(|nodes| {
            nodes.push(Node { operation, value });
            Self(nodes.len() - 1)
        })
    }

    /// A float of the scene.
    pub(super) fn float(name: &'static str) -> Self {
        Self::input(name, 0, true)
    }

    /// A number that is known within so many roundings.
    pub(super) fn rounded(name: &'static str, roundings: u32) -> Self {
        Self::input(name, roundings, false)
    }

    fn input(name: &'static str, roundings: u32, float: bool) -> Self {
        let operation = Operation::Input {
            name,
            roundings,
            float,
        };
        Self::new(operation, 1.0)
    }

    pub(super) fn operation(self) -> Operation {
        NODES.with_borrow(|nodes| nodes[self.0].operation)
    }

    pub(super) fn value(self) -> f64 {
        NODES.with_borrow(|nodes| nodes[self.0].value)
    }

    /// The operands of a sum, a difference, a product or a quotient.
    pub(super) fn operands(self) -> [Self; 2] {
        match self.operation() {
            Operation::Sum(of)
            | Operation::Difference(of)
            | Operation::Product(of)
            | Operation::Quotient(of) => of,
            other => panic!("{other:?} has not two operands"),
        }
    }

    /// What this is the root of.
    pub(super) fn square(self) -> Self {
        match self.operation() {
            Operation::Root(of) => of,
            other => panic!("{other:?} is no root"),
        }
    }

    pub(super) fn constant_value(self) -> Option<f64> {
        match self.operation() {
            Operation::Constant(value) => Some(value),
            _ => None,
        }
    }

    pub(super) fn magnitude(self) -> Self {
        Self::new(Operation::Magnitude(self), self.value().abs())
    }

    fn fused(of: [Self; 3], signs: [bool; 2]) -> Self {
        let [a, b, c] = of.map(Self::value);
        let signed = |sign: bool, value: f64| if sign { value } else { -value };
        let value = signed(signs[0], a * b) + signed(signs[1], c);
        Self::new(Operation::Fused(of, signs), value)
    }
}

macro_rules! operator {
    ($operator:ident, $function:ident, $operation:ident) => {
        impl $operator for Traced {
            type Output = Self;

            fn $function(self, other: Self) -> Self {
                let value = self.value().$function(other.value());
                Self::new(Operation::$operation([self, other]), value)
            }
        }
    };
}

operator!(Add, add, Sum);
operator!(Sub, sub, Difference);
operator!(Mul, mul, Product);
operator!(Div, div, Quotient);

impl Neg for Traced {
    type Output = Self;

    fn neg(self) -> Self {
        Self::new(Operation::Negative(self), -self.value())
    }
}

impl Number for Traced {
    fn constant(value: f64) -> Self {
        Self::new(Operation::Constant(value), value)
    }

    fn times_plus(self, a: Self, b: Self) -> Self {
        Self::fused([self, a, b], [true, true])
    }

    fn times_minus(self, a: Self, b: Self) -> Self {
        Self::fused([self, a, b], [true, false])
    }

    fn times_from(self, a: Self, b: Self) -> Self {
        Self::fused([self, a, b], [false, true])
    }

    fn root(self) -> Self {
        Self::new(Operation::Root(self), self.value().sqrt())
    }

    fn abs(self) -> Self {
        self.magnitude()
    }

    fn positive_part(self) -> Self {
        if self.value() > 0.0 {
            self
        } else {
            Self::constant(0.0)
        }
    }
}

/// A polynomial: its terms by the sorted names of their factors, each with the number of
/// factors `1 + d`, `|d| <= u`, that it is wrong by at most.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Terms {
    pub(super) terms: BTreeMap<Vec<String>, u32>,
    /// Nothing was rounded yet.
    exact: bool,
    /// It is a float.
    float: bool,
}

impl Terms {
    fn single(name: String, roundings: u32, float: bool) -> Self {
        Self {
            terms: BTreeMap::from([(vec![name], roundings)]),
            exact: roundings == 0,
            float,
        }
    }

    /// The greatest count; 0 of a polynomial without terms.
    pub(super) fn roundings(&self) -> u32 {
        self.terms.values().copied().max().unwrap_or(0)
    }

    fn is_zero(&self) -> bool {
        self.terms.is_empty()
    }

    fn rounded(mut self) -> Self {
        for count in self.terms.values_mut() {
            *count += 1;
        }
        self.exact = false;
        self.float = false;
        self
    }

    fn sum(&self, other: &Self) -> Self {
        let mut terms = self.terms.clone();
        for (names, count) in &other.terms {
            let greatest = terms.entry(names.clone()).or_default();
            *greatest = (*greatest).max(*count);
        }
        Self {
            terms,
            exact: self.exact && other.exact,
            float: false,
        }
    }

    fn product(&self, other: &Self) -> Self {
        let mut terms = BTreeMap::new();
        for (left, count) in &self.terms {
            for (right, more) in &other.terms {
                let mut names = [left.as_slice(), right].concat();
                names.sort_unstable();
                let greatest: &mut u32 = terms.entry(names).or_default();
                *greatest = (*greatest).max(count + more);
            }
        }
        Self {
            terms,
            exact: self.exact && other.exact && self.float && other.float,
            float: false,
        }
    }
}

/// How roundings are counted.
#[derive(Clone, Debug, Default)]
pub(super) struct Counter {
    /// Whether a fused operation rounds once.
    pub(super) fused: bool,
    /// Numbers taken as they were computed, or as known within so many roundings.
    pub(super) given: BTreeMap<Traced, (&'static str, u32)>,
}

impl Counter {
    pub(super) fn new(fused: bool) -> Self {
        Self {
            fused,
            ..Self::default()
        }
    }

    pub(super) fn given(mut self, numbers: &[(Traced, &'static str, u32)]) -> Self {
        let given = numbers.iter();
        self.given
            .extend(given.map(|&(number, name, roundings)| (number, (name, roundings))));
        self
    }

    fn sum(&self, a: &Terms, b: &Terms) -> Terms {
        match (a.is_zero(), b.is_zero()) {
            (true, _) => b.clone(),
            (_, true) => a.clone(),
            // One rounding of what was not rounded is relative to the sum itself.
            _ if a.exact && b.exact && a.terms.len() == 1 && b.terms.len() == 1 => {
                let name = format!("({:?} and {:?})", a.terms, b.terms);
                Terms::single(name, 1, false)
            }
            _ => a.sum(b).rounded(),
        }
    }

    fn product(a: &Terms, b: &Terms) -> Terms {
        let product = a.product(b);
        if product.exact {
            product
        } else {
            product.rounded()
        }
    }

    /// Of one sign: its greatest count is that of the whole.
    fn whole(of: Traced, terms: &Terms, what: &str) -> Terms {
        Terms::single(format!("{what} {}", of.0), terms.roundings(), false)
    }

    /// Divisors and what is under a root are taken to be sums of terms of one sign; that
    /// they are is said where the bound is.
    pub(super) fn terms(&self, of: Traced) -> Terms {
        if let Some(&(name, roundings)) = self.given.get(&of) {
            return Terms::single(name.into(), roundings, false);
        }
        match of.operation() {
            Operation::Input {
                name,
                roundings,
                float,
            } => Terms::single(name.into(), roundings, float),
            Operation::Constant(value) => constant(value),
            Operation::Sum([a, b]) | Operation::Difference([a, b]) => {
                self.sum(&self.terms(a), &self.terms(b))
            }
            Operation::Product([a, b]) => match (power_of_two(a), power_of_two(b)) {
                (true, _) => self.terms(b),
                (_, true) => self.terms(a),
                _ => Self::product(&self.terms(a), &self.terms(b)),
            },
            Operation::Quotient([a, b]) if power_of_two(a) => {
                Self::whole(b, &self.terms(b), "1 over").rounded()
            }
            Operation::Quotient([a, b]) => {
                let divisor = Self::whole(b, &self.terms(b), "1 over");
                self.terms(a).product(&divisor).rounded()
            }
            Operation::Fused([a, b, c], _) => {
                let (a, b, c) = (self.terms(a), self.terms(b), self.terms(c));
                let product = if self.fused {
                    a.product(&b)
                } else {
                    Self::product(&a, &b)
                };
                self.sum(&product, &c)
            }
            Operation::Root(square) => {
                let mut root = Self::whole(square, &self.terms(square), "root of");
                for count in root.terms.values_mut() {
                    // sqrt(1 + d) is nearer to 1 than 1 + d.
                    *count = count.div_ceil(2) + 1;
                }
                root
            }
            Operation::Negative(of) | Operation::Magnitude(of) => self.terms(of),
        }
    }
}

impl Traced {
    /// What underflows lose in the format's least unit, half the spacing of subnormals,
    /// with the greatest magnitudes of those inputs that factors multiply it by. Other
    /// inputs have lost one unit.
    pub(super) fn lost_units(self, greatest: &BTreeMap<&str, f64>) -> f64 {
        let lost = |of: Self| of.lost_units(greatest);
        let factor = |of: Self| match of.operation() {
            Operation::Input { name, .. } => greatest.get(name).copied(),
            _ => None,
        };
        let product = |a: Self, b: Self| match (factor(a), factor(b)) {
            (_, Some(greatest)) => lost(a) * greatest + 1.0,
            (Some(greatest), _) => lost(b) * greatest + 1.0,
            _ => panic!("a product of {a:?} and {b:?}"),
        };
        match self.operation() {
            Operation::Input { name, .. } => f64::from(!greatest.contains_key(name)),
            Operation::Sum([a, b]) | Operation::Difference([a, b]) => lost(a) + lost(b),
            Operation::Product([a, b]) => product(a, b),
            Operation::Fused([a, b, c], _) => product(a, b) + lost(c),
            other => panic!("{other:?}"),
        }
    }
}

fn power_of_two(of: Traced) -> bool {
    of.constant_value()
        .is_some_and(|value| value != 0.0 && value.to_bits() << 12 == 0)
}

fn constant(value: f64) -> Terms {
    if value == 0.0 {
        return Terms {
            exact: true,
            ..Terms::default()
        };
    }
    let float = f64::from(value as f32) == value;
    Terms::single(format!("{value:e}"), 0, float)
}
