//! Each reader as a function of a file's bytes, for tests with arbitrary bytes (`fuzz/`).
//!
//! The result of a reader is discarded; the tests look for a panic, a hang, or unlimited memory.

use crate::form::events::read_events_from;
use crate::form::footer::read_footer_from;
use crate::form::journaled::read_journal;
use crate::form::read::read_trial_from;
use crate::form::session_record::record_from;
use crate::form::sweep::read_sweep_from;
use crate::{Files, Signal, StoreError};
use std::path::{Path, PathBuf};

/// A journal; the number of its samples.
///
/// # Errors
/// Why it cannot be read.
pub fn journal(files: &dyn Files, path: &Path) -> Result<usize, StoreError> {
    read_journal(files, path).map(|read| read.trial().map_or(0, |(trial, _)| trial.samples.len()))
}

/// An event log with its head.
///
/// # Errors
/// Why it cannot be read.
pub fn events(files: &dyn Files, path: &Path) -> Result<(), StoreError> {
    read_events_from(files, path).map(drop)
}

/// Where the head of a log is.
pub fn head_of(log: &Path) -> PathBuf {
    crate::form::head::head_of(log)
}

/// A session's record.
///
/// # Errors
/// Why it cannot be read.
pub fn record(path: &Path, text: &str) -> Result<(), StoreError> {
    record_from(path, text).map(drop)
}

/// A trial: its footer, then its samples.
///
/// # Errors
/// Why it cannot be read.
pub fn trial(files: &dyn Files, path: &Path) -> Result<(), StoreError> {
    read_footer_from(files, path)?;
    read_trial_from(files, path, Signal::all()).map(drop)
}

/// A sweep.
///
/// # Errors
/// Why it cannot be read.
pub fn sweep(files: &dyn Files, path: &Path) -> Result<(), StoreError> {
    read_sweep_from(files, path).map(drop)
}
