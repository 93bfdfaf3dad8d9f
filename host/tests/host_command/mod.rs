//! The `host` program as a user starts it in a folder, its messages plain and unwrapped.
//!
//! Holds how it is started and how its messages are read. Does not depend on a
//! robot: with one, see `bench_host`.
// Every test file uses another part of it.
#![allow(dead_code)]

use assert_cmd::Command;
use std::path::Path;

/// `host` with these arguments, in `folder`; no colours, lines of 400 characters.
pub fn host(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::cargo_bin("host").unwrap();
    command.current_dir(folder).env("NO_COLOR", "1").env("COLUMNS", "400").args(args);
    command
}

/// Runs `host`, which has to fail with `code` and print nothing to standard output;
/// returns standard error without line breaks.
#[track_caller]
pub fn refused(folder: &Path, code: i32, args: &[&str]) -> String {
    let assert = host(folder, args).assert().code(code);
    assert!(assert.get_output().stdout.is_empty());
    unwrapped(&assert.get_output().stderr)
}

/// Undoes the terminal's line breaks: `|` and spaces at the start of a line.
pub fn unwrapped(bytes: &[u8]) -> String {
    let text = String::from_utf8_lossy(bytes);
    text.split_whitespace().filter(|word| *word != "│").collect::<Vec<_>>().join(" ")
}
