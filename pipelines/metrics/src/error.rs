//! What can be wrong with a trial whose metrics are requested.

use zwidth_numerics::NumericsError;
use zwidth_stats::StatsError;

/// Why a trial has no metrics. A quantity that was merely not recorded is null, not an error.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum MetricsError {
    /// No time.
    #[error("the trial has no sample with a time: record it again, or leave it out")]
    NoTime,
    /// A column that is not as long as time.
    #[error(
        "column {column} has {found} samples where t_s has {expected}: columns must be equally long"
    )]
    Ragged {
        /// The column.
        column: String,
        /// Samples of time.
        expected: usize,
        /// Samples of the column.
        found: usize,
    },
    /// A numerical routine refused.
    #[error(transparent)]
    Numerics(#[from] NumericsError),
    /// A statistic was refused.
    #[error(transparent)]
    Stats(#[from] StatsError),
}
