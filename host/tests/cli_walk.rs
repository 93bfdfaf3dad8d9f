//! Status, walks, live changes and stored gaits as processes, on a
//! pseudo-terminal with the fake robot at its other end. Linux only: the
//! terminal is.
#![cfg(target_os = "linux")]

mod bench_host;
mod fake_robot;

use bench_host::{Setting, fails, json, says};
use fake_robot::{FakeRobot, Troubles};
use protocol::{Amplitude, Command, Fault, Speed, State, WalkEnd};

#[test]
fn the_status_is_told_in_plain_words() {
    let setting = Setting::new(Troubles::default());

    let text = says(&mut setting.host(&["status"]));

    for line in [
        "state idle, servos limp",
        "gait \"old\" (CRC",
        "at 1x, saved",
        "calibration default, the authors' robot: none is stored",
        "supply 5.00 V",
        "412 bytes of stack were never used",
        "1 failed transfer",
        "the robot got 2 damaged frames and lost 7 bytes, this computer got 0 damaged frames",
    ] {
        assert!(text.contains(line), "{line}: {text}");
    }
}

#[test]
fn the_status_is_told_to_scripts() {
    let setting = Setting::new(Troubles::default());

    let status = json(&mut setting.host(&["status", "--json"]));

    assert_eq!(status["state"], "idle");
    assert_eq!(status["fault"], serde_json::Value::Null);
    assert_eq!(status["gait"]["name"], "old");
    assert_eq!(status["gait"]["storage"], "saved");
    assert_eq!(status["calibration"], "default");
    assert_eq!(status["supply_v"], 5.0);
    assert_eq!(status["stack_left_bytes"], 412);
    assert_eq!(status["dropped_bytes"], 7);
}

#[test]
fn a_fault_is_named_with_its_code_and_the_way_out_and_left_only_when_asked() {
    let mut robot = FakeRobot::new(Troubles::default());
    robot.state = State::Fault(Fault::Overcurrent);
    let setting = Setting::with(robot);

    let text = says(&mut setting.host(&["status"]));
    assert!(text.contains("F5: the supply current was too high"), "{text}");
    assert!(text.contains("a caught leg, a stalled servo"), "{text}");
    assert!(text.contains("host status --clear-fault"), "{text}");

    let refused = fails(&mut setting.host(&["walk", "--for", "1"]), 5);
    assert!(refused.contains("a fault is latched"), "{refused}");

    let status = json(&mut setting.host(&["status", "--clear-fault", "--json"]));
    assert_eq!(status["state"], "idle");
}

#[test]
fn an_attached_walk_ends_by_itself_and_tells_what_it_cost() {
    let setting = Setting::new(Troubles { depends_on_host: true, ..Default::default() });

    let text = says(&mut setting.host(&["walk", "--for", "1.5"]));

    assert!(text.contains("walked \"old\" for 1.50 s, 90 frames: its time was over"), "{text}");
    assert!(text.contains("energy 1.350 J"), "{text}");
    assert!(text.contains("mean power 0.900 W"), "{text}");
}

#[test]
fn a_walk_takes_changes_that_are_typed_meanwhile() {
    let setting = Setting::new(Troubles::default());
    let mut command = setting.host(&["walk", "--stdin", "--json"]);

    let result = json(command.write_stdin("amp 1.8\nfaster\nspeed 0.5\n\nstop\n"));

    assert_eq!(result["stopped"], serde_json::Value::Null);
    assert_eq!(result["amplitude"], 1.8);
    let done = setting.done();
    assert!(done.contains(&Command::SetAmplitude(Amplitude::from_f64(1.8).unwrap())));
    assert!(done.contains(&Command::SetSpeed(Speed::from_f64(0.5).unwrap())));
    assert_eq!(setting.bench.robot(|robot| robot.last_trial.unwrap().end), WalkEnd::Asked);
}

/// The gait's own period is 0.6 s.
#[test]
fn a_period_is_as_good_as_a_speed_within_the_robots_range() {
    let setting = Setting::new(Troubles::default());

    let result = json(&mut setting.host(&["walk", "--for", "0.2", "--period", "1.2", "--json"]));
    let refused = fails(&mut setting.host(&["walk", "--for", "0.2", "--period", "0.2"]), 2);

    assert_eq!(result["speed"], 0.5);
    assert!(setting.done().contains(&Command::SetSpeed(Speed::from_f64(0.5).unwrap())));
    assert!(refused.contains("the gait's own is 0.6 s, and it can be played in 0.3 s or more"), "{refused}");
}

#[test]
fn a_rehearsal_asks_the_robot_for_limp_servos() {
    let setting = Setting::new(Troubles::default());

    let text = says(&mut setting.host(&["walk", "--for", "0.2", "--dry-run"]));

    assert!(text.contains("rehearsed \"old\" for 0.20 s"), "{text}");
    let walks = setting.done().into_iter().find(|command| matches!(command, Command::Walk { .. }));
    assert!(matches!(walks, Some(Command::Walk { dry_run: true, detached: false, .. })), "{walks:?}");
}

#[test]
fn a_detached_walk_goes_on_without_the_program_and_takes_changes_from_the_next() {
    let setting = Setting::new(Troubles { depends_on_host: true, ..Default::default() });

    let text = says(&mut setting.host(&["walk", "--detached", "--for", "60"]));
    assert!(text.contains("by itself for 60 s, then stands and goes limp"), "{text}");
    assert!(text.contains("host -- stop --port"), "{text}");
    assert!(text.contains("measure --last"), "{text}");

    let text = says(&mut setting.host(&["set", "--amp", "1.5", "--pause"]));
    assert!(text.contains("done; the robot is"), "{text}");
    assert_eq!(setting.bench.robot(|robot| (robot.amplitude.value(), robot.speed)), (1.5, Speed::PAUSED));

    says(&mut setting.host(&["set", "--resume"]));
    let text = says(&mut setting.host(&["stop"]));
    assert!(text.contains("the robot is standing still, servos on"), "{text}");
    let (stop_bytes, end) = setting.bench.robot(|robot| (robot.stop_bytes, robot.last_trial.unwrap().end));
    assert_eq!((stop_bytes, end), (1, WalkEnd::StopByte));
}

#[test]
fn a_detached_walk_without_an_end_is_not_started() {
    let setting = Setting::new(Troubles::default());

    let message = fails(&mut setting.host(&["walk", "--detached"]), 2);

    assert!(message.contains("--for <S>"), "{message}");
}

#[test]
fn a_change_for_a_robot_that_stands_says_how_to_start_one() {
    let setting = Setting::new(Troubles::default());

    let message = fails(&mut setting.host(&["set", "--pause"]), 5);

    assert!(message.contains("is not walking: it is idle, servos limp"), "{message}");
    assert!(message.contains("host walk --detached --for 60"), "{message}");
    assert!(fails(&mut setting.host(&["set"]), 2).contains("--amp"));
    assert!(fails(&mut setting.host(&["set", "--amp", "4"]), 2).contains("within 0.5 to 3"));
}

#[test]
fn a_supply_that_is_too_low_is_named_with_its_voltage() {
    let setting = Setting::new(Troubles { supply_mv: Some(4200), ..Default::default() });

    let message = fails(&mut setting.host(&["walk", "--for", "1"]), 5);

    assert!(message.contains("its supply has 4.20 V at rest, too little to walk"), "{message}");
    assert!(message.contains("a charged battery"), "{message}");
}

#[test]
fn a_fault_in_mid_walk_is_an_error_and_the_energy_so_far_is_told() {
    let setting = Setting::new(Troubles { faults_at: Some(20), ..Default::default() });
    let mut command = setting.host(&["walk", "--for", "1"]);

    let assert = command.assert().code(5);

    let out = String::from_utf8_lossy(&assert.get_output().stdout).into_owned();
    let err = String::from_utf8_lossy(&assert.get_output().stderr).into_owned();
    assert!(out.contains("energy"), "{out}");
    assert!(err.contains("the robot stopped by itself: the power sensor"), "{err}");
    assert!(err.contains("host status --clear-fault"), "{err}");
}

#[test]
fn stored_gaits_are_listed_selected_and_erased_by_name() {
    let setting = Setting::new(Troubles::default());
    says(&mut setting.host(&["upload-gait", "--amp", "2.2", "--gait", "gait.toml"]));

    let list = json(&mut setting.host(&["gaits", "--json"]));
    assert_eq!((&list["places"], &list["active"]), (&3.into(), &"new".into()));
    assert_eq!(list["gaits"][0]["name"], "old");
    assert_eq!(list["gaits"][1]["at_start"], true);

    let text = says(&mut setting.host(&["gaits", "--select", "old"]));
    assert!(text.contains("1 old 1x, played after every start, active now"), "{text}");
    assert!(text.contains("2 new 2.2x 3 free"), "{text}");

    let text = says(&mut setting.host(&["gaits", "--erase", "old"]));
    assert!(text.contains("1 free"), "{text}");
    assert!(text.contains("active now: \"old\", which is not stored"), "{text}");

    let message = fails(&mut setting.host(&["gaits", "--select", "trot"]), 5);
    assert!(message.contains("the robot stores no gait \"trot\"; it has new"), "{message}");
    assert!(message.contains("such as 'new'"), "{message}");
}

/// 10 T_2 reaches 20 degrees at 2.0x.
#[test]
fn an_amplitude_beyond_the_gaits_limits_is_no_change_to_a_walk_unless_asked_for_with_clip() {
    let mut narrow = bench_host::gait("narrow");
    narrow.joints[2].max_deg = 20.0;
    let bytes = narrow.encoded().unwrap();
    let setting = Setting::with(FakeRobot::with_gait(Troubles::default(), &bytes, 1.0));

    says(&mut setting.host(&["walk", "--detached", "--for", "60"]));
    let refused = fails(&mut setting.host(&["set", "--amp", "2.5"]), 3);
    let kept = setting.bench.robot(|robot| robot.amplitude.value());
    says(&mut setting.host(&["set", "--amp", "2.5", "--clip"]));
    let clipped = setting.bench.robot(|robot| robot.amplitude.value());

    assert!(refused.contains("hip3 would go to 25.0 degrees"), "{refused}");
    assert!(refused.contains("the largest amplitude that fits is 2"), "{refused}");
    assert_eq!((kept, clipped), (1.0, 2.5));
}
