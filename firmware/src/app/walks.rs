//! Walks: how they begin, what they depend on, how they end, what stays of them.
//!
//! Holds the rules. Whatever ends a walk leaves a reason: sent at once, and kept
//! with the trial. Does not depend on the motion, which is in [`crate::player`].

use protocol::command::CalibrationSource;
use protocol::gait::Product;
use protocol::trial::TRIAL_LEN;
use protocol::{Amplitude, Event, FRAME_RATE_HZ, LINK_TIMEOUT_FRAMES, Refusal, TrialRecord, WalkEnd};

use super::{App, Ended};
use crate::hal::{Board, Panel};
use crate::limits::BUTTON_FRAMES;
use crate::player::{Frame, Mode, Outcome};
use crate::power::Trial;
use crate::store::Kind;

/// Walks until the button is pressed again.
const AUTOSTART_ENDLESS: u8 = u8::MAX;

/// What a walk is to be.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walk {
    pub amplitude: Option<Amplitude>,
    pub frames: Option<u32>,
    pub detached: bool,
    pub dry_run: bool,
}

impl App {
    /// Enters the active gait.
    ///
    /// # Errors
    /// Why it does not; then nothing has changed.
    #[inline(never)]
    pub(super) fn walk(&mut self, board: &mut impl Board, walk: Walk) -> Result<(), Refusal> {
        self.require_rest()?;
        if walk.dry_run && self.staged.servos_on {
            // Standing, it would go limp.
            return Err(Refusal::ServosOn);
        }
        if self.gait.bytes().is_empty() {
            return Err(Refusal::NoGait);
        }
        let amplitude = walk.amplitude.unwrap_or(self.amplitude);
        if !amplitude.is_valid() {
            return Err(Refusal::Amplitude);
        }
        self.prepare(board)?;
        self.detached = walk.detached;
        self.dry_run = walk.dry_run;
        self.player.walk(&self.gait, amplitude, walk.frames);
        Ok(())
    }

    /// Waits for setpoints.
    ///
    /// # Errors
    /// As [`Self::walk`].
    pub(super) fn stream(&mut self, board: &mut impl Board) -> Result<(), Refusal> {
        self.require_rest()?;
        self.prepare(board)?;
        self.detached = false;
        self.dry_run = false;
        self.upload.begin_stream();
        self.player.stream();
        Ok(())
    }

    /// Makes sure that there is no fault and the robot does not move.
    fn require_rest(&self) -> Result<(), Refusal> {
        if let Some(fault) = self.fault {
            return Err(Refusal::Faulted(fault));
        }
        if self.player.is_walking() || self.nudge.is_some() {
            return Err(Refusal::AlreadyWalking);
        }
        Ok(())
    }

    /// Looks at supply and chips, and makes room for a new trial.
    fn prepare(&mut self, board: &mut impl Board) -> Result<(), Refusal> {
        if self.calibration_source == CalibrationSource::Damaged {
            return Err(Refusal::CalibrationDamaged);
        }
        self.require_supply()?;
        self.configure_chips(board).map_err(Refusal::ChipMissing)?;
        // What is still on its way to the servos belongs to the walk before.
        (self.live.gait, self.staged.gait) = (false, false);
        self.conclude();
        self.store.forget_trial();
        self.trial = Trial::NONE;
        (self.ended, self.trial_due) = (None, false);
        Ok(())
    }

    /// Computes the coming frame.
    pub(super) fn advance<P: Product>(&mut self) {
        if self.nudge.is_some() {
            self.staged = Frame { servos_on: true, ..Frame::LIMP };
            return;
        }
        let (mut frame, outcome) = self.player.step::<P>(&self.gait, &mut self.upload, self.staged.servos_on);
        match outcome {
            Outcome::Goes => {}
            Outcome::Finished => self.ending = Some(WalkEnd::Finished),
            Outcome::Dry => self.ending = Some(WalkEnd::StreamDry),
        }
        frame.servos_on &= !self.dry_run;
        self.staged = frame;
    }

    /// Stops with a way to a stand.
    #[inline(never)]
    pub(super) fn stop(&mut self, end: WalkEnd) {
        if self.player.is_walking() {
            self.ending = Some(end);
            self.player.stop();
        }
        self.let_go();
    }

    /// Stops where it is.
    #[inline(never)]
    pub(super) fn halt(&mut self, end: WalkEnd) {
        if self.player.is_walking() {
            self.ending = Some(end);
        }
        self.player.freeze();
        self.let_go();
    }

    /// Ends a nudge, and what has no pulses yet: no stop may switch servos on.
    fn let_go(&mut self) {
        self.nudge = None;
        if !self.staged.servos_on {
            self.player.go_limp();
        }
    }

    /// Stops an attached walk, or a nudge, whose host has been silent for too long.
    pub(super) fn depend_on_link(&mut self, frames: u8) {
        self.silent_frames = self.silent_frames.saturating_add(frames);
        if !self.detached && self.silent_frames >= LINK_TIMEOUT_FRAMES {
            // Where it is: a robot that is not watched should take no further step.
            self.halt(WalkEnd::LinkLost);
        }
    }

    /// A press stops what moves, and starts what rests if that was asked for.
    pub(super) fn watch_button(&mut self, board: &mut impl Board) {
        let is_down = board.panel().is_button_pressed();
        self.button_frames = if is_down == self.is_button_down { 0 } else { self.button_frames + 1 };
        if self.button_frames < BUTTON_FRAMES {
            return;
        }
        self.button_frames = 0;
        self.is_button_down = is_down;
        if !is_down {
            return;
        }
        if self.nudge.is_some() || self.player.mode() != Mode::Limp {
            self.halt(WalkEnd::Button);
            return;
        }
        let seconds = self.calibration.board().autostart_s;
        if seconds > 0 {
            let frames = u32::from(seconds) * FRAME_RATE_HZ;
            let frames = (seconds != AUTOSTART_ENDLESS).then_some(frames);
            // Nobody is there to hear a refusal; the light keeps winking.
            let _ = self.walk(board, Walk { amplitude: None, frames, detached: true, dry_run: false });
        }
    }

    /// Reports that a walk is over, once its last frame has been counted.
    pub(super) fn conclude(&mut self) {
        if self.live.gait {
            return;
        }
        let Some(end) = self.ending.take() else { return };
        if !matches!(end, WalkEnd::Fault(_)) {
            self.tell(Event::WalkEnded(end));
        }
        if self.trial.frames > 0 && !self.dry_run {
            let gait_crc32 = if self.player.streams() { 0 } else { self.gait.crc32() };
            self.ended = Some(Ended { end, amplitude: self.player.amplitude(), gait_crc32 });
            self.trial_due = true;
        }
    }

    /// Starts to save the trial that has ended, once the memory is free.
    pub(super) fn save_trial(&mut self, board: &mut impl Board) {
        if self.trial_due && self.store.saving().is_none() {
            self.trial_due = false;
            let record = self.trial_record();
            self.store.save_record(board.memory(), Kind::Trial, &record);
        }
    }

    pub(super) fn trial_record(&self) -> [u8; TRIAL_LEN] {
        let Some(Ended { end, amplitude, gait_crc32 }) = self.ended else { return [0; TRIAL_LEN] };
        let Trial { frames, clipped_frames, energy_uj, missed_samples, .. } = self.trial;
        TrialRecord { frames, energy_uj, clipped_frames, missed_samples, gait_crc32, amplitude, end }.bytes()
    }
}
