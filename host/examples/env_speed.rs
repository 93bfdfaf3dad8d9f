//! Prints environment steps a second while the Ant walks, on one core.
//!
//! `cargo run -p host --example env_speed`. Observation, reward and episode
//! resets are included: it is what a learner gets.

use host::env::Env as _;
use host::robot::Robot;
use host::sim::{AntEnv, AntEnvConfig};
use std::time::Instant;

const STEPS: u32 = 10_000;

fn main() -> Result<(), host::robot::RobotError> {
    let mut env = AntEnv::new(&Robot::ant(1.0)?, AntEnvConfig::default());
    let mut observation = [0.0; 27];
    let mut rates = Vec::new();
    for run in 0..5 {
        env.reset(run, &mut observation);
        let began = Instant::now();
        for step in 0..STEPS {
            let phase = core::f32::consts::TAU * (step as f32 / 60.0) / 0.9;
            let action: [f32; 8] = core::array::from_fn(|j| {
                let leg_phase = phase + core::f32::consts::PI * (j % 2) as f32;
                if j < 4 { 0.5 * leg_phase.sin() } else { 0.4 * leg_phase.cos() }
            });
            let step = env.step(&action, &mut observation);
            if step.terminated || step.truncated {
                env.reset(run, &mut observation);
            }
        }
        rates.push(f64::from(STEPS) / began.elapsed().as_secs_f64());
    }
    rates.sort_by(f64::total_cmp);
    println!(
        "{:.0} environment steps/s (median of 5 runs of {STEPS}; {:.0} to {:.0}), 4 physics steps each",
        rates[2], rates[0], rates[4]
    );
    Ok(())
}
