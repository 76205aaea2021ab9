//! Our fits of a case.

use crate::cases::{Case, Data, Kind};
use zwidth_stats::Unestimable;
use zwidth_stats::clmm::{self, Column, Integral, Ratings, Terms};
use zwidth_stats::lmm::trials::{Trials, fit_trials};

/// Points of the scale.
const POINTS: u8 = 5;
/// Level of the intervals.
const LEVEL: f64 = 0.95;

/// What a fit says, in the order in which the peer says it.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Found {
    /// The criterion: REML's deviance, or the log-likelihood.
    pub(crate) criterion: f64,
    /// Of the second and of the third mode against the first.
    pub(crate) estimates: Vec<f64>,
    pub(crate) std_errors: Vec<f64>,
    /// After Kenward and Roger; none for answers.
    pub(crate) df: Vec<f64>,
}

/// Fits a case, from its columns to what is said of two contrasts.
pub(crate) fn fit(case: &Case, data: &Data) -> Result<Found, Unestimable> {
    match case.kind {
        Kind::Mixed => mixed(data),
        Kind::Ordinal => ordinal(data),
    }
}

/// REML, then two contrasts after Kenward and Roger.
fn mixed(data: &Data) -> Result<Found, Unestimable> {
    let fitted = fit_trials(Trials {
        participant: &data.participant,
        session: &data.session,
        mode: &data.mode,
        value: &data.value,
    })?;
    let adjusted = fitted.fit.kenward_roger()?;
    let mut found = Found { criterion: fitted.fit.deviance, ..Found::default() };
    for mode in [1, 2] {
        let tested = adjusted.test(&fitted.difference(mode, 0)?, LEVEL)?;
        found.estimates.push(tested.estimate);
        found.std_errors.push(tested.std_error);
        found.df.push(tested.df);
    }
    Ok(found)
}

/// Participant and participant × mode by Laplace's approximation, with standard errors.
fn ordinal(data: &Data) -> Result<Found, Unestimable> {
    let column = |mode: usize| Column {
        name: format!("mode {mode}"),
        values: data.mode.iter().map(|m| f64::from(u8::from(*m == mode))).collect(),
    };
    let ratings = Ratings {
        answers: &data.answer,
        points: POINTS,
        columns: &[column(1), column(2)],
        participants: &data.participant,
        modes: &data.mode,
    };
    let model = clmm::Model::new(&ratings, Terms::ParticipantAndMode)?;
    let fit = clmm::fit(&model, Integral::Laplace)?;
    let std_error = |column| Ok(fit.wald(column, LEVEL)?.std_error);
    Ok(Found {
        criterion: fit.log_likelihood,
        estimates: fit.coefficients.clone(),
        std_errors: [0, 1].into_iter().map(std_error).collect::<Result<_, Unestimable>>()?,
        df: Vec::new(),
    })
}
