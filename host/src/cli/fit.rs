//! `host fit`: a trajectory in, a gait out.
//!
//! Owns the history that a gait carries, and the report; the choice of rows and
//! scales is [`super::recording`]'s, the fit and the file are the library's.

pub(super) mod history;
mod joined;
mod kept;
mod pace;
mod policy_record;
mod refusal;
mod report;

use super::explain::{failure, failure_with_help, file_cause};
use super::recording::{Chosen, Recording, Unsaid};
use super::upload_gait::material::playable;
use super::{Cause, Failure};
use crate::gait::fit::{self, Seam};
use crate::gait::gait_file::GaitFile;
use crate::robot::Robot;
use crate::run_folder;
use history::Destination;
use joined::{Joined, Seams};
use kept::Kept;
use pace::Pace;
use policy_record::PolicyRecord;
use protocol::gait::{MAX_PERIOD_US, MIN_PERIOD_US};
use refusal::{unplayable, unsaved};
use std::path::PathBuf;
use thiserror::Error;

/// What the README's story uploads at.
const USUAL_AMPLITUDE: f64 = 2.2;

/// Fit a degree-10 polynomial per joint and write the gait.
///
/// Without --rows, a file as `record` writes it is one stride, and in any other
/// the stride is looked for. Columns hold actions, and the scales are degrees:
/// angle = centre-offset + centre-unit * mean action + amplitude * unit *
/// (action - mean action). Columns in degrees: --unit-deg 1 --centre-unit-deg 1.
///
/// A gait that the servos cannot follow at amplitude 1.0 is refused. Of a run's own
/// recording the gait is played in the simulation, for what it keeps of the policy's speed.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    recording: Recording,
    /// Run folder whose trajectory is fitted [default: the last run's]
    #[arg(long, value_name = "DIR", conflicts_with = "trajectory")]
    run: Option<PathBuf>,
    /// How strides join: with value and slope continuous, or free to jump, as in the paper
    /// [default: continuous; free for what `record --window` recorded]
    #[arg(long, value_name = "free|continuous")]
    seam: Option<Seam>,
    /// Folder of the robot that it is for [default: the run's, else the Ant]
    #[arg(long, value_name = "FOLDER", conflicts_with = "leg")]
    robot: Option<PathBuf>,
    /// Write a gait that the servos cannot follow: they will lag
    #[arg(long)]
    lag: bool,
    /// What the robot will call it, up to 16 characters [default: from the file or the seed]
    #[arg(long)]
    name: Option<String>,
    /// Seed to note in the gait [default: from the run's configuration]
    #[arg(long, value_parser = super::seed())]
    seed: Option<u64>,
    /// Gait file to write; the robot's bytes go beside it as .bin [default: gait.toml beside a
    /// trajectory with time_s, else in a new run folder]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// A flag that clap cannot judge.
#[derive(Debug, Error)]
enum BadFlag {
    #[error("--out {} does not end in .toml", .path.display())]
    Out { path: PathBuf },
    #[error(
        "the stride would last {played_s:.3} s ({recorded_s:.3} s recorded, times {stretch}); a robot plays {} to {} s",
        f64::from(MIN_PERIOD_US) / 1e6, f64::from(MAX_PERIOD_US) / 1e6
    )]
    Period { recorded_s: f64, stretch: f64, played_s: f64 },
}

pub fn run(mut args: Args) -> Result<(), Failure> {
    args.recording.run = args.run.take();
    args.recording.robot = args.robot.take();
    if let Some(path) = args.out.as_ref().filter(|path| path.extension().is_none_or(|e| e != "toml")) {
        return Err(failure(Cause::Usage, BadFlag::Out { path: path.clone() }));
    }
    let chosen = args.recording.choose(Unsaid::FindStride)?;
    check_period(&chosen)?;
    let rows = chosen.actions()?;
    let record = PolicyRecord::beside(&chosen);
    let described = record.as_ref().ok().and_then(Option::as_ref);
    let is_window = described.is_some_and(|record| record.window_s.is_some());
    let seam = args.seam.unwrap_or(Seam::usual(is_window));
    let fits = fit::fit(rows, &chosen.scale, seam).map_err(|e| failure(Cause::Input, e))?;

    let provenance = history::provenance(&args, &chosen, seam);
    let gait = GaitFile {
        name: args.name.clone().unwrap_or_else(|| history::default_name(&chosen.path, &provenance)),
        period_s: chosen.played_s(),
        unit_deg: chosen.scale.unit_deg,
        provenance,
        joints: fits.clone().map(|fit| fit.series),
    };
    let playable = playable(&gait.encoded().map_err(unplayable)?)?;
    let taken = Joined::new(fits, playable, joined::own_stroke(&chosen.scale));
    let seams = Seams::new(seam, taken, rows, &chosen.scale, &gait);
    let robot = match &chosen.robot {
        Some(robot) => robot.clone(),
        None => Robot::ant(1.0).map_err(|e| failure(Cause::Input, e))?,
    };
    let pace = Pace::of(&seams.taken, robot.servo.top_speed_rad_s().to_degrees());
    if !args.lag {
        pace.check(&seams, chosen.time_stretch, &robot.name, described)?;
    }
    let Destination { out, latest } = history::destination(&args, &chosen)?;
    gait.save(&out).map_err(unsaved)?;
    if let Some(folder) = latest {
        run_folder::make_latest(&folder).map_err(|e| failure(file_cause(&e), e))?;
    }
    let crowded_strides = described.and_then(PolicyRecord::crowded_strides);
    let kept = match record {
        Ok(None) => Ok(None),
        Ok(Some(record)) => Kept::of(&chosen, &robot, &gait, &seams, &pace, &record).map(Some),
        Err(error) => Err(error.into()),
    };
    report::print(&args, &Fitted { out, gait, seams, pace, crowded_strides, kept, chosen });
    Ok(())
}

/// All that there is to say about a fit.
struct Fitted {
    out: PathBuf,
    gait: GaitFile,
    seams: Seams,
    pace: Pace,
    /// Strides in one curve, where they are too many.
    crowded_strides: Option<f64>,
    kept: Result<Option<Kept>, kept::NoComparison>,
    chosen: Chosen,
}

/// Refuses strides that no robot plays.
pub fn check_period(chosen: &Chosen) -> Result<(), Failure> {
    let (recorded_s, stretch, played_s) = (chosen.recorded_s, chosen.time_stretch, chosen.played_s());
    if !(f64::from(MIN_PERIOD_US)..=f64::from(MAX_PERIOD_US)).contains(&(played_s * 1e6)) {
        let error = BadFlag::Period { recorded_s, stretch, played_s };
        return Err(failure_with_help(Cause::Input, error, "see --period and --time-stretch"));
    }
    Ok(())
}
