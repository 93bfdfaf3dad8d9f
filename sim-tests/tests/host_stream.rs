//! The host streams setpoints to the real image in the emulator, in real time:
//! alone in its file, for other tests beside it would make it late.

#[allow(dead_code)]
mod processes;

use processes::{RobotProcess, host_json, play_patiently};
use protocol::JOINT_COUNT;
use std::f64::consts::TAU;
use std::path::Path;

/// The default calibration: 5/3 counts a degree about 330.
const COUNTS_PER_DEG: f64 = 5.0 / 3.0;
const NEUTRAL_COUNTS: f64 = 330.0;

/// One stride of a wave, degrees from neutral, 60 rows a second.
fn pose_deg(frame: usize, frames: usize) -> [f64; JOINT_COUNT] {
    std::array::from_fn(|joint| 12.0 * (TAU * frame as f64 / frames as f64 + joint as f64).sin())
}

/// Such a stride as a file.
fn recording(folder: &Path, name: &str, frames: usize) {
    let mut text = String::from("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4\n");
    for frame in 0..frames {
        let joints = pose_deg(frame, frames).map(|deg| format!(",{deg:.5}")).concat();
        text.push_str(&format!("{:.6}{joints}\n", frame as f64 / 60.0));
    }
    std::fs::write(folder.join(name), text).unwrap();
}

/// Every pose goes out once, in order, to half a count and the rounding to 1/256 degree.
#[test]
fn a_trajectory_is_streamed_frame_by_frame() {
    const FRAMES: usize = 120;
    let folder = tempfile::tempdir().unwrap();
    let robot = RobotProcess::start(folder.path(), &["--no-reset-on-open"]);
    recording(folder.path(), "wave.csv", FRAMES);

    // Not in the robot's first moments: it is asked how it is before.
    host_json(folder.path(), &["status", "--port", robot.port()]);
    let played = play_patiently(folder.path(), &["--port", robot.port()]);
    let last = host_json(folder.path(), &["measure", "--last", "--port", robot.port()]);

    assert_eq!(played["stopped"], serde_json::Value::Null, "{played}");
    let told = played["frames_played"].as_u64().unwrap();
    assert!((FRAMES as u64 - 1..=FRAMES as u64).contains(&told), "{played}");
    assert_eq!(last["gait"], "setpoints from a computer", "{last}");
    let pulses = robot.pulses();
    let misses = |first: usize| -> f64 {
        let frame_misses = (0..FRAMES - 1).map(|frame| {
            let counts = pulses[first + frame].1;
            let expected = pose_deg(frame, FRAMES).map(|deg| NEUTRAL_COUNTS + COUNTS_PER_DEG * deg);
            counts.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        });
        frame_misses.fold(0.0, f64::max)
    };
    assert!(pulses.len() >= FRAMES, "{} bursts", pulses.len());
    let best = (0..=pulses.len() - (FRAMES - 1)).map(misses).fold(f64::INFINITY, f64::min);
    assert!(best < 0.52, "no run of {} bursts follows the recording: off by {best:.3} counts", FRAMES - 1);
}
