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
        /// The requested level.
        level: f64,
    },
    /// Degrees of freedom that are not positive.
    #[error("{df} degrees of freedom leave nothing to estimate an error from: give more values")]
    DegreesOfFreedom {
        /// The requested degrees of freedom.
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
    /// A bound of equivalence that bounds nothing.
    #[error(
        "an equivalence bound of {bound} bounds nothing: give a positive number in the unit of the difference"
    )]
    Bound {
        /// The requested bound.
        bound: f64,
    },
    /// A level of significance outside (0, 0.5).
    #[error(
        "a level of significance of {alpha} tests nothing: give a share between 0 and 0.5, such as 0.05"
    )]
    Alpha {
        /// The requested level.
        alpha: f64,
    },
    /// A number given as a probability that is none.
    #[error("value {index} is {value}, which is not a p value: give numbers from 0 to 1")]
    Probability {
        /// Index of the first such value.
        index: usize,
        /// The value itself.
        value: f64,
    },
    /// A trial of a mode that there is not.
    #[error("trial {trial} has mode {mode}, but modes are numbered from 0 and there are {modes}")]
    Mode {
        /// The first such trial.
        trial: usize,
        /// Its mode.
        mode: usize,
        /// Number of modes.
        modes: usize,
    },
    /// A trial that does not move with those it is said to move with.
    #[error(
        "trial {trial} has another mode than those it is said to move with: give it a number of its own"
    )]
    Apart {
        /// The first such trial.
        trial: usize,
    },
    /// All orders that a design can draw, and the actual one is not among them.
    #[error(
        "the order of the trials is not among the {orders} that the design can draw: give the design that drew it"
    )]
    OrderNotAmong {
        /// Number of orders given.
        orders: usize,
    },
    /// A claim that a design cannot carry, however large the effect.
    #[error(
        "with {pairs} pairs and {contrasts} contrast{}, however large the effect, they cannot bring an adjusted p below {reachable}; below {alpha} takes {needed} pairs",
        if *.contrasts == 1 { "" } else { "s" }
    )]
    OutOfReach {
        /// Pairs that the design has.
        pairs: usize,
        /// Contrasts of the family.
        contrasts: usize,
        /// The smallest adjusted p value that they reach.
        reachable: f64,
        /// The p value below which a claim counts.
        alpha: f64,
        /// The fewest pairs that reach below it.
        needed: usize,
    },
    /// More answers of one kind than there were.
    #[error(
        "row {index} counts {positive} answers of {trials} trials: give no more answers than there were trials"
    )]
    MoreThanTrials {
        /// Index of the first such row.
        index: usize,
        /// Its trials.
        trials: u64,
        /// Its positive answers.
        positive: u64,
    },
    /// Bounds between which there is no share of lapses.
    #[error(
        "lapses between {least} and {most} are no shares: give two numbers from 0 to below 0.5, the smaller one first"
    )]
    Lapse {
        /// The lower bound.
        least: f64,
        /// The upper bound.
        most: f64,
    },
    /// A level that has no logarithm.
    #[error(
        "the Weibull sigmoid begins at 0, and there is a level of {level}: take another sigmoid, such as norm"
    )]
    BelowZero {
        /// The lowest level.
        level: f64,
    },
    /// A plan of a staircase that cannot work.
    #[error(
        "this staircase has no end or leaves its bounds: give answers, steps, reversals and trials above 0, no more reversals to average than there are, and a start between its lowest and highest level, all three multiples of 0.000001 and above 0 on a logarithmic scale"
    )]
    Staircase,
    /// Settings that cannot be made.
    #[error(
        "these settings have no end or leave their bounds: give settings and a step above 0, starts between the lowest and the highest level, and no wishes after the last setting"
    )]
    Adjustment,
    /// Answers beyond the end of a staircase.
    #[error(
        "{answers} answers, and the staircase ended after {trials}: give the plan that they were answered by"
    )]
    StaircaseEnded {
        /// Trials until its end.
        trials: usize,
        /// Answers that were given.
        answers: usize,
    },
    /// A grid of QUEST+ that has no curves.
    #[error(
        "QUEST+ has no curves on this grid: give rising levels, thresholds (above 0 for Weibull's sigmoid), scales above 0 and lapses from 0 to below 0.5, and ask which was more, or right or wrong"
    )]
    QuestGrid,
    /// A grid of QUEST+ that is too large.
    #[error(
        "this grid of QUEST+ has {cells} curves at {levels} levels, more than {most} shares together: give fewer levels, thresholds, scales or lapses"
    )]
    QuestSize {
        /// Curves.
        cells: usize,
        /// Levels.
        levels: usize,
        /// The most shares: curves times levels.
        most: usize,
    },
    /// An answer that none of the curves on a grid can give.
    #[error(
        "the answer of trial {trial} is impossible for every curve of the grid: allow lapses above 0"
    )]
    Impossible {
        /// The first such trial.
        trial: usize,
    },
    /// A variance that weighs nothing.
    #[error("variance {index} is {value}: give the squared error of each value, above 0")]
    Variance {
        /// Index of the first such variance.
        index: usize,
        /// The variance.
        value: f64,
    },
    /// Answers of yes and no that do not tell how often people guess.
    #[error(
        "no trial was at level 0, so nothing tells how often yes was a guess: show nothing in some trials, or ask which of two it was"
    )]
    NothingShown,
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

/// Checks that `what` has as many entries as expected.
pub(crate) fn same_length(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), StatsError> {
    match found == expected {
        true => Ok(()),
        false => Err(NumericsError::LengthMismatch { what, expected, found }.into()),
    }
}

/// Checks that `level` lies strictly between 0 and 1.
pub(crate) fn check_level(level: f64) -> Result<(), StatsError> {
    if level > 0.0 && level < 1.0 { Ok(()) } else { Err(StatsError::Level { level }) }
}

/// Checks that every value lies between 0 and 1, both ends included.
pub(crate) fn check_probabilities(values: &[f64]) -> Result<(), StatsError> {
    match values.iter().position(|v| !(0.0..=1.0).contains(v)) {
        None => Ok(()),
        Some(index) => Err(StatsError::Probability { index, value: values[index] }),
    }
}
