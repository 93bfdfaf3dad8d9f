//! The learning curve: one row an evaluation.
//!
//! Owns the rows and their file format; refuses to judge them.

use serde::{Deserialize, Serialize};

/// One evaluation: a row of the learning curve.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Control steps gathered.
    pub env_steps: u64,
    /// Updates done.
    pub updates: u64,
    /// Wall-clock time learning, interruptions left out.
    pub wall_s: f64,
    /// Mean reward of an evaluation episode.
    pub reward: f64,
    /// Mean forward speed.
    pub speed_m_s: f64,
    /// Mean control steps of an evaluation episode.
    pub episode_steps: f64,
    /// Of the latest round.
    pub critic_loss: f64,
    /// Of the latest round.
    pub actor_loss: f64,
    /// Of the latest round.
    pub q_mean: f64,
}

/// The learning curve as people and plots read it.
pub fn to_csv(curve: &[CurvePoint]) -> String {
    let mut csv = String::from(
        "env_steps,updates,wall_s,reward,speed_m_s,episode_steps,critic_loss,actor_loss,q_mean\n",
    );
    for p in curve {
        csv += &format!(
            "{},{},{:.2},{:.4},{:.5},{:.1},{:.6},{:.6},{:.6}\n",
            p.env_steps,
            p.updates,
            p.wall_s,
            p.reward,
            p.speed_m_s,
            p.episode_steps,
            p.critic_loss,
            p.actor_loss,
            p.q_mean
        );
    }
    csv
}
