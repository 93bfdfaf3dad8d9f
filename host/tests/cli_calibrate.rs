//! The calibration wizard, fed line by line and key by key, against the fake
//! robot. Linux only: the terminal is.
#![cfg(target_os = "linux")]

mod bench_host;
mod fake_robot;
mod terminal;

use bench_host::{Setting, fails, says, words};
use fake_robot::{FakeRobot, Troubles};
use host::calibration::RobotCalibration;
use protocol::calibration::{JointCalibration, MAX_PRESCALE};
use protocol::command::CalibrationSource;
use protocol::{Calibration, Command, Joint, State};
use terminal::Terminal;

fn on_robot(setting: &Setting) -> Calibration {
    setting.bench.robot(|robot| robot.calibration)
}

fn file(setting: &Setting) -> RobotCalibration {
    RobotCalibration::load(&setting.folder.path().join("calibration.toml")).unwrap()
}

/// Every joint kept as it is: output, switch on, neutral, direction, scale, limits.
const KEPT: &str = "\n\n\ny\n\n\n";

#[test]
fn the_robots_calibration_goes_into_a_file_and_from_there_onto_another() {
    let authors = Calibration::authors();
    let mut joints = Joint::ALL.map(|joint| authors.joint(joint));
    joints.swap(0, 5);
    joints[2] = JointCalibration { reversed: true, neutral_counts: 351, ..joints[2] };
    let mut robot = FakeRobot::new(Troubles::default());
    robot.calibration = Calibration::new(&joints, &authors.board());
    let from = Setting::with(robot);
    let to = Setting::new(Troubles::default());
    let path = from.folder.path().join("mine.toml");
    let path = path.to_str().unwrap();

    let read = says(&mut from.host(&["calibrate", "--read", path]));
    let written = says(&mut to.host(&["calibrate", "--write", path]));

    assert!(read.contains("the calibration of the robot on"), "{read}");
    assert!(written.contains("has saved the calibration in"), "{written}");
    assert_eq!(on_robot(&to), on_robot(&from));
    assert_eq!(to.bench.robot(|robot| robot.calibration_source), CalibrationSource::Stored);
}

#[test]
fn a_file_that_no_robot_takes_is_refused_before_the_port_is_opened() {
    let setting = Setting::new(Troubles::default());
    says(&mut setting.host(&["calibrate", "--read", "mine.toml"]));
    let path = setting.folder.path().join("mine.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let talked = setting.done().len();

    std::fs::write(&path, text.replacen("neutral_us = 1346.4", "neutral_us = 3100.0", 1)).unwrap();
    let message = fails(&mut setting.host(&["calibrate", "--write", "mine.toml"]), 3);

    assert!(message.contains("hip1: neutral_us is 3100; it must be within 300 to 3000 us"), "{message}");
    assert!(message.contains("correct the value in the file"), "{message}");
    assert_eq!(setting.done().len(), talked);
    assert!(fails(&mut setting.host(&["calibrate", "--write", "none.toml"]), 3).contains("cannot read"));
}

#[test]
fn a_moving_robot_a_worn_out_eeprom_and_a_forgetful_robot_are_told_apart() {
    let write = |troubles: Troubles, state: State| {
        let mut robot = FakeRobot::new(troubles);
        robot.state = state;
        let setting = Setting::with(robot);
        let path = setting.folder.path().join("mine.toml");
        RobotCalibration::from_record(&Calibration::authors()).save(&path).unwrap();
        fails(&mut setting.host(&["calibrate", "--write", "mine.toml"]), 5)
    };

    let moving = write(Troubles::default(), State::Walking);
    let worn_out = write(Troubles { worn_out: true, ..Default::default() }, State::Idle);
    let forgetful = write(Troubles { misremembers: true, ..Default::default() }, State::Idle);

    assert!(moving.contains("its servos are on") && moving.contains("host stop"), "{moving}");
    assert!(worn_out.contains("its EEPROM did not read back"), "{worn_out}");
    assert!(forgetful.contains("differs from the one that was sent, at byte 0 of 84"), "{forgetful}");
}

/// hip1 sits on output 3, 10 counts off, turned round; 45 degrees take 80 counts.
#[test]
fn a_joint_is_found_out_by_moving_it() {
    let setting = Setting::new(Troubles::default());
    let hip1 = "3\n\n+25\n-\n-14\n\nn\nm\n+80\n\nm\n-100\n\n+120\n\n";
    // hip4 takes the output that is free now.
    let hip4 = "0\n\n\ny\n\n\n";
    let answers = format!("n\n{hip1}{KEPT}{KEPT}{hip4}{}y\n", KEPT.repeat(4));

    let text = says(setting.host(&["calibrate"]).write_stdin(answers));

    assert!(text.contains("the robot has saved the calibration"), "{text}");
    let hip1 = on_robot(&setting).joint(Joint::Hip1);
    assert_eq!((hip1.channel, hip1.reversed, hip1.neutral_counts), (3, true, 340));
    // 80 counts in 45 degrees, where the authors' 45 degrees take 75.
    assert!((f64::from(hip1.scale_q20) / 6826.67 - 80.0 / 75.0).abs() < 1e-3, "{hip1:?}");
    assert_eq!((hip1.min_counts, hip1.max_counts), (240, 460));
    assert_eq!(on_robot(&setting).joint(Joint::Hip2), Calibration::authors().joint(Joint::Hip2));
    assert!(file(&setting).joints.iter().all(|joint| joint.is_measured));
}

/// Whatever moves, moves alone, in steps that a servo can follow, and is let go.
#[test]
fn one_servo_moves_at_a_time_and_gently() {
    let setting = Setting::new(Troubles::default());

    let answers = format!("n\n{}y\n", KEPT.repeat(8));
    says(setting.host(&["calibrate"]).write_stdin(answers));

    let nudges: Vec<(u8, u16)> = setting
        .done()
        .into_iter()
        .filter_map(|command| match command {
            Command::Nudge { channel, counts } => Some((channel, counts)),
            _ => None,
        })
        .collect();
    for pair in nudges.windows(2) {
        let ((from, a), (to, b)) = (pair[0], pair[1]);
        assert!(from == to || a == 0, "{pair:?}");
        let is_switched = a == 0 || b == 0;
        assert!(is_switched || a.abs_diff(b) <= 3, "{pair:?}");
    }
    assert!(nudges.contains(&(0, 355)), "hip1 was never shown turning: {nudges:?}");
    assert_eq!(setting.bench.robot(|robot| robot.nudged), None);
}

/// The Ant's robot.toml has 40.1 degrees.
#[test]
fn the_knees_neutral_slope_is_that_of_the_robots_description() {
    let setting = Setting::new(Troubles::default());

    let answers = format!("n\n{}n\n", KEPT.repeat(8));
    let assert = setting.host(&["calibrate"]).write_stdin(answers).assert().success();

    let questions = words(&assert.get_output().stderr);
    assert!(
        questions.contains("turn the shin until it slopes 40 degrees below the horizontal"),
        "{questions}"
    );
}

/// Another robot: its drawing, its pulses to start with, and pictures of what is asked.
#[test]
fn the_wizard_asks_for_the_poses_of_the_robot_that_is_named() {
    let setting = Setting::new(Troubles::default());
    let pony = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pony");

    let answers = format!("n\n{}n\n", KEPT.repeat(8));
    let assert = setting.host(&["calibrate", "--robot", pony]).write_stdin(answers).assert().success();

    let questions = words(&assert.get_output().stderr);
    for part in ["switches it on at 1500 us", "Scale: 10.00 us a degree", "calibrate-knee4.svg"] {
        assert!(questions.contains(part), "{part}: {questions}");
    }
    let picture = std::fs::read_to_string(setting.folder.path().join("calibrate-knee4.svg")).unwrap();
    assert!(picture.contains("knee4: seen from the side"), "{picture}");
}

#[test]
fn an_end_before_the_first_answer_names_no_file() {
    let setting = Setting::new(Troubles::default());

    let ended = fails(setting.host(&["calibrate"]).write_stdin("q\n"), 130);

    assert!(ended.contains("cancelled; nothing was measured yet"), "{ended}");
    assert!(!setting.folder.path().join("calibration.toml").exists());
}

#[test]
fn what_was_measured_survives_the_end_and_the_same_command_goes_on() {
    let setting = Setting::new(Troubles::default());
    let first = "n\n\n\n+4\n\ny\n\n\n";

    let ended = fails(setting.host(&["calibrate"]).write_stdin(format!("{first}\n\nq\n")), 130);
    assert!(ended.contains("cancelled; what was measured is in calibration.toml"), "{ended}");
    assert_eq!(setting.bench.robot(|robot| robot.nudged), None);
    let kept = file(&setting);
    assert_eq!(kept.joints.iter().filter(|joint| joint.is_measured).count(), 1);
    assert!((kept.joints[0].neutral_us - 334.0 * 4.08).abs() < 0.01);
    assert_eq!(on_robot(&setting), Calibration::authors());

    let cut = fails(setting.host(&["calibrate"]).write_stdin("n\n\n"), 2);
    assert!(cut.contains("standard input ended"), "{cut}");

    let text = says(setting.host(&["calibrate"]).write_stdin(format!("n\n{}n\n", KEPT.repeat(7))));
    assert!(text.contains("the robot keeps the calibration it had"), "{text}");
    assert!(text.contains("calibrate --write calibration.toml --port"), "{text}");
    assert!(file(&setting).joints.iter().all(|joint| joint.is_measured));
}

#[test]
fn two_joints_on_one_output_are_refused_with_the_way_out() {
    let setting = Setting::new(Troubles::default());
    let answers = format!("n\n1\n\n\ny\n\n\n{}", KEPT.repeat(7));

    let message = fails(setting.host(&["calibrate"]).write_stdin(answers), 3);

    assert!(message.contains("hip1 and hip2 both have channel 1"), "{message}");
    assert!(message.contains("host calibrate --joint hip2"), "{message}");
}

/// 58.4 Hz of prescaler 101 are 24.4 MHz; 50 Hz of that are prescaler 118.
#[test]
fn the_boards_values_are_asked_for_and_unusable_ones_asked_for_again() {
    let setting = Setting::new(Troubles::default());
    let board = "y\ny\n\n\n58.4\n50\n0.1\n6,8\nmany\n20\n6\n2.5\n2.5\n30\n";
    let skipped = "\ns\n".repeat(8);

    says(setting.host(&["calibrate"]).write_stdin(format!("{board}{skipped}y\n")));

    let board = on_robot(&setting).board();
    assert_eq!((board.oscillator_khz, board.prescale), (24_399, 118));
    assert_eq!((board.start_mv, board.undervoltage_mv, board.overcurrent_ma), (6_800, 6_000, 2_500));
    assert_eq!(board.autostart_s, 30);
    assert!(board.prescale < MAX_PRESCALE);
    // Pulses stay what they were in microseconds: 330 counts of 4.08 us.
    let neutral = on_robot(&setting).joint(Joint::Knee1).neutral_counts;
    let pulse_us = f64::from(neutral) * 119.0 / 24.399;
    assert!((pulse_us - 1346.4).abs() < 2.5, "{pulse_us}");
}

#[test]
fn a_robot_that_walks_is_not_calibrated() {
    let mut robot = FakeRobot::new(Troubles::default());
    robot.state = State::Walking;
    let setting = Setting::with(robot);

    let message = fails(setting.host(&["calibrate"]).write_stdin(""), 5);

    assert!(message.contains("only while its servos are limp"), "{message}");
    assert!(message.contains("host stop"), "{message}");
}

/// At a terminal, arrow keys move the servo, which is kept on meanwhile.
#[test]
fn at_a_terminal_the_arrow_keys_move_the_servo() {
    let setting = Setting::new(Troubles::default());
    let args = ["calibrate", "--joint", "knee2", "--port", &setting.bench.port];
    let mut terminal = Terminal::host(setting.folder.path(), &args);

    terminal.after("on which output", "\n");
    terminal.after("switches it on", "\r");
    terminal.after("330 counts", "\x1b[A");
    terminal.after("340 counts", "\x1b[D");
    terminal.after("339 counts", "\r");
    terminal.after("fold down and inward", "y");
    terminal.after("a degree. Enter keeps", "\r");
    terminal.after("Limits", "\r");
    terminal.after("let it save it", "\n");
    let (status, said) = terminal.end();

    assert!(status.success(), "{said}");
    assert_eq!(on_robot(&setting).joint(Joint::Knee2).neutral_counts, 339);
}
