//! The host streams setpoints to the real image in the emulator, in real time:
//! alone in its file, for other tests beside it would make it late.

#[allow(dead_code)]
mod processes;

use processes::{RobotProcess, host_json, play_patiently, pose_deg, recording};

/// The default calibration: 5/3 counts a degree about 330.
const COUNTS_PER_DEG: f64 = 5.0 / 3.0;
const NEUTRAL_COUNTS: f64 = 330.0;

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
