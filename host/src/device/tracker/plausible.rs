//! Which tracks and distances are beyond what a robot's legs can make.
//!
//! Holds the limits. Does not depend on a file's format.

use super::Point;
use super::error::TrackerError;
use super::top_speed::TopSpeed;
use std::path::Path;

/// Steps of a track up to this speed are never called jumps, nor those up to so many times the median.
const STEADY_LEG_LENGTHS_PER_S: f64 = 2.0;
const STEADY_MEDIANS: f64 = 8.0;
/// Noise of a tracker and movements of the body, in leg lengths.
const SLACK_LEG_LENGTHS: f64 = 0.2;
/// Longest time for which another marker may be taken for the robot; as long as gaps are bridged.
const EXCURSION_S: f64 = super::MAX_GAP_S;
/// A floor may rise by this in a tracker's frame, and by this share of the way.
const RISE_M: f64 = 0.1;
const RISE_SHARE: f64 = 0.3;

/// Refuses what no robot can have walked between two points of its track.
///
/// Returns how often the track left the robot for a moment and came back, away from
/// both ends of the trial: such positions do not change the distance.
pub(super) fn check(
    path: &Path,
    points: &[Point],
    start: &Point,
    end: &Point,
    top: TopSpeed,
) -> Result<usize, TrackerError> {
    let duration_s = end.time_s - start.time_s;
    let distance_m = distance(start, end);
    // Those that the two ends are interpolated from, and all between.
    let first = points.partition_point(|point| point.time_s <= start.time_s).saturating_sub(1);
    let last = points.partition_point(|point| point.time_s < end.time_s).min(points.len() - 1);
    let used = &points[first.min(last)..=last];
    let median = median_speed(used);
    if !top.allows(median) || (!top.allows(distance_m / duration_s) && used.len() < 3) {
        let unit = top.likely_unit(median.max(distance_m / duration_s));
        return Err(TrackerError::Unit { path: path.to_owned(), distance_m, duration_s, top, unit });
    }
    let jumps = jumps(path, used, start, median, top)?;
    if !top.allows(distance_m / duration_s) {
        let unit = top.likely_unit(distance_m / duration_s);
        return Err(TrackerError::Unit { path: path.to_owned(), distance_m, duration_s, top, unit });
    }
    if let (Some(from_m), Some(to_m)) = (start.z_m, end.z_m) {
        let dz_m = (to_m - from_m).abs();
        if dz_m > RISE_M.max(RISE_SHARE * distance_m) {
            return Err(TrackerError::YUp { path: path.to_owned(), dz_m, distance_m });
        }
    }
    Ok(jumps)
}

/// How often the track left the robot and came back; an error where it matters.
fn jumps(
    path: &Path,
    used: &[Point],
    start: &Point,
    median: f64,
    top: TopSpeed,
) -> Result<usize, TrackerError> {
    let leg_m = top.leg_length_m;
    let steady = (STEADY_LEG_LENGTHS_PER_S * leg_m).max(STEADY_MEDIANS * median).min(top.m_s());
    let is_reached =
        |a: &Point, b: &Point| distance(a, b) <= steady * (b.time_s - a.time_s) + SLACK_LEG_LENGTHS * leg_m;
    // Two positions, unless one is exactly at the start.
    let begins = usize::from(used[0].time_s < start.time_s);
    let mut count = 0;
    let mut at = 0;
    while at + 1 < used.len() {
        let (here, next) = (&used[at], &used[at + 1]);
        if is_reached(here, next) {
            at += 1;
            continue;
        }
        let back = used[at + 2..]
            .iter()
            .take_while(|point| point.time_s - here.time_s <= EXCURSION_S)
            .position(|point| is_reached(here, point))
            .map(|position| at + 2 + position);
        // The positions beside both ends make the distance.
        let is_between = at >= begins && back.is_some_and(|back| back + 1 < used.len());
        match back {
            Some(back) if is_between => {
                count += 1;
                at = back;
            }
            _ => {
                return Err(TrackerError::Jump {
                    path: path.to_owned(),
                    line: next.line,
                    step_m: distance(here, next),
                    step_s: next.time_s - here.time_s,
                    top,
                });
            }
        }
    }
    Ok(count)
}

fn distance(a: &Point, b: &Point) -> f64 {
    (b.x_m - a.x_m).hypot(b.y_m - a.y_m)
}

/// Of the steps from each position to the next; 0 without any.
fn median_speed(points: &[Point]) -> f64 {
    let mut speeds: Vec<f64> = points
        .windows(2)
        .filter(|pair| pair[1].time_s > pair[0].time_s)
        .map(|pair| distance(&pair[0], &pair[1]) / (pair[1].time_s - pair[0].time_s))
        .collect();
    speeds.sort_by(f64::total_cmp);
    speeds.get(speeds.len() / 2).copied().unwrap_or(0.0)
}
