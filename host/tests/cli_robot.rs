//! `upload-gait` and `measure` as processes, on a pseudo-terminal with a robot
//! that fails on request at its other end. Linux only: the terminal is.
#![cfg(target_os = "linux")]

mod bench_host;
mod fake_robot;

use bench_host::{Setting, fails, gait, json, says};
use fake_robot::{FakeRobot, Troubles};
use protocol::State;
use std::time::{Duration, Instant};

#[test]
fn a_gait_is_uploaded_verified_and_saved() {
    let setting = Setting::new(Troubles::default());

    let result = json(&mut setting.upload());

    assert_eq!(setting.active_gait(), "new");
    assert_eq!(result["saved"], true);
    assert_eq!(result["amplitude"], 2.2);
    assert_eq!(result["gait_source"], "trained");
    assert_eq!(result["clipped_share"], 0.0);
    let bytes = std::fs::read(setting.folder.path().join("gait.bin")).unwrap();
    assert_eq!(result["gait_sha256"], host::gait::gait_file::gait_sha256(&bytes));
}

#[test]
fn a_cable_pulled_in_mid_upload_leaves_the_old_gait() {
    let setting = Setting::new(Troubles { cut_after: Some(150), ..Default::default() });

    let message = fails(&mut setting.upload(), 4);

    assert_eq!(setting.active_gait(), "old");
    assert!(message.contains("the robot keeps the gait it had"), "{message}");
    assert!(message.contains("the link broke: cannot"), "{message}");
    assert!(message.contains("check the cable"), "{message}");
}

#[test]
fn lost_and_corrupt_bytes_are_survived() {
    let setting =
        Setting::new(Troubles { loses_every: Some(3), flips_every: Some(97), ..Default::default() });

    json(&mut setting.upload());

    assert_eq!(setting.active_gait(), "new");
}

#[test]
fn another_protocol_version_is_refused_with_both_versions() {
    let setting = Setting::new(Troubles { protocol_version: Some(9), ..Default::default() });

    let message = fails(&mut setting.upload(), 5);

    assert_eq!(setting.active_gait(), "old");
    assert!(message.contains("speaks protocol version 9, this program version 3"), "{message}");
    assert!(message.contains("update this program"), "{message}");
}

#[test]
fn a_port_where_nobody_answers_is_given_up() {
    let setting = Setting::new(Troubles { silent: true, ..Default::default() });
    let begin = Instant::now();

    let message = fails(&mut setting.upload(), 4);

    assert!(message.contains("no hello within 6 s, and not a single byte"), "{message}");
    assert!(message.contains("that its firmware is flashed"), "{message}");
    assert!(begin.elapsed() < Duration::from_secs(20));
}

#[test]
fn a_worn_out_eeprom_is_a_robots_failure() {
    let setting = Setting::new(Troubles { worn_out: true, ..Default::default() });

    let message = fails(&mut setting.upload(), 5);

    assert!(message.contains("its EEPROM did not read back what was written"), "{message}");
}

/// 30 frames of 15 mJ are 0.45 J over 0.5 s; 0.1 m with 1 kg: 0.45 / 0.980665.
#[test]
fn a_trial_is_measured_and_noted() {
    let setting = Setting::new(Troubles::default());

    let result = json(&mut setting.measure(&["--distance", "0.1"]));

    assert_eq!(result["frames_played"], 30);
    assert_eq!(result["energy_j"], 0.45);
    assert!((result["mean_power_w"].as_f64().unwrap() - 0.9).abs() < 1e-9);
    assert!((result["speed_m_s"].as_f64().unwrap() - 0.2).abs() < 1e-9);
    assert!((result["cost_of_transport"].as_f64().unwrap() - 0.458_872).abs() < 1e-6);
    assert_eq!(setting.trials().len(), 1);
    let telemetry = std::fs::read_to_string(setting.folder.path().join("telemetry-1.csv")).unwrap();
    assert!(telemetry.lines().count() > 30, "{telemetry}");
}

/// Twice the time after which the robot would stop.
#[test]
fn a_trial_longer_than_the_robots_patience_is_kept_alive_to_its_end() {
    let setting = Setting::new(Troubles { depends_on_host: true, ..Default::default() });

    let result = json(&mut setting.measure(&["--duration", "2", "--distance", "0.1"]));

    assert_eq!(result["frames_played"], 120);
}

#[test]
fn a_second_trial_is_added_below_the_first() {
    let setting = Setting::new(Troubles::default());

    json(&mut setting.measure(&["--distance", "0.1"]));
    json(&mut setting.measure(&["--distance", "0.2"]));

    assert_eq!(setting.trials().len(), 2);
    assert!(setting.folder.path().join("telemetry-2.csv").exists());
}

/// The tracker sees 0.3 m/s from long before the trial to long after.
#[test]
fn a_trackers_positions_are_taken_at_the_trials_own_times() {
    let setting = Setting::new(Troubles::default());
    let now = std::time::UNIX_EPOCH.elapsed().unwrap().as_secs_f64();
    let rows: String =
        (0..600).map(|i| f64::from(i) / 10.0).map(|t| format!("{:.3},{:.6},0\n", now + t, 0.3 * t)).collect();
    std::fs::write(setting.folder.path().join("track.csv"), format!("time_s,x_m,y_m\n{rows}")).unwrap();

    let result = json(&mut setting.measure(&["--tracker", "track.csv"]));

    // 0.5 s, give or take how evenly a busy machine plays 60 frames a second.
    let distance_m = result["distance_m"].as_f64().unwrap();
    assert!((distance_m - 0.15).abs() < 0.03, "{result:#}");
}

#[test]
fn a_tracker_that_missed_the_trial_is_refused_and_the_trial_noted_as_invalid() {
    let setting = Setting::new(Troubles::default());
    let rows = "1000000000.5,0,0\n1000000010,1,0\n";
    std::fs::write(setting.folder.path().join("track.csv"), format!("time_s,x_m,y_m\n{rows}")).unwrap();

    let message = fails(&mut setting.measure(&["--tracker", "track.csv"]), 3);

    assert!(
        message.contains("does not cover the trial: it has 1000000000.500 to 1000000010.000 s"),
        "{message}"
    );
    let trials = setting.trials();
    assert!(trials[0].iter().any(|field| field == "false"), "{trials:?}");
}

#[test]
fn a_robot_that_did_not_move_has_no_cost_of_transport() {
    let setting = Setting::new(Troubles::default());

    let message = fails(&mut setting.measure(&["--distance", "0"]), 3);

    assert!(message.contains("the distance must be above 0 for a cost of transport"), "{message}");
    assert_eq!(setting.trials().len(), 1);
}

#[test]
fn a_fault_in_mid_trial_is_named_and_the_trial_noted_as_invalid() {
    let setting = Setting::new(Troubles { faults_at: Some(10), ..Default::default() });

    let message = fails(&mut setting.measure(&["--distance", "1"]), 5);

    assert!(message.contains("the power sensor (INA219) does not answer"), "{message}");
    assert!(message.contains("address 0x41"), "{message}");
    let trials = setting.trials();
    assert!(trials[0].iter().any(|field| field == "false"), "{trials:?}");
    assert!(trials[0].iter().any(|field| field.contains("INA219")), "{trials:?}");
}

#[test]
fn a_reset_in_mid_trial_is_named_with_its_cause() {
    let setting = Setting::new(Troubles { resets_at: Some(10), ..Default::default() });

    let message = fails(&mut setting.measure(&["--distance", "1"]), 5);

    assert!(message.contains("its supply voltage dropped (brown-out)"), "{message}");
    assert!(message.contains("servo power must not come through the Nano"), "{message}");
}

/// Each table allows 55 degrees; 10 T_2 reaches that at 5.5x, so the limits
/// are narrowed here.
#[test]
fn an_amplitude_beyond_the_robots_own_gait_is_refused_before_it_walks() {
    let mut narrow = gait("narrow");
    narrow.joints[2].max_deg = 20.0;
    let robot = FakeRobot::with_gait(Troubles::default(), &narrow.encoded().unwrap(), 1.0);
    let setting = Setting::with(robot);

    let message = fails(&mut setting.measure(&["--distance", "1", "--amp", "2.5"]), 3);

    assert!(message.contains("hip3 would go to 25.0 degrees"), "{message}");
    assert!(message.contains("the largest amplitude that fits is 2"), "{message}");
    assert!(setting.bench.robot(|robot| robot.trial_frames() == 0));
}

#[test]
fn ctrl_c_stops_the_robot_and_the_program() {
    let setting = Setting::new(Troubles::default());
    let mut host = std::process::Command::new(assert_cmd::cargo::cargo_bin("host"))
        .current_dir(setting.folder.path())
        .args(["measure", "--duration", "60", "--distance", "1", "--out", ".", "--port", &setting.bench.port])
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let deadline = Instant::now() + Duration::from_secs(30);
    while setting.bench.robot(|robot| robot.state != State::Walking) {
        assert!(Instant::now() < deadline, "the robot never walked");
        std::thread::yield_now();
    }

    let pid = nix::unistd::Pid::from_raw(host.id() as i32);
    nix::sys::signal::kill(pid, nix::sys::signal::Signal::SIGINT).unwrap();
    let status = host.wait().unwrap();

    assert_eq!(status.code(), Some(130));
    assert_eq!(setting.bench.robot(|robot| (robot.state, robot.stop_bytes)), (State::Holding, 1));
    assert!(setting.trials()[0].iter().any(|field| field.contains("interrupted")));
}

#[test]
fn a_walk_without_a_cable_is_told_afterwards() {
    let setting = Setting::new(Troubles::default());
    let message = fails(&mut setting.host(&["measure", "--last"]), 5);
    assert!(message.contains("the robot remembers no walk"), "{message}");
    says(&mut setting.host(&["walk", "--detached", "--for", "0.5"]));
    let deadline = Instant::now() + Duration::from_secs(30);
    while setting.bench.robot(|robot| robot.last_trial.is_none()) {
        assert!(Instant::now() < deadline, "the walk never ended");
        std::thread::yield_now();
    }

    let text = says(&mut setting.host(&["measure", "--last"]));
    let last =
        json(&mut setting.host(&["measure", "--last", "--mass-kg", "1", "--distance", "0.1", "--json"]));

    assert!(text.contains("gait \"old\" (CRC"), "{text}");
    assert!(text.contains("at 1x, 30 frames in 0.50 s it ended because its time was over"), "{text}");
    assert!(text.contains("energy 0.450 J mean power 0.900 W"), "{text}");
    assert!(text.contains("held at its limit in 3 frames 1 power samples failed"), "{text}");
    assert_eq!(last["ended"], "finished");
    assert!((last["cost_of_transport"].as_f64().unwrap() - 0.458_872).abs() < 1e-6);
    assert!((last["speed_m_s"].as_f64().unwrap() - 0.2).abs() < 1e-9);
}
