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
use crate::shared::making::{derived, join_sessions, read_shared, split, write_tables};
use crate::shared::trials::{Known, OfTrials, Recordings, files, name, read_all};
use rayon::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use zwidth_replay::{Parameters, Rendering, TrialReplay};
use zwidth_results::{Causality, HeldOutModel, ModelPlant, ReplayedPeak, ReplayedTrial};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, Signal, StudyData, Trial};
use zwidth_study::{Analysis, Scene};
use zwidth_tables::{Table, TableError};

pub(crate) const STAGE: Stage = Stage { name: "replay", version: zwidth_replay::VERSION };

/// The replays of a condition, `replay/P01.S01.spring.hybrid.parquet`.
pub(crate) fn of_condition(layout: &Layout, repeats: &Repeats) -> PathBuf {
    derived(layout, format!("replay/{}.parquet", repeats.key))
}

/// Those of the fitted model, `replay/P01.S01.spring.hybrid.fitted.parquet`.
fn fitted_of_condition(layout: &Layout, repeats: &Repeats) -> PathBuf {
    derived(layout, format!("replay/{}.fitted.parquet", repeats.key))
}

/// Those of the model that the ladder chose, `replay/P01.S01.spring.hybrid.auto.parquet`.
fn auto_of_condition(layout: &Layout, repeats: &Repeats) -> PathBuf {
    derived(layout, format!("replay/{}.auto.parquet", repeats.key))
}

/// The replays, and their agreement, if anything was rendered.
pub(crate) fn of_study(data: &StudyData) -> Option<[PathBuf; 2]> {
    let names = ["replay.parquet", "replay.agreement.parquet"];
    let is_any = replayable(data).next().is_some();
    is_any.then(|| names.map(|name| derived(&data.layout, name)))
}

/// The replays of a condition by each model.
fn files_of(data: &StudyData, repeats: &Repeats) -> Vec<PathBuf> {
    let fitted = || fitted_of_condition(&data.layout, repeats);
    let fitted = identify::known_plant(data).is_some().then(fitted);
    let auto = ladder::of_replay(data, repeats).map(|_| auto_of_condition(&data.layout, repeats));
    [of_condition(&data.layout, repeats)].into_iter().chain(fitted).chain(auto).collect()
}

/// Rows that the table of replays has of a trial, at most: the model by eye and the fitted one three
/// ways each, and so the one that a ladder chose.
pub(crate) fn rows_of_a_trial(data: &StudyData) -> usize {
    let models = 2 + usize::from(ladder::of_study(data).is_some());
    models * Causality::ALL.len()
}

/// Conditions whose environment is more than a questionnaire.
pub(crate) fn rendered(data: &StudyData) -> impl Iterator<Item = Repeats<'_>> {
    repeats(data).into_iter().filter(|r| r.environment.scene != Scene::None)
}

/// The same; none where not one trial can be replayed.
fn replayed(data: &StudyData) -> impl Iterator<Item = Repeats<'_>> {
    let is_any = replayable(data).next().is_some();
    rendered(data).filter(move |_| is_any)
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
    let analysis = data.study.analysis;
    let modelled = |repeats: &Repeats| {
        let rendering = repeats
            .trials
            .first()
            .map(|trial| rendering(data, &trial.meta, repeats.environment, repeats.mode));
        OfTrials::new(Modelled { rendering, analysis, plant: Parameters::BY_EYE }, &repeats.trials)
    };
    let by_eye = |repeats: &Repeats| {
        let output = of_condition(&data.layout, repeats);
        let name = format!("replay {}", repeats.who);
        Job::new(STAGE, name, modelled(repeats), files(&repeats.trials), vec![output], make_by_eye)
            .of_part(&repeats.key)
    };
    let plant = identify::tables(data).into_iter().next();
    let fitted = |repeats: &Repeats| {
        let output = fitted_of_condition(&data.layout, repeats);
        let inputs = (files(&repeats.trials), plant.clone()?);
        let name = format!("replay {} fitted", repeats.who);
        let job = Job::new(STAGE, name, modelled(repeats), inputs, vec![output], make_fitted);
        Some(job.of_part(&repeats.key))
    };
    let auto = |repeats: &Repeats| {
        let output = auto_of_condition(&data.layout, repeats);
        let inputs = (files(&repeats.trials), ladder::of_replay(data, repeats)?);
        let name = format!("replay {} auto", repeats.who);
        let OfTrials { trials, stage: modelled } = modelled(repeats);
        let of = OfTrials { trials, stage: Chosen { modelled, auto: Auto::of(&data.study) } };
        Some(Job::new(STAGE, name, of, inputs, vec![output], make_auto).of_part(&repeats.key))
    };
    let conditions: Vec<Repeats> = replayed(data).collect();
    let sessions: Vec<Vec<PathBuf>> = conditions
        .chunk_by(Repeats::is_of_session_of)
        .map(|of| of.iter().flat_map(|repeats| files_of(data, repeats)).collect())
        .collect();
    let level = analysis.confidence;
    let of_study = of_study(data).map(|[replays, agreement]| {
        let whole = "replay of the study";
        let agree = "agreement of model and recordings";
        [
            Job::new(STAGE, whole, (), sessions, vec![replays.clone()], make_study),
            Job::new(STAGE, agree, level, Derived::at(replays), vec![agreement], make_agreement),
        ]
    });
    let each = conditions.iter().map(by_eye).chain(conditions.iter().filter_map(fitted));
    each.chain(conditions.iter().filter_map(auto)).chain(of_study.into_iter().flatten()).collect()
}

fn make_by_eye(
    of: &OfTrials<Modelled>,
    files: &Recordings,
    making: &Making,
) -> Result<Made, JobError> {
    let model = |trial: &Trial, rendering: &Rendering, analysis: &Analysis| {
        Ok(zwidth_replay::replay(trial, rendering, analysis, ModelPlant::ByEye, &of.stage.plant)?)
    };
    let (rows, problems) = replays(&of.stage, &of.trials, files, &model)?;
    write_tables(&[Table::of_rows(&zwidth_replay::rows(&rows))?], making, problems)
}

/// Without rows if nothing was fitted. The job by eye reports trials that cannot be replayed.
fn make_fitted(
    of: &OfTrials<Modelled>,
    (files, plant): &(Recordings, PathBuf),
    making: &Making,
) -> Result<Made, JobError> {
    let plant = identify::fitted(&*read_shared(plant, making)?)?;
    let rows = match plant {
        Some(plant) => {
            let model = |trial: &Trial, rendering: &Rendering, analysis: &Analysis| {
                Ok(zwidth_replay::replay(trial, rendering, analysis, ModelPlant::Fitted, &plant)?)
            };
            replays(&of.stage, &of.trials, files, &model)?.0
        }
        None => Vec::new(),
    };
    write_tables(&[Table::of_rows(&zwidth_replay::rows(&rows))?], making, Vec::new())
}

/// By the model that the ladder chose. The job by eye reports trials that cannot be replayed.
fn make_auto(
    of: &OfTrials<Chosen>,
    (files, chosen): &(Recordings, Derived<HeldOutModel>),
    making: &Making,
) -> Result<Made, JobError> {
    let chosen = chosen.read()?;
    let model = |trial: &Trial, rendering: &Rendering, analysis: &Analysis| {
        of.stage.auto.replay(trial, rendering, analysis, &chosen)
    };
    let (rows, _) = replays(&of.stage.modelled, &of.trials, files, &model)?;
    write_tables(&[Table::of_rows(&zwidth_replay::rows(&rows))?], making, Vec::new())
}

/// A model of a trial.
type Model<'a> =
    &'a (dyn Fn(&Trial, &Rendering, &Analysis) -> Result<Vec<TrialReplay>, JobError> + Sync);

/// The trials of a condition through a model, and what is wrong with those that are left out.
fn replays(
    modelled: &Modelled,
    known: &[Known],
    files: &Recordings,
    model: Model,
) -> Result<(Vec<TrialReplay>, Vec<String>), JobError> {
    let (trials, mut problems) = read_all(files, known, Signal::all())?;
    let rendering = modelled.rendering.as_ref().ok_or("there is no trial")?;
    let rows = |trial: &Trial| -> Result<Vec<TrialReplay>, String> {
        let rows = model(trial, rendering, &modelled.analysis);
        rows.map_err(|e| format!("{}: {e}", name(&trial.meta)))
    };
    let (rows, more) = split(trials.par_iter().map(rows).collect());
    problems.extend(more);
    Ok((rows.concat(), problems))
}

/// The replays of all sessions in one table.
fn make_study(_: &(), sessions: &Vec<Vec<PathBuf>>, making: &Making) -> Result<Made, JobError> {
    Ok(join_sessions(sessions, join_tables, making))
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
    let read = |path: &PathBuf| Derived::<ReplayedTrial>::at(path.clone()).read();
    let rows = tables.par_iter().map(read).collect::<Result<Vec<_>, _>>()?;
    Ok(zwidth_replay::in_order(rows.into_iter().flatten().collect()))
}

fn make_agreement(
    level: &f64,
    replays: &Derived<ReplayedPeak>,
    making: &Making,
) -> Result<Made, JobError> {
    let replays = replays.read_own_columns()?;
    let rows = zwidth_replay::agreement(&replays, *level)?;
    let table = zwidth_replay::agreement_table(&rows, &replays)?;
    write_tables(&[table], making, Vec::new())
}
