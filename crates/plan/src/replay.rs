//! Stage `replay`: every trial that counts through the model, a table a condition of a session;
//! then one of the whole study, and how far peaks and times agree.

use crate::conditions::{Repeats, Session, calibration, repeats, sessions};
use crate::identify;
use crate::trials::{OfTrials, files, name, read_all};
use crate::{derived, made, read_tables, split};
use rayon::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use zwidth_replay::{Parameters, Rendering, Row};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, Signal, StudyData, Trial, TrialEntry};
use zwidth_study::{Analysis, Environment, Mode, ModeId, Scene, TrialMeta};
use zwidth_tables::Table;

const STAGE: Stage = Stage { name: "replay", version: zwidth_replay::VERSION };

/// The replays of a condition, `replay/P01.S01.spring.hybrid.parquet`.
pub(crate) fn of_condition(layout: &Layout, repeats: &Repeats) -> PathBuf {
    derived(layout, format!("replay/{}.parquet", repeats.key))
}

/// The replays, and their agreement, if anything was rendered.
pub(crate) fn of_study(data: &StudyData) -> Vec<PathBuf> {
    let names = ["replay.parquet", "replay.agreement.parquet"].into_iter();
    let is_any = rendered(data).next().is_some();
    names.filter(|_| is_any).map(|name| derived(&data.layout, name)).collect()
}

/// The courses of typical trials of one environment of a session, if one can be replayed.
pub(crate) fn courses(
    data: &StudyData,
    session: &Session,
    environment: &Environment,
) -> Option<PathBuf> {
    let is_any = session.of(environment).iter().any(|t| is_replayable(data, t));
    let key = [session.ids().as_slice(), &[environment.id.to_string()]].concat().join(".");
    is_any.then(|| derived(&data.layout, format!("courses/{key}.parquet")))
}

/// Conditions whose environment is more than a questionnaire.
fn rendered(data: &StudyData) -> impl Iterator<Item = Repeats<'_>> {
    repeats(data).into_iter().filter(|r| r.environment.scene != Scene::None)
}

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

/// What the replays of a condition depend on besides its trials.
#[derive(Serialize)]
struct Modelled {
    rendering: Option<Rendering>,
    analysis: Analysis,
    plant: Parameters,
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let analysis = data.study.analysis;
    let condition = |repeats: &Repeats| {
        let of =
            |trial: &&TrialEntry| rendering(data, &trial.meta, repeats.environment, repeats.mode);
        let rendering = repeats.trials.first().map(of);
        Job::new(
            STAGE,
            format!("replay {}", repeats.who),
            OfTrials::new(
                Modelled { rendering, analysis, plant: Parameters::BY_EYE },
                &repeats.trials,
            ),
            files(&repeats.trials),
            vec![of_condition(&data.layout, repeats)],
            make_condition,
        )
    };
    let conditions: Vec<Repeats> = rendered(data).collect();
    let tables: Vec<PathBuf> = conditions.iter().map(|r| of_condition(&data.layout, r)).collect();
    let outputs = of_study(data);
    let level = analysis.confidence;
    let whole = || Job::new(STAGE, "replay of the study", level, tables, outputs, make_study);
    let whole = (!conditions.is_empty()).then(whole);
    conditions.iter().map(condition).chain(whole).collect()
}

/// What the courses depend on besides files.
#[derive(Serialize)]
struct Typical {
    /// In the order of the study, each with how it was rendered.
    modes: Vec<(ModeId, Rendering)>,
    plant: Parameters,
}

/// The courses of typical trials of each environment with a spring.
pub(crate) fn course_jobs(data: &StudyData) -> Vec<Job> {
    let mut jobs = Vec::new();
    for session in sessions(data) {
        for environment in &data.study.environments {
            let of_modes = data.study.modes.iter().filter_map(|m| session.repeats(environment, m));
            let conditions: Vec<Repeats> = of_modes.collect();
            let Some(output) = courses(data, &session, environment) else { continue };
            let mut trials = session.of(environment);
            trials.retain(|t| is_replayable(data, t));
            let rendered = |r: &Repeats| {
                let meta = &r.trials.first()?.meta;
                Some((r.mode.id.clone(), rendering(data, meta, environment, r.mode)))
            };
            let modes = conditions.iter().filter_map(rendered).collect();
            let typical = Typical { modes, plant: Parameters::BY_EYE };
            let replays: Vec<PathBuf> =
                conditions.iter().map(|r| of_condition(&data.layout, r)).collect();
            let inputs = (files(&trials), replays, identify::plant_of(&data.layout));
            let name = format!("courses {} {}", session.who(), environment.id);
            let of = OfTrials::new(typical, &trials);
            jobs.push(Job::new(STAGE, name, of, inputs, vec![output], make_courses));
        }
    }
    jobs
}

fn make_courses(
    of: &OfTrials<Typical>,
    (files, replays, plant): &(Vec<PathBuf>, Vec<PathBuf>, PathBuf),
    making: &Making,
) -> Result<Made, JobError> {
    let replays = zwidth_replay::together(&read_tables(replays)?)?.ok_or("there is no trial")?;
    let fitted = identify::fitted(&Table::from_parquet(plant)?)?;
    let mut trials = Vec::new();
    for (mode, rendering) in &of.stage.modes {
        let Some(number) = zwidth_replay::typical(&replays, mode.as_str())? else { continue };
        let Some(at) = of.trials.iter().position(|known| known.trial == number) else { continue };
        let (read, problems) = read_all(&files[at..=at], &of.trials[at..=at], Signal::all());
        let trial = read.into_iter().next().ok_or_else(|| problems.join("; "))?;
        trials.push((trial, rendering));
    }
    let courses = zwidth_replay::courses(&trials, &of.stage.plant, fitted.as_ref())?;
    if courses.height() == 0 {
        return Err("no trial could be replayed: the table 'replay' says why".into());
    }
    made(&[courses], making, Vec::new())
}

fn make_condition(
    of: &OfTrials<Modelled>,
    files: &Vec<PathBuf>,
    making: &Making,
) -> Result<Made, JobError> {
    let (trials, mut problems) = read_all(files, &of.trials, Signal::all());
    let Modelled { rendering, analysis, plant } = &of.stage;
    let rendering = rendering.as_ref().ok_or("there is no trial")?;
    let rows = |trial: &Trial| -> Result<Vec<Row>, String> {
        let rows = zwidth_replay::replay(trial, rendering, analysis, plant);
        rows.map_err(|e| format!("{}: {e}", name(&trial.meta)))
    };
    let (rows, more) = split(trials.par_iter().map(rows).collect());
    problems.extend(more);
    made(&[zwidth_replay::table(&rows.concat())?], making, problems)
}

fn make_study(level: &f64, tables: &Vec<PathBuf>, making: &Making) -> Result<Made, JobError> {
    let replays = zwidth_replay::together(&read_tables(tables)?)?.ok_or("there is no trial")?;
    let agreement = zwidth_replay::agreement(&replays, *level)?;
    made(&[replays, agreement], making, Vec::new())
}
