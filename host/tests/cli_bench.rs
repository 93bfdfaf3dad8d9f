//! The command `bench`, as a script uses it.
#![cfg(feature = "torch")]
#![allow(missing_docs)]

use assert_cmd::Command;
use predicates::prelude::*;
use predicates::str::contains;

/// One round: whether the figures are there and add up, not how good they are.
#[test]
fn one_round_prints_every_figure_and_the_ratios_fit_them() {
    let output = Command::new(env!("CARGO_BIN_EXE_host")).args(["bench", "--rounds", "1", "--json"]).assert();

    let output = output.success();
    let text = String::from_utf8_lossy(&output.get_output().stdout).into_owned();
    let figures: serde_json::Value = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
    let figure = |name: &str| figures[name].as_f64().unwrap_or_else(|| panic!("no {name}: {text}"));
    for name in [
        "env_steps_per_s",
        "env_steps_per_s_2",
        "updates_per_s",
        "update_vs_plain_tch",
        "gemm_gflops",
        "train_steps_per_s",
        "learn_steps_per_s",
        "evaluation_episode_steps",
        "peak_memory_bytes",
    ] {
        assert!(figure(name) > 0.0, "{name}: {text}");
    }
    // 107 million operations an update; the figures are rounded.
    let fraction = figure("updates_per_s") * 0.1072 / figure("gemm_gflops");
    assert!((figure("update_fraction_of_gemm") - fraction).abs() < 0.01, "{fraction}: {text}");
    assert!(figure("learn_steps_per_s") > figure("train_steps_per_s"), "evaluation takes time: {text}");
    assert!(figure("peak_memory_bytes") < 1e9 * 1.073_741_824, "{text}");
    assert!(output.get_output().stderr.is_empty(), "no terminal, no progress");
}

#[test]
fn no_rounds_at_all_are_refused() {
    Command::new(env!("CARGO_BIN_EXE_host")).args(["bench", "--rounds", "0"]).assert().code(2);
}

#[test]
fn updates_that_do_not_make_whole_rounds_are_refused_with_the_number_that_counts() {
    let run = Command::new(env!("CARGO_BIN_EXE_host")).args(["bench", "--updates", "510"]).assert();

    run.failure().stderr(contains("--updates 510").and(contains("25")));
}
