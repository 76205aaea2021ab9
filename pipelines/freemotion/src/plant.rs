//! The plant fitted to one recording with an angle.

use crate::FreeMotionError;
use crate::Parameters;
use crate::average::{HALF_S, average, stretch};
use crate::fit::{recorded, sample_interval_s, torque};
use zwidth_numerics::lsq;
use zwidth_results::FreePlant;
use zwidth_stats::recording::recording_fit;
use zwidth_store::{Signal, Trial};

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
///
/// The torque is the recorded one, or L F_ex where a force and a lever length are there instead.
///
/// # Errors
/// A signal that is not recorded; no stretch that slips, or too few; movements too alike to tell
/// the five apart.
pub fn plant_fit(trial: &Trial, parameters: &Parameters) -> Result<FreePlant, FreeMotionError> {
    let t = recorded(&trial.samples, Signal::Time, NEEDS)?;
    let theta = recorded(&trial.samples, Signal::Theta, NEEDS)?;
    let velocity = recorded(&trial.samples, Signal::ThetaDot, NEEDS)?;
    let torque = torque(&trial.samples, parameters.lever_m)?;
    let mut columns: [Vec<f64>; TERMS.len()] = Default::default();
    let mut torques = Vec::new();
    for stretch in (0..t.len()).filter_map(|centre| stretch(t, centre)) {
        let inside = stretch.first..stretch.first + stretch.weights.len();
        let [theta, velocity, torque] = [theta, velocity, &torque[..]].map(|y| &y[inside.clone()]);
        let sign = velocity[0].signum();
        // Dry friction turns with the velocity: over a change of sign it has no one value.
        if velocity.iter().all(|v| sign * v >= parameters.onset_rad_s) {
            let terms = [
                1.0,
                average(&stretch.curvature, theta),
                average(&stretch.slope, theta),
                sign,
                average(&stretch.weights, theta),
            ];
            columns.iter_mut().zip(terms).for_each(|(column, term)| column.push(term));
            torques.push(average(&stretch.weights, torque));
        }
    }
    if torques.is_empty() {
        return Err(FreeMotionError::no_slip(2.0 * HALF_S, parameters));
    }
    let columns = columns.each_ref().map(Vec::as_slice);
    let fit = lsq::fit(&columns, &torques).map_err(|e| FreeMotionError::of_terms(e, &TERMS))?;
    let intervals = recording_fit(&columns, &fit, parameters.confidence)?;
    let [offset, inertia, damping, friction, stiffness] =
        [0, 1, 2, 3, 4].map(|j| intervals.estimates[j]);
    let meta = trial.meta.clone();
    Ok(FreePlant {
        participant: meta.participant,
        session: meta.session,
        trial: meta.trial,
        repeat: meta.repeat,
        environment: meta.environment,
        mode: meta.mode,
        source: meta.source,
        offset_nm: offset.estimate,
        offset_std_error_nm: offset.std_error,
        offset_ci_low_nm: offset.ci_low,
        offset_ci_high_nm: offset.ci_high,
        inertia_kg_m2: inertia.estimate,
        inertia_std_error_kg_m2: inertia.std_error,
        inertia_ci_low_kg_m2: inertia.ci_low,
        inertia_ci_high_kg_m2: inertia.ci_high,
        damping_nm_s_per_rad: damping.estimate,
        damping_std_error_nm_s_per_rad: damping.std_error,
        damping_ci_low_nm_s_per_rad: damping.ci_low,
        damping_ci_high_nm_s_per_rad: damping.ci_high,
        friction_nm: friction.estimate,
        friction_std_error_nm: friction.std_error,
        friction_ci_low_nm: friction.ci_low,
        friction_ci_high_nm: friction.ci_high,
        stiffness_nm_per_rad: stiffness.estimate,
        stiffness_std_error_nm_per_rad: stiffness.std_error,
        stiffness_ci_low_nm_per_rad: stiffness.ci_low,
        stiffness_ci_high_nm_per_rad: stiffness.ci_high,
        r2: fit.r2,
        rms_nm: (fit.rss / torques.len() as f64).sqrt(),
        samples: torques.len(),
        lags: intervals.lags,
        bandwidth_s: intervals.lags as f64 * sample_interval_s(t),
    })
}

/// The terms of the fit, in the order of its columns.
const TERMS: [&str; 5] = ["the offset", "inertia", "damping", "friction", "stiffness"];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::tests::{parameters, trial};
    use crate::plant_table;

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

    fn check(step_rad: f64, relative: f64) {
        let fit = plant_fit(&recording(step_rad), &parameters()).unwrap();
        let found = [
            fit.offset_nm,
            fit.inertia_kg_m2,
            fit.damping_nm_s_per_rad,
            fit.friction_nm,
            fit.stiffness_nm_per_rad,
        ];
        for (found, expect) in found.iter().zip(PLANT) {
            assert!((found / expect - 1.0).abs() < relative, "{found} {expect}");
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

    #[test]
    fn a_coefficient_whose_interval_holds_zero_is_said_to_be_unseen() {
        let fit = FreePlant {
            inertia_ci_low_kg_m2: -3.0,
            inertia_ci_high_kg_m2: 1.0,
            ..plant_fit(&recording(0.0), &parameters()).unwrap()
        };
        let table = plant_table(std::slice::from_ref(&fit)).unwrap();
        assert_eq!(table.to_rows::<FreePlant>().unwrap(), [fit]);
        let notes = table.notes().to_vec();
        assert_eq!(notes.len(), 1);
        assert!(
            notes[0].starts_with("The inertia I is not identified: its interval"),
            "{}",
            notes[0]
        );
    }
}
