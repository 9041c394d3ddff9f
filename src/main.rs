//! The program: a CPU that will do, then arguments, a run, one error line.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    // Before anything that may be vectorised.
    if let Some(feature) = cli::processor::missing_feature() {
        cli::tell(format_args!(
            "sfera: this program was built for a CPU with {feature}, which this one has not; build it again on this machine (make build)"
        ));
        return ExitCode::FAILURE;
    }
    cli::main()
}
