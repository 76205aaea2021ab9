//! Typical trials through the model over its parameters, as a script that the page's sliders load.

use super::course::pack;
use serde::Serialize;
use std::io;
use zwidth_results::PlantRun;
use zwidth_study::ModeId;

/// The key of the script, and the stem of its file.
pub const TURNED: &str = "replay";
/// θ is told to a multiple of this, rad (0.0035°): a line of it is looked at, and short numbers
/// pack.
const GRAIN_RAD: f64 = 1.0 / 16_384.0;

/// The plant's parameters as sliders have them: mass, kg; damping, N·s/rad; friction, N.
pub type Turn = [f64; 3];

/// One mode's trial.
#[derive(Serialize)]
struct Turned<'a> {
    environment: &'a str,
    mode: ModeId,
    trial: u32,
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

/// The script: one entry per mode for each environment's runs.
///
/// # Errors
/// What cannot be packed or written as JSON.
pub fn turned_script(
    environments: &[(&str, Vec<PlantRun>)],
    by_eye: Turn,
    fitted: Option<Turn>,
) -> io::Result<String> {
    let mut turned = Vec::new();
    for (environment, runs) in environments {
        turned.extend(of_environment(environment, runs, by_eye, fitted)?);
    }
    let json = serde_json::to_string(&turned)?;
    Ok(format!("zwidthData(\"{TURNED}\", {{\"turned\":{json}}});\n"))
}

fn of_environment<'a>(
    environment: &'a str,
    rows: &[PlantRun],
    by_eye: Turn,
    fitted: Option<Turn>,
) -> io::Result<Vec<Turned<'a>>> {
    let mut turned = Vec::new();
    for of_trial in rows.chunk_by(|a, b| a.trial == b.trial) {
        let times = of_trial.iter().take_while(|row| row.mass_kg.is_none()).count();
        let (recorded, runs) = of_trial.split_at(times);
        let parameters = |row: &PlantRun| [row.mass_kg, row.damping_ns_per_rad, row.friction_n];
        // Rising values, each once.
        let values = [0, 1, 2].map(|k| {
            let values = runs.iter().filter_map(|row| parameters(row)[k]);
            let mut values: Vec<f64> = values.collect();
            values.sort_by(f64::total_cmp);
            values.dedup();
            values
        });
        let combinations = values.iter().map(Vec::len).product::<usize>();
        let mut errors = vec![f64::NAN; combinations];
        let mut angles = vec![f64::NAN; combinations * times];
        for run in runs.chunks(times.max(1)) {
            let Some(place) = place(&values, parameters(&run[0])) else { continue };
            errors[place] = run[0].rmse_rad.unwrap_or(f64::NAN);
            for (angle, row) in angles[place * times..].iter_mut().zip(run) {
                *angle = (row.theta_rad / GRAIN_RAD).round() * GRAIN_RAD;
            }
        }
        let t_s: Vec<f64> = recorded.iter().map(|row| row.t_s).collect();
        let theta: Vec<f64> = recorded.iter().map(|row| row.theta_rad).collect();
        turned.push(Turned {
            environment,
            mode: of_trial[0].mode.clone(),
            trial: of_trial[0].trial,
            values,
            by_eye,
            fitted,
            times,
            t_s: pack([&*t_s])?,
            recorded_rad: pack([&*theta])?,
            rmse_rad: pack([&*errors])?,
            theta_rad: pack([&*angles])?,
        });
    }
    Ok(turned)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_combination_has_its_place_and_one_that_did_not_run_is_no_number() {
        let none = f64::NAN;
        let given = |value: f64| value.is_finite().then_some(value);
        let row = |t_s, theta_rad, [mass, damping, friction, error]: [f64; 4]| PlantRun {
            trial: 4,
            mode: "hybrid".parse().unwrap(),
            source: zwidth_study::Source::Twin,
            mass_kg: given(mass),
            damping_ns_per_rad: given(damping),
            friction_n: given(friction),
            rmse_rad: given(error),
            t_s,
            theta_rad,
        };
        let rows = [
            row(0.0, 0.1, [none; 4]),
            row(1.0, 0.2, [none; 4]),
            row(0.0, 0.5, [0.1, 0.0, 0.0, 0.3]),
            row(1.0, 1.0, [0.1, 0.0, 0.0, 0.3]),
            row(0.0, 1.5, [0.1, 1.0, 0.0, 0.4]),
            row(1.0, 2.0, [0.1, 1.0, 0.0, 0.4]),
            row(0.0, 2.5, [0.2, 0.0, 0.0, 0.5]),
            row(1.0, 3.0, [0.2, 0.0, 0.0, 0.5]),
        ];
        let found = of_environment("spring", &rows, [0.1, 1.0, 0.0], None).unwrap();
        let [one] = found.as_slice() else { panic!("{} modes", found.len()) };
        assert_eq!(one.values, [vec![0.1, 0.2], vec![0.0, 1.0], vec![0.0]]);
        assert_eq!((one.times, one.trial, one.mode.as_str()), (2, 4, "hybrid"));
        assert_eq!(one.rmse_rad, pack([&[0.3, 0.4, 0.5, none][..]]).unwrap());
        assert_eq!(one.theta_rad, pack([&[0.5, 1.0, 1.5, 2.0, 2.5, 3.0, none, none][..]]).unwrap());
    }
}
