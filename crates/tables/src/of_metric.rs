//! One metric's rows of a table of all metrics, as a table of their own.

use crate::unit::split_unit;
use crate::{Column, Field, Table, TableError, UNIT_OF_ROW};
use zwidth_results::{Compared, MetricNote};
use zwidth_study::TaskQuantity;

/// The rows of a metric: its columns are in its unit, which their names end with, and a column that
/// none of them has a value of is left out. `notes` are those of all tables.
///
/// # Errors
/// A table without a column `metric`.
pub fn of_metric(
    all: &Table,
    metric: &Compared,
    notes: &[MetricNote],
) -> Result<Table, TableError> {
    let id = metric.metric.as_str();
    let own = all.with_text("metric", id)?.without_empty_columns();
    let (_, suffix) = split_unit(id, &metric.unit);
    let mut columns = Vec::new();
    for column in own.columns().iter().filter(|c| !matches!(&*c.field.name, "metric" | "unit")) {
        let Column { mut field, values } = column.clone();
        // The unit of the rows is one, now that they are of one metric.
        if field.unit == UNIT_OF_ROW {
            field = Field {
                name: (field.name.to_string() + suffix).into(),
                unit: metric.unit.to_string().into(),
                ..field
            };
        }
        columns.push(Column { field, values });
    }
    let name = format!("{}_{id}", all.name());
    let table = Table::new(&name, &format!("{}: {}", all.title(), metric.words), columns)?;
    let notes =
        notes.iter().filter(|note| note.metric == metric.metric && note.table == all.name());
    let table =
        notes.fold(table, |table, note| table.with_note_of(note.kind, note.note.to_string()));
    let has_own_unit = table.fields().any(|field| *field.unit == *metric.unit);
    let table = match TaskQuantity::logarithm_of(&metric.unit).filter(|_| has_own_unit) {
        Some(unit) => table.with_note(logarithms(unit)),
        None => table,
    };
    Ok(table.with_notes_of(&own))
}

/// How numbers of a metric of logarithms are read.
fn logarithms(unit: &str) -> String {
    let of = if unit == "1" { String::new() } else { format!(" of what is in {unit}") };
    format!(
        "Numbers with “{}” in their unit are natural logarithms{of}: with e = 2.718, e to the power of a mean is a \
         geometric mean, and e to the power of a difference is a ratio.",
        TaskQuantity::LN.trim_end()
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_results::{Cell, NoteKind, Role, UnitOfAnalysis};

    fn cell(metric: &str, unit: &str, mean: Option<f64>) -> Cell {
        Cell {
            metric: metric.parse().unwrap(),
            unit: unit.into(),
            participant: "P01".parse().unwrap(),
            session: "S01".parse().unwrap(),
            environment: "spring".parse().unwrap(),
            mode: "active".parse().unwrap(),
            trials: 6,
            n: 6,
            mean,
            sd: None,
        }
    }

    #[test]
    fn a_metric_of_logarithms_says_how_its_numbers_are_read() {
        let all = Table::of_rows(&[cell("ln_jnd_stiffer", "ln N/rad", Some(0.1))]).unwrap();
        let metric = Compared {
            metric: "ln_jnd_stiffer".parse().unwrap(),
            unit: "ln N/rad".into(),
            words: "JND".to_owned(),
            role: Role::Primary,
            better: zwidth_study::Better::Lower,
            unit_of_analysis: UnitOfAnalysis::Participants,
        };
        let own = of_metric(&all, &metric, &[]).unwrap();
        let field = own.fields().find(|field| &*field.name == "mean").unwrap();
        assert_eq!(&*field.unit, "ln N/rad");
        let [note] = own.notes() else { panic!("{:?}", own.notes()) };
        assert!(
            note.starts_with(
                "Numbers with “ln” in their unit are natural logarithms of what is in N/rad:"
            ),
            "{note}"
        );
    }

    #[test]
    fn a_metric_has_its_rows_its_unit_and_its_notes_and_no_empty_column() {
        let cells = [cell("past_rad", "rad", Some(0.1)), cell("length_s", "s", Some(2.0))];
        let all = Table::of_rows(&cells).unwrap().with_mark(true);
        let metric = Compared {
            metric: "past_rad".parse().unwrap(),
            unit: "rad".into(),
            words: "angle past the wall".to_owned(),
            role: Role::Primary,
            better: zwidth_study::Better::Lower,
            unit_of_analysis: UnitOfAnalysis::Participants,
        };
        let note = |metric: &str, table: &str, note: &str| MetricNote {
            metric: metric.parse().unwrap(),
            table: table.to_owned(),
            kind: NoteKind::Care,
            note: note.into(),
        };
        let notes = [
            note("past_rad", "cells", "its own"),
            note("length_s", "cells", "another's"),
            note("past_rad", "means", "of another table"),
        ];
        let own = of_metric(&all, &metric, &notes).unwrap();
        assert_eq!((own.name(), own.height()), ("cells_past_rad", 1));
        assert_eq!(own.title(), "By participant, session and condition: angle past the wall");
        assert_eq!(own.floats("mean_rad").unwrap(), [Some(0.1)]);
        assert!(own.column("sd_rad").is_err() && own.column("unit").is_err());
        assert_eq!(own.notes(), ["its own", crate::SYNTHETIC]);
        assert_eq!(of_metric(&all, &metric, &[]).unwrap().notes(), [crate::SYNTHETIC]);
    }
}
