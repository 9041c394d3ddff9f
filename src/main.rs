//! The program: checks the CPU, reads the arguments, runs, and prints at most one error.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    // Before any code that may be vectorised.
    if let Some(feature) = cli::processor::missing_feature() {
        cli::processor::report(feature);
        return ExitCode::FAILURE;
    }
    cli::main()
}
