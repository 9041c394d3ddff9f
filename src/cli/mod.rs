//! What the program does: one module a concern, `run` in the order it happens.

mod arguments;
mod output;
pub(crate) mod processor;
mod progress;
mod signals;
mod statistics;
mod workers;

use std::{
    fmt,
    panic::{self, AssertUnwindSafe},
    process::ExitCode,
    sync::Once,
};

use clap::Parser;
use sfera::{render::Renderer, scene::Scene};

use self::{
    arguments::{Arguments, Job},
    output::{Destination, Output},
    progress::Progress,
    signals::Interrupts,
    statistics::{Clock, Report},
};

/// Why the program ends with something else than 0.
#[derive(Debug)]
enum Failure {
    /// One line for the user, exit code 1.
    Message(String),
    /// Nobody reads what is written: nothing to say, and the exit code of a
    /// program that `SIGPIPE` ended, 141.
    NobodyReads,
}

const EXIT_NOBODY_READS: u8 = 141;

impl<E: fmt::Display> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::Message(error.to_string())
    }
}

pub(crate) fn main() -> ExitCode {
    let arguments = Arguments::parse();
    report_panics_in_one_line();
    match panic::catch_unwind(AssertUnwindSafe(|| run(&arguments))) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(Failure::NobodyReads)) => EXIT_NOBODY_READS.into(),
        Ok(Err(Failure::Message(message))) => {
            eprintln!("sfera: {message}");
            ExitCode::FAILURE
        }
        Err(_panic) => ExitCode::FAILURE,
    }
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    let job = arguments.job();
    let interrupts = signals::prepare()?;
    workers::pool(job.threads())?.install(|| render(job, interrupts))
}

/// The plain job: a scene to an image, or some of its rows.
fn render(job: &Job, interrupts: Interrupts) -> Result<(), Failure> {
    let mut clock = Clock::start();
    let destination = Destination::of(&job.image)?;
    destination.refuse_to_replace(&job.scene)?;
    let scene = Scene::read(&job.scene)?;
    clock.lap("read");

    let size = job.size();
    let rows = job.rows();
    let renderer = Renderer::new(&scene, size, job.method(), job.form());
    let mut output = Output::open(&destination, size, job.rows.is_some(), interrupts)?;
    clock.lap("prepare");

    let progress = Progress::new(size, rows.len(), job.quiet);
    let mut counts = sfera::render::Counts::default();
    output.draw(rows.clone(), |rows, pixels| {
        counts += renderer.draw(rows, pixels, &|drawn| progress.advance(drawn));
    })?;
    progress.finish();
    clock.lap("render");

    output.publish()?;
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
            eprintln!("sfera: internal error, please report it: {what}{place}");
        });
    }));
}
