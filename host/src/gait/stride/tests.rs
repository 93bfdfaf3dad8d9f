use super::*;
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

const RATE_HZ: f64 = 60.0;

/// A gait with a pivot, a second harmonic and every joint at another phase.
fn gait(joint: usize, phase: f64) -> f64 {
    let phase = phase + joint as f64 / 8.0;
    0.1 * joint as f64 - 0.3 + 0.5 * (TAU * phase).sin() + 0.15 * (2.0 * TAU * phase).cos()
}

/// 20 trials that begin anywhere in the gait, with some noise.
fn trials(period_s: f64, noise: f64, gait: impl Fn(usize, f64) -> f64) -> Vec<Vec<Sample>> {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    (0..20)
        .map(|_| {
            let phase: f64 = rng.random();
            (0..540)
                .map(|step| {
                    let phase = phase + step as f64 / RATE_HZ / period_s;
                    std::array::from_fn(|joint| gait(joint, phase) + noise * rng.random_range(-1.0..1.0))
                })
                .collect()
        })
        .collect()
}

/// Worst error against the gait at the phase that fits best.
fn worst_error(stride: &Stride) -> f64 {
    let n = stride.samples.len() as f64;
    let error_at = |shift: f64| {
        let errors = stride.samples.iter().enumerate().flat_map(|(index, sample)| {
            sample
                .iter()
                .enumerate()
                .map(move |(joint, value)| (value - gait(joint, shift + index as f64 / n)).abs())
        });
        errors.fold(0.0, f64::max)
    };
    (0..1000).map(|shift| error_at(f64::from(shift) / 1000.0)).fold(f64::INFINITY, f64::min)
}

#[test]
fn trials_that_start_anywhere_average_to_the_gait_behind_them() {
    let stride = average(&trials(0.813, 0.05, gait), RATE_HZ).unwrap();

    assert!((stride.period_s - 0.813).abs() < 0.002, "{}", stride.period_s);
    assert_eq!(stride.samples.len(), 49);
    assert!(worst_error(&stride) < 0.02, "{}", worst_error(&stride));
    assert!(stride.averaged >= 20 * 8 && stride.left_out == 0, "{}", stride.averaged);
    // Uniform noise of 0.05 has a deviation of 0.029; interpolation lessens it.
    assert!(stride.spread.iter().all(|&s| (0.01..0.04).contains(&s)), "{:?}", stride.spread);
}

#[test]
fn the_fundamental_wins_over_its_multiples() {
    for period_s in [0.25, 0.5, 1.1, 1.9] {
        let stride = average(&trials(period_s, 0.02, gait), RATE_HZ).unwrap();

        assert!((stride.period_s - period_s).abs() < 0.02 * period_s, "{} for {period_s}", stride.period_s);
    }
}

/// Every second step is the other pair of legs: half a stride is not a stride.
#[test]
fn a_stride_whose_halves_mirror_each_other_is_not_cut_in_two() {
    let trot = |joint: usize, phase: f64| {
        let pair = if joint.is_multiple_of(2) { 0.0 } else { 0.5 };
        0.5 * (TAU * (phase + pair)).sin()
    };

    let stride = average(&trials(1.0, 0.02, trot), RATE_HZ).unwrap();

    assert!((stride.period_s - 1.0).abs() < 0.01, "{}", stride.period_s);
}

#[test]
fn noise_is_not_periodic_and_standing_is_still() {
    let noise = average(&trials(1.0, 0.5, |_, _| 0.0), RATE_HZ);
    let still = average(&trials(1.0, 0.001, |joint, _| joint as f64 / 8.0), RATE_HZ);

    assert!(matches!(noise, Err(StrideError::NotPeriodic { .. })), "{noise:?}");
    assert!(matches!(still, Err(StrideError::Still { .. })), "{still:?}");
}

#[test]
fn trials_too_short_to_compare_strides_are_refused() {
    let short: Vec<Vec<Sample>> = vec![vec![[0.0; JOINT_COUNT]; 30]];

    assert!(matches!(average(&short, RATE_HZ), Err(StrideError::TooShort { .. })));
    assert!(matches!(average(&[], RATE_HZ), Err(StrideError::TooShort { .. })));
}

/// A trial in which the robot walked otherwise must not blur the rest.
#[test]
fn a_trial_unlike_the_others_is_left_out() {
    let mut trials = trials(0.8, 0.02, gait);
    trials[3] = (0..540)
        .map(|step| {
            std::array::from_fn(|joint| (TAU * step as f64 / 48.0 * 0.31 + joint as f64 * joint as f64).sin())
        })
        .collect();

    let stride = average(&trials, RATE_HZ).unwrap();

    assert!((stride.period_s - 0.8).abs() < 0.01, "{}", stride.period_s);
    assert!(worst_error(&stride) < 0.03, "{}", worst_error(&stride));
    assert!(stride.left_out > 0);
}

fn worst_error_over(samples: &[Sample], period_s: f64, gait: impl Fn(usize, f64) -> f64) -> f64 {
    let error_at = |shift: f64| {
        let at = |row: usize| shift + row as f64 / RATE_HZ / period_s;
        let rows = samples.iter().enumerate();
        let errors = rows.flat_map(|(row, sample)| {
            let gait = &gait;
            sample.iter().enumerate().map(move |(joint, value)| (value - gait(joint, at(row))).abs())
        });
        errors.fold(0.0, f64::max)
    };
    (0..1000).map(|shift| error_at(f64::from(shift) / 1000.0)).fold(f64::INFINITY, f64::min)
}

/// 4 s are 3.08 of these strides: the ends do not meet.
#[test]
fn a_window_over_trials_that_start_anywhere_averages_to_the_gait_behind_them() {
    let stride = window::average(&trials(1.3, 0.05, gait), RATE_HZ, window::PAPER_WINDOW_S).unwrap();

    assert_eq!((stride.samples.len(), stride.deviations.len()), (240, 240));
    assert!((stride.period_s - 4.0).abs() < 1e-9, "{}", stride.period_s);
    assert_eq!((stride.averaged, stride.left_out), (20, 0));
    let error = worst_error_over(&stride.samples, 1.3, gait);
    assert!(error < 0.04, "{error}");
    // Uniform noise of 0.05 has a deviation of 0.029.
    assert!(stride.spread.iter().all(|&s| (0.01..0.04).contains(&s)), "{:?}", stride.spread);
    assert!(stride.correlation > 0.98, "{}", stride.correlation);
}

/// Of motion without a stride only one place in a trial is alike.
#[test]
fn a_window_finds_the_one_place_in_which_trials_are_alike() {
    // Its rate grows all the time, so that it never repeats.
    let chirp = |joint: usize, time_s: f64| 0.5 * (2.0 * time_s + 0.3 * time_s * time_s + joint as f64).sin();
    let trials: Vec<Vec<Sample>> = (0..12)
        .map(|trial| {
            let late_s = f64::from(trial) / 10.0;
            (0..540)
                .map(|row| std::array::from_fn(|joint| chirp(joint, f64::from(row) / RATE_HZ - late_s)))
                .collect()
        })
        .collect();

    let stride = window::average(&trials, RATE_HZ, 3.0).unwrap();

    assert_eq!(stride.averaged, 12);
    assert!(stride.correlation > 0.999, "{}", stride.correlation);
    assert!(stride.spread.iter().all(|&s| s < 0.01), "{:?}", stride.spread);
}

#[test]
fn a_window_leaves_out_a_trial_unlike_the_others_and_refuses_them_if_most_are() {
    let mut trials = trials(0.8, 0.02, gait);
    let strange = |seed: usize| -> Vec<Sample> {
        let rate = 0.1 + 0.37 * seed as f64;
        (0..540)
            .map(|row| std::array::from_fn(|j| (row as f64 * rate + (j * j * seed) as f64).sin()))
            .collect()
    };
    trials[0] = strange(1);

    let stride = window::average(&trials, RATE_HZ, 4.0).unwrap();

    assert_eq!((stride.averaged, stride.left_out), (19, 1));
    for (seed, trial) in trials.iter_mut().enumerate().take(12) {
        *trial = strange(seed + 1);
    }
    let refused = window::average(&trials, RATE_HZ, 4.0);
    assert!(matches!(refused, Err(StrideError::WindowsUnlike { found: 20, .. })), "{refused:?}");
}

#[test]
fn a_window_that_cannot_be_moved_by_a_stride_is_refused() {
    let trials = trials(0.8, 0.02, gait);

    for window_s in [5.1, 0.1, f64::NAN] {
        let refused = window::average(&trials, RATE_HZ, window_s);
        assert!(matches!(refused, Err(StrideError::Window { .. })), "{refused:?}");
    }
    assert!(matches!(window::average(&[], RATE_HZ, 4.0), Err(StrideError::Window { .. })));
    let still = vec![vec![[0.1; JOINT_COUNT]; 540]; 3];
    assert!(matches!(window::average(&still, RATE_HZ, 4.0), Err(StrideError::Still { .. })));
}

/// Where the gait is surest, and where it is not.
#[test]
fn deviations_are_of_the_phase_in_which_strides_differ() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let trials: Vec<Vec<Sample>> = (0..20)
        .map(|_| {
            (0..540)
                .map(|row| {
                    let phase = f64::from(row % 60) / 60.0;
                    let noise = if phase < 0.5 { 0.2 * rng.random_range(-1.0..1.0) } else { 0.0 };
                    std::array::from_fn(|joint| gait(joint, phase) + noise)
                })
                .collect()
        })
        .collect();

    let stride = average(&trials, RATE_HZ).unwrap();

    let surely = |deviation: &&Sample| deviation.iter().all(|&d| d < 0.05);
    let sure = stride.deviations.iter().filter(surely).count();
    assert!((24..=34).contains(&sure), "{sure} of {}", stride.deviations.len());
}
