//! What can go wrong: a parameter that makes no sense, a scene that a method cannot run, a run that
//! does not end.

use std::fmt::Display;

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
    /// The state left the numbers that the equations can go on with: an entry is infinite, or
    /// beyond 1e100.
    #[error(
        "the state is no longer finite at t = {t_s} s; {suspect} is furthest from its usual size: check it"
    )]
    NotFinite {
        /// Time at which it was seen, s.
        t_s: f64,
        /// The parameter furthest from its usual size.
        suspect: String,
    },
    /// The run needs more work than allowed, for instance because it bounces without end.
    #[error(
        "more than {limit} {what} up to t = {t_s} s; {suspect} is furthest from its usual size: shorten the run or soften it"
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

/// What the functions of this crate return.
pub(crate) type Result<T> = std::result::Result<T, DynamicsError>;

/// No parameter is larger, in SI units, and none that divides is smaller than its inverse. No
/// device comes near it; within it every product of the equations stays below the largest number,
/// 1.8e308.
pub(crate) const LARGEST: f64 = 1e30;

/// No angle, velocity or force of a state is larger, in SI units: the stiffest spring times it,
/// over the lightest mass and the shortest lever, times the heaviest finger is still a number (1e30
/// · 1e100 / 1e-60 · 1e60 = 1e250).
const LARGEST_STATE: f64 = 1e100;

/// Whether every entry of a state is a number that the equations can go on with.
pub(crate) fn in_bounds(state: &[f64]) -> bool {
    state.iter().all(|x| x.abs() <= LARGEST_STATE)
}

/// `value` must be above zero, and neither it nor its inverse too large.
pub(crate) fn positive(name: impl Display, value: f64) -> Result<()> {
    let ok = (1.0 / LARGEST..=LARGEST).contains(&value);
    check(name, value, ok, "above 0: from 1e-30 to 1e30")
}

/// `value` must not be below zero, nor too large.
pub(crate) fn not_negative(name: impl Display, value: f64) -> Result<()> {
    check(name, value, (0.0..=LARGEST).contains(&value), "finite and not below 0 (at most 1e30)")
}

/// `value` must be finite, and not too large.
pub(crate) fn finite(name: impl Display, value: f64) -> Result<()> {
    check(name, value, value.abs() <= LARGEST, "finite (at most 1e30 either way)")
}

/// An error that names the parameter unless `ok`. The name is only put together for the error: a
/// sweep checks every scene.
pub(crate) fn check(name: impl Display, value: f64, ok: bool, allowed: &'static str) -> Result<()> {
    if ok {
        Ok(())
    } else {
        Err(DynamicsError::Parameter { name: name.to_string(), value, allowed })
    }
}
