//! The body that a description makes of a drawing.
//!
//! Holds the overrides: leg scale, the shins' slope at neutral, foot radius,
//! torso mass. All angles here are from neutral. The result is valid for
//! any finite numbers; [`check_neutral`] tells whether it has the slope that was
//! asked. Does not depend on files.

use super::Robot;
use super::drawn::{Drawn, DrawnLeg, Part, weld};
use super::error::ModelError;
use super::inertia::{Inertia, Stretch};
use super::raw::Hinge;
use super::solid::Solid;
use core::f64::consts::PI;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use protocol::{JOINT_COUNT, LEG_COUNT};

/// Legs are drawn by hand: within these they are alike.
const ALIKE_DEG: f64 = 0.1;
const ALIKE_M: f64 = 1e-5;
/// Many joints are drawn at the end of their range; so far beyond it is rounding.
const AT_END_RAD: f64 = 1e-3;

/// Bodies that move as one.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// In its own frame.
    pub inertia: Inertia,
    /// What it touches with, the foot's ball excluded.
    pub solids: Vec<Solid>,
}

/// A leg; the angles of its hinges are 0 at neutral.
#[derive(Debug, Clone, PartialEq)]
pub struct Leg {
    /// Torso to thigh.
    pub hip: Hinge,
    /// Thigh to shin.
    pub knee: Hinge,
    /// Between hip and knee.
    pub thigh: Link,
    /// Below the knee.
    pub shin: Link,
    /// Middle of the foot's ball, in the shin's frame.
    pub foot_m: Point3<f64>,
}

/// A robot's body, as it is built.
#[derive(Debug, Clone, PartialEq)]
pub struct Limbs {
    /// In the robot's frame: z up, x forward.
    pub torso: Link,
    /// Legs 1 to 4.
    pub legs: [Leg; LEG_COUNT],
    /// Of all feet.
    pub foot_radius_m: f64,
}

impl Limbs {
    /// The drawn body with what the description changes.
    #[must_use]
    pub fn of(robot: &Robot) -> Self {
        let mut torso = robot.drawn.torso.clone();
        torso[0].inertia = torso[0].inertia.weighing(robot.mass.torso_kg);
        Self {
            torso: link(&torso),
            legs: core::array::from_fn(|leg| Leg::of(robot, &robot.drawn.legs[leg])),
            foot_radius_m: robot.geometry.foot_radius_m,
        }
    }

    /// All of it.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        let legs = self.legs.iter().map(|leg| leg.thigh.inertia.mass_kg + leg.shin.inertia.mass_kg);
        self.torso.inertia.mass_kg + legs.sum::<f64>()
    }

    /// How high the level torso's frame stands over the ground, resting on
    /// whatever is lowest.
    #[must_use]
    pub fn standing_height_m(&self, joint_angles_rad: &[f64; JOINT_COUNT]) -> f64 {
        let of = |link: &Link, pose: &Isometry3<f64>| {
            link.solids.iter().map(|solid| solid.lowest_m(pose)).fold(f64::INFINITY, f64::min)
        };
        let mut lowest_m = of(&self.torso, &Isometry3::identity());
        for (leg, [hip, knee]) in self.legs.iter().zip(pairs(joint_angles_rad)) {
            let thigh = leg.hip.at(hip);
            let shin = thigh * leg.knee.at(knee);
            let foot_m = (shin * leg.foot_m).z - self.foot_radius_m;
            lowest_m = lowest_m.min(of(&leg.thigh, &thigh)).min(of(&leg.shin, &shin)).min(foot_m);
        }
        -lowest_m
    }

    /// What each joint carries next, about its axis: the least that a torque
    /// there has to turn. Hips 1 to 4, then knees.
    #[must_use]
    pub fn carried_kg_m2(&self) -> [f64; JOINT_COUNT] {
        core::array::from_fn(|j| {
            let leg = &self.legs[j % LEG_COUNT];
            let (hinge, link) = if j < LEG_COUNT { (&leg.hip, &leg.thigh) } else { (&leg.knee, &leg.shin) };
            let about = link.inertia.moved(&hinge.in_child.inverse());
            let off_axis_m = about.centre_m.y.hypot(about.centre_m.z);
            about.tensor_kg_m2[(0, 0)] + about.mass_kg * off_axis_m * off_axis_m
        })
    }

    /// How far each joint turns from neutral: its own range or the servo's end
    /// stop, whichever is tighter. Hips 1 to 4, then knees.
    #[must_use]
    pub fn stops_rad(&self, robot: &Robot) -> [[f64; 2]; JOINT_COUNT] {
        let stop_rad = robot.servo.end_stop_deg.to_radians();
        core::array::from_fn(|j| {
            let leg = &self.legs[j % LEG_COUNT];
            let [low, high] = if j < LEG_COUNT { &leg.hip } else { &leg.knee }
                .range_rad
                .unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            [low.max(-stop_rad), high.min(stop_rad)]
        })
    }
}

/// Hip and knee of each leg.
fn pairs(joint_angles_rad: &[f64; JOINT_COUNT]) -> [[f64; 2]; LEG_COUNT] {
    core::array::from_fn(|leg| [joint_angles_rad[leg], joint_angles_rad[LEG_COUNT + leg]])
}

fn link(part: &Part) -> Link {
    let solids = part.iter().flat_map(|piece| piece.solids.iter().cloned()).collect();
    Link { inertia: weld(part), solids }
}

/// A part with its scaled pieces drawn out, and the others moved along.
fn scaled(part: &Part, stretch: &Stretch) -> Part {
    let mut part = part.clone();
    for piece in &mut part {
        if piece.scaled {
            piece.inertia = piece.inertia.stretched(stretch);
        } else {
            piece.inertia.centre_m = stretch.point(&piece.inertia.centre_m);
        }
        for solid in &mut piece.solids {
            *solid = if piece.scaled { solid.stretched(stretch) } else { solid.shifted(stretch) };
        }
    }
    part
}

/// How a limb from one point to another is drawn out; not at all without scaled pieces.
fn stretch_of(part: &Part, from_m: Point3<f64>, to_m: Point3<f64>, leg_scale: f64) -> Stretch {
    let scale = if part.iter().any(|piece| piece.scaled) { leg_scale } else { 1.0 };
    // A limb without length has no direction to be drawn out in.
    let along = (to_m - from_m).try_normalize(1e-9).unwrap_or_else(Vector3::zeros);
    Stretch { from_m, along, scale }
}

impl Leg {
    fn of(robot: &Robot, drawn: &DrawnLeg) -> Self {
        let scale = robot.geometry.leg_scale.value();
        let hip_m: Point3<f64> = drawn.hip.in_child.translation.vector.into();
        let knee_m: Point3<f64> = drawn.knee.in_parent.translation.vector.into();
        let thigh_stretch = stretch_of(&drawn.thigh, hip_m, knee_m, scale);
        let mut knee = drawn.knee.clone();
        knee.in_parent.translation = thigh_stretch.point(&knee_m).into();

        let knee_m: Point3<f64> = knee.in_child.translation.vector.into();
        let (ball_m, drawn_radius_m) = drawn.ball();
        let shin_stretch = stretch_of(&drawn.shin, knee_m, ball_m, scale);
        let mut shin = scaled(&drawn.shin, &shin_stretch);
        let (piece, solid) = drawn.foot;
        shin[piece].solids.remove(solid);
        // The tip is the limb's end; a larger ball has its middle farther from it.
        let tip_m = (ball_m - knee_m).norm() + drawn_radius_m;
        let direction = (ball_m - knee_m).normalize();
        let foot_m = knee_m + direction * (shin_stretch.scale * tip_m - robot.geometry.foot_radius_m);

        let turn_rad = Slopes::of(drawn).nearest_rad(robot.geometry.shin_below_horizontal_deg.to_radians());
        // Neutral reads 0 from here on.
        knee.in_child *= UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -turn_rad);
        knee.range_rad = knee.range_rad.map(|range| with_neutral(range.map(|end| end - turn_rad)));
        let mut hip = drawn.hip.clone();
        hip.range_rad = hip.range_rad.map(with_neutral);
        Self { hip, knee, thigh: link(&scaled(&drawn.thigh, &thigh_stretch)), shin: link(&shin), foot_m }
    }
}

/// The range with neutral in it, where that is outside by rounding only.
fn with_neutral([low, high]: [f64; 2]) -> [f64; 2] {
    let low = if low > 0.0 && low < AT_END_RAD { 0.0 } else { low };
    let high = if high < 0.0 && high > -AT_END_RAD { 0.0 } else { high };
    [low, high]
}

/// How a shin slopes as its knee turns, all other joints as drawn.
struct Slopes {
    /// `sin(slope) = mean + swing * cos(turn - phase)`.
    mean: f64,
    swing: f64,
    phase_rad: f64,
}

impl Slopes {
    fn of(drawn: &DrawnLeg) -> Self {
        let knee_m: Point3<f64> = drawn.knee.in_child.translation.vector.into();
        let shin = (drawn.ball().0 - knee_m).normalize();
        // In the knee's frame it turns about x; what of the world's down lies in that frame?
        let shin = drawn.knee.in_child.rotation.inverse() * shin;
        let knee = drawn.hip.at(0.0).rotation * drawn.knee.in_parent.rotation;
        let down = knee.inverse() * -Vector3::z();
        let cosine = down.y * shin.y + down.z * shin.z;
        let sine = down.z * shin.y - down.y * shin.z;
        Self { mean: down.x * shin.x, swing: cosine.hypot(sine), phase_rad: sine.atan2(cosine) }
    }

    fn at_rad(&self, turn_rad: f64) -> f64 {
        (self.mean + self.swing * (turn_rad - self.phase_rad).cos()).clamp(-1.0, 1.0).asin()
    }

    /// The least turn that gives a slope, or comes nearest to it.
    fn nearest_rad(&self, slope_rad: f64) -> f64 {
        let share = ((slope_rad.sin() - self.mean) / self.swing.max(1e-12)).clamp(-1.0, 1.0);
        let least = |turn: f64| turn - 2.0 * PI * (turn / (2.0 * PI)).round();
        let (one, other) = (least(self.phase_rad + share.acos()), least(self.phase_rad - share.acos()));
        if one.abs() <= other.abs() { one } else { other }
    }

    fn range_rad(&self) -> [f64; 2] {
        [(self.mean - self.swing).max(-1.0).asin(), (self.mean + self.swing).min(1.0).asin()]
    }
}

/// The one value that all legs have as drawn.
fn alike(
    values: [f64; LEG_COUNT],
    within: f64,
    what: &'static str,
    field: &'static str,
) -> Result<f64, ModelError> {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    if most - least <= within { Ok(values[0]) } else { Err(ModelError::Unlike { what, least, most, field }) }
}

/// The shins' slope as drawn.
pub fn drawn_slope_deg(drawn: &Drawn) -> Result<f64, ModelError> {
    let slopes: [f64; LEG_COUNT] = core::array::from_fn(|leg| {
        let slope_deg = Slopes::of(&drawn.legs[leg]).at_rad(0.0).to_degrees();
        // Loaders keep rotations in single precision.
        (slope_deg * 1e4).round() / 1e4
    });
    alike(slopes, ALIKE_DEG, "shins' slopes in degrees", "geometry.shin_below_horizontal_deg")
}

/// The feet's radius as drawn.
pub fn drawn_radius_m(drawn: &Drawn) -> Result<f64, ModelError> {
    let radii: [f64; LEG_COUNT] = core::array::from_fn(|leg| drawn.legs[leg].ball().1);
    alike(radii, ALIKE_M, "feet's radii in metres", "geometry.foot_radius_m")
}

/// Knee to tip of the shortest shin as drawn.
pub fn shortest_drawn_shin_m(drawn: &Drawn) -> f64 {
    let length = |leg: &DrawnLeg| {
        let (ball_m, radius_m) = leg.ball();
        (ball_m.coords - leg.knee.in_child.translation.vector).norm() + radius_m
    };
    drawn.legs.iter().map(length).fold(f64::INFINITY, f64::min)
}

/// Whether the knees can be turned to the asked neutral, and all joints stand there.
pub fn check_neutral(robot: &Robot) -> Result<(), ModelError> {
    let asked_deg = robot.geometry.shin_below_horizontal_deg;
    let names = robot.model.hips.iter().chain(&robot.model.knees);
    for (j, joint) in names.enumerate() {
        let leg = &robot.drawn.legs[j % LEG_COUNT];
        let mut neutral_rad = 0.0;
        if j >= 4 {
            let slopes = Slopes::of(leg);
            neutral_rad = slopes.nearest_rad(asked_deg.to_radians());
            if (slopes.at_rad(neutral_rad).to_degrees() - asked_deg).abs() > ALIKE_DEG {
                let [least_deg, most_deg] = slopes.range_rad().map(f64::to_degrees);
                return Err(ModelError::Slope { joint: joint.clone(), asked_deg, least_deg, most_deg });
            }
        }
        let range_rad = if j < LEG_COUNT { leg.hip.range_rad } else { leg.knee.range_rad };
        let [low, high] = range_rad.unwrap_or([-2.0 * PI, 2.0 * PI]);
        if !(low - AT_END_RAD..=high + AT_END_RAD).contains(&neutral_rad) {
            let next = if j < LEG_COUNT {
                "a hip is neutral as it is drawn: turn its drawing, or change its range".to_owned()
            } else {
                let [one, other] = [low, high].map(|end| Slopes::of(leg).at_rad(end).to_degrees());
                format!(
                    "change its range or geometry.shin_below_horizontal_deg; the ends of its range slope the \
                     shin by {one:.1} and {other:.1} degrees"
                )
            };
            return Err(ModelError::Neutral {
                joint: joint.clone(),
                neutral_deg: neutral_rad.to_degrees(),
                low_deg: low.to_degrees(),
                high_deg: high.to_degrees(),
                next,
            });
        }
    }
    Ok(())
}
