//! The tables of metrics that other programs computed, compared with the log that has the hash of each and
//! with the recordings that they speak of.

use crate::disk::walk::parquet_below;
use crate::form::change_list::pending;
use crate::form::events::read_lines_to;
use crate::form::outside::read_outside;
use crate::{Entry, Files, Layout, RealFiles, StoreError, TrialEntry};
use std::collections::BTreeMap;
use std::path::PathBuf;
use zwidth_study::{Event, ExperimenterId, MetricId, OutsideMetric, ParticipantId, SessionId};

/// Which trial of the study.
type TrialName = (ParticipantId, SessionId, u32);

/// A table of a metric that another program computed, as the log has it.
#[derive(Debug, Clone, PartialEq)]
pub struct OutsideEntry {
    /// The metric, with unit, label and program.
    pub metric: OutsideMetric,
    /// The number of the table, from 1.
    pub table: u32,
    /// Its file.
    pub path: PathBuf,
    /// BLAKE3 of its file, hexadecimal.
    pub blake3: String,
    /// The name of the file that was given.
    pub file: String,
    /// BLAKE3 of the file that was given, hexadecimal.
    pub file_blake3: String,
    /// When, UTC, RFC 3339.
    pub utc: String,
    /// Who gave it.
    pub by: Option<ExperimenterId>,
    /// Why it does not count; `None` if it does.
    pub why_not: Option<String>,
    /// How many trials have a row.
    pub rows: usize,
    /// The trials whose recordings are other ones than those it speaks of, or are gone: of these nothing counts.
    pub outdated: Vec<TrialName>,
}

impl OutsideEntry {
    /// Whether its values enter results.
    pub fn counts(&self) -> bool {
        self.why_not.is_none()
    }
}

/// Every table of a metric from outside that the study's log speaks of, in its order; none of their files is read.
///
/// # Errors
/// A log that is damaged.
pub fn outside_log(layout: &Layout) -> Result<Vec<OutsideEntry>, StoreError> {
    logged(&RealFiles, layout)
}

/// Every table that the log speaks of, in its order. The last of a metric counts, unless it was withdrawn.
///
/// # Errors
/// A log that is damaged; a line that declares no metric.
pub(crate) fn logged(files: &dyn Files, layout: &Layout) -> Result<Vec<OutsideEntry>, StoreError> {
    let log = layout.own_events();
    let mut entries: Vec<OutsideEntry> = Vec::new();
    let most = pending(files, layout).get(&log).copied();
    for (row, line) in read_lines_to(files, &log, most)?.into_iter().enumerate() {
        match line.event {
            Event::MetricGiven {
                metric,
                table,
                unit,
                label,
                better,
                program,
                file,
                file_blake3,
                blake3,
            } => {
                let path = layout.own_table(&metric, table);
                let declared = OutsideMetric::new(metric, &unit, &label).map_err(|what| {
                    let remedy = "another version of zwidth wrote the line: use that one";
                    StoreError::new(&log, what, remedy).row0(row)
                })?;
                let metric = OutsideMetric { better, program, ..declared };
                leave_out(&mut entries, &metric.id, &format!("table {table} took its place"));
                entries.push(OutsideEntry {
                    metric,
                    table,
                    path,
                    blake3,
                    file,
                    file_blake3,
                    utc: line.utc,
                    by: line.by,
                    why_not: None,
                    rows: 0,
                    outdated: Vec::new(),
                });
            }
            Event::MetricWithdrawn { metric, reason } => {
                leave_out(&mut entries, &metric, &format!("withdrawn: {reason}"));
            }
            _ => {
                let what = "the line is no event of a metric";
                return Err(StoreError::new(&log, what, "restore the log from a copy").row0(row));
            }
        }
    }
    Ok(entries)
}

/// Says why the table of a metric that counted so far does so no more.
fn leave_out(entries: &mut [OutsideEntry], metric: &MetricId, why: &str) {
    let of_metric = entries.iter_mut().filter(|entry| entry.metric.id == *metric);
    for entry in of_metric.filter(|entry| entry.counts()) {
        entry.why_not = Some(why.to_owned());
    }
}

/// The tables that are, by the log, the ones that were given; what does not fit; and what is to be read with care.
pub(crate) fn outside_tables(
    files: &dyn Files,
    layout: &Layout,
    trials: &[TrialEntry],
) -> OutsideTables {
    let mut found = OutsideTables::default();
    let entries = match logged(files, layout) {
        Ok(entries) => entries,
        Err(error) => {
            found.problems.push(error);
            return found;
        }
    };
    let known = |path: &PathBuf| entries.iter().any(|entry| entry.path == *path);
    match parquet_below(files, &layout.own()) {
        Ok(paths) => found.problems.extend(paths.iter().filter(|path| !known(path)).map(|path| {
            let what = "the log of the metrics from outside does not mention it: left out";
            StoreError::new(path, what, "give the table with `zwidth metric`, and remove this file")
        })),
        Err(error) => found.problems.push(error),
    }
    let recordings: BTreeMap<_, &str> = trials
        .iter()
        .map(|own| {
            ((&own.meta.participant, &own.meta.session, own.meta.trial), own.blake3.as_str())
        })
        .collect();
    for mut entry in entries {
        let restore = "restore the file from a copy, or give the table again";
        if files.kind(&entry.path) != Some(Entry::File) {
            let what = "the log knows the table of a metric, but its file is missing";
            found.problems.push(StoreError::new(&entry.path, what, restore));
            continue;
        }
        let rows = match read_outside(files, &entry.path, &entry.metric.unit) {
            Ok((rows, blake3)) if blake3 == entry.blake3 => rows,
            Ok(_) => {
                let what =
                    "the file is not the table that was given: its hash differs from the log";
                found.problems.push(StoreError::new(&entry.path, what, restore));
                continue;
            }
            Err(error) => {
                found.problems.push(error);
                continue;
            }
        };
        entry.rows = rows.len();
        for row in rows {
            let name = (&row.participant, &row.session, row.trial);
            if recordings.get(&name) != Some(&row.recording.as_str()) {
                entry.outdated.push((row.participant, row.session, row.trial));
            }
        }
        if let Some((participant, session, trial)) =
            entry.outdated.first().filter(|_| entry.counts())
        {
            let what = format!(
                "of its {} trials {} have a recording that changed since the values were computed, or that cannot be \
                 read: their values are left out; the first is {participant} {session} trial {trial}",
                entry.rows,
                entry.outdated.len()
            );
            let remedy =
                "restore the recordings, or compute the metric anew and give the table again";
            found.warnings.push(StoreError::new(&entry.path, what, remedy));
        }
        found.entries.push(entry);
    }
    found
}

/// What was found below `raw/<study>/own`.
#[derive(Debug, Default)]
pub(crate) struct OutsideTables {
    pub(crate) entries: Vec<OutsideEntry>,
    pub(crate) problems: Vec<StoreError>,
    pub(crate) warnings: Vec<StoreError>,
}
