//! The link, the upload and the trial against a robot that fails on request.

mod fake_robot;

use fake_robot::{FRAME_ENERGY_UJ, FakeRobot, Troubles};
use host::device::link::{Link, LinkError, Timeouts};
use host::device::trial::{self, Order, Trial, TrialStop};
use host::device::upload::{self, Stage, UploadError, Uploaded};
use host::gait::gait_file::{GaitFile, JointSeries, Provenance, Source};
use protocol::command::Storage;
use protocol::{Amplitude, Command, Fault, Joint, ResetCause, State, WalkEnd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// A robot in memory answers at once; only what never comes is waited for.
const TIMEOUTS: Timeouts = Timeouts {
    settle: Duration::from_millis(2),
    hello_every: Duration::from_millis(5),
    hello_for: Duration::from_millis(60),
    reply: Duration::from_millis(5),
    attempts: 6,
    busy_for: Duration::from_millis(100),
    busy_every: Duration::from_millis(1),
};

fn table(name: &str) -> Vec<u8> {
    let mut coefficients_deg = [0.0; 11];
    coefficients_deg[2] = 10.0;
    coefficients_deg[7] = 0.5;
    let series = JointSeries { min_deg: -55.0, max_deg: 55.0, coefficients_deg, ..Default::default() };
    let gait = GaitFile {
        name: name.into(),
        period_s: 0.6,
        unit_deg: 24.0,
        provenance: Provenance::of(Source::Fitted),
        joints: Joint::ALL.map(|_| series.clone()),
    };
    gait.encoded().unwrap()
}

fn amplitude() -> Amplitude {
    Amplitude::from_f64(2.2).unwrap()
}

fn connect(robot: &mut FakeRobot) -> Result<Link<&mut FakeRobot>, LinkError> {
    Link::connect(robot, "the robot", TIMEOUTS)
}

fn upload(robot: &mut FakeRobot, table: &[u8]) -> Result<Uploaded, UploadError> {
    upload::upload(&mut connect(robot).unwrap(), table, amplitude(), true, |_, _| {})
}

fn walk(robot: &mut FakeRobot) -> Trial {
    let mut link = connect(robot).unwrap();
    trial::prepare(&mut link).unwrap();
    trial::walk(&mut link, &Order::of(120), &AtomicBool::new(false), |_: State, _: u32| {}).unwrap()
}

#[test]
fn a_session_begins_with_the_robots_hello() {
    let mut robot = FakeRobot::new(Troubles::default());

    let link = connect(&mut robot).unwrap();

    assert_eq!(link.hello().unwrap().limits.max_gait_len, 264);
}

#[test]
fn a_robot_that_starts_after_its_old_program_answered_is_greeted_again() {
    let mut robot = FakeRobot::with_gait(Troubles::default(), &table("old"), 1.0);
    robot.reset(ResetCause::External);

    let mut link = connect(&mut robot).unwrap();

    assert_eq!(link.status().unwrap().state, State::Idle);
}

#[test]
fn another_protocol_version_is_named_and_nothing_else_is_sent() {
    let mut robot = FakeRobot::new(Troubles { protocol_version: Some(9), ..Default::default() });

    let error = connect(&mut robot).unwrap_err();

    assert!(matches!(error, LinkError::ProtocolVersion { robot: 9, .. }), "{error}");
    assert!(error.to_string().contains("speaks protocol version 9, this program version 3"), "{error}");
    assert!(robot.done.iter().all(|command| matches!(command, Command::Hello { .. })), "{:?}", robot.done);
}

#[test]
fn silence_and_babble_are_told_apart() {
    let mut silent = FakeRobot::new(Troubles { silent: true, ..Default::default() });
    let mut babbling =
        FakeRobot::new(Troubles { babbles: Some(b"start\r\n".to_vec()), ..Default::default() });

    let silence = connect(&mut silent).unwrap_err().to_string();
    let babble = connect(&mut babbling).unwrap_err().to_string();

    assert!(silence.contains("and not a single byte"), "{silence}");
    assert!(babble.contains("bytes that are no message of a robot"), "{babble}");
}

#[test]
fn an_upload_is_verified_and_saved() {
    let mut robot = FakeRobot::with_gait(Troubles::default(), &table("old"), 1.0);

    let uploaded = upload(&mut robot, &table("new")).unwrap();

    assert_eq!((uploaded.gait.name.as_str(), uploaded.storage), ("new", Storage::Saved));
    assert_eq!(uploaded.gait.amplitude, amplitude());
    assert_eq!(robot.table, table("new"));
}

#[test]
fn lost_answers_are_asked_for_again_and_no_command_is_carried_out_twice() {
    let mut robot = FakeRobot::new(Troubles { loses_every: Some(3), ..Default::default() });

    upload(&mut robot, &table("new")).unwrap();

    let chunks = robot.done.iter().filter(|command| matches!(command, Command::UploadChunk { .. }));
    assert_eq!(chunks.count(), table("new").len().div_ceil(64));
    assert_eq!(robot.table, table("new"));
}

#[test]
fn corrupt_bytes_cost_time_but_no_bytes() {
    let mut robot = FakeRobot::new(Troubles { flips_every: Some(101), ..Default::default() });

    upload(&mut robot, &table("new")).unwrap();

    assert_eq!(robot.table, table("new"));
}

/// Wherever the cable is pulled, the robot has the old gait or the new one, whole.
#[test]
fn a_cable_pulled_in_mid_upload_leaves_a_whole_gait() {
    let (old, new) = (table("old"), table("new"));
    let mut kept = 0;
    for cut_after in (20..400).step_by(7) {
        // The hello takes the first few bytes.
        let troubles = Troubles { cut_after: Some(cut_after), ..Default::default() };
        let mut robot = FakeRobot::with_gait(troubles, &old, 1.0);

        let outcome = upload(&mut robot, &new);

        match outcome {
            Ok(_) => assert_eq!(robot.table, new),
            Err(UploadError::Link { stage: Stage::Transfer, source: LinkError::Broken { .. } }) => {
                assert_eq!(robot.table, old, "cut after {cut_after} bytes");
                kept += 1;
            }
            Err(UploadError::Link { source: LinkError::Broken { .. }, .. }) => {
                assert!(robot.table == old || robot.table == new, "cut after {cut_after} bytes");
            }
            Err(other) => panic!("cut after {cut_after} bytes: {other}"),
        }
    }
    assert!(kept > 10, "only {kept} cuts fell into the transfer");
}

#[test]
fn a_worn_out_eeprom_is_reported() {
    let mut robot = FakeRobot::new(Troubles { worn_out: true, ..Default::default() });

    assert!(matches!(upload(&mut robot, &table("new")), Err(UploadError::NotSaved)));
}

#[test]
fn a_gait_that_reads_back_differently_is_reported() {
    let mut robot = FakeRobot::new(Troubles { misremembers: true, ..Default::default() });

    assert!(matches!(upload(&mut robot, &table("new")), Err(UploadError::Differs { at: 0 })));
}

#[test]
fn a_damaged_table_is_refused_by_the_robot_and_the_old_gait_stays() {
    let mut robot = FakeRobot::with_gait(Troubles::default(), &table("old"), 1.0);
    let mut damaged = table("new");
    damaged[40] ^= 1;

    let error = upload(&mut robot, &damaged).unwrap_err();

    let UploadError::Link { stage: Stage::Transfer, source } = &error else { panic!("{error}") };
    assert!(source.to_string().contains("refused to activate the gait"), "{source}");
    assert!(error.to_string().contains("the robot keeps the gait it had"), "{error}");
    assert_eq!(robot.table, table("old"));
}

#[test]
fn a_trial_is_the_gait_frames_and_their_energy() {
    let mut robot = FakeRobot::with_gait(Troubles::default(), &table("walk"), 2.2);

    let trial = walk(&mut robot);

    assert!(trial.stop.is_none(), "{:?}", trial.stop);
    assert_eq!((trial.frames(), trial.lost_frames()), (120, 0));
    assert!((trial.energy_j() - 120.0 * FRAME_ENERGY_UJ as f64 / 1e6).abs() < 1e-9);
    assert_eq!(trial.duration_s(), 2.0);
}

/// The counters of the last trial are still on the wire when the next begins.
#[test]
fn the_trial_before_is_not_mistaken_for_this_one() {
    let mut robot = FakeRobot::with_gait(Troubles::default(), &table("walk"), 2.2);
    walk(&mut robot);

    let trial = walk(&mut robot);

    assert!(trial.samples.len() > 120, "{}", trial.samples.len());
    assert_eq!(trial.frames(), 120);
}

#[test]
fn lost_telemetry_is_counted_and_costs_no_energy() {
    let troubles = Troubles { drops_telemetry_every: Some(4), ..Default::default() };
    let mut robot = FakeRobot::with_gait(troubles, &table("walk"), 2.2);

    let trial = walk(&mut robot);

    assert_eq!(trial.frames(), 120);
    // Every fourth of 120 frames, give or take the one that the end falls on.
    assert!((29..=31).contains(&trial.lost_frames()), "{}", trial.lost_frames());
    assert!((trial.energy_j() - 120.0 * FRAME_ENERGY_UJ as f64 / 1e6).abs() < 1e-9);
}

#[test]
fn a_noisy_cable_does_not_spoil_a_trial() {
    let troubles = Troubles { flips_every: Some(211), loses_every: Some(4), ..Default::default() };
    let mut robot = FakeRobot::with_gait(troubles, &table("walk"), 2.2);

    let trial = walk(&mut robot);

    assert!(trial.stop.is_none(), "{:?}", trial.stop);
    assert_eq!(trial.frames(), 120);
}

#[test]
fn a_fault_in_mid_walk_ends_the_trial_with_its_name() {
    let mut robot =
        FakeRobot::with_gait(Troubles { faults_at: Some(50), ..Default::default() }, &table("walk"), 2.2);

    let trial = walk(&mut robot);

    assert!(matches!(trial.stop, Some(TrialStop::Fault { fault: Fault::SensorLost })), "{:?}", trial.stop);
    assert!(trial.frames() < 120);
}

#[test]
fn a_robot_that_missed_its_host_ends_the_trial_with_the_reason() {
    // Its time runs faster than ours here: 60 frames pass between two heartbeats.
    let troubles = Troubles { depends_on_host: true, ..Default::default() };
    let mut robot = FakeRobot::with_gait(troubles, &table("walk"), 2.2);

    let trial = walk(&mut robot);

    assert!(matches!(trial.stop, Some(TrialStop::LinkLost)), "{:?}", trial.stop);
}

#[test]
fn a_reset_in_mid_walk_ends_the_trial_with_its_cause() {
    let mut robot =
        FakeRobot::with_gait(Troubles { resets_at: Some(50), ..Default::default() }, &table("walk"), 2.2);

    let trial = walk(&mut robot);

    let Some(TrialStop::Link { source }) = trial.stop else { panic!("{:?}", trial.stop) };
    assert!(source.to_string().contains("was reset: its supply voltage dropped (brown-out)"), "{source}");
}

#[test]
fn a_robot_that_goes_limp_early_has_not_walked_the_trial() {
    let mut robot =
        FakeRobot::with_gait(Troubles { ends_at: Some(50), ..Default::default() }, &table("walk"), 2.2);

    let trial = walk(&mut robot);

    assert!(
        matches!(trial.stop, Some(TrialStop::Early { frames: 50, asked: Some(120) })),
        "{:?}",
        trial.stop
    );
}

/// Whoever has seen to the cause says so, not the program that wants to walk.
#[test]
fn a_latched_fault_is_left_by_an_explicit_clear_only() {
    let mut robot = FakeRobot::with_gait(Troubles::default(), &table("walk"), 2.2);
    robot.state = State::Fault(Fault::Watchdog);

    let error = trial::prepare(&mut connect(&mut robot).unwrap()).unwrap_err();

    assert!(error.to_string().contains("latched: its program hung"), "{error}");
    assert!(error.help().unwrap().contains("host status --clear-fault"));
    assert!(!robot.done.contains(&Command::ClearFault));
}

#[test]
fn a_button_on_the_robot_ends_the_trial_with_the_reason() {
    let troubles = Troubles { button_at: Some(50), ..Default::default() };
    let mut robot = FakeRobot::with_gait(troubles, &table("walk"), 2.2);

    let stop = walk(&mut robot).stop.unwrap();

    assert!(stop.to_string().contains("of 120 gait frames: its button was pressed"), "{stop}");
}

#[test]
fn a_robot_that_writes_its_eeprom_is_waited_for_but_not_for_ever() {
    let mut busy = FakeRobot::new(Troubles { busy_for: 5, ..Default::default() });
    let mut stuck = FakeRobot::new(Troubles { busy_for: u32::MAX, ..Default::default() });

    upload(&mut busy, &table("new")).unwrap();
    let error = upload(&mut stuck, &table("new")).unwrap_err();

    assert_eq!(busy.table, table("new"));
    let UploadError::Link { stage: Stage::Transfer, source } = &error else { panic!("{error}") };
    assert!(source.to_string().contains("an earlier save is still going on"), "{source}");
}

/// A power cut in mid save must leave the old one: a new gait never takes its place.
#[test]
fn a_full_memory_for_gaits_keeps_the_gait_it_had() {
    let mut robot = FakeRobot::new(Troubles::default());
    for name in ["one", "two", "three"] {
        upload(&mut robot, &table(name)).unwrap();
    }

    for name in ["four", "two"] {
        let error = upload(&mut robot, &table(name)).unwrap_err();

        let UploadError::Link { stage: Stage::Transfer, source } = &error else { panic!("{error}") };
        assert!(source.to_string().contains("all its places for gaits are taken"), "{source}");
        assert!(source.help().unwrap().contains("host gaits --erase NAME"));
        assert_eq!(robot.table, table("three"));
    }
}

#[test]
fn an_interrupted_trial_tells_the_robot_to_stop() {
    let mut robot = FakeRobot::with_gait(Troubles::default(), &table("walk"), 2.2);
    let stop = AtomicBool::new(false);
    let mut link = connect(&mut robot).unwrap();
    trial::prepare(&mut link).unwrap();

    let trial = trial::walk(&mut link, &Order::of(120), &stop, |_: State, played: u32| {
        if played == 40 {
            stop.store(true, Ordering::Relaxed);
        }
    })
    .unwrap();

    drop(link);
    assert!(matches!(trial.stop, Some(TrialStop::Interrupted)), "{:?}", trial.stop);
    assert_eq!(trial.frames(), 40);
    // The byte ended it, before the command came.
    assert_eq!((robot.state, robot.stop_bytes), (State::Holding, 1));
    assert_eq!(robot.last_trial.map(|trial| trial.end), Some(WalkEnd::StopByte));
    assert!(robot.done.contains(&Command::Stop));
}

#[test]
fn a_robot_without_a_gait_refuses_to_walk() {
    let mut robot = FakeRobot::new(Troubles::default());
    let mut link = connect(&mut robot).unwrap();

    let error =
        trial::walk(&mut link, &Order::of(120), &AtomicBool::new(false), |_: State, _: u32| {}).unwrap_err();

    assert_eq!(error.to_string(), "the robot refused to walk: it has no gait");
    assert!(error.help().unwrap().contains("host upload-gait"));
}
