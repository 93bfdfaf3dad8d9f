//! `host simulate`: a gait on the simulated robot, without firmware and ports.
//!
//! Holds the flags and the words. Does not depend on how a trial is simulated,
//! which is [`crate::sim::open_loop`]'s.

mod report;
mod result;

use super::explain::{failure, failure_with_help};
use super::material::Material;
use super::ranges::{DURATION_RANGE_S, OutOfRange, check_range};
use super::robots::{self, RobotArg};
use super::{Cause, Failure};
use crate::gait::gait_file::Source;
use crate::robot::LegScale;
use crate::run_folder;
use crate::sim::Perturbation;
use crate::sim::open_loop::{Playback, Starts, Trial, Walk, play_starts};
use protocol::Amplitude;
use std::path::{Path, PathBuf};

/// Default amplitude: about a policy's own stroke,
const AMPLITUDE: f64 = 2.0;
/// and for a searched gait the stroke that was searched.
const SEARCHED_AMPLITUDE: f64 = 1.0;

/// Play a gait open loop in simulation: speed, power, cost of transport, falls.
///
/// The setpoints are computed 60 times a second from the table that the robot plays, held at
/// its limits and rounded to pulses, as in the firmware; there is no feedback. The starts
/// differ a little in heading, height, joint angles and friction.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The gait: a readable file, or the bytes of a table (.bin) [default: that of the last run]
    gait: Option<PathBuf>,
    /// Amplitude about each joint's centre, 0.5 to 3.0; 1.875 is a policy's own stroke [default:
    /// 2, and 1 for a gait of host optimise]
    #[arg(long = "amp", value_name = "X")]
    amplitude: Option<f64>,
    /// Length of the walk from each start, in seconds
    #[arg(long = "duration", value_name = "S", default_value_t = 60.0)]
    duration_s: f64,
    /// Number of starts
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    starts: u32,
    /// Random seed of the starts
    #[arg(long, default_value_t = 0, value_parser = super::seed())]
    seed: u64,
    /// Folder of the robot that walks [default: the run's, else the Ant with the gait's legs]
    #[arg(long, value_name = "FOLDER", conflicts_with = "leg")]
    robot: Option<PathBuf>,
    /// Play it although the gait is of another robot
    #[arg(long)]
    anyway: bool,
    /// The Ant with legs of this length: 1.0 is 23 cm, 0.6 is 13.8 cm
    #[arg(long, value_name = "X")]
    leg: Option<LegScale>,
    /// Print the result as JSON, with a row for each start
    #[arg(long)]
    json: bool,
}

/// What was played, and the walks.
struct Simulated {
    material: Material,
    amplitude: Amplitude,
    /// The same before rounding, as typed or by default.
    amplitude_typed: f64,
    starts: Starts,
    walks: Vec<Walk>,
}

pub fn run(args: Args) -> Result<(), Failure> {
    let exact = |value: f64| {
        let (min, max) = (Amplitude::MIN.value(), Amplitude::MAX.value());
        let error = OutOfRange { flag: "amp", value, min, max };
        Amplitude::from_f64(value).ok_or_else(|| failure(Cause::Usage, error))
    };
    // Before anything is read: a bad flag is a bad flag whatever the gait.
    args.amplitude.map(exact).transpose()?;
    check_range("duration", Some(args.duration_s), DURATION_RANGE_S.0, DURATION_RANGE_S.1)?;
    let default = || Path::new(run_folder::LATEST).join(run_folder::GAIT);
    let path = args.gait.clone().unwrap_or_else(default);
    let named = args.leg.map_or(RobotArg::folder(args.robot.as_deref()), RobotArg::Leg);
    let material = Material::load(path, named, args.anyway)?;
    robots::warn_of(&material.robot);
    let usual = if material.source == Source::Searched.name() { SEARCHED_AMPLITUDE } else { AMPLITUDE };
    let amplitude_typed = args.amplitude.unwrap_or(usual);
    let amplitude = exact(amplitude_typed)?;
    let playback = Playback::new(&material.playable, amplitude, &material.robot);
    let trial = Trial { duration_s: args.duration_s, ..Trial::default() };
    let starts = Starts { perturbation: Perturbation::default(), seed: args.seed, count: args.starts };
    let walks = play_starts(&material.robot, &trial, &starts, |time_s| playback.setpoints_rad(time_s));
    let walks = walks.map_err(|e| {
        let help = "this robot cannot be simulated: are the servos' stiffness and the masses in its robot.toml right?";
        failure_with_help(Cause::Input, e, help)
    })?;
    let simulated = Simulated { material, amplitude, amplitude_typed, starts, walks };
    report::print(&args, &simulated).map_err(|error| failure(Cause::Machine, error))
}
