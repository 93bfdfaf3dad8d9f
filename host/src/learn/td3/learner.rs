//! The learner on any device.
//!
//! Holds the choice of the device and the random numbers of an update, which are the
//! same on all. Does not depend on how experience is gathered. The [`Agent`] in plain
//! memory is initialised, saved and acted with; another device copies its numbers when
//! it starts and copies them back on request, so that weights, files and checkpoints do
//! not depend on the device.

use super::agent::{Agent, Losses};
use super::device::{Device, DeviceError};
use super::policy::Policy;
#[cfg(feature = "torch")]
use super::torch::TorchAgent;
use rand_chacha::ChaCha8Rng;

/// An agent and the device that updates it.
#[derive(Debug)]
pub struct Learner {
    agent: Agent,
    losses: Losses,
    #[cfg(feature = "torch")]
    torch: Option<TorchBackend>,
}

/// The agent's numbers on libtorch; those in plain memory are out of date until copied back.
#[cfg(feature = "torch")]
#[derive(Debug)]
struct TorchBackend {
    device: Device,
    agent: TorchAgent,
    normals: Vec<f32>,
}

#[cfg(feature = "torch")]
impl TorchBackend {
    fn refusal(&self) -> impl Fn(tch::TchError) -> DeviceError + use<> {
        refusal(self.device)
    }
}

/// libtorch's message, without the C++ stack that it appends.
#[cfg(feature = "torch")]
fn refusal(device: Device) -> impl Fn(tch::TchError) -> DeviceError {
    move |error| {
        let reason = error.to_string().lines().next().unwrap_or_default().to_owned();
        DeviceError::Torch { device, reason }
    }
}

impl Learner {
    /// Updates `agent` on `device` from now on.
    ///
    /// # Errors
    /// [`DeviceError`] if the device is not available or out of memory.
    pub fn new(agent: Agent, device: Device) -> Result<Self, DeviceError> {
        device.check()?;
        #[cfg(feature = "torch")]
        let torch = match device {
            Device::Cpu => None,
            Device::Torch => Some(tch::Device::Cpu),
            Device::Cuda => Some(tch::Device::Cuda(0)),
        }
        .map(|place| TorchAgent::new(&agent, place))
        .transpose()
        .map_err(refusal(device))?
        .map(|agent| TorchBackend { device, agent, normals: Vec::new() });
        Ok(Self {
            agent,
            losses: Losses::default(),
            #[cfg(feature = "torch")]
            torch,
        })
    }

    /// Updates done.
    pub fn updates(&self) -> u64 {
        self.agent.updates
    }

    /// One update on `batch`, `[batch, row]`; `rng` gives the smoothing noise.
    ///
    /// # Errors
    /// [`DeviceError`] from libtorch.
    pub fn update(&mut self, batch: &[f32], rng: &mut ChaCha8Rng) -> Result<(), DeviceError> {
        #[cfg(feature = "torch")]
        if let Some(backend) = &mut self.torch {
            self.agent.sample_normals(batch, rng, &mut backend.normals);
            let refusal = backend.refusal();
            backend.agent.update_with(batch, &backend.normals).map_err(refusal)?;
            self.agent.updates += 1;
            return Ok(());
        }
        let losses = self.agent.update(batch, rng);
        self.losses = Losses { actor: losses.actor.or(self.losses.actor), ..losses };
        Ok(())
    }

    /// Losses of the latest update; the actor's of the latest that updated it.
    ///
    /// # Errors
    /// [`DeviceError`] from libtorch.
    pub fn losses(&self) -> Result<Losses, DeviceError> {
        #[cfg(feature = "torch")]
        if let Some(backend) = &self.torch {
            return backend.agent.losses().map_err(backend.refusal());
        }
        Ok(self.losses)
    }

    /// The present actor.
    ///
    /// # Errors
    /// [`DeviceError`] from libtorch.
    pub fn policy(&mut self) -> Result<Policy, DeviceError> {
        #[cfg(feature = "torch")]
        if let Some(backend) = &self.torch {
            backend.agent.store_actor(&mut self.agent).map_err(backend.refusal())?;
        }
        Ok(self.agent.actor.policy())
    }

    /// The present state of everything, copied to plain memory.
    ///
    /// # Errors
    /// [`DeviceError`] from libtorch.
    pub fn agent(&mut self) -> Result<&mut Agent, DeviceError> {
        #[cfg(feature = "torch")]
        if let Some(backend) = &self.torch {
            backend.agent.store(&mut self.agent).map_err(backend.refusal())?;
        }
        Ok(&mut self.agent)
    }
}
