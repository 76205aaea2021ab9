//! Stage `average`: two tables a condition of a session, one for each alignment; without a mean they are empty and
//! their note says why.

use super::{JobError, Session, analysis_parameters, derived, known, made, paths, read_all, sessions};
use std::path::PathBuf;
use zwidth_average::{Alignment, AverageError};
use zwidth_runner::Job;
use zwidth_store::{StudyData, Trial, TrialEntry};
use zwidth_study::{Environment, Mode};
use zwidth_tables::Table;

/// The average of a condition with the alignment asked for, if the session has trials of it:
/// `average/P01.S01.spring.hybrid.parquet` at onset, `….hybrid.landmarks.parquet` by landmarks.
pub(super) fn aligned(
    data: &StudyData,
    session: &Session,
    environment: &Environment,
    mode: &Mode,
    alignment: Alignment,
) -> Option<PathBuf> {
    if !session.of(environment).iter().any(|t| t.meta.mode == mode.id) {
        return None;
    }
    let suffix = match alignment {
        Alignment::Onset => "",
        Alignment::Landmarks => ".landmarks",
    };
    let name = format!("average/{}.{}.{}{suffix}.parquet", session.key(), environment.id, mode.id);
    Some(derived(&data.layout, name))
}

/// Every average of the study aligned at onset: what the summary speaks of.
pub(super) fn all(data: &StudyData) -> Vec<PathBuf> {
    jobs(data).into_iter().filter_map(|job| job.outputs.into_iter().next()).collect()
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let mut jobs = Vec::new();
    for session in sessions(data) {
        for environment in &data.study.environments {
            for mode in &data.study.modes {
                let of = |alignment| aligned(data, &session, environment, mode, alignment);
                let outputs: Vec<PathBuf> = Alignment::ALL.into_iter().filter_map(of).collect();
                if outputs.is_empty() {
                    continue;
                }
                let of_mode = |t: &&TrialEntry| t.meta.mode == mode.id;
                let trials: Vec<_> = session.of(environment).into_iter().filter(of_mode).collect();
                let name = format!("average {} {} {}", session.who(), environment.id, mode.id);
                jobs.push(job(data, name, trials, outputs));
            }
        }
    }
    jobs
}

fn job<'a>(data: &'a StudyData, name: String, trials: Vec<&'a TrialEntry>, outputs: Vec<PathBuf>) -> Job<'a> {
    let out = outputs.clone();
    Job {
        stage: "average",
        name,
        version: zwidth_average::VERSION,
        parameters: format!("{}; {}", analysis_parameters(data), known(&trials)),
        inputs: paths(&trials),
        outputs,
        tolerant: false,
        make: Box::new(move |from| {
            let (trials, problems) = read_all(&trials);
            let average = |alignment| average(&trials, data, alignment);
            let tables = Alignment::ALL.into_iter().map(average).collect::<Result<Vec<_>, _>>()?;
            made(&tables, &out, from, problems)
        }),
    }
}

/// The average's table; where there is none and no fault, an empty one that says why.
fn average(trials: &[Trial], data: &StudyData, alignment: Alignment) -> Result<Table, JobError> {
    match zwidth_average::average(trials, &data.study, alignment) {
        Ok(average) => Ok(zwidth_average::table(&[average])?),
        Err(AverageError::WhyNot(why)) => {
            Ok(zwidth_average::table(&[])?.with_note(sentence(&why.to_string())))
        }
        Err(error) => Err(error.into()),
    }
}

/// A reason as a sentence.
fn sentence(reason: &str) -> String {
    let mut letters = reason.chars();
    let first = letters.next().map(|c| c.to_uppercase().collect::<String>()).unwrap_or_default();
    format!("{first}{}.", letters.as_str().trim_end_matches('.'))
}
