//! The trials of a study, in the order of its plan.
//!
//! Holds the progress bar and Ctrl-C: a trial is in the ledger before the next
//! one begins. Does not depend on how a trial is walked.

use super::ExperimentError;
use super::device::Device;
use crate::experiment::ledger::Ledger;
use crate::experiment::materials::Materials;
use crate::experiment::plan::Plan;
use crate::experiment::summary::Planned;
use crate::experiment::trial::Trial;
use crate::experiment::twin_trials::{self, Authors};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// The trials of all conditions, without those that are in the ledger.
pub struct Walks<'a> {
    pub plan: &'a Plan,
    pub legs: &'a [Materials],
    pub authors: Option<&'a Authors>,
    pub planned: &'a [Planned],
    pub stop: &'a AtomicBool,
}

impl Walks<'_> {
    fn runnable(&self) -> impl Iterator<Item = &Planned> {
        self.planned.iter().filter(|planned| planned.not_run.is_none())
    }

    fn left(&self, ledger: &Ledger) -> usize {
        self.runnable().map(|planned| ledger.missing(planned.place, self.plan.trials).len()).sum()
    }

    pub fn in_twin(&self, ledger: &mut Ledger, folder: &Path) -> Result<(), ExperimentError> {
        let style =
            ProgressStyle::with_template("{bar:30} {pos}/{len} trials, {msg}, {elapsed} elapsed, {eta} left");
        let bar = ProgressBar::new(self.left(ledger) as u64)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        for Planned { place, .. } in self.runnable() {
            let numbers = ledger.missing(*place, self.plan.trials);
            if numbers.is_empty() {
                continue;
            }
            bar.set_message(format!("{} {}", place.method.label(), place.leg));
            let trials = twin_trials::walk(self.plan, self.legs, self.authors, *place, &numbers, self.stop);
            bar.inc(trials.len() as u64);
            ledger.add(trials)?;
            if self.stop.load(Ordering::Relaxed) {
                bar.finish_and_clear();
                return Err(ExperimentError::Interrupted { folder: folder.to_owned() });
            }
        }
        bar.finish_and_clear();
        Ok(())
    }

    pub fn on_device(&self, ledger: &mut Ledger, device: &mut Device<'_>) -> Result<(), ExperimentError> {
        for Planned { place, .. } in self.runnable() {
            let same_legs = |materials: &&Materials| materials.robot.geometry.leg_scale == place.leg;
            let Some(materials) = self.legs.iter().find(same_legs) else { continue };
            for number in ledger.missing(*place, self.plan.trials) {
                let left = self.left(ledger);
                let trial: Option<Trial> = device.walk(*place, number, materials, left)?;
                ledger.add(trial.into_iter().collect())?;
                if self.stop.load(Ordering::Relaxed) {
                    return Err(ExperimentError::Interrupted { folder: device.folder.to_owned() });
                }
            }
        }
        Ok(())
    }
}
