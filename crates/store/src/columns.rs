//! The signals of a trial one by one: in memory, or read when they are looked at. What looks at two
//! signals of a long recording never has the others in memory.

use crate::read::{OpenColumns, read_trial_and_channels};
use crate::{RealFiles, Samples, Signal, StoreError, Trial};
use std::ops::Deref;
use std::path::Path;
use std::sync::Arc;
use zwidth_study::{ChannelId, TrialMeta};

/// Samples from which on a trial is checked column by column, so that no more than two are in
/// memory.
pub(crate) const LONG: usize = 1 << 20;

/// The values of a signal.
#[derive(Debug, Clone)]
pub enum Values<'a> {
    /// In a trial in memory.
    Held(&'a [f64]),
    /// Read from a file, and forgotten when nobody looks at them any more.
    Read(Arc<Vec<f64>>),
}

impl Deref for Values<'_> {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        match self {
            Self::Held(values) => values,
            Self::Read(values) => values,
        }
    }
}

/// The signals of a trial.
pub trait Columns {
    /// How many samples.
    fn rows(&self) -> usize;

    /// The values of `signal`, where the recording has it.
    fn column(&self, signal: Signal) -> Option<Values<'_>>;

    /// Whether the recording has `signal`.
    fn has(&self, signal: Signal) -> bool;

    /// The values of a channel of the study's own, where the recording has it.
    fn channel(&self, name: &str) -> Option<Values<'_>>;

    /// Gives back the memory of what was looked at and nobody holds any more.
    fn forget(&self) {}

    /// What of the trial cannot be read, and so is not there for whoever looks at it: whatever was made
    /// without it is void. Signals that nobody looked at yet are read for this.
    fn failure(&self) -> Option<StoreError> {
        None
    }

    /// A column that is not as long as the trial's time, where that was not checked yet: its name and
    /// its length.
    fn ragged(&self) -> Option<(String, usize)> {
        None
    }
}

impl Columns for Samples {
    fn rows(&self) -> usize {
        self.get(Signal::Time).map_or(0, <[f64]>::len)
    }

    fn column(&self, signal: Signal) -> Option<Values<'_>> {
        self.get(signal).map(Values::Held)
    }

    fn has(&self, signal: Signal) -> bool {
        self.get(signal).is_some()
    }

    fn channel(&self, name: &str) -> Option<Values<'_>> {
        self.channels().find(|(id, _)| id.as_str() == name).map(|(_, values)| Values::Held(values))
    }

    fn ragged(&self) -> Option<(String, usize)> {
        let signals = Signal::all().filter_map(|s| Some((s.name(), self.get(s)?)));
        let all = signals.chain(self.channels().map(|(id, values)| (id.as_str(), values)));
        let mut lengths = all.map(|(name, values)| (name, values.len()));
        let other = lengths.find(|(_, length)| *length != self.rows())?;
        Some((other.0.to_owned(), other.1))
    }
}

/// A trial to be looked at, wherever its samples are.
#[derive(Clone, Copy)]
pub struct Recorded<'a> {
    /// What is known of the trial.
    pub meta: &'a TrialMeta,
    /// Its samples.
    pub columns: &'a dyn Columns,
}

impl<'a> From<&'a Trial> for Recorded<'a> {
    fn from(trial: &'a Trial) -> Self {
        Self { meta: &trial.meta, columns: &trial.samples }
    }
}

/// A trial of a file: in memory, or if it is long with columns that are read when they are looked
/// at.
pub struct OpenTrial {
    /// What is known of the trial.
    pub meta: TrialMeta,
    columns: Box<dyn Columns + Send>,
}

impl OpenTrial {
    /// Opens the trial at `path`. Of a short one all signals and these channels are read.
    ///
    /// # Errors
    /// Those of [`read_trial`](crate::read_trial), of a long one those that show without its columns:
    /// the others are a [`Columns::failure`].
    pub fn open(path: &Path, channels: &[ChannelId]) -> Result<Self, StoreError> {
        Self::open_from(path, channels, LONG)
    }

    fn open_from(path: &Path, channels: &[ChannelId], long: usize) -> Result<Self, StoreError> {
        let open = OpenColumns::open(&RealFiles, path)?;
        if open.rows() <= long {
            let Trial { meta, samples, .. } =
                read_trial_and_channels(path, Signal::all(), channels)?;
            return Ok(Self { meta, columns: Box::new(samples) });
        }
        Ok(Self { meta: open.said()?.0, columns: Box::new(open) })
    }

    /// Its samples.
    pub fn columns(&self) -> &dyn Columns {
        &*self.columns
    }
}

impl<'a> From<&'a OpenTrial> for Recorded<'a> {
    fn from(trial: &'a OpenTrial) -> Self {
        Self { meta: &trial.meta, columns: trial.columns() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::tests::written;

    #[test]
    fn a_long_trial_has_the_columns_of_a_short_one_and_keeps_none_that_nobody_holds() {
        let folder = tempfile::tempdir().unwrap();
        let (_, path) = written(folder.path());
        let trial = crate::read_trial(&path, Signal::all()).unwrap();
        let [short, long] = [1000, 10].map(|long| OpenTrial::open_from(&path, &[], long).unwrap());
        for open in [&short, &long] {
            assert_eq!((&open.meta, open.columns().rows()), (&trial.meta, 200));
            for signal in Signal::all() {
                let values = open.columns().column(signal);
                assert!(values.as_deref() == trial.samples.get(signal), "{signal:?}");
                assert_eq!(open.columns().has(signal), values.is_some());
            }
        }
        let held = long.columns().column(Signal::Theta);
        long.columns().forget();
        let again = long.columns().column(Signal::Theta);
        let place = |values: &Option<Values>| values.as_ref().unwrap().as_ptr();
        assert_eq!(place(&held), place(&again), "what somebody holds is not read twice");
        assert_eq!(long.columns().failure(), None);
    }

    #[test]
    fn a_long_trial_whose_file_is_damaged_says_so_though_nobody_looked_at_that_column() {
        let folder = tempfile::tempdir().unwrap();
        let (_, path) = written(folder.path());
        let mut bytes = std::fs::read(&path).unwrap();
        // The first column's first page.
        bytes[8..64].iter_mut().for_each(|byte| *byte ^= 0x5a);
        std::fs::write(&path, &bytes).unwrap();
        let refused = OpenTrial::open_from(&path, &[], 1000).err().unwrap();
        let long = OpenTrial::open_from(&path, &[], 10).unwrap();
        assert!(long.columns().column(Signal::Theta).is_some());
        assert_eq!(long.columns().failure(), Some(refused));
        assert!(long.columns().column(Signal::Time).is_none());
    }
}
