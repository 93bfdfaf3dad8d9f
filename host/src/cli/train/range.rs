//! A range of seeds: `A..B` on the command line, `seeds.json` in a folder.
//!
//! Holds the range and its limits. Does not depend on training.

use crate::run_folder::FileError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The file that says which seeds a folder holds.
pub const SEEDS: &str = "seeds.json";
/// Maximum number of seeds; more is a typing error.
const MAX_SEEDS: u64 = 1_000;

/// Why `seeds.json` cannot be used.
#[derive(Debug, Error)]
pub enum SeedsFileError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error("{path} is not a valid range of seeds")]
    Damaged { path: PathBuf, source: serde_json::Error },
    #[error("{path} is not a valid range of seeds")]
    Range { path: PathBuf, source: BadRange },
}

/// `first..end`, the end left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SeedRange {
    /// The first seed.
    pub first: u64,
    /// The one after the last.
    pub end: u64,
}

/// Why a range of seeds is invalid.
#[derive(Debug, PartialEq, Error)]
pub enum BadRange {
    #[error("write a range of seeds as A..B: 0..10 are 0 to 9")]
    Form,
    #[error("there must be 1 to {MAX_SEEDS} seeds, got {count}")]
    Count { count: u64 },
    #[error("seed {seed} is above the maximum, {}", i64::MAX)]
    Large { seed: u64 },
}

impl std::str::FromStr for SeedRange {
    type Err = BadRange;

    fn from_str(text: &str) -> Result<Self, BadRange> {
        let (first, end) = text.split_once("..").ok_or(BadRange::Form)?;
        let number = |word: &str| word.parse::<u64>().map_err(|_| BadRange::Form);
        Self { first: number(first)?, end: number(end)? }.checked()
    }
}

impl SeedRange {
    /// The seeds of a folder, if it holds several.
    pub fn of(folder: &Path) -> Result<Option<Self>, SeedsFileError> {
        let path = folder.join(SEEDS);
        if !path.exists() {
            return Ok(None);
        }
        let text = std::fs::read(&path).map_err(FileError::on("read", &path))?;
        let seeds: Self = serde_json::from_slice(&text)
            .map_err(|source| SeedsFileError::Damaged { path: path.clone(), source })?;
        seeds.checked().map(Some).map_err(|source| SeedsFileError::Range { path, source })
    }

    fn checked(self) -> Result<Self, BadRange> {
        match self.end.saturating_sub(self.first) {
            1..=MAX_SEEDS if self.end > i64::MAX as u64 => Err(BadRange::Large { seed: self.end }),
            1..=MAX_SEEDS => Ok(self),
            count => Err(BadRange::Count { count }),
        }
    }

    /// Number of seeds, at least 1.
    pub fn count(self) -> usize {
        (self.end - self.first) as usize
    }

    /// The label in the folder's name.
    pub fn label(self) -> String {
        format!("seeds{}-{}", self.first, self.end - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_leaves_its_end_out() {
        let seeds: SeedRange = "3..5".parse().unwrap();

        assert_eq!(seeds, SeedRange { first: 3, end: 5 });
        assert_eq!(seeds.label(), "seeds3-4");
    }

    #[test]
    fn a_range_of_no_seeds_or_too_many_is_refused() {
        let parse = |text: &str| text.parse::<SeedRange>().unwrap_err();

        assert_eq!(parse("3"), BadRange::Form);
        assert_eq!(parse("a..4"), BadRange::Form);
        assert_eq!(parse("4..4"), BadRange::Count { count: 0 });
        assert_eq!(parse("5..4"), BadRange::Count { count: 0 });
        assert_eq!(parse("0..1001"), BadRange::Count { count: 1001 });
        assert_eq!(parse(&format!("{0}..{1}", i64::MAX, 1_u64 << 63)), BadRange::Large { seed: 1 << 63 });
    }

    #[test]
    fn a_damaged_file_of_seeds_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(SEEDS);
        let of = || SeedRange::of(folder.path());
        assert_eq!(of().unwrap(), None);

        std::fs::write(&path, r#"{"first":2,"end":4}"#).unwrap();
        assert_eq!(of().unwrap(), Some(SeedRange { first: 2, end: 4 }));

        std::fs::write(&path, r#"{"first":4,"end":2}"#).unwrap();
        assert!(matches!(of(), Err(SeedsFileError::Range { .. })));

        std::fs::write(&path, "{").unwrap();
        assert!(matches!(of(), Err(SeedsFileError::Damaged { .. })));
    }
}
