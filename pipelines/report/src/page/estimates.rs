//! What the stage `compare` estimated of a metric, as the page's script draws it: means and
//! differences with their intervals.

use crate::compared::floats;
use serde::Serialize;
use zwidth_tables::{Table, TableError};

/// A mean in one condition, or a difference between two, in the table's unit.
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
    n: Option<i64>,
    unit_of_analysis: String,
}

/// The means by environment and mode.
pub(super) fn means(table: &Table) -> Result<Vec<Estimate>, TableError> {
    estimates(table, "mode", ["mean", "ci_low", "ci_high"])
}

/// The differences by environment and contrast.
pub(super) fn differences(table: &Table) -> Result<Vec<Estimate>, TableError> {
    estimates(table, "contrast", ["difference", "difference_ci_low", "difference_ci_high"])
}

fn estimates(table: &Table, of: &str, columns: [&str; 3]) -> Result<Vec<Estimate>, TableError> {
    if table.height() == 0 {
        return Ok(Vec::new());
    }
    let (environments, ofs) = (table.texts("environment")?, table.texts(of)?);
    let (units, n) = (table.texts("unit_of_analysis")?, table.integers("n")?);
    let [value, low, high] = columns.map(|stem| floats(table, stem));
    let (value, low, high) = (value?, low?, high?);
    let estimate = |row: usize| {
        Some(Estimate {
            environment: environments[row].clone()?,
            of: ofs[row].clone()?,
            value: value[row]?,
            low: low[row],
            high: high[row],
            n: n[row],
            unit_of_analysis: units[row].clone().unwrap_or_default(),
        })
    };
    Ok((0..table.height()).filter_map(estimate).collect())
}
