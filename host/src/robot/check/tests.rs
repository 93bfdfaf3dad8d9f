//! Findings by hand, and robots that are wrong in one way each.

use super::*;
use std::path::Path;

fn shipped(name: &str) -> Robot {
    Robot::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name)).expect("a robot")
}

/// The Pony with its drawing changed.
fn changed(change: impl Fn(&str) -> String) -> Robot {
    let folder = tempfile::tempdir().expect("a folder");
    let pony = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/pony");
    std::fs::copy(pony.join("robot.toml"), folder.path().join("robot.toml")).expect("copied");
    let text = std::fs::read_to_string(pony.join("pony.urdf")).expect("text");
    std::fs::write(folder.path().join("pony.urdf"), change(&text)).expect("written");
    Robot::load(folder.path()).expect("a robot")
}

fn mark(robot: &Robot, topic: Topic) -> Mark {
    check(robot).finding(topic).expect("every topic is looked at").mark
}

#[test]
fn the_shipped_robots_have_no_errors() {
    for name in ["ant", "pony", "newt"] {
        let found = check(&shipped(name));
        assert_eq!(found.count(Mark::Error), 0, "{name}: {found:#?}");
    }
    assert_eq!(check(&shipped("newt")).count(Mark::Warning), 0, "{:#?}", check(&shipped("newt")));
}

/// A foot's share of 1.8 kg at 45 mm before its knee, less shin and foot, which hang there.
#[test]
fn the_ponys_knees_hold_the_share_of_its_weight_on_their_feet_at_their_lever() {
    let pony = shipped("pony");
    let limbs = Limbs::of(&pony);
    let standing = Standing::of(&limbs);

    let forces_n = standing.on_four_n();
    let held_n_m = standing.holding_n_m(&forces_n);

    let weight_n = 1.8 * 9.80665;
    assert!((forces_n.iter().sum::<f64>() - weight_n).abs() < 1e-6, "{forces_n:?}");
    let moment_n_m: f64 =
        forces_n.iter().zip(&standing.feet_m).map(|(force_n, foot_m)| force_n * foot_m.x).sum();
    assert!((moment_n_m - weight_n * standing.centre_m.x).abs() < 1e-6, "{forces_n:?}");
    // Ball and tube in middle and mass: 0.09 and 0.046 m down a shin at 30 degrees from upright.
    let expected = 0.5 * (forces_n[0] * 0.09 - 9.80665 * (0.01 * 0.09 + 0.03 * 0.046));
    assert!((held_n_m[4].abs() - expected).abs() < 1e-3, "{} {expected}", held_n_m[4]);
    let two = standing.on_two_n(DIAGONALS[0]);
    assert!((two[0] + two[2] - weight_n).abs() < 1e-9 && two[1] == 0.0, "{two:?}");
}

#[test]
fn span_and_height_are_those_of_the_drawing() {
    let found = check(&shipped("pony"));

    // From the torso's front to the rear knees, 50 mm behind their hips, with the thigh's tube
    // of 8 mm; feet of 10 mm below hips at 80 mm are the widest.
    let length_m = 0.14 + 0.12 + 0.05 + 0.008 * 0.75_f64.sqrt();
    assert!((found.span_m[0] - length_m).abs() < 1e-5, "{:?}", found.span_m);
    assert!((found.span_m[1] - 0.18).abs() < 1e-4, "{:?}", found.span_m);
    assert!((found.standing_height_m - (0.75_f64.sqrt() * 0.19 + 0.01)).abs() < 1e-4, "{found:?}");
    assert!((found.span_m[2] - found.standing_height_m - 0.03).abs() < 1e-6, "{found:?}");
}

#[test]
fn a_robot_that_is_too_heavy_for_its_servos_is_an_error() {
    let mut heavy = shipped("newt");
    heavy.mass.torso_kg = 12.0;

    let found = check(&heavy);

    let finding = found.finding(Topic::KneeTorqueOnFour).expect("looked at");
    assert_eq!(finding.mark, Mark::Error);
    assert!(finding.next.as_ref().is_some_and(|next| next.contains("cannot carry")), "{finding:?}");
    assert_eq!(found.finding(Topic::Mass).map(|finding| finding.mark), Some(Mark::Warning));
}

#[test]
fn a_supply_that_cannot_feed_the_servos_is_found() {
    let mut weak = shipped("newt");
    weak.supply.resistance_ohm = 5.0;

    assert_eq!(mark(&weak, Topic::PeakPower), Mark::Warning);
    assert_eq!(mark(&shipped("newt"), Topic::PeakPower), Mark::Ok);
}

#[test]
fn grams_for_kilograms_are_found_by_density() {
    let robot = changed(|text| text.replace("<mass value=\"0.03\"/>", "<mass value=\"30\"/>"));

    assert_eq!(mark(&robot, Topic::Density), Mark::Warning);
    assert_eq!(mark(&shipped("pony"), Topic::Density), Mark::Ok);
}

#[test]
fn legs_out_of_order_are_an_error_that_names_the_leg() {
    let mut robot = shipped("pony");
    let drawn = std::sync::Arc::make_mut(&mut robot.drawn);
    drawn.legs.swap(1, 3);
    robot.model.hips.swap(1, 3);

    let found = check(&robot);

    let finding = found.finding(Topic::LegOrder).expect("looked at");
    assert_eq!(finding.mark, Mark::Error);
    let next = finding.next.as_deref().unwrap_or_default();
    assert!(
        next.contains(
            "leg 2, front_right_hip, sits at x 0.120, y -0.080: front right, but leg 2 is rear left"
        ),
        "{next}"
    );
}

#[test]
fn a_leg_that_hangs_and_a_torso_that_lies_are_found() {
    let hanging =
        changed(|text| text.replacen("<origin xyz=\"0.12 0.08 0\"", "<origin xyz=\"0.12 0.08 0.01\"", 1));
    let found = check(&hanging);
    let finding = found.finding(Topic::GroundContact).expect("looked at");
    assert_eq!((finding.mark, finding.value), (Mark::Warning, 3.0), "{finding:?}");
    assert_eq!(finding.part.as_deref(), Some("foot 1"));

    let mut lying = shipped("ant");
    lying.geometry.shin_below_horizontal_deg = 0.0;
    assert_eq!(mark(&lying, Topic::GroundContact), Mark::Error);
}

#[test]
fn ranges_in_the_wrong_unit_are_found() {
    let with = |range_rad: [f64; 2]| {
        let mut robot = shipped("pony");
        for leg in &mut std::sync::Arc::make_mut(&mut robot.drawn).legs {
            leg.hip.range_rad = Some(range_rad);
            leg.knee.range_rad = Some(range_rad);
        }
        mark(&robot, Topic::Range)
    };
    assert_eq!(with([-69.0, 69.0]), Mark::Error);
    assert_eq!(with([-0.0183, 0.0183]), Mark::Warning);
    assert_eq!(with([-1.2, 1.2]), Mark::Ok);
}

#[test]
fn a_range_tighter_than_the_joint_limit_is_noted() {
    let mut robot = shipped("pony");
    std::sync::Arc::make_mut(&mut robot.drawn).legs[2].hip.range_rad = Some([-0.1, 1.0]);

    let found = check(&robot);

    let finding = found.finding(Topic::JointLimit).expect("looked at");
    assert_eq!((finding.mark, finding.part.as_deref()), (Mark::Note, Some("rear_right_hip")));
    assert!(finding.next.as_ref().is_some_and(|next| next.contains("5.7 degrees")), "{finding:?}");
}
