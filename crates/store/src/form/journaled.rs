//! A journal, read.

use crate::disk::SECTOR;
use crate::form::frame::{Decoded, Frame, Header, MAGIC, Protocol, decode};
use crate::{Files, MOST_BYTES, Samples, StoreError, Trial};
use std::path::Path;
use zwidth_study::{Given, Sample, Status, TrialMeta};

/// The ending of a damaged journal's name.
pub(crate) const DAMAGED: &str = ".damaged";

/// The contents of a journal.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Journaled {
    pub(crate) header: Option<Header>,
    pub(crate) rows: Vec<Sample>,
    pub(crate) ended: bool,
    pub(crate) answer: Option<Given>,
    /// Bytes of which nothing could be made.
    pub(crate) damaged: usize,
    /// Bytes of an append that was never finished.
    pub(crate) unfinished: usize,
    /// Damaged frames that could be mended.
    pub(crate) mended: usize,
}

impl Journaled {
    /// The trial, if it has any row. One that may lack rows is incomplete.
    pub(crate) fn trial(&self) -> Option<(Trial, Protocol)> {
        let header = self.header.clone().filter(|_| !self.rows.is_empty())?;
        let Header { meta, file, protocol } = header;
        let is_whole = self.ended && self.damaged == 0;
        let status = if is_whole { Status::Complete } else { Status::Incomplete };
        let likert = self.answer.map(|answer| answer.value);
        let meta = TrialMeta { status, likert, ..meta };
        let samples = Samples::from_rows(&self.rows);
        let samples = samples.with_channels(&self.rows, &protocol.given, &protocol.form);
        Some((Trial { meta, file, samples }, protocol))
    }

    /// From the question to its answer, ms, where it was measured.
    pub(crate) fn time_ms(&self) -> Option<u32> {
        self.answer?.time_ms
    }
}

/// Reads every whole frame of a journal.
///
/// # Errors
/// A file that cannot be read, or that is not a journal of this version.
pub(crate) fn read_journal(files: &dyn Files, path: &Path) -> Result<Journaled, StoreError> {
    let bytes = files.read(path, MOST_BYTES).map_err(|e| StoreError::io(path, "read", &e))?;
    let (first, framed) = bytes.split_at(MAGIC.len().min(bytes.len()));
    let is_journal = first == MAGIC;
    let Decoded { frames, damaged, unfinished, mended } = decode(framed);
    // The first append has the magic and the header; of what was not synced any sector may be zeros.
    let lacks_first = bytes.iter().take(SECTOR).all(|b| *b == 0) && frames.is_empty();
    if !is_journal && (MAGIC.starts_with(first) || lacks_first) {
        return Ok(Journaled { unfinished: bytes.len(), ..Journaled::default() });
    }
    let mut read = Journaled { damaged, unfinished, mended, ..Journaled::default() };
    for frame in frames {
        match frame {
            Frame::Header(header) => read.header = Some(header),
            Frame::Rows(rows) => read.rows.extend(rows),
            Frame::End => read.ended = true,
            Frame::Answer(answer) => read.answer = Some(answer),
        }
    }
    if !is_journal && read.header.is_none() {
        let what = "not a journal of this version";
        let remedy = "use the zwidth that wrote it, or move the file elsewhere";
        return Err(StoreError::new(path, what, remedy));
    }
    Ok(read)
}
