//! The force of compression minus that of decompression at the same angle, and its summaries.

use crate::MetricsError;
use zwidth_numerics::series::trapezoid;
use zwidth_stats::interval::Estimate;
use zwidth_stats::recording::recording_line;

/// The step at the reversal is read from the last tenth of the common range of angles: wide enough
/// for the force sensor's held values and the actuators' lag to average out, narrow against a
/// spring's saturation.
const STEP_WINDOW: usize = 10;

/// D(θ) on even angles that both branches cover, in any unit.
pub(crate) struct Gap {
    theta: Vec<f64>,
    d: Vec<f64>,
    /// θ at the reversal.
    turned_rad: f64,
}

impl Gap {
    /// On a grid of at least two angles.
    pub(crate) fn new(theta: Vec<f64>, d: Vec<f64>, turned_rad: f64) -> Self {
        Self { theta, d, turned_rad }
    }

    fn low_rad(&self) -> f64 {
        self.theta.first().copied().unwrap_or(self.turned_rad)
    }

    /// Δθ of the common angles, rad.
    pub(crate) fn range_rad(&self) -> f64 {
        self.theta.last().map_or(0.0, |high| high - self.low_rad())
    }

    /// ∫ D dθ / Δθ by the trapezoidal rule.
    pub(crate) fn mean(&self) -> Result<f64, MetricsError> {
        Ok(trapezoid(&self.theta, &self.d)? / self.range_rad())
    }

    /// Largest D.
    pub(crate) fn largest(&self) -> Option<f64> {
        self.d.iter().copied().reduce(f64::max)
    }

    /// The line through D, at the middle of the angles.
    pub(crate) fn line_in_the_middle(&self, level: f64) -> Result<Option<Estimate>, MetricsError> {
        line_at(&self.theta, &self.d, self.low_rad() + self.range_rad() / 2.0, level)
    }

    /// The line through D over the last tenth of the angles, at the reversal.
    pub(crate) fn step(&self, level: f64) -> Result<Option<Estimate>, MetricsError> {
        // by count: an angle that lies on the tenth's edge must not come and go with a rounding
        let last = (self.theta.len() - 1) - (self.theta.len() - 1) / STEP_WINDOW;
        line_at(&self.theta[last..], &self.d[last..], self.turned_rad, level)
    }
}

/// The line through `d` over `grid`, at `at_rad`; `None` for too few points.
fn line_at(
    grid: &[f64],
    d: &[f64],
    at_rad: f64,
    level: f64,
) -> Result<Option<Estimate>, MetricsError> {
    let line = recording_line(grid.len(), |i| (grid[i], d[i]), at_rad, level)?;
    Ok(line.map(|line| line.value))
}
