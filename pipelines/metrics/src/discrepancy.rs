//! The force discrepancy: compression against decompression (thesis, appendix B).

use crate::MetricsError;
use crate::branch::{Branches, branches};
use crate::signals::Signals;
use zwidth_numerics::lsq;
use zwidth_numerics::phases::Phases;
use zwidth_numerics::series::{loop_area, trapezoid};

/// The step at the reversal is read from the last tenth of the common range of angles: wide enough for the
/// force sensor's held values and the actuators' lag to average out, narrow against a spring's saturation.
const STEP_WINDOW: f64 = 0.1;

/// Fewest points of the grid for a line with a residual.
const MIN_POINTS: usize = 3;

/// Force discrepancy D(θ) = F_compression(θ) − F_decompression(θ) (thesis, appendix B, Fig. 31).
///
/// Each branch is made single-valued by keeping only samples that lie farther along than any before, then
/// interpolated linearly on `analysis.grid_points` even angles over the range both branches cover. All null where that
/// is less than a tenth of the compression's angles: a lever that a brake holds has no decompression, and its path
/// is no loop.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Discrepancy {
    /// Mean of D over the angle, ∫ D dθ / Δθ by the trapezoidal rule, N.
    pub mean_n: Option<f64>,
    /// Largest D, N.
    pub max_n: Option<f64>,
    /// D at the reversal, N: a straight line fitted to D on the last tenth of the common range, evaluated at
    /// the reversal's angle. Evenly spaced angles keep the many samples of the slow turn from outweighing the rest.
    pub step_n: Option<f64>,
    /// ∮ F dx from onset to end, closed by a straight chord, J: the energy the user leaves in the device. From all
    /// samples as recorded, not from the single-valued branches. Null without a lever length.
    pub loop_area_j: Option<f64>,
}

pub(crate) fn discrepancy(signals: &Signals, grid_points: usize) -> Result<Discrepancy, MetricsError> {
    let Some((theta, force, phases)) = signals.force_over_angle() else {
        return Ok(Discrepancy::default());
    };
    let Phases { onset, reversal, end } = phases;
    if reversal == end {
        return Ok(Discrepancy::default());
    }
    let Some(Branches { theta: grid, forward, backward }) = branches(theta, force, phases, grid_points)
    else {
        return Ok(Discrepancy::default());
    };
    let area = loop_area(&theta[onset..=end], &force[onset..=end])?;
    let d: Vec<f64> = forward.iter().zip(&backward).map(|(f, b)| f - b).collect();
    Ok(Discrepancy {
        mean_n: Some(trapezoid(&grid, &d)? / (grid[grid.len() - 1] - grid[0])),
        max_n: d.iter().copied().reduce(f64::max),
        step_n: step(&grid, &d, theta[reversal])?,
        loop_area_j: signals.lever_m.map(|lever_m| lever_m * area),
    })
}

/// The line through D on the last [`STEP_WINDOW`] of the grid, at `reversal_rad`.
fn step(grid: &[f64], d: &[f64], reversal_rad: f64) -> Result<Option<f64>, MetricsError> {
    let (low, high) = (grid[0], grid[grid.len() - 1]);
    let from = grid.partition_point(|&theta| theta < high - STEP_WINDOW * (high - low));
    if grid.len() - from < MIN_POINTS {
        return Ok(None);
    }
    let before: Vec<f64> = grid[from..].iter().map(|theta| theta - reversal_rad).collect();
    let ones = vec![1.0; before.len()];
    Ok(Some(lsq::fit(&[&ones, &before], &d[from..])?.coefficients[0]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{LEVER_M, REST_RAD, spring_study, stroke, trial};
    use crate::trial_metrics;

    /// K = 4 N/rad from rest at −45°.
    const K: f64 = 4.0;

    fn check(found: Option<f64>, expect: f64, tolerance: f64) {
        let found = found.unwrap();
        assert!((found - expect).abs() < tolerance, "{found} against {expect}");
    }

    /// Forward min(K u, strong), backward min(K u, weak), u = θ − θ_rest: half a bow tie.
    fn hybrid(stroke_rad: f64, strong_n: f64, weak_n: f64) -> Discrepancy {
        let force = move |theta: f64, velocity: f64| {
            let limit = if velocity > 0.0 { strong_n } else { weak_n };
            (K * (theta - REST_RAD)).min(limit)
        };
        let trial = trial(&stroke(stroke_rad, 2.0), force);
        trial_metrics(&trial, &spring_study(K, REST_RAD)).unwrap().discrepancy
    }

    /// Thesis §5.3: reversal at 32° from rest at −45° gives 5.38 N by the brake, and 2.08 N by the motor.
    #[test]
    fn the_ideal_hybrid_spring_steps_from_5_38_to_2_08_newton() {
        let stroke_rad = 77_f64.to_radians();
        let found = hybrid(stroke_rad, 13.0, 2.08);
        check(found.step_n, K * stroke_rad - 2.08, 1e-4);
        assert_eq!(format!("{:.2}", found.step_n.unwrap()), "3.30");
        check(found.max_n, K * stroke_rad - 2.08, 1e-3);
        // the triangle above the motor's limit: (K X − F)² / 2K
        let triangle = (K * stroke_rad - 2.08) * (K * stroke_rad - 2.08) / (2.0 * K);
        check(found.loop_area_j, LEVER_M * triangle, 2e-5 * LEVER_M);
        check(found.mean_n, triangle / stroke_rad, 5e-3);
    }

    #[test]
    fn a_spring_that_saturates_both_ways_differs_by_the_two_limits() {
        let found = hybrid(1.5, 4.16, 2.08);
        check(found.step_n, 2.08, 1e-9);
        check(found.max_n, 2.08, 1e-9);
        // K/2 (x₁² − x₀²) − … : the trapezium between the limits
        let (x0, x1) = (2.08 / K, 4.16 / K);
        let area = 2.08 * ((1.5 - x1) + (1.5 - x0)) / 2.0;
        check(found.loop_area_j, LEVER_M * area, 2e-5 * LEVER_M);
    }

    /// Fig. 31: over both sides of the rest the strong actuator resists and the weak one returns.
    #[test]
    fn the_bow_tie_is_the_sum_of_its_two_triangles() {
        let (half, weak_n) = (1.0, 1.0);
        let force = move |theta: f64, velocity: f64| {
            let u = theta - REST_RAD - half;
            if u * velocity > 0.0 { K * u } else { (K * u).clamp(-weak_n, weak_n) }
        };
        let trial = trial(&stroke(2.0 * half, 2.0), force);
        let found = trial_metrics(&trial, &spring_study(K, REST_RAD)).unwrap().discrepancy;
        let triangle = (K * half - weak_n) * (K * half - weak_n) / (2.0 * K);
        // the closing chord cuts the corner left of the onset's angle, where D is at most K
        check(found.loop_area_j, LEVER_M * 2.0 * triangle, LEVER_M * 2e-2);
        check(found.step_n, K * half - weak_n, 1e-3);
        check(found.mean_n, 2.0 * triangle / (2.0 * half), 2e-2);
    }

    /// F = b sin ωt over θ = −a cos ωt encloses π a b.
    #[test]
    fn a_sine_loop_encloses_pi_a_b() {
        let (a, b) = (0.6, 3.0);
        let middle = REST_RAD + a;
        let force = move |theta: f64, velocity: f64| {
            let c = ((theta - middle) / a).clamp(-1.0, 1.0);
            b * (1.0 - c * c).sqrt() * if velocity < 0.0 { -1.0 } else { 1.0 }
        };
        let trial = trial(&stroke(2.0 * a, 2.0), force);
        let found = trial_metrics(&trial, &spring_study(K, REST_RAD)).unwrap().discrepancy;
        let ellipse = core::f64::consts::PI * a * b;
        check(found.loop_area_j, LEVER_M * ellipse, LEVER_M * ellipse * 5e-3);
        check(found.max_n, 2.0 * b, 1e-3);
    }

    #[test]
    fn an_elastic_spring_has_no_discrepancy() {
        let found = hybrid(1.0, 100.0, 100.0);
        check(found.mean_n, 0.0, 1e-12);
        check(found.step_n, 0.0, 1e-12);
        check(found.loop_area_j, 0.0, 1e-12);
    }

    #[test]
    fn a_movement_that_is_cut_at_its_reversal_has_no_discrepancy() {
        let points: Vec<_> = stroke(1.0, 2.0).into_iter().filter(|p| p.0 <= 1.5).collect();
        let trial = trial(&points, |theta, _| K * theta);
        let found = trial_metrics(&trial, &spring_study(K, REST_RAD)).unwrap().discrepancy;
        assert_eq!(found, Discrepancy::default());
    }

    #[test]
    fn without_a_lever_length_there_is_no_energy() {
        let mut study = spring_study(K, REST_RAD);
        study.device.lever_m = None;
        let trial = trial(&stroke(1.0, 2.0), |theta, _| theta);
        let found = trial_metrics(&trial, &study).unwrap().discrepancy;
        assert_eq!(found.loop_area_j, None);
        assert!(found.mean_n.is_some());
    }
}
