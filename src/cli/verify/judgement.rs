//! Why pixels are wrong.

use sfera::{
    nearness::{Cause, Judge, Verdict},
    render::Method,
    scene::Scene,
};

use super::{
    guess::{self, Fit},
    tally::{Tally, Wrong},
    text::SceneText,
};
use crate::cli::arguments::Job;

/// The findings on the wrong pixels.
#[derive(Debug, Default)]
pub(super) struct Judgement {
    /// The verdicts on the first wrong pixels, in their order; empty if the picture is
    /// compared with another method than the exact one.
    pub(super) first: Vec<Verdict>,
    /// The examined pixel that is farthest from an outline or tie that would explain it.
    pub(super) worst: Option<(Wrong, Verdict)>,
    /// How many were examined for that.
    pub(super) looked_at: usize,
    /// The error of the textbook formula that explains all of these.
    pub(super) rounding: f64,
    pub(super) fit: Option<Fit>,
    /// Spheres that are named, in ascending order, and their line numbers.
    lines: Vec<(usize, Option<u64>)>,
}

/// The limit of wrong pixels times spheres: some seconds of work.
const MAX_ESTIMATES: usize = 200_000_000;

/// If every wrong pixel is this near to an outline, in pixels, or to a tie, relative to the
/// distance, no other cause than rounding is searched for.
const NEAR: f64 = 1e-2;

impl Judgement {
    pub(super) fn of(job: &Job, scene: &Scene, text: &SceneText<'_>, tally: &Tally) -> Self {
        if tally.wrong == 0 || !matches!(job.method(), Method::Exact | Method::Reference) {
            return Self::default();
        }
        let judge = Judge::new(scene, job.size());
        let verdict = |wrong: &Wrong| judge.judge(wrong.pixel, wrong.right, wrong.found);
        let first: Vec<Verdict> = tally.first.iter().map(verdict).collect();
        let affordable = MAX_ESTIMATES / scene.spheres().len().max(1);
        let looked_at = tally.spread(affordable.max(tally.first.len()));
        let (worst, rounding) = worst(&judge, &looked_at).unzip();
        let is_near = worst.is_some_and(|(_, verdict)| {
            verdict.cause.is_some_and(|cause| cause.distance() <= NEAR)
        });
        let fit = if is_near {
            None
        } else {
            guess::best_fit(scene, job.size(), &tally.sample)
        };
        let named = first
            .iter()
            .chain(worst.as_ref().map(|(_, verdict)| verdict));
        let lines = lines(text, named);
        Self {
            first,
            worst,
            looked_at: looked_at.len(),
            rounding: rounding.unwrap_or_default(),
            fit,
            lines,
        }
    }

    pub(super) fn line(&self, sphere: usize) -> Option<u64> {
        let found = self
            .lines
            .binary_search_by_key(&sphere, |&(sphere, _)| sphere);
        found.ok().and_then(|index| self.lines[index].1)
    }
}

/// The wrong pixel that is farthest from an outline or a tie that would explain it, and the
/// rounding error that would explain all of them.
fn worst(judge: &Judge<'_>, wrong: &[Wrong]) -> Option<((Wrong, Verdict), f64)> {
    use rayon::prelude::*;
    let estimates: Vec<Verdict> = wrong
        .par_iter()
        .map(|wrong| judge.estimate(wrong.pixel, wrong.right, wrong.found))
        .collect();
    let rounding = estimates.iter().map(|verdict| verdict.rounding);
    let rounding = rounding.fold(0.0, f64::max);
    let distance = |verdict: &Verdict| verdict.cause.map_or(f64::INFINITY, Cause::distance);
    let (worst, _) = wrong
        .iter()
        .zip(&estimates)
        .rev()
        .max_by(|(_, one), (_, other)| distance(one).total_cmp(&distance(other)))?;
    let verdict = judge.judge(worst.pixel, worst.right, worst.found);
    Some(((*worst, verdict), rounding))
}

/// The line numbers of all spheres that verdicts name.
fn lines<'a>(
    text: &SceneText<'_>,
    verdicts: impl Iterator<Item = &'a Verdict>,
) -> Vec<(usize, Option<u64>)> {
    let mut spheres: Vec<usize> = verdicts
        .flat_map(|verdict| [verdict.seen, verdict.cause.map(Cause::sphere)])
        .flatten()
        .collect();
    spheres.sort_unstable();
    spheres.dedup();
    let lines = text.lines(&spheres);
    spheres.into_iter().zip(lines).collect()
}
