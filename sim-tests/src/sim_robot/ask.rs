//! What a bench asks for again and again, in one call each.
//!
//! Holds short names for whole conversations. An answer other than the expected one
//! is a panic that shows it. Does not depend on the chips.

use super::SimRobot;
use protocol::calibration::CalibrationError;
use protocol::command::{Record, StoredGait};
use protocol::{Amplitude, Calibration, Chunk, Command, JOINT_COUNT, Refusal, Reply, TrialRecord, WalkEnd};

/// A walk without end that needs no host.
pub const WALK: Command = Command::Walk { amplitude: None, frames: None, detached: true, dry_run: false };
/// A walk without end that depends on its host.
pub const ATTACHED_WALK: Command =
    Command::Walk { amplitude: None, frames: None, detached: false, dry_run: false };

/// A walk of so many frames that needs no host.
#[must_use]
pub const fn walk_for(frames: u32) -> Command {
    Command::Walk { amplitude: None, frames: Some(frames), detached: true, dry_run: false }
}

/// A rehearsal of so many frames.
#[must_use]
pub const fn rehearse_for(frames: u32) -> Command {
    Command::Walk { amplitude: None, frames: Some(frames), detached: true, dry_run: true }
}

/// Setpoints of a stream, in degrees.
#[must_use]
pub fn setpoints(poses_deg: &[[f64; JOINT_COUNT]]) -> Command {
    let units = poses_deg.iter().flatten().map(|deg| (deg * 256.0).round() as i16);
    let bytes: Vec<u8> = units.flat_map(i16::to_le_bytes).collect();
    Command::Setpoints { data: Chunk::of(&bytes) }
}

impl SimRobot {
    /// Asks until the memory has time for the answer.
    pub fn ask_patiently(&mut self, command: Command) -> Reply {
        loop {
            match self.ask(command) {
                Reply::Refused(Refusal::StorageBusy) => self.run_frames(1),
                reply => return reply,
            }
        }
    }

    /// A record, piece by piece.
    ///
    /// # Panics
    /// If the robot answers anything else.
    pub fn read_record(&mut self, record: Record) -> Vec<u8> {
        let mut bytes = Vec::new();
        loop {
            let offset = bytes.len() as u16;
            match self.ask_patiently(Command::Read { record, offset }) {
                Reply::Piece(chunk) if chunk.as_slice().is_empty() => return bytes,
                Reply::Piece(chunk) => bytes.extend_from_slice(chunk.as_slice()),
                other => panic!("a piece of {record:?} was asked for, not {other:?}"),
            }
        }
    }

    /// The last trial, if there is one.
    ///
    /// # Panics
    /// If the robot's record is none.
    pub fn last_trial(&mut self) -> Option<TrialRecord> {
        let bytes = self.read_record(Record::LastTrial);
        (!bytes.is_empty()).then(|| TrialRecord::from_bytes(&bytes).expect("a trial"))
    }

    /// What is in a place for gaits.
    ///
    /// # Panics
    /// If the robot answers anything else.
    pub fn stored_gait(&mut self, slot: u8) -> Option<StoredGait> {
        match self.ask_patiently(Command::StoredGait { slot }) {
            Reply::Stored(stored) => stored,
            other => panic!("a stored gait was asked for, not {other:?}"),
        }
    }

    /// Sends a calibration; returns the answer to its commit.
    pub fn send_calibration(&mut self, calibration: &Calibration) -> Reply {
        self.send_pieces(calibration.bytes());
        self.ask(Command::CalibrationCommit)
    }

    /// A robot with this calibration, as it is used and saved.
    ///
    /// # Panics
    /// If the robot refuses it.
    pub fn calibrate(&mut self, calibration: &Calibration) {
        assert_eq!(self.send_calibration(calibration), Reply::Done);
        self.run_frames(40);
    }

    /// The robot's calibration.
    ///
    /// # Errors
    /// If the robot's record is none.
    pub fn calibration(&mut self) -> Result<Calibration, CalibrationError> {
        Calibration::from_bytes(&self.read_record(Record::Calibration))
    }

    /// How walks ended, in order.
    #[must_use]
    pub fn walk_ends(&self) -> Vec<WalkEnd> {
        self.events()
            .filter_map(|event| match event {
                protocol::Event::WalkEnded(end) => Some(end),
                _ => None,
            })
            .collect()
    }

    /// Frames until the robot is in another state than `state`.
    ///
    /// # Panics
    /// If that takes more than 20 s.
    pub fn frames_in(&mut self, state: protocol::State) -> u64 {
        let from = self.board.frames();
        while self.state() == state {
            self.run_frames(1);
            assert!(self.board.frames() < from + 1_200, "still {state:?} after 20 s");
        }
        self.board.frames() - from
    }

    /// Uploads a gait to keep it, and waits until it is kept.
    ///
    /// # Panics
    /// If the robot refuses it.
    pub fn keep(&mut self, gait: &crate::fixtures::Gait, amplitude: Amplitude) {
        self.upload(gait, amplitude, true);
        self.run_frames(90);
    }
}
