//! A trial of a file; if it is long, its columns are read when they are needed.

use crate::form::columns::{Columns, LONG, Recorded};
use crate::form::read::{OpenColumns, with_time};
use crate::form::seen::{Seen, Signals};
use crate::form::shown::Shown;
use crate::judge::samples::{check_samples, import_findings};
use crate::{Asked, RealFiles, Signal, StoreError, Trial};
use std::path::Path;
use std::sync::Arc;
use zwidth_study::{ChannelId, TrialMeta};

/// A trial of a file: in memory, or, if it is long, with columns that are read when they are
/// needed.
pub struct OpenTrial {
    /// The trial's metadata.
    pub meta: TrialMeta,
    /// The findings of its import ([`LOST`](crate::LOST), [`DOUBTS`](crate::DOUBTS)).
    imported: Vec<StoreError>,
    columns: Box<dyn Columns + Send>,
}

/// A short trial, read.
pub(crate) struct Short {
    pub(crate) trial: Trial,
    /// How long the device's clock ran, s.
    pub(crate) device_s: Option<f64>,
}

impl OpenTrial {
    /// Opens the trial at `path`. Of a short one time, these signals and these channels are read; a
    /// long one has them all.
    ///
    /// # Errors
    /// Those of [`read_trial`](crate::read_trial), of a long one those that show without its columns:
    /// the others are a [`Columns::failure`].
    pub fn open(
        path: &Path,
        signals: &[Signal],
        channels: &[ChannelId],
    ) -> Result<Self, StoreError> {
        Self::open_from(path, signals, channels, LONG)
    }

    fn open_from(
        path: &Path,
        signals: &[Signal],
        channels: &[ChannelId],
        long: usize,
    ) -> Result<Self, StoreError> {
        Ok(match Self::read(&Seen::default(), path, signals, channels, long)? {
            Ok(Short { trial: Trial { meta, file, samples }, device_s }) => {
                let signals = with_time(signals.iter().copied());
                let shown = Shown::new(Arc::new(samples), device_s, &signals, channels);
                Self::of(meta, import_findings(Path::new(""), &file), shown)
            }
            Err(long) => long,
        })
    }

    /// A short trial, read, or one of more than `long` samples, opened. Signals that matched their
    /// digests once are not held against them again.
    pub(crate) fn read(
        seen: &Seen,
        path: &Path,
        signals: &[Signal],
        channels: &[ChannelId],
        long: usize,
    ) -> Result<Result<Short, Self>, StoreError> {
        let mut open = OpenColumns::open(&RealFiles, path)?;
        if open.rows() > long {
            let (meta, file) = open.meta_and_file()?;
            let imported = import_findings(Path::new(""), &file);
            return Ok(Err(Self::of(meta, imported, open)));
        }
        let wanted = with_time(signals.iter().copied());
        let signals = Signals::of(&wanted);
        if seen.matched(path, signals, || open.blake3())? {
            open.matched = signals;
        }
        let trial = open.read(&wanted, &|channel| channels.contains(&channel.id))?;
        Ok(Ok(Short { trial, device_s: open.reach_of(Signal::DeviceTime)? }))
    }

    pub(crate) fn of(
        meta: TrialMeta,
        imported: Vec<StoreError>,
        columns: impl Columns + Send + 'static,
    ) -> Self {
        Self { meta, imported, columns: Box::new(columns) }
    }

    /// Its doubts: those from its samples ([`check_samples`]), and those that its import found.
    pub fn check(&self, expected: &Asked) -> Vec<StoreError> {
        let doubts = check_samples(expected, Path::new(""), self.columns());
        doubts.into_iter().chain(self.imported.clone()).collect()
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
    use crate::form::columns::Values;
    use crate::form::read::tests::{form, written};

    #[test]
    fn a_long_trial_has_the_columns_of_a_short_one_and_keeps_none_that_nobody_holds() {
        let (_folder, _, path) = written();
        let trial = crate::read_trial(&path, Signal::all()).unwrap();
        let all: Vec<Signal> = Signal::all().collect();
        let [short, long] =
            [1000, 10].map(|long| OpenTrial::open_from(&path, &all, &[], long).unwrap());
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
    fn a_signal_that_was_not_recorded_takes_the_place_of_no_other() {
        let (_folder, _, path) = written();
        let long = OpenTrial::open_from(&path, &[], &[], 10).unwrap();
        let Some(Values::Read(theta)) = long.columns().column(Signal::Theta) else { panic!() };
        let theta = Arc::downgrade(&{ theta });
        assert!(long.columns().column(Signal::Time).is_some());
        assert!(long.columns().column(Signal::TorqueEx).is_none());
        assert!(theta.upgrade().is_some());
        assert!(long.columns().column(Signal::VoltageMotor).is_some());
        assert!(theta.upgrade().is_none(), "no more than two");
    }

    #[test]
    fn how_far_a_signal_reaches_is_known_without_its_column() {
        let (folder, mut trial, _) = written();
        let device = trial.samples.get(Signal::Time).unwrap().iter().map(|t| 70.0 + 1.01 * t);
        trial.samples.set(Signal::DeviceTime, device.collect());
        let path = folder.path().join("participant=P01/session=S01/trial-018.parquet");
        std::fs::write(&path, crate::trial_bytes(&trial, &form(), &path).unwrap()).unwrap();
        let reach = trial.samples.reach(Signal::DeviceTime).unwrap();
        assert!(reach > 0.0);
        for long in [1000, 10] {
            let open = OpenTrial::open_from(&path, &[Signal::Theta], &[], long).unwrap();
            let columns = open.columns();
            assert_eq!(columns.reach(Signal::DeviceTime), Some(reach));
            assert_eq!(columns.reach(Signal::Theta), trial.samples.reach(Signal::Theta));
            assert_eq!(columns.reach(Signal::TorqueEx), None, "not recorded");
            assert_eq!(columns.column(Signal::DeviceTime).is_some(), long == 10);
        }
    }

    #[test]
    fn a_long_trial_whose_file_is_damaged_says_so_though_nobody_looked_at_that_column() {
        let (_folder, _, path) = written();
        let mut bytes = std::fs::read(&path).unwrap();
        // The first column's first page.
        bytes[8..64].iter_mut().for_each(|byte| *byte ^= 0x5a);
        std::fs::write(&path, &bytes).unwrap();
        let all: Vec<Signal> = Signal::all().collect();
        let refused = OpenTrial::open_from(&path, &all, &[], 1000).err().unwrap();
        let long = OpenTrial::open_from(&path, &all, &[], 10).unwrap();
        assert!(long.columns().column(Signal::Theta).is_some());
        assert_eq!(long.columns().failure(), Some(refused));
        assert!(long.columns().column(Signal::Time).is_none());
    }
}
