//! Stage `trials`: which trials count, in a file that other programs read before they read a recording.

use crate::making::{derived, write_tables};
use crate::metrics;
use crate::summary::notes;
use crate::trials::name;
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::PathBuf;
use zwidth_runner::{Job, JobError, Made, Making, Stage};
use zwidth_store::{DOUBTS, Findings, LOST, StudyData, TrialEntry};
use zwidth_study::TrialMeta;
use zwidth_tables::{Column, NoteKind, Table};

/// Its version is raised when the table would be another one of the same data.
const STAGE: Stage = Stage { name: "trials", version: 1 };

/// A trial of the table.
#[derive(Serialize)]
struct Row {
    meta: TrialMeta,
    /// From the folder that holds the data, with `/` on every system.
    path: String,
    why_not: Option<String>,
    /// Whether something was found in it without its samples being read.
    is_doubted: bool,
}

pub(crate) fn job(data: &StudyData, found: &Findings) -> Job {
    let doubted: BTreeSet<_> =
        found.with_care.iter().map(|finding| finding.path.as_path()).collect();
    let row = |trial: &TrialEntry| Row {
        meta: trial.meta.clone(),
        path: data.layout.shown(&trial.path).to_string_lossy().replace('\\', "/"),
        why_not: trial.why_not(),
        is_doubted: doubted.contains(&*trial.path)
            || [LOST, DOUBTS].iter().any(|key| trial.said.file.contains_key(*key)),
    };
    let rows: Vec<Row> = data.trials.iter().map(row).collect();
    let logs = data.sessions.iter().flat_map(|s| [&s.path, &s.events_path]);
    let origins: Vec<_> = data
        .trials
        .iter()
        .map(|trial| trial.path.clone())
        .chain(logs.map(|path| path.as_path().into()))
        .collect();
    let output = derived(&data.layout, "trials.parquet");
    Job::new(STAGE, "trials", rows, metrics::of_sessions(data), vec![output], make)
        .told_by(origins)
        .tolerant()
}

fn make(rows: &Vec<Row>, sessions: &Vec<PathBuf>, making: &Making) -> Result<Made, JobError> {
    // A note of a trial begins with its name, and what follows with a comma or a colon.
    let notes = notes(sessions, |kind| kind == NoteKind::Care)?;
    let doubted: BTreeSet<&str> =
        notes.iter().filter_map(|note| note.split([',', ':']).next()).collect();
    let with_care = |row: &Row| row.is_doubted || doubted.contains(name(&row.meta).as_str());
    let text = |name: &'static str, about: &'static str, of: fn(&Row) -> &str| {
        Column::text(name, about, rows.iter().map(|row| Some(of(row))))
    };
    let number = |name: &'static str, about: &'static str, of: fn(&Row) -> u32| {
        Column::integer(name, "1", about, rows.iter().map(|row| Some(of(row).into())))
    };
    let counts = rows.iter().map(|row| Some(row.why_not.is_none()));
    let care = rows.iter().map(|row| Some(row.why_not.is_none() && with_care(row)));
    let columns = vec![
        text("path", "the trial's file, from the folder that holds raw/", |row| &row.path),
        text("participant", "who", |row| row.meta.participant.as_str()),
        text("session", "in which session", |row| row.meta.session.as_str()),
        number("trial", "its number in the session", |row| row.meta.trial),
        number("repeat", "of its condition", |row| row.meta.repeat),
        text("environment", "what was rendered", |row| row.meta.environment.as_str()),
        text("mode", "how it was rendered; a code while the session is sealed", |row| {
            row.meta.mode.as_str()
        }),
        text("kind", "trial or familiarisation", |row| row.meta.kind.as_str()),
        text("status", "complete or incomplete", |row| row.meta.status.as_str()),
        text("source", "where its numbers come from", |row| row.meta.source.as_str()),
        Column::flag("counts", "whether it enters any mean, metric or test", counts),
        Column::text(
            "why_not",
            "why it does not count; null if it does",
            rows.iter().map(|row| row.why_not.as_deref()),
        ),
        Column::flag("read_with_care", "whether it counts and something was found in it", care),
    ];
    let table = Table::new("trials", "Every trial, and whether it counts", columns)?;
    write_tables(&[table], making, Vec::new())
}
