//! The result of the walks, for people and for scripts.
//!
//! Holds the words, the table and the warnings. Does not depend on how a gait is
//! played.

use super::result::{Figures, OF_WALK, SimulateResult, Spread, StartResult, finite};
use super::{Args, Simulated};
use crate::cli::explain::{path_text, warn};
use crate::gait::fit::speeds::{fastest, lagging_share, peak_speeds};
use crate::gait::gait_file::gait_sha256;
use crate::sim::open_loop::{Walk, direction_warning};
use protocol::{FRAME_RATE_HZ, Joint};

/// Infinite values, of a robot that stood still, stay infinite.
fn spread(walks: &[Walk], value: fn(&Walk) -> f64) -> Spread<f64> {
    let values: Vec<f64> = walks.iter().map(value).collect();
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    let extreme = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick).unwrap_or(mean);
    Spread {
        mean,
        spread: (square / (count - 1.0).max(1.0)).sqrt(),
        least: extreme(f64::min),
        most: extreme(f64::max),
    }
}

/// Prints the table, or with `--json` one object; warnings go to standard error.
pub fn print(args: &Args, simulated: &Simulated) -> serde_json::Result<()> {
    let mut warnings = warnings(simulated);
    warnings.extend(direction_warning(mean_displacement_m(&simulated.walks), args.duration_s));
    for warning in &warnings {
        warn(warning);
    }
    if args.json {
        // Those of the robot were printed before the walks.
        let of_robot = simulated.material.robot.warnings().into_iter().map(|warning| warning.to_string());
        let warnings = of_robot.chain(warnings).collect();
        println!("{:#}", serde_json::to_value(result(args, simulated, warnings))?);
    } else {
        print_table(args, simulated);
    }
    Ok(())
}

/// Displacement along x and y, mean over the starts.
fn mean_displacement_m(walks: &[Walk]) -> [f64; 2] {
    [0, 1].map(|axis| {
        walks.iter().map(|walk| walk.displacement_m[axis]).sum::<f64>() / walks.len().max(1) as f64
    })
}

/// Reasons why a robot, simulated or real, cannot follow the gait.
fn warnings(simulated: &Simulated) -> Vec<String> {
    let Simulated { material, amplitude, .. } = simulated;
    let mut warnings = material.doubts(*amplitude);
    let asked_deg = material.playable.asked_deg(amplitude.value(), true);
    if let Err(beyond) = material.robot.check_range(&asked_deg) {
        warnings.push(format!("{beyond}; it is held at its end"));
    }
    let clipped_share = material.clipped_share(*amplitude);
    if clipped_share > 0.0 {
        warnings.push(format!(
            "at {}x joints are held at their limits during {:.1} % of each stride",
            simulated.amplitude_typed,
            100.0 * clipped_share
        ));
    }
    let servo_deg_s = material.robot.servo.top_speed_rad_s().to_degrees();
    let peaks = peak_speeds(&material.playable, *amplitude);
    let (joint, deg_s) = fastest(&peaks);
    if deg_s > servo_deg_s {
        let lagging_share = lagging_share(&material.playable, joint, *amplitude, servo_deg_s);
        warnings.push(format!(
            "{} would have to turn at up to {deg_s:.0} degrees/s; its servo does {servo_deg_s:.0}: it lags for {} \
             of the stride, and other joints may lag too",
            joint.name(),
            share_text(lagging_share)
        ));
    }
    let widest = Joint::ALL.into_iter().zip(peaks).max_by(|(_, a), (_, b)| {
        let (a, b) = (a.jump_deg.abs(), b.jump_deg.abs());
        a.total_cmp(&b)
    });
    let frames = |jump_deg: f64| jump_deg.abs() * f64::from(FRAME_RATE_HZ) / servo_deg_s;
    if let Some((joint, peak)) = widest.filter(|(_, peak)| frames(peak.jump_deg) > 1.0) {
        warnings.push(format!(
            "{}: strides meet with a step of {:.1} degrees at {}x, for which its servo takes {:.1} frames; \
             it is the largest of all joints",
            joint.name(),
            peak.jump_deg,
            simulated.amplitude_typed,
            frames(peak.jump_deg)
        ));
    }
    let limited_share = simulated.walks.iter().map(|walk| walk.supply_limited_share).fold(0.0, f64::max);
    if limited_share > 0.0 {
        let robot = &material.robot;
        warnings.push(format!(
            "for {} of the time the servos ask for more than the {:.1} W that a supply of {} V behind {} ohm gives at \
             most (V^2 / 4R); power and cost of transport count what it gives, but a real robot would be slower: \
             correct [supply], or take a stronger one",
            share_text(limited_share),
            robot.supply.most_power_w(),
            robot.supply.nominal_v,
            robot.supply.resistance_ohm
        ));
    }
    warnings
}

/// A share that is not zero, in percent.
fn share_text(share: f64) -> String {
    let percent = 100.0 * share;
    if percent < 1.0 { "less than 1 %".to_owned() } else { format!("{percent:.0} %") }
}

fn fell(walks: &[Walk]) -> usize {
    walks.iter().filter(|walk| walk.fell).count()
}

fn print_table(args: &Args, simulated: &Simulated) {
    let Simulated { material, starts, walks, .. } = simulated;
    println!(
        "gait \"{}\" at {}x, a stride in {:.3} s, on {} (leg {}, {:.3} kg)",
        material.playable.encoded().name().as_str(),
        simulated.amplitude_typed,
        material.period_s(),
        material.robot.name,
        material.robot.geometry.leg_scale.value(),
        material.robot.mass_kg(),
    );
    println!("{} starts of {} s, seed {}\n", starts.count, args.duration_s, starts.seed);
    println!("                         mean   spread    least     most");
    let Figures {
        speed_m_s,
        mean_power_w,
        cost_of_transport,
        distance_m,
        forward_m,
        turned_deg,
        dragged_share,
    } = OF_WALK.map(|value| spread(walks, value));
    for (words, unit, scale, of) in [
        ("speed", "m/s", 1.0, speed_m_s),
        ("mean power", "W", 1.0, mean_power_w),
        ("cost of transport", "", 1.0, cost_of_transport),
        ("distance", "m", 1.0, distance_m),
        ("forward", "m", 1.0, forward_m),
        ("turned", "degrees", 1.0, turned_deg),
        ("body on the ground", "% of time", 100.0, dragged_share),
    ] {
        let line =
            [of.mean, of.spread, of.least, of.most].map(|value| format!("{:9.3}", scale * value)).concat();
        println!("{}", format!("{words:20}{line}  {unit}").trim_end());
    }
    match fell(walks) {
        0 => println!("\nit fell from none of {} starts", walks.len()),
        fell => println!(
            "\nit FELL from {fell} of {} starts; their walks count in the figures above",
            walks.len()
        ),
    }
}

fn result(args: &Args, simulated: &Simulated, warnings: Vec<String>) -> SimulateResult {
    let Simulated { material, amplitude, starts, walks, .. } = simulated;
    let row = |(number, walk): (u32, &Walk)| {
        let start = starts.start(number);
        StartResult {
            start: number,
            start_yaw_deg: start.yaw_rad.to_degrees(),
            start_friction_share: start.friction_share,
            sideways_m: walk.displacement_m[1],
            energy_j: walk.energy_j,
            max_tilt_deg: walk.max_tilt_rad.to_degrees(),
            fell: walk.fell,
            figures: OF_WALK.map(|value| finite(value(walk))),
        }
    };
    let of_walks = |value| {
        let Spread { mean, spread, least, most } = spread(walks, value);
        Spread { mean: finite(mean), spread: finite(spread), least: finite(least), most: finite(most) }
    };
    SimulateResult {
        gait: path_text(&material.path),
        gait_name: material.playable.encoded().name().as_str().to_owned(),
        gait_sha256: gait_sha256(&material.bytes),
        gait_source: material.source.to_string(),
        period_s: material.period_s(),
        amplitude: simulated.amplitude_typed,
        duration_s: args.duration_s,
        starts: starts.count,
        seed: starts.seed,
        robot: material.robot.name.clone(),
        leg_scale: material.robot.geometry.leg_scale,
        mass_kg: material.robot.mass_kg(),
        clipped_share: material.clipped_share(*amplitude),
        fell: fell(walks),
        walks: (0..starts.count).zip(walks).map(row).collect(),
        warnings,
        figures: OF_WALK.map(of_walks),
    }
}

#[cfg(test)]
mod tests {
    use super::share_text;

    #[test]
    fn a_share_that_is_not_zero_is_never_shown_as_zero() {
        assert_eq!(share_text(0.002), "less than 1 %");
        assert_eq!(share_text(0.124), "12 %");
    }
}
