//! Which trials can be replayed, and how each was rendered.

use crate::conditions::calibration;
use zwidth_replay::Rendering;
use zwidth_store::{Signal, StudyData, TrialEntry};
use zwidth_study::{Environment, Mode, TrialMeta};

/// Whether a trial has a spring, and everything that a run of the model driven by force needs.
pub(crate) fn is_replayable(data: &StudyData, trial: &TrialEntry) -> bool {
    let environment = data.study.environment(&trial.meta.environment);
    let spring = environment.is_some_and(|e| e.scene.spring().is_some());
    let recorded = [Signal::Theta, Signal::ForceEx].iter().all(|s| trial.signals.contains(s));
    data.study.device.lever_m.is_some()
        && spring
        && recorded
        && calibration(data, &trial.meta).is_some()
}

/// How a trial's condition was rendered in its session.
pub(crate) fn rendering(
    data: &StudyData,
    meta: &TrialMeta,
    environment: &Environment,
    mode: &Mode,
) -> Rendering {
    Rendering::of(&data.study, environment, mode, calibration(data, meta).cloned())
}
