//! What `host twin` prints.

use crate::cli::explain::path_text;
use crate::robot::Robot;
use crate::twin::{Both, FitReport, Parameter, Report};
use std::path::Path;

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn both(both: &Both, digits: usize) -> String {
    format!("{:>7.digits$} {:>7.digits$}", both.measured, both.predicted)
}

/// Finite numbers under string keys: serialising cannot fail.
fn json_of(result: &impl serde::Serialize) -> serde_json::Value {
    serde_json::json!(result)
}

/// A validation, for people or for scripts.
pub fn print(report: &Report, json: bool) {
    if json {
        println!("{}", json_of(report));
        return;
    }
    println!("                              speed m/s           power W      cost of transport");
    println!("method       amp. trials measured   twin  measured   twin  measured   twin");
    for condition in &report.conditions {
        println!(
            "{:<12} {:>4.1} {:>5}    {}   {}   {}",
            condition.method,
            condition.amplification,
            condition.trials,
            both(&condition.speed_m_s, 3),
            both(&condition.power_w, 3),
            both(&condition.cost_of_transport, 3),
        );
    }
    println!("");
    for (name, method) in &report.methods {
        println!(
            "{name}{}: speed off by {}, power by {}, cost of transport by {}",
            if method.fitted { " (fitted)" } else { "" },
            percent(method.speed_mare),
            percent(method.power_mare),
            percent(method.cot_mare)
        );
        if let Some(free) = method.free_power_mare {
            println!("  power by work alone, no bound on the efficiency: {}", percent(free));
        }
        println!("  power by the tables' steps, no physics: {}", percent(method.baseline_power_mare));
        println!(
            "  fastest at {}x (twin {}x), cheapest at {}x (twin {}x)",
            method.fastest_amplification.measured,
            method.fastest_amplification.predicted,
            method.cheapest_amplification.measured,
            method.cheapest_amplification.predicted
        );
    }
    let rank = |value: Option<f64>| value.map_or("none".to_owned(), |value| format!("{value:.3}"));
    println!(
        "rank correlation: speed {}, cost of transport {}",
        rank(report.spearman_speed),
        rank(report.spearman_cot)
    );
    for pair in &report.pairs {
        let word = |agrees| if agrees { "agree" } else { "disagree" };
        println!(
            "{} or {} at {}x: robot and twin {} on the faster, {} on the cheaper",
            pair.a,
            pair.b,
            pair.amplification,
            word(pair.faster_agrees),
            word(pair.cheaper_agrees)
        );
    }
    if let Some(own) = &report.repeatability {
        println!(
            "trials of one gait differ by: speed {}, power {}, cost of transport {}",
            percent(own.speed),
            percent(own.power),
            percent(own.cost_of_transport)
        );
    }
    if let Some(half) = &report.half_step {
        println!(
            "half the physics step changes speed by {}, cost of transport by {} in the mean",
            percent(half.speed),
            percent(half.cost_of_transport)
        );
    }
}

/// A fit: what was found, then how near it is.
pub fn print_fit(robot: &Robot, parameters: &[Parameter], path: &Path, report: &Report, json: bool) {
    let Some(found) = FitReport::of(robot, path_text(path), parameters, report.clone()) else { return };
    if json {
        println!("{}", json_of(&found));
        return;
    }
    println!("Score {} after {} sets; wrote {}.", percent(found.score), found.evaluations, path.display());
    for parameter in parameters {
        let spread = found.parameters.get(parameter.name).and_then(|fitted| fitted.spread).unwrap_or(0.0);
        println!("  {:<36} {:>8.4} ± {spread:.4}", parameter.name, parameter.value_of(robot));
    }
    let power = &robot.power;
    println!(
        "  power: {:.3} W + work / {:.3} + heat of holding torque",
        power.electronics_w, power.efficiency
    );
    println!("");
    print(report, false);
}
