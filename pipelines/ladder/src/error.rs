//! What can go wrong.

use thiserror::Error;
use zwidth_dynamics::DynamicsError;

/// Every error of this crate.
#[derive(Debug, Error)]
pub enum LadderError {
    /// A scene that makes no sense, or that the fullest model cannot be made of.
    #[error(transparent)]
    Scene(#[from] DynamicsError),
    /// The fullest model, which all others are held against, does not run everywhere.
    #[error(
        "the fullest model of '{scene}' does not run at point {point} of the parameters: {error}; \
         correct the scene"
    )]
    Fullest {
        /// The scene's name.
        scene: String,
        /// Number of the point, from 0.
        point: usize,
        /// Why.
        error: DynamicsError,
    },
    /// A loop whose period makes no sense, or too many ticks.
    #[error(
        "the loop's period is {period_s} s and the scene takes {duration_s} s; the period must be above 0, and \
         the scene between 1 and {most} periods long"
    )]
    Period {
        /// The period, s.
        period_s: f64,
        /// The scene's duration, s.
        duration_s: f64,
        /// The most periods.
        most: usize,
    },
    /// A number of points that makes no sense.
    #[error("{points} points of the parameters; it must be from 1 to {most}")]
    Points {
        /// The requested number.
        points: usize,
        /// The most.
        most: usize,
    },
    /// More ranges than Sobol's sequence has coordinates here.
    #[error(
        "the twin has more parameters than Sobol's sequence has coordinates: add direction numbers"
    )]
    TooManyRanges,
}
