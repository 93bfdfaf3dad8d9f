//! An export is read back as the body that it was made of.

use super::*;
use crate::robot::{Geometry, Mass, Robot};
use nalgebra::Point3;
use std::path::Path;

/// Metres, kilograms and kg m^2 per their own size: loaders keep single precision.
const NEAR: f64 = 1e-6;

/// Robots whose description changes the drawing in every way.
fn robots() -> Vec<Robot> {
    let folder = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name);
    let mut ant = Robot::ant(crate::robot::LegScale::SHORT).expect("a leg scale");
    ant.geometry.shin_below_horizontal_deg = 55.0;
    ant.geometry.foot_radius_m = 0.012;
    ant.mass.torso_kg = 0.5;
    let mut pony = Robot::load(&folder("pony")).expect("a robot");
    pony.servo.end_stop_deg = 50.0;
    pony.geometry.foot_radius_m = 0.013;
    pony.geometry.shin_below_horizontal_deg = 55.0;
    let newt = Robot::load(&folder("newt")).expect("a robot");
    let robots = vec![ant, pony, newt];
    robots.iter().for_each(|robot| robot.check().expect("a robot"));
    robots
}

/// The exported file in a folder of its own, with nothing in robot.toml that changes it.
fn read_back(robot: &Robot, format: Format) -> Robot {
    let file = format!("body.{}", format.extension());
    let Export { text, model } = export(robot, format, &file);
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join(&file), text).expect("written");
    let mut toml: toml::Table = robot.to_toml().parse().expect("a table");
    for section in ["geometry", "mass", "twin"] {
        toml.remove(section);
    }
    toml.insert("model".to_owned(), toml::Value::try_from(&model).expect("a table"));
    std::fs::write(folder.path().join("robot.toml"), toml.to_string()).expect("written");
    Robot::load(folder.path()).expect("our own loader reads it")
}

fn near(a: f64, b: f64, size: f64) -> bool {
    (a - b).abs() <= NEAR * size
}

#[test]
fn an_export_is_read_back_as_the_same_limbs_in_both_formats() {
    for robot in robots() {
        for format in [Format::Mjcf, Format::Urdf] {
            let other = read_back(&robot, format);
            let what = format!("{} in {format:?}", robot.name);
            let (a, b) = (Limbs::of(&robot), Limbs::of(&other));

            assert!(near(a.mass_kg(), b.mass_kg(), 1.0), "{what}");
            assert!(near(a.foot_radius_m, b.foot_radius_m, 1.0), "{what}");
            for (a, b) in a.stops_rad(&robot).iter().flatten().zip(b.stops_rad(&other).iter().flatten()) {
                assert!(near(*a, *b, 1.0), "{what}: {a} {b}");
            }
            // Frames of parts may differ, so everything is looked at where it is in the world.
            for [hip, knee] in [[0.0, 0.0], [0.4, -0.3], [-0.2, 0.5]] {
                let angles = core::array::from_fn(|j| if j < 4 { hip } else { knee });
                let heights = [&a, &b].map(|limbs| limbs.standing_height_m(&angles));
                assert!(near(heights[0], heights[1], 1.0), "{what}: {heights:?}");
                for leg in 0..4 {
                    let place = |limbs: &Limbs| -> (Inertia, Inertia, Point3<f64>) {
                        let leg = &limbs.legs[leg];
                        let thigh = leg.hip.at(hip);
                        let shin = thigh * leg.knee.at(knee);
                        (leg.thigh.inertia.moved(&thigh), leg.shin.inertia.moved(&shin), shin * leg.foot_m)
                    };
                    let ((thigh, shin, foot), (other_thigh, other_shin, other_foot)) = (place(&a), place(&b));
                    assert!((foot - other_foot).norm() < NEAR, "{what}: {foot} {other_foot}");
                    for (one, other) in
                        [(&thigh, &other_thigh), (&shin, &other_shin), (&a.torso.inertia, &b.torso.inertia)]
                    {
                        assert!(near(one.mass_kg, other.mass_kg, one.mass_kg), "{what}");
                        assert!((one.centre_m - other.centre_m).norm() < NEAR, "{what}: {one:?} {other:?}");
                        let size = one.tensor_kg_m2.amax();
                        let apart = (one.tensor_kg_m2 - other.tensor_kg_m2).amax();
                        assert!(apart < 3.0 * NEAR * size, "{what}: {apart} of {size}");
                    }
                }
            }
        }
    }
}

#[test]
fn an_exported_body_needs_no_overrides() {
    for robot in robots() {
        let other = read_back(&robot, Format::Mjcf);
        let Geometry { leg_scale, shin_below_horizontal_deg, foot_radius_m } = &other.geometry;

        assert_eq!(*leg_scale, crate::robot::LegScale::LONG);
        assert!(near(*shin_below_horizontal_deg, robot.geometry.shin_below_horizontal_deg, 100.0));
        assert!(near(*foot_radius_m, robot.geometry.foot_radius_m, 1.0));
        let Mass { torso_kg } = other.mass;
        let torso_with_servos_kg = Limbs::of(&robot).torso.inertia.mass_kg;
        assert!(near(torso_kg, torso_with_servos_kg, 1.0), "{torso_kg} {torso_with_servos_kg}");
    }
}
