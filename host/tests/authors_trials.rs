//! The simulated Ant against the authors' measured one: their tables in, speed and power out.
#![cfg(feature = "sim")]

use host::robot::Robot;
use host::sim::open_loop::{Trial, play};
use std::path::{Path, PathBuf};

/// The robot held each sample of a table for this long (fitted with the rest).
const SAMPLE_S: f64 = 0.117;

/// The authors' measurements lie beside the project, not in it.
fn measurements() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    folder.join("ant-tables.csv").exists().then_some(folder)
}

type Row = Vec<String>;

fn rows(path: &Path) -> Vec<Row> {
    let mut reader = csv::Reader::from_path(path).expect("the table is there");
    reader.records().map(|record| record.expect("a row").iter().map(str::to_owned).collect()).collect()
}

fn number(text: &str) -> f64 {
    text.parse().expect("a number")
}

/// Angles from neutral in the order of our joints: their columns already are in it.
fn table(tables: &[Row], method: &str, amplification: f64) -> Vec<[f64; 8]> {
    tables
        .iter()
        .filter(|row| row[0] == method && number(&row[1]) == amplification)
        .map(|row| core::array::from_fn(|j| (0.6 * (number(&row[3 + j]) - 330.0)).to_radians()))
        .collect()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Mean relative errors of speed and power over all amplifications of a method.
fn errors(folder: &Path, robot: &Robot, method: &str) -> (f64, f64) {
    let tables = rows(&folder.join("ant-tables.csv"));
    let trials = rows(&folder.join("ant-trials.csv"));
    let trials: Vec<_> = trials.iter().filter(|row| row[0] == "1.0" && row[1] == method).collect();
    let mut amplifications: Vec<f64> = trials.iter().map(|row| number(&row[2])).collect();
    amplifications.dedup();

    println!("{method}: amplification, speed m/s simulated and measured, power W simulated and measured");
    let (mut speed_errors, mut power_errors) = (Vec::new(), Vec::new());
    for amplification in amplifications {
        let measured = |column: usize| {
            mean(trials.iter().filter(|row| number(&row[2]) == amplification).map(|row| number(&row[column])))
        };
        let (power_w, speed_m_s) = (measured(3), measured(4));
        let samples = table(&tables, method, amplification);
        let walk = play(robot, &Trial::default(), |t| samples[(t / SAMPLE_S) as usize % samples.len()]);
        println!(
            "  {amplification:.1}  {:.4} {speed_m_s:.4}  {:.3} {power_w:.3}  turned {:.0} deg, tilt {:.0} deg, dx {:.2} dy {:.2}{}",
            walk.speed_m_s,
            walk.mean_power_w,
            walk.turned_rad.to_degrees(),
            walk.max_tilt_rad.to_degrees(),
            walk.displacement_m[0],
            walk.displacement_m[1],
            if walk.fell { ", fell" } else { "" },
        );
        speed_errors.push((walk.speed_m_s / speed_m_s - 1.0).abs());
        power_errors.push((walk.mean_power_w / power_w - 1.0).abs());
    }
    let errors = (mean(speed_errors.into_iter()), mean(power_errors.into_iter()));
    println!("  mean error: speed {:.1} %, power {:.1} %", 100.0 * errors.0, 100.0 * errors.1);
    errors
}

#[test]
fn the_authors_gaits_walk_at_their_measured_speed_and_power() {
    let Some(folder) = measurements() else {
        println!("skipped: ../shared/data with the authors' measurements is not there");
        return;
    };
    let robot = Robot::ant(1.0).expect("1.0 is a leg scale");

    let (speed_error, power_error) = errors(&folder, &robot, "psto");
    let (original_speed_error, original_power_error) = errors(&folder, &robot, "original");

    assert!(speed_error < 0.15, "speed on the fitted tables is off by {speed_error}");
    assert!(power_error < 0.15, "power on the fitted tables is off by {power_error}");
    assert!(original_speed_error < 0.3, "speed on the other tables is off by {original_speed_error}");
    assert!(original_power_error < 0.3, "power on the other tables is off by {original_power_error}");
}
