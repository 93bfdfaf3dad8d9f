//! Bad input without a robot: exit codes, and messages that name value, limit
//! and next move.
//!
//! Beyond 300 lines: one short test a kind of bad input, all at the same desk.

mod host_command;

use assert_cmd::Command;
use host_command::unwrapped;
use predicates::str::contains;
use std::path::{Path, PathBuf};

/// A folder with a fitted gait, and commands that run in it.
struct Desk {
    folder: tempfile::TempDir,
}

impl Desk {
    fn new() -> Self {
        let desk = Self { folder: tempfile::tempdir().unwrap() };
        desk.write("walk.csv", &recording("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4", 30));
        desk.host(&["fit", "walk.csv", "--out", "gait.toml", "--leg", "1.0"]).assert().success();
        desk
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).unwrap();
    }

    fn host(&self, args: &[&str]) -> Command {
        host_command::host(self.folder.path(), args)
    }

    /// Runs and expects the exit code; returns standard error without line breaks.
    #[track_caller]
    fn fails(&self, code: i32, args: &[&str]) -> String {
        host_command::refused(self.folder.path(), code, args)
    }
}

/// One stride of `rows` rows at 60 Hz, every joint a little different.
fn recording(header: &str, rows: usize) -> String {
    let columns = header.split(',').count();
    let row = |i: usize| {
        let angle = |joint: usize| std::f64::consts::TAU * i as f64 / rows as f64 + joint as f64;
        let joints = (1..columns).map(|joint| format!(",{:.6}", 0.3 * angle(joint).sin()));
        format!("{:.6}{}\n", i as f64 / 60.0, joints.collect::<String>())
    };
    format!("{header}\n{}", (0..rows).map(row).collect::<String>())
}

/// The recording with another value on a line (from 1) in a column (from 0).
fn with_field(text: &str, line: usize, column: usize, value: &str) -> String {
    let change = |(i, row): (usize, &str)| {
        let mut fields: Vec<&str> = row.split(',').collect();
        if i + 1 == line {
            fields[column] = value;
        }
        format!("{}\n", fields.join(","))
    };
    text.lines().enumerate().map(change).collect()
}

#[test]
fn a_stride_becomes_a_gait_with_its_bytes_beside_it() {
    let desk = Desk::new();

    let assert =
        desk.host(&["fit", "walk.csv", "--out", "again.toml", "--leg", "1.0", "--json"]).assert().success();

    let result: serde_json::Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert_eq!(result["period_s"].as_f64().map(|s| (s * 1e4).round()), Some(5000.0));
    assert_eq!(result["gait_source"], "fitted");
    assert_eq!(result["joints"].as_array().unwrap().len(), 8);
    assert_eq!(std::fs::read(desk.path("again.bin")).unwrap(), std::fs::read(desk.path("gait.bin")).unwrap());
}

#[test]
fn a_stretched_gait_plays_slower_than_it_was_recorded() {
    let desk = Desk::new();

    let assert = desk
        .host(&[
            "fit",
            "walk.csv",
            "--rows",
            "0..30",
            "--period",
            "0.45",
            "--time-stretch",
            "6",
            "--out",
            "slow.toml",
            "--json",
        ])
        .assert()
        .success();

    let result: serde_json::Value = serde_json::from_slice(&assert.get_output().stdout).unwrap();
    assert!((result["period_s"].as_f64().unwrap() - 2.7).abs() < 1e-9);
}

#[test]
fn a_curve_that_does_not_follow_is_warned_of() {
    let desk = Desk::new();
    let rows: String = (0..60)
        .map(|i| {
            let phase = std::f64::consts::TAU * f64::from(i) / 60.0;
            // The curve follows the slow part only: a fifth of the motion.
            let fast = (9.0 * phase).sin() + 0.5 * phase.sin();
            format!("{},{fast},{fast},{fast},{fast},{fast},{fast},{fast},{fast}\n", f64::from(i) / 60.0)
        })
        .collect();
    desk.write("fast.csv", &format!("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4\n{rows}"));

    let assert = desk.host(&["fit", "fast.csv", "--lag", "--out", "fast.toml"]).assert().success();

    assert!(unwrapped(&assert.get_output().stderr).contains("warning: R2 is below 0.8 of hip1 (0."));
}

#[test]
fn bad_recordings_are_refused_with_line_and_column() {
    let desk = Desk::new();
    let header = "time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4";
    let good = recording(header, 30);
    desk.write("nan.csv", &with_field(&good, 3, 1, "NaN"));
    desk.write("inf.csv", &with_field(&good, 2, 8, "-inf"));
    desk.write("long.csv", &with_field(&good, 2, 8, "0.1,0.2"));
    desk.write("seven.csv", &recording("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3", 30));
    desk.write("twice.csv", &recording("time_s,hip1,hip1,hip3,hip4,knee1,knee2,knee3,knee4", 30));
    desk.write("short.csv", &recording(header, 11));
    desk.write("empty.csv", "");
    let bare: String = good.lines().skip(1).map(|line| format!("{line}\n")).collect();
    desk.write("bare.csv", &bare);
    let cases = [
        ("absent.csv", "cannot read absent.csv"),
        ("nan.csv", "nan.csv, line 3: hip1 is \"NaN\", which is not a finite number"),
        ("inf.csv", "inf.csv, line 2: knee4 is \"-inf\", which is not a finite number"),
        ("long.csv", "long.csv, line 2: 10 values where there are 9 columns"),
        ("seven.csv", "seven.csv has 7 of 8 joints: knee4 missing"),
        ("twice.csv", "twice.csv has hip1 twice: columns 2 and 3"),
        ("short.csv", "the stride has 11 rows; a degree-10 curve and its residual need 12"),
        ("empty.csv", "empty.csv has no rows"),
        ("bare.csv", "bare.csv has no header"),
    ];
    for (file, expected) in cases {
        let message = desk.fails(3, &["fit", file, "--out", "out.toml"]);

        assert!(message.contains(expected), "{file}: {message}");
        assert!(!desk.path("out.toml").exists(), "{file}");
    }
}

#[test]
fn bad_rows_and_periods_are_refused_with_their_limits() {
    let desk = Desk::new();
    let cases: [(i32, &[&str], &str); 7] = [
        (2, &["--rows", "9..3"], "\"9..3\" is not a range of rows: write A..B with A below B"),
        (3, &["--rows", "20..50"], "rows 20..50 are not in the file, which has rows 0..30"),
        (3, &["--period", "0.01"], "a robot plays 0.1 to 60 s"),
        (3, &["--time-stretch", "500"], "the stride would last 250.000 s (0.500 s recorded, times 500)"),
        (2, &["--period", "nan"], "--period is NaN; it must be within"),
        (2, &["--limit-deg", "120"], "--limit-deg is 120; it must be within 1 to 90"),
        (2, &["--negate", "tail"], "\"tail\" is not a joint"),
    ];
    for (code, flags, expected) in cases {
        let message = desk.fails(code, &[&["fit", "walk.csv", "--out", "out.toml"], flags].concat());

        assert!(message.contains(expected), "{flags:?}: {message}");
    }
}

#[test]
fn without_time_and_period_the_duration_is_asked_for() {
    let desk = Desk::new();
    let stripped: String = recording("time_s,hip1,hip2,hip3,hip4,knee1,knee2,knee3,knee4", 30)
        .lines()
        .map(|line| format!("{}\n", line.split_once(',').unwrap().1))
        .collect();
    desk.write("untimed.csv", &stripped);

    let message = desk.fails(2, &["fit", "untimed.csv", "--rows", "all"]);

    assert!(message.contains("has no time_s column"), "{message}");
    assert!(message.contains("--period S gives the duration"), "{message}");
}

/// The shell lets no file grow at all; the signal for it is ignored, so the
/// write fails as on a full disk.
#[cfg(unix)]
#[test]
fn on_a_full_disk_the_old_gait_stays() {
    let desk = Desk::new();
    let before = std::fs::read(desk.path("gait.toml")).unwrap();
    desk.write("other.csv", &recording("time_s,hip4,hip3,hip2,hip1,knee1,knee2,knee3,knee4", 30));
    let host = assert_cmd::cargo::cargo_bin("host");

    let assert = Command::new("sh")
        .current_dir(desk.folder.path())
        .args(["-c", "trap '' XFSZ; ulimit -f 0; exec \"$0\" fit other.csv --rows all --out gait.toml"])
        .arg(host)
        .assert()
        .code(1)
        .stderr(contains("cannot write gait.bin"));

    let message = unwrapped(&assert.get_output().stderr);
    assert!(message.contains("the file that was there before, if any, is unharmed"), "{message}");
    assert_eq!(std::fs::read(desk.path("gait.toml")).unwrap(), before);
    let leftovers = std::fs::read_dir(desk.folder.path()).unwrap().count();
    assert_eq!(leftovers, 4, "walk.csv, other.csv, gait.toml, gait.bin and nothing half written");
}

#[test]
fn damaged_gaits_are_refused_before_any_port_is_opened() {
    let desk = Desk::new();
    let bytes = std::fs::read(desk.path("gait.bin")).unwrap();
    std::fs::write(desk.path("cut.bin"), &bytes[..100]).unwrap();
    let mut flipped = bytes.clone();
    flipped[70] ^= 1;
    std::fs::write(desk.path("flipped.bin"), flipped).unwrap();
    let text = std::fs::read_to_string(desk.path("gait.toml")).unwrap();
    desk.write("newer.toml", &text.replacen("version = 1", "version = 7", 1));
    desk.write("text.toml", "a gait, honestly");
    let cases = [
        ("absent.toml", "cannot read absent.toml"),
        ("cut.bin", "cut.bin is not a gait table, or is damaged (100 bytes): its checksum does not match"),
        ("flipped.bin", "its checksum does not match"),
        ("newer.toml", "its version is 7; this program reads version 1"),
        ("text.toml", "text.toml is not a gait file"),
    ];
    for (file, expected) in cases {
        let message =
            desk.fails(3, &["upload-gait", "--amp", "1.0", "--gait", file, "--port", "/dev/does-not-exist"]);

        assert!(message.contains(expected), "{file}: {message}");
        assert!(message.contains("help:"), "{file}: {message}");
    }
}

/// 0.3 of action is 7.2 degrees at 1.0x; with limits of 20 degrees that is 2.77x.
#[test]
fn a_gait_outside_its_limits_is_refused_with_what_fits() {
    let desk = Desk::new();
    desk.host(&["fit", "walk.csv", "--limit-deg", "20", "--out", "narrow.toml"]).assert().success();

    let message = desk
        .fails(3, &["upload-gait", "--amp", "2.9", "--gait", "narrow.toml", "--port", "/dev/does-not-exist"]);

    assert!(message.contains("at amplitude 2.9"), "{message}");
    assert!(message.contains("its limit is"), "{message}");
    assert!(message.contains("the largest amplitude that fits is 2.7"), "{message}");
    assert!(message.contains("--clip"), "{message}");
}

#[test]
fn amplitudes_beyond_the_robots_are_usage_errors() {
    let desk = Desk::new();
    for amplitude in ["0.4", "3.1", "nan", "-1"] {
        let flag = format!("--amp={amplitude}");
        let message = desk.fails(2, &["upload-gait", &flag, "--gait", "gait.toml"]);

        assert!(message.contains("it must be within 0.5 to 3"), "{amplitude}: {message}");
    }
}

#[test]
fn a_wrong_port_is_named_with_the_next_move() {
    let desk = Desk::new();
    let upload =
        |port: &str| desk.fails(4, &["upload-gait", "--amp", "1", "--gait", "gait.toml", "--port", port]);

    let absent = upload("/dev/does-not-exist");
    let file = upload(desk.path("gait.toml").to_str().unwrap());

    assert!(absent.contains("cannot open /dev/does-not-exist"), "{absent}");
    assert!(absent.contains("ls /dev/ttyUSB*"), "{absent}");
    assert!(file.contains("is") && file.contains("a serial port?"), "{file}");
}

#[test]
fn a_distance_that_cannot_be_asked_for_is_missed_before_the_walk() {
    let desk = Desk::new();

    let message = desk.fails(2, &["measure", "--port", "/dev/does-not-exist"]);

    assert!(message.contains("standard input is not a terminal"), "{message}");
    assert!(message.contains("--distance M, or --tracker FILE"), "{message}");
}

#[test]
fn numbers_that_no_trial_has_are_usage_errors() {
    let desk = Desk::new();
    let cases: [&[&str]; 5] = [
        &["--duration", "0"],
        &["--duration", "nan"],
        &["--mass-kg", "0"],
        &["--amp", "5"],
        &["--distance", "-1"],
    ];
    for flags in cases {
        let args = [&["measure", "--port", "/dev/does-not-exist"], flags].concat();
        let message = desk.fails(2, &args);

        assert!(message.contains("it must be within"), "{flags:?}: {message}");
    }
}

#[test]
fn a_tracker_that_is_not_there_and_a_strange_table_are_found_before_the_walk() {
    let desk = Desk::new();
    desk.write("trials.csv", "my,own,table\n");

    let tracker = desk.fails(3, &["measure", "--port", "/dev/does-not-exist", "--tracker", "absent.csv"]);
    let table = desk.fails(3, &["measure", "--port", "/dev/does-not-exist", "--distance", "1", "--out", "."]);

    assert!(tracker.contains("cannot read absent.csv"), "{tracker}");
    assert!(table.contains("trials.csv has other columns: it begins with \"my,own,table\""), "{table}");
}

#[test]
fn the_help_tells_the_story_in_order() {
    let desk = Desk::new();
    let output = desk.host(&["--help"]).assert().success();
    let text = String::from_utf8_lossy(&output.get_output().stdout).into_owned();

    let places: Vec<_> =
        ["  fit", "  upload-gait", "  measure", "  demo"].map(|s| text.find(s).unwrap()).into();

    assert!(places.is_sorted(), "{text}");
    assert!(text.contains("Exit codes"), "{text}");
    assert!(Path::new(desk.folder.path()).exists());
}

/// The trial, the training or the fit is done by then: only the report is lost.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_output_is_an_error_after_the_files_are_written() {
    let desk = Desk::new();
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();

    let output = std::process::Command::new(assert_cmd::cargo::cargo_bin("host"))
        .current_dir(desk.folder.path())
        .args(["fit", "walk.csv", "--out", "again.toml", "--leg", "1.0"])
        .stdout(full)
        .output()
        .unwrap();

    let message = unwrapped(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("could not be written to standard output"), "{message}");
    assert!(desk.path("again.bin").is_file());
}

#[cfg(target_os = "linux")]
#[test]
fn a_path_that_is_not_utf_8_is_a_path() {
    use std::os::unix::ffi::OsStrExt as _;
    let desk = Desk::new();
    let odd = |name: &[u8]| std::ffi::OsStr::from_bytes(name).to_owned();
    std::fs::copy(desk.path("walk.csv"), desk.folder.path().join(odd(b"w\xFF.csv"))).unwrap();

    let mut fit = desk.host(&["fit", "--json", "--leg", "1.0"]);
    fit.arg(odd(b"w\xFF.csv")).arg("--out").arg(odd(b"g\xFF.toml"));

    fit.assert().success().stdout(contains("gait_sha256"));
    assert!(desk.folder.path().join(odd(b"g\xFF.bin")).is_file());
}

#[test]
fn a_seed_that_no_file_can_hold_is_refused_before_the_work() {
    let desk = Desk::new();

    let message = desk.fails(2, &["fit", "walk.csv", "--seed", "9223372036854775808"]);

    assert!(message.contains("9223372036854775808 is not in 0..=9223372036854775807"), "{message}");
}

/// Each of these steps comes after the training.
#[test]
fn the_demo_refuses_what_its_last_steps_would_before_it_trains() {
    let desk = Desk::new();

    let amplitude = desk.fails(2, &["demo", "--amp", "9"]);
    let duration = desk.fails(2, &["demo", "--duration", "1e9"]);
    let robot = desk.fails(1, &["demo", "--virtual-robot", "nowhere"]);

    assert!(amplitude.contains("--amp is 9; it must be within 0.5 to 3"), "{amplitude}");
    assert!(duration.contains("--duration is 1000000000; it must be within 0.1 to 3600"), "{duration}");
    assert!(robot.contains("there is no virtual robot at nowhere"), "{robot}");
    assert!(!desk.path("runs").exists());
}

#[test]
fn a_gait_remembers_the_leg_of_the_robot_beside_its_recording() {
    let desk = Desk::new();
    host::robot::Robot::ant(host::robot::LegScale::SHORT)
        .unwrap()
        .save(&desk.path(host::run_folder::ROBOT))
        .unwrap();

    desk.host(&["fit", "walk.csv", "--time-stretch", "3", "--out", "short.toml"])
        .assert()
        .success()
        .stdout(contains("Next: cargo run -p host -- upload-gait --amp 2.2 --gait short.toml"));

    let gait = host::gait::gait_file::GaitFile::load(&desk.path("short.toml")).unwrap();
    assert_eq!(gait.provenance.leg_scale, Some(host::robot::LegScale::SHORT));
}
