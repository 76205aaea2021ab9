//! Why there is no fit.

use zwidth_numerics::NumericsError;
use zwidth_stats::StatsError;

/// Why parameters could not be fitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IdentifyError {
    /// Too few trials.
    #[error("{trials} trials can be fitted, but an interval needs at least 2: record more repeats")]
    TooFew {
        /// Trials there are to fit.
        trials: usize,
    },
    /// The model does not run from any of the starts.
    #[error(
        "the model does not run on every trial from any of the {starts} starts: give other starts"
    )]
    NoStart {
        /// Starts that were tried.
        starts: usize,
    },
    /// A numerical routine refused.
    #[error(transparent)]
    Numerics(#[from] NumericsError),
    /// A statistic was refused.
    #[error(transparent)]
    Stats(#[from] StatsError),
}
