//! What outlasts a reset: what is loaded at the start, and saved in between.
//!
//! Holds which of it is active, and whether it is saved as it is. Does not depend on
//! the layout of the memory, which is in [`crate::store`].

use protocol::command::{CalibrationSource, Storage};
use protocol::{GAIT_SLOTS, Refusal};

use super::App;
use crate::hal::Board;
use crate::store::{Kind, Saved};

impl App {
    #[inline(never)]
    pub(super) fn load_calibration(&mut self, board: &mut impl Board) {
        let (memory, buffer) = (board.memory(), self.upload.buffer_mut());
        if self.store.load_calibration(memory, buffer, &mut self.calibration) {
            self.calibration_source = CalibrationSource::Stored;
        } else {
            self.calibration.set_authors();
            if self.store.has_calibration(board.memory()) {
                self.calibration_source = CalibrationSource::Damaged;
            }
        }
    }

    pub(super) fn load_start_gait(&mut self, board: &mut impl Board) {
        // Slots as long as they go around: the first one, then the others.
        let start = self.store.start_slot(board.memory()).unwrap_or(0);
        for next in 0..GAIT_SLOTS {
            if self.load_gait(board, (start + next) % GAIT_SLOTS).is_ok() {
                return;
            }
        }
    }

    /// Makes the gait stored in `slot` the active one.
    ///
    /// # Errors
    /// Why it is not; the active one stays.
    #[inline(never)]
    pub(super) fn load_gait(&mut self, board: &mut impl Board, slot: u8) -> Result<(), Refusal> {
        // The buffer is used up: what had been announced is gone.
        self.upload.close();
        let buffer = self.upload.buffer_mut();
        let (amplitude, len) = self.store.load_gait(board.memory(), slot, buffer)?;
        let encoding = buffer.get(..len).unwrap_or(&[]);
        self.gait.replace(encoding).map_err(Refusal::BadGait)?;
        self.amplitude = amplitude;
        self.storage = Storage::Saved;
        Ok(())
    }

    pub(super) fn save(&mut self, board: &mut impl Board) {
        self.save_trial(board);
        if self.store.saving().is_some() {
            self.save_on(board);
        }
    }

    #[inline(never)]
    fn save_on(&mut self, board: &mut impl Board) {
        let record;
        let payload: &[u8] = match self.store.saving() {
            None => return,
            Some(Kind::Gait | Kind::Start) => self.gait.bytes(),
            Some(Kind::Calibration) => self.calibration.bytes(),
            Some(Kind::Trial) => {
                record = self.trial_record();
                &record
            }
        };
        let Some(Saved { kind, verified }) = self.store.step(board.memory(), payload) else { return };
        match kind {
            // Another amplitude since it began, and what was saved is not what is active.
            Kind::Gait if verified && self.storage == Storage::Saving => self.storage = Storage::Saved,
            Kind::Gait if !verified => self.storage = Storage::Failed,
            Kind::Calibration if !verified => self.calibration_source = CalibrationSource::NotSaved,
            Kind::Gait | Kind::Start | Kind::Calibration | Kind::Trial => {}
        }
    }
}
