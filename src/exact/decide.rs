//! The last stages: one pixel at a time, eight spheres at a time, first by inverse depths in doubles,
//! then by the powers of the hits in doubles, by inverse depths in double-doubles, and in
//! [`integers`](super::integers). Each takes the pixels that the one before leaves undecided.

use std::cmp::Ordering;

use wide::f64x8;

use super::{
    bins::Candidate,
    bits::set_bits,
    integers,
    real::{DoubleDouble, Real},
    sight::{Order, Rays, Sights, Targets},
};
use crate::{
    camera::Camera,
    methods::{NONE, Seen},
    spheres::{LANES, Sphere},
};

#[cfg(test)]
mod tests;

/// The stage that settled a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rung {
    Doubles,
    DoubleDoubles,
    Integers,
}

/// The sphere that is visible at pixel `(column, row)`, of `candidates` in any order. If not
/// `trusted`, only integers decide.
pub(super) fn decide(
    camera: &Camera,
    (column, row): (u32, u32),
    candidates: &mut Vec<Candidate>,
    trusted: bool,
) -> (Seen, Rung) {
    if trusted {
        let mut ray = Sighted::<f64x8>::new(camera, (column, row), candidates);
        ray.drop_hidden();
        if let Some(seen) = ray.seen(candidates) {
            return (seen, Rung::Doubles);
        }
        ray.drop_behind_leader(candidates);
        if let Some(seen) = ray.seen(candidates) {
            return (seen, Rung::Doubles);
        }
        ray.keep_left(candidates);
        let mut ray = Sighted::<DoubleDouble>::new(camera, (column, row), candidates);
        ray.drop_hidden();
        if let Some(seen) = ray.seen(candidates) {
            return (seen, Rung::DoubleDoubles);
        }
        ray.keep_left(candidates);
    }
    let ray = integers::Ray::new(camera, column, row);
    let mut nearest: Option<(Seen, integers::InverseDepth)> = None;
    for &(index, [x, y, z, radius]) in candidates.iter() {
        let sphere = Sphere {
            centre: [x, y, z],
            radius,
            colour: [0; 3],
        };
        let Some(depth) = ray.meet(&sphere) else {
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
    (nearest.map_or(NONE, |(index, _)| index), Rung::Integers)
}

/// The ray of a pixel, and the candidates that it may hit, eight at a time.
struct Sighted<N> {
    rays: Rays<N>,
    eights: Vec<Eight<N>>,
}

/// Up to eight spheres and the inverse depths at which they are hit.
struct Eight<N> {
    targets: Targets<N>,
    sights: Sights<N>,
    /// Those that may be visible.
    left: u32,
}

impl<N: Real> Eight<N> {
    fn new(rays: &Rays<N>, candidates: &[Candidate]) -> Self {
        let targets = Targets::of(candidates.iter().map(|&(_, sphere)| sphere));
        Self {
            sights: Sights::new(rays, &targets),
            targets,
            left: u32::MAX >> (u32::BITS - candidates.len() as u32),
        }
    }
}

impl<N: Real> Sighted<N> {
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
        let mut greatest_lower = N::splat(f64::NEG_INFINITY);
        for Eight { sights, .. } in &self.eights {
            let nearer = sights.lower.exceeds(greatest_lower);
            greatest_lower = sights.lower.where_or(nearer, greatest_lower);
        }
        let nearest_lower = greatest_lower.greatest();
        for eight in &mut self.eights {
            let hidden = nearest_lower.exceeds(eight.sights.upper);
            let missed = N::splat(f64::MIN).exceeds(eight.sights.upper);
            eight.left &= !(hidden | missed).to_bitmask();
        }
    }

    /// The visible sphere, if only one is left and it is surely hit, or none is left.
    fn seen(&self, candidates: &[Candidate]) -> Option<Seen> {
        let count = |eight: &Eight<N>| eight.left.count_ones();
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

    /// Removes the candidates that were dropped.
    fn keep_left(&self, candidates: &mut Vec<Candidate>) {
        let mut places = 0..;
        candidates.retain(|_| {
            let at: usize = places.next().expect("a place");
            self.eights[at / LANES].left >> (at % LANES) & 1 == 1
        });
    }
}

impl Sighted<f64x8> {
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
