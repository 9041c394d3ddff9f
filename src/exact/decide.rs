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
        if let Some(seen) = narrow::<f64x8>(camera, (column, row), candidates) {
            return (seen, Rung::Doubles);
        }
        if let Some(seen) = nearest(camera, (column, row), candidates) {
            return (seen, Rung::Doubles);
        }
        if let Some(seen) = narrow::<DoubleDouble>(camera, (column, row), candidates) {
            return (seen, Rung::DoubleDoubles);
        }
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

/// The visible sphere, if this arithmetic can decide. Otherwise removes the candidates that
/// are certainly not visible.
fn narrow<N: Real>(
    camera: &Camera,
    (column, row): (u32, u32),
    candidates: &mut Vec<Candidate>,
) -> Option<Seen> {
    let rays = Rays::<N>::of_pixel(camera, column, row);
    let mut greatest_lower = N::splat(f64::NEG_INFINITY);
    let mut sights = Vec::with_capacity(candidates.len().div_ceil(LANES));
    for eight in candidates.chunks(LANES) {
        let spheres = eight.iter().map(|&(_, sphere)| sphere);
        let sight = Sights::new(&rays, &Targets::<N>::of(spheres));
        greatest_lower = sight
            .lower
            .where_or(sight.lower.exceeds(greatest_lower), greatest_lower);
        sights.push(sight);
    }
    let nearest_lower = greatest_lower.greatest();
    let none = N::splat(f64::NEG_INFINITY);
    let mut kept = 0;
    for (at, sight) in sights.iter().enumerate() {
        let hidden = nearest_lower.exceeds(sight.upper);
        let missed = N::splat(f64::MIN).exceeds(sight.upper);
        let possible = !(hidden | missed).to_bitmask();
        let lanes = LANES.min(candidates.len() - at * LANES);
        for lane in set_bits(u64::from(possible & ((1 << lanes) - 1))) {
            candidates[kept] = candidates[at * LANES + lane];
            kept += 1;
        }
    }
    candidates.truncate(kept);
    let hit = nearest_lower.exceeds(none).to_bitmask() != 0;
    match candidates[..] {
        [] => Some(NONE),
        [(seen, _)] if hit => Some(seen),
        _ => None,
    }
}

/// The visible sphere, if the powers of the hits can tell, whose differences are relative to those of
/// the spheres and not to their distances. Otherwise removes candidates that are certainly behind
/// another one.
fn nearest(
    camera: &Camera,
    (column, row): (u32, u32),
    candidates: &mut Vec<Candidate>,
) -> Option<Seen> {
    let rays = Rays::<f64x8>::of_pixel(camera, column, row);
    let mut eights: Vec<Eight> = candidates
        .chunks(LANES)
        .map(|eight| Eight::new(&rays, eight))
        .collect();
    let of_hit = |(at, eight): (usize, &Eight)| {
        let lane = set_bits(u64::from(eight.sights.hit() & eight.left)).next()?;
        Some(at * LANES + lane)
    };
    let mut leader = eights.iter().enumerate().find_map(of_hit)?;
    loop {
        let alone = Eight::new(&rays, &candidates[leader..leader + 1]);
        let (mut next, mut farthest) = (None, 0.0);
        for (at, eight) in eights.iter_mut().enumerate() {
            let order = Order::new(
                &rays,
                [
                    (&alone.targets, &alone.sights),
                    (&eight.targets, &eight.sights),
                ],
            );
            eight.left &= !order.first;
            for lane in set_bits(u64::from(order.second & eight.left)) {
                let apart = order.apart.as_array()[lane];
                if next.is_none() || apart > farthest {
                    (next, farthest) = (Some(at * LANES + lane), apart);
                }
            }
        }
        let Some(nearer) = next else { break };
        leader = nearer;
    }
    let mut places = 0..;
    candidates.retain(|_| {
        let at: usize = places.next().expect("a place");
        eights[at / LANES].left >> (at % LANES) & 1 == 1
    });
    match candidates[..] {
        [(seen, _)] => Some(seen),
        _ => None,
    }
}

/// Up to eight spheres and the inverse depths at which they are hit.
struct Eight {
    targets: Targets<f64x8>,
    sights: Sights<f64x8>,
    /// Those that are not certainly behind another one.
    left: u32,
}

impl Eight {
    fn new(rays: &Rays<f64x8>, candidates: &[Candidate]) -> Self {
        let targets = Targets::of(candidates.iter().map(|&(_, sphere)| sphere));
        Self {
            sights: Sights::new(rays, &targets),
            targets,
            // Of equal ones, which fill the rest, the first is found first.
            left: u32::MAX,
        }
    }
}
