//! The command line: one module a subcommand, each with `Args` and `run`.
//!
//! Holds the choice of the subcommand and the exit codes. A subcommand does not
//! depend on another one.

// First: its macros are in force below it.
#[macro_use]
mod output;

// What several subcommands need, and none owns.
mod agreement;
mod explain;
mod help;
mod material;
#[cfg(feature = "train")]
mod new_gait;
mod ranges;
mod reach;
mod recording;
mod robots;
#[cfg(feature = "train")]
mod steps;
#[cfg(feature = "train")]
mod virtual_robot;

// The subcommands: `help` has them in groups.
#[cfg(feature = "torch")]
mod bench;
mod calibrate;
#[cfg(feature = "train")]
mod curves;
#[cfg(feature = "train")]
mod demo;
#[cfg(feature = "train")]
mod experiment;
mod fit;
mod gaits;
mod measure;
#[cfg(feature = "train")]
mod optimise;
mod play;
#[cfg(feature = "train")]
mod record;
mod robot;
mod set;
mod simulate;
#[cfg(feature = "train")]
mod sinusoid;
mod status;
mod stop;
#[cfg(feature = "train")]
mod train;
mod twin;
mod upload_gait;
mod walk;

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use std::process::ExitCode;

/// Energy-efficient gaits for a small quadruped: train, fit, upload, measure.
#[derive(Debug, Parser)]
#[command(name = "host", version)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
}

impl Cli {
    /// The command line of this process; ends it after `--help`, `--version` or an unknown flag.
    #[must_use]
    pub fn from_process() -> Self {
        let matches = help::with_groups(Self::command()).get_matches();
        // Parsed by the definition that it is read by.
        Self::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
    }
}

/// A variant without a doc comment is described by that of its `Args`, in full;
/// one with a comment hides all of theirs but the flags.
#[derive(Debug, Subcommand)]
enum Command {
    /// Train a walking policy with TD3 in the simulation
    #[cfg(feature = "train")]
    Train(train::Args),
    #[cfg(feature = "train")]
    Curves(curves::Args),
    /// Average a policy's strides over 20 trials, and draw them
    #[cfg(feature = "train")]
    Record(record::Args),
    Fit(fit::Args),
    Simulate(simulate::Args),
    #[cfg(feature = "train")]
    Optimise(optimise::Args),
    #[cfg(feature = "train")]
    Sinusoid(sinusoid::Args),
    Calibrate(calibrate::Args),
    UploadGait(upload_gait::Args),
    Measure(measure::Args),
    Walk(walk::Args),
    Play(play::Args),
    Status(status::Args),
    Set(set::Args),
    Stop(stop::Args),
    Gaits(gaits::Args),
    Robot(robot::Args),
    /// Fit or validate the simulation against measured trials
    Twin(twin::Args),
    #[cfg(feature = "torch")]
    Bench(bench::Args),
    /// Train, upload and measure on the virtual robot
    #[cfg(feature = "train")]
    Demo(demo::Args),
    #[cfg(feature = "train")]
    Experiment(experiment::Args),
}

/// What the exit code tells a script; `help` has the words for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Cause {
    /// Disk, memory, libtorch.
    Machine = 1,
    /// A flag whose value clap cannot check.
    Usage = 2,
    /// A file or its contents.
    Input = 3,
    /// Port or link.
    Link = 4,
    /// The robot refused, or stopped by itself.
    Robot = 5,
    /// Ctrl-C.
    Interrupted = 130,
}

#[cfg(feature = "train")]
impl Cause {
    /// The cause behind a step's exit code; an unknown code counts as a system error.
    fn of_code(code: Option<i32>) -> Self {
        let known = [Self::Usage, Self::Input, Self::Link, Self::Robot, Self::Interrupted];
        known.into_iter().find(|&cause| code == Some(cause as i32)).unwrap_or(Self::Machine)
    }
}

/// Seeds that a run's files can hold: TOML's integers are signed.
fn seed() -> impl clap::builder::TypedValueParser<Value = u64> {
    clap::value_parser!(u64).range(..=i64::MAX as u64)
}

/// Why a subcommand failed: what a script sees and what a person reads.
#[derive(Debug)]
pub struct Failure {
    /// Becomes the exit code.
    pub cause: Cause,
    /// Becomes the text on standard error.
    pub report: miette::Report,
}

impl Failure {
    /// A failure with its exit code.
    pub fn new(cause: Cause, error: impl Into<miette::Report>) -> Self {
        Self { cause, report: error.into() }
    }
}

/// Runs the subcommand and reports its outcome.
#[must_use]
pub fn run(cli: Cli) -> ExitCode {
    // Unwrapped: a command that the help names must survive being copied. Only
    // a second call could fail, and there is none.
    let _ =
        miette::set_hook(Box::new(|_| Box::new(miette::MietteHandlerOpts::new().wrap_lines(false).build())));
    let outcome = match cli.command {
        #[cfg(feature = "train")]
        Command::Train(args) => train::run(args),
        #[cfg(feature = "train")]
        Command::Curves(args) => curves::run(args),
        #[cfg(feature = "train")]
        Command::Record(args) => record::run(args),
        Command::Fit(args) => fit::run(args),
        Command::Simulate(args) => simulate::run(args),
        #[cfg(feature = "train")]
        Command::Optimise(args) => optimise::run(args),
        #[cfg(feature = "train")]
        Command::Sinusoid(args) => sinusoid::run(args),
        Command::Calibrate(args) => calibrate::run(args),
        Command::UploadGait(args) => upload_gait::run(args),
        Command::Measure(args) => measure::run(args),
        Command::Walk(args) => walk::run(args),
        Command::Play(args) => play::run(args),
        Command::Status(args) => status::run(args),
        Command::Set(args) => set::run(args),
        Command::Stop(args) => stop::run(args),
        Command::Gaits(args) => gaits::run(args),
        Command::Robot(args) => robot::run(args),
        Command::Twin(args) => twin::run(args),
        #[cfg(feature = "torch")]
        Command::Bench(args) => bench::run(args),
        #[cfg(feature = "train")]
        Command::Demo(args) => demo::run(args),
        #[cfg(feature = "train")]
        Command::Experiment(args) => experiment::run(args),
    };
    match outcome.and_then(|()| output::finish()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("{:?}", failure.report);
            ExitCode::from(failure.cause as u8)
        }
    }
}
