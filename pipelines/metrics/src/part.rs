//! Parts of a trial: which samples and which shares of the intervals between them belong to it.

use std::ops::Range;

/// The part of the interval between samples i and i + 1 that counts, as shares of the interval.
pub(crate) struct Piece {
    pub(crate) i: usize,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

impl Piece {
    /// The mean over it of a signal with straight lines between its samples.
    pub(crate) fn mean(&self, values: &[f64]) -> f64 {
        let share = (self.from + self.to) / 2.0;
        values[self.i] + share * (values[self.i + 1] - values[self.i])
    }
}

/// A part of a trial.
pub(crate) struct Part {
    /// Whether a sample belongs to it.
    pub(crate) samples: Vec<bool>,
    /// The intervals from the first that does, in part, to the last.
    intervals: Range<usize>,
    /// Where an interval with one sample in it and one not enters or leaves it, as a share of the
    /// interval: in order.
    crossings: Vec<f64>,
}

impl Part {
    /// From the sample `first` to the sample `last`, of so many.
    pub(crate) fn between(first: usize, last: usize, samples: usize) -> Self {
        Self {
            samples: (0..samples).map(|i| (first..=last).contains(&i)).collect(),
            intervals: first..last,
            crossings: Vec::new(),
        }
    }

    /// Where θ > θ_wall, θ taken as straight lines between samples.
    pub(crate) fn past(theta: &[f64], wall: f64) -> Self {
        let passes = theta.windows(2).filter(|w| (w[0] > wall) != (w[1] > wall));
        let samples: Vec<bool> = theta.iter().map(|theta| *theta > wall).collect();
        let first = samples.iter().position(|past| *past).unwrap_or(samples.len());
        let last = samples.iter().rposition(|past| *past).unwrap_or(0);
        Self {
            intervals: first.saturating_sub(1)..(last + 1).min(samples.len().saturating_sub(1)),
            samples,
            crossings: passes.map(|w| (wall - w[0]) / (w[1] - w[0])).collect(),
        }
    }

    /// Σ over its parts of intervals.
    pub(crate) fn over_pieces(&self, value: impl Fn(&Piece) -> f64) -> f64 {
        let mut crossings = self.crossings.iter().copied();
        let mut sum = 0.0;
        for i in self.intervals.clone() {
            let (from, to) = match (self.samples[i], self.samples[i + 1]) {
                (true, true) => (0.0, 1.0),
                (false, true) => (crossings.next().unwrap_or_default(), 1.0),
                (true, false) => (0.0, crossings.next().unwrap_or_default()),
                (false, false) => continue,
            };
            sum += value(&Piece { i, from, to });
        }
        sum
    }

    /// The samples in it, in order.
    pub(crate) fn places(&self) -> impl Iterator<Item = usize> {
        self.samples.iter().enumerate().filter_map(|(i, is_in)| is_in.then_some(i))
    }

    /// The largest value of a signal there.
    pub(crate) fn largest(&self, values: &[f64]) -> Option<f64> {
        self.places().map(|i| values[i]).reduce(f64::max)
    }
}
