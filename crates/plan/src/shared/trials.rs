//! Reading the trials of a job.

use crate::shared::making::split;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt::Display;
use std::path::Path;
use std::sync::Arc;
use zwidth_store::{
    Lately, OpenTrial, Signal, StoreError, StudyData, Trial, TrialEntry, read_thinned, read_trial,
};
use zwidth_study::{ChannelId, ModeId, TrialMeta};

/// A trial's number, mode and repeat as the session has them. A trial that was recorded sealed has a
/// code for its mode in its file, also after the session was unsealed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct TrialLabel {
    pub(crate) trial: u32,
    pub(crate) mode: ModeId,
    pub(crate) repeat: u32,
}

/// A stage's parameters, and the labels of the trials that it gets.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct OfTrials<P> {
    #[serde(flatten)]
    pub(crate) stage: P,
    pub(crate) trials: Vec<TrialLabel>,
}

impl<P> OfTrials<P> {
    pub(crate) fn new(stage: P, trials: &[&TrialEntry]) -> Self {
        Self { stage, trials: label_trials(trials) }
    }
}

/// The labels of trials.
pub(crate) fn label_trials(trials: &[&TrialEntry]) -> Vec<TrialLabel> {
    trials
        .iter()
        .map(|TrialEntry { meta, .. }| TrialLabel {
            trial: meta.trial,
            mode: meta.mode.clone(),
            repeat: meta.repeat,
        })
        .collect()
}

impl TrialLabel {
    /// Writes mode and repeat over those that a trial's file has.
    fn apply(&self, meta: &mut TrialMeta) {
        meta.mode = self.mode.clone();
        meta.repeat = self.repeat;
    }
}

/// Recordings that a job reads. All jobs share a trial's path.
pub(crate) type Recordings = Vec<Arc<Path>>;

/// The files of trials.
pub(crate) fn files(trials: &[&TrialEntry]) -> Recordings {
    trials.iter().map(|t| t.path.clone()).collect()
}

/// The files that say what was recorded: trials, and the records and events of sessions.
pub(crate) fn origins(data: &StudyData) -> Vec<Arc<Path>> {
    let logs = data.sessions.iter().flat_map(|s| [&s.path, &s.events_path]);
    let trials = data.trials.iter().map(|trial| trial.path.clone());
    trials.chain(logs.map(|path| path.as_path().into())).collect()
}

/// What could be made of trials, and in words what is wrong with the files of the others.
pub(crate) type WithProblems<T> = (Vec<T>, Vec<String>);

/// The trials or sweeps that could be read; the others are left out and reported.
///
/// # Errors
/// A file that the system does not give, though it did when the study was planned. A result without
/// it would be remembered as that of all files, and nobody would ask again.
pub(crate) fn readable<T>(read: Vec<Result<T, StoreError>>) -> Result<WithProblems<T>, StoreError> {
    check_system(&read)?;
    Ok(split(read))
}

/// The first error that is the system's, and not the file's, if there is one.
fn check_system<T>(read: &[Result<T, StoreError>]) -> Result<(), StoreError> {
    let mut errors = read.iter().filter_map(|read| read.as_ref().err());
    errors.find(|error| error.by_system).map_or(Ok(()), |error| Err(error.clone()))
}

/// Reads trials in parallel, with these signals; those that cannot be read are left out and reported.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn read_all(
    files: &[Arc<Path>],
    labels: &[TrialLabel],
    signals: impl Iterator<Item = Signal> + Clone + Sync,
) -> Result<WithProblems<Trial>, StoreError> {
    let read = files.par_iter().zip(labels).map(|(file, label)| {
        let mut trial = read_trial(file, signals.clone())?;
        label.apply(&mut trial.meta);
        Ok(trial)
    });
    readable(read.collect())
}

/// What `make` makes of each trial with all its signals, side by side; trials that cannot be read or
/// are refused are left out and reported.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn read_and_make<T: Send, E: Display>(
    files: &[Arc<Path>],
    labels: &[TrialLabel],
    make: impl Fn(&Trial) -> Result<T, E> + Sync,
) -> Result<WithProblems<T>, StoreError> {
    let (trials, mut problems) = read_all(files, labels, Signal::all())?;
    let results = trials
        .par_iter()
        .map(|trial| make(trial).map_err(|error| format!("{}: {error}", name(&trial.meta))));
    let (good, refused) = split(results.collect());
    problems.extend(refused);
    Ok((good, problems))
}

/// Trials with more samples than this are drawn with fewer: paper and screens have a few thousand
/// places.
pub(crate) const MOST_DRAWN: usize = 1 << 18;

/// The same to be drawn: a long trial with fewer samples, and of each trial how many were recorded.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn read_drawn(
    files: &[Arc<Path>],
    labels: &[TrialLabel],
    signals: impl Iterator<Item = Signal> + Clone + Sync,
) -> Result<WithProblems<(Trial, usize)>, StoreError> {
    let read = files.par_iter().zip(labels).map(|(file, label)| {
        let (mut trial, recorded) = read_thinned(file, signals.clone(), MOST_DRAWN)?;
        label.apply(&mut trial.meta);
        Ok((trial, recorded))
    });
    readable(read.collect())
}

/// What `make` makes of each trial with these signals, side by side; of a long trial only the columns
/// that `make` looks at are read. Channels are included where the files have them.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn of_each<T: Send>(
    lately: &Lately,
    files: &[Arc<Path>],
    labels: &[TrialLabel],
    signals: &[Signal],
    channels: &[ChannelId],
    make: impl Fn(&OpenTrial) -> T + Sync,
) -> Result<Vec<Result<T, StoreError>>, StoreError> {
    let each = files.par_iter().zip(labels).map(|(file, label)| {
        let mut trial = lately.open(file, signals, channels)?;
        label.apply(&mut trial.meta);
        let result = make(&trial);
        // Whatever was made without a column that could not be read is void.
        trial.columns().failure().map_or(Ok(result), Err)
    });
    let each: Vec<Result<T, StoreError>> = each.collect();
    check_system(&each)?;
    Ok(each)
}

/// The trials, opened side by side; of long ones no column is read yet.
///
/// # Errors
/// A file that the system does not give.
pub(crate) fn open_all(
    files: &[Arc<Path>],
    labels: &[TrialLabel],
) -> Result<WithProblems<OpenTrial>, StoreError> {
    let all: Vec<Signal> = Signal::all().collect();
    let open = files.par_iter().zip(labels).map(|(file, label)| {
        let mut trial = OpenTrial::open(file, &all, &[])?;
        label.apply(&mut trial.meta);
        Ok(trial)
    });
    readable(open.collect())
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
        let known = [TrialLabel { trial: 1, mode: "hybrid".parse().unwrap(), repeat: 1 }];
        let read = |file: std::path::PathBuf| {
            let sweeps = read_sweeps(std::slice::from_ref(&file));
            let files = [Arc::from(file)];
            let counts = |found: Result<usize, StoreError>| found.map_err(|error| error.by_system);
            let lately = Lately::default();
            let of = of_each(&lately, &files, &known, &[], &[], |_| ()).and_then(readable);
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
