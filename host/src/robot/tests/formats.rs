//! The same robot in MJCF and in URDF is the same body.

use super::*;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use std::fmt::Write as _;

/// A robot of four like legs, in numbers; x of a limb's frame points along it.
#[derive(Debug, Clone)]
struct Sketch {
    torso_half_m: [f64; 3],
    hip_m: [f64; 3],
    hip_axis: [f64; 3],
    hip_pitch_rad: f64,
    thigh_m: f64,
    knee_pitch_rad: f64,
    shin_m: f64,
    foot_m: f64,
    /// Torso, thigh, a servo on it, shin.
    masses_kg: [f64; 4],
    high_rad: f64,
}

const KNEE_AXIS: [f64; 3] = [0.1, 1.0, -0.05];
const SERVO_HALF_M: [f64; 3] = [0.02, 0.01, 0.02];

/// Moments of a box, turned: products of inertia are then not 0.
fn moments(mass_kg: f64, half_m: [f64; 3], turn_rad: f64) -> [f64; 6] {
    let [x, y, z] = half_m.map(|half| half * half * mass_kg / 3.0);
    let turn = UnitQuaternion::from_euler_angles(turn_rad, 0.5 * turn_rad, 0.0).to_rotation_matrix();
    let m = turn.matrix()
        * Matrix3::from_diagonal(&Vector3::new(y + z, x + z, x + y))
        * turn.matrix().transpose();
    [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(0, 2)], m[(1, 2)]]
}

fn words(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}

/// A turn as MJCF has it, from a URDF's roll, pitch and yaw.
fn quat(roll: f64, pitch: f64, yaw: f64) -> String {
    let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    words(&[turn.w, turn.i, turn.j, turn.k])
}

fn mjcf_inertial(x_m: f64, mass_kg: f64, half_m: [f64; 3], turn_rad: f64) -> String {
    let full = words(&moments(mass_kg, half_m, turn_rad));
    format!("<inertial pos=\"{x_m} 0 0\" mass=\"{mass_kg}\" fullinertia=\"{full}\"/>")
}

fn urdf_inertial(x_m: f64, mass_kg: f64, half_m: [f64; 3], turn_rad: f64) -> String {
    let [xx, yy, zz, xy, xz, yz] = moments(mass_kg, half_m, turn_rad);
    format!(
        "<inertial><origin xyz=\"{x_m} 0 0\"/><mass value=\"{mass_kg}\"/><inertia ixx=\"{xx}\" \
         iyy=\"{yy}\" izz=\"{zz}\" ixy=\"{xy}\" ixz=\"{xz}\" iyz=\"{yz}\"/></inertial>"
    )
}

fn urdf_collision(at: &str, shape: &str) -> String {
    format!("<collision><origin {at}/><geometry>{shape}</geometry></collision>")
}

fn urdf_joint(name: &str, links: [&str; 2], at: &str, more: &str) -> String {
    let [parent, child] = links;
    format!(
        "<joint name=\"{name}\" {more}<parent link=\"{parent}\"/><child link=\"{child}\"/><origin {at}/></joint>"
    )
}

impl Sketch {
    /// Where a leg's hip is, and where the leg points.
    fn hip(&self, leg: usize) -> ([f64; 3], f64) {
        let (x, y) = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)][leg];
        let [hip_x, hip_y, hip_z] = self.hip_m;
        ([x * hip_x, y * hip_y, hip_z], f64::atan2(y * hip_y, x * hip_x))
    }

    fn halves_m(&self) -> [[f64; 3]; 2] {
        [[self.thigh_m / 2.0, 0.007, 0.009], [self.shin_m / 2.0, 0.006, 0.006]]
    }

    fn mjcf(&self) -> String {
        let Self { thigh_m, shin_m, foot_m, high_rad, .. } = *self;
        let [torso, thigh, servo, shin] = self.masses_kg;
        let [thigh_half, shin_half] = self.halves_m();
        let mut text = format!(
            "<mujoco><compiler angle=\"radian\"/><worldbody><body name=\"torso\"><freejoint/>{}\
             <geom type=\"box\" size=\"{}\"/>",
            mjcf_inertial(0.0, torso, self.torso_half_m, 0.1),
            words(&self.torso_half_m)
        );
        for leg in 0..4 {
            let (hip_m, yaw) = self.hip(leg);
            let (hip_m, hip_quat) = (words(&hip_m), quat(0.0, self.hip_pitch_rad, yaw));
            let (hip_axis, knee_axis) = (words(&self.hip_axis), words(&KNEE_AXIS));
            let thigh = mjcf_inertial(thigh_m / 2.0, thigh, thigh_half, 0.3);
            let servo = mjcf_inertial(0.0, servo, SERVO_HALF_M, 0.0);
            let shin = mjcf_inertial(shin_m / 2.0, shin, shin_half, 0.0);
            let (middle, along) = (thigh_m / 2.0, quat(0.0, core::f64::consts::FRAC_PI_2, 0.0));
            let (knee_quat, ball) = (quat(0.0, self.knee_pitch_rad, 0.0), shin_m - foot_m);
            let _ = write!(
                text,
                "<body name=\"thigh{leg}\" pos=\"{hip_m}\" quat=\"{hip_quat}\">\
                 <joint name=\"hip{leg}\" axis=\"{hip_axis}\" range=\"-0.5 {high_rad}\"/>{thigh}\
                 <geom type=\"cylinder\" pos=\"{middle} 0 0\" quat=\"{along}\" size=\"0.01 {middle}\"/>\
                 <body name=\"servo{leg}\" pos=\"{thigh_m} 0 0.01\">{servo}</body>\
                 <body name=\"shin{leg}\" pos=\"{thigh_m} 0 0\" quat=\"{knee_quat}\">\
                 <joint name=\"knee{leg}\" axis=\"{knee_axis}\"/>{shin}\
                 <geom type=\"sphere\" pos=\"{ball} 0 0\" size=\"{foot_m}\"/></body></body>"
            );
        }
        text + "</body></worldbody></mujoco>"
    }

    fn urdf(&self) -> String {
        let Self { thigh_m, shin_m, foot_m, high_rad, .. } = *self;
        let [torso, thigh, servo, shin] = self.masses_kg;
        let [thigh_half, shin_half] = self.halves_m();
        let size = words(&self.torso_half_m.map(|half| 2.0 * half));
        let torso = urdf_inertial(0.0, torso, self.torso_half_m, 0.1)
            + &urdf_collision("xyz=\"0 0 0\"", &format!("<box size=\"{size}\"/>"));
        let mut text = format!("<robot name=\"sketch\"><link name=\"torso\">{torso}</link>");
        for leg in 0..4 {
            let (hip_m, yaw) = self.hip(leg);
            let names = ["thigh", "servo", "shin"].map(|part| format!("{part}{leg}"));
            let [thigh_name, servo_name, shin_name] = names.each_ref().map(String::as_str);
            let rod = format!("<cylinder radius=\"0.01\" length=\"{thigh_m}\"/>");
            let along = format!("xyz=\"{} 0 0\" rpy=\"0 {} 0\"", thigh_m / 2.0, core::f64::consts::FRAC_PI_2);
            let thigh = urdf_inertial(thigh_m / 2.0, thigh, thigh_half, 0.3) + &urdf_collision(&along, &rod);
            let servo = urdf_inertial(0.0, servo, SERVO_HALF_M, 0.0);
            let ball = format!("xyz=\"{} 0 0\"", shin_m - foot_m);
            let shin = urdf_inertial(shin_m / 2.0, shin, shin_half, 0.0)
                + &urdf_collision(&ball, &format!("<sphere radius=\"{foot_m}\"/>"));
            let _ = write!(
                text,
                "<link name=\"{thigh_name}\">{thigh}</link><link name=\"{servo_name}\">{servo}</link>\
                 <link name=\"{shin_name}\">{shin}</link>"
            );
            let turning =
                |kind: &str, axis: &[f64]| format!("type=\"{kind}\"><axis xyz=\"{}\"/>", words(axis));
            let limit = format!("<limit lower=\"-0.5\" upper=\"{high_rad}\" effort=\"1\" velocity=\"1\"/>");
            let hip_at = format!("xyz=\"{}\" rpy=\"0 {} {yaw}\"", words(&hip_m), self.hip_pitch_rad);
            let hip = turning("revolute", &self.hip_axis) + &limit;
            text += &urdf_joint(&format!("hip{leg}"), ["torso", thigh_name], &hip_at, &hip);
            let servo_at = format!("xyz=\"{thigh_m} 0 0.01\"");
            text +=
                &urdf_joint(&format!("weld{leg}"), [thigh_name, servo_name], &servo_at, "type=\"fixed\">");
            let knee_at = format!("xyz=\"{thigh_m} 0 0\" rpy=\"0 {} 0\"", self.knee_pitch_rad);
            let knee = turning("continuous", &KNEE_AXIS);
            text += &urdf_joint(&format!("knee{leg}"), [thigh_name, shin_name], &knee_at, &knee);
        }
        text + "</robot>"
    }

    /// The Ant's description with this body, the overrides included.
    fn robot(&self, file: &str, text: String) -> Robot {
        let named = |part: &str| core::array::from_fn(|leg| format!("{part}{leg}"));
        let model = Model {
            file: file.to_owned(),
            torso: "torso".to_owned(),
            hips: named("hip"),
            knees: named("knee"),
            feet: named("shin"),
            scaled: [named("shin"), named("thigh")].concat(),
        };
        let drawn = document::read_drawing(&model, text).expect("a body");
        let mut robot = Robot { model, drawn: Arc::new(drawn), ..ant() };
        robot.geometry.leg_scale = LegScale::new(1.3).expect("a leg scale");
        robot.mass.torso_kg = 0.7;
        robot
    }
}

fn near(a: f64, b: f64, scale: f64) -> bool {
    (a - b).abs() <= 2e-5 * scale
}

fn assert_alike(a: &Link, b: &Link) {
    assert!(near(a.inertia.mass_kg, b.inertia.mass_kg, a.inertia.mass_kg), "{a:?} {b:?}");
    assert!(near((a.inertia.centre_m - b.inertia.centre_m).norm(), 0.0, 0.1), "{a:?} {b:?}");
    let size = a.inertia.tensor_kg_m2.amax();
    assert!(near((a.inertia.tensor_kg_m2 - b.inertia.tensor_kg_m2).amax(), 0.0, size), "{a:?} {b:?}");
    assert_eq!(a.solids.len(), b.solids.len());
    for (a, b) in a.solids.iter().zip(&b.solids) {
        for turn in [[0.0, 0.0, 0.0], [0.4, -1.0, 0.2], [2.0, 0.3, 1.0]] {
            let pose = nalgebra::Isometry3::new(Vector3::zeros(), Vector3::from(turn));
            assert!(near(a.lowest_m(&pose), b.lowest_m(&pose), 0.1), "{a:?} {b:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: proptest::test_runner::RngSeed::Fixed(7),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn one_robot_in_both_formats_is_one_body(
        torso_half_m in prop::array::uniform3(0.02..0.2_f64),
        hip_m in prop::array::uniform3(0.03..0.2_f64),
        hip_axis in prop::array::uniform3(0.1..1.0_f64),
        pitches_rad in prop::array::uniform2(0.1..0.7_f64),
        lengths_m in prop::array::uniform2(0.06..0.3_f64),
        foot_m in 0.004..0.012_f64,
        masses_kg in prop::array::uniform4(0.02..1.5_f64),
        high_rad in 0.1..1.5_f64,
    ) {
        let [hip_pitch_rad, knee_pitch_rad] = pitches_rad;
        let [thigh_m, shin_m] = lengths_m;
        let sketch = Sketch {
            torso_half_m, hip_m, hip_axis, hip_pitch_rad, thigh_m, knee_pitch_rad, shin_m, foot_m,
            masses_kg, high_rad,
        };

        let one = sketch.robot("sketch.xml", sketch.mjcf());
        let other = sketch.robot("sketch.urdf", sketch.urdf());

        let (a, b) = (Limbs::of(&one), Limbs::of(&other));
        assert_alike(&a.torso, &b.torso);
        for (a, b) in a.legs.iter().zip(&b.legs) {
            assert_alike(&a.thigh, &b.thigh);
            assert_alike(&a.shin, &b.shin);
            assert!(near((a.foot_m - b.foot_m).norm(), 0.0, 0.1), "{a:?} {b:?}");
            for (a, b) in [(&a.hip, &b.hip), (&a.knee, &b.knee)] {
                for angle_rad in [0.0, 0.5, -1.2] {
                    let apart = a.at(angle_rad).inverse() * b.at(angle_rad);
                    assert!(near(apart.translation.vector.norm(), 0.0, 0.1), "{a:?} {b:?}");
                    assert!(near(apart.rotation.angle(), 0.0, 50.0), "{a:?} {b:?}");
                }
            }
        }
        for (a, b) in a.stops_rad(&one).iter().flatten().zip(b.stops_rad(&other).iter().flatten()) {
            assert!(near(*a, *b, 1.0), "{a} {b}");
        }
    }
}
