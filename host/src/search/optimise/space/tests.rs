//! Every point is a gait that its robot can play.

use super::*;

fn space(waves: usize) -> Space {
    let robot = Robot::ant(crate::robot::LegScale::LONG).expect("1.0 is a leg scale");
    Space::new(Basis::new().expect("the algebra holds"), Bounds::of(&robot), waves)
}

#[test]
fn whatever_is_asked_for_the_servos_can_follow() {
    let space = space(4);
    let bounds = space.bounds;
    for size in [0.1, 1.0, 5.0, 1e3, f64::INFINITY, f64::NAN] {
        let point: Vec<f64> = (0..space.dimension()).map(|i| size * (i as f64 * 0.7).sin()).collect();

        let motion = space.motion(&point);

        assert!((LEAST_PERIOD_S..=MOST_PERIOD_S).contains(&motion.period_s), "{size}: {}", motion.period_s);
        assert!(motion.fastest_deg_s(1.0) <= bounds.speed_deg_s * 1.000_001, "{size}");
        for i in 0..1000 {
            for angle in motion.angles_rad(motion.period_s * f64::from(i) / 1000.0, 1.0) {
                assert!(
                    angle.to_degrees().abs() <= bounds.ranges_deg[0].1 + 0.05,
                    "{size}: {}",
                    angle.to_degrees()
                );
            }
        }
    }
}

#[test]
fn a_motion_is_found_again_by_its_point() {
    let space = space(2);
    let point: Vec<f64> = (0..space.dimension()).map(|i| 0.3 * (i as f64).sin()).collect();
    let motion = space.motion(&point);

    let found = space.point(&motion);

    for (found, asked) in found.iter().zip(&point) {
        assert!((found - asked).abs() < 1e-9, "{found} {asked}");
    }
}

#[test]
fn a_point_of_fewer_waves_is_the_same_gait_among_more() {
    let point: Vec<f64> = (0..space(1).dimension()).map(|i| 0.5 * (i as f64).cos()).collect();

    assert_eq!(space(1).motion(&point), space(3).motion(&point));
}

#[test]
fn the_gaits_that_come_with_the_program_keep_their_robots_bounds() {
    for (leg, folder) in
        [(crate::robot::LegScale::LONG, "ant-1L"), (crate::robot::LegScale::SHORT, "ant-0.6L")]
    {
        let path = format!("{}/gaits/{folder}/searched.toml", env!("CARGO_MANIFEST_DIR"));
        let gait = GaitFile::load(std::path::Path::new(&path)).expect("a gait file");
        let motion = Motion::of(&gait, 1.0);
        let bounds = Bounds::of(&Robot::ant(leg).expect("a leg scale"));

        assert!(motion.fastest_deg_s(1.0) <= bounds.speed_deg_s * 1.001, "{leg}");
        assert!(motion.excess_deg(&bounds, 1.0) <= 0.01, "{leg}");
    }
}
