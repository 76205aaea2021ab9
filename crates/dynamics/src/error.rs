//! What can go wrong: a parameter that makes no sense, a scene a method cannot run, a run that does not end.

use thiserror::Error;

/// Every error of this crate.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum DynamicsError {
    /// A parameter lies outside what its equation allows.
    #[error("{name} is {value}, but it must be {allowed}")]
    Parameter {
        /// The parameter as the scene's TOML spells it, with its unit suffix.
        name: String,
        /// The value that was given.
        value: f64,
        /// The values that make sense.
        allowed: &'static str,
    },
    /// Two parts of a scene that have no meaning together.
    #[error("{what}; {remedy}")]
    Combination {
        /// What does not fit.
        what: &'static str,
        /// What to change.
        remedy: &'static str,
    },
    /// A scene's TOML could not be read.
    #[error("this is not a scene: {0}")]
    Toml(String),
    /// The exact solver was given a model that is not piecewise affine.
    #[error(
        "{term} is not piecewise affine, so the exact solver cannot run it; use dormand_prince or tr_bdf2"
    )]
    NotPiecewiseAffine {
        /// The term that is nonlinear.
        term: &'static str,
    },
    /// The state left the finite numbers.
    #[error("the state is no longer finite at t = {t_s} s; {suspect} is the extreme parameter")]
    NotFinite {
        /// Time at which it was seen, s.
        t_s: f64,
        /// The parameter furthest from its usual size.
        suspect: String,
    },
    /// The run needs more work than allowed, for instance because it bounces without end.
    #[error(
        "more than {limit} {what} up to t = {t_s} s; {suspect} is the extreme parameter: shorten the run or soften it"
    )]
    TooMuchWork {
        /// The work limit that was passed.
        limit: u64,
        /// What was counted: events, pieces or steps.
        what: &'static str,
        /// Time reached, s.
        t_s: f64,
        /// The parameter furthest from its usual size.
        suspect: String,
    },
}

/// Shorthand.
pub(crate) type Result<T> = std::result::Result<T, DynamicsError>;

/// `value` must be finite and above zero, and no denormal: the inverse of one is infinite.
pub(crate) fn positive(name: &str, value: f64) -> Result<()> {
    let ok = value.is_finite() && value >= f64::MIN_POSITIVE;
    check(name, value, ok, "finite and above 0 (at least 2.3e-308)")
}

/// `value` must be finite and not below zero.
pub(crate) fn not_negative(name: &str, value: f64) -> Result<()> {
    check(name, value, value.is_finite() && value >= 0.0, "finite and not below 0")
}

/// `value` must be finite.
pub(crate) fn finite(name: &str, value: f64) -> Result<()> {
    check(name, value, value.is_finite(), "finite")
}

/// An error that names the parameter unless `ok`.
pub(crate) fn check(name: &str, value: f64, ok: bool, allowed: &'static str) -> Result<()> {
    if ok { Ok(()) } else { Err(DynamicsError::Parameter { name: name.to_owned(), value, allowed }) }
}
