//! URDF: links and joints side by side.
//!
//! A link's frame is where its joint is, as URDF has it. Capsules are not in
//! URDF: each becomes a cylinder and two balls.

use super::{Body, escaped, moments, moved, number, vector};
use crate::robot::{Inertia, Link, Shape, Solid};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use std::fmt::Write as _;

pub fn text(body: &Body<'_>) -> String {
    let Body { robot, limbs, .. } = body;
    let mut out = String::new();
    let _ = write!(
        out,
        "<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n  <!--\n    {}\n  -->\n",
        escaped(&robot.name),
        body.note()
    );
    let origin = Isometry3::identity();
    link(&mut out, &robot.model.torso, &limbs.torso, &origin);
    for (k, leg) in limbs.legs.iter().enumerate() {
        // From the parts' own frames to frames of like directions at their joints.
        let to = |hinge: &crate::robot::Hinge| {
            let joint_m = hinge.in_child.translation.vector;
            Isometry3::from_parts((-joint_m).into(), UnitQuaternion::identity())
        };
        let (to_thigh, to_shin) = (to(&leg.hip), to(&leg.knee));
        link(&mut out, &body.thighs[k], &leg.thigh, &to_thigh);
        let hip = leg.hip.at(0.0) * to_thigh.inverse();
        let axis = leg.hip.in_child.rotation * Vector3::x();
        joint(&mut out, body, k, [&robot.model.torso, &body.thighs[k]], &hip, &axis);
        link(&mut out, &body.shins[k], &leg.shin, &to_shin);
        let knee = to_thigh * leg.knee.at(0.0) * to_shin.inverse();
        let axis = leg.knee.in_child.rotation * Vector3::x();
        joint(&mut out, body, 4 + k, [&body.thighs[k], &body.shins[k]], &knee, &axis);
        let (shin, foot) = (escaped(&body.shins[k]), escaped(&body.feet[k]));
        let _ = write!(
            out,
            "  <link name=\"{foot}\">\n    <collision>\n      <geometry><sphere radius=\"{}\"/></geometry>\n    \
             </collision>\n  </link>\n  <joint name=\"{foot}_joint\" type=\"fixed\">\n    \
             <parent link=\"{shin}\"/>\n    <child link=\"{foot}\"/>\n    {}\n  </joint>\n",
            number(limbs.foot_radius_m),
            place(&Isometry3::from_parts((to_shin * leg.foot_m).coords.into(), UnitQuaternion::identity())),
        );
    }
    out + "</robot>\n"
}

/// An `<origin>`.
fn place(pose: &Isometry3<f64>) -> String {
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    format!(
        "<origin xyz=\"{}\" rpy=\"{} {} {}\"/>",
        vector(&pose.translation.vector),
        number(roll),
        number(pitch),
        number(yaw)
    )
}

fn link(out: &mut String, name: &str, link: &Link, to: &Isometry3<f64>) {
    let _ = writeln!(out, "  <link name=\"{}\">", escaped(name));
    inertial(out, &link.inertia.moved(to));
    for solid in moved(&link.solids, to) {
        for Solid { pose, shape } in without_capsules(&solid) {
            let shape = match shape {
                Shape::Ball { radius_m } => format!("<sphere radius=\"{}\"/>", number(radius_m)),
                Shape::Cylinder { half_m, radius_m } | Shape::Capsule { half_m, radius_m } => {
                    format!("<cylinder radius=\"{}\" length=\"{}\"/>", number(radius_m), number(2.0 * half_m))
                }
                Shape::Cuboid { half_m } => format!("<box size=\"{}\"/>", vector(&(2.0 * half_m))),
            };
            let _ = write!(
                out,
                "    <collision>\n      {}\n      <geometry>{shape}</geometry>\n    </collision>\n",
                place(&pose)
            );
        }
    }
    *out += "  </link>\n";
}

fn without_capsules(solid: &Solid) -> Vec<Solid> {
    let Shape::Capsule { half_m, radius_m } = solid.shape else { return vec![solid.clone()] };
    let rod = Solid { pose: solid.pose, shape: Shape::Cylinder { half_m, radius_m } };
    let end =
        |z: f64| Solid { pose: solid.pose * Translation3::new(0.0, 0.0, z), shape: Shape::Ball { radius_m } };
    vec![rod, end(-half_m), end(half_m)]
}

fn inertial(out: &mut String, inertia: &Inertia) {
    let [xx, yy, zz, xy, xz, yz] = moments(inertia).map(number);
    let _ = write!(
        out,
        "    <inertial>\n      <origin xyz=\"{}\"/>\n      <mass value=\"{}\"/>\n      <inertia ixx=\"{xx}\" \
         ixy=\"{xy}\" ixz=\"{xz}\" iyy=\"{yy}\" iyz=\"{yz}\" izz=\"{zz}\"/>\n    </inertial>\n",
        vector(&inertia.centre_m.coords),
        number(inertia.mass_kg)
    );
}

fn joint(
    out: &mut String,
    body: &Body<'_>,
    j: usize,
    [parent, child]: [&str; 2],
    pose: &Isometry3<f64>,
    axis: &Vector3<f64>,
) {
    let Body { robot, stops_rad, .. } = body;
    let name = if j < 4 { &robot.model.hips[j] } else { &robot.model.knees[j - 4] };
    let [lower, upper] = stops_rad[j].map(number);
    let _ = write!(
        out,
        "  <joint name=\"{}\" type=\"revolute\">\n    <parent link=\"{}\"/>\n    <child link=\"{}\"/>\n    {}\n    \
         <axis xyz=\"{}\"/>\n    <limit lower=\"{lower}\" upper=\"{upper}\" effort=\"{}\" velocity=\"{}\"/>\n    \
         <dynamics damping=\"{}\" friction=\"{}\"/>\n  </joint>\n",
        escaped(name),
        escaped(parent),
        escaped(child),
        place(pose),
        vector(axis),
        number(robot.servo.torque_limit_n_m),
        number(robot.servo.no_load_speed_rad_s),
        number(robot.servo.damping_n_m_s_rad),
        number(robot.servo.friction_n_m),
    );
}
