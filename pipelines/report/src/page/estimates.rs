//! What the stage `compare` estimated of a metric, as the page's script draws it: means and
//! differences with their intervals.

use serde::Serialize;
use zwidth_results::{Mean, ModeDifference};

/// A mean in one condition, or a difference between two, in the metric's unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Estimate {
    environment: String,
    /// The mode, or the contrast as the tables write it.
    of: String,
    value: f64,
    /// Ends of the interval, where there is one.
    low: Option<f64>,
    high: Option<f64>,
    /// Units of analysis, and what they are.
    n: usize,
    unit_of_analysis: String,
}

impl Estimate {
    pub(super) fn of_mean(row: &Mean) -> Self {
        Self {
            environment: row.environment.to_string(),
            of: row.mode.to_string(),
            value: row.mean,
            low: row.ci_low,
            high: row.ci_high,
            n: row.n,
            unit_of_analysis: row.unit_of_analysis.to_string(),
        }
    }

    pub(super) fn of_difference(row: &ModeDifference) -> Self {
        Self {
            environment: row.environment.to_string(),
            of: row.contrast.to_string(),
            value: row.difference,
            low: row.difference_ci_low,
            high: row.difference_ci_high,
            n: row.n,
            unit_of_analysis: row.unit_of_analysis.to_string(),
        }
    }
}
