use super::*;
use crate::gait::policy_record::{PolicyRecord, RECORD};
use crate::learn::td3::policy::DenseLayer;
use crate::robot::LegScale;
use protocol::Joint;

/// Asks for the same pose whatever it sees: `observations` in, 8 out.
fn statue(observations: usize) -> Policy {
    Policy::new(vec![DenseLayer { weight: vec![0.0; observations * 8], bias: vec![0.0; 8] }])
}

fn ant() -> Robot {
    Robot::ant(LegScale::LONG).unwrap()
}

#[test]
fn a_policy_that_stands_has_no_stride() {
    let error =
        record(&statue(OBSERVATION_LEN), &ant(), AntEnvConfig::default(), 0, 2, Part::Strides).unwrap_err();

    assert!(matches!(error, RecordError::NoStride { source: StrideError::Still { .. }, .. }), "{error}");
}

#[test]
fn a_policy_of_another_robot_is_refused() {
    let error = record(&statue(12), &ant(), AntEnvConfig::default(), 0, 2, Part::Strides).unwrap_err();

    assert!(matches!(error, RecordError::OtherRobot { observation_len: 12, action_len: 8 }), "{error}");
}

/// What is recorded is the twin's gait, on whatever robots it was learned.
#[test]
fn trials_are_walked_on_the_described_robot() {
    let told = |trials: Vec<Trial>| -> Vec<[f64; 3]> {
        trials.iter().map(|trial| [trial.reward, trial.speed, trial.servo_power_w]).collect()
    };
    let play = |randomisation| {
        let env = AntEnvConfig { randomisation, ..AntEnvConfig::default() };
        told(play_all(&statue(OBSERVATION_LEN), &ant(), env, 3, 2))
    };

    let differing = Randomisation { mass_share: 0.3, supply_share: 0.5, ..Randomisation::NONE };
    assert_eq!(play(differing), play(Randomisation::NONE));
}

#[test]
fn a_policy_that_falls_is_refused() {
    let mut layer = DenseLayer { weight: vec![0.0; OBSERVATION_LEN * 8], bias: vec![0.0; 8] };
    layer.bias[4..].fill(-5.0);

    let error =
        record(&Policy::new(vec![layer]), &ant(), AntEnvConfig::default(), 0, 2, Part::Strides).unwrap_err();

    assert!(matches!(error, RecordError::Fell { fell: 2, trials: 2 }), "{error}");
}

/// What a recording of these samples looks like.
fn recording(samples: Vec<Sample>) -> Recording {
    recording_of(samples, None)
}

fn recording_of(samples: Vec<Sample>, window_s: Option<f64>) -> Recording {
    let fits = fit_samples(&samples, window_s);
    let summary = RecordSummary {
        period_s: 0.5,
        window_s,
        strides_in_window: None,
        trials: 1,
        fell: 0,
        strides_averaged: 1,
        strides_left_out: 0,
        correlation: 1.0,
        spread: [0.1; 8],
        spread_deg: [4.5; 8],
        polynomial_r2: [Some(0.5); 8],
        speed_m_s: 0.1,
        reward_per_step: 0.0,
        power_w: 1.0,
    };
    Recording { summary, deviations: vec![[0.1; 8]; samples.len()], samples, fits }
}

fn wave(rows: usize) -> Vec<Sample> {
    let phase = |row: usize| std::f64::consts::TAU * row as f64 / rows as f64;
    (0..rows).map(|row| std::array::from_fn(|joint| 0.5 * (phase(row) + joint as f64).sin())).collect()
}

#[test]
fn the_trajectory_names_its_columns_and_spaces_its_rows_evenly() {
    let recording = recording(vec![[0.25; 8], [-0.5; 8]]);

    let csv = recording.to_csv(&recording.samples);

    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4"));
    assert_eq!(lines.next().map(|line| &line[..17]), Some("0.000000,0.250000"));
    assert_eq!(lines.next().map(|line| &line[..18]), Some("0.250000,-0.500000"));
    assert_eq!(lines.next(), None);
}

#[test]
fn the_picture_shows_every_joint_with_its_samples_spread_and_curve() {
    let svg = figure::of(&recording(wave(30))).to_svg().unwrap();

    for joint in Joint::ALL {
        assert!(svg.contains(joint.name()), "{}", joint.name());
    }
    // One more of each in the legend, where the band is a rectangle.
    let count = |tag: &str| svg.matches(tag).count();
    assert_eq!((count("<circle"), count("<polygon")), (8 * 30 + 1, 8));
    assert_eq!(svg.matches("polynomial of degree 10").count(), 1);
}

/// The same run must leave the same bytes, or a figure in a paper cannot be checked.
#[test]
fn the_picture_of_the_same_recording_is_the_same_file() {
    let draw = || figure::of(&recording(wave(30))).to_svg().unwrap();

    assert_eq!(draw(), draw());
}

#[test]
fn a_stride_of_too_few_samples_for_a_curve_is_drawn_without_one() {
    let recording = recording(wave(8));

    let svg = figure::of(&recording).to_svg().unwrap();

    assert!(matches!(recording.fits, Err(FitError::TooFewRows { rows: 8 })));
    assert!(!svg.contains("polynomial"));
}

#[test]
fn a_recording_leaves_its_files_in_the_run() {
    let folder = tempfile::tempdir().unwrap();

    recording(wave(30)).save(folder.path()).unwrap();

    let lines = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap().lines().count();
    assert_eq!((lines(crate::run_folder::TRAJECTORY), lines(SPREAD)), (31, 31));
    let record: PolicyRecord =
        serde_json::from_slice(&std::fs::read(folder.path().join(RECORD)).unwrap()).unwrap();
    assert_eq!(record.summary, recording(wave(30)).summary);
    let trajectory = folder.path().join(crate::run_folder::TRAJECTORY);
    let read = crate::gait::trajectory::Trajectory::read(&trajectory, None).unwrap();
    assert_eq!(record.trajectory_sha256, read.sha256);
    assert!(lines(FIGURE) > 100);
}

/// A window's ends need not meet: 0.5 at its beginning, -0.5 at its end.
#[test]
fn a_windows_curve_is_free_and_ends_at_its_last_sample() {
    let ramp: Vec<Sample> = (0..30).map(|row| [0.5 - f64::from(row) / 29.0; 8]).collect();

    let window = recording_of(ramp.clone(), Some(0.5));
    let stride = recording_of(ramp, None);

    let r2 = |recording: &Recording| recording.fits.as_ref().unwrap()[0].series.r2.unwrap();
    assert!(r2(&window) > 0.999_999 && r2(&stride) < 0.99, "{} {}", r2(&window), r2(&stride));
    let end = |recording: &Recording| figure::curve_end(recording, Joint::Hip1).unwrap();
    let (at_s, angle_deg) = end(&window);
    assert!((at_s - 0.5 * 29.0 / 30.0).abs() < 1e-9, "{at_s}");
    assert!((angle_deg + 0.5 * ACTION_DEG).abs() < 1e-6, "{angle_deg}");
    assert_eq!(end(&stride).0, 0.5);
}
