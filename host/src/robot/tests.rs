//! Descriptions are read back as written, and refused by name.

use super::*;

fn ant() -> Robot {
    Robot::ant(1.0).expect("1.0 is a leg scale")
}

#[test]
fn the_ant_is_the_fitted_one_and_weighs_about_a_kilogram() {
    let ant = ant();

    let record = ant.twin.as_ref().expect("the description says what it was fitted to");
    assert_eq!(record.methods, ["psto"]);
    assert!(record.spread.contains_key("ground.friction"), "{record:?}");
    assert!((0.8..1.1).contains(&ant.mass_kg()), "{} kg", ant.mass_kg());
}

#[test]
fn only_the_shin_scales() {
    let short = Robot::ant(0.6).expect("0.6 is a leg scale");

    assert!((short.scaled_shin_m() - 0.138).abs() < 1e-12);
    assert_eq!(short.geometry.thigh_m, ant().geometry.thigh_m);
    assert!((ant().mass_kg() - short.mass_kg() - 4.0 * 0.4 * 0.02).abs() < 1e-12);
}

#[test]
fn what_is_written_is_read_back() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.toml");
    crate::run_folder::write(&path, ant().to_toml().as_bytes()).expect("written");

    assert_eq!(Robot::load(&path).expect("read"), ant());
}

#[test]
fn a_number_out_of_range_is_refused_by_name_value_and_limit() {
    let error = Robot::ant(0.1).expect_err("too short");

    let text = error.to_string();
    for part in ["geometry.leg_scale", "0.1", "0.3", "2"] {
        assert!(text.contains(part), "{text:?} lacks {part:?}");
    }
}

#[test]
fn a_number_that_is_none_is_refused() {
    let mut robot = ant();
    robot.ground.friction = f64::NAN;

    assert!(matches!(robot.check(), Err(RobotError::OutOfRange { field: "ground.friction", .. })));
}

#[test]
fn an_unknown_field_and_a_missing_file_are_named() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("robot.toml");
    let text = ant().to_toml().replace("friction", "fricton");
    std::fs::write(&path, text).expect("written");

    let error = Robot::load(&path).expect_err("misspelt");
    let cause = std::error::Error::source(&error).expect("TOML says where").to_string();
    assert!(cause.contains("fricton") && error.to_string().contains("robot.toml"), "{error}: {cause}");
    let error = Robot::load(&folder.path().join("none.toml")).expect_err("missing").to_string();
    assert!(error.contains("none.toml"), "{error}");
}
