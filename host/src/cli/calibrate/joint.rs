//! The questions about one joint.
//!
//! Holds their order and words: output, neutral, direction, scale, limits. Does
//! not depend on the file that the answers go to.

use super::dialog::{Dialog, Key, UserExit};
use super::pose::Pose;
use super::servo::{self, HEARTBEAT_EVERY, SerialServo, Servo};
use crate::calibration::JointSetup;
use crate::device::link::LinkError;
use crate::device::link::ports::SerialLink;
use crate::robot::Robot;
use crate::run_folder;
use protocol::Joint;
use std::path::PathBuf;

/// How far a joint is turned to see which way it goes.
const SHOWN_DEG: f64 = 15.0;
/// Scales that servos have.
const SCALE_RANGE: (f64, f64) = (1.0, 30.0);

/// Why a joint was not finished.
#[derive(Debug)]
pub enum Stopped {
    /// No more answers come.
    UserExit(UserExit),
    /// The robot cannot be reached, or refused.
    Link(LinkError),
}

impl From<UserExit> for Stopped {
    fn from(exit: UserExit) -> Self {
        Self::UserExit(exit)
    }
}

impl From<LinkError> for Stopped {
    fn from(error: LinkError) -> Self {
        Self::Link(error)
    }
}

/// The robot, the user, and what is the same for all joints.
pub struct Bench<'a> {
    pub link: &'a mut SerialLink,
    pub dialog: &'a mut Dialog,
    /// One count of the PWM in use.
    pub count_us: f64,
    /// Where scales are measured.
    pub angle_deg: f64,
    /// What is calibrated.
    pub robot: &'a Robot,
    /// Folder for the pictures.
    pub pictures: PathBuf,
}

/// Asks everything about `joint`; `None` if it was skipped.
pub fn measure(
    bench: &mut Bench<'_>,
    joint: Joint,
    setup: &JointSetup,
) -> Result<Option<JointSetup>, Stopped> {
    let mut found = setup.clone();
    let question = format!("\n{}: on which output of the PCA9685, 0 to 7?", joint.name());
    found.channel = bench.dialog.whole(&question, setup.channel, 7)?;
    bench.dialog.say(&format!(
        "Enter switches it on at {:.0} us, and it may jump there; s skips this joint, q cancels",
        setup.neutral_us
    ));
    loop {
        match bench.dialog.key(HEARTBEAT_EVERY)? {
            Some(Key::Enter) => break,
            Some(Key::Letter('s')) => return Ok(None),
            _ => {}
        }
    }
    let channel = found.channel;
    let outcome = move_about(bench, joint, &mut found);
    bench.dialog.end_show();
    // Also after a failure or a cancellation.
    servo::let_go(bench.link, channel);
    outcome?;
    found.is_measured = true;
    Ok(Some(found))
}

fn move_about(bench: &mut Bench<'_>, joint: Joint, found: &mut JointSetup) -> Result<(), Stopped> {
    let Bench { link, dialog, count_us, angle_deg, robot, pictures } = bench;
    let pose = Pose::of(robot, joint);
    let picture = pictures.join(format!("calibrate-{}.svg", joint.name()));
    // The words say the same: a picture that cannot be written stops nothing.
    if run_folder::write(&picture, pose.svg().as_bytes()).is_ok() {
        dialog.say(&format!("  Picture: {}", picture.display()));
    }
    let mut servo = Servo::on(link, found.channel, *count_us, found.neutral_us)?;

    dialog.say(&format!(
        "  Neutral: {}. Arrows move it: left and right by one count, up and down by ten; Enter when it is there",
        pose.neutral()
    ));
    found.neutral_us = settle(dialog, &mut servo)?;

    dialog.say(&format!("  Direction: {} y, n, or r to see it again", pose.direction()));
    found.reversed = !sees(dialog, &mut servo, found)?;

    dialog.say(&format!(
        "  Scale: {:.2} us a degree. Enter keeps it; m measures it at {angle_deg} degrees",
        found.us_per_degree
    ));
    if wants(dialog, &mut servo)? {
        dialog.say(&format!(
            "  Turn it {angle_deg} degrees from neutral, either way, by a set square; then Enter"
        ));
        loop {
            let scale = (settle(dialog, &mut servo)? - found.neutral_us).abs() / *angle_deg;
            if (SCALE_RANGE.0..=SCALE_RANGE.1).contains(&scale) {
                found.us_per_degree = (scale * 1e3).round() / 1e3;
                break;
            }
            dialog.say(&format!(
                "  That would be {scale:.2} us a degree; servos have {} to {}. Turn it to {angle_deg} degrees",
                SCALE_RANGE.0, SCALE_RANGE.1
            ));
        }
        servo.glide(found.neutral_us)?;
    }

    (found.min_us, found.max_us) = (found.min_us.min(found.neutral_us), found.max_us.max(found.neutral_us));
    dialog.say(&format!(
        "  Limits: pulses of {:.0} to {:.0} us, {}. Enter keeps them; m finds them by moving",
        found.min_us,
        found.max_us,
        reach(found)
    ));
    if wants(dialog, &mut servo)? {
        dialog.say("  Go to the farthest that a shorter pulse may take it (left, down); then Enter");
        found.min_us = settle(dialog, &mut servo)?.min(found.neutral_us);
        servo.glide(found.neutral_us)?;
        dialog.say("  Go to the farthest that a longer pulse may take it (right, up); then Enter");
        found.max_us = settle(dialog, &mut servo)?.max(found.neutral_us);
        servo.glide(found.neutral_us)?;
    }
    servo.off()?;
    dialog.end_show();
    dialog.say(&format!(
        "  {}: output {}, neutral {:.1} us, {:.2} us a degree{}, {}",
        joint.name(),
        found.channel,
        found.neutral_us,
        found.us_per_degree,
        if found.reversed { ", reversed" } else { "" },
        reach(found)
    ));
    Ok(())
}

/// How far the limits let the joint go.
fn reach(found: &JointSetup) -> String {
    let deg = |us: f64| (us - found.neutral_us) / found.us_per_degree;
    let (a, b) = (deg(found.min_us), deg(found.max_us));
    let (low, high) = if found.reversed { (-b, -a) } else { (a, b) };
    format!("{low:.0} to {high:.0} degrees")
}

/// Lets the user move the servo until it is good; its pulse then.
fn settle(dialog: &mut Dialog, servo: &mut SerialServo<'_>) -> Result<f64, Stopped> {
    loop {
        dialog.show(&format!("  pulse {:.1} us, {} counts", servo.pulse_us(), servo.counts()));
        match key(dialog, servo)? {
            Key::Step(counts) => servo.step(counts)?,
            Key::Enter => {
                dialog.end_show();
                return Ok((servo.pulse_us() * 100.0).round() / 100.0);
            }
            Key::Letter(_) => {}
        }
    }
}

/// Shows a longer pulse, and asks what it did.
fn sees(dialog: &mut Dialog, servo: &mut SerialServo<'_>, found: &JointSetup) -> Result<bool, Stopped> {
    let shown_us = found.neutral_us + SHOWN_DEG * found.us_per_degree;
    servo.glide(shown_us)?;
    let saw = loop {
        match key(dialog, servo)? {
            Key::Letter('y') => break true,
            Key::Letter('n') => break false,
            Key::Letter('r') => {
                servo.glide(found.neutral_us)?;
                servo.glide(shown_us)?;
            }
            _ => {}
        }
    };
    servo.glide(found.neutral_us)?;
    Ok(saw)
}

/// Whether something is to be measured (m) or kept (Enter).
fn wants(dialog: &mut Dialog, servo: &mut SerialServo<'_>) -> Result<bool, Stopped> {
    loop {
        match key(dialog, servo)? {
            Key::Letter('m') => return Ok(true),
            Key::Enter => return Ok(false),
            _ => {}
        }
    }
}

/// The next key, the servo kept on meanwhile.
fn key(dialog: &mut Dialog, servo: &mut SerialServo<'_>) -> Result<Key, Stopped> {
    loop {
        match dialog.key(HEARTBEAT_EVERY)? {
            Some(key) => return Ok(key),
            None => servo.repeat()?,
        }
    }
}
