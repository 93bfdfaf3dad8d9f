//! Why a robot was refused: every message names the value, the limit and the next move.

use crate::run_folder::FileError;
use rapier3d_mjcf::mjcf_rs;
use rapier3d_urdf::urdf_rs;
use std::path::PathBuf;
use thiserror::Error;

/// Why a robot's folder was refused.
#[derive(Debug, Error)]
pub enum RobotError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The text is not TOML, or lacks a field or has one too many.
    #[error("{path} is not a robot description")]
    Parse {
        /// Which file.
        path: PathBuf,
        /// Where and why.
        source: Box<toml::de::Error>,
    },
    /// The robot's body cannot be used.
    #[error("the body in {path} cannot be used")]
    Model {
        /// The body's file.
        path: PathBuf,
        /// Why.
        source: Box<ModelError>,
    },
    /// A number outside its bounds, or NaN.
    #[error("robot description: {field} is {value}, but must be within {min} to {max}; correct the value")]
    OutOfRange {
        /// Path of the field in the file.
        field: &'static str,
        /// What it says.
        value: f64,
        /// Least allowed.
        min: f64,
        /// Most allowed.
        max: f64,
    },
    /// A negative, huge or NaN standard deviation.
    #[error(
        "robot description: twin.spread gives {name} the standard deviation {value}, but it must be within 0 \
         to 1000; correct the value, or fit the robot again"
    )]
    Spread {
        /// The fitted parameter.
        name: String,
        /// What it says.
        value: f64,
    },
    /// It has a number that descriptions no longer have.
    #[error(
        "{path} has {name}, which descriptions of an older release had; repeat the run or the fit, or \
         delete that line"
    )]
    NoLonger {
        /// The file.
        path: PathBuf,
        /// The field.
        name: &'static str,
    },
    /// A robot in one file; a robot is a folder.
    #[error(
        "{path} has no [model]: it is a robot in one file, of an older release; repeat the run, or name a \
         robot's folder"
    )]
    OldFile {
        /// The file.
        path: PathBuf,
    },
}

/// Why a body's file was refused.
#[derive(Debug, Error)]
pub enum ModelError {
    /// Neither format.
    #[error("model.file is {file:?}; name a file beside robot.toml that ends in .xml (MJCF) or .urdf")]
    Name {
        /// As in the description.
        file: String,
    },
    /// A file too large for a parser.
    #[error("it has {bytes} bytes, but must have at most {most}; leave out what is drawn for looks only")]
    TooLong {
        /// How many.
        bytes: usize,
        /// Limit.
        most: usize,
    },
    /// Elements nested too deep for a parser's stack.
    #[error("its elements are nested more than {most} deep; is a closing tag missing?")]
    TooDeep {
        /// Limit.
        most: usize,
    },
    /// Text that is not XML.
    #[error("it is not XML; correct what the cause names")]
    Xml(#[source] Box<quick_xml::Error>),
    /// A body in several files cannot be kept with a run.
    #[error("it includes other files with <{tag}>; put everything into one file")]
    Include {
        /// Which element does.
        tag: &'static str,
    },
    /// XML that is not MJCF.
    #[error("it is not MJCF")]
    Mjcf(#[source] Box<mjcf_rs::ParseError>),
    /// XML that is not URDF.
    #[error("it is not URDF")]
    Urdf(#[source] Box<urdf_rs::UrdfError>),
    /// NaN, infinite or far too large.
    #[error("{what} has the number {value}, but must be within -{most} to {most}; correct it")]
    Number {
        /// Which element.
        what: String,
        /// The number.
        value: f64,
        /// Limit.
        most: f64,
    },
    /// A size or mass below or at zero.
    #[error("{what} is {value}, but must be more than 0; correct it")]
    NotPositive {
        /// What of which element.
        what: String,
        /// The number.
        value: f64,
    },
    /// A shape for touching that cannot be read.
    #[error(
        "body {body:?} touches with a {shape}; only sphere, capsule, cylinder and box can touch here: draw \
         it with these, and keep the {shape} for looks only"
    )]
    Shape {
        /// On which body.
        body: String,
        /// What it is.
        shape: &'static str,
    },
    /// A name in robot.toml that the body's file does not have.
    #[error("{field} names {name:?}, but the file has {has}; correct the name")]
    Unknown {
        /// Field of robot.toml.
        field: &'static str,
        /// What it names.
        name: String,
        /// What there is.
        has: String,
    },
    /// Two joints or two bodies with the same name.
    #[error("the name {name:?} is used twice; give each its own")]
    Twice {
        /// The name.
        name: String,
    },
    /// A joint that no servo moves.
    #[error(
        "joint {name:?} is a {kind}, but only the eight hinges of model.hips and model.knees may move; make \
         it fixed, or name it there"
    )]
    Moves {
        /// The joint.
        name: String,
        /// What it is.
        kind: &'static str,
    },
    /// Bodies that do not form a tree.
    #[error("body {body:?} is its own ancestor or has two parents; a robot is a tree")]
    Loop {
        /// The body.
        body: String,
    },
    /// A body that is not connected to the torso.
    #[error("body {body:?} is not connected to the robot; leave it out, or fix it to a part")]
    Loose {
        /// The body.
        body: String,
    },
    /// The torso cannot move.
    #[error("the torso {body:?} is fixed to the world; give it a <freejoint/>")]
    Held {
        /// The torso.
        body: String,
    },
    /// Not torso, thigh, shin.
    #[error(
        "{field} names {name:?}, which sits on {on:?}, but must sit on {must}; is the order legs 1 to 4?"
    )]
    Elsewhere {
        /// Field of robot.toml.
        field: &'static str,
        /// The joint or body.
        name: String,
        /// The body that it sits on.
        on: String,
        /// What it must sit on.
        must: String,
    },
    /// Mass or moments of inertia that no rigid body can have.
    #[error(
        "the part with {body:?} has {mass_kg} kg and moments of inertia {moments:?} kg m^2, which no \
         rigid body can have; correct them"
    )]
    Inertia {
        /// The first body of the part.
        body: String,
        /// Its mass.
        mass_kg: f64,
        /// Its principal moments.
        moments: [f64; 3],
    },
    /// A rotated inertial frame, which the loader would ignore.
    #[error("link {link:?} has a rotated <inertial> (rpy); give its inertia along the link's axes")]
    TurnedInertia {
        /// The link.
        link: String,
    },
    /// An empty joint range.
    #[error(
        "joint {joint:?} has the range {low} to {high} rad; the first must be below the second, or leave it out"
    )]
    Range {
        /// The joint.
        joint: String,
        /// From.
        low: f64,
        /// To.
        high: f64,
    },
    /// Springs and couplings are not simulated.
    #[error("{what} is not simulated here; leave it out")]
    Unsupported {
        /// What.
        what: String,
    },
    /// A foot is one ball.
    #[error("model.feet names {body:?}, which has {balls} balls to touch with, but a foot is exactly 1")]
    Foot {
        /// The body.
        body: String,
        /// How many.
        balls: usize,
    },
    /// A foot on its knee's axis.
    #[error("foot {body:?} sits on the axis of its knee, so the shin has no direction; move it away")]
    NoShin {
        /// The body.
        body: String,
    },
    /// Legs that differ where the description gives one number for all.
    #[error("the legs' {what} differ, from {least} to {most}; draw them alike, or set {field}")]
    Unlike {
        /// What of the legs.
        what: &'static str,
        /// Least.
        least: f64,
        /// Most.
        most: f64,
        /// The field that overrides it.
        field: &'static str,
    },
    /// A neutral position outside the joint's range.
    #[error(
        "joint {joint:?} is to be neutral {neutral_deg:.1} degrees from where it is drawn, but turns from \
         {low_deg:.1} to {high_deg:.1}; change its range or geometry.shin_below_horizontal_deg"
    )]
    Neutral {
        /// The joint.
        joint: String,
        /// Asked.
        neutral_deg: f64,
        /// From.
        low_deg: f64,
        /// To.
        high_deg: f64,
    },
    /// A slope that turning the knee does not give.
    #[error(
        "geometry.shin_below_horizontal_deg is {asked_deg}, but turning {joint:?} slopes its shin by \
         {least_deg:.1} to {most_deg:.1} degrees only; choose one of these"
    )]
    Slope {
        /// The knee.
        joint: String,
        /// Asked.
        asked_deg: f64,
        /// Least that it can be.
        least_deg: f64,
        /// Most that it can be.
        most_deg: f64,
    },
}
