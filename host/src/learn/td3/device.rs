//! Which machinery learns: plain memory, or libtorch on the CPU or on a GPU.
//!
//! Owns the names and what each needs to be there. Refuses to fall back on
//! another: whoever asked for a GPU should hear that it was not used.

use serde::{Deserialize, Serialize};
use std::fmt;
use thiserror::Error;

/// Where the updates are computed, as `--device` and `config.toml` know it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Device {
    /// Plain memory, no libtorch: on a CPU some 2.4 times as many updates a second as `torch`.
    #[default]
    Cpu,
    /// libtorch on the CPU: the same update by other code, to compare with.
    Torch,
    /// libtorch on the first NVIDIA GPU; expect little of it with networks as small as the presets'.
    Cuda,
}

impl fmt::Display for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Cpu => "cpu",
            Self::Torch => "torch",
            Self::Cuda => "cuda",
        })
    }
}

/// Why a device cannot learn.
#[derive(Debug, Error)]
pub enum DeviceError {
    /// The feature `torch` is off.
    #[error("device {device} needs libtorch, and this program was built without it")]
    NotBuilt {
        /// What was asked for.
        device: Device,
    },
    /// libtorch is there, a GPU that it can use is not.
    #[error("device cuda: libtorch finds no CUDA GPU (tch::Cuda::is_available() says no)")]
    NoCuda,
    /// libtorch refused an operation: most often memory.
    #[cfg(feature = "torch")]
    #[error("libtorch on device {device} refused: {reason}")]
    Torch {
        /// On which.
        device: Device,
        /// Its own words, without its stack.
        reason: String,
    },
}

impl DeviceError {
    /// What to do about it.
    pub fn next_move(&self) -> &'static str {
        match self {
            Self::NotBuilt { .. } => {
                "run `make setup`, build with the feature `torch` (on unless --no-default-features), or take --device cpu"
            }
            Self::NoCuda => {
                "`make setup` brings libtorch for the CPU alone: where `nvidia-smi` shows a GPU, set LIBTORCH to a CUDA libtorch and build again; or take --device cpu"
            }
            #[cfg(feature = "torch")]
            Self::Torch { .. } => {
                "a smaller td3.batch_size or td3.hidden_width needs less memory; or take --device cpu"
            }
        }
    }
}

impl Device {
    /// Whether this program on this machine can learn on it.
    ///
    /// # Errors
    /// [`DeviceError`] with what is missing.
    pub fn check(self) -> Result<(), DeviceError> {
        match self {
            Self::Cpu => Ok(()),
            #[cfg(feature = "torch")]
            Self::Torch => Ok(()),
            #[cfg(feature = "torch")]
            Self::Cuda if tch::Cuda::is_available() => Ok(()),
            #[cfg(feature = "torch")]
            Self::Cuda => Err(DeviceError::NoCuda),
            #[cfg(not(feature = "torch"))]
            Self::Torch | Self::Cuda => Err(DeviceError::NotBuilt { device: self }),
        }
    }
}
