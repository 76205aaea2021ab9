//! Stage `metrics`: a table a condition of a session, then one of the whole study. A changed trial leaves the tables of the
//! other conditions as they are, and so the figures that take their onsets from there.

use super::{Repeats, analysis_parameters, derived, joined, known, made, paths, read_all, repeats, split};
use rayon::prelude::*;
use std::path::PathBuf;
use zwidth_runner::Job;
use zwidth_store::{Layout, Signal, StudyData};
use zwidth_tables::Table;

const STAGE: &str = "metrics";

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
        parameters: format!("{}; {:?}; {}", analysis_parameters(data), protocol(data), known(&trials)),
        inputs: paths(&trials),
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let (trials, mut problems) = read_all(&trials, Signal::all());
            let one = |t| {
                let row = zwidth_metrics::trial_metrics(t, &data.study);
                row.map_err(|e| {
                    format!("{} {} trial {}: {e}", t.meta.participant, t.meta.session, t.meta.trial)
                })
            };
            let (rows, more) = split(trials.par_iter().map(one).collect());
            problems.extend(more);
            made(&[zwidth_metrics::table(&rows)?], &out, from, problems)
        }),
    }
}

/// What the compliance of a trial depends on besides its file: the time allowed, and which modes have a motor.
fn protocol(data: &StudyData) -> impl std::fmt::Debug {
    let study = &data.study;
    let actuators: Vec<_> = study.modes.iter().map(|m| (&m.id, m.motor_max_v, m.brake_max_v)).collect();
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
            let tables = files.iter().map(|f| Table::from_parquet(f)).collect::<Result<Vec<_>, _>>()?;
            let all = zwidth_metrics::together(&tables)?.ok_or("there is no trial")?;
            let conditions = zwidth_metrics::by_condition(&all, &conditions)?;
            made(&[all, conditions], &out, from, Vec::new())
        }),
    }
}
