//! The cheapest gaits of several speeds: cost of transport against speed.
//!
//! Owns the chain of searches, each from the gait of the speed before, and the
//! files and words about them.

use super::hunt::Hunt;
use super::{SPEED_RESERVE, write_figure};
use crate::cli::explain::{failure, path_text};
use crate::cli::{Cause, Failure};
use crate::optimise::figure;
use crate::optimise::report::OverDraws;
use crate::optimise::score::Aim;
use crate::optimise::search::Found;
use crate::optimise::space::Motion;
use crate::robot::Robot;
use crate::run_folder;
use serde_json::{Value, json};
use std::path::Path;

/// Share of the budget for the first gait, of the usual speed.
pub const FIRST_SHARE: f64 = 0.4;
/// The picture, and the table behind it.
const FIGURE: &str = "front.svg";
const TABLE: &str = "front.csv";
/// Speeds that are asked for, as shares of the usual one: slower and slower, faster and faster.
const SLOWER: [f64; 3] = [0.8, 0.6, 0.4];
const FASTER: [f64; 4] = [1.2, 1.4, 1.6, 1.8];

/// A gait of the front.
pub struct Point {
    asked_m_s: f64,
    motion: Motion,
    walks: OverDraws,
}

/// Searches on from `first`, in both directions; the slowest comes first.
pub fn search(hunt: &Hunt<'_>, first: &mut Found, usual_m_s: f64) -> Vec<Point> {
    let budget = ((1.0 - FIRST_SHARE) * hunt.args.budget.trials as f64) as u64;
    let each = budget / (SLOWER.len() + FASTER.len()) as u64;
    let point = |asked_m_s: f64, motion: Motion| {
        let walks = hunt.over_draws(&motion);
        Point { asked_m_s, motion, walks }
    };
    let mut points = vec![point(usual_m_s, first.motion.clone())];
    for shares in [&SLOWER[..], &FASTER[..]] {
        let mut motion = first.motion.clone();
        for share in shares {
            if first.stopped {
                break;
            }
            let asked_m_s = share * usual_m_s;
            let aim = Aim::Cost { at_least_m_s: SPEED_RESERVE * asked_m_s };
            let found = hunt.next(aim, &motion, each, &format!("{asked_m_s:.2} m/s: "));
            first.trials += found.trials;
            first.stopped |= found.stopped;
            motion = found.motion;
            points.push(point(asked_m_s, motion.clone()));
        }
    }
    points.sort_by(|a, b| a.asked_m_s.total_cmp(&b.asked_m_s));
    points
}

/// Writes gaits, table and picture; the front for scripts.
pub fn save(points: &[Point], hunt: &Hunt<'_>, folder: &Path) -> Result<Value, Failure> {
    let machine = |error: run_folder::FileError| failure(Cause::Machine, error);
    let mut table =
        String::from("asked_m_s,speed_m_s,cost_of_transport,cost_p10,cost_p90,power_w,period_s,fell,gait\n");
    let mut front = Vec::new();
    for Point { asked_m_s, motion, walks } in points {
        let path = folder.join(format!("gait-{asked_m_s:.2}.toml"));
        let gait = super::gait(hunt.args, hunt.robot, motion, None);
        gait.save(&path).map_err(|error| failure(Cause::Machine, error))?;
        let cost = &walks.cost_of_transport;
        table += &format!(
            "{asked_m_s:.3},{:.4},{:.4},{:.4},{:.4},{:.3},{:.4},{},{}\n",
            walks.speed_m_s.median,
            cost.median,
            cost.p10,
            cost.p90,
            walks.power_w.median,
            motion.period_s,
            walks.fell,
            path.file_name().unwrap_or_default().to_string_lossy()
        );
        front.push(json!({
            "asked_m_s": asked_m_s,
            "period_s": motion.period_s,
            "gait": path_text(&path),
            "over_draws": walks,
        }));
    }
    run_folder::write(&folder.join(TABLE), table.as_bytes()).map_err(machine)?;
    let walks: Vec<OverDraws> = points.iter().map(|point| point.walks.clone()).collect();
    let drawn = figure::of_front(hunt.robot, &walks).to_svg();
    write_figure(&folder.join(FIGURE), drawn)?;
    Ok(Value::Array(front))
}

/// The table for people.
pub fn print(points: &[Point], robot: &Robot, folder: &Path) {
    if points.is_empty() {
        return;
    }
    println!("\nasked m/s   speed m/s   cost of transport (10 %, 90 %)   power W   stride s");
    for Point { asked_m_s, motion, walks } in points {
        let cost = &walks.cost_of_transport;
        println!(
            "{asked_m_s:9.2} {:11.3} {:19.3} ({:.3}, {:.3}) {:9.2} {:10.2}   predicted",
            walks.speed_m_s.median, cost.median, cost.p10, cost.p90, walks.power_w.median, motion.period_s
        );
    }
    for ((speed_m_s, cost), method) in
        figure::measured(robot).into_iter().flatten().zip(["original", "sinusoid", "PSTO"])
    {
        println!("{:>9} {speed_m_s:11.3} {cost:19.3} {:>25} measured, {method}", "", "");
    }
    println!("{}", folder.join(FIGURE).display());
}
