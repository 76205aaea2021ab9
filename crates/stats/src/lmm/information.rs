//! The information of the data on the variances: the sums that Kenward–Roger's and Satterthwaite's
//! degrees of freedom are made of.
//!
//! The covariance V = Σᵣ γᵣ Gᵣ is linear in the variance parameters γ: each term's covariances and,
//! last, the residual variance with G = I. Kenward & Roger (1997), Biometrics 53:983, with
//! Φ = (Xᵀ V⁻¹ X)⁻¹:
//!
//! Pᵣ = −Xᵀ V⁻¹ Gᵣ V⁻¹ X, Qᵣₛ = Xᵀ V⁻¹ Gᵣ V⁻¹ Gₛ V⁻¹ X,
//! tr(P Gᵣ P Gₛ) = tr(V⁻¹ Gᵣ V⁻¹ Gₛ) − 2 tr(Φ Qᵣₛ) + tr(Φ Pᵣ Φ Pₛ)
//!
//! Everything here is in units of the residual variance (V = W), and for a term's entry (a, b) is
//! Gᵣ = Z Dᵣ Zᵀ, with ones at (a, b) and (b, a) of each of its blocks in D: sums per group.

use super::design::{Block, Design, Entry, Pattern};
use super::profile::{Profile, Spread, residual_squares};
use crate::tested::Unestimable;
use zwidth_numerics::dense::{Matrix, dot};

/// A variance parameter of which less than this share is left beside the others is not told apart
/// from them.
const ALIASED: f64 = 1e-9;
/// Weights of a dependent combination below this are rounding.
const TAKEN: f64 = 1e-3;

/// The sums, one row and column per variance parameter, the residual's last.
pub(super) struct Information {
    /// Pᵣ.
    pub(super) p: Vec<Matrix>,
    /// Qᵣₛ, row by row.
    pub(super) q: Vec<Matrix>,
    /// tr(V⁻¹ Gᵣ V⁻¹ Gₛ).
    pub(super) full: Matrix,
    /// tr(P Gᵣ P Gₛ), P = V⁻¹ − V⁻¹ X Φ Xᵀ V⁻¹: twice the expected information of REML.
    pub(super) expected: Matrix,
}

/// The sums that take the response: slopes and curvatures of the criterion in γ.
pub(super) struct Observed {
    /// ∂ deviance / ∂ γ.
    pub(super) slopes: Vec<f64>,
    /// yᵀ P Gᵣ P Gₛ P y.
    pub(super) quadratic: Matrix,
}

/// The sums at a profile.
pub(super) fn information(design: &Design, at: &Profile) -> Information {
    let size = design.entries.len() + 1;
    let p = design.least_squares.len();
    let mut sums = Information {
        p: vec![Matrix::zeros(p, p); size],
        q: vec![Matrix::zeros(p, p); size * size],
        full: Matrix::zeros(size, size),
        expected: Matrix::zeros(size, size),
    };
    for (pattern, spread) in design.patterns.iter().zip(&at.spreads) {
        add_pattern(&mut sums, design, pattern, spread);
    }
    let phi_p: Vec<Matrix> = sums.p.iter().map(|p| at.a_inverse.times(p)).collect();
    sums.expected = Matrix::from_fn(size, size, |r, s| {
        let q = &sums.q[r.min(s) * size + r.max(s)];
        sums.full[(r, s)] - 2.0 * at.a_inverse.dot(q) + phi_p[r].dot(&phi_p[s].transpose())
    });
    sums
}

/// Adds the sums over one pattern's groups.
fn add_pattern(sums: &mut Information, design: &Design, pattern: &Pattern, spread: &Spread) {
    let residual = design.entries.len();
    let size = residual + 1;
    let groups = pattern.groups;
    // Zᵀ W⁻² Z and Zᵀ W⁻² X; Xᵀ Wᵏ X for k = −1, −2, −3 by W⁻¹ = I − Z N Zᵀ
    let zw2z = spread.f.times(&spread.zwz);
    let zw2x = spread.f.times(&spread.zwx);
    let ntx = spread.n.times(&pattern.ztx);
    let mut xwx = pattern.xtx.clone();
    xwx.add(-1.0, &ntx.transposed_times(&pattern.ztx));
    let mut xw2x = xwx;
    xw2x.add(-1.0, &ntx.transposed_times(&spread.zwx));
    let mut xw3x = xw2x.clone();
    xw3x.add(-1.0, &ntx.transposed_times(&zw2x));
    let [d_zwz, d_zwx] = [&spread.zwz, &spread.zwx].map(|m| -> Vec<Matrix> {
        design.entries.iter().map(|e| times_d(*e, &pattern.blocks, m)).collect()
    });
    for r in 0..residual {
        sums.p[r].add(-groups, &d_zwx[r].transposed_times(&spread.zwx));
        for s in 0..residual {
            sums.full[(r, s)] += groups * d_zwz[r].transpose().dot(&d_zwz[s]);
            if s >= r {
                let q = d_zwx[r].transposed_times(&spread.zwz.times(&d_zwx[s]));
                sums.q[r * size + s].add(groups, &q);
            }
        }
        let with_residual = groups
            * times_d(design.entries[r], &pattern.blocks, &zw2z).diagonal().iter().sum::<f64>();
        sums.full[(r, residual)] += with_residual;
        sums.full[(residual, r)] += with_residual;
        sums.q[r * size + residual].add(groups, &d_zwx[r].transposed_times(&zw2x));
    }
    sums.p[residual].add(-groups, &xw2x);
    sums.q[residual * size + residual].add(groups, &xw3x);
    // tr W⁻² = n − 2 tr N S + tr N S N S, S = Zᵀ Z
    let ns = spread.n.times(&pattern.ztz);
    let trace = pattern.rows - 2.0 * ns.diagonal().iter().sum::<f64>() + ns.dot(&ns.transpose());
    sums.full[(residual, residual)] += groups * trace;
}

/// D M for an entry's D.
fn times_d(entry: Entry, blocks: &[Block], m: &Matrix) -> Matrix {
    let mut product = Matrix::zeros(m.rows, m.cols);
    for Block { at, .. } in blocks.iter().filter(|block| block.term == entry.term) {
        let a = at + entry.a;
        let b = at + entry.b;
        product.row_mut(a).copy_from_slice(m.row(b));
        product.row_mut(b).copy_from_slice(m.row(a));
    }
    product
}

/// The sums with the response, in units of the residual variance.
pub(super) fn observed(
    design: &Design,
    reml: bool,
    at: &Profile,
    information: &Information,
) -> Observed {
    let residual = design.entries.len();
    let size = residual + 1;
    let p = design.least_squares.len();
    let mut quadratic = Matrix::zeros(size, size);
    let mut trace = vec![0.0; size]; // tr W⁻¹ Gᵣ
    let mut form = vec![0.0; size]; // uᵀ Dᵣ u, for the residual rᵀ W⁻² r
    let mut w = vec![vec![0.0; p]; size]; // Xᵀ W⁻¹ Gᵣ W⁻¹ r
    let mut rw2r = at.rss;
    let mut rw3r = at.rss;
    for (pattern, spread) in design.patterns.iter().zip(&at.spreads) {
        let squares = residual_squares(pattern, &at.gamma);
        let ur = spread.f.times(&squares); // Σ u rᵀ Z, u = Zᵀ W⁻¹ r
        let uu = ur.times(&spread.f.transpose()); // Σ u uᵀ
        let u2u = spread.f.times(&uu); // Σ Zᵀ W⁻² r uᵀ
        let mut u = spread.f.times_vector(&pattern.zty);
        let fitted = spread.zwx.times_vector(&at.gamma);
        u.iter_mut().zip(fitted).for_each(|(u, fitted)| *u -= pattern.groups * fitted);
        let d_uu: Vec<Matrix> =
            design.entries.iter().map(|e| times_d(*e, &pattern.blocks, &uu)).collect();
        let column = Matrix::from_fn(u.len(), 1, |i, _| u[i]);
        for (r, entry) in design.entries.iter().enumerate() {
            let d_zwz = times_d(*entry, &pattern.blocks, &spread.zwz);
            trace[r] += pattern.groups * d_zwz.diagonal().iter().sum::<f64>();
            form[r] += d_uu[r].diagonal().iter().sum::<f64>();
            let du = times_d(*entry, &pattern.blocks, &column);
            for (j, w) in w[r].iter_mut().enumerate() {
                *w += (0..u.len()).map(|i| spread.zwx[(i, j)] * du[(i, 0)]).sum::<f64>();
            }
            for (s, d_uu) in d_uu.iter().enumerate() {
                quadratic[(r, s)] += d_zwz.dot(&d_uu.transpose());
            }
            let crossed = times_d(*entry, &pattern.blocks, &u2u).diagonal().iter().sum::<f64>();
            quadratic[(r, residual)] += crossed;
            quadratic[(residual, r)] += crossed;
        }
        let nu = spread.n.times_vector(&u);
        let lost = pattern.ztx.transposed_times_vector(&nu);
        w[residual].iter_mut().zip(lost).for_each(|(w, lost)| *w -= lost);
        let once = spread.n.dot(&ur);
        rw2r -= once;
        rw3r -= once + spread.n.dot(&spread.f.times(&ur));
        let ns = spread.n.dot(&pattern.ztz);
        trace[residual] += pattern.groups * (pattern.rows - ns);
    }
    form[residual] = rw2r;
    quadratic[(residual, residual)] = rw3r;
    let lost: Vec<Vec<f64>> = w.iter().map(|w| at.a_inverse.times_vector(w)).collect();
    let quadratic = Matrix::from_fn(size, size, |r, s| {
        (quadratic[(r, s)] - dot(&w[r], &lost[s])) / at.variance
    });
    let slopes = (0..size).map(|r| {
        let restriction = if reml { at.a_inverse.dot(&information.p[r]) } else { 0.0 };
        trace[r] + restriction - form[r] / at.variance
    });
    Observed { slopes: slopes.collect(), quadratic }
}

/// Refuses what the design cannot tell apart: at V = I, the information on the variances must have
/// full rank.
pub(super) fn check_identified(design: &Design, at_zero: &Profile) -> Result<(), Unestimable> {
    let Information { full, expected, .. } = information(design, at_zero);
    let size = full.rows;
    let mut are_left = (0..size).map(|r| expected[(r, r)] > ALIASED * full[(r, r)]);
    if let Some(gone) = are_left.position(|is_left| !is_left) {
        let what = format!("{} from the fixed effects", name(design, gone));
        return Err(Unestimable::Confounded { what });
    }
    let root: Vec<f64> = expected.diagonal().iter().map(|d| d.sqrt()).collect();
    let scaled = Matrix::from_fn(size, size, |r, s| expected[(r, s)] / (root[r] * root[s]));
    let (values, vectors) = scaled.eigen();
    let Some(at) = values.iter().position(|value| *value < ALIASED) else { return Ok(()) };
    // The parameters that this dependent combination takes.
    let taken = (0..size).filter(|r| vectors[(at, *r)].abs() > TAKEN);
    let mut names: Vec<&str> = taken.map(|r| name(design, r)).collect();
    names.dedup();
    Err(Unestimable::Confounded { what: names.join(" and ") })
}

fn name(design: &Design, parameter: usize) -> &str {
    match design.entries.get(parameter) {
        Some(entry) => &design.names[entry.term],
        None => "the residual",
    }
}
