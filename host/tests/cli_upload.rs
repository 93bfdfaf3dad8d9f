//! Sampled uploads and dry runs as processes, against the fake robot. Linux
//! only: the terminal is.
#![cfg(target_os = "linux")]

mod bench_host;
mod fake_robot;

use bench_host::{Setting, fails, gait, json, says};
use fake_robot::Troubles;
use protocol::calibration::JointCalibration;
use protocol::gait::Encoded;
use protocol::{Amplitude, Calibration, Command, Joint};
use std::f64::consts::TAU;

/// A recording as `record` writes it: `rows` rows at 60 Hz of a wave of `action`.
fn record(setting: &Setting, rows: usize, action: f64) {
    let row = |i: usize| {
        let angle = |joint: usize| TAU * i as f64 / rows as f64 + joint as f64;
        let joints = (0..8).map(|joint| format!(",{:.6}", action * angle(joint).sin()));
        format!("{:.6}{}\n", i as f64 / 60.0, joints.collect::<String>())
    };
    let header = "time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4\n";
    let text = format!("{header}{}", (0..rows).map(row).collect::<String>());
    std::fs::write(setting.folder.path().join("walk.csv"), text).unwrap();
}

fn changes(setting: &Setting) -> usize {
    let moves = |command: &Command| {
        !matches!(command, Command::Hello { .. } | Command::Status | Command::Read { .. })
    };
    setting.done().iter().filter(|command| moves(command)).count()
}

#[test]
fn a_recording_is_uploaded_as_samples_and_says_what_fitted() {
    let setting = Setting::new(Troubles::default());
    record(&setting, 54, 0.3);

    let text =
        says(&mut setting.host(&["upload-gait", "walk.csv", "--sampled", "--amp", "1.5", "--name", "raw"]));

    assert!(text.contains("27 rows, of 54 recorded: a robot takes 27; steps of 0.06 degree"), "{text}");
    assert!(text.contains("the robot has gait \"raw\""), "{text}");
    assert!(text.contains("261 bytes transferred and verified"), "{text}");
    let mut on_robot = Encoded::EMPTY;
    on_robot.replace(&setting.bench.robot(|robot| robot.table.clone())).unwrap();
    assert!(on_robot.is_sampled());
    // The times of the recording are rounded to microseconds.
    assert!(on_robot.period_us().abs_diff(900_000) <= 2);
    // hip1 is 0.3 sin(phase): a quarter stride in, 24 * 0.3 degrees at amplitude 1.
    let quarter = on_robot.setpoint(Joint::Hip1, 16_384, Amplitude::ONE).deg();
    assert!((quarter - 7.2).abs() < 0.1, "{quarter}");
}

#[test]
fn rows_and_pace_are_chosen_as_for_a_fit() {
    let setting = Setting::new(Troubles::default());
    record(&setting, 60, 0.3);
    let flags = ["--rows", "10..30", "--period", "0.5", "--time-stretch", "3"];

    let result = json(
        &mut setting
            .host(&[&["upload-gait", "walk.csv", "--sampled", "--amp", "1", "--json"], &flags[..]].concat()),
    );

    assert_eq!(result["sampled"]["rows"], 20);
    assert_eq!(result["period_s"], 1.5);
    assert_eq!(result["gait_source"], "sampled");
    assert_eq!(result["gait_name"], "walk");
}

#[test]
fn a_sampled_gait_can_be_measured_and_is_held_to_its_limits() {
    let setting = Setting::new(Troubles::default());
    record(&setting, 27, 0.9);
    let upload = ["upload-gait", "walk.csv", "--sampled", "--limit-deg", "50"];

    let refused = fails(&mut setting.host(&[&upload[..], &["--amp", "2.5"]].concat()), 3);
    says(&mut setting.host(&[&upload[..], &["--amp", "2"]].concat()));
    let beyond = fails(&mut setting.measure(&["--distance", "1", "--amp", "2.5"]), 3);

    assert!(refused.contains("its limit is"), "{refused}");
    assert!(refused.contains("the largest amplitude that fits is 2.3"), "{refused}");
    assert!(beyond.contains("the largest amplitude that fits is 2.3"), "{beyond}");
}

#[test]
fn a_recording_without_the_flag_for_it_is_not_taken_for_a_gait() {
    let setting = Setting::new(Troubles::default());
    record(&setting, 27, 0.3);

    let message = fails(&mut setting.host(&["upload-gait", "walk.csv", "--amp", "1"]), 2);

    assert!(message.contains("a trajectory was given, but this uploads a gait"), "{message}");
    assert!(message.contains("add --sampled"), "{message}");
}

#[test]
fn a_dry_run_tells_what_each_joint_would_do_and_changes_nothing() {
    let setting = Setting::new(Troubles::default());

    let text = says(&mut setting.host(&["upload-gait", "--dry-run", "--gait", "gait.toml", "--amp", "2.2"]));
    let result = json(&mut setting.host(&[
        "upload-gait",
        "--dry-run",
        "--gait",
        "gait.toml",
        "--amp",
        "2.2",
        "--json",
    ]));

    assert!(text.contains("gait \"new\" at 2.2x, a stride in 0.600 s"), "{text}");
    // 10 T_2 at 2.2: -22 to 22 degrees of 6.8 us about 1346.4.
    assert!(text.contains("hip1 -22.0 22.0"), "{text}");
    assert!(text.contains("1195..1497"), "{text}");
    assert!(text.contains("251 bytes could be uploaded; nothing was"), "{text}");
    assert_eq!(result["joints"][7]["highest_deg"], 22.0);
    let servo = host::robot::Robot::ant(host::robot::LegScale::LONG).unwrap().servo;
    let does = format!("its servo does {:.0}: it lags in", servo.top_speed_rad_s().to_degrees());
    assert!(result["warnings"][0].as_str().is_some_and(|text| text.contains(&does)), "{does}: {result:#}");
    assert_eq!(changes(&setting), 0, "{:?}", setting.done());
    assert_eq!(setting.active_gait(), "old");
}

#[test]
fn a_pulse_beyond_the_robots_calibration_fails_the_dry_run_and_warns_the_upload() {
    let authors = Calibration::authors();
    let mut joints = Joint::ALL.map(|joint| authors.joint(joint));
    joints[4] = JointCalibration { max_counts: 350, ..joints[4] };
    let mut robot =
        fake_robot::FakeRobot::with_gait(Troubles::default(), &gait("old").encoded().unwrap(), 1.0);
    robot.calibration = Calibration::new(&joints, &authors.board());
    let setting = Setting::with(robot);
    let upload = ["upload-gait", "--gait", "gait.toml", "--amp", "2.2"];

    let message = fails(&mut setting.host(&[&upload[..], &["--dry-run"]].concat()), 3);
    let assert = setting.host(&upload).assert().success();

    assert!(
        message.contains("knee1 would need a pulse of 1497 us (367 counts) at 22.0 degrees"),
        "{message}"
    );
    assert!(message.contains("its calibration allows 600 to 1428 us"), "{message}");
    assert!(message.contains("host calibrate"), "{message}");
    let err = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
    assert!(err.contains("warning: knee1 would need a pulse of 1497 us"), "{err}");
    assert!(err.contains("it is held there"), "{err}");
}
