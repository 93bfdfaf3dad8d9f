//! The simulated HAL.
//!
//! Holds a clock that moves only when asked to, a serial line at its real pace
//! behind rings of the real size, the chips of [`crate::devices`], a memory that
//! takes 3.4 ms a byte and loses the byte under way when the power goes, and a
//! watchdog that measures instead of resetting. Misuse is a panic: reading memory
//! during a write, or writing a byte where there is no room. Does not depend on the
//! application. Longer than most files: the parts of the board share one clock.

mod bus;

use crate::devices::{Bus as Chips, SHUNT_OHM};
use embedded_hal::delay::DelayNs;
use embedded_hal::i2c::Operation;
use firmware::chips::{Reading, ServoBurst, ServoChip, ServoDriver};
use firmware::hal::{Board, FrameClock, Panel, PersistentMemory, SerialRing, Watchdog};
use protocol::FRAME_RATE_HZ;
use protocol::frame::STOP_BYTE;
use std::cell::Cell;
use std::collections::VecDeque;
use std::rc::Rc;

pub use bus::SimBusError;

/// Simulated time.
pub const NS_PER_S: u64 = 1_000_000_000;
/// 9 bits at 400 kHz.
const BUS_BYTE_NS: u64 = 22_500;
/// When a transfer on a stuck bus is given up.
const BUS_TIMEOUT_NS: u64 = 1_000_000;
/// 10 bits at 115,200 baud.
const SERIAL_BYTE_NS: u64 = 86_806;
/// Bytes that the board's rings hold, and how many are many.
const RECEIVED_CAPACITY: usize = 63;
const TO_SEND_CAPACITY: usize = 127;
const MANY_BYTES: usize = 32;
/// One byte of EEPROM.
const MEMORY_WRITE_NS: u64 = 3_400_000;
/// A figure for a stack that is not there.
const STACK_LEFT: u16 = 300;

pub struct SimBoard {
    now_ns: u64,
    frames: u64,
    untaken_frames: u8,
    /// The chips on the bus, to measure and to break.
    pub chips: Chips,
    staged: ServoBurst,
    burst_ends_ns: u64,
    burst_failed: bool,
    readings: VecDeque<Reading>,
    /// Of this frame, whatever came of them.
    readings_taken: u8,
    incoming: VecDeque<u8>,
    incoming_next_ns: u64,
    received: VecDeque<u8>,
    to_send: VecDeque<u8>,
    placed: [u8; TO_SEND_CAPACITY],
    sent_next_ns: u64,
    outgoing: Vec<u8>,
    memory: [u8; 1024],
    memory_free_ns: u64,
    memory_write_at: u16,
    /// A worn cell: it stores the inverse of what is written.
    pub worn_cell: Option<u16>,
    fed_ns: u64,
    longest_unfed_ns: u64,
    servos_noted_on: bool,
    is_lit: bool,
    outputs_enabled: bool,
    /// Whether somebody holds the start button down.
    pub is_button_down: bool,
    is_stopped: bool,
    dropped_bytes: u16,
    bus_errors: u16,
    waited_ns: Rc<Cell<u64>>,
}

impl SimBoard {
    /// A healthy board with erased memory and 5 V supply.
    pub(super) fn new() -> Self {
        let mut chips = Chips::default();
        chips.power_sensor.set_inputs(0.0, 5.0, 0.0);
        Self {
            now_ns: 0,
            frames: 0,
            untaken_frames: 0,
            chips,
            staged: ServoChip::limp_burst(),
            burst_ends_ns: 0,
            burst_failed: false,
            readings: VecDeque::new(),
            readings_taken: 0,
            incoming: VecDeque::new(),
            incoming_next_ns: 0,
            received: VecDeque::new(),
            to_send: VecDeque::new(),
            placed: [0; TO_SEND_CAPACITY],
            sent_next_ns: 0,
            outgoing: Vec::new(),
            memory: [0xFF; 1024],
            memory_free_ns: 0,
            memory_write_at: 0,
            worn_cell: None,
            fed_ns: 0,
            longest_unfed_ns: 0,
            servos_noted_on: false,
            is_lit: false,
            outputs_enabled: false,
            is_button_down: false,
            is_stopped: false,
            dropped_bytes: 0,
            bus_errors: 0,
            waited_ns: Rc::default(),
        }
    }

    /// The board after a reset: rings and timers anew, everything else as it was.
    pub(super) fn after_reset(self) -> Self {
        let mut board = Self::new();
        board.now_ns = self.now_ns;
        board.fed_ns = self.now_ns;
        board.frames = self.frames;
        board.chips = self.chips;
        board.memory = self.memory;
        board.memory_free_ns = self.now_ns;
        board.servos_noted_on = self.servos_noted_on;
        board
    }

    /// The board after the power was off: the byte being written is erased,
    /// not written, and the chips start anew.
    pub(super) fn after_power_cut(mut self) -> Self {
        if self.is_busy() {
            self.memory[usize::from(self.memory_write_at)] = 0xFF;
        }
        Self { memory: self.memory, ..Self::new() }
    }

    /// Loads the supply from now on.
    pub fn set_supply(&mut self, bus_v: f64, current_a: f64) {
        let now_s = self.now_s();
        self.chips.power_sensor.set_inputs(current_a * SHUNT_OHM, bus_v, now_s);
    }

    /// Frames since power-on.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Longest time that the watchdog was not fed.
    #[must_use]
    pub fn longest_unfed_s(&self) -> f64 {
        self.longest_unfed_ns as f64 / NS_PER_S as f64
    }

    /// Whether the board's light is on.
    #[must_use]
    pub fn is_lit(&self) -> bool {
        self.is_lit
    }

    /// Whether the servo driver's `/OE` lets pulses out.
    #[must_use]
    pub fn outputs_enabled(&self) -> bool {
        self.outputs_enabled
    }

    #[must_use]
    pub fn memory(&self) -> &[u8; 1024] {
        &self.memory
    }

    /// The persistent memory, to damage.
    pub fn memory_mut(&mut self) -> &mut [u8; 1024] {
        &mut self.memory
    }

    pub(super) fn servos_noted_on(&self) -> bool {
        self.servos_noted_on
    }

    pub(super) fn receive(&mut self, bytes: &[u8]) {
        self.incoming.extend(bytes);
    }

    pub(super) fn take_outgoing(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.outgoing)
    }

    /// Seconds since power-on.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.now_ns as f64 / NS_PER_S as f64
    }

    fn next_frame_ns(&self) -> u64 {
        (self.frames + 1) * NS_PER_S / u64::from(FRAME_RATE_HZ)
    }

    pub(super) fn advance(&mut self, ns: u64) {
        self.now_ns += ns;
        self.longest_unfed_ns = self.longest_unfed_ns.max(self.now_ns - self.fed_ns);
        while self.now_ns >= self.next_frame_ns() {
            self.frames += 1;
            self.readings_taken = 0;
            self.untaken_frames = self.untaken_frames.saturating_add(1);
            let (result, busy_ns) =
                self.transfer(ServoChip::ADDRESS, &mut [Operation::Write(&self.staged.clone())]);
            self.burst_failed = result.is_err();
            self.burst_ends_ns = self.now_ns + busy_ns;
        }
        self.read_sensor();
        self.move_serial_bytes();
    }

    fn move_serial_bytes(&mut self) {
        while self.incoming_next_ns <= self.now_ns {
            let Some(byte) = self.incoming.pop_front() else { break };
            // A full ring drops the byte, as the board does.
            if byte == STOP_BYTE {
                self.is_stopped = true;
            } else if self.received.len() < RECEIVED_CAPACITY {
                self.received.push_back(byte);
            } else {
                self.dropped_bytes = self.dropped_bytes.saturating_add(1);
            }
            self.incoming_next_ns += SERIAL_BYTE_NS;
        }
        self.incoming_next_ns = self.incoming_next_ns.max(self.now_ns);
        while self.sent_next_ns <= self.now_ns {
            let Some(byte) = self.to_send.pop_front() else { break };
            self.outgoing.push(byte);
            self.sent_next_ns += SERIAL_BYTE_NS;
        }
        self.sent_next_ns = self.sent_next_ns.max(self.now_ns);
    }
}

/// A wait; the board's clock catches up at the next transfer.
pub struct SimDelay(Rc<Cell<u64>>);

impl DelayNs for SimDelay {
    fn delay_ns(&mut self, ns: u32) {
        self.0.set(self.0.get() + u64::from(ns));
    }
}

impl FrameClock for SimBoard {
    fn take_frames(&mut self) -> u8 {
        std::mem::take(&mut self.untaken_frames)
    }

    fn left_us(&mut self) -> u16 {
        ((self.next_frame_ns() - self.now_ns) / 1_000) as u16
    }
}

impl SerialRing for SimBoard {
    fn is_worth_reading(&mut self) -> bool {
        self.received.contains(&0) || self.received.len() >= MANY_BYTES
    }

    fn received(&mut self) -> impl Iterator<Item = u8> {
        std::iter::from_fn(|| self.received.pop_front())
    }

    fn room(&self) -> u8 {
        (TO_SEND_CAPACITY - self.to_send.len()) as u8
    }

    fn place(&mut self, at: u8, byte: u8) {
        assert!(at < self.room(), "a byte was placed where there is no room");
        self.placed[usize::from(at)] = byte;
    }

    fn send(&mut self, len: u8) {
        assert!(len <= self.room(), "bytes were queued where there is no room");
        self.to_send.extend(&self.placed[..usize::from(len)]);
    }

    fn take_stop(&mut self) -> bool {
        std::mem::take(&mut self.is_stopped)
    }

    fn dropped(&self) -> u16 {
        self.dropped_bytes
    }
}

impl PersistentMemory for SimBoard {
    fn is_busy(&self) -> bool {
        self.now_ns < self.memory_free_ns
    }

    fn read(&mut self, at: u16) -> u8 {
        assert!(!self.is_busy(), "memory was read during a write");
        self.memory[usize::from(at)]
    }

    fn write(&mut self, at: u16, byte: u8) {
        assert!(!self.is_busy(), "memory was written during a write");
        self.memory[usize::from(at)] = if self.worn_cell == Some(at) { !byte } else { byte };
        self.memory_write_at = at;
        self.memory_free_ns = self.now_ns + MEMORY_WRITE_NS;
    }
}

impl Watchdog for SimBoard {
    fn feed(&mut self, servos_on: bool) {
        self.fed_ns = self.now_ns;
        self.servos_noted_on = servos_on;
    }
}

impl Panel for SimBoard {
    fn light(&mut self, on: bool) {
        self.is_lit = on;
    }

    fn is_button_pressed(&mut self) -> bool {
        self.is_button_down
    }

    fn enable_outputs(&mut self, on: bool) {
        self.outputs_enabled = on;
    }
}

/// One struct is the whole board: what is shared, above all the time, is shared.
impl Board for SimBoard {
    type Product = protocol::gait::PlainProduct;
    type I2c = Self;
    type Servos = Self;
    type Sensor = Self;
    type Clock = Self;
    type Delay = SimDelay;
    type Serial = Self;
    type Memory = Self;
    type Watchdog = Self;
    type Panel = Self;
    fn i2c(&mut self) -> &mut Self {
        self
    }
    fn servos(&mut self) -> &mut Self {
        self
    }
    fn sensor(&mut self) -> &mut Self {
        self
    }
    fn clock(&mut self) -> &mut Self {
        self
    }
    fn delay(&self) -> SimDelay {
        SimDelay(Rc::clone(&self.waited_ns))
    }
    fn serial(&mut self) -> &mut Self {
        self
    }
    fn memory(&mut self) -> &mut Self {
        self
    }
    fn watchdog(&mut self) -> &mut Self {
        self
    }
    fn panel(&mut self) -> &mut Self {
        self
    }
    fn bus_errors(&self) -> u16 {
        self.bus_errors
    }
    fn stack_left(&self) -> u16 {
        STACK_LEFT
    }
}
