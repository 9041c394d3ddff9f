//! The program: a module for each of its tasks. `run` calls them in order.
//!
//! | exit code | meaning |
//! | --- | --- |
//! | 0 | the image is complete; with `--verify`, every pixel is right |
//! | 1 | something failed: one line on standard error names the file and what would fix it |
//! | 2 | the command line is wrong; nothing was touched |
//! | 128 + N | ended by signal N: 129 hung up, 130 interrupted, 143 terminated, or any other that ends a program; no temporary file is left |
//! | 141 | nobody reads standard output any more, as when `SIGPIPE` ends a program; no message |
//!
//! Colour is for terminals only, and `NO_COLOR` turns it off. A progress bar appears on terminals
//! after half a second. A program built on one
//! CPU runs on CPUs that have all its features; on others `processor` names the one
//! that is missing. Standard output that was closed before the program began (`>&-`)
//! counts as `/dev/null`, because Rust's standard library opens that in its place.
//!
//! A module imports only modules above it in this table.
//!
//! | module | what it does |
//! | --- | --- |
//! | `failure`, `messages` | why the program fails, and its messages |
//! | `system`, `processor` | functions of the operating system, and a check of the CPU |
//! | `png` | PNG files, written and read |
//! | `arguments`, `generate` | the command line, and its manual page and completions |
//! | `signals`, `memory` | signals, and failed allocations |
//! | `workers`, `progress` | threads, and the progress bar |
//! | `input`, `output` | the scene that is read; the images that are made |
//! | `statistics` | `--stats` |
//! | `difference` | `--diff` |
//! | `render`, `compare`, `verify` | the three jobs |

mod arguments;
mod compare;
mod difference;
mod failure;
mod generate;
mod input;
mod memory;
mod messages;
mod output;
mod png;
pub(crate) mod processor;
mod progress;
mod render;
mod signals;
mod statistics;
mod system;
mod verify;
mod workers;

use std::{panic, process::ExitCode, sync::Once};

use self::{
    arguments::{Arguments, Mode},
    failure::{EXIT_NOBODY_READS, Failure},
    messages::{print, tell},
    workers::Workers,
};

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

fn run(arguments: &Arguments) -> Result<(), Failure> {
    if let Some(page) = arguments.generate {
        return print(&generate::page(page));
    }
    let job = arguments.job();
    let workers = Workers::new(job.threads()).map_err(|error| {
        format!("can't prepare the threads to draw with: {error}; raise the limit on processes (ulimit -u)")
    })?;
    workers.run(job, || match job.mode() {
        Mode::Render => render::render(job, &workers),
        Mode::Verify => verify::verify(job),
        Mode::Compare => compare::compare(job),
    })
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
