//! Parses the command line, runs one subcommand, prints its error.

use std::process::ExitCode;

fn main() -> ExitCode {
    host::cli::run(host::cli::Cli::from_process())
}
