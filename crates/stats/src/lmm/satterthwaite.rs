//! Satterthwaite's degrees of freedom, as in the R package lmerTest.
//!
//! Fai & Cornelius (1996), J. Stat. Comput. Simul. 54:363; Kuznetsova, Brockhoff & Christensen
//! (2017), J. Stat. Softw. 82(13): df = 2 f² / (gᵀ A g), with f the variance of a contrast, g its
//! gradient in η = (θ, σ) and A = 2 H⁻¹, H the Hessian of the criterion in η. lmerTest takes both
//! by finite differences; here they are sums, by way of the variances γ(η), where V is linear:
//! H = Jᵀ {−tr(P Gᵣ P Gₛ) + 2 yᵀ P Gᵣ P Gₛ P y} J + Σᵣ (∂ deviance / ∂ γᵣ) ∂² γᵣ / ∂η².

use super::contrast::{Contrasts, check_independent, f_test, sandwich, t_test};
use super::design::{Design, Entry};
use super::information::{information, observed};
use super::profile::{Profile, factors};
use crate::tested::{FTest, Tested, Unestimable};
use zwidth_numerics::dense::{Matrix, dot};

/// Curvatures below this share of their own scale tell nothing (lmerTest: 1e-8 of their unit).
const NO_CURVATURE: f64 = 1e-8;
/// Degrees of freedom that differ by less are equal, as in lmerTest.
const SAME_DF: f64 = 1e-8;
/// Eigenvalues below this share of the largest are none, as in lmerTest (√ε).
const NO_VARIANCE: f64 = 1.5e-8;

/// The parts of the degrees of freedom.
#[derive(Debug, Clone)]
pub(super) struct Approximated {
    /// Φ, in the square of the response's unit.
    covariance: Matrix,
    /// ∂ Φ / ∂ η.
    slopes: Vec<Matrix>,
    /// A = 2 H⁻¹.
    uncertainty: Matrix,
}

/// The covariance, its slopes and the uncertainty of (θ, σ).
pub(super) fn approximate(
    design: &Design,
    reml: bool,
    theta: &[f64],
    at: &Profile,
) -> Approximated {
    let information = information(design, at);
    let observed = observed(design, reml, at, &information);
    let size = information.p.len();
    let traces = if reml { &information.expected } else { &information.full };
    let in_gamma =
        Matrix::from_fn(size, size, |r, s| 2.0 * observed.quadratic[(r, s)] - traces[(r, s)]);
    let jacobian = jacobian(design, theta);
    let mut hessian = jacobian.transposed_times(&in_gamma.times(&jacobian));
    (0..size).for_each(|r| hessian.add(observed.slopes[r], &curvature(design, theta, r)));
    // ∂ Φ / ∂ γᵣ = −Φ Pᵣ Φ
    let in_gamma: Vec<Matrix> =
        information.p.iter().map(|p| at.a_inverse.times(&p.times(&at.a_inverse))).collect();
    let slopes = (0..size).map(|k| {
        let mut slope = Matrix::zeros(at.a_inverse.rows, at.a_inverse.rows);
        let parts = in_gamma.iter().enumerate();
        parts.for_each(|(r, part)| slope.add(-at.variance * jacobian[(r, k)], part));
        slope
    });
    let mut covariance = Matrix::zeros(at.a_inverse.rows, at.a_inverse.rows);
    covariance.add(at.variance, &at.a_inverse);
    Approximated { covariance, slopes: slopes.collect(), uncertainty: twice_inverse(&hessian) }
}

/// ∂ γᵣ / ∂ ηₖ at σ = 1: γ of entry (a, b) is σ² Σ_c T_ac T_bc, that of the residual σ².
fn jacobian(design: &Design, theta: &[f64]) -> Matrix {
    let factors = factors(design, theta);
    let residual = design.entries.len();
    Matrix::from_fn(residual + 1, residual + 1, |r, k| {
        let Some(gamma) = design.entries.get(r) else { return if k == r { 2.0 } else { 0.0 } };
        let t = &factors[gamma.term];
        match design.entries.get(k) {
            None => 2.0 * dot(t.row(gamma.a), t.row(gamma.b)),
            Some(eta) if eta.term == gamma.term => slope_of_product(*gamma, *eta, t),
            Some(_) => 0.0,
        }
    })
}

/// ∂ (T Tᵀ)_ab / ∂ T_cd = [a = c] T_bd + [b = c] T_ad.
fn slope_of_product(gamma: Entry, eta: Entry, t: &Matrix) -> f64 {
    let mut slope = 0.0;
    if gamma.a == eta.a {
        slope += t[(gamma.b, eta.b)];
    }
    if gamma.b == eta.a {
        slope += t[(gamma.a, eta.b)];
    }
    slope
}

/// ∂² γᵣ / ∂η² at σ = 1.
fn curvature(design: &Design, theta: &[f64], r: usize) -> Matrix {
    let factors = factors(design, theta);
    let residual = design.entries.len();
    Matrix::from_fn(residual + 1, residual + 1, |k, l| {
        let Some(gamma) = design.entries.get(r) else {
            return if k == r && l == r { 2.0 } else { 0.0 };
        };
        let t = &factors[gamma.term];
        match (design.entries.get(k), design.entries.get(l)) {
            (None, None) => 2.0 * dot(t.row(gamma.a), t.row(gamma.b)),
            (Some(eta), None) | (None, Some(eta)) if eta.term == gamma.term => {
                2.0 * slope_of_product(*gamma, *eta, t)
            }
            (Some(x), Some(y)) if x.term == gamma.term && y.term == gamma.term && x.b == y.b => {
                let [one, other] = [(gamma.a, gamma.b), (gamma.b, gamma.a)]
                    .map(|pair| if (x.a, y.a) == pair { 1.0 } else { 0.0 });
                one + other
            }
            _ => 0.0,
        }
    })
}

/// 2 H⁻¹ over the directions in which H is curved upwards.
fn twice_inverse(hessian: &Matrix) -> Matrix {
    let root: Vec<f64> =
        hessian.diagonal().iter().map(|d| if *d > 0.0 { d.sqrt() } else { 1.0 }).collect();
    let size = hessian.rows;
    let scaled = Matrix::from_fn(size, size, |r, s| hessian[(r, s)] / (root[r] * root[s]));
    let (values, vectors) = scaled.eigen();
    let mut inverse = Matrix::zeros(size, size);
    for (i, value) in values.iter().enumerate().filter(|(_, value)| **value > NO_CURVATURE) {
        inverse.add_outer(2.0 / value, vectors.row(i), vectors.row(i));
    }
    Matrix::from_fn(size, size, |r, s| inverse[(r, s)] / (root[r] * root[s]))
}

impl Approximated {
    /// The t test of a single contrast.
    pub(super) fn t(&self, contrast: &Contrasts, level: f64) -> Result<Tested, Unestimable> {
        let variance = sandwich(&contrast.l, &self.covariance);
        check_independent(&variance)?;
        let df = self.df(contrast.l.row(0), variance[(0, 0)]);
        t_test(contrast.estimates[0], variance[(0, 0)], df, level)
    }

    /// The F test of several: independent contrasts by the eigenvectors of L Φ Lᵀ, their squared t
    /// averaged, and the degrees of freedom whose F has the mean of that average.
    pub(super) fn f(&self, contrasts: &Contrasts) -> Result<FTest, Unestimable> {
        let variance = sandwich(&contrasts.l, &self.covariance);
        check_independent(&variance)?;
        let (values, vectors) = variance.eigen();
        let largest = values.iter().fold(0.0_f64, |most, v| v.max(most));
        let kept = (0..values.len()).filter(|i| values[*i] > NO_VARIANCE * largest);
        let parts: Vec<(f64, f64)> = kept
            .map(|i| {
                let t = dot(vectors.row(i), &contrasts.estimates);
                let l = contrasts.l.transposed_times_vector(vectors.row(i));
                (t * t / values[i], self.df(&l, values[i]))
            })
            .collect();
        let q = parts.len() as f64;
        let statistic = parts.iter().map(|(t2, _)| t2).sum::<f64>() / q;
        let df: Vec<f64> = parts.iter().map(|(_, df)| *df).collect();
        f_test(statistic, q, pooled_df(&df))
    }

    /// 2 f² / (gᵀ A g).
    fn df(&self, l: &[f64], variance: f64) -> f64 {
        let slopes: Vec<f64> = self.slopes.iter().map(|s| s.form(l, l)).collect();
        2.0 * variance * variance / self.uncertainty.form(&slopes, &slopes)
    }
}

/// E = Σ ν / (ν − 2) is q times the mean of F; F with 2 E / (E − q) has it too.
fn pooled_df(df: &[f64]) -> f64 {
    let q = df.len() as f64;
    if df.windows(2).all(|pair| (pair[1] - pair[0]).abs() < SAME_DF) {
        return df.iter().sum::<f64>() / q;
    }
    // With 2 degrees of freedom or fewer F has no mean.
    if df.iter().any(|df| *df <= 2.0) {
        return 2.0;
    }
    let e: f64 = df.iter().map(|df| df / (df - 2.0)).sum();
    2.0 * e / (e - q)
}
