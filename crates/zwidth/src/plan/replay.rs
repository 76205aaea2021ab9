//! Stage `replay`: every trial that counts through the model, a table a condition of a session;
//! then one of the whole study, and how far peaks and times agree.

use super::{
    JobError, Repeats, analysis_parameters, derived, joined, known, made, paths, read_all, repeats,
    split,
};
use rayon::prelude::*;
use std::path::PathBuf;
use zwidth_replay::{Parameters, Row};
use zwidth_runner::Job;
use zwidth_store::{Layout, Signal, StudyData, Trial, TrialEntry};
use zwidth_study::{Calibration, Scene, SessionRecord, TrialMeta};
use zwidth_tables::Table;

const STAGE: &str = "replay";

/// The replays, and their agreement.
pub(super) fn tables_of(layout: &Layout) -> Vec<PathBuf> {
    vec![derived(layout, "replay.parquet"), derived(layout, "replay.agreement.parquet")]
}

/// The replays of a condition, `replay/P01.S01.spring.hybrid.parquet`.
pub(super) fn of_condition(layout: &Layout, repeats: &Repeats) -> PathBuf {
    derived(layout, format!("replay/{}.parquet", repeats.key))
}

/// Whether a trial's environment is more than free motion.
fn is_rendered(data: &StudyData, trial: &TrialEntry) -> bool {
    data.study.environment(&trial.meta.environment).is_some_and(|e| e.scene != Scene::None)
}

/// Whether a trial has a spring, and everything that a run of the model driven by force needs.
pub(super) fn is_replayable(data: &StudyData, trial: &TrialEntry) -> bool {
    let environment = data.study.environment(&trial.meta.environment);
    let spring = environment.is_some_and(|e| e.scene.spring().is_some());
    let recorded = [Signal::Theta, Signal::ForceEx].iter().all(|s| trial.signals.contains(s));
    data.study.device.lever_m.is_some()
        && spring
        && recorded
        && calibration(data, &trial.meta).is_some()
}

/// The calibration in force in a trial's session.
pub(super) fn calibration<'a>(data: &'a StudyData, meta: &TrialMeta) -> Option<&'a Calibration> {
    let mine = |record: &&SessionRecord| {
        record.participant == meta.participant && record.session == meta.session
    };
    data.sessions.iter().map(|s| &s.record).find(mine)?.calibration.as_ref()
}

/// Whatever a replay depends on besides the trials' files.
pub(super) fn parameters(data: &StudyData, trials: &[&TrialEntry]) -> String {
    let study = &data.study;
    let modes: Vec<_> =
        study.modes.iter().map(|m| (m.id.as_str(), m.motor_max_v, m.brake_max_v)).collect();
    let is_of = |record: &SessionRecord, t: &TrialEntry| {
        record.participant == t.meta.participant && record.session == t.meta.session
    };
    let mine =
        data.sessions.iter().map(|s| &s.record).filter(|r| trials.iter().any(|t| is_of(r, t)));
    let calibrations: Vec<_> = mine.map(|record| &record.calibration).collect();
    let model = (study.control.let_go_n, modes, calibrations, Parameters::BY_EYE);
    format!("{}; {model:?}; {}", analysis_parameters(data), known(trials))
}

/// A trial's name in a message.
pub(super) fn named(meta: &TrialMeta) -> String {
    format!("{} {} trial {}", meta.participant, meta.session, meta.trial)
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let rendered = |repeats: &Repeats| repeats.trials.iter().any(|t| is_rendered(data, t));
    let conditions =
        repeats(data).into_iter().filter(rendered).map(|repeats| condition_job(data, repeats));
    joined(conditions.collect(), |tables| study_job(data, tables))
}

fn condition_job<'a>(data: &'a StudyData, repeats: Repeats<'a>) -> Job<'a> {
    let outputs = vec![of_condition(&data.layout, &repeats)];
    let (out, trials) = (outputs.clone(), repeats.trials);
    Job {
        stage: STAGE,
        name: format!("replay {}", repeats.who),
        version: zwidth_replay::VERSION,
        parameters: parameters(data, &trials),
        inputs: paths(&trials),
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let (trials, mut problems) = read_all(&trials, Signal::all());
            let (rows, more) = split(trials.par_iter().map(|t| rows(data, t)).collect());
            problems.extend(more);
            made(&[zwidth_replay::table(&rows.concat())?], &out, from, problems)
        }),
    }
}

fn study_job(data: &StudyData, inputs: Vec<PathBuf>) -> Job<'_> {
    let outputs = tables_of(&data.layout);
    let (files, out) = (inputs.clone(), outputs.clone());
    let level = data.study.analysis.confidence;
    Job {
        stage: STAGE,
        name: "replay of the study".to_owned(),
        version: zwidth_replay::VERSION,
        parameters: format!("level {level}"),
        inputs,
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let tables =
                files.iter().map(|f| Table::from_parquet(f)).collect::<Result<Vec<_>, _>>()?;
            let replays = zwidth_replay::together(&tables)?.ok_or("there is no trial")?;
            let agreement = zwidth_replay::agreement(&replays, level)?;
            made(&[replays, agreement], &out, from, Vec::new())
        }),
    }
}

fn rows(data: &StudyData, trial: &Trial) -> Result<Vec<Row>, JobError> {
    let calibration = calibration(data, &trial.meta);
    let rows = zwidth_replay::replay(trial, &data.study, calibration, &Parameters::BY_EYE);
    rows.map_err(|e| format!("{}: {e}", named(&trial.meta)).into())
}
