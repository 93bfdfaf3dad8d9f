//! The twin against what the authors' robot did: their tables in, speed, power
//! and cost of transport out. `docs/twin.md` says what is reached and how.

use host::robot::{LegScale, Robot};
use host::twin::{Options, Tables, Trials, validate};
use std::path::Path;

/// Mean absolute relative errors of speed, power and cost of transport that
/// the description must keep to; `psto` is fitted, `original` is not.
const BARS: [(&str, [f64; 3]); 2] = [("psto", [0.04, 0.045, 0.04]), ("original", [0.08, 0.06, 0.12])];

#[test]
fn the_authors_gaits_walk_at_their_measured_speed_and_power() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data");
    let files = ["ant-tables.csv", "ant-trials.csv"].map(|name| folder.join(name));
    if !files.iter().all(|file| file.exists()) {
        println!("skipped: ../shared/data with the authors' measurements is not there");
        return;
    }
    let tables = Tables::read(&files[0]).expect("their tables");
    let trials = Trials::read(&files[1], LegScale::LONG).expect("their trials");
    let robot = Robot::ant(LegScale::LONG).expect("the Ant");

    let report = validate(&robot, &tables, &trials, &Options { half_step: true, ..Options::default() })
        .expect("a report");

    for (name, bars) in BARS {
        let method = &report.methods[name];
        let errors = [method.speed_mare, method.power_mare, method.cot_mare];
        println!("{name}: speed, power, cost of transport off by {errors:.3?}, bars {bars:?}");
        for (error, bar) in errors.into_iter().zip(bars) {
            assert!(error <= bar, "{name}: {errors:?}, but the bars are {bars:?}");
        }
    }
    assert!(report.methods["psto"].fitted && !report.methods["original"].fitted);
    let half = report.half_step.expect("it was asked for");
    println!(
        "half the physics step changes speed by {:.3}, cost of transport by {:.3}",
        half.speed, half.cost_of_transport
    );
    assert!(half.speed <= 0.05 && half.cost_of_transport <= 0.05, "{half:?}");
    assert!(report.spearman_speed.is_some_and(|rank| rank >= 0.95), "{:?}", report.spearman_speed);
    for pair in &report.pairs {
        assert!(pair.faster_agrees, "{pair:?}");
    }
}
