//! What the drawing holds.

use super::*;
use crate::robot::check::check;
use std::path::Path;

#[test]
fn every_shipped_robot_is_drawn_with_three_views_four_feet_and_eight_axes() {
    for name in ["ant", "pony", "newt"] {
        let robot =
            Robot::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name)).expect("a robot");

        let svg = to_svg(&robot, &check(&robot));

        for text in [">top<", ">side, from its right<", ">front<", &robot.name, " mm<", ">centre of mass<"] {
            assert!(svg.contains(text), "{name}: {text}");
        }
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{name}");
        for leg in ["1", "2", "3", "4"] {
            assert!(svg.contains(&format!(">{leg}</text>")), "{name}: foot {leg} in the top view");
        }
    }
}

#[test]
fn a_box_seen_along_an_axis_shows_one_side_of_its_own_size() {
    let solid =
        Solid { pose: Isometry3::identity(), shape: Shape::Cuboid { half_m: Vector3::new(0.1, 0.2, 0.3) } };
    let mut drawn = Vec::new();

    VIEWS[1].solid(&solid, &Isometry3::identity(), TORSO, &mut drawn);

    assert_eq!(drawn.len(), 1);
    let [low, high] = drawn[0].outline.bounds();
    assert!((high - low - Vector2::new(0.2, 0.6)).norm() < 1e-12, "{low} {high}");
}

#[test]
fn a_cylinder_seen_from_its_end_is_a_circle_and_from_its_side_a_rectangle() {
    let shape = Shape::Cylinder { half_m: 0.05, radius_m: 0.02 };
    let solid = Solid { pose: Isometry3::identity(), shape };
    let sizes = [&VIEWS[0], &VIEWS[1]].map(|view| {
        let mut drawn = Vec::new();
        view.solid(&solid, &Isometry3::identity(), SHIN, &mut drawn);
        let [low, high] = drawn[0].outline.bounds();
        high - low
    });

    assert!((sizes[0] - Vector2::new(0.04, 0.04)).norm() < 1e-9, "{sizes:?}");
    assert!((sizes[1] - Vector2::new(0.04, 0.1)).norm() < 1e-9, "{sizes:?}");
}

#[test]
fn scale_bars_are_round_and_fit() {
    assert_eq!(round_length_mm(110.0), 100.0);
    assert_eq!(round_length_mm(99.0), 50.0);
    assert_eq!(round_length_mm(4.9), 2.0);
}
