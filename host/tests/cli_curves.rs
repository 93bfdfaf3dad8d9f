//! The command `curves`, as a user runs it.
#![cfg(feature = "train")]
#![allow(missing_docs)]

mod host_command;

use host_command::host;

const HEADER: &str =
    "env_steps,updates,wall_s,reward,speed_m_s,episode_steps,critic_loss,actor_loss,q_mean\n";

/// Two seeds with two evaluations each; the robot beside them is the Ant with short shins.
fn folder_with_runs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (seed, reward) in [(0, 10), (1, 20)] {
        let run = folder.path().join(format!("walk/seed-{seed}"));
        std::fs::create_dir_all(&run).unwrap();
        let rows = format!("0,0,0.0,1,0.0,300,0,0,0\n35000,2500,4.5,{reward},0.{reward},300,0,0,0\n");
        std::fs::write(run.join("train.csv"), format!("{HEADER}{rows}")).unwrap();
    }
    host::robot::Robot::ant(host::robot::LegScale::SHORT)
        .unwrap()
        .save(&folder.path().join("walk/robot"))
        .unwrap();
    folder
}

#[test]
fn curves_draws_a_picture_and_sums_up() {
    let folder = folder_with_runs();

    let output = host(folder.path(), &["curves", "walk", "--json"]).assert().success();

    let result: serde_json::Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let run = &result["runs"][0];
    assert_eq!(run["label"], "walk (0.6 L)");
    assert_eq!(run["seeds"], 2);
    assert_eq!(run["final"]["reward"]["mean"], 15.0);
    assert_eq!(run["best"]["reward"]["most"], 20.0);
    assert_eq!(run["each"][1]["seed"], "seed-1");
    assert_eq!(result["figure"], "walk/curves.svg");
    let svg = std::fs::read_to_string(folder.path().join("walk/curves.svg")).unwrap();
    assert!(svg.contains("walk (0.6 L), 2 seeds"), "{svg}");
}

#[test]
fn curves_of_several_runs_go_where_they_are_told() {
    let folder = folder_with_runs();

    let args = ["curves", "walk/seed-0", "walk", "--label", "one", "--label", "both", "--out", "new/fig.svg"];
    let output = host(folder.path(), &args).assert().success();

    let text = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    assert!(text.contains("both: 2 seeds, 2500 updates") && text.contains("new/fig.svg"), "{text}");
    let svg = std::fs::read_to_string(folder.path().join("new/fig.svg")).unwrap();
    assert!(svg.contains("one, 1 seed") && svg.contains("both, 2 seeds"));
}

#[test]
fn what_curves_cannot_use_has_its_exit_code_and_writes_nothing() {
    let folder = folder_with_runs();
    let fails = |args: &[&str], code: i32, says: &str| {
        let output = host(folder.path(), &["curves"]).args(args).assert().code(code);
        let text = String::from_utf8_lossy(&output.get_output().stderr).into_owned();
        assert!(text.contains(says), "{text}");
    };

    fails(&[], 3, "runs/latest holds no train.csv");
    fails(&["walk/robot"], 3, "walk/robot holds no train.csv");
    fails(&["walk", "--label", "a", "--label", "b"], 2, "2 labels (--label) for 1 runs");
    fails(&["walk", "--out", "fig.png"], 2, "fig.png does not end in .svg");
    fails(&["walk"; 8], 2, "8 runs in one figure");
    let damaged = folder.path().join("walk/seed-1/train.csv");
    std::fs::write(&damaged, format!("{HEADER}0,0,0.0,much,0,0,0,0,0\n")).unwrap();
    fails(&["walk"], 3, "walk/seed-1/train.csv");
    assert!(!folder.path().join("walk/curves.svg").exists());
}
