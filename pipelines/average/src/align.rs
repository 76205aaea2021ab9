//! One repeat, placed at its onset.

use crate::{AverageError, WhyNot};
use zwidth_numerics::activity::activity;
use zwidth_numerics::series::interpolate_all;
use zwidth_store::{Signal, Trial};
use zwidth_study::Analysis;

/// A repeat with its own times since onset.
pub(crate) struct Aligned<'a> {
    trial: &'a Trial,
    pub(crate) onset_s: f64,
    /// Time since onset, s; negative before it.
    since_onset_s: Vec<f64>,
}

impl<'a> Aligned<'a> {
    /// Places `trial` at its onset, or says why it has none.
    pub(crate) fn new(trial: &'a Trial, analysis: &Analysis) -> Result<Self, WhyNot> {
        let t = trial.samples.get(Signal::Time).unwrap_or_default();
        trial.samples.get(Signal::Theta).ok_or(WhyNot::NoAngle)?;
        let velocity = trial.samples.get(Signal::ThetaDot).ok_or(WhyNot::NoVelocity)?;
        let moving = activity(velocity, analysis.onset_rad_s, analysis.offset_rad_s);
        let onset_s = t[moving.ok_or(WhyNot::NoMovement)?.onset];
        Ok(Self { trial, onset_s, since_onset_s: t.iter().map(|t| t - onset_s).collect() })
    }

    pub(crate) fn trial(&self) -> &'a Trial {
        self.trial
    }

    /// From onset to the last sample, s.
    pub(crate) fn length_s(&self) -> f64 {
        self.since_onset_s.last().copied().unwrap_or(0.0)
    }

    /// `signal` on the grid: null where the repeat has ended. `None` where it was not recorded.
    pub(crate) fn on_grid(&self, signal: Signal, grid_s: &[f64]) -> Option<Vec<Option<f64>>> {
        Some(interpolate_all(&self.since_onset_s, self.trial.samples.get(signal)?, grid_s))
    }
}

/// Checks that every column of `trial` is as long as its time.
pub(crate) fn check_lengths(trial: &Trial) -> Result<(), AverageError> {
    let expected = trial.samples.get(Signal::Time).map_or(0, <[f64]>::len);
    for signal in Signal::all() {
        let found = trial.samples.get(signal).map_or(expected, <[f64]>::len);
        if found != expected {
            let (trial, column) = (trial.meta.trial, signal.name());
            return Err(AverageError::Ragged { trial, column, expected, found });
        }
    }
    Ok(())
}

/// How long the average lasts, s: as long as at least half of the repeats do (with `lengths_s` not empty).
pub(crate) fn average_length_s(mut lengths_s: Vec<f64>) -> f64 {
    lengths_s.sort_by(|a, b| b.total_cmp(a));
    lengths_s[lengths_s.len().div_ceil(2) - 1]
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
