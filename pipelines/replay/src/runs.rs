//! The runs that the page's sliders for the plant's parameters show: trials driven by their
//! recorded force, through the model at every point of a grid.

use crate::drive::theta_at;
use crate::{Drive, Parameters, Rendering, ReplayError};
use zwidth_results::PlantRun;
use zwidth_store::Trial;

/// Values of the grid, besides those by eye and fitted: mass, kg; damping, N·s/rad; friction, N.
const MASSES_KG: [f64; 4] = [0.05, 0.1, 0.2, 0.5];
const DAMPINGS_NS_PER_RAD: [f64; 5] = [0.0, 0.2, 0.5, 1.0, 2.0];
const FRICTIONS_N: [f64; 3] = [0.0, 0.1, 0.3];
/// Times that a run keeps; its error is over all samples.
const MOST_TIMES: usize = 60;

/// The angle against time of trials as recorded, and of the model driven by their force with every
/// mass, damping and friction of a grid that has those by eye and those `fitted`; lags are the
/// fitted ones. At most 60 times a run, one after the other; errors are over every sample. Trials to
/// which the replay does not apply are passed by, and so are plants that do not run.
///
/// # Errors
/// A trial of columns of unequal length.
pub fn runs(
    trials: &[(Trial, &Rendering)],
    by_eye: &Parameters,
    fitted: Option<&Parameters>,
) -> Result<Vec<PlantRun>, ReplayError> {
    let plants = grid(by_eye, fitted);
    let mut runs = Vec::new();
    for (trial, rendering) in trials {
        let drive = match Drive::new(trial, rendering) {
            Err(ReplayError::WhyNot(_)) => continue,
            other => other?,
        };
        let recorded = drive.recorded();
        let row = |i: usize, theta: &[f64], plant: Option<(&Parameters, f64)>| PlantRun {
            trial: trial.meta.trial,
            mode: trial.meta.mode.clone(),
            source: trial.meta.source,
            mass_kg: plant.map(|(plant, _)| plant.mass_kg),
            damping_ns_per_rad: plant.map(|(plant, _)| plant.damping_ns_per_rad),
            friction_n: plant.map(|(plant, _)| plant.friction_n),
            rmse_rad: plant.map(|(_, error)| error),
            t_s: recorded.t_s[i],
            theta_rad: theta[i],
        };
        let times = kept_samples(recorded.t_s.len());
        runs.extend(times.iter().map(|i| row(*i, &recorded.theta_rad, None)));
        for plant in &plants {
            let Ok(theta) = theta_at(&drive.scene, &recorded.t_s, plant) else { continue };
            let pairs = theta.iter().zip(&recorded.theta_rad);
            let squares: f64 = pairs.map(|(model, seen)| (model - seen) * (model - seen)).sum();
            let error = (squares / theta.len() as f64).sqrt();
            if error.is_finite() {
                runs.extend(times.iter().map(|i| row(*i, &theta, Some((plant, error)))));
            }
        }
    }
    Ok(runs)
}

/// Every combination, masses slowest.
fn grid(by_eye: &Parameters, fitted: Option<&Parameters>) -> Vec<Parameters> {
    let own: Vec<&Parameters> = std::iter::once(by_eye).chain(fitted).collect();
    let masses = values(&MASSES_KG, &own, |plant| plant.mass_kg);
    let dampings = values(&DAMPINGS_NS_PER_RAD, &own, |plant| plant.damping_ns_per_rad);
    let frictions = values(&FRICTIONS_N, &own, |plant| plant.friction_n);
    let lags = fitted.unwrap_or(by_eye);
    let mut plants = Vec::with_capacity(masses.len() * dampings.len() * frictions.len());
    for mass_kg in &masses {
        for damping_ns_per_rad in &dampings {
            plants.extend(frictions.iter().map(|friction_n| Parameters {
                mass_kg: *mass_kg,
                damping_ns_per_rad: *damping_ns_per_rad,
                friction_n: *friction_n,
                ..*lags
            }));
        }
    }
    plants
}

/// The values of a grid and those of the plants `own`, each once, rising.
fn values(grid: &[f64], own: &[&Parameters], number: fn(&Parameters) -> f64) -> Vec<f64> {
    let mut values: Vec<f64> =
        grid.iter().copied().chain(own.iter().map(|plant| number(plant))).collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Which samples a run keeps: evenly chosen, the last among them.
fn kept_samples(samples: usize) -> Vec<usize> {
    let times = samples.min(MOST_TIMES);
    (0..times).map(|k| k * (samples - 1) / (times - 1).max(1)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{rendering, simulated};

    #[test]
    fn the_model_that_a_trial_is_of_has_no_error_and_every_other_one_has() {
        let plant = Parameters { mass_kg: 0.2, friction_n: 0.1, ..Parameters::BY_EYE };
        let (trial, rendering) = (simulated("active", &plant), rendering("active"));
        let found = runs(&[(trial, &rendering)], &Parameters::BY_EYE, None).unwrap();
        assert_eq!(found.len(), 60 * (1 + 4 * 5 * 3), "a grid that has the thesis' values");
        let first = &found[0];
        assert_eq!((first.mass_kg, first.rmse_rad), (None, None), "what was recorded comes first");
        let expect = [plant.mass_kg, plant.damping_ns_per_rad, plant.friction_n].map(Some);
        for run in &found[60..] {
            let is = [run.mass_kg, run.damping_ns_per_rad, run.friction_n] == expect;
            assert_eq!(run.rmse_rad.unwrap() < 1e-9, is, "{run:?}");
        }
    }

    #[test]
    fn samples_are_chosen_evenly_to_the_last() {
        assert_eq!(kept_samples(3), [0, 1, 2]);
        let many = kept_samples(4001);
        assert_eq!((many.len(), many[0], many[59]), (60, 0, 4000));
    }
}
