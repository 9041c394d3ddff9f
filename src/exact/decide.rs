//! The last stages: one pixel at a time, eight spheres at a time, first by inverse depths in doubles,
//! then by the powers of the hits in doubles, and in [`integers`]. Each takes the
//! pixels that the one before leaves undecided.

use super::{
    bins::Candidate,
    bits::set_bits,
    grid::splat,
    integers,
    sight::{Order, Rays, Sights, Targets},
};
use crate::{
    camera::Camera,
    methods::{NONE, Seen},
    spheres::LANES,
};

#[cfg(test)]
mod tests;

/// The stage that settled a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rung {
    Doubles,
    Integers,
}

/// The sphere that is visible at pixel `(column, row)`, of `candidates` in any order. If not
/// `trusted`, only integers decide.
pub(super) fn decide(
    camera: &Camera,
    (column, row): (u32, u32),
    candidates: &[Candidate],
    trusted: bool,
) -> (Seen, Rung) {
    let in_integers = |left: &[Candidate]| {
        let seen = integers::seen(camera, (column, row), left);
        (seen, Rung::Integers)
    };
    if !trusted {
        return in_integers(candidates);
    }
    let mut ray = Sighted::new(camera, (column, row), candidates);
    ray.drop_hidden();
    if let Some(seen) = ray.seen(candidates) {
        return (seen, Rung::Doubles);
    }
    ray.drop_behind_leader(candidates);
    match ray.seen(candidates) {
        Some(seen) => (seen, Rung::Doubles),
        None => in_integers(&ray.left(candidates)),
    }
}

/// The ray of a pixel, and the candidates that it may hit, eight at a time.
struct Sighted {
    rays: Rays,
    eights: Vec<Eight>,
}

/// Up to eight spheres and the inverse depths at which they are hit.
struct Eight {
    targets: Targets,
    sights: Sights,
    /// Those that may be visible.
    left: u32,
}

impl Eight {
    fn new(rays: &Rays, candidates: &[Candidate]) -> Self {
        let targets = Targets::of(candidates.iter().map(|&(_, sphere)| sphere));
        Self {
            sights: Sights::new(rays, &targets),
            targets,
            left: u32::MAX >> (u32::BITS - candidates.len() as u32),
        }
    }
}

impl Sighted {
    fn new(camera: &Camera, (column, row): (u32, u32), candidates: &[Candidate]) -> Self {
        let rays = Rays::of_pixel(camera, column, row);
        let eights = candidates.chunks(LANES);
        Self {
            eights: eights.map(|eight| Eight::new(&rays, eight)).collect(),
            rays,
        }
    }

    /// Drops the spheres that are missed, or farther than one that is surely hit.
    fn drop_hidden(&mut self) {
        let none = splat(f64::NEG_INFINITY);
        let greatest = self.eights.iter().fold(none, |greatest, eight| {
            let lower = eight.sights.lower;
            lower.simd_gt(greatest).select(lower, greatest)
        });
        let lanes = greatest.to_array().into_iter();
        let nearest = splat(lanes.fold(f64::NEG_INFINITY, f64::max));
        for eight in &mut self.eights {
            let hidden = nearest.simd_gt(eight.sights.upper);
            let missed = splat(f64::MIN).simd_gt(eight.sights.upper);
            eight.left &= !(hidden | missed).to_bitmask();
        }
    }

    /// The visible sphere, if only one is left and it is surely hit, or none is left.
    fn seen(&self, candidates: &[Candidate]) -> Option<Seen> {
        let count = |eight: &Eight| eight.left.count_ones();
        match self.eights.iter().map(count).sum() {
            0 => Some(NONE),
            1 => self.first_hit().map(|at| candidates[at].0),
            _ => None,
        }
    }

    /// The place of the first sphere that is left and surely hit.
    fn first_hit(&self) -> Option<usize> {
        self.eights.iter().enumerate().find_map(|(at, eight)| {
            let lane = set_bits(u64::from(eight.sights.hit() & eight.left)).next()?;
            Some(at * LANES + lane)
        })
    }

    /// The candidates that were not dropped.
    fn left(&self, candidates: &[Candidate]) -> Vec<Candidate> {
        let eights = self.eights.iter().zip(candidates.chunks(LANES));
        let left = eights.flat_map(|(eight, candidates)| {
            set_bits(u64::from(eight.left)).map(|lane| candidates[lane])
        });
        left.collect()
    }

    /// Drops spheres that are behind a leader, by the powers of the hits. Their difference is
    /// relative to the difference of two spheres, not to their distances. (Theorem 11.)
    fn drop_behind_leader(&mut self, candidates: &[Candidate]) {
        let mut next = self.first_hit();
        while let Some(leader) = next {
            let leader = Eight::new(&self.rays, &candidates[leader..leader + 1]);
            let mut farthest = f64::NEG_INFINITY;
            next = None;
            for (at, eight) in self.eights.iter_mut().enumerate() {
                let pair = [&leader, eight].map(|of| (&of.targets, &of.sights));
                let order = Order::new(&self.rays, pair);
                eight.left &= !order.first;
                for lane in set_bits(u64::from(order.second & eight.left)) {
                    let apart = order.apart.as_array()[lane];
                    if apart > farthest {
                        (next, farthest) = (Some(at * LANES + lane), apart);
                    }
                }
            }
        }
    }
}
