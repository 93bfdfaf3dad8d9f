//! Robot files as people write them: read as MuJoCo and ROS do, refused in the
//! file's own format, or used with a warning.

use host::robot::{Limbs, Robot, RobotWarning};
use host::sim::World;
use std::fmt::Write as _;
use std::path::Path;

const TOML: &str = r#"
name = "Beetle"
joint_limit_deg = 45.0
[model]
file = "FILE"
torso = "base"
hips = ["hip1", "hip2", "hip3", "hip4"]
knees = ["knee1", "knee2", "knee3", "knee4"]
feet = ["shin1", "shin2", "shin3", "shin4"]
scaled = []
[servo]
stiffness_n_m_rad = 6.0
damping_n_m_s_rad = 0.1
no_load_speed_rad_s = 6.0
torque_limit_n_m = 0.9
end_stop_deg = 90.0
neutral_pulse_us = 1500.0
pulse_us_per_deg = 10.0
[ground]
friction = 0.6
[power]
electronics_w = 0.3
efficiency = 0.6
heat_w_per_n2_m2 = 2.0
[supply]
nominal_v = 6.0
resistance_ohm = 0.1
"#;

const CORNERS: [[i32; 2]; 4] = [[1, 1], [-1, 1], [-1, -1], [1, -1]];

/// Hips that swing about z, shins that hang 0.1 m below the thighs' ends.
fn mjcf() -> String {
    let mut text = String::from(
        "<mujoco><compiler angle=\"degree\"/><worldbody><body name=\"base\"><freejoint/>\
         <geom type=\"box\" size=\"0.05 0.04 0.015\" mass=\"0.4\"/>",
    );
    for (k, [x, y]) in CORNERS.into_iter().enumerate() {
        let leg = k + 1;
        let _ = write!(
            text,
            "<body name=\"thigh{leg}\" pos=\"{} {} 0\"><joint name=\"hip{leg}\" axis=\"0 0 1\" range=\"-60 60\"/>\
             <geom type=\"capsule\" fromto=\"0 0 0 0 {} 0\" size=\"0.006\" mass=\"0.05\"/>\
             <body name=\"shin{leg}\" pos=\"0 {} 0\"><joint name=\"knee{leg}\" axis=\"{} 0 0\"/>\
             <geom type=\"capsule\" fromto=\"0 0 0 0 {} -0.09\" size=\"0.004\" mass=\"0.02\"/>\
             <geom type=\"sphere\" pos=\"0 {} -0.09\" size=\"0.008\" mass=\"0.005\"/></body></body>",
            0.05 * f64::from(x),
            0.04 * f64::from(y),
            0.05 * f64::from(y),
            0.05 * f64::from(y),
            y,
            0.02 * f64::from(y),
            0.02 * f64::from(y),
        );
    }
    text + "</body></worldbody></mujoco>"
}

/// The same kind of robot; its knees have limits.
fn urdf() -> String {
    let inertial = |z: f64, mass: f64, moment: f64| {
        format!(
            "<inertial><origin xyz=\"0 0 {z}\"/><mass value=\"{mass}\"/><inertia ixx=\"{moment}\" ixy=\"0\" ixz=\"0\" \
             iyy=\"{moment}\" iyz=\"0\" izz=\"{moment}\"/></inertial>"
        )
    };
    let mut text = format!(
        "<robot name=\"beetle\"><link name=\"base\">{}<collision><geometry><box size=\"0.1 0.08 0.03\"/></geometry>\
         </collision></link>",
        inertial(0.0, 0.4, 0.0005)
    );
    for (k, [x, y]) in CORNERS.into_iter().enumerate() {
        let leg = k + 1;
        let _ = write!(
            text,
            "<link name=\"thigh{leg}\">{}</link><link name=\"shin{leg}\">{}<collision><origin xyz=\"0.03 0 -0.09\"/>\
             <geometry><sphere radius=\"0.008\"/></geometry></collision></link>\
             <joint name=\"hip{leg}\" type=\"revolute\"><parent link=\"base\"/><child link=\"thigh{leg}\"/>\
             <origin xyz=\"{} {} 0\"/><axis xyz=\"0 1 0\"/><limit lower=\"-1.1\" upper=\"1.1\" effort=\"1\" velocity=\"1\"/>\
             </joint><joint name=\"knee{leg}\" type=\"revolute\"><parent link=\"thigh{leg}\"/><child link=\"shin{leg}\"/>\
             <origin xyz=\"-0.03 0 -0.08\" rpy=\"0 -0.3 0\"/><axis xyz=\"0 -1 0\"/><limit lower=\"-0.7\" upper=\"0.8\" effort=\"1\" \
             velocity=\"1\"/></joint>",
            inertial(-0.04, 0.05, 0.00004),
            inertial(-0.05, 0.02, 0.00002),
            0.07 * f64::from(x),
            0.05 * f64::from(y),
        );
    }
    text + "</robot>"
}

/// Loads a body and description; the error with all its causes.
fn load_as(file: &str, text: &str, toml: &str) -> Result<Robot, String> {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("robot.toml"), toml.replace("FILE", file)).expect("written");
    std::fs::write(folder.path().join(file), text).expect("written");
    Robot::load(folder.path()).map_err(|error| {
        let mut text = error.to_string();
        let mut cause = std::error::Error::source(&error);
        while let Some(error) = cause {
            let _ = write!(text, ": {error}");
            cause = error.source();
        }
        text
    })
}

/// All places of `from` changed.
fn changed(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "no {from:?} in {text}");
    text.replace(from, to)
}

fn load_mjcf(from: &str, to: &str) -> Result<Robot, String> {
    load_as("beetle.xml", &changed(&mjcf(), from, to), TOML)
}

fn load_urdf(from: &str, to: &str) -> Result<Robot, String> {
    load_as("beetle.urdf", &changed(&urdf(), from, to), TOML)
}

fn says(refused: Result<Robot, String>, parts: &[&str]) {
    let text = refused.expect_err("refused");
    for part in parts {
        assert!(text.contains(part), "{text:?} lacks {part:?}");
    }
}

fn warns(loaded: Result<Robot, String>, parts: &[&str]) {
    let robot = loaded.expect("a robot");
    let texts: Vec<String> = robot.warnings().iter().map(ToString::to_string).collect();
    assert!(
        texts.iter().any(|text| parts.iter().all(|part| text.contains(part))),
        "{texts:?} lack {parts:?}"
    );
}

fn is_quiet(loaded: Result<Robot, String>) -> Robot {
    let robot = loaded.expect("a robot");
    assert!(robot.warnings().is_empty(), "{:?}", robot.warnings());
    robot
}

#[test]
fn robots_that_look_right_load_without_a_word() {
    is_quiet(load_as("beetle.xml", &mjcf(), TOML));
    is_quiet(load_as("beetle.urdf", &urdf(), TOML));
    for name in ["ant", "pony"] {
        is_quiet(Ok(
            Robot::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name)).expect(name)
        ));
    }
}

#[test]
fn legs_outside_their_quadrants_are_refused_by_number_hip_and_place() {
    let orders = [
        // The habit of ROS, mirrored, clockwise, and one corner on.
        (["1", "4", "2", "3"], 2, "front right", "rear left"),
        (["4", "3", "2", "1"], 1, "front right", "front left"),
        (["1", "4", "3", "2"], 2, "front right", "rear left"),
        (["2", "3", "4", "1"], 1, "rear left", "front left"),
    ];
    for (order, leg, is, must) in orders {
        let listed = |part: &str| order.map(|leg| format!("\"{part}{leg}\"")).join(", ");
        let mut toml = TOML.to_owned();
        for part in ["hip", "knee", "shin"] {
            let usual = ["1", "2", "3", "4"].map(|leg| format!("\"{part}{leg}\"")).join(", ");
            toml = changed(&toml, &usual, &listed(part));
        }
        let refused = load_as("beetle.urdf", &urdf(), &toml);
        says(refused, &[&format!("leg {leg}, hip"), is, must, "counter-clockwise from front left"]);
    }
}

#[test]
fn ranges_in_the_other_unit_are_told_in_the_files_own_words() {
    let limits = "lower=\"-1.1\" upper=\"1.1\"";
    warns(load_urdf(limits, "lower=\"-63\" upper=\"63\""), &["hip1", "-63 to 63 rad", "radians"]);
    warns(
        load_mjcf("range=\"-60 60\"", "range=\"-1.05 1.05\""),
        &["hip1", "1.05 degrees", "angle=\"radian\""],
    );
    let radians = changed(&mjcf(), "angle=\"degree\"", "angle=\"radian\"");
    warns(load_as("beetle.xml", &radians, TOML), &["hip1", "-60 to 60 rad", "angle=\"degree\""]);
    warns(load_urdf("rpy=\"0 -0.3 0\"", "rpy=\"0 -17 0\""), &["knee1", "radians"]);
}

#[test]
fn limits_of_any_size_are_none_and_a_full_turn_is_plausible() {
    for size in ["1e16", "inf", "3.4e38", "6.29"] {
        let limits = format!("lower=\"-{size}\" upper=\"{size}\"");
        is_quiet(load_urdf("lower=\"-1.1\" upper=\"1.1\"", &limits));
    }
    is_quiet(load_mjcf("range=\"-60 60\"", "range=\"0 0\""));
    is_quiet(load_mjcf("range=\"-60 60\"", "range=\"-1e9 1e9\""));
    says(load_urdf("lower=\"-1.1\"", "lower=\"nan\""), &["hip1", "<limit>"]);
}

#[test]
fn hinges_that_cannot_turn_are_refused_with_what_urdf_reads() {
    let limits = "lower=\"-0.7\" upper=\"0.8\" ";
    says(load_urdf(limits, ""), &["knee1", "missing lower or upper", "as 0", "continuous"]);
    says(load_urdf(limits, "lower=\"0\" "), &["knee1", "missing lower or upper"]);
    says(load_urdf(limits, "lower=\"0\" upper=\"0\" "), &["knee1", "0 to 0", "below upper"]);
    says(load_urdf(limits, "lower=\"0.8\" upper=\"-0.7\" "), &["knee1", "exchange"]);
    is_quiet(load_urdf(limits, "upper=\"0.8\" "));
    says(load_mjcf("range=\"-60 60\"", "range=\"60 -60\""), &["hip1", "first must be below"]);
    let continuous = "type=\"continuous\"><parent link=\"thigh1\"/>";
    is_quiet(load_urdf("type=\"revolute\"><parent link=\"thigh1\"/>", continuous));
}

#[test]
fn a_joint_may_be_drawn_at_either_end_of_its_range() {
    for (lower, upper) in [("0", "1.57"), ("-1.57", "0")] {
        let limits = format!("lower=\"{lower}\" upper=\"{upper}\" ");
        let robot = is_quiet(load_urdf("lower=\"-0.7\" upper=\"0.8\" ", &limits));

        let [low, high] = Limbs::of(&robot).stops_rad(&robot)[4];
        assert!(low <= 0.0 && high >= 0.0 && (high - low - 1.57).abs() < 2e-3, "{low} to {high}");
    }
    let beyond = load_urdf("lower=\"-0.7\" upper=\"0.8\" ", "lower=\"0.1\" upper=\"0.8\" ");
    says(beyond, &["knee1", "neutral", "shin_below_horizontal_deg"]);
    let hip = load_urdf("lower=\"-1.1\" upper=\"1.1\"", "lower=\"0.1\" upper=\"1.1\"");
    says(hip, &["hip1", "as it is drawn"]);
}

#[test]
fn a_root_joint_that_frees_the_torso_is_left_out_and_others_are_refused_by_name() {
    let with_root = |kind: &str, link: &str, more: &str| {
        let joint = format!(
            "<robot name=\"beetle\"><link name=\"{link}\"/>{more}<joint name=\"to_ground\" type=\"{kind}\">\
             <parent link=\"{link}\"/><child link=\"base\"/></joint>"
        );
        load_urdf("<robot name=\"beetle\">", &joint)
    };
    let bare = is_quiet(load_as("beetle.urdf", &urdf(), TOML));
    for link in ["world", "odom"] {
        let robot = is_quiet(with_root("floating", link, ""));
        assert_eq!(Limbs::of(&robot), Limbs::of(&bare));
    }
    // A name alone fixes nothing: an empty first link is a habit of ROS.
    is_quiet(with_root("fixed", "base_footprint", ""));
    let fixed = with_root("fixed", "world", "");
    says(fixed, &["to_ground", "fixed joint", "\"base\"", "\"world\"", "leave that link and the joint out"]);
    for kind in ["planar", "prismatic", "revolute"] {
        let refused = with_root(kind, "world", "").expect_err("refused");
        assert!(refused.contains("to_ground") && !refused.contains("freejoint"), "{refused}");
    }
    let heavy = "<inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial>";
    let cart = format!(
        "<link name=\"cart\">{heavy}</link><joint name=\"weld\" type=\"fixed\"><parent link=\"world\"/><child link=\"cart\"/></joint>"
    );
    says(with_root("floating", "world", &cart), &["to_ground", "cart", "part of the robot"]);

    says(load_mjcf("<freejoint/>", ""), &["base", "<freejoint/>"]);
    let slide = "<joint name=\"rootx\" type=\"slide\" axis=\"1 0 0\"/>";
    says(load_mjcf("<freejoint/>", slide), &["rootx", "slide", "one <freejoint/>"]);
    is_quiet(load_mjcf("<freejoint/>", "<joint name=\"root\" type=\"free\"/>"));
}

#[test]
fn a_mimic_joint_and_two_roots_are_refused() {
    let mimic = "<axis xyz=\"0 -1 0\"/><mimic joint=\"hip1\"/>";
    says(load_urdf("<axis xyz=\"0 -1 0\"/>", mimic), &["mimic", "knee1"]);
    says(load_urdf("</robot>", "<link name=\"spare\"/></robot>"), &["spare", "not connected"]);
}

#[test]
fn densities_of_real_materials_load_and_others_are_doubted_or_refused() {
    let torso = "size=\"0.05 0.04 0.015\" mass=\"0.4\"";
    for (density, mass_kg) in [(1240.0, 0.2976), (2700.0, 0.648), (19_300.0, 4.632)] {
        let dense = format!("size=\"0.05 0.04 0.015\" density=\"{density}\"");
        let robot = load_mjcf(torso, &dense).expect("a robot");
        assert!((robot.mass.torso_kg - mass_kg).abs() < 1e-5, "{} kg", robot.mass.torso_kg);
    }
    says(load_mjcf(torso, "size=\"0.05 0.04 0.015\" density=\"-1240\""), &["density", "-1240", "0 or more"]);
    says(load_mjcf(torso, "size=\"0.05 0.04 0.015\" density=\"1e6\""), &["density", "25000"]);
    says(load_mjcf("mass=\"0.05\"", "mass=\"-0.05\""), &["thigh1", "-0.05", "0 or more"]);
    warns(load_mjcf("mass=\"0.05\"", "density=\"1.24\""), &["thigh1", "1.24", "g/cm^3"]);
    let light = "size=\"0.05 0.04 0.015\" density=\"1.24\"";
    says(load_mjcf(torso, light), &["base", "0.01 to 20 kg", "kg/m^3"]);
}

#[test]
fn lengths_and_masses_in_another_unit_are_told() {
    let millimetres = |text: &str, scale: f64| {
        // Every length of the MJCF: what stands in pos, fromto and size.
        let mut scaled = String::new();
        for piece in text.split_inclusive('"') {
            let is_length = ["pos=\"", "fromto=\"", "size=\""].iter().any(|name| scaled.ends_with(name));
            let Some(numbers) = piece.strip_suffix('"').filter(|_| is_length) else {
                scaled += piece;
                continue;
            };
            let numbers = numbers.split(' ').map(|number| number.parse::<f64>().expect("a number") * scale);
            scaled += &numbers.map(|number| number.to_string()).collect::<Vec<_>>().join(" ");
            scaled.push('"');
        }
        scaled
    };
    for scale in [1000.0, 100.0, 39.37] {
        says(load_as("beetle.xml", &millimetres(&mjcf(), scale), TOML), &["leg 1", "metres", "millimetres"]);
    }
    says(load_mjcf("mass=\"0.4\"", "mass=\"400\""), &["base", "400 kg", "grams"]);
    warns(load_mjcf("mass=\"0.02\"", "mass=\"20\""), &["shin1", "grams"]);
    says(load_urdf("<box size=\"0.1 0.08 0.03\"/>", "<box size=\"100 80 30\"/>"), &["base", "millimetres"]);
}

#[test]
fn inertia_beyond_a_parts_size_is_refused_and_a_doubtful_one_told() {
    for moment in ["1.0", "0.01", "20000"] {
        let inertia =
            format!("ixx=\"{moment}\" ixy=\"0\" ixz=\"0\" iyy=\"{moment}\" iyz=\"0\" izz=\"{moment}\"");
        let plain = "ixx=\"0.00002\" ixy=\"0\" ixz=\"0\" iyy=\"0.00002\" iyz=\"0\" izz=\"0.00002\"";
        says(load_urdf(plain, &inertia), &["shin1", "radius of gyration", "placeholder"]);
    }
    let moderate = "ixx=\"0.001\" ixy=\"0\" ixz=\"0\" iyy=\"0.001\" iyz=\"0\" izz=\"0.001\"";
    let plain = "ixx=\"0.00002\" ixy=\"0\" ixz=\"0\" iyy=\"0.00002\" iyz=\"0\" izz=\"0.00002\"";
    warns(load_urdf(plain, moderate), &["shin1", "radius of gyration", "placeholder"]);
    let tiny = "ixx=\"1e-9\" ixy=\"0\" ixz=\"0\" iyy=\"1e-9\" iyz=\"0\" izz=\"1e-9\"";
    warns(load_urdf(plain, tiny), &["shin1", "reaches", "kg m^2"]);
}

#[test]
fn geoms_for_looks_neither_touch_nor_weigh() {
    let with = |geom: &str| load_mjcf("<freejoint/>", &format!("<freejoint/>{geom}"));
    let bare = Limbs::of(&is_quiet(load_as("beetle.xml", &mjcf(), TOML)));
    let looks = "contype=\"0\" conaffinity=\"0\"";
    for geom in [
        format!("<geom type=\"mesh\" mesh=\"cover\" {looks} mass=\"0\"/>"),
        format!("<geom type=\"mesh\" mesh=\"cover\" {looks} density=\"0\"/>"),
        format!("<geom type=\"ellipsoid\" size=\"1 1 1\" {looks} mass=\"0\"/>"),
        format!("<geom type=\"plane\" size=\"1 1 1\" {looks}/>"),
    ] {
        assert_eq!(Limbs::of(&is_quiet(with(&geom))), bare, "{geom}");
    }
    let weighed = with(&format!("<geom type=\"mesh\" mesh=\"cover\" {looks}/>"));
    says(weighed, &["base", "has no <inertial>", "mass=\"0\""]);
    says(with("<geom type=\"mesh\" mesh=\"cover\" mass=\"0\"/>"), &["base", "mesh", "contype=\"0\""]);
    let by_class = changed(
        &changed(
            &mjcf(),
            "<worldbody>",
            "<default><default class=\"visual\"><geom type=\"mesh\" contype=\"0\" conaffinity=\"0\" mass=\"0\"/></default></default><worldbody>",
        ),
        "<freejoint/>",
        "<freejoint/><geom class=\"visual\" mesh=\"cover\"/>",
    );
    assert_eq!(Limbs::of(&is_quiet(load_as("beetle.xml", &by_class, TOML))), bare);
    let mesh = "</collision></link>";
    let visual = "</collision><visual><geometry><mesh filename=\"cover.stl\"/></geometry></visual></link>";
    is_quiet(load_urdf(mesh, visual));
}

#[test]
fn a_box_or_ellipsoid_between_two_points_is_as_mujoco_makes_it() {
    let capsule = "<geom type=\"capsule\" fromto=\"0 0 0 0 0.05 0\" size=\"0.006\" mass=\"0.05\"/>";
    let rods = changed(
        &mjcf(),
        capsule,
        "<geom type=\"box\" fromto=\"0 0 0 0 0.05 0\" size=\"0.006\" mass=\"0.05\"/>",
    );
    let thigh = Limbs::of(&is_quiet(load_as("beetle.xml", &rods, TOML))).legs[0].thigh.clone();
    let written = changed(
        &mjcf(),
        capsule,
        "<geom type=\"box\" pos=\"0 0.025 0\" size=\"0.006 0.025 0.006\" mass=\"0.05\"/>",
    );
    let other = Limbs::of(&is_quiet(load_as("beetle.xml", &written, TOML))).legs[0].thigh.clone();
    assert!((thigh.inertia.centre_m - other.inertia.centre_m).norm() < 1e-6, "{thigh:?}");
    let size = other.inertia.tensor_kg_m2.amax();
    assert!((thigh.inertia.tensor_kg_m2 - other.inertia.tensor_kg_m2).amax() < 1e-4 * size, "{thigh:?}");

    let egg = "<geom type=\"ellipsoid\" fromto=\"0 0 0 0 0.05 0\" size=\"0.006\" mass=\"0.05\" contype=\"0\" conaffinity=\"0\"/>";
    let eggs = changed(&mjcf(), capsule, egg);
    let inertia = Limbs::of(&is_quiet(load_as("beetle.xml", &eggs, TOML))).legs[0].thigh.inertia.clone();
    let moment = 0.05 / 5.0 * (0.025 * 0.025 + 0.006 * 0.006);
    assert!((inertia.principal().moments_kg_m2.max() / moment - 1.0).abs() < 1e-4, "{inertia:?}");
    let touching = egg.replace(" contype=\"0\" conaffinity=\"0\"", " contype=\"1\"");
    says(load_as("beetle.xml", &changed(&mjcf(), capsule, &touching), TOML), &["ellipsoid"]);
    is_quiet(load_as(
        "beetle.xml",
        &changed(&mjcf(), capsule, &capsule.replace("capsule", "cylinder")),
        TOML,
    ));
    says(
        load_as("beetle.xml", &changed(&mjcf(), capsule, &capsule.replace("capsule", "sphere")), TOML),
        &["fromto", "sphere"],
    );
    let short = "<geom type=\"capsule\" size=\"0.006\" mass=\"0.05\"/>";
    says(load_as("beetle.xml", &changed(&mjcf(), capsule, short), TOML), &["thigh1", "2 numbers", "fromto"]);
    says(load_mjcf("size=\"0.05 0.04 0.015\"", "size=\"0.05 0.04\""), &["base", "3 numbers"]);
}

#[test]
fn a_xacro_and_a_file_of_the_other_format_are_told_apart() {
    let property =
        "<robot name=\"beetle\" xmlns:xacro=\"http://ros.org\"><xacro:property name=\"L\" value=\"0.1\"/>";
    for (from, to) in [
        ("<robot name=\"beetle\">", property),
        ("<robot name=\"beetle\">", "<robot name=\"beetle\"><xacro:include filename=\"a.xacro\"/>"),
        ("radius=\"0.008\"", "radius=\"${r}\""),
        ("<robot name=\"beetle\">", "<robot name=\"$(arg name)\">"),
    ] {
        says(load_urdf(from, to), &["is a xacro, not a URDF yet", "xacro FILE"]);
    }
    // What xacro leaves behind.
    is_quiet(load_urdf("<robot name=\"beetle\">", "<robot name=\"beetle\" xmlns:xacro=\"http://ros.org\">"));
    says(load_as("beetle.urdf.xacro", &urdf(), TOML), &["xacro"]);
    says(load_as("beetle.xml", &urdf(), TOML), &["<robot>", ".urdf"]);
    says(load_as("beetle.urdf", &mjcf(), TOML), &["<mujoco>", ".xml"]);
    says(load_mjcf("<worldbody>", "<worldbody><include file=\"a.xml\"/>"), &["<include>", "one file"]);
}

/// The share of two seconds of standing in which more than feet touch.
fn drags(robot: &Robot) -> bool {
    let mut world = World::new(robot);
    for _ in 0..480 {
        world.step(&[Some(0.0); 8]);
    }
    assert_eq!(world.foot_contacts(), [true; 4]);
    world.body_touches_ground()
}

#[test]
fn a_shin_that_ends_within_its_foots_ball_is_the_foot_and_a_thicker_one_is_told() {
    for radius in ["0.004", "0.0076", "0.008"] {
        let robot = is_quiet(load_mjcf("size=\"0.004\"", &format!("size=\"{radius}\"")));
        assert!(!drags(&robot), "{radius}");
    }
    warns(load_mjcf("size=\"0.004\"", "size=\"0.012\""), &["leg 1", "4.0 mm", "thicker"]);
    let longer = load_mjcf("-0.09\" size=\"0.004\"", "-0.11\" size=\"0.004\"").expect("a robot");
    assert!(
        matches!(longer.warnings()[..], [RobotWarning::ShinBelowFoot { leg: 1, .. }]),
        "{:?}",
        longer.warnings()
    );
    let mut world = World::new(&longer);
    for _ in 0..480 {
        world.step(&[Some(0.0); 8]);
    }
    assert!(world.body_touches_ground());
}

#[test]
fn no_robot_draws_more_than_its_supply_gives_and_a_weight_beyond_the_servos_is_told() {
    for (ohm, limit_w) in [("0.01", 900.0), ("0.1", 90.0), ("5.0", 1.8)] {
        let toml = changed(TOML, "resistance_ohm = 0.1", &format!("resistance_ohm = {ohm}"));
        let toml = changed(&toml, "heat_w_per_n2_m2 = 2.0", "heat_w_per_n2_m2 = 80.0");
        let toml = changed(&toml, "torque_limit_n_m = 0.9", "torque_limit_n_m = 0.15");
        let heavy = changed(&mjcf(), "mass=\"0.4\"", "mass=\"12\"");
        let heavy = changed(&heavy, "<joint name=\"knee1\"", "<joint range=\"-20 20\" name=\"knee1\"");
        let robot = load_as("beetle.xml", &heavy, &toml).expect("a robot");
        let too_heavy = robot.warnings().into_iter().find(|one| matches!(one, RobotWarning::TooHeavy { .. }));
        let text = too_heavy.expect("12 kg on 0.15 N m").to_string();
        assert!(text.contains("12.30 kg") && text.contains("0.15"), "{text}");

        let mut world = World::new(&robot);
        for step in 0..720 {
            let outcome = world.step(&[Some(0.8 * f64::from(step / 60 % 3 - 1)); 8]);
            assert!(outcome.servo_power_w + 0.3 <= limit_w + 1e-9, "{outcome:?}");
            assert!(
                outcome.mechanical_power_w <= limit_w && outcome.holding_power_w <= limit_w,
                "{outcome:?}"
            );
        }
    }
    let weak = changed(TOML, "resistance_ohm = 0.1", "resistance_ohm = 5.0");
    let weak = changed(&weak, "electronics_w = 0.3", "electronics_w = 3.0");
    warns(load_as("beetle.xml", &mjcf(), &weak), &["1.80 W at most", "5 ohm"]);
}
