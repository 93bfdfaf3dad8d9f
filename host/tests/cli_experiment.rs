//! `host experiment`: a small study, what it leaves, going on with it, and bad flags.
#![cfg(feature = "train")]

mod host_command;

use host_command::host;
use serde_json::Value;
use std::path::Path;

const STUDY: [&str; 12] = [
    "experiment",
    "--leg",
    "1",
    "--method",
    "psto",
    "--method",
    "searched",
    "--amp",
    "1.4,2.0",
    "--trials",
    "2",
    "--duration=3",
];

fn study(folder: &Path, out: &str, more: &[&str]) -> Value {
    let args = [&STUDY[..], &["--out", out, "--json"], more].concat();
    let output = host(folder, &args).assert().success();
    serde_json::from_slice(&output.get_output().stdout).unwrap()
}

#[track_caller]
fn refused(folder: &Path, code: i32, args: &[&str]) -> String {
    host_command::refused(folder, code, &[&["experiment"], args].concat())
}

fn trials(folder: &Path, out: &str) -> String {
    std::fs::read_to_string(folder.join(out).join("study-trials.csv")).unwrap()
}

#[test]
fn a_study_has_its_conditions_its_best_its_claims_and_its_report_and_is_the_same_again() {
    let desk = tempfile::tempdir().unwrap();

    let first = study(desk.path(), "first", &[]);

    let conditions = first["conditions"].as_array().unwrap();
    assert_eq!(conditions.len(), 4);
    for condition in conditions {
        assert_eq!((condition["n"].as_u64(), condition["falls"].as_u64()), (Some(2), Some(0)), "{condition}");
        for figure in ["speed_m_s", "power_w", "cost_of_transport"] {
            let Value::Object(of) = &condition[figure] else { panic!("{figure}: {condition}") };
            assert!(of["mean"].as_f64().unwrap() > 0.0 && of["ci95"].as_f64().unwrap() > 0.0, "{condition}");
        }
    }
    let psto = &first["best"][0];
    assert_eq!(
        (psto["method"].as_str(), psto["paper_cost_of_transport"].as_f64()),
        (Some("psto"), Some(0.595))
    );
    for claim in first["claims"].as_array().unwrap() {
        assert!(claim["text"].is_string() && claim["evidence"].is_string(), "{claim}");
        assert!(claim["holds"].is_boolean() || claim["holds"].is_null(), "{claim}");
    }
    assert_eq!(first["prepare_wall_s"].as_f64(), Some(0.0));
    assert!(first["wall_s"].as_f64().unwrap() > 0.0);
    for gait in first["gaits"].as_array().unwrap() {
        assert!(gait["gait"]["command"].as_str().unwrap().starts_with("host "), "{gait}");
        assert!(gait["gait"]["seed"].is_u64(), "{gait}");
    }
    let report = std::fs::read_to_string(desk.path().join("first/report.html")).unwrap();
    assert!(report.contains("0.595") && !report.contains("src=\"http"));
    for file in ["figure-6.svg", "figure-6.png", "figure-8.png", "table-2.svg", "results.json", "plan.json"] {
        assert!(desk.path().join("first").join(file).is_file(), "{file}");
    }

    let again = study(desk.path(), "second", &[]);
    assert_eq!(first["conditions"], again["conditions"]);
    assert_eq!(trials(desk.path(), "first"), trials(desk.path(), "second"));
    let other = study(desk.path(), "third", &["--seed", "1"]);
    assert_ne!(first["conditions"], other["conditions"]);
}

#[test]
fn a_study_goes_on_with_the_trials_that_are_missing_and_with_no_other_plan() {
    let desk = tempfile::tempdir().unwrap();
    let whole = study(desk.path(), "study", &[]);
    let all = trials(desk.path(), "study");
    // As if it had been interrupted after three trials.
    let begun: String = all.lines().take(4).map(|line| format!("{line}\n")).collect();
    std::fs::write(desk.path().join("study/study-trials.csv"), begun).unwrap();

    let again = study(desk.path(), "study", &[]);

    assert_eq!(trials(desk.path(), "study").lines().count(), all.lines().count());
    assert_eq!(whole["conditions"], again["conditions"]);
    let out = ["--out", "study", "--leg", "1", "--method", "psto", "--trials", "3"];
    assert!(refused(desk.path(), 2, &out).contains("its methods differ"));
    assert!(refused(desk.path(), 2, &out).contains("--out"));
    // What is refused changes nothing, and a study's own gaits are never replaced.
    let own = desk.path().join("study/gaits/ant-1L/psto.toml");
    let edited = std::fs::read_to_string(&own).unwrap().replace("centre_deg = ", "centre_deg = 0.0 # ");
    std::fs::write(&own, &edited).unwrap();
    let args = [&STUDY[1..], &["--out", "study"]].concat();
    assert!(refused(desk.path(), 2, &args).contains("its gaits differ"));
    assert_eq!(std::fs::read_to_string(&own).unwrap(), edited);
    std::fs::remove_dir_all(desk.path().join("study/gaits")).unwrap();
    std::fs::write(desk.path().join("study/study-trials.csv"), "method,leg\npsto,much\n").unwrap();
    let args = [&STUDY[1..], &["--out", "study"]].concat();
    assert!(refused(desk.path(), 3, &args).contains("not a table of a study's trials"));
}

#[test]
fn a_gait_of_ones_own_and_the_authors_tables_take_part() {
    let desk = tempfile::tempdir().unwrap();
    let gait = concat!(env!("CARGO_MANIFEST_DIR"), "/gaits/ant-1L/psto.toml");
    let mut tables = String::from("method,amplification,sample,hip1,hip2,hip3,hip4,ank1,ank2,ank3,ank4\n");
    for sample in 0..8 {
        let swing = [0, 30, 40, 30, 0, -30, -40, -30][sample];
        let [up, down] = [330 + swing, 330 - swing];
        tables += &format!("psto,1.4,{sample},{up},{down},{up},{down},{down},{up},{down},{up}\n");
    }
    std::fs::write(desk.path().join("tables.csv"), tables).unwrap();

    let args = ["--gait", gait, "--reference-tables", "tables.csv"];
    let found = study(desk.path(), "study", &args);

    let of = |method: &str, amplification: f64| {
        let conditions = found["conditions"].as_array().unwrap();
        let is = |c: &&Value| c["method"] == method && c["amplification"].as_f64() == Some(amplification);
        conditions.iter().find(is).unwrap().clone()
    };
    assert_eq!(of("yours", 1.4)["speed_m_s"], of("psto", 1.4)["speed_m_s"]);
    assert_eq!(of("authors-psto", 1.4)["trials"].as_u64(), Some(2));
    assert!(of("authors-psto", 2.0)["not_run"].is_string());
    let skipped = found["skipped"].to_string();
    assert!(!skipped.contains("--reference-tables") && skipped.contains("Figure 5"), "{skipped}");
}

#[test]
fn conditions_that_cannot_be_walked_are_not_run_and_bad_flags_say_what_to_do() {
    let desk = tempfile::tempdir().unwrap();
    let folder = desk.path();
    let wide = study(folder, "wide", &["--method", "original", "--robots-differ"]);
    assert!(wide["parameters"].to_string().contains("standard deviations"));

    let message = refused(folder, 2, &["--amp", "1.4,9"]);
    assert!(message.contains("--amp is 9") && message.contains("0.5 to 3"), "{message}");
    assert!(refused(folder, 2, &["--amp", "1.4,1.4"]).contains("twice"));
    assert!(refused(folder, 2, &["--duration", "0"]).contains("--duration is 0"));
    assert!(refused(folder, 2, &["--duration", "-1"]).contains("--duration is -1"));
    assert!(refused(folder, 2, &["--method", "authors-psto"]).contains("--reference-tables"));
    assert!(refused(folder, 2, &["--method", "yours"]).contains("--gait"));
    assert!(refused(folder, 2, &["--port", "nowhere", "--leg", "1"]).contains("--tracker"));
    assert!(refused(folder, 3, &["--leg", "0.8", "--out", "legs"]).contains("--retrain"));
    assert!(refused(folder, 3, &["--reference-tables", "nowhere.csv"]).contains("nowhere.csv"));
    assert!(refused(folder, 1, &["--on", "virtual-robot", "--virtual-robot", "nowhere"]).contains("nowhere"));
    let on_virtual = ["--on", "virtual-robot", "--robots-differ"];
    assert!(refused(folder, 2, &on_virtual).contains("--robots-differ is for the simulation"));
    assert!(refused(folder, 2, &["--effort", "0.5"]).contains("--retrain"));
}

#[test]
fn gaits_are_made_anew_with_a_share_of_the_effort_and_say_how() {
    let desk = tempfile::tempdir().unwrap();
    let args = [
        "experiment",
        "--out",
        "study",
        "--leg",
        "1",
        "--method",
        "sinusoid",
        "--amp",
        "1.8",
        "--trials",
        "1",
    ];
    let retrain = ["--duration", "2", "--retrain", "--effort", "0.02", "--seed", "5", "--json"];
    let made = || -> Value {
        let output = host(desk.path(), &[&args[..], &retrain].concat()).assert().success();
        serde_json::from_slice(&output.get_output().stdout).unwrap()
    };

    let first = made();
    let again = made();

    let gait = &first["gaits"][0]["gait"];
    assert_eq!((gait["method"].as_str(), gait["seed"].as_u64()), (Some("sinusoid"), Some(5)));
    assert!(gait["command"].as_str().unwrap().contains("host sinusoid --preset psto --seed 5"), "{gait}");
    assert!(gait["simulated_s"].as_f64().unwrap() > 100.0, "{gait}");
    assert!(first["prepare_wall_s"].as_f64().unwrap() > 0.0);
    // What is there is not made twice.
    assert_eq!(again["prepare_wall_s"], first["prepare_wall_s"]);
    let otherwise =
        [&args[1..], &["--duration", "2", "--retrain", "--effort", "0.03", "--seed", "5"]].concat();
    assert!(refused(desk.path(), 2, &otherwise).contains("made with another --seed or --effort"));
    // Another plan is refused before anything is trained for it.
    let longer = [&args[1..], &["--duration", "3", "--retrain", "--seed", "6"]].concat();
    assert!(refused(desk.path(), 2, &longer).contains("its lengths of trials differ"));
    assert_eq!(first["conditions"], again["conditions"]);
}
