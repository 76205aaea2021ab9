//! Reading the trials of a job.

use crate::making::split;
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};
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

/// The files of trials.
pub(crate) fn files(trials: &[&TrialEntry]) -> Vec<PathBuf> {
    trials.iter().map(|t| t.path.clone()).collect()
}

/// Reads trials in parallel, with these signals; what cannot be read is left out and told.
pub(crate) fn read_all(
    files: &[PathBuf],
    known: &[Known],
    signals: impl Iterator<Item = Signal> + Clone + Sync,
) -> (Vec<Trial>, Vec<String>) {
    let trials = files.par_iter().zip(known);
    split(trials.map(|(file, known)| read_one(file, known, signals.clone())).collect())
}

/// Samples of a trial from which on it is drawn with fewer: what is on paper or a screen has a few
/// thousand places.
pub(crate) const MOST_DRAWN: usize = 1 << 18;

/// The same to be drawn: a long trial with fewer samples, and of each trial how many were recorded.
pub(crate) fn read_drawn(
    files: &[PathBuf],
    known: &[Known],
    signals: impl Iterator<Item = Signal> + Clone + Sync,
) -> (Vec<(Trial, usize)>, Vec<String>) {
    let read = files.par_iter().zip(known).map(|(file, known)| {
        let (trial, recorded) = read_thinned(file, signals.clone(), MOST_DRAWN)?;
        Ok::<_, StoreError>((known.names(trial), recorded))
    });
    split(read.collect())
}

/// What `make` makes of each trial with these signals, side by side: of a long one it reads the
/// columns that it looks at. Channels that metrics read are there where the files have them. What
/// cannot be read, and why `make` made nothing, is told.
pub(crate) fn of_each<T: Send>(
    lately: &Lately,
    (files, known): (&[PathBuf], &[Known]),
    signals: &[Signal],
    make: impl Fn(&OpenTrial) -> Result<T, String> + Sync,
) -> (Vec<T>, Vec<String>) {
    let names = [CURRENT_MOTOR, CURRENT_BRAKE, REFERENCE];
    let channels: Vec<ChannelId> =
        names.into_iter().filter_map(|name| ChannelId::new(name).ok()).collect();
    let each = files.par_iter().zip(known).map(|(file, known)| {
        let trial = lately.open(file, signals, &channels).map_err(|e| e.to_string())?;
        let trial = known.of_open(trial);
        let made = make(&trial);
        // Whatever was made without a column that could not be read is void.
        trial.columns().failure().map_or(made, |error| Err(error.to_string()))
    });
    split(each.collect())
}

/// The trials, opened, one after the other: of long ones no column is read yet.
pub(crate) fn open_all(files: &[PathBuf], known: &[Known]) -> (Vec<OpenTrial>, Vec<String>) {
    let all: Vec<Signal> = Signal::all().collect();
    let open = |(file, known): (&PathBuf, &Known)| {
        Ok::<_, StoreError>(known.of_open(OpenTrial::open(file, &all, &[])?))
    };
    split(files.par_iter().zip(known).map(open).collect())
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
