//! `--retrain`: every gait made anew, as a person would with the other commands.
//!
//! Owns the order of the commands, what is kept of them, and equal effort:
//! `--effort` scales training, the sinusoid's search and ours alike. What is
//! there from an interrupted call is not made twice.

use super::{Args, ExperimentError};
use crate::cli::Cause;
use crate::cli::steps::{StepError, Steps};
use crate::experiment::materials::{LEARNING, MADE, Made, MadeFile, Materials, SPREAD, STRIDE, read_made};
use crate::experiment::method::Method;
use crate::experiment::plan::Plan;
use crate::learn::record;
use crate::learn::td3::preset::Preset;
use crate::learn::td3::run_config::{ConfigError, RunConfig};
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use crate::sim::ant_env::CONTROL_RATE_HZ;
use clap::ValueEnum as _;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::time::Instant;
use thiserror::Error;

/// Seeds that are trained, of which the best is taken: PSTO's, whose rival has as much simulated time,
const PSTO_SEEDS: u64 = 2;
/// and those of the policy that pays for power.
const OURS_SEEDS: u64 = 3;
/// Trials of the search at full effort: ten minutes of two cores.
const SEARCH_TRIALS: f64 = 30_000.0;
/// Fewer are no search.
const LEAST_SEARCH_TRIALS: f64 = 300.0;

/// Why gaits were not made.
#[derive(Debug, Error)]
pub enum PrepareError {
    /// A preset of ours that is none.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// What was made cannot be noted.
    #[error("cannot note how gaits were made")]
    Made(#[from] toml::ser::Error),
    /// Another call made it otherwise.
    #[error("{path} has the gait of {method} already, made with another --seed or --effort")]
    Otherwise {
        /// Which method.
        method: &'static str,
        /// Where that is noted.
        path: PathBuf,
    },
}

/// One robot's gaits in the making.
struct Making<'a> {
    args: &'a Args,
    steps: Steps,
    robot_flags: [String; 2],
    /// The study's.
    folder: &'a Path,
    /// Runs and searches.
    work: PathBuf,
    /// What of them takes part.
    gaits: &'a Path,
    made: MadeFile,
}

/// Makes what the plan asks for and the folder lacks.
pub fn make(
    args: &Args,
    plan: &Plan,
    robot: &Robot,
    folder: &Path,
    gaits: &Path,
) -> Result<(), ExperimentError> {
    let name = crate::experiment::materials::folder_name(robot);
    let work = folder.join("prepare").join(name);
    std::fs::create_dir_all(&work).map_err(FileError::on("create", &work))?;
    let robot_folder = work.join(run_folder::ROBOT);
    robot.save(&robot_folder)?;
    let robot_flags = ["--robot".to_owned(), robot_folder.display().to_string()];
    let made = read_made(gaits)?;
    let mut making = Making { args, steps: Steps::new()?, robot_flags, folder, work, gaits, made };
    let wants = |methods: &[Method]| plan.methods.iter().any(|method| methods.contains(method));
    if wants(&[Method::Original, Method::Psto]) {
        making.learned(Method::Psto, Preset::Psto, PSTO_SEEDS, "free")?;
    }
    if wants(&[Method::Ours]) {
        making.learned(Method::Ours, Preset::Walk, OURS_SEEDS, "continuous")?;
    }
    if wants(&[Method::Sinusoid]) {
        making.sinusoid()?;
    }
    if wants(&[Method::Searched]) {
        making.searched()?;
    }
    Ok(())
}

impl Making<'_> {
    /// Whether it was made before, by the same seed and effort: rivals must have had equal chances.
    fn has(&self, method: Method) -> Result<bool, PrepareError> {
        let Some(made) = self.made.get(method.name()) else { return Ok(false) };
        if (made.seed, made.effort) == (Some(self.args.seed), Some(self.args.effort)) {
            return Ok(true);
        }
        Err(PrepareError::Otherwise { method: method.name(), path: self.gaits.join(MADE) })
    }

    /// A policy, its stride and its curves.
    fn learned(
        &mut self,
        method: Method,
        preset: Preset,
        seeds: u64,
        seam: &'static str,
    ) -> Result<(), ExperimentError> {
        if self.has(method)? {
            return Ok(());
        }
        let began = Instant::now();
        let config = scaled(preset, self.args.effort)?;
        let path = self.work.join(format!("{}.toml", method.name()));
        let text = format!(
            "based_on = \"{}\"\n\n[schedule]\nepochs = {}\n",
            preset_name(preset),
            config.schedule.epochs
        );
        run_folder::write(&path, text.as_bytes())?;
        let run = self.work.join(method.name());
        let (run_name, path) = (run.display().to_string(), path.display().to_string());
        let range = format!("{}..{}", self.args.seed, self.args.seed + seeds);
        let mut commands = Vec::new();
        let robot = self.robot_flags.clone();
        let flags = ["--config", &path, "--seeds", &range, "--out", &run_name, &robot[0], &robot[1]];
        if run.join(run_folder::CONFIG).exists() || run.join("seeds.json").exists() {
            self.step("train", &["--resume", &run_name], &mut Vec::new())?;
            // The same networks as without the interruption, and so by the same command.
            commands.push(format!("host train {}", flags.join(" ")));
        } else {
            self.step("train", &flags, &mut commands)?;
        }
        self.step("record", &["--run", &run_name], &mut commands)?;
        if method == Method::Psto {
            self.keep(&run.join(run_folder::TRAJECTORY), STRIDE)?;
            self.keep(&run.join(record::SPREAD), SPREAD)?;
            for k in 0..seeds {
                let seed = format!("seed-{}", self.args.seed + k);
                let curve = run.join(&seed).join(run_folder::LEARNING_CURVE);
                self.keep(&curve, &format!("{LEARNING}/{seed}/{}", run_folder::LEARNING_CURVE))?;
            }
            self.note(Method::Original, &commands, Some(simulated_s(&config, seeds)), began)?;
        }
        // Walked in any case: a servo that lags is part of what is compared.
        self.step("fit", &["--run", &run_name, "--seam", seam, "--lag"], &mut commands)?;
        self.keep(&run.join(run_folder::GAIT), &format!("{}.toml", method.name()))?;
        self.note(method, &commands, Some(simulated_s(&config, seeds)), began)
    }

    /// The rival, with the simulated time that PSTO had.
    fn sinusoid(&mut self) -> Result<(), ExperimentError> {
        if self.has(Method::Sinusoid)? {
            return Ok(());
        }
        let began = Instant::now();
        let budget_s = simulated_s(&scaled(Preset::Psto, self.args.effort)?, PSTO_SEEDS).round();
        let out = self.fresh(Method::Sinusoid)?;
        let (seed, budget) = (self.args.seed.to_string(), budget_s.to_string());
        let out_name = out.display().to_string();
        let robot = self.robot_flags.clone();
        let mut commands = Vec::new();
        let flags = [
            "--preset",
            "psto",
            "--seed",
            &seed,
            "--budget-s",
            &budget,
            "--out",
            &out_name,
            &robot[0],
            &robot[1],
        ];
        let json = self.step("sinusoid", &flags, &mut commands)?;
        self.keep(&out.join(run_folder::GAIT), "sinusoid.toml")?;
        self.note(Method::Sinusoid, &commands, json["simulated_s"].as_f64().or(Some(budget_s)), began)
    }

    fn searched(&mut self) -> Result<(), ExperimentError> {
        if self.has(Method::Searched)? {
            return Ok(());
        }
        let began = Instant::now();
        let out = self.fresh(Method::Searched)?;
        let trials = (SEARCH_TRIALS * self.args.effort).max(LEAST_SEARCH_TRIALS).round().to_string();
        let (seed, out_name) = (self.args.seed.to_string(), out.display().to_string());
        let robot = self.robot_flags.clone();
        let mut commands = Vec::new();
        let flags = ["--seed", &seed, "--budget", &trials, "--out", &out_name, &robot[0], &robot[1]];
        let json = self.step("optimise", &flags, &mut commands)?;
        self.keep(&out.join(run_folder::GAIT), "searched.toml")?;
        // A trial of the search: 1 s of entry, 5 s of walking.
        self.note(Method::Searched, &commands, json["evaluations"].as_f64().map(|n| 6.0 * n), began)
    }

    fn step(
        &mut self,
        step: &'static str,
        flags: &[&str],
        commands: &mut Vec<String>,
    ) -> Result<Value, ExperimentError> {
        commands.push(format!("host {step} {}", flags.join(" ")));
        self.steps.run(step, flags).map_err(|error| match error {
            StepError::Failed { cause: Cause::Interrupted, .. } => {
                ExperimentError::Interrupted { folder: self.folder.to_owned() }
            }
            error => error.into(),
        })
    }

    /// A folder for a search; what an interrupted one left there goes, it cannot be gone on with.
    fn fresh(&self, method: Method) -> Result<PathBuf, ExperimentError> {
        let out = self.work.join(method.name());
        if out.exists() {
            std::fs::remove_dir_all(&out).map_err(FileError::on("remove", &out))?;
        }
        Ok(out)
    }

    fn keep(&self, from: &Path, name: &str) -> Result<(), ExperimentError> {
        let bytes = std::fs::read(from).map_err(FileError::on("read", from))?;
        let path = self.gaits.join(name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(FileError::on("create", parent))?;
        }
        Ok(run_folder::write(&path, &bytes)?)
    }

    fn note(
        &mut self,
        method: Method,
        commands: &[String],
        simulated_s: Option<f64>,
        began: Instant,
    ) -> Result<(), ExperimentError> {
        let made = Made {
            seed: Some(self.args.seed),
            effort: Some(self.args.effort),
            simulated_s,
            wall_s: Some((10.0 * began.elapsed().as_secs_f64()).round() / 10.0),
            commands: commands.to_vec(),
        };
        self.made.insert(method.name().to_owned(), made);
        let text = toml::to_string_pretty(&self.made).map_err(PrepareError::from)?;
        Ok(run_folder::write(&self.gaits.join(MADE), text.as_bytes())?)
    }
}

/// The preset with a share of its epochs.
fn scaled(preset: Preset, effort: f64) -> Result<RunConfig, PrepareError> {
    let mut config = RunConfig::preset(preset)?;
    config.schedule.epochs = (config.schedule.epochs as f64 * effort).round().max(1.0) as u64;
    Ok(config)
}

/// Simulated time of all seeds: what is gathered to learn from, and what is walked to choose the
/// best policy by.
fn simulated_s(config: &RunConfig, seeds: u64) -> f64 {
    let schedule = &config.schedule;
    let gathered = schedule.warm_up_env_steps
        + schedule.epochs * schedule.updates_per_epoch * schedule.env_steps_per_update;
    let evaluated =
        (schedule.epochs + 1) * schedule.evaluation_episodes as u64 * u64::from(config.env.episode_steps);
    (seeds * (gathered + evaluated)) as f64 / CONTROL_RATE_HZ
}

/// As `based_on` has it.
fn preset_name(preset: Preset) -> String {
    preset.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

/// Wall-clock time of all that was made, in this call or before it. PSTO's has its stride's in it,
/// which is the original's.
pub fn wall_s(legs: &[Materials]) -> f64 {
    let of_leg = |materials: &Materials| -> f64 {
        let notes = || materials.gaits.iter().map(|material| &material.note);
        let has_psto = notes().any(|note| note.method == Method::Psto);
        let own = notes().filter(|note| !(has_psto && note.method == Method::Original));
        own.filter_map(|note| note.prepare_wall_s).sum()
    };
    legs.iter().map(of_leg).sum()
}
