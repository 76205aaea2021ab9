//! Stage `likert`: tallies by question, and by group of questions; the answers themselves.

use crate::making::{derived, write_tables};
use serde::Serialize;
use std::path::PathBuf;
use zwidth_likert::Scheme;
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{Answer, StudyData};

const STAGE: Stage = Stage { name: "likert", version: zwidth_likert::VERSION };

/// Everything that a tally depends on: the answers are joined from several files, and are
/// not a file themselves.
#[derive(Serialize)]
struct Asked {
    scheme: Scheme,
    answers: Vec<Answer>,
}

/// The tallies of the study, if there is an answer.
pub(crate) fn tally(data: &StudyData) -> Option<PathBuf> {
    (!data.answers().is_empty()).then(|| derived(&data.layout, "likert.parquet"))
}

/// Every answer of the study, one row each, if there is one.
pub(crate) fn long(data: &StudyData) -> Option<PathBuf> {
    (!data.answers().is_empty()).then(|| derived(&data.layout, "answers.parquet"))
}

/// Files an answer can stand in: trials that count, session records, event logs.
fn origins(data: &StudyData) -> Vec<PathBuf> {
    let trials = data.counting().map(|t| t.path.clone());
    let logs = data.sessions.iter().flat_map(|s| [s.path.clone(), s.events_path.clone()]);
    trials.chain(logs).collect()
}

pub(crate) fn jobs(data: &StudyData) -> Vec<Job> {
    let job = |output: PathBuf| {
        let asked = Asked { scheme: Scheme::of(&data.study), answers: data.answers() };
        let outputs = [Some(output), long(data)].into_iter().flatten().collect();
        let job = Job::new(STAGE, "likert tallies", asked, (), outputs, make);
        job.told_by(origins(data))
    };
    tally(data).map(job).into_iter().collect()
}

fn make(asked: &Asked, (): &(), making: &Making) -> Result<Made, JobError> {
    let Asked { scheme, answers } = asked;
    write_tables(
        &[zwidth_likert::tally(answers, scheme)?, zwidth_likert::long(answers, scheme)?],
        making,
        Vec::new(),
    )
}
