//! Sums of squares of complete tables.

use crate::error::{StatsError, all_finite};
use crate::tested::{Unestimable, at_least, not_constant};

/// The two-way decomposition of a complete table without repeats.
pub(crate) struct TwoWay {
    /// Sum of squares between rows, times columns.
    pub(crate) rows: f64,
    /// Sum of squares between columns, times rows.
    pub(crate) columns: f64,
    /// The remaining sum of squares.
    pub(crate) error: f64,
}

/// Decomposes a table of at least two rows and two columns, all rows of one length, all values
/// finite, whose rows do not all differ alike. The `units` say in messages what its rows, its
/// columns, and their differences are.
pub(crate) fn two_way(table: &[Vec<f64>], units: [&'static str; 3]) -> Result<TwoWay, Unestimable> {
    /// A sum of squares below this share of the total is rounding.
    const ROUNDING: f64 = 1e-24;
    let n = table.len();
    at_least(units[0], n, 2)?;
    let k = table[0].len();
    for (row, values) in table.iter().enumerate() {
        if values.len() != k {
            return Err(StatsError::Ragged { row, expected: k, found: values.len() }.into());
        }
        all_finite(values)?;
    }
    at_least(units[1], k, 2)?;
    let square = |x: f64| x * x;
    // Far from zero the squares would lose the digits in which values differ.
    let origin = table[0][0];
    let of_row: Vec<f64> =
        table.iter().map(|row| row.iter().map(|v| v - origin).sum::<f64>() / k as f64).collect();
    let of_column: Vec<f64> =
        (0..k).map(|j| table.iter().map(|row| row[j] - origin).sum::<f64>() / n as f64).collect();
    let mean = of_row.iter().sum::<f64>() / n as f64;
    let mut error = 0.0;
    // Σ (y − ȳ)², which tells what of `error` is rounding.
    let mut total = 0.0;
    for (row, of_row) in table.iter().zip(&of_row) {
        for (value, of_column) in row.iter().zip(&of_column) {
            let value = value - origin;
            error += square(value - of_row - of_column + mean);
            total += square(value - mean);
        }
    }
    not_constant(units[2], error <= ROUNDING * total || total <= 0.0)?;
    Ok(TwoWay {
        rows: k as f64 * of_row.iter().map(|m| square(m - mean)).sum::<f64>(),
        columns: n as f64 * of_column.iter().map(|m| square(m - mean)).sum::<f64>(),
        error,
    })
}
