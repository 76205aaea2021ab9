//! Stage `replay`: every trial that counts through the model, and how far peaks and times agree.

use super::{JobError, analysis_parameters, derived, known, made, paths, read_all, split};
use rayon::prelude::*;
use std::path::PathBuf;
use zwidth_replay::{Parameters, Row};
use zwidth_runner::Job;
use zwidth_store::{Layout, Signal, StudyData, Trial, TrialEntry};
use zwidth_study::{Calibration, Scene, TrialMeta};

/// The replays, and their agreement.
pub(super) fn tables_of(layout: &Layout) -> Vec<PathBuf> {
    vec![derived(layout, "replay.parquet"), derived(layout, "replay.agreement.parquet")]
}

/// The trials that count in which something was rendered.
pub(super) fn trials(data: &StudyData) -> Vec<&TrialEntry> {
    let rendered =
        |t: &&TrialEntry| data.study.environment(&t.meta.environment).is_some_and(|e| e.scene != Scene::None);
    data.counting().filter(rendered).collect()
}

/// Those of them with a spring, and with everything that a run of the model driven by force needs.
pub(super) fn replayable(data: &StudyData) -> Vec<&TrialEntry> {
    let whole = |t: &&TrialEntry| {
        let spring = data.study.environment(&t.meta.environment).is_some_and(|e| e.scene.spring().is_some());
        let recorded = [Signal::Theta, Signal::ForceEx].iter().all(|s| t.signals.contains(s));
        spring && recorded && calibration(data, &t.meta).is_some()
    };
    match data.study.device.lever_m {
        Some(_) => trials(data).into_iter().filter(whole).collect(),
        None => Vec::new(),
    }
}

/// The calibration in force in a trial's session.
pub(super) fn calibration<'a>(data: &'a StudyData, meta: &TrialMeta) -> Option<&'a Calibration> {
    let mine = |record: &&zwidth_study::SessionRecord| {
        record.participant == meta.participant && record.session == meta.session
    };
    data.sessions.iter().map(|s| &s.record).find(mine)?.calibration.as_ref()
}

/// Whatever a replay depends on besides the trials' files.
pub(super) fn parameters(data: &StudyData, trials: &[&TrialEntry]) -> String {
    let study = &data.study;
    let modes: Vec<_> = study.modes.iter().map(|m| (m.id.as_str(), m.motor_max_v, m.brake_max_v)).collect();
    let calibrations: Vec<_> = data.sessions.iter().map(|s| &s.record.calibration).collect();
    let model = (study.control.let_go_n, modes, calibrations, Parameters::BY_EYE);
    format!("{}; {model:?}; {}", analysis_parameters(data), known(trials))
}

/// A trial's name in a message.
pub(super) fn named(meta: &TrialMeta) -> String {
    format!("{} {} trial {}", meta.participant, meta.session, meta.trial)
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let trials = trials(data);
    if trials.is_empty() {
        return Vec::new();
    }
    let (inputs, outputs) = (paths(&trials), tables_of(&data.layout));
    let (out, parameters) = (outputs.clone(), parameters(data, &trials));
    let make = move |from: &_| {
        let (trials, mut problems) = read_all(&trials);
        let (rows, more) = split(trials.par_iter().map(|t| rows(data, t)).collect());
        problems.extend(more);
        let replays = zwidth_replay::table(&rows.concat())?;
        let agreement = zwidth_replay::agreement(&replays, data.study.analysis.confidence)?;
        made(&[replays, agreement], &out, from, problems)
    };
    vec![Job {
        stage: "replay",
        name: "replay".to_owned(),
        version: zwidth_replay::VERSION,
        parameters,
        inputs,
        outputs,
        tolerant: false,
        make: Box::new(make),
    }]
}

fn rows(data: &StudyData, trial: &Trial) -> Result<Vec<Row>, JobError> {
    let calibration = calibration(data, &trial.meta);
    let rows = zwidth_replay::replay(trial, &data.study, calibration, &Parameters::BY_EYE);
    rows.map_err(|e| format!("{}: {e}", named(&trial.meta)).into())
}
