//! `host optimise`: short searches, what they leave, Ctrl-C, and bad flags.
#![cfg(feature = "train")]

mod host_command;

use host_command::host;
use serde_json::Value;
use std::path::Path;
use std::sync::OnceLock;

/// A search; what it prints as JSON, and what it says of it.
fn search(folder: &Path, out: &str, more: &[&str]) -> (Value, String) {
    let args = ["optimise", "--draws", "8", "--seed", "3", "--out", out, "--json"];
    let output = host(folder, &[&args[..], more].concat()).assert().success();
    let said = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    (serde_json::from_slice(&output.get_output().stdout).unwrap(), said)
}

/// The least search there is, in folder `first`: several tests look at it.
fn first() -> &'static (tempfile::TempDir, Value, String) {
    static FIRST: OnceLock<(tempfile::TempDir, Value, String)> = OnceLock::new();
    FIRST.get_or_init(|| {
        let desk = tempfile::tempdir().unwrap();
        let (found, said) = search(desk.path(), "first", &["--budget", "100"]);
        (desk, found, said)
    })
}

#[track_caller]
fn refused(folder: &Path, code: i32, args: &[&str]) -> String {
    host_command::refused(folder, code, &[&["optimise"], args].concat())
}

#[test]
fn a_search_leaves_a_gait_that_a_robot_can_play_and_says_what_is_known_of_it() {
    let (desk, found, said) = first();

    for figure in [
        "wall_s",
        "period_s",
        "cost_of_transport_median",
        "cost_of_transport_p90",
        "speed_m_s_median",
        "speed_m_s_p10",
        "forward_m",
        "sideways_m",
        "yaw_deg_median",
        "setpoint_speed_max_rad_s",
        "servo_speed_rad_s",
        "slower_servos_share",
    ] {
        assert!(found[figure].as_f64().is_some_and(f64::is_finite), "{figure}: {found:#}");
    }
    assert_eq!((found["leg"].as_f64(), found["seed"].as_u64()), (Some(1.0), Some(3)));
    assert_eq!((&found["twin_spread_used"], &found["interrupted"]), (&true.into(), &false.into()));
    let evaluations = found["evaluations"].as_u64().unwrap();
    assert!((90..=110).contains(&evaluations), "{evaluations}");
    assert!(
        said.contains("of 100 trials, initialising: ") && said.contains("of 100 trials, validating: "),
        "{said}"
    );
    let (asked, servo) = (&found["setpoint_speed_max_rad_s"], &found["servo_speed_rad_s"]);
    assert!(asked.as_f64().unwrap() <= 0.9 * servo.as_f64().unwrap() + 1e-3, "{asked} of {servo}");
    // The books are of the fitted robot, the trials of robots about it.
    let (total, median) = (found["power"]["total_w"].as_f64(), found["power_w_median"].as_f64());
    assert!((total.unwrap() / median.unwrap() - 1.0).abs() < 0.15, "{total:?} beside {median:?}");

    for file in ["gait.toml", "gait.bin", "summary.json", "amplitudes.svg", "robot/robot.toml"] {
        assert!(desk.path().join("first").join(file).is_file(), "{file}");
    }
    let gait = std::fs::read_to_string(desk.path().join("first/gait.toml")).unwrap();
    assert!(gait.contains("source = \"searched\"") && gait.contains("seed = 3"), "{gait}");
    let args = ["simulate", "first/gait.toml", "--duration", "3", "--starts", "2", "--json"];
    let simulated = host(desk.path(), &args).assert().success();
    let simulated: Value = serde_json::from_slice(&simulated.get_output().stdout).unwrap();
    assert_eq!(simulated["amplitude"].as_f64(), Some(1.0), "as it was searched");
}

#[test]
fn the_same_seed_and_budget_find_the_same_gait() {
    let (_, once, _) = first();
    let desk = tempfile::tempdir().unwrap();

    let (again, _) = search(desk.path(), "again", &["--budget", "100"]);

    assert_eq!(once["gait_sha256"], again["gait_sha256"]);
    assert_eq!(once["over_draws"], again["over_draws"]);
}

#[test]
fn the_fastest_gait_begun_at_a_good_one_is_about_as_fast_as_that() {
    let desk = tempfile::tempdir().unwrap();
    // A search as short as this one finds nothing so fast by itself: 0.16 to 0.2 m/s.
    let start = concat!(env!("CARGO_MANIFEST_DIR"), "/gaits/ant-1L/searched.toml");
    let walked = host(desk.path(), &["simulate", start, "--duration", "5", "--json"]).assert().success();
    let walked: Value = serde_json::from_slice(&walked.get_output().stdout).unwrap();

    let more = ["--budget", "100", "--objective", "speed", "--start", start, "--start-amp", "1"];
    let (fast, _) = search(desk.path(), "fast", &more);

    assert!(fast["min_speed_m_s"].is_null());
    let (found, before) = (fast["speed_m_s_median"].as_f64(), walked["speed_m_s"]["mean"].as_f64());
    // On other robots, and turning less may be worth some speed; hence the margin.
    assert!(found.unwrap() >= 0.8 * before.unwrap(), "{found:?} after {before:?}");
}

#[test]
fn another_robot_is_searched_like_the_ant_and_what_no_fit_says_of_it_is_said() {
    let desk = tempfile::tempdir().unwrap();
    let pony = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/pony");

    let args = ["optimise", "--robot", pony, "--budget", "100", "--draws", "8", "--start", "nothing"];
    let output = host(desk.path(), &[&args[..], &["--min-speed", "2"]].concat()).assert().success();

    let warned = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
    assert!(warned.contains("slower than the 2 m/s that were asked for"), "{warned}");
    let said = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    assert!(said.contains("no [twin.spread] in robot.toml"), "{said}");
    let runs: Vec<_> = std::fs::read_dir(desk.path().join("runs")).unwrap().flatten().collect();
    // Not even the link to the last trained run.
    assert_eq!(runs.len(), 1, "{runs:?}");
    let summary = std::fs::read_to_string(runs[0].path().join("summary.json")).unwrap();
    let found: Value = serde_json::from_str(&summary).unwrap();
    assert_eq!(found["twin_spread_used"], false);
    assert_eq!(found["min_speed_m_s"].as_f64(), Some(2.0));
    assert!(found["cost_of_transport_median"].as_f64().is_some(), "{summary}");
    assert!(std::fs::read_to_string(runs[0].path().join("robot/robot.toml")).unwrap().contains("Pony"));
}

/// The least budget of a front: each of its steps searches.
#[test]
fn a_front_has_gaits_that_no_other_beats_beside_what_was_measured() {
    let desk = tempfile::tempdir().unwrap();

    let (found, said) = search(desk.path(), "front", &["--objective", "pareto", "--budget", LEAST_FRONT]);

    assert!(said.contains("0.20 m/s, 1 of 7: ") && said.contains("0.50 m/s, 7 of 7: "), "{said}");
    let front = found["front"].as_array().unwrap();
    let dropped = found["front_dropped"].as_u64().unwrap();
    assert!(!front.is_empty() && front.len() as u64 + dropped <= 8, "{found:#}");
    let mut before = (0.0, 0.0);
    for point in front {
        let median = |of: &str| point["over_draws"][of]["median"].as_f64().unwrap();
        let now = (median("speed_m_s"), median("cost_of_transport"));
        assert!(now.0 > before.0 && now.1 > before.1, "{now:?} after {before:?}");
        before = now;
        let gait = std::fs::read_to_string(desk.path().join(point["gait"].as_str().unwrap())).unwrap();
        assert!(gait.contains(&format!("name = {}", point["name"])), "{gait}");
        assert!(gait.contains("seed = 3") && gait.contains("--objective pareto"), "{gait}");
        assert_eq!(gait.contains("safe_amplitudes"), !point["safe_amplitudes"].is_null(), "{gait}");
    }
    for key in ["name", "gait", "gait_sha256"] {
        let all: std::collections::HashSet<_> = front.iter().map(|point| point[key].to_string()).collect();
        assert_eq!(all.len(), front.len(), "two have the same {key}: {front:#?}");
    }
    let picture = std::fs::read_to_string(desk.path().join("front/front.svg")).unwrap();
    assert!(picture.contains("measured by the authors"));
    let table = std::fs::read_to_string(desk.path().join("front/front.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + front.len(), "{table}");
}

const LEAST_FRONT: &str = "500";

#[test]
fn bad_flags_name_the_value_and_what_is_allowed() {
    let desk = tempfile::tempdir().unwrap();
    let below = (LEAST_FRONT.parse::<u32>().unwrap() - 1).to_string();

    let budget = refused(desk.path(), 2, &["--budget", "10"]);
    let speed = refused(desk.path(), 2, &["--min-speed", "9"]);
    let amplitude = refused(desk.path(), 2, &["--start", "a", "--start-amp", "NaN"]);
    let start = refused(desk.path(), 3, &["--start", "nowhere.toml"]);
    let leg = refused(desk.path(), 2, &["--leg", "7"]);
    let draws = refused(desk.path(), 2, &["--draws", "1"]);
    let no_speed = refused(desk.path(), 2, &["--objective", "speed", "--min-speed", "0.2"]);
    let no_stroke = refused(desk.path(), 2, &["--start", "nothing", "--start-amp", "1"]);
    let front = refused(desk.path(), 2, &["--objective", "pareto", "--budget", &below]);

    assert!(budget.contains("\"10\" is not a valid budget") && budget.contains("10m"), "{budget}");
    assert!(speed.contains("--min-speed is 9; it must be within 0.02 to 2 m/s"), "{speed}");
    assert!(amplitude.contains("--start-amp is NaN"), "{amplitude}");
    assert!(start.contains("cannot read nowhere.toml") && start.contains("sinusoid"), "{start}");
    assert!(leg.contains("leg_scale"), "{leg}");
    assert!(draws.contains("8..=1000"), "{draws}");
    assert!(no_speed.contains("--min-speed is for --objective cot and pareto"), "{no_speed}");
    assert!(no_stroke.contains("--start nothing has no amplitude"), "{no_stroke}");
    let least = format!("--budget is {below} trials; a front needs at least {LEAST_FRONT} (10s)");
    assert!(front.contains(&least), "{front}");
    assert_eq!(std::fs::read_dir(desk.path()).unwrap().count(), 0, "nothing is left behind");
}

#[test]
fn beyond_the_amplitudes_that_a_searched_gait_declares_is_a_warning() {
    let desk = tempfile::tempdir().unwrap();
    let gait = concat!(env!("CARGO_MANIFEST_DIR"), "/gaits/ant-1L/searched.toml");
    let said = |amplitude: &[&str]| {
        let args = ["simulate", gait, "--duration", "1", "--starts", "1"];
        let output = host(desk.path(), &[&args[..], amplitude].concat()).assert().success();
        String::from_utf8_lossy(&output.get_output().stderr).into_owned()
    };

    assert!(said(&["--amp", "1.2"]).contains("found safe at amplitudes 0.5 to 1; at 1.2"));
    assert!(!said(&[]).contains("found safe"));
}

#[cfg(unix)]
mod interrupted {
    use super::*;
    use nix::sys::signal::{Signal, kill};
    use nix::unistd::Pid;
    use std::io::{BufRead as _, BufReader, Read as _};
    use std::process::Stdio;

    /// Ctrl-C once a line of standard error contains `sign`; what it says after that.
    fn interrupted_at(sign: &str, folder: &Path, args: &[&str]) -> (Value, String) {
        let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin("host"))
            .current_dir(folder)
            .envs([("NO_COLOR", "1"), ("COLUMNS", "400")])
            .args([&["optimise", "--json", "--out", "run"], args].concat())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut stderr = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        while !line.contains(sign) {
            line.clear();
            assert!(stderr.read_line(&mut line).unwrap() > 0, "it ended before {sign:?}");
        }

        kill(Pid::from_raw(child.id() as i32), Signal::SIGINT).unwrap();

        let mut said = String::new();
        stderr.read_to_string(&mut said).unwrap();
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{said}");
        (serde_json::from_slice(&output.stdout).unwrap(), said)
    }

    fn plays(folder: &Path) {
        let args = ["simulate", "run/gait.toml", "--duration", "1", "--starts", "1"];
        host(folder, &args).assert().success();
    }

    #[test]
    fn a_search_that_is_interrupted_leaves_the_best_gait_so_far() {
        let desk = tempfile::tempdir().unwrap();

        let (found, said) = interrupted_at("initialising", desk.path(), &["--budget", "1h"]);

        assert!(said.contains("interrupted after") && said.contains("run/gait.toml"), "{said}");
        assert_eq!(found["interrupted"], true);
        assert!(found["evaluations"].as_u64().unwrap() < 2000, "{}", found["evaluations"]);
        assert!(found["safe_amplitudes"].is_null());
        plays(desk.path());
    }

    #[test]
    fn a_report_that_is_interrupted_ends_with_the_robots_that_it_has() {
        let desk = tempfile::tempdir().unwrap();

        let args = ["--budget", "100", "--draws", "1000"];
        let (found, said) = interrupted_at("testing the gait on 1000 robots", desk.path(), &args);

        assert!(said.contains("interrupted while the report was made"), "{said}");
        assert_eq!(found["interrupted"], true);
        let draws = found["over_draws"]["draws"].as_u64().unwrap();
        assert!((8..1000).contains(&draws), "{draws}");
        plays(desk.path());
    }
}
