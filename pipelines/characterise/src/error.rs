//! Why sweeps could not be characterised.

use crate::characteristic::Grouping;
use zwidth_numerics::NumericsError;
use zwidth_stats::StatsError;

/// What is wrong with the sweeps or the settings. Sweeps and rows count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CharacteriseError {
    /// A sweep whose two columns differ in length.
    #[error(
        "sweep {sweep} has {commands} commands and {responses} responses: each sample needs both"
    )]
    LengthMismatch {
        /// The first such sweep.
        sweep: usize,
        /// Its commands.
        commands: usize,
        /// Its responses.
        responses: usize,
    },
    /// A NaN or an infinity.
    #[error("sweep {sweep}, row {row}: the {column} is {value}; drop the row or mend its source")]
    NonFinite {
        /// The sweep it is in.
        sweep: usize,
        /// Row within the sweep.
        row: usize,
        /// `command` or `response`.
        column: &'static str,
        /// The value itself.
        value: f64,
    },
    /// Not enough to fit and to test even a line.
    #[error(
        "{points} points at {commands} different commands cannot show a characteristic: \
         need at least {MIN_POINTS} points and {MIN_COMMANDS} commands"
    )]
    TooFew {
        /// Points in all sweeps.
        points: usize,
        /// Different commands among them.
        commands: usize,
    },
    /// Each candidate, the line too, needs a sweep (or block) that is to be left out.
    #[error("no line can be fitted with one {} left out: the others need two different commands between them", grouping.name())]
    NothingFits {
        /// What was left out.
        grouping: Grouping,
    },
    /// A curve that no calibration can be made from.
    #[error("no calibration of the {actuator}: {problem}")]
    Calibration {
        /// `motor` or `brake`.
        actuator: &'static str,
        /// What is wrong, with the value and the remedy.
        problem: String,
    },
    /// A statistic was refused, for example for its confidence level.
    #[error(transparent)]
    Stats(#[from] StatsError),
    /// The first-order fit was refused.
    #[error(transparent)]
    Numerics(#[from] NumericsError),
}

/// Three blocks of two points: a line through two of them keeps degrees of freedom.
pub(crate) const MIN_POINTS: usize = 6;
/// Two commands make a line; a third shows whether it is one.
pub(crate) const MIN_COMMANDS: usize = 3;
