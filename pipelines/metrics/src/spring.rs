//! How a spring was rendered.

use crate::MetricsError;
use crate::signals::{Phases, Signals};
use zwidth_numerics::series::trapezoid;
use zwidth_numerics::{NumericsError, lsq};
use zwidth_stats::recording::recording_fit;
use zwidth_study::{Analysis, Spring};

/// How a spring was rendered: F = F₀ + k (θ − θ_rest) by least squares over the compression.
///
/// **Samples of the fit**: onset → reversal, with θ − θ_rest ≥ `analysis.slope_from_rad` and, where there is a
/// wall, θ below it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpringRendering {
    /// Slope k: the rendered stiffness, N/rad.
    pub stiffness_n_per_rad: Option<f64>,
    /// Its standard error, N/rad: Newey–West with a tenth of the fit's samples as lags
    /// ([`recording_fit`]), because neighbouring samples are alike. It speaks of this trial alone.
    pub stiffness_std_error_n_per_rad: Option<f64>,
    /// Lower end of its interval at `analysis.confidence`, N/rad (t, 9 degrees of freedom).
    pub stiffness_ci_low_n_per_rad: Option<f64>,
    /// Upper end of its interval, N/rad.
    pub stiffness_ci_high_n_per_rad: Option<f64>,
    /// Rendered minus commanded stiffness k − K, N/rad.
    pub stiffness_error_n_per_rad: Option<f64>,
    /// F₀: the line's force at the spring's rest, N (friction and preload).
    pub force_at_rest_n: Option<f64>,
    /// R² of the line.
    pub r2: Option<f64>,
    /// Samples of the fit.
    pub samples: Option<i64>,
    /// √mean (F_ex − F_cmd)² over the samples of the fit, N. Null where no commanded force is recorded.
    pub force_rms_error_n: Option<f64>,
    /// Work the device gives back over work the user puts in: −∫F dθ (reversal → end) / ∫F dθ (onset →
    /// reversal), by the trapezoidal rule, a wall's work included. 1 for an elastic spring; below 0 where the way back
    /// takes work too.
    pub returned_energy_share: Option<f64>,
}

pub(crate) fn spring_rendering(
    signals: &Signals,
    spring: Spring,
    wall_rad: Option<f64>,
    analysis: &Analysis,
) -> Result<SpringRendering, MetricsError> {
    let Some((theta, force, phases)) = signals.force_over_angle() else {
        return Ok(SpringRendering::default());
    };
    let in_fit = |&i: &usize| {
        let u = theta[i] - spring.rest_rad;
        u >= analysis.slope_from_rad && wall_rad.is_none_or(|wall| theta[i] < wall)
    };
    let samples: Vec<usize> = (phases.onset..=phases.reversal).filter(in_fit).collect();
    let u: Vec<f64> = samples.iter().map(|&i| theta[i] - spring.rest_rad).collect();
    let f: Vec<f64> = samples.iter().map(|&i| force[i]).collect();
    let commanded = signals.force_cmd.map(|cmd| samples.iter().map(|&i| cmd[i]).collect::<Vec<_>>());
    Ok(SpringRendering {
        samples: Some(samples.len() as i64),
        force_rms_error_n: commanded.and_then(|cmd| rms_difference(&f, &cmd)),
        returned_energy_share: returned_energy(theta, force, phases)?,
        ..line(&u, &f, spring.stiffness_n_per_rad, analysis.confidence)?
    })
}

/// The fitted line; all null where the samples cannot show one (too few, or of one angle).
fn line(u: &[f64], f: &[f64], stiffness: f64, level: f64) -> Result<SpringRendering, MetricsError> {
    let ones = vec![1.0; u.len()];
    let columns: [&[f64]; 2] = [&ones, u];
    let fit = match lsq::fit(&columns, f) {
        Err(NumericsError::TooFewRows { .. } | NumericsError::RankDeficient { .. }) => {
            return Ok(SpringRendering::default());
        }
        fit => fit?,
    };
    let intervals = recording_fit(&columns, &fit, level)?;
    let slope = intervals.estimates[1];
    Ok(SpringRendering {
        stiffness_n_per_rad: Some(slope.estimate),
        stiffness_std_error_n_per_rad: Some(slope.std_error),
        stiffness_ci_low_n_per_rad: Some(slope.ci_low),
        stiffness_ci_high_n_per_rad: Some(slope.ci_high),
        stiffness_error_n_per_rad: Some(slope.estimate - stiffness),
        force_at_rest_n: Some(intervals.estimates[0].estimate),
        r2: fit.r2,
        ..SpringRendering::default()
    })
}

fn rms_difference(a: &[f64], b: &[f64]) -> Option<f64> {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    (!a.is_empty()).then(|| (squares / a.len() as f64).sqrt())
}

/// The lever length cancels, so torque per radian would do as well.
fn returned_energy(theta: &[f64], force: &[f64], phases: Phases) -> Result<Option<f64>, MetricsError> {
    let Phases { onset, reversal, end } = phases;
    let put_in = trapezoid(&theta[onset..=reversal], &force[onset..=reversal])?;
    let given_back = -trapezoid(&theta[reversal..=end], &force[reversal..=end])?;
    Ok((put_in > 0.0 && end > reversal).then(|| given_back / put_in))
}

#[cfg(test)]
mod tests {
    use crate::testing::{REST_RAD, spring_study, stroke, trial, wall_study};
    use crate::trial_metrics;
    use zwidth_store::Signal;

    fn check(found: Option<f64>, expect: f64, tolerance: f64) {
        let found = found.unwrap();
        assert!((found - expect).abs() < tolerance, "{found} against {expect}");
    }

    #[test]
    fn a_line_is_found_with_its_slope_its_offset_and_all_its_energy() {
        let points = stroke(1.0, 2.0);
        let mut trial = trial(&points, |theta, _| 0.3 + 4.2 * (theta - REST_RAD));
        let cmd = points.iter().map(|p| 4.2 * (p.1 - REST_RAD)).collect();
        trial.samples.set(Signal::ForceCmd, cmd);
        let found = trial_metrics(&trial, &spring_study(4.0, REST_RAD)).unwrap().spring;
        check(found.stiffness_n_per_rad, 4.2, 1e-12);
        check(found.stiffness_error_n_per_rad, 0.2, 1e-12);
        check(found.force_at_rest_n, 0.3, 1e-12);
        check(found.r2, 1.0, 1e-12);
        check(found.force_rms_error_n, 0.3, 1e-12);
        // the way back is a little longer: it ends at half the onset's velocity
        check(found.returned_energy_share, 1.0, 2e-3);
    }

    /// Backward 2.08 N at most: given back 2.08 X − 2.08²/2K of K X²/2.
    #[test]
    fn a_weak_return_gives_back_its_share_of_the_energy() {
        let (k, weak, x) = (4.0, 2.08, 1.2);
        let force = move |theta: f64, velocity: f64| {
            let u = k * (theta - REST_RAD);
            if velocity > 0.0 { u } else { u.min(weak) }
        };
        let found = trial_metrics(&trial(&stroke(x, 2.0), force), &spring_study(k, REST_RAD)).unwrap().spring;
        let share = (weak * x - weak * weak / (2.0 * k)) / (k * x * x / 2.0);
        check(found.returned_energy_share, share, 2e-3);
    }

    #[test]
    fn samples_past_the_wall_or_short_of_the_limit_are_left_out_of_the_fit() {
        let mut study = wall_study(4.0, REST_RAD, REST_RAD + 0.8);
        study.analysis.slope_from_rad = 0.2;
        let force = |theta: f64, _: f64| match theta - REST_RAD {
            u if u >= 0.8 => 13.0,
            u if u < 0.2 => 0.0,
            u => 3.5 * u,
        };
        let found = trial_metrics(&trial(&stroke(1.0, 2.0), force), &study).unwrap().spring;
        check(found.stiffness_n_per_rad, 3.5, 1e-12);
    }

    #[test]
    fn a_lever_that_stays_short_of_the_limit_has_no_slope_but_a_count_of_zero() {
        let mut study = spring_study(4.0, REST_RAD);
        study.analysis.slope_from_rad = 2.0;
        let found = trial_metrics(&trial(&stroke(1.0, 2.0), |theta, _| theta), &study).unwrap().spring;
        assert_eq!((found.stiffness_n_per_rad, found.r2, found.samples), (None, None, Some(0)));
        assert_eq!(found.force_rms_error_n, None);
    }
}
