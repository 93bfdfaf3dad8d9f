//! Everything the `host` command does, as a library.
//!
//! Owns training, fitting, the gait and robot files, the serial link and the
//! arithmetic of a trial. Refuses to know the firmware: it speaks
//! [`protocol`] to whatever answers on a port.
//!
//! Features: `train` (default) adds TD3 on plain memory, `torch` (default) its
//! updates on libtorch, on the CPU or a GPU, and `bench`, which compares them.
//! Without either, the tool still simulates, fits, uploads and measures.
#![deny(unsafe_code)]

pub mod calibration;
mod cause_chain;
pub mod cli;
#[cfg(feature = "train")]
pub mod curves;
pub mod energy;
pub mod env;
#[cfg(feature = "train")]
pub mod experiment;
pub mod fit;
pub mod gait_file;
pub mod joint_map;
pub mod link;
#[cfg(feature = "train")]
pub mod optimise;
pub mod playable;
#[cfg(feature = "train")]
pub mod plot;
#[cfg(feature = "train")]
pub mod record;
pub mod robot;
pub mod run_folder;
pub mod sampled;
pub mod searched;
pub mod sim;
#[cfg(feature = "train")]
pub mod sinusoid;
pub mod stream;
#[cfg(feature = "train")]
pub mod stride;
#[cfg(feature = "train")]
pub mod td3;
pub mod tracker;
pub mod trajectory;
pub mod trial;
pub mod twin;
pub mod upload;
