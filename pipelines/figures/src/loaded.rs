//! One environment of one session as it was read, from which the figures of trials are drawn.

use crate::{About, EnvironmentData, ModeData, Repeat};
use std::collections::BTreeMap;
use zwidth_store::Trial;
use zwidth_study::{Alignment, Environment, ModeId};
use zwidth_tables::{NoteKind, Table, TableError};

/// The columns that figures read of a table of the stage `metrics`.
pub const METRICS_COLUMNS: [&str; 2] = ["trial", "onset_s"];

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
    /// By mode; those without a row are none.
    averages: BTreeMap<ModeId, Table>,
    notes: Vec<String>,
}

impl<'a> Loaded<'a> {
    /// What was read: trials, tables of the stage `metrics` with [`METRICS_COLUMNS`], and by mode
    /// those of the stage `average`. `warp` gives, for trials of one mode, the times at which
    /// their samples stand behind a mean aligned by landmarks; a repeat that is in no mean stays at
    /// its own.
    ///
    /// # Errors
    /// A table that lacks a column.
    pub fn new(
        (about, environment, who, alignment): (&'a About, &'a Environment, &'a str, Alignment),
        mut trials: Vec<Trial>,
        metrics: &[Table],
        averages: Vec<(ModeId, Table)>,
        warp: impl Fn(&[Trial]) -> Option<Vec<Option<Vec<f64>>>>,
    ) -> Result<Self, TableError> {
        trials.sort_by_key(|t| about.modes.iter().position(|mode| mode.id == t.meta.mode));
        let mut onsets = BTreeMap::new();
        for table in metrics {
            onsets.extend(table.integers("trial")?.into_iter().zip(table.floats("onset_s")?));
        }
        let onset = |t: &Trial| onsets.get(&Some(i64::from(t.meta.trial))).copied().flatten();
        let by_landmarks = alignment == Alignment::Landmarks && !averages.is_empty();
        let times = |of_mode: &[Trial]| {
            let warped = by_landmarks.then(|| warp(of_mode)).flatten();
            warped.unwrap_or_else(|| vec![None; of_mode.len()])
        };
        let of_modes = trials.chunk_by(|a, b| a.meta.mode == b.meta.mode);
        let notes = footnotes(averages.iter().map(|(_, table)| table))?;
        Ok(Self {
            about,
            environment,
            who,
            alignment,
            onsets: trials.iter().map(onset).collect(),
            warped_s: of_modes.flat_map(times).collect(),
            trials,
            averages: averages.into_iter().filter(|(_, table)| table.height() > 0).collect(),
            notes,
        })
    }

    /// The same, by modes that have a repeat.
    pub fn scene(&self) -> EnvironmentData<'_> {
        let modes = self.about.modes.iter().enumerate().filter_map(|(index, mode)| {
            let mine = (0..self.trials.len()).filter(|i| self.trials[*i].meta.mode == mode.id);
            let repeats: Vec<_> = mine.map(|i| self.repeat(i)).collect();
            let average = self.averages.get(&mode.id);
            let data = ModeData { index, label: &mode.label, repeats, average };
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

    fn repeat(&self, i: usize) -> Repeat<'_> {
        Repeat {
            trial: &self.trials[i],
            onset_s: self.onsets[i],
            warped_s: self.warped_s[i].as_deref(),
        }
    }
}

/// Why there is no mean, each reason once; and where the earliest mean ends before all of its
/// repeats do.
fn footnotes<'t>(
    averages: impl Iterator<Item = &'t Table> + Clone,
) -> Result<Vec<String>, TableError> {
    let without = averages.clone().filter(|t| t.height() == 0);
    let mut notes: Vec<String> = without.flat_map(|t| t.notes().iter().cloned()).collect();
    notes.sort();
    notes.dedup();
    let mut ends = Vec::new();
    for average in averages.filter(|t| t.height() > 0) {
        let is_extent = |(kind, _): &(NoteKind, &str)| *kind == NoteKind::Extent;
        let others = average.notes_by_kind().filter(|note| !is_extent(note));
        notes.extend(others.map(|(_, note)| note.to_owned()));
        if average.notes_by_kind().any(|note| is_extent(&note)) {
            ends.extend(average.floats("t_s")?.into_iter().flatten().max_by(f64::total_cmp));
        }
    }
    if let Some(first) = ends.into_iter().min_by(f64::total_cmp) {
        notes.push(format!(
            "Each mean ends where fewer than half of its repeats remain (the first at {first:.2} s)."
        ));
    }
    Ok(notes)
}
