//! An error with its causes in one line: for warnings, and for tests to look at.

use std::error::Error;

/// The error and every cause of it, one after another.
pub fn message_of(error: &dyn Error) -> String {
    std::iter::successors(error.source(), |&cause| cause.source())
        .fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}
