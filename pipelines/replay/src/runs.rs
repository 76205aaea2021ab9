//! What a reader sees who turns the plant's parameters: trials driven by their recorded force,
//! through the model at every point of a grid.

use crate::{Drive, Parameters, Rendering, ReplayError};
use zwidth_store::Trial;
use zwidth_tables::{Column, Table, TableError};

/// Values of the grid, besides those by eye and fitted: mass, kg; damping, N·s/rad; friction, N.
const MASSES_KG: [f64; 4] = [0.05, 0.1, 0.2, 0.5];
const DAMPINGS_NS_PER_RAD: [f64; 5] = [0.0, 0.2, 0.5, 1.0, 2.0];
const FRICTIONS_N: [f64; 3] = [0.0, 0.1, 0.3];
/// Times at which a run is told; its error is over all samples.
const MOST_TIMES: usize = 60;

/// One point of the grid on one trial.
struct Run {
    /// Of the trial, in the order in which trials were given.
    trial: usize,
    /// None: what was recorded.
    plant: Option<Parameters>,
    rmse_rad: Option<f64>,
    t_s: Vec<f64>,
    theta_rad: Vec<f64>,
}

/// The angle against time of trials as recorded, and of the model driven by their force with every
/// mass, damping and friction of a grid that has those by eye and those `fitted`; lags are the
/// fitted ones. One row a run and time, at most 60 times a run: `trial`, `mode`, `source`,
/// `mass_kg`, `damping_ns_per_rad`, `friction_n` (null: recorded), `rmse_rad` (over every sample),
/// `t_s`, `theta_rad`. Trials to which the replay does not apply are passed by, and so are plants
/// that do not run.
///
/// # Errors
/// A trial of columns of unequal length.
pub fn runs(
    trials: &[(Trial, &Rendering)],
    by_eye: &Parameters,
    fitted: Option<&Parameters>,
) -> Result<Table, ReplayError> {
    let plants = grid(by_eye, fitted);
    let mut runs = Vec::new();
    for (place, (trial, rendering)) in trials.iter().enumerate() {
        let drive = match Drive::new(trial, rendering) {
            Err(ReplayError::WhyNot(_)) => continue,
            other => other?,
        };
        let rows = told(drive.recorded().t_s.len());
        runs.push(recorded(place, &drive, &rows));
        runs.extend(plants.iter().filter_map(|plant| run(place, &drive, plant, &rows)));
    }
    Ok(table(trials, &runs)?)
}

/// Every combination, masses slowest.
fn grid(by_eye: &Parameters, fitted: Option<&Parameters>) -> Vec<Parameters> {
    let given = || std::iter::once(by_eye).chain(fitted);
    let values = |values: &[f64], of: fn(&Parameters) -> f64| {
        let mut values: Vec<f64> = values.iter().copied().chain(given().map(of)).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values
    };
    let masses = values(&MASSES_KG, |plant| plant.mass_kg);
    let dampings = values(&DAMPINGS_NS_PER_RAD, |plant| plant.damping_ns_per_rad);
    let frictions = values(&FRICTIONS_N, |plant| plant.friction_n);
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

/// Which of so many samples are told: evenly chosen, the last among them.
fn told(samples: usize) -> Vec<usize> {
    let times = samples.min(MOST_TIMES);
    (0..times).map(|k| k * (samples - 1) / (times - 1).max(1)).collect()
}

fn recorded(trial: usize, drive: &Drive, rows: &[usize]) -> Run {
    let course = drive.recorded();
    let at = |values: &[f64]| rows.iter().map(|row| values[*row]).collect();
    let (t_s, theta_rad) = (at(&course.t_s), at(&course.theta_rad));
    Run { trial, plant: None, rmse_rad: None, t_s, theta_rad }
}

/// The model with this plant; `None` where it does not run.
fn run(trial: usize, drive: &Drive, plant: &Parameters, rows: &[usize]) -> Option<Run> {
    let course = drive.recorded();
    let theta = drive.theta_at(&course.t_s, plant).ok()?;
    let squares =
        theta.iter().zip(&course.theta_rad).map(|(model, is)| (model - is) * (model - is));
    let rmse_rad = (squares.sum::<f64>() / theta.len() as f64).sqrt();
    let t_s = rows.iter().map(|row| course.t_s[*row]).collect();
    let theta_rad = rows.iter().map(|row| theta[*row]).collect();
    rmse_rad.is_finite().then_some(Run {
        trial,
        plant: Some(*plant),
        rmse_rad: Some(rmse_rad),
        t_s,
        theta_rad,
    })
}

fn table(trials: &[(Trial, &Rendering)], runs: &[Run]) -> Result<Table, TableError> {
    let each = || runs.iter().flat_map(|run| (0..run.t_s.len()).map(move |i| (run, i)));
    let meta = |run: &Run| &trials[run.trial].0.meta;
    let float = |name, unit, about, get: fn(&Run, usize) -> Option<f64>| {
        Column::float(name, unit, about, each().map(|(run, i)| get(run, i)))
    };
    let number = each().map(|(run, _)| Some(i64::from(meta(run).trial)));
    let mode = each().map(|(run, _)| Some(meta(run).mode.to_string()));
    let source = each().map(|(run, _)| Some(meta(run).source.as_str().to_owned()));
    let columns = vec![
        Column::integer("trial", "1", "number of the trial in the session", number),
        Column::text("mode", "how it was rendered", mode),
        Column::text("source", "recorded, twin or imported", source),
        float("mass_kg", "kg", "mass of the model; null: recorded", |run, _| {
            run.plant.map(|plant| plant.mass_kg)
        }),
        float("damping_ns_per_rad", "N·s/rad", "its damping", |run, _| {
            run.plant.map(|plant| plant.damping_ns_per_rad)
        }),
        float("friction_n", "N", "its friction in motion", |run, _| {
            run.plant.map(|plant| plant.friction_n)
        }),
        float("rmse_rad", "rad", "RMS error of the angle over all samples", |run, _| run.rmse_rad),
        float("t_s", "s", "time since the first sample", |run, i| Some(run.t_s[i])),
        float("theta_rad", "rad", "lever angle", |run, i| Some(run.theta_rad[i])),
    ];
    Table::new("runs", "Recorded trials through the model over its parameters", columns)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{rendering, simulated};

    #[test]
    fn the_model_that_a_trial_is_of_has_no_error_and_every_other_one_has() {
        let plant = Parameters { mass_kg: 0.2, friction_n: 0.1, ..Parameters::BY_EYE };
        let (trial, rendering) = (simulated("active", &plant), rendering("active"));
        let table = runs(&[(trial, &rendering)], &Parameters::BY_EYE, None).unwrap();
        let column = |name| table.floats(name).unwrap();
        let (masses, frictions, errors) =
            (column("mass_kg"), column("friction_n"), column("rmse_rad"));
        let dampings = column("damping_ns_per_rad");
        assert_eq!(table.height(), 60 * (1 + 4 * 5 * 3), "a grid that has the thesis' values");
        assert_eq!((masses[0], errors[0]), (None, None), "what was recorded comes first");
        for row in 60..table.height() {
            let is = [masses[row], dampings[row], frictions[row]]
                == [Some(plant.mass_kg), Some(plant.damping_ns_per_rad), Some(plant.friction_n)];
            assert_eq!(errors[row].unwrap() < 1e-9, is, "{row}: {:?}", errors[row]);
        }
    }

    #[test]
    fn samples_are_chosen_evenly_to_the_last() {
        assert_eq!(told(3), [0, 1, 2]);
        let many = told(4001);
        assert_eq!((many.len(), many[0], many[59]), (60, 0, 4000));
    }
}
