//! `host fit`: a trajectory in, a gait out.
//!
//! Holds the flags and the order of the steps. Does not depend on the choice of rows
//! and scales ([`super::recording`]), the fit ([`crate::gait::fit`]) or the file format.

mod history;
mod joined;
mod open_loop;
mod pace;
mod policy_record;
mod refusal;
mod report;

use super::explain::{failure, failure_with_help, file_cause};
use super::material::playable;
use super::recording::{Chosen, DefaultRows, Recording};
use super::{Cause, Failure};
use crate::gait::fit::{self, JointFit, Seam};
use crate::gait::gait_file::GaitFile;
use crate::gait::policy_record::RecordSummary;
use crate::robot::{LegScale, Robot};
use crate::run_folder;
use history::Destination;
use joined::{Joined, Seams};
use open_loop::OpenLoopComparison;
use pace::Pace;
use protocol::JOINT_COUNT;
use refusal::{beyond_range, unplayable, unsaved};
use std::path::PathBuf;
use thiserror::Error;

/// The amplitude of the README's example.
const USUAL_AMPLITUDE: f64 = 2.2;

/// Fit a degree-10 polynomial per joint and write the gait.
///
/// Without --rows, a file from `record` is one stride; in any other file a stride is
/// searched for. Columns hold actions, and the scales are degrees:
/// angle = centre-offset + centre-unit * mean action + amplitude * unit *
/// (action - mean action). Columns in degrees: --unit-deg 1 --centre-unit-deg 1.
///
/// A gait too fast for the servos at amplitude 1.0 is refused. The gait of a run's own
/// recording is played in the simulation, to compare its speed with the policy's.
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
    /// Write a gait even if it is too fast for the servos, which will lag
    #[arg(long)]
    lag: bool,
    /// Name on the robot, up to 16 characters [default: from the file or the seed]
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

#[derive(Debug, Error)]
#[error("--out {} does not end in .toml", .path.display())]
struct BadOut {
    path: PathBuf,
}

#[derive(Debug, Error)]
#[error("the curve keeps nothing of the recording: R2 is below {LEAST_R2} of every joint that moves")]
struct KeepsNothing;

/// A curve with less is not the recording's.
const LEAST_R2: f64 = 0.05;

fn keeps_nothing(fits: &[fit::JointFit]) -> bool {
    let mut shares = fits.iter().filter_map(|fit| fit.series.r2).peekable();
    shares.peek().is_some() && shares.all(|r2| r2 < LEAST_R2)
}

pub fn run(mut args: Args) -> Result<(), Failure> {
    args.recording.run = args.run.take();
    args.recording.robot = args.robot.take();
    if let Some(path) = args.out.as_ref().filter(|path| path.extension().is_none_or(|e| e != "toml")) {
        return Err(failure(Cause::Usage, BadOut { path: path.clone() }));
    }
    let chosen = args.recording.choose(DefaultRows::FindStride)?;
    chosen.check_period()?;
    let rows = chosen.actions()?;
    let record = policy_record::beside(&chosen);
    let described = record.as_ref().ok().and_then(Option::as_ref);
    let is_window = described.is_some_and(|record| record.window_s.is_some());
    let seam = args.seam.unwrap_or(Seam::usual(is_window));
    let fits = fit::fit(rows, &chosen.scale, seam).map_err(|e| failure(Cause::Input, e))?;
    let robot = match &chosen.robot {
        Some(robot) => robot.clone(),
        None => Robot::ant(LegScale::LONG).map_err(|e| failure(Cause::Input, e))?,
    };
    let fits = within_ranges(fits, &robot)?;

    if keeps_nothing(&fits) {
        let help = "choose the rows of one stride: --rows A..B, or a --period that fits them";
        return Err(failure_with_help(Cause::Input, KeepsNothing, help));
    }

    let provenance = history::provenance(&args, &chosen, seam);
    let gait = GaitFile {
        name: args.name.clone().unwrap_or_else(|| provenance.gait_name(&chosen.path)),
        period_s: chosen.played_s(),
        unit_deg: chosen.scale.unit_deg,
        provenance,
        joints: fits.clone().map(|fit| fit.series),
    };
    let playable = playable(&gait.encoded().map_err(unplayable)?)?;
    let taken = Joined::new(fits, playable, joined::own_stroke(&chosen.scale));
    let seams = Seams::new(seam, taken, rows, &chosen.scale, &gait);
    super::robots::warn_of(&robot);
    let pace = Pace::of(&seams.taken, robot.servo.top_speed_rad_s().to_degrees());
    if !args.lag {
        pace.check(&seams, chosen.time_stretch, &robot.name, described)?;
    }
    let Destination { out, latest } = history::destination(&args, &chosen)?;
    gait.save(&out).map_err(unsaved)?;
    if let Some(folder) = latest {
        run_folder::make_latest(&folder).map_err(|e| failure(file_cause(&e), e))?;
    }
    let crowded_strides = described.and_then(RecordSummary::crowded_strides);
    let comparison = match record {
        Ok(None) => Ok(None),
        Ok(Some(record)) => OpenLoopComparison::of(&chosen, &robot, &gait, &seams, &pace, &record).map(Some),
        Err(error) => Err(error.into()),
    };
    report::print(&args, &Fitted { out, gait, seams, pace, crowded_strides, comparison, chosen });
    Ok(())
}

/// Curves whose limits are the tighter of the flags' and the robot's.
///
/// # Errors
/// A joint is asked at amplitude 1.0 for more than the robot lets it turn.
fn within_ranges(
    mut fits: [JointFit; JOINT_COUNT],
    robot: &Robot,
) -> Result<[JointFit; JOINT_COUNT], Failure> {
    let asked_deg = fits.each_ref().map(|fit| {
        let (low_deg, high_deg) = fit.series.deviation_range_deg();
        (fit.series.centre_deg + low_deg, fit.series.centre_deg + high_deg)
    });
    robot.check_range(&asked_deg).map_err(|beyond| beyond_range(beyond, robot))?;
    for (fit, (low_deg, high_deg)) in fits.iter_mut().zip(robot.joint_ranges_deg()) {
        fit.series.min_deg = fit.series.min_deg.max(low_deg);
        fit.series.max_deg = fit.series.max_deg.min(high_deg);
    }
    Ok(fits)
}

/// The result of a fit, for the report.
struct Fitted {
    out: PathBuf,
    gait: GaitFile,
    seams: Seams,
    pace: Pace,
    /// Strides in one curve, where they are too many.
    crowded_strides: Option<f64>,
    comparison: Result<Option<OpenLoopComparison>, open_loop::NoComparison>,
    chosen: Chosen,
}
