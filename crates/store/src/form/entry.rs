//! What a study consists of: its trials, its sweeps and its sessions, each with its metadata.

use crate::{Signal, StoreError, Trial, TrialFile, read_trial};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zwidth_study::{
    ActuatorId, Event, Kind, PlannedTrial, Seal, SessionRecord, Source, Status, Study, TrialForm,
    TrialMeta,
};

/// Largest `study.toml` that is read, bytes: a hundred times a long one.
pub const MOST_STUDY: u64 = 1 << 20;

/// A file's entries besides participant, time and trial.
#[derive(Debug, Clone, PartialEq)]
pub struct Said {
    /// What the file says about itself, without the start of the trial and the file from which it
    /// was imported.
    pub file: TrialFile,
    /// Which columns the file has.
    pub form: TrialForm,
    /// The signals that were recorded, in file order.
    pub signals: Vec<Signal>,
}

/// One trial file, and what the events say about it.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialEntry {
    /// Its file.
    pub path: Arc<Path>,
    /// Its metadata.
    pub meta: TrialMeta,
    /// The file's other entries.
    pub said: Arc<Said>,
    /// Number of samples.
    pub rows: usize,
    /// BLAKE3 of the file, hexadecimal.
    pub blake3: String,
    /// The trial that took its place.
    pub superseded_by: Option<u32>,
    /// Why it was excluded.
    pub excluded: Option<String>,
    /// Whether it was excluded because it did not meet the protocol, by the study's own rule.
    pub is_unmet: bool,
    /// Why its mode is not known, while it is a sealed code.
    pub sealed: Option<String>,
}

impl TrialEntry {
    /// Whether the trial may enter a mean, a metric table or a tally: of the experiment, complete,
    /// neither superseded nor excluded, and not sealed.
    pub fn counts(&self) -> bool {
        self.why_not().is_none()
    }

    /// Why the trial does not count, in words.
    pub fn why_not(&self) -> Option<String> {
        self.why_left_out().or_else(|| self.sealed.clone())
    }

    /// Why the trial does not count even where its mode is known, in words.
    pub fn why_left_out(&self) -> Option<String> {
        if self.meta.kind == Kind::Familiarisation {
            return Some("familiarisation".to_owned());
        }
        if self.meta.status == Status::Incomplete {
            return Some("incomplete".to_owned());
        }
        if let Some(by) = self.superseded_by {
            let unmet = self.excluded.as_ref().filter(|_| self.is_unmet);
            let why = unmet.map(|reason| format!("{reason}; ")).unwrap_or_default();
            return Some(format!("{why}superseded by trial {by}"));
        }
        self.excluded.as_ref().map(|reason| format!("excluded: {reason}"))
    }

    /// Reads the trial's file, with those of the requested `signals` that were recorded, as
    /// [`read_trial`] does. Its metadata are those of the session: an unsealed trial has its mode
    /// and repeat, where the file has a code.
    ///
    /// # Errors
    /// Those of [`read_trial`].
    pub fn read(&self, signals: impl IntoIterator<Item = Signal>) -> Result<Trial, StoreError> {
        let recorded = signals.into_iter().filter(|signal| self.said.signals.contains(signal));
        let trial = read_trial(&self.path, recorded)?;
        Ok(Trial { meta: self.meta.clone(), ..trial })
    }
}

/// One sweep file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SweepEntry {
    /// Its file.
    pub path: PathBuf,
    /// What was characterised.
    pub actuator: ActuatorId,
    /// What it comes from.
    pub source: Source,
    /// BLAKE3 of the file, hexadecimal.
    pub blake3: String,
}

/// A session's record and its events.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionLog {
    /// The session's record.
    pub record: SessionRecord,
    /// The record's file.
    pub path: PathBuf,
    /// Its events, in order.
    pub events: Vec<Event>,
    /// The events' file.
    pub events_path: PathBuf,
    /// The session's trials as they are known now: those of the record, with their modes if they
    /// were unsealed, and those that took, or are to take, another's place.
    pub trials: Vec<PlannedTrial>,
    /// The seal, once it was opened and verified.
    pub seal: Option<Seal>,
    /// The study as it was when the session was set up; none for a session without a copy of it.
    pub study: Option<Arc<Study>>,
}

impl SessionLog {
    /// BLAKE3 of the session's own `study.toml`, and of each that was accepted since.
    pub fn studies(&self) -> impl Iterator<Item = &str> {
        let accepted = self.events.iter().filter_map(|event| match event {
            Event::StudyAccepted { study_blake3 } => Some(study_blake3.as_str()),
            _ => None,
        });
        std::iter::once(self.record.study_blake3.as_str()).chain(accepted)
    }

    /// Whether the session's modes are still codes.
    pub fn is_sealed(&self) -> bool {
        self.record.commitment.is_some() && self.seal.is_none()
    }
}
