//! An error with its causes, as the program prints it: what tests look at.

use std::error::Error;

/// The error and every cause of it, one after another.
pub fn message_of(error: &dyn Error) -> String {
    std::iter::successors(error.source(), |&cause| cause.source())
        .fold(error.to_string(), |text, cause| format!("{text}: {cause}"))
}
