//! Common words of all tests: an estimate with its test, or why there is none.

use crate::error::StatsError;
use zwidth_study::counted;

/// An estimate, its interval and its test against zero. Units as the estimated quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tested {
    /// The estimate.
    pub estimate: f64,
    /// Its standard error.
    pub std_error: f64,
    /// Lower end of the interval.
    pub ci_low: f64,
    /// Upper end of the interval.
    pub ci_high: f64,
    /// The test statistic: estimate / std_error.
    pub statistic: f64,
    /// Degrees of freedom of the t distribution that the interval and the p value refer to.
    pub df: f64,
    /// Two-sided p value of "the quantity is zero".
    pub p_value: f64,
}

/// The test of several contrasts at once.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FTest {
    /// The F statistic.
    pub statistic: f64,
    /// Degrees of freedom of the numerator: independent contrasts.
    pub df_num: f64,
    /// Degrees of freedom of the denominator.
    pub df_den: f64,
    /// The p value of "all contrasts are zero".
    pub p_value: f64,
}

/// `1 is needed`, `2 are needed`.
fn needed_words(needed: usize) -> String {
    format!("{needed} {} needed", if needed == 1 { "is" } else { "are" })
}

/// Refuses fewer units than a statistic takes.
pub(crate) fn at_least(
    units: &'static str,
    found: usize,
    needed: usize,
) -> Result<(), Unestimable> {
    if found < needed { Err(Unestimable::TooFew { units, found, needed }) } else { Ok(()) }
}

/// Refuses values that do not vary.
pub(crate) fn not_constant(units: &'static str, are_constant: bool) -> Result<(), Unestimable> {
    if are_constant { Err(Unestimable::Constant { units }) } else { Ok(()) }
}

/// Why data that are as they should be have no such statistic. Each is an answer for a table, in
/// words, where another program would print NaN.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Unestimable {
    /// Fewer units than the statistic takes.
    #[error("{}, {}", counted(*found, units), needed_words(*needed))]
    TooFew {
        /// What is counted, in the plural: `participants`, `pairs`.
        units: &'static str,
        /// Number of units that there are.
        found: usize,
        /// The least number that the statistic takes.
        needed: usize,
    },
    /// Values along a line, whose own error is not among theirs.
    #[error("the values are along a line over trials, whose error they do not tell")]
    Adjusted,
    /// Values that are equal up to their rounding.
    #[error("there is no difference beyond the rounding of the values")]
    NoDifference,
    /// Values that do not vary, so that no error can be estimated from them.
    #[error("all {units} are equal, so nothing tells how far they scatter")]
    Constant {
        /// What is equal, in the plural: `differences`, `answers`.
        units: &'static str,
    },
    /// Answers that one side always gives and the other never, so that the estimate is infinite.
    #[error("the answers separate {what} completely, so the estimate has no end")]
    Separated {
        /// What the answers separate.
        what: String,
    },
    /// Columns of a model that the data cannot tell apart.
    #[error("the data cannot tell {what} apart")]
    Confounded {
        /// What cannot be told apart.
        what: String,
    },
    /// A search that found no optimum.
    #[error("the search for {what} found no optimum (slope {slope:.1e} left)")]
    NotConverged {
        /// What was searched.
        what: &'static str,
        /// Largest component of the gradient where the search stopped.
        slope: f64,
    },
    /// A request that cannot be meant.
    #[error(transparent)]
    Refused(#[from] StatsError),
}
