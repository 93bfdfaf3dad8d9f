//! The host's command line as a program of this crate, so that its tests can
//! start the host of this very build as a process, without libtorch.

use clap::Parser as _;
use std::process::ExitCode;

fn main() -> ExitCode {
    host::cli::run(host::cli::Cli::parse())
}
