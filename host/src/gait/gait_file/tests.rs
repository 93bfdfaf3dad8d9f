use super::*;
use crate::cause_chain::message_of;
use proptest::prelude::*;
use protocol::Amplitude;
use protocol::gait::COEFFICIENT_COUNT;
use std::path::PathBuf;

/// Eight joints about 5 degrees, hips and knees with different strokes.
fn walk() -> GaitFile {
    let joints = Joint::ALL.map(|joint| {
        let mut coefficients_deg = [0.0; COEFFICIENT_COUNT];
        coefficients_deg[2] = if joint.is_hip() { 12.0 } else { -8.0 };
        coefficients_deg[0] = coefficients_deg[2] / 3.0;
        coefficients_deg[7] = 0.1 * f64::from(joint.leg());
        JointSeries { centre_deg: 5.0, min_deg: -55.0, max_deg: 55.0, coefficients_deg, ..Default::default() }
    });
    GaitFile {
        name: "walk".into(),
        period_s: 0.7,
        unit_deg: 24.0,
        provenance: Provenance { seed: Some(7), ..Provenance::of(Source::Trained) },
        joints,
    }
}

fn saved(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gait.toml");
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

/// One of the two cannot be written; they must not be of different gaits.
#[test]
fn a_gait_that_cannot_be_saved_whole_leaves_both_old_files() {
    for blocked in ["gait.toml", "gait.bin"] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gait.toml");
        walk().save(&path).unwrap();
        let read = |name: &str| std::fs::read(folder.path().join(name)).ok();
        std::fs::remove_file(folder.path().join(blocked)).unwrap();
        std::fs::create_dir(folder.path().join(blocked)).unwrap();
        let before = (read("gait.toml"), read("gait.bin"));

        let error = GaitFile { period_s: 0.9, ..walk() }.save(&path).unwrap_err();

        assert!(matches!(&error, GaitFileError::File(file) if file.path.ends_with(blocked)), "{error}");
        assert_eq!((read("gait.toml"), read("gait.bin")), before, "{blocked}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "something was left behind");
    }
}

#[test]
fn a_saved_gait_is_read_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gait.toml");
    let mut gait = walk();
    gait.joints[3].coefficients_deg[4] = 1.0 / 3.0;
    gait.joints[3].r2 = Some(0.987_654_321);

    gait.save(&path).unwrap();

    assert_eq!(GaitFile::load(&path).unwrap(), gait);
}

#[test]
fn the_bytes_beside_it_hold_the_same_table() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gait.toml");

    walk().save(&path).unwrap();
    let from_bytes = GaitFile::load(&path.with_extension("bin")).unwrap();

    assert_eq!(from_bytes.table(), walk().table());
    assert_eq!(from_bytes.encoded(), walk().encoded());
    assert_eq!(from_bytes.provenance.source, Source::Table);
}

#[test]
fn the_longest_table_fits_its_buffer() {
    let mut gait = walk();
    gait.name = "sixteen letters!".into();
    gait.period_s = 60.0;

    let encoded = gait.encoded().unwrap();

    assert!(!encoded.is_empty() && encoded.len() <= MAX_ENCODED_LEN, "{}", encoded.len());
}

/// `printf '' | sha256sum`: the known digest of nothing.
#[test]
fn the_hash_is_what_sha256sum_prints() {
    assert_eq!(gait_sha256(b""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
}

#[test]
fn each_unusable_value_is_named_with_its_joint_and_limit() {
    let text = walk().to_toml();
    let cases = [
        ("version = 1", "version = 2", "its version is 2; this program reads version 1"),
        ("name = \"walk\"", "name = \"\"", "its name is \"\""),
        ("period_s = 0.7", "period_s = 0.05", "period_s is 0.05; it must be within 0.1 to 60"),
        ("period_s = 0.7", "period_s = nan", "period_s is NaN"),
        ("name = \"knee4\"", "name = \"tail\"", "it names a joint \"tail\""),
        ("name = \"knee4\"", "name = \"knee3\"", "it has knee3 twice"),
        ("centre_deg = 5.0", "centre_deg = 70.0", "hip1: centre_deg is 70; it must be within -55 to 55"),
        ("max_deg = 55.0", "max_deg = 120.0", "hip1: max_deg is 120; it must be within -54 to 90"),
        ("4.0, 0.0, 12.0", "4.0, nan, 12.0", "hip1: a coefficient is NaN"),
        ("4.0, 0.0, 12.0", "4.0, 55.0, 52.0", "hip1: the curve swings"),
        ("4.0, 0.0, 12.0", "4.0, 12.0", "hip1 has 10 coefficients; a degree-10 curve has 11"),
    ];
    for (from, to, expected) in cases {
        let (_folder, path) = saved(&text.replacen(from, to, 1));

        let message = message_of(&GaitFile::load(&path).unwrap_err());

        assert!(message.contains(expected), "{to}: {message}");
        assert!(message.contains("gait.toml"), "{to}: {message}");
    }
}

#[test]
fn the_file_says_whose_gait_it_is_and_one_that_does_not_loads_as_well() {
    let robot = Robot::ant(LegScale::SHORT).unwrap();
    let robot = Robot { name: "Pony II".into(), ..robot };
    let mut gait = walk();
    gait.provenance = gait.provenance.with_robot(&robot);

    let text = gait.to_toml();
    let (_folder, path) = saved(&text);

    assert!(text.starts_with("# A gait of Pony II. angle ="), "{text}");
    assert_eq!(GaitFile::load(&path).unwrap().provenance.robot_sha256, Some(robot.sha256()));
    assert!(walk().to_toml().starts_with("# A gait. angle ="));
    assert_eq!(gait.encoded(), walk().encoded());
}

#[test]
fn a_default_name_is_the_robots_own_and_fits() {
    let trained = |robot: Option<&str>| {
        let provenance =
            Provenance { seed: Some(12), robot: robot.map(str::to_owned), ..Provenance::of(Source::Trained) };
        provenance.gait_name(Path::new("stride.csv"))
    };

    assert_eq!(trained(None), "ant-seed-12");
    assert_eq!(trained(Some("Ant")), "ant-seed-12");
    assert_eq!(trained(Some("Pony")), "pony-seed-12");
    assert_eq!(trained(Some("Großer Roboter 3")), "gro-er-r-seed-12");
    assert_eq!(short_name("opt-", "Pony", "-seed0"), "opt-pony-seed0");
    assert_eq!(short_name("opt-", "…", "-seed0"), "opt-robot-seed0");
}

#[test]
fn a_missing_joint_is_counted() {
    let text = walk().to_toml();
    let last = text.rfind("[[joint]]").unwrap();
    let (_folder, path) = saved(&text[..last]);

    let message = message_of(&GaitFile::load(&path).unwrap_err());

    assert!(message.contains("it has 7 joints; a robot has 8"), "{message}");
}

#[test]
fn a_cut_or_flipped_table_is_refused() {
    let bytes = walk().encoded().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gait.bin");
    for damage in 0..bytes.len() {
        let mut flipped = bytes.clone();
        flipped[damage] ^= 0x10;
        for bad in [&bytes[..damage], &flipped] {
            std::fs::write(&path, bad).unwrap();

            assert!(matches!(GaitFile::load(&path), Err(GaitFileError::Bytes { .. })), "byte {damage}");
        }
    }
}

#[test]
fn text_that_is_no_toml_is_refused_with_its_line() {
    let (_folder, path) = saved("version = 1\nname = walk\n");

    let message = message_of(&GaitFile::load(&path).unwrap_err());

    assert!(message.contains("line 2"), "{message}");
}

#[test]
fn at_the_largest_amplitude_a_joint_touches_its_limit_and_none_passes_it() {
    let gait = walk();

    let largest = gait.largest_amplitude().unwrap();

    assert!(gait.check_limits(largest.amplitude).is_ok());
    assert!(gait.check_limits(largest.amplitude + 1e-6).is_err());
    let angle_deg = gait.angle_deg(largest.joint, largest.phase, largest.amplitude);
    assert!((angle_deg - largest.limit_deg).abs() < 1e-6, "{angle_deg} {largest:?}");
}

/// 12 T_2 + 4 is 16 at both ends of the stride and lowest, -8, in its middle;
/// leg 4's 0.4 T_7 takes 0.4 from the start and adds 0.4 at the end.
#[test]
fn the_refusal_names_joint_angle_and_what_fits() {
    let gait = walk();

    let refusal = gait.check_limits(3.5).unwrap_err();

    assert_eq!(refusal.joint, Joint::Hip4);
    assert!((refusal.angle_deg - (5.0 + 3.5 * 16.4)).abs() < 0.01, "{refusal}");
    assert_eq!(refusal.largest, Some(3.0));
    assert!(refusal.to_string().contains("hip4 would go to 62.4 degrees at phase 1.000; its limit is 55.0"));
}

#[test]
fn only_the_time_beyond_the_limits_is_clipped() {
    let mut gait = walk();
    for series in &mut gait.joints {
        // A straight line from -20 to 20 degrees, held at 10: the last quarter is beyond.
        series.coefficients_deg = [0.0; COEFFICIENT_COUNT];
        series.coefficients_deg[1] = 20.0;
        series.centre_deg = 0.0;
        series.max_deg = 10.0;
    }

    assert!((gait.clipped_share(1.0) - 0.25).abs() < 1e-3);
    assert_eq!(gait.clipped_share(0.5), 0.0);
}

#[test]
fn a_gait_that_stands_still_has_no_largest_amplitude() {
    let mut gait = walk();
    for series in &mut gait.joints {
        series.coefficients_deg = [0.0; COEFFICIENT_COUNT];
    }

    assert_eq!(gait.largest_amplitude(), None);
    assert!(gait.check_limits(3.0).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig {
        rng_seed: proptest::test_runner::RngSeed::Fixed(6),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    /// What the robot computes stays within 0.05 degree of what the file says.
    #[test]
    fn setpoints_follow_the_file_within_a_twentieth_of_a_degree(
        coefficients in prop::array::uniform11(-4.0..4.0_f64),
        centre_deg in -20.0..20.0_f64,
        phase in any::<u16>(),
        amplitude in 0.5..3.0_f64,
    ) {
        let mut gait = walk();
        gait.joints[5] = JointSeries {
            centre_deg, min_deg: -90.0, max_deg: 90.0, coefficients_deg: coefficients, ..Default::default()
        };

        let table = gait.table().unwrap();
        let asked = table.setpoint(Joint::Knee2, phase, Amplitude::from_f64(amplitude).unwrap());

        let reference = gait.angle_deg(Joint::Knee2, f64::from(phase) / 65536.0, amplitude);
        prop_assert!((asked.deg() - reference).abs() <= 0.05, "{} {}", asked.deg(), reference);
    }
}
