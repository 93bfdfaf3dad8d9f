//! A training of a second, in a folder of its own.
// Every test file uses another part of it.
#![allow(dead_code)]

use assert_cmd::Command;
use std::path::Path;
use std::time::Duration;

/// Episodes are short so that some end within it. 100 random steps are 2
/// rounds, 80 updates are 8 more.
pub const TINY: &str = "
[td3]
hidden_layers = 1
hidden_width = 16
batch_size = 16
[schedule]
epochs = 2
updates_per_epoch = 40
env_steps_per_update = 5
round_updates = 10
warm_up_env_steps = 100
training_envs = 2
evaluation_episodes = 2
[env]
episode_steps = 70
";

/// To be added to [`TINY`]: every episode's robot differs in every way.
pub const DIFFERING: &str = "
[env.randomisation]
twin_spread = 2.0
friction_share = 0.3
mass_share = 0.2
latency_s = 0.05
supply_share = 0.3
";

/// A folder that holds it as `tiny.toml`.
pub fn folder() -> tempfile::TempDir {
    folder_with(TINY)
}

/// A folder that holds another configuration as `tiny.toml`.
pub fn folder_with(config: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("tiny.toml"), config).unwrap();
    folder
}

/// The program in that folder, in plain words.
pub fn host(folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_host"));
    command.current_dir(folder).env("NO_COLOR", "1").timeout(Duration::from_secs(120));
    command
}
