//! How the angle follows a step of its reference.

use crate::signals::Signals;
use serde::Serialize;
use zwidth_numerics::series::ends;
use zwidth_study::REFERENCE;

/// A step of the reference is at least this share of the reference's whole range, so that ripple of
/// a recorded set-point is none.
const STEP: f64 = 0.5;
/// The reference has changed again where it is off its new value by more than this share of the
/// step.
const CHANGED: f64 = 0.01;
/// The last share of the time until the reference changes again, or until the end: its mean is where
/// the angle comes to rest.
const LAST: f64 = 0.1;
/// The angle has settled where it stays within this share of its change.
const SETTLED: f64 = 0.02;
/// Fewest samples from the step on.
const LEAST_SAMPLES: usize = 20;

/// The response of the angle to the first step of its reference
/// ([`REFERENCE`](zwidth_study::REFERENCE)): a change from one sample to the next by at least half of
/// the reference's range. It is evaluated until the reference changes again, or until the recording
/// ends.
///
/// θ₀ is the angle at the step, θ_f its mean over the last tenth of that time. Rise, overshoot and
/// settling are those of θ between θ₀ and θ_f, so that a steady error does not affect them (Ogata,
/// Modern Control Engineering, 5th ed. 2010). Straight lines between samples.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct StepResponse {
    /// The step of the reference, rad.
    pub step_rad: Option<f64>,
    /// From 10 % to 90 % of the way from θ₀ to θ_f, s.
    pub rise_s: Option<f64>,
    /// How far θ goes beyond θ_f, divided by |θ_f − θ₀|; 0 if it does not.
    pub overshoot_share: Option<f64>,
    /// From the step until θ stays within 2 % of |θ_f − θ₀| of θ_f, s.
    pub settling_s: Option<f64>,
    /// The reference minus θ_f, rad.
    pub steady_error_rad: Option<f64>,
}

pub(crate) fn step_response(signals: &Signals) -> StepResponse {
    response(signals).unwrap_or_default()
}

fn response(signals: &Signals) -> Option<StepResponse> {
    let reference = signals.channel(REFERENCE)?;
    let theta = signals.theta()?;
    let t = signals.t().ok()?;
    let at = step(&reference)?;
    let from = reference[at - 1];
    let to = reference[at];
    let changed = reference[at..].iter().position(|r| (r - to).abs() > CHANGED * (to - from).abs());
    let end = changed.map_or(t.len(), |n| at + n);
    if end - at < LEAST_SAMPLES {
        return None;
    }
    let step_rad = Some(to - from);
    let t = &t[at..end];
    let theta = &theta[at..end];
    // By time, not by count: samples need not be evenly spaced.
    let last_s = t[t.len() - 1] - LAST * (t[t.len() - 1] - t[0]);
    let last = &theta[t.partition_point(|t| *t < last_s)..];
    let rest = last.iter().sum::<f64>() / last.len() as f64;
    let steady_error_rad = Some(to - rest);
    let way = rest - theta[0];
    // An angle that does not follow has no way to take shares of.
    if way.abs() < CHANGED * (to - from).abs() {
        return Some(StepResponse { step_rad, steady_error_rad, ..StepResponse::default() });
    }
    // 0 at the step, 1 where it comes to rest.
    let share: Vec<f64> = theta.iter().map(|theta| (theta - rest) / way + 1.0).collect();
    let most = share.iter().copied().fold(1.0, f64::max);
    let rise = first_at(t, &share, 0.1).zip(first_at(t, &share, 0.9));
    Some(StepResponse {
        step_rad,
        rise_s: rise.map(|(begin, end)| end - begin),
        overshoot_share: Some(most - 1.0),
        settling_s: Some(settled_at(t, &share) - t[0]),
        steady_error_rad,
    })
}

/// The first sample with the new value of the first step.
fn step(reference: &[f64]) -> Option<usize> {
    let (low, high) = ends(reference);
    let least = STEP * (high - low);
    reference.windows(2).position(|w| least > 0.0 && (w[1] - w[0]).abs() >= least).map(|i| i + 1)
}

/// When a share of the way is first reached.
fn first_at(t: &[f64], share: &[f64], level: f64) -> Option<f64> {
    let after = share.iter().position(|share| *share >= level)?;
    Some(if after == 0 { t[0] } else { crossing(t, share, after, level) })
}

/// From when on the share stays close to 1.
fn settled_at(t: &[f64], share: &[f64]) -> f64 {
    match share.iter().rposition(|share| (share - 1.0).abs() > SETTLED) {
        None => t[0],
        Some(last) if last + 1 == t.len() => t[last],
        Some(last) => {
            let side = if share[last] > 1.0 { 1.0 + SETTLED } else { 1.0 - SETTLED };
            crossing(t, share, last + 1, side)
        }
    }
}

/// When the line from the sample before `after` to that one is at `level`.
fn crossing(t: &[f64], share: &[f64], after: usize, level: f64) -> f64 {
    let before = share[after - 1];
    let step = share[after] - share[after - 1];
    t[after - 1] + (level - before) / step * (t[after] - t[after - 1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{check, in_spring, trial};
    use crate::trial_metrics;
    use libm::{cos, exp, log, sin, sqrt};
    use zwidth_study::REFERENCE;

    /// Half a second at 0.1 rad, then 4 s to the next set-point; `y` is 0 at first and 1 at rest.
    fn respond(step_rad: f64, stays_short_by: f64, y: impl Fn(f64) -> f64) -> StepResponse {
        let time = |i: u32| f64::from(i) * 1e-3;
        let reference = |t: f64| if t < 0.5 { 0.1 } else { 0.1 + step_rad };
        let theta = |t: f64| 0.1 + (step_rad - stays_short_by) * y((t - 0.5).max(0.0));
        let points: Vec<_> = (0..4500).map(time).map(|t| (t, theta(t), 0.0)).collect();
        let mut made = trial(&points, |_, _| 0.0);
        let values = points.iter().map(|p| reference(p.0)).collect();
        made.samples.set_channel(REFERENCE.parse().unwrap(), values);
        trial_metrics(&made, &in_spring(4.0, 0.0)).unwrap().step
    }

    /// 1 − e^(−t/τ): rise τ ln 9, settling τ ln 50, no overshoot.
    #[test]
    fn a_first_order_lag_has_its_closed_form() {
        let tau = 0.08;
        for (step_rad, short) in [(0.5, 0.0), (-0.5, 0.0), (0.5, 0.05)] {
            let found = respond(step_rad, short, |t| 1.0 - exp(-t / tau));
            check(found.step_rad, step_rad, 1e-12);
            check(found.rise_s, tau * log(9.0), 1e-5);
            check(found.settling_s, tau * log(50.0), 1e-4);
            check(found.overshoot_share, 0.0, 1e-12);
            check(found.steady_error_rad, short, 1e-12);
        }
    }

    /// ζ = 0.3: an overshoot of e^(−πζ/√(1−ζ²)).
    #[test]
    fn an_underdamped_second_order_has_its_overshoot() {
        let (zeta, omega) = (0.3, 20.0);
        let damped = omega * sqrt(1.0 - zeta * zeta);
        let y = |t: f64| {
            1.0 - exp(-zeta * omega * t)
                * (cos(damped * t) + zeta * omega / damped * sin(damped * t))
        };
        let found = respond(0.4, 0.0, y);
        let expect = exp(-core::f64::consts::PI * zeta / sqrt(1.0 - zeta * zeta));
        check(found.overshoot_share, expect, 1e-5);
        // The envelope bounds when it settles.
        assert!(found.settling_s.unwrap() < -log(0.02 * sqrt(1.0 - zeta * zeta)) / (zeta * omega));
    }

    #[test]
    fn where_nothing_follows_only_the_error_is_told_and_without_a_step_nothing() {
        let found = respond(0.4, 0.4, |_| 0.0);
        check(found.steady_error_rad, 0.4, 1e-12);
        assert_eq!((found.rise_s, found.overshoot_share, found.settling_s), (None, None, None));
        assert_eq!(respond(0.0, 0.0, |_| 0.0), StepResponse::default());
    }
}
