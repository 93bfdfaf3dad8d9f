//! One learner, whichever device computes its updates.
//!
//! Owns the choice and the random numbers of an update, which are the same for
//! all. The [`Agent`] in plain memory is what is begun with, saved and acted
//! by: another device starts from its numbers and hands its own back, so
//! weights, files and checkpoints know no device.

use super::agent::{Agent, Losses};
use super::device::{Device, DeviceError};
use super::policy::Policy;
#[cfg(feature = "torch")]
use super::torch::TorchAgent;
use rand_chacha::ChaCha8Rng;

/// An agent and what learns for it.
#[derive(Debug)]
pub struct Learner {
    agent: Agent,
    losses: Losses,
    #[cfg(feature = "torch")]
    torch: Option<Away>,
}

/// The agent's numbers on libtorch; those in plain memory are old until asked for.
#[cfg(feature = "torch")]
#[derive(Debug)]
struct Away {
    device: Device,
    agent: TorchAgent,
    normals: Vec<f32>,
}

#[cfg(feature = "torch")]
impl Away {
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
    /// Has `agent` learn on `device` from here on.
    ///
    /// # Errors
    /// [`DeviceError`] where the device is not there or has no room.
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
        .map(|agent| Away { device, agent, normals: Vec::new() });
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

    /// One update on `batch` (whole rows of the layout) with the smoothing noise of `rng`.
    ///
    /// # Errors
    /// [`DeviceError`] where libtorch refuses.
    pub fn update(&mut self, batch: &[f32], rng: &mut ChaCha8Rng) -> Result<(), DeviceError> {
        #[cfg(feature = "torch")]
        if let Some(away) = &mut self.torch {
            self.agent.draw_normals(batch, rng, &mut away.normals);
            let refusal = away.refusal();
            away.agent.update_with(batch, &away.normals).map_err(refusal)?;
            self.agent.updates += 1;
            return Ok(());
        }
        let losses = self.agent.update(batch, rng);
        self.losses = Losses { actor: losses.actor.or(self.losses.actor), ..losses };
        Ok(())
    }

    /// Of the latest update; the actor's of the latest that moved it.
    ///
    /// # Errors
    /// [`DeviceError`] where libtorch refuses.
    pub fn losses(&self) -> Result<Losses, DeviceError> {
        #[cfg(feature = "torch")]
        if let Some(away) = &self.torch {
            return away.agent.losses().map_err(away.refusal());
        }
        Ok(self.losses)
    }

    /// The actor as it is now.
    ///
    /// # Errors
    /// [`DeviceError`] where libtorch refuses.
    pub fn policy(&mut self) -> Result<Policy, DeviceError> {
        #[cfg(feature = "torch")]
        if let Some(away) = &self.torch {
            away.agent.store_actor(&mut self.agent).map_err(away.refusal())?;
        }
        Ok(self.agent.actor.policy())
    }

    /// Everything as it is now, in plain memory.
    ///
    /// # Errors
    /// [`DeviceError`] where libtorch refuses.
    pub fn agent(&mut self) -> Result<&mut Agent, DeviceError> {
        #[cfg(feature = "torch")]
        if let Some(away) = &self.torch {
            away.agent.store(&mut self.agent).map_err(away.refusal())?;
        }
        Ok(&mut self.agent)
    }
}
