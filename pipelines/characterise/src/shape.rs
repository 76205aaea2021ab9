//! The interface of every curve: an equation with parameters, fitted to points.

use zwidth_results::CurveSymbol;

/// A curve response = f(command; parameters).
pub trait Shape: Sync {
    /// The equation, x the command and y the response.
    fn formula(&self) -> &'static str;

    /// Symbol and meaning of each parameter, in the order of [`Shape::fit`].
    fn parameters(&self) -> &'static [(CurveSymbol, Quantity)];

    /// The parameters with the smallest weighted sum of squares; `None` if the points cannot
    /// determine them. A search that could end in another minimum elsewhere may start from
    /// `near` alone where it is given.
    fn fit(&self, points: &Points, near: Option<&[f64]>) -> Option<Vec<f64>>;

    /// The curve at `command`.
    fn predict(&self, parameters: &[f64], command: f64) -> f64;

    /// Whether it says how the response comes about (its parameters have a meaning), or only
    /// describes it.
    fn is_law(&self) -> bool {
        true
    }

    /// Number of parameters that are fitted.
    fn complexity(&self) -> usize {
        self.parameters().iter().filter(|(_, quantity)| *quantity != Quantity::Knot).count()
    }
}

/// The quantity of a parameter: it determines the unit and the possible faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A response.
    Response,
    /// Response per command.
    Slope,
    /// The command at which the curve begins to rise (or fall).
    Break,
    /// The command at which the curve ends to rise (or fall).
    Plateau,
    /// A command that is set by the data's range, not fitted.
    Knot,
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
            Self::Break | Self::Plateau | Self::Knot => command.to_owned(),
            Self::Gain => format!("{response}/{command}^p"),
            Self::Exponent => String::new(),
        }
    }
}

/// Samples of nearly one command, as one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Their mean command.
    pub command: f64,
    /// Their mean response.
    pub response: f64,
    /// Their weight: their number, with those drawn twice counted twice.
    pub weight: f64,
}

/// The points to which a curve is fitted.
#[derive(Debug, Clone, Copy)]
pub struct Points<'a> {
    /// Points of positive weight by rising command.
    pub at: &'a [Point],
    /// Number of samples that they stand for, each counted once.
    pub samples: usize,
    /// The commands of all points there are, rising, left out or not.
    pub levels: &'a [f64],
}

impl Points<'_> {
    /// Whether there are more samples than `parameters`, at as many commands at least.
    pub fn can_determine(&self, parameters: usize) -> bool {
        self.samples > parameters && self.at.len() >= parameters
    }

    /// Lowest and highest command at which a break may be: from the lowest command to the third
    /// from the top, so that two different commands at least are left to show the law above it. It
    /// depends on all points, left out or not. `None` if that leaves no room.
    pub fn break_range(&self) -> Option<(f64, f64)> {
        break_range(self.levels)
    }
}

/// See [`Points::break_range`]; `levels` are the different commands, rising.
pub(crate) fn break_range(levels: &[f64]) -> Option<(f64, f64)> {
    let highest = levels.len().checked_sub(3)?;
    (highest > 0).then(|| (levels[0], levels[highest]))
}

/// Weighted straight line y = a + b x through (x, y, w): (a, b), `None` if all x are equal. Two
/// passes, about the mean, so that a large offset costs no digits.
pub(crate) fn weighted_line(
    points: impl Iterator<Item = (f64, f64, f64)> + Clone,
) -> Option<(f64, f64)> {
    let mut sw = 0.0;
    let mut sx = 0.0;
    let mut sy = 0.0;
    for (x, y, w) in points.clone() {
        (sw, sx, sy) = (sw + w, sx + w * x, sy + w * y);
    }
    let mean_x = sx / sw;
    let mean_y = sy / sw;
    let mut sxx = 0.0;
    let mut sxy = 0.0;
    for (x, y, w) in points {
        let dx = x - mean_x;
        (sxx, sxy) = (sxx + w * dx * dx, sxy + w * dx * (y - mean_y));
    }
    let slope = sxy / sxx;
    (sxx > 0.0).then_some((mean_y - slope * mean_x, slope))
}

#[cfg(test)]
pub(crate) mod check {
    //! Simulate → fit → recover, for every shape alike.
    use super::*;

    /// Commands 0 … 10 in steps of 0.05.
    pub(crate) fn ramp() -> Vec<f64> {
        (0..=200).map(|i| f64::from(i) * 0.05).collect()
    }

    pub(crate) fn fit(shape: &dyn Shape, command: &[f64], response: &[f64]) -> Option<Vec<f64>> {
        fit_near(shape, command, response, None)
    }

    /// `shape` fitted to points of rising commands and weight 1.
    pub(crate) fn fit_near(
        shape: &dyn Shape,
        command: &[f64],
        response: &[f64],
        near: Option<&[f64]>,
    ) -> Option<Vec<f64>> {
        let point = |(&command, &response)| Point { command, response, weight: 1.0 };
        let at: Vec<Point> = command.iter().zip(response).map(point).collect();
        shape.fit(&Points { at: &at, samples: at.len(), levels: command }, near)
    }

    /// Asserts that `shape` recovers `truth` from its own noise-free curve to a relative 1e-6, from
    /// nowhere and from a place near by.
    pub(crate) fn recovers(shape: &dyn Shape, truth: &[f64]) {
        let command = ramp();
        let response: Vec<f64> = command.iter().map(|&x| shape.predict(truth, x)).collect();
        let near: Vec<f64> = truth.iter().map(|p| p * 1.01).collect();
        for near in [None, Some(near.as_slice())] {
            let found = fit_near(shape, &command, &response, near).unwrap();
            for (found, truth) in found.iter().zip(truth) {
                assert!((found - truth).abs() < 1e-6 * (1.0 + truth.abs()), "{found} for {truth}");
            }
        }
    }

    /// Σ (y − f(x))².
    pub(crate) fn rss(shape: &dyn Shape, parameters: &[f64], x: &[f64], y: &[f64]) -> f64 {
        x.iter().zip(y).map(|(x, y)| y - shape.predict(parameters, *x)).map(|r| r * r).sum()
    }
}
