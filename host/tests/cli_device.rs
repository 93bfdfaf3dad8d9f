//! `train --device`, as a user runs it.
#![cfg(feature = "train")]
#![allow(missing_docs)]

mod tiny_training;

use assert_cmd::assert::Assert;
use std::path::Path;
use tiny_training::{folder, host};

fn train(folder: &Path, args: &[&str]) -> Assert {
    host(folder).arg("train").args(args).assert()
}

fn stderr(output: &Assert) -> String {
    // The error's lines are wrapped, and framed at the left.
    let text = String::from_utf8_lossy(&output.get_output().stderr).replace('│', " ");
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// Gives a run that is done an epoch more to do.
#[cfg(feature = "torch")]
fn prolong(run: &Path, epochs: u32) {
    let path = run.join("config.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let longer = text.replace(&format!("epochs = {epochs}\n"), &format!("epochs = {}\n", epochs + 1));
    assert_ne!(longer, text);
    std::fs::write(path, longer).unwrap();
}

#[cfg(feature = "torch")]
fn device_of(output: &Assert, run: &Path) -> [String; 2] {
    let line: serde_json::Value = serde_json::from_slice(&output.get_output().stdout).unwrap();
    let config: toml::Table = std::fs::read_to_string(run.join("config.toml")).unwrap().parse().unwrap();
    [&line["device"].to_string(), &config["device"].to_string()].map(|name| name.replace('"', ""))
}

#[cfg(feature = "torch")]
#[test]
fn a_run_keeps_its_device_until_another_is_asked_for() {
    let folder = folder();
    let run = folder.path().join("run");
    let train = |args: &[&str]| train(folder.path(), args).success();

    let output = train(&["--config", "tiny.toml", "--device", "torch", "--out", "run", "--json"]);
    assert_eq!(device_of(&output, &run), ["torch", "torch"]);

    prolong(&run, 2);
    let output = train(&["--resume", "run", "--json"]);
    assert_eq!(device_of(&output, &run), ["torch", "torch"]);

    prolong(&run, 3);
    let output = train(&["--resume", "run", "--device", "cpu", "--json"]);
    assert_eq!(device_of(&output, &run), ["cpu", "cpu"]);
}

/// It was learned on what its folder names.
#[cfg(feature = "torch")]
#[test]
fn a_run_that_is_done_keeps_its_device_whatever_is_asked_for() {
    let folder = folder();
    train(folder.path(), &["--config", "tiny.toml", "--out", "run"]).success();

    let output = train(folder.path(), &["--resume", "run", "--device", "torch", "--json"]).success();

    assert_eq!(device_of(&output, &folder.path().join("run")), ["cpu", "cpu"]);
}

#[cfg(feature = "torch")]
#[test]
fn every_seed_learns_on_the_device() {
    let folder = folder();

    let args = ["--config", "tiny.toml", "--seeds", "0..2", "--device", "torch", "--out", "both"];
    train(folder.path(), &args).success();

    for seed in ["seed-0", "seed-1"] {
        let path = folder.path().join("both").join(seed).join("config.toml");
        assert!(std::fs::read_to_string(path).unwrap().contains("device = \"torch\""), "{seed}");
    }
}

#[cfg(feature = "torch")]
#[test]
fn without_a_gpu_cuda_is_refused_with_the_next_move_and_nothing_is_written() {
    if tch::Cuda::is_available() {
        println!("skipped: this machine has a CUDA GPU");
        return;
    }
    let folder = folder();

    let output = train(folder.path(), &["--config", "tiny.toml", "--device", "cuda", "--out", "run"]).code(1);

    let text = stderr(&output);
    for part in ["libtorch finds no CUDA GPU", "LIBTORCH", "--device cpu"] {
        assert!(text.contains(part), "no {part}: {text}");
    }
    assert!(!folder.path().join("run").exists());

    // The same of a run that was made where there was one.
    train(folder.path(), &["--config", "tiny.toml", "--out", "run"]).success();
    let path = folder.path().join("run").join("config.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("device = \"cpu\"", "device = \"cuda\"")).unwrap();
    let output = train(folder.path(), &["--resume", "run"]).code(1);
    assert!(stderr(&output).contains("libtorch finds no CUDA GPU"));
    train(folder.path(), &["--resume", "run", "--device", "cpu"]).success();
}

#[cfg(not(feature = "torch"))]
#[test]
fn without_libtorch_its_devices_are_refused_with_how_to_build_it_in() {
    let folder = folder();
    for device in ["torch", "cuda"] {
        let args = ["--config", "tiny.toml", "--device", device, "--out", "run"];
        let output = train(folder.path(), &args).code(1);

        let text = stderr(&output);
        for part in [device, "built without it", "make setup", "feature `torch`", "--device cpu"] {
            assert!(text.contains(part), "no {part}: {text}");
        }
        assert!(!folder.path().join("run").exists());
    }
}

#[test]
fn a_device_by_another_name_is_refused_with_the_names_that_there_are() {
    let folder = folder();

    let output = train(folder.path(), &["--device", "gpu"]).code(2);

    assert!(stderr(&output).contains("cpu, torch, cuda"));
}
