//! Stage `metrics`: one table for each session, and one of what happened in its trials; then one
//! table for the whole study. Metrics that need the identified plant are in a table of their own for
//! each session, because `identify` depends on every trial. The study's table has both kinds.

use crate::identify::{known_plant, plant_with_spread};
use crate::shared::conditions::{Repeats, is_any, repeats};
use crate::shared::handle::Derived;
use crate::shared::making::{derived, join_sessions, read_shared, read_tables, write_tables};
use crate::shared::trials::{OfTrials, Recordings, files, name, of_each};
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_metrics::{Parameters, TrialMetrics};
use zwidth_results::{TrialEvent, TrialRemark};
use zwidth_runner::{Job, JobError, Made, Making, Stage, strip_root};
use zwidth_store::{Asked, Layout, OpenTrial, Signal, StoreError, StudyData};
use zwidth_study::{Condition, TrialMeta};
use zwidth_tables::{Measured, NoteKind, Table, TableError};

const STAGE: Stage = Stage { name: "metrics", version: zwidth_metrics::VERSION };

/// The metrics of a session that need nothing but its trials, `metrics/P01.S01.parquet`.
fn of_session(layout: &Layout, session: &str) -> PathBuf {
    derived(layout, format!("metrics/{session}.parquet"))
}

/// What happened in the trials of a session, `metrics/P01.S01.events.parquet`.
pub(crate) fn events_of(layout: &Layout, of: &TrialMeta) -> Derived<TrialEvent> {
    Derived::at(derived(layout, format!("metrics/{}.events.parquet", key(of))))
}

/// What is said of the trials of a session, `metrics/P01.S01.remarks.parquet`.
fn remarks_of(layout: &Layout, session: &str) -> Derived<TrialRemark> {
    Derived::at(derived(layout, format!("metrics/{session}.remarks.parquet")))
}

/// What is said of the trials of every session that has trials.
pub(crate) fn remarks(data: &StudyData) -> Vec<Derived<TrialRemark>> {
    by_session(&repeats(data)).map(|s| remarks_of(&data.layout, &key(meta(s)))).collect()
}

/// Those of a session that rest on the plant, `metrics/P01.S01.plant.parquet`.
fn with_plant(layout: &Layout, session: &str) -> PathBuf {
    derived(layout, format!("metrics/{session}.plant.parquet"))
}

/// The metrics of the study, where it has trials.
pub(crate) fn of_study(data: &StudyData) -> Option<PathBuf> {
    is_any(data).then(|| study_files(&data.layout)[0].clone())
}

/// Of the metrics of the study what a report looks at, and these.
pub(crate) fn looked_at(file: &Path, compared: &[String]) -> Result<Measured, TableError> {
    let mut metrics = zwidth_report::metric_columns();
    metrics.extend(compared.iter().map(String::as_str));
    Measured::read(file, &metrics)
}

/// The metrics of the study trial by trial, and by condition.
pub(crate) fn study_files(layout: &Layout) -> [PathBuf; 2] {
    ["metrics.parquet", "conditions.parquet"].map(|name| derived(layout, name))
}

/// What the metrics of a condition depend on besides its trials.
#[derive(Serialize)]
struct Asking {
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
        OfTrials::new(Asking { metrics, asked }, &repeats.trials)
    };
    let conditions: Vec<_> = session.iter().map(of_condition).collect();
    let of = meta(session);
    let key = key(meta(session));
    let events = events_of(&data.layout, of).path().to_owned();
    let remarks = remarks_of(&data.layout, &key).path().to_owned();
    let outputs = vec![of_session(&data.layout, &key), events, remarks];
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
    let of = meta(session);
    let key = key(meta(session));
    let outputs = vec![with_plant(&data.layout, &key)];
    let title = format!("metrics {} {} with the plant", of.participant, of.session);
    let inputs = (trials_of(session), plant);
    Job::new(STAGE, title, conditions, inputs, outputs, make_with_plant).of_part(key)
}

/// The metrics of all sessions in one table, and by condition.
fn study_jobs(data: &StudyData, sessions: Vec<Vec<PathBuf>>) -> [Job; 2] {
    let [metrics, by_condition] = study_files(&data.layout);
    let whole = "metrics of the study";
    let conditions = "metrics by condition";
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
            let estimates = read_shared(estimates, making)?;
            let covariances = read_shared(covariances, making)?;
            plant_with_spread(&estimates, &covariances)?
        }
        None => None,
    };
    let rows = conditions.par_iter().zip(trials).map(|(of, trials)| {
        let signals = &zwidth_metrics::PLANT_SIGNALS;
        let found = of_each(making.trials, trials, &of.trials, signals, |trial| {
            zwidth_metrics::plant_metrics(trial, &of.stage, plant.as_ref())
        });
        found.map(|each| each.into_iter().flatten().flatten().collect::<Vec<_>>())
    });
    let rows: Vec<_> = rows.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    write_tables(&[zwidth_metrics::plant_table(&rows)?], making, Vec::new())
}

/// What is made of a condition's trials.
type OfCondition = (Vec<TrialMetrics>, Vec<TrialRemark>);

fn make_session(
    conditions: &Vec<OfTrials<Asking>>,
    trials: &Vec<Recordings>,
    making: &Making,
) -> Result<Made, JobError> {
    let made =
        conditions.par_iter().zip(trials).map(|(of, files)| make_condition(of, files, making));
    let made: Vec<OfCondition> = made.collect::<Result<_, StoreError>>()?;
    let (rows, remarks): (Vec<_>, Vec<_>) = made.into_iter().unzip();
    let rows = rows.concat();
    let mut remarks = remarks.concat();
    // Those that are left out come first.
    remarks.sort_by_key(|remark| remark.kind == NoteKind::Care);

    let told = |kind| remarks.iter().filter(move |remark| remark.kind == kind).map(in_words);
    let metrics = zwidth_metrics::table(&rows)?;
    let metrics = remarks
        .iter()
        .fold(metrics, |table, remark| table.with_note_of(remark.kind, in_words(remark)));
    let events = rows.iter().flat_map(|row| row.events.iter().map(|event| event.of(&row.meta)));
    let tables = [metrics, Table::of_rows(&events.collect::<Vec<_>>())?, Table::of_rows(&remarks)?];
    let problems = told(NoteKind::LeftOut).collect();
    let care = told(NoteKind::Care).collect();
    Ok(Made { care, ..write_tables(&tables, making, problems)? })
}

fn in_words(remark: &TrialRemark) -> String {
    format!("{}: {}", remark.what, remark.why)
}

fn make_condition(
    of: &OfTrials<Asking>,
    files: &Recordings,
    making: &Making,
) -> Result<OfCondition, StoreError> {
    let signals = [&zwidth_metrics::SIGNALS[..], &zwidth_store::CHECKED].concat();
    let each = of_each(making.trials, files, &of.trials, &signals, |trial| {
        let found = zwidth_metrics::trial_metrics(trial, &of.stage.metrics);
        let mut care: Vec<_> =
            trial.check(&of.stage.asked).into_iter().map(|f| describe(trial, f)).collect();
        care.extend(found.as_ref().ok().and_then(|row| covers_little(row, trial)));
        (found.map_err(|error| (name(&trial.meta), error.to_string())), care)
    })?;
    let mut rows = Vec::new();
    let mut remarks = Vec::new();
    for (file, each) in files.iter().zip(each) {
        let mut remark = |kind, (what, why): (String, String)| {
            let path = making.shown(file);
            remarks.push(TrialRemark {
                path,
                kind,
                what: strip_root(making.root, &what),
                why: why.into(),
            });
        };
        match each {
            Ok((found, care)) => {
                match found {
                    Ok(row) => rows.push(row),
                    Err(left_out) => remark(NoteKind::LeftOut, left_out),
                }
                care.into_iter().for_each(|found| remark(NoteKind::Care, found));
            }
            Err(error) => remark(NoteKind::LeftOut, (error.place(), error.remark())),
        }
    }
    Ok((rows, remarks))
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
    let summarised: Vec<&str> = zwidth_metrics::summarised().collect();
    let metrics = Measured::read(metrics, &summarised)?;
    write_tables(&[zwidth_metrics::by_condition(&metrics, conditions)?], making, Vec::new())
}

/// A movement that covers less than this share of its recording …
const LITTLE: f64 = 0.05;
/// … and leaves this long, s, may not be the one that was meant.
const LONG_S: f64 = 5.0;

/// What is said of a movement that covers little of its recording: of what, and what it is.
fn covers_little(row: &TrialMetrics, trial: &OpenTrial) -> Option<(String, String)> {
    let duration_s = row.movement.duration_s?;
    let t = trial.columns().column(Signal::Time)?;
    let recorded_s = t.last()? - t.first()?;
    let is_little = duration_s < LITTLE * recorded_s && recorded_s - duration_s > LONG_S;
    let why = || {
        format!(
            "its movement is taken to be {duration_s:.2} s of the {recorded_s:.1} s that were recorded; look whether \
             this is the one that was meant, and set onset_deg_s and offset_deg_s under [analysis] of study.toml, or split \
             the recording"
        )
    };
    is_little.then(|| (format!("{}, {}", name(&trial.meta), Signal::ThetaDot.name()), why()))
}

/// What `verify` finds in a trial, which counts all the same: in what, and what it is.
fn describe(trial: &OpenTrial, finding: StoreError) -> (String, String) {
    let column = finding.column.map(|column| format!(", {column}")).unwrap_or_default();
    let row = finding.row.map(|row| format!(", row {row}")).unwrap_or_default();
    let what = format!("{}{column}{row}", name(&trial.meta));
    (what, format!("{}; {}", finding.what, finding.remedy))
}
