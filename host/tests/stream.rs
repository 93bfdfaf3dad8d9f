//! Setpoints to a robot that buffers a few of them, and fails on request; in real
//! time, for pace is what this is about.

mod fake_robot;

use fake_robot::{FakeRobot, Pose, Troubles};
use host::device::link::{Link, Timeouts};
use host::device::stream::{PoseDeg, stream};
use host::device::trial::{Trial, TrialStop};
use protocol::{Command, Fault, State, WalkEnd};
use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Result, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

const TIMEOUTS: Timeouts = Timeouts {
    settle: Duration::from_millis(2),
    hello_every: Duration::from_millis(40),
    hello_for: Duration::from_millis(200),
    reply: Duration::from_millis(40),
    attempts: 6,
    busy_for: Duration::from_millis(100),
    busy_every: Duration::from_millis(1),
};

/// The robot plays 60 frames a second by the clock on the wall, but for moments
/// in which a busy machine runs something else: those are not what is tested.
struct Paced<'a> {
    robot: &'a mut FakeRobot,
    looked: Instant,
    age: Duration,
    frames: u128,
    said: VecDeque<u8>,
    /// An adapter that hands on what it has got only so often.
    hands_on_every: Duration,
    handed_on: Duration,
}

impl<'a> Paced<'a> {
    fn new(robot: &'a mut FakeRobot) -> Self {
        Self {
            robot,
            looked: Instant::now(),
            age: Duration::ZERO,
            frames: 0,
            said: VecDeque::new(),
            hands_on_every: Duration::ZERO,
            handed_on: Duration::ZERO,
        }
    }

    fn keep_up(&mut self) {
        self.age += self.looked.elapsed().min(Duration::from_millis(3));
        self.looked = Instant::now();
        while self.frames < self.age.as_micros() * 60 / 1_000_000 {
            self.robot.frame();
            self.frames += 1;
        }
    }
}

impl Read for Paced<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        self.keep_up();
        if self.age >= self.handed_on + self.hands_on_every {
            self.handed_on = self.age;
            self.said.extend(self.robot.take_said());
        }
        if self.said.is_empty() {
            std::thread::sleep(Duration::from_millis(1));
            return Err(ErrorKind::TimedOut.into());
        }
        self.said.read(buffer)
    }
}

impl Write for Paced<'_> {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.keep_up();
        self.robot.write(bytes)
    }

    fn flush(&mut self) -> Result<()> {
        Ok(())
    }
}

/// hip1 climbs by 1/256 degree a frame, so that each pose tells its number.
fn numbered(count: usize) -> impl Iterator<Item = PoseDeg> {
    (0..count).map(|number| {
        let mut pose = [0.0; 8];
        pose[0] = number as f64 / 256.0;
        pose[7] = -20.0;
        pose
    })
}

fn play(robot: &mut FakeRobot, poses: impl Iterator<Item = PoseDeg>) -> Trial {
    let mut link = Link::connect(Paced::new(robot), "the robot", TIMEOUTS).unwrap();
    stream(&mut link, poses, &AtomicBool::new(false), |_: State, _: u32| {}).unwrap()
}

#[track_caller]
fn assert_played_in_order(played: &[Pose]) {
    for (number, pose) in played.iter().enumerate() {
        assert_eq!((pose[0], pose[7]), (number as i16, -5120), "frame {number}");
    }
}

#[test]
fn every_setpoint_is_played_once_and_in_order_and_the_robot_is_stopped_after() {
    let mut robot = FakeRobot::new(Troubles::default());

    let trial = play(&mut robot, numbered(90));

    assert!(trial.stop.is_none(), "{:?}", trial.stop);
    assert_played_in_order(&robot.played);
    // This robot counts a pose when it takes it, real ones a frame later: it is stopped early.
    assert!(robot.played.len() >= 88, "{}", robot.played.len());
    assert!(trial.frames() >= 88, "{}", trial.frames());
    assert!((trial.energy_j() - f64::from(trial.frames()) * 0.015).abs() < 1e-9);
    assert_eq!(robot.state, State::Holding);
    let last = robot.done.iter().rev().find(|command| !matches!(command, Command::StreamTelemetry { .. }));
    assert_eq!(last, Some(&Command::Stop));
}

fn sizes(robot: &FakeRobot) -> Vec<usize> {
    let size = |command: &Command| match command {
        Command::Setpoints { data } => Some(data.as_slice().len() / 16),
        _ => None,
    };
    robot.done.iter().filter_map(size).collect()
}

#[test]
fn setpoints_travel_one_by_one_over_a_fast_adapter() {
    let mut robot = FakeRobot::new(Troubles::default());

    play(&mut robot, numbered(60));

    assert!(sizes(&robot).iter().all(|&size| size == 1), "{:?}", sizes(&robot));
}

/// FTDI's latency timer: what the robot says waits for up to 16 ms.
#[test]
fn setpoints_travel_in_pairs_over_a_slow_adapter_and_none_is_late() {
    let mut robot = FakeRobot::new(Troubles::default());
    let adapter = Paced { hands_on_every: Duration::from_millis(16), ..Paced::new(&mut robot) };
    let mut link = Link::connect(adapter, "the robot", TIMEOUTS).unwrap();

    let trial = stream(&mut link, numbered(120), &AtomicBool::new(false), |_: State, _: u32| {}).unwrap();

    drop(link);
    assert!(trial.stop.is_none(), "{:?}", trial.stop);
    assert_played_in_order(&robot.played);
    assert!(sizes(&robot).contains(&2), "{:?}", sizes(&robot));
}

#[test]
fn a_noisy_cable_loses_and_repeats_no_setpoint() {
    let mut robot =
        FakeRobot::new(Troubles { loses_every: Some(17), flips_every: Some(3001), ..Default::default() });

    let trial = play(&mut robot, numbered(90));

    // Waiting for lost answers takes the robot's time: it may run dry, but never skips.
    assert_played_in_order(&robot.played);
    assert!(trial.stop.is_none() || matches!(trial.stop, Some(TrialStop::Ended { .. })), "{:?}", trial.stop);
}

#[test]
fn a_stream_that_runs_dry_is_an_error_with_the_frames_that_were_played() {
    let mut robot = FakeRobot::new(Troubles { runs_dry_at: Some(50), ..Default::default() });

    let trial = play(&mut robot, numbered(90));

    let stop = trial.stop.unwrap();
    assert!(matches!(stop, TrialStop::Ended { end: WalkEnd::StreamDry, frames: 50, .. }), "{stop:?}");
    assert!(stop.to_string().contains("50 gait frames: the next setpoint did not arrive in time"), "{stop}");
}

#[test]
fn a_fault_in_mid_stream_is_named() {
    let mut robot = FakeRobot::new(Troubles { faults_at: Some(50), ..Default::default() });

    let trial = play(&mut robot, numbered(90));

    assert!(matches!(trial.stop, Some(TrialStop::Fault { fault: Fault::SensorLost })), "{:?}", trial.stop);
}

#[test]
fn an_interrupted_stream_stops_the_robot_at_once() {
    let mut robot = FakeRobot::new(Troubles::default());
    let stop = AtomicBool::new(false);
    let mut link = Link::connect(Paced::new(&mut robot), "the robot", TIMEOUTS).unwrap();

    let trial = stream(&mut link, numbered(90), &stop, |_: State, played: u32| {
        if played == 40 {
            stop.store(true, Ordering::Relaxed);
        }
    })
    .unwrap();

    drop(link);
    assert!(matches!(trial.stop, Some(TrialStop::Interrupted)), "{:?}", trial.stop);
    assert_eq!((robot.state, robot.stop_bytes), (State::Holding, 1));
}

#[test]
fn nothing_to_play_and_a_single_pose_end_as_well() {
    for count in [0, 1, 3] {
        let mut robot = FakeRobot::new(Troubles::default());

        let trial = play(&mut robot, numbered(count));

        assert!(trial.stop.is_none(), "{count}: {:?}", trial.stop);
        assert_eq!(robot.state, State::Holding, "{count}");
    }
}
