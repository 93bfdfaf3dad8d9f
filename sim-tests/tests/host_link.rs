//! Host and virtual robot as separate processes, a pseudo-terminal between
//! them, in real time: fit, upload, measure, with a reset at each opening.
//!
//! A missing firmware image fails these tests and says how to build one. The authors'
//! trajectory is not ours to publish: where it is absent, a synthetic loop in
//! the same format takes its place, and the output says so. Longer than most files:
//! the tests share the processes that they start.

// `host_stream` uses the rest of it.
#[allow(dead_code)]
mod processes;

use host::gait::gait_file::GaitFile;
use processes::{RobotProcess, Sample, finish, host, host_json, host_outcome, measure_patiently, start_host};
use protocol::JOINT_COUNT;
use sim_tests::fixtures;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

const AMPLITUDE: f64 = 2.2;
/// Half a count of rounding plus what the protocol proves of its setpoints.
const HALF_COUNT: f64 = 0.5;
const SETPOINT_ERROR_DEG: f64 = 0.05;
/// The firmware's default calibration: 5/3 counts a degree about 330.
const COUNTS_PER_DEG: f64 = 5.0 / 3.0;
const NEUTRAL_COUNTS: f64 = 330.0;
const FRAME_S: f64 = 1.0 / 60.0;

/// The published trajectory beside this checkout, if it is there.
fn authors_trajectory() -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/ant-trajectory.csv");
    path.exists().then_some(path)
}

/// 1000 rows with the authors' columns, the last 27 two strides of a trot.
fn synthetic_trajectory(folder: &Path) -> PathBuf {
    let columns = ["hip4", "ank4", "hip1", "ank1", "hip2", "ank2", "hip3", "ank3"];
    let mut text = columns.join(",");
    for row in 0..1000 {
        text.push('\n');
        let phase = 2.0 * f64::from(row - 973) / 27.0;
        for (i, column) in columns.iter().enumerate() {
            let leg = u32::from(column.as_bytes()[3] - b'0');
            let shift = if leg.is_multiple_of(2) { 0.5 } else { 0.0 };
            let wave = if column.starts_with("hip") { 0.30 } else { 0.20 } * (TAU * (phase + shift)).sin();
            let _ = write!(text, "{}{wave:.6}", if i == 0 { "" } else { "," });
        }
    }
    let path = folder.join("synthetic-trajectory.csv");
    std::fs::write(&path, text).unwrap();
    path
}

/// Fits two strides, played over 2.7 s, as the authors' robot did.
fn fit(folder: &Path) -> (PathBuf, GaitFile) {
    let trajectory = authors_trajectory();
    let said = match trajectory {
        Some(_) => "fitting the authors' own loop",
        None => "SKIPPED the authors' loop: it is not there; fitting a synthetic one instead",
    };
    // Not `println`: the test harness would keep it to itself while tests pass.
    let _ = writeln!(std::io::stderr(), "{said}");
    let trajectory = trajectory.unwrap_or_else(|| synthetic_trajectory(folder));
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("../host/configs/authors-map.toml");
    let out = folder.join("gait.toml");
    let rows = ["--rows", "973..1000", "--period", "0.45", "--time-stretch", "6", "--name", "authors"];
    let seam = ["--seam", "free"];
    let mut arguments = vec!["fit", trajectory.to_str().unwrap(), "--map", map.to_str().unwrap()];
    arguments.extend(rows);
    arguments.extend(seam);
    arguments.extend(["--out", out.to_str().unwrap()]);
    host(folder, &arguments);
    let gait = GaitFile::load(&out).unwrap();
    (out, gait)
}

/// The f64 reference: the series by its definition, within the limits, in counts.
fn reference_counts(gait: &GaitFile, amplitude: f64, phase: f64) -> [f64; JOINT_COUNT] {
    std::array::from_fn(|joint| {
        let series = &gait.joints[joint];
        let deviation_deg = fixtures::evaluate(&series.coefficients_deg, phase);
        let asked_deg = series.centre_deg + amplitude * deviation_deg;
        NEUTRAL_COUNTS + COUNTS_PER_DEG * asked_deg.clamp(series.min_deg, series.max_deg)
    })
}

/// What a frame of the walk may be: one set of counts, but two where the
/// stride's ends meet. A curve fitted as in the paper jumps there, and which
/// side a phase within the robot's 1/65536 lies on is rounding.
fn references(gait: &GaitFile, amplitude: f64, frame: usize) -> Vec<[f64; JOINT_COUNT]> {
    const PHASE_STEP: f64 = 1.0 / 65_536.0;
    let strides = frame as f64 * FRAME_S / gait.period_s;
    let phases = if (strides - strides.round()).abs() < PHASE_STEP && frame > 0 {
        vec![0.0, 1.0 - PHASE_STEP]
    } else {
        vec![strides.fract()]
    };
    phases.into_iter().map(|phase| reference_counts(gait, amplitude, phase)).collect()
}

/// Degrees by which a burst misses the reference beyond half a count.
fn miss_deg(counts: &[f64; JOINT_COUNT], references: &[[f64; JOINT_COUNT]]) -> f64 {
    let miss = |(a, b): (&f64, &f64)| ((a - b).abs() - HALF_COUNT) / COUNTS_PER_DEG;
    let misses =
        references.iter().map(|reference| counts.iter().zip(reference).map(miss).fold(f64::MIN, f64::max));
    misses.fold(f64::MAX, f64::min)
}

/// Where in `pulses` a walk of `frames` frames from phase 0 begins.
fn find_walk(pulses: &[(f64, [f64; JOINT_COUNT])], gait: &GaitFile, amplitude: f64, frames: usize) -> usize {
    let reference: Vec<_> = (0..frames).map(|frame| references(gait, amplitude, frame)).collect();
    let matches = |first: usize| {
        pulses.len() >= first + frames
            && pulses[first..]
                .iter()
                .zip(&reference)
                .all(|((_, counts), expected)| miss_deg(counts, expected) <= SETPOINT_ERROR_DEG)
    };
    let found = (0..pulses.len()).rev().find(|&first| matches(first));
    found.unwrap_or_else(|| {
        // Which offset comes closest, and where it fails, is the first question.
        let worst = |first: usize| {
            let misses = pulses[first..].iter().zip(&reference).map(|((_, counts), r)| miss_deg(counts, r));
            misses.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, f64::MAX))
        };
        let closest = (0..=pulses.len().saturating_sub(frames))
            .map(|first| (first, worst(first)))
            .min_by(|a, b| a.1.1.total_cmp(&b.1.1));
        let Some((first, (frame, miss))) = closest else { panic!("no burst at all") };
        panic!(
            "no {frames} of {} bursts follow the gait; closest from burst {first}: frame {frame} misses by {miss:.3} \
             degrees: {:?}, expected {:.1?}",
            pulses.len(), pulses[first + frame].1, reference[frame]
        )
    })
}

fn at(truth: &[Sample], time_s: f64) -> &Sample {
    &truth[truth.partition_point(|sample| sample.time_s < time_s).min(truth.len() - 1)]
}

/// The authors' loop through the whole chain.
#[test]
fn a_fitted_loop_uploaded_at_2_2_plays_within_half_a_count_and_0_05_degree_at_60_hertz() {
    let folder = tempfile::tempdir().unwrap();
    let (gait_path, gait) = fit(folder.path());
    let robot = RobotProcess::start(folder.path(), &[]);

    let uploaded = host_json(
        folder.path(),
        &[
            "upload-gait",
            "--gait",
            gait_path.to_str().unwrap(),
            "--amp",
            "2.2",
            "--clip",
            "--port",
            robot.port(),
        ],
    );
    assert_eq!(uploaded["saved"], true, "{uploaded}");
    // Opening the port again resets the robot: the gait comes out of its EEPROM.
    let measured =
        measure_patiently(folder.path(), &["--port", robot.port(), "--duration", "6", "--distance", "0.5"]);
    assert_eq!(measured["frames_played"], 360, "{measured}");

    let pulses = robot.pulses();
    let amplitude = uploaded["amplitude"].as_f64().unwrap();
    assert!((amplitude - AMPLITUDE).abs() < 1e-4);
    let first = find_walk(&pulses, &gait, amplitude, 360);
    let walk = &pulses[first..first + 360];
    let worst = walk
        .iter()
        .enumerate()
        .map(|(frame, (_, counts))| miss_deg(counts, &references(&gait, amplitude, frame)))
        .fold(f64::MIN, f64::max);
    let off_grid_us = walk
        .iter()
        .enumerate()
        .map(|(frame, (time_s, _))| (time_s - walk[0].0 - frame as f64 * FRAME_S).abs() * 1e6)
        .fold(0.0, f64::max);
    println!(
        "{} bursts, {:.1} loops: worst {worst:+.4} degrees beyond half a count, {off_grid_us:.1} us off 60 Hz",
        walk.len(),
        walk.len() as f64 * FRAME_S / gait.period_s
    );
    assert!(off_grid_us < 100.0);
}

/// What the host reports against the battery.
#[test]
fn reported_energy_over_12_s_is_within_2_per_cent_of_the_batterys_true_integral() {
    let folder = tempfile::tempdir().unwrap();
    let gait = fixtures::trot();
    let gait_path = folder.path().join("gait.toml");
    let file = GaitFile::from_table(&gait.table());
    file.save(&gait_path).unwrap();
    let robot = RobotProcess::start(folder.path(), &["--seed", "3"]);
    let truth_path = robot.truth_path();

    let upload =
        ["upload-gait", "--gait", gait_path.to_str().unwrap(), "--amp", "2.2", "--port", robot.port()];
    let uploaded = host_json(folder.path(), &upload);
    let measured = measure_patiently(
        folder.path(),
        &["--port", robot.port(), "--duration", "12", "--tracker", truth_path.to_str().unwrap()],
    );

    assert_eq!(measured["frames_played"], 720, "{measured}");
    let pulses = robot.pulses();
    let first = find_walk(&pulses, &file, uploaded["amplitude"].as_f64().unwrap(), 720);
    let truth = robot.truth();
    let (began_s, ended_s) = (pulses[first].0, pulses[first].0 + 720.0 * FRAME_S);
    let (began, ended) = (at(&truth, began_s), at(&truth, ended_s));
    let true_j = ended.true_energy_j - began.true_energy_j;
    let reported_j = measured["energy_j"].as_f64().unwrap();
    let error = reported_j / true_j - 1.0;
    let true_m = (ended.x_m - began.x_m).hypot(ended.y_m - began.y_m);
    let reported_m = measured["distance_m"].as_f64().unwrap();
    println!(
        "{reported_j:.3} J reported, {true_j:.3} J true, {:+.2} %; {reported_m:.3} m reported, {true_m:.3} m true",
        100.0 * error
    );
    assert!(error.abs() < 0.02, "{:.2} %", 100.0 * error);
    assert!((reported_m - true_m).abs() < 0.03 * true_m + 0.01, "{reported_m} m, {true_m} m");
}

/// `host`'s exit codes.
const NO_ROBOT: i32 = 4;
const ROBOT_REFUSED: i32 = 5;

/// A synthetic gait on disk.
fn trot_file(folder: &Path) -> PathBuf {
    let path = folder.join("gait.toml");
    GaitFile::from_table(&fixtures::trot().table()).save(&path).unwrap();
    path
}

/// Opens and closes the port as a program does that leaves DTR to the system.
fn lower_dtr(port: &str) {
    use nix::sys::termios::{ControlFlags, SetArg, tcgetattr, tcsetattr};
    let port = std::fs::OpenOptions::new().read(true).write(true).open(port).unwrap();
    let mut settings = tcgetattr(&port).unwrap();
    settings.control_flags.insert(ControlFlags::HUPCL);
    tcsetattr(&port, SetArg::TCSANOW, &settings).unwrap();
    // Long enough for the robot to see it.
    std::thread::sleep(std::time::Duration::from_millis(100));
}

#[test]
fn a_gait_in_ram_is_there_for_the_next_command_and_gone_after_a_reset_by_dtr() {
    for (arguments, after_reset) in [(&[][..], ROBOT_REFUSED), (&["--no-reset-on-open"][..], 0)] {
        let folder = tempfile::tempdir().unwrap();
        let gait = trot_file(folder.path());
        let robot = RobotProcess::start(folder.path(), arguments);
        let upload =
            ["upload-gait", "--gait", gait.to_str().unwrap(), "--amp", "1", "--ram", "--port", robot.port()];
        host(folder.path(), &upload);
        let measure = ["measure", "--port", robot.port(), "--duration", "1", "--distance", "0.1"];

        let (at_once, out, err) = host_outcome(folder.path(), &measure);
        lower_dtr(robot.port());
        let (then, _, _) = host_outcome(folder.path(), &measure);

        assert_eq!((at_once, then), (0, after_reset), "{arguments:?}\n{out}\n{err}");
    }
}

#[test]
fn the_eeprom_file_carries_a_gait_from_one_robot_process_to_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let gait = trot_file(folder.path());
    let robot = RobotProcess::start(folder.path(), &["--eeprom", "eeprom.bin"]);
    host(
        folder.path(),
        &["upload-gait", "--gait", gait.to_str().unwrap(), "--amp", "1", "--port", robot.port()],
    );
    drop(robot);

    let robot = RobotProcess::start(folder.path(), &["--eeprom", "eeprom.bin"]);
    let measure = ["--port", robot.port(), "--duration", "1", "--distance", "0.1"];
    let measured = measure_patiently(folder.path(), &measure);

    assert_eq!(measured["gait_name"], "trot", "{measured}");
}

#[test]
fn a_cable_pulled_in_mid_trial_is_a_clear_error_and_no_endless_wait() {
    let folder = tempfile::tempdir().unwrap();
    let gait = trot_file(folder.path());
    let robot = RobotProcess::start(folder.path(), &[]);
    host(
        folder.path(),
        &["upload-gait", "--gait", gait.to_str().unwrap(), "--amp", "1", "--port", robot.port()],
    );

    let trial = start_host(
        folder.path(),
        &["measure", "--port", robot.port(), "--duration", "12", "--distance", "1"],
    );
    robot.wait_until_walking();
    drop(robot);
    let (code, out, err) = finish(trial);

    assert_eq!(code, NO_ROBOT, "{out}\n{err}");
}

#[test]
fn a_host_that_claims_the_port_for_itself_releases_it_for_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let robot = RobotProcess::start(folder.path(), &[]);

    // Opened the way the host does; closing it must leave the port usable.
    for _ in 0..2 {
        let port = serialport::new(robot.port(), 115_200).open().expect("an exclusive opening");
        drop(port);
    }
}
