//! What the subcommands print, where printing can fail.
//!
//! Owns this module tree's `println!` and its siblings, which stand in for the
//! standard ones: those panic if the disk behind `> FILE` is full, and a trial
//! or an hour of training would be lost with them. Here the work goes on, and
//! [`finish`] reports the loss. Refuses to call a reader that has seen enough,
//! as `head` has, a failure.

use super::{Cause, Failure, explain};
use std::fmt;
use std::io::{self, ErrorKind, Write as _};
use std::sync::OnceLock;
use thiserror::Error;

/// The first failure to write to standard output.
static LOST: OnceLock<io::Error> = OnceLock::new();

#[derive(Debug, Error)]
#[error("the result could not be written to standard output; all else is done")]
struct Lost {
    source: io::Error,
}

macro_rules! println {
    ($($text:tt)*) => { $crate::cli::output::to_stdout(format_args!("{}\n", format_args!($($text)*))) };
}

macro_rules! eprint {
    ($($text:tt)*) => { $crate::cli::output::to_stderr(format_args!($($text)*)) };
}

macro_rules! eprintln {
    ($($text:tt)*) => { eprint!("{}\n", format_args!($($text)*)) };
}

/// Writes, or notes that it failed.
pub fn to_stdout(text: fmt::Arguments<'_>) {
    if let Err(error) = io::stdout().write_fmt(text) {
        let _ = LOST.set(error);
    }
}

/// Writes, if there is anywhere to write to; there is nowhere else to complain.
pub fn to_stderr(text: fmt::Arguments<'_>) {
    let _ = io::stderr().write_fmt(text);
}

/// Whether everything that was printed has arrived.
pub fn finish() -> Result<(), Failure> {
    let flushed = io::stdout().flush();
    let lost = LOST.get().map(|error| error.kind()).or(flushed.err().map(|error| error.kind()));
    match lost {
        None | Some(ErrorKind::BrokenPipe) => Ok(()),
        Some(kind) => {
            Err(explain::failure_with_help(Cause::Machine, Lost { source: kind.into() }, "free some space"))
        }
    }
}
