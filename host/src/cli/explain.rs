//! Turns a library's error into what the user reads: what happened, why, what to do.
//!
//! Connects `thiserror` with `miette`: the messages are made where the errors are
//! made, the help where the subcommand knows what to do next. Does not depend on a
//! subcommand.

use super::{Cause, Failure};
use std::error::Error;
use std::fmt;

/// An error with the user's next move, if there is one.
#[derive(Debug)]
struct Explained {
    error: Box<dyn Error + Send + Sync>,
    help: Option<String>,
}

impl fmt::Display for Explained {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.error.fmt(f)
    }
}

impl Error for Explained {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.error.source()
    }
}

impl miette::Diagnostic for Explained {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }
}

/// A failure that explains itself.
pub fn failure(cause: Cause, error: impl Error + Send + Sync + 'static) -> Failure {
    Failure::new(cause, Explained { error: Box::new(error), help: None })
}

/// A failure that also says what to do.
pub fn failure_with_help(
    cause: Cause,
    error: impl Error + Send + Sync + 'static,
    help: impl Into<String>,
) -> Failure {
    Failure::new(cause, Explained { error: Box::new(error), help: Some(help.into()) })
}

/// A file that cannot be written is a system error, one that cannot be read invalid input.
pub fn file_cause(error: &crate::run_folder::FileError) -> Cause {
    if error.action == "read" { Cause::Input } else { Cause::Machine }
}

/// A warning on standard error, within 100 columns.
pub fn warn(warning: &str) {
    eprintln!("{}", wrapped(&format!("warning: {warning}")));
}

/// Lines of words; those after the first are indented.
fn wrapped(text: &str) -> String {
    const MOST_COLUMNS: usize = 100;
    let (mut lines, mut column) = (String::new(), 0);
    for word in text.split_whitespace() {
        let width = word.chars().count();
        if column > 0 && column + 1 + width > MOST_COLUMNS {
            lines.push_str("\n ");
            column = 1;
        }
        if column > 0 {
            lines.push(' ');
            column += 1;
        }
        lines.push_str(word);
        column += width;
    }
    lines
}

/// A path for a result in JSON, which cannot hold one that is not UTF-8.
pub fn path_text(path: &std::path::Path) -> String {
    path.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_warning_is_wrapped_between_words_and_loses_none() {
        let words: Vec<String> = (0..80).map(|n| format!("word{n}")).collect();
        let text = words.join(" ");

        let lines = wrapped(&text);

        assert!(
            lines.lines().count() > 4 && lines.lines().all(|line| line.chars().count() <= 100),
            "{lines}"
        );
        assert!(lines.lines().skip(1).all(|line| line.starts_with("  word")), "{lines}");
        assert_eq!(lines.split_whitespace().collect::<Vec<_>>().join(" "), text);
        assert_eq!(wrapped(&"x".repeat(300)).len(), 300, "one word is not cut");
    }
}
