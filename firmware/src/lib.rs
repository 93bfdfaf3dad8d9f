//! Everything the robot does, without the hardware that it runs on.
//!
//! Holds the control loop ([`app`]), messages in and out ([`link`]), time to
//! setpoints ([`player`]), angles to pulses ([`servos`]), readings to energy
//! ([`power`]), the chips ([`chips`]), bounds ([`limits`]), uploads ([`upload`]) and
//! the stored gaits ([`store`]). The board is behind the traits of [`hal`], so what
//! can go wrong on the bench is tested on a laptop. Does not depend on registers,
//! interrupts, floating point, allocation, unbounded waits, or strings: an AVR keeps
//! those in RAM.
#![no_std]
#![forbid(unsafe_code)]

pub mod app;
pub mod chips;
pub mod hal;
pub mod limits;
pub mod link;
pub mod player;
pub mod power;
pub mod servos;
pub mod store;
pub mod upload;

pub use app::{App, Boot};

/// Major, minor, patch, as in Cargo.toml.
pub const FIRMWARE_VERSION: [u8; 3] = [
    digits(env!("CARGO_PKG_VERSION_MAJOR")),
    digits(env!("CARGO_PKG_VERSION_MINOR")),
    digits(env!("CARGO_PKG_VERSION_PATCH")),
];

const fn digits(text: &str) -> u8 {
    let bytes = text.as_bytes();
    let mut value = 0;
    let mut at = 0;
    while at < bytes.len() {
        value = value * 10 + (bytes[at] - b'0');
        at += 1;
    }
    value
}
