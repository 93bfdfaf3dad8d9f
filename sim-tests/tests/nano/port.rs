//! What the port's handlers do with single bytes, and what the robot counts.

use super::stack::untouched;
use super::support::*;
use protocol::command::Storage;
use protocol::frame::{self, MAX_FRAME_LEN, Request, STOP_BYTE};
use protocol::{Command, Event, Message, State, WalkEnd};
use sim_tests::client::Client;
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::virtual_robot::VirtualRobot;

const WALK: Command = Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false };

fn walking() -> (VirtualRobot, Client) {
    let (mut robot, mut client) = on_the_bench();
    client.upload(&mut robot, &fixtures::trot().table(), amplitude(1.0), false).unwrap();
    client.expect_done(&mut robot, WALK).unwrap();
    wait_for(&mut robot, &mut client, State::Walking, 5.0);
    client.run_for(&mut robot, 0.05).unwrap();
    (robot, client)
}

fn framed(seq: u8, command: Command) -> Vec<u8> {
    let mut buffer = [0; MAX_FRAME_LEN];
    frame::encode(&Request { seq, command }, &mut buffer).unwrap().to_vec()
}

#[test]
fn a_stop_byte_in_the_middle_of_a_frame_stops_the_walk_and_leaves_the_frame_whole() {
    let (mut robot, mut client) = walking();
    client.forget();
    let bytes = framed(200, Command::SetAmplitude(amplitude(1.5)));
    let (head, tail) = bytes.split_at(bytes.len() / 2);

    for piece in [head, &[STOP_BYTE], tail] {
        robot.nano_mut().send(piece);
    }
    client.run_for(&mut robot, 0.5).unwrap();

    let ended = |message: &Message| matches!(message, Message::Event(Event::WalkEnded(WalkEnd::StopByte)));
    assert!(client.heard().iter().any(|(_, message)| ended(message)), "{:?}", client.heard());
    let answered = |message: &Message| matches!(message, Message::Reply { seq: 200, .. });
    assert!(client.heard().iter().any(|(_, message)| answered(message)), "the frame around it is answered");
    let status = status(&mut robot, &mut client);
    assert!(!matches!(status.state, State::Walking | State::Entering), "{:?}", status.state);
    assert_eq!((status.bad_frames, status.dropped_bytes), (0, 0));
}

/// Answers leave no faster than the line carries them, and until they have
/// left, requests wait in a ring of 63 bytes.
#[test]
fn bytes_that_find_no_room_are_counted_and_the_walk_goes_on() {
    let (mut robot, mut client) = walking();

    for seq in 0..100 {
        robot.nano_mut().send(&framed(seq, Command::Status));
    }
    client.run_for(&mut robot, 1.0).unwrap();
    // The rest of a broken frame takes the next one with it, unless that is ended first.
    robot.nano_mut().send(&[0]);

    let status = status(&mut robot, &mut client);
    println!("{} bytes dropped, {} frames broken", status.dropped_bytes, status.bad_frames);
    assert!((100..1_000).contains(&status.dropped_bytes), "{} bytes", status.dropped_bytes);
    assert!(status.bad_frames > 0, "what is left of a frame is none");
    assert_eq!(status.state, State::Walking);
}

#[test]
fn transfers_that_fail_are_counted_nine_readings_a_frame() {
    let (mut robot, mut client) = walking();
    let before = status(&mut robot, &mut client).bus_errors;

    robot.nano_mut().bus_mut().unplug(Chip::PowerSensor);
    client.run_for(&mut robot, 3.0 / 60.0).unwrap();
    robot.nano_mut().bus_mut().replug(Chip::PowerSensor);
    client.run_for(&mut robot, 0.1).unwrap();

    let status = status(&mut robot, &mut client);
    assert_eq!(before, 0);
    assert!((26..=29).contains(&status.bus_errors), "{} errors", status.bus_errors);
    assert_eq!(status.state, State::Walking);
}

#[test]
fn the_robot_counts_the_stack_that_it_never_used_as_it_is_in_its_memory() {
    let (mut robot, mut client) = walking();
    client.upload(&mut robot, &fixtures::medley().table(), amplitude(1.0), true).unwrap();
    while status(&mut robot, &mut client).storage == Storage::Saving {
        client.run_for(&mut robot, 0.1).unwrap();
    }
    // It looks four times a second.
    client.run_for(&mut robot, 0.5).unwrap();

    let told = usize::from(status(&mut robot, &mut client).stack_left);

    assert_eq!(told, untouched(robot.nano().sram()));
}
