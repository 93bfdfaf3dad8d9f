//! From a cable that is pulled to servos that stand still.
//!
//! The host says something at a steady pace, and then nothing more. Counted is
//! the time from the last byte on the wire to the last change of any servo's
//! pulse, whatever the firmware does then: freeze, go on to a hold, or let go.
//! What the host says is the caller's: heartbeats of an attached walk, or
//! setpoints of a stream.

use super::rig::{Firmware, Rig, RigError};
use crate::devices::pca9685::Burst;
use crate::nano::{CLOCK_HZ, seconds};
use protocol::frame::{self, MAX_FRAME_LEN, Request};
use protocol::{Command, Event, LINK_TIMEOUT_FRAMES, Message, State, WalkEnd};

/// Servos that move for so long after the last byte do not stop.
const PATIENCE_S: f64 = 3.0;
/// Moments of the robot's frame at which the cable is pulled.
pub const MOMENTS: u32 = 4;
const FRAME_S: f64 = 1.0 / protocol::FRAME_RATE_HZ as f64;

/// What one pulled cable showed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Silence {
    /// From the last byte to the last change of a pulse; `None`: they go on.
    pub still_ms: Option<f64>,
    /// From the last byte to the first pulse taken away, if they were.
    pub limp_ms: Option<f64>,
    /// Whether the robot said that the link was lost.
    pub told: bool,
}

/// Says `talk(0)`, `talk(1)` and so on, each `every_s`, for `duration_s`, then
/// nothing more.
///
/// # Errors
/// [`RigError`] if the firmware ends, or a command does not encode.
pub fn silence_after(
    rig: &mut Rig,
    every_s: f64,
    duration_s: f64,
    mut talk: impl FnMut(u32) -> Command,
) -> Result<Silence, RigError> {
    let began = rig.robot.now();
    let mut last_byte = began;
    for index in 0..(duration_s / every_s) as u32 {
        let at = began + (f64::from(index) * every_s * CLOCK_HZ as f64) as u64;
        rig.client.run_until(&mut rig.robot, at)?;
        let mut buffer = [0; MAX_FRAME_LEN];
        let request = Request { seq: index as u8, command: talk(index) };
        let bytes = frame::encode(&request, &mut buffer).map_err(crate::client::ClientError::Frame)?;
        rig.robot.nano_mut().send(bytes);
        last_byte = rig.robot.nano().line_free_at();
    }
    rig.client.forget();
    rig.robot.take_bursts();
    rig.client.run_until(&mut rig.robot, last_byte)?;
    let before = rig.robot.take_bursts();
    rig.client.run_for(&mut rig.robot, PATIENCE_S)?;
    let after = rig.robot.take_bursts();

    let still = last_change(before.last(), &after);
    let end_s = rig.robot.now_s();
    let in_ms = |at_s: f64| (at_s - seconds(last_byte)) * 1e3;
    let limp = after.iter().find(|burst| burst.counts.iter().all(Option::is_none));
    let is_loss =
        |(_, message): &(u64, Message)| *message == Message::Event(Event::WalkEnded(WalkEnd::LinkLost));
    Ok(Silence {
        // Half a second without a change is a stop, not a slow gait.
        still_ms: still.filter(|at_s| end_s - at_s > 0.5).map(in_ms),
        limp_ms: limp.map(|burst| in_ms(burst.stop_s)),
        told: rig.client.heard().iter().any(is_loss),
    })
}

/// When a pulse changed last, a pulse that goes away apart: that is no motion.
fn last_change(before: Option<&Burst>, after: &[Burst]) -> Option<f64> {
    let bursts: Vec<&Burst> = before.into_iter().chain(after).collect();
    let moves = |pair: &&[&Burst]| {
        let both = pair[0].counts.iter().zip(&pair[1].counts);
        both.clone().any(|(a, b)| a.is_some() && b.is_some() && a != b)
    };
    bursts.windows(2).filter(moves).map(|pair| pair[1].stop_s).last()
}

/// An attached walk whose host asks for the status and then falls silent.
///
/// # Errors
/// [`RigError`] if the robot does not walk.
pub fn attached_walk(firmware: &Firmware) -> Result<Vec<Silence>, RigError> {
    let mut silences = Vec::new();
    for moment in 0..MOMENTS {
        let mut rig = Rig::started(firmware)?;
        rig.upload(false)?;
        let walk = Command::Walk { amplitude: None, frames: None, detached: false, dry_run: false };
        rig.client.expect_done(&mut rig.robot, walk)?;
        rig.wait_for(State::Walking)?;
        rig.client.run_for(&mut rig.robot, f64::from(moment) / f64::from(MOMENTS) * FRAME_S)?;
        silences.push(silence_after(&mut rig, 0.25, 0.5, |_| Command::Status)?);
    }
    Ok(silences)
}

/// The firmware's own timeout of an attached walk, in milliseconds.
#[must_use]
pub fn attached_timeout_ms() -> f64 {
    f64::from(LINK_TIMEOUT_FRAMES) * FRAME_S * 1e3
}

/// The slowest to stand still.
///
/// # Errors
/// If one never does.
pub fn slowest_ms(silences: &[Silence]) -> Result<f64, String> {
    let mut slowest = None;
    for silence in silences {
        let still_ms = silence.still_ms.ok_or("the servos go on without a host")?;
        slowest = Some(still_ms.max(slowest.unwrap_or(f64::MIN)));
    }
    slowest.ok_or("no cable was pulled".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::devices::pca9685::CHANNEL_COUNT;

    fn burst(stop_s: f64, first: Option<u16>) -> Burst {
        let mut counts = [None; CHANNEL_COUNT];
        counts[0] = first;
        Burst { start_s: stop_s, stop_s, counts }
    }

    #[test]
    fn the_last_change_is_the_last_motion_and_neither_a_repeat_nor_the_end_of_the_pulses() {
        let bursts = [burst(2.0, Some(331)), burst(3.0, Some(332)), burst(4.0, Some(332)), burst(5.0, None)];

        assert_eq!(last_change(Some(&burst(1.0, Some(330))), &bursts), Some(3.0));
        assert_eq!(last_change(Some(&burst(1.0, Some(330))), &bursts[..1]), Some(2.0));
        assert_eq!(last_change(None, &bursts[2..]), None);
    }

    #[test]
    fn one_cable_after_which_the_servos_go_on_is_no_figure() {
        let silence = |still_ms| Silence { still_ms, limp_ms: None, told: true };

        assert_eq!(slowest_ms(&[silence(Some(80.0)), silence(Some(90.0))]), Ok(90.0));
        assert!(slowest_ms(&[silence(Some(80.0)), silence(None)]).is_err());
        assert!(slowest_ms(&[]).is_err());
    }
}
