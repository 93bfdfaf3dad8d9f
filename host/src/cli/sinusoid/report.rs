//! The result of a search, for people and for scripts.
//!
//! Holds the words, the fields of the JSON, and the table of evaluations. Does
//! not depend on how a gait is searched.

use crate::cli::explain::{path_text, warn};
use crate::gait::gait_file::{GaitFile, gait_sha256};
use crate::learn::preset::Preset;
use crate::robot::Robot;
use crate::search::optimise::report::TRIAL_S;
use crate::search::sinusoid::result::SinusoidResult;
use crate::search::sinusoid::search::{Evaluation, Found};
use crate::search::sinusoid::task::seconds;
use crate::search::sinusoid::wave::{Pairs, Sinusoid, Wave};
use crate::sim::ant_env::ACTION_DEG;
use crate::sim::open_loop::direction_warning;
use std::path::Path;
use thiserror::Error;

/// The table of evaluations could not be made.
#[derive(Debug, Error)]
#[error("the table of evaluations could not be made")]
pub struct Unwritable {
    source: Box<dyn std::error::Error + Send + Sync>,
}

/// A gait and all that is known of it.
pub struct Outcome<'a> {
    pub robot: &'a Robot,
    pub gait: &'a GaitFile,
    pub path: &'a Path,
    pub found: &'a Found,
    pub preset: Preset,
    pub pairs: Pairs,
    pub seed: u64,
    pub wall_s: f64,
    /// Of the described robot in 12 s, along x and y.
    pub displacement_m: [f64; 2],
}

impl Outcome<'_> {
    /// What scripts read.
    pub fn result(&self) -> SinusoidResult {
        let Self { found, .. } = self;
        let names = Sinusoid::NAMES.iter().map(|name| (*name).to_owned());
        SinusoidResult {
            leg: self.robot.geometry.leg_scale,
            seed: self.seed,
            preset: self.preset,
            pairs: self.pairs,
            wall_s: self.wall_s,
            evaluations: found.evaluations.len(),
            rounds: found.rounds(),
            simulated_s: seconds(found.steps),
            reward_per_step: found.score.reward_per_step,
            period_s: found.motion.period_s,
            speed_m_s: found.score.speed_m_s,
            forward_m: self.displacement_m[0],
            sideways_m: self.displacement_m[1],
            power_w: found.score.power_w,
            cost_of_transport: found.score.cost_of_transport,
            falls: found.score.falls,
            amplitude: ACTION_DEG / self.gait.unit_deg,
            parameters: names.zip(found.gait.numbers()).collect(),
            gait: path_text(self.path),
            gait_sha256: self.gait.encoded().map(|bytes| gait_sha256(&bytes)).unwrap_or_default(),
        }
    }

    /// Warns if the gait does not walk forward.
    pub fn warn(&self) {
        if let Some(warning) = direction_warning(self.displacement_m, TRIAL_S) {
            warn(&warning);
        }
    }

    pub fn print(&self) {
        let Self { found, gait, .. } = self;
        println!(
            "gait \"{}\": a stride of {:.3} s, found in {} evaluations ({}), {:.0} s of simulation, {:.0} s",
            gait.name,
            found.motion.period_s,
            found.evaluations.len(),
            if found.rounds() == 1 { "one round".to_owned() } else { format!("{} rounds", found.rounds()) },
            seconds(found.steps),
            self.wall_s
        );
        let score = &found.score;
        let from =
            if found.stopped { "the search's own starts" } else { "starts that the search has not seen" };
        println!("\nIn the task that `train` learns, from {from}:");
        println!("reward per step    {:8.3}", score.reward_per_step);
        println!("speed              {:8.3} m/s", score.speed_m_s);
        println!("mean power         {:8.3} W", score.power_w);
        println!("cost of transport  {:8.3}", score.cost_of_transport);
        println!("falls              {:8}", score.falls);

        println!("\n           amplitude    phase   offset");
        let [a, b] = self.pairs.names();
        let Sinusoid { hips, knees, .. } = &found.gait;
        for (joints, waves) in [("hips", hips), ("knees", knees)] {
            for (legs, Wave { amplitude_deg, phase, offset_deg }) in [a, b].into_iter().zip(waves) {
                println!("{joints:5} {legs}  {amplitude_deg:8.2} {phase:8.3} {offset_deg:8.2}");
            }
        }
        println!("\n{}", self.path.display());
        let own = ACTION_DEG / gait.unit_deg;
        println!("Next: cargo run -p host -- simulate --amp {own} {}", self.path.display());
    }
}

/// The table of all evaluations, in the order in which they were made.
pub fn table(evaluations: &[Evaluation]) -> Result<Vec<u8>, Unwritable> {
    let failed = |error: csv::Error| Unwritable { source: Box::new(error) };
    let mut table = csv::Writer::from_writer(Vec::new());
    let figures = ["reward_per_step", "speed_m_s", "power_w", "falls"];
    let head = ["evaluation", "round", "stage"].into_iter().chain(Sinusoid::NAMES).chain(figures);
    table.write_record(head).map_err(failed)?;
    for (number, Evaluation { round, stage, gait, score, .. }) in evaluations.iter().enumerate() {
        let own = [number.to_string(), round.to_string(), stage.name().to_owned()];
        let numbers = gait.numbers().map(|number| number.to_string());
        let figures = [score.reward_per_step, score.speed_m_s, score.power_w].map(|n| n.to_string());
        let falls = [score.falls.to_string()];
        table.write_record(own.iter().chain(&numbers).chain(&figures).chain(&falls)).map_err(failed)?;
    }
    table.into_inner().map_err(|error| Unwritable { source: Box::new(error) })
}
