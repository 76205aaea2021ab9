//! The contrasts of every metric in one table, as a paper prints them.

use crate::CompareError;
use crate::notes::of_whom;
use zwidth_results::{Compared, ModeDifference, PrintedDifference, Role, UnitOfAnalysis};
use zwidth_tables::Table;

/// The contrasts of all metrics one below the other, each in its own unit: what a paper prints of
/// them.
///
/// # Errors
/// A number that is none.
pub fn together(metrics: &[Compared], contrasts: &[ModeDifference]) -> Result<Table, CompareError> {
    let printed = Table::of_rows(contrasts)?.to_rows::<PrintedDifference>()?;
    let table = Table::of_rows(&printed)?.without_empty_columns();
    let Some(first) = metrics.first() else { return Ok(table) };
    let test = match first.unit_of_analysis {
        UnitOfAnalysis::TrialsOf(_) => {
            "p: the sharp null, that no trial depended on mode. Intervals describe the trials."
        }
        UnitOfAnalysis::Participants => {
            "t and p: the participants' differences, n − 1 degrees of freedom."
        }
    };
    let claims = match metrics.iter().find(|metric| metric.role == Role::Primary) {
        Some(Compared { words, .. }) => {
            format!("Claims rest on the primary metric, {words}; the others are exploratory.")
        }
        None => "The primary metric is not among these: all are exploratory.".to_owned(),
    };
    let family =
        "p adjusted after Holm, each metric a family of its own; intervals are not adjusted.";
    let table = table.with_note(of_whom(&first.unit_of_analysis)).with_note(test);
    Ok(table.with_note(claims).with_note(family))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{four, metrics, parameters};
    use crate::{MetricParameters, compare};
    use zwidth_tables::{Column, Measured, for_people};

    fn both(primary: &str) -> Table {
        let steps = metrics(&four());
        let angles = steps.numbers("step_n").unwrap();
        let angles = Column::float("past_rad", "rad", "an angle", angles);
        let columns = [steps.table().columns(), &[angles]];
        let of = |metric: &str| MetricParameters {
            metric: metric.parse().unwrap(),
            primary: metric == primary,
            ..parameters().metrics[0].clone()
        };
        let both = ["past_rad", "step_n"].map(of).to_vec();
        let parameters = crate::Parameters { metrics: both, ..parameters() };
        let table = Table::new("metrics", "", columns.concat()).unwrap();
        let found = compare(&Measured::of(table).unwrap(), &parameters).unwrap();
        together(&found.metrics, &found.contrasts).unwrap()
    }

    #[test]
    fn every_metric_has_its_rows_in_its_unit_and_the_claims_are_named() {
        let table = both("step_n");
        let texts = |name| table.texts(name).unwrap().into_iter().flatten().collect::<Vec<_>>();
        assert_eq!(texts("metric"), ["past_rad", "past_rad", "step_n", "step_n"]);
        assert_eq!(texts("unit"), ["rad", "rad", "N", "N"]);
        let notes: Vec<&str> = table.notes_by_kind().map(|(_, note)| note).collect();
        assert!(notes[0].starts_with("n counts participants"), "{notes:?}");
        assert!(notes[2].starts_with("Claims rest on the primary metric, a step;"), "{notes:?}");
        let people = for_people(&table, zwidth_study::Coordinate::Rotational).unwrap();
        assert_eq!(people.texts("unit").unwrap()[0].as_deref(), Some("°"));
        let (own, told) =
            (table.floats("difference").unwrap(), people.floats("difference").unwrap());
        assert!((told[0].unwrap() - own[0].unwrap().to_degrees()).abs() < 1e-12);
        assert_eq!(told[2], own[2]);
    }

    #[test]
    fn what_no_metric_has_is_no_column_and_without_the_primary_one_nothing_is_claimed() {
        let table = both("other_n");
        assert!(table.column("d_av").is_err() && table.column("difference_jnd").is_err());
        assert!(table.notes_by_kind().any(|(_, note)| note.ends_with("all are exploratory.")));
        assert_eq!(together(&[], &[]).unwrap().height(), 0);
    }
}
