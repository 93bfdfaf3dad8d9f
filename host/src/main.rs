//! Parses the command line, runs one subcommand, prints its error.

use clap::Parser as _;
use std::process::ExitCode;

fn main() -> ExitCode {
    host::cli::run(host::cli::Cli::parse())
}
