//! Which trials can be replayed, and how their conditions were rendered.

use crate::shared::conditions::calibration;
use std::collections::BTreeSet;
use zwidth_replay::Rendering;
use zwidth_store::{Signal, StudyData, TrialEntry};
use zwidth_study::{Environment, Mode, TrialMeta};

/// Whether a trial has a spring or a constant force, and everything that a run of the model driven by force needs.
pub(crate) fn is_replayable(data: &StudyData, trial: &TrialEntry) -> bool {
    is_recorded(data, trial) && calibration(data, &trial.meta).is_some()
}

/// The trials that count and are replayable.
pub(crate) fn replayable(data: &StudyData) -> impl Iterator<Item = &TrialEntry> {
    // The set is made once: trials are many, and looking a session up compares names.
    let calibrated = data.sessions.iter().map(|session| &session.record);
    let calibrated: BTreeSet<_> = calibrated
        .filter(|record| record.calibration.is_some())
        .map(|record| (&record.participant, &record.session))
        .collect();
    data.counting().filter(move |trial| {
        let TrialMeta { participant, session, .. } = &trial.meta;
        is_recorded(data, trial) && calibrated.contains(&(participant, session))
    })
}

/// Whether a trial has a spring or a constant force without a delay, and its recording what a run of the model needs.
/// (The table of replays says of the others why not.) The model has one coordinate: of a movement in several axes, and of
/// forces across the push, it knows nothing.
fn is_recorded(data: &StudyData, trial: &TrialEntry) -> bool {
    let environment = data.study.environment(&trial.meta.environment);
    let is_modelled = environment.is_some_and(|e| {
        (e.scene.spring().is_some() || e.scene.constant_n().is_some()) && e.delay_s == 0.0
    });
    let recorded = [Signal::Theta, Signal::ForceEx].iter().all(|s| trial.said.signals.contains(s));
    data.study.axes.is_none() && data.study.device.lever_m.is_some() && is_modelled && recorded
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
