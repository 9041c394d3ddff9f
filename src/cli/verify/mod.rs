//! `--verify`: is a picture, whoever drew it, what the method draws? And if not,
//! where, by how much, and why?

mod found;
mod guess;
mod report;
mod tally;

use std::{
    fs::{self, File},
    io::{self, BufReader, Read},
    path::Path,
};

use sfera::{
    nearness::{Cause, Judge, Verdict},
    ppm,
    render::{Method, Renderer},
    scene::{Scene, lines_of_spheres},
};

use self::{
    found::Found,
    guess::Fit,
    tally::{Tally, Wrong},
};
use super::{
    Failure, STANDARD_INPUT,
    arguments::Job,
    difference::mark,
    output::{self, Output, Places},
    progress::Progress,
    statistics::Clock,
};

/// Draws the rows again, in memory, compares them with those of the picture, and
/// tells what differs.
pub(crate) fn verify(job: &Job) -> Result<(), Failure> {
    let mut clock = Clock::start();
    let places = Places::of(job)?;
    let (scene, text) = read_scene(job)?;
    clock.lap("read");
    let renderer = super::renderer(job, &scene);
    let tally = match &places.marks {
        None => compare(job, &renderer)?,
        Some(marks) => {
            let output = Output::open(marks, job)?;
            compare_and_mark(job, &renderer, output, &places)?
        }
    };
    clock.lap("compare");
    let judgement = Judgement::of(job, &scene, &text, &tally);
    clock.lap("judge");
    report::report(&report::Findings {
        job,
        spheres: scene.spheres.len(),
        tally: &tally,
        judgement: &judgement,
        clock: &clock,
    })
}

/// Where the lines of the spheres can be looked up.
#[derive(Debug)]
enum SceneText<'job> {
    File(&'job Path),
    Bytes(Vec<u8>),
}

/// The whole scene: what should not show in some rows may be what does.
fn read_scene(job: &Job) -> Result<(Scene, SceneText<'_>), Failure> {
    let path = &*job.scene;
    let mut bytes = Vec::new();
    let name = if job.scene_is_standard_input() {
        io::stdin()
            .read_to_end(&mut bytes)
            .map_err(|error| output::unread(STANDARD_INPUT.as_ref(), error))?;
        STANDARD_INPUT.as_ref()
    } else if fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
        File::open(path)
            .and_then(|mut file| file.read_to_end(&mut bytes))
            .map_err(|error| output::unread(path, error))?;
        path
    } else {
        return Ok((Scene::read(path)?, SceneText::File(path)));
    };
    let scene = Scene::read_stream(&mut bytes.as_slice(), name, |_| |_: &_| true)?;
    Ok((scene, SceneText::Bytes(bytes)))
}

impl SceneText<'_> {
    /// The lines of some spheres, as far as they can be told.
    fn lines(&self, spheres: &[usize]) -> Vec<Option<u64>> {
        let lines = match self {
            Self::File(path) => File::open(path)
                .and_then(|file| lines_of_spheres(&mut BufReader::new(file), spheres)),
            Self::Bytes(bytes) => lines_of_spheres(&mut bytes.as_slice(), spheres),
        };
        lines.unwrap_or_else(|_| vec![None; spheres.len()])
    }
}

/// Reads and compares all rows.
fn compare(job: &Job, renderer: &Renderer<'_>) -> Result<Tally, Failure> {
    let (size, rows) = (job.size(), job.rows());
    let progress = Progress::new(size, rows.len(), job.quiet);
    let mut picture = Found::open(&job.image, size, rows.start)?;
    let mut tally = Tally::new(size, rows.clone());
    let (mut found, mut right) = (Vec::new(), Vec::new());
    for rows in ppm::row_groups(size, rows) {
        let bytes = rows.len() * size.row_bytes();
        found.resize(bytes, 0);
        right.resize(bytes, 0);
        picture.read(&mut found)?;
        renderer.draw(rows.clone(), &mut right, &|rows| progress.advance(rows));
        tally.compare(rows, &found, &right);
    }
    picture.finish()?;
    progress.finish();
    Ok(tally)
}

/// As [`compare`], and makes a picture of what differs.
fn compare_and_mark(
    job: &Job,
    renderer: &Renderer<'_>,
    mut output: Output,
    places: &Places,
) -> Result<Tally, Failure> {
    let size = job.size();
    let progress = Progress::new(size, size.height() as usize, job.quiet);
    let mut picture = Found::open(&job.image, size, 0)?;
    let mut tally = Tally::new(size, job.rows());
    let mut right = Vec::new();
    let mut unread = None;
    output.draw(job.rows(), |rows, pixels| {
        if unread.is_some() {
            return;
        }
        if let Err(error) = picture.read(pixels) {
            unread = Some(error);
            return;
        }
        right.resize(pixels.len(), 0);
        renderer.draw(rows.clone(), &mut right, &|rows| progress.advance(rows));
        tally.compare(rows, pixels, &right);
        mark(pixels, &right);
    })?;
    progress.finish();
    if let Some(error) = unread {
        return Err(error);
    }
    picture.finish()?;
    output.publish(places)?;
    Ok(tally)
}

/// What is to be said of the wrong pixels.
#[derive(Debug, Default)]
struct Judgement {
    /// Of the first wrong pixels, in their order; nothing where another method than
    /// the exact one is the measure.
    first: Vec<Verdict>,
    /// The one of those looked at that is farthest from what would excuse it.
    worst: Option<(Wrong, Verdict)>,
    /// How many were looked at for that.
    looked_at: usize,
    fit: Option<Fit>,
    /// Spheres that are named, in rising order, and their lines.
    lines: Vec<(usize, Option<u64>)>,
}

/// Wrong pixels times spheres that are looked at: some seconds.
const MOST_ESTIMATES: usize = 200_000_000;

/// Pixels or a share of the depth within which rounding is the likely cause.
const ROUNDING: f64 = 1e-2;

impl Judgement {
    fn of(job: &Job, scene: &Scene, text: &SceneText<'_>, tally: &Tally) -> Self {
        if tally.wrong == 0 || !matches!(job.method(), Method::Exact | Method::Reference) {
            return Self::default();
        }
        let judge = Judge::new(scene, job.size());
        let verdict = |wrong: &Wrong| judge.judge(wrong.pixel, wrong.right, wrong.found);
        let first: Vec<Verdict> = tally.first.iter().map(verdict).collect();
        let affordable = MOST_ESTIMATES / scene.spheres.len().max(1);
        let looked_at = tally.spread(affordable.max(tally.first.len()));
        let worst = worst(&judge, &looked_at);
        let is_rounding = worst.is_some_and(|(_, verdict)| {
            verdict
                .cause
                .is_some_and(|cause| cause.distance() <= ROUNDING)
        });
        let fit = if is_rounding {
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
            fit,
            lines,
        }
    }

    fn line(&self, sphere: usize) -> Option<u64> {
        let found = self
            .lines
            .binary_search_by_key(&sphere, |&(sphere, _)| sphere);
        found.ok().and_then(|index| self.lines[index].1)
    }
}

/// The wrong pixel that is farthest from an outline or a tie that would excuse it.
fn worst(judge: &Judge<'_>, wrong: &[Wrong]) -> Option<(Wrong, Verdict)> {
    use rayon::prelude::*;
    let distance = |wrong: &Wrong| {
        let verdict = judge.estimate(wrong.pixel, wrong.right, wrong.found);
        verdict.cause.map_or(f64::INFINITY, Cause::distance)
    };
    // Of equals the first, whatever the threads do.
    let (_, worst) = wrong
        .par_iter()
        .enumerate()
        .map(|(index, pixel)| (distance(pixel), index))
        .reduce_with(|one, other| {
            let order = one.0.total_cmp(&other.0).then(other.1.cmp(&one.1));
            if order.is_ge() { one } else { other }
        })?;
    let worst = wrong[worst];
    Some((worst, judge.judge(worst.pixel, worst.right, worst.found)))
}

/// The lines of all spheres that verdicts name.
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
