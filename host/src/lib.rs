//! Everything the `host` command does, as a library.
//!
//! Holds training, fitting, the gait and robot files, the serial link and the
//! arithmetic of a trial. Does not depend on the firmware: it speaks
//! [`protocol`] to whatever answers on a port.
//!
//! Features: `train` (default) adds TD3 on plain memory, `torch` (default) its
//! updates on libtorch, on the CPU or a GPU, and `bench`, which compares them.
//! Without either, the tool still simulates, fits, uploads and measures.
#![deny(unsafe_code)]

pub mod calibration;
mod cause_chain;
pub mod cli;
pub mod device;
pub mod energy;
pub mod env;
#[cfg(feature = "train")]
pub mod experiment;
pub mod gait;
#[cfg(feature = "train")]
pub mod learn;
pub mod paper;
#[cfg(feature = "train")]
mod plot;
pub mod pwm;
pub mod robot;
pub mod run_folder;
pub mod search;
pub mod sim;
pub mod twin;
