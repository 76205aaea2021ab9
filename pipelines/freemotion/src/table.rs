//! The tables of the fits, with what to doubt of them.

use zwidth_results::{FreePlane, FreePlant};
use zwidth_tables::{Table, TableError};

/// The table of the plane fits, with what to doubt of them below.
///
/// # Errors
/// A number that is not finite.
pub fn plane_table(fits: &[FreePlane]) -> Result<Table, TableError> {
    let signals = "sign, delay or filter of the recorded acceleration and torque do not go together. Compare the coefficients; \
                   do not read them as";
    let notes = [
        negative(
            "inertia",
            fits.iter().map(|fit| fit.inertia_ci_high_kg_m2),
            &format!("{signals} masses"),
        ),
        negative(
            "damping",
            fits.iter().map(|fit| fit.damping_ci_high_nm_s_per_rad),
            &format!("{signals} friction"),
        ),
        unexplained(fits.iter().map(|fit| fit.r2)),
    ];
    Ok(notes.into_iter().flatten().fold(Table::of_rows(fits)?, Table::with_note))
}

/// The table of the plants. A note names what the recordings do not show.
///
/// # Errors
/// A number that is not finite.
pub fn plant_table(fits: &[FreePlant]) -> Result<Table, TableError> {
    let signs = "check the signs of torque and angle";
    let doubts = [
        negative("inertia", fits.iter().map(|fit| fit.inertia_ci_high_kg_m2), signs),
        negative("damping", fits.iter().map(|fit| fit.damping_ci_high_nm_s_per_rad), signs),
        unexplained(fits.iter().map(|fit| fit.r2)),
    ];
    let notes = unseen(fits).into_iter().chain(doubts.into_iter().flatten());
    Ok(notes.fold(Table::of_rows(fits)?, Table::with_note))
}

/// A fit that explains less of the torque than this share does not count as a fit.
const LEAST_R2: f64 = 0.1;

/// What no body can have: a coefficient that is negative in some fits, and what to do about it.
fn negative(
    what: &str,
    ci_high: impl ExactSizeIterator<Item = f64>,
    remedy: &str,
) -> Option<String> {
    let all = ci_high.len();
    // The whole interval is below 0: an estimate alone may be there by chance.
    let count = ci_high.filter(|high| *high < 0.0).count();
    (count > 0).then(|| {
        format!(
            "The {what} is negative in {count} of {all} fits, which no mechanism has: {remedy}."
        )
    })
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

/// The interval of a coefficient of a plant.
type Interval = fn(&FreePlant) -> [f64; 2];

/// The coefficients whose interval holds 0: the movements do not show them.
fn unseen(fits: &[FreePlant]) -> Vec<String> {
    let coefficients: [(&str, Interval); 5] = [
        ("offset c", |fit| [fit.offset_ci_low_nm, fit.offset_ci_high_nm]),
        ("inertia I", |fit| [fit.inertia_ci_low_kg_m2, fit.inertia_ci_high_kg_m2]),
        ("damping b", |fit| [fit.damping_ci_low_nm_s_per_rad, fit.damping_ci_high_nm_s_per_rad]),
        ("dry friction", |fit| [fit.friction_ci_low_nm, fit.friction_ci_high_nm]),
        ("stiffness", |fit| [fit.stiffness_ci_low_nm_per_rad, fit.stiffness_ci_high_nm_per_rad]),
    ];
    let mut notes = Vec::new();
    for (what, interval) in coefficients {
        let count =
            fits.iter().map(interval).filter(|[low, high]| *low <= 0.0 && *high >= 0.0).count();
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
        assert_eq!(rows, [fit]);
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
}
