//! Stage `metrics`: a table a session, then one of the whole study.

use super::{Session, analysis_parameters, derived, known, made, paths, read_all, sessions, split};
use rayon::prelude::*;
use std::path::PathBuf;
use zwidth_runner::Job;
use zwidth_store::{Layout, StudyData};
use zwidth_tables::Table;

const STAGE: &str = "metrics";

/// The metrics of one session.
pub(super) fn of_session(layout: &Layout, session: &Session) -> PathBuf {
    derived(layout, format!("metrics/{}.parquet", session.key()))
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
    let sessions = sessions(data);
    let mut jobs: Vec<Job> = sessions.iter().map(|s| session_job(data, s)).collect();
    if !jobs.is_empty() {
        jobs.push(study_job(data, sessions.iter().map(|s| of_session(&data.layout, s)).collect()));
    }
    jobs
}

fn session_job<'a>(data: &'a StudyData, session: &Session<'a>) -> Job<'a> {
    let outputs = vec![of_session(&data.layout, session)];
    let (trials, out) = (session.trials.clone(), outputs.clone());
    Job {
        stage: STAGE,
        name: format!("metrics {}", session.who()),
        version: zwidth_metrics::VERSION,
        parameters: format!("{}; {:?}; {}", analysis_parameters(data), protocol(data), known(&trials)),
        inputs: paths(&trials),
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let (trials, mut problems) = read_all(&trials);
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
            let all = Table::concat("metrics", "Metrics, one row a trial", &tables)?
                .ok_or("there is no session")?;
            let conditions = zwidth_metrics::by_condition(&all, &conditions)?;
            made(&[all, conditions], &out, from, Vec::new())
        }),
    }
}
