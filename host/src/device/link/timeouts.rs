//! How long a session waits, and how often it repeats a command.

use std::time::Duration;

/// Defaults suit a Nano over USB; tests take shorter ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Timeouts {
    /// Listening after the port was opened, and again after an early answer:
    /// opening resets a Nano, and its old program must not be taken for the new.
    pub settle: Duration,
    /// Between two hellos.
    pub hello_every: Duration,
    /// Until nobody is there: an old bootloader takes 2 s.
    pub hello_for: Duration,
    /// For one answer. At 115,200 baud the longest command and its answer take
    /// 15 ms, and a frame of telemetry 4 ms.
    pub reply: Duration,
    /// How often a command is sent before giving up.
    pub attempts: u32,
    /// For a robot that writes its EEPROM: a gait and its header take about a second.
    pub busy_for: Duration,
    /// Between two tries meanwhile.
    pub busy_every: Duration,
}

impl Default for Timeouts {
    fn default() -> Self {
        Self {
            settle: Duration::from_millis(300),
            hello_every: Duration::from_millis(250),
            hello_for: Duration::from_secs(6),
            reply: Duration::from_millis(250),
            attempts: 6,
            busy_for: Duration::from_secs(10),
            busy_every: Duration::from_millis(50),
        }
    }
}
