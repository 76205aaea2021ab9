//! Why sweeps could not be characterised.

use zwidth_numerics::NumericsError;
use zwidth_stats::StatsError;

/// What is wrong with the sweeps or the settings.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CharacteriseError {
    /// Sweeps that show no characteristic, or a curve that no calibration can be made from: what is
    /// wrong, with the value and the remedy. Sweeps and rows count from 0.
    #[error("{0}")]
    Refused(String),
    /// A statistic was refused, for example for its confidence level.
    #[error(transparent)]
    Stats(#[from] StatsError),
    /// The first-order fit was refused.
    #[error(transparent)]
    Numerics(#[from] NumericsError),
}

impl CharacteriseError {
    pub(crate) fn no_calibration(actuator: &str, problem: &str) -> Self {
        Self::Refused(format!("no calibration of the {actuator}: {problem}"))
    }
}
