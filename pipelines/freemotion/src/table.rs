//! The fits as rows: SI units, one per trial.

use crate::{PlaneFit, PlantFit};
use zwidth_results::{FreePlane, FreePlant};
use zwidth_stats::interval::Estimate;
use zwidth_tables::{Table, TableError};

/// The table of the plane fits, with what to doubt of them below.
///
/// # Errors
/// A number that is not finite.
pub fn plane_table(fits: &[PlaneFit]) -> Result<Table, TableError> {
    let rows: Vec<FreePlane> = fits.iter().map(FreePlane::from).collect();
    Ok(doubts(fits).into_iter().fold(Table::of_rows(&rows)?, Table::with_note))
}

/// The table of the plants. A note names what the recordings do not show.
///
/// # Errors
/// A number that is not finite.
pub fn plant_table(fits: &[PlantFit]) -> Result<Table, TableError> {
    let rows: Vec<FreePlant> = fits.iter().map(FreePlant::from).collect();
    let notes = unseen(fits).into_iter().chain(impossible(fits));
    Ok(notes.fold(Table::of_rows(&rows)?, Table::with_note))
}

impl From<&PlaneFit> for FreePlane {
    fn from(fit: &PlaneFit) -> Self {
        Self {
            participant: fit.meta.participant.clone(),
            session: fit.meta.session.clone(),
            trial: fit.meta.trial,
            repeat: fit.meta.repeat,
            environment: fit.meta.environment.clone(),
            mode: fit.meta.mode.clone(),
            source: fit.meta.source,
            offset_nm: fit.offset_nm.estimate,
            offset_std_error_nm: fit.offset_nm.std_error,
            offset_ci_low_nm: fit.offset_nm.ci_low,
            offset_ci_high_nm: fit.offset_nm.ci_high,
            inertia_kg_m2: fit.inertia_kg_m2.estimate,
            inertia_std_error_kg_m2: fit.inertia_kg_m2.std_error,
            inertia_ci_low_kg_m2: fit.inertia_kg_m2.ci_low,
            inertia_ci_high_kg_m2: fit.inertia_kg_m2.ci_high,
            damping_nm_s_per_rad: fit.damping_nm_s_per_rad.estimate,
            damping_std_error_nm_s_per_rad: fit.damping_nm_s_per_rad.std_error,
            damping_ci_low_nm_s_per_rad: fit.damping_nm_s_per_rad.ci_low,
            damping_ci_high_nm_s_per_rad: fit.damping_nm_s_per_rad.ci_high,
            r2: fit.r2,
            rms_nm: fit.rms_nm,
            samples: fit.samples,
            lags: fit.lags,
            bandwidth_s: fit.bandwidth_s,
        }
    }
}

impl From<&PlantFit> for FreePlant {
    fn from(fit: &PlantFit) -> Self {
        Self {
            participant: fit.meta.participant.clone(),
            session: fit.meta.session.clone(),
            trial: fit.meta.trial,
            repeat: fit.meta.repeat,
            environment: fit.meta.environment.clone(),
            mode: fit.meta.mode.clone(),
            source: fit.meta.source,
            offset_nm: fit.offset_nm.estimate,
            offset_std_error_nm: fit.offset_nm.std_error,
            offset_ci_low_nm: fit.offset_nm.ci_low,
            offset_ci_high_nm: fit.offset_nm.ci_high,
            inertia_kg_m2: fit.inertia_kg_m2.estimate,
            inertia_std_error_kg_m2: fit.inertia_kg_m2.std_error,
            inertia_ci_low_kg_m2: fit.inertia_kg_m2.ci_low,
            inertia_ci_high_kg_m2: fit.inertia_kg_m2.ci_high,
            damping_nm_s_per_rad: fit.damping_nm_s_per_rad.estimate,
            damping_std_error_nm_s_per_rad: fit.damping_nm_s_per_rad.std_error,
            damping_ci_low_nm_s_per_rad: fit.damping_nm_s_per_rad.ci_low,
            damping_ci_high_nm_s_per_rad: fit.damping_nm_s_per_rad.ci_high,
            friction_nm: fit.friction_nm.estimate,
            friction_std_error_nm: fit.friction_nm.std_error,
            friction_ci_low_nm: fit.friction_nm.ci_low,
            friction_ci_high_nm: fit.friction_nm.ci_high,
            stiffness_nm_per_rad: fit.stiffness_nm_per_rad.estimate,
            stiffness_std_error_nm_per_rad: fit.stiffness_nm_per_rad.std_error,
            stiffness_ci_low_nm_per_rad: fit.stiffness_nm_per_rad.ci_low,
            stiffness_ci_high_nm_per_rad: fit.stiffness_nm_per_rad.ci_high,
            r2: fit.r2,
            rms_nm: fit.rms_nm,
            samples: fit.samples,
            lags: fit.lags,
            bandwidth_s: fit.bandwidth_s,
        }
    }
}

/// A fit that explains less of the torque than this share does not count as a fit.
const LEAST_R2: f64 = 0.1;

/// What no body can have, and fits that explain nothing: the signals do not go together.
fn doubts(fits: &[PlaneFit]) -> Vec<String> {
    let signals = "sign, delay or filter of the recorded acceleration and torque do not go together. Compare the coefficients; \
                   do not read them as";
    // The whole interval is below 0: an estimate alone may be there by chance.
    let inertia = fits.iter().filter(|f| f.inertia_kg_m2.ci_high < 0.0).count();
    let damping = fits.iter().filter(|f| f.damping_nm_s_per_rad.ci_high < 0.0).count();
    let mut notes = Vec::new();
    for (what, count, read_as) in [("inertia", inertia, "masses"), ("damping", damping, "friction")]
    {
        if count > 0 {
            notes.push(format!(
                "The {what} is negative in {count} of {} fits, which no mechanism has: {signals} {read_as}.",
                fits.len()
            ));
        }
    }
    notes.extend(unexplained(fits.iter().map(|f| f.r2)));
    notes
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
    let coefficients: [(&str, Coefficient); 2] =
        [("inertia", |f| f.inertia_kg_m2), ("damping", |f| f.damping_nm_s_per_rad)];
    let mut notes = Vec::new();
    for (what, get) in coefficients {
        let count = fits.iter().filter(|f| get(f).ci_high < 0.0).count();
        if count > 0 {
            notes.push(format!(
                "The {what} is negative in {count} of {} fits, which no mechanism has: check the signs of torque and angle.",
                fits.len()
            ));
        }
    }
    notes.extend(unexplained(fits.iter().map(|f| f.r2)));
    notes
}

/// One coefficient of a plant.
type Coefficient = fn(&PlantFit) -> Estimate;

/// The coefficients whose interval holds 0: the movements do not show them.
fn unseen(fits: &[PlantFit]) -> Vec<String> {
    let coefficients: [(&str, Coefficient); 5] = [
        ("offset c", |f| f.offset_nm),
        ("inertia I", |f| f.inertia_kg_m2),
        ("damping b", |f| f.damping_nm_s_per_rad),
        ("dry friction", |f| f.friction_nm),
        ("stiffness", |f| f.stiffness_nm_per_rad),
    ];
    let mut notes = Vec::new();
    for (what, get) in coefficients {
        let count = fits.iter().filter(|f| get(f).ci_low <= 0.0 && get(f).ci_high >= 0.0).count();
        let among = match fits.len() {
            1 => String::new(),
            all => format!(" in {count} of {all} recordings"),
        };
        let says = "its interval holds 0, so these movements bound it and do not show it";
        if count > 0 {
            notes.push(format!("The {what} is not identified{among}: {says}."));
        }
    }
    notes
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
        let fit = plane_fit(&trial(columns), &parameters()).unwrap();
        let table = plane_table(std::slice::from_ref(&fit)).unwrap();
        let rows: Vec<FreePlane> = table.to_rows().unwrap();
        assert_eq!(rows, [FreePlane::from(&fit)]);
        let FreePlane { inertia_kg_m2, inertia_ci_low_kg_m2, inertia_ci_high_kg_m2, .. } = rows[0];
        assert!(inertia_ci_low_kg_m2 < inertia_kg_m2 && inertia_kg_m2 < inertia_ci_high_kg_m2);
        // Each column of a coefficient is from where its name says.
        let value = |name: &str| table.floats(name).unwrap()[0].unwrap();
        for (what, unit) in [("offset", "nm"), ("inertia", "kg_m2"), ("damping", "nm_s_per_rad")] {
            let [estimate, std_error, low, high] = ["", "_std_error", "_ci_low", "_ci_high"]
                .map(|part| value(&format!("{what}{part}_{unit}")));
            assert!(std_error > 0.0 && low < estimate && estimate < high, "{what}");
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
        let table = plant_table(std::slice::from_ref(&fit)).unwrap();
        assert_eq!(table.to_rows::<FreePlant>().unwrap(), [FreePlant::from(&fit)]);
        let notes = table.notes().to_vec();
        assert_eq!(notes.len(), 1);
        assert!(
            notes[0].starts_with("The inertia I is not identified: its interval"),
            "{}",
            notes[0]
        );
    }
}
