//! Typical trials through the model over its parameters, as a script that the page's sliders load.

use super::course::pack;
use serde::Serialize;
use zwidth_tables::{Table, TableError};

/// The key of the script, and the stem of its file.
pub const TURNED: &str = "replay";
/// θ is told to a multiple of this, rad (0.0035°): a line of it is looked at, and short numbers
/// pack.
const GRAIN_RAD: f64 = 1.0 / 16_384.0;

/// The plant's parameters as sliders have them: mass, kg; damping, N·s/rad; friction, N.
pub type Turn = [f64; 3];

/// The columns of the table of runs that are turned.
const PARAMETERS: [&str; 3] = ["mass_kg", "damping_ns_per_rad", "friction_n"];

/// One mode's trial.
#[derive(Serialize)]
struct Turned<'a> {
    environment: &'a str,
    mode: String,
    trial: i64,
    /// Values of each parameter.
    values: [Vec<f64>; 3],
    by_eye: Turn,
    #[serde(skip_serializing_if = "Option::is_none")]
    fitted: Option<Turn>,
    times: usize,
    t_s: String,
    recorded_rad: String,
    /// One per combination, the last parameter fastest; no number where the model does not run.
    rmse_rad: String,
    /// Each combination's times after one another.
    theta_rad: String,
}

#[derive(Serialize)]
struct Script<'a> {
    turned: Vec<Turned<'a>>,
}

/// The script: of each environment's table of runs (`zwidth_replay::runs`) one entry per mode.
///
/// # Errors
/// A table that lacks a column.
pub fn turned_script(
    environments: &[(&str, Table)],
    by_eye: Turn,
    fitted: Option<Turn>,
) -> Result<String, TurnedError> {
    let mut turned = Vec::new();
    for (environment, table) in environments {
        turned.extend(of_environment(environment, table, by_eye, fitted)?);
    }
    let json = serde_json::to_string(&Script { turned })?;
    Ok(format!("zwidthData({}, {json});\n", serde_json::to_string(TURNED)?))
}

/// What no script can be made of.
#[derive(Debug, thiserror::Error)]
pub enum TurnedError {
    /// Not a table of runs.
    #[error(transparent)]
    Table(#[from] TableError),
    /// Numbers that cannot be packed.
    #[error(transparent)]
    Pack(#[from] std::io::Error),
    /// What cannot be told as JSON.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

fn of_environment<'a>(
    environment: &'a str,
    table: &Table,
    by_eye: Turn,
    fitted: Option<Turn>,
) -> Result<Vec<Turned<'a>>, TurnedError> {
    let (modes, trials) = (table.texts("mode")?, table.integers("trial")?);
    let (t_s, theta, rmse) =
        (table.floats("t_s")?, table.floats("theta_rad")?, table.floats("rmse_rad")?);
    let parameters = PARAMETERS.map(|name| table.floats(name));
    let [masses, dampings, frictions] = parameters;
    let parameters = [masses?, dampings?, frictions?];
    let rows: Vec<usize> = (0..table.height()).collect();
    let mut turned = Vec::new();
    for of_trial in rows.chunk_by(|a, b| trials[*a] == trials[*b]) {
        let is_recorded = |row: &&usize| parameters[0][**row].is_none();
        let recorded: Vec<usize> = of_trial.iter().filter(is_recorded).copied().collect();
        let times = recorded.len();
        let runs = of_trial.get(times..).unwrap_or_default();
        let values = [0, 1, 2].map(|k| distinct(runs.iter().filter_map(|row| parameters[k][*row])));
        let combinations = values.iter().map(Vec::len).product::<usize>();
        let mut errors = vec![f64::NAN; combinations];
        let mut angles = vec![f64::NAN; combinations * times];
        for run in runs.chunks(times.max(1)) {
            let Some(place) = place(&values, [0, 1, 2].map(|k| parameters[k][run[0]])) else {
                continue;
            };
            errors[place] = rmse[run[0]].unwrap_or(f64::NAN);
            for (angle, row) in angles[place * times..].iter_mut().zip(run) {
                *angle = theta[*row].map_or(f64::NAN, grained);
            }
        }
        let at = |values: &[Option<f64>]| -> Vec<f64> {
            recorded.iter().map(|row| values[*row].unwrap_or(f64::NAN)).collect()
        };
        turned.push(Turned {
            environment,
            mode: modes[of_trial[0]].clone().unwrap_or_default(),
            trial: trials[of_trial[0]].unwrap_or_default(),
            values,
            by_eye,
            fitted,
            times,
            t_s: pack([&*at(&t_s)])?,
            recorded_rad: pack([&*at(&theta)])?,
            rmse_rad: pack([&*errors])?,
            theta_rad: pack([&*angles])?,
        });
    }
    Ok(turned)
}

/// Rising values, each once.
fn distinct(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Which combination these are, the last parameter fastest.
fn place(values: &[Vec<f64>; 3], of: [Option<f64>; 3]) -> Option<usize> {
    let mut place = 0;
    for (values, value) in values.iter().zip(of) {
        let value = value?;
        place = place * values.len() + values.iter().position(|v| v.total_cmp(&value).is_eq())?;
    }
    Some(place)
}

fn grained(theta_rad: f64) -> f64 {
    (theta_rad / GRAIN_RAD).round() * GRAIN_RAD
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_tables::Column;

    #[test]
    fn each_combination_has_its_place_and_one_that_did_not_run_is_no_number() {
        let n = |name, values: &[f64]| {
            let values = values.iter().map(|v| v.is_finite().then_some(*v)).collect::<Vec<_>>();
            Column::float(name, "1", "", values)
        };
        let none = f64::NAN;
        let columns = vec![
            Column::integer("trial", "1", "", [Some(4); 8]),
            Column::text("mode", "", [Some("hybrid"); 8]),
            n("mass_kg", &[none, none, 0.1, 0.1, 0.1, 0.1, 0.2, 0.2]),
            n("damping_ns_per_rad", &[none, none, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0]),
            n("friction_n", &[none, none, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            n("rmse_rad", &[none, none, 0.3, 0.3, 0.4, 0.4, 0.5, 0.5]),
            n("t_s", &[0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0]),
            n("theta_rad", &[0.1, 0.2, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0]),
        ];
        let table = Table::new("runs", "", columns).unwrap();
        let found = of_environment("spring", &table, [0.1, 1.0, 0.0], None).unwrap();
        let [one] = found.as_slice() else { panic!("{} modes", found.len()) };
        assert_eq!(one.values, [vec![0.1, 0.2], vec![0.0, 1.0], vec![0.0]]);
        assert_eq!((one.times, one.trial, one.mode.as_str()), (2, 4, "hybrid"));
        assert_eq!(one.rmse_rad, pack([&[0.3, 0.4, 0.5, none][..]]).unwrap());
        assert_eq!(one.theta_rad, pack([&[0.5, 1.0, 1.5, 2.0, 2.5, 3.0, none, none][..]]).unwrap());
    }
}
