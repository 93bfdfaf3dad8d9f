//! What an action of 1 is in degrees: in training, and in a gait at amplitude 1.0.
//!
//! Holds these two numbers and their ratio. Does not depend on anything.

/// Degrees from neutral that a policy's action of 1 asks for.
///
/// # Source
/// The paper limits each servo to 45 degrees either way.
pub const POLICY_DEG_PER_ACTION: f64 = 45.0;

/// Degrees that a gait's table moves a joint for an action of 1 at amplitude 1.0.
///
/// # Source
/// The authors' robot: its smoothed tables have 40 ticks of 0.6 degree for an
/// action of 1. The paper sweeps amplifications of 1.0 to 2.4 (figures 6 to 8)
/// and gives no degrees; by its tables, "1.0x" is 0.533 of the trained stroke.
pub const TABLE_DEG_PER_ACTION: f64 = 24.0;

/// The amplitude at which a gait moves as far as its policy did in training: 1.875.
pub const OWN_STROKE: f64 = POLICY_DEG_PER_ACTION / TABLE_DEG_PER_ACTION;
