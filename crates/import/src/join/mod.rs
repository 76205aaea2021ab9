//! What other programs wrote beside a recording, joined to its rows: a log with a row per trial, and second files of the
//! same trials.
//!
//! A column of a log is a further column of the recording, `NAME@log`, of which each row has the cell of the log's row that
//! belongs to it. One of a second file is `NAME@ID`, put on the times of the recording as the mapping says. Whatever reads
//! columns of recordings reads these, and knows nothing of the files.

mod log;
mod named;
mod once;
mod second;
#[cfg(test)]
mod tests;
mod times;

use super::check_beside::{LOG, of_file};
use super::context::Context;
use super::errors::Errors;
use super::limits::{Budget, Take};
use super::mapping::{At, Beside, FileBeside, LogFrom, RowBy, Who, WithFrom};
use super::plan::Plan;
use super::recording::Recording;
use super::shape::Resample;
use super::table::ColumnRef;
use named::Named;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use zwidth_store::StoreError;

pub(super) use once::{Uses, check};

/// Joins files to recordings, as a mapping says.
pub(super) struct Joiner<'a> {
    beside: &'a Beside,
    named: Named<'a>,
    /// Logs that were read: many recordings have one.
    logs: Mutex<BTreeMap<PathBuf, Arc<Recording>>>,
}

impl Beside {
    /// Whether a column is of one of the files that are joined.
    pub(super) fn is_of_file(&self, column: &ColumnRef) -> bool {
        of_file(column).is_some_and(|(file, _)| {
            (file == LOG && self.log.is_some()) || self.with.iter().any(|with| with.id == file)
        })
    }

    /// What a join makes of the columns `named`, in words, for reports and files.
    pub(super) fn words(&self, named: &[&ColumnRef]) -> Vec<String> {
        let of = |file: &str| {
            let mut names: Vec<String> = Vec::new();
            for column in named {
                let name = column.to_string();
                if of_file(column).is_some_and(|(other, _)| other == file) && !names.contains(&name)
                {
                    names.push(name);
                }
            }
            names.join(", ")
        };
        let log = self.log.as_ref().map(|LogFrom { by, .. }| {
            let by = match by {
                RowBy::Number { column, add, .. } => match add {
                    0 => format!("with the trial's number in {column}"),
                    add => format!("with the trial's number in {column}, to which {add} is added"),
                },
                RowBy::Time { offset_s, at, .. } => {
                    let at = match at {
                        At::Begin => "with which the trial begins",
                        At::End => "with which the trial ends",
                        At::Within => "that lies within the recording",
                    };
                    format!("{at}, by its time and {offset_s} s")
                }
            };
            format!("{} of the row of a log {by}", of(LOG))
        });
        let seconds = self.with.iter().map(|WithFrom { id, offset_s, resample, .. }| {
            let how = match resample {
                None => "at the times of both",
                Some(Resample::Previous) => "as the last sample before has it",
                Some(Resample::Linear) => "on the line between its samples",
            };
            format!("{} of a second file {how}, by its times and {offset_s} s", of(id))
        });
        log.into_iter().chain(seconds).collect()
    }
}

impl<'a> Joiner<'a> {
    /// Joins files to recordings that become trials by `plan`; `named` are all columns of the mapping.
    pub(super) fn new(
        beside: &'a Beside,
        who: &'a Who,
        plan: &'a Plan<'a>,
        budget: &'a Budget,
        splits_at: bool,
        named: Vec<&'a ColumnRef>,
    ) -> Self {
        let (of_files, own) = named.into_iter().partition(|column| beside.is_of_file(column));
        let labels =
            who.columns().into_iter().filter(|column| !beside.is_of_file(column)).collect();
        let named = Named { plan, budget, splits_at, own, labels, of_files };
        Self { beside, named, logs: Mutex::default() }
    }

    /// Adds the columns of files to those of a recording, whose own time was read.
    ///
    /// # Errors
    /// A file that cannot be read or has no such column; times that do not meet; a trial without a row, or with two.
    pub(super) fn join(
        &self,
        context: &Context,
        recording: &mut Recording,
    ) -> Result<Uses, Errors> {
        let Beside { log, with, .. } = self.beside;
        let mut uses = Uses::default();
        if log.is_none() && with.is_empty() {
            return Ok(uses);
        }
        let mut own = Vec::new();
        for column in &self.named.own {
            own.push(recording.find(column)?);
        }
        let height = recording.height(&own, &[])?;
        let by_time = !with.is_empty()
            || log.as_ref().is_some_and(|log| matches!(log.by, RowBy::Time { .. }));
        let times = match by_time {
            true => times::of_recording(recording, self.named.plan, height)?,
            false => Vec::new(),
        };
        for with in with {
            let other = self.read(context, recording, &with.file, &self.columns_of(with))?;
            uses.seconds.push(second::join(&self.named, with, recording, other, &times)?);
        }
        if let Some(from) = log {
            let path = path_of(recording, &from.file)?;
            let known =
                self.logs.lock().unwrap_or_else(PoisonError::into_inner).get(&path).cloned();
            let table = match known {
                Some(table) => table,
                None => {
                    let table = Arc::new(self.read(
                        context,
                        recording,
                        &from.file,
                        &self.columns_of_log(from),
                    )?);
                    let mut logs = self.logs.lock().unwrap_or_else(PoisonError::into_inner);
                    logs.insert(path, Arc::clone(&table));
                    table
                }
            };
            let mut labels = Vec::new();
            for column in &self.named.labels {
                labels.push(recording.find(column)?);
            }
            uses.log =
                Some(log::join(&self.named, from, recording, &table, &labels, &times, height)?);
        }
        Ok(uses)
    }

    fn columns_of(&self, with: &WithFrom) -> Vec<ColumnRef> {
        let own = self.named.of(&with.id).map(|(_, column)| column);
        own.chain(times::column(&with.clock).cloned()).collect()
    }

    fn columns_of_log(&self, from: &LogFrom) -> Vec<ColumnRef> {
        let key = match &from.by {
            RowBy::Number { column, .. } => vec![column],
            RowBy::Time { clock, until, .. } => {
                times::column(clock).into_iter().chain(until).collect()
            }
        };
        let only = from.only.iter().map(|(column, _)| column);
        let when = from.when.iter().map(|(column, _)| column);
        let named = key.into_iter().chain(only).chain(when).cloned();
        named.chain(self.named.of(LOG).map(|(_, column)| column)).collect()
    }

    fn read(
        &self,
        context: &Context,
        recording: &Recording,
        file: &FileBeside,
        columns: &[ColumnRef],
    ) -> Result<Recording, StoreError> {
        let path = path_of(recording, file)?;
        let take = Take {
            turned: file.form.turned,
            ..Take::of(columns.iter().collect(), self.named.budget)
        };
        let other = Recording::read(&path, &file.form, None, &take).map_err(|error| {
            let beside = format!(
                "{}; it is joined to {}",
                error.what,
                context.layout.shown(&recording.path).display()
            );
            StoreError { what: beside, ..error }
        })?;
        if other.blake3 == recording.blake3 {
            let what = "it is joined to itself";
            return Err(other.error(what, "mend the path of the file that is joined"));
        }
        for column in columns {
            other.find(column)?;
        }
        Ok(other)
    }
}

/// Where a file beside a recording lies.
fn path_of(recording: &Recording, file: &FileBeside) -> Result<PathBuf, StoreError> {
    let mut path = String::new();
    let mut rest = file.path.as_str();
    while let Some((before, from)) = rest.split_once('{') {
        let Some((group, after)) = from.split_once('}') else { break };
        path += before;
        path += &recording.group(group)?;
        rest = after;
    }
    path += rest;
    Ok(recording.path.parent().map_or_else(|| PathBuf::from(&path), |folder| folder.join(&path)))
}
