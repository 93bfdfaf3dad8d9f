//! What a report counts, and that its books agree with the trial's own.

use super::*;
use crate::search::optimise::basis::Basis;
use crate::search::optimise::score::Aim;
use crate::search::optimise::space::Space;
use crate::sim::open_loop::{Trial, play};

fn fresh(draws: usize, stop: &AtomicBool) -> Fresh<'_> {
    Fresh { seed: 0, draws, stop }
}

/// Diagonal legs together, at a stroke that walks.
fn trot(robot: &Robot) -> Motion {
    let space = Space::new(Basis::new().expect("the algebra holds"), Bounds::of(robot), 1);
    let mut waves = [[0.0; 2]; 8];
    for (leg, forwards) in [-1.0, -1.0, 1.0, 1.0].into_iter().enumerate() {
        let side = if leg % 2 == 0 { 1.0 } else { -1.0 };
        waves[leg] = [15.0 * forwards * side, 0.0];
        waves[4 + leg] = [0.0, -10.0 * side];
    }
    space.swinging(1.2, [0.0; 8], &waves)
}

#[test]
fn quantiles_lie_between_the_values() {
    let quantiles = quantiles((0..=10).rev().map(f64::from).collect());

    assert_eq!((quantiles.p10, quantiles.median, quantiles.p90), (1.0, 5.0, 9.0));
    assert!(super::quantiles(vec![1.0, f64::INFINITY, 2.0]).p90.is_infinite());
}

#[test]
fn a_standing_robot_pays_for_its_electronics_alone() {
    let robot = Robot::ant(1.0).expect("1.0 is a leg scale");
    let still = Motion { period_s: 1.0, centres_deg: [0.0; 8], curves_deg: [[0.0; 11]; 8] };

    let books = power_books(&robot, &still).expect("nothing moves");

    assert!((books.total_w - robot.power.electronics_w).abs() < 0.01, "{books:?}");
    assert!(books.slipping_w.abs() < 0.01 && books.braking_w.abs() < 0.01, "{books:?}");
}

#[test]
fn the_safe_range_ends_at_the_first_gap_on_either_side() {
    let robot = Robot::ant(1.0).expect("1.0 is a leg scale");
    let still = Motion { period_s: 1.0, centres_deg: [0.0; 8], curves_deg: [[0.0; 11]; 8] };
    let test = Test { aim: Aim::Speed, duration_s: 0.1 };
    let walks =
        over_draws(&robot, &Tolerances::default(), &test, &still, 1.0, fresh(1, &AtomicBool::new(false)));
    let at =
        |amplitude, safe| AtAmplitude { amplitude, setpoint_speed_rad_s: 1.0, safe, walks: walks.clone() };
    let mut amplitudes = vec![at(0.7, true), at(0.8, false), at(0.9, true), at(1.0, true), at(1.1, false)];

    assert_eq!(safe_range(&amplitudes), Some((0.9, 1.0)));
    amplitudes[3].safe = false;
    assert_eq!(safe_range(&amplitudes), None);
}

/// The trial counts what the supply gives, the books what becomes of it.
#[test]
fn where_the_power_goes_comes_to_what_a_trial_takes() {
    let robot = Robot::ant(1.0).expect("1.0 is a leg scale");
    let motion = trot(&robot);
    let walk = play(&robot, &Trial::default(), |time_s| motion.angles_rad(time_s, 1.0));

    let books = power_books(&robot, &motion).expect("it walks");

    // Both drives and soles take something: it walks.
    assert!(books.slipping_w > 0.01 && books.braking_w > 0.01 && walk.speed_m_s > 0.03, "{books:?}");
    assert!((books.total_w / walk.mean_power_w - 1.0).abs() < 0.03, "{books:?} {}", walk.mean_power_w);
    assert!(books.rest_w.abs() < 0.15 * books.total_w, "{books:?}");
}

#[test]
fn a_report_that_is_told_to_stop_plays_the_least_robots_and_no_amplitudes() {
    let robot = Robot::ant(1.0).expect("1.0 is a leg scale");
    let test = Test { aim: Aim::Speed, duration_s: 0.1 };
    let (tolerances, stop) = (Tolerances::default(), AtomicBool::new(true));
    let motion = trot(&robot);

    let walks = over_draws(&robot, &tolerances, &test, &motion, 1.0, fresh(100, &stop));
    let amplitudes = over_amplitudes(&robot, &tolerances, &test, &motion, fresh(100, &stop));

    assert_eq!(walks.draws, LEAST_DRAWS);
    assert!(amplitudes.is_empty());
}

#[test]
fn servos_that_cannot_follow_are_counted() {
    let robot = Robot::ant(1.0).expect("1.0 is a leg scale");
    let test = Test { aim: Aim::Speed, duration_s: 0.1 };
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
