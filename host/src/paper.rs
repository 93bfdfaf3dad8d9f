//! What the paper prints: Zhu and Rosendo, *PSTO: Learning Energy-Efficient
//! Locomotion for Quadruped Robots*, Machines 2022, 10, 185.
//!
//! Holds its numbers. The study's table of methods says which method has which.

use crate::robot::LegScale;

/// Amplifications of sections 2.4 and 3.
pub const AMPLIFICATIONS: [f64; 8] = [1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.4];
/// Legs of both groups, in units of 23 cm.
pub const LEGS: [LegScale; 2] = [LegScale::LONG, LegScale::SHORT];
/// Length of a trial.
pub const TRIAL_S: f64 = 12.0;
/// The speed at which Figure 5 compares.
pub const FIGURE_5_SPEED_M_S: f64 = 0.12;
/// The speed that its robot does not exceed.
pub const TOP_SPEED_M_S: f64 = 0.139;

/// What is printed for one method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Printed {
    /// Table 2: cost of transport and speed in m/s of the method's best, for each of [`LEGS`].
    pub table_2: [(f64, f64); 2],
    /// Figure 5 and section 3: mean power at 0.12 m/s on long legs.
    pub figure_5_w: f64,
}

/// The averaged stride, sample by sample.
pub const ORIGINAL: Printed = Printed { table_2: [(0.688, 0.127), (0.839, 0.096)], figure_5_w: 0.837 };
/// Sine waves.
pub const SINUSOID: Printed = Printed { table_2: [(0.639, 0.127), (0.764, 0.104)], figure_5_w: 0.802 };
/// Polynomials of degree 10 through the stride.
pub const PSTO: Printed = Printed { table_2: [(0.595, 0.139), (0.563, 0.139)], figure_5_w: 0.776 };
