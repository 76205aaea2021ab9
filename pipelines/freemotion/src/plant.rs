//! The plant fitted to one recording with an angle.

use crate::FreeMotionError;
use crate::Parameters;
use crate::average::{HALF_S, Stretch, average, stretch};
use crate::fit::{recorded, sample_interval_s, torque};
use zwidth_numerics::lsq;
use zwidth_stats::interval::Estimate;
use zwidth_stats::recording::recording_fit;
use zwidth_store::{Signal, Trial};
use zwidth_study::TrialMeta;

/// What a plant fit needs, in words.
const NEEDS: &str = "a plant fit needs torque, angle and velocity";

/// τ = c + I θ̈ + b θ̇ + τ_c sgn θ̇ + κ θ for one recording, from its angle: θ̈ is never formed.
///
/// Each side is averaged over stretches of 0.2 s with weights φ that vanish with their derivatives
/// at both ends: ∫φ τ = c ∫φ + I ∫φ'' θ − b ∫φ' θ + τ_c sgn θ̇ ∫φ + κ ∫φ θ. Differentiating the
/// angle sensor's steps twice would pull I towards 0; here the steps average out, and torque and
/// angle pass through the same weights, so neither lags behind the other. A stretch counts if |θ̇|
/// ≥ `analysis.onset_rad_s` with one sign at every sample: while the device sticks, dry friction
/// takes any value. There is one stretch per sample, and least squares over all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantFit {
    /// Which trial.
    pub meta: TrialMeta,
    /// c, N·m: what the drive is off by.
    pub offset_nm: Estimate,
    /// I, kg·m².
    pub inertia_kg_m2: Estimate,
    /// b, N·m·s/rad.
    pub damping_nm_s_per_rad: Estimate,
    /// τ_c, N·m: dry friction while slipping.
    pub friction_nm: Estimate,
    /// κ, N·m/rad: what pulls back to θ = 0 (weight, cables).
    pub stiffness_nm_per_rad: Estimate,
    /// R² of the fit.
    pub r2: Option<f64>,
    /// √mean residual² of the averages, N·m.
    pub rms_nm: f64,
    /// Stretches, one about each sample that has one.
    pub samples: usize,
    /// Lags of the covariance, stretches.
    pub lags: usize,
    /// The same in time, lags × the mean sample interval, s.
    pub bandwidth_s: f64,
}

/// The plant through `trial`'s slipping stretches; the torque is the recorded one, or L F_ex where
/// a force and a lever length are there instead.
///
/// # Errors
/// A signal that is not recorded; no stretch that slips, or too few; movements too alike to tell
/// the five apart.
pub fn plant_fit(trial: &Trial, parameters: &Parameters) -> Result<PlantFit, FreeMotionError> {
    let t = recorded(&trial.samples, Signal::Time, NEEDS)?;
    let theta = recorded(&trial.samples, Signal::Theta, NEEDS)?;
    let velocity = recorded(&trial.samples, Signal::ThetaDot, NEEDS)?;
    let torque = torque(&trial.samples, parameters.lever_m)?;
    let least_rad_s = parameters.onset_rad_s;
    let rows: Vec<StretchMeans> = (0..t.len())
        .filter_map(|centre| row(&stretch(t, centre)?, [theta, velocity, &torque], least_rad_s))
        .collect();
    if rows.is_empty() {
        return Err(FreeMotionError::no_slip(2.0 * HALF_S, parameters));
    }
    // In the order of `TERMS`.
    let terms: [fn(&StretchMeans) -> f64; 5] =
        [|_| 1.0, |r| r.acceleration, |r| r.velocity, |r| r.sign, |r| r.angle];
    let columns = terms.map(|term| rows.iter().map(term).collect::<Vec<f64>>());
    let columns: [&[f64]; 5] = columns.each_ref().map(Vec::as_slice);
    let torque: Vec<f64> = rows.iter().map(|r| r.torque).collect();
    let fit = lsq::fit(&columns, &torque).map_err(|e| FreeMotionError::of_terms(e, &TERMS))?;
    let intervals = recording_fit(&columns, &fit, parameters.confidence)?;
    Ok(PlantFit {
        meta: trial.meta.clone(),
        offset_nm: intervals.estimates[0],
        inertia_kg_m2: intervals.estimates[1],
        damping_nm_s_per_rad: intervals.estimates[2],
        friction_nm: intervals.estimates[3],
        stiffness_nm_per_rad: intervals.estimates[4],
        r2: fit.r2,
        rms_nm: (fit.rss / rows.len() as f64).sqrt(),
        samples: rows.len(),
        lags: intervals.lags,
        bandwidth_s: intervals.lags as f64 * sample_interval_s(t),
    })
}

/// The terms of the fit, in the order of its columns.
const TERMS: [&str; 5] = ["the offset", "inertia", "damping", "friction", "stiffness"];

/// The averages over one stretch.
struct StretchMeans {
    torque: f64,
    acceleration: f64,
    velocity: f64,
    sign: f64,
    angle: f64,
}

/// The averages of `[θ, θ̇, τ]` over `stretch`; `None` unless it slips one way throughout.
fn row(
    stretch: &Stretch,
    [theta, velocity, torque]: [&[f64]; 3],
    least_rad_s: f64,
) -> Option<StretchMeans> {
    let inside = stretch.first..stretch.first + stretch.weights.len();
    let [theta, velocity, torque] = [theta, velocity, torque].map(|y| &y[inside.clone()]);
    let sign = velocity[0].signum();
    // Dry friction turns with the velocity: over a change of sign it has no one value.
    let slips = velocity.iter().all(|v| sign * v >= least_rad_s);
    slips.then(|| StretchMeans {
        torque: average(&stretch.weights, torque),
        acceleration: average(&stretch.curvature, theta),
        velocity: average(&stretch.slope, theta),
        sign,
        angle: average(&stretch.weights, theta),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::tests::{parameters, trial};

    /// c, I, b, τ_c, κ.
    const PLANT: [f64; 5] = [2e-4, 3e-5, 2e-4, 6e-4, 1.3e-3];

    /// Two sines, 200 Hz, 20 s: θ = 0.4 sin 3t + 0.15 sin 11t.
    fn motion() -> [Vec<f64>; 4] {
        let t: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.005).collect();
        let of = |f: fn(f64) -> f64| t.iter().map(|t| f(*t)).collect();
        let theta = of(|t| 0.4 * (3.0 * t).sin() + 0.15 * (11.0 * t).sin());
        let velocity = of(|t| 1.2 * (3.0 * t).cos() + 1.65 * (11.0 * t).cos());
        let acceleration = of(|t| -3.6 * (3.0 * t).sin() - 18.15 * (11.0 * t).sin());
        [t, theta, velocity, acceleration]
    }

    fn recording(step_rad: f64) -> Trial {
        let [t, theta, velocity, acceleration] = motion();
        let [c, i, b, friction, k] = PLANT;
        let torque = (0..t.len())
            .map(|n| {
                c + i * acceleration[n]
                    + b * velocity[n]
                    + friction * velocity[n].signum()
                    + k * theta[n]
            })
            .collect();
        let stepped = |y: &f64| if step_rad > 0.0 { (y / step_rad).round() * step_rad } else { *y };
        trial([
            (Signal::Time, t),
            (Signal::Theta, theta.iter().map(stepped).collect()),
            (Signal::ThetaDot, velocity),
            (Signal::TorqueEx, torque),
        ])
    }

    fn found(fit: &PlantFit) -> [Estimate; 5] {
        [
            fit.offset_nm,
            fit.inertia_kg_m2,
            fit.damping_nm_s_per_rad,
            fit.friction_nm,
            fit.stiffness_nm_per_rad,
        ]
    }

    fn check(step_rad: f64, relative: f64) {
        let fit = plant_fit(&recording(step_rad), &parameters()).unwrap();
        for (found, expect) in found(&fit).iter().zip(PLANT) {
            assert!((found.estimate / expect - 1.0).abs() < relative, "{found:?} {expect}");
        }
    }

    #[test]
    fn all_five_are_recovered_from_an_exact_angle() {
        check(0.0, 5e-4);
    }

    /// The same angle through a sensor of 4,096 counts a turn: differentiated twice, its steps
    /// would be 60 rad/s² high.
    #[test]
    fn the_steps_of_a_sensor_leave_the_inertia_within_two_percent() {
        check(core::f64::consts::TAU / 4096.0, 0.02);
    }

    #[test]
    fn a_device_that_never_slips_is_refused_in_words() {
        let mut still = recording(0.0);
        still.samples.set(Signal::ThetaDot, vec![0.01; 4000]);
        let error = plant_fit(&still, &parameters()).unwrap_err().to_string();
        let expect =
            "no stretch of 0.2 s in which the speed stays above 10\u{a0}°/s (analysis.onset_deg_s)";
        assert!(error.starts_with(expect), "{error}");
        let mut one_way = recording(0.0);
        let there = one_way.samples.get(Signal::ThetaDot).unwrap().iter().map(|v| v.abs());
        let there = there.collect();
        one_way.samples.set(Signal::ThetaDot, there);
        let error = plant_fit(&one_way, &parameters()).unwrap_err().to_string();
        assert!(error.starts_with("the motion cannot tell friction from"), "{error}");
        assert!(error.contains("because it goes one way only"), "{error}");
    }

    #[test]
    fn a_recording_without_an_angle_is_refused_by_name() {
        let [t, _, velocity, acceleration] = motion();
        let without = trial([
            (Signal::Time, t),
            (Signal::ThetaDdot, acceleration),
            (Signal::ThetaDot, velocity.clone()),
            (Signal::TorqueEx, velocity),
        ]);
        let error = plant_fit(&without, &parameters()).unwrap_err().to_string();
        assert!(error.contains("no theta_rad was recorded"), "{error}");
    }
}
