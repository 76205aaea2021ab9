//! How a spring was rendered.

use crate::MetricsError;
use crate::plateau::plateau;
use crate::signals::Signals;
use zwidth_numerics::phases::{Phases, return_begins};
use zwidth_numerics::series::trapezoid;
use zwidth_stats::interval::{Estimate, t_interval};
use zwidth_stats::recording::{RecordingLine, recording_line, recording_mean};
use zwidth_store::{Signal, Values};
use zwidth_study::{Analysis, Spring};

/// How a spring was rendered: F = F₀ + k (θ − θ_rest) up to saturation, a constant force from there
/// on.
///
/// **Samples**: those of the compression (onset → reversal) with θ − θ_rest ≥
/// `analysis.slope_from_rad` and, where there is a wall, θ below it. Where their force saturates (a
/// line that ends in a plateau fits them at least twice as well as a line, the plateau is flat and
/// spans at least 5 % of their angles), the line is fitted to those below the angle of saturation;
/// else to all of them, and the saturation is null: not reached.
///
/// **Intervals** are Newey–West with a tenth of the samples as lags (`zwidth_stats::recording`),
/// because neighbouring samples are alike; Student's t with 9 degrees of freedom at
/// `analysis.confidence`. They speak of this trial alone, and of the division between line and
/// plateau as found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SpringRendering {
    /// Slope k: the rendered stiffness, N/rad.
    pub stiffness_n_per_rad: Option<f64>,
    /// Its standard error, N/rad.
    pub stiffness_std_error_n_per_rad: Option<f64>,
    /// Lower end of its interval, N/rad.
    pub stiffness_ci_low_n_per_rad: Option<f64>,
    /// Upper end of its interval, N/rad.
    pub stiffness_ci_high_n_per_rad: Option<f64>,
    /// Rendered minus commanded stiffness k − K, N/rad.
    pub stiffness_error_n_per_rad: Option<f64>,
    /// F₀: the line's force at the spring's rest, N (friction and preload).
    pub force_at_rest_n: Option<f64>,
    /// R² of the line, over its samples.
    pub r2: Option<f64>,
    /// Samples of the line.
    pub samples: Option<i64>,
    /// Where and at which force the spring saturates; all null if it does not.
    pub saturation: Saturation,
    /// √mean (F_ex − F_cmd)² over the samples of line and plateau, N: the command saturates too.
    /// Null where no commanded force is recorded.
    pub force_rms_error_n: Option<f64>,
    /// F where the lever begins to return, N: at the first sample from the reversal on from which
    /// θ̇ stays below −`analysis.offset_rad_s` until it is below −`analysis.onset_rad_s`, so that
    /// jitter does not count as a return. Null if this never happens before the end.
    pub return_force_n: Option<f64>,
    /// Work the device gives back over work the user puts in: −∫F dθ (reversal → end) / ∫F dθ
    /// (onset → reversal), by the trapezoidal rule, a wall's work included. 1 for an elastic
    /// spring, 0 for a lever that stays where it is; below 0 where the way back takes work
    /// too. Null where the recording stops at the reversal.
    pub returned_energy_share: Option<f64>,
}

/// Where the rendered force stops growing. Intervals as those of [`SpringRendering`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Saturation {
    /// Mean force of the plateau F_s, N.
    pub force_n: Option<f64>,
    /// Lower end of its interval, N.
    pub force_ci_low_n: Option<f64>,
    /// Upper end of its interval, N.
    pub force_ci_high_n: Option<f64>,
    /// θ_s = θ_rest + (F_s − F₀) / k, where the line meets the plateau, rad.
    pub theta_rad: Option<f64>,
    /// Lower end of its interval, rad: by the delta method, the variances of F_s and of the line
    /// at θ_s added and divided by k².
    pub theta_ci_low_rad: Option<f64>,
    /// Upper end of its interval, rad.
    pub theta_ci_high_rad: Option<f64>,
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
    let returned_energy_share = returned_energy(&theta, &force, phases)?;
    drop(force);
    let is_in_fit = theta[phases.onset..=phases.reversal].iter().map(|theta| {
        theta - spring.rest_rad >= analysis.slope_from_rad
            && wall_rad.is_none_or(|wall| *theta < wall)
    });
    let fit = Fit(is_in_fit.collect());
    drop(theta);
    let Analysis { onset_rad_s, offset_rad_s, .. } = *analysis;
    let velocity = signals.theta_dot();
    let begins = velocity.and_then(|v| return_begins(&v, phases, onset_rad_s, offset_rad_s));
    let return_force_n = begins.and_then(|begins| Some(signals.force()?[begins]));
    let force_rms_error_n = fit.rms_error(signals, phases);
    // Each column is given back before the next one is read.
    let u = fit.taken(signals.theta(), phases, |theta| theta - spring.rest_rad);
    signals.forget();
    let f = fit.taken(signals.force(), phases, |force| force);
    signals.forget();
    Ok(SpringRendering {
        force_rms_error_n,
        return_force_n,
        returned_energy_share,
        ..line_and_plateau(&u, &f, spring, analysis.confidence)?
    })
}

/// Which samples of the compression are in the fit.
struct Fit(Vec<bool>);

impl Fit {
    /// Their values.
    fn taken(
        &self,
        values: Option<Values>,
        phases: Phases,
        value: impl Fn(f64) -> f64,
    ) -> Vec<f64> {
        let values = values.as_deref().unwrap_or_default();
        let mut taken = Vec::with_capacity(self.0.iter().filter(|is_in| **is_in).count());
        let is_in =
            self.0.iter().zip(values.iter().skip(phases.onset)).filter(|(is_in, _)| **is_in);
        taken.extend(is_in.map(|(_, v)| value(*v)));
        taken
    }

    /// √mean (F_ex − F_cmd)².
    fn rms_error(&self, signals: &Signals, phases: Phases) -> Option<f64> {
        let force = signals.force()?;
        let commanded = signals.column(Signal::ForceCmd)?;
        let both = force.iter().zip(commanded.iter()).skip(phases.onset);
        let both = self.0.iter().zip(both).filter(|(is_in, _)| **is_in).map(|(_, both)| both);
        let (n, squares) =
            both.fold((0_u64, 0.0), |(n, sum), (a, b)| (n + 1, sum + (a - b) * (a - b)));
        (n > 0).then(|| (squares / n as f64).sqrt())
    }
}

/// The line, and the plateau where there is one.
fn line_and_plateau(
    u: &[f64],
    f: &[f64],
    spring: Spring,
    level: f64,
) -> Result<SpringRendering, MetricsError> {
    let Some(u_s) = plateau(u, f) else {
        return line(u.len(), |i| (u[i], f[i]), spring.stiffness_n_per_rad, level);
    };
    // Of every sample its place, in the order of recording: those of the line, those of the plateau.
    let (below, past): (Vec<u32>, Vec<u32>) =
        (0..u.len() as u32).partition(|i| u[*i as usize] < u_s);
    let sample = |place: u32| (u[place as usize], f[place as usize]);
    let commanded = spring.stiffness_n_per_rad;
    let rendering = line(below.len(), |i| sample(below[i]), commanded, level)?;
    let Some(stiffness) = rendering.stiffness_n_per_rad else { return Ok(rendering) };
    let below = recording_line(below.len(), |i| sample(below[i]), u_s, level)?;
    let flat = recording_mean(past.len(), |i| sample(past[i]).1, level)?;
    let (Some(below), Some(flat)) = (below, flat) else { return Ok(rendering) };
    let saturation = saturation(stiffness, below.value, flat, spring.rest_rad + u_s, level)?;
    Ok(SpringRendering { saturation, ..rendering })
}

/// The saturation from the plateau's mean force and the line's force at θ_s.
fn saturation(
    stiffness: f64,
    line: Estimate,
    flat: Estimate,
    theta_s: f64,
    level: f64,
) -> Result<Saturation, MetricsError> {
    let variance = line.std_error * line.std_error + flat.std_error * flat.std_error;
    let theta = t_interval(theta_s, variance.sqrt() / stiffness.abs(), flat.df, level)?;
    Ok(Saturation {
        force_n: Some(flat.estimate),
        force_ci_low_n: Some(flat.ci_low),
        force_ci_high_n: Some(flat.ci_high),
        theta_rad: Some(theta.estimate),
        theta_ci_low_rad: Some(theta.ci_low),
        theta_ci_high_rad: Some(theta.ci_high),
    })
}

/// The fitted line; all null but the count where the samples cannot show one (too few, or of one
/// angle).
fn line(
    n: usize,
    sample: impl Fn(usize) -> (f64, f64),
    stiffness: f64,
    level: f64,
) -> Result<SpringRendering, MetricsError> {
    let samples = Some(n as i64);
    let Some(RecordingLine { value, slope, r2, .. }) = recording_line(n, sample, 0.0, level)?
    else {
        return Ok(SpringRendering { samples, ..SpringRendering::default() });
    };
    Ok(SpringRendering {
        stiffness_n_per_rad: Some(slope.estimate),
        stiffness_std_error_n_per_rad: Some(slope.std_error),
        stiffness_ci_low_n_per_rad: Some(slope.ci_low),
        stiffness_ci_high_n_per_rad: Some(slope.ci_high),
        stiffness_error_n_per_rad: Some(slope.estimate - stiffness),
        force_at_rest_n: Some(value.estimate),
        r2,
        samples,
        ..SpringRendering::default()
    })
}

/// The lever length cancels, so torque per radian would do as well.
fn returned_energy(
    theta: &[f64],
    force: &[f64],
    phases: Phases,
) -> Result<Option<f64>, MetricsError> {
    let Phases { onset, reversal, end } = phases;
    let put_in = trapezoid(&theta[onset..=reversal], &force[onset..=reversal])?;
    // not a negation: a lever that stays gives back 0, not −0
    let given_back = 0.0 - trapezoid(&theta[reversal..=end], &force[reversal..=end])?;
    // A recording that stops at the reversal says nothing of the way back.
    let goes_on = reversal + 1 < theta.len();
    Ok((put_in > 0.0 && goes_on).then(|| given_back / put_in))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{REST_RAD, at_wall, check, in_spring, stroke, trial};
    use crate::trial_metrics;
    use zwidth_store::{Signal, Trial};

    fn in_trial(trial: &Trial) -> SpringRendering {
        trial_metrics(trial, &in_spring(4.0, REST_RAD)).unwrap().spring
    }

    #[test]
    fn a_line_is_found_with_its_slope_its_offset_and_all_its_energy() {
        let points = stroke(1.0, 2.0);
        let mut trial = trial(&points, |theta, _| 0.3 + 4.2 * (theta - REST_RAD));
        let cmd = points.iter().map(|p| 4.2 * (p.1 - REST_RAD)).collect();
        trial.samples.set(Signal::ForceCmd, cmd);
        let found = in_trial(&trial);
        check(found.stiffness_n_per_rad, 4.2, 1e-12);
        check(found.stiffness_error_n_per_rad, 0.2, 1e-12);
        check(found.force_at_rest_n, 0.3, 1e-12);
        check(found.r2, 1.0, 1e-12);
        check(found.force_rms_error_n, 0.3, 1e-12);
        // the way back is a little longer: it ends at half the onset's velocity
        check(found.returned_energy_share, 1.0, 2e-3);
    }

    /// θ̇ = A ω/2 sin ωt falls through −v at t = π/ω + asin(2v/(Aω))/ω; the force is the time.
    #[test]
    fn the_force_of_the_return_is_that_of_the_moment_at_which_the_lever_goes_back() {
        let (stroke_rad, omega) = (1.0, core::f64::consts::PI);
        let points = stroke(stroke_rad, 2.0);
        let mut trial = trial(&points, |_, _| 0.0);
        trial.samples.set(Signal::ForceEx, points.iter().map(|p| p.0).collect());
        let v = in_spring(4.0, REST_RAD).analysis.offset_rad_s;
        let begins_s = 0.5 + 1.0 + libm::asin(2.0 * v / (stroke_rad * omega)) / omega;
        check(in_trial(&trial).return_force_n, begins_s, 1.1e-3);
    }

    #[test]
    fn a_lever_that_jitters_where_it_stands_does_not_return() {
        let mut points = stroke(1.0, 2.0);
        points.truncate(1501);
        let last = points[1500];
        points.extend(
            (1..500).map(|i| {
                (last.0 + f64::from(i) * 1e-3, last.1, if i % 2 == 0 { -0.1 } else { 0.1 })
            }),
        );
        assert_eq!(in_trial(&trial(&points, |_, _| 1.0)).return_force_n, None);
    }

    /// A motor of 2.08 N on 4 N/rad from −45° on saturates at −15.2°; friction of 0.2 N lies under
    /// both.
    #[test]
    fn a_saturated_spring_keeps_its_slope_and_tells_where_it_saturates() {
        let force = |theta: f64, _: f64| 0.2 + (4.0 * (theta - REST_RAD)).min(2.08);
        let found = in_trial(&trial(&stroke(1.3, 2.0), force));
        check(found.stiffness_n_per_rad, 4.0, 1e-12);
        check(found.force_at_rest_n, 0.2, 1e-12);
        check(found.r2, 1.0, 1e-12);
        check(found.saturation.force_n, 2.28, 1e-12);
        check(found.saturation.theta_rad, REST_RAD + 0.52, 1e-12);
        assert_eq!(format!("{:.1}", found.saturation.theta_rad.unwrap().to_degrees()), "-15.2");
    }

    /// statsmodels and NumPy: `OLS(f, [1, u]).fit(cov_type="HAC", cov_kwds={"maxlags": 7})` below
    /// the division, `OLS(f, [1])` with 4 lags above it, `t.ppf(0.975, 9)`; the angle with the
    /// full covariance gᵀ C g, g = (1, u_s).
    #[test]
    fn slope_plateau_and_angle_have_the_intervals_of_an_independent_program() {
        let u: Vec<f64> = (0..120).map(|i| 1.2 * f64::from(i) / 119.0).collect();
        let noise = |i: u32| f64::from(i * i * 7 % 31) / 62.0;
        let f: Vec<f64> = u.iter().zip(0..).map(|(u, i)| (4.0 * u).min(3.0) + noise(i)).collect();
        let spring = Spring { stiffness_n_per_rad: 4.0, rest_rad: 0.0 };
        let found = line_and_plateau(&u, &f, spring, 0.95).unwrap();
        check(found.stiffness_n_per_rad, 4.00869124642469, 1e-9);
        check(found.stiffness_ci_low_n_per_rad, 3.935046052450864, 1e-9);
        check(found.stiffness_ci_high_n_per_rad, 4.0823364403985165, 1e-9);
        check(found.saturation.force_n, 3.193906810035842, 1e-9);
        check(found.saturation.force_ci_low_n, 3.1675019686132684, 1e-9);
        check(found.saturation.force_ci_high_n, 3.220311651458416, 1e-9);
        check(found.saturation.theta_rad, 0.7497014493464207, 1e-9);
        check(found.saturation.theta_ci_low_rad, 0.7397268070402802, 1e-9);
        check(found.saturation.theta_ci_high_rad, 0.7596760916525612, 1e-9);
        assert_eq!(found.samples, Some(75));
    }

    #[test]
    fn a_spring_that_does_not_saturate_has_no_saturation() {
        let found = in_trial(&trial(&stroke(1.3, 2.0), |theta, _| 4.0 * theta));
        assert_eq!(found.saturation, Saturation::default());
    }

    /// Backward 2.08 N at most: given back 2.08 X − 2.08²/2K of K X²/2.
    #[test]
    fn a_weak_return_gives_back_its_share_of_the_energy() {
        let (k, weak, x) = (4.0, 2.08, 1.2);
        let force = move |theta: f64, velocity: f64| {
            let u = k * (theta - REST_RAD);
            if velocity > 0.0 { u } else { u.min(weak) }
        };
        let found = in_trial(&trial(&stroke(x, 2.0), force));
        let share = (weak * x - weak * weak / (2.0 * k)) / (k * x * x / 2.0);
        check(found.returned_energy_share, share, 2e-3);
    }

    #[test]
    fn a_lever_that_stays_gives_nothing_back_and_one_that_is_cut_off_is_unknown() {
        let way_in: Vec<_> = stroke(1.2, 2.0).into_iter().take_while(|p| p.0 <= 1.5).collect();
        let held = (1..200).map(|i| (1.5 + f64::from(i) / 1000.0, way_in[1500].1, 0.0));
        let stays: Vec<_> = way_in.iter().copied().chain(held).collect();
        let share =
            |points: &[(f64, f64, f64)]| in_trial(&trial(points, |_, _| 1.0)).returned_energy_share;
        assert_eq!(share(&stays).map(f64::to_bits), Some(0.0_f64.to_bits()));
        assert_eq!(share(&way_in[..1300]), None);
    }

    #[test]
    fn samples_past_the_wall_or_short_of_the_limit_are_left_out_of_the_fit() {
        let mut parameters = at_wall(4.0, REST_RAD, REST_RAD + 0.8);
        parameters.analysis.slope_from_rad = 0.2;
        let force = |theta: f64, _: f64| match theta - REST_RAD {
            u if u >= 0.8 => 13.0,
            u if u < 0.2 => 0.0,
            u => 3.5 * u,
        };
        let found = trial_metrics(&trial(&stroke(1.0, 2.0), force), &parameters).unwrap().spring;
        check(found.stiffness_n_per_rad, 3.5, 1e-12);
    }

    #[test]
    fn a_lever_that_stays_short_of_the_limit_has_no_slope_but_a_count_of_zero() {
        let mut parameters = in_spring(4.0, REST_RAD);
        parameters.analysis.slope_from_rad = 2.0;
        let found =
            trial_metrics(&trial(&stroke(1.0, 2.0), |theta, _| theta), &parameters).unwrap().spring;
        assert_eq!((found.stiffness_n_per_rad, found.r2, found.samples), (None, None, Some(0)));
        assert_eq!(found.force_rms_error_n, None);
    }
}
