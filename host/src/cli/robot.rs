//! `host robot`: make, check and export a robot's folder.

mod check;
mod export;
mod new;

use super::Failure;
use clap::Subcommand;

/// Make a robot of your own, check its numbers, or export its body.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    New(Box<new::Args>),
    Check(check::Args),
    Export(export::Args),
}

pub fn run(args: Args) -> Result<(), Failure> {
    match args.command {
        Command::New(args) => new::run(*args),
        Command::Check(args) => check::run(args),
        Command::Export(args) => export::run(args),
    }
}
