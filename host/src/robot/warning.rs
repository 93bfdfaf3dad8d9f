//! What of a robot is probably not meant as it is written.
//!
//! Holds the kinds of warning and their words; the robot is used as it is
//! written. Does not depend on how they are found. What cannot be meant at all is
//! an error instead ([`super::ModelError`]).

use serde::Serialize;
use thiserror::Error;

/// One thing to look at, with the value, what it is held against, and the next move.
#[derive(Debug, Clone, PartialEq, Serialize, Error)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum RobotWarning {
    /// A hinge that turns farther than any servo: its limits are in another unit.
    #[error(
        "joint {joint:?} may turn from {low} to {high} {unit}, {turns:.1} turns, so that its limits limit \
         nothing; {hint}"
    )]
    WideRange {
        /// The joint.
        joint: String,
        /// In the file's unit.
        low: f64,
        /// In the file's unit.
        high: f64,
        /// The file's unit.
        unit: &'static str,
        /// From end to end.
        turns: f64,
        /// What may be wrong, in the file's own format.
        hint: &'static str,
    },
    /// Hinges that hardly turn: their limits are in another unit.
    #[error(
        "joint {joint:?} may turn from {low} to {high} degrees only, and {count} of the file's {of} limited \
         hinges less than 4 degrees either way; {hint}"
    )]
    NarrowRange {
        /// The first of them.
        joint: String,
        /// In degrees.
        low: f64,
        /// In degrees.
        high: f64,
        /// How many.
        count: usize,
        /// How many have limits.
        of: usize,
        /// What may be wrong, in the file's own format.
        hint: &'static str,
    },
    /// A turn of more than a full one: it is in degrees.
    #[error(
        "the rpy of {what} has {angle} rad, more than a full turn; URDF's rpy is in radians: {angle} degrees \
         are {radians:.4} rad"
    )]
    Turned {
        /// Which origin.
        what: String,
        /// As written.
        angle: f64,
        /// The same number, taken as degrees.
        radians: f64,
    },
    /// A density that only gases and foams have.
    #[error(
        "a geom of body {body:?} has a density of {density} kg/m^3; printed plastic has about 1240: is it in \
         g/cm^3?"
    )]
    Density {
        /// The body.
        body: String,
        /// As written.
        density: f64,
    },
    /// More inertia than the part's size has room for.
    #[error(
        "body {body:?} has a radius of gyration of {gyration_m:.3} m, but the part that it belongs to reaches \
         only {reach_m:.3} m from its centre of mass; is its <inertial> a placeholder? The robot turns slower \
         with it than a real one"
    )]
    Gyration {
        /// The body.
        body: String,
        /// Root of the largest moment of inertia over the mass.
        gyration_m: f64,
        /// From the centre of mass to the part's farthest point.
        reach_m: f64,
    },
    /// Far less inertia than the part's size.
    #[error(
        "the part with {body:?} has a radius of gyration of {gyration_m:.5} m, but reaches {reach_m:.3} m from \
         its centre of mass; is its <inertial> a placeholder, or in another unit than kg m^2?"
    )]
    PointMass {
        /// The first body of the part.
        body: String,
        /// Root of the largest moment of inertia over the mass.
        gyration_m: f64,
        /// From the centre of mass to the part's farthest point.
        reach_m: f64,
    },
    /// Legs longer or shorter than those of robots with hobby servos.
    #[error("{what} is {length_m:.3} m; lengths are in metres: are these {unit}?")]
    Length {
        /// Which.
        what: String,
        /// In metres.
        length_m: f64,
        /// A guess, in words.
        unit: &'static str,
    },
    /// A part denser than any metal.
    #[error(
        "the part with {body:?} has {mass_kg} kg within {reach_m:.3} m of its centre of mass, which is denser \
         than a ball of steel; masses are in kilograms: are these grams?"
    )]
    Dense {
        /// The first body of the part.
        body: String,
        /// Its mass.
        mass_kg: f64,
        /// From the centre of mass to the part's farthest point.
        reach_m: f64,
    },
    /// A shin that touches before its foot.
    #[error(
        "the shin of leg {leg} reaches {below_mm:.1} mm below the ball of its foot {foot:?} as the robot \
         stands; it touches first, which counts as dragging: make the ball thicker than the shin, or the shin \
         shorter"
    )]
    ShinBelowFoot {
        /// From 1.
        leg: usize,
        /// The foot's body.
        foot: String,
        /// In millimetres.
        below_mm: f64,
    },
    /// Servos that cannot hold the robot's weight.
    #[error(
        "the servos cannot carry the robot of {mass_kg:.2} kg: to stand at neutral, {joint:?} has to hold \
         {needed_n_m:.2} N m, but servo.torque_limit_n_m is {limit_n_m}; take stronger servos, shorter legs or \
         less mass"
    )]
    TooHeavy {
        /// Of all parts.
        mass_kg: f64,
        /// The joint that holds most.
        joint: String,
        /// With a quarter of the weight on each foot.
        needed_n_m: f64,
        /// Of the servos.
        limit_n_m: f64,
    },
    /// A supply that cannot feed the robot as it stands.
    #[error(
        "to stand at neutral, the robot draws {needed_w:.2} W, but a supply of {nominal_v} V behind \
         {resistance_ohm} ohm gives {most_w:.2} W at most (V^2 / 4R); correct [supply] or [power]"
    )]
    WeakSupply {
        /// Electronics, and the heat of holding the weight.
        needed_w: f64,
        /// Without load.
        nominal_v: f64,
        /// Supply and leads.
        resistance_ohm: f64,
        /// What it can give.
        most_w: f64,
    },
}
