//! What `host fit` reports: seams, joint speeds, and the curve against the policy.

mod host_command;

use assert_cmd::Command;
use host::gait::policy_record::{PolicyRecord, RECORD, RecordSummary};
use host::gait::trajectory::Trajectory;
use protocol::JOINT_COUNT;
use serde_json::{Value, json};
use std::f64::consts::{PI, TAU};

struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    /// With `trajectory.csv`, a trot as `record` would have written it.
    fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        desk.stride("trajectory.csv", 60, |phase, joint| {
            let leg_phase = TAU * phase + PI * (joint % 2) as f64;
            // Forward is counter-clockwise for the left legs' hips, clockwise for the right ones'.
            let swing = if joint < 2 { 0.4 } else { -0.4 };
            if joint < 4 { swing * leg_phase.sin() } else { 0.35 * leg_phase.cos() }
        });
        desk
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.path().join(name), text).unwrap();
    }

    /// What `record` writes beside the trajectory, with `changed` in place of its own numbers.
    fn record(&self, changed: Value) {
        let trajectory = Trajectory::read(&self.folder.path().join("trajectory.csv"), None).unwrap();
        let none = [0.0; JOINT_COUNT];
        let summary = RecordSummary {
            period_s: 1.0,
            window_s: None,
            strides_in_window: None,
            trials: 20,
            fell: 0,
            strides_averaged: 100,
            strides_left_out: 0,
            correlation: 1.0,
            spread: none,
            spread_deg: none,
            polynomial_r2: [None; JOINT_COUNT],
            speed_m_s: 0.05,
            reward_per_step: 0.0,
            power_w: 1.0,
        };
        let mut record = json!(PolicyRecord { summary, trajectory_sha256: trajectory.sha256 });
        for (name, value) in changed.as_object().unwrap() {
            record[name] = value.clone();
        }
        self.write(RECORD, &record.to_string());
    }

    /// Rows at 60 Hz, in units of action.
    fn stride(&self, name: &str, rows: usize, action: impl Fn(f64, usize) -> f64) {
        let mut csv = String::from("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4\n");
        for row in 0..rows {
            let phase = row as f64 / rows as f64;
            let joints: String = (0..8).map(|joint| format!(",{:.6}", action(phase, joint))).collect();
            csv.push_str(&format!("{:.6}{joints}\n", row as f64 / 60.0));
        }
        self.write(name, &csv);
    }

    fn host(&self, args: &[&str]) -> Command {
        host_command::host(self.folder.path(), &[&["fit"], args, &["--out", "gait.toml"]].concat())
    }

    fn fit(&self, args: &[&str]) -> Value {
        let output = self.host(&[args, &["--json"]].concat()).assert().success();
        serde_json::from_slice(&output.get_output().stdout).unwrap()
    }

    #[track_caller]
    fn fails(&self, args: &[&str]) -> String {
        let assert = self.host(args).assert().code(3);
        host_command::unwrapped(&assert.get_output().stderr)
    }
}

fn joint<'a>(result: &'a Value, seam: &str, name: &str) -> &'a Value {
    let joints = result["seams"][seam]["joints"].as_array().unwrap();
    joints.iter().find(|joint| joint["name"] == name).unwrap()
}

/// hip1 goes from -0.2 to 0.2 and jumps back: 9.6 degrees at 24 a unit.
#[test]
fn both_seams_stand_side_by_side_and_the_jump_is_a_speed() {
    let desk = Desk::new();
    desk.stride("ramp.csv", 120, |phase, joint| if joint == 0 { 0.4 * phase - 0.2 } else { 0.0 });

    let result = desk.fit(&["ramp.csv"]);

    let number = |seam: &str, key: &str| joint(&result, seam, "hip1")[key].as_f64().unwrap();
    assert_eq!(result["seam"], "continuous");
    assert!(number("free", "r2") > 0.9999 && number("continuous", "r2") < number("free", "r2"));
    assert!((number("free", "seam_jump_deg") + 9.52).abs() < 0.02, "{result:#}");
    assert!(number("continuous", "seam_jump_deg").abs() < 1e-9);
    // In one frame.
    assert!((number("free", "peak_deg_s") - 60.0 * 9.5).abs() < 10.0, "{result:#}");
    let own = number("free", "peak_deg_s_own_stroke") / number("free", "peak_deg_s");
    assert!((own - 1.875).abs() < 0.01, "{own}");
    assert!((number("free", "curve_peak_deg_s") - 4.8).abs() < 0.5, "{result:#}");
    // What was there before is of the seam that was taken.
    assert_eq!(result["joints"][0]["r2"], joint(&result, "continuous", "hip1")["r2"]);
    assert_eq!(joint(&result, "free", "hip2")["r2"], Value::Null);
}

#[test]
fn the_table_has_both_seams_within_100_columns() {
    let desk = Desk::new();

    let output = desk.host(&[]).arg("trajectory.csv").assert().success();

    let text = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    let widest =
        text.lines().filter(|line| line.contains('|')).map(|line| line.chars().count()).max().unwrap();
    assert!(widest <= 100, "{widest} columns:\n{text}");
    let warnings = desk.host(&["trajectory.csv", "--time-stretch", "0.5"]).assert().success();
    let warnings = String::from_utf8_lossy(&warnings.get_output().stderr).into_owned();
    assert!(warnings.lines().count() > 1 && warnings.lines().all(|line| line.len() <= 100), "{warnings}");
    assert!(text.contains("seam continuous") && text.contains("seam free, not in the gait"), "{text}");
}

/// A sine of 0.6 in 0.3 s: 0.6 * 24 * 2 pi / 0.3 = 302 degrees/s at 1.0x, of 175.
#[test]
fn a_gait_that_servos_cannot_follow_is_refused_with_the_joint_and_the_next_moves() {
    let desk = Desk::new();
    let rush =
        |phase: f64, joint| if joint == 5 { 0.6 * (TAU * phase).sin() } else { 0.1 * (TAU * phase).sin() };
    desk.stride("rush.csv", 18, rush);

    let message = desk.fails(&["rush.csv"]);

    assert!(
        message.contains("knee2 would have to turn at 29")
            || message.contains("knee2 would have to turn at 30"),
        "{message}"
    );
    for part in
        ["the servos of Ant do 175", "--time-stretch 1.", "--lag, and play it at 0.5", "--robot FOLDER"]
    {
        assert!(message.contains(part), "{part}: {message}");
    }
    assert!(!desk.folder.path().join("gait.toml").exists(), "it was written all the same");

    assert!(desk.fit(&["rush.csv", "--lag"])["largest_followed_amplitude"].as_f64().unwrap() < 0.7);
    assert!(
        desk.fit(&["rush.csv", "--time-stretch", "2"])["largest_followed_amplitude"].as_f64().unwrap() > 1.0
    );
    let pony = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pony");
    assert!(desk.fit(&["rush.csv", "--robot", pony])["servo_deg_s"].as_f64().unwrap() > 300.0);
}

/// 0.4 * 24 * 2 pi = 60 degrees/s at 1.0x in a stride of 1 s, 121 in one of 0.5 s.
#[test]
fn where_servos_stop_following_below_the_usual_amplitude_is_a_warning() {
    let desk = Desk::new();
    let slow = desk.fit(&["trajectory.csv"]);
    let fast = desk.fit(&["trajectory.csv", "--time-stretch", "0.5"]);

    let followed = fast["largest_followed_amplitude"].as_f64().unwrap();
    let warnings = fast["warnings"].to_string();
    assert!(!slow["warnings"].to_string().contains("they lag"), "{slow:#}");
    assert!((1.4..1.5).contains(&followed), "{fast:#}");
    for part in ["at 1.875x, the policy's own stroke", "at 2.2x", &format!("they follow up to {followed}x")] {
        assert!(warnings.contains(part), "{part}: {warnings}");
    }
}

/// A jump is one frame long, a curve is all the time.
#[test]
fn a_jump_at_a_free_seam_is_warned_of_and_not_refused() {
    let desk = Desk::new();
    desk.stride("ramp.csv", 120, |phase, joint| if joint == 0 { 0.4 * phase - 0.2 } else { 0.0 });

    let result = desk.fit(&["ramp.csv", "--seam", "free"]);

    let warnings = result["warnings"].to_string();
    assert!(warnings.contains("hip1: strides meet with a step of -9.5 degrees"), "{warnings}");
    assert!(warnings.contains("takes 3.3 frames; --seam continuous joins them"), "{warnings}");
}

#[test]
fn a_runs_own_recording_is_played_open_loop_against_its_policy() {
    let desk = Desk::new();
    assert_eq!(desk.fit(&["trajectory.csv"])["open_loop"], Value::Null, "there is no record yet");

    desk.record(json!({ "speed_m_s": 0.05 }));
    let kept = desk.fit(&["trajectory.csv"]);
    desk.record(json!({ "speed_m_s": 10.0 }));
    let lost = desk.fit(&["trajectory.csv", "--time-stretch", "3"]);

    let loop_of = |result: &Value, key: &str| result["open_loop"][key].as_f64().unwrap();
    let speed_m_s = loop_of(&kept, "speed_m_s");
    assert!(speed_m_s > 0.05, "{kept:#}");
    assert!((loop_of(&kept, "share_of_policy_speed") - speed_m_s / 0.05).abs() < 1e-9);
    assert_eq!((loop_of(&kept, "amplitude"), loop_of(&kept, "fell")), (1.875, 0.0));
    assert!(!kept["warnings"].to_string().contains("open loop"), "{kept:#}");
    // At the policy's period, whatever the gait's.
    assert_eq!(loop_of(&lost, "speed_m_s"), speed_m_s);
    assert!(lost["warnings"].to_string().contains("% of the policy's speed, below 80"), "{lost:#}");
}

#[test]
fn a_record_that_is_of_another_trajectory_or_damaged_is_not_compared_with() {
    let desk = Desk::new();
    let warnings = || {
        let result = desk.fit(&["trajectory.csv"]);
        assert_eq!(result["open_loop"], Value::Null);
        result["warnings"].to_string()
    };

    desk.record(json!({ "trajectory_sha256": "0" }));
    let of_another = warnings();
    desk.write(RECORD, "{\"period_s\": ");
    let damaged = warnings();
    desk.write(RECORD, "{\"period_s\": 1.0, \"speed_m_s\": 0.1, \"power_w\": 1.0}");
    let incomplete = warnings();
    std::fs::remove_file(desk.folder.path().join(RECORD)).unwrap();
    std::fs::create_dir(desk.folder.path().join(RECORD)).unwrap();
    let unreadable = warnings();

    assert!(of_another.contains("is of another trajectory"), "{of_another}");
    assert!(damaged.contains("is not a record of a policy") && damaged.contains("EOF"), "{damaged}");
    assert!(incomplete.contains("missing field"), "{incomplete}");
    assert!(unreadable.contains("cannot read") && unreadable.contains("directory"), "no cause: {unreadable}");
}

/// The same trot with its hips the other way round goes backward, as far as the other forward.
#[test]
fn a_gait_that_walks_backward_keeps_nothing_of_the_policys_speed() {
    let desk = Desk::new();
    desk.stride("trajectory.csv", 60, |phase, joint| {
        let leg_phase = TAU * phase + PI * (joint % 2) as f64;
        let swing = if joint < 2 { -0.4 } else { 0.4 };
        if joint < 4 { swing * leg_phase.sin() } else { 0.35 * leg_phase.cos() }
    });

    desk.record(json!({ "speed_m_s": 0.05 }));
    let backward = desk.fit(&["trajectory.csv"]);
    desk.record(json!({ "speed_m_s": -0.05 }));
    let neither = desk.fit(&["trajectory.csv"]);

    let share = &backward["open_loop"]["share_of_policy_speed"];
    assert!(share.as_f64().unwrap() < -0.5, "{backward:#}");
    let warnings = backward["warnings"].to_string();
    assert!(warnings.contains("open loop it walks backward, at -0."), "{warnings}");
    assert_eq!(neither["open_loop"]["share_of_policy_speed"], Value::Null);
    let warnings = neither["warnings"].to_string();
    assert!(warnings.contains("the policy itself does not walk forward (-0.050 m/s)"), "{warnings}");
}

#[test]
fn what_is_not_the_policys_own_walk_is_not_compared_and_the_reason_is_said() {
    let desk = Desk::new();
    desk.record(json!({}));
    let pony = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pony");
    let cases: [(&[&str], &str); 7] = [
        (&["--leg", "0.6"], "it walked as Ant with legs of 1 L; this gait is for Ant with legs of 0.6 L"),
        (&["--robot", pony], "this gait is for Pony"),
        (&["--negate", "knee1"], "--negate says otherwise"),
        (&["--centre-offset-deg", "5"], "--centre-offset-deg says otherwise"),
        (&["--centre-unit-deg", "24"], "--centre-unit-deg says otherwise"),
        (&["--unit-deg", "1"], "the robot has no amplitude for its stroke"),
        (&["--period", "2"], "it walked in strides of 1.000 s; --period says 2.000 s"),
    ];

    for (flags, reason) in cases {
        let result = desk.fit(&[&["trajectory.csv"], flags].concat());

        assert_eq!(result["open_loop"], Value::Null, "{flags:?}");
        let warnings = result["warnings"].to_string();
        assert!(warnings.contains("not compared with the policy") && warnings.contains(reason), "{warnings}");
    }
    assert_ne!(desk.fit(&["trajectory.csv", "--leg", "1"])["open_loop"], Value::Null, "its own legs");
}

/// What a run's window leads to: 5.4 strides in one curve, too fast and unlike the recording.
#[test]
fn a_window_of_several_strides_is_fitted_free_and_its_refusal_names_the_cause() {
    let desk = Desk::new();
    let strides = |phase: f64, joint| if joint == 4 { 0.9 * (5.4 * TAU * phase).sin() } else { 0.0 };
    desk.stride("trajectory.csv", 90, strides);

    desk.record(json!({ "period_s": 1.5, "speed_m_s": 0.3 }));
    let alone = desk.fails(&["trajectory.csv"]);
    desk.record(json!({ "period_s": 1.5, "speed_m_s": 0.3, "window_s": 1.5, "strides_in_window": 5.4 }));
    let known = desk.fails(&["trajectory.csv"]);
    let written = desk.fit(&["trajectory.csv", "--lag"]);
    let joined = desk.fit(&["trajectory.csv", "--lag", "--seam", "continuous"]);

    assert!(alone.contains("fit fewer strides at a time, --rows A..B"), "{alone}");
    assert!(alone.contains("knee1's R2 is 0."), "{alone}");
    assert!(known.contains("record the stride itself, host record without --window"), "{known}");
    assert!(known.contains("one curve cannot follow 5.4 strides"), "{known}");
    assert!(!known.contains("play it slower"), "{known}");
    assert_eq!((&written["seam"], &joined["seam"]), (&"free".into(), &"continuous".into()));
    let warnings = joined["warnings"].to_string();
    assert!(warnings.contains("it must follow 5.4 strides; record the stride itself"), "{warnings}");
}

/// As the help advertises: the first column is of no interest.
#[test]
fn a_list_of_columns_may_begin_with_a_skipped_one() {
    let desk = Desk::new();

    let result = desk.fit(&[
        "trajectory.csv",
        "--columns",
        "-,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4",
        "--period",
        "1",
        "--rows",
        "all",
    ]);

    assert_eq!(result["rows"], serde_json::json!([0, 60]));
}

/// The curve is asked for 121 degrees/s at 1.0x, of 175: 1.45x is all that servos follow.
#[test]
fn the_next_command_asks_for_no_more_than_the_servos_follow_and_the_policys_period_is_named() {
    let desk = Desk::new();
    desk.record(json!({}));

    let args = ["trajectory.csv", "--time-stretch", "0.5"];
    let followed = desk.fit(&args)["largest_followed_amplitude"].as_f64().unwrap();
    let output = desk.host(&args).assert().success();

    let text = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    assert!(text.contains(&format!("upload-gait --amp {followed} ")), "{text}");
    assert!(text.contains("open loop at 1.875x and 1.000 s a stride, the policy's own"), "{text}");
    assert!(text.contains("the gait itself takes 0.500 s a stride"), "{text}");
}
