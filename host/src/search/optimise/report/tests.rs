//! What a report counts, and that its energy balance agrees with the trial's energy.

use super::*;
use crate::robot::LegScale;
use crate::search::optimise::basis::Basis;
use crate::search::optimise::score::{Aim, Counted};
use crate::search::optimise::space::Space;
use crate::sim::open_loop::{Trial, play};
use protocol::gait::COEFFICIENT_COUNT;
use protocol::{JOINT_COUNT, LEG_COUNT};

fn fresh(draws: usize, stop: &AtomicBool) -> Fresh<'_> {
    Fresh { seed: 0, draws, stop }
}

/// Diagonal legs together, at a stroke that walks.
fn trot(robot: &Robot) -> Motion {
    let space = Space::new(Basis::new().expect("the algebra holds"), Bounds::of(robot), 1);
    let mut waves = [[0.0; 2]; JOINT_COUNT];
    for (leg, forwards) in [-1.0, -1.0, 1.0, 1.0].into_iter().enumerate() {
        let side = if leg % 2 == 0 { 1.0 } else { -1.0 };
        waves[leg] = [15.0 * forwards * side, 0.0];
        waves[LEG_COUNT + leg] = [0.0, -10.0 * side];
    }
    space.swinging(1.2, [0.0; JOINT_COUNT], &waves)
}

#[test]
fn quantiles_lie_between_the_values() {
    let quantiles = quantiles((0..=10).rev().map(f64::from).collect());

    assert_eq!((quantiles.p10, quantiles.median, quantiles.p90), (1.0, 5.0, 9.0));
    assert!(super::quantiles(vec![1.0, f64::INFINITY, 2.0]).p90.is_infinite());
}

#[test]
fn a_standing_robot_pays_for_its_electronics_alone() {
    let robot = Robot::ant(LegScale::LONG).expect("1.0 is a leg scale");
    let still = Motion {
        period_s: 1.0,
        centres_deg: [0.0; JOINT_COUNT],
        curves_deg: [[0.0; COEFFICIENT_COUNT]; JOINT_COUNT],
    };

    let power = power_balance(&robot, &still).expect("nothing moves");

    assert!((power.total_w - robot.power.electronics_w).abs() < 0.01, "{power:?}");
    assert!(power.slipping_w.abs() < 0.01 && power.braking_w.abs() < 0.01, "{power:?}");
}

#[test]
fn the_safe_range_ends_at_the_first_gap_on_either_side() {
    let robot = Robot::ant(LegScale::LONG).expect("1.0 is a leg scale");
    let still = Motion {
        period_s: 1.0,
        centres_deg: [0.0; JOINT_COUNT],
        curves_deg: [[0.0; COEFFICIENT_COUNT]; JOINT_COUNT],
    };
    let test = Test { aim: Aim::Speed, counted: Counted::Distance, duration_s: 0.1 };
    let walks =
        over_draws(&robot, &Tolerances::default(), &test, &still, 1.0, fresh(1, &AtomicBool::new(false)));
    let at =
        |amplitude, safe| AtAmplitude { amplitude, setpoint_speed_rad_s: 1.0, safe, walks: walks.clone() };
    let mut amplitudes = vec![at(0.7, true), at(0.8, false), at(0.9, true), at(1.0, true), at(1.1, false)];

    assert_eq!(safe_range(&amplitudes), Some((0.9, 1.0)));
    amplitudes[3].safe = false;
    assert_eq!(safe_range(&amplitudes), None);
}

/// A trial counts the energy of the supply, the balance where it goes.
#[test]
fn where_the_power_goes_comes_to_what_a_trial_takes() {
    let robot = Robot::ant(LegScale::LONG).expect("the Ant");
    let motion = trot(&robot);
    let walk = play(&robot, &Trial::default(), |time_s| motion.angles_rad(time_s, 1.0));

    let power = power_balance(&robot, &motion).expect("it walks");

    // Both drives and soles take something: it walks.
    assert!(power.slipping_w > 0.01 && power.braking_w > 0.01 && walk.speed_m_s > 0.03, "{power:?}");
    assert!((power.total_w / walk.mean_power_w - 1.0).abs() < 0.03, "{power:?} {}", walk.mean_power_w);
    assert!(power.rest_w.abs() < 0.15 * power.total_w, "{power:?}");
}

#[test]
fn a_report_that_is_told_to_stop_plays_the_least_robots_and_no_amplitudes() {
    let robot = Robot::ant(LegScale::LONG).expect("the Ant");
    let test = Test { aim: Aim::Speed, counted: Counted::Distance, duration_s: 0.1 };
    let (tolerances, stop) = (Tolerances::default(), AtomicBool::new(true));
    let motion = trot(&robot);

    let walks = over_draws(&robot, &tolerances, &test, &motion, 1.0, fresh(100, &stop));
    let amplitudes = over_amplitudes(&robot, &tolerances, &test, &motion, fresh(100, &stop));

    assert_eq!(walks.draws, LEAST_DRAWS);
    assert!(amplitudes.is_empty());
}

#[test]
fn servos_that_cannot_follow_are_counted() {
    let robot = Robot::ant(LegScale::LONG).expect("the Ant");
    let test = Test { aim: Aim::Speed, counted: Counted::Distance, duration_s: 0.1 };
    let stop = AtomicBool::new(false);
    let mut motion = trot(&robot);
    let count = |motion: &Motion| {
        let walks = over_draws(&robot, &Tolerances::default(), &test, motion, 1.0, fresh(20, &stop));
        walks.slower_servos
    };

    motion.period_s = 10.0;
    let slow = count(&motion);
    // As fast as the fitted robot's servos: some of the drawn ones are slower.
    motion.period_s *= motion.fastest_deg_s(1.0) / robot.servo.top_speed_rad_s().to_degrees();
    let even = count(&motion);

    assert!(slow == 0 && (3..=17).contains(&even), "{slow}, {even}");
}
