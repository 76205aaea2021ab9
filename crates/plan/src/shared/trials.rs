//! Reading the trials of a job.

use crate::shared::making::split;
use rayon::prelude::*;
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use zwidth_store::{
    Lately, OpenTrial, Signal, StoreError, Trial, TrialEntry, read_thinned, read_trial,
};
use zwidth_study::{CURRENT_BRAKE, CURRENT_MOTOR, ChannelId, ModeId, REFERENCE, TrialMeta};

/// What the session knows of a trial beside its file: of an unsealed one, whose file has a code,
/// the mode and the repeat.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Known {
    pub(crate) trial: u32,
    mode: ModeId,
    repeat: u32,
}

/// A stage's parameters, and what is known of the trials that it gets.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct OfTrials<P> {
    #[serde(flatten)]
    pub(crate) stage: P,
    pub(crate) trials: Vec<Known>,
}

impl<P> OfTrials<P> {
    pub(crate) fn new(stage: P, trials: &[&TrialEntry]) -> Self {
        Self { stage, trials: describe_trials(trials) }
    }
}

/// What is known of trials.
pub(crate) fn describe_trials(trials: &[&TrialEntry]) -> Vec<Known> {
    trials.iter().map(|trial| Known::of(&trial.meta)).collect()
}

impl Known {
    fn of(meta: &TrialMeta) -> Self {
        Self { trial: meta.trial, mode: meta.mode.clone(), repeat: meta.repeat }
    }

    /// A trial with what is known of it.
    fn names(&self, trial: Trial) -> Trial {
        Trial { meta: self.named(trial.meta), ..trial }
    }

    fn of_open(&self, mut trial: OpenTrial) -> OpenTrial {
        trial.meta = self.named(trial.meta);
        trial
    }

    fn named(&self, meta: TrialMeta) -> TrialMeta {
        TrialMeta { mode: self.mode.clone(), repeat: self.repeat, ..meta }
    }
}

/// Recordings that a job reads. All jobs share a trial's path.
pub(crate) type Recordings = Vec<Arc<Path>>;

/// The files of trials.
pub(crate) fn files(trials: &[&TrialEntry]) -> Recordings {
    trials.iter().map(|t| t.path.clone()).collect()
}

/// What is there of trials, and in words what is wrong with the files of the others.
pub(crate) type Found<T> = (Vec<T>, Vec<String>);

/// What could be read of trials or sweeps; what cannot is left out and told.
///
/// # Errors
/// A file that the system does not give, though it did when the study was planned. A result without
/// it would be remembered as that of all files, and nobody would ask again.
pub(crate) fn readable<T>(read: Vec<Result<T, StoreError>>) -> Result<Found<T>, StoreError> {
    given(&read)?;
    Ok(split(read))
}

/// Whether the system gives all of them.
fn given<T>(read: &[Result<T, StoreError>]) -> Result<(), StoreError> {
    let mut errors = read.iter().filter_map(|read| read.as_ref().err());
    errors.find(|error| error.by_system).map_or(Ok(()), |error| Err(error.clone()))
}

/// Reads trials in parallel, with these signals; what cannot be read is left out and told.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn read_all(
    files: &[Arc<Path>],
    known: &[Known],
    signals: impl Iterator<Item = Signal> + Clone + Sync,
) -> Result<Found<Trial>, StoreError> {
    let trials = files.par_iter().zip(known);
    readable(trials.map(|(file, known)| read_one(file, known, signals.clone())).collect())
}

/// Samples of a trial from which on it is drawn with fewer: what is on paper or a screen has a few
/// thousand places.
pub(crate) const MOST_DRAWN: usize = 1 << 18;

/// The same to be drawn: a long trial with fewer samples, and of each trial how many were recorded.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn read_drawn(
    files: &[Arc<Path>],
    known: &[Known],
    signals: impl Iterator<Item = Signal> + Clone + Sync,
) -> Result<Found<(Trial, usize)>, StoreError> {
    let read = files.par_iter().zip(known).map(|(file, known)| {
        let (trial, recorded) = read_thinned(file, signals.clone(), MOST_DRAWN)?;
        Ok((known.names(trial), recorded))
    });
    readable(read.collect())
}

/// What `make` makes of each trial with these signals, side by side: of a long one it reads the
/// columns that it looks at. Channels that metrics read are there where the files have them.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn of_each<T: Send>(
    lately: &Lately,
    files: &[Arc<Path>],
    known: &[Known],
    signals: &[Signal],
    make: impl Fn(&OpenTrial) -> T + Sync,
) -> Result<Vec<Result<T, StoreError>>, StoreError> {
    let names = [CURRENT_MOTOR, CURRENT_BRAKE, REFERENCE];
    let channels: Vec<ChannelId> =
        names.into_iter().filter_map(|name| ChannelId::new(name).ok()).collect();
    let each = files.par_iter().zip(known).map(|(file, known)| {
        let trial = known.of_open(lately.open(file, signals, &channels)?);
        let made = make(&trial);
        // Whatever was made without a column that could not be read is void.
        trial.columns().failure().map_or(Ok(made), Err)
    });
    let each: Vec<Result<T, StoreError>> = each.collect();
    given(&each)?;
    Ok(each)
}

/// The trials, opened, one after the other: of long ones no column is read yet.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn open_all(
    files: &[Arc<Path>],
    known: &[Known],
) -> Result<Found<OpenTrial>, StoreError> {
    let all: Vec<Signal> = Signal::all().collect();
    let open =
        |(file, known): (&Arc<Path>, &Known)| Ok(known.of_open(OpenTrial::open(file, &all, &[])?));
    readable(files.par_iter().zip(known).map(open).collect())
}

fn read_one(
    file: &Path,
    known: &Known,
    signals: impl Iterator<Item = Signal>,
) -> Result<Trial, StoreError> {
    Ok(known.names(read_trial(file, signals)?))
}

/// A trial's name in a message: `P01 S01 trial 2`.
pub(crate) fn name(meta: &TrialMeta) -> String {
    format!("{} {} trial {}", meta.participant, meta.session, meta.trial)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::characterise::read_sweeps;
    use std::fs;

    /// A file that went away after the study was read stands for any that the system does not give: a
    /// disk in the network that fails for a moment.
    #[test]
    fn a_damaged_file_is_told_and_one_that_the_system_does_not_give_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let known = [Known { trial: 1, mode: "hybrid".parse().unwrap(), repeat: 1 }];
        let read = |file: std::path::PathBuf| {
            let sweeps = read_sweeps(std::slice::from_ref(&file));
            let files = [Arc::from(file)];
            let counts = |found: Result<usize, StoreError>| found.map_err(|error| error.by_system);
            let lately = Lately::default();
            let of = of_each(&lately, &files, &known, &[], |_| ()).and_then(readable);
            [
                counts(read_all(&files, &known, Signal::all()).map(|(_, told)| told.len())),
                counts(read_drawn(&files, &known, Signal::all()).map(|(_, told)| told.len())),
                counts(open_all(&files, &known).map(|(_, told)| told.len())),
                counts(of.map(|(_, told)| told.len())),
                counts(sweeps.map(|(_, told)| told.len())),
            ]
        };
        let damaged = folder.path().join("damaged.parquet");
        fs::write(&damaged, "no recording").unwrap();
        assert_eq!(read(damaged), [Ok(1); 5]);
        assert_eq!(read(folder.path().join("gone.parquet")), [Err(true); 5]);
    }
}
