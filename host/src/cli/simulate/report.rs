//! What the walks came to, for people and for scripts.

use super::{Args, Simulated};
use crate::cli::explain::{path_text, warn};
use crate::gait::fit::speeds::{fastest, lagging_share, peak_speeds};
use crate::gait::gait_file::gait_sha256;
use crate::sim::open_loop::Walk;
use protocol::{FRAME_RATE_HZ, Joint};
use serde_json::{Value, json};

/// Mean and spread of one figure over the starts.
struct Figure {
    mean: f64,
    /// Standard deviation of a start; 0 for a single one.
    spread: f64,
    least: f64,
    most: f64,
}

impl Figure {
    fn of(walks: &[Walk], value: impl Fn(&Walk) -> f64) -> Self {
        let values: Vec<f64> = walks.iter().map(value).collect();
        let count = values.len().max(1) as f64;
        let mean = values.iter().sum::<f64>() / count;
        let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        let extreme = |pick: fn(f64, f64) -> f64| values.iter().copied().reduce(pick).unwrap_or(mean);
        Self {
            mean,
            spread: (square / (count - 1.0).max(1.0)).sqrt(),
            least: extreme(f64::min),
            most: extreme(f64::max),
        }
    }

    /// Infinite ones, of a robot that stood still, are null.
    fn to_json(&self) -> Value {
        json!({ "mean": self.mean, "spread": self.spread, "least": self.least, "most": self.most })
    }
}

type Row = (&'static str, &'static str, &'static str, fn(&Walk) -> f64);

/// Words, unit, key and value of each line.
const ROWS: [Row; 7] = [
    ("speed", "m/s", "speed_m_s", |walk| walk.speed_m_s),
    ("mean power", "W", "mean_power_w", |walk| walk.mean_power_w),
    ("cost of transport", "", "cost_of_transport", |walk| walk.cost_of_transport),
    ("distance", "m", "distance_m", |walk| walk.distance_m),
    ("forward", "m", "forward_m", |walk| walk.displacement_m[0]),
    ("turned", "degrees", "turned_deg", |walk| walk.turned_rad.to_degrees()),
    ("dragged", "% of time", "dragged_share", |walk| walk.dragged_share),
];

/// Prints the table, or with `--json` one object; warnings go to standard error.
pub fn print(args: &Args, simulated: &Simulated) {
    let warnings = warnings(simulated);
    for warning in &warnings {
        warn(warning);
    }
    if args.json {
        println!("{:#}", to_json(args, simulated, &warnings));
    } else {
        print_table(args, simulated);
    }
}

/// What keeps the simulated robot, and a real one, from walking as the gait says.
fn warnings(simulated: &Simulated) -> Vec<String> {
    let Simulated { material, amplitude, .. } = simulated;
    let mut warnings = material.doubts(*amplitude);
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
            "{} is to turn at up to {deg_s:.0} degrees/s; its servo does {servo_deg_s:.0}: it lags in {:.0} % \
             of the stride, and so may others",
            joint.name(),
            100.0 * lagging_share
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
             no other joint has a wider one",
            joint.name(),
            peak.jump_deg,
            simulated.amplitude_typed,
            frames(peak.jump_deg)
        ));
    }
    warnings
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
        material.robot.geometry.leg_scale,
        material.robot.mass_kg(),
    );
    println!("{} starts of {} s, seed {}\n", starts.count, args.duration_s, starts.seed);
    println!("                         mean   spread    least     most");
    for (words, unit, key, value) in ROWS {
        let scale = if key == "dragged_share" { 100.0 } else { 1.0 };
        let figure = Figure::of(walks, |walk| scale * value(walk));
        let line =
            [figure.mean, figure.spread, figure.least, figure.most].map(|v| format!("{v:9.3}")).concat();
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

fn to_json(args: &Args, simulated: &Simulated, warnings: &[String]) -> Value {
    let Simulated { material, amplitude, starts, walks, .. } = simulated;
    let rows: Vec<Value> = (0..starts.count)
        .zip(walks)
        .map(|(number, walk)| {
            let start = starts.start(number);
            let mut row = json!({
                "start": number,
                "start_yaw_deg": start.yaw_rad.to_degrees(),
                "start_friction_share": start.friction_share,
                "sideways_m": walk.displacement_m[1],
                "energy_j": walk.energy_j,
                "max_tilt_deg": walk.max_tilt_rad.to_degrees(),
                "fell": walk.fell,
            });
            for (_, _, key, value) in ROWS {
                row[key] = value(walk).into();
            }
            row
        })
        .collect();
    let mut result = json!({
        "gait": path_text(&material.path),
        "gait_name": material.playable.encoded().name().as_str(),
        "gait_sha256": gait_sha256(&material.bytes),
        "gait_source": material.source,
        "period_s": material.period_s(),
        "amplitude": simulated.amplitude_typed,
        "duration_s": args.duration_s,
        "starts": starts.count,
        "seed": starts.seed,
        "robot": material.robot.name,
        "leg_scale": material.robot.geometry.leg_scale,
        "mass_kg": material.robot.mass_kg(),
        "clipped_share": material.clipped_share(*amplitude),
        "fell": fell(walks),
        "walks": rows,
        "warnings": warnings,
    });
    for (_, _, key, value) in ROWS {
        result[key] = Figure::of(walks, value).to_json();
    }
    result
}
