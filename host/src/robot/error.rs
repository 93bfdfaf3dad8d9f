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
    /// An output that the servo driver does not have, or two joints on one.
    #[error(
        "robot description: servo.channels gives {joint} output {channel}, but {problem}; correct the list"
    )]
    Channel {
        /// The joint.
        joint: &'static str,
        /// What it says.
        channel: u8,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// A range of pulses without the neutral one, or beyond what servos take.
    #[error(
        "robot description: servo.pulse_range_us is {shortest} to {longest}, but must begin above 0, end at most \
         at 4000 and contain neutral_pulse_us, which is {neutral}; correct the range"
    )]
    PulseRange {
        /// Shortest pulse.
        shortest: f64,
        /// Longest pulse.
        longest: f64,
        /// Neutral pulse.
        neutral: f64,
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
    /// A xacro, which has to be expanded to a URDF first.
    #[error(
        "it is a xacro, not a URDF yet: it has {what}; expand it with \"xacro FILE.xacro > FILE.urdf\" and \
         name FILE.urdf in robot.toml"
    )]
    Xacro {
        /// What shows that.
        what: String,
    },
    /// A file of one format that is named as one of the other.
    #[error(
        "its first element is <{other_root}> instead of <{root}>; let its name end in {other_ending}, here \
         and in robot.toml"
    )]
    OtherFormat {
        /// Expected by the file's name.
        root: &'static str,
        /// Found.
        other_root: &'static str,
        /// How such files are named.
        other_ending: &'static str,
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
    /// A mass or density below zero.
    #[error("{what} is {value}, but must be 0 or more; correct it")]
    Negative {
        /// What of which element.
        what: String,
        /// The number.
        value: f64,
    },
    /// Fewer numbers than a shape takes, or one that is 0.
    #[error("{what} is a {shape} of size {size:?}, but needs {needs}; write the missing number")]
    Size {
        /// Which element.
        what: String,
        /// What it is.
        shape: &'static str,
        /// What it says, missing ones as 0.
        size: [f64; 3],
        /// What the shape takes.
        needs: &'static str,
    },
    /// Two ends for a shape that has none.
    #[error(
        "{what} has fromto, but is a {shape}; fromto is read for capsule, cylinder, box and ellipsoid: write \
         its type, or its pos instead"
    )]
    FromTo {
        /// Which element.
        what: String,
        /// What it is.
        shape: &'static str,
    },
    /// A shape for looks that would have to be weighed.
    #[error(
        "body {body:?} {why}, so its {shape} would have to be weighed, which is not done here: {next}, or the \
         {shape} mass=\"0\" contype=\"0\" conaffinity=\"0\""
    )]
    Weighed {
        /// On which body.
        body: String,
        /// Why its geoms are weighed.
        why: &'static str,
        /// What it is.
        shape: &'static str,
        /// What to do.
        next: &'static str,
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
         it with these, and keep the {shape} for looks only ({looks})"
    )]
    Shape {
        /// On which body.
        body: String,
        /// What it is.
        shape: &'static str,
        /// How the file's format says that it is for looks only.
        looks: &'static str,
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
         it fixed, or, if it is a hinge, name it there"
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
    /// An MJCF body that is fixed to the world.
    #[error("body {body:?} is fixed to the world; give the robot's first body a <freejoint/>")]
    Held {
        /// The body.
        body: String,
    },
    /// An MJCF body that the world carries by another joint than a free one.
    #[error(
        "joint {joint:?}, a {kind}, ties body {body:?} to the world; replace the joints of that body by one \
         <freejoint/>"
    )]
    Tied {
        /// The joint.
        joint: String,
        /// What it is.
        kind: &'static str,
        /// What it carries.
        body: String,
    },
    /// A URDF's torso that a joint holds.
    #[error("joint {joint:?}, a {kind}, ties the torso {torso:?} to the link {link:?}; {next}")]
    HeldBy {
        /// The joint.
        joint: String,
        /// What it is.
        kind: &'static str,
        /// As in robot.toml.
        torso: String,
        /// What carries it.
        link: String,
        /// What to do.
        next: &'static str,
    },
    /// A URDF whose torso is the ground.
    #[error("the torso is the link \"world\", which is the ground in a URDF; give it another name")]
    Ground,
    /// A floating joint below which not the whole robot is.
    #[error(
        "joint {joint:?} is a floating joint, but the link {link:?} above it is part of the robot; a floating \
         joint may only carry the whole robot: make it fixed, or leave out what is above it"
    )]
    Floating {
        /// The joint.
        joint: String,
        /// A link with mass, shapes or other joints above it.
        link: String,
    },
    /// A leg that sits where another one should.
    #[error(
        "leg {leg}, {hip}, sits at x {x_m:.3}, y {y_m:.3}: {is}, but leg {leg} is {must}; x is forward and y \
         left: order the legs counter-clockwise from front left (front left, rear left, rear right, front \
         right) in model.hips, model.knees and model.feet, or turn the body"
    )]
    LegOrder {
        /// From 1.
        leg: usize,
        /// Its hip's name.
        hip: String,
        /// Forward.
        x_m: f64,
        /// To the left.
        y_m: f64,
        /// Where it is.
        is: &'static str,
        /// Where it must be.
        must: &'static str,
    },
    /// Lengths that no robot of hobby servos has.
    #[error(
        "{what} is {length_m} m, but must be within {least_m} to {most_m} m; lengths are in metres: are these \
         {unit}?"
    )]
    Length {
        /// Which.
        what: String,
        /// In metres.
        length_m: f64,
        /// Limit.
        least_m: f64,
        /// Limit.
        most_m: f64,
        /// A guess, in words.
        unit: &'static str,
    },
    /// A torso whose drawn mass is beyond the bounds of `mass.torso_kg`.
    #[error(
        "the torso {body:?} has {mass_kg} kg, but must have {least_kg} to {most_kg} kg; {hint}, or set \
         mass.torso_kg in robot.toml"
    )]
    Weight {
        /// The torso.
        body: String,
        /// In kilograms.
        mass_kg: f64,
        /// Limit.
        least_kg: f64,
        /// Limit.
        most_kg: f64,
        /// What the unit might be.
        hint: &'static str,
    },
    /// Inertia that a part of that size cannot have.
    #[error(
        "body {body:?} has a radius of gyration of {gyration_m:.3} m (the root of its largest moment of inertia \
         over its mass of {mass_kg} kg), but the part that it belongs to reaches only {reach_m:.3} m from its \
         centre of mass; its <inertial> is a placeholder or in another unit than kg m^2: compute it from the \
         shapes{more}"
    )]
    Gyration {
        /// The body.
        body: String,
        /// In metres.
        gyration_m: f64,
        /// Its mass.
        mass_kg: f64,
        /// From the centre of mass to the farthest point of its part.
        reach_m: f64,
        /// What else the format offers.
        more: &'static str,
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
         rigid body can have; {next}"
    )]
    Inertia {
        /// The first body of the part.
        body: String,
        /// Its mass.
        mass_kg: f64,
        /// Its principal moments.
        moments: [f64; 3],
        /// What to do.
        next: &'static str,
    },
    /// A rotated inertial frame, which the loader would ignore.
    #[error("link {link:?} has a rotated <inertial> (rpy); give its inertia along the link's axes")]
    TurnedInertia {
        /// The link.
        link: String,
    },
    /// An empty joint range.
    #[error("joint {joint:?} has the range {low} to {high} rad, from 0 where it is drawn; {next}")]
    Range {
        /// The joint.
        joint: String,
        /// From.
        low: f64,
        /// To.
        high: f64,
        /// What to do.
        next: &'static str,
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
         {low_deg:.1} to {high_deg:.1}; {next}"
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
        /// What to do.
        next: String,
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
