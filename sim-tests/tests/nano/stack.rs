//! How deep the stack gets: one that runs into data is silent on an AVR.

use super::support::*;
use protocol::command::Record;
use protocol::{Chunk, Command, Fault, GaitTable, Refusal, Reply, State};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};

/// What the firmware paints unused memory with at start-up (`stack.rs`).
const PAINT: u8 = 0xC5;
/// Bytes that must never be touched: an interrupt's frame and then some.
const SPARE_BYTES: usize = 96;

/// Bytes between data and stack that were never used.
pub fn untouched(sram: &[u8]) -> usize {
    sram.split(|&byte| byte != PAINT).map(<[u8]>::len).max().unwrap_or(0)
}

#[test]
fn the_deepest_stack_stays_clear_of_the_data() {
    let (mut robot, mut client) = on_the_bench();
    let table = fixtures::medley().table();
    let fresh = untouched(robot.nano().sram());

    // Every command, both faults, a table refused at its last joint, a save
    // while walking, telemetry in every frame.
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), true).unwrap();
    client.expect_done(&mut robot, Command::StreamTelemetry { every_frames: 1 }).unwrap();
    client
        .expect_done(
            &mut robot,
            Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false },
        )
        .unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);
    client.run_for(&mut robot, 1.5).unwrap();
    client.upload(&mut robot, &table, amplitude(2.2), true).unwrap();
    client.ask(&mut robot, hello()).unwrap();
    for offset in [0, 64, 128, 192] {
        client.ask(&mut robot, Command::Read { record: Record::Gait, offset }).unwrap();
    }
    client.expect_done(&mut robot, Command::SetAmplitude(amplitude(1.5))).unwrap();
    client.run_for(&mut robot, 1.5).unwrap();
    refuse_a_bad_table(&mut robot, &mut client, &table);
    for (chip, fault) in [(Chip::PowerSensor, Fault::SensorLost), (Chip::ServoDriver, Fault::ServoDriverLost)]
    {
        robot.nano_mut().bus_mut().unplug(chip);
        wait_for(&mut robot, &mut client, State::Fault(fault), 3.0);
        let walk = Command::Walk { amplitude: None, frames: Some(30), detached: true, dry_run: false };
        client.ask(&mut robot, Command::ClearFault).unwrap();
        client.ask(&mut robot, walk).unwrap();
        robot.nano_mut().bus_mut().replug(chip);
        client.expect_done(&mut robot, Command::ClearFault).unwrap();
        client.expect_done(&mut robot, walk).unwrap();
    }
    client.expect_done(&mut robot, Command::Stop).unwrap();
    client.run_for(&mut robot, 1.5).unwrap();

    let left = untouched(robot.nano().sram());
    println!("{left} of {fresh} painted bytes were never used");
    assert!(fresh < 1_000 && left < fresh, "{left} of {fresh} bytes: is this the paint?");
    assert!(left >= SPARE_BYTES, "{left} bytes between the deepest stack and the data");
}

fn refuse_a_bad_table(
    robot: &mut sim_tests::virtual_robot::VirtualRobot,
    client: &mut sim_tests::client::Client,
    good: &GaitTable,
) {
    let mut buffer = [0; protocol::gait::MAX_ENCODED_LEN];
    let len = good.encode(&mut buffer).unwrap().len();
    // The last joint's limits, two bytes each before its coefficients.
    let joint_len = 6 + 2 * protocol::gait::COEFFICIENT_COUNT;
    let (body, crc) = buffer[..len].split_at_mut(len - 4);
    let limits = body.len() - joint_len + 2;
    body[limits..limits + 4].copy_from_slice(&[0xFF, 0x7F, 0, 0x80]);
    crc.copy_from_slice(&protocol::crc::crc32(body).to_le_bytes());
    client.expect_done(robot, Command::UploadBegin { len: len as u16 }).unwrap();
    for (index, piece) in buffer[..len].chunks(64).enumerate() {
        let offset = (64 * index) as u16;
        client.expect_done(robot, Command::UploadChunk { offset, data: Chunk::of(piece) }).unwrap();
    }
    let commit = Command::UploadCommit { amplitude: amplitude(1.0), persist: false };
    let reply = client.ask(robot, commit).unwrap();
    let joint = protocol::gait::GaitError::JointLimits(7);
    assert_eq!(reply, Reply::Refused(Refusal::BadGait(joint)));
}
