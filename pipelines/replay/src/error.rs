//! Why a trial cannot be replayed.

use zwidth_dynamics::DynamicsError;
use zwidth_numerics::NumericsError;
use zwidth_results::ReplayOutcome;
use zwidth_stats::StatsError;
use zwidth_tables::TableError;

/// Why a replay does not apply, though nothing is wrong with the trial: a word in the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum WhyNot {
    /// Fewer than three samples.
    #[error("the recording has fewer than three samples")]
    TooShort,
    /// No θ.
    #[error("no angle was recorded (theta_rad)")]
    NoAngle,
    /// No F_ex.
    #[error("no force was recorded (force_ex_n)")]
    NoForce,
    /// No L.
    #[error("the study has no device.lever_m")]
    NoLever,
    /// No voltages of an actuator that the mode uses.
    #[error("no voltages were recorded (voltage_motor_v, voltage_brake_v)")]
    NoVoltages,
    /// No calibration, so that what the actuators can give is not known.
    #[error("the session has no calibration")]
    NoCalibration,
    /// The rendering was late, and the model's is not.
    #[error("the environment is rendered with a delay, which the model does not have")]
    Delayed,
    /// A questionnaire, or anything else that no device rendered.
    #[error("nothing was rendered")]
    NotRendered,
}

impl From<WhyNot> for ReplayOutcome {
    fn from(why: WhyNot) -> Self {
        match why {
            WhyNot::TooShort => Self::TooShort,
            WhyNot::NoAngle => Self::NoAngle,
            WhyNot::NoForce => Self::NoForce,
            WhyNot::NoLever => Self::NoLever,
            WhyNot::NoVoltages => Self::NoVoltages,
            WhyNot::NoCalibration => Self::NoCalibration,
            WhyNot::Delayed => Self::Delayed,
            WhyNot::NotRendered => Self::NotRendered,
        }
    }
}

/// Why a trial has no rows. What merely does not apply is a word in its row, and no error.
#[derive(Debug, thiserror::Error)]
pub enum ReplayError {
    /// A replay does not apply, and there is a reason.
    #[error(transparent)]
    WhyNot(#[from] WhyNot),
    /// A column that is not as long as time.
    #[error(
        "column {column} has {found} samples where t_s has {expected}: columns must be equally long"
    )]
    Ragged {
        /// The column.
        column: &'static str,
        /// Samples of time.
        expected: usize,
        /// Samples of the column.
        found: usize,
    },
    /// The trial, its study or the parameters make no model.
    #[error(transparent)]
    Dynamics(#[from] DynamicsError),
    /// A numerical routine refused.
    #[error(transparent)]
    Numerics(#[from] NumericsError),
    /// A statistic was refused.
    #[error(transparent)]
    Stats(#[from] StatsError),
    /// A table could not be made.
    #[error(transparent)]
    Table(#[from] TableError),
}
