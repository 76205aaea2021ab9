//! Stage `metrics`: a table a condition of a session, then one of the whole study. A changed trial
//! leaves the tables of the other conditions as they are, and so the figures that take their onsets
//! from there.

use super::{
    Repeats, analysis_parameters, derived, joined, known, made, name, paths, plain, read_all,
    repeats, split,
};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use zwidth_report::Remark;
use zwidth_runner::{Job, Made};
use zwidth_store::{Layout, Signal, StoreError, StudyData, Trial, check_samples};
use zwidth_tables::Table;

const STAGE: &str = "metrics";
/// Version of the notes under the tables of conditions: raised when one would be written
/// differently.
const NOTES: u32 = 1;
/// How a note begins that is about something left out; the others are about what is to be read with
/// care.
const LEFT_OUT: &str = "left out: ";

/// The metrics of a condition, `metrics/P01.S01.spring.hybrid.parquet`.
pub(super) fn of_condition(layout: &Layout, repeats: &Repeats) -> PathBuf {
    derived(layout, format!("metrics/{}.parquet", repeats.key))
}

/// The metrics of the study.
pub(super) fn of_study(layout: &Layout) -> PathBuf {
    derived(layout, "metrics.parquet")
}

/// The metrics of the study, by condition.
pub(super) fn by_condition(layout: &Layout) -> PathBuf {
    derived(layout, "conditions.parquet")
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let conditions = repeats(data).into_iter().map(|repeats| condition_job(data, repeats));
    joined(conditions.collect(), |tables| study_job(data, tables))
}

fn condition_job<'a>(data: &'a StudyData, repeats: Repeats<'a>) -> Job<'a> {
    let outputs = vec![of_condition(&data.layout, &repeats)];
    let (out, trials) = (outputs.clone(), repeats.trials);
    Job {
        stage: STAGE,
        name: format!("metrics {}", repeats.who),
        version: zwidth_metrics::VERSION,
        parameters: format!(
            "{}; {:?}; {}; notes {NOTES}",
            analysis_parameters(data),
            protocol(data),
            known(&trials)
        ),
        inputs: paths(&trials),
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let (trials, mut problems) = read_all(&trials, Signal::all());
            let one = |t| {
                let row = zwidth_metrics::trial_metrics(t, &data.study);
                row.map_err(|e| format!("{}: {e}", name(&t.meta)))
            };
            let (rows, more) = split(trials.par_iter().map(one).collect());
            problems.extend(more);
            let care: Vec<String> = trials.iter().flat_map(|t| care(data, t)).collect();
            let left_out =
                problems.iter().map(|problem| format!("{LEFT_OUT}{}", plain(data, problem)));
            let notes = left_out.chain(care.iter().cloned());
            let table = notes.fold(zwidth_metrics::table(&rows)?, Table::with_note);
            Ok(Made { care, ..made(&[table], &out, from, problems)? })
        }),
    }
}

/// What `verify` finds in a trial's samples, which count all the same.
fn care(data: &StudyData, trial: &Trial) -> Vec<String> {
    let found = check_samples(&data.study, Path::new(""), &trial.samples);
    let words = |f: StoreError| {
        let column = f.column.map(|column| format!(", {column}")).unwrap_or_default();
        let row = f.row.map(|row| format!(", row {row}")).unwrap_or_default();
        format!("{}{column}{row}: {}", name(&trial.meta), f.what)
    };
    found.into_iter().map(words).collect()
}

/// What the notes under a condition's table say: what was left out of it, or else what in it is to
/// be read with care.
pub(super) fn told(note: &str) -> Result<Remark, Remark> {
    let remark = |text: &str| {
        let (what, why) = text.split_once(": ").unwrap_or((STAGE, text));
        Remark { what: what.to_owned(), why: why.to_owned() }
    };
    note.strip_prefix(LEFT_OUT).map(remark).ok_or_else(|| remark(note))
}

/// The tables with such notes.
pub(super) fn of_conditions(planned: &[Job]) -> Vec<PathBuf> {
    let conditions = planned.iter().filter(|job| job.stage == STAGE && job.outputs.len() == 1);
    conditions.flat_map(|job| job.outputs.iter().cloned()).collect()
}

/// What the compliance of a trial depends on besides its file: the time allowed, and which modes
/// have a motor.
fn protocol(data: &StudyData) -> impl std::fmt::Debug {
    let study = &data.study;
    let actuators: Vec<_> =
        study.modes.iter().map(|m| (&m.id, m.motor_max_v, m.brake_max_v)).collect();
    (study.design.trial_limit_s, actuators)
}

fn study_job<'a>(data: &'a StudyData, inputs: Vec<PathBuf>) -> Job<'a> {
    let outputs = vec![of_study(&data.layout), by_condition(&data.layout)];
    let conditions = data.study.conditions();
    let (files, out) = (inputs.clone(), outputs.clone());
    Job {
        stage: STAGE,
        name: "metrics of the study".to_owned(),
        version: zwidth_metrics::VERSION,
        parameters: format!("{conditions:?}"),
        inputs,
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let tables =
                files.iter().map(|f| Table::from_parquet(f)).collect::<Result<Vec<_>, _>>()?;
            let all = zwidth_metrics::together(&tables)?.ok_or("there is no trial")?;
            let conditions = zwidth_metrics::by_condition(&all, &conditions)?;
            made(&[all, conditions], &out, from, Vec::new())
        }),
    }
}
