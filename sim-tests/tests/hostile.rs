//! Requests that pass every checksum and mean harm, or nothing at all.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use protocol::frame::{self, MAX_BODY_LEN, MAX_FRAME_LEN};
use protocol::gait::{COEFFICIENT_COUNT, Coefficient, MAX_ENCODED_LEN};
use protocol::{
    Amplitude, Angle, Chunk, Command, GaitTable, JOINT_COUNT, JointCurve, Name, ResetCause, State,
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

/// 330 counts at neutral and 5/3 a degree: no table's limits lie beyond 90 degrees.
const REACH_COUNTS: std::ops::RangeInclusive<u16> = 330 - 150..=330 + 150;

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
            assert!(!robot.board.chips.pca9685.drives_any(), "servos on in {state:?}");
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
        any::<u16>().prop_map(|len| Command::UploadBegin { len }),
        (any::<u16>(), prop::collection::vec(any::<u8>(), 0..=64))
            .prop_map(|(offset, data)| Command::UploadChunk { offset, data: Chunk::of(&data) }),
        (any_amplitude(), any::<bool>())
            .prop_map(|(amplitude, persist)| Command::UploadCommit { amplitude, persist }),
        any::<u16>().prop_map(|offset| Command::Read { record: protocol::command::Record::Gait, offset }),
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

fn any_deed() -> impl Strategy<Value = Deed> {
    prop_oneof![
        3 => prop::collection::vec(any::<u8>(), 1..=MAX_BODY_LEN).prop_map(Deed::Raw),
        8 => any_command().prop_map(Deed::Ask),
        2 => (any_table(), any::<bool>()).prop_map(|(table, persist)| Deed::Upload(table, persist)),
        1 => prop_oneof![Just(Chip::Pca9685), Just(Chip::Ina219)].prop_map(Deed::Unplug),
        2 => Just(Deed::Replug),
        1 => prop_oneof![Just(ResetCause::External), Just(ResetCause::Watchdog)].prop_map(Deed::Reset),
        4 => (0..90_u64).prop_map(Deed::Wait),
    ]
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
            let bytes = table.encode(&mut buffer).expect("a valid table").to_vec();
            robot.ask(Command::UploadBegin { len: bytes.len() as u16 });
            for (index, piece) in bytes.chunks(64).enumerate() {
                robot.ask(Command::UploadChunk { offset: (64 * index) as u16, data: Chunk::of(piece) });
            }
            robot.ask(Command::UploadCommit { amplitude: Amplitude::MAX, persist });
        }
        Deed::Unplug(chip) => robot.board.chips.unplug(chip),
        Deed::Replug => {
            for chip in [Chip::Pca9685, Chip::Ina219] {
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
            let in_reach = robot.board.chips.start(sim_tests::devices::PCA9685_ADDRESS, false, robot.board.now_s());
            robot.board.chips.stop(robot.board.now_s());
            if in_reach {
                assert_in_charge(&mut robot);
            }
        }
    }
}
