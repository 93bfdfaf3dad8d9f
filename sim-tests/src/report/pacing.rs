//! When the servo bursts begin, against an ideal grid of 60 a second.
//!
//! The grid stands on the crystal's cycles, 266,666 2/3 apart, through the
//! earliest burst of the run: every figure is a lateness, and the worst is the
//! whole spread. A slope would be the timer's, not the crystal's: in cycles,
//! the crystal is exact. While the robot walks, telemetry streams at 60 Hz and
//! one gait after another is uploaded and saved.

use super::memory::Stack;
use super::rig::{Firmware, Rig, RigError};
use super::transfer::Transfers;
use crate::devices::servo_driver::Burst;
use crate::nano::trace::{InterruptLog, Transfer};
use crate::nano::{CLOCK_HZ, seconds};
use protocol::command::Storage;
use protocol::{FRAME_RATE_HZ, JOINT_COUNT};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lateness {
    pub bursts: usize,
    /// Frames of the grid without a burst.
    pub missing: u64,
    /// Half of the bursts are no later than this.
    pub p50_us: f64,
    /// All but one in a hundred are no later.
    pub p99_us: f64,
    /// None is later.
    pub max_us: f64,
    /// Growth of the lateness, in millionths.
    pub drift_ppm: f64,
}

impl Lateness {
    /// Of bursts that began at these cycles; `None` for fewer than three.
    #[must_use]
    pub fn of(began: &[u64]) -> Option<Self> {
        const FRAME_CYCLES: f64 = CLOCK_HZ as f64 / FRAME_RATE_HZ as f64;
        let &first = began.first()?;
        if began.len() < 3 {
            return None;
        }
        let mut frame = 0_u64;
        let mut points = Vec::with_capacity(began.len());
        for (index, &cycle) in began.iter().enumerate() {
            if index > 0 {
                // At least one frame on from the burst before, however late that was.
                let since = (cycle - began[index - 1]) as f64 / FRAME_CYCLES;
                frame += (since.round() as u64).max(1);
            }
            points.push((frame as f64, (cycle - first) as f64 - frame as f64 * FRAME_CYCLES));
        }
        let earliest = points.iter().map(|&(_, late)| late).fold(f64::MAX, f64::min);
        let in_us = |cycles: f64| cycles / CLOCK_HZ as f64 * 1e6;
        let mut late_us: Vec<f64> = points.iter().map(|&(_, late)| in_us(late - earliest)).collect();
        late_us.sort_by(f64::total_cmp);
        let quantile = |share: f64| late_us[((late_us.len() as f64 * share).ceil() as usize).max(1) - 1];
        Some(Self {
            bursts: began.len(),
            missing: frame + 1 - began.len() as u64,
            p50_us: quantile(0.5),
            p99_us: quantile(0.99),
            max_us: quantile(1.0),
            drift_ppm: slope(&points) / FRAME_CYCLES * 1e6,
        })
    }
}

/// Of the straight line with the least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let mean = |part: fn(&(f64, f64)) -> f64| points.iter().map(part).sum::<f64>() / count;
    let (mean_x, mean_y) = (mean(|p| p.0), mean(|p| p.1));
    let (over, under) = points.iter().fold((0.0, 0.0), |(over, under), &(x, y)| {
        (over + (x - mean_x) * (y - mean_y), under + (x - mean_x) * (x - mean_x))
    });
    if under > 0.0 { over / under } else { 0.0 }
}

/// The transfers that were bursts which set all eight servos.
#[must_use]
pub fn burst_transfers(transfers: &[Transfer], bursts: &[Burst]) -> Vec<Transfer> {
    let is_walking = |burst: &&Burst| burst.counts[..JOINT_COUNT].iter().all(Option::is_some);
    bursts
        .iter()
        .filter(is_walking)
        .filter_map(|burst| {
            // The chip is addressed a bit after the START was asked for.
            let addressed = (burst.start_s * CLOCK_HZ as f64).round() as u64;
            let after = transfers.partition_point(|transfer| transfer.began <= addressed);
            transfers[..after].last().copied()
        })
        .collect()
}

/// What a walk with everything going on showed.
#[derive(Debug)]
pub struct Pacing {
    pub lateness: Lateness,
    /// Uploads and saves during it.
    pub transfers: Transfers,
    pub interrupts: InterruptLog,
    /// Cycles of the main loop's longest pass.
    pub longest_pass_cycles: u64,
    /// Cycles of the longest burst, from its START to its STOP.
    pub longest_burst_cycles: u64,
    pub stack: Stack,
    pub seconds: f64,
}

/// Walks with telemetry, uploads and saves.
///
/// # Errors
/// [`RigError`] if the robot does not do as it is asked.
pub fn measure(firmware: &Firmware, duration_s: f64) -> Result<Pacing, RigError> {
    let mut rig = Rig::started(firmware)?;
    rig.walk()?;
    // Outputs follow a frame after the state.
    rig.client.run_for(&mut rig.robot, 0.1)?;
    rig.robot.take_bursts();
    rig.robot.nano_mut().start_trace(firmware.trace());
    let began = rig.robot.now_s();

    let mut transfers = Transfers::default();
    while rig.robot.now_s() < began + duration_s {
        if rig.status()?.0.storage == Storage::Saving {
            rig.client.run_for(&mut rig.robot, 0.02)?;
        } else {
            transfers.upload_and_save(&mut rig)?;
        }
    }

    let trace = rig.take_trace()?;
    let bursts = rig.robot.take_bursts();
    let transfers_of_bursts = burst_transfers(trace.bus.transfers(), &bursts);
    let starts: Vec<u64> = transfers_of_bursts.iter().map(|transfer| transfer.began).collect();
    let longest_burst = transfers_of_bursts.iter().map(|transfer| transfer.ended - transfer.began).max();
    let lateness = Lateness::of(&starts).ok_or(RigError::Unseen("servo bursts"))?;
    let passes = trace.passes.as_ref().ok_or(RigError::Unseen("main loop"))?;
    Ok(Pacing {
        lateness,
        transfers,
        longest_pass_cycles: passes.longest().0,
        longest_burst_cycles: longest_burst.unwrap_or(0),
        stack: Stack::of(&rig, firmware, &trace),
        seconds: seconds(trace.cycles()),
        interrupts: trace.interrupts,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Burst `k` of an ideal grid that begins at cycle 1,000.
    fn ideal(k: u64) -> u64 {
        1_000 + (k * CLOCK_HZ).div_euclid(u64::from(FRAME_RATE_HZ))
    }

    #[test]
    fn a_grid_rounded_to_cycles_is_late_by_less_than_a_cycle_and_does_not_drift() {
        let lateness = Lateness::of(&(0..3600).map(ideal).collect::<Vec<_>>()).unwrap();

        assert!(lateness.max_us < 0.0625, "{lateness:?}");
        assert!(lateness.drift_ppm.abs() < 1e-3, "{lateness:?}");
        assert_eq!((lateness.bursts, lateness.missing), (3600, 0));
    }

    #[test]
    fn one_late_burst_in_a_thousand_is_the_worst_and_not_the_99th_percentile() {
        let late = |k: u64| ideal(k) + if k == 500 { 1_600 } else { 0 };

        let lateness = Lateness::of(&(0..1000).map(late).collect::<Vec<_>>()).unwrap();

        assert!((lateness.max_us - 100.0).abs() < 0.1, "{lateness:?}");
        assert!(lateness.p99_us < 0.1, "{lateness:?}");
    }

    #[test]
    fn a_tick_of_8_cycles_too_few_every_third_frame_is_seen_as_10_ppm() {
        // 33,333 ticks of 8 cycles are 2.67 cycles short of a frame.
        let lateness = Lateness::of(&(0..3600).map(|k| k * 266_664).collect::<Vec<_>>()).unwrap();

        assert!((lateness.drift_ppm + 10.0).abs() < 0.01, "{lateness:?}");
    }

    #[test]
    fn a_frame_without_a_burst_is_missing_and_not_late() {
        let bursts: Vec<u64> = (0..100).filter(|k| *k != 50).map(ideal).collect();

        let lateness = Lateness::of(&bursts).unwrap();

        assert_eq!(lateness.missing, 1);
        assert!(lateness.max_us < 0.1, "{lateness:?}");
    }
}
