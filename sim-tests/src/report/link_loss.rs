//! From a cable that is pulled to servos that stand still.
//!
//! The host says something at a steady pace, and then nothing more. Counted is
//! the time from the last byte on the wire to the last change of any servo's
//! pulse, whatever the firmware does then: freeze, go on to a hold, or let go.
//! That is when the servo driver's registers change; on a servo's wire it may be
//! a PWM cycle later, which the figure of the stream adds.
//! What the host says is either heartbeats of an attached walk, or setpoints of
//! a stream, of which the robot then has as many in store as it takes.

use super::rig::{Firmware, Rig, RigError};
use crate::client::ClientError;
use crate::devices::servo_driver::Burst;
use crate::nano::seconds;
use protocol::{Angle, Chunk, Command, Event, JOINT_COUNT, Message, Refusal, Reply, State, WalkEnd};

/// Servos that move for so long after the last byte do not stop.
const PATIENCE_S: f64 = 3.0;
/// 4,096 counts of prescaler 101 at 25 MHz.
pub(super) const PWM_CYCLE_MS: f64 = 4096.0 * 102.0 / 25e3;
/// Setpoints of a stream before it ends.
const STREAM_FRAMES: i16 = 60;
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

/// Watches a robot that hears nothing after this cycle.
fn watch(rig: &mut Rig, last_byte: u64, end: WalkEnd) -> Result<Silence, RigError> {
    rig.client.run_until(&mut rig.robot, last_byte)?;
    let before = rig.robot.take_bursts();
    rig.client.forget();
    rig.client.run_for(&mut rig.robot, PATIENCE_S)?;
    let after = rig.robot.take_bursts();

    let still = last_change(before.last(), &after);
    let end_s = rig.robot.now_s();
    let in_ms = |at_s: f64| (at_s - seconds(last_byte)) * 1e3;
    let limp = after.iter().find(|burst| burst.counts.iter().all(Option::is_none));
    let is_loss = |(_, message): &(u64, Message)| *message == Message::Event(Event::WalkEnded(end));
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
    bursts.windows(2).rfind(moves).map(|pair| pair[1].stop_s)
}

/// An attached walk whose host asks for the status and then falls silent, at so
/// many moments of a frame.
///
/// # Errors
/// [`RigError`] if the robot does not walk.
pub fn attached_walk(firmware: &Firmware, moments: u32) -> Result<Vec<Silence>, RigError> {
    let mut silences = Vec::new();
    for moment in 0..moments {
        let mut rig = Rig::started(firmware)?;
        rig.upload(false)?;
        let walk = Command::Walk { amplitude: None, frames: None, detached: false, dry_run: false };
        rig.client.expect_done(&mut rig.robot, walk)?;
        rig.wait_for(State::Walking)?;
        for _ in 0..2 {
            rig.client.run_for(&mut rig.robot, 0.25)?;
            rig.status()?;
        }
        rig.client.run_for(&mut rig.robot, offset_s(moment, moments))?;
        rig.status()?;
        let last_byte = rig.robot.nano().line_free_at();
        silences.push(watch(&mut rig, last_byte, WalkEnd::LinkLost)?);
    }
    Ok(silences)
}

/// A stream of setpoints that ends without a word, at so many moments of a frame.
///
/// # Errors
/// [`RigError`] if the robot does not take them.
pub fn stream(firmware: &Firmware, moments: u32) -> Result<Vec<Silence>, RigError> {
    let mut silences = Vec::new();
    for moment in 0..moments {
        let mut rig = Rig::started(firmware)?;
        rig.client.expect_done(&mut rig.robot, Command::Stream)?;
        let mut index = 0;
        while index < STREAM_FRAMES {
            match feed(&mut rig, index)? {
                Some(_) => index += 1,
                None => rig.client.run_for(&mut rig.robot, FRAME_S / 4.0)?,
            }
        }
        if rig.status()?.0.state != State::Walking {
            return Err(RigError::Unseen("stream"));
        }
        rig.client.run_for(&mut rig.robot, offset_s(moment, moments))?;
        // As many as it takes: the longest that it can go on.
        let mut last_byte = None;
        while let Some(at) = feed(&mut rig, index)? {
            last_byte = Some(at);
            index += 1;
        }
        let last_byte = last_byte.ok_or(RigError::Unseen("room for a setpoint"))?;
        silences.push(watch(&mut rig, last_byte, WalkEnd::StreamDry)?);
    }
    Ok(silences)
}

/// Sends one setpoint, a degree away from the one before, and returns when its
/// last byte was whole; `None` if the robot has no room for it.
fn feed(rig: &mut Rig, index: i16) -> Result<Option<u64>, RigError> {
    let degrees = (index % 40 - 20).abs() - 10;
    let angle = (Angle::UNITS_PER_DEG * degrees).to_le_bytes();
    let data = Chunk::of(&angle.repeat(JOINT_COUNT));
    let reply = rig.client.ask(&mut rig.robot, Command::Setpoints { data })?;
    match reply {
        Reply::Buffered(_) => Ok(Some(rig.robot.nano().line_free_at())),
        Reply::Refused(Refusal::StreamFull) => Ok(None),
        other => Err(ClientError::Unexpected(Box::new(other)).into()),
    }
}

/// Spreads the moments over a frame, behind the two frames that an answer takes.
fn offset_s(moment: u32, moments: u32) -> f64 {
    (2.0 + f64::from(moment) / f64::from(moments)) * FRAME_S
}

/// An attached walk stands by then.
pub const ATTACHED_BAR_MS: f64 = 1_000.0;

/// The slowest stream's last change on a servo's wire: where the PWM cycle begins
/// is chance, so all of one comes on top.
///
/// # Errors
/// If one never stops, or stops without a word.
pub fn stream_stop_ms(silences: &[Silence]) -> Result<f64, String> {
    if silences.iter().any(|silence| !silence.told) {
        return Err("a stream that ran dry is not told".to_owned());
    }
    Ok(slowest_ms(silences)? + PWM_CYCLE_MS)
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
    use crate::devices::servo_driver::CHANNEL_COUNT;

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
    fn a_stream_stops_on_the_wire_a_pwm_cycle_later_and_must_say_so() {
        let silence = |told| Silence { still_ms: Some(80.0), limp_ms: None, told };

        assert!((stream_stop_ms(&[silence(true)]).unwrap() - 96.7).abs() < 0.1);
        assert!(stream_stop_ms(&[silence(true), silence(false)]).is_err());
    }

    #[test]
    fn one_cable_after_which_the_servos_go_on_is_no_figure() {
        let silence = |still_ms| Silence { still_ms, limp_ms: None, told: true };

        assert_eq!(slowest_ms(&[silence(Some(80.0)), silence(Some(90.0))]), Ok(90.0));
        assert!(slowest_ms(&[silence(Some(80.0)), silence(None)]).is_err());
        assert!(slowest_ms(&[]).is_err());
    }
}
