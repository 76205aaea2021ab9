//! The fits as tables: SI units, one row per trial.

use crate::{PlaneFit, PlantFit};
use zwidth_stats::interval::Estimate;
use zwidth_tables::{Column, Table, TableError, identity};

/// What a coefficient is, the names of its four columns, its unit, and where it stands.
type Coefficient<F> = (&'static str, [&'static str; 4], &'static str, fn(&F) -> Estimate);

const OFFSET: [&str; 4] =
    ["offset_nm", "offset_std_error_nm", "offset_ci_low_nm", "offset_ci_high_nm"];
const INERTIA: [&str; 4] =
    ["inertia_kg_m2", "inertia_std_error_kg_m2", "inertia_ci_low_kg_m2", "inertia_ci_high_kg_m2"];
const DAMPING: [&str; 4] = [
    "damping_nm_s_per_rad",
    "damping_std_error_nm_s_per_rad",
    "damping_ci_low_nm_s_per_rad",
    "damping_ci_high_nm_s_per_rad",
];
const FRICTION: [&str; 4] =
    ["friction_nm", "friction_std_error_nm", "friction_ci_low_nm", "friction_ci_high_nm"];
const STIFFNESS: [&str; 4] = [
    "stiffness_nm_per_rad",
    "stiffness_std_error_nm_per_rad",
    "stiffness_ci_low_nm_per_rad",
    "stiffness_ci_high_nm_per_rad",
];

const PLANE: [Coefficient<PlaneFit>; 3] = [
    ("offset c", OFFSET, "N·m", |f| f.offset_nm),
    ("inertia I", INERTIA, "kg·m²", |f| f.inertia_kg_m2),
    ("damping b", DAMPING, "N·m·s/rad", |f| f.damping_nm_s_per_rad),
];

const PLANT: [Coefficient<PlantFit>; 5] = [
    ("offset c", OFFSET, "N·m", |f| f.offset_nm),
    ("inertia I", INERTIA, "kg·m²", |f| f.inertia_kg_m2),
    ("damping b", DAMPING, "N·m·s/rad", |f| f.damping_nm_s_per_rad),
    ("dry friction", FRICTION, "N·m", |f| f.friction_nm),
    ("stiffness", STIFFNESS, "N·m/rad", |f| f.stiffness_nm_per_rad),
];

/// What a column of a coefficient holds: in words, and from where.
type Part = (&'static str, fn(Estimate) -> f64);

const PARTS: [Part; 4] = [
    ("estimate", |e| e.estimate),
    ("standard error (Newey-West, a tenth of the recording)", |e| e.std_error),
    ("lower end of the interval within this recording", |e| e.ci_low),
    ("upper end of the interval within this recording", |e| e.ci_high),
];

/// One row per trial, in the order given: which trial it is; c, I and b of τ = c + I θ̈ + b θ̇,
/// each with standard error and interval; how well the plane fits.
///
/// # Errors
/// A number that is not finite.
pub fn table(fits: &[PlaneFit]) -> Result<Table, TableError> {
    let mut columns = identity(&fits.iter().map(|f| &f.meta).collect::<Vec<_>>());
    columns.extend(coefficients(&PLANE, fits));
    columns.extend([
        r2("R² of the plane", fits.iter().map(|f| f.r2)),
        rms(fits.iter().map(|f| f.rms_nm)),
        count("samples", "samples of the fit", fits.iter().map(|f| f.samples)),
        count("lags", "lags of the covariance, samples", fits.iter().map(|f| f.lags)),
        bandwidth(fits.iter().map(|f| f.bandwidth_s)),
    ]);
    let title = "Plane fits of free motion: torque = c + I·acceleration + b·velocity";
    Ok(doubts(fits).into_iter().fold(Table::new("free_motion", title, columns)?, Table::with_note))
}

/// One row per trial, in the order given: which trial it is; c, I, b, τ_c and κ of
/// τ = c + I θ̈ + b θ̇ + τ_c sgn θ̇ + κ θ, each with standard error and interval; how well they
/// fit. A note names what the recording does not show.
///
/// # Errors
/// A number that is not finite.
pub fn plant_table(fits: &[PlantFit]) -> Result<Table, TableError> {
    let mut columns = identity(&fits.iter().map(|f| &f.meta).collect::<Vec<_>>());
    columns.extend(coefficients(&PLANT, fits));
    columns.extend([
        r2("R² of the fit", fits.iter().map(|f| f.r2)),
        rms(fits.iter().map(|f| f.rms_nm)),
        count("samples", "slipping stretches of the fit", fits.iter().map(|f| f.samples)),
        count("lags", "lags of the covariance, stretches", fits.iter().map(|f| f.lags)),
        bandwidth(fits.iter().map(|f| f.bandwidth_s)),
    ]);
    let title = "The plant in free motion: torque = c + I·acceleration + b·velocity + friction·direction + stiffness·angle";
    Ok(unseen(fits)
        .into_iter()
        .chain(impossible(fits))
        .fold(Table::new("plant", title, columns)?, Table::with_note))
}

fn coefficients<'a, F>(
    of: &'a [Coefficient<F>],
    fits: &'a [F],
) -> impl Iterator<Item = Column> + 'a {
    of.iter().flat_map(move |(what, names, unit, get)| {
        names.iter().zip(PARTS).map(move |(name, (meaning, part))| {
            let mut column =
                Column::float(name, unit, meaning, fits.iter().map(|f| Some(part(get(f)))));
            column.field.description = format!("{what}: {meaning}").into();
            column
        })
    })
}

/// A fit that explains less of the torque than this share does not count as a fit.
const LEAST_R2: f64 = 0.1;

/// What no body can have, and fits that explain nothing: the signals do not go together.
fn doubts(fits: &[PlaneFit]) -> Vec<String> {
    let signals = "sign, delay or filter of the recorded acceleration and torque do not go together. Compare the coefficients; \
                   do not read them as";
    let negative = |what: &str, get: fn(&PlaneFit) -> Estimate, read_as: &str| {
        let count = fits.iter().filter(|f| get(f).ci_high < 0.0).count();
        (count > 0).then(|| {
            format!(
                "The {what} is negative in {count} of {} fits, which no mechanism has: {signals} {read_as}.",
                fits.len()
            )
        })
    };
    let inertia = negative("inertia", |f| f.inertia_kg_m2, "masses");
    let damping = negative("damping", |f| f.damping_nm_s_per_rad, "friction");
    [inertia, damping, unexplained(fits.iter().map(|f| f.r2))].into_iter().flatten().collect()
}

/// Fits that explain next to nothing of the torque.
fn unexplained(r2: impl ExactSizeIterator<Item = Option<f64>>) -> Option<String> {
    let all = r2.len();
    let count = r2.flatten().filter(|r2| *r2 < LEAST_R2).count();
    (count > 0).then(|| {
        format!(
            "R² is below {LEAST_R2} in {count} of {all} fits: the motion explains next to nothing of the torque there. Check \
             the columns and units of torque and angle; no coefficient of such a fit means anything."
        )
    })
}

/// The same of plants, whose inertia and damping no body has below 0.
fn impossible(fits: &[PlantFit]) -> Vec<String> {
    let negative = |what: &str, get: fn(&PlantFit) -> Estimate| {
        let count = fits.iter().filter(|f| get(f).ci_high < 0.0).count();
        (count > 0).then(|| {
            format!(
                "The {what} is negative in {count} of {} fits, which no mechanism has: check the signs of torque and angle.",
                fits.len()
            )
        })
    };
    let found = [
        negative("inertia", |f| f.inertia_kg_m2),
        negative("damping", |f| f.damping_nm_s_per_rad),
        unexplained(fits.iter().map(|f| f.r2)),
    ];
    found.into_iter().flatten().collect()
}

/// The coefficients whose interval holds 0: the movements do not show them.
fn unseen(fits: &[PlantFit]) -> Vec<String> {
    let note = |(what, _, _, get): &Coefficient<PlantFit>| {
        let around_zero = |f: &&PlantFit| get(f).ci_low <= 0.0 && get(f).ci_high >= 0.0;
        let count = fits.iter().filter(around_zero).count();
        let of = if fits.len() == 1 {
            String::new()
        } else {
            format!(" in {count} of {} recordings", fits.len())
        };
        let says = "its interval holds 0, so these movements bound it and do not show it";
        (count > 0).then(|| format!("The {what} is not identified{of}: {says}."))
    };
    PLANT.iter().filter_map(note).collect()
}

fn r2(description: &'static str, values: impl Iterator<Item = Option<f64>>) -> Column {
    Column::float("r2", "1", description, values)
}

fn rms(values: impl Iterator<Item = f64>) -> Column {
    Column::float("rms_nm", "N·m", "RMS of the residuals", values.map(Some))
}

fn count(
    name: &'static str,
    description: &'static str,
    values: impl Iterator<Item = usize>,
) -> Column {
    Column::integer(name, "1", description, values.map(|n| Some(n as i64)))
}

fn bandwidth(values: impl Iterator<Item = f64>) -> Column {
    Column::float("bandwidth_s", "s", "the lags in time", values.map(Some))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::tests::{parameters, trial};
    use crate::plane_fit;
    use zwidth_store::Signal;

    #[test]
    fn an_estimate_stands_between_the_ends_of_its_interval() {
        let series =
            |step: u32| (0..100u32).map(|i| f64::from(i * i * step % 23)).collect::<Vec<_>>();
        let t = (0..100u32).map(f64::from).collect();
        let columns = [
            (Signal::Time, t),
            (Signal::ThetaDdot, series(3)),
            (Signal::ThetaDot, series(5)),
            (Signal::TorqueEx, series(7)),
        ];
        let table = table(&[plane_fit(&trial(columns), &parameters()).unwrap()]).unwrap();
        let value = |name: &str| table.floats(name).unwrap()[0].unwrap();
        for (_, names, _, _) in PLANE {
            let [estimate, std_error, low, high] = names.map(value);
            assert!(std_error > 0.0 && low < estimate && estimate < high, "{names:?}");
        }
    }
    #[test]
    fn a_coefficient_whose_interval_holds_zero_is_said_to_be_unseen() {
        let of = |estimate: f64| Estimate {
            estimate,
            std_error: 1.0,
            ci_low: estimate - 2.0,
            ci_high: estimate + 2.0,
            df: 9.0,
        };
        let fit = PlantFit {
            meta: trial(
                [Signal::Time, Signal::Theta, Signal::ThetaDot, Signal::TorqueEx]
                    .map(|s| (s, vec![0.0])),
            )
            .meta,
            offset_nm: of(3.0),
            inertia_kg_m2: of(-1.0),
            damping_nm_s_per_rad: of(3.0),
            friction_nm: of(9.0),
            stiffness_nm_per_rad: of(-9.0),
            r2: Some(0.9),
            rms_nm: 0.1,
            samples: 1,
            lags: 1,
            bandwidth_s: 0.1,
        };
        let notes = plant_table(&[fit]).unwrap().notes().to_vec();
        assert_eq!(notes.len(), 1);
        assert!(
            notes[0].starts_with("The inertia I is not identified: its interval"),
            "{}",
            notes[0]
        );
    }
}
