//! Hostile or meaningless requests that pass every checksum.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use protocol::calibration::{BoardCalibration, JointCalibration, UNITY_GAIN_Q14};
use protocol::command::Record;
use protocol::frame::{self, MAX_BODY_LEN, MAX_FRAME_LEN, STOP_BYTE};
use protocol::gait::{COEFFICIENT_COUNT, Coefficient, MAX_ENCODED_LEN, MAX_ROWS, Rows, SampledTable};
use protocol::{
    Amplitude, Angle, Calibration, Chunk, Command, GaitTable, JOINT_COUNT, JointCurve, Name, ResetCause,
    Speed, State,
};
use serde::ser::{Serialize, SerializeTuple as _, Serializer};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;

/// A body of any bytes, to be framed as if it were a message.
#[derive(Debug, Clone)]
struct Raw(Vec<u8>);

impl Serialize for Raw {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut bytes = serializer.serialize_tuple(self.0.len())?;
        for byte in &self.0 {
            bytes.serialize_element(byte)?;
        }
        bytes.end()
    }
}

fn send_raw(robot: &mut SimRobot, body: &[u8]) {
    let mut buffer = [0; MAX_FRAME_LEN];
    let framed = frame::encode(&Raw(body.to_vec()), &mut buffer).expect("a body that fits").to_vec();
    robot.send(&framed);
}

/// What the authors' servos are sent at most, and all that a hostile calibration may change it to.
const REACH_COUNTS: std::ops::RangeInclusive<u16> = 147..=515;

/// What no request whatever may change.
fn assert_in_charge(robot: &mut SimRobot) {
    for pulses in robot.take_pulses() {
        for counts in pulses.into_iter().flatten() {
            assert!(REACH_COUNTS.contains(&counts), "{counts} counts");
        }
    }
    let state = robot.status().state;
    assert!(robot.board.longest_unfed_s() < 0.05, "{} s in one turn", robot.board.longest_unfed_s());
    if matches!(state, State::Idle | State::Fault(_)) {
        // The last burst handed over may still be on its way.
        robot.run_frames(3);
        if matches!(robot.state(), State::Idle | State::Fault(_)) {
            assert!(!robot.board.chips.servo_driver.drives_any(), "servos on in {state:?}");
        }
    }
}

#[test]
fn every_first_byte_of_a_command_is_answered_whatever_follows() {
    let mut robot = SimRobot::playing(&fixtures::trot(), amplitude(2.2));

    for tail in [&[][..], &[0; 40], &[0xFF; 40]] {
        for first in 0..=u8::MAX {
            let before = robot.answers();
            send_raw(&mut robot, &[&[200, first], tail].concat());
            robot.run_frames(3);
            assert_eq!(robot.answers(), before + 1, "command {first} and {} bytes", tail.len());
        }
        assert_in_charge(&mut robot);
    }
}

/// What somebody does to a robot.
#[derive(Debug, Clone)]
enum Deed {
    Raw(Vec<u8>),
    Ask(Command),
    /// A table that no fit would make, limits and coefficients from these bits.
    Upload(Box<GaitTable>, bool),
    Sampled(Vec<[i8; JOINT_COUNT]>, u8, bool),
    /// Outputs permuted and reversed by these bits, the board's numbers any that are sound.
    Calibrate(Box<[JointCalibration; JOINT_COUNT]>, BoardCalibration),
    StopByte,
    Button(bool),
    Supply(f64, f64),
    Rot(usize, u8),
    PowerCycle,
    Unplug(Chip),
    Replug,
    Reset(ResetCause),
    Wait(u64),
}

fn any_amplitude() -> impl Strategy<Value = Amplitude> {
    (Amplitude::MIN.units()..=Amplitude::MAX.units()).prop_map(|units| Amplitude::from_units(units).unwrap())
}

fn any_command() -> impl Strategy<Value = Command> {
    prop_oneof![
        (any::<Option<u8>>(), prop::option::of(any_amplitude())).prop_map(|(frames, amplitude)| {
            Command::Walk {
                amplitude,
                frames: frames.map(|f| if f == 255 { u32::MAX } else { f.into() }),
                detached: frames.is_none_or(|f| f % 2 == 0),
                dry_run: frames.is_some_and(|f| f % 5 == 0),
            }
        }),
        Just(Command::Stop),
        any_amplitude().prop_map(Command::SetAmplitude),
        (0..4_u8).prop_map(|every_frames| Command::StreamTelemetry { every_frames }),
        Just(Command::ClearFault),
        (0..=Speed::MAX.units()).prop_map(|units| Command::SetSpeed(Speed::from_units(units).unwrap())),
        Just(Command::Stream),
        prop::collection::vec(any::<u8>(), 0..=64)
            .prop_map(|bytes| Command::Setpoints { data: Chunk::of(&bytes) }),
        prop::collection::vec(any::<[u8; 16]>(), 1..=4)
            .prop_map(|poses| Command::Setpoints { data: Chunk::of(&poses.concat()) }),
        (0..4_u8).prop_map(|slot| Command::StoredGait { slot }),
        (0..4_u8).prop_map(|slot| Command::SelectGait { slot }),
        (0..4_u8).prop_map(|slot| Command::EraseGait { slot }),
        // Within the servos' reach, so that whatever is beyond it is a finding.
        (any::<u8>(), prop_oneof![Just(0), 147..=515_u16, 4_096..=u16::MAX])
            .prop_map(|(channel, counts)| Command::Nudge { channel: channel % 10, counts }),
        Just(Command::CalibrationCommit),
        any::<u16>().prop_map(|len| Command::UploadBegin { len }),
        (any::<u16>(), prop::collection::vec(any::<u8>(), 0..=64))
            .prop_map(|(offset, data)| Command::UploadChunk { offset, data: Chunk::of(&data) }),
        (any_amplitude(), any::<bool>())
            .prop_map(|(amplitude, persist)| Command::UploadCommit { amplitude, persist }),
        (0..3_usize, any::<u16>()).prop_map(|(record, offset)| {
            let record = [Record::Gait, Record::Calibration, Record::LastTrial][record];
            Command::Read { record, offset: offset % 300 }
        }),
    ]
}

/// Any table that the robot accepts: fields in range, coefficients anything.
fn any_table() -> impl Strategy<Value = Box<GaitTable>> {
    let limit = 90 * Angle::UNITS_PER_DEG;
    let joint = (-limit..limit, -limit..limit, -limit..limit, any::<[i16; COEFFICIENT_COUNT]>()).prop_map(
        |(a, b, c, coefficients)| {
            let mut angles = [a, b, c];
            angles.sort_unstable();
            let [min, centre, max] = angles;
            JointCurve {
                centre: Angle::from_units(centre),
                min: Angle::from_units(min),
                max: Angle::from_units(max.max(min + 1)),
                coefficients: coefficients.map(Coefficient),
            }
        },
    );
    (prop::collection::vec(joint, JOINT_COUNT), 100_000..=60_000_000_u32).prop_map(|(joints, period_us)| {
        let joints = joints.try_into().expect("eight");
        Box::new(GaitTable { name: Name::new("hostile").unwrap(), period_us, unit: Angle::NEUTRAL, joints })
    })
}

/// Any calibration that keeps within [`REACH_COUNTS`].
fn any_calibration() -> impl Strategy<Value = Deed> {
    let joint = (any::<bool>(), any::<u16>(), 147..=515_u16, 147..=515_u16, 147..=515_u16);
    let joints = prop::collection::vec(joint, JOINT_COUNT);
    let board = (17..=152_u8, UNITY_GAIN_Q14 / 2..=UNITY_GAIN_Q14 / 2 * 3, 0..=16_000_u16, 0..=16_000_u16);
    (joints, board, 1..=3_150_u16, any::<u8>(), 0..8_u8).prop_map(
        |(joints, (prescale, shunt_gain_q14, a_mv, b_mv), overcurrent_ma, autostart_s, rotation)| {
            let joints = std::array::from_fn(|index| {
                let (reversed, scale_q20, a, b, c) = joints[index];
                let mut counts = [a, b, c];
                counts.sort_unstable();
                let [min_counts, neutral_counts, max_counts] = counts;
                let channel = (index as u8 + rotation) % 8;
                JointCalibration { channel, reversed, neutral_counts, scale_q20, min_counts, max_counts }
            });
            let board = BoardCalibration {
                prescale,
                oscillator_khz: 25_000,
                shunt_gain_q14,
                undervoltage_mv: a_mv.min(b_mv),
                start_mv: a_mv.max(b_mv),
                overcurrent_ma,
                autostart_s,
            };
            Deed::Calibrate(Box::new(joints), board)
        },
    )
}

fn any_deed() -> impl Strategy<Value = Deed> {
    prop_oneof![
        3 => prop::collection::vec(any::<u8>(), 1..=MAX_BODY_LEN).prop_map(Deed::Raw),
        8 => any_command().prop_map(Deed::Ask),
        2 => (any_table(), any::<bool>()).prop_map(|(table, persist)| Deed::Upload(table, persist)),
        1 => (prop::collection::vec(any::<[i8; JOINT_COUNT]>(), 2..=MAX_ROWS), 1..=u8::MAX, any::<bool>())
            .prop_map(|(rows, step, persist)| Deed::Sampled(rows, step, persist)),
        1 => any_calibration(),
        1 => Just(Deed::StopByte),
        2 => any::<bool>().prop_map(Deed::Button),
        1 => (0.0..12.0_f64, -1.0..3.5_f64).prop_map(|(bus_v, current_a)| Deed::Supply(bus_v, current_a)),
        2 => Just(Deed::Supply(5.0, 0.4)),
        1 => (0..1_024_usize, any::<u8>()).prop_map(|(at, byte)| Deed::Rot(at, byte)),
        1 => Just(Deed::PowerCycle),
        1 => prop_oneof![Just(Chip::ServoDriver), Just(Chip::PowerSensor)].prop_map(Deed::Unplug),
        2 => Just(Deed::Replug),
        1 => prop_oneof![Just(ResetCause::External), Just(ResetCause::Watchdog)].prop_map(Deed::Reset),
        4 => (0..90_u64).prop_map(Deed::Wait),
    ]
}

/// Sends bytes in pieces, refused or not.
fn offer(robot: &mut SimRobot, bytes: &[u8]) {
    robot.ask(Command::UploadBegin { len: bytes.len() as u16 });
    for (index, piece) in bytes.chunks(64).enumerate() {
        robot.ask(Command::UploadChunk { offset: (64 * index) as u16, data: Chunk::of(piece) });
    }
}

fn carry_out(mut robot: SimRobot, deed: Deed) -> SimRobot {
    match deed {
        Deed::Raw(body) => {
            send_raw(&mut robot, &body);
            robot.run_frames(3);
        }
        Deed::Ask(command) => {
            robot.ask(command);
        }
        Deed::Upload(table, persist) => {
            let mut buffer = [0; MAX_ENCODED_LEN];
            offer(&mut robot, table.encode(&mut buffer).expect("a valid table"));
            robot.ask(Command::UploadCommit { amplitude: Amplitude::MAX, persist });
        }
        Deed::Sampled(rows, step, persist) => {
            let (name, rows) = (Name::new("sampled").unwrap(), Rows::new(&rows).unwrap());
            let centres = [Angle::NEUTRAL; JOINT_COUNT];
            let table =
                SampledTable { name, period_us: 100_000, step, min_deg: -90, max_deg: 90, centres, rows };
            let mut buffer = [0; MAX_ENCODED_LEN];
            offer(&mut robot, table.encode(&mut buffer).expect("a valid table"));
            robot.ask(Command::UploadCommit { amplitude: Amplitude::MAX, persist });
        }
        Deed::Calibrate(joints, board) => {
            offer(&mut robot, Calibration::new(&joints, &board).bytes());
            robot.ask(Command::CalibrationCommit);
        }
        Deed::StopByte => {
            robot.send(&[STOP_BYTE]);
            robot.run_frames(2);
            assert!(!matches!(robot.state(), State::Entering | State::Walking | State::Stopping));
        }
        Deed::Button(is_down) => {
            robot.board.is_button_down = is_down;
            robot.run_frames(4);
        }
        Deed::Supply(bus_v, current_a) => robot.board.set_supply(bus_v, current_a),
        Deed::Rot(at, byte) => robot.board.memory_mut()[at] = byte,
        Deed::PowerCycle => robot = robot.power_cycle(),
        Deed::Unplug(chip) => robot.board.chips.unplug(chip),
        Deed::Replug => {
            for chip in Chip::ALL {
                robot.board.chips.replug(chip);
            }
        }
        Deed::Reset(cause) => robot = robot.reset(cause),
        Deed::Wait(frames) => robot.run_frames(frames),
    }
    robot
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, rng_seed: RngSeed::Fixed(11), ..ProptestConfig::default() })]

    #[test]
    fn no_order_of_intact_requests_takes_the_robot_out_of_control(
        deeds in prop::collection::vec(any_deed(), 1..24)
    ) {
        let mut robot = SimRobot::playing(&fixtures::trot(), amplitude(2.2));
        for deed in deeds {
            robot = carry_out(robot, deed);
            // Out of reach a servo driver goes on as it was told last.
            let in_reach = robot.board.chips.start(Chip::ServoDriver.address(), false, robot.board.now_s());
            robot.board.chips.stop(robot.board.now_s());
            if in_reach {
                assert_in_charge(&mut robot);
            }
        }
    }
}
