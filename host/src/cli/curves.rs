//! `curves`: how runs learned, as the paper's Figure 3.
//!
//! Owns the flags and the summary; reading, statistics and picture are
//! [`crate::learn::curves`]'.

use super::explain::{failure, failure_with_help, file_cause, path_text, warn};
use super::{Cause, Failure};
use crate::learn::curves::{
    self, Band, CurvesError, RunCurves, Score, SeedCurve, Spread, TooManyRuns, default_label,
};
use crate::learn::td3::curve::CurveError;
use crate::run_folder::{self, FileError};
use serde_json::{Value, json};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The picture's name where none is given.
const FIGURE: &str = "curves.svg";

/// Draw learning curves: mean and spread over the seeds of each run.
///
/// Reward and speed of the evaluations over updates. A run that is still going on, or was
/// stopped, is drawn as far as it came.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folders of `train` or `train --seeds`; each is a curve
    #[arg(value_name = "RUN", default_value = run_folder::LATEST)]
    runs: Vec<PathBuf>,

    /// What the runs are called, in their order [default: the folder and the leg]
    #[arg(long = "label", value_name = "NAME")]
    labels: Vec<String>,

    /// What is shaded: a standard deviation either way, or from the least seed to the best
    #[arg(long, value_enum, default_value = "deviation")]
    band: Shaded,

    /// Picture to write [default: curves.svg in the run's folder, for several runs in runs]
    #[arg(long, value_name = "FILE.svg")]
    out: Option<PathBuf>,

    /// Print the result as one line of JSON on standard output
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, clap::ValueEnum)]
enum Shaded {
    Deviation,
    Range,
}

/// Flags that clap cannot judge.
#[derive(Debug, Error)]
enum BadFlag {
    #[error("{labels} labels (--label) for {runs} runs: give each its own, or none")]
    Labels { labels: usize, runs: usize },
    #[error("--out {} does not end in .svg", .path.display())]
    Out { path: PathBuf },
}

pub fn run(args: Args) -> Result<(), Failure> {
    let (labels, count) = (args.labels.len(), args.runs.len());
    if labels != 0 && labels != count {
        return Err(failure(Cause::Usage, BadFlag::Labels { labels, runs: count }));
    }
    if let Some(path) = args.out.as_ref().filter(|path| path.extension().is_none_or(|e| e != "svg")) {
        return Err(failure(Cause::Usage, BadFlag::Out { path: path.clone() }));
    }
    let label = |index: usize, folder: &Path| {
        args.labels.get(index).cloned().unwrap_or_else(|| default_label(folder))
    };
    let runs: Vec<RunCurves> = args
        .runs
        .iter()
        .enumerate()
        .map(|(index, folder)| RunCurves::read(folder, label(index, folder)).map_err(unreadable))
        .collect::<Result<_, _>>()?;
    let mut said = HashSet::new();
    let warnings = runs.iter().zip(&args.runs).flat_map(|(run, folder)| warnings(run, folder));
    // A run that is drawn twice is behind once.
    for warning in warnings.filter(|warning| said.insert(warning.clone())) {
        warn(&warning);
    }
    let band = match args.band {
        Shaded::Deviation => Band::Deviation,
        Shaded::Range => Band::Range,
    };
    let figure = curves::figure(&runs, band)
        .map_err(|e: TooManyRuns| failure_with_help(Cause::Usage, e, "draw fewer runs at a time"))?;
    let svg = figure.to_svg().map_err(|e| failure(Cause::Input, e))?;
    let out = out_path(&args)?;
    run_folder::write(&out, svg.as_bytes()).map_err(|e| failure(Cause::Machine, e))?;
    if args.json {
        let runs: Vec<Value> =
            runs.iter().zip(&args.runs).map(|(run, folder)| summary(run, folder)).collect();
        println!("{}", json!({ "figure": path_text(&out), "runs": runs }));
    } else {
        print(&runs, &out);
    }
    Ok(())
}

fn unreadable(error: CurvesError) -> Failure {
    let help = match &error {
        CurvesError::NoCurve { .. } => {
            "name the folder of a run that was evaluated at least once: train makes one in runs"
        }
        CurvesError::Grid { .. } => {
            "seeds of one run share a schedule; draw such seeds as runs of their own, each by its folder"
        }
        CurvesError::Curve(CurveError::File(_)) => return failure(Cause::Input, error),
        CurvesError::Curve(_) => {
            "train writes the file as a whole: was it edited? `train --resume` writes it again"
        }
    };
    failure_with_help(Cause::Input, error, help)
}

fn out_path(args: &Args) -> Result<PathBuf, Failure> {
    let out = match (&args.out, args.runs.as_slice()) {
        (Some(out), _) => out.clone(),
        (None, [run]) => run.join(FIGURE),
        (None, _) => Path::new(run_folder::RUNS).join(FIGURE),
    };
    if let Some(folder) = out.parent() {
        std::fs::create_dir_all(folder)
            .map_err(FileError::on("create", folder))
            .map_err(|e| failure(file_cause(&e), e))?;
    }
    Ok(out)
}

fn warnings(run: &RunCurves, folder: &Path) -> Vec<String> {
    let folder = folder.display();
    let mut warnings = Vec::new();
    if !run.without_curve.is_empty() {
        warnings.push(format!("{folder}: no evaluation yet of {}", run.without_curve.join(", ")));
    }
    let behind: Vec<String> =
        run.behind().map(|seed| format!("{} ({} updates)", seed.name, seed.last().updates)).collect();
    if !behind.is_empty() {
        warnings.push(format!(
            "{folder}: behind the others are {}; beyond, the mean is of the others and dashed",
            behind.join(", ")
        ));
    }
    warnings
}

fn summary(run: &RunCurves, folder: &Path) -> Value {
    let seed = |seed: &SeedCurve| {
        let (last, best) = (seed.last(), seed.best());
        json!({
            "seed": seed.name,
            "updates": last.updates,
            "env_steps": last.env_steps,
            "wall_s": last.wall_s,
            "final": { "reward": last.reward, "speed_m_s": last.speed_m_s },
            "best": { "updates": best.updates, "reward": best.reward, "speed_m_s": best.speed_m_s },
        })
    };
    json!({
        "run": path_text(folder),
        "label": run.label,
        "seeds": run.seeds.len(),
        "final": run.last(),
        "best": run.best(),
        "without_curve": run.without_curve,
        "each": run.seeds.iter().map(seed).collect::<Vec<_>>(),
    })
}

fn print(runs: &[RunCurves], out: &Path) {
    for run in runs {
        let furthest = run.seeds.iter().map(|seed| seed.last().updates).max().unwrap_or(0);
        let count = run.seeds.len();
        println!("{}: {count} seed{}, {furthest} updates", run.label, if count == 1 { "" } else { "s" });
        for (name, Score { reward, speed_m_s }) in [("final", run.last()), ("best", run.best())] {
            let (reward, speed_m_s) = (spread(&reward, 1, count), spread(&speed_m_s, 3, count));
            println!("  {name:5}  reward {reward}   speed {speed_m_s} m/s");
        }
    }
    if runs.iter().any(|run| run.seeds.len() > 1) {
        println!("Mean \u{b1} standard deviation over the seeds (least to most).");
    }
    println!("Best: each seed's best evaluation by reward, whose policy it keeps.");
    println!("{}", out.display());
}

fn spread(value: &Spread, decimals: usize, seeds: usize) -> String {
    let Spread { mean, deviation, least, most } = value;
    if seeds == 1 {
        return format!("{mean:.decimals$}");
    }
    format!("{mean:.decimals$} \u{b1} {deviation:.decimals$} ({least:.decimals$} to {most:.decimals$})")
}
