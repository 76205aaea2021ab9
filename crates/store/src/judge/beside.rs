//! The tables of streams that other programs recorded beside sessions, compared with the sessions' logs.

use crate::disk::hash::blake3_of;
use crate::disk::walk::parquet_below;
use crate::{Entry, Files, Layout, SessionLog, StoreError};
use std::path::PathBuf;
use zwidth_study::{Event, ParticipantId, SessionId, StreamId};

const RESTORE: &str = "restore the file from a copy, or give the recording again";

/// A table of a stream, as a session's log has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BesideEntry {
    /// Whose session.
    pub participant: ParticipantId,
    /// Which session.
    pub session: SessionId,
    /// The stream.
    pub stream: StreamId,
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
    /// Why it does not count; `None` if it does.
    pub why_not: Option<String>,
}

impl BesideEntry {
    /// Whether it lies beside the session of this log.
    pub fn is_of(&self, log: &SessionLog) -> bool {
        (&self.participant, &self.session) == (&log.record.participant, &log.record.session)
    }

    /// Whether it is the stream's table.
    pub fn counts(&self) -> bool {
        self.why_not.is_none()
    }
}

/// Every table that a session's log speaks of, in its order. The last of a stream counts, unless it was withdrawn.
pub fn beside_of(layout: &Layout, log: &SessionLog) -> Vec<BesideEntry> {
    let mut entries: Vec<BesideEntry> = Vec::new();
    let leave_out = |entries: &mut Vec<BesideEntry>, of: &StreamId, why: String| {
        let counting = entries.iter_mut().filter(|entry| entry.stream == *of && entry.counts());
        counting.for_each(|entry| entry.why_not = Some(why.clone()));
    };
    let (participant, session) = (&log.record.participant, &log.record.session);
    for event in &log.events {
        match event {
            Event::StreamGiven { stream, table, file, file_blake3, blake3 } => {
                leave_out(&mut entries, stream, format!("table {table} took its place"));
                entries.push(BesideEntry {
                    participant: participant.clone(),
                    session: session.clone(),
                    stream: stream.clone(),
                    table: *table,
                    path: layout.beside_table(participant, session, stream, *table),
                    blake3: blake3.clone(),
                    file: file.clone(),
                    file_blake3: file_blake3.clone(),
                    why_not: None,
                });
            }
            Event::StreamWithdrawn { stream, reason } => {
                leave_out(&mut entries, stream, format!("withdrawn: {reason}"));
            }
            _ => {}
        }
    }
    entries
}

/// What does not fit: tables that are gone, or that no log knows if all logs could be read. None of the tables is read.
pub(crate) fn beside_findings(
    files: &dyn Files,
    layout: &Layout,
    entries: &[BesideEntry],
    all_read: bool,
) -> Vec<StoreError> {
    let mut findings = Vec::new();
    match parquet_below(files, &layout.beside()) {
        Ok(paths) => {
            let unknown = |path: &&PathBuf| all_read && entries.iter().all(|e| e.path != **path);
            findings.extend(paths.iter().filter(unknown).map(|path| {
                let what = "no session's log mentions the table of a stream: left out";
                StoreError::new(path, what, "give it with `zwidth beside`, and remove this file")
            }));
        }
        Err(error) => findings.push(error),
    }
    let gone = entries.iter().filter(|entry| files.kind(&entry.path) != Some(Entry::File));
    findings.extend(gone.map(|entry| {
        let what = "a session's log knows the table of a stream, but its file is missing";
        StoreError::new(&entry.path, what, RESTORE)
    }));
    findings
}

/// Reads a table's bytes: whether it is the one that was given.
pub(crate) fn altered(files: &dyn Files, entry: &BesideEntry) -> Option<StoreError> {
    // One that is gone is told already.
    if files.kind(&entry.path) != Some(Entry::File) {
        return None;
    }
    match blake3_of(files, &entry.path) {
        Ok(blake3) if blake3 == entry.blake3 => None,
        Ok(_) => {
            let what =
                "the file is not the table that was given: its hash differs from the session's log";
            Some(StoreError::new(&entry.path, what, RESTORE))
        }
        Err(error) => Some(error),
    }
}
