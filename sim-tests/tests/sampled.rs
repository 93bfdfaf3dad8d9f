//! A gait as rows of samples, for what no polynomial holds.

use protocol::command::{Record, Storage};
use protocol::gait::{GaitError, GaitTable, MAX_ENCODED_LEN, MAX_ROWS, SampledTable};
use protocol::{Command, FRAME_RATE_HZ, JOINT_COUNT, Name, Refusal, Reply, State, WalkEnd};
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;
use sim_tests::sim_robot::ask::{WALK, walk_for};
use sim_tests::sim_robot::pulses::{COUNTS_PER_DEG, SLOW_STEP_COUNTS, error_from, largest_step, servos_on};

const CENTRES_DEG: [f64; JOINT_COUNT] = [-4.0, 3.0, -2.0, 1.0, 9.0, 10.0, 11.0, 12.0];

/// A saw: straight up, and down within a row; no polynomial has that.
fn saw(rows: usize) -> Vec<[f64; JOINT_COUNT]> {
    let row = |row: usize| {
        std::array::from_fn(|joint| {
            let place = (row + joint) % rows;
            18.0 * place as f64 / (rows - 1) as f64 - 9.0
        })
    };
    (0..rows).map(row).collect()
}

fn encoded(rows_deg: &[[f64; JOINT_COUNT]], period_us: u32) -> Vec<u8> {
    let name = Name::new("saw").unwrap();
    let table = SampledTable::quantise(name, period_us, (-55, 55), &CENTRES_DEG, rows_deg).unwrap();
    let mut buffer = [0; MAX_ENCODED_LEN];
    table.encode(&mut buffer).unwrap().to_vec()
}

/// Straight lines between rows, the last one back to the first, in f64.
fn angles(rows_deg: &[[f64; JOINT_COUNT]], phase: f64, value: f64) -> [f64; JOINT_COUNT] {
    let place = phase.fract() * rows_deg.len() as f64;
    let (row, share) = (place as usize % rows_deg.len(), place.fract());
    let next = (row + 1) % rows_deg.len();
    std::array::from_fn(|joint| {
        let deviation = rows_deg[row][joint] * (1.0 - share) + rows_deg[next][joint] * share;
        CENTRES_DEG[joint] + value * deviation
    })
}

#[test]
fn every_pulse_lies_on_straight_lines_between_the_rows() {
    for (rows, period_us, value) in [(MAX_ROWS, 1_800_000, 1.0), (2, 500_000, 2.0), (9, 2_700_000, 3.0)] {
        let rows_deg = saw(rows);
        let mut robot = SimRobot::new();
        robot.upload_encoded(&encoded(&rows_deg, period_us), amplitude(value), false);
        robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
        robot.expect_done(WALK);
        robot.run_until(State::Walking);
        robot.take_pulses();

        let frames = f64::from(period_us) * 1e-6 * f64::from(FRAME_RATE_HZ);
        let pulses = robot.pulses_over(2 * frames as u64 + 4);

        // Half of a step of 9 / 127 degrees at most, scaled; and half a count.
        let bound = 0.5 + COUNTS_PER_DEG * (value * 0.5 * (9.0 / 127.0 + 1.0 / 512.0) + 0.01);
        let error = |frame: usize, at: usize| {
            error_from(&angles(&rows_deg, frame as f64 / frames, value), &pulses[at])
        };
        let start = (0..4)
            .find(|&at| (0..20).all(|frame| error(frame, at + frame) <= bound))
            .expect("the first stride");
        for at in start..pulses.len() {
            assert!(
                error(at - start, at) <= bound,
                "{rows} rows, frame {}: {}",
                at - start,
                error(at - start, at)
            );
        }
    }
}

#[test]
fn it_is_kept_read_back_and_walked_after_a_power_cycle() {
    let bytes = encoded(&saw(MAX_ROWS), 1_800_000);
    let mut robot = SimRobot::new();
    robot.upload_encoded(&bytes, amplitude(1.5), true);
    robot.run_frames(90);

    let mut robot = robot.power_cycle();
    robot.run_frames(2);
    let status = robot.status();
    robot.expect_done(walk_for(60));
    robot.run_until(State::Idle);

    let gait = status.gait.unwrap();
    assert_eq!((gait.name.as_str(), gait.amplitude, status.storage), ("saw", amplitude(1.5), Storage::Saved));
    assert_eq!(gait.crc32, GaitTable::crc32_of(&bytes));
    assert_eq!(robot.read_record(Record::Gait), bytes);
    assert_eq!(robot.stored_gait(0).unwrap().name.as_str(), "saw");
    assert_eq!(robot.walk_ends(), [WalkEnd::Finished]);
}

#[test]
fn the_way_in_and_out_is_slow_and_ends_at_its_centre() {
    let mut robot = SimRobot::new();
    robot.upload_encoded(&encoded(&saw(9), 2_700_000), amplitude(3.0), false);
    robot.take_pulses();
    robot.expect_done(WALK);
    robot.run_until(State::Walking);
    let way_in: Vec<_> = robot.take_pulses().into_iter().filter(servos_on).collect();
    robot.run_frames(30);
    robot.expect_done(Command::Stop);
    robot.run_frames(2);
    robot.take_pulses();
    robot.run_until(State::Idle);
    let way_out: Vec<_> = robot.take_pulses().into_iter().filter(servos_on).collect();

    assert!(largest_step(&way_in) <= SLOW_STEP_COUNTS && largest_step(&way_out) <= SLOW_STEP_COUNTS);
    assert!(error_from(&CENTRES_DEG, way_out.last().unwrap()) <= 0.6);
}

#[test]
fn it_replaces_a_polynomial_while_walking_and_the_other_way_round() {
    let mut robot = SimRobot::playing(&fixtures::trot(), amplitude(1.0));
    robot.run_frames(20);
    for sampled in [true, false] {
        if sampled {
            robot.upload_encoded(&encoded(&saw(9), 2_700_000), amplitude(1.0), false);
        } else {
            robot.upload(&fixtures::trot(), amplitude(1.0), false);
        }
        assert_eq!(robot.state(), State::Entering);
        robot.run_frames(2);
        robot.take_pulses();
        robot.run_until(State::Walking);
        assert!(largest_step(&robot.take_pulses()) <= SLOW_STEP_COUNTS);
        robot.run_frames(30);
    }
}

#[test]
fn joints_are_held_at_its_limits_and_the_frames_are_counted() {
    let name = Name::new("narrow").unwrap();
    let table = SampledTable::quantise(name, 1_000_000, (-5, 12), &CENTRES_DEG, &saw(10)).unwrap();
    let mut buffer = [0; MAX_ENCODED_LEN];
    let bytes = table.encode(&mut buffer).unwrap();
    let mut robot = SimRobot::new();
    robot.upload_encoded(bytes, amplitude(1.0), false);
    robot.expect_done(Command::StreamTelemetry { every_frames: 1 });
    robot.take_pulses();

    robot.expect_done(walk_for(120));
    robot.run_until(State::Idle);
    robot.run_frames(2);

    let within = (330.0 - 5.0 * COUNTS_PER_DEG - 0.5)..=(330.0 + 12.0 * COUNTS_PER_DEG + 0.5);
    assert!(robot.take_pulses().iter().flatten().flatten().all(|c| within.contains(&f64::from(*c))));
    let clipped = robot.telemetry().last().unwrap().clipped_frames;
    let is_beyond = |deg: f64| !(-5.0..=12.0).contains(&deg);
    let expected =
        (0..120).filter(|&frame| angles(&saw(10), f64::from(frame) / 60.0, 1.0).into_iter().any(is_beyond));
    let expected = expected.count() as u32;
    assert!(clipped.abs_diff(expected) <= 4, "{clipped} frames clipped, {expected} expected");
    assert!((60..120).contains(&expected), "{expected}");
}

#[test]
fn a_damaged_or_unsound_one_is_refused_with_what_is_wrong() {
    let good = encoded(&saw(9), 1_000_000);
    let with = |at: usize, byte: u8| {
        let mut bytes = good[..good.len() - 4].to_vec();
        bytes[at] = byte;
        bytes.extend(protocol::crc::crc32(&bytes).to_le_bytes());
        bytes
    };
    let mut damaged = good.clone();
    damaged[60] ^= 1;
    for (bytes, error) in [
        (damaged, GaitError::Crc),
        (with(0, 2), GaitError::Kind),
        (with(1, 0), GaitError::Name),
        (with(20, 0xFF), GaitError::Period),
        (with(21, 0), GaitError::Step),
        (with(22, 60), GaitError::JointLimits(0)),
        (with(25, 0x7F), GaitError::JointLimits(0)),
        (with(40, 1), GaitError::Rows),
        (with(40, 28), GaitError::Rows),
        (with(40, 8), GaitError::Length),
    ] {
        let mut robot = SimRobot::new();
        robot.send_pieces(&bytes);

        let refused = robot.ask(Command::UploadCommit { amplitude: amplitude(1.0), persist: true });

        assert_eq!(refused, Reply::Refused(Refusal::BadGait(error)), "{bytes:x?}");
        assert_eq!(robot.status().gait, None);
    }
}
