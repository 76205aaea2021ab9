//! Gives a table of a metric that another program computed, or withdraws it: file and line of the log as
//! one change.

use crate::form::outside::outside_bytes;
use crate::judge::outside::logged;
use crate::keep::commit::{Change, commit_events};
use crate::{Entered, Files, FirstErrors, Layout, OutsideRow, StoreError, hex_blake3, write_new};
use std::path::{Path, PathBuf};
use zwidth_study::{Event, MetricId, OutsideMetric};

/// Where a table of values came from.
#[derive(Debug, Clone, Copy)]
pub struct GivenFile<'a> {
    /// The name of the file that was given, without its folder.
    pub name: &'a str,
    /// Its BLAKE3, hexadecimal.
    pub blake3: &'a str,
}

/// The number of the next table of a metric from outside.
///
/// # Errors
/// A log that cannot be read to its end; a metric that counts with another unit.
pub fn next_table(
    files: &dyn Files,
    layout: &Layout,
    metric: &OutsideMetric,
) -> Result<u32, StoreError> {
    let before = logged(files, layout)?;
    let mut own = before.iter().filter(|entry| entry.metric.id == metric.id);
    let other = own.clone().find(|entry| entry.counts() && entry.metric.unit != metric.unit);
    if let Some(other) = other {
        let what = format!(
            "the metric {} has the unit {}, not {}",
            metric.id, other.metric.unit, metric.unit
        );
        let remedy =
            "give the values in that unit, choose another id, or withdraw the metric first";
        return Err(StoreError::new(&other.path, what, remedy));
    }
    // A file that no line speaks of keeps its number.
    let mut table = own.next_back().map_or(1, |last| last.table + 1);
    while files.kind(&layout.own_table(&metric.id, table)).is_some() {
        table += 1;
    }
    Ok(table)
}

/// Keeps a table of a metric from outside as its next one, and says so in the log: both, or neither. The path of the
/// table.
///
/// # Errors
/// A log that cannot be read to its end; a metric that counts with another unit; a value that is not finite; the write
/// that failed. Then nothing was given.
pub fn give_metric(
    files: &dyn Files,
    layout: &Layout,
    entered: Entered<'_>,
    metric: &OutsideMetric,
    rows: &[OutsideRow],
    from: GivenFile<'_>,
) -> Result<PathBuf, FirstErrors> {
    let table = next_table(files, layout, metric)?;
    let path = layout.own_table(&metric.id, table);
    let bytes = outside_bytes(metric, table, rows, &path)?;
    let blake3 = hex_blake3(&bytes);
    let event = Event::MetricGiven {
        metric: metric.id.clone(),
        table,
        unit: metric.unit.clone(),
        label: metric.label.clone(),
        better: metric.better,
        program: metric.program.clone(),
        file: from.name.to_owned(),
        file_blake3: from.blake3.to_owned(),
        blake3: blake3.clone(),
    };
    let log = layout.own_events();
    let events = [event];
    let change = Change::of(files, layout, entered, &[(&path, blake3)], &[(&log, &events)])?;
    change
        .make("given", || write_new(files, &path, &bytes))
        .map_err(|errors| errors.into_iter().collect::<FirstErrors>())?;
    Ok(path)
}

/// Says in the log that no table of a metric counts any more. The tables stay.
///
/// # Errors
/// A log that cannot be read to its end; a metric of which no table counts; the write that failed.
pub fn withdraw_metric(
    files: &dyn Files,
    layout: &Layout,
    entered: Entered<'_>,
    metric: &MetricId,
    reason: &str,
) -> Result<(), StoreError> {
    let log = layout.own_events();
    let before = logged(files, layout)?;
    let counting: Vec<&str> =
        before.iter().filter(|own| own.counts()).map(|own| own.metric.id.as_str()).collect();
    if !counting.contains(&metric.as_str()) {
        return Err(not_counting(&log, format!("a metric {metric}"), &counting));
    }
    let event = Event::MetricWithdrawn { metric: metric.clone(), reason: reason.to_owned() };
    commit_events(files, layout, entered, &[(&log, &[event])])
}

/// The error of withdrawing what has no table that counts; others that have one.
pub(crate) fn not_counting(log: &Path, named: String, counting: &[&str]) -> StoreError {
    let remedy = match counting.is_empty() {
        true => "there is nothing to withdraw".to_owned(),
        false => format!("name one of {}", counting.join(", ")),
    };
    StoreError::new(log, format!("no table of {named} counts"), remedy)
}
