//! Writes figures and report of a study whose numbers are made up.
//!
//! `cargo run -p host --example sample_report -- FOLDER`. Nothing was simulated
//! for it: it shows how a report looks, and is what `scripts/check` looks at in
//! a browser.

use host::experiment::materials::{GaitNote, LearnedStride};
use host::experiment::method::Method;
use host::experiment::study::{Claim, LegStudy, Parameter, Study, Venue};
use host::experiment::summary::{Planned, best, conditions};
use host::experiment::trial::{Place, Raw, Trial, mark_reversed};
use host::experiment::{figures, report};
use host::gait::stride::Sample;
use host::learn::curves::{RunCurves, SeedCurve};
use host::learn::td3::curve::CurvePoint;
use host::paper;
use host::robot::{LegScale, Robot};
use host::run_folder;
use miette::IntoDiagnostic as _;
use protocol::JOINT_COUNT;
use std::f64::consts::TAU;
use std::path::PathBuf;

const MASS_KG: f64 = 1.0;
const NOTE: &str = "These numbers are made up: the page shows how a report looks, not what came of a study.";

fn main() -> miette::Result<()> {
    let folder = PathBuf::from(std::env::args_os().nth(1).unwrap_or_else(|| "sample-report".into()));
    std::fs::create_dir_all(&folder).into_diagnostic()?;
    let study = sample();
    let drawn = figures::all(&study);
    figures::write(&folder, &drawn).into_diagnostic()?;
    let page = folder.join("report.html");
    run_folder::write(&page, report::html(&study, &drawn).as_bytes()).into_diagnostic()?;
    println!("{}", page.display());
    Ok(())
}

fn description(robot: &Robot) -> Parameter {
    Parameter { name: "The robot".into(), value: robot.to_toml() }
}

fn sample() -> Study {
    let mut planned = Vec::new();
    let mut trials = Vec::new();
    for leg in paper::LEGS {
        for method in Method::gaits() {
            for amplification in paper::AMPLIFICATIONS {
                let place = Place { method, leg, amplification };
                let beyond = method == Method::Original && amplification > 1.9;
                let not_run = beyond.then(|| "asks hip2 for 51.3 degrees; the servo reaches 45".to_owned());
                if not_run.is_none() {
                    trials.extend((0..3).map(|number| walk(place, number)));
                }
                planned.push(Planned { place, setpoint_speed_max_rad_s: Some(1.1 * amplification), not_run });
            }
        }
    }
    mark_reversed(&mut trials);
    let conditions = conditions(&planned, &trials);
    Study {
        robot: "Ant".into(),
        venue: Venue::Twin,
        legs: paper::LEGS.map(leg_study).to_vec(),
        best: best(&conditions),
        conditions,
        claims: claims(),
        trials,
        descriptions: Robot::ant(LegScale::LONG).iter().map(description).collect(),
        parameters: [("what this is", NOTE), ("trial", "12 s"), ("seed of the perturbations", "0")]
            .map(|(name, value)| Parameter { name: name.into(), value: value.into() })
            .to_vec(),
        skipped: vec![NOTE.into(), "the authors\u{2019} tables: --reference-tables was not given".into()],
        energy: Vec::new(),
        prepare_wall_s: 4_520.0,
        wall_s: 143.2,
    }
}

/// Cost falls with the amplification, and rises again where the robot slips.
fn walk(place: Place, number: u32) -> Trial {
    let Place { method, leg, amplification } = place;
    let rank = method as u8 as f64;
    let jitter = 0.02 * (f64::from(number) - 1.0) * (1.0 + 0.5 * (7.0 * amplification + rank).sin());
    let top_m_s = 0.125 + 0.006 * rank - 0.02 * (1.0 - leg.value());
    let speed_m_s = (top_m_s - 0.04 * (2.1 - amplification).powi(2)).max(0.03) * (1.0 + jitter);
    let power_w = (0.55 + 0.16 * amplification - 0.02 * rank) * (1.0 - jitter / 3.0);
    let fell = method == Method::Psto && leg == LegScale::SHORT && amplification < 1.1 && number == 0;
    let raw = Raw {
        duration_s: paper::TRIAL_S,
        energy_j: power_w * paper::TRIAL_S,
        displacement_m: Some([speed_m_s * paper::TRIAL_S, 0.0]),
        mass_kg: MASS_KG,
        fell,
        ..Raw::default()
    };
    Trial::of(place, number, &raw, "")
}

fn leg_study(leg: LegScale) -> LegStudy {
    let gait = |method: Method| GaitNote {
        method,
        command: format!("host experiment --retrain --method {} --leg {leg} --seed 3", method.name()),
        seed: (method != Method::Searched).then_some(3),
        simulated_s: (method != Method::Searched).then_some(151_000.0),
        period_s: 1.5,
        gait_sha256: "0123456789abcdef".repeat(4),
        prepare_wall_s: (method == Method::Sinusoid).then_some(1_260.0),
        remark: Some("made up".into()),
    };
    LegStudy {
        leg,
        gaits: Method::gaits().map(gait).collect(),
        learning: Some(RunCurves {
            label: format!("{leg}"),
            seeds: (0..3).map(|seed| learned(leg, seed)).collect(),
            without_curve: vec![],
        }),
        stride: Some(stride(leg)),
    }
}

fn learned(leg: LegScale, seed: u64) -> SeedCurve {
    let point = |step: u64| {
        let share = step as f64 / 40.0;
        let wobble = 40.0 * (step as f64 + seed as f64 * 2.0).sin();
        let reward = leg.value() * 1_500.0 * (1.0 - (-4.0 * share).exp()) + wobble;
        CurvePoint {
            env_steps: step * 25_000,
            updates: step * 2_500,
            wall_s: step as f64 * 10.0,
            reward,
            speed_m_s: reward / 9_000.0,
            episode_steps: 1_000.0,
            critic_loss: 0.0,
            actor_loss: 0.0,
            q_mean: 0.0,
        }
    };
    SeedCurve { name: format!("seed-{seed}"), points: (0..=40).map(point).collect() }
}

fn stride(leg: LegScale) -> LearnedStride {
    const ROWS: usize = 90;
    let sample = |row: usize| -> Sample {
        let phase = TAU * row as f64 / ROWS as f64;
        std::array::from_fn(|joint| {
            let shift = joint as f64 * 0.8;
            let fine = 0.05 * (9.0 * phase + shift).sin();
            0.35 * leg.value() * (phase + shift).sin() + 0.15 * (2.0 * phase + shift).cos() + fine
        })
    };
    LearnedStride {
        period_s: 1.5,
        samples: (0..ROWS).map(sample).collect(),
        deviations: vec![[0.07; JOINT_COUNT]; ROWS],
    }
}

fn claims() -> Vec<Claim> {
    let claim =
        |text: &str, holds, evidence: &str| Claim { text: text.into(), holds, evidence: evidence.into() };
    vec![
        claim(
            "At 0.12 m/s on long legs PSTO takes 7 % less power than the original and the sinusoid.",
            Some(true),
            "Made up: 0.741 W beside 0.802 W and 0.837 W.",
        ),
        claim(
            "PSTO can achieve a 15 % lower cost of transport than the others on long legs.",
            Some(false),
            "Made up: 2.1 % lower than the sinusoid; the intervals overlap.",
        ),
        claim(
            "The original cannot be walked at high amplifications.",
            None,
            "Made up: the conditions that it needs were not run.",
        ),
    ]
}
