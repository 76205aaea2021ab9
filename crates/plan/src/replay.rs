//! Stage `replay`: every trial that counts through the model, a table a condition of a session;
//! then one of the whole study, and how far peaks and times agree.

use crate::conditions::{Repeats, repeats};
use crate::ladder::{self, Auto};
use crate::making::{derived, read_tables, split, write_tables};
use crate::replayable::rendering;
use crate::trials::{OfTrials, files, name, read_all};
use rayon::prelude::*;
use serde::Serialize;
use std::path::PathBuf;
use zwidth_replay::{Parameters, Rendering, TrialReplay};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Layout, Signal, StudyData, Trial, TrialEntry};
use zwidth_study::{Analysis, Scene};
use zwidth_tables::Table;

pub(crate) const STAGE: Stage = Stage { name: "replay", version: zwidth_replay::VERSION };

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

/// Conditions whose environment is more than a questionnaire.
fn rendered(data: &StudyData) -> impl Iterator<Item = Repeats<'_>> {
    repeats(data).into_iter().filter(|r| r.environment.scene != Scene::None)
}

/// What the replays of a condition depend on besides its trials.
#[derive(Serialize)]
struct Modelled {
    rendering: Option<Rendering>,
    analysis: Analysis,
    plant: Parameters,
    /// The ladder's model, where the study asks for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    auto: Option<Auto>,
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let analysis = data.study.analysis;
    let condition = |repeats: &Repeats| {
        let of =
            |trial: &&TrialEntry| rendering(data, &trial.meta, repeats.environment, repeats.mode);
        let rendering = repeats.trials.first().map(of);
        let model = ladder::of_replay(data, repeats);
        let auto = model.as_ref().map(|_| Auto::of(&data.study));
        let plant = Parameters::BY_EYE;
        Job::new(
            STAGE,
            format!("replay {}", repeats.who),
            OfTrials::new(Modelled { rendering, analysis, plant, auto }, &repeats.trials),
            (files(&repeats.trials), model),
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

fn make_condition(
    of: &OfTrials<Modelled>,
    (files, model): &(Vec<PathBuf>, Option<PathBuf>),
    making: &Making,
) -> Result<Made, JobError> {
    let (trials, mut problems) = read_all(files, &of.trials, Signal::all());
    let Modelled { rendering, analysis, plant, auto } = &of.stage;
    let model = model.as_ref().map(|file| Table::from_parquet(file)).transpose()?;
    let rendering = rendering.as_ref().ok_or("there is no trial")?;
    let rows = |trial: &Trial| -> Result<Vec<TrialReplay>, String> {
        let rows = match (auto, &model) {
            (Some(auto), Some(model)) => auto.replay(trial, rendering, analysis, model),
            _ => zwidth_replay::replay(trial, rendering, analysis, plant).map_err(JobError::from),
        };
        rows.map_err(|e| format!("{}: {e}", name(&trial.meta)))
    };
    let (rows, more) = split(trials.par_iter().map(rows).collect());
    problems.extend(more);
    write_tables(&[zwidth_replay::table(&rows.concat())?], making, problems)
}

fn make_study(level: &f64, tables: &Vec<PathBuf>, making: &Making) -> Result<Made, JobError> {
    let replays =
        zwidth_replay::join_conditions(&read_tables(tables)?)?.ok_or("there is no trial")?;
    let agreement = zwidth_replay::agreement(&replays, *level)?;
    write_tables(&[replays, agreement], making, Vec::new())
}
