//! The results of a study: files, words and JSON.
//!
//! Holds the lists of parameters and of what is missing, and the printed table.
//! Does not depend on how trials are walked.

use super::ExperimentError;
use super::request::{Request, Retraining};
use crate::cli::explain::path_text;
use crate::experiment::ledger::Identity;
use crate::experiment::materials::Materials;
use crate::experiment::method::{Method, OWN_STROKE};
use crate::experiment::report::words::listed;
use crate::experiment::results::StudySummary;
use crate::experiment::study::{LegStudy, Parameter, Study, Venue};
use crate::experiment::summary::{self, Condition, Mean, Planned};
use crate::experiment::trial::Trial;
use crate::experiment::twin_trials::PERTURBATION;
use crate::experiment::{claims, energy_balance, figures, report};
use crate::learn::preset::Preset;
use crate::learn::run_config::RunConfig;
use crate::run_folder;
use crate::search::optimise::tolerances::Tolerances;
use crate::search::sinusoid::wave::{LEAST_PERIOD_S, MOST_PERIOD_S};
use std::path::Path;
use std::time::Instant;

/// What scripts read; `--json` prints the same.
const RESULTS: &str = "results.json";
/// What people look at.
const REPORT: &str = "report.html";

/// All that was made and walked.
pub struct Parts {
    pub identity: Identity,
    pub legs: Vec<Materials>,
    pub planned: Vec<Planned>,
    pub trials: Vec<Trial>,
    pub prepare_wall_s: f64,
    pub began: Instant,
}

/// Writes everything, and prints the best of each method and the claims.
pub fn finish(request: &Request, folder: &Path, parts: Parts) -> Result<(), ExperimentError> {
    let began = parts.began;
    let mut study = study(request, parts);
    let drawn = figures::all(&study);
    figures::write(folder, &drawn)?;
    study.wall_s = began.elapsed().as_secs_f64();
    run_folder::write(&folder.join(REPORT), report::html(&study, &drawn).as_bytes())?;
    let (out, report) = (path_text(folder), path_text(&folder.join(REPORT)));
    let summary = StudySummary::of(&study, report::skipped(&study, &drawn), out, report);
    let json = serde_json::to_value(summary).map_err(ExperimentError::Json)?;
    run_folder::write(&folder.join(RESULTS), format!("{json:#}\n").as_bytes())?;
    if request.json {
        println!("{json:#}");
    } else {
        print(&study, folder);
    }
    Ok(())
}

fn study(request: &Request, parts: Parts) -> Study {
    let Parts { identity, legs, planned, trials, prepare_wall_s, .. } = parts;
    let mut parameters = parameters(&identity, &legs);
    if let Some(Retraining { effort, .. }) = request.retraining {
        parameters.push(Parameter { name: "effort of retraining".into(), value: effort.to_string() });
    }
    let descriptions = descriptions(&identity, &legs);
    let conditions = summary::conditions(&planned, &trials);
    let best = summary::best(&conditions);
    let energy = if identity.venue == Venue::Robot { Vec::new() } else { energy_balance::of(&legs, &best) };
    let robot = legs.first().map(|materials| materials.robot.name.clone()).unwrap_or_default();
    let of_leg = |materials: Materials| LegStudy {
        leg: materials.robot.geometry.leg_scale,
        gaits: materials.gaits.into_iter().map(|material| material.note).collect(),
        learning: materials.learning,
        stride: materials.stride,
    };
    let legs: Vec<LegStudy> = legs.into_iter().map(of_leg).collect();
    let claims = claims::judge(&conditions, &best, &legs);
    let mut skipped = Vec::new();
    if identity.venue == Venue::Twin && request.reference.is_none() {
        skipped.push("the authors' own tables: add them with --reference-tables".to_owned());
    }
    let runnable = planned.iter().filter(|planned| planned.not_run.is_none()).count();
    let left_out = (runnable * identity.plan.trials as usize).saturating_sub(trials.len());
    if left_out > 0 {
        skipped.push(format!("trials that were skipped, {left_out}: run the same command to walk them"));
    }
    let unseen = trials.iter().filter(|trial| trial.fall_unseen && trial.mark.is_none()).count();
    if unseen > 0 {
        skipped.push(format!(
            "falls in {unseen} trials: the tracker records no tilt, and nobody was at the terminal to ask"
        ));
    }
    let venue = identity.venue;
    Study {
        robot,
        descriptions,
        venue,
        legs,
        conditions,
        best,
        energy,
        claims,
        trials,
        parameters,
        skipped,
        prepare_wall_s,
        wall_s: 0.0,
    }
}

/// Robots and presets, with all their numbers.
fn descriptions(identity: &Identity, legs: &[Materials]) -> Vec<Parameter> {
    let robots = legs.iter().map(|materials| Parameter {
        name: format!("The robot with legs of {}", materials.robot.geometry.leg_scale),
        value: materials.robot.to_toml(),
    });
    // Each preset once, with all methods that it decides, of which one at least takes part.
    let mut presets: Vec<Preset> = Vec::new();
    for preset in
        Method::all().filter(|method| identity.plan.methods.contains(method)).filter_map(Method::preset)
    {
        if !presets.contains(&preset) {
            presets.push(preset);
        }
    }
    let presets = presets.into_iter().filter_map(|preset| {
        let with_it = Method::all().filter(|method| method.preset() == Some(preset));
        let labels: Vec<String> = with_it.map(|method| method.label().to_owned()).collect();
        let value = RunConfig::preset(preset).ok()?.to_toml().ok()?;
        Some(Parameter { name: format!("Learning and task of {}", listed(&labels)), value })
    });
    robots.chain(presets).collect()
}

/// Everything that was chosen.
fn parameters(identity: &Identity, legs: &[Materials]) -> Vec<Parameter> {
    let plan = &identity.plan;
    let mut parameters = Vec::new();
    let mut add = |name: &str, value: String| parameters.push(Parameter { name: name.into(), value });
    let list = |values: &[f64]| values.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
    add("amplifications", list(&plan.amplifications));
    add("amplification at which each gait was found", OWN_STROKE.to_string());
    add("trials of a condition", plan.trials.to_string());
    add("length of a trial", format!("{} s, after a slow entry", plan.duration_s));
    add("seed of starts", plan.seed.to_string());
    for materials in legs {
        let robot = &materials.robot;
        add(
            &format!("robot with legs of {}", robot.geometry.leg_scale),
            format!(
                "{}, {:.3} kg, {:.2} rad/s without load",
                robot.name,
                robot.mass_kg(),
                robot.servo.top_speed_rad_s()
            ),
        );
    }
    match identity.venue {
        Venue::Twin if plan.robots_differ => {
            let Tolerances { robot, stiffness_share, damping_share, neutral_deg } = Tolerances::default();
            add(
                "trials differ by robot",
                format!(
                    "{} standard deviations of the fit, friction {} %, mass {} %, supply {} %, latency up to {} ms, \
                     stiffness {} %, damping {} %, neutrals {neutral_deg} degrees, and start",
                    robot.twin_spread,
                    100.0 * robot.friction_share,
                    100.0 * robot.mass_share,
                    100.0 * robot.supply_share,
                    1000.0 * robot.latency_s,
                    100.0 * stiffness_share,
                    100.0 * damping_share
                ),
            );
        }
        Venue::Twin => add(
            "trials differ by start",
            format!(
                "heading {} rad, joints {} rad, friction {} % either way, dropped from up to {} mm",
                PERTURBATION.yaw_rad,
                PERTURBATION.joint_rad,
                100.0 * PERTURBATION.friction_share,
                1000.0 * PERTURBATION.height_m
            ),
        ),
        Venue::VirtualRobot => {
            add("trials differ by", "the virtual robot's own seed: start, noise of its sensor".into())
        }
        Venue::Robot => {
            add("trials differ by", "how the robot stood on its mark, its battery and its floor".into());
            add(
                "mass",
                plan.mass_kg.map_or("as described below".into(), |mass_kg| format!("{mass_kg} kg, weighed")),
            );
        }
    }
    if plan.methods.contains(&Method::Sinusoid) {
        add(
            "where the sinusoid is searched",
            format!(
                "strides of {LEAST_PERIOD_S} to {MOST_PERIOD_S} s; angles and their speed as the task below limits \
                 them"
            ),
        );
    }
    if let Some(sha256) = &identity.reference {
        add("authors' tables, SHA-256", sha256.clone());
    }
    parameters
}

fn print(study: &Study, folder: &Path) {
    println!("                            best cost of transport    paper      highest speed, m/s    paper");
    for best in &study.best {
        let paper = |value: Option<f64>| value.map_or("     ".to_owned(), |value| format!("{value:.3}"));
        println!(
            "{:>6} {:18} {}   {}   {}   {}",
            best.leg,
            best.method.label(),
            shown(best.cost_of_transport, best.cost_amplification),
            paper(best.paper_cost_of_transport),
            shown(best.speed_m_s, best.speed_amplification),
            paper(best.paper_speed_m_s),
        );
    }
    println!("\u{b1}: half of the 95 % interval over trials; x: the amplification\n");
    for claim in &study.claims {
        let verdict = match claim.holds {
            Some(true) => "holds",
            Some(false) => "fails",
            None => continue,
        };
        println!("{verdict}  {}\n       {}", claim.text, claim.evidence);
    }
    let not_judged = study.claims.iter().filter(|claim| claim.holds.is_none()).count();
    println!(
        "{not_judged} of the paper's {} claims not judged: their conditions were not run",
        study.claims.len()
    );
    let unclean = |of: &dyn Fn(&Condition) -> bool| study.conditions.iter().filter(|c| of(c)).count();
    let (not_run, marked) = (unclean(&|c| c.not_run.is_some()), unclean(&|c| !c.marks.is_empty()));
    let count = |n: usize, what: &str| format!("{n} {what}{}", if n == 1 { "" } else { "s" });
    println!(
        "\n{} in {}; {not_run} of them not run, {marked} with trials that do not count: the report says why",
        count(study.trials.len(), "trial"),
        count(study.conditions.len(), "condition")
    );
    for skipped in &study.skipped {
        println!("skipped: {skipped}");
    }
    println!("{}", folder.join(REPORT).display());
}

fn shown(mean: Option<Mean>, amplification: Option<f64>) -> String {
    let (Some(Mean { mean, ci95 }), Some(amplification)) = (mean, amplification) else {
        return format!("{:>23}", "not run");
    };
    let ci95 = ci95.map_or("      ".to_owned(), |ci95| format!("\u{b1}{ci95:.3}"));
    format!("{mean:7.3} {ci95} at {amplification:?}x ")
}
