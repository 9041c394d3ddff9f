//! `--verify`: compares a picture that any program drew with the one that the method
//! draws, and says which pixels differ, by how much, and why.
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
//! the worst of 4 examined:
//!       1132       1008    0 180   0  255 255 255  the background; 0.002 pixels to the outline of sphere 8 (line 11)
//! sfera: standard input: 4 of 2073600 pixels differ, 1.929 per million, in 4 of 1080 rows: 525..526, 554..555, 954..955, 1008..1009;
//! this is rounding in floats: an error of 2.1e-7 in the squares of the textbook formula explains every pixel examined
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
mod judgement;
mod report;
mod tally;
mod text;

use sfera::{ppm, render::Renderer};

use self::{found::Found, judgement::Judgement, tally::Tally, text::read_scene};
use super::{
    arguments::Job,
    difference::mark,
    failure::Failure,
    output::{Output, Places},
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
    let renderer = Renderer::new(&scene, job.size(), job.method());
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
