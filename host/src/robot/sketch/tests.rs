//! Sketched robots load, stand and pass the check.

use super::*;
use crate::robot::check::{Mark, Topic, check};
use crate::robot::{Limbs, Robot};

fn robot(sketch: &Sketch) -> Robot {
    let files = sketch.files().expect("answers that fit");
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("robot.toml"), files.description).expect("written");
    std::fs::write(folder.path().join(&files.model_file), files.model).expect("written");
    Robot::load(folder.path()).expect("a robot")
}

#[test]
fn both_mountings_have_the_lengths_and_masses_that_were_asked_for_and_pass_the_check() {
    for mounting in [Mounting::Sprawling, Mounting::Mammal] {
        let robot = robot(&Sketch { mounting, name: "Two words".to_owned(), ..Sketch::default() });
        let found = check(&robot);
        let limbs = Limbs::of(&robot);

        assert_eq!((robot.name.as_str(), robot.model.file.as_str()), ("Two words", "two-words.xml"));
        assert!(
            (robot.mass_kg() - (0.230 + 8.0 * 0.0134 + 8.0 * 0.014)).abs() < 1e-6,
            "{} kg",
            robot.mass_kg()
        );
        assert_eq!(found.count(Mark::Error), 0, "{mounting:?}: {found:#?}");
        for leg in &limbs.legs {
            let thigh_m =
                (leg.knee.in_parent.translation.vector - leg.hip.in_child.translation.vector).norm();
            let shin_m =
                (leg.foot_m.coords - leg.knee.in_child.translation.vector).norm() + limbs.foot_radius_m;
            assert!((thigh_m - 0.055).abs() < 1e-6 && (shin_m - 0.075).abs() < 1e-5, "{thigh_m} {shin_m}");
        }
        assert_eq!(found.finding(Topic::GroundContact).map(|finding| finding.mark), Some(Mark::Ok));
    }
}

#[test]
fn a_mammals_feet_stand_below_its_hips() {
    let robot = robot(&Sketch { mounting: Mounting::Mammal, ..Sketch::default() });
    let limbs = Limbs::of(&robot);

    let standing = crate::robot::statics::Standing::of(&limbs);

    for leg in 0..4 {
        let apart = standing.feet_m[leg] - standing.joints[leg].0;
        assert!(apart.x.abs() < 1e-4 && apart.y.abs() < 1e-6 && apart.z < -0.09, "{apart}");
    }
}

#[test]
fn answers_that_cannot_be_are_refused_by_name() {
    let with = |k: usize, value: f64| {
        let mut sketch = Sketch::default();
        sketch.numbers[k] = value;
        sketch.check().expect_err("refused").to_string()
    };
    assert!(with(0, 5.0).contains("within 15 to 300 mm"), "{}", with(0, 5.0));
    assert!(with(0, f64::NAN).contains("within 15 to 300 mm"));
    assert!(with(8, 30.0).contains("a quarter of the shin"), "{}", with(8, 30.0));
    assert!(with(10, 8.0).contains("4.8 to 6 V"), "{}", with(10, 8.0));
    for name in ["", "  ", "a/b", "x\n", "a\"b", &"n".repeat(33)] {
        assert!(check_name(name).is_err(), "{name:?}");
    }
    assert!(check_name("Änne 2-b_c").is_ok());
    let mut short = Sketch { mounting: Mounting::Mammal, ..Sketch::default() };
    (short.numbers[0], short.numbers[1]) = (150.0, 60.0);
    assert!(matches!(short.check(), Err(SketchError::Shin { .. })));
}

#[test]
fn file_names_are_lower_case_words() {
    assert_eq!(file_stem("My  Robot_2 "), "my-robot-2");
    assert_eq!(file_stem("Änne"), "nne");
}
