//! A front as files, a table and a picture.
//!
//! Holds their names and columns. Does not depend on how a front is searched.

use super::{Front, names};
use crate::cli::explain::{failure, path_text};
use crate::cli::optimise::session::SearchSession;
use crate::cli::optimise::{NAME_PREFIX, gait, write_figure};
use crate::cli::{Cause, Failure};
use crate::gait::gait_file::{GaitFile, gait_sha256};
use crate::robot::Robot;
use crate::run_folder;
use crate::search::optimise::figure;
use crate::search::optimise::report::{OverDraws, safe_range};
use crate::search::optimise::result::{FrontPoint, FrontResult};
use std::path::{Path, PathBuf};

/// The picture, and the table behind it.
const FIGURE: &str = "front.svg";
const TABLE: &str = "front.csv";
const HEAD: &str = "asked_m_s,speed_m_s,speed_p10,speed_p90,cost_of_transport,cost_p10,cost_p90,power_w,\
                    period_s,least_safe_amplitude,most_safe_amplitude,name,gait\n";

/// Gaits of the front as files have them.
fn gaits(front: &Front, session: &SearchSession<'_>) -> Vec<GaitFile> {
    let speeds: Vec<f64> = front.points.iter().map(|point| point.walks.speed_m_s.median).collect();
    let prefix = session.args.new.names_or(NAME_PREFIX, session.robot);
    let with_name = names::distinct(&prefix, &speeds).into_iter().zip(&front.points);
    let one = |(name, point): (String, &super::Point)| {
        gait(session.args, session.robot, &name, &point.motion, safe_range(&point.amplitudes))
    };
    with_name.map(one).collect()
}

/// `front-1.toml` is the slowest one's: speeds in a name could be alike.
fn path(folder: &Path, number: usize) -> PathBuf {
    folder.join(format!("front-{}.toml", number + 1))
}

/// Writes gaits, table and picture; returns the front for scripts.
pub fn save(front: &Front, session: &SearchSession<'_>, folder: &Path) -> Result<FrontResult, Failure> {
    let machine = |error: run_folder::FileError| failure(Cause::Machine, error);
    let mut table = HEAD.to_owned();
    let mut points = Vec::new();
    for (number, (point, gait)) in front.points.iter().zip(gaits(front, session)).enumerate() {
        let path = path(folder, number);
        gait.save(&path).map_err(|error| failure(Cause::Machine, error))?;
        let (speed, cost) = (&point.walks.speed_m_s, &point.walks.cost_of_transport);
        let safe = gait.provenance.safe_amplitudes;
        let [least, most] = safe.map_or([String::new(), String::new()], |ends| ends.map(|a| a.to_string()));
        let file = path.file_name().unwrap_or_default().to_string_lossy();
        table += &format!("{:.3},{:.4},{:.4},{:.4},", point.asked_m_s, speed.median, speed.p10, speed.p90);
        table += &format!("{:.4},{:.4},{:.4},", cost.median, cost.p10, cost.p90);
        table += &format!("{:.3},{:.4},", point.walks.power_w.median, point.motion.period_s);
        table += &format!("{least},{most},{},{file}\n", gait.name.replace(',', " "));
        points.push(FrontPoint {
            asked_m_s: point.asked_m_s,
            reached: point.asked_m_s <= speed.median,
            period_s: point.motion.period_s,
            gait: path_text(&path),
            gait_sha256: gait.encoded().map(|bytes| gait_sha256(&bytes)).unwrap_or_default(),
            name: gait.name,
            safe_amplitudes: safe,
            over_draws: point.walks.clone(),
        });
    }
    run_folder::write(&folder.join(TABLE), table.as_bytes()).map_err(machine)?;
    let walks: Vec<OverDraws> = front.points.iter().map(|point| point.walks.clone()).collect();
    write_figure(&folder.join(FIGURE), figure::of_front(session.robot, &walks).to_svg())?;
    Ok(FrontResult { points, dropped: front.dropped, unreached_m_s: front.unreached_m_s.clone() })
}

/// The table for people.
pub fn print(front: &Front, robot: &Robot, folder: &Path) {
    println!("\nThe front: for each of these gaits, no other is both faster and cheaper.");
    println!(
        "asked m/s   speed m/s   cost of transport (10 %, 90 %)   power W   stride s   safe at     file"
    );
    for (number, point) in front.points.iter().enumerate() {
        let (speed_m_s, cost) = (point.walks.speed_m_s.median, &point.walks.cost_of_transport);
        let safe = safe_range(&point.amplitudes)
            .map_or_else(|| "none".to_owned(), |(least, most)| format!("{least:.1} to {most:.1}"));
        println!(
            "{:9.2} {speed_m_s:11.3} {:19.3} ({:.3}, {:.3}) {:9.2} {:10.2}   {safe:10}  {}{}",
            point.asked_m_s,
            cost.median,
            cost.p10,
            cost.p90,
            point.walks.power_w.median,
            point.motion.period_s,
            path(Path::new(""), number).display(),
            if point.asked_m_s > speed_m_s { ", slower than asked" } else { "" }
        );
    }
    for ((speed_m_s, cost), method) in
        figure::measured(robot).into_iter().flatten().zip(["original", "sinusoid", "PSTO"])
    {
        println!("{:>9} {speed_m_s:11.3} {cost:19.3}   measured by the authors, {method}", "");
    }
    if front.dropped > 0 {
        let dropped = front.dropped;
        println!("gaits left out, because one of these is faster and cheaper: {dropped}");
    }
    if !front.unreached_m_s.is_empty() {
        let speeds: Vec<String> = front.unreached_m_s.iter().map(|speed| format!("{speed:.2}")).collect();
        println!("No gait was found that walks at {} m/s.", speeds.join(", "));
    }
    println!("{}", folder.join(FIGURE).display());
}
