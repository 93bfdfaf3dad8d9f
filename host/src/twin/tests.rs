//! Synthetic robots, tables and trials: what is planted is found, what cannot be is refused.

use super::*;
use crate::robot::{LegScale, Power, Robot};
use core::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

const HEADER: &str = "method,amplification,sample,hip1,hip2,hip3,hip4,ank1,ank2,ank3,ank4\n";
const TRIALS: &str = "leg_length,method,amplification,power_w,speed_m_s,cost_of_transport,duration_s\n";
const ROWS: usize = 12;

fn ant() -> Robot {
    let mut robot = Robot::ant(LegScale::LONG).expect("the Ant");
    parameters::record(&mut robot).sample_s = 0.12;
    robot
}

/// A trot in ticks, a row a sample.
fn rows(method: &str, amplification: f64) -> String {
    let mut text = String::new();
    for sample in 0..ROWS {
        let joint = |j: usize| {
            let phase = TAU * sample as f64 / ROWS as f64 + PI * (j % 2) as f64;
            let swing = if j % 4 < 2 { 45.0 } else { -45.0 };
            330.0 + amplification * if j < 4 { swing * phase.sin() } else { 30.0 * phase.cos() }
        };
        let ticks: Vec<String> = (0..8).map(|j| format!("{:.0}", joint(j))).collect();
        let _ = writeln!(text, "{method},{amplification},{sample},{}", ticks.join(","));
    }
    text
}

struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, text).expect("written");
        path
    }

    /// Tables of a trot at four strokes.
    fn tables(&self) -> Tables {
        let text: String = STROKES.iter().map(|stroke| rows("trot", *stroke)).collect();
        Tables::read(&self.write("tables.csv", &format!("{HEADER}{text}"))).expect("tables")
    }

    fn trials(&self, text: &str) -> Result<Trials, TwinError> {
        Trials::read(&self.write("trials.csv", &format!("{TRIALS}{text}")), LegScale::LONG)
    }

    /// What a robot would have done with [`Self::tables`], in short trials.
    fn walked_by(&self, robot: &Robot) -> Trials {
        let tables = self.tables();
        let mut text = String::new();
        for stroke in STROKES {
            let angles = tables.angles_rad(&Gait::new("trot", stroke), robot).expect("a table");
            let walk = predict(robot, 0.12, &angles, 3.0);
            let cost = walk.power_w / (10.0 * walk.speed_m_s);
            let _ = writeln!(text, "1.0,trot,{stroke},{},{},{cost},3", walk.power_w, walk.speed_m_s);
        }
        self.trials(&text).expect("trials")
    }
}

const STROKES: [f64; 4] = [0.7, 0.9, 1.1, 1.3];

#[test]
fn a_planted_friction_is_found_again_and_does_not_depend_on_the_number_of_cores() {
    let desk = Desk::new();
    let mut planted = ant();
    planted.ground.friction = 0.6;
    planted.power = Power { electronics_w: 0.35, efficiency: 0.8, ..planted.power };
    let trials = desk.walked_by(&planted);
    let mut start = ant();
    start.ground.friction = 0.4;
    let parameters = Parameter::choose(&["ground.friction".to_owned()]).expect("a parameter");
    let budget = Budget { seed: 3, evaluations: 100, first_step: 0.1, ..Budget::default() };

    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| fit(&start, &desk.tables(), &trials, &parameters, &budget, &mut |_| true))
            .expect("a fit")
    };
    let found = on(1);

    let record = found.robot.twin.clone().expect("a record");
    assert!((found.robot.ground.friction - 0.6).abs() < 0.03, "{}", found.robot.ground.friction);
    assert!((found.robot.power.efficiency - 0.8).abs() < 0.05, "{:?}", found.robot.power);
    assert!(record.score < 0.03, "{record:?}");
    assert!(record.spread.contains_key("ground.friction"), "{record:?}");
    assert_eq!(found, on(2));
}

#[test]
fn a_search_anywhere_does_not_depend_on_what_the_description_says() {
    let desk = Desk::new();
    let mut planted = ant();
    planted.ground.friction = 0.55;
    let trials = desk.walked_by(&planted);
    let parameters = Parameter::choose(&["ground.friction".to_owned()]).expect("a parameter");
    let budget = Budget { seed: 5, evaluations: 48, ..Budget::default() };

    let from = |friction: f64| {
        let mut start = ant();
        start.ground.friction = friction;
        fit(&start, &desk.tables(), &trials, &parameters, &budget, &mut |_| true).expect("a fit")
    };
    let found = from(0.31);

    assert_eq!(found, from(0.89));
    assert!((found.robot.ground.friction - 0.55).abs() < 0.03, "{}", found.robot.ground.friction);
}

#[test]
fn a_search_that_is_stopped_keeps_the_best_so_far() {
    let desk = Desk::new();
    let trials = desk.walked_by(&ant());
    let parameters = Parameter::choose(&["ground.friction".to_owned()]).expect("a parameter");
    let budget = Budget { evaluations: 10_000, ..Budget::default() };

    let found = fit(&ant(), &desk.tables(), &trials, &parameters, &budget, &mut |_| false).expect("a fit");

    assert!(found.stopped);
    assert!(found.robot.twin.is_some_and(|twin| twin.score < 0.5 && twin.evaluations < 100));
}

#[test]
fn a_twin_of_itself_is_right_about_everything() {
    let desk = Desk::new();
    let robot = ant();
    let trials = desk.walked_by(&robot);

    let report = validate(&robot, &desk.tables(), &trials, &Options::default()).expect("a report");

    let method = &report.methods["trot"];
    for error in [method.speed_mare, method.power_mare, method.cot_mare] {
        assert!(error < 1e-6, "{method:?}");
    }
    assert!((report.weight_n - 10.0).abs() < 1e-9);
    assert_eq!(report.spearman_speed, Some(1.0));
    assert_eq!(method.fastest_amplification.measured, method.fastest_amplification.predicted);
    assert_eq!(report.repeatability, None);
    assert!(report.pairs.is_empty());
}

#[test]
fn what_was_measured_is_the_mean_of_the_trials_and_repeats_itself_so_well() {
    let desk = Desk::new();

    let trials = desk.trials("1,trot,1,0.6,0.05,1.2,8\n1.0,trot,1.0,0.8,0.05,1.6,12\n").expect("trials");

    let measured = &trials.measured[&Gait::new("trot", 1.0)];
    assert_eq!(measured.trials.len(), 2);
    assert!((measured.mean()[1] - 0.7).abs() < 1e-12);
    assert_eq!(measured.duration_s, Some(10.0));
    let report = validate(&ant(), &tables_of(&desk, "trot"), &trials, &Options::default()).expect("a report");
    let own = report.repeatability.expect("two trials");
    assert!((own.power - (2.0 * (0.1_f64 / 0.7).powi(2)).sqrt()).abs() < 1e-9, "{own:?}");
    assert_eq!(own.speed, 0.0);
}

fn tables_of(desk: &Desk, method: &str) -> Tables {
    Tables::read(&desk.write("tables.csv", &format!("{HEADER}{}", rows(method, 1.0)))).expect("tables")
}

#[test]
fn two_methods_at_one_amplification_are_a_pair() {
    let desk = Desk::new();
    let text = format!("{HEADER}{}{}", rows("slow", 0.5), rows("slow", 1.0)) + &rows("wide", 1.0);
    let tables = Tables::read(&desk.write("tables.csv", &text)).expect("tables");
    let trials = desk
        .trials("1,slow,0.5,0.5,0.03,1.7,4\n1,slow,1,0.6,0.06,1,4\n1,wide,1,0.7,0.05,1.4,4\n")
        .expect("trials");

    let report = validate(&ant(), &tables, &trials, &Options::default()).expect("a report");

    let [pair] = &report.pairs[..] else { panic!("{:?}", report.pairs) };
    assert_eq!((pair.a.as_str(), pair.b.as_str(), pair.amplification), ("slow", "wide", 1.0));
    assert_eq!(report.conditions.len(), 3);
}

#[test]
fn knees_go_by_either_name_and_a_tick_is_six_tenths_of_a_degree() {
    let desk = Desk::new();
    let text = format!("{HEADER}g,1,0,330,340,330,330,330,330,330,320\n");
    let by_paper = Tables::read(&desk.write("a.csv", &text)).expect("tables");
    let by_us = Tables::read(&desk.write("b.csv", &text.replace("ank", "knee"))).expect("tables");

    let angles = by_us.angles_rad(&Gait::new("g", 1.0), &ant()).expect("a table");

    assert_eq!(by_paper, by_us);
    assert!((angles[0][1].to_degrees() - 6.0).abs() < 1e-9);
    assert!((angles[0][7].to_degrees() + 6.0).abs() < 1e-9);
}

#[track_caller]
fn says(error: &TwinError, parts: &[&str]) {
    let text = error.to_string();
    for part in parts {
        assert!(text.contains(part), "{text:?} lacks {part:?}");
    }
}

#[test]
fn trials_that_cannot_be_are_refused_by_line_and_value() {
    let desk = Desk::new();

    says(&desk.trials("1,trot,1,0.6,0,1.2,8\n").expect_err("zero speed"), &["line 2", "speed_m_s is 0"]);
    says(&desk.trials("1,trot,1,0.6,fast,1.2,8\n").expect_err("no number"), &["line 2", "fast"]);
    says(&desk.trials("1,trot,1,0.6,nan,1.2,8\n").expect_err("no number"), &["line 2", "NaN"]);
    says(&desk.trials("0.6,trot,1,0.6,0.05,1.2,8\n").expect_err("other leg"), &["0.6", "--leg"]);
    says(&desk.trials("").expect_err("nothing"), &["none at all"]);
    let short = desk.write("short.csv", "leg_length,method,amplification,power_w\n1,trot,1,0.6\n");
    says(&Trials::read(&short, LegScale::LONG).expect_err("no speed"), &["speed_m_s", "power_w"]);
    let none = Path::new("none.csv");
    says(&Trials::read(none, LegScale::LONG).expect_err("no file"), &["none.csv"]);
}

#[test]
fn a_gait_without_a_table_and_a_method_without_a_trial_are_named() {
    let desk = Desk::new();
    let trials = desk.trials("1,gallop,1,0.6,0.05,1.2,8\n").expect("trials");

    let error = validate(&ant(), &desk.tables(), &trials, &Options::default()).expect_err("no table");
    says(&error, &["gallop 1x", "trot 0.7x"]);
    let error = trials.of(&["trot".to_owned()]).expect_err("no trial");
    says(&error, &["trot", "gallop"]);
}

#[test]
fn a_table_with_a_hole_or_a_tick_beyond_the_counter_is_refused() {
    let desk = Desk::new();
    let row = |sample: usize, tick: i32| format!("g,1,{sample},{tick},330,330,330,330,330,330,330\n");
    let read = |text: String| Tables::read(&desk.write("t.csv", &format!("{HEADER}{text}")));

    says(&read(row(0, 330) + &row(2, 330)).expect_err("a hole"), &["line 3", "sample 2", "next"]);
    says(&read(row(0, 5000)).expect_err("no tick"), &["line 2", "5000", "4095"]);
}

#[test]
fn a_robot_that_was_never_fitted_needs_a_sample_time() {
    let desk = Desk::new();
    let trials = desk.walked_by(&ant());
    let mut robot = ant();
    robot.twin = None;

    let error = validate(&robot, &desk.tables(), &trials, &Options::default()).expect_err("unknown");

    says(&error, &["--sample-time"]);
    assert!(
        validate(&robot, &desk.tables(), &trials, &Options { sample_s: Some(0.12), ..Options::default() })
            .is_ok()
    );
}

#[test]
fn ranks_lines_and_errors_are_what_the_books_say() {
    assert_eq!(spearman(&[1.0, 2.0, 3.0], &[10.0, 20.0, 15.0]), Some(0.5));
    assert_eq!(spearman(&[1.0, 2.0, 3.0], &[3.0, 2.0, 1.0]), Some(-1.0));
    // Ties share a rank: 1, 2.5, 2.5, 4 against 1, 2, 3, 4.
    let tied = spearman(&[1.0, 2.0, 2.0, 4.0], &[1.0, 2.0, 3.0, 4.0]).expect("ranks");
    assert!((tied - 4.5 / (4.5_f64 * 5.0).sqrt()).abs() < 1e-12);
    assert_eq!(spearman(&[1.0, 1.0], &[1.0, 2.0]), None);
    let line = line_to(&[1.0, 2.0, 4.0], &[0.7, 0.9, 1.3]);
    assert!((line.constant_w - 0.5).abs() < 1e-9 && (line.slope_w - 0.2).abs() < 1e-9, "{line:?}");
    assert!((mean_relative_error(&[1.1, 1.8], &[1.0, 2.0]) - 0.1).abs() < 1e-12);
}

#[test]
fn the_power_model_finds_what_was_planted_and_never_makes_work_from_nothing() {
    let trial = |mechanical_w: f64, holding_w: f64| Prediction {
        speed_m_s: 0.1,
        mechanical_w,
        holding_w,
        power_w: 0.0,
        fell: false,
    };
    let trials = [trial(0.1, 0.2), trial(0.3, 0.1), trial(0.5, 0.3)];
    let servo = ant().power;

    let measured: Vec<f64> = trials.iter().map(|t| 0.35 + t.mechanical_w / 0.6 + t.holding_w).collect();
    let found = power::best(&servo, &trials, &measured);
    assert!((found.electronics_w - 0.35).abs() < 1e-6 && (found.efficiency - 0.6).abs() < 1e-6, "{found:?}");

    // Less than the work: the bounds hold, whatever the error.
    let measured: Vec<f64> = trials.iter().map(|t| 0.4 * t.mechanical_w).collect();
    let found = power::best(&servo, &trials, &measured);
    assert_eq!((found.electronics_w, found.efficiency), (0.25, 1.0));
}

#[test]
fn a_share_beyond_a_parameters_range_is_folded_back_into_it() {
    for parameter in PARAMETERS {
        for share in [-1.3, -0.2, 0.0, 0.4, 1.0, 1.7, 5.1] {
            let value = parameter.value_at(share);
            assert!((parameter.min..=parameter.max).contains(&value), "{} {value}", parameter.name);
        }
        let mut robot = ant();
        parameter.put(&mut robot, parameter.value_at(0.25));
        assert!((parameter.share_of(&robot) - 0.25).abs() < 1e-9, "{}", parameter.name);
    }
    assert!(matches!(Parameter::choose(&["colour".to_owned()]), Err(TwinError::Parameter { .. })));
}
