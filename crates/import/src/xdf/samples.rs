//! The samples of a stream, for the requested channels only.

use super::super::limits::{MOST_TEXT, MOST_WHOLE_ROWS, Take, too_many_rows, too_much};
use super::super::table::Cells;
use super::chunks::Bytes;
use super::header::{Header, Written};
use arrow::array::{Float64Array, LargeStringBuilder};
use std::path::Path;
use zwidth_store::StoreError;

/// The samples read so far.
pub(super) struct Samples<'a> {
    /// On the stream's own clock, s.
    pub(super) times: Vec<f64>,
    channels: Vec<Channel>,
    /// Samples that their chunks claim and that are not there.
    lost: u64,
    /// Of all texts.
    text: usize,
    /// Rows, cells or texts of which there are too many.
    over: Option<Over>,
    take: &'a Take<'a>,
}

/// A channel, grown sample by sample.
enum Channel {
    Unread,
    Numbers(Vec<f64>),
    Text(LargeStringBuilder),
}

#[derive(Clone, Copy)]
enum Over {
    Rows,
    Cells,
    Text,
}

impl<'a> Samples<'a> {
    pub(super) fn new(header: &Header, take: &'a Take<'a>) -> Self {
        let channels = (0..header.channels).map(|place| {
            let name = Some(header.labels[place].as_str()).filter(|name| !name.is_empty());
            let other = format!("channel_{}", place + 1);
            // Before them stands the time.
            match (take.wants(place + 1, name.or(Some(&other))), header.written) {
                (false, _) => Channel::Unread,
                (true, Written::Text) => Channel::Text(LargeStringBuilder::new()),
                (true, _) => Channel::Numbers(Vec::new()),
            }
        });
        let channels = channels.collect();
        Self { times: Vec::new(), channels, lost: 0, text: 0, over: None, take }
    }

    /// Adds the samples of a chunk as far as they go; whether it holds what it claims.
    pub(super) fn add(&mut self, header: &Header, content: &[u8]) -> bool {
        let mut content = Bytes(content);
        let Some(claimed) = content.length() else { return false };
        for read in 0..claimed {
            if self.over.is_some() {
                return true;
            }
            if self.sample(header, &mut content).is_none() {
                self.lost = self.lost.saturating_add(claimed - read);
                return false;
            }
        }
        content.0.is_empty()
    }

    /// Adds a sample; `None` where it is cut off.
    fn sample(&mut self, header: &Header, content: &mut Bytes) -> Option<()> {
        let interval_s = if header.rate_hz > 0.0 { 1.0 / header.rate_hz } else { 0.0 };
        let time = match content.take(1)? {
            // It has no time of its own.
            [0] => self.times.last().copied().unwrap_or(0.0) + interval_s,
            [8] => content.f64()?,
            _ => return None,
        };
        if header.written == Written::Text {
            // All of them before the first is kept: a sample is there whole or not at all.
            let texts = (0..self.channels.len()).map(|_| {
                let length = usize::try_from(content.length()?).ok()?;
                content.take(length)
            });
            let texts: Vec<&[u8]> = texts.collect::<Option<_>>()?;
            for (channel, text) in self.channels.iter_mut().zip(texts) {
                if let Channel::Text(built) = channel {
                    self.text += text.len();
                    let text = String::from_utf8_lossy(text);
                    built.append_option(Some(text.trim()).filter(|text| !text.is_empty()));
                }
            }
        } else {
            let size = header.written.size();
            let row = content.take(size * self.channels.len())?;
            for (channel, value) in self.channels.iter_mut().zip(row.chunks_exact(size)) {
                if let Channel::Numbers(values) = channel {
                    values.push(header.written.number(value)?);
                }
            }
        }
        self.times.push(time);
        self.count();
        Some(())
    }

    /// Counts a sample against what is read at most.
    fn count(&mut self) {
        let read = self.channels.iter().filter(|c| !matches!(c, Channel::Unread)).count();
        if self.times.len() > MOST_WHOLE_ROWS {
            self.over = Some(Over::Rows);
        } else if self.text > MOST_TEXT {
            self.over = Some(Over::Text);
        } else if !self.take.budget.cells(read + 1) {
            self.over = Some(Over::Cells);
        }
    }

    /// Whether there is no more than is read.
    ///
    /// # Errors
    /// Rows, cells or texts of which there are too many.
    pub(super) fn check(&self, path: &Path) -> Result<(), StoreError> {
        match self.over {
            None => Ok(()),
            Some(Over::Rows) => Err(too_many_rows(path, &format!("more than {MOST_WHOLE_ROWS}"))),
            Some(Over::Cells) => Err(too_much(path)),
            Some(Over::Text) => {
                let what = format!("the texts in mapped columns have more than {MOST_TEXT} bytes");
                Err(StoreError::new(path, what, "split the file"))
            }
        }
    }

    /// Notes on what is lost, and on what the stream's footer counts besides what is there.
    pub(super) fn notes(&self, counted: Option<u64>) -> Vec<String> {
        let read = self.times.len() as u64;
        let mut notes = Vec::new();
        if self.lost > 0 {
            let lost = self.lost;
            notes.push(format!("{lost} samples of damaged chunks are lost, {read} are read"));
        }
        if let Some(counted) = counted.filter(|counted| *counted != read) {
            notes
                .push(format!("the stream's footer counts {counted} samples, and {read} are read"));
        }
        notes
    }

    /// What of the stream could not be read, in words; `is_damaged` says whether the file has bytes that
    /// hold no whole chunk.
    pub(super) fn lost(&self, counted: Option<u64>, is_damaged: bool) -> Option<String> {
        let why = "the XDF file is damaged or was cut off";
        let read = self.times.len() as u64;
        // What a damaged chunk claims is trusted less than the footer.
        let all = match counted {
            Some(counted) if counted > read => counted,
            _ => read.saturating_add(self.lost),
        };
        if all > read {
            return Some(format!("{read} of {all} samples are read: {why}"));
        }
        // If the footer's samples are all there, another stream was damaged.
        (is_damaged && counted.is_none()).then(|| {
            format!("{read} samples are read, and it is not known how many are lost: {why}")
        })
    }

    /// The channels as columns.
    pub(super) fn cells(self) -> impl Iterator<Item = Cells> {
        self.channels.into_iter().map(|channel| match channel {
            Channel::Unread => Cells::Unread,
            Channel::Numbers(values) => Cells::Numbers(Float64Array::from(values)),
            Channel::Text(mut built) => Cells::Text(built.finish()),
        })
    }
}
