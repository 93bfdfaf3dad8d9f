//! The folder that `docs/robots.md` prints is a robot that stands.

use host::robot::Robot;
use host::sim::World;

const DOC: &str = include_str!("../../docs/robots.md");

/// The first block of a language.
fn block(language: &str) -> &'static str {
    let open = format!("```{language}\n");
    let start = DOC.find(&open).expect("a block") + open.len();
    &DOC[start..start + DOC[start..].find("```").expect("its end")]
}

#[test]
fn the_printed_folder_loads_and_stands_on_its_feet() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("robot.toml"), block("toml")).expect("written");
    std::fs::write(folder.path().join("crab.xml"), block("xml")).expect("written");

    let robot = Robot::load(folder.path()).expect("a robot");

    assert!((robot.mass_kg() - (0.11 + 4.0 * 0.018)).abs() < 1e-6, "{} kg", robot.mass_kg());
    assert!((robot.geometry.shin_below_horizontal_deg - 60.0).abs() < 1e-3);
    let mut world = World::new(&robot);
    for _ in 0..720 {
        world.step(&[Some(0.0); 8]);
    }
    assert_eq!(world.foot_contacts(), [true; 4]);
    assert!(!world.body_touches_ground() && world.torso().tilt_rad() < 0.02, "{:?}", world.torso());
    assert!(world.torso().position_m[2] > 0.04, "{:?}", world.torso());
}
