//! `host robot check`: what a robot's numbers mean, and which look wrong.
//!
//! Holds the flags, the list's words and the drawing's place; findings are
//! [`crate::robot::check`]'s, the drawing [`crate::robot::views`]'s.

use crate::cli::explain::{failure, failure_with_help, path_text};
use crate::cli::{Cause, Failure};
use crate::robot::check::{Check, Finding, Mark, check};
use crate::robot::sketch::file_stem;
use crate::robot::{Robot, views};
use crate::run_folder::{self, FileError};
use serde_json::json;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Widest line of advice.
const COLUMNS: usize = 100;

/// Check a robot's folder: sizes, balance, torques, power, and numbers in the wrong unit.
///
/// Prints one line for each number with its limits, and what to do where it is beyond them;
/// draws the robot from above, from its right and from the front. Torques are those of
/// standing still at neutral, with feet that push straight up. Exit code 3 if there is an error.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The robot's folder, or the robot.toml in it
    folder: PathBuf,
    /// Where the three views are drawn [default: runs/NAME-views.svg]
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Error)]
enum CheckError {
    #[error("{} has {errors}", .folder.display())]
    Errors { folder: PathBuf, errors: String },
}

pub fn run(args: Args) -> Result<(), Failure> {
    let robot = Robot::load(&args.folder).map_err(|error| failure(Cause::Input, error))?;
    let found = check(&robot);
    let svg = args
        .svg
        .clone()
        .unwrap_or_else(|| Path::new(run_folder::RUNS).join(format!("{}-views.svg", file_stem(&robot.name))));
    save(&svg, &views::to_svg(&robot, &found)).map_err(|error| failure(Cause::Machine, error))?;
    let errors = found.count(Mark::Error);
    if args.json {
        let json = json!({
            "robot": robot.name,
            "folder": path_text(&args.folder),
            "views": path_text(&svg),
            "errors": errors,
            "warnings": found.count(Mark::Warning),
            "mass_kg": found.mass_kg,
            "span_m": found.span_m,
            "standing_height_m": found.standing_height_m,
            "findings": found.findings,
        });
        println!("{json:#}");
    } else {
        print(&robot, &found);
        println!("\nthree views: {}", svg.display());
    }
    if errors > 0 {
        let error = CheckError::Errors { folder: args.folder, errors: counted(errors, "error") };
        return Err(failure_with_help(
            Cause::Input,
            error,
            "the lines marked ERROR say what is wrong and what to do",
        ));
    }
    if !args.json {
        println!("Next: cargo run -p host -- optimise --robot {}", args.folder.display());
    }
    Ok(())
}

/// Writes a drawing, and the folder that it goes to.
fn save(path: &Path, svg: &str) -> Result<(), FileError> {
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(FileError::on("create", folder))?;
    }
    run_folder::write(path, svg.as_bytes())
}

/// The list, one number a line.
pub fn print(robot: &Robot, found: &Check) {
    println!("{}: {}", robot.name, summary(found));
    for finding in &found.findings {
        println!("{}", line(finding));
        if let Some(next) = &finding.next {
            wrapped(next).iter().for_each(|line| println!("       {line}"));
        }
    }
}

fn summary(found: &Check) -> String {
    let (errors, warnings) = (found.count(Mark::Error), found.count(Mark::Warning));
    format!("{}, {}", counted(errors, "error"), counted(warnings, "warning"))
}

/// How many of something.
pub fn counted(count: usize, one: &str) -> String {
    match count {
        0 => format!("no {one}s"),
        1 => format!("1 {one}"),
        many => format!("{many} {one}s"),
    }
}

fn line(finding: &Finding) -> String {
    let Finding { topic, mark, part, value, unit, least, most, .. } = finding;
    let mark = match mark {
        Mark::Ok => "ok",
        Mark::Note => "note",
        Mark::Warning => "warn",
        Mark::Error => "ERROR",
    };
    let limits = match (least.map(short), most.map(short)) {
        (Some(least), Some(most)) if least == most => format!("must be {least}"),
        (Some(least), Some(most)) => format!("{least} to {most} {unit}"),
        (Some(least), None) => format!("at least {least} {unit}"),
        (None, Some(most)) => format!("at most {most} {unit}"),
        (None, None) => String::new(),
    };
    let value = format!("{} {unit}", short(*value));
    let text = format!(
        "{mark:<5}  {:<20} {value:<14} {limits:<22} {}",
        topic.label(),
        part.as_deref().unwrap_or("")
    );
    text.trim_end().to_owned()
}

/// Three digits or the whole number.
fn short(value: f64) -> String {
    let size = value.abs();
    if size >= 100.0 || size.fract() == 0.0 {
        format!("{value:.0}")
    } else {
        let digits = (2 - size.max(1e-4).log10().floor() as i32).clamp(0, 5) as usize;
        let text = format!("{value:.digits$}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    }
}

fn wrapped(text: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 1 + word.chars().count() <= COLUMNS - 7 => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits_at_most_after_what_leads() {
        let shown = [0.0, 4.0, 0.45, 0.183_39, 0.000_123, 12.345, 62.5, 1234.5, -0.5].map(short);

        assert_eq!(shown, ["0", "4", "0.45", "0.183", "0.00012", "12.3", "62.5", "1234", "-0.5"]);
    }
}
