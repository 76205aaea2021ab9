//! The contrasts of every metric in one table, as a paper prints them.

use crate::CompareError;
use zwidth_tables::{Column, NoteKind, Table, TableError, UNIT_OF_ROW, Values};

/// How the name of a metric's contrasts begins.
pub(crate) const CONTRASTS: &str = "contrasts_";

/// Columns in the metric's own unit, and what they are.
const IN_THE_UNIT: [(&str, &str); 5] = [
    ("mean_first", "mean in the contrast's first mode"),
    ("mean_second", "mean in the contrast's second mode"),
    ("difference", "mean difference"),
    ("difference_ci_low", "lower end of its interval"),
    ("difference_ci_high", "upper end of its interval"),
];
/// Pure numbers, and what they are. A study has some of the effect sizes.
const NUMBERS: [(&str, &str); 8] = [
    ("statistic", "t statistic"),
    ("df", "degrees of freedom"),
    ("p_adjusted", "p value, adjusted by Holm over the metric's family"),
    ("g_av", "d_av without its bias where people are few"),
    ("g_z", "d_z without its bias where people are few"),
    ("d_av", "difference over the root mean of the modes' variances between participants"),
    ("d_z", "difference over the standard deviation of participants' differences"),
    ("difference_jnd", "difference over the one that is just noticed"),
];

/// The contrasts of several metrics ([`Compared::contrasts`](crate::Compared::contrasts)) one below
/// the other, each in its own unit: what a paper prints of them. `primary` is the metric on which
/// claims rest.
///
/// # Errors
/// A table that is not one of contrasts.
pub fn together(contrasts: &[Table], primary: &str) -> Result<Table, CompareError> {
    let metric = |table: &Table| table.name().trim_start_matches(CONTRASTS).to_owned();
    let unit =
        |table: &Table| table.column_of("difference").map(|column| column.field.unit.to_string());
    let texts = |name: &'static str, description: &'static str| {
        Ok::<_, TableError>(Column::text(name, description, joined(contrasts, |t| t.texts(name))?))
    };
    let metrics = joined(contrasts, |t| Ok(vec![Some(metric(t)); t.height()]))?;
    let units = joined(contrasts, |t| Ok(vec![Some(unit(t)?); t.height()]))?;
    let mut all = vec![
        Column::text("metric", "what is compared", metrics),
        Column::text("unit", "unit of the metric", units),
        texts("environment", "what was rendered")?,
        texts("contrast", "the modes compared: the one minus the other")?,
        texts("unit_of_analysis", "what n counts")?,
        Column::integer("n", "1", "units of analysis", joined(contrasts, |t| t.integers("n"))?),
    ];
    for (name, description) in IN_THE_UNIT {
        let values = joined(contrasts, |table| floats(table, name))?;
        all.push(Column::float(name, UNIT_OF_ROW, description, values));
    }
    for (name, description) in NUMBERS {
        // With one participant there is no t statistic and no effect size; not all metrics are felt.
        let values = joined(contrasts, |table| {
            Ok(floats(table, name).unwrap_or(vec![None; table.height()]))
        })?;
        if values.iter().any(Option::is_some) {
            all.push(Column::float(name, "1", description, values));
        }
    }
    all.push(texts("verdict", "what the tests show")?);
    let remarks = joined(contrasts, |table| table.texts("remark"))?;
    if remarks.iter().any(Option::is_some) {
        all.push(Column::text("remark", "why there is no test, or no claim", remarks));
    }
    let sizes =
        joined(contrasts, |table| Ok(table.texts("size").unwrap_or(vec![None; table.height()])))?;
    if sizes.iter().any(Option::is_some) {
        let description = "whether the interval is of differences that are felt, no claim";
        all.push(Column::text("size", description, sizes));
    }
    let table = Table::new("comparison", "Modes compared in every metric", all)?;
    let table = notes(contrasts, primary)?
        .into_iter()
        .fold(table, |table, (kind, note)| table.with_note_of(kind, note));
    Ok(table)
}

/// A column of every table, one below the other.
fn joined<T: Clone>(
    tables: &[Table],
    of: impl Fn(&Table) -> Result<Vec<T>, TableError>,
) -> Result<Vec<T>, TableError> {
    Ok(tables.iter().map(of).collect::<Result<Vec<_>, _>>()?.concat())
}

/// The numbers of a column by its name without the unit.
fn floats(table: &Table, stem: &str) -> Result<Vec<Option<f64>>, TableError> {
    match &table.column_of(stem)?.values {
        Values::Float(values) => Ok(values.clone()),
        _ => table.floats(stem),
    }
}

/// Whom the table speaks of, how was tested, and what is a claim.
fn notes(contrasts: &[Table], primary: &str) -> Result<Vec<(NoteKind, String)>, TableError> {
    let Some(first) = contrasts.first() else { return Ok(Vec::new()) };
    let of_whom = first.notes_by_kind().next().map(|(kind, note)| (kind, note.to_owned()));
    let within = first.texts("unit_of_analysis")?.into_iter().flatten().next();
    let within_one = within.is_some_and(|unit| unit.starts_with("trials of "));
    let test = if within_one {
        "p: the sharp null, that no trial depended on mode. Intervals describe the trials."
    } else {
        "t and p: the participants' differences, n − 1 degrees of freedom."
    };
    let claims = match contrasts.iter().find(|table| table.name() == [CONTRASTS, primary].concat())
    {
        Some(table) => {
            let words = table.title().split_once(": ").map_or(primary, |(_, words)| words);
            format!("Claims rest on the primary metric, {words}; the others are exploratory.")
        }
        None => "The primary metric is not among these: all are exploratory.".to_owned(),
    };
    let general = |text: String| (NoteKind::General, text);
    let family =
        "p adjusted after Holm, each metric a family of its own; intervals are not adjusted.";
    let said = [general(test.to_owned()), general(claims), general(family.to_owned())];
    Ok(of_whom.into_iter().chain(said).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contrasts(metric: &str, unit: &'static str, difference: f64, d_av: bool) -> Table {
        let suffix = metric.rsplit_once('_').map_or("", |(_, suffix)| suffix);
        let float = |stem: &str, value| {
            let column = Column::float("difference", unit, "", [Some(value)]);
            let name = format!("{stem}_{suffix}").into();
            Column { field: zwidth_tables::Field { name, ..column.field }, ..column }
        };
        let text =
            |name: &'static str, value: &str| Column::text(name, "", [Some(value.to_owned())]);
        let mut columns = vec![
            text("environment", "spring"),
            text("contrast", "hybrid − active"),
            text("unit_of_analysis", "participants"),
            Column::integer("n", "1", "", [Some(4)]),
            text("verdict", "different"),
            Column::text("remark", "", [None::<String>]),
            Column::float("df", "1", "", [Some(3.0)]),
            Column::float("p_adjusted", "1", "", [Some(0.02)]),
        ];
        columns.extend(IN_THE_UNIT.map(|(stem, _)| float(stem, difference)));
        columns.extend(d_av.then(|| Column::float("d_av", "1", "", [Some(1.5)])));
        let name = [CONTRASTS, metric].concat();
        let title = format!("Modes compared: {metric} in words");
        Table::new(&name, &title, columns).unwrap().with_note("n counts participants.")
    }

    #[test]
    fn every_metric_has_its_rows_in_its_unit_and_the_claims_are_named() {
        let tables =
            [contrasts("past_rad", "rad", 0.1, true), contrasts("length_s", "s", 2.0, true)];
        let table = together(&tables, "length_s").unwrap();
        let texts = |name| table.texts(name).unwrap().into_iter().flatten().collect::<Vec<_>>();
        assert_eq!(texts("metric"), ["past_rad", "length_s"]);
        assert_eq!(texts("unit"), ["rad", "s"]);
        assert_eq!(table.floats("difference").unwrap(), [Some(0.1), Some(2.0)]);
        assert_eq!(table.floats("d_av").unwrap(), [Some(1.5); 2]);
        let notes: Vec<&str> = table.notes_by_kind().map(|(_, note)| note).collect();
        assert_eq!(notes[0], "n counts participants.");
        assert!(notes[2].starts_with("Claims rest on the primary metric, length_s in words;"));
        let people =
            zwidth_tables::for_people(&table, zwidth_study::Coordinate::Rotational).unwrap();
        assert_eq!(people.texts("unit").unwrap()[0].as_deref(), Some("°"));
        assert!(
            (people.floats("difference").unwrap()[0].unwrap() - 0.1_f64.to_degrees()).abs() < 1e-12
        );
    }

    #[test]
    fn what_no_metric_has_is_no_column_and_without_the_primary_one_nothing_is_claimed() {
        let tables =
            [contrasts("past_rad", "rad", 0.1, true), contrasts("length_s", "s", 2.0, false)];
        let table = together(&tables, "other_n").unwrap();
        assert!(table.column("g_av").is_err() && table.column("statistic").is_err());
        assert_eq!(table.floats("d_av").unwrap(), [Some(1.5), None]);
        assert!(table.notes_by_kind().any(|(_, note)| note.ends_with("all are exploratory.")));
        assert_eq!(together(&[], "other_n").unwrap().height(), 0);
    }
}
