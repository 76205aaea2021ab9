//! Stage `likert`: tallies by question, and by group of questions; the answers themselves.

use super::{derived, made};
use std::path::PathBuf;
use zwidth_runner::Job;
use zwidth_store::{Layout, StudyData, hex_blake3};

/// The tallies of the study.
pub(super) fn tally_of(layout: &Layout) -> PathBuf {
    derived(layout, "likert.parquet")
}

/// Every answer of the study, one row each.
fn answers_of(layout: &Layout) -> PathBuf {
    derived(layout, "answers.parquet")
}

/// Files an answer can stand in: trials that count, session records, event logs.
fn inputs(data: &StudyData) -> Vec<PathBuf> {
    let trials = data.counting().map(|t| t.path.clone());
    let logs = data.sessions.iter().flat_map(|s| [s.path.clone(), s.events_path.clone()]);
    trials.chain(logs).collect()
}

pub(super) fn jobs(data: &StudyData) -> Vec<Job<'_>> {
    if data.answers().is_empty() {
        return Vec::new();
    }
    let outputs = vec![tally_of(&data.layout), answers_of(&data.layout)];
    let out = outputs.clone();
    let make = move |from: &_| {
        let answers = data.answers();
        let tables = [zwidth_likert::tally(&answers, &data.study)?, zwidth_likert::long(&answers)?];
        made(&tables, &out, from, Vec::new())
    };
    vec![Job {
        stage: "likert",
        name: "likert tallies".to_owned(),
        version: zwidth_likert::VERSION,
        parameters: hex_blake3(
            format!("{:?}", (&data.study.questions, data.study.conditions(), data.answers()))
                .as_bytes(),
        ),
        inputs: inputs(data),
        outputs,
        tolerant: false,
        make: Box::new(make),
    }]
}
