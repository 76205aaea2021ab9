//! The trials that were read last, for the next reader of the same ones: several jobs of a run read
//! the trials of a session one after the other.

use crate::disk::stamp::Stamp;
use crate::form::columns::LONG;
use crate::form::read::with_time;
use crate::form::seen::{Seen, Signals};
use crate::form::shown::Shown;
use crate::judge::open::{OpenTrial, Short};
use crate::judge::samples::import_findings;
use crate::{Samples, Signal, StoreError, Trial};
use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use zwidth_study::{ChannelId, TrialMeta};

/// Bytes of samples that are kept at most (32 MiB): the trials of two sessions of 36 of 4 s at 1 kHz.
const MOST: usize = 1 << 25;

/// Trials that were read last. A file that changed since is read again.
#[derive(Debug, Default)]
pub struct Lately {
    read: Mutex<VecDeque<Read>>,
    seen: Arc<Seen>,
}

/// A trial as it was read.
#[derive(Debug, Clone)]
struct Read {
    path: PathBuf,
    stamp: Stamp,
    meta: TrialMeta,
    imported: Vec<StoreError>,
    samples: Arc<Samples>,
    /// How long the device's clock ran, s.
    device_s: Option<f64>,
    /// The requested signals, which the file may lack.
    signals: Vec<Signal>,
    channels: Vec<ChannelId>,
}

impl Lately {
    /// None yet. Signals that `seen` knows need not be compared with digests again, and it learns
    /// which were.
    pub fn seeing(seen: Arc<Seen>) -> Self {
        Self { read: Mutex::default(), seen }
    }

    /// [`OpenTrial::open`], from memory if a short one was read lately with all the requested
    /// signals.
    ///
    /// # Errors
    /// Those of [`OpenTrial::open`].
    pub fn open(
        &self,
        path: &Path,
        signals: &[Signal],
        channels: &[ChannelId],
    ) -> Result<OpenTrial, StoreError> {
        self.open_if(Stamp::settled, path, signals, channels)
    }

    /// `stamp_of` tells one state of a file from any other.
    fn open_if(
        &self,
        stamp_of: impl Fn(&Path) -> Option<Stamp>,
        path: &Path,
        signals: &[Signal],
        channels: &[ChannelId],
    ) -> Result<OpenTrial, StoreError> {
        let signals = &*with_time(signals.iter().copied());
        let stamp = stamp_of(path);
        if let Some(read) = stamp.and_then(|stamp| self.kept(path, stamp, signals, channels)) {
            let shown = Shown::new(read.samples, read.device_s, signals, channels);
            return Ok(OpenTrial::of(read.meta, read.imported, shown));
        }
        let (trial, device_s) = match OpenTrial::read(&self.seen, path, signals, channels, LONG)? {
            Ok(Short { trial, device_s }) => (trial, device_s),
            Err(long) => return Ok(long),
        };
        let Trial { meta, file, samples } = trial;
        let imported = import_findings(Path::new(""), &file);
        let samples = Arc::new(samples);
        // One that changed while it was read is not kept: nobody knows which state was read.
        if let Some(stamp) = stamp.filter(|stamp| stamp_of(path) == Some(*stamp)) {
            self.seen.match_now(path, stamp, Signals::of(signals));
            self.keep(Read {
                path: path.to_owned(),
                stamp,
                meta: meta.clone(),
                imported: imported.clone(),
                samples: samples.clone(),
                device_s,
                signals: signals.to_vec(),
                channels: channels.to_vec(),
            });
        }
        Ok(OpenTrial::of(meta, imported, Shown::new(samples, device_s, signals, channels)))
    }

    fn kept(
        &self,
        path: &Path,
        stamp: Stamp,
        signals: &[Signal],
        channels: &[ChannelId],
    ) -> Option<Read> {
        let kept = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter()
            .find(|read| {
                (read.stamp, read.path.as_path()) == (stamp, path)
                    && signals.iter().all(|signal| read.signals.contains(signal))
                    && channels.iter().all(|channel| read.channels.contains(channel))
            })
            .cloned()
    }

    fn keep(&self, read: Read) {
        let mut kept = self.read.lock().unwrap_or_else(PoisonError::into_inner);
        kept.push_front(read);
        let mut bytes = 0;
        let fits = kept.iter().take_while(|read| {
            let Read { samples, .. } = read;
            let signals = Signal::all().filter(|signal| samples.get(*signal).is_some()).count();
            bytes += samples.len() * (signals + samples.channels().count()) * size_of::<f64>();
            bytes <= MOST
        });
        let fits = fits.count();
        kept.truncate(fits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::read::tests::{with_other_entries, written};
    use crate::hex_blake3;
    use std::fs::File;
    use std::time::SystemTime;

    fn places(trial: &OpenTrial) -> [Option<*const f64>; 3] {
        [Signal::Time, Signal::Theta, Signal::VoltageMotor]
            .map(|signal| trial.columns().column(signal).map(|values| values.as_ptr()))
    }

    #[test]
    #[cfg(unix)]
    fn a_trial_is_read_once_for_those_who_ask_for_no_more_and_shows_each_what_it_asked_for() {
        let (_folder, trial, path) = written();
        let lately = Lately::default();
        let open = |signals: &[Signal]| lately.open_if(Stamp::at, &path, signals, &[]).unwrap();
        let first = open(&[Signal::Theta]);
        let same = open(&[Signal::Theta, Signal::Time]);
        assert_eq!(places(&first), [places(&same)[0], places(&same)[1], None], "read once");
        let more = open(&[Signal::Theta, Signal::VoltageMotor]);
        assert_ne!(places(&more)[1], places(&first)[1]);
        let few = open(&[Signal::VoltageMotor]);
        assert_eq!(places(&few), [places(&more)[0], None, places(&more)[2]], "what it asked for");
        let theta = more.columns().column(Signal::Theta).unwrap();
        assert_eq!(Some(&*theta), trial.samples.get(Signal::Theta));
        assert_eq!((&few.meta, few.columns().rows()), (&trial.meta, 200));
        // A file that changed is read again, and one that may have changed is not kept.
        let file = File::options().append(true).open(&path).unwrap();
        file.set_modified(SystemTime::UNIX_EPOCH).unwrap();
        assert_ne!(places(&open(&[Signal::VoltageMotor]))[2], places(&more)[2]);
        let doubtful = Lately::default();
        doubtful.open_if(|_| None, &path, &[], &[]).unwrap();
        assert!(doubtful.read.lock().unwrap().is_empty());
    }

    /// A recording that says that its angles have the digest of others, and one that knows what it
    /// was.
    #[cfg(unix)]
    fn with_a_wrong_digest(path: &Path) -> Arc<Seen> {
        let bytes = with_other_entries(&std::fs::read(path).unwrap(), |entries| {
            let voltage = entries["blake3:voltage_motor_v"].clone();
            entries.insert("blake3:theta_rad".to_owned(), voltage);
        });
        std::fs::write(path, &bytes).unwrap();
        let seen = Seen::default();
        seen.written(path, &hex_blake3(&bytes));
        Arc::new(seen)
    }

    #[test]
    #[cfg(unix)]
    fn signals_that_matched_are_not_digested_again_until_their_bytes_are_others() {
        let (_folder, trial, path) = written();
        let seen = with_a_wrong_digest(&path);
        // As if nothing was read lately.
        let open = |signals: &[Signal]| {
            Lately::seeing(seen.clone()).open_if(Stamp::at, &path, signals, &[])
        };
        let refused = |signals: &[Signal]| {
            let error = open(signals).err().unwrap();
            assert_eq!(error.column.as_deref(), Some("theta_rad"), "{error}");
        };
        open(&[Signal::VoltageMotor]).unwrap();
        refused(&[Signal::Theta]);
        seen.match_now(&path, Stamp::at(&path).unwrap(), Signals::of(&[Signal::Theta]));
        let found = open(&[Signal::VoltageMotor, Signal::Theta]).unwrap();
        let theta = found.columns().column(Signal::Theta).unwrap();
        assert_eq!(Some(&*theta), trial.samples.get(Signal::Theta));
        refused(&[Signal::Theta, Signal::StateBits]);
        // The same values in other bytes, which are as long as before.
        let bytes = with_other_entries(&std::fs::read(&path).unwrap(), |entries| {
            entries.insert("seed".to_owned(), "2".to_owned());
        });
        std::fs::write(&path, bytes).unwrap();
        refused(&[Signal::VoltageMotor, Signal::Theta]);
    }

    #[test]
    #[cfg(unix)]
    fn what_was_read_whole_is_known_to_match_and_what_was_refused_is_not() {
        let (_folder, _, path) = written();
        let hash = hex_blake3(&std::fs::read(&path).unwrap());
        let seen = Arc::new(Seen::default());
        let lately = Lately::seeing(seen.clone());
        let open = |signals: &[Signal]| lately.open_if(Stamp::at, &path, signals, &[]);
        let knows = |signals: &[Signal], hash: &str| {
            seen.matched(&path, Signals::of(signals), || Ok(hash.to_owned())).unwrap()
        };
        open(&[Signal::Theta]).unwrap();
        assert!(!knows(&[Signal::Theta], &hash), "of a file that was never hashed");
        seen.written(&path, &hash);
        open(&[Signal::VoltageMotor]).unwrap();
        assert!(knows(&[Signal::Time, Signal::VoltageMotor], &hash));
        assert!(!knows(&[Signal::VoltageMotor], "another"), "of other content");
        assert!(!knows(&[Signal::Theta], &hash), "it was read before that");
        let seen = with_a_wrong_digest(&path);
        let lately = Lately::seeing(seen.clone());
        lately.open_if(Stamp::at, &path, &[Signal::Theta], &[]).err().unwrap();
        let hash = hex_blake3(&std::fs::read(&path).unwrap());
        let wanted = Signals::of(&[Signal::Time, Signal::Theta]);
        assert!(!seen.matched(&path, wanted, || Ok(hash)).unwrap());
    }

    #[test]
    fn no_more_is_kept_than_fits() {
        let lately = Lately::default();
        let (_folder, trial, path) = written();
        let Some(stamp) = Stamp::at(&path) else { return };
        let samples = Arc::new({
            let mut samples = Samples::default();
            samples.set(Signal::Time, vec![0.0; MOST / size_of::<f64>() / 3]);
            samples
        });
        for i in 0..5 {
            let path = PathBuf::from(i.to_string());
            let (signals, channels, meta) = (Vec::new(), Vec::new(), trial.meta.clone());
            let (samples, device_s) = (samples.clone(), None);
            lately.keep(Read {
                path,
                stamp,
                meta,
                imported: Vec::new(),
                samples,
                device_s,
                signals,
                channels,
            });
        }
        let kept = lately.read.into_inner().unwrap();
        let names: Vec<_> = kept.iter().map(|read| read.path.to_str().unwrap()).collect();
        assert_eq!(names, ["4", "3", "2"]);
    }
}
