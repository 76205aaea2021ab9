//! The profiled criterion of a linear mixed model and its gradient.
//!
//! Bates, Mächler, Bolker & Walker (2015), J. Stat. Softw. 67(1), §3: y ~ N(X β, σ² W) with
//! W = I + Z Λ Λᵀ Zᵀ, where Λ repeats each term's lower triangle T (the relative Cholesky factor,
//! its entries are θ) once per level. At a given θ the best β and σ² have closed forms, and minus
//! twice the log-likelihood with these values is
//!
//! ML:   ln det W + n (1 + ln(2π r²/n))
//! REML: ln det W + ln det Xᵀ W⁻¹ X + ν (1 + ln(2π r²/ν)), ν = n − p
//!
//! with r² = (y − X β̂)ᵀ W⁻¹ (y − X β̂). The criterion is even in each column of T, so θ needs no
//! bounds: a negative column is the positive one.

use super::design::{Block, Design, Entry, Pattern};
use zwidth_numerics::dense::{Matrix, SINGULAR, add_scaled, dot};

const TWO_PI: f64 = 2.0 * core::f64::consts::PI;

/// The part of a group's likelihood that depends on θ and not on y.
pub(super) struct Spread {
    /// N = Λ (I + Λᵀ Zᵀ Z Λ)⁻¹ Λᵀ, so that W⁻¹ = I − Z N Zᵀ (Woodbury).
    pub(super) n: Matrix,
    /// B with Bᵀ B = N.
    root: Matrix,
    /// F = I − Zᵀ Z N, so that Zᵀ W⁻¹ = F Zᵀ.
    pub(super) f: Matrix,
    /// Zᵀ W⁻¹ Z.
    pub(super) zwz: Matrix,
    /// Zᵀ W⁻¹ X.
    pub(super) zwx: Matrix,
    /// ln det W.
    log_det: f64,
}

/// The criterion and its intermediate results.
pub(super) struct Profile {
    /// Minus twice the log-likelihood, restricted or not.
    pub(super) deviance: f64,
    /// Its gradient in θ.
    pub(super) gradient: Vec<f64>,
    /// For each term ∂ deviance / ∂ (T Tᵀ) as a symmetric matrix: the slope in the variances.
    pub(super) in_variances: Vec<Matrix>,
    /// β̂ in coordinates of Q, about the least-squares fit.
    pub(super) gamma: Vec<f64>,
    /// (Qᵀ W⁻¹ Q)⁻¹.
    pub(super) a_inverse: Matrix,
    /// r².
    pub(super) rss: f64,
    /// σ̂² = r² / ν.
    pub(super) variance: f64,
    /// One per pattern.
    pub(super) spreads: Vec<Spread>,
}

/// The triangles T of all terms.
pub(super) fn factors(design: &Design, theta: &[f64]) -> Vec<Matrix> {
    let mut factors: Vec<Matrix> =
        design.scales.iter().map(|s| Matrix::zeros(s.len(), s.len())).collect();
    for (Entry { term, a, b }, theta) in design.entries.iter().zip(theta) {
        factors[*term][(*a, *b)] = *theta;
    }
    factors
}

/// The criterion at θ; `None` where it has no finite value.
pub(super) fn profile(design: &Design, reml: bool, theta: &[f64]) -> Option<Profile> {
    let p = design.least_squares.len();
    let factors = factors(design, theta);
    let mut a = Matrix::zeros(p, p);
    let mut xwy = vec![0.0; p];
    let mut ywy = 0.0;
    let mut log_det = 0.0;
    let mut spreads = Vec::with_capacity(design.patterns.len());
    for pattern in &design.patterns {
        let spread = spread(pattern, &factors)?;
        // Xᵀ W⁻¹ X, Xᵀ W⁻¹ y and yᵀ W⁻¹ y, each with W⁻¹ = I − Z Bᵀ B Zᵀ.
        let bx = spread.root.times(&pattern.ztx);
        a.add(pattern.groups, &pattern.xtx);
        a.add(-pattern.groups, &bx.transposed_times(&bx));
        add_scaled(&mut xwy, 1.0, &pattern.xty);
        let by = spread.root.times_vector(&pattern.zty);
        add_scaled(&mut xwy, -1.0, &bx.transposed_times_vector(&by));
        ywy += pattern.yty;
        // Group by group, because a square does not add up over groups.
        for zty in &pattern.each {
            let by = spread.root.times_vector(zty);
            ywy -= dot(&by, &by);
        }
        log_det += pattern.groups * spread.log_det;
        spreads.push(spread);
    }
    let (a_inverse, log_det_a) = a.inverse_and_log_det()?;
    let gamma = a_inverse.times_vector(&xwy);
    let rss = ywy - dot(&xwy, &gamma);
    let nu = design.rows as f64 - if reml { p as f64 } else { 0.0 };
    let restriction = if reml { log_det_a + 2.0 * design.log_det_r } else { 0.0 };
    let deviance = log_det + restriction + nu * (1.0 + libm::log(TWO_PI * rss / nu));
    let variance = rss / nu;
    let in_variances = in_variances(design, reml, &spreads, &gamma, &a_inverse, variance);
    let gradient = gradient(design, &factors, &in_variances);
    Some(Profile { deviance, gradient, in_variances, gamma, a_inverse, rss, variance, spreads })
}

/// N, F, Zᵀ W⁻¹ Z and Zᵀ W⁻¹ X of a group.
fn spread(pattern: &Pattern, factors: &[Matrix]) -> Option<Spread> {
    let size = pattern.zty.len();
    let sl = times_lambda(&pattern.ztz, &pattern.blocks, factors);
    let mut inner = times_lambda(&sl.transpose(), &pattern.blocks, factors);
    (0..size).for_each(|i| inner[(i, i)] += 1.0);
    let l = inner.cholesky(SINGULAR)?;
    // B = L⁻¹ Λᵀ and B S: N itself grows with θ² where columns of Z depend on each other, these do
    // not.
    let root = times_lambda_transposed(&l.lower_inverse(), &pattern.blocks, factors);
    let bs = root.times(&pattern.ztz);
    let mut f = Matrix::identity(size);
    f.add(-1.0, &bs.transposed_times(&root));
    let mut zwz = pattern.ztz.clone();
    zwz.add(-1.0, &bs.transposed_times(&bs));
    let mut zwx = pattern.ztx.clone();
    zwx.add(-1.0, &bs.transposed_times(&root.times(&pattern.ztx)));
    let log_det = l.diagonal().iter().map(|d| 2.0 * libm::log(*d)).sum();
    Some(Spread { n: root.transposed_times(&root), root, f, zwz, zwx, log_det })
}

/// M Λ.
fn times_lambda(m: &Matrix, blocks: &[Block], factors: &[Matrix]) -> Matrix {
    let mut product = Matrix::zeros(m.rows, m.cols);
    for i in 0..m.rows {
        for Block { term, at } in blocks {
            let t = &factors[*term];
            for b in 0..t.rows {
                product[(i, at + b)] = (b..t.rows).map(|a| m[(i, at + a)] * t[(a, b)]).sum();
            }
        }
    }
    product
}

/// M Λᵀ.
fn times_lambda_transposed(m: &Matrix, blocks: &[Block], factors: &[Matrix]) -> Matrix {
    let mut product = Matrix::zeros(m.rows, m.cols);
    for i in 0..m.rows {
        for Block { term, at } in blocks {
            let t = &factors[*term];
            for a in 0..t.rows {
                product[(i, at + a)] = (0..=a).map(|b| m[(i, at + b)] * t[(a, b)]).sum();
            }
        }
    }
    product
}

/// ∂ deviance / ∂ (T Tᵀ) = Σ over groups and levels of the term's blocks of
/// Zᵀ W⁻¹ Z − [REML] Zᵀ W⁻¹ X (Xᵀ W⁻¹ X)⁻¹ Xᵀ W⁻¹ Z − u uᵀ / σ̂², u = Zᵀ W⁻¹ (y − X β̂).
fn in_variances(
    design: &Design,
    reml: bool,
    spreads: &[Spread],
    gamma: &[f64],
    a_inverse: &Matrix,
    variance: f64,
) -> Vec<Matrix> {
    let mut slopes: Vec<Matrix> =
        design.scales.iter().map(|s| Matrix::zeros(s.len(), s.len())).collect();
    for (pattern, spread) in design.patterns.iter().zip(spreads) {
        let uu = blup_squares(pattern, spread, gamma);
        let xa = spread.zwx.times(a_inverse);
        for Block { term, at } in &pattern.blocks {
            let slope = &mut slopes[*term];
            for i in 0..slope.rows {
                for j in 0..slope.rows {
                    let a = at + i;
                    let b = at + j;
                    let lost = if reml { dot(xa.row(a), spread.zwx.row(b)) } else { 0.0 };
                    let rest = pattern.groups * (spread.zwz[(a, b)] - lost);
                    slope[(i, j)] += rest - uu[(a, b)] / variance;
                }
            }
        }
    }
    slopes
}

/// Σ u uᵀ over the groups of a pattern, u = Zᵀ W⁻¹ (y − X γ). Group by group: a square that is
/// taken before the large parts of Zᵀ y cancel has lost twice the digits.
fn blup_squares(pattern: &Pattern, spread: &Spread, gamma: &[f64]) -> Matrix {
    let fitted = pattern.ztx.times_vector(gamma);
    let mut squares = Matrix::zeros(fitted.len(), fitted.len());
    for zty in &pattern.each {
        let rest: Vec<f64> = zty.iter().zip(&fitted).map(|(z, fitted)| z - fitted).collect();
        let u = spread.f.times_vector(&rest);
        squares.add_outer(1.0, &u, &u);
    }
    squares
}

/// Σ Zᵀ r rᵀ Z over the groups of a pattern, r = y − X γ.
pub(super) fn residual_squares(pattern: &Pattern, gamma: &[f64]) -> Matrix {
    let fitted = pattern.ztx.times_vector(gamma);
    let mut squares = pattern.zty_ytz.clone();
    squares.add_outer(-1.0, &pattern.zty, &fitted);
    squares.add_outer(-1.0, &fitted, &pattern.zty);
    squares.add_outer(pattern.groups, &fitted, &fitted);
    squares
}

/// ∂ deviance / ∂ T = 2 (∂ deviance / ∂ T Tᵀ) T, its free entries.
fn gradient(design: &Design, factors: &[Matrix], in_variances: &[Matrix]) -> Vec<f64> {
    let products: Vec<Matrix> = in_variances.iter().zip(factors).map(|(s, t)| s.times(t)).collect();
    design.entries.iter().map(|e| 2.0 * products[e.term][(e.a, e.b)]).collect()
}
