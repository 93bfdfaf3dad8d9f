//! Learning to walk: TD3, the record of what a policy does, learning curves.
//!
//! Holds the learner ([`td3`]), the configuration of a run ([`run_config`],
//! [`preset`]), the recording of a policy's stride and the statistics over seeds.
//! Does not depend on the link to a robot. [`td3`] depends on no simulator: it sees
//! a task as [`crate::env::Env`]. What joins both, such as [`run_config`] and
//! [`record`], stands beside it.

pub mod curves;
pub mod preset;
pub mod record;
pub mod run_config;
pub mod td3;
pub mod train_result;
