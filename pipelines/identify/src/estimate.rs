//! How well each parameter is known.

use crate::IdentifyError;
use crate::fit::{Block, Problem, sum};
use crate::profile::Curve;
use crate::slopes::Parameter;
use crate::verdict::verdict;
use zwidth_numerics::expm::Matrix;
use zwidth_numerics::nonlinear::Minimum;
use zwidth_results::{Identifiability, PlantProfile};
use zwidth_stats::student_t::critical_value;

/// A fitted parameter; unit as the parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The parameter.
    pub parameter: Parameter,
    /// Its value.
    pub fitted: f64,
    /// Standard error by leaving out each trial in turn; `None` where the trials do not determine
    /// the parameter, or not without one of them.
    pub std_error: Option<f64>,
    /// Effective degrees of freedom of the standard error; `None` likewise.
    pub df: Option<f64>,
    /// Where the profile stays within the requested level; an end may be a bound. `None` likewise.
    pub interval: Option<(f64, f64)>,
    /// Variance inflation: by how much its variance is larger than if the other parameters were
    /// known, 1 at least; `None` for a parameter that the trials do not determine.
    pub inflation: Option<f64>,
    /// Its profile, by rising value; empty without standard error.
    pub profile: Vec<PlantProfile>,
    /// Whether the trials say what it is.
    pub verdict: Identifiability,
}

/// A standard error below this share of the value is that of the arithmetic: there is no noise, and
/// nothing to profile.
const NOISELESS: f64 = 1e-6;

/// The scatter of an estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spread {
    pub(crate) std_error: f64,
    pub(crate) df: f64,
}

/// The spread of free parameter `j`, from what its estimate becomes without each trial in turn: the
/// trial-block jackknife (Efron 1982; as the covariance CR3 of Bell & McCaffrey 2002, Surv.
/// Methodol. 28:169), V = (G − 1)/G Σ_g (p_g − p̄)². It holds whatever the errors within a trial
/// are like. Its degrees of freedom are Satterthwaite's (1946), (Σ_g h_g)² / Σ_g h_g² with the
/// trials' shares h_g = (A⁻¹ A_g A⁻¹)_jj of the variance: few where few trials tell.
pub(crate) fn spread<const P: usize>(
    blocks: &[Block<P>],
    free: &[bool; P],
    j: usize,
) -> Option<Spread> {
    let all = sum(blocks);
    let inverse_all = inverse(&all.curvature, free)?;
    let moved: Vec<[f64; P]> = moved(blocks, free).into_iter().collect::<Option<_>>()?;
    let variance = jackknife(&moved, j, j);
    let mut total = 0.0;
    let mut squares = 0.0;
    for Block { curvature, .. } in blocks {
        let share: f64 = (0..P)
            .map(|k| {
                let row: f64 = (0..P).map(|l| curvature[k][l] * inverse_all[l][j]).sum();
                inverse_all[j][k] * row
            })
            .sum();
        total += share;
        squares += share * share;
    }
    Some(Spread { std_error: variance.sqrt(), df: total * total / squares })
        .filter(|s| s.std_error.is_finite() && s.df > 0.0)
}

/// By how much the parameters move without each trial in turn, one Gauss–Newton step each, 0 for
/// those that are not free; `None` where the other trials do not determine them.
pub(crate) fn moved<const P: usize>(
    blocks: &[Block<P>],
    free: &[bool; P],
) -> Vec<Option<[f64; P]>> {
    (0..blocks.len())
        .map(|g| {
            let others =
                sum(blocks.iter().enumerate().filter(|(i, _)| *i != g).map(|(_, block)| block));
            let inverse = inverse(&others.curvature, free)?;
            Some(core::array::from_fn(|j| {
                -(0..P).map(|k| inverse[j][k] * others.gradient[k]).sum::<f64>()
            }))
        })
        .collect()
}

/// The covariance V_jk = (G − 1)/G Σ_g (p_g − p̄)_j (p_g − p̄)_k of two parameters by the same
/// jackknife; 0 for those that are not free.
pub(crate) fn jackknife<const P: usize>(moved: &[[f64; P]], j: usize, k: usize) -> f64 {
    let n = moved.len() as f64;
    let [mean_j, mean_k] = [j, k].map(|j| moved.iter().map(|m| m[j]).sum::<f64>() / n);
    (n - 1.0) / n * moved.iter().map(|m| (m[j] - mean_j) * (m[k] - mean_k)).sum::<f64>()
}

/// Which parameters are free to move: those that are on no bound and on which the recordings
/// depend.
pub(crate) fn free<const P: usize>(
    parameters: &[Parameter; P],
    at: &[f64; P],
    all: &Block<P>,
) -> [bool; P] {
    core::array::from_fn(|j| !on_bound(&parameters[j], at[j]) && all.curvature[j][j] > 0.0)
}

/// Whether a value sits on one of its bounds.
pub(crate) fn on_bound(parameter: &Parameter, value: f64) -> bool {
    value <= parameter.lower || value >= parameter.upper
}

/// The inverse over the free parameters, 0 elsewhere, by elimination of the matrix scaled to a
/// diagonal of ones; `None` if it is singular.
pub(crate) fn inverse<const P: usize>(
    matrix: &[[f64; P]; P],
    free: &[bool; P],
) -> Option<[[f64; P]; P]> {
    let scale: [f64; P] = core::array::from_fn(|j| matrix[j][j].sqrt());
    let scaled = Matrix::<P>::from_fn(|j, k| match free[j] && free[k] {
        true => matrix[j][k] / (scale[j] * scale[k]),
        false => f64::from(u8::from(j == k)),
    });
    // Positive definite: every pivot is above 0 where it stands, and rounding is what is left of
    // one that is not.
    let inverse = scaled.inverse_by(|rows, k| (rows[k][k] > f64::EPSILON).then_some(k))?;
    Some(core::array::from_fn(|j| {
        core::array::from_fn(|k| match free[j] && free[k] {
            true => inverse.at(j, k) / (scale[j] * scale[k]),
            false => 0.0,
        })
    }))
}

/// The estimate of each parameter, from the trials' parts of the normal equations and from fits
/// with the parameter held.
pub(crate) fn estimates<const P: usize>(
    problem: &Problem<P>,
    minimum: &Minimum<P>,
    blocks: &[Block<P>],
    slopes: &[Vec<[f64; P]>],
    level: f64,
) -> Result<Vec<Estimate>, IdentifyError> {
    let all = sum(blocks);
    let free = free(problem.parameters, &minimum.parameters, &all);
    let inverse = inverse(&all.curvature, &free);
    let mut estimates = Vec::with_capacity(P);
    for j in 0..P {
        // (JᵀJ)⁻¹ times JᵀJ, diagonal entries; `None` where others stand in for it wholly.
        let inflation = inverse.filter(|_| free[j]).map(|i| i[j][j] * all.curvature[j][j]);
        // One on its bound may leave it, to tell how far: the bracket that is left of its interval.
        let mut free = free;
        free[j] = all.curvature[j][j] > 0.0;
        // On `free` as it is now, so that one on its bound has a spread to profile with.
        let spread = spread(blocks, &free, j).filter(|_| free[j]);
        let fitted = minimum.parameters[j];
        let noisy = spread.filter(|spread| spread.std_error > NOISELESS * fitted.abs());
        let curve =
            noisy.and_then(|spread| Curve::new(problem, minimum, &all, slopes, &free, j, spread));
        let critical = spread.map(|spread| critical_value(level, spread.df)).transpose()?;
        let interval = match (noisy, &curve) {
            (None, _) => spread.map(|_| (fitted, fitted)),
            (_, curve) => curve.as_ref().zip(critical).and_then(|(curve, t)| curve.interval(t)),
        };
        let mut estimate = Estimate {
            parameter: problem.parameters[j],
            fitted,
            std_error: spread.map(|s| s.std_error),
            df: spread.map(|s| s.df),
            interval,
            inflation,
            profile: curve.map(|curve| curve.points()).unwrap_or_default(),
            verdict: Identifiability::OnBound,
        };
        estimate.verdict = verdict(&estimate, all.curvature[j][j]);
        estimates.push(estimate);
    }
    Ok(estimates)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::each;
    use crate::{Recording, Task, identify};
    use zwidth_results::PlantParameter;

    /// Five trials of a line through two columns made of whole numbers, every other repeat held
    /// out.
    fn line(trial: usize) -> (Vec<[f64; 2]>, Vec<f64>) {
        let row = |i: usize| {
            let x = (i + 1) as f64 / 6.0 * (1.0 + 0.5 * trial as f64);
            [x, if (7 * i + 3 * trial) % 5 < 2 { 1.0 } else { -0.5 }]
        };
        let error = |i: usize| (((5 * i + 3 * trial) % 7) as f64 / 7.0 - 0.4) * 0.3;
        let rows: Vec<[f64; 2]> = (0..6).map(row).collect();
        let y = rows.iter().enumerate().map(|(i, [x, z])| 2.0 * x + z + error(i)).collect();
        (rows, y)
    }

    /// The fit of both columns with a lower bound for the second.
    fn fitted(lower: f64) -> Vec<Estimate> {
        let metas = crate::testing::metas(10);
        let (rows, y): (Vec<_>, Vec<_>) = (0..10).map(|i| line(i / 2)).unzip();
        let recordings: Vec<_> =
            metas.iter().zip(&y).map(|(meta, observed)| Recording { meta, observed }).collect();
        let parameter =
            |name, lower| Parameter { name, unit: "1", by_eye: 0.5, lower, upper: 10.0 };
        let parameters =
            [parameter(PlantParameter::Mass, -10.0), parameter(PlantParameter::Damping, lower)];
        let task = Task { parameters: &parameters, starts: &[], level: 0.95 };
        let explain = |i: usize, p: &[f64; 2]| {
            Some(rows[i].iter().map(|r| p[0] * r[0] + p[1] * r[1]).collect())
        };
        identify(&recordings, &task, each(explain), |_, _| None).unwrap().estimates
    }

    fn close(found: f64, expect: f64, share: f64) {
        assert!((found / expect - 1.0).abs() < share, "{found} instead of {expect}");
    }

    /// NumPy and SciPy: `lstsq` on the rows of five trials, and five times on those of four of
    /// them; SE² = 4/5 Σ (b₋g − mean)²; df = (Σ h)²/Σ h² with h = diag(A⁻¹ X_gᵀX_g A⁻¹); b ∓
    /// `t.ppf(0.975, df)` SE; Σ r² with b₀ held at b₀ + SE over that of the fit.
    #[test]
    fn standard_error_degrees_of_freedom_interval_and_profile_are_those_of_numpy_and_scipy() {
        let found = fitted(-10.0);
        let one_off = |estimate: &Estimate, at: f64| {
            estimate.profile.iter().find(|p| (p.value - at).abs() < 1e-6).unwrap().clone()
        };
        for (estimate, [fitted, std_error, df, low, high]) in found.iter().zip(SCIPY) {
            let (ci_low, ci_high) = estimate.interval.unwrap();
            close(estimate.fitted, fitted, 1e-9);
            close(estimate.std_error.unwrap(), std_error, 1e-7);
            close(estimate.df.unwrap(), df, 1e-7);
            close(ci_low - fitted, low - fitted, 1e-4);
            close(ci_high - fitted, high - fitted, 1e-4);
            close(one_off(estimate, fitted + std_error).likelihood_ratio, 1.0, 1e-6);
            assert_eq!(estimate.verdict, Identifiability::Identifiable);
        }
        close(
            one_off(&found[0], SCIPY[0][0] + SCIPY[0][1]).relative_error,
            1.0044031616756472,
            1e-8,
        );
    }

    /// With b̂ beyond the bound a, the ratio is ((v − b̂)² − (a − b̂)²)/SE², which meets t² at b̂ +
    /// √(t² SE² + (a − b̂)²).
    #[test]
    fn a_value_on_its_bound_has_a_bracket_from_there() {
        let (lower, [free, _, _, _, free_high]) = (0.97, SCIPY[1]);
        let found = &fitted(lower)[1];
        assert_eq!((found.fitted, found.verdict), (lower, Identifiability::OnBound));
        let (low, high) = found.interval.unwrap();
        assert_eq!(low.to_bits(), lower.to_bits());
        close(high - free, ((free_high - free).powi(2) + (lower - free).powi(2)).sqrt(), 0.02);
        assert!(found.inflation.is_none() && found.profile[0].value >= lower);
    }

    #[test]
    fn a_profile_that_stays_low_up_to_a_bound_is_flat() {
        let found = &fitted(0.95)[1];
        assert_eq!(found.verdict, Identifiability::Flat);
        assert_eq!(found.interval.unwrap().0.to_bits(), 0.95_f64.to_bits());
        close(found.interval.unwrap().1 - SCIPY[1][0], SCIPY[1][4] - SCIPY[1][0], 1e-3);
    }

    /// Estimate, standard error, degrees of freedom and interval of either column.
    const SCIPY: [[f64; 5]; 2] = [
        [
            2.01103809188346,
            0.00391665044356254,
            3.534853848951035,
            1.999575463550812,
            2.022500720216108,
        ],
        [
            0.960841342525034,
            0.01903117042108361,
            4.956659735515703,
            0.9117912208814738,
            1.009891464168594,
        ],
    ];

    #[test]
    fn the_inverse_over_free_parameters_undoes_the_matrix() {
        let matrix = [[4.0, 2.0, 9.0], [2.0, 9.0, 9.0], [9.0, 9.0, 0.0]];
        let found = inverse(&matrix, &[true, true, false]).unwrap();
        let expect = [[9.0 / 32.0, -2.0 / 32.0, 0.0], [-2.0 / 32.0, 4.0 / 32.0, 0.0], [0.0; 3]];
        for (found, expect) in found.iter().flatten().zip(expect.iter().flatten()) {
            assert!((found - expect).abs() < 1e-15, "{found} instead of {expect}");
        }
        assert_eq!(inverse(&[[1.0, 1.0], [1.0, 1.0]], &[true; 2]), None);
    }
}
