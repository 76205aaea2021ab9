//! The data for figures of a replay: recorded trials and their models against time.

use crate::table::OWN_MODEL;
use crate::{Course, Drive, Parameters, Rendering, ReplayError};
use zwidth_results::{Causality, CourseSample, CourseSeries, ReplayedTrial};
use zwidth_store::Trial;
use zwidth_study::{ModeId, Source};

/// Of the replayed trials of one session and environment, in their order, the number of the mode's
/// trial with the median error of the angle, driven by force (the lower of two); `None` where none
/// was replayed.
pub fn typical(replays: &[ReplayedTrial], mode: &ModeId) -> Option<u32> {
    let own =
        replays.iter().filter(|row| row.mode == *mode && row.causality == Causality::ForceDriven);
    let mut errors: Vec<(f64, u32)> = own.filter_map(|row| Some((row.nrmse?, row.trial))).collect();
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = errors.len().saturating_sub(1) / 2;
    errors.get(middle).map(|(_, trial)| *trial)
}

/// Motion and forces of trials as recorded, and of the models that were given their external force.
/// Trials to which the replay does not apply are passed by, and so is a fit that does not run on
/// one.
///
/// # Errors
/// A trial or a choice by eye that makes no model.
pub fn courses(
    trials: &[(Trial, &Rendering)],
    by_eye: &Parameters,
    fitted: Option<&Parameters>,
) -> Result<Vec<CourseSample>, ReplayError> {
    let mut samples = Vec::new();
    for (trial, rendering) in trials {
        let drive = match Drive::new(trial, rendering) {
            Err(ReplayError::WhyNot(_)) => continue,
            other => other?,
        };
        let by_eye = drive.run(Causality::ForceDriven, by_eye)?;
        let fitted = fitted.and_then(|plant| drive.run(Causality::ForceDriven, plant).ok());
        let fitted = fitted.filter(is_finite);
        for (series, course) in [
            (CourseSeries::Recorded, Some(drive.recorded())),
            (CourseSeries::ByEye, Some(&by_eye)),
            (CourseSeries::Fitted, fitted.as_ref()),
        ] {
            let Some(course) = course else { continue };
            samples.extend((0..course.t_s.len()).map(|i| CourseSample {
                trial: trial.meta.trial,
                mode: trial.meta.mode.clone(),
                source: trial.meta.source,
                series,
                t_s: course.t_s[i],
                theta_rad: course.theta_rad[i],
                theta_dot_rad_s: course.theta_dot_rad_s[i],
                force_ex_n: course.force_ex_n[i],
                feedback_n: course.feedback_n.as_ref().map(|force| force[i]),
            }));
        }
    }
    Ok(samples)
}

/// Notes that describe the models of courses.
pub fn course_notes(
    trials: &[(Trial, &Rendering)],
    by_eye: &Parameters,
    fitted: Option<&Parameters>,
) -> Vec<String> {
    let own_model = trials.iter().any(|(trial, _)| trial.meta.source == Source::Twin);
    [note("by eye", by_eye)]
        .into_iter()
        .chain(fitted.map(|plant| note("fitted", plant)))
        .chain(["Of each mode the trial with the median error by eye.".to_owned()])
        .chain(own_model.then(|| OWN_MODEL.to_owned()))
        .collect()
}

fn is_finite(course: &Course) -> bool {
    let Course { theta_rad, theta_dot_rad_s, feedback_n, .. } = course;
    let all = theta_rad.iter().chain(theta_dot_rad_s).chain(feedback_n.iter().flatten());
    all.copied().all(f64::is_finite)
}

/// The note on a model's plant.
fn note(how: &str, plant: &Parameters) -> String {
    let Parameters { mass_kg, damping_ns_per_rad, friction_n, .. } = plant;
    let lags_ms @ [motor, on, off] =
        [plant.motor_lag_s, plant.brake_on_s, plant.brake_off_s].map(|lag_s| 1e3 * lag_s);
    let lags = match lags_ms.iter().any(|lag| *lag > 0.0) {
        true => format!(", lags {motor:.2} ms (motor), {on:.1} and {off:.1} ms (brake on, off)"),
        false => String::new(),
    };
    format!(
        "Model, {how}: mass {mass_kg:.3} kg, damping {damping_ns_per_rad:.3} N·s/rad, friction {friction_n:.3} N{lags}."
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{rendering, replays, simulated};

    #[test]
    fn the_typical_trial_has_the_median_error_and_the_lower_of_two() {
        let of = |trial: u32, mass_kg: f64| {
            let plant = Parameters { mass_kg, ..Parameters::BY_EYE };
            let mut made = simulated("hybrid", &plant);
            made.meta.trial = trial;
            replays(&made)
        };
        // The further the plant's mass from that by eye, the larger the error.
        let trials = [of(4, 0.5), of(7, 0.1), of(9, 0.2), of(12, 0.9)];
        let number = |n: usize| typical(&trials[..n].concat(), &"hybrid".parse().unwrap());
        assert_eq!([1, 2, 3, 4].map(number), [Some(4), Some(7), Some(9), Some(9)]);
        assert_eq!(typical(&trials.concat(), &"active".parse().unwrap()), None);
    }

    #[test]
    fn a_trial_of_the_model_itself_lies_on_its_recording_and_a_missing_fit_has_no_rows() {
        let (trial, rendering) = (simulated("active", &Parameters::BY_EYE), rendering("active"));
        let samples = trial.samples.len();
        let trials = [(trial, &rendering)];
        let found = courses(&trials, &Parameters::BY_EYE, None).unwrap();
        assert_eq!(found.len(), 2 * samples);
        let apart = |i: usize| (found[i].theta_rad - found[samples + i].theta_rad).abs();
        assert!((0..samples).all(|i| apart(i) < 1e-9));
        let notes = course_notes(&trials, &Parameters::BY_EYE, None);
        assert!(notes[0].starts_with("Model, by eye: mass 0.100 kg"), "{notes:?}");
    }
}
