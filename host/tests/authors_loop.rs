//! The authors' published loop, fitted here, is the loop that their robot played.
//!
//! Their data are not ours to publish: where they are absent, a synthetic loop
//! stands in, and the test says so.

use host::gait::fit::{self, Scale, Seam};
use host::gait::gait_file::{GaitFile, Provenance, Source};
use host::gait::joint_map::JointMap;
use host::gait::trajectory::Trajectory;
use protocol::Joint;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Neutral and scale of their tables.
const NEUTRAL_TICKS: f64 = 330.0;
const DEG_PER_TICK: f64 = 0.6;
const ROWS: std::ops::Range<usize> = 973..1000;

fn data(file: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data").join(file);
    path.is_file().then_some(path)
}

fn authors_scale() -> (JointMap, Scale) {
    let map =
        JointMap::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/authors-map.toml")).unwrap();
    let scale = Scale {
        signs: map.signs().unwrap(),
        unit_deg: map.unit_deg.unwrap(),
        centre_unit_deg: map.centre_unit_deg.unwrap(),
        centre_offset_deg: map.centre_offset_deg.unwrap(),
        limit_deg: map.limit_deg.unwrap(),
    };
    (map, scale)
}

fn gait(rows: &[[f64; 8]], scale: &Scale) -> GaitFile {
    let fits = fit::fit(rows, scale, Seam::Free).unwrap();
    GaitFile {
        name: "loop".into(),
        period_s: 2.7,
        unit_deg: scale.unit_deg,
        provenance: Provenance::of(Source::Fitted),
        joints: fits.map(|fit| fit.series),
    }
}

/// Ticks by (amplification, sample, joint), of their smoothed method.
fn their_tables(path: &Path) -> HashMap<(String, usize, Joint), f64> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let headers = reader.headers().unwrap().clone();
    let mut tables = HashMap::new();
    for row in reader.records().map(Result::unwrap).filter(|row| &row[0] == "psto") {
        for (place, name) in headers.iter().enumerate().skip(3) {
            let joint = Joint::from_name(name).unwrap();
            tables.insert((row[1].into(), row[2].parse().unwrap(), joint), row[place].parse().unwrap());
        }
    }
    tables
}

/// Where their sample lies in our stride: the first row is phase 0, the last phase 1.
fn ticks(gait: &GaitFile, joint: Joint, sample: usize, amplitude: f64) -> f64 {
    let phase = (sample as f64 / (ROWS.len() - 1) as f64).min(1.0 - 1e-9);
    NEUTRAL_TICKS + gait.angle_deg(joint, phase, amplitude) / DEG_PER_TICK
}

/// At 1.0x their integers cut up to a tick off; above, their pivot is the mean
/// of their samples where ours is the mean of the curve, and the difference
/// grows with the amplitude.
#[test]
fn the_fitted_loop_reproduces_the_tables_that_the_authors_robot_played() {
    let (Some(trajectory), Some(tables)) = (data("ant-trajectory.csv"), data("ant-tables.csv")) else {
        println!(
            "SKIPPED: the authors' trajectory and tables are not here; only the synthetic loop was fitted"
        );
        return;
    };
    let (map, scale) = authors_scale();
    let trajectory = Trajectory::read(&trajectory, map.columns.as_deref()).unwrap();
    let gait = gait(trajectory.rows(ROWS.start, ROWS.end).unwrap(), &scale);
    let tables = their_tables(&tables);

    for (amplification, bound_ticks) in [("1.0", 1.5), ("2.2", 4.0), ("2.4", 4.0)] {
        let mut worst = 0.0_f64;
        for joint in Joint::ALL {
            for sample in 0..ROWS.len() {
                let theirs = tables[&(amplification.to_owned(), sample, joint)];
                let ours = ticks(&gait, joint, sample, amplification.parse().unwrap());
                worst = worst.max((ours - theirs).abs());
            }
        }
        println!("{amplification}x: at most {worst:.2} ticks from the authors' table");
        assert!(worst <= bound_ticks, "{amplification}x: {worst} ticks");
    }
    assert!(gait.check_limits(2.4).is_ok(), "their largest amplification must fit the Ant's limits");
}

/// A synthetic loop in the authors' conventions: two strides of 13.5 rows.
#[test]
fn a_synthetic_loop_in_the_authors_conventions_is_scaled_as_theirs() {
    let (_, scale) = authors_scale();
    let action = |row: usize, joint: Joint| {
        let angle = std::f64::consts::TAU * 2.0 * row as f64 / 27.0 + f64::from(joint.leg());
        0.1 * f64::from(joint.leg()) + 0.3 * angle.sin()
    };
    let rows: Vec<[f64; 8]> = (0..27).map(|row| Joint::ALL.map(|joint| action(row, joint))).collect();

    let gait = gait(&rows, &scale);

    for joint in Joint::ALL {
        let sign = if matches!(joint, Joint::Knee3 | Joint::Knee4) { -1.0 } else { 1.0 };
        let worst = (0..27)
            .map(|row| (ticks(&gait, joint, row, 1.0) - (350.0 + 40.0 * sign * action(row, joint))).abs())
            .fold(0.0, f64::max);
        assert!(worst < 0.5, "{}: {worst} ticks", joint.name());
        assert!(gait.joints[joint.index()].r2.unwrap() > 0.99, "{}", joint.name());
    }
}
