//! One repeat, placed at its onset or by its landmarks.

use crate::landmarks::{Landmark, Times, shared, warp};
use crate::{AverageError, WhyNot};
use zwidth_numerics::activity::activity;
use zwidth_numerics::phases::{Phases, first_passing, phases, return_begins};
use zwidth_numerics::series::interpolate_by;
use zwidth_store::{Recorded, Signal, Values};
use zwidth_study::{Alignment, Analysis, TrialMeta};

/// A repeat with its times on the common scale.
pub(crate) struct Aligned<'a> {
    trial: Recorded<'a>,
    pub(crate) onset_s: f64,
    /// Times at which it passes its landmarks, s since its onset.
    pub(crate) landmarks: Times,
    /// Its phases, and the sample at which the way back begins.
    pub(crate) phases: (Phases, Option<usize>),
    /// Its last sample, s since its onset.
    last_s: f64,
    /// Its own landmarks and those of the common scale that they meet, s; empty if it is aligned at
    /// onset alone.
    warped: (Vec<f64>, Vec<f64>),
}

impl<'a> Aligned<'a> {
    /// Places `trial` at its onset, or says why it has no onset.
    pub(crate) fn new(
        trial: Recorded<'a>,
        analysis: &Analysis,
        wall_rad: Option<f64>,
    ) -> Result<Self, WhyNot> {
        let columns = trial.columns;
        let Analysis { onset_rad_s, offset_rad_s, .. } = *analysis;
        // Columns are read from the file when they are requested, and forgotten when they are
        // dropped: the velocity alone shows whether there is a movement for the others to place.
        let moving = {
            if !columns.has(Signal::Theta) {
                return Err(WhyNot::NoAngle);
            }
            let velocity = columns.column(Signal::ThetaDot).ok_or(WhyNot::NoVelocity)?;
            activity(&velocity, onset_rad_s, offset_rad_s).ok_or(WhyNot::NoMovement)?
        };
        let theta = columns.column(Signal::Theta).ok_or(WhyNot::NoAngle)?;
        let phases = phases(&theta, moving.onset, moving.end.unwrap_or(columns.rows() - 1));
        let velocity = columns.column(Signal::ThetaDot).ok_or(WhyNot::NoVelocity)?;
        let returns = return_begins(&velocity, phases, onset_rad_s, offset_rad_s);
        let t = columns.column(Signal::Time).ok_or(WhyNot::NoMovement)?;
        let wall_s = wall_rad.and_then(|wall| first_passing(&t, &theta, wall));
        let landmarks = [
            Some(t[phases.onset]),
            wall_s,
            Some(t[phases.reversal]),
            returns.map(|returns| t[returns]),
            moving.end.map(|end| t[end]),
        ];
        let onset_s = t[moving.onset];
        Ok(Self {
            trial,
            onset_s,
            landmarks: landmarks.map(|l| l.map(|t| t - onset_s)),
            phases: (phases, returns),
            last_s: t.last().copied().unwrap_or(onset_s) - onset_s,
            warped: Default::default(),
        })
    }

    /// The repeat itself, unless it lacks what `alignment` needs.
    pub(crate) fn fit_for(self, alignment: Alignment) -> Result<Self, WhyNot> {
        let has_end = self.landmarks[Landmark::End as usize].is_some();
        if has_end || alignment == Alignment::Onset { Ok(self) } else { Err(WhyNot::NoEnd) }
    }

    /// A signal as it was recorded.
    pub(crate) fn column(&self, signal: Signal) -> Option<Values<'a>> {
        self.trial.columns.column(signal)
    }

    pub(crate) fn meta(&self) -> &'a TrialMeta {
        self.trial.meta
    }

    /// A time since the onset on the common scale, s.
    fn common_s(&self, since_onset_s: f64) -> f64 {
        let (own, common) = &self.warped;
        if own.is_empty() { since_onset_s } else { warp(since_onset_s, own, common) }
    }

    /// The time of each sample on the common scale, s; negative before the onset.
    pub(crate) fn times_s(&self) -> Vec<f64> {
        let t = self.trial.columns.column(Signal::Time);
        t.iter().flat_map(|t| t.iter()).map(|t| self.common_s(t - self.onset_s)).collect()
    }

    /// From onset to the last sample on the common scale, s.
    pub(crate) fn length_s(&self) -> f64 {
        self.common_s(self.last_s)
    }

    /// `signal` on the grid: null where the repeat has ended. `None` where it was not recorded.
    pub(crate) fn on_grid(&self, signal: Signal, grid_s: &[f64]) -> Option<Vec<Option<f64>>> {
        let columns = self.trial.columns;
        let t = columns.column(Signal::Time)?;
        let values = columns.column(signal)?;
        let time = |i: usize| self.common_s(t[i] - self.onset_s);
        Some(grid_s.iter().map(|at| interpolate_by(t.len(), time, |i| values[i], *at)).collect())
    }
}

/// The landmarks that all repeats share, with their mean times.
pub(crate) fn mean_landmarks(aligned: &[Aligned]) -> Vec<(Landmark, f64)> {
    let times: Vec<_> = aligned.iter().map(|a| a.landmarks).collect();
    let mut means = Vec::new();
    for landmark in shared(&times) {
        let passed: Vec<f64> = times.iter().filter_map(|times| times[landmark as usize]).collect();
        means.push((landmark, passed.iter().sum::<f64>() / passed.len() as f64));
    }
    means
}

/// The repeat with its own landmarks at the times of `landmarks`; unchanged where there are none.
pub(crate) fn warped<'a>(repeat: Aligned<'a>, landmarks: &[(Landmark, f64)]) -> Aligned<'a> {
    let both = landmarks.iter().filter_map(|(l, t)| Some((repeat.landmarks[*l as usize]?, *t)));
    Aligned { warped: both.unzip(), ..repeat }
}

/// Checks that every column of `trial` is as long as its time.
pub(crate) fn check_lengths(trial: &Recorded) -> Result<(), AverageError> {
    match trial.columns.ragged() {
        None => Ok(()),
        Some((column, found)) => Err(AverageError::Ragged {
            trial: trial.meta.trial,
            column,
            expected: trial.columns.rows(),
            found,
        }),
    }
}

/// Repeats of one length differ by no more than this share of it after their onset is taken off.
const ROUNDING: f64 = 1e-9;

/// The length of the average, s: that which at least half of the repeats reach (with `lengths_s`
/// not empty).
pub(crate) fn average_length_s(mut lengths_s: Vec<f64>) -> f64 {
    lengths_s.sort_by(|a, b| b.total_cmp(a));
    let half = lengths_s[lengths_s.len().div_ceil(2) - 1];
    // The shortest of those that last as long but for rounding: none must drop out at the last
    // point.
    lengths_s.into_iter().filter(|l| *l >= half * (1.0 - ROUNDING)).fold(half, f64::min)
}

/// `points` (at least 2) even times from 0 to `length_s`, both exactly.
pub(crate) fn grid(length_s: f64, points: usize) -> Vec<f64> {
    (0..points).map(|i| length_s * (i as f64 / (points - 1) as f64)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_average_lasts_as_long_as_half_of_its_repeats() {
        for (lengths, expect) in [
            (vec![2.0], 2.0),
            (vec![2.0, 3.0], 3.0),
            (vec![1.0, 2.0, 3.0], 2.0),
            (vec![3.0, 3.0 - 1e-15, 3.0 - 2e-15, 1.0], 3.0 - 2e-15),
            (vec![6.0, 1.0, 5.0, 2.0, 4.0, 3.0], 4.0),
        ] {
            assert_eq!(Some(average_length_s(lengths.clone())), Some(expect), "{lengths:?}");
        }
    }

    #[test]
    fn a_grid_begins_and_ends_exactly() {
        let grid = grid(1.7, 401);
        assert_eq!((grid.len(), grid[0], grid[400]), (401, 0.0, 1.7));
        assert!(grid.windows(2).all(|w| w[0] < w[1]));
    }
}
