//! Kenward & Roger's small-sample tests of fixed effects, as in the R package pbkrtest.
//!
//! Kenward & Roger (1997), Biometrics 53:983; Halekoh & Højsgaard (2014), J. Stat. Softw. 59(9).
//! The covariance is linear in the variances, and a variance that was estimated as zero remains a
//! parameter. So a fit at the bound keeps its degrees of freedom, where Satterthwaite's collapse.

use super::contrast::{Contrasts, check_independent, f_test, sandwich, t_test};
use super::design::Design;
use super::information::{Information, information};
use super::profile::Profile;
use crate::tested::{FTest, Tested, Unestimable};
use zwidth_numerics::dense::{Matrix, dot};

/// Below this 1 + c₁ B counts as zero, as in pbkrtest.
const ZERO: f64 = 1e-10;
/// So near 2 the scale of F would divide by zero; pbkrtest then leaves F unscaled.
const NEAR_TWO: f64 = 0.01;

/// The adjusted covariance and what the degrees of freedom are made of.
#[derive(Debug, Clone)]
pub(super) struct Adjusted {
    /// Φ = (Xᵀ V⁻¹ X)⁻¹ in units of the residual variance.
    phi: Matrix,
    /// Φ_A, in the square of the response's unit.
    covariance: Matrix,
    /// Pᵣ.
    p: Vec<Matrix>,
    /// Covariance of the variance parameters, 2 tr(P Gᵣ P Gₛ)⁻¹.
    w: Matrix,
}

/// Φ_A = Φ + 2 Φ {Σᵣₛ wᵣₛ (Qᵣₛ − Pᵣ Φ Pₛ)} Φ (equation 8 of the paper without its last term, which
/// vanishes for a linear covariance).
pub(super) fn adjust(design: &Design, at: &Profile) -> Result<Adjusted, Unestimable> {
    let Information { p, q, expected, .. } = information(design, at);
    let size = p.len();
    let root: Vec<f64> = expected.diagonal().iter().map(|d| d.sqrt()).collect();
    let scaled = Matrix::from_fn(size, size, |r, s| expected[(r, s)] / (root[r] * root[s]));
    let (inverse, _) = scaled
        .inverse_and_log_det()
        .ok_or_else(|| Unestimable::Confounded { what: "the variances".to_owned() })?;
    let w = Matrix::from_fn(size, size, |r, s| 2.0 * inverse[(r, s)] / (root[r] * root[s]));
    let phi = at.a_inverse.clone();
    let mut u = Matrix::zeros(phi.rows, phi.rows);
    for r in 0..size {
        // wᵣₛ = wₛᵣ, and the part of (s, r) is the transpose of that of (r, s).
        for s in r..size {
            let mut part = q[r * size + s].clone();
            part.add(-1.0, &p[r].times(&phi.times(&p[s])));
            u.add(w[(r, s)], &part);
            if s > r {
                u.add(w[(r, s)], &part.transpose());
            }
        }
    }
    let mut covariance = Matrix::zeros(phi.rows, phi.rows);
    covariance.add(at.variance, &phi);
    covariance.add(2.0 * at.variance, &phi.times(&u.times(&phi)));
    Ok(Adjusted { phi, covariance, p, w })
}

impl Adjusted {
    /// The t test of a single contrast: its scale is 1.
    pub(super) fn t(&self, contrast: &Contrasts, level: f64) -> Result<Tested, Unestimable> {
        let variance = sandwich(&contrast.l, &self.covariance);
        check_independent(&variance)?;
        let (df, _) = self.df_and_scale(&contrast.l)?;
        t_test(contrast.estimates[0], variance[(0, 0)], df, level)
    }

    /// λ F = λ (L β)ᵀ (L Φ_A Lᵀ)⁻¹ (L β) / q.
    pub(super) fn f(&self, contrasts: &Contrasts) -> Result<FTest, Unestimable> {
        let variance = sandwich(&contrasts.l, &self.covariance);
        check_independent(&variance)?;
        let (df, scale) = self.df_and_scale(&contrasts.l)?;
        let inverse = inverse(&variance)?;
        let q = contrasts.l.rows as f64;
        let wald = inverse.form(&contrasts.estimates, &contrasts.estimates);
        f_test(scale * wald / q, q, df)
    }

    /// The degrees of freedom m of the denominator and the scale λ of F (section 3 of the paper).
    fn df_and_scale(&self, l: &Matrix) -> Result<(f64, f64), Unestimable> {
        let q = l.rows as f64;
        // Θ = Lᵀ (L Φ Lᵀ)⁻¹ L
        let theta = l.transposed_times(&inverse(&sandwich(l, &self.phi))?.times(l));
        let theta_phi = theta.times(&self.phi);
        let parts: Vec<Matrix> =
            self.p.iter().map(|p| theta_phi.times(&p.times(&self.phi))).collect();
        let traces: Vec<f64> = parts.iter().map(|u| u.diagonal().iter().sum()).collect();
        let a1 = self.w.form(&traces, &traces);
        let a2: f64 = (0..parts.len())
            .map(|r| {
                let transposed = parts[r].transpose();
                let row: Vec<f64> = parts.iter().map(|u| u.dot(&transposed)).collect();
                dot(self.w.row(r), &row)
            })
            .sum();
        let b = (a1 + 6.0 * a2) / (2.0 * q);
        let g = ((q + 1.0) * a1 - (q + 4.0) * a2) / ((q + 2.0) * a2);
        let d = 3.0 * q + 2.0 * (1.0 - g);
        let c1 = g / d;
        let c2 = (q - g) / d;
        let c3 = (q + 2.0 - g) / d;
        let v0 = 1.0 + c1 * b;
        let v0 = if v0.abs() < ZERO { 0.0 } else { v0 };
        let v1 = 1.0 - c2 * b;
        let v2 = 1.0 - c3 * b;
        let e = 1.0 - a2 / q; // 1 / E*
        let ratio = if e.abs() < ZERO && v1.abs() < ZERO { 1.0 } else { e / v1 };
        let rho = ratio * ratio * v0 / (q * v2);
        let df = 4.0 + (q + 2.0) / (q * rho - 1.0);
        let scale = if (df - 2.0).abs() < NEAR_TWO { 1.0 } else { df * e / (df - 2.0) };
        Ok((df, scale))
    }
}

fn inverse(m: &Matrix) -> Result<Matrix, Unestimable> {
    match m.inverse_and_log_det() {
        Some((inverse, _)) => Ok(inverse),
        None => Err(Unestimable::Confounded { what: "the contrasts".to_owned() }),
    }
}
