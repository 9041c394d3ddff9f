//! The program: checks the CPU, reads the arguments, runs, and prints at most one error.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    // Before any code that may be vectorised.
    if let Some(feature) = cli::processor::missing_feature() {
        cli::tell(format_args!(
            "sfera: this program was built for a CPU with {feature}, which this one lacks; build it again on this machine (make build)"
        ));
        return ExitCode::FAILURE;
    }
    cli::main()
}
