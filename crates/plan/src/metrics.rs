//! Stage `metrics`: one table for each condition of a session, then one for the whole study. A
//! changed trial leaves the tables of the other conditions as they are, and so the figures that
//! take their onsets from them. Metrics that need the identified plant are in a table of their own
//! for each session, because `identify` depends on every trial. The study's table has both kinds.

use crate::conditions::{Repeats, is_any, repeats};
use crate::identify::{known_plant, plant_with_spread};
use crate::making::{derived, read_parts, split, write_tables};
use crate::trials::{OfTrials, files, name, of_each};
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_metrics::Parameters;
use zwidth_runner::{Job, JobError, Made, Making, Stage, strip_root};
use zwidth_store::{Asked, Layout, OpenTrial, StoreError, StudyData, check_samples};
use zwidth_study::Condition;
use zwidth_tables::{NoteKind, Table};

const STAGE: Stage = Stage { name: "metrics", version: zwidth_metrics::VERSION };

/// The metrics of a condition, `metrics/P01.S01.spring.hybrid.parquet`.
pub(crate) fn of_condition(layout: &Layout, repeats: &Repeats) -> PathBuf {
    derived(layout, format!("metrics/{}.parquet", repeats.key))
}

/// What happened in a condition's trials, `metrics/P01.S01.spring.hybrid.events.parquet`.
pub(crate) fn events_of(layout: &Layout, repeats: &Repeats) -> PathBuf {
    derived(layout, format!("metrics/{}.events.parquet", repeats.key))
}

/// Those of a session that rest on the plant, `metrics/P01.S01.plant.parquet`.
fn with_plant(layout: &Layout, session: &str) -> PathBuf {
    derived(layout, format!("metrics/{session}.plant.parquet"))
}

/// The metrics of every condition that has trials.
pub(crate) fn of_conditions(data: &StudyData) -> Vec<PathBuf> {
    repeats(data).iter().map(|repeats| of_condition(&data.layout, repeats)).collect()
}

/// The metrics of the study, where it has trials.
pub(crate) fn of_study(data: &StudyData) -> Option<PathBuf> {
    is_any(data).then(|| study_files(&data.layout)[0].clone())
}

/// The metrics of the study trial by trial, and by condition.
pub(crate) fn study_files(layout: &Layout) -> [PathBuf; 2] {
    ["metrics.parquet", "conditions.parquet"].map(|name| derived(layout, name))
}

/// What the table of a condition depends on besides its trials.
#[derive(Serialize)]
struct OfCondition {
    #[serde(flatten)]
    metrics: Parameters,
    asked: Asked,
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let repeats = repeats(data);
    if repeats.is_empty() {
        return Vec::new();
    }
    let plant = known_plant(data);
    let (mut jobs, mut tables) = (Vec::new(), Vec::new());
    // Those of a session follow each other: they look at the same trials.
    for session in by_session(&repeats) {
        jobs.extend(session.iter().map(|r| condition_job(data, r)));
        let (job, table) = plant_job(data, session, plant.clone());
        jobs.push(job);
        tables.push(table);
    }
    jobs.push(study_job(data, tables));
    jobs
}

/// The conditions of each session.
fn by_session<'r, 'a>(repeats: &'r [Repeats<'a>]) -> impl Iterator<Item = &'r [Repeats<'a>]> {
    repeats.chunk_by(|a, b| a.trials[0].meta.is_of_session_of(&b.trials[0].meta))
}

/// The metrics and events of a condition's trials that need nothing but the trials.
fn condition_job(data: &StudyData, repeats: &Repeats) -> Job {
    let metrics = Parameters::of(&data.study, repeats.environment, repeats.mode);
    Job::new(
        STAGE,
        format!("metrics {}", repeats.who),
        OfTrials::new(
            OfCondition { metrics, asked: Asked::of(&data.study, &repeats.environment.id) },
            &repeats.trials,
        ),
        files(&repeats.trials),
        vec![of_condition(&data.layout, repeats), events_of(&data.layout, repeats)],
        make_condition,
    )
    .of_part(&repeats.key)
}

/// The metrics of a session's trials that need the identified plant, and their table.
fn plant_job(data: &StudyData, session: &[Repeats], plant: Option<[PathBuf; 2]>) -> (Job, PathBuf) {
    let of = &session[0].trials[0].meta;
    let key = format!("{}.{}", of.participant, of.session);
    let conditions: Vec<_> = session
        .iter()
        .map(|r| {
            let metrics = Parameters::of(&data.study, r.environment, r.mode);
            OfTrials::new(metrics, &r.trials)
        })
        .collect();
    let trials: Vec<_> = session.iter().map(|repeats| files(&repeats.trials)).collect();
    let table = with_plant(&data.layout, &key);
    let title = format!("metrics {} {} with the plant", of.participant, of.session);
    let outputs = vec![table.clone()];
    let job = Job::new(STAGE, title, conditions, (trials, plant), outputs, make_with_plant);
    (job.of_part(key), table)
}

/// The metrics of all conditions in one table, and by condition.
fn study_job(data: &StudyData, plant: Vec<PathBuf>) -> Job {
    let (tables, outputs) = ((of_conditions(data), plant), study_files(&data.layout).to_vec());
    Job::new(STAGE, "metrics of the study", data.study.conditions(), tables, outputs, make_study)
}

/// Trials that cannot be read, or whose samples make no metrics, the job without the plant tells.
fn make_with_plant(
    conditions: &Vec<OfTrials<Parameters>>,
    (trials, plant): &(Vec<Vec<PathBuf>>, Option<[PathBuf; 2]>),
    making: &Making,
) -> Result<Made, JobError> {
    let plant = match plant {
        Some([estimates, covariances]) => {
            plant_with_spread(&Table::from_parquet(estimates)?, &Table::from_parquet(covariances)?)?
        }
        None => None,
    };
    let of_condition = |(of, trials): (&OfTrials<Parameters>, &Vec<PathBuf>)| {
        let signals = &zwidth_metrics::PLANT_SIGNALS;
        of_each(making.trials, (trials, &of.trials), signals, |trial| {
            let row = zwidth_metrics::plant_metrics(trial, &of.stage, plant.as_ref());
            row.map_err(|e| e.to_string())
        })
        .0
    };
    let rows: Vec<_> = conditions.par_iter().zip(trials).flat_map_iter(of_condition).collect();
    write_tables(&[zwidth_metrics::plant_table(&rows)?], making, Vec::new())
}

fn make_condition(
    of: &OfTrials<OfCondition>,
    files: &Vec<PathBuf>,
    making: &Making,
) -> Result<Made, JobError> {
    let signals = [&zwidth_metrics::SIGNALS[..], &zwidth_store::CHECKED].concat();
    let (made, problems) = of_each(making.trials, (files, &of.trials), &signals, |trial| {
        let row = zwidth_metrics::trial_metrics(trial, &of.stage.metrics);
        Ok((
            row.map_err(|e| format!("{}: {e}", name(&trial.meta))),
            with_care(&of.stage.asked, trial),
        ))
    });
    let (rows, care): (Vec<_>, Vec<_>) = made.into_iter().unzip();
    let (rows, more) = split(rows);
    let problems = [problems, more].concat();
    let care = care.concat();
    let left_out = problems.iter().map(|p| (NoteKind::LeftOut, strip_root(making.root, p)));
    let notes = left_out.chain(care.iter().map(|note| (NoteKind::Care, note.clone())));
    let table = zwidth_metrics::table(&rows)?;
    let table = notes.fold(table, |table, (kind, note)| table.with_note_of(kind, note));
    let events: Vec<_> = rows.iter().map(|row| (&row.meta, row.events.as_slice())).collect();
    let events = zwidth_metrics::events_table(&events)?;
    Ok(Made { care, ..write_tables(&[table, events], making, problems)? })
}

fn make_study(
    conditions: &Vec<Condition>,
    (plain, plant): &(Vec<PathBuf>, Vec<PathBuf>),
    making: &Making,
) -> Result<Made, JobError> {
    let join = |tables: &[PathBuf]| -> Result<Table, JobError> {
        let joined = zwidth_metrics::join_conditions(read_parts(tables)?)?;
        Ok(joined.ok_or("there is no trial")?)
    };
    let all = zwidth_metrics::join_plant(&join(plain)?, &join(plant)?)?;
    let conditions = zwidth_metrics::by_condition(&all, conditions)?;
    write_tables(&[all, conditions], making, Vec::new())
}

/// What `verify` finds in a trial's samples, which count all the same.
fn with_care(asked: &Asked, trial: &OpenTrial) -> Vec<String> {
    let found = check_samples(asked, Path::new(""), trial.columns());
    found.into_iter().map(|finding| describe(trial, finding)).collect()
}

fn describe(trial: &OpenTrial, finding: StoreError) -> String {
    let column = finding.column.map(|column| format!(", {column}")).unwrap_or_default();
    let row = finding.row.map(|row| format!(", row {row}")).unwrap_or_default();
    format!("{}{column}{row}: {}; {}", name(&trial.meta), finding.what, finding.remedy)
}
