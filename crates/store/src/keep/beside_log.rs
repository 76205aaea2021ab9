//! Gives streams that another program recorded beside a session, or withdraws one: their tables and the lines of the
//! session's log as one change.

use crate::form::beside::beside_bytes;
use crate::keep::commit::{Change, commit_events};
use crate::keep::outside_log::not_counting;
use crate::{
    BesideStream, Entered, Files, FirstErrors, GivenFile, Layout, SessionLog, StoreError,
    beside_of, hex_blake3, write_new,
};
use std::path::{Path, PathBuf};
use zwidth_study::{Event, StreamId};

/// Keeps each stream as its next table, and says so in the session's log: all, or none. Their paths.
///
/// # Errors
/// A log that cannot be read to its end; the write that failed. Then nothing was given.
pub fn give_beside(
    files: &dyn Files,
    layout: &Layout,
    entered: Entered<'_>,
    log: &SessionLog,
    streams: &[BesideStream],
    from: GivenFile<'_>,
) -> Result<Vec<PathBuf>, FirstErrors> {
    let before = beside_of(layout, log);
    let (participant, session) = (&log.record.participant, &log.record.session);
    let mut made: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    let mut events = Vec::new();
    for stream in streams {
        let own = before.iter().filter(|entry| entry.stream == stream.id);
        let mut table = own.map(|entry| entry.table).max().map_or(1, |last| last + 1);
        // A file that no line speaks of keeps its number.
        let path = |table| layout.beside_table(participant, session, &stream.id, table);
        while files.kind(&path(table)).is_some() {
            table += 1;
        }
        let path = path(table);
        let bytes = beside_bytes(stream, table, &path)?;
        events.push(Event::StreamGiven {
            stream: stream.id.clone(),
            table,
            file: from.name.to_owned(),
            file_blake3: from.blake3.to_owned(),
            blake3: hex_blake3(&bytes),
        });
        made.push((path, bytes));
    }
    let new: Vec<(&Path, String)> =
        made.iter().map(|(path, bytes)| (path.as_path(), hex_blake3(bytes))).collect();
    let change = Change::of(files, layout, entered, &new, &[(&log.events_path, &events)])?;
    change
        .make("given", || made.iter().try_for_each(|(path, bytes)| write_new(files, path, bytes)))
        .map_err(|errors| errors.into_iter().collect::<FirstErrors>())?;
    Ok(made.into_iter().map(|(path, _)| path).collect())
}

/// Says in the session's log that no table of a stream counts any more. The tables stay.
///
/// # Errors
/// A stream of which no table counts; the write that failed.
pub fn withdraw_beside(
    files: &dyn Files,
    layout: &Layout,
    entered: Entered<'_>,
    log: &SessionLog,
    stream: &StreamId,
    reason: &str,
) -> Result<(), StoreError> {
    let before = beside_of(layout, log);
    let counting: Vec<&str> =
        before.iter().filter(|entry| entry.counts()).map(|entry| entry.stream.as_str()).collect();
    if !counting.contains(&stream.as_str()) {
        return Err(not_counting(&log.events_path, format!("a stream {stream}"), &counting));
    }
    let event = Event::StreamWithdrawn { stream: stream.clone(), reason: reason.to_owned() };
    commit_events(files, layout, entered, &[(&log.events_path, &[event])])
}
