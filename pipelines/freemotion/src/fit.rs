//! The plane fitted to one recording.

use serde::Serialize;
use zwidth_numerics::{NumericsError, lsq};
use zwidth_results::FreePlane;
use zwidth_stats::StatsError;
use zwidth_stats::recording::recording_fit;
use zwidth_store::{Samples, Signal, Trial};
use zwidth_study::{Analysis, Coordinate, Study};
use zwidth_tables::given;

/// Why a trial has no plane fit.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FreeMotionError {
    /// Its recording does not give one: what is missing, and what to do.
    #[error("{0}")]
    Refused(String),
    /// The fit was refused: too few samples.
    #[error(transparent)]
    Numerics(NumericsError),
    /// A statistic was refused.
    #[error(transparent)]
    Stats(#[from] StatsError),
}

/// What a plane fit needs, in words.
const NEEDS: &str = "a plane fit needs torque, acceleration and velocity";

/// A signal, or the error that names it.
pub(crate) fn recorded<'a>(
    samples: &'a Samples,
    signal: Signal,
    needs: &'static str,
) -> Result<&'a [f64], FreeMotionError> {
    samples.get(signal).ok_or_else(|| {
        FreeMotionError::Refused(format!("no {} was recorded: {needs}", signal.name()))
    })
}

/// Everything that the fits of a trial depend on besides the trial.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parameters {
    /// Lever length L, m: makes a torque of a force.
    pub lever_m: Option<f64>,
    /// Movement is faster than this, rad/s.
    pub onset_rad_s: f64,
    /// Level of every interval, as a fraction.
    pub confidence: f64,
    /// In which units people read angles.
    pub coordinate: Coordinate,
}

impl Parameters {
    /// The parameters that a study sets.
    pub fn of(study: &Study) -> Self {
        let Analysis { onset_rad_s, confidence, .. } = study.analysis;
        let lever_m = study.device.lever_m;
        let coordinate = study.coordinate;
        Self { lever_m, onset_rad_s, confidence, coordinate }
    }
}

impl FreeMotionError {
    /// There is no movement above the study's onset.
    pub(crate) fn no_slip(needed_s: f64, parameters: &Parameters) -> Self {
        let key = match parameters.coordinate {
            Coordinate::Rotational => "analysis.onset_deg_s",
            Coordinate::Linear { .. } => "analysis.onset_mm_s",
        };
        let least = given(parameters.onset_rad_s, "rad/s", parameters.coordinate);
        Self::Refused(format!(
            "no stretch of {needed_s} s in which the speed stays above {least} ({key}): nothing slips for long enough to tell \
             friction from inertia"
        ))
    }

    /// Why a fit of these terms was refused: a column that is a combination of those before it is
    /// named by its term.
    pub(crate) fn of_terms(error: NumericsError, terms: &[&str]) -> Self {
        match error {
            NumericsError::RankDeficient { column } if column < terms.len() => {
                let term = terms[column];
                let because =
                    if term == "friction" { ", because it goes one way only" } else { "" };
                Self::Refused(format!(
                    "the motion cannot tell {term} from the terms before it{because}: record a motion that does, or leave the trial out"
                ))
            }
            other => Self::Numerics(other),
        }
    }
}

/// The plane τ = c + I θ̈ + b θ̇ through `trial`'s samples; the torque is the recorded one, or L
/// F_ex where a force and a lever length are there instead.
///
/// # Errors
/// A signal that is not recorded; too few samples; an acceleration or velocity that does not vary,
/// or that are proportional to each other.
pub fn plane_fit(trial: &Trial, parameters: &Parameters) -> Result<FreePlane, FreeMotionError> {
    let torque = torque(&trial.samples, parameters.lever_m)?;
    let ones = vec![1.0; torque.len()];
    // In the order of the names below: a column that depends on those before it is named by its place.
    let columns = [
        &ones[..],
        recorded(&trial.samples, Signal::ThetaDdot, NEEDS)?,
        recorded(&trial.samples, Signal::ThetaDot, NEEDS)?,
    ];
    let fit = lsq::fit(&columns, &torque)
        .map_err(|e| FreeMotionError::of_terms(e, &["the offset", "inertia", "damping"]))?;
    let intervals = recording_fit(&columns, &fit, parameters.confidence)?;
    let [offset, inertia, damping] = [0, 1, 2].map(|j| intervals.estimates[j]);
    let t = recorded(&trial.samples, Signal::Time, NEEDS)?;
    let meta = trial.meta.clone();
    Ok(FreePlane {
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
        r2: fit.r2,
        rms_nm: (fit.rss / torque.len() as f64).sqrt(),
        samples: torque.len(),
        lags: intervals.lags,
        bandwidth_s: intervals.lags as f64 * sample_interval_s(t),
    })
}

/// The recorded torque, or L F_ex, N·m.
pub(crate) fn torque(samples: &Samples, lever_m: Option<f64>) -> Result<Vec<f64>, FreeMotionError> {
    if let Some(torque) = samples.get(Signal::TorqueEx) {
        return Ok(torque.to_vec());
    }
    let Some((force, lever_m)) = samples.get(Signal::ForceEx).zip(lever_m) else {
        let why = "no torque was recorded, and no force with a lever length (device.lever_m) to make it from";
        return Err(FreeMotionError::Refused(why.to_owned()));
    };
    Ok(force.iter().map(|force| lever_m * force).collect())
}

/// Mean over a recording of more than one sample, s.
pub(crate) fn sample_interval_s(t: &[f64]) -> f64 {
    (t[t.len() - 1] - t[0]) / (t.len() - 1) as f64
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use zwidth_study::{StudyId, TrialMeta};

    pub(crate) fn parameters() -> Parameters {
        let study = zwidth_study::template(&StudyId::new("free").unwrap());
        Parameters::of(&Study::from_toml(&study).unwrap())
    }

    pub(crate) fn trial(columns: [(Signal, Vec<f64>); 4]) -> Trial {
        let meta =
            TrialMeta { environment: "free".parse().unwrap(), ..zwidth_testing::meta(1, "active") };
        let mut samples = Samples::default();
        for (signal, values) in columns {
            samples.set(signal, values);
        }
        Trial { meta, file: Default::default(), samples }
    }

    /// Whole numbers that vary without pattern: t, acceleration, velocity.
    fn motion(n: u32) -> [Vec<f64>; 3] {
        let series = |f: fn(u32) -> u32| (0..n).map(|i| f64::from(f(i)) - 8.0).collect();
        let t = (0..n).map(|i| f64::from(i) * 0.005).collect();
        [t, series(|i| i * i * 7 % 17), series(|i| (i / 3) * (i / 3) * 5 % 19)]
    }

    fn plane(measured: Signal, scale: f64) -> Trial {
        let [t, acc, vel] = motion(400);
        let torque =
            acc.iter().zip(&vel).map(|(a, v)| (0.01 + 0.5 * a - 0.25 * v) * scale).collect();
        trial([
            (Signal::Time, t),
            (Signal::ThetaDdot, acc),
            (Signal::ThetaDot, vel),
            (measured, torque),
        ])
    }

    #[test]
    fn an_exact_plane_is_recovered() {
        let fit = plane_fit(&plane(Signal::TorqueEx, 1.0), &parameters()).unwrap();
        for (found, expect) in
            [(fit.offset_nm, 0.01), (fit.inertia_kg_m2, 0.5), (fit.damping_nm_s_per_rad, -0.25)]
        {
            assert!((found - expect).abs() < 1e-13, "{found}");
        }
        assert!(fit.rms_nm < 1e-13 && (fit.r2.unwrap() - 1.0).abs() < 1e-13);
        assert_eq!((fit.samples, fit.lags), (400, 40));
        assert!((fit.bandwidth_s - 0.2).abs() < 1e-12);
    }

    #[test]
    fn a_force_becomes_a_torque_by_the_lever_length() {
        let lever_m = parameters().lever_m.unwrap();
        let fit = plane_fit(&plane(Signal::ForceEx, 1.0 / lever_m), &parameters()).unwrap();
        assert!((fit.inertia_kg_m2 - 0.5).abs() < 1e-13);
        let mut without = parameters();
        without.lever_m = None;
        let refused = plane_fit(&plane(Signal::ForceEx, 1.0), &without).unwrap_err().to_string();
        assert_eq!(
            refused,
            "no torque was recorded, and no force with a lever length (device.lever_m) to make it from"
        );
    }

    #[test]
    fn a_recording_without_acceleration_is_refused_by_name() {
        let [t, acc, vel] = motion(50);
        let without = trial([
            (Signal::Time, t),
            (Signal::Theta, acc),
            (Signal::ThetaDot, vel.clone()),
            (Signal::TorqueEx, vel),
        ]);
        let error = plane_fit(&without, &parameters()).unwrap_err();
        assert!(error.to_string().contains("no theta_ddot_rad_s2"), "{error}");
    }

    #[test]
    fn motion_that_cannot_tell_inertia_from_damping_is_refused() {
        let [t, _, vel] = motion(50);
        let acc = vec![0.0; 50];
        let still = trial([
            (Signal::Time, t),
            (Signal::ThetaDdot, acc),
            (Signal::ThetaDot, vel.clone()),
            (Signal::TorqueEx, vel),
        ]);
        let error = plane_fit(&still, &parameters()).unwrap_err().to_string();
        assert!(
            error.starts_with("the motion cannot tell inertia from the terms before it"),
            "{error}"
        );
    }
}
