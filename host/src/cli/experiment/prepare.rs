//! `--retrain`: every gait made anew, by the commands that a person would type.
//!
//! Holds the order of the commands and what is kept of their output. Which
//! method is made how is said in [`Method::spec`]; `--effort` scales training
//! and searches alike. What an interrupted call has made is not made twice.

use super::ExperimentError;
use super::request::Retraining;
use crate::cli::Cause;
use crate::cli::steps::{StepError, Steps};
use crate::experiment::materials::{
    LEARNING, MADE, Made, MadeFile, Materials, SPREAD, STRIDE, file_name, folder_name, read_made,
};
use crate::experiment::method::{Method, Recipe};
use crate::learn::preset::Preset;
use crate::learn::record;
use crate::learn::run_config::{ConfigError, RunConfig};
use crate::robot::Robot;
use crate::run_folder::{self, FileError};
use crate::search::optimise::result::OptimiseResult;
use crate::search::sinusoid::result::SinusoidResult;
use crate::sim::ant_env::CONTROL_RATE_HZ;
use clap::ValueEnum as _;
use serde::de::{DeserializeOwned, IgnoredAny};
use std::path::{Path, PathBuf};
use std::time::Instant;
use thiserror::Error;

/// Simulated time of a trial of `optimise`: 1 s of entry, 5 s of walking.
const SEARCH_TRIAL_S: f64 = 6.0;

/// Why gaits were not made.
#[derive(Debug, Error)]
pub enum PrepareError {
    /// A preset that cannot be read.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// What was made cannot be noted.
    #[error("cannot note how gaits were made")]
    Made(#[from] toml::ser::Error),
    /// Another call made it with another seed or effort.
    #[error("{path} has the gait of {method} already, made with another --seed or --effort")]
    Otherwise {
        /// Which method.
        method: &'static str,
        /// Where that is noted.
        path: PathBuf,
    },
}

/// Makes the gaits of one robot.
struct GaitBuilder<'a> {
    retraining: Retraining,
    steps: Steps,
    robot_flags: [String; 2],
    /// The study's.
    folder: &'a Path,
    /// Runs and searches.
    work: PathBuf,
    /// Where the gaits that take part are kept.
    gaits: &'a Path,
    made: MadeFile,
}

/// A policy's training, as its method asks for it.
struct Training {
    preset: Preset,
    seeds: u64,
    seam: &'static str,
    keeps_stride: bool,
}

/// Makes the gaits of some methods that the folder lacks.
pub fn make(
    retraining: Retraining,
    methods: &[Method],
    robot: &Robot,
    folder: &Path,
    gaits: &Path,
) -> Result<(), ExperimentError> {
    let work = folder.join("prepare").join(folder_name(robot));
    std::fs::create_dir_all(&work).map_err(FileError::on("create", &work))?;
    let robot_folder = work.join(run_folder::ROBOT);
    robot.save(&robot_folder)?;
    let robot_flags = ["--robot".to_owned(), robot_folder.display().to_string()];
    let made = read_made(gaits)?;
    let steps = Steps::new()?;
    let mut builder = GaitBuilder { retraining, steps, robot_flags, folder, work, gaits, made };
    Method::all().filter(|method| methods.contains(method)).try_for_each(|method| builder.make(method))
}

impl GaitBuilder<'_> {
    fn make(&mut self, method: Method) -> Result<(), ExperimentError> {
        match method.spec().recipe {
            None => Ok(()),
            Some(Recipe::With(other)) => self.make(other),
            Some(_) if self.has(method)? => Ok(()),
            Some(Recipe::Train { preset, seeds, seam, keeps_stride }) => {
                self.train(method, &Training { preset, seeds, seam, keeps_stride })
            }
            Some(Recipe::Sinusoid { preset, seeds }) => self.sinusoid(method, preset, seeds),
            Some(Recipe::Optimise { trials, least_trials }) => self.optimise(method, trials, least_trials),
        }
    }

    /// Whether it was made before with the same seed and effort: all methods get the same.
    fn has(&self, method: Method) -> Result<bool, PrepareError> {
        let Some(made) = self.made.get(method.name()) else { return Ok(false) };
        if (made.seed, made.effort) == (Some(self.retraining.seed), Some(self.retraining.effort)) {
            return Ok(true);
        }
        Err(PrepareError::Otherwise { method: method.name(), path: self.gaits.join(MADE) })
    }

    /// A policy, its stride and its curves.
    fn train(&mut self, method: Method, training: &Training) -> Result<(), ExperimentError> {
        let Training { preset, seeds, seam, keeps_stride } = *training;
        let began = Instant::now();
        let config = scaled(preset, self.retraining.effort)?;
        let path = self.work.join(format!("{}.toml", method.name()));
        let text = format!(
            "based_on = \"{}\"\n\n[schedule]\nepochs = {}\n",
            preset_name(preset),
            config.schedule.epochs
        );
        run_folder::write(&path, text.as_bytes())?;
        let run = self.work.join(method.name());
        let (run_name, path) = (run.display().to_string(), path.display().to_string());
        let range = format!("{}..{}", self.retraining.seed, self.retraining.seed + seeds);
        let mut commands = Vec::new();
        let robot = self.robot_flags.clone();
        let flags = ["--config", &path, "--seeds", &range, "--out", &run_name, &robot[0], &robot[1]];
        if run.join(run_folder::CONFIG).exists() || run.join("seeds.json").exists() {
            self.step::<IgnoredAny>("train", &["--resume", &run_name], &mut Vec::new())?;
            // The same networks as without the interruption, and so by the same command.
            commands.push(format!("host train {}", flags.join(" ")));
        } else {
            self.step::<IgnoredAny>("train", &flags, &mut commands)?;
        }
        self.step::<IgnoredAny>("record", &["--run", &run_name], &mut commands)?;
        if keeps_stride {
            self.keep(&run.join(run_folder::TRAJECTORY), STRIDE)?;
            self.keep(&run.join(record::SPREAD), SPREAD)?;
            for k in 0..seeds {
                let seed = format!("seed-{}", self.retraining.seed + k);
                let curve = run.join(&seed).join(run_folder::LEARNING_CURVE);
                self.keep(&curve, &format!("{LEARNING}/{seed}/{}", run_folder::LEARNING_CURVE))?;
            }
            let with_it = |other: &Method| other.spec().recipe == Some(Recipe::With(method));
            for other in Method::all().filter(with_it) {
                self.note(other, &commands, Some(simulated_s(&config, seeds)), began)?;
            }
        }
        // Walked in any case: a servo that lags is part of what is compared.
        self.step::<IgnoredAny>("fit", &["--run", &run_name, "--seam", seam, "--lag"], &mut commands)?;
        self.keep(&run.join(run_folder::GAIT), &file_name(method))?;
        self.note(method, &commands, Some(simulated_s(&config, seeds)), began)
    }

    fn sinusoid(&mut self, method: Method, preset: Preset, seeds: u64) -> Result<(), ExperimentError> {
        let began = Instant::now();
        let budget_s = simulated_s(&scaled(preset, self.retraining.effort)?, seeds).round();
        let flags = ["--preset", &preset_name(preset)];
        let (result, commands): (SinusoidResult, _) =
            self.search("sinusoid", method, &flags, ["--budget-s", &budget_s.to_string()])?;
        self.note(method, &commands, Some(result.simulated_s), began)
    }

    fn optimise(&mut self, method: Method, trials: f64, least_trials: f64) -> Result<(), ExperimentError> {
        let began = Instant::now();
        let trials = (trials * self.retraining.effort).max(least_trials).round().to_string();
        let (result, commands): (OptimiseResult, _) =
            self.search("optimise", method, &[], ["--budget", &trials])?;
        self.note(method, &commands, Some(SEARCH_TRIAL_S * result.evaluations as f64), began)
    }

    /// A search in a folder of its own, of which the gait is kept: its result and its command.
    fn search<T: DeserializeOwned>(
        &mut self,
        step: &'static str,
        method: Method,
        flags: &[&str],
        budget: [&str; 2],
    ) -> Result<(T, Vec<String>), ExperimentError> {
        let out = self.fresh(method)?;
        let (seed, out_name) = (self.retraining.seed.to_string(), out.display().to_string());
        let robot = self.robot_flags.clone();
        let own = ["--seed", &seed, budget[0], budget[1], "--out", &out_name, &robot[0], &robot[1]];
        let mut commands = Vec::new();
        let result = self.step(step, &[flags, &own[..]].concat(), &mut commands)?;
        self.keep(&out.join(run_folder::GAIT), &file_name(method))?;
        Ok((result, commands))
    }

    fn step<T: DeserializeOwned>(
        &mut self,
        step: &'static str,
        flags: &[&str],
        commands: &mut Vec<String>,
    ) -> Result<T, ExperimentError> {
        commands.push(format!("host {step} {}", flags.join(" ")));
        self.steps.run(step, flags).map_err(|error| match error {
            StepError::Failed { cause: Cause::Interrupted, .. } => {
                ExperimentError::Interrupted { folder: self.folder.to_owned() }
            }
            error => error.into(),
        })
    }

    /// A folder for a search; the remains of an interrupted one are removed, since none can be resumed.
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
            seed: Some(self.retraining.seed),
            effort: Some(self.retraining.effort),
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

/// Wall-clock time of all that was made, in this call or before it. A gait that comes with the
/// training of another method is counted once, there.
pub fn wall_s(legs: &[Materials]) -> f64 {
    let of_leg = |materials: &Materials| -> f64 {
        let notes = || materials.gaits.iter().map(|material| &material.note);
        let is_there = |method: Method| notes().any(|note| note.method == method);
        let comes_with = |method: Method| match method.spec().recipe {
            Some(Recipe::With(other)) => is_there(other),
            _ => false,
        };
        let own = notes().filter(|note| !comes_with(note.method));
        own.filter_map(|note| note.prepare_wall_s).sum()
    };
    legs.iter().map(of_leg).sum()
}
