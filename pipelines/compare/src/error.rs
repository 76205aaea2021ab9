//! Why a comparison was refused.

use zwidth_frames::FrameError;
use zwidth_stats::StatsError;
use zwidth_tables::TableError;

/// The reason for which a comparison was refused.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// A query was refused.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// There is no table.
    #[error("there is no table of metrics or scores to compare")]
    NoTable,
    /// A table was refused.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A statistic was refused.
    #[error(transparent)]
    Stats(#[from] StatsError),
}
