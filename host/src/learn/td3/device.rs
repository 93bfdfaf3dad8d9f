//! The device of the updates: plain memory, or libtorch on the CPU or on a GPU.
//!
//! Holds the names and the check that a device is available. Does not fall back to
//! another one: a user who asked for a GPU must know if it is not used.

use serde::{Deserialize, Serialize};
use std::fmt;
use thiserror::Error;

/// Where the updates are computed: `--device` and `device` in `config.toml`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Device {
    /// The CPU, without libtorch: the fastest with networks of the presets' size.
    #[default]
    Cpu,
    /// libtorch on the CPU: the same update by other code, for comparison.
    Torch,
    /// libtorch on the first NVIDIA GPU; slow with networks of the presets' size.
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

/// Why a device cannot be used.
#[derive(Debug, Error)]
pub enum DeviceError {
    /// The feature `torch` is off.
    #[error("device {device} needs libtorch, and this program was built without it")]
    NotBuilt {
        /// The requested device.
        device: Device,
    },
    /// libtorch finds no GPU that it can use.
    #[error("device cuda: libtorch finds no CUDA GPU (tch::Cuda::is_available() is false)")]
    NoCuda,
    /// libtorch reported an error: most often it is out of memory.
    #[cfg(feature = "torch")]
    #[error("libtorch on device {device}: {reason}")]
    Torch {
        /// The device.
        device: Device,
        /// libtorch's message, without its stack trace.
        reason: String,
    },
}

impl DeviceError {
    /// The user's next step, as a help text.
    pub fn next_move(&self) -> &'static str {
        match self {
            Self::NotBuilt { .. } => {
                "run `make setup`, build with the feature `torch` (on unless --no-default-features), or use --device cpu"
            }
            Self::NoCuda => {
                "`make setup` installs libtorch for the CPU only: where `nvidia-smi` shows a GPU, set LIBTORCH to a CUDA libtorch and build again; or use --device cpu"
            }
            #[cfg(feature = "torch")]
            Self::Torch { .. } => {
                "a smaller td3.batch_size or td3.hidden_width needs less memory; or use --device cpu"
            }
        }
    }
}

impl Device {
    /// Checks that this program can use the device on this machine.
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
