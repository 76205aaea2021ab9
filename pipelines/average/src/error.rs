//! Why there is no average.

use zwidth_numerics::NumericsError;
use zwidth_stats::StatsError;
use zwidth_tables::TableError;

/// Why trials have no average over time, though nothing is wrong with them.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WhyNot {
    /// Free motion.
    #[error(
        "free motion has no average over time: no two movements follow the same course; \
         compare the fits of free motion instead"
    )]
    FreeMotion,
    /// Nothing was rendered.
    #[error(
        "study.toml does not say what was rendered in this environment (kind = none): repeats are drawn one by one and not averaged"
    )]
    NothingRendered,
    /// Fewer than two participants with an average.
    #[error("fewer than two participants have an average aligned by landmarks")]
    Nobody,
    /// No θ.
    #[error("no angle was recorded (theta_rad), so the movement cannot be placed")]
    NoAngle,
    /// No θ̇.
    #[error(
        "no velocity was recorded (theta_dot_rad_s), so the movement's onset cannot be found; \
         an import can be told to compute it from the angle"
    )]
    NoVelocity,
    /// θ̇ stays below the threshold.
    #[error("the lever never moved faster than analysis.onset, so there is no onset to align at")]
    NoMovement,
    /// The recording stops in mid-movement.
    #[error(
        "the recording stops before the movement ends, so it cannot be aligned at its end; the average \
         aligned at onset has it"
    )]
    NoEnd,
}

/// Why a request for an average failed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum AverageError {
    /// There is no average, and there is a reason.
    #[error(transparent)]
    WhyNot(#[from] WhyNot),
    /// No trial.
    #[error("no trial was given: an average needs at least one repeat")]
    Empty,
    /// Trials that do not belong together.
    #[error(
        "trial {trial} is of another participant, session or condition than the first: average each apart"
    )]
    Mixed {
        /// The first such trial's number.
        trial: u32,
    },
    /// A column that is not as long as time.
    #[error(
        "trial {trial}: column {column} has {found} samples where t_s has {expected}: columns must be equally long"
    )]
    Ragged {
        /// The trial.
        trial: u32,
        /// The column.
        column: String,
        /// Samples of time.
        expected: usize,
        /// Samples of the column.
        found: usize,
    },
    /// Too few points for a grid.
    #[error("analysis.grid_points = {points} makes no grid: give at least 2")]
    Grid {
        /// The number given.
        points: usize,
    },
    /// A numerical routine refused.
    #[error(transparent)]
    Numerics(#[from] NumericsError),
    /// A statistic was refused.
    #[error(transparent)]
    Stats(#[from] StatsError),
    /// A table that is not one of this stage.
    #[error("{0}")]
    Table(String),
}

impl From<TableError> for AverageError {
    fn from(error: TableError) -> Self {
        Self::Table(error.to_string())
    }
}
