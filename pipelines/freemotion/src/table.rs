//! The plane fits as a table: SI units, one row a trial.

use crate::PlaneFit;
use zwidth_stats::interval::Estimate;
use zwidth_tables::{Column, Table, TableError, identity};

type Get = fn(&PlaneFit) -> Estimate;
/// What a coefficient is, the names of its four columns, its unit, and where it stands.
type Coefficient = (&'static str, [&'static str; 4], &'static str, Get);

const COEFFICIENTS: [Coefficient; 3] = [
    (
        "offset c",
        ["offset_nm", "offset_std_error_nm", "offset_ci_low_nm", "offset_ci_high_nm"],
        "N·m",
        |f| f.offset_nm,
    ),
    (
        "inertia I",
        ["inertia_kg_m2", "inertia_std_error_kg_m2", "inertia_ci_low_kg_m2", "inertia_ci_high_kg_m2"],
        "kg·m²",
        |f| f.inertia_kg_m2,
    ),
    (
        "damping b",
        [
            "damping_nm_s_per_rad",
            "damping_std_error_nm_s_per_rad",
            "damping_ci_low_nm_s_per_rad",
            "damping_ci_high_nm_s_per_rad",
        ],
        "N·m·s/rad",
        |f| f.damping_nm_s_per_rad,
    ),
];

/// What a column of a coefficient holds: in words, and from where.
type Part = (&'static str, fn(Estimate) -> f64);

const PARTS: [Part; 4] = [
    ("estimate", |e| e.estimate),
    ("standard error (Newey-West, a tenth of the recording)", |e| e.std_error),
    ("lower end of the interval within this recording", |e| e.ci_low),
    ("upper end of the interval within this recording", |e| e.ci_high),
];

/// One row a trial, in the order given: which trial it is; c, I and b of τ = c + I θ̈ + b θ̇, each with standard
/// error and interval; how well the plane fits.
///
/// # Errors
/// A number that is not finite.
pub fn table(fits: &[PlaneFit]) -> Result<Table, TableError> {
    let mut columns = identity(&fits.iter().map(|f| &f.meta).collect::<Vec<_>>());
    for (what, names, unit, get) in COEFFICIENTS {
        for (name, (meaning, part)) in names.into_iter().zip(PARTS) {
            let mut column = Column::float(name, unit, meaning, fits.iter().map(|f| Some(part(get(f)))));
            column.field.description = format!("{what}: {meaning}").into();
            columns.push(column);
        }
    }
    columns.extend(quality(fits));
    let table = Table::new(
        "free_motion",
        "Plane fits of free motion: torque = c + I·acceleration + b·velocity",
        columns,
    )?;
    Ok(doubts(fits).into_iter().fold(table, Table::with_note))
}

/// What no body can have: an inertia below zero says that the recorded signals do not go together.
fn doubts(fits: &[PlaneFit]) -> Option<String> {
    let negative = fits.iter().filter(|f| f.inertia_kg_m2.ci_high < 0.0).count();
    (negative > 0).then(|| {
        format!(
            "The inertia is negative in {negative} of {} fits, which no mechanism has: sign, delay or filter of the \
             recorded acceleration and torque do not go together. Compare the coefficients; do not read them as \
             masses.",
            fits.len()
        )
    })
}

fn quality(fits: &[PlaneFit]) -> Vec<Column> {
    let count = |name, description, get: fn(&PlaneFit) -> usize| {
        Column::integer(name, "1", description, fits.iter().map(|f| Some(get(f) as i64)))
    };
    vec![
        Column::float("r2", "1", "R² of the plane", fits.iter().map(|f| f.r2)),
        Column::float("rms_nm", "N·m", "RMS of the residuals", fits.iter().map(|f| Some(f.rms_nm))),
        count("samples", "samples of the fit", |f| f.samples),
        count("lags", "lags of the covariance, samples", |f| f.lags),
        Column::float("bandwidth_s", "s", "the lags in time", fits.iter().map(|f| Some(f.bandwidth_s))),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::tests::{study, trial};
    use crate::plane_fit;
    use zwidth_store::Signal;

    #[test]
    fn an_estimate_stands_between_the_ends_of_its_interval() {
        let series = |step: u32| (0..100u32).map(|i| f64::from(i * i * step % 23)).collect::<Vec<_>>();
        let t = (0..100u32).map(f64::from).collect();
        let columns = [
            (Signal::Time, t),
            (Signal::ThetaDdot, series(3)),
            (Signal::ThetaDot, series(5)),
            (Signal::TorqueEx, series(7)),
        ];
        let table = table(&[plane_fit(&trial(columns), &study()).unwrap()]).unwrap();
        let value = |name: &str| table.floats(name).unwrap()[0].unwrap();
        for (_, names, _, _) in COEFFICIENTS {
            let [estimate, std_error, low, high] = names.map(value);
            assert!(std_error > 0.0 && low < estimate && estimate < high, "{names:?}");
        }
    }
}
