//! Stage `metrics`: one table for each session, and one of what happened in its trials; then one
//! table for the whole study. Metrics that need the identified plant are in a table of their own for
//! each session, because `identify` depends on every trial. The study's table has both kinds.

use crate::identify::{known_plant, plant_with_spread};
use crate::outside::{Joined, joined};
use crate::shared::conditions::{Repeats, is_any, repeats};
use crate::shared::handle::Derived;
use crate::shared::making::{derived, join_sessions, read_shared, read_tables, write_tables};
use crate::shared::trials::{OfTrials, Recordings, files, name, of_each};
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};
use zwidth_metrics::{Parameters, TrialMetrics, own_metrics};
use zwidth_results::{OutsideValue, TrialEvent, TrialRemark};
use zwidth_runner::{Job, JobError, Made, Making, Stage, strip_root};
use zwidth_store::{Asked, Layout, OpenTrial, Signal, StoreError, StudyData};
use zwidth_study::{Condition, MetricId, TrialMeta};
use zwidth_tables::{Measured, NoteKind, Table, TableError};

const STAGE: Stage = Stage { name: "metrics", version: zwidth_metrics::VERSION };

/// What happened in the trials of a session, `metrics/P01.S01.events.parquet`.
pub(crate) fn events_of(layout: &Layout, trial: &TrialMeta) -> Derived<TrialEvent> {
    Derived::at(derived(layout, format!("metrics/{}.events.parquet", session_key(trial))))
}

/// The remarks on the trials of a session, `metrics/P01.S01.remarks.parquet`.
fn remarks_of(layout: &Layout, session: &str) -> Derived<TrialRemark> {
    Derived::at(derived(layout, format!("metrics/{session}.remarks.parquet")))
}

/// The remarks on the trials of every session that has trials.
pub(crate) fn remarks(data: &StudyData) -> Vec<Derived<TrialRemark>> {
    by_session(&repeats(data))
        .map(|session| remarks_of(&data.layout, &session_key(first_trial(session))))
        .collect()
}

/// The metrics of the study, if it has trials.
pub(crate) fn of_study(data: &StudyData) -> Option<PathBuf> {
    is_any(data).then(|| study_files(&data.layout)[0].clone())
}

/// The metrics of the session of a trial without those that rest on the plant.
pub(crate) fn of_session(layout: &Layout, trial: &TrialMeta) -> PathBuf {
    derived(layout, format!("metrics/{}.parquet", session_key(trial)))
}

/// Reads the metrics of the study that a report needs, and those that are compared.
pub(crate) fn read_for_report(file: &Path, compared: &[String]) -> Result<Measured, TableError> {
    let mut metrics = zwidth_report::metric_columns();
    metrics.extend(compared.iter().map(String::as_str));
    Measured::read(file, &metrics)
}

/// The metrics of the study trial by trial, and by condition.
pub(crate) fn study_files(layout: &Layout) -> [PathBuf; 2] {
    ["metrics.parquet", "conditions.parquet"].map(|name| derived(layout, name))
}

/// The tables of metrics of each session, without and with the plant: [`join_tables`] makes one of both.
pub(crate) fn of_sessions(data: &StudyData) -> Vec<Vec<PathBuf>> {
    let repeats = repeats(data);
    let sessions = by_session(&repeats).map(|session| {
        let key = session_key(first_trial(session));
        let of = |end: &str| derived(&data.layout, format!("metrics/{key}{end}.parquet"));
        vec![of(""), of(".plant")]
    });
    sessions.collect()
}

/// What the metrics of a condition depend on besides its trials.
#[derive(Serialize)]
struct ConditionParameters {
    #[serde(flatten)]
    metrics: Parameters,
    asked: Asked,
}

/// What the table of conditions depends on besides the metrics.
#[derive(Serialize)]
struct ByCondition {
    conditions: Vec<Condition>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    own: Vec<MetricId>,
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let repeats = repeats(data);
    if repeats.is_empty() {
        return Vec::new();
    }
    let plant = known_plant(data);
    let mut jobs = Vec::new();
    let mut sessions = Vec::new();
    for session in by_session(&repeats) {
        let first = first_trial(session);
        let key = session_key(first);
        let name = format!("metrics {} {}", first.participant, first.session);
        let plain_metrics = of_session(&data.layout, first);
        let plant_metrics = derived(&data.layout, format!("metrics/{key}.plant.parquet"));
        sessions.push(vec![plain_metrics.clone(), plant_metrics.clone()]);
        // One table for all conditions: a table has a hundred columns, and to write and read one takes
        // as long as the metrics of a trial or two.
        let mut plain = Vec::new();
        let mut with_plant = Vec::new();
        let mut trials: Vec<Recordings> = Vec::new();
        for repeats in session {
            let metrics = Parameters::of(&data.study, repeats.environment, repeats.mode);
            let asked = Asked::of(&data.study, &repeats.environment.id);
            // The plant changes none of the study's own.
            let plant = Parameters { own: Vec::new(), ..metrics.clone() };
            with_plant.push(OfTrials::new(plant, &repeats.trials));
            plain.push(OfTrials::new(ConditionParameters { metrics, asked }, &repeats.trials));
            trials.push(files(&repeats.trials));
        }
        let events = events_of(&data.layout, first).path().to_owned();
        let remarks = remarks_of(&data.layout, &key).path().to_owned();
        let outputs = vec![plain_metrics, events, remarks];
        // The two of a session follow each other: they look at the same trials.
        let job = Job::new(STAGE, name.clone(), plain, trials.clone(), outputs, make_session);
        jobs.push(job.of_part(key.clone()));
        let name = format!("{name} with the plant");
        let inputs = (trials, plant.clone());
        let job = Job::new(STAGE, name, with_plant, inputs, vec![plant_metrics], make_with_plant);
        jobs.push(job.of_part(key));
    }
    let [metrics, conditions] = study_files(&data.layout);
    let whole = vec![metrics.clone()];
    let (outside, tables): (Vec<Joined>, Vec<_>) = joined(data).into_iter().unzip();
    let mut own: Vec<MetricId> = own_metrics(&data.study).map(|own| own.id.clone()).collect();
    own.extend(outside.iter().map(|outside| outside.metric.column.clone()));
    let of_study = Job::new(
        STAGE,
        "metrics of the study",
        // Nothing in a study without them, as it was before there were any.
        Some(outside).filter(|outside| !outside.is_empty()),
        (sessions, tables),
        whole,
        join_study,
    );
    // Whatever becomes of a stage of the study's own, all else is made.
    let may_fail = !data.study.stages.is_empty();
    jobs.push(if may_fail { of_study.tolerant() } else { of_study });
    let name = "metrics by condition";
    let parameters = ByCondition { conditions: data.study.conditions(), own };
    let outputs = vec![conditions];
    jobs.push(Job::new(
        STAGE,
        name,
        parameters,
        metrics,
        outputs,
        |ByCondition { conditions, own }, metrics, making| {
            // The table has a hundred columns: those alone are read.
            let metrics = Measured::read(metrics, &zwidth_metrics::summarised(own))?;
            let table = zwidth_metrics::by_condition(&metrics, conditions, own)?;
            write_tables(&[table], making, Vec::new())
        },
    ));
    jobs
}

/// The conditions of each session.
fn by_session<'r, 'a>(repeats: &'r [Repeats<'a>]) -> impl Iterator<Item = &'r [Repeats<'a>]> {
    repeats.chunk_by(Repeats::is_of_session_of)
}

/// The first trial of a session, which tells whose session it is. Neither list is ever empty.
fn first_trial<'r>(session: &'r [Repeats]) -> &'r TrialMeta {
    &session[0].trials[0].meta
}

/// `P01.S01`, the session of a trial.
fn session_key(trial: &TrialMeta) -> String {
    format!("{}.{}", trial.participant, trial.session)
}

/// The job without the plant reports trials that are damaged, or have samples that make no metrics.
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
    let rows = conditions.par_iter().zip(trials).map(|(parameters, files)| {
        let signals = &zwidth_metrics::PLANT_SIGNALS;
        let each = of_each(making.trials, files, &parameters.trials, signals, &[], |trial| {
            zwidth_metrics::plant_metrics(trial, &parameters.stage, plant.as_ref())
        });
        // A trial that cannot be read, or has no metrics, has no row.
        each.map(|each| each.into_iter().flatten().flatten().collect::<Vec<_>>())
    });
    let rows: Vec<_> = rows.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    let in_space = conditions.first().is_some_and(|first| first.stage.axes.is_some());
    write_tables(&[zwidth_metrics::plant_table(&rows, in_space)?], making, Vec::new())
}

/// The metrics of a session's trials, and the remarks on them.
fn make_session(
    conditions: &Vec<OfTrials<ConditionParameters>>,
    trials: &Vec<Recordings>,
    making: &Making,
) -> Result<Made, JobError> {
    let results = conditions.par_iter().zip(trials).map(|(parameters, files)| {
        let ConditionParameters { metrics, asked } = &parameters.stage;
        let signals = [&metrics.signals()[..], &zwidth_store::CHECKED].concat();
        let channels = metrics.channels();
        let each =
            of_each(making.trials, files, &parameters.trials, &signals, &channels, |trial| {
                let row = zwidth_metrics::trial_metrics(trial, metrics);
                let mut care: Vec<_> = trial
                    .check(asked)
                    .into_iter()
                    .map(|finding| describe(trial, finding))
                    .collect();
                care.extend(
                    row.as_ref()
                        .ok()
                        .and_then(|row| covers_little(row, trial, metrics.axes.is_some())),
                );
                (row.map_err(|error| (name(&trial.meta), error.to_string())), care)
            })?;
        let mut rows = Vec::new();
        let mut remarks = Vec::new();
        for (file, each) in files.iter().zip(each) {
            let mut own = Vec::new();
            match each {
                Ok((row, care)) => {
                    match row {
                        Ok(row) => rows.push(row),
                        Err(left_out) => own.push((NoteKind::LeftOut, left_out)),
                    }
                    own.extend(care.into_iter().map(|remark| (NoteKind::Care, remark)));
                }
                Err(error) => own.push((NoteKind::LeftOut, (error.place(), error.remark()))),
            }
            remarks.extend(own.into_iter().map(|(kind, (what, why))| TrialRemark {
                path: making.shown(file),
                kind,
                what: strip_root(making.root, &what),
                why: why.into(),
            }));
        }
        Ok((rows, remarks))
    });
    let results = results.collect::<Result<Vec<_>, StoreError>>()?;
    let (rows, remarks): (Vec<_>, Vec<_>) = results.into_iter().unzip();
    let rows = rows.concat();
    let mut remarks = remarks.concat();
    // Those that are left out come first.
    remarks.sort_by_key(|remark| remark.kind == NoteKind::Care);

    let own = conditions.first().map_or(&[][..], |first| &first.stage.metrics.own);
    let in_space = conditions.first().is_some_and(|first| first.stage.metrics.axes.is_some());
    let mut metrics = zwidth_metrics::table(&rows, own, in_space)?;
    let (mut problems, mut care) = (Vec::new(), Vec::new());
    for TrialRemark { kind, what, why, .. } in &remarks {
        let sentence = format!("{what}: {why}");
        metrics = metrics.with_note_of(*kind, sentence.clone());
        match kind {
            NoteKind::LeftOut => problems.push(sentence),
            NoteKind::Care => care.push(sentence),
            // The other kinds are of tables, and no trial's.
            _ => {}
        }
    }
    let events = rows.iter().flat_map(|row| row.events.iter().map(|event| event.of(&row.meta)));
    let tables = [metrics, Table::of_rows(&events.collect::<Vec<_>>())?, Table::of_rows(&remarks)?];
    Ok(Made { care, ..write_tables(&tables, making, problems)? })
}

/// The tables of all sessions as one, with the metrics of other programs as further columns.
fn join_study(
    outside: &Option<Vec<Joined>>,
    (sessions, tables): &(Vec<Vec<PathBuf>>, Vec<Derived<OutsideValue>>),
    making: &Making,
) -> Result<Made, JobError> {
    let outside = outside.iter().flatten().zip(tables).map(|(joined, table)| joined.column(table));
    let outside = outside.collect::<Result<Vec<_>, _>>()?;
    let join = move |tables: &[PathBuf]| match outside.as_slice() {
        [] => join_tables(tables),
        outside => Ok(zwidth_metrics::join_outside(&join_tables(tables)?, outside)?),
    };
    Ok(join_sessions(sessions, join, making))
}

/// The two tables of a session as one.
pub(crate) fn join_tables(tables: &[PathBuf]) -> Result<Table, JobError> {
    let [plain, plant]: [Table; 2] =
        read_tables(tables)?.try_into().map_err(|_| "a session has two tables")?;
    let plain = zwidth_metrics::join_sessions(vec![plain])?.ok_or("there is no trial")?;
    Ok(zwidth_metrics::join_plant(&plain, &plant)?)
}

/// A movement that covers less than this share of its recording …
const LITTLE: f64 = 0.05;
/// … and leaves out more than this, s, may not be the one that was meant.
const LONG_S: f64 = 5.0;

/// The remark on a movement that covers little of its recording: subject and sentence.
fn covers_little(
    row: &TrialMetrics,
    trial: &OpenTrial,
    in_space: bool,
) -> Option<(String, String)> {
    let duration_s = row.movement.duration_s?;
    let t = trial.columns().column(Signal::Time)?;
    let recorded_s = t.last()? - t.first()?;
    let is_little = duration_s < LITTLE * recorded_s && recorded_s - duration_s > LONG_S;
    let said = match row.space.completion_s {
        // The movement in space tells how long it took: what is short is only the part along the push.
        Some(completion_s) => format!(
            "its movement along push is taken to be {duration_s:.2} s of the {recorded_s:.1} s that were recorded, and \
             duration_s and all else that says \"along push\" is of that alone; in all axes the movement lasts \
             {completion_s:.2} s (completion_s)"
        ),
        None => format!(
            "its movement{} is taken to be {duration_s:.2} s of the {recorded_s:.1} s that were recorded; look whether \
             this is the one that was meant, and set onset_deg_s and offset_deg_s under [analysis] of study.toml, or split \
             the recording",
            if in_space { " along push" } else { "" }
        ),
    };
    is_little.then(|| (format!("{}, {}", name(&trial.meta), Signal::ThetaDot.name()), said))
}

/// The remark on a finding of `verify` in a trial that counts all the same: subject and sentence.
fn describe(trial: &OpenTrial, finding: StoreError) -> (String, String) {
    let column = finding.column.map(|column| format!(", {column}")).unwrap_or_default();
    let row = finding.row.map(|row| format!(", row {row}")).unwrap_or_default();
    let what = format!("{}{column}{row}", name(&trial.meta));
    (what, format!("{}; {}", finding.what, finding.remedy))
}
