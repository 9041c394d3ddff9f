//! `--verify`: is a picture, whoever drew it, what the method draws? And if not,
//! where, by how much, and why?
//!
//! The picture is a binary PPM of the right size with any style of header, from a file
//! or a pipe, or a PNG file. Exit code 0 means right. Exit code 1 means wrong, and the
//! report says how many pixels are wrong and which, what they should show, and how
//! near they are to showing what was found:
//!
//! ```text
//! $ my-renderer scenes/example.txt | sfera scenes/example.txt - 1920 1080 --verify
//!     column        row  found        right
//!       1228        525    0   0 195    0   0 225  sphere 12 (line 15); 6.6e-5 pixels to the outline of sphere 13 (line 16)
//!       1228        554    0   0 195    0   0 225  sphere 12 (line 15); 6.6e-5 pixels to the outline of sphere 13 (line 16)
//!       1163        954    0 180   0  255 255 255  the background; 3.8e-4 pixels to the outline of sphere 8 (line 11)
//!       1132       1008    0 180   0  255 255 255  the background; 0.002 pixels to the outline of sphere 8 (line 11)
//! the worst of 4 looked at:
//!       1132       1008    0 180   0  255 255 255  the background; 0.002 pixels to the outline of sphere 8 (line 11)
//! sfera: standard input: 4 of 2073600 pixels differ, 1.929 per million, in 4 of 1080 rows: 525..526, 554..555, 954..955, 1008..1009;
//! this is rounding in floats: an error of 2.1e-7 in the squares of the textbook formula explains every pixel looked at
//! ```
//!
//! Rounding errors occur only near outlines, and where two spheres are almost equally
//! far. How near depends on the arithmetic, and on the sphere's distance relative to
//! its size. A programming mistake can be wrong anywhere. `guess` tries the common
//! ones and names one, or several together, that explain nine of ten wrong pixels:
//! a picture upside down or mirrored, rays through the centres or corners of pixels
//! or half a pixel off ("its rays go through (i+1/2)/W and (j+1/2)/H of the viewport
//! instead of i/(W-1) and j/(H-1)"), spheres behind the camera, spheres seen from
//! inside. `--diff` marks the wrong pixels, and `--stats=json` writes the whole report
//! as one line on standard error. Memory does not grow with the picture.

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

/// Draws the rows in memory, compares them with those of the picture, and reports the
/// differences.
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
        spheres: scene.spheres().len(),
        tally: &tally,
        judgement: &judgement,
        clock: &clock,
    })
}

/// The text in which the line numbers of spheres are looked up.
#[derive(Debug)]
enum SceneText<'job> {
    File(&'job Path),
    Bytes(Vec<u8>),
}

/// Reads the whole scene: a sphere that should not be visible in the rows may be the one that
/// the picture shows there.
fn read_scene(job: &Job) -> Result<(Scene, SceneText<'_>), Failure> {
    let path = &*job.scene;
    let mut bytes = Vec::new();
    let name = if job.scene_is_standard_input() {
        io::stdin()
            .read_to_end(&mut bytes)
            .map_err(|error| output::read_failed(STANDARD_INPUT.as_ref(), error))?;
        STANDARD_INPUT.as_ref()
    } else if fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
        File::open(path)
            .and_then(|mut file| file.read_to_end(&mut bytes))
            .map_err(|error| output::read_failed(path, error))?;
        path
    } else {
        return Ok((Scene::read(path)?, SceneText::File(path)));
    };
    let scene = Scene::read_stream(&mut bytes.as_slice(), name, |_| |_: &_| true)?;
    Ok((scene, SceneText::Bytes(bytes)))
}

impl SceneText<'_> {
    /// The line numbers of some spheres, as far as they can be found.
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
        renderer.draw_with_progress(rows.clone(), &mut right, &|rows| progress.advance(rows));
        tally.compare(rows, &found, &right);
    }
    picture.finish()?;
    progress.finish();
    Ok(tally)
}

/// Like [`compare`], and makes an image that marks the differences.
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
    output.draw(job.rows(), |rows, pixels| {
        picture.read(pixels)?;
        right.resize(pixels.len(), 0);
        renderer.draw_with_progress(rows.clone(), &mut right, &|rows| progress.advance(rows));
        tally.compare(rows, pixels, &right);
        mark(pixels, &right);
        Ok(())
    })?;
    progress.finish();
    picture.finish()?;
    output.publish(places)?;
    Ok(tally)
}

/// What was found out about the wrong pixels.
#[derive(Debug, Default)]
struct Judgement {
    /// The verdicts on the first wrong pixels, in their order; empty if the picture is
    /// compared with another method than the exact one.
    first: Vec<Verdict>,
    /// The examined pixel that is farthest from an outline or tie that would explain it.
    worst: Option<(Wrong, Verdict)>,
    /// How many were examined for that.
    looked_at: usize,
    /// The error of the textbook formula that explains all of these.
    rounding: f64,
    fit: Option<Fit>,
    /// Spheres that are named, in ascending order, and their line numbers.
    lines: Vec<(usize, Option<u64>)>,
}

/// The limit of wrong pixels times spheres: some seconds of work.
const MAX_ESTIMATES: usize = 200_000_000;

/// If every wrong pixel is this near to an outline, in pixels, or to a tie, relative to the
/// distance, no other cause than rounding is searched for.
const NEAR: f64 = 1e-2;

impl Judgement {
    fn of(job: &Job, scene: &Scene, text: &SceneText<'_>, tally: &Tally) -> Self {
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

    fn line(&self, sphere: usize) -> Option<u64> {
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
