//! The control loop: one [`App::poll`] after another, 60 frames a second.
//!
//! Holds the state of the robot and the order of things within a frame: the
//! timer starts the servo burst, then the frame before is counted, telemetry
//! goes out, and the next burst is computed and handed over. The board reads
//! the sensor meanwhile. Bytes from the host and bytes for the persistent memory
//! fill the gaps. No call waits: each returns within a few milliseconds. A chip that
//! is lost while servos are on stops the robot, and it stays stopped until a command
//! clears the fault. Does not depend on the board beyond the traits of [`crate::hal`].
//!
//! The board's light tells the state without a host: a wink a second is idle,
//! an even blink is walking or on the way to or from it, steady light is holding,
//! and a fast flicker is a fault. A light that does not change is a hung program,
//! or a robot that holds, which it does for a second only, unless it was paused.
//!
//! The parts of a turn are kept from being inlined: in one function, the locals
//! of all of them would lie on the stack all the time.
//!
//! A burst computed in one frame goes out at the start of the next, so what
//! the robot does is always one frame behind the player.

mod chips;
mod commands;
mod keeping;
mod messages;
mod walks;

use heapless::Deque;
use protocol::command::{CalibrationSource, Storage};
use protocol::gait::Encoded;
use protocol::{Amplitude, Calibration, Event, Fault, ResetCause, State, WalkEnd};

use crate::chips::{ServoChip, ServoDriver};
use crate::hal::{Board, FrameClock, Panel, SerialRing, ServoOutput, Watchdog};
use crate::link::Link;
use crate::player::{Frame, Mode, Player};
use crate::power::{Readings, Sample, Trial};
use crate::servos;
use crate::store::Store;
use crate::upload::Upload;
use chips::BusWork;

/// What the board knows about its last reset.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Boot {
    /// Why it started.
    pub cause: ResetCause,
    /// Whether servos were on when it happened.
    pub servos_were_on: bool,
}

/// Pulses for one output alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Nudge {
    channel: u8,
    counts: u16,
}

/// How a walk ended, while its trial is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Ended {
    end: WalkEnd,
    amplitude: Amplitude,
    gait_crc32: u32,
}

/// All that the robot remembers between two calls.
#[derive(Debug)]
pub struct App {
    player: Player,
    calibration: Calibration,
    calibration_source: CalibrationSource,
    gait: Encoded,
    /// The active gait's own.
    amplitude: Amplitude,
    storage: Storage,
    store: Store,
    upload: Upload,
    link: Link,
    /// Whether the stop byte came, and requests from before it may still wait.
    stopped: bool,
    /// Whether the last command was setpoints, whose answer tells the buffer.
    streamed: bool,
    /// Frames since the last command.
    silent_frames: u8,
    /// Whether the walk goes on without them.
    detached: bool,
    /// Whether the walk is a rehearsal without pulses.
    dry_run: bool,
    nudge: Option<Nudge>,
    fault: Option<Fault>,
    trial: Trial,
    /// Why the walk is over, while its last frames are still counted.
    ending: Option<WalkEnd>,
    ended: Option<Ended>,
    /// Whether its trial is still to be saved.
    trial_due: bool,
    sample: Sample,
    readings: Readings,
    telemetry_every: u8,
    reset_cause: ResetCause,
    booted: bool,
    events: Deque<Event, 4>,
    uptime_frames: u32,
    telemetry_in: u8,
    staged: Frame,
    live: Frame,
    bus_work: BusWork,
    since_check: u8,
    servo_misses: u8,
    sensor_misses: u8,
    /// Samples in a row with too little voltage.
    low_samples: u8,
    /// Samples in a row with too much current.
    high_samples: u8,
    is_button_down: bool,
    /// Frames for which the button has been otherwise.
    button_frames: u8,
}

impl Default for App {
    fn default() -> Self {
        Self::new()
    }
}

impl App {
    /// A robot that has not started: call [`Self::boot`].
    ///
    /// All of it is zeros, and [`Self::boot`] sets what is not: as a static with
    /// any other value, its 0.9 KB would lie in flash too.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            player: Player::new(),
            calibration: Calibration::NONE,
            calibration_source: CalibrationSource::Default,
            gait: Encoded::EMPTY,
            amplitude: Amplitude::UNSET,
            storage: Storage::RamOnly,
            store: Store::new(),
            upload: Upload::new(),
            link: Link::new(),
            stopped: false,
            streamed: false,
            silent_frames: 0,
            detached: false,
            dry_run: false,
            nudge: None,
            fault: None,
            trial: Trial::NONE,
            ending: None,
            ended: None,
            trial_due: false,
            sample: Sample::NONE,
            readings: Readings::NONE,
            telemetry_every: 0,
            reset_cause: ResetCause::PowerOn,
            booted: false,
            events: Deque::new(),
            uptime_frames: 0,
            telemetry_in: 0,
            staged: Frame::LIMP,
            live: Frame::LIMP,
            bus_work: BusWork::Burst,
            since_check: 0,
            servo_misses: 0,
            sensor_misses: 0,
            low_samples: 0,
            high_samples: 0,
            is_button_down: false,
            button_frames: 0,
        }
    }

    /// Servos off, chips configured, stored calibration and gait loaded.
    ///
    /// A chip that does not answer is not a fault yet: nothing moves, and
    /// [`protocol::Command::Walk`] looks again.
    #[inline(never)]
    pub fn boot(&mut self, board: &mut impl Board, boot: Boot) {
        self.reset_cause = boot.cause;
        self.switch_off(board);
        self.load_calibration(board);
        let _ = self.configure_chips(board);
        // There is no sample yet.
        self.sensor_misses = 1;
        // A button that is held down from the start is not a press.
        self.is_button_down = true;
        self.load_start_gait(board);
        // The first frame's burst comes before the first is computed: unstaged, it
        // would be zeros, which the servo driver takes for its configuration.
        self.stage(board);
        self.booted = true;
        self.tell(Event::Started(boot.cause));
        if boot.cause == ResetCause::Watchdog && boot.servos_were_on {
            self.latch(board, Fault::Watchdog);
        }
    }

    /// One turn of the main loop.
    pub fn poll(&mut self, board: &mut impl Board) {
        let frames = board.clock().take_frames();
        if frames > 0 {
            self.start_frame(board, frames);
        }
        self.stopped |= board.serial().take_stop();
        self.use_bus(board);
        // Looked at here, not in there: most turns have nothing to do, and a flood
        // pays for the turns beside its own.
        let has_bytes = board.serial().is_worth_reading();
        if has_bytes {
            self.listen(board);
        }
        if self.stopped {
            self.halt(WalkEnd::StopByte);
            // The byte overtakes what waits in the ring: a walk there is halted too.
            self.stopped = has_bytes;
        }
        self.save(board);
        if !self.events.is_empty() {
            self.report(board);
        }
        board.watchdog().feed(self.servos_on());
    }

    /// What the robot is doing.
    #[must_use]
    pub const fn state(&self) -> State {
        if !self.booted {
            return State::Booting;
        }
        if let Some(fault) = self.fault {
            return State::Fault(fault);
        }
        if self.nudge.is_some() || self.player.is_paused() {
            return State::Holding;
        }
        match self.player.mode() {
            Mode::Limp => State::Idle,
            Mode::Entering => State::Entering,
            Mode::Walking => State::Walking,
            Mode::Stopping => State::Stopping,
            Mode::Holding(_) => State::Holding,
        }
    }

    #[inline(never)]
    fn start_frame<B: Board>(&mut self, board: &mut B, frames: u8) {
        self.close_frame(board);
        self.uptime_frames = self.uptime_frames.wrapping_add(u32::from(frames));
        self.live = self.staged;
        self.bus_work = BusWork::Burst;
        self.conclude();
        self.send_telemetry(board);
        self.watch_button(board);
        self.depend_on_link(frames);
        self.advance::<B::Product>();
        self.stage(board);
        let (is_lit, servos_on) = (self.is_lit(), self.servos_on());
        board.panel().light(is_lit);
        board.panel().enable_outputs(servos_on);
    }

    const fn is_lit(&self) -> bool {
        let frame = self.uptime_frames as u8;
        match self.state() {
            State::Booting => false,
            State::Idle => frame & 0x3F < 4,
            State::Entering | State::Walking | State::Stopping => frame & 0x10 != 0,
            State::Holding => true,
            State::Fault(_) => frame & 0x04 != 0,
        }
    }

    /// Hands over the burst of the coming frame.
    fn stage(&mut self, board: &mut impl Board) {
        let mut burst = ServoChip::limp_burst();
        if let Some(Nudge { channel, counts }) = self.nudge {
            ServoChip::set_pulse(&mut burst, channel, counts);
        } else if self.staged.servos_on || self.staged.gait {
            // A rehearsal is to find out what would be held at a limit, and no more.
            let Frame { servos_on, clipped, .. } = &mut self.staged;
            *clipped |= servos::set_pulses(&mut burst, self.player.pose(), &self.calibration, *servos_on);
        }
        board.servos().stage(&burst);
    }
}
