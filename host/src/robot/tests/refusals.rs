//! Whatever a file can have wrong is told by name, and nothing panics.

use super::*;
use crate::cause_chain::message_of;

/// The Ant's folder with one text changed in one of its files.
fn changed(file: &str, from: &str, to: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    ant().save(folder.path()).expect("written");
    let path = folder.path().join(file);
    let text = std::fs::read_to_string(&path).expect("read");
    assert!(text.contains(from), "{file} has no {from:?}");
    std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
    told(folder.path())
}

/// The pony's, in the same way.
fn changed_pony(from: &str, to: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    // Not saved: what it leaves out is to be left out here, too.
    let text = include_str!("../../../robots/pony/robot.toml");
    std::fs::write(folder.path().join(DESCRIPTION), text).expect("written");
    let text = include_str!("../../../robots/pony/pony.urdf");
    assert!(text.contains(from), "the pony has no {from:?}");
    std::fs::write(folder.path().join("pony.urdf"), text.replacen(from, to, 1)).expect("written");
    told(folder.path())
}

/// The error of a folder, with its causes.
fn told(folder: &Path) -> String {
    message_of(&Robot::load(folder).expect_err("refused"))
}

fn says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{text:?} lacks {part:?}");
    }
}

#[test]
fn a_number_out_of_range_is_refused_by_name_value_and_limit() {
    let error = changed(DESCRIPTION, "leg_scale = 1.0", "leg_scale = 0.1");

    says(&error, &["geometry.leg_scale", "0.1", "0.3", "2"]);
}

#[test]
fn a_spread_that_is_none_is_refused_by_its_parameter() {
    for value in [-0.1, f64::NAN, f64::INFINITY] {
        let mut robot = ant();
        let record = robot.twin.as_mut().expect("the Ant is fitted");
        record.spread.insert("ground.friction".to_owned(), value);

        let error = robot.check().expect_err("no standard deviation");

        says(
            &error.to_string(),
            &["ground.friction", &value.to_string(), "0 to 1000", "fit the robot again"],
        );
    }
}

#[test]
fn a_number_that_is_none_is_refused() {
    let mut robot = ant();
    robot.ground.friction = f64::NAN;

    assert!(matches!(robot.check(), Err(RobotError::OutOfRange { field: "ground.friction", .. })));
}

#[test]
fn an_unknown_field_and_missing_files_are_named() {
    says(&changed(DESCRIPTION, "friction = ", "fricton = "), &["fricton", DESCRIPTION]);
    let folder = tempfile::tempdir().expect("a folder");
    says(&told(&folder.path().join("none")), &["none", DESCRIPTION]);
    ant().save(folder.path()).expect("written");
    std::fs::remove_file(folder.path().join("ant.xml")).expect("removed");
    says(&told(folder.path()), &["cannot read", "ant.xml"]);
}

#[test]
fn a_robot_in_one_file_of_an_older_release_is_told_apart() {
    let folder = tempfile::tempdir().expect("a folder");
    let old = "name = \"Ant\"\njoint_limit_deg = 55.0\n[geometry]\nhip_offset_m = 0.07\nthigh_m = 0.1414\n";
    std::fs::write(folder.path().join(DESCRIPTION), old).expect("written");

    says(&told(folder.path()), &[DESCRIPTION, "older release", "folder"]);
    assert!(matches!(Robot::of_run(folder.path()), Err(RobotError::OldFile { .. })));
}

#[test]
fn a_number_that_robots_no_longer_have_is_told_with_the_next_move() {
    let text = changed(DESCRIPTION, "leg_scale = ", "hip_twist_rad_per_n_m = 0.06\nleg_scale = ");

    says(&text, &[DESCRIPTION, "hip_twist_rad_per_n_m", "older release", "repeat the run"]);
}

#[test]
fn a_model_outside_the_folder_or_of_another_kind_is_refused() {
    for name in ["../ant.xml", "/ant.xml", "ant.sdf", "ant"] {
        let text = changed(DESCRIPTION, "\"ant.xml\"", &format!("{name:?}"));
        says(&text, &[name, ".xml", ".urdf"]);
    }
}

#[test]
fn a_name_that_nothing_has_is_told_with_those_that_there_are() {
    says(&changed(DESCRIPTION, "\"hip3\"", "\"hip9\""), &["model.hips", "hip9", "hip1, knee1, hip2"]);
    says(
        &changed(DESCRIPTION, "torso = \"torso\"", "torso = \"trunk\""),
        &["model.torso", "trunk", "thigh1"],
    );
    says(&changed("ant.xml", "name=\"knee2\"", "name=\"ankle2\""), &["model.knees", "knee2", "ankle2"]);
    says(
        &changed_pony("<child link=\"rear_left_shin\"/>", "<child link=\"stump\"/>"),
        &["stump", "rear_left_shin"],
    );
    says(&changed_pony("\"front_left_knee\"", "\"front_left_hip\""), &["front_left_hip", "used twice"]);
}

#[test]
fn joints_in_the_wrong_order_or_place_are_refused() {
    let swapped = changed(DESCRIPTION, "\"knee1\",\n    \"knee2\"", "\"knee2\",\n    \"knee1\"");
    says(&swapped, &["model.knees", "knee2", "hip1", "legs 1 to 4"]);
    says(&changed(DESCRIPTION, "\"hip1\"", "\"knee1\""), &["hip1", "eight hinges"]);
    says(
        &changed(DESCRIPTION, "feet = [\n    \"shin1\"", "feet = [\n    \"shin2\""),
        &["model.feet", "shin2"],
    );
}

#[test]
fn whatever_moves_without_a_servo_is_refused() {
    let slide = "<joint name=\"knee1\" type=\"slide\" axis";
    says(&changed("ant.xml", "<joint name=\"knee1\" axis", slide), &["knee1", "slide"]);
    let tail = "<body name=\"tail\"><joint name=\"wag\" axis=\"0 0 1\"/>\
        <inertial pos=\"0 0 0\" mass=\"0.1\" diaginertia=\"1e-4 1e-4 1e-4\"/></body>";
    let with_tail = format!("<geom type=\"box\" size=\"0.07 0.07 0.02\"/>{tail}");
    let text = changed("ant.xml", "<geom type=\"box\" size=\"0.07 0.07 0.02\"/>", &with_tail);
    says(&text, &["wag", "hinge", "eight"]);
    says(
        &changed_pony(
            "name=\"rear_right_ankle\" type=\"fixed\"",
            "name=\"rear_right_ankle\" type=\"continuous\"",
        ),
        &["rear_right"],
    );
    says(&changed("ant.xml", "<freejoint/>", ""), &["torso", "freejoint"]);
    let ball = "</body>\n  </worldbody>";
    let with_ball =
        "</body><body name=\"toy\"><freejoint/><geom type=\"sphere\" size=\"0.1\"/></body></worldbody>";
    says(&changed("ant.xml", ball, with_ball), &["toy", "not connected"]);
}

#[test]
fn a_link_that_hangs_on_itself_is_refused() {
    let text = changed_pony("<parent link=\"base\"/>", "<parent link=\"front_left_shin\"/>");
    says(&text, &["front_left", "its own ancestor"]);
}

#[test]
fn meshes_and_what_else_cannot_touch_are_refused_by_their_kind() {
    let mesh = "<geom type=\"mesh\" mesh=\"hull\"/>";
    let text = changed("ant.xml", "<geom type=\"box\" size=\"0.07 0.07 0.02\"/>", mesh);
    says(&text, &["torso", "mesh", "sphere"]);
    let hull = "<mesh filename=\"hull.stl\"/>";
    says(&changed_pony("<box size=\"0.28 0.14 0.06\"/>", hull), &["base", "mesh"]);
    let plane = "<geom type=\"plane\" size=\"1 1 1\"/>";
    says(&changed("ant.xml", "<geom type=\"box\" size=\"0.07 0.07 0.02\"/>", plane), &["torso", "plane"]);
}

#[test]
fn a_mesh_that_is_only_looked_at_is_passed_over() {
    let folder = tempfile::tempdir().expect("a folder");
    ant().save(folder.path()).expect("written");
    let path = folder.path().join("ant.xml");
    let text = std::fs::read_to_string(&path).expect("read");
    let looks = "<geom class=\"looks\" type=\"mesh\" mesh=\"hull\"/><geom type=\"box\" size";
    std::fs::write(&path, text.replacen("<geom type=\"box\" size", looks, 1)).expect("written");

    assert_eq!(Limbs::of(&Robot::load(folder.path()).expect("a robot")), Limbs::of(&ant()));
}

#[test]
fn a_part_without_mass_or_with_an_inertia_that_nothing_has_is_refused() {
    let no_mass = "<inertial pos=\"0.115 0 0\" mass=\"0\"";
    says(&changed("ant.xml", "<inertial pos=\"0.115 0 0\" mass=\"0.02\"", no_mass), &["shin1", "0 kg"]);
    let text = changed_pony("iyy=\"0.0", "iyy=\"5.0");
    says(&text, &["base", "moments"]);
    let turned = "<origin xyz=\"0 0 -0.046\" rpy=\"0 1 0\"/>";
    says(&changed_pony("<origin xyz=\"0 0 -0.046\"/>", turned), &["front_left_shin", "rpy"]);
}

#[test]
fn numbers_that_are_none_are_refused_before_a_loader_sees_them() {
    for bad in ["nan", "inf", "1e30", "-1e9"] {
        let mass = format!("mass=\"{bad}\"");
        says(&changed("ant.xml", "mass=\"0.055\"", &mass), &["servo_hip1", "1000"]);
        let size = format!("<sphere radius=\"{bad}\"/>");
        says(&changed_pony("<sphere radius=\"0.01\"/>", &size), &["front_left_foot", "1000"]);
        let place = format!("<origin xyz=\"0 0 {bad}\" rpy=\"0 -1.0");
        says(&changed_pony("<origin xyz=\"0 0 -0.1\" rpy=\"0 -1.0", &place), &["front_left_knee", "1000"]);
    }
    says(
        &changed_pony("<sphere radius=\"0.01\"/>", "<sphere radius=\"0\"/>"),
        &["front_left_foot", "more than 0"],
    );
    says(&changed("ant.xml", "axis=\"0 1 0\"", "axis=\"0 0 0\""), &["knee1", "axis", "more than 0"]);
}

#[test]
fn ranges_that_are_none_or_leave_neutral_out_are_refused() {
    let text = changed_pony("<limit lower=\"-0.8\" upper=\"0.9\"", "<limit lower=\"0\" upper=\"0\"");
    says(&text, &["front_left_knee", "0 to 0", "continuous"]);
    let narrow = "<joint name=\"knee1\" range=\"10 20\" axis";
    says(&changed("ant.xml", "<joint name=\"knee1\" axis", narrow), &["knee1", "neutral", "10.0", "20.0"]);
}

#[test]
fn a_slope_that_no_turn_of_the_knee_gives_is_refused_with_those_that_there_are() {
    // A knee that turns about an axis near the shin swings it in a narrow cone.
    let from = "euler=\"0 58 0\">\n          <joint name=\"knee1\" axis=\"0 1 0\"/>";
    let text = changed("ant.xml", from, "euler=\"0 20 0\"><joint name=\"knee1\" axis=\"1 0.1 0\"/>");
    let asked_deg = ant().geometry.shin_below_horizontal_deg.to_string();
    says(&text, &["shin_below_horizontal_deg", &asked_deg, "knee1"]);
    assert!(matches!(
        Robot { geometry: Geometry { shin_below_horizontal_deg: 95.0, ..ant().geometry }, ..ant() }.check(),
        Err(RobotError::OutOfRange { field: "geometry.shin_below_horizontal_deg", .. })
    ));
}

#[test]
fn feet_that_are_no_ball_and_legs_that_differ_are_refused() {
    let foot = "<geom type=\"sphere\" pos=\"0.224 0 0\" size=\"0.006\"/>";
    says(&changed("ant.xml", foot, ""), &["shin1", "0 balls"]);
    says(&changed("ant.xml", foot, &format!("{foot}{foot}")), &["shin1", "2 balls"]);
    let on_axis = "<geom type=\"sphere\" pos=\"0 0 0\" size=\"0.006\"/>";
    says(&changed("ant.xml", foot, on_axis), &["shin1", "direction"]);
    says(
        &changed_pony("<sphere radius=\"0.01\"/>", "<sphere radius=\"0.02\"/>"),
        &["0.01", "0.02", "foot_radius_m"],
    );
}

#[test]
fn springs_equalities_and_files_in_files_are_refused() {
    let spring = "<joint name=\"knee1\" stiffness=\"3\" axis";
    says(&changed("ant.xml", "<joint name=\"knee1\" axis", spring), &["spring", "knee1"]);
    let loops = "</worldbody><equality><weld body1=\"shin1\" body2=\"shin2\"/></equality>";
    says(&changed("ant.xml", "</worldbody>", loops), &["<equality>"]);
    let more = "<worldbody><include file=\"/dev/zero\"/>";
    says(&changed("ant.xml", "<worldbody>", more), &["<include>", "one file"]);
    let prefixed = "<worldbody><x:include xmlns:x=\"u\" file=\"/dev/zero\"/>";
    says(&changed("ant.xml", "<worldbody>", prefixed), &["<include>", "one file"]);
    says(&changed("ant.xml", "<mujoco", "<!DOCTYPE mujoco><mujoco"), &["<!DOCTYPE>"]);
}

#[test]
fn a_text_that_is_no_model_does_no_harm() {
    let deep = "<body>".repeat(100_000);
    // An attribute may hold what looks like a tag's end.
    let disguised = "<body name=\"/>\">".repeat(30_000);
    let long = " ".repeat(2_000_000);
    for (text, said) in [
        ("", "not MJCF"),
        ("torso", "not MJCF"),
        ("<mujoco>", "not MJCF"),
        ("<mujoco/>", "model.torso"),
        ("<robot/>", ".urdf"),
        ("<mujoco><worldbody><body name=\"torso\"><body/></worldbody></mujoco>", "not XML"),
        (deep.as_str(), "nested"),
        (disguised.as_str(), "nested"),
        (long.as_str(), "2000000"),
    ] {
        let drawn = document::read_drawing(&ant().model, text.to_owned());

        let error = drawn.expect_err("no model").to_string();
        assert!(error.contains(said), "{error}");
    }
}

#[test]
fn files_cut_short_anywhere_do_no_harm() {
    for robot in [ant(), pony()] {
        let text = robot.drawn.text.clone();
        for length in (0..text.len()).step_by(97).filter(|length| text.is_char_boundary(*length)) {
            assert!(
                document::read_drawing(&robot.model, text[..length].to_owned()).is_err(),
                "{length} bytes"
            );
        }
    }
}
