//! A pulse on one output alone, for calibration.

use protocol::{Command, Fault, JOINT_COUNT, LINK_TIMEOUT_FRAMES, Refusal, Reply, State};
use sim_tests::devices::Chip;
use sim_tests::fixtures::{self, amplitude};
use sim_tests::sim_robot::SimRobot;
use sim_tests::sim_robot::ask::{WALK, rehearse_for};
use sim_tests::sim_robot::pulses::servos_off;

const fn nudge(channel: u8, counts: u16) -> Command {
    Command::Nudge { channel, counts }
}

fn ready() -> SimRobot {
    let mut robot = SimRobot::new();
    robot.upload(&fixtures::trot(), amplitude(1.0), false);
    robot
}

#[test]
fn one_output_gets_exactly_its_pulse_and_all_others_stay_limp() {
    let mut robot = ready();
    for (channel, counts) in [(0, 330), (7, 147), (3, 515), (3, 1), (4, 4_095)] {
        robot.expect_done(nudge(channel, counts));
        robot.run_frames(2);

        let mut expected = [None; JOINT_COUNT];
        expected[usize::from(channel)] = Some(counts);
        assert_eq!(robot.pulses_over(2).last(), Some(&expected));
        assert_eq!(robot.state(), State::Holding);
        assert!(robot.board.outputs_enabled());
    }
}

#[test]
fn no_counts_end_it() {
    let mut robot = ready();
    robot.expect_done(nudge(2, 400));
    robot.run_frames(3);

    robot.expect_done(nudge(5, 0));
    robot.run_frames(2);

    assert_eq!(robot.state(), State::Idle);
    assert!(robot.pulses_over(2).iter().all(servos_off));
    assert!(!robot.board.outputs_enabled());
}

#[test]
fn it_ends_after_a_second_without_a_host_and_not_before() {
    let mut robot = ready();
    robot.expect_done(nudge(2, 400));
    for _ in 0..20 {
        robot.run_frames(u64::from(LINK_TIMEOUT_FRAMES) / 2);
        assert_eq!(robot.status().state, State::Holding, "a host that asks anything keeps it");
    }

    robot.run_frames(u64::from(LINK_TIMEOUT_FRAMES) - 3);
    let before = robot.state();
    robot.run_frames(4);

    assert_eq!((before, robot.state()), (State::Holding, State::Idle));
    robot.run_frames(1);
    assert!(robot.pulses_over(2).iter().all(servos_off));
    assert!(robot.walk_ends().is_empty(), "it is no walk");
    assert_eq!(robot.last_trial(), None);
}

#[test]
fn a_stop_ends_it() {
    let mut robot = ready();
    robot.expect_done(nudge(2, 400));
    robot.run_frames(3);

    robot.expect_done(Command::Stop);
    robot.run_frames(2);

    assert_eq!(robot.state(), State::Idle);
    assert!(robot.pulses_over(2).iter().all(servos_off));
}

#[test]
fn outputs_and_pulses_out_of_range_are_refused_and_change_nothing() {
    let mut robot = ready();
    robot.expect_done(nudge(2, 400));
    for (channel, counts) in [(8, 330), (255, 330), (0, 4_096), (0, u16::MAX)] {
        assert_eq!(robot.ask(nudge(channel, counts)), Reply::Refused(Refusal::Range));
    }
    robot.run_frames(2);

    let mut expected = [None; JOINT_COUNT];
    expected[2] = Some(400);
    assert_eq!(robot.pulses_over(2).last(), Some(&expected));
}

#[test]
fn it_is_refused_during_a_walk_and_a_walk_during_it() {
    let mut robot = ready();
    robot.expect_done(nudge(0, 330));
    assert_eq!(robot.ask(WALK), Reply::Refused(Refusal::AlreadyWalking));
    assert_eq!(robot.ask(Command::Stream), Reply::Refused(Refusal::AlreadyWalking));
    robot.expect_done(nudge(0, 0));
    let on = Reply::Refused(Refusal::ServosOn);
    for walk in [WALK, rehearse_for(600), Command::Stream] {
        robot.expect_done(walk);
        assert_eq!(robot.ask(nudge(0, 330)), on);
        robot.run_frames(3);
        assert_eq!(robot.ask(nudge(0, 330)), on);
        robot.expect_done(Command::Stop);
        robot.run_until(State::Idle);
    }

    robot.expect_done(nudge(0, 330));
}

#[test]
fn it_needs_supply_chips_and_no_fault_as_a_walk_does() {
    let mut low = ready();
    low.board.set_supply(3.9, 0.0);
    low.run_frames(3);
    assert!(matches!(low.ask(nudge(0, 330)), Reply::Refused(Refusal::SupplyTooLow { .. })));

    let mut missing = ready();
    missing.board.chips.unplug(Chip::ServoDriver);
    assert_eq!(missing.ask(nudge(0, 330)), Reply::Refused(Refusal::ChipMissing(Fault::ServoDriverLost)));
    assert_eq!(missing.state(), State::Idle);

    let mut robot = ready();
    robot.expect_done(nudge(0, 330));
    robot.run_frames(3);
    robot.board.set_supply(3.9, 0.0);
    robot.run_frames(10);
    assert_eq!(robot.state(), State::Fault(Fault::Undervoltage));
    assert!(!robot.board.chips.servo_driver.drives_any());
    assert_eq!(robot.ask(nudge(0, 330)), Reply::Refused(Refusal::Faulted(Fault::Undervoltage)));
}

#[test]
fn a_detached_walk_before_it_does_not_free_it_from_its_host() {
    let mut robot = ready();
    robot.expect_done(WALK);
    robot.run_frames(10);
    robot.expect_done(Command::Stop);
    robot.run_until(State::Idle);
    robot.expect_done(nudge(1, 330));

    robot.run_frames(u64::from(LINK_TIMEOUT_FRAMES) + 2);

    assert_eq!(robot.state(), State::Idle);
}
