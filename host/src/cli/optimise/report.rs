//! The result of a search, for people and for scripts.
//!
//! Holds the words and the fields of the JSON. Does not depend on how a gait is
//! searched.

use crate::cli::explain::{path_text, warn};
use crate::gait::gait_file::{GaitFile, gait_sha256};
use crate::paper;
use crate::robot::Robot;
use crate::search::optimise::report::{
    AtAmplitude, OverDraws, PowerBalance, Quantiles, TRIAL_S, floor, power_balance,
};
use crate::search::optimise::result::{FrontResult, OptimiseResult};
use crate::search::optimise::space::{Motion, SPEED_MARGIN};
use crate::search::optimise::tolerances::has_spread;
use crate::sim::open_loop::direction_warning;
use std::path::Path;

/// A gait and all that is known of it.
pub struct Outcome<'a> {
    pub robot: &'a Robot,
    pub gait: &'a GaitFile,
    pub path: &'a Path,
    pub motion: &'a Motion,
    pub walks: &'a OverDraws,
    pub amplitudes: &'a [AtAmplitude],
    pub trials: u64,
    pub at_least_m_s: Option<f64>,
    pub seed: u64,
    pub wall_s: f64,
    /// By Ctrl-C: there are fewer robots, and perhaps no amplitudes.
    pub interrupted: bool,
}

impl Outcome<'_> {
    /// What scripts read.
    pub fn result(&self, front: Option<FrontResult>) -> OptimiseResult {
        let Self { robot, walks, motion, .. } = self;
        OptimiseResult {
            leg: robot.geometry.leg_scale,
            seed: self.seed,
            wall_s: self.wall_s,
            evaluations: self.trials,
            interrupted: self.interrupted,
            gait: path_text(self.path),
            gait_sha256: self.gait.encoded().map(|bytes| gait_sha256(&bytes)).unwrap_or_default(),
            period_s: motion.period_s,
            min_speed_m_s: self.at_least_m_s,
            cost_of_transport_median: walks.cost_of_transport.median,
            cost_of_transport_p90: walks.cost_of_transport.p90,
            speed_m_s_median: walks.speed_m_s.median,
            speed_m_s_p10: walks.speed_m_s.p10,
            forward_m: walks.forward_m.median,
            sideways_m: walks.sideways_m.median,
            power_w_median: walks.power_w.median,
            yaw_deg_median: walks.yaw_deg.median,
            setpoint_speed_max_rad_s: motion.fastest_deg_s(1.0).to_radians(),
            servo_speed_rad_s: robot.servo.top_speed_rad_s(),
            slower_servos_share: self.slower_share(),
            twin_spread_used: has_spread(robot),
            over_draws: self.walks.clone(),
            amplitudes: self.amplitudes.to_vec(),
            safe_amplitudes: self.gait.provenance.safe_amplitudes,
            power: power_balance(robot, motion),
            cost_of_transport_of_electronics: floor(robot, walks.speed_m_s.median),
            front,
        }
    }

    /// Share of the drawn robots whose servos are slower than the gait's fastest setpoint.
    fn slower_share(&self) -> f64 {
        self.walks.slower_servos as f64 / self.walks.draws.max(1) as f64
    }

    /// Warns if the gait is slower than what was asked for, or does not walk forward.
    pub fn warn(&self) {
        let median_m_s = self.walks.speed_m_s.median;
        if let Some(asked_m_s) = self.at_least_m_s.filter(|asked_m_s| median_m_s < *asked_m_s) {
            eprintln!(
                "warning: it walks at {median_m_s:.3} m/s, slower than the {asked_m_s} m/s that were asked \
                 for; search longer (--budget) or lower --min-speed"
            );
        }
        let displacement_m = [self.walks.forward_m.median, self.walks.sideways_m.median];
        if let Some(warning) = direction_warning(displacement_m, TRIAL_S) {
            warn(&warning);
        }
    }

    pub fn print(&self) {
        let Self { robot, gait, walks, motion, .. } = self;
        println!(
            "gait \"{}\": a stride of {:.3} s, found in {} trials, {:.0} s",
            gait.name, motion.period_s, self.trials, self.wall_s
        );
        println!("\nPredicted over {} robots that the search has not seen:", walks.draws);
        println!("                          10 %   median     90 %");
        let row = |name: &str, of: &Quantiles, digits: usize| {
            println!("{name:22} {:8.digits$} {:8.digits$} {:8.digits$}", of.p10, of.median, of.p90);
        };
        row("cost of transport", &walks.cost_of_transport, 3);
        row("speed m/s", &walks.speed_m_s, 3);
        row("forward m in 12 s", &walks.forward_m, 2);
        row("sideways m in 12 s", &walks.sideways_m, 2);
        row("power W", &walks.power_w, 2);
        row("turned deg in 12 s", &walks.yaw_deg, 1);
        row("leaned deg at most", &walks.tilt_deg, 1);
        println!(
            "robots that fell: {}; whose torso, thighs or shins touched the ground: {}",
            walks.fell, walks.dragged
        );

        let (fastest, servo) = (motion.fastest_deg_s(1.0).to_radians(), robot.servo.top_speed_rad_s());
        println!(
            "setpoints move at up to {fastest:.2} rad/s; a servo does {servo:.2}, of which {:.0} % may be asked for",
            100.0 * SPEED_MARGIN
        );
        println!(
            "robots whose servos are slower than that, by make or supply, and lag: {} of {}",
            walks.slower_servos, walks.draws
        );
        println!(
            "servos are at their torque limit for {:.1} % of the time",
            100.0 * walks.strained_share.median
        );

        if self.amplitudes.is_empty() {
            println!(
                "\nInterrupted before it was tried at other amplitudes: the gait declares none as safe."
            );
        } else {
            self.print_amplitudes();
        }

        if let Some(power) = power_balance(robot, motion) {
            print_power(&power);
        }
        println!(
            "The electronics alone cost {:.3} at that speed: no gait is cheaper.",
            floor(robot, walks.speed_m_s.median)
        );
        self.print_doubts();
        println!("\n{}", self.path.display());
        if let Some([least, _]) = gait.provenance.safe_amplitudes {
            println!("Next: cargo run -p host -- upload-gait --amp {least} --gait {}", self.path.display());
        }
    }

    fn print_amplitudes(&self) {
        println!("\namplitude   cost of transport   speed m/s   safe");
        for at in self.amplitudes {
            println!(
                "{:9.1} {:19.3} {:11.3}   {}",
                at.amplitude,
                at.walks.cost_of_transport.median,
                at.walks.speed_m_s.median,
                if at.safe { "yes" } else { "no" }
            );
        }
        match self.gait.provenance.safe_amplitudes {
            Some([least, most]) => println!("the gait declares {least} to {most}"),
            None => println!("the gait declares none: at 1.0 it leaves its bounds, or robots fell"),
        }
    }

    fn print_doubts(&self) {
        if !has_spread(self.robot) {
            println!(
                "\nThe uncertainty of this robot's numbers is unknown (no [twin.spread] in robot.toml): the robots of \
                 the report differ by tolerances alone."
            );
        }
        if self.robot.twin.is_some() {
            println!(
                "\nThese are predictions: the simulation was fitted to walks of up to {} m/s, and this is \
                 {:.1} times that.",
                paper::TOP_SPEED_M_S,
                self.walks.speed_m_s.median / paper::TOP_SPEED_M_S
            );
        } else {
            println!("\nThese are predictions of a robot that was never compared with a trial.");
        }
        println!(
            "On a real robot check first: do the feet slip as expected, does it turn, do servos get warm?"
        );
    }
}

fn print_power(power: &PowerBalance) {
    println!("\nWhere {:.2} W go, on the fitted robot:", power.total_w);
    for (name, watts) in [
        ("electronics", power.electronics_w),
        ("slipping soles", power.slipping_w),
        ("landing feet", power.landing_w),
        ("braking, legs against each other", power.braking_w),
        ("drives", power.drive_w),
        ("unexplained", power.rest_w),
    ] {
        println!("  {name:33} {} W  {} %", fixed(watts, 6, 3), fixed(100.0 * watts / power.total_w, 3, 0));
    }
}

/// A number with so many decimals, right-aligned; what rounds to zero has no sign.
fn fixed(value: f64, width: usize, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let is_zero = text.chars().all(|c| matches!(c, '-' | '0' | '.'));
    format!("{:>width$}", if is_zero { text.trim_start_matches('-') } else { &text })
}

#[cfg(test)]
mod tests {
    use super::fixed;

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        assert_eq!(fixed(-0.4, 3, 0), "  0");
        assert_eq!(fixed(-0.0004, 6, 3), " 0.000");
        assert_eq!(fixed(-0.6, 3, 0), " -1");
        assert_eq!(fixed(28.4, 3, 0), " 28");
    }
}
