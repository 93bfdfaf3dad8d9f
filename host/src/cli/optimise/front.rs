//! The cheapest gaits of several speeds: cost of transport against speed.
//!
//! Holds the chain of searches, each starting from the best gait so far for its
//! speed, and which of the gaits that were found make the front; `table` writes
//! it. Does not depend on flags.

mod names;
mod table;

pub use table::{print, save};

use super::SPEED_RESERVE;
use super::budget::LEAST_TRIALS;
use super::session::SearchSession;
use crate::search::optimise::front::{Winner, undominated, winners};
use crate::search::optimise::report::{AtAmplitude, OverDraws};
use crate::search::optimise::score::Aim;
use crate::search::optimise::search::{Found, least_step};
use crate::search::optimise::space::Motion;

/// Share of the budget for the first gait, of the least speed itself.
pub const FIRST_SHARE: f64 = 0.4;
/// Speeds that are asked for after it, as shares of it: slower and slower, faster and faster.
const SLOWER: [f64; 2] = [0.8, 0.6];
const FASTER: [f64; 5] = [1.2, 1.4, 1.6, 1.8, 2.0];
const STEPS: u64 = (SLOWER.len() + FASTER.len()) as u64;
/// Speeds that gaits are chosen for, as shares of it: from the least searched for to beyond the most.
/// A gait may be the best for a speed that no step asked for.
const CHOSEN: (f64, f64) = (0.5, 2.4);
const CHOSEN_STEP: f64 = 0.05;

/// A gait of the front.
pub struct Point {
    /// The fastest speed that it was chosen for and reaches, else the slowest that it misses.
    asked_m_s: f64,
    motion: Motion,
    walks: OverDraws,
    amplitudes: Vec<AtAmplitude>,
}

/// The front, slowest first.
#[derive(Default)]
pub struct Front {
    points: Vec<Point>,
    /// Gaits that were the best on the validation robots, and that another beats on the report's robots.
    dropped: usize,
    /// Speeds that no gait reaches.
    unreached_m_s: Vec<f64>,
}

/// The least speed is asked for with a reserve.
pub fn aim(asked_m_s: f64) -> Aim {
    Aim::Cost { at_least_m_s: SPEED_RESERVE * asked_m_s }
}

fn each(budget: u64) -> u64 {
    ((1.0 - FIRST_SHARE) * budget as f64) as u64 / STEPS
}

/// The first gait's part of a front's budget.
pub fn first_budget(budget: u64) -> u64 {
    (FIRST_SHARE * budget as f64) as u64
}

/// The least budget of which each step gets what it takes.
pub fn least_budget() -> u64 {
    let enough = |budget: &u64| {
        let first = first_budget(*budget);
        first >= LEAST_TRIALS && each(*budget) >= least_step(first)
    };
    // Each hundred, to be typed.
    (1..).map(|hundreds| 100 * hundreds).find(enough).unwrap_or(u64::MAX)
}

/// Searches on from `found`, which was searched for `least_m_s`, in both
/// directions; all gaits join those of `found`.
pub fn search(session: &SearchSession<'_>, found: &mut Found, least_m_s: f64) {
    let each = each(session.args.budget.trials);
    for (number, share) in SLOWER.into_iter().chain(FASTER).enumerate() {
        if session.stopped() {
            break;
        }
        let asked_m_s = share * least_m_s;
        let what = format!("{asked_m_s:.2} m/s, {} of {STEPS}: ", number + 1);
        session.next(found, aim(asked_m_s), number as u64, each, &what);
    }
    // A gait that was found on the way to another speed may be the better one here.
    if let Some(best) = winners(&found.pool, &[least_m_s], |asked_m_s| session.test(aim(asked_m_s))).pop() {
        found.motion = best.motion;
    }
}

/// The gaits that make the front, played on the report's robots.
pub fn of(session: &SearchSession<'_>, found: &Found, least_m_s: f64) -> Front {
    let steps = ((CHOSEN.1 - CHOSEN.0) / CHOSEN_STEP).round() as u32;
    let chosen: Vec<f64> = (0..=steps).map(|k| (CHOSEN.0 + CHOSEN_STEP * f64::from(k)) * least_m_s).collect();
    let mut winners = winners(&found.pool, &chosen, |asked_m_s| session.test(aim(asked_m_s)));
    for winner in &mut winners {
        winner.motion = session.forward(winner.motion.clone());
    }
    let walks: Vec<OverDraws> = winners.iter().map(|winner| session.over_draws(&winner.motion)).collect();
    let places: Vec<(f64, f64)> =
        walks.iter().map(|walks| (walks.speed_m_s.median, walks.cost_of_transport.median)).collect();
    let kept = undominated(&places);
    let dropped = kept.iter().filter(|kept| !**kept).count();
    let on_it = winners.into_iter().zip(walks).zip(kept).filter_map(|(point, kept)| kept.then_some(point));
    let mut points: Vec<Point> = on_it
        .map(|(Winner { asked_m_s, motion }, walks)| {
            let reached = asked_m_s.iter().rev().find(|asked| **asked <= walks.speed_m_s.median);
            let asked_m_s = reached.or(asked_m_s.first()).copied().unwrap_or(least_m_s);
            let amplitudes = session.over_amplitudes(&motion);
            Point { asked_m_s, motion, walks, amplitudes }
        })
        .collect();
    points.sort_by(|a, b| a.walks.speed_m_s.median.total_cmp(&b.walks.speed_m_s.median));
    let fastest_m_s = points.last().map_or(0.0, |point| point.walks.speed_m_s.median);
    let asked = FASTER.into_iter().map(|share| share * least_m_s);
    Front { points, dropped, unreached_m_s: asked.filter(|asked| *asked > fastest_m_s).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_budget_of_a_front_is_enough_for_each_of_its_steps_and_no_smaller_one_is() {
        let least = least_budget();

        assert!(first_budget(least) >= LEAST_TRIALS && each(least) >= least_step(first_budget(least)));
        let below = least - 100;
        assert!(first_budget(below) < LEAST_TRIALS || each(below) < least_step(first_budget(below)));
    }
}
