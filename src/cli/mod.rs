//! What the program does: one module a concern, `run` in the order it happens.

mod arguments;
mod compare;
mod difference;
mod generate;
mod output;
mod png;
pub(crate) mod processor;
mod progress;
mod signals;
mod statistics;
mod system;
mod verify;
mod workers;

use std::{
    fmt,
    io::{self, Write},
    panic::{self, AssertUnwindSafe},
    path::Path,
    process::ExitCode,
    sync::Once,
};

use clap::Parser;
use sfera::{
    exact,
    render::{Counts, Method, Renderer},
    scene::{Scene, Viewport},
    spheres::Sphere,
};

use self::{
    arguments::{Arguments, Job, Mode},
    compare::Comparison,
    difference::Marker,
    output::{Destination, Output},
    progress::Progress,
    signals::Interrupts,
    statistics::{Clock, Report},
    workers::Workers,
};

/// Why the program ends with something else than 0.
#[derive(Debug)]
enum Failure {
    /// One line for the user, exit code 1.
    Message(String),
    /// Exit code 1; what there is to say has been said.
    Told,
    /// Nobody reads what is written: nothing to say, and the exit code of a
    /// program that `SIGPIPE` ended, 141.
    NobodyReads,
}

const EXIT_NOBODY_READS: u8 = 141;

/// What messages call it.
const STANDARD_INPUT: &str = "standard input";

impl<E: fmt::Display> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Message(error.to_string())
    }
}

pub(crate) fn main() -> ExitCode {
    report_panics_in_one_line();
    // Before anything that may lack memory.
    let interrupts = signals::prepare();
    let arguments = Arguments::parse();
    match panic::catch_unwind(AssertUnwindSafe(|| run(&arguments, &interrupts?))) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(Failure::NobodyReads)) => EXIT_NOBODY_READS.into(),
        Ok(Err(Failure::Message(message))) => {
            tell(format_args!("sfera: {message}"));
            ExitCode::FAILURE
        }
        Ok(Err(Failure::Told)) | Err(_) => ExitCode::FAILURE,
    }
}

/// A line on standard error; that it can't be written changes nothing.
pub(crate) fn tell(line: fmt::Arguments<'_>) {
    let _ = writeln!(io::stderr(), "{}", without_controls(&line.to_string()));
}

/// Names of files may hold what a terminal obeys: it is shown as escapes.
fn without_controls(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '\n' => shown.push(character),
            // Marks that turn or isolate the direction of what follows.
            '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
                shown.extend(character.escape_unicode());
            }
            _ if character.is_control() => {
                shown.push_str(&format!("\\x{:02x}", u32::from(character)));
            }
            _ => shown.push(character),
        }
    }
    shown
}

fn run(arguments: &Arguments, interrupts: &Interrupts) -> Result<(), Failure> {
    if let Some(page) = arguments.generate {
        return generate::generate(page).map_err(|error| output::lost("-".as_ref(), error));
    }
    let job = arguments.job();
    let workers = Workers::new(job.threads())?;
    workers.run(job, || match job.mode() {
        Mode::Render => render(job, interrupts, &workers),
        Mode::Verify => verify::verify(job, interrupts),
        Mode::Compare => compare(job, interrupts),
    })
}

/// The plain job: a scene to an image, or some of its rows.
fn render(job: &Job, interrupts: &Interrupts, workers: &Workers) -> Result<(), Failure> {
    let mut clock = Clock::start();
    let destination = destination(job)?;
    let scene = read_scene(job)?;
    clock.lap("read");

    let (size, rows) = (job.size(), job.rows());
    let renderer = renderer(job, &scene);
    let mut output = Output::open(&destination, size, job.rows.is_some(), interrupts)?;
    clock.lap("prepare");

    let progress = Progress::new(size, rows.len(), job.quiet);
    let mut counts = Counts::default();
    output.draw(rows, |rows, pixels| {
        counts += renderer.draw(rows, pixels, &|drawn| {
            workers.call_if_late();
            progress.advance(drawn);
        });
    })?;
    progress.finish();
    clock.lap("render");

    if let Some(marks) = &job.diff {
        draw_difference(job, marks, &scene, &renderer, interrupts)?;
    }
    output.publish(interrupts)?;
    clock.lap("publish");
    if let Some(style) = job.stats {
        Report {
            job,
            spheres: scene.spheres.len(),
            counts,
            clock: &clock,
        }
        .print(style);
    }
    Ok(())
}

/// Where the image goes, once it is sure that nothing else is lost there.
fn destination(job: &Job) -> Result<Destination, Failure> {
    let destination = Destination::of(&job.image)?;
    destination.refuse_to_replace(&job.scene)?;
    Ok(destination)
}

/// The one place where a scene is read; of some rows, without the spheres that
/// can't show in them.
fn read_scene(job: &Job) -> Result<Scene, Failure> {
    let exact = matches!(job.method(), Method::Exact | Method::Reference);
    if job.rows.is_some() && exact {
        let (size, rows) = (job.size(), job.rows());
        read_kept(job, |viewport| exact::may_show(viewport, size, rows))
    } else if job.scene_is_standard_input() {
        read_kept(job, |_| |_: &_| true)
    } else {
        Ok(Scene::read(&job.scene)?)
    }
}

fn read_kept<K>(job: &Job, filter: impl FnOnce(Viewport) -> K) -> Result<Scene, Failure>
where
    K: Fn(&Sphere) -> bool + Sync,
{
    Ok(if job.scene_is_standard_input() {
        Scene::read_stream(&mut io::stdin(), STANDARD_INPUT.as_ref(), filter)
    } else {
        Scene::read_kept(&job.scene, filter)
    }?)
}

fn renderer<'scene>(job: &Job, scene: &'scene Scene) -> Renderer<'scene> {
    Renderer::new(scene, job.size(), job.method(), job.form())
}

/// `--diff`: a second image, of the pixels that the method draws wrong.
fn draw_difference(
    job: &Job,
    marks: &Path,
    scene: &Scene,
    renderer: &Renderer<'_>,
    interrupts: &Interrupts,
) -> Result<(), Failure> {
    let destination = Destination::of(marks)?;
    destination.refuse_to_replace(&job.scene)?;
    let mut output = Output::open(&destination, job.size(), false, interrupts)?;
    let mut marker = Marker::new(scene, job.size());
    output.draw(job.rows(), |rows, pixels| {
        renderer.draw(rows.clone(), pixels, &|_| ());
        marker.mark(rows, pixels);
    })?;
    output.publish(interrupts)?;
    if !job.quiet {
        tell(format_args!(
            "{} of {} pixels differ from exact",
            marker.wrong,
            job.size().pixels()
        ));
    }
    Ok(())
}

/// `--compare`: the exact image, and a table of what the others make of it.
fn compare(job: &Job, interrupts: &Interrupts) -> Result<(), Failure> {
    let destination = destination(job)?;
    let scene = read_scene(job)?;
    let mut output = Output::open(&destination, job.size(), false, interrupts)?;
    let mut comparison = Comparison::new(&scene, job.size());
    output.draw(job.rows(), |rows, pixels| comparison.draw(&rows, pixels))?;
    output.publish(interrupts)?;
    io::stdout()
        .write_all(comparison.table().as_bytes())
        .map_err(|error| output::lost("-".as_ref(), error))
}

/// A panic is a mistake of ours: one line that says so, and no backtrace.
fn report_panics_in_one_line() {
    static FIRST: Once = Once::new();
    panic::set_hook(Box::new(|panic| {
        FIRST.call_once(|| {
            let payload = panic.payload();
            let what = payload
                .downcast_ref::<&str>()
                .copied()
                .or_else(|| payload.downcast_ref::<String>().map(String::as_str))
                .unwrap_or("a panic");
            let place = panic.location().map_or_else(String::new, |place| {
                format!(" at {}:{}", place.file(), place.line())
            });
            tell(format_args!(
                "sfera: internal error, please report it: {what}{place}"
            ));
        });
    }));
}
