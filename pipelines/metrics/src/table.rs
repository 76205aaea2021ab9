//! The rows as a table: SI units, one row a trial.

use crate::TrialMetrics;
use crate::columns::{GROUPS, Get, Spec};
use zwidth_tables::{Column, Table, TableError, identity};

/// One row a trial, in the order given: which trial it is, then every metric. SI units; null where
/// a metric does not apply or the recording lacks what it needs. The columns' definitions stand at
/// the fields of [`TrialMetrics`]'s parts and, by column, in `docs/analysis.md`.
///
/// # Errors
/// A metric that is not finite.
pub fn table(rows: &[TrialMetrics]) -> Result<Table, TableError> {
    let mut columns = identity(&rows.iter().map(|r| &r.meta).collect::<Vec<_>>());
    columns.extend(GROUPS.into_iter().flatten().map(|spec| column(spec, rows)));
    Table::new("metrics", "Metrics, one row a trial", columns)
}

fn column(spec: &Spec, rows: &[TrialMetrics]) -> Column {
    let Spec { name, unit, description, get, .. } = spec;
    match get {
        Get::Float(get) => Column::float(name, unit, description, rows.iter().map(get)),
        Get::Count(get) => Column::integer(name, unit, description, rows.iter().map(get)),
        Get::Flag(get) => Column::flag(name, description, rows.iter().map(get)),
        Get::Word(get) => {
            Column::text(name, description, rows.iter().map(|r| get(r).map(str::to_owned)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{REST_RAD, at_wall, stroke, trial};
    use crate::trial_metrics;

    #[test]
    fn a_column_ends_in_its_unit() {
        let endings = [
            ("s", "_s"),
            ("rad", "_rad"),
            ("rad/s", "_rad_s"),
            ("N", "_n"),
            ("J", "_j"),
            ("m", "_m"),
            ("N·s", "_n_s"),
            ("N/rad", "_n_per_rad"),
            ("Hz", "_hz"),
        ];
        let table = table(&[]).unwrap();
        for field in table.fields().filter(|f| f.unit != "1") {
            let (_, ending) = endings.iter().find(|(unit, _)| *unit == field.unit).unwrap();
            assert!(field.name.ends_with(ending), "{}: {}", field.name, field.unit);
        }
    }

    /// `docs/analysis.md` is the page on which a reader looks a column up.
    #[test]
    fn every_column_is_defined_on_the_page_about_the_analysis() {
        let page = include_str!("../../../docs/analysis.md");
        for spec in GROUPS.into_iter().flatten() {
            let part = spec.name.contains("_ci_") || spec.name.contains("_std_error_");
            assert!(
                part || page.contains(&format!("`{}`", spec.name)),
                "{} is not defined",
                spec.name
            );
        }
    }

    #[test]
    fn a_row_lands_in_its_columns_and_what_does_not_apply_is_null() {
        let trial = trial(&stroke(1.0, 2.0), |theta, _| 4.0 * (theta - REST_RAD));
        let row = trial_metrics(&trial, &at_wall(4.0, REST_RAD, 3.0)).unwrap();
        let table = table(std::slice::from_ref(&row)).unwrap();
        assert_eq!(table.floats("stiffness_n_per_rad").unwrap(), [row.spring.stiffness_n_per_rad]);
        assert_eq!(table.flags("wall_reached").unwrap(), [Some(false)]);
        assert_eq!(table.floats("wall_dwell_s").unwrap(), [None]);
        assert_eq!(table.texts("mode").unwrap(), [Some("hybrid".to_owned())]);
    }
}
