//! The two chips within a frame: burst, readings, a look at their configuration.
//!
//! Holds when the main loop uses the bus, and what counts as a lost chip or a
//! bad supply: while servos are on it stops the robot, otherwise nothing moves
//! and the next walk looks again. Does not use the bus where too little of the
//! frame is left, and does not depend on the chips beyond their roles.

use protocol::{Event, Fault, Refusal, WalkEnd};

use super::App;
use crate::chips::{ChipFault, PowerSensor, SensorChip, ServoChip, ServoDriver};
use crate::hal::{Board, BurstState, FrameClock, Panel, PowerReadings, ServoOutput};
use crate::limits::{
    BUS_SLOT_US, CHECK_EVERY_FRAMES, SENSOR_LOST_FRAMES, SERVO_DRIVER_LOST_FRAMES, SUPPLY_FAULT_FRAMES,
};
use crate::player::Frame;
use crate::power;

/// Half of what the board keeps.
const READINGS_AT_ONCE: u8 = 4;

/// Where this frame stands with the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum BusWork {
    /// The burst has not been seen to end.
    Burst,
    /// The chips' configuration is to be looked at.
    Check,
    /// Nothing more in this frame.
    Rest,
}

impl App {
    #[inline(never)]
    pub(super) fn use_bus(&mut self, board: &mut impl Board) {
        // A few at a time: taken one by one, each would cost a turn.
        if board.sensor().readings() >= READINGS_AT_ONCE {
            self.take_readings(board);
        }
        if self.bus_work == BusWork::Burst {
            match board.servos().burst() {
                BurstState::Running => return,
                BurstState::Done => {
                    self.servo_misses = 0;
                    self.since_check = self.since_check.saturating_add(1);
                    let is_time = self.since_check >= CHECK_EVERY_FRAMES;
                    self.bus_work = if is_time { BusWork::Check } else { BusWork::Rest };
                }
                BurstState::Failed => {
                    // The main loop's transfers would meet the same bus.
                    self.servo_misses = self.servo_misses.saturating_add(1);
                    self.bus_work = BusWork::Rest;
                    if self.servos_on() && self.servo_misses >= SERVO_DRIVER_LOST_FRAMES {
                        self.latch(board, Fault::ServoDriverLost);
                    }
                }
            }
        }
        if self.bus_work == BusWork::Check && board.clock().left_us() >= BUS_SLOT_US {
            self.since_check = 0;
            self.bus_work = BusWork::Rest;
            self.check_chips(board);
        }
    }

    fn take_readings(&mut self, board: &mut impl Board) {
        while !self.readings.is_complete()
            && let Some(reading) = board.sensor().take_reading()
        {
            self.readings.add(reading);
        }
    }

    /// Closes the live frame: its energy counts, with its own sample or the last.
    pub(super) fn close_frame(&mut self, board: &mut impl Board) {
        self.take_readings(board);
        let sample = self.readings.close(self.calibration.board().shunt_gain_q14);
        self.count_supply_faults(sample);
        match sample {
            Ok(sample) => {
                self.sample = sample;
                self.sensor_misses = 0;
            }
            Err(power::Missed::NoAnswer) => self.sensor_misses = self.sensor_misses.saturating_add(1),
            // A sensor that says so is not lost.
            Err(power::Missed::Saturated) => self.sensor_misses = 0,
        }
        if self.live.gait {
            self.trial.add(self.sample, self.live.clipped, sample.is_err());
        }
        if self.servos_on() {
            // Too much current is why there is too little voltage.
            if self.high_samples >= SUPPLY_FAULT_FRAMES {
                self.latch(board, Fault::Overcurrent);
            } else if self.low_samples >= SUPPLY_FAULT_FRAMES {
                self.latch(board, Fault::Undervoltage);
            } else if self.sensor_misses >= SENSOR_LOST_FRAMES {
                self.latch(board, Fault::SensorLost);
            }
        }
    }

    /// Counts the samples in a row that the supply is wrong for; a limp robot's
    /// do not count, and a missed one changes nothing.
    fn count_supply_faults(&mut self, sample: Result<power::Sample, power::Missed>) {
        let servos_on = self.servos_on();
        let board = self.calibration.board();
        let count = |samples: &mut u8, is_wrong: bool| {
            *samples = if is_wrong && servos_on { samples.saturating_add(1) } else { 0 };
        };
        match sample {
            Ok(sample) => {
                count(&mut self.low_samples, sample.bus_mv() < board.undervoltage_mv);
                count(&mut self.high_samples, sample.is_above_ma(board.overcurrent_ma));
            }
            Err(power::Missed::Saturated) => count(&mut self.high_samples, true),
            Err(power::Missed::NoAnswer) => {}
        }
    }

    /// Makes sure that the supply could carry a walk, as far as is known.
    ///
    /// # Errors
    /// [`Refusal::SupplyTooLow`]; while samples are missing, that comes first.
    pub(super) fn require_supply(&self) -> Result<(), Refusal> {
        let bus_mv = self.sample.bus_mv();
        if self.sensor_misses == 0 && bus_mv < self.calibration.board().start_mv {
            return Err(Refusal::SupplyTooLow { bus_mv });
        }
        Ok(())
    }

    /// Checks whether a brown-out has taken a chip's configuration.
    fn check_chips(&mut self, board: &mut impl Board) {
        if !self.servos_on() {
            return;
        }
        // A transfer that failed does not count here: the next frame's burst or sample will fail too.
        let prescale = self.calibration.board().prescale;
        if ServoChip::check(board.i2c(), prescale) == Err(ChipFault::WrongConfiguration) {
            self.latch(board, Fault::ServoDriverLost);
        } else if SensorChip::check(board.i2c()) == Err(ChipFault::WrongConfiguration) {
            self.latch(board, Fault::SensorLost);
        }
    }

    /// Makes sure that both chips are there and configured.
    ///
    /// # Errors
    /// Which one is not.
    pub(super) fn configure_chips(&mut self, board: &mut impl Board) -> Result<(), Fault> {
        let mut delay = board.delay();
        let prescale = self.calibration.board().prescale;
        let bus = board.i2c();
        if ServoChip::check(bus, prescale).is_err() {
            ServoChip::configure(bus, &mut delay, prescale).map_err(|_| Fault::ServoDriverLost)?;
        }
        if SensorChip::check(bus).is_err() {
            SensorChip::configure(bus).map_err(|_| Fault::SensorLost)?;
        }
        self.servo_misses = 0;
        self.sensor_misses = 0;
        Ok(())
    }

    /// Stops by itself: servos off at once, and latched.
    pub(super) fn latch(&mut self, board: &mut impl Board, fault: Fault) {
        self.fault = Some(fault);
        self.nudge = None;
        if self.player.is_walking() {
            self.ending = Some(WalkEnd::Fault(fault));
        }
        self.player.go_limp();
        self.staged = Frame::LIMP;
        self.stage(board);
        self.switch_off(board);
        self.tell(Event::Fault(fault));
    }

    pub(super) fn switch_off(&mut self, board: &mut impl Board) {
        board.panel().enable_outputs(false);
        // A chip that misses this gets the same in every frame's burst.
        if ServoChip::switch_off(board.i2c()).is_err() {
            let _ = ServoChip::switch_off(board.i2c());
        }
    }

    pub(super) const fn servos_on(&self) -> bool {
        self.live.servos_on || self.staged.servos_on
    }
}
