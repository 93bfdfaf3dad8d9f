//! `curves`: learning curves, as in the paper's Figure 3.
//!
//! Holds the flags and the summary. Does not depend on how curves are read, averaged
//! and drawn: that is [`crate::learn::curves`].

use super::explain::{failure, failure_with_help, file_cause, path_text, warn};
use super::{Cause, Failure};
use crate::learn::curves::{
    self, Band, CurvesError, RunCurves, Score, SeedCurve, Spread, TooManyRuns, default_label,
};
use crate::learn::td3::curve::CurveError;
use crate::run_folder::{self, FileError};
use serde::{Deserialize, Serialize};
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Default name of the picture.
const FIGURE: &str = "curves.svg";

/// Draw learning curves: mean and spread over the seeds of each run.
///
/// Reward and speed of the evaluations over updates. A run that still trains, or was stopped,
/// is drawn up to its last evaluation.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Run folders of `train` or `train --seeds`, a curve each
    #[arg(value_name = "RUN", default_value = run_folder::LATEST)]
    runs: Vec<PathBuf>,

    /// Labels of the runs, in their order [default: the folder and the leg length]
    #[arg(long = "label", value_name = "NAME")]
    labels: Vec<String>,

    /// What is shaded: one standard deviation either way, or minimum to maximum over seeds
    #[arg(long, value_enum, default_value = "deviation")]
    band: Shaded,

    /// File of the picture [default: curves.svg in the run's folder, for several runs in runs]
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

/// Flags that clap cannot check.
#[derive(Debug, Error)]
enum BadFlag {
    #[error("{labels} labels (--label) for {runs} runs: give one for each run, or none")]
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
    // A run that is drawn twice is warned of once.
    for warning in warnings.filter(|warning| said.insert(warning.clone())) {
        warn(&warning);
    }
    let band = match args.band {
        Shaded::Deviation => Band::Deviation,
        Shaded::Range => Band::Range,
    };
    let figure = curves::figure(&runs, band)
        .map_err(|e: TooManyRuns| failure_with_help(Cause::Usage, e, "draw fewer runs"))?;
    let svg = figure.to_svg().map_err(|e| failure(Cause::Input, e))?;
    let out = out_path(&args)?;
    run_folder::write(&out, svg.as_bytes()).map_err(|e| failure(Cause::Machine, e))?;
    if args.json {
        let runs = runs.iter().zip(&args.runs).map(|(run, folder)| summary(run, folder)).collect();
        println!("{}", serde_json::json!(CurvesResult { figure: path_text(&out), runs }));
    } else {
        print(&runs, &out);
    }
    Ok(())
}

fn unreadable(error: CurvesError) -> Failure {
    let help = match &error {
        CurvesError::NoCurve { .. } => {
            "name the folder of a run with at least one evaluation: train makes one in runs"
        }
        CurvesError::Grid { .. } => {
            "seeds of one run must have the same schedule; draw these as separate runs, each by its folder"
        }
        CurvesError::Curve(CurveError::File(_)) => return failure(Cause::Input, error),
        CurvesError::Curve(_) => {
            "train writes the whole file, so it was edited or damaged; `train --resume` writes it again"
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
            "{folder}: {} have fewer evaluations; beyond them the mean is over the others, and dashed",
            behind.join(", ")
        ));
    }
    warnings
}

/// What `curves --json` prints.
#[derive(Debug, Serialize, Deserialize)]
struct CurvesResult {
    /// Path of the picture.
    figure: String,
    runs: Vec<RunSummary>,
}

/// One run, over its seeds.
#[derive(Debug, Serialize, Deserialize)]
struct RunSummary {
    run: String,
    label: String,
    /// Number of seeds with a curve.
    seeds: usize,
    /// Over each seed's latest evaluation.
    #[serde(rename = "final")]
    last: Score,
    /// Over each seed's best evaluation.
    best: Score,
    /// Seeds without an evaluation yet.
    without_curve: Vec<String>,
    each: Vec<SeedSummary>,
}

/// One seed, after its latest evaluation.
#[derive(Debug, Serialize, Deserialize)]
struct SeedSummary {
    seed: String,
    updates: u64,
    env_steps: u64,
    wall_s: f64,
    #[serde(rename = "final")]
    last: EvaluationSummary,
    best: BestSummary,
}

/// One evaluation.
#[derive(Debug, Serialize, Deserialize)]
struct EvaluationSummary {
    reward: f64,
    speed_m_s: f64,
}

/// The best evaluation, and the updates before it.
#[derive(Debug, Serialize, Deserialize)]
struct BestSummary {
    updates: u64,
    reward: f64,
    speed_m_s: f64,
}

fn summary(run: &RunCurves, folder: &Path) -> RunSummary {
    let seed = |seed: &SeedCurve| {
        let (last, best) = (seed.last(), seed.best());
        SeedSummary {
            seed: seed.name.clone(),
            updates: last.updates,
            env_steps: last.env_steps,
            wall_s: last.wall_s,
            last: EvaluationSummary { reward: last.reward, speed_m_s: last.speed_m_s },
            best: BestSummary { updates: best.updates, reward: best.reward, speed_m_s: best.speed_m_s },
        }
    };
    RunSummary {
        run: path_text(folder),
        label: run.label.clone(),
        seeds: run.seeds.len(),
        last: run.last(),
        best: run.best(),
        without_curve: run.without_curve.clone(),
        each: run.seeds.iter().map(seed).collect(),
    }
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
        println!("Mean \u{b1} standard deviation over the seeds (minimum to maximum).");
    }
    println!("Best: each seed's best evaluation by reward, whose policy is kept.");
    println!("{}", out.display());
}

fn spread(value: &Spread, decimals: usize, seeds: usize) -> String {
    let Spread { mean, deviation, min, max } = value;
    if seeds == 1 {
        return format!("{mean:.decimals$}");
    }
    format!("{mean:.decimals$} \u{b1} {deviation:.decimals$} ({min:.decimals$} to {max:.decimals$})")
}
