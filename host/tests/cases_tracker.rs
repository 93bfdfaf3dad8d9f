//! Trackers' files as other programs write them: what is read, and what is refused and why.

use host::device::tracker::top_speed::TopSpeed;
use host::device::tracker::{Epoch, Track, TrackerError, Walked};

/// Of legs of 0.4 m: 4 m/s.
const TOP: TopSpeed = TopSpeed::of_legs(0.4);

fn load(bytes: &[u8]) -> Result<Track, TrackerError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("track.csv");
    std::fs::write(&path, bytes).unwrap();
    Track::load(&path)
}

/// Over the first two seconds.
fn walked(text: &str) -> Result<Walked, TrackerError> {
    load(text.as_bytes())?.walked(0.0, 2.0, TOP)
}

/// Rows every 0.1 s for 3 s at 0.15 m/s, each position multiplied and changed.
fn rows(scale: f64, change: impl Fn(usize) -> Option<f64>) -> String {
    let row = |i: usize| {
        let x = change(i).unwrap_or(scale * 0.015 * i as f64);
        format!("{:.3},{x:.4},0.0000\n", i as f64 / 10.0)
    };
    (0..=30).map(row).collect()
}

fn csv(scale: f64) -> String {
    format!("time_s,x_m,y_m\n{}", rows(scale, |_| None))
}

#[track_caller]
fn is_read(text: &str) {
    let distance_m = walked(text).unwrap().distance_m;

    assert!((distance_m - 0.3).abs() < 1e-6, "{distance_m}: {text}");
}

#[track_caller]
fn is_refused(text: &str, because: &str) {
    let message = walked(text).unwrap_err().to_string();

    assert!(message.contains(because), "{message}");
    assert!(message.len() < 500, "{message}");
}

#[test]
fn separators_line_ends_and_encodings_of_spreadsheets_are_read() {
    let plain = csv(1.0);
    is_read(&plain);
    is_read(&plain.replace(',', ";").replace('.', ","));
    is_read(&plain.replace(',', ";"));
    is_read(&plain.replace(',', "\t"));
    is_read(&plain.replace('\n', "\r"));
    is_read(&plain.replace('\n', "\r\n"));
    is_read(&plain.replace('\n', ",\n"));
    is_read(&format!("\u{FEFF}{plain}"));
    let utf_16: Vec<u8> = format!("\u{FEFF}{plain}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert!(load(&utf_16).is_ok());
}

#[test]
fn units_in_the_names_of_columns_are_converted() {
    for (names, scale) in [
        ("Time_s,X_m,Y_m", 1.0),
        ("time_s,x_mm,y_mm", 1000.0),
        ("Time (s),X [cm],Y [cm]", 100.0),
        ("t,x_in,y_in", 1.0 / 0.0254),
    ] {
        let text = format!("{names}\n{}", rows(scale, |_| None));
        let distance_m = walked(&text).unwrap().distance_m;
        assert!((distance_m - 0.3).abs() < 1e-3, "{names}: {distance_m}");
    }
}

#[test]
fn rows_without_a_sighting_are_gaps() {
    for lost in [",", "NaN,NaN", "nan,nan", "null,null", "NA,NA"] {
        let text: String = csv(1.0)
            .lines()
            .enumerate()
            .map(|(i, line)| match line.split_once(',') {
                Some((time, _)) if (9..13).contains(&i) => format!("{time},{lost}\n"),
                _ => format!("{line}\n"),
            })
            .collect();
        is_read(&text);
    }
}

#[test]
fn positions_in_another_unit_are_too_fast_and_the_unit_is_named() {
    is_refused(&csv(1000.0), "are the positions in millimetres?");
    is_refused(&csv(100.0), "are the positions in centimetres?");
    is_refused(&csv(39.37), "are the positions in inches?");
}

#[test]
fn another_marker_at_an_end_or_for_good_is_refused_and_a_moment_in_between_is_not() {
    let track = |change: &dyn Fn(usize) -> Option<f64>| format!("time_s,x_m,y_m\n{}", rows(1.0, change));
    is_refused(&track(&|i| (i == 20).then_some(57.1)), "line 22: the position jumps 56.");
    is_refused(&track(&|i| (i == 0).then_some(57.1)), "line 3: the position jumps 57.");
    is_refused(&track(&|i| (i > 9).then_some(57.1)), "the position jumps");
    let moment = track(&|i| (i == 10).then_some(57.1));
    is_read(&moment);
    assert_eq!(walked(&moment).unwrap().jumps, 1);
}

#[test]
fn exports_and_columns_without_a_unit_are_refused_with_what_is_wanted() {
    for (text, program) in [
        ("Format Version,1.23,Take Name,Walk\n\n,Type,Rigid Body\n", "Motive (OptiTrack)"),
        ("NO_OF_FRAMES\t600\nNO_OF_CAMERAS\t8\n", "Qualisys Track Manager"),
        ("Trajectories\n100\n,,dog:A\nFrame,Sub Frame,X,Y,Z\n", "Vicon Nexus"),
        ("PathFileType\t4\t(X/Y/Z)\twalk.trc\n", "Cortex or OpenSim (TRC)"),
    ] {
        let error = walked(text).unwrap_err();
        assert!(error.to_string().contains(program), "{error}");
        for word in ["time_s", "x_m and y_m", "metres", "y points up"] {
            assert!(error.help().contains(word), "{}", error.help());
        }
    }
    is_refused("time_s,X,Y,Z\n0,1,2,3\n", "does not say in which unit column \"X\" is");
    is_refused(&csv(1.0).replace('.', ","), "are there decimal commas");
    let long = "a,".repeat(5000);
    is_refused(&format!("{long}\n1,2\n"), "has no column time_s");
    assert!(matches!(load(b"PK\x03\x04\0\0\x08\0"), Err(TrackerError::NotText { .. })));
}

#[test]
fn a_height_in_the_place_of_y_is_asked_about() {
    let row = |i: usize| format!("{:.3},0.0,0.112,{:.4}\n", i as f64 / 10.0, 0.015 * i as f64);
    let rows: String = (0..=30).map(row).collect();

    is_refused(&format!("time_s,x_m,y_m,z_m\n{rows}"), "does y point up");
}

#[test]
fn what_times_count_from_is_known_before_a_walk() {
    assert_eq!(load(csv(1.0).as_bytes()).unwrap().epoch(), Epoch::TrialStart);
    let unix = "time_s,x_m,y_m\n1700000000.0,0,0\n";
    assert_eq!(load(unix.as_bytes()).unwrap().epoch(), Epoch::Unix);
    is_refused("time_s,x_m,y_m\n1700000000000,0,0\n", "are its times in milliseconds?");
}
