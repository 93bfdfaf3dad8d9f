//! MJCF: bodies in bodies, with servos as position actuators.
//!
//! The floor and the actuators are for MuJoCo; our own loader passes over them.

use super::{Body, escaped, moments, number, numbers, vector};
use crate::robot::{Hinge, Inertia, Shape, Solid};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use std::fmt::Write as _;

pub fn text(body: &Body<'_>) -> String {
    let Body { robot, limbs, .. } = body;
    let servo = &robot.servo;
    let mut out = String::new();
    let _ = write!(
        out,
        "<mujoco model=\"{}\">\n  <!--\n    {}\n    Actuators: position servos; their speed limit, dead band and delay are not in MJCF.\n  -->\n  \
         <compiler angle=\"radian\" autolimits=\"true\"/>\n  <option timestep=\"0.002\" integrator=\"implicitfast\"/>\n  \
         <default>\n    <geom contype=\"1\" conaffinity=\"0\" mass=\"0\" friction=\"{} 0.005 0.0001\"/>\n    \
         <joint damping=\"{}\" frictionloss=\"{}\"/>\n  </default>\n  <worldbody>\n    \
         <geom name=\"floor\" type=\"plane\" size=\"5 5 0.1\" contype=\"0\" conaffinity=\"1\"/>\n",
        escaped(&robot.name),
        body.note(),
        number(robot.ground.friction),
        number(servo.damping_n_m_s_rad),
        number(servo.friction_n_m),
    );
    let pose =
        Isometry3::from_parts(Vector3::new(0.0, 0.0, body.height_m).into(), UnitQuaternion::identity());
    open(&mut out, 4, &robot.model.torso, &pose);
    let _ = writeln!(out, "      <freejoint/>");
    contents(&mut out, 6, &limbs.torso.inertia, &limbs.torso.solids);
    for (k, leg) in limbs.legs.iter().enumerate() {
        open(&mut out, 6, &body.thighs[k], &leg.hip.at(0.0));
        joint(&mut out, 8, &robot.model.hips[k], &leg.hip, body.stops_rad[k]);
        contents(&mut out, 8, &leg.thigh.inertia, &leg.thigh.solids);
        open(&mut out, 8, &body.shins[k], &leg.knee.at(0.0));
        joint(&mut out, 10, &robot.model.knees[k], &leg.knee, body.stops_rad[4 + k]);
        contents(&mut out, 10, &leg.shin.inertia, &leg.shin.solids);
        // A body of its own: a foot has one ball, and a shin may have more.
        let at = Isometry3::from_parts(leg.foot_m.coords.into(), UnitQuaternion::identity());
        open(&mut out, 10, &body.feet[k], &at);
        let _ = writeln!(
            out,
            "            <geom type=\"sphere\" size=\"{}\"/>\n          </body>\n        </body>\n      </body>",
            number(limbs.foot_radius_m)
        );
    }
    out += "    </body>\n  </worldbody>\n  <actuator>\n";
    for name in robot.model.hips.iter().chain(&robot.model.knees) {
        let name = escaped(name);
        let limit = number(servo.torque_limit_n_m);
        let _ = writeln!(
            out,
            "    <position name=\"{name}\" joint=\"{name}\" kp=\"{}\" forcerange=\"-{limit} {limit}\"/>",
            number(servo.stiffness_n_m_rad)
        );
    }
    out + "  </actuator>\n</mujoco>\n"
}

fn turn(rotation: &UnitQuaternion<f64>) -> String {
    numbers(&[rotation.w, rotation.i, rotation.j, rotation.k])
}

fn open(out: &mut String, indent: usize, name: &str, pose: &Isometry3<f64>) {
    let _ = writeln!(
        out,
        "{:indent$}<body name=\"{}\" pos=\"{}\" quat=\"{}\">",
        "",
        escaped(name),
        vector(&pose.translation.vector),
        turn(&pose.rotation)
    );
}

fn joint(out: &mut String, indent: usize, name: &str, hinge: &Hinge, stops_rad: [f64; 2]) {
    let _ = writeln!(
        out,
        "{:indent$}<joint name=\"{}\" pos=\"{}\" axis=\"{}\" range=\"{}\"/>",
        "",
        escaped(name),
        vector(&hinge.in_child.translation.vector),
        vector(&(hinge.in_child.rotation * Vector3::x())),
        numbers(&stops_rad)
    );
}

fn contents(out: &mut String, indent: usize, inertia: &Inertia, solids: &[Solid]) {
    let _ = writeln!(
        out,
        "{:indent$}<inertial pos=\"{}\" mass=\"{}\" fullinertia=\"{}\"/>",
        "",
        vector(&inertia.centre_m.coords),
        number(inertia.mass_kg),
        numbers(&moments(inertia))
    );
    for Solid { pose, shape } in solids {
        let (kind, size) = match shape {
            Shape::Ball { radius_m } => ("sphere", numbers(&[*radius_m])),
            Shape::Capsule { half_m, radius_m } => ("capsule", numbers(&[*radius_m, *half_m])),
            Shape::Cylinder { half_m, radius_m } => ("cylinder", numbers(&[*radius_m, *half_m])),
            Shape::Cuboid { half_m } => ("box", vector(half_m)),
        };
        let _ = writeln!(
            out,
            "{:indent$}<geom type=\"{kind}\" size=\"{size}\" pos=\"{}\" quat=\"{}\"/>",
            "",
            vector(&pose.translation.vector),
            turn(&pose.rotation)
        );
    }
}
