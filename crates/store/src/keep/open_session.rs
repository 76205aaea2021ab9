//! A session that is being recorded: the cost of a trial does not depend on how many there were
//! before.
//!
//! Its record, its copy of `study.toml`, its log and the names of its trials are read and checked
//! once. After that only this handle writes them, under the study's lock. Before each trial the
//! system is asked whether anybody else wrote them ([`Stamp`]); if so, they are read and checked
//! again.

use crate::disk::stamp::Stamp;
use crate::form::frame::Protocol;
use crate::judge::whole::check_session;
use crate::keep::open_log::OpenLog;
use crate::keep::record::Ended;
use crate::{Entered, Files, Layout, StoreError, Trial};
use std::path::PathBuf;
use zwidth_study::{Event, ParticipantId, SessionId, SessionRecord};

/// A session that is being recorded.
#[derive(Debug)]
pub struct OpenSession {
    layout: Layout,
    record: PathBuf,
    study_copy: PathBuf,
    /// The folder of its trials.
    trials: PathBuf,
    log: OpenLog,
    /// The stamps when the session was last found whole.
    whole: Option<Stamps>,
}

/// The stamps of a session's files besides its log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamps {
    record: Stamp,
    study_copy: Stamp,
    /// Of the folder: it changes with every name in it.
    trials: Stamp,
}

impl OpenSession {
    /// A session of a study; nothing of it is read yet.
    pub fn new(layout: &Layout, participant: &ParticipantId, session: &SessionId) -> Self {
        Self {
            layout: layout.clone(),
            record: layout.session(participant, session),
            study_copy: layout.study_copy(participant, session),
            trials: layout.trials_of(participant, session),
            log: OpenLog::new(layout.events(participant, session)),
            whole: None,
        }
    }

    /// Checks that the session is still as it was set up.
    ///
    /// # Errors
    /// The first finding.
    pub fn check(&mut self, files: &dyn Files, record: &SessionRecord) -> Result<(), StoreError> {
        let now = self.stamps(files);
        if now.is_some() && now == self.whole && self.log.is_unchanged(files) {
            return Ok(());
        }
        self.whole = None;
        check_session(files, &self.layout, record)?;
        // Taken before the files were read: what changed meanwhile has another one.
        self.whole = now;
        Ok(())
    }

    /// Appends events to the log in one synced write ([`crate::append_events`]).
    ///
    /// # Errors
    /// A log that cannot be read to its end; the write that failed.
    pub fn append<'a>(
        &mut self,
        files: &dyn Files,
        entered: impl Into<Entered<'a>>,
        events: &[Event],
    ) -> Result<(), StoreError> {
        self.log.append(files, entered.into(), events)
    }

    /// Makes a trial that ended a file ([`crate::record_trial`]).
    ///
    /// # Errors
    /// Those of [`crate::record_trial`].
    pub(crate) fn record(
        &mut self,
        files: &dyn Files,
        entered: Entered<'_>,
        ended: &Ended<'_>,
    ) -> Result<PathBuf, StoreError> {
        // Only this trial may change the names in the folder.
        let before =
            self.whole.take().filter(|whole| files.stamp(&self.trials) == Some(whole.trials));
        let path = ended.record(files, &self.layout, &mut self.log, entered)?;
        let trials = files.stamp(&self.trials);
        self.whole = before.zip(trials).map(|(before, trials)| Stamps { trials, ..before });
        Ok(path)
    }

    fn stamps(&self, files: &dyn Files) -> Option<Stamps> {
        Some(Stamps {
            record: files.stamp(&self.record)?,
            study_copy: files.stamp(&self.study_copy)?,
            trials: files.stamp(&self.trials)?,
        })
    }
}

/// Writes a trial's file, the event that reports it as recorded and the event of the answer to its
/// question; returns the file's path. `utc` is the time of the events, `answer_time_ms` the time of
/// the answer, if it was measured.
///
/// Steps of a first attempt are not repeated: the file may be there with this very trial in it, and
/// the event may be there with the file's hash.
///
/// # Errors
/// Samples that break a promise of the schema; another trial under the same number; a log that
/// cannot be read; a write that failed.
pub fn record_trial<'a>(
    files: &dyn Files,
    layout: &Layout,
    entered: impl Into<Entered<'a>>,
    trial: &Trial,
    protocol: &Protocol,
    answer_time_ms: Option<u32>,
) -> Result<PathBuf, StoreError> {
    let m = &trial.meta;
    let mut session = OpenSession::new(layout, &m.participant, &m.session);
    session.record(files, entered.into(), &Ended { trial, protocol, answer_time_ms })
}
