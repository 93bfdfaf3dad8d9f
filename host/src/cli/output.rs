//! What the subcommands print, where printing can fail.
//!
//! Holds this module tree's `println!` and its siblings, which replace the standard
//! ones: those panic if the disk behind `> FILE` is full, and a trial or an hour of
//! training would be lost with them. Here the work goes on, and [`finish`] reports the
//! loss. A reader that closes the pipe early, as `head` does, is not a failure. Does
//! not depend on what is printed.

use super::{Cause, Failure, explain};
use serde::Serialize;
use serde_json::Value;
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

/// Prints a result as JSON, indented.
pub fn print_json(result: &impl Serialize) {
    println!("{:#}", json(result));
}

/// A result as JSON, with its keys in the alphabet's order.
pub fn json(result: &impl Serialize) -> Value {
    // Only a map with keys that are not text would fail, and no result has one.
    serde_json::to_value(result).unwrap_or_default()
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
