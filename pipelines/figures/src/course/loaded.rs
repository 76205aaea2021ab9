//! One environment of one session as it was read, from which the figures of trials are drawn.

use crate::{About, EnvironmentData, ModeData, Repeat};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_numerics::activity::activity;
use zwidth_results::AveragedTime;
use zwidth_store::{Signal, Trial};
use zwidth_study::{Alignment, Analysis, Environment, ModeId};
use zwidth_tables::{NoteKind, Table, TableError};

/// The subject of a figure of trials: the study, the environment, the participant, the alignment of
/// means against time, and the speed at which a movement begins.
pub type Of<'a> = (&'a About, &'a Environment, &'a str, Alignment, &'a Analysis);

/// Tables of the stage `average`, by mode.
#[derive(Debug, Clone, Default)]
pub struct Averages {
    /// Those against time.
    pub over_time: BTreeMap<ModeId, Table>,
    /// Those of force against position.
    pub over_position: BTreeMap<ModeId, Table>,
}

/// Everything read for one environment of one session; figures borrow from it.
#[derive(Debug, Clone)]
pub struct Loaded<'a> {
    about: &'a About,
    environment: &'a Environment,
    who: &'a str,
    alignment: Alignment,
    trials: Vec<Trial>,
    onsets: Vec<Option<f64>>,
    /// Times of the samples on the scale of the mean, s, where that is not since onset.
    warped_s: Vec<Option<Vec<f64>>>,
    averages: Averages,
    notes: Vec<String>,
}

impl<'a> Loaded<'a> {
    /// What was read: trials, and tables of the stage `average`. `warp` gives, for trials of one
    /// mode, the times at which their samples are drawn behind a mean against time aligned by
    /// landmarks; a repeat that is in no mean keeps its own times.
    ///
    /// # Errors
    /// A table that lacks a column.
    pub fn new(
        (about, environment, who, alignment, analysis): Of<'a>,
        mut trials: Vec<Trial>,
        averages: Averages,
        warp: impl Fn(&[Trial]) -> Option<Vec<Option<Vec<f64>>>>,
    ) -> Result<Self, TableError> {
        // By mode, so that the trials of each stand together for `warp`.
        trials.sort_by_key(|t| about.modes.iter().position(|mode| mode.id == t.meta.mode));
        let by_landmarks = alignment == Alignment::Landmarks && !averages.over_time.is_empty();
        let of_modes = trials.chunk_by(|a, b| a.meta.mode == b.meta.mode);
        let notes = footnotes(&averages)?;
        Ok(Self {
            about,
            environment,
            who,
            alignment,
            onsets: trials.iter().map(|trial| onset_s(trial, analysis)).collect(),
            warped_s: of_modes
                .flat_map(|of_mode| {
                    let warped = by_landmarks.then(|| warp(of_mode)).flatten();
                    warped.unwrap_or_else(|| vec![None; of_mode.len()])
                })
                .collect(),
            trials,
            averages,
            notes,
        })
    }

    /// The data of the figures, for the modes that have a repeat.
    pub fn scene(&self) -> EnvironmentData<'_> {
        let Averages { over_time, over_position } = &self.averages;
        let modes = self.about.modes.iter().enumerate().filter_map(|(index, mode)| {
            let mine = (0..self.trials.len()).filter(|i| self.trials[*i].meta.mode == mode.id);
            let repeats: Vec<Repeat> = mine
                .map(|i| Repeat {
                    trial: &self.trials[i],
                    onset_s: self.onsets[i],
                    warped_s: self.warped_s[i].as_deref(),
                })
                .collect();
            let [average, loop_average] = [over_time, over_position]
                .map(|averages| averages.get(&mode.id).filter(|table| table.height() > 0));
            let data = ModeData { index, label: &mode.label, repeats, average, loop_average };
            (!data.repeats.is_empty()).then_some(data)
        });
        EnvironmentData {
            about: self.about,
            environment: self.environment,
            who: self.who.to_owned(),
            modes: modes.collect(),
            alignment: self.alignment,
            notes: self.notes.clone(),
        }
    }
}

/// When the movement of a trial begins, s, as metrics and means have it. A long trial that is drawn
/// with fewer samples has the largest speed of each short stretch, so its onset is in the same one.
fn onset_s(trial: &Trial, analysis: &Analysis) -> Option<f64> {
    let [t, velocity] = [Signal::Time, Signal::ThetaDot].map(|signal| trial.samples.get(signal));
    let moving = activity(velocity?, analysis.onset_rad_s, analysis.offset_rad_s)?;
    t?.get(moving.onset).copied()
}

/// Why there is no mean, and which repeats are not in one, each once; and where the earliest mean
/// against time ends before all of its repeats do.
fn footnotes(averages: &Averages) -> Result<Vec<String>, TableError> {
    let Averages { over_time, over_position } = averages;
    let all = over_time.values().chain(over_position.values());
    // Where a mean ends is said once for all below, how means are aligned in the legend.
    let kept = all
        .flat_map(Table::notes_by_kind)
        .filter(|(kind, _)| !matches!(kind, NoteKind::Extent | NoteKind::Alignment));
    let notes: BTreeSet<&str> = kept.map(|(_, note)| note).collect();
    let mut notes: Vec<String> = notes.into_iter().map(str::to_owned).collect();
    let mut ends = Vec::new();
    for average in over_time.values().filter(|t| t.height() > 0) {
        if average.notes_by_kind().any(|(kind, _)| kind == NoteKind::Extent) {
            let times: Vec<AveragedTime> = average.to_rows()?;
            ends.extend(times.iter().map(|time| time.t_s).max_by(f64::total_cmp));
        }
    }
    if let Some(first) = ends.into_iter().min_by(f64::total_cmp) {
        notes.push(format!(
            "Each mean ends where fewer than half of its repeats remain (the first at {first:.2} s)."
        ));
    }
    Ok(notes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_store::{Samples, TrialFile};

    #[test]
    fn a_movement_begins_at_the_first_sample_above_the_speed_whatever_its_sign() {
        let of = |velocity: Option<[f64; 4]>| {
            let mut samples = Samples::default();
            samples.set(Signal::Time, vec![0.5, 0.6, 0.7, 0.8]);
            if let Some(velocity) = velocity {
                samples.set(Signal::ThetaDot, velocity.to_vec());
            }
            let meta = zwidth_testing::meta(1, "hybrid");
            let analysis = Analysis { onset_rad_s: 0.1, ..Analysis::default() };
            onset_s(&Trial { meta, file: TrialFile::new(), samples }, &analysis)
        };
        assert_eq!(of(Some([0.0, 0.1, -0.2, 0.3])), Some(0.7), "at the threshold nobody moves yet");
        assert_eq!(of(Some([0.0, 0.1, -0.1, 0.0])), None);
        assert_eq!(of(None), None, "without a velocity nobody knows");
    }
}
