//! statsmodels' standard errors of a mixed model with a random intercept.
//!
//! They come from the observed information on (β, ψ), ψ the variance of participants relative to the
//! residual's, of the restricted likelihood with σ² profiled out (`MixedLM.hessian`); lme4's come from (Xᵀ V⁻¹ X)⁻¹ alone.
//! Both are one where the design is balanced: elsewhere β and ψ are correlated in the data at hand. With Vᵢ = I + ψ 1 1ᵀ
//! of a participant of nᵢ trials and uᵢ = 1 / (1 + nᵢ ψ), 1ᵀ Vᵢ⁻¹ x = uᵢ Σ x, so that sums of trials are enough:
//! A = Xᵀ V⁻¹ X, c = Xᵀ V⁻¹ Z Zᵀ V⁻¹ r, ρ = rᵀ V⁻¹ r, σ² = ρ / (N − p),
//! h = (N − p) / 2 (D / ρ − B² / ρ²) − tr(…)² / 2 − tr(A⁻¹ F A⁻¹ F) / 2 + tr(A⁻¹ G), and the covariance of β is
//! (A / σ² − c cᵀ / (σ⁴ h))⁻¹.

use super::trials::{Row, Trials};
use crate::lmm::Fit;
use crate::tested::Unestimable;
use std::collections::BTreeMap;
use zwidth_numerics::dense::{Matrix, dot};

/// Sums over the trials of a participant.
struct Own {
    /// Trials of each mode.
    counts: Vec<f64>,
    /// Sum of the residuals.
    residual: f64,
}

/// The variance of Σ weightⱼ βⱼ by the observed information, of the model with a random intercept.
pub(super) fn observed(
    trials: Trials<'_>,
    modes: &[usize],
    fit: &Fit,
    weights: &[f64],
) -> Result<f64, Unestimable> {
    let fixed = modes.len();
    let mut people: BTreeMap<usize, Own> = BTreeMap::new();
    let mut squares = 0.0;
    for Row { participant, place, value } in trials.rows(modes) {
        let residual = value - fit.coefficients[place];
        let own = people
            .entry(participant)
            .or_insert_with(|| Own { counts: vec![0.0; fixed], residual: 0.0 });
        own.counts[place] += 1.0;
        own.residual += residual;
        squares += residual * residual;
    }
    let psi = fit.terms[0].covariance[0][0] / fit.residual_variance;
    let mut a = Matrix::zeros(fixed, fixed);
    let mut f = Matrix::zeros(fixed, fixed);
    let mut g = Matrix::zeros(fixed, fixed);
    let mut c = vec![0.0; fixed];
    let mut rho = squares;
    let (mut b, mut d, mut trace) = (0.0, 0.0, 0.0);
    for own in people.values() {
        let n: f64 = own.counts.iter().sum();
        let u = 1.0 / (1.0 + n * psi);
        let x: Vec<f64> = own.counts.iter().map(|count| u * count).collect();
        let r = u * own.residual;
        (0..fixed).for_each(|k| a[(k, k)] += own.counts[k]);
        a.add_outer(-psi * u, &own.counts, &own.counts);
        f.add_outer(1.0, &x, &x);
        g.add_outer(n * u, &x, &x);
        (0..fixed).for_each(|k| c[k] += x[k] * r);
        rho -= psi * u * own.residual * own.residual;
        b += r * r;
        d += 2.0 * r * r * n * u;
        trace += (n * u) * (n * u);
    }
    let confounded = || Unestimable::Confounded { what: "the modes".to_owned() };
    let (inverse, _) = a.inverse_and_log_det().ok_or_else(confounded)?;
    let spare = trials.value.len() as f64 - fixed as f64;
    let variance = rho / spare;
    let through = inverse.times(&f);
    let curvature = spare / 2.0 * (d / rho - (b / rho) * (b / rho))
        - trace / 2.0
        - through.dot(&through.transpose()) / 2.0
        + inverse.dot(&g);
    // (A / σ² − c cᵀ / (σ⁴ h))⁻¹ by Sherman and Morrison.
    let along = inverse.times_vector(&c);
    let left = curvature - dot(&c, &along) / variance;
    let shift = dot(weights, &along);
    let found = variance * inverse.form(weights, weights) + shift * shift / left;
    if found > 0.0 && found.is_finite() {
        Ok(found)
    } else {
        // The program prints nan.
        Err(Unestimable::NotConverged { what: "the variances", slope: left })
    }
}
