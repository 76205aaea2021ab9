//! The samples of a stream, for the requested channels only.

use super::super::limits::{MOST_TEXT, MOST_WHOLE_ROWS, Take, more_rows, too_much_text};
use super::super::table::{Built, Cells};
use super::chunks::Bytes;
use super::header::{Header, Written};
use arrow::array::{Float64Builder, LargeStringBuilder};
use std::path::Path;
use zwidth_store::StoreError;

/// The samples read so far.
pub(super) struct Samples<'a> {
    /// On the stream's own clock, s.
    pub(super) times: Vec<f64>,
    channels: Vec<Built>,
    /// Samples that their chunks claim and that are not there.
    lost: u64,
    /// Of all texts.
    text: usize,
    /// More rows, cells or texts than are read.
    pub(super) over: Option<StoreError>,
    path: &'a Path,
    take: &'a Take<'a>,
}

impl<'a> Samples<'a> {
    pub(super) fn new(path: &'a Path, header: &Header, take: &'a Take<'a>) -> Self {
        let channels = header.channels.iter().enumerate().map(|(place, channel)| {
            // Before them stands the time.
            match (take.wants(place + 1, Some(&channel.name)), header.written) {
                (false, _) => Built::Unread,
                (true, Written::Text) => Built::Text(LargeStringBuilder::new()),
                (true, _) => Built::Numbers(Float64Builder::new()),
            }
        });
        let channels = channels.collect();
        Self { times: Vec::new(), channels, lost: 0, text: 0, over: None, path, take }
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
        match header.written {
            Written::Text => {
                // All of them before the first is kept: a sample is there whole or not at all.
                let texts = (0..self.channels.len()).map(|_| {
                    let length = usize::try_from(content.length()?).ok()?;
                    content.take(length)
                });
                let texts: Vec<&[u8]> = texts.collect::<Option<_>>()?;
                for (channel, text) in self.channels.iter_mut().zip(texts) {
                    if let Built::Text(built) = channel {
                        self.text += text.len();
                        let text = String::from_utf8_lossy(text);
                        built.append_option(Some(text.trim()).filter(|text| !text.is_empty()));
                    }
                }
            }
            Written::Number(number) => {
                let row = content.take(number.size * self.channels.len())?;
                for (channel, value) in self.channels.iter_mut().zip(row.chunks_exact(number.size))
                {
                    if let Built::Numbers(values) = channel {
                        values.append_value(number.read(value));
                    }
                }
            }
        }
        self.times.push(time);
        let read = self.channels.iter().filter(|c| !matches!(c, Built::Unread)).count();
        if self.times.len() > MOST_WHOLE_ROWS {
            self.over = Some(more_rows(self.path));
        } else if self.text > MOST_TEXT {
            self.over = Some(too_much_text(self.path));
        } else {
            self.over = self.take.room(self.path, read + 1).err();
        }
        Some(())
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
        self.channels.into_iter().map(Built::finish)
    }
}
