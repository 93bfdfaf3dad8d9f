//! Everything the robot does, and none of the hardware it does it on.
//!
//! Owns the control loop ([`app`]), what it says and hears ([`link`]), time to
//! setpoints ([`player`]), angles to pulses ([`limits`]), the two chips
//! ([`servos`], [`power`]), uploads ([`upload`]) and the stored gait
//! ([`store`]). The board is behind the traits of [`hal`], so what can go wrong
//! on the bench is tested on a laptop. Refuses registers, interrupts, floating
//! point, allocation, unbounded waits, and strings: an AVR keeps those in RAM.
#![no_std]
#![forbid(unsafe_code)]

pub mod app;
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
