//! The gaits that come with the program, walked as a user walks them.

use host::gait::gait_file::{GaitFile, Source};
use host::gait::gait_player::Playable;
use host::robot::{LegScale, Robot};
use host::sim::open_loop::{self, Playback, Trial};
use protocol::Amplitude;
use std::path::Path;

/// Where a learned or sinusoidal gait has the stroke of its policy: 45 degrees an action over 24.
const OWN_STROKE: f64 = 1.875;

/// Forward is +x: a robot with a sensor in front, or a body that is not
/// symmetric, needs to know where a gait takes it.
#[test]
fn every_committed_gait_walks_forward_and_fairly_straight() {
    let mut wrong = Vec::new();
    for (leg, folder) in [(LegScale::LONG, "ant-1L"), (LegScale::SHORT, "ant-0.6L")] {
        let robot = Robot::ant(leg).unwrap();
        for name in ["psto", "ours", "sinusoid", "searched"] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("gaits/{folder}/{name}.toml"));
            let gait = GaitFile::load(&path).unwrap();
            let own = if gait.provenance.source == Source::Searched { 1.0 } else { OWN_STROKE };
            let playable = Playable::from_bytes(&gait.encoded().unwrap()).unwrap();
            let playback = Playback::new(&playable, Amplitude::from_f64(own).unwrap(), &robot);

            let walk = open_loop::play(&robot, &Trial::default(), |time_s| playback.setpoints_rad(time_s));

            let [x_m, y_m] = walk.displacement_m;
            if walk.fell || x_m <= 0.0 || y_m.abs() >= 0.3 * x_m {
                wrong.push(format!("{folder}/{name}: x {x_m:.2} m, y {y_m:.2} m, fell: {}", walk.fell));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
