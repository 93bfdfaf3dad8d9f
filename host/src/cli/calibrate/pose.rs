//! What a joint looks like at neutral, and which way it turns: words and a picture.
//!
//! Holds the angles, which come from the robot's drawing. Does not depend on the
//! questions or on a link to a robot.

use crate::robot::{Limbs, Robot};
use nalgebra::{Point3, Vector3};
use protocol::{Joint, LEG_COUNT};
use std::fmt::Write as _;

/// A hinge or a movement closer to an axis than this (cosine of 45 degrees) is described by it.
const ALONG: f64 = 0.7;
/// Share of a movement below which it is not mentioned.
const LITTLE: f64 = 0.25;
/// How far the picture shows the joint turned, in degrees.
const SHOWN_DEG: f64 = 30.0;

/// A joint of a robot, all joints at neutral.
pub struct Pose {
    joint: Joint,
    /// Pivots, ends and feet of all legs, in the torso's frame: x forward, y left, z up.
    legs: [[Point3<f64>; 3]; LEG_COUNT],
    /// Of the joint, by the right hand.
    axis: Vector3<f64>,
    /// The same leg with the joint turned by [`SHOWN_DEG`].
    turned: [Point3<f64>; 3],
}

impl Pose {
    /// The joint as the robot is drawn.
    pub fn of(robot: &Robot, joint: Joint) -> Self {
        let limbs = Limbs::of(robot);
        let leg_at = |leg: usize, hip_rad: f64, knee_rad: f64| {
            let leg = &limbs.legs[leg];
            let thigh = leg.hip.at(hip_rad);
            let shin = thigh * leg.knee.at(knee_rad);
            let hip_m: Point3<f64> = leg.hip.in_parent.translation.vector.into();
            [hip_m, thigh * Point3::from(leg.knee.in_parent.translation.vector), shin * leg.foot_m]
        };
        let leg = joint.index() % LEG_COUNT;
        let turn_rad = SHOWN_DEG.to_radians();
        let (turned, frame) = if joint.is_hip() {
            (leg_at(leg, turn_rad, 0.0), limbs.legs[leg].hip.in_parent)
        } else {
            let thigh = limbs.legs[leg].hip.at(0.0);
            (leg_at(leg, 0.0, turn_rad), thigh * limbs.legs[leg].knee.in_parent)
        };
        Self {
            joint,
            legs: core::array::from_fn(|leg| leg_at(leg, 0.0, 0.0)),
            axis: frame.rotation * Vector3::x(),
            turned,
        }
    }

    fn leg(&self) -> &[Point3<f64>; 3] {
        &self.legs[self.joint.index() % LEG_COUNT]
    }

    /// From the joint to the end of the limb that it turns; of a hip without a thigh, to the foot.
    fn limb(&self) -> Vector3<f64> {
        let [hip, knee, foot] = self.leg();
        let thigh = knee - hip;
        let level = Vector3::new(thigh.x, thigh.y, 0.0);
        let limb = match (self.joint.is_hip(), self.is_upright()) {
            (true, true) if level.norm() > 1e-3 => thigh,
            (true, false) if thigh.norm() > 1e-3 => thigh,
            (true, _) => foot - hip,
            (false, _) => foot - knee,
        };
        limb.try_normalize(1e-9).unwrap_or_else(Vector3::x)
    }

    /// Whether the joint turns about the vertical.
    fn is_upright(&self) -> bool {
        self.axis.z.abs() > ALONG
    }

    /// How to hold the joint at neutral.
    pub fn neutral(&self) -> String {
        let limb = self.limb();
        let part = if self.joint.is_hip() { "leg" } else { "shin" };
        if self.is_upright() {
            let azimuth_deg = limb.y.atan2(limb.x).to_degrees();
            let side = if azimuth_deg < 0.0 { "right" } else { "left" };
            return match azimuth_deg.abs().round() {
                0.0 => format!("turn the {part} until it points straight ahead, seen from above"),
                180.0 => format!("turn the {part} until it points straight back, seen from above"),
                deg => format!(
                    "turn the {part} until it points {deg:.0} degrees to the {side} of straight ahead, seen from above"
                ),
            };
        }
        let slope_deg = (-limb.z).clamp(-1.0, 1.0).asin().to_degrees();
        match slope_deg.round() {
            0.0 => format!("turn the {part} until it is horizontal"),
            90.0 => format!("turn the {part} until it points straight down"),
            deg if deg > 0.0 => {
                format!("turn the {part} until it slopes {deg:.0} degrees below the horizontal")
            }
            deg => format!("turn the {part} until it slopes {:.0} degrees above the horizontal", -deg),
        }
    }

    /// A question whose answer is yes if the joint turned towards positive angles.
    pub fn direction(&self) -> String {
        let part = if self.joint.is_hip() { "leg" } else { "shin" };
        if self.is_upright() {
            let sense = if self.axis.z > 0.0 { "counter-clockwise" } else { "clockwise" };
            return format!("did the {part} swing {sense}, seen from above?");
        }
        let moved = self.axis.cross(&self.limb()).try_normalize(1e-9).unwrap_or_else(Vector3::z);
        let [hip, _, foot] = self.leg();
        // Outward is away from the torso's middle, along the leg.
        let away = Vector3::new(foot.x - hip.x, foot.y - hip.y, 0.0);
        let away = away.try_normalize(1e-3).unwrap_or_else(|| Vector3::new(hip.x, hip.y, 0.0).normalize());
        let mut ways = Vec::new();
        for (share, positive, negative) in [(moved.z, "up", "down"), (moved.dot(&away), "outward", "inward")]
        {
            if share.abs() > LITTLE {
                ways.push(if share > 0.0 { positive } else { negative });
            }
        }
        if ways.is_empty() {
            ways.push(if moved.x > 0.0 { "forward" } else { "back" });
        }
        let verb = if self.joint.is_hip() { "swing" } else { "fold" };
        format!("did the {part} {verb} {}?", ways.join(" and "))
    }

    /// The robot from above or from the side, the joint's limb at neutral in red, and
    /// towards positive angles dashed.
    pub fn svg(&self) -> String {
        const SIZE: f64 = 360.0;
        let [hip, _, foot] = self.leg();
        let along = Vector3::new(foot.x - hip.x, foot.y - hip.y, 0.0);
        let along = along.try_normalize(1e-3).unwrap_or_else(Vector3::x);
        // From above, forward is up; from the side, the leg points to the right.
        let flat = |point: &Point3<f64>| {
            if self.is_upright() { [-point.y, -point.x] } else { [point.coords.dot(&along), -point.z] }
        };
        let shown: Vec<&[Point3<f64>; 3]> =
            if self.is_upright() { self.legs.iter().collect() } else { vec![self.leg()] };
        let all: Vec<[f64; 2]> = shown
            .iter()
            .flat_map(|leg| leg.iter())
            .chain(&self.turned)
            .map(flat)
            .chain([[0.0, 0.0]])
            .collect();
        let extent = |axis: usize| {
            let of = |pick: fn(f64, f64) -> f64, start: f64| all.iter().map(|p| p[axis]).fold(start, pick);
            (of(f64::min, f64::INFINITY), of(f64::max, f64::NEG_INFINITY))
        };
        let ((left, right), (top, bottom)) = (extent(0), extent(1));
        let scale = (SIZE - 80.0) / (right - left).max(bottom - top).max(1e-3);
        let at = |point: &Point3<f64>| {
            let [x, y] = flat(point);
            (40.0 + (x - left) * scale, 60.0 + (y - top) * scale)
        };
        let line = |points: &[Point3<f64>], style: &str| {
            let text: Vec<String> = points.iter().map(&at).map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
            format!("<polyline points=\"{}\" fill=\"none\" {style}/>\n", text.join(" "))
        };
        let grey = "stroke=\"#888\" stroke-width=\"4\" stroke-linecap=\"round\"";
        let red = "stroke=\"#c22\" stroke-width=\"6\" stroke-linecap=\"round\"";
        let dashed = "stroke=\"#c22\" stroke-width=\"3\" stroke-dasharray=\"6 5\"";
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {SIZE} {0}\" font-family=\"sans-serif\" \
             font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            SIZE + 40.0
        );
        let view = if self.is_upright() { "from above, forward is up" } else { "from the side" };
        // Writing to a string cannot fail.
        let _ = writeln!(svg, "<text x=\"12\" y=\"22\">{}: seen {view}</text>", self.joint.name());
        let _ = writeln!(
            svg,
            "<text x=\"12\" y=\"42\">red: neutral; dashed: {SHOWN_DEG:.0} degrees, the positive way</text>"
        );
        if self.is_upright() {
            let hips: Vec<Point3<f64>> = (0..=LEG_COUNT).map(|leg| self.legs[leg % LEG_COUNT][0]).collect();
            svg += &line(&hips, "stroke=\"#ccc\" stroke-width=\"3\"");
        } else {
            let middle = Point3::new(0.0, 0.0, hip.z);
            svg += &line(&[middle, *hip], "stroke=\"#ccc\" stroke-width=\"8\"");
        }
        for leg in &shown {
            svg += &line(*leg, grey);
        }
        let part = if self.joint.is_hip() { 0..2 } else { 1..3 };
        // A hip without a thigh turns the whole leg.
        let part = if self.joint.is_hip() && (self.leg()[1] - hip).norm() < 1e-3 { 0..3 } else { part };
        svg += &line(&self.leg()[part.clone()], red);
        svg += &line(&self.turned[part], dashed);
        svg + "</svg>\n"
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::LegScale;

    #[test]
    fn the_words_come_from_the_drawing() {
        let mut robot = Robot::ant(LegScale::LONG).unwrap();
        robot.geometry.shin_below_horizontal_deg = 57.0;
        let of = |joint| Pose::of(&robot, joint);

        assert_eq!(
            of(Joint::Hip1).neutral(),
            "turn the leg until it points 45 degrees to the left of straight ahead, seen from above"
        );
        assert_eq!(
            of(Joint::Hip3).neutral(),
            "turn the leg until it points 135 degrees to the right of straight ahead, seen from above"
        );
        assert_eq!(of(Joint::Hip4).direction(), "did the leg swing counter-clockwise, seen from above?");
        assert_eq!(
            of(Joint::Knee2).neutral(),
            "turn the shin until it slopes 57 degrees below the horizontal"
        );
        assert_eq!(of(Joint::Knee2).direction(), "did the shin fold down and inward?");
    }

    #[test]
    fn the_picture_shows_the_joint_at_neutral_and_turned() {
        let robot = Robot::ant(LegScale::LONG).unwrap();

        for joint in Joint::ALL {
            let svg = Pose::of(&robot, joint).svg();

            assert!(svg.contains(joint.name()) && !svg.contains("NaN"), "{svg}");
            assert_eq!(svg.matches("#c22").count(), 2, "{svg}");
        }
    }
}
