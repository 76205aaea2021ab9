//! Wide sweeps: a column a value of one quantity, read from its header; its cells are the other
//! one.

use super::convert::mean;
use super::limits::shown;
use super::mapping::{QuantityFrom, Reduce, Side, SweepLabels};
use super::recording::Recording;
use super::report::FileReport;
use super::sweeps::{Piece, note};
use super::{Context, EMPTY, Errors, all};
use regex::Regex;
use std::collections::BTreeSet;
use zwidth_store::StoreError;

/// How a wide file is mapped.
#[derive(Debug, Clone)]
pub(super) struct Wide {
    /// Matches the headers in use; its group `value` is the number.
    pub(super) pattern: Regex,
    /// Which quantity stands in the headers.
    pub(super) header: Side,
    pub(super) reduce: Option<Reduce>,
    pub(super) command: QuantityFrom,
    pub(super) response: QuantityFrom,
}

/// The one sweep of a wide file: a sample a cell, or a sample a column where it is reduced.
pub(super) fn wide(
    context: &Context,
    labels: &SweepLabels,
    form: &Wide,
    recording: &Recording,
) -> Result<(Vec<Piece>, FileReport), Errors> {
    let columns = header_values(&form.pattern, recording)?;
    let places: Vec<usize> = columns.iter().map(|(place, _)| *place).collect();
    let label_columns = all(labels.columns().map(|c| recording.find(c)))?;
    let rows = recording.rows(&context.mapping.file, &places, &label_columns)?;
    let samples = all(columns.iter().map(|(place, value)| {
        let cells = recording.numbers(*place, &rows.kept)?;
        let cells = if form.reduce == Some(Reduce::Mean) { vec![mean(&cells)] } else { cells };
        Ok::<_, StoreError>(cells.into_iter().map(|cell| (*value, cell)).collect::<Vec<_>>())
    }))?;
    let (headers, cells): (Vec<f64>, Vec<f64>) = samples.into_iter().flatten().unzip();
    let mut report = context.file_report(
        recording,
        &rows,
        rows.kept.len(),
        &[places, label_columns].concat(),
    )?;
    report.null.push("t_s".to_owned());
    let (cells_are, mut command, mut response) = match form.header {
        Side::Command => ("response", headers, cells),
        Side::Response => ("command", cells, headers),
    };
    if form.reduce == Some(Reduce::Mean) {
        report
            .computed
            .push(format!("{cells_are} = mean of {} rows of each column", rows.kept.len()));
    }
    for (side, q, values) in
        [("command", &form.command, &mut command), ("response", &form.response, &mut response)]
    {
        q.line.apply_to_all(values, 1.0);
        let from = if side == cells_are { "the cells" } else { "the number in the header" };
        note(&mut report, side, &format!("{from} of the columns '{}'", form.pattern), q);
    }
    let (actuator, number) = labels.of(recording, rows.kept[0])?;
    report.add_empty(recording.gaps(&rows, &rows.kept).empty, EMPTY);
    Ok((vec![Piece { actuator, number, t_s: None, command, response, gaps: None }], report))
}

/// The columns whose header matches, each with the number in its header.
fn header_values(pattern: &Regex, recording: &Recording) -> Result<Vec<(usize, f64)>, StoreError> {
    let names = recording.table.names.as_deref().unwrap_or_default();
    let mut seen = BTreeSet::new();
    let numbered = names.iter().map(String::as_str).enumerate();
    let values = numbered.filter_map(|(place, name)| {
        let text = pattern.captures(name)?.name("value")?.as_str();
        if !seen.insert(name.to_owned()) {
            let what = "two columns have this header, and both match the pattern";
            return Some(Err(recording.error(what, "rename one of them").column(shown(name))));
        }
        let number: Option<f64> = text.parse().ok().filter(|v: &f64| v.is_finite());
        Some(number.map(|v| (place, v)).ok_or_else(|| {
            let what = format!("'{text}' in the header is not a number");
            recording.error(what, "mend the pattern in [wide]").column(shown(name))
        }))
    });
    let found = values.collect::<Result<Vec<_>, _>>()?;
    if found.is_empty() {
        let what = format!("no header matches the pattern '{pattern}'");
        return Err(recording.error(what, "mend the pattern in [wide], or header in [file]"));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::super::world::World;
    use zwidth_store::{Sweep, read_sweep};

    const WIDE: &str = "
kind = \"sweeps\"
[file]
rows = 2
[sweep]
actuator = \"brake\"
[wide]
pattern = '^deg_(?<value>-?[0-9.]+)_\\d+$'
header = \"command\"
[command]
name = \"angle\"
unit = \"deg\"
[response]
name = \"sensor voltage\"
unit = \"V\"
offset = 1.0
";

    #[test]
    fn a_wide_table_gives_a_sample_a_cell_or_the_mean_of_each_column() {
        let csv = "deg_-1.5_1,other,deg_2_2\n1,x,3\n2,x,5\n9,x,\n";
        let world = World::new();
        let report = world.import(WIDE, &[world.file("a.csv", csv)]).unwrap();
        assert_eq!(sweep(&world).command_values, [-1.5, -1.5, 2.0, 2.0]);
        assert_eq!(sweep(&world).response_values, [2.0, 3.0, 4.0, 6.0]);
        assert_eq!(report.files[0].rows_dropped[0].why, "after the first 2 (rows = 2)");

        let world = World::new();
        let mean = WIDE.replace("[command]", "reduce = \"mean\"\n[command]");
        world.import(&mean, &[world.file("a.csv", csv)]).unwrap();
        assert_eq!(sweep(&world).command_values, [-1.5, 2.0]);
        assert_eq!(sweep(&world).response_values, [2.5, 5.0]);
        let made = &sweep(&world).file["made_by_import"];
        assert!(made.contains("response = mean of 2 rows of each column"), "{made}");
    }

    #[test]
    fn bad_wide_tables_are_refused_with_column_and_row() {
        let world = World::new();
        let check = |map: &str, csv: &str, words: &str, at| {
            world.refuses(map, &world.file("a.csv", csv), words, at)
        };
        check(WIDE, "deg_1_1,deg_2_2\n1,2\nNaN,2\n", "NaN is not a number", Some(("deg_1_1", 2)));
        check(WIDE, "a,b\n1,2\n", "no header matches", None);
        check(
            &WIDE.replace("-?[0-9.]+", ".+"),
            "deg_x_1\n1\n",
            "'x' in the header is not a number",
            None,
        );
    }

    fn sweep(world: &World) -> Sweep {
        read_sweep(&world.layout.sweep(&"brake".parse().unwrap(), 1)).unwrap()
    }
}
