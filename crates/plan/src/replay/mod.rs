//! Stage `replay`: the model fitted by eye is run on every trial that counts, and so is the plant
//! that `identify` found, if there is one. Each condition of a session has one table for each
//! model; then there is one for the whole study, and one that says how closely peaks and times
//! agree.

pub(crate) mod courses;
pub(crate) mod figures;
pub(crate) mod oscillations;
pub(crate) mod replayable;
pub(crate) mod runs;

use crate::identify;
use crate::ladder::{self, Auto};
use crate::replay::replayable::{rendering, replayable};
use crate::shared::conditions::{Repeats, repeats};
use crate::shared::handle::Derived;
use crate::shared::making::{derived, join_sessions, read_shared, write_tables};
use crate::shared::trials::{OfTrials, Recordings, TrialLabel, files, read_and_make};
use rayon::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use zwidth_replay::{Parameters, Rendering};
use zwidth_results::{Causality, HeldOutModel, ModelPlant, ReplayedPeak, ReplayedTrial};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, StudyData, Trial};
use zwidth_study::{Analysis, Scene};
use zwidth_tables::{Table, TableError};

pub(crate) const STAGE: Stage = Stage { name: "replay", version: zwidth_replay::VERSION };

/// The replays of a condition by a model: `replay/P01.S01.spring.hybrid.parquet` by eye,
/// `….hybrid.fitted.parquet` and `….hybrid.auto.parquet`.
pub(crate) fn of_condition(layout: &Layout, repeats: &Repeats, model: ModelPlant) -> PathBuf {
    let suffix = match model {
        ModelPlant::ByEye => "",
        ModelPlant::Fitted => ".fitted",
        ModelPlant::Auto => ".auto",
    };
    derived(layout, format!("replay/{}{suffix}.parquet", repeats.key))
}

/// The replays, and their agreement, if anything was rendered.
pub(crate) fn of_study(data: &StudyData) -> Option<[PathBuf; 2]> {
    replayable(data).next()?;
    Some(["replay.parquet", "replay.agreement.parquet"].map(|name| derived(&data.layout, name)))
}

/// Rows that the table of replays has of a trial, at most: three for the model by eye, three for the
/// fitted one, and three for the one that a ladder chose.
pub(crate) fn rows_of_a_trial(data: &StudyData) -> usize {
    let models = 2 + usize::from(ladder::of_study(data).is_some());
    models * Causality::ALL.len()
}

/// Conditions whose environment is more than a questionnaire.
pub(crate) fn rendered(data: &StudyData) -> impl Iterator<Item = Repeats<'_>> {
    repeats(data).into_iter().filter(|r| r.environment.scene != Scene::None)
}

/// What the replays of a condition depend on besides its trials.
#[derive(Serialize)]
struct Modelled {
    rendering: Option<Rendering>,
    analysis: Analysis,
    plant: Parameters,
}

/// What the replays by the model that the ladder chose depend on besides its trials.
#[derive(Serialize)]
struct Chosen {
    modelled: Modelled,
    auto: Auto,
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let Some([replays, agreement]) = of_study(data) else { return Vec::new() };
    let analysis = data.study.analysis;
    let modelled = |repeats: &Repeats| {
        // How a condition is rendered is the same in all trials of a session.
        let rendering = repeats
            .trials
            .first()
            .map(|trial| rendering(data, &trial.meta, repeats.environment, repeats.mode));
        OfTrials::new(Modelled { rendering, analysis, plant: Parameters::BY_EYE }, &repeats.trials)
    };
    let conditions: Vec<Repeats> = rendered(data).collect();
    let mut jobs = Vec::new();
    // Model by model: those by eye wait for no other job, and are planned first.
    for repeats in &conditions {
        let output = vec![of_condition(&data.layout, repeats, ModelPlant::ByEye)];
        let name = format!("replay {}", repeats.who);
        let files = files(&repeats.trials);
        let job = Job::new(STAGE, name, modelled(repeats), files, output, make_by_eye);
        jobs.push(job.of_part(&repeats.key));
    }
    for repeats in &conditions {
        let output = vec![of_condition(&data.layout, repeats, ModelPlant::Fitted)];
        let name = format!("replay {} fitted", repeats.who);
        let inputs = (files(&repeats.trials), identify::plant_of(&data.layout));
        let job = Job::new(STAGE, name, modelled(repeats), inputs, output, make_fitted);
        jobs.push(job.of_part(&repeats.key));
    }
    for repeats in &conditions {
        let Some(models) = ladder::of_replay(data, repeats) else { continue };
        let output = vec![of_condition(&data.layout, repeats, ModelPlant::Auto)];
        let name = format!("replay {} auto", repeats.who);
        let inputs = (files(&repeats.trials), models);
        let OfTrials { trials, stage: modelled } = modelled(repeats);
        let stage = Chosen { modelled, auto: Auto::of(&data.study) };
        let job = Job::new(STAGE, name, OfTrials { trials, stage }, inputs, output, make_auto);
        jobs.push(job.of_part(&repeats.key));
    }
    let mut sessions = Vec::new();
    for session in conditions.chunk_by(Repeats::is_of_session_of) {
        let mut tables = Vec::new();
        for repeats in session {
            let table = |model| of_condition(&data.layout, repeats, model);
            tables.extend([ModelPlant::ByEye, ModelPlant::Fitted].map(table));
            tables.extend(ladder::of_replay(data, repeats).map(|_| table(ModelPlant::Auto)));
        }
        sessions.push(tables);
    }
    let whole = vec![replays.clone()];
    jobs.push(Job::new(
        STAGE,
        "replay of the study",
        (),
        sessions,
        whole,
        |(), sessions, making| Ok(join_sessions(sessions, join_tables, making)),
    ));
    let (name, replays) = ("agreement of model and recordings", Derived::at(replays));
    let level = analysis.confidence;
    let outputs = vec![agreement];
    jobs.push(Job::new(STAGE, name, level, replays, outputs, |level, replays, making| {
        let replays: Vec<ReplayedPeak> = replays.read_own_columns()?;
        let rows = zwidth_replay::agreement(&replays, *level)?;
        write_tables(&[zwidth_replay::agreement_table(&rows, &replays)?], making, Vec::new())
    }));
    jobs
}

fn make_by_eye(
    parameters: &OfTrials<Modelled>,
    files: &Recordings,
    making: &Making,
) -> Result<Made, JobError> {
    let OfTrials { stage: modelled, trials: labels } = parameters;
    let (rows, problems) = replay_all(modelled, labels, files, &|trial, rendering, analysis| {
        let plant = &modelled.plant;
        Ok(zwidth_replay::replay(trial, rendering, analysis, ModelPlant::ByEye, plant)?)
    })?;
    write_tables(&[Table::of_rows(&rows)?], making, problems)
}

/// Without rows if nothing was fitted. The job by eye reports trials that cannot be replayed.
fn make_fitted(
    parameters: &OfTrials<Modelled>,
    (files, plant): &(Recordings, PathBuf),
    making: &Making,
) -> Result<Made, JobError> {
    let OfTrials { stage: modelled, trials: labels } = parameters;
    let mut rows = Vec::new();
    if let Some(plant) = identify::fitted(&*read_shared(plant, making)?)? {
        (rows, _) = replay_all(modelled, labels, files, &|trial, rendering, analysis| {
            Ok(zwidth_replay::replay(trial, rendering, analysis, ModelPlant::Fitted, &plant)?)
        })?;
    }
    write_tables(&[Table::of_rows(&rows)?], making, Vec::new())
}

/// By the model that the ladder chose. The job by eye reports trials that cannot be replayed.
fn make_auto(
    parameters: &OfTrials<Chosen>,
    (files, models): &(Recordings, Derived<HeldOutModel>),
    making: &Making,
) -> Result<Made, JobError> {
    let OfTrials { stage: Chosen { modelled, auto }, trials: labels } = parameters;
    let models = models.read()?;
    let (rows, _) = replay_all(modelled, labels, files, &|trial, rendering, analysis| {
        auto.replay(trial, rendering, analysis, &models)
    })?;
    write_tables(&[Table::of_rows(&rows)?], making, Vec::new())
}

/// A model of a trial.
type Model<'a> =
    &'a (dyn Fn(&Trial, &Rendering, &Analysis) -> Result<Vec<ReplayedTrial>, JobError> + Sync);

/// The trials of a condition through a model, and what is wrong with those that are left out.
fn replay_all(
    modelled: &Modelled,
    labels: &[TrialLabel],
    files: &Recordings,
    model: Model,
) -> Result<(Vec<ReplayedTrial>, Vec<String>), JobError> {
    let rendering = modelled.rendering.as_ref().ok_or("there is no trial")?;
    let (rows, problems) =
        read_and_make(files, labels, |trial| model(trial, rendering, &modelled.analysis))?;
    Ok((rows.concat(), problems))
}

/// The replays of a session in one table.
fn join_tables(tables: &[PathBuf]) -> Result<Table, JobError> {
    let rows = join_rows(tables)?;
    let note = zwidth_replay::own_model(rows.iter().map(|row| row.source));
    let table = Table::of_rows(&rows)?;
    Ok(note.into_iter().fold(table, Table::with_note))
}

/// The replays of several conditions, in the order of their trials.
pub(crate) fn join_rows(tables: &[PathBuf]) -> Result<Vec<ReplayedTrial>, TableError> {
    let rows = tables.par_iter().map(|path| Derived::<ReplayedTrial>::at(path.clone()).read());
    let rows = rows.collect::<Result<Vec<_>, _>>()?;
    Ok(zwidth_replay::in_order(rows.into_iter().flatten().collect()))
}
