//! Stage `trials`: which trials count, in a file that other programs read before they read a recording.

use crate::metrics;
use crate::page::summary;
use crate::shared::handle::Derived;
use crate::shared::making::{derived, write_tables};
use crate::shared::trials::origins;
use serde::Serialize;
use std::collections::BTreeSet;
use zwidth_results::{CountedTrial, NoteKind, TrialRemark};
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{DOUBTS, Findings, LOST, StudyData};
use zwidth_study::TrialMeta;
use zwidth_tables::Table;

/// Its version is raised when the same data would give another table.
const STAGE: Stage = Stage { name: "trials", version: 1 };

/// A trial of the table.
#[derive(Serialize)]
struct Row {
    meta: TrialMeta,
    /// From the folder that holds the data, with `/` on every system.
    path: String,
    why_not: Option<String>,
    /// Whether there is a finding about it that needs none of its samples.
    is_doubted: bool,
}

pub(crate) fn job(data: &StudyData, findings: &Findings) -> Job {
    let doubted: BTreeSet<_> =
        findings.with_care.iter().map(|finding| finding.path.as_path()).collect();
    let rows = data.trials.iter().map(|trial| Row {
        meta: trial.meta.clone(),
        path: data.layout.shown(&trial.path).to_string_lossy().replace('\\', "/"),
        why_not: trial.why_not(),
        is_doubted: doubted.contains(&*trial.path)
            || [LOST, DOUBTS].iter().any(|key| trial.said.file.contains_key(*key)),
    });
    let rows: Vec<Row> = rows.collect();
    let output = derived(&data.layout, "trials.parquet");
    // Where the rows come from is no input: of all that these files hold, only the rows matter.
    Job::new(STAGE, "trials", rows, metrics::remarks(data), vec![output], make)
        .told_by(origins(data))
        .tolerant()
}

fn make(
    rows: &Vec<Row>,
    remarks: &Vec<Derived<TrialRemark>>,
    making: &Making,
) -> Result<Made, JobError> {
    let remarks = summary::remarks(remarks)?;
    let with_care = remarks.iter().filter(|remark| remark.kind == NoteKind::Care);
    let doubted: BTreeSet<&str> = with_care.map(|remark| remark.path.as_str()).collect();
    let counted = rows.iter().map(|row| {
        let TrialMeta { participant, session, trial, repeat, .. } = row.meta.clone();
        let TrialMeta { environment, mode, kind, status, source, .. } = row.meta.clone();
        let is_doubted = row.is_doubted || doubted.contains(row.path.as_str());
        CountedTrial {
            path: row.path.clone(),
            participant,
            session,
            trial,
            repeat,
            environment,
            mode,
            kind,
            status,
            source,
            counts: row.why_not.is_none(),
            why_not: row.why_not.clone(),
            read_with_care: row.why_not.is_none() && is_doubted,
        }
    });
    let counted: Vec<CountedTrial> = counted.collect();
    write_tables(&[Table::of_rows(&counted)?], making, Vec::new())
}
