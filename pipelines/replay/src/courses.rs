//! What figures show of a replay: recorded trials and their models against time.

use crate::table::OWN_MODEL;
use crate::{Course, Drive, Parameters, Rendering, ReplayError};
use zwidth_results::{Causality, ReplayedTrial};
use zwidth_store::Trial;
use zwidth_study::{ModeId, Source, TrialMeta};
use zwidth_tables::{Column, Table, TableError};

/// Who follows a course: what was recorded, the model by eye, the model as fitted.
const SERIES: [&str; 3] = ["recorded", "by_eye", "fitted"];

/// Of the replayed trials of one session and environment, in their order, the number of the mode's
/// trial with the median error of the angle, driven by force (the lower of two); `None` where none
/// was replayed.
pub fn typical(replays: &[ReplayedTrial], mode: &ModeId) -> Option<u32> {
    let own =
        replays.iter().filter(|row| row.mode == *mode && row.causality == Causality::ForceDriven);
    let mut known: Vec<(f64, u32)> = own.filter_map(|row| Some((row.nrmse?, row.trial))).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = known.len().saturating_sub(1) / 2;
    known.get(middle).map(|(_, trial)| *trial)
}

/// Motion and forces of trials as recorded, and of the models that were given their external force,
/// one row per sample: `trial`, `mode`, `source`, `series` (`recorded`, `by_eye`, `fitted`), `t_s`,
/// `theta_rad`, `theta_dot_rad_s`, `force_ex_n`, `feedback_n`. Trials to which the replay does not
/// apply are passed by, and so is a fit that does not run on one. Notes say what the models are.
///
/// # Errors
/// A trial or a choice by eye that makes no model.
pub fn courses(
    trials: &[(Trial, &Rendering)],
    by_eye: &Parameters,
    fitted: Option<&Parameters>,
) -> Result<Table, ReplayError> {
    let mut rows: Vec<(&TrialMeta, &str, Course)> = Vec::new();
    for (trial, rendering) in trials {
        let drive = match Drive::new(trial, rendering) {
            Err(ReplayError::WhyNot(_)) => continue,
            other => other?,
        };
        let run = |plant: &Parameters| drive.run(Causality::ForceDriven, plant);
        let fitted = fitted.and_then(|plant| run(plant).ok()).filter(is_finite);
        let all = [Some(drive.recorded().clone()), Some(run(by_eye)?), fitted];
        let named = SERIES.into_iter().zip(all);
        rows.extend(named.filter_map(|(series, course)| Some((&trial.meta, series, course?))));
    }
    let notes = [note("by eye", by_eye)]
        .into_iter()
        .chain(fitted.map(|plant| note("fitted", plant)))
        .chain(["Of each mode the trial with the median error by eye.".to_owned()])
        .chain(
            trials
                .iter()
                .any(|(trial, _)| trial.meta.source == Source::Twin)
                .then(|| OWN_MODEL.to_owned()),
        );
    Ok(notes.fold(table(&rows)?, Table::with_note))
}

fn is_finite(course: &Course) -> bool {
    let Course { theta_rad, theta_dot_rad_s, feedback_n, .. } = course;
    let all = theta_rad.iter().chain(theta_dot_rad_s).chain(feedback_n.iter().flatten());
    all.copied().all(f64::is_finite)
}

fn table(rows: &[(&TrialMeta, &str, Course)]) -> Result<Table, TableError> {
    let each = || rows.iter().flat_map(|row| (0..row.2.t_s.len()).map(move |i| (row, i)));
    let text = |name, about, get: fn(&TrialMeta) -> &str| {
        Column::text(name, about, each().map(|((meta, _, _), _)| Some(get(meta).to_owned())))
    };
    let float = |name, unit, about, get: fn(&Course) -> Option<&Vec<f64>>| {
        let value = |((_, _, course), i): (&(_, _, Course), usize)| Some(get(course)?[i]);
        Column::float(name, unit, about, each().map(value))
    };
    let trial = each().map(|((meta, _, _), _)| Some(i64::from(meta.trial)));
    let series = each().map(|((_, series, _), _)| Some((*series).to_owned()));
    let columns = vec![
        Column::integer("trial", "1", "number of the trial in the session", trial),
        text("mode", "how it was rendered", |m| m.mode.as_str()),
        text("source", "recorded, twin or imported", |m| m.source.as_str()),
        Column::text("series", "recorded, or the model: by eye or fitted", series),
        float("t_s", "s", "time since the first sample", |c| Some(&c.t_s)),
        float("theta_rad", "rad", "lever angle", |c| Some(&c.theta_rad)),
        float("theta_dot_rad_s", "rad/s", "lever velocity", |c| Some(&c.theta_dot_rad_s)),
        float("force_ex_n", "N", "the user's force, which drives the model", |c| {
            Some(&c.force_ex_n)
        }),
        float("feedback_n", "N", "force of the actuators against the user", |c| {
            c.feedback_n.as_ref()
        }),
    ];
    Table::new("courses", "Recorded trials and their models against time", columns)
}

/// What a model's plant is made of.
fn note(how: &str, plant: &Parameters) -> String {
    let Parameters {
        mass_kg,
        damping_ns_per_rad,
        friction_n,
        motor_lag_s,
        brake_on_s,
        brake_off_s,
    } = *plant;
    let lags_ms = [motor_lag_s, brake_on_s, brake_off_s].map(|lag_s| 1e3 * lag_s);
    let lags = match lags_ms.iter().any(|lag| *lag > 0.0) {
        true => format!(
            ", lags {:.2} ms (motor), {:.1} and {:.1} ms (brake on, off)",
            lags_ms[0], lags_ms[1], lags_ms[2]
        ),
        false => String::new(),
    };
    format!(
        "Model, {how}: mass {mass_kg:.3} kg, damping {damping_ns_per_rad:.3} N·s/rad, friction {friction_n:.3} N{lags}."
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{rendering, simulated};
    use crate::{replay, rows};
    use zwidth_results::ModelPlant;
    use zwidth_study::Analysis;

    #[test]
    fn the_typical_trial_has_the_median_error_and_the_lower_of_two() {
        let rendering = rendering("hybrid");
        let of = |trial: u32, mass_kg: f64| {
            let plant = Parameters { mass_kg, ..Parameters::BY_EYE };
            let mut made = simulated("hybrid", &plant);
            made.meta.trial = trial;
            replay(
                &made,
                &rendering,
                &Analysis::default(),
                (ModelPlant::ByEye, &Parameters::BY_EYE),
            )
            .unwrap()
        };
        // The further the plant's mass from that by eye, the larger the error.
        let trials = [of(4, 0.5), of(7, 0.1), of(9, 0.2), of(12, 0.9)];
        let number = |n: usize| typical(&rows(&trials[..n].concat()), &"hybrid".parse().unwrap());
        assert_eq!([1, 2, 3, 4].map(number), [Some(4), Some(7), Some(9), Some(9)]);
        assert_eq!(typical(&rows(&trials.concat()), &"active".parse().unwrap()), None);
    }

    #[test]
    fn a_trial_of_the_model_itself_lies_on_its_recording_and_a_missing_fit_has_no_rows() {
        let (trial, rendering) = (simulated("active", &Parameters::BY_EYE), rendering("active"));
        let samples = trial.samples.len();
        let table = courses(&[(trial, &rendering)], &Parameters::BY_EYE, None).unwrap();
        assert_eq!(table.height(), 2 * samples);
        let theta = table.floats("theta_rad").unwrap();
        let apart = |i: usize| (theta[i].unwrap() - theta[samples + i].unwrap()).abs();
        assert!((0..samples).all(|i| apart(i) < 1e-9));
        assert!(
            table.notes()[0].starts_with("Model, by eye: mass 0.100 kg"),
            "{:?}",
            table.notes()
        );
    }
}
