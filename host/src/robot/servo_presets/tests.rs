//! Presets by hand, and how a description takes them.

use super::*;

/// A `[servo]` of these lines.
fn servo(text: &str) -> Result<Servo, String> {
    toml::from_str::<Servo>(text).map_err(|error| error.to_string())
}

#[test]
fn every_preset_is_plausible_at_its_voltages_and_names_one_source_for_each_number() {
    assert!(presets().len() >= 12, "{} presets", presets().len());
    for preset in presets() {
        let name = &preset.name;
        assert!(preset.at.is_sorted_by(|a, b| a.voltage_v < b.voltage_v), "{name}");
        for rating in &preset.at {
            let Derived { servo, heat_w_per_n2_m2 } = preset.at(rating.voltage_v).expect(name);
            assert!((0.05..4.0).contains(&servo.torque_limit_n_m), "{name}: {servo:?}");
            assert!((3.0..15.0).contains(&servo.no_load_speed_rad_s), "{name}: {servo:?}");
            assert!(
                (400.0..=2600.0)
                    .contains(&(servo.neutral_pulse_us - servo.end_stop_deg * servo.pulse_us_per_deg))
            );
            assert!((5.0..=15.0).contains(&servo.pulse_us_per_deg), "{name}: {servo:?}");
            let stall_a = heat_w_per_n2_m2 * servo.torque_limit_n_m.powi(2) / rating.voltage_v;
            assert!((0.2..6.0).contains(&stall_a), "{name}: {stall_a} A");
        }
        let has = [
            (Stated::Torque, true),
            (Stated::Speed, true),
            (Stated::Current, preset.at.iter().any(|rating| rating.stall_current_a.is_some())),
            (Stated::Mass, preset.mass_g.is_some()),
            (Stated::DeadBand, preset.dead_band_us.is_some()),
            (Stated::Travel, true),
        ];
        for (group, is_there) in has {
            let times = preset.sources.iter().filter(|source| source.of.contains(&group)).count();
            assert_eq!(times, usize::from(is_there), "{name}: sources of {group:?}");
        }
        assert!(preset.sources.iter().all(|source| source.document.len() > 10), "{name}");
        assert_eq!(super::preset(name).expect(name), preset, "two are called {name}");
    }
}

/// MG90S: 1.8 and 2.2 kgf cm at 4.8 and 6 V, 0.10 and 0.08 s for 60 degrees.
#[test]
fn numbers_between_two_stated_voltages_are_on_the_line_between_them() {
    let servo = preset("mg90s").expect("a servo").at(5.4).expect("between").servo;

    assert!((servo.torque_limit_n_m - 2.0 * 0.098_066_5).abs() < 1e-12, "{servo:?}");
    let speed = (10.0 + 12.5) / 2.0 * FRAC_PI_3;
    assert!((servo.no_load_speed_rad_s - speed).abs() < 1e-9, "{servo:?}");
    assert!((servo.damping_n_m_s_rad - servo.torque_limit_n_m / speed).abs() < 1e-12);
    assert_eq!((servo.neutral_pulse_us, servo.end_stop_deg), (1450.0, 90.0));
    assert!((servo.pulse_us_per_deg - 1900.0 / 180.0).abs() < 1e-12);
    assert!((servo.dead_band_deg - 2.5 / (1900.0 / 180.0)).abs() < 1e-12);
}

#[test]
fn a_voltage_a_little_beyond_the_stated_ones_scales_and_a_far_one_is_refused() {
    let sg90 = preset("SG90").expect("a servo");

    let servo = sg90.at(5.0).expect("a little beyond").servo;

    assert!((servo.torque_limit_n_m - 1.8 * 0.098_066_5 * 5.0 / 4.8).abs() < 1e-12, "{servo:?}");
    let error = sg90.at(7.4).expect_err("two cells").to_string();
    assert!(error.contains("7.4") && error.contains("4.8 V"), "{error}");
    assert!(sg90.at(f64::NAN).is_err());
}

/// By stall current 0.7 A x 4.8 V over (3 kgf cm)^2; and by torque and speed without one.
#[test]
fn the_heat_of_holding_is_the_stall_power_over_the_stall_torque_squared() {
    let torque_n_m: f64 = 3.0 * 0.098_066_5;
    let heat = preset("HS-311").expect("a servo").at(4.8).expect("stated").heat_w_per_n2_m2;
    assert!((heat - 0.7 * 4.8 / torque_n_m.powi(2)).abs() < 1e-9, "{heat}");

    let torque_n_m: f64 = 1.8 * 0.098_066_5;
    let heat = preset("MG90S").expect("a servo").at(4.8).expect("stated").heat_w_per_n2_m2;
    assert!((heat - FRAC_PI_3 / 0.1 / 0.5 / torque_n_m).abs() < 1e-9, "{heat}");
}

#[test]
fn a_model_fills_what_the_file_leaves_out_and_a_number_that_is_given_overrides_it() {
    let known = preset("ES08MA II").expect("a servo").at(5.0).expect("stated").servo;

    let filled = servo("model = \"es08maii\"\nvoltage_v = 5.0").expect("a servo");
    let changed =
        servo("model = \"ES08MA II\"\nvoltage_v = 5.0\nneutral_pulse_us = 1520.0\nfriction_n_m = 0.0")
            .expect("a servo");

    assert_eq!(filled, known);
    assert_eq!(changed, Servo { neutral_pulse_us: 1520.0, friction_n_m: 0.0, ..known.clone() });
    let written = toml::to_string(&changed).expect("text");
    assert_eq!(servo(&written).expect("a servo"), changed, "{written}");
}

#[test]
fn an_unknown_model_is_refused_with_the_nearest_names() {
    let error = servo("model = \"MG9OS\"\nvoltage_v = 5.0").expect_err("a letter for a digit");
    assert!(error.contains("MG9OS") && error.contains("did you mean MG90S"), "{error}");

    let error = servo("model = \"MG90S\"").expect_err("no voltage");
    assert!(error.contains("servo.voltage_v is missing") && error.contains("4.8 to 6 V"), "{error}");

    let error = servo("voltage_v = 5.0").expect_err("no model");
    assert!(error.contains("goes with servo.model"), "{error}");

    let error = servo("stiffness_n_m_rad = 2.0").expect_err("nothing else");
    assert!(error.contains("missing field `damping_n_m_s_rad`"), "{error}");
}
