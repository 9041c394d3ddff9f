//! The ordinary job: from a scene to an image.

use sfera::{
    render::{Counts, Renderer},
    scene::Scene,
};

use super::{
    arguments::Job,
    difference::Marker,
    failure::Failure,
    input::read_scene,
    messages::tell,
    output::{Output, Places},
    progress::Progress,
    statistics::{Clock, Report},
    workers::Workers,
};

/// Draws the scene as an image, or some of its rows.
pub(crate) fn render(job: &Job, workers: &Workers) -> Result<(), Failure> {
    let mut clock = Clock::start();
    let places = Places::of(job)?;
    let scene = read_scene(job)?;
    clock.lap("read");

    let (size, rows) = (job.size(), job.rows());
    let renderer = Renderer::new(&scene, job.size(), job.method());
    let mut output = places.open_image(job)?;
    // Opened before anything is drawn, because it may be refused.
    let marks = match &places.marks {
        Some(marks) => Some(Output::open(marks, job)?),
        None => None,
    };
    clock.lap("prepare");

    let progress = Progress::new(size, rows.len(), job.quiet);
    let mut counts = Counts::default();
    output.draw(rows, |rows, pixels| {
        counts += renderer.draw_with_progress(rows, pixels, &|drawn| {
            workers.has_drawn();
            workers.start_others_if_late();
            progress.advance(drawn);
        });
        Ok(())
    })?;
    progress.finish();
    clock.lap("render");

    let wrong = match marks {
        Some(marks) => Some(draw_difference(job, marks, &scene, &renderer, &places)?),
        None => None,
    };
    output.publish(&places)?;
    clock.lap("publish");
    if let Some(wrong) = wrong.filter(|_| !job.quiet) {
        let pixels = size.pixels();
        tell(format_args!("{wrong} of {pixels} pixels differ from exact"));
    }
    if let Some(style) = job.stats {
        Report {
            job,
            spheres: scene.spheres().len(),
            threads: workers.that_drew(),
            counts,
            clock: &clock,
        }
        .print(style);
    }
    Ok(())
}

/// `--diff`: draws a second image that marks the pixels that the method draws wrong.
/// Returns their number.
fn draw_difference(
    job: &Job,
    mut output: Output,
    scene: &Scene,
    renderer: &Renderer<'_>,
    places: &Places,
) -> Result<u64, Failure> {
    let mut marker = Marker::new(scene, job.size());
    output.draw(job.rows(), |rows, pixels| {
        renderer.draw(rows.clone(), pixels);
        marker.mark(rows, pixels);
        Ok(())
    })?;
    output.publish(places)?;
    Ok(marker.wrong)
}
