//! Robots are read back as written, and refused by name.

mod formats;
mod refusals;

use super::*;

fn ant() -> Robot {
    Robot::ant(LegScale::LONG).expect("the Ant")
}

fn pony() -> Robot {
    Robot::load(Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pony"))).expect("a robot")
}

#[test]
fn the_ant_is_the_fitted_one_and_weighs_about_a_kilogram() {
    let ant = ant();

    let record = ant.twin.as_ref().expect("the description says what it was fitted to");
    assert_eq!(record.methods, ["psto"]);
    assert!(record.spread.contains_key("ground.friction"), "{record:?}");
    assert!((0.8..1.1).contains(&ant.mass_kg()), "{} kg", ant.mass_kg());
}

/// The Ant's drawing, by hand: 4 hip and 4 knee servos of 55 g, tubes of 10 and
/// 20 g; a shin's middle half its 230 mm below and out of the knee.
#[test]
fn the_ants_drawing_has_the_masses_and_lengths_that_it_tells() {
    let ant = ant();
    let limbs = Limbs::of(&ant);

    let torso = &limbs.torso.inertia;
    assert!((torso.mass_kg - (ant.mass.torso_kg + 0.22)).abs() < 1e-12, "{torso:?}");
    let expected = ant.mass.torso_kg / 12.0 * (0.14 * 0.14 + 0.14 * 0.14)
        + 4.0 * 0.055 * (0.07 * 0.07 * 2.0 + (0.04 * 0.04 + 0.02 * 0.02) / 12.0);
    assert!((torso.tensor_kg_m2[(2, 2)] / expected - 1.0).abs() < 1e-6, "{torso:?}");
    for leg in &limbs.legs {
        assert!((leg.thigh.inertia.mass_kg - 0.065).abs() < 1e-12);
        let shin = &leg.shin.inertia;
        assert!((shin.mass_kg - 0.02).abs() < 1e-12);
        let knee = leg.knee.in_child.translation.vector;
        assert!(((shin.centre_m.coords - knee).norm() - 0.115).abs() < 1e-6);
        assert!(((leg.foot_m.coords - knee).norm() + ant.geometry.foot_radius_m - 0.23).abs() < 1e-6);
        let moments = shin.principal().moments_kg_m2;
        let thick = 0.02 / 12.0 * (0.23 * 0.23 + 0.012 * 0.012);
        assert!((moments.max() / thick - 1.0).abs() < 1e-5, "{moments}");
    }
}

#[test]
fn only_the_shin_of_the_ant_scales_in_length_mass_and_inertia() {
    let short = Robot::ant(LegScale::SHORT).expect("the Ant");

    let (short_limbs, limbs) = (Limbs::of(&short), Limbs::of(&ant()));
    assert!((ant().mass_kg() - short.mass_kg() - 4.0 * 0.4 * 0.02).abs() < 1e-12);
    assert_eq!(short_limbs.legs[2].thigh, limbs.legs[2].thigh);
    let shin = &short_limbs.legs[2].shin.inertia;
    let moments = shin.principal().moments_kg_m2;
    let thick = 0.6 * 0.02 / 12.0 * (0.138 * 0.138 + 0.012 * 0.012);
    let thin = 0.6 * 0.02 / 12.0 * (2.0 * 0.012 * 0.012);
    assert!((moments.max() / thick - 1.0).abs() < 1e-5, "{moments}");
    assert!((moments.min() / thin - 1.0).abs() < 1e-3, "{moments}");
}

#[test]
fn one_scale_draws_out_both_limbs_of_the_pony() {
    let mut long = pony();
    long.geometry.leg_scale = LegScale::new(1.5).expect("a leg scale");
    long.check().expect("a leg scale");

    let (long, drawn) = (Limbs::of(&long), Limbs::of(&pony()));
    let standing_m = |limbs: &Limbs| limbs.standing_height_m(&[0.0; 8]) - limbs.foot_radius_m;
    // Thigh and shin end at 0.1 m each, the shin's with the ball that keeps its size.
    let height_m = 0.75_f64.sqrt() * (1.5 * 0.2 - 0.01);
    assert!((standing_m(&long) - height_m).abs() < 1e-5, "{}", standing_m(&long));
    // 40 and 60 g of the thigh go with the length, as does the shin's tube; the foot does not.
    assert!((long.mass_kg() - drawn.mass_kg() - 4.0 * 0.5 * 0.13).abs() < 1e-9);
}

#[test]
fn a_torso_of_another_mass_has_inertia_in_proportion_and_the_same_servos() {
    let mut heavy = ant();
    heavy.mass.torso_kg *= 2.0;

    let (heavy_torso, torso) = (Limbs::of(&heavy).torso.inertia, Limbs::of(&ant()).torso.inertia);
    let drawn = &ant().drawn.torso[0].inertia;
    let frame = drawn.tensor_kg_m2 * (ant().mass.torso_kg / drawn.mass_kg);
    assert!((heavy_torso.mass_kg - torso.mass_kg - ant().mass.torso_kg).abs() < 1e-12);
    assert!((heavy_torso.tensor_kg_m2 - torso.tensor_kg_m2 - frame).amax() < 1e-9 + 1e-6 * frame.amax());
}

#[test]
fn the_shins_slope_as_the_description_says_and_their_tips_stay_where_they_are() {
    for (slope_deg, radius_m) in [(40.0, 0.005), (57.3, 0.02), (75.0, 0.01)] {
        let mut robot = ant();
        robot.geometry.shin_below_horizontal_deg = slope_deg;
        robot.geometry.foot_radius_m = radius_m;
        robot.check().expect("a robot");

        let limbs = Limbs::of(&robot);
        for leg in &limbs.legs {
            let thigh = leg.hip.at(0.0);
            let shin = thigh * leg.knee.at(0.0);
            let knee_m = shin * nalgebra::Point3::from(leg.knee.in_child.translation.vector);
            let limb = shin * leg.foot_m - knee_m;
            let slope = (-limb.z).atan2(limb.xy().norm()).to_degrees();
            assert!((slope - slope_deg).abs() < 1e-4, "{slope} instead of {slope_deg}");
            // Outwards, not folded under the torso.
            assert!(limb.xy().dot(&knee_m.coords.xy()) > 0.0, "{limb}");
            assert!((limb.norm() + radius_m - 0.23).abs() < 1e-6, "{}", limb.norm());
        }
    }
}

#[test]
fn the_pony_is_as_its_file_draws_it() {
    let pony = pony();

    assert!((pony.mass_kg() - 1.8).abs() < 1e-9, "{} kg", pony.mass_kg());
    assert_eq!(pony.mass.torso_kg, 1.24);
    assert_eq!(pony.geometry.foot_radius_m, 0.01);
    assert_eq!(pony.geometry.shin_below_horizontal_deg, 60.0);
    let stops = Limbs::of(&pony).stops_rad(&pony);
    assert!((stops[0][1] - 1.2).abs() < 1e-6 && (stops[4][0] + 0.8).abs() < 1e-5, "{stops:?}");
}

#[test]
fn a_folder_that_is_written_is_read_back_whole_without_the_original() {
    for robot in [ant(), pony()] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("copy");
        robot.save(&path).expect("written");

        assert_eq!(Robot::load(&path).expect("read"), robot);
        assert_eq!(Robot::load(&path.join(DESCRIPTION)).expect("read"), robot);
    }
}

#[test]
fn a_run_has_the_robot_that_it_keeps_or_none() {
    let run = tempfile::tempdir().expect("a folder");
    assert_eq!(Robot::of_run(run.path()).expect("nothing there"), None);
    let missing = Robot::of_trained_run(run.path()).expect_err("nothing there").to_string();
    assert!(missing.contains("robot.toml"), "{missing}");

    pony().save(&run.path().join(run_folder::ROBOT)).expect("written");

    assert_eq!(Robot::of_run(run.path()).expect("a robot"), Some(pony()));
}
