//! Stage `metrics`: one table for each session, and one of what happened in its trials; then one
//! table for the whole study. Metrics that need the identified plant are in a table of their own for
//! each session, because `identify` depends on every trial. The study's table has both kinds.

use crate::conditions::{Repeats, is_any, repeats};
use crate::identify::{known_plant, plant_with_spread};
use crate::making::{derived, join_sessions, read_shared, read_tables, split, write_tables};
use crate::trials::{OfTrials, Recordings, files, name, of_each};
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_metrics::{Parameters, TrialMetrics};
use zwidth_runner::{Job, JobError, Made, Making, Stage, strip_root};
use zwidth_store::{Asked, Layout, OpenTrial, Signal, StoreError, StudyData};
use zwidth_study::{Condition, TrialMeta};
use zwidth_tables::{NoteKind, Table, TableError};

const STAGE: Stage = Stage { name: "metrics", version: zwidth_metrics::VERSION };

/// The metrics of a session that need nothing but its trials, `metrics/P01.S01.parquet`.
fn of_session(layout: &Layout, session: &str) -> PathBuf {
    derived(layout, format!("metrics/{session}.parquet"))
}

/// What happened in the trials of a session, `metrics/P01.S01.events.parquet`.
pub(crate) fn events_of(layout: &Layout, of: &TrialMeta) -> PathBuf {
    derived(layout, format!("metrics/{}.events.parquet", key(of)))
}

/// Those of a session that rest on the plant, `metrics/P01.S01.plant.parquet`.
fn with_plant(layout: &Layout, session: &str) -> PathBuf {
    derived(layout, format!("metrics/{session}.plant.parquet"))
}

/// The metrics of every session that has trials.
pub(crate) fn of_sessions(data: &StudyData) -> Vec<PathBuf> {
    by_session(&repeats(data)).map(|s| of_session(&data.layout, &key(meta(s)))).collect()
}

/// The metrics of the study, where it has trials.
pub(crate) fn of_study(data: &StudyData) -> Option<PathBuf> {
    is_any(data).then(|| study_files(&data.layout)[0].clone())
}

/// Of the metrics of the study what a report looks at, and these.
pub(crate) fn looked_at(file: &Path, compared: &[String]) -> Result<Table, TableError> {
    let mut columns = zwidth_report::metric_columns();
    columns.extend(compared.iter().map(String::as_str));
    Table::columns_from_parquet(file, &columns)
}

/// The metrics of the study trial by trial, and by condition.
pub(crate) fn study_files(layout: &Layout) -> [PathBuf; 2] {
    ["metrics.parquet", "conditions.parquet"].map(|name| derived(layout, name))
}

/// What the metrics of a condition depend on besides its trials.
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
    // The two of a session follow each other: they look at the same trials.
    let of_one = |session| [session_job(data, session), plant_job(data, session, plant.clone())];
    let mut jobs: Vec<Job> = by_session(&repeats).flat_map(of_one).collect();
    let keys = by_session(&repeats).map(|session| key(meta(session)));
    let files = |key: String| [of_session, with_plant].map(|of| of(&data.layout, &key)).to_vec();
    jobs.extend(study_jobs(data, keys.map(files).collect()));
    jobs
}

/// The conditions of each session.
fn by_session<'r, 'a>(repeats: &'r [Repeats<'a>]) -> impl Iterator<Item = &'r [Repeats<'a>]> {
    repeats.chunk_by(Repeats::is_of_session_of)
}

/// A trial of a session: which session it is.
fn meta<'r>(session: &'r [Repeats]) -> &'r TrialMeta {
    &session[0].trials[0].meta
}

/// `P01.S01`, the session of a trial.
fn key(of: &TrialMeta) -> String {
    format!("{}.{}", of.participant, of.session)
}

/// The trials of each condition of a session.
fn trials_of(session: &[Repeats]) -> Vec<Recordings> {
    session.iter().map(|repeats| files(&repeats.trials)).collect()
}

/// The metrics of a session's trials that need nothing but the trials, and what happened in them.
fn session_job(data: &StudyData, session: &[Repeats]) -> Job {
    let of_condition = |repeats: &Repeats| {
        let metrics = Parameters::of(&data.study, repeats.environment, repeats.mode);
        let asked = Asked::of(&data.study, &repeats.environment.id);
        OfTrials::new(OfCondition { metrics, asked }, &repeats.trials)
    };
    let conditions: Vec<_> = session.iter().map(of_condition).collect();
    let (of, key) = (meta(session), key(meta(session)));
    let outputs = vec![of_session(&data.layout, &key), events_of(&data.layout, of)];
    let title = format!("metrics {} {}", of.participant, of.session);
    Job::new(STAGE, title, conditions, trials_of(session), outputs, make_session).of_part(key)
}

/// The metrics of a session's trials that need the identified plant.
fn plant_job(data: &StudyData, session: &[Repeats], plant: Option<[PathBuf; 2]>) -> Job {
    let of_condition = |repeats: &Repeats| {
        let metrics = Parameters::of(&data.study, repeats.environment, repeats.mode);
        OfTrials::new(metrics, &repeats.trials)
    };
    let conditions: Vec<_> = session.iter().map(of_condition).collect();
    let (of, key) = (meta(session), key(meta(session)));
    let outputs = vec![with_plant(&data.layout, &key)];
    let title = format!("metrics {} {} with the plant", of.participant, of.session);
    let inputs = (trials_of(session), plant);
    Job::new(STAGE, title, conditions, inputs, outputs, make_with_plant).of_part(key)
}

/// The metrics of all sessions in one table, and by condition.
fn study_jobs(data: &StudyData, sessions: Vec<Vec<PathBuf>>) -> [Job; 2] {
    let [metrics, by_condition] = study_files(&data.layout);
    let (whole, conditions) = ("metrics of the study", "metrics by condition");
    let asked = data.study.conditions();
    [
        Job::new(STAGE, whole, (), sessions, vec![metrics.clone()], make_study),
        Job::new(STAGE, conditions, asked, metrics, vec![by_condition], make_by_condition),
    ]
}

/// Which trials are damaged, or have samples that make no metrics, the job without the plant tells.
fn make_with_plant(
    conditions: &Vec<OfTrials<Parameters>>,
    (trials, plant): &(Vec<Recordings>, Option<[PathBuf; 2]>),
    making: &Making,
) -> Result<Made, JobError> {
    let plant = match plant {
        Some([estimates, covariances]) => {
            let (estimates, covariances) =
                (read_shared(estimates, making)?, read_shared(covariances, making)?);
            plant_with_spread(&estimates, &covariances)?
        }
        None => None,
    };
    let of_condition = |(of, trials): (&OfTrials<Parameters>, &Recordings)| {
        let signals = &zwidth_metrics::PLANT_SIGNALS;
        let found = of_each(making.trials, (trials, &of.trials), signals, |trial| {
            let row = zwidth_metrics::plant_metrics(trial, &of.stage, plant.as_ref());
            row.map_err(|e| e.to_string())
        });
        found.map(|(rows, _)| rows)
    };
    let rows = conditions.par_iter().zip(trials).map(of_condition);
    let rows: Vec<_> = rows.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    write_tables(&[zwidth_metrics::plant_table(&rows)?], making, Vec::new())
}

/// What is made of a condition's trials.
struct OfOne {
    rows: Vec<TrialMetrics>,
    /// What had to be left out.
    problems: Vec<String>,
    /// What is to be read with care.
    care: Vec<String>,
}

fn make_session(
    conditions: &Vec<OfTrials<OfCondition>>,
    trials: &Vec<Recordings>,
    making: &Making,
) -> Result<Made, JobError> {
    let made: Result<Vec<OfOne>, StoreError> = conditions
        .par_iter()
        .zip(trials)
        .map(|(of, files)| make_condition(of, files, making))
        .collect();
    let (mut rows, mut problems, mut care) = (Vec::new(), Vec::new(), Vec::new());
    for of in made? {
        rows.extend(of.rows);
        problems.extend(of.problems);
        care.extend(of.care);
    }
    let left_out = problems.iter().map(|p| (NoteKind::LeftOut, strip_root(making.root, p)));
    let notes = left_out.chain(care.iter().map(|note| (NoteKind::Care, note.clone())));
    let table = zwidth_metrics::table(&rows)?;
    let table = notes.fold(table, |table, (kind, note)| table.with_note_of(kind, note));
    let events: Vec<_> = rows.iter().map(|row| (&row.meta, row.events.as_slice())).collect();
    let events = zwidth_metrics::events_table(&events)?;
    Ok(Made { care, ..write_tables(&[table, events], making, problems)? })
}

fn make_condition(
    of: &OfTrials<OfCondition>,
    files: &Recordings,
    making: &Making,
) -> Result<OfOne, StoreError> {
    let signals = [&zwidth_metrics::SIGNALS[..], &zwidth_store::CHECKED].concat();
    let (made, problems) = of_each(making.trials, (files, &of.trials), &signals, |trial| {
        let row = zwidth_metrics::trial_metrics(trial, &of.stage.metrics);
        let mut care = with_care(&of.stage.asked, trial);
        care.extend(row.as_ref().ok().and_then(|row| covers_little(row, trial)));
        Ok((row.map_err(|e| format!("{}: {e}", name(&trial.meta))), care))
    })?;
    let (rows, care): (Vec<_>, Vec<_>) = made.into_iter().unzip();
    let (rows, more) = split(rows);
    Ok(OfOne { rows, problems: [problems, more].concat(), care: care.concat() })
}

fn make_study(_: &(), sessions: &Vec<Vec<PathBuf>>, making: &Making) -> Result<Made, JobError> {
    Ok(join_sessions(sessions, join_tables, making))
}

/// The two tables of a session as one.
fn join_tables(tables: &[PathBuf]) -> Result<Table, JobError> {
    let [plain, plant]: [Table; 2] =
        read_tables(tables)?.try_into().map_err(|_| "a session has two tables")?;
    let plain = zwidth_metrics::join_sessions(vec![plain])?.ok_or("there is no trial")?;
    Ok(zwidth_metrics::join_plant(&plain, &plant)?)
}

fn make_by_condition(
    conditions: &Vec<Condition>,
    metrics: &PathBuf,
    making: &Making,
) -> Result<Made, JobError> {
    let columns = zwidth_metrics::condition_columns();
    let metrics = Table::columns_from_parquet(metrics, &columns)?;
    write_tables(&[zwidth_metrics::by_condition(&metrics, conditions)?], making, Vec::new())
}

/// A movement that covers less than this share of its recording …
const LITTLE: f64 = 0.05;
/// … and leaves this long, s, may not be the one that was meant.
const LONG_S: f64 = 5.0;

/// What is said of a movement that covers little of its recording.
fn covers_little(row: &TrialMetrics, trial: &OpenTrial) -> Option<String> {
    let duration_s = row.movement.duration_s?;
    let recorded_s = {
        let t = trial.columns().column(Signal::Time)?;
        t.last()? - t.first()?
    };
    let is_little = duration_s < LITTLE * recorded_s && recorded_s - duration_s > LONG_S;
    is_little.then(|| {
        format!(
            "{}, {}: its movement is taken to be {duration_s:.2} s of the {recorded_s:.1} s that were recorded; look whether \
             this is the one that was meant, and set onset_deg_s and offset_deg_s under [analysis] of study.toml, or split \
             the recording",
            name(&trial.meta),
            Signal::ThetaDot.name()
        )
    })
}

/// What `verify` finds in a trial, which counts all the same.
fn with_care(asked: &Asked, trial: &OpenTrial) -> Vec<String> {
    trial.check(asked).into_iter().map(|finding| describe(trial, finding)).collect()
}

fn describe(trial: &OpenTrial, finding: StoreError) -> String {
    let column = finding.column.map(|column| format!(", {column}")).unwrap_or_default();
    let row = finding.row.map(|row| format!(", row {row}")).unwrap_or_default();
    format!("{}{column}{row}: {}; {}", name(&trial.meta), finding.what, finding.remedy)
}
