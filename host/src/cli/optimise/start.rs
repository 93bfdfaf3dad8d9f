//! `--start`: where a search begins, as it is typed.
//!
//! Holds the names of starts, and the amplitude of a gait to begin at. Does not
//! depend on the search.

use crate::cli::explain::failure_with_help;
use crate::cli::{Cause, Failure};
use crate::gait::gait_file::{GaitFile, Source};
use crate::gait::scale::OWN_STROKE;
use crate::run_folder;
use crate::search::optimise::search::Start;
use crate::search::optimise::space::Motion;
use std::path::Path;

/// Whether the start is a gait, and has an amplitude.
pub fn is_a_gait(text: &str) -> bool {
    !["nothing", "sinusoid"].contains(&text)
}

/// The start of that name, or the gait of that file or run.
pub fn read(text: &str, amplitude: Option<f64>) -> Result<Start, Failure> {
    match text {
        "nothing" => return Ok(Start::Nothing),
        "sinusoid" => return Ok(Start::Sinusoid),
        _ => {}
    }
    let path = Path::new(text);
    let path = if path.is_dir() { path.join(run_folder::GAIT) } else { path.to_owned() };
    let gait = GaitFile::load(&path).map_err(|error| {
        failure_with_help(
            Cause::Input,
            error,
            "--start takes nothing, sinusoid, a gait file, or a run folder that `host fit` was run on",
        )
    })?;
    let own = if gait.provenance.source == Source::Searched { 1.0 } else { OWN_STROKE };
    Ok(Start::Gait(Box::new(Motion::of(&gait, amplitude.unwrap_or(own)))))
}
