//! Learning to walk: TD3, the record of what a policy does, learning curves.
//!
//! Does not depend on the link to a robot. [`td3`] knows no simulator: the two
//! meet at [`crate::env::Env`].

pub mod curves;
pub mod record;
pub mod td3;
