//! What can be wrong with a request for a statistic.

use zwidth_numerics::NumericsError;

/// Why a statistic was refused. Indices count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum StatsError {
    /// A NaN or an infinity.
    #[error("value {index} is {value}: leave it out (or null) before asking for a statistic")]
    NonFinite {
        /// Index of the first such value.
        index: usize,
        /// The value itself.
        value: f64,
    },
    /// A confidence level outside (0, 1).
    #[error(
        "a confidence level of {level} makes no interval: give a share between 0 and 1, such as 0.95"
    )]
    Level {
        /// The level asked for.
        level: f64,
    },
    /// Degrees of freedom that are not positive.
    #[error("{df} degrees of freedom leave nothing to estimate an error from: give more values")]
    DegreesOfFreedom {
        /// Degrees of freedom asked for.
        df: f64,
    },
    /// An answer that is not on its scale.
    #[error(
        "answer {index} is {found} on a scale from 1 to {points}: give the scale it was asked on"
    )]
    Answer {
        /// Index of the first such answer.
        index: usize,
        /// The answer.
        found: u8,
        /// Points of the scale.
        points: u8,
    },
    /// Repeats that do not lie on one grid.
    #[error(
        "row {row} has {found} points where the first has {expected}: put all repeats on one grid first"
    )]
    Ragged {
        /// The first such row.
        row: usize,
        /// Points in row 0.
        expected: usize,
        /// Points in this row.
        found: usize,
    },
    /// Inputs of a fit that do not belong together.
    #[error(transparent)]
    Numerics(#[from] NumericsError),
}

/// Checks that every value is finite.
pub(crate) fn all_finite(values: &[f64]) -> Result<(), StatsError> {
    match values.iter().position(|v| !v.is_finite()) {
        None => Ok(()),
        Some(index) => Err(StatsError::NonFinite { index, value: values[index] }),
    }
}

/// Checks that `level` lies strictly between 0 and 1.
pub(crate) fn check_level(level: f64) -> Result<(), StatsError> {
    if level > 0.0 && level < 1.0 { Ok(()) } else { Err(StatsError::Level { level }) }
}
