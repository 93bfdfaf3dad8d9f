//! Prints how long a trial of 12 s takes to simulate on one core.
//!
//! `cargo run -p host --release --example trial_speed`. The entry of 1.5 s is
//! included, as in every trial that a fit plays.

use host::robot::Robot;
use host::sim::open_loop::{Trial, play};
use std::time::Instant;

const TRIALS: usize = 15;

fn main() -> Result<(), host::robot::RobotError> {
    let robot = Robot::ant(1.0)?;
    let mut times_s: Vec<f64> = (0..TRIALS)
        .map(|_| {
            let began = Instant::now();
            let walk = play(&robot, &Trial::default(), |t| {
                let phase = core::f64::consts::TAU * t / 1.6;
                core::array::from_fn(|j| {
                    let leg_phase = phase + core::f64::consts::PI * (j % 2) as f64;
                    let swing = if j % 4 < 2 { 0.5 } else { -0.5 };
                    if j < 4 { swing * leg_phase.sin() } else { 0.3 * leg_phase.cos() }
                })
            });
            assert!(walk.distance_m > 0.0);
            began.elapsed().as_secs_f64()
        })
        .collect();
    times_s.sort_by(f64::total_cmp);
    println!(
        "{:.3} s for a trial of 12 s (median of {TRIALS}; {:.3} to {:.3})",
        times_s[TRIALS / 2],
        times_s[0],
        times_s[TRIALS - 1]
    );
    Ok(())
}
