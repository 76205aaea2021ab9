//! Stage `average`: one table a condition of a session; without a mean it is empty and its note says why.

use super::{Session, analysis_parameters, derived, made, paths, read_all, sessions};
use std::path::PathBuf;
use zwidth_average::AverageError;
use zwidth_runner::Job;
use zwidth_store::{StudyData, TrialEntry};
use zwidth_study::{Environment, Mode};

/// The average of a condition, if the session has trials of it.
pub(super) fn of_condition(
    data: &StudyData,
    session: &Session,
    environment: &Environment,
    mode: &Mode,
) -> Option<PathBuf> {
    if !session.of(environment).iter().any(|t| t.meta.mode == mode.id) {
        return None;
    }
    let name = format!("average/{}.{}.{}.parquet", session.key(), environment.id, mode.id);
    Some(derived(&data.layout, name))
}

/// Every average of the study.
pub(super) fn all(data: &StudyData) -> Vec<PathBuf> {
    jobs(data).into_iter().flat_map(|job| job.outputs).collect()
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    let mut jobs = Vec::new();
    for session in sessions(data) {
        for environment in &data.study.environments {
            for mode in &data.study.modes {
                let Some(output) = of_condition(data, &session, environment, mode) else { continue };
                let of_mode = |t: &&TrialEntry| t.meta.mode == mode.id;
                let trials: Vec<_> = session.of(environment).into_iter().filter(of_mode).collect();
                let name = format!("average {} {} {}", session.who(), environment.id, mode.id);
                jobs.push(job(data, name, paths(&trials), output));
            }
        }
    }
    jobs
}

fn job(data: &StudyData, name: String, inputs: Vec<PathBuf>, output: PathBuf) -> Job<'_> {
    let (files, out) = (inputs.clone(), vec![output.clone()]);
    Job {
        stage: "average",
        name,
        version: zwidth_average::VERSION,
        parameters: analysis_parameters(data),
        inputs,
        outputs: vec![output],
        tolerant: false,
        make: Box::new(move |from| {
            let (trials, problems) = read_all(&files);
            let table = match zwidth_average::average(&trials, &data.study) {
                Ok(average) => zwidth_average::table(&[average])?,
                Err(AverageError::WhyNot(why)) => {
                    zwidth_average::table(&[])?.with_note(sentence(&why.to_string()))
                }
                Err(error) => return Err(error.into()),
            };
            made(&[table], &out, from, problems)
        }),
    }
}

/// A reason as a sentence.
fn sentence(reason: &str) -> String {
    let mut letters = reason.chars();
    let first = letters.next().map(|c| c.to_uppercase().collect::<String>()).unwrap_or_default();
    format!("{first}{}.", letters.as_str().trim_end_matches('.'))
}
