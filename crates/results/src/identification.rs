//! What the stage `identify` finds: the plant that fits recorded trials best, and how well it is
//! known. The numbers of a row are in the unit that the row names, if it has one.

use crate::row::{of_trial, rows};
use crate::value::{texts, words};
use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;
use zwidth_study::{EnvironmentId, IdError, ModeId};

words! {
    /// A parameter of the plant.
    PlantParameter {
        /// Mass at the lever's end.
        Mass = "mass",
        /// Viscous friction.
        Damping = "damping",
        /// Dry friction.
        Friction = "friction",
        /// How late the motor's force is.
        MotorLag = "motor_lag",
        /// How long the brake takes to take hold.
        BrakeOn = "brake_on",
        /// How long it takes to let go.
        BrakeOff = "brake_off",
    }
    /// Whether the trials say what a parameter is.
    Identifiability {
        /// They do: no reason below applies.
        Identifiable = "identifiable",
        /// The recordings do not depend on it.
        Insensitive = "insensitive",
        /// The best value is a bound: a better one may lie beyond.
        OnBound = "on_bound",
        /// Other parameters can stand in for it: its variance inflation is above 100.
        Confounded = "confounded",
        /// Its profile stays within the level up to a bound: on that side nothing is known of it
        /// (Raue et al. 2009, Bioinformatics 25:1923).
        Flat = "flat",
        /// Its interval is wider than twice its value, or there is none because too few trials tell
        /// of it.
        Uncertain = "uncertain",
    }
    /// What a trial was used for.
    FitPart {
        /// It was fitted.
        Fitted = "fitted",
        /// It was only judged.
        HeldOut = "held_out",
    }
    /// A threshold of the controller.
    Threshold {
        /// The force below which the brake lets go.
        LetGo = "let_go",
    }
}

/// A product of two units.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnitProduct(pub Arc<str>, pub Arc<str>);

/// What stands between the units of a product.
const TIMES: &str = " · ";

impl fmt::Display for UnitProduct {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{TIMES}{}", self.0, self.1)
    }
}

impl FromStr for UnitProduct {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        let (first, second) = text.split_once(TIMES).unwrap_or((text, ""));
        Ok(Self(first.into(), second.into()))
    }
}

/// One of several, or all of them together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum OneOrAll<T> {
    /// One.
    One(T),
    /// All of them.
    All,
}

/// How all of them are named.
const ALL: &str = "all";

impl<T: fmt::Display> fmt::Display for OneOrAll<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::One(one) => one.fmt(f),
            Self::All => f.pad(ALL),
        }
    }
}

impl<T: FromStr<Err = IdError>> FromStr for OneOrAll<T> {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        match text {
            ALL => Ok(Self::All),
            one => one.parse().map(Self::One),
        }
    }
}

texts!(UnitProduct, OneOrAll<EnvironmentId>, OneOrAll<ModeId>);

rows! {
    /// A parameter of the plant: by eye, fitted, with its interval.
    PlantEstimate = "identify", "The plant, by eye and fitted" {
        /// which parameter of the plant
        parameter: PlantParameter,
        /// unit of the numbers in this row
        unit: Arc<str>,
        /// chosen by eye in the thesis
        by_eye: f64,
        /// least squares
        fitted: f64,
        /// standard error, by leaving out each trial in turn
        std_error: Option<f64>,
        /// effective degrees of freedom of the standard error
        df: Option<f64>,
        /// lower end of the interval
        ci_low: Option<f64>,
        /// upper end of the interval
        ci_high: Option<f64>,
        /// smallest value allowed
        lower_bound: f64,
        /// largest value allowed
        upper_bound: f64,
        /// variance over that with the others known
        variance_inflation: Option<f64>,
        /// whether the trials say what it is
        verdict: Identifiability,
    }

    /// The covariance of two parameters, or of one with itself; each pair once.
    PlantCovariance = "identify.covariance", "Covariance of the plant's parameters" {
        /// which parameter of the plant
        parameter: PlantParameter,
        /// which other one, or the same
        other: PlantParameter,
        /// unit of the covariance
        unit: UnitProduct,
        /// by leaving out each trial in turn
        covariance: f64,
        /// over the product of both standard errors
        correlation: f64,
    }

    /// What becomes of the error when a parameter is held and the others are fitted anew.
    PlantProfile = "identify.profile", "Profiles of the plant's parameters" {
        /// which parameter of the plant
        parameter: PlantParameter,
        /// unit of the value
        unit: Arc<str>,
        /// where the parameter is held
        value: f64,
        /// sum of squares with the others fitted anew, over that of the fit
        relative_error: f64,
        /// how much less likely than the fit, -2 ln of the ratio
        likelihood_ratio: f64,
    }

    /// Between which forces a threshold lies.
    ThresholdBracket = "identify.threshold", "The brake's let-go threshold, bracketed" {
        /// which threshold
        threshold: Threshold,
        /// largest force at which the brake let go
        low_n: Option<f64> = "N",
        /// smallest at which it held a lever that did not move on
        high_n: Option<f64> = "N",
        /// times it let go
        releases: usize,
        /// what the study set
        set_n: f64 = "N",
    }

    /// By eye against fitted on the trials held out of the fit, of a condition or of all.
    HeldOutError =
        "identify.held_out",
        "The plant by eye against fitted, on trials held out of the fit"
    {
        /// what was rendered
        environment: OneOrAll<EnvironmentId>,
        /// how it was rendered
        mode: OneOrAll<ModeId>,
        /// trials held out
        n: usize,
        /// root mean square error of the angle, by eye
        rmse_by_eye_rad: Option<f64> = "rad",
        /// that of the fit
        rmse_fitted_rad: Option<f64> = "rad",
        /// the second over the first: below 1 the fit is better
        fitted_over_by_eye: Option<f64>,
    }

    /// The errors of the plant on one trial.
    PlantTrialError =
        "identify.trials",
        "Errors of the plant, by eye and fitted, one row per trial"
    {
        ..of_trial,
        /// fitted, or held out and only judged
        part: FitPart,
        /// root mean square error of the angle, by eye
        rmse_by_eye_rad: Option<f64> = "rad",
        /// that of the fit
        rmse_fitted_rad: Option<f64> = "rad",
        /// that of a fit without this trial
        rmse_left_out_rad: Option<f64> = "rad",
    }
}
