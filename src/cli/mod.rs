//! What the program does: one module for each concern, `run` in the order of events.
//!
//! | exit code | meaning |
//! | --- | --- |
//! | 0 | the image is complete; with `--verify`, every pixel is right |
//! | 1 | something failed: one line on standard error names the file and what would fix it |
//! | 2 | the command line is wrong; nothing was touched |
//! | 128 + N | ended by signal N: 129 hung up, 130 interrupted, 143 terminated, or any other that ends a program; no temporary file is left |
//! | 141 | nobody reads standard output any more, as when `SIGPIPE` ends a program; no message |
//!
//! Colour is for terminals only, and `NO_COLOR` turns it off. A program built on one
//! CPU runs on CPUs that have all its features; on others `processor` names the one
//! that is missing. Standard output that was closed before the program began (`>&-`)
//! counts as `/dev/null`, because Rust's standard library opens that in its place.

mod arguments;
mod compare;
mod difference;
mod generate;
mod memory;
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
    panic,
    process::ExitCode,
    sync::Once,
};

use sfera::{
    exact,
    name::printable,
    ppm::ImageError,
    render::{Counts, Method, Renderer},
    scene::{Scene, SceneError, Viewport},
    spheres::Sphere,
};

use self::{
    arguments::{Arguments, Job, Mode},
    compare::Comparison,
    difference::Marker,
    output::{Output, Places},
    progress::Progress,
    statistics::{Clock, Report},
    workers::Workers,
};

/// Why the program ends with an exit code other than 0.
#[derive(Debug)]
enum Failure {
    /// One line for the user, exit code 1.
    Message(String),
    /// Exit code 1, without a message: the report has been printed.
    Reported,
    /// Nobody reads the output: no message, and the exit code of a program that `SIGPIPE`
    /// ended, 141.
    NobodyReads,
}

const EXIT_NOBODY_READS: u8 = 141;

/// Its name in messages.
const STANDARD_INPUT: &str = "standard input";

/// Every conversion is from an error that names its file, or from a message of our own.
impl From<ImageError> for Failure {
    fn from(error: ImageError) -> Self {
        Self::Message(error.to_string())
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::Message(error.to_string())
    }
}

impl From<String> for Failure {
    fn from(message: String) -> Self {
        Self::Message(message)
    }
}

pub(crate) fn main() -> ExitCode {
    report_panics_in_one_line();
    // Before anything that may fail for lack of memory.
    signals::prepare();
    match panic::catch_unwind(|| run(&Arguments::read()?)) {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(Failure::NobodyReads)) => EXIT_NOBODY_READS.into(),
        Ok(Err(Failure::Message(message))) => {
            tell(format_args!("sfera: {message}"));
            ExitCode::FAILURE
        }
        Ok(Err(Failure::Reported)) | Err(_) => ExitCode::FAILURE,
    }
}

/// Writes a line to standard error in one piece, since other programs may write there too.
/// Failing to write it changes nothing.
pub(crate) fn tell(text: fmt::Arguments<'_>) {
    let text = text.to_string();
    let mut lines: Vec<_> = text
        .split('\n')
        .map(|line| printable(line.as_bytes()))
        .collect();
    lines.push(String::new());
    let _ = io::stderr().write_all(lines.join("\n").as_bytes());
}

/// Writes all of a text to standard output.
fn print(text: &[u8]) -> Result<(), Failure> {
    let mut stdout = io::stdout();
    stdout
        .write_all(text)
        .and_then(|()| stdout.flush())
        .map_err(|error| output::write_failed("-".as_ref(), error))
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(page) = arguments.generate {
        return print(&generate::page(page));
    }
    let job = arguments.job();
    let workers = Workers::new(job.threads()).map_err(|error| {
        format!("can't prepare the threads to draw with: {error}; raise the limit on processes (ulimit -u)")
    })?;
    workers.run(job, || match job.mode() {
        Mode::Render => render(job, &workers),
        Mode::Verify => verify::verify(job),
        Mode::Compare => compare(job),
    })
}

/// The ordinary job: from a scene to an image, or some of its rows.
fn render(job: &Job, workers: &Workers) -> Result<(), Failure> {
    let mut clock = Clock::start();
    let places = Places::of(job)?;
    let scene = read_scene(job)?;
    clock.lap("read");

    let (size, rows) = (job.size(), job.rows());
    let renderer = renderer(job, &scene);
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

/// Reads the scene; for some rows, without the spheres that can't be visible in them.
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
        Scene::read_stream(&mut io::stdin(), STANDARD_INPUT, filter)
    } else {
        Scene::read_kept(&job.scene, filter)
    }?)
}

fn renderer<'scene>(job: &Job, scene: &'scene Scene) -> Renderer<'scene> {
    Renderer::new(scene, job.size(), job.method())
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

/// `--compare`: draws the exact image, and prints a table of every method.
fn compare(job: &Job) -> Result<(), Failure> {
    let places = Places::of(job)?;
    let scene = read_scene(job)?;
    let mut output = places.open_image(job)?;
    let mut comparison = Comparison::new(&scene, job.size());
    output.draw(job.rows(), |rows, pixels| {
        comparison.draw(&rows, pixels);
        Ok(())
    })?;
    output.publish(&places)?;
    print(comparison.table().as_bytes())
}

/// A panic is a bug of sfera: reports it in one line, without a backtrace.
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
