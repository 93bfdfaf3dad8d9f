use super::*;

fn track(text: &str) -> Result<Track, TrackerError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("track");
    std::fs::write(&path, text).unwrap();
    Track::load(&path)
}

const UNIX: f64 = 1_700_000_000.0;
/// Of legs of 0.4 m: 4 m/s.
const TOP: TopSpeed = TopSpeed::of_legs(0.4);

/// 0.1 m/s along x and 0.2 m/s along y, every 0.1 s for `seconds`.
fn json_lines(seconds: usize) -> String {
    (0..=seconds * 10)
        .map(|i| {
            let t = i as f64 / 10.0;
            format!(
                "{{\"unix_time_s\": {}, \"x_m\": {}, \"y_m\": {}, \"z_m\": 0.1, \"true_energy_j\": {}}}\n",
                UNIX + t,
                0.1 * t,
                0.2 * t,
                0.8 * t
            )
        })
        .collect()
}

/// From 1.05 s to 11.05 s: 1 m along x and 2 m along y, sqrt(5) m; 8 J.
#[test]
fn the_displacement_is_interpolated_at_both_ends_of_the_trial() {
    let walked = track(&json_lines(20)).unwrap().walked(UNIX + 1.05, UNIX + 11.05, TOP).unwrap();

    assert!((walked.distance_m - 5.0_f64.sqrt()).abs() < 1e-6, "{walked:?}");
    assert!((walked.true_energy_j.unwrap() - 8.0).abs() < 1e-6);
    assert_eq!(walked.max_tilt_rad, None);
}

#[test]
fn a_csv_without_unix_time_starts_with_the_trial() {
    let track = track("time_s,x_m,y_m,marker\n-0.2,9,9,a\n0,1,0,a\n0.4,1,0.3,a\n0.8,1,0.6,b\n").unwrap();

    let walked = track.walked(UNIX, UNIX + 0.6, TOP).unwrap();

    assert_eq!(track.epoch(), Epoch::TrialStart);
    assert!((walked.distance_m - 0.45).abs() < 1e-6, "{walked:?}");
    assert_eq!(walked.true_energy_j, None);
}

#[test]
fn a_trial_beyond_the_recording_is_refused_with_both_intervals() {
    let message =
        track(&json_lines(5)).unwrap().walked(UNIX + 1.0, UNIX + 13.0, TOP).unwrap_err().to_string();

    assert!(message.contains("it has 1700000000.000 to 1700000005.000 s"), "{message}");
    assert!(message.contains("the trial is 1700000001.000 to 1700000013.000 s"), "{message}");
}

#[test]
fn a_gap_at_an_end_of_the_trial_is_refused() {
    let track = track("time_s,x_m,y_m\n0,0,0\n0.1,0,0\n2,0,1\n2.1,0,1\n").unwrap();

    let message = track.walked(UNIX, UNIX + 1.0, TOP).unwrap_err().to_string();

    assert!(message.contains("no position from 0.100 to 2.000 s"), "{message}");
    assert!(track.walked(UNIX, UNIX + 2.05, TOP).is_ok());
}

#[test]
fn an_unfinished_last_line_is_left_to_its_writer() {
    let mut text = json_lines(2);
    text.push_str("{\"unix_time_s\": 17000");

    assert_eq!(track(&text).unwrap().points.len(), 21);
}

#[test]
fn damage_is_named_with_its_line() {
    let cases = [
        ("time_s,x_m\n0,1\n", "has no column y_m; its columns are time_s, x_m"),
        ("time_s,x_m,y_m\n0,1,2\n1,lost,2\n", "line 3: \"1,lost,2\""),
        ("time_s,x_m,y_m\n0,1,2\n-1,1,2\n", "line 3: time goes back from 0 to -1"),
        ("time_s,x_m,y_m\n", "holds no positions"),
        ("{\"unix_time_s\": 1, \"x_m\": 2}\n{}\n", "line 1: "),
    ];
    for (text, expected) in cases {
        let message = track(text).unwrap_err().to_string();

        assert!(message.contains(expected), "{text:?}: {message}");
    }
}
