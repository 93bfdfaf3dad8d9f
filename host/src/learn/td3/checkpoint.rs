//! The checkpoint: everything that a run needs to resume bit for bit.
//!
//! Holds `checkpoint/` in the run folder: a `state.json` that names one tensor file.
//! Does not depend on the task. The tensor file is written first, and the state
//! renamed over the old one last, so that there is a complete checkpoint at any time.

use super::agent::{Agent, Losses};
use super::collect::{Episode, MAX_ENVS};
use super::config::Td3Config;
use super::curve::CurvePoint;
use super::replay::{Layout, ReplayBuffer};
use super::tensor_file::{TensorFile, TensorFileError};
use crate::run_folder::{self, FileError};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// The checkpoint's folder within a run.
pub const FOLDER: &str = "checkpoint";
const STATE: &str = "state.json";
/// Increased when older checkpoints can no longer be read.
const VERSION: u32 = 2;
/// Maximum number of rounds of `random::stream`, with a stream for each environment.
const MAX_COUNT: u64 = (1 << 56) / MAX_ENVS;

/// Why a run cannot be resumed or saved.
#[derive(Debug, Error)]
pub enum CheckpointError {
    /// The disk's reason.
    #[error(transparent)]
    File(#[from] FileError),
    /// The tensor file's reason.
    #[error(transparent)]
    Tensors(#[from] TensorFileError),
    /// `state.json` is damaged.
    #[error("{path} is not a checkpoint's state")]
    Format {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// Written by another version of this program.
    #[error("{path} has version {version}, this program reads version {VERSION}; start a new training")]
    Version {
        /// The file.
        path: PathBuf,
        /// The file's version.
        version: u32,
    },
    /// The parts contradict each other.
    #[error("{path} is damaged: {what} contradicts the rest")]
    Contradiction {
        /// The file.
        path: PathBuf,
        /// The part that contradicts the others.
        what: &'static str,
    },
}

impl CheckpointError {
    /// Whether writing failed; otherwise reading did.
    pub fn is_of_writing(&self) -> bool {
        match self {
            Self::File(error) | Self::Tensors(TensorFileError::File(error)) => error.action != "read",
            _ => false,
        }
    }
}

/// `state.json`: the parts of a run's state that are not tensors.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    version: u32,
    tensors: String,
    /// Rounds done, warm-up included.
    pub round: u64,
    /// Control steps gathered.
    pub env_steps: u64,
    updates: u64,
    /// Wall-clock time so far.
    pub wall_s: f64,
    /// Every evaluation so far.
    pub curve: Vec<CurvePoint>,
    /// Index of the best evaluation; its policy is in the run folder.
    pub best: usize,
    /// Losses of the latest round.
    #[serde(default)]
    pub losses: Losses,
    actor_adam_steps: u64,
    critics_adam_steps: u64,
    replay_next: usize,
    episodes: Vec<u64>,
}

/// Progress of a run, between two rounds.
#[derive(Debug, Default)]
pub struct Progress {
    /// Rounds done, warm-up included.
    pub round: u64,
    /// Control steps gathered.
    pub env_steps: u64,
    /// Wall-clock time so far.
    pub wall_s: f64,
    /// Every evaluation so far.
    pub curve: Vec<CurvePoint>,
    /// Index of the best evaluation.
    pub best: usize,
    /// Losses of the latest round.
    pub losses: Losses,
}

/// A checkpoint as it was read.
#[derive(Debug)]
pub struct Restored {
    /// Networks and optimisers.
    pub agent: Agent,
    /// The replay buffer.
    pub replay: ReplayBuffer,
    /// The environments' episodes.
    pub episodes: Vec<Episode>,
    /// Counters, learning curve and losses.
    pub progress: Progress,
}

/// The agent's arrays by name, for saving and loading.
fn numbers(agent: &mut Agent) -> [(&'static str, &mut Vec<f32>); 12] {
    let [critic1, critic2] = &mut agent.critics;
    let [target_critic1, target_critic2] = &mut agent.target_critics;
    let [adam1, adam2] = &mut agent.critics_adam;
    [
        ("actor", &mut agent.actor.parameters),
        ("critic1", &mut critic1.parameters),
        ("critic2", &mut critic2.parameters),
        ("target_actor", &mut agent.target_actor.parameters),
        ("target_critic1", &mut target_critic1.parameters),
        ("target_critic2", &mut target_critic2.parameters),
        ("actor_adam_mean", &mut agent.actor_adam.mean),
        ("actor_adam_square", &mut agent.actor_adam.square),
        ("critic1_adam_mean", &mut adam1.mean),
        ("critic1_adam_square", &mut adam1.square),
        ("critic2_adam_mean", &mut adam2.mean),
        ("critic2_adam_square", &mut adam2.square),
    ]
}

/// Whether a run has a checkpoint.
pub fn exists(run: &Path) -> bool {
    run.join(FOLDER).join(STATE).exists()
}

/// Writes a checkpoint into the run folder.
///
/// # Errors
/// [`CheckpointError`] with the previous checkpoint still in place.
pub fn save(
    run: &Path,
    agent: &mut Agent,
    replay: &ReplayBuffer,
    episodes: Vec<Episode>,
    progress: &Progress,
) -> Result<(), CheckpointError> {
    let folder = run.join(FOLDER);
    std::fs::create_dir_all(&folder).map_err(FileError::on("create", &folder))?;
    let state = State {
        version: VERSION,
        tensors: format!("round-{}.safetensors", progress.round),
        round: progress.round,
        env_steps: progress.env_steps,
        updates: agent.updates,
        wall_s: progress.wall_s,
        curve: progress.curve.clone(),
        best: progress.best,
        losses: progress.losses,
        actor_adam_steps: agent.actor_adam.steps,
        critics_adam_steps: agent.critics_adam[0].steps,
        replay_next: replay.next(),
        episodes: episodes.iter().map(|episode| episode.number).collect(),
    };
    let mut file = TensorFile::new(&folder.join(&state.tensors));
    for (name, values) in numbers(agent) {
        file.put(name, &[values.len()], values.clone());
    }
    file.put("replay", &[replay.rows().len()], replay.rows().to_vec());
    for (slot, episode) in episodes.into_iter().enumerate() {
        file.put(actions_name(slot), &[episode.actions.len()], episode.actions);
    }
    file.save()?;
    let path = folder.join(STATE);
    let json = serde_json::to_vec_pretty(&state)
        .map_err(|source| CheckpointError::Format { path: path.clone(), source })?;
    run_folder::write(&path, &json)?;
    remove_older(&folder, &state.tensors);
    Ok(())
}

/// Removes earlier tensor files. They only take space, so errors are ignored.
fn remove_older(folder: &Path, keep: &str) {
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with("round-") && name != keep {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Reads a run's checkpoint.
///
/// # Errors
/// [`CheckpointError`] if there is none, or its parts do not fit `config`.
pub fn load(
    run: &Path,
    config: &Td3Config,
    layout: Layout,
    envs: usize,
) -> Result<Restored, CheckpointError> {
    let path = run.join(FOLDER).join(STATE);
    let json = std::fs::read(&path).map_err(FileError::on("read", &path))?;
    let state: State = serde_json::from_slice(&json)
        .map_err(|source| CheckpointError::Format { path: path.clone(), source })?;
    if state.version != VERSION {
        return Err(CheckpointError::Version { path, version: state.version });
    }
    let contradiction = |what| CheckpointError::Contradiction { path: path.clone(), what };
    // More than any schedule has, and low enough that counting on cannot overflow.
    let counters = [
        ("round", state.round),
        ("env_steps", state.env_steps),
        ("updates", state.updates),
        ("actor_adam_steps", state.actor_adam_steps),
        ("critics_adam_steps", state.critics_adam_steps),
    ];
    if let Some((what, _)) = counters.into_iter().find(|(_, count)| *count > MAX_COUNT) {
        return Err(contradiction(what));
    }
    if state.best >= state.curve.len() {
        return Err(contradiction("best"));
    }
    if state.episodes.len() != envs || state.episodes.iter().any(|number| *number > MAX_COUNT) {
        return Err(contradiction("episodes"));
    }
    if Path::new(&state.tensors).components().count() != 1 {
        return Err(contradiction("tensors"));
    }
    let mut file = TensorFile::load(&run.join(FOLDER).join(&state.tensors))?;
    let mut agent = Agent::new(config, layout, 0);
    for (name, values) in numbers(&mut agent) {
        *values = file.take_len(name, values.len())?;
    }
    agent.updates = state.updates;
    agent.actor_adam.steps = state.actor_adam_steps;
    for adam in &mut agent.critics_adam {
        adam.steps = state.critics_adam_steps;
    }
    let rows = file.take("replay")?.numbers;
    let replay = ReplayBuffer::restore(layout, config.buffer_size, rows, state.replay_next)
        .ok_or_else(|| contradiction("replay_next"))?;
    // No batch can be sampled from an empty buffer.
    if replay.is_empty() && state.env_steps > 0 {
        return Err(contradiction("replay"));
    }
    let mut episodes = Vec::new();
    for (slot, number) in state.episodes.into_iter().enumerate() {
        let actions = file.take(&actions_name(slot))?.numbers;
        if actions.len() % layout.action_len != 0 {
            return Err(contradiction("actions"));
        }
        episodes.push(Episode { number, actions });
    }
    Ok(Restored {
        agent,
        replay,
        episodes,
        progress: Progress {
            round: state.round,
            env_steps: state.env_steps,
            wall_s: state.wall_s,
            curve: state.curve,
            best: state.best,
            losses: state.losses,
        },
    })
}

fn actions_name(slot: usize) -> String {
    format!("actions{slot}")
}
