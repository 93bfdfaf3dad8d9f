//! The robot in a simulated world, and the task that a policy learns in it.
//!
//! Holds the rapier world, the servo model, the power of the servos and the Ant
//! task with its reward. Does not depend on networks or on the link to a robot: the
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
pub use world::{GroundLosses, Soles, StepOutcome, World};
