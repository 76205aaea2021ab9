//! When the lever moves, how far and how fast.

use crate::MetricsError;
use crate::Parameters;
use crate::compliance::MOVEMENT_SHARE;
use crate::signals::Signals;
use zwidth_numerics::series::ends;
use zwidth_numerics::smoothness::Smoothness;

/// A lever has left a stop when it is farther from it than this share of the angles travelled; less
/// is the angle sensor's jitter.
const RETREAT_SHARE: f64 = 0.01;

/// When the lever moves, how far and how fast. Times are the trial's own `t_s`, to the sample.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Movement {
    /// Last time of the recording − first, s.
    pub recording_s: Option<f64>,
    /// First time with |θ̇| above `analysis.onset_rad_s`, s. Null if never, or without θ̇.
    pub onset_s: Option<f64>,
    /// First time of the largest θ between onset and end, s.
    pub reversal_s: Option<f64>,
    /// First time with |θ̇| below `analysis.offset_rad_s` after |θ̇| last exceeded the onset's
    /// threshold, s. Null if the recording stops before; the decompression then runs to its
    /// last sample.
    pub end_s: Option<f64>,
    /// End − onset, s.
    pub duration_s: Option<f64>,
    /// Largest θ of the whole recording, rad.
    pub theta_max_rad: Option<f64>,
    /// Path length: Σ |θᵢ₊₁ − θᵢ| from onset to end, rad. What the angle sensor trembles by while the
    /// lever is slow counts as way.
    pub path_rad: Option<f64>,
    /// Mean |θ̇| over time, onset to reversal: ∫|θ̇| dt / Δt by the trapezoidal rule, rad/s.
    pub velocity_forward_mean_rad_s: Option<f64>,
    /// Largest |θ̇|, onset to reversal, rad/s.
    pub velocity_forward_peak_rad_s: Option<f64>,
    /// Mean |θ̇| over time, reversal to end, rad/s.
    pub velocity_backward_mean_rad_s: Option<f64>,
    /// Largest |θ̇|, reversal to end, rad/s.
    pub velocity_backward_peak_rad_s: Option<f64>,
    /// Smoothness of the way forward: spectral arc length of |θ̇|, onset to reversal;
    /// dimensionless, below 0, a minimum-jerk movement has −1.40 ([`spectral_arc_length`](zwidth_numerics::smoothness::spectral_arc_length);
    /// Balasubramanian et al. 2015). Null if there are fewer than 20 samples per second, and for a
    /// way of less than 10 % of the angles travelled.
    pub sparc_forward: Option<f64>,
    /// Smoothness of the way back, reversal to end.
    pub sparc_backward: Option<f64>,
    /// How often θ arrives at or below the work space's lower end, from more than 1 % of the
    /// angles travelled away, in the whole recording. A spring that rests at the stop brings
    /// the lever there at the end of every trial.
    pub work_space_hits_low: Option<i64>,
    /// How often θ arrives at or above the work space's upper end, likewise.
    pub work_space_hits_high: Option<i64>,
}

pub(crate) fn movement(
    signals: &Signals,
    parameters: &Parameters,
) -> Result<Movement, MetricsError> {
    let activity = signals.activity;
    let phases = signals.phases;
    let ways = phases.map(|p| [(p.onset, p.reversal), (p.reversal, p.end)]);
    // The angle before the velocity, so that no more than two columns are needed at a time.
    let angles = signals.theta().map(|theta| Angles::of(&theta, ways, parameters));
    let t = signals.t()?;
    let theta_dot = signals.theta_dot();
    let [forward, backward] = ways.map_or([None; 2], |ways| {
        ways.map(|(from, to)| theta_dot.as_ref().map(|v| speed(&t[from..=to], &v[from..=to])))
    });
    let smoothness = [0, 1].map(|way| {
        let (from, to) = ways.filter(|_| angles.is_some_and(|a| a.is_movement[way]))?[way];
        Smoothness::of(&t[from..=to], &theta_dot.as_ref()?[from..=to])
    });
    let recording_s = t.first().zip(t.last()).map(|(first, last)| last - first);
    let onset_s = activity.map(|a| t[a.onset]);
    let end_s = activity.and_then(|a| a.end).map(|i| t[i]);
    let reversal_s = phases.map(|p| t[p.reversal]);
    // Before the spectra, which take memory of their own.
    drop((t, theta_dot));
    signals.forget();
    let [sparc_forward, sparc_backward] =
        smoothness.map(|way| way.and_then(Smoothness::spectral_arc_length));
    Ok(Movement {
        recording_s,
        onset_s,
        reversal_s,
        end_s,
        duration_s: onset_s.zip(end_s).map(|(onset, end)| end - onset),
        theta_max_rad: angles.map(|a| a.most_rad),
        path_rad: angles.and_then(|a| a.path_rad),
        velocity_forward_mean_rad_s: forward.and_then(|s| s.mean),
        velocity_forward_peak_rad_s: forward.map(|s| s.peak),
        velocity_backward_mean_rad_s: backward.and_then(|s| s.mean),
        velocity_backward_peak_rad_s: backward.map(|s| s.peak),
        sparc_forward,
        sparc_backward,
        work_space_hits_low: angles.and_then(|a| a.hits[0]),
        work_space_hits_high: angles.and_then(|a| a.hits[1]),
    })
}

/// The part of the movement that follows from the angle alone.
#[derive(Clone, Copy)]
struct Angles {
    most_rad: f64,
    /// From onset to end.
    path_rad: Option<f64>,
    /// Whether the way forward, and the way back, is long enough to have a shape.
    is_movement: [bool; 2],
    /// Arrivals at the lower and the upper end of the work space.
    hits: [Option<i64>; 2],
}

impl Angles {
    fn of(theta: &[f64], ways: Option<[(usize, usize); 2]>, parameters: &Parameters) -> Self {
        let (least_rad, most_rad) = ends(theta);
        let travelled = most_rad - least_rad;
        let is_movement = ways.map_or([false; 2], |ways| {
            ways.map(|(from, to)| (theta[to] - theta[from]).abs() > MOVEMENT_SHARE * travelled)
        });
        let path_rad = ways.map(|[(onset, _), (_, end)]| {
            theta[onset..=end].windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum()
        });
        let hits = [(parameters.theta_min_rad, -1.0), (parameters.theta_max_rad, 1.0)]
            .map(|(limit, sign)| Some(arrivals(theta, limit?, sign, RETREAT_SHARE * travelled)));
        Self { most_rad, path_rad, is_movement, hits }
    }
}

#[derive(Clone, Copy)]
struct Speed {
    /// `None` for a single sample.
    mean: Option<f64>,
    peak: f64,
}

fn speed(t: &[f64], v: &[f64]) -> Speed {
    let speeds = v.iter().map(|v| v.abs());
    let mean = match t {
        [first, .., last] => {
            let steps = t.windows(2).zip(speeds.clone().zip(speeds.clone().skip(1)));
            // The trapezoidal rule without a copy of all speeds.
            let way = steps.fold(0.0, |sum, (t, (a, b))| sum + (t[1] - t[0]) * (a + b) / 2.0);
            Some(way / (last - first))
        }
        _ => None,
    };
    Speed { mean, peak: speeds.fold(0.0, f64::max) }
}

/// How often sign · θ comes from below sign · limit to it or beyond, after a retreat from it by
/// more than `retreat`.
fn arrivals(theta: &[f64], limit: f64, sign: f64, retreat: f64) -> i64 {
    // A lever that begins at the limit has not arrived there.
    let mut is_there = theta.first().is_some_and(|theta| sign * (theta - limit) >= 0.0);
    let mut count = 0;
    for theta in theta {
        let beyond = sign * (theta - limit);
        if !is_there && beyond >= 0.0 {
            (is_there, count) = (true, count + 1);
        } else if beyond < -retreat {
            is_there = false;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{RATE_HZ, REST_RAD, in_spring, only, stroke, trial};
    use crate::trial_metrics;
    use zwidth_store::{Signal, Trial};

    /// One sample's worth of time.
    const SAMPLE_S: f64 = 1.0 / RATE_HZ;

    fn metrics(trial: &Trial) -> Movement {
        trial_metrics(trial, &in_spring(4.0, REST_RAD)).unwrap().movement
    }

    /// θ = rest + A (1 − cos ωt)/2, θ̇ = A ω/2 sin ωt: the onset is at asin(threshold / (A ω/2)) /
    /// ω.
    #[test]
    fn a_raised_cosine_begins_turns_and_ends_where_its_formula_says() {
        let (stroke_rad, period_s) = (1.2, 2.0);
        let found = metrics(&trial(&stroke(stroke_rad, period_s), |_, _| 0.0));
        let omega = core::f64::consts::TAU / period_s;
        let peak = stroke_rad * omega / 2.0;
        let crossing =
            |threshold_deg_s: f64| libm::asin(threshold_deg_s.to_radians() / peak) / omega;
        // the generator rests half a second before and after the movement
        assert!((found.onset_s.unwrap() - (0.5 + crossing(10.0))).abs() <= SAMPLE_S);
        assert!((found.end_s.unwrap() - (0.5 + period_s - crossing(5.0))).abs() <= SAMPLE_S);
        assert!((found.reversal_s.unwrap() - (0.5 + period_s / 2.0)).abs() <= SAMPLE_S);
        assert!((found.theta_max_rad.unwrap() - (REST_RAD + stroke_rad)).abs() < 1e-12);
        assert!((found.velocity_forward_peak_rad_s.unwrap() - peak).abs() < 1e-5);
        assert!((found.velocity_backward_peak_rad_s.unwrap() - peak).abs() < 1e-5);
        // onset to reversal: the way left to go over the time left
        let onset = found.onset_s.unwrap() - 0.5;
        let way = stroke_rad * (1.0 + libm::cos(omega * onset)) / 2.0;
        let mean = way / (period_s / 2.0 - onset);
        assert!((found.velocity_forward_mean_rad_s.unwrap() / mean - 1.0).abs() < 1e-4);
        assert_eq!(found.duration_s, Some(found.end_s.unwrap() - found.onset_s.unwrap()));
        assert!((found.recording_s.unwrap() - (period_s + 1.0)).abs() <= SAMPLE_S);
        // there and back, less what is left of both ways when the lever is slow
        let left = stroke_rad * (1.0 - libm::cos(omega * onset)) / 2.0;
        let end = found.end_s.unwrap() - 0.5;
        let left = left + stroke_rad * (1.0 - libm::cos(omega * end)) / 2.0;
        assert!((found.path_rad.unwrap() - (2.0 * stroke_rad - left)).abs() < 1e-4);
    }

    /// A minimum-jerk way there and back, and one with a halt on the way: NumPy from the paper's
    /// equations gives −1.4024 for a whole minimum-jerk way; onset and end cut off its slowest
    /// parts.
    #[test]
    fn a_halting_movement_is_less_smooth_than_a_minimum_jerk_one() {
        let speed = |s: f64| 30.0 * s * s * (1.0 - s) * (1.0 - s);
        let way = |s: f64| s * s * s * (10.0 + s * (6.0 * s - 15.0));
        let point = |i: u32| {
            let (t, leg) = (f64::from(i) / RATE_HZ, f64::from(i % 1000) / RATE_HZ);
            if i < 1000 { (t, way(leg), speed(leg)) } else { (t, 1.0 - way(leg), -speed(leg)) }
        };
        let points: Vec<_> = (0..2000).map(point).collect();
        let smooth = metrics(&trial(&points, |_, _| 0.0));
        assert!((smooth.sparc_forward.unwrap() + 1.4024).abs() < 0.02, "{smooth:?}");
        assert!((smooth.sparc_backward.unwrap() + 1.4024).abs() < 0.02, "{smooth:?}");
        let halting: Vec<_> = points
            .iter()
            .map(|p| (p.0, p.1, p.2 * libm::sin(9.0 * p.0) * libm::sin(9.0 * p.0)))
            .collect();
        let halting = metrics(&trial(&halting, |_, _| 0.0));
        assert!(halting.sparc_forward.unwrap() < -1.8, "{halting:?}");
    }

    #[test]
    fn a_recording_that_stops_in_mid_movement_has_no_end() {
        let points: Vec<_> = stroke(1.2, 2.0).into_iter().filter(|p| p.0 < 2.0).collect();
        let found = metrics(&trial(&points, |_, _| 0.0));
        assert_eq!((found.end_s, found.duration_s), (None, None));
        assert!((1.2..2.4).contains(&found.path_rad.unwrap()), "{found:?}");
        assert!(found.velocity_backward_mean_rad_s.is_some());
    }

    #[test]
    fn a_lever_that_does_not_move_has_an_angle_and_no_movement() {
        let found = metrics(&trial(&[(0.0, 0.1, 0.0), (0.1, 0.1, 0.01)], |_, _| 0.0));
        assert_eq!(found.theta_max_rad, Some(0.1));
        assert_eq!(
            (found.onset_s, found.path_rad, found.velocity_forward_mean_rad_s),
            (None, None, None)
        );
    }

    #[test]
    fn without_a_velocity_the_recording_stands_in_for_the_movement() {
        let trial = trial(&stroke(1.2, 2.0), |_, _| 0.0);
        let found = metrics(&only(&trial, [Signal::Time, Signal::Theta]));
        assert_eq!((found.onset_s, found.velocity_forward_peak_rad_s), (None, None));
        assert!(found.reversal_s.is_some());
    }

    #[test]
    fn a_stop_is_hit_when_the_lever_arrives_not_while_it_stays_or_leaves() {
        let mut parameters = in_spring(4.0, 0.0);
        (parameters.theta_min_rad, parameters.theta_max_rad) = (Some(0.0), Some(1.0));
        let angles = [0.0, 0.001, 0.0, 0.5, 1.0, 1.0, 0.999, 1.0, 0.9, 1.1, 0.5, 0.0, 0.001, 0.0];
        let points: Vec<_> = (0..).zip(angles).map(|(i, a)| (f64::from(i), a, 0.0)).collect();
        let found = trial_metrics(&trial(&points, |_, _| 0.0), &parameters).unwrap().movement;
        assert_eq!((found.work_space_hits_low, found.work_space_hits_high), (Some(1), Some(2)));
    }
}
