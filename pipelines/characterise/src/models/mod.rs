//! The candidates: each is a curve with parameters, one file each.
//!
//! A new one is a file with a unit struct that implements [`Model`], and a line in [`ALL`].

mod hinge;
mod line;
mod power_law;

pub use hinge::Hinge;
pub use line::Line;
pub use power_law::PowerLaw;

/// The candidates, simplest first.
pub const ALL: [&dyn Model; 3] = [&Line, &Hinge, &PowerLaw];

/// The candidate of that name.
pub fn by_name(name: &str) -> Option<&'static dyn Model> {
    ALL.into_iter().find(|model| model.name() == name)
}

/// A curve response = f(command; parameters).
pub trait Model: Sync {
    /// Name in tables and files.
    fn name(&self) -> &'static str;

    /// The equation, x the command and y the response.
    fn formula(&self) -> &'static str;

    /// Name and meaning of each parameter, in the order of [`Model::fit`].
    fn parameters(&self) -> &'static [(&'static str, Quantity)];

    /// The parameters with the smallest weighted sum of squares; `None` if the points of positive weight
    /// cannot determine them.
    fn fit(&self, points: &Points) -> Option<Vec<f64>>;

    /// The curve at `command`.
    fn predict(&self, parameters: &[f64], command: f64) -> f64;
}

/// What a parameter stands for: it decides the unit and what can be wrong with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A response.
    Response,
    /// Response per command.
    Slope,
    /// The command at which the curve changes its law.
    Break,
    /// Response per command to the power of the exponent.
    Gain,
    /// A pure number.
    Exponent,
}

impl Quantity {
    /// Its unit, from those of command and response; empty for a pure number.
    pub fn unit(self, command: &str, response: &str) -> String {
        match self {
            Self::Response => response.to_owned(),
            Self::Slope => format!("{response}/{command}"),
            Self::Break => command.to_owned(),
            Self::Gain => format!("{response}/{command}^p"),
            Self::Exponent => String::new(),
        }
    }
}

/// What a model is fitted to: samples in the order of recording, with weights ≥ 0 (0 leaves a sample out, 2
/// counts it twice). All slices but `levels` have one length.
#[derive(Debug, Clone, Copy)]
pub struct Points<'a> {
    /// Commands.
    pub command: &'a [f64],
    /// Responses.
    pub response: &'a [f64],
    /// Weights, no unit.
    pub weight: &'a [f64],
    /// Indices of the samples by rising command.
    pub order: &'a [usize],
    /// The different commands, rising, of all samples, whatever their weight.
    pub levels: &'a [f64],
}

impl Points<'_> {
    /// Samples of positive weight: (command, response, weight), in the order of recording.
    pub fn weighted(&self) -> impl Iterator<Item = (f64, f64, f64)> + Clone {
        let samples = self.command.iter().zip(self.response).zip(self.weight);
        samples.map(|((&x, &y), &w)| (x, y, w)).filter(|&(_, _, w)| w > 0.0)
    }

    /// Whether there are more samples of positive weight than `parameters`, at as many commands at least.
    pub fn can_determine(&self, parameters: usize) -> bool {
        let mut used = self.order.iter().filter(|&&i| self.weight[i] > 0.0).map(|&i| self.command[i]);
        let Some(mut last) = used.next() else { return false };
        let (mut samples, mut commands) = (1, 1);
        for command in used {
            samples += 1;
            commands += usize::from(command > last);
            last = command;
        }
        samples > parameters && commands >= parameters
    }

    /// Lowest and highest command at which a break may lie: from the lowest command to the third from the top,
    /// so that two different commands at least are left to show the law above it. It depends on all samples,
    /// whatever their weight. `None` if that leaves no room.
    pub fn break_range(&self) -> Option<(f64, f64)> {
        break_range(self.levels)
    }
}

/// See [`Points::break_range`]; `levels` are the different commands, rising.
pub(crate) fn break_range(levels: &[f64]) -> Option<(f64, f64)> {
    let highest = levels.len().checked_sub(3)?;
    (highest > 0).then(|| (levels[0], levels[highest]))
}

/// Weighted straight line y = a + b x through (x, y, w): (a, b), `None` if all x are equal. Two passes, about
/// the mean, so that a large offset costs no digits.
pub(crate) fn weighted_line(points: impl Iterator<Item = (f64, f64, f64)> + Clone) -> Option<(f64, f64)> {
    let (mut sw, mut sx, mut sy) = (0.0, 0.0, 0.0);
    for (x, y, w) in points.clone() {
        (sw, sx, sy) = (sw + w, sx + w * x, sy + w * y);
    }
    let (mean_x, mean_y) = (sx / sw, sy / sw);
    let (mut sxx, mut sxy) = (0.0, 0.0);
    for (x, y, w) in points {
        let dx = x - mean_x;
        (sxx, sxy) = (sxx + w * dx * dx, sxy + w * dx * (y - mean_y));
    }
    let slope = sxy / sxx;
    (sxx > 0.0).then_some((mean_y - slope * mean_x, slope))
}

#[cfg(test)]
pub(crate) mod check {
    //! Simulate → fit → recover, for every candidate alike.
    use super::*;
    use crate::samples::{Samples, Sweep};

    /// Commands 0 … 10 in steps of 0.05.
    pub(crate) fn ramp() -> Vec<f64> {
        (0..=200).map(|i| f64::from(i) * 0.05).collect()
    }

    pub(crate) fn fit(
        model: &dyn Model,
        command: &[f64],
        response: &[f64],
        weight: &[f64],
    ) -> Option<Vec<f64>> {
        let samples = Samples::new(&[Sweep { command, response }]).unwrap();
        model.fit(&samples.points(response, weight))
    }

    /// Asserts that `model` recovers `truth` from its own noise-free curve to a relative 1e-6.
    pub(crate) fn recovers(model: &dyn Model, truth: &[f64]) {
        let command = ramp();
        let response: Vec<f64> = command.iter().map(|&x| model.predict(truth, x)).collect();
        let found = fit(model, &command, &response, &vec![1.0; command.len()]).unwrap();
        for (found, truth) in found.iter().zip(truth) {
            assert!((found - truth).abs() < 1e-6 * (1.0 + truth.abs()), "{found} for {truth}");
        }
    }
}
