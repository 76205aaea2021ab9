//! A fitted linear mixed model and the tests of its coefficients.

use super::contrast::{contrasts, sandwich};
use super::design::{Design, reduce};
use super::information::check_identified;
use super::kenward_roger::{Adjusted, adjust};
use super::model::Model;
use super::profile::{Profile, factors, profile};
use super::satterthwaite::{Approximated, approximate};
use super::search::{Optimum, search};
use crate::error::StatsError;
use crate::tested::{FTest, Tested, Unestimable, at_least};
use zwidth_numerics::dense::{Matrix, dot};

/// The criterion that is maximised.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Criterion {
    /// The restricted likelihood: variances are estimated as if the mean took no data.
    Reml,
    /// The likelihood, for comparing models that differ in fixed effects.
    Ml,
}

/// The covariance matrix of a random term's effects.
#[derive(Debug, Clone, PartialEq)]
pub struct TermCovariance {
    /// The name of the term.
    pub name: String,
    /// Row by row; a single variance for a term of one column. Unit of y squared per units of the
    /// columns.
    pub covariance: Vec<Vec<f64>>,
}

/// A fitted linear mixed model.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The criterion that was maximised.
    pub criterion: Criterion,
    /// Minus twice the maximised (restricted) log-likelihood, with all constants.
    pub deviance: f64,
    /// β̂, one per fixed column.
    pub coefficients: Vec<f64>,
    /// Their names.
    pub names: Vec<String>,
    /// (Xᵀ V̂⁻¹ X)⁻¹, without any correction for few groups, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// The residual variance σ̂², unit of y squared.
    pub residual_variance: f64,
    /// The random terms' covariances.
    pub terms: Vec<TermCovariance>,
    /// Whether a variance, or a combination of effects, was estimated as exactly zero.
    pub singular: bool,
    /// Largest component of the criterion's gradient at the optimum, in the relative factor's
    /// entries (without unit) that are not zero.
    pub slope: f64,
    /// Smallest slope of the criterion in a variance (relative to σ²) that was estimated as zero;
    /// not negative, but for rounding. `None` if there is none.
    pub bound_slope: Option<f64>,
    /// Steps of the search that found the optimum.
    pub iterations: usize,
    /// Rows of the data.
    pub rows: usize,
    /// Groups (participants).
    pub groups: usize,
    design: Design,
    theta: Vec<f64>,
}

/// Fits `model` by `criterion`.
///
/// The cost of one evaluation of the criterion is that of a small matrix per *different* design of
/// a group. It is a sum of cross-products, which lose digits as a random effect's SD outgrows the
/// residual's: up to a hundred times this is not noticeable; at a thousand the search may end in
/// [`Unestimable::NotConverged`].
///
/// # Errors
/// Lengths that differ, numbers that are not finite; fixed columns or variances that the data
/// cannot tell apart (a random term with one level in each group of one row, say); fewer than two
/// groups; a response that the fixed effects, or they and the random ones, explain to the last
/// digit; no optimum found.
pub fn fit(model: &Model, criterion: Criterion) -> Result<Fit, Unestimable> {
    let design = reduce(model)?;
    at_least("participants", design.groups, 2)?;
    // With all variances 0, V is the identity, and the test does not depend on the response.
    let zero = vec![0.0; design.entries.len()];
    let at_zero = evaluate(&design, false, &zero)?;
    check_identified(&design, &at_zero)?;
    let names = model.fixed.iter().map(|column| column.name.clone()).collect();
    fit_design(design, criterion, names)
}

fn fit_design(
    design: Design,
    criterion: Criterion,
    names: Vec<String>,
) -> Result<Fit, Unestimable> {
    let reml = criterion == Criterion::Reml;
    let Optimum { theta, deviance, slope, bound_slope, iterations, singular } =
        search(&design, reml)?;
    let at = evaluate(&design, reml, &theta)?;
    let along = design.r_inverse.times_vector(&at.gamma);
    let covariance = sandwich(&design.r_inverse, &at.a_inverse);
    Ok(Fit {
        criterion,
        deviance,
        coefficients: design.least_squares.iter().zip(&along).map(|(b, c)| b + c).collect(),
        names,
        covariance: scaled_rows(&covariance, |_, _| at.variance),
        residual_variance: at.variance,
        terms: terms(&design, &theta, at.variance),
        singular,
        slope,
        bound_slope,
        iterations,
        rows: design.rows,
        groups: design.groups,
        design,
        theta,
    })
}

fn evaluate(design: &Design, reml: bool, theta: &[f64]) -> Result<Profile, Unestimable> {
    let failed = Unestimable::NotConverged { what: "the variances", slope: f64::INFINITY };
    profile(design, reml, theta).ok_or(failed)
}

/// σ² T Tᵀ of each term, in units of its columns.
fn terms(design: &Design, theta: &[f64], variance: f64) -> Vec<TermCovariance> {
    let all = design.names.iter().zip(&design.scales).zip(factors(design, theta));
    let terms = all.map(|((name, scales), t)| {
        let product = Matrix::from_fn(t.rows, t.rows, |a, b| dot(t.row(a), t.row(b)));
        TermCovariance {
            name: name.clone(),
            covariance: scaled_rows(&product, |a, b| variance / (scales[a] * scales[b])),
        }
    });
    terms.collect()
}

fn scaled_rows(m: &Matrix, scale: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    (0..m.rows).map(|a| (0..m.cols).map(|b| scale(a, b) * m[(a, b)]).collect()).collect()
}

impl Fit {
    /// Tests of coefficients after Kenward & Roger (1997), as in pbkrtest. Of a fit by maximum
    /// likelihood they are those of REML's optimum, as there.
    ///
    /// # Errors
    /// REML finds no optimum where this fit was by maximum likelihood.
    pub fn kenward_roger(&self) -> Result<Tests, Unestimable> {
        let reml = match self.criterion {
            Criterion::Reml => self.clone(),
            Criterion::Ml => fit_design(self.design.clone(), Criterion::Reml, self.names.clone())?,
        };
        let at = evaluate(&reml.design, true, &reml.theta)?;
        Ok(Tests { covariance: Covariance::Adjusted(adjust(&reml.design, &at)?), fit: reml })
    }

    /// Tests of coefficients with Satterthwaite's degrees of freedom, as in lmerTest. They trust a
    /// variance of zero, so on a singular fit they count repeats as people: prefer
    /// [`Fit::kenward_roger`].
    ///
    /// # Errors
    /// The criterion has no finite value at the optimum.
    pub fn satterthwaite(&self) -> Result<Tests, Unestimable> {
        let reml = self.criterion == Criterion::Reml;
        let at = evaluate(&self.design, reml, &self.theta)?;
        let approximated = approximate(&self.design, reml, &self.theta, &at);
        Ok(Tests { covariance: Covariance::Approximated(approximated), fit: self.clone() })
    }
}

/// Tests of one fit's coefficients.
#[derive(Debug, Clone)]
pub struct Tests {
    covariance: Covariance,
    fit: Fit,
}

/// The coefficients' covariance, with what its degrees of freedom are made of.
#[derive(Debug, Clone)]
enum Covariance {
    /// Kenward & Roger's.
    Adjusted(Adjusted),
    /// Satterthwaite's.
    Approximated(Approximated),
}

impl Tests {
    /// The test of Σ weightⱼ βⱼ = 0, with its interval at `level`.
    ///
    /// # Errors
    /// Not one weight per coefficient, all weights zero, `level` outside (0, 1).
    pub fn test(&self, weights: &[f64], level: f64) -> Result<Tested, Unestimable> {
        let contrast = contrasts(&self.fit.design, &self.fit.coefficients, &[weights])?;
        match &self.covariance {
            Covariance::Adjusted(adjusted) => adjusted.t(&contrast, level),
            Covariance::Approximated(approximated) => approximated.t(&contrast, level),
        }
    }

    /// The F test that all of several contrasts are zero; scaled after Kenward & Roger.
    ///
    /// # Errors
    /// Not one weight per coefficient, contrasts that depend on each other, none.
    pub fn test_all(&self, contrast_weights: &[&[f64]]) -> Result<FTest, Unestimable> {
        if contrast_weights.is_empty() {
            return Err(StatsError::DegreesOfFreedom { df: 0.0 }.into());
        }
        let all = contrasts(&self.fit.design, &self.fit.coefficients, contrast_weights)?;
        match &self.covariance {
            Covariance::Adjusted(adjusted) => adjusted.f(&all),
            Covariance::Approximated(approximated) => approximated.f(&all),
        }
    }
}
