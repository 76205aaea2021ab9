//! What can be wrong with the given numbers.

/// Why a numerical routine refused its input. Indices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NumericsError {
    /// Two slices that belong together differ in length.
    #[error("{what} has {found} values where {expected} are needed: give slices of one length")]
    LengthMismatch {
        /// Which input is at fault.
        what: &'static str,
        /// Length of the input it belongs to.
        expected: usize,
        /// Its own length.
        found: usize,
    },
    /// A NaN or an infinity.
    #[error("{what} holds {value} in row {row}: drop the row or mend its source before fitting")]
    NonFinite {
        /// Which input is at fault, for example `column 1` or `y`.
        what: String,
        /// Row of the first such value.
        row: usize,
        /// The value itself.
        value: f64,
    },
    /// A fit needs more rows than parameters.
    #[error("{rows} rows cannot determine {parameters} parameters with an error estimate: need at least {}", parameters + 1)]
    TooFewRows {
        /// Rows given.
        rows: usize,
        /// Parameters asked for.
        parameters: usize,
    },
    /// A column is, to rounding, a combination of those before it.
    #[error("column {column} is a combination of the columns before it: leave one of them out")]
    RankDeficient {
        /// The first such column.
        column: usize,
    },
    /// A minimisation whose starting point has no finite cost.
    #[error(
        "the sum of squares at the starting point is {value}: choose a start where the model is finite"
    )]
    BadStart {
        /// Sum of squares found there.
        value: f64,
    },
}

/// Checks that `length` equals `expected`, naming the input `what` otherwise.
pub(crate) fn same_length(
    what: &'static str,
    expected: usize,
    length: usize,
) -> Result<(), NumericsError> {
    if expected == length {
        return Ok(());
    }
    Err(NumericsError::LengthMismatch { what, expected, found: length })
}

/// Checks that every value is finite, naming the input `what` and the first bad row otherwise.
pub(crate) fn all_finite(what: impl Fn() -> String, values: &[f64]) -> Result<(), NumericsError> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(row) => Err(NumericsError::NonFinite { what: what(), row, value: values[row] }),
    }
}
