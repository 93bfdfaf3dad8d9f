//! The robot in a simulated world, and the task that a policy learns in it.
//!
//! Owns the rapier world, the servo law, the power of the servos and the Ant
//! task with its reward. Refuses to know of networks and of serial ports: the
//! learner sees [`crate::env::Env`], the virtual robot sees [`World`].

pub mod ant_env;
mod body;
pub mod open_loop;
mod randomisation;
pub mod reward;
mod servos;
mod start;
mod torso;
mod world;

pub use ant_env::{AntEnv, AntEnvConfig};
pub use randomisation::{Randomisation, Robots};
pub use start::{Perturbation, Start};
pub use torso::TorsoState;
pub use world::{Soles, StepOutcome, Taken, World};
