//! Files of characterisation sweeps → sweeps.

use super::batch::Batch;
use super::context::{Context, Converted, EMPTY, EMPTY_AT_A_RATE};
use super::convert::mean;
use super::errors::{Errors, all};
use super::label::Label;
use super::limits::{Budget, Take, check_time};
use super::mapping::{Pairs, QuantityFrom, Reduce, Side, SweepForm, SweepFrom, Time, Wide};
use super::plan::{TimeColumn, rate_times, rate_words};
use super::recording::{Gaps, Recording};
use super::report::FileReport;
use super::spelling::shown;
use super::table::ColumnRef;
use super::{identity, once, unit};
use regex::Regex;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use zwidth_store::{GAPS, LOST, StoreError, Sweep, hex_blake3, sweep_bytes};
use zwidth_study::{ActuatorId, Source};

/// One sweep of a file, its values converted, its number there where the mapping gives it.
pub(super) struct Piece {
    pub(super) actuator: ActuatorId,
    pub(super) number: Option<u32>,
    pub(super) t_s: Option<Vec<f64>>,
    pub(super) command: Vec<f64>,
    pub(super) response: Vec<f64>,
    /// Samples that it lacks between its first and its last, in words.
    pub(super) gaps: Option<String>,
}

/// Converts every file and numbers the sweeps of each actuator in the order of the files.
pub(super) fn sweeps(
    context: &Context,
    sweep: &SweepFrom,
    files: &[PathBuf],
) -> Result<Batch, Errors> {
    let budget = Budget::default();
    let (columns, pattern) = match &sweep.form {
        SweepForm::Pairs(form) => (form.columns(), None),
        SweepForm::Wide(form) => (Vec::new(), Some(&form.pattern)),
    };
    let columns = columns.into_iter().chain(sweep.label_columns()).collect();
    let take = Take { pattern, ..context.take(columns, &budget) };
    let converted = context.convert(files, &take, |recording| match &sweep.form {
        SweepForm::Pairs(form) => pairs(context, sweep, form, &budget, recording),
        SweepForm::Wide(form) => wide(context, sweep, form, recording),
    })?;
    once::sweeps(context, &converted)?;
    let mut batch = Batch::default();
    let mut last = BTreeMap::new();
    let mut taken = BTreeSet::new();
    let mut results = Vec::new();
    let mut cases = once::existing_actuators(context)?;
    for Converted { path: file, blake3, parsed: (pieces, mut report) } in converted {
        let mut footer = context.footer(blake3, &report.computed);
        footer.extend(report.lost.clone().map(|lost| (LOST.to_owned(), lost)));
        let source = context.mapping.source();
        for piece in pieces {
            let number = identity::next(&mut last, piece.actuator.clone(), piece.number);
            report.made.push(format!(
                "sweep {number} of {}: {} samples",
                piece.actuator,
                piece.command.len()
            ));
            let actuator = piece.actuator.clone();
            let path = context.layout.sweep(&actuator, number);
            // Neither a file of this import nor one of the study may have the number.
            let free = taken.insert(path.clone()) && context.files.kind(&path).is_none();
            let bytes = match cases.add("", actuator.as_str()) {
                Some(other) => {
                    let what = format!(
                        "actuator '{actuator}' differs only by case from '{other}', which is there"
                    );
                    let remedy = "write it as it is written there, or choose another id";
                    Err(StoreError::new(&file, what, remedy))
                }
                None if free => encode(sweep, piece, number, source, &footer, &file),
                None => {
                    let shown = context.layout.shown(&path).display().to_string();
                    let what = format!("duplicate sweep: {shown} exists already");
                    let remedy = "give the sweep another number in [sweep], or leave the file out";
                    Err(StoreError::new(&file, what, remedy))
                }
            };
            results.push(bytes.map(|bytes| {
                batch.sweeps.push((actuator, number, hex_blake3(&bytes)));
                (path, bytes.into())
            }));
        }
        batch.files.push(report);
    }
    // Only now, so that every problem of every file is reported at once.
    batch.outputs = all(results)?;
    Ok(batch)
}

/// One sweep's file; `path` names the recording in errors.
fn encode(
    from: &SweepFrom,
    piece: Piece,
    number: u32,
    source: Source,
    footer: &BTreeMap<String, String>,
    path: &Path,
) -> Result<Vec<u8>, StoreError> {
    let mut file = footer.clone();
    file.extend(piece.gaps.map(|gaps| (GAPS.to_owned(), gaps)));
    let sweep = Sweep {
        actuator: piece.actuator,
        sweep: number,
        source,
        command: from.command.quantity.clone(),
        response: from.response.quantity.clone(),
        t_s: piece.t_s,
        command_values: piece.command,
        response_values: piece.response,
        file,
    };
    sweep_bytes(&sweep, path)
}

/// A row a sample; consecutive rows with equal labels are one sweep.
fn pairs(
    context: &Context,
    sweep: &SweepFrom,
    form: &Pairs,
    budget: &Budget,
    recording: &mut Recording,
) -> Result<(Vec<Piece>, FileReport), Errors> {
    let numeric = all(form.columns().into_iter().map(|c| recording.find(c)))?;
    let mut time = None;
    if let Some(Time::Column { column, mend }) = &form.time {
        // The time is the last of the columns.
        let told =
            recording.check_unit(numeric[2], column.unit, &column.unit_text, &column.line)?;
        recording.table.told.extend(told);
        let column = TimeColumn::of(column, *mend);
        recording.read_clock(column, column.from_first)?;
        time = Some(column);
    }
    let label_columns = all(sweep.label_columns().map(|c| recording.find(c)))?;
    let mut rows = recording.rows(&context.mapping.file, &numeric, &label_columns)?;
    if let Some(time) = time {
        recording.mend(time, &mut rows, &numeric, &label_columns)?;
    }
    let at_a_rate = matches!(form.time, Some(Time::Rate { .. }));
    // Counted before anything is made of them.
    budget.trials(&recording.path, recording.pieces(&rows.kept, &label_columns).count())?;
    let stretches = recording.pieces(&rows.kept, &label_columns);
    let pieces = all(stretches.map(|stretch| {
        let (actuator, number) = sweep.labels(recording, stretch[0])?;
        let t_s = match &form.time {
            None => None,
            Some(Time::Rate { rate_hz }) => Some(rate_times(*rate_hz, recording.places(stretch))),
            Some(Time::Column { column, .. }) => {
                let factor = column.unit.to_si;
                let t = recording.converted(numeric[2], stretch, &column.line, factor)?;
                check_time(&t).map_err(|(i, what)| {
                    let remedy = "check the unit of the time";
                    recording.cell_error(numeric[2], stretch[i], &what, remedy)
                })?;
                if let Some(i) = t.windows(2).position(|pair| pair[1] <= pair[0]) {
                    let what = "time runs backwards or stands still";
                    let remedy = "sort or mend the recording";
                    return Err(recording.cell_error(numeric[2], stretch[i + 1], what, remedy));
                }
                Some(t)
            }
        };
        let command = recording.converted(numeric[0], stretch, &sweep.command.line, 1.0)?;
        let response = recording.converted(numeric[1], stretch, &sweep.response.line, 1.0)?;
        let gaps = recording.gaps(&rows, stretch);
        let empty = if at_a_rate { gaps.empty } else { 0 };
        let gaps = Gaps { empty, ..gaps }.in_words(stretch.len());
        Ok::<_, StoreError>(Piece { actuator, number, t_s, command, response, gaps })
    }))?;
    let used = [numeric.as_slice(), &label_columns].concat();
    let mut report = context.file_report(recording, &rows, rows.kept.len(), &used)?;
    let why = if at_a_rate { EMPTY_AT_A_RATE } else { EMPTY };
    report.add_empty(recording.gaps(&rows, &rows.kept).empty, why);
    match &form.time {
        Some(Time::Rate { rate_hz }) => report.computed.push(rate_words(*rate_hz)),
        Some(Time::Column { column, mend }) => {
            report.computed.extend(column.line.words().map(|words| format!("t_s = {words}")));
            report.computed.extend(mend.words());
        }
        None => report.null.push("t_s".to_owned()),
    }
    let sides =
        [("command", &form.command, &sweep.command), ("response", &form.response, &sweep.response)];
    for (place, (side, from, q)) in numeric.iter().zip(sides) {
        let text = &q.quantity.unit;
        if let Some(unit) = unit::declared(text) {
            report.told.extend(recording.check_unit(*place, unit, text, &q.line)?);
        }
        note(&mut report, side, &from.to_string(), q);
    }
    Ok((pieces, report))
}

/// Says in the report where a quantity came from, and what was done to it.
fn note(report: &mut FileReport, side: &str, from: &str, q: &QuantityFrom) {
    let words = q.line.words();
    let line = words.as_ref().map(|w| format!(", {w}")).unwrap_or_default();
    report
        .converted
        .push(format!("{side} ({}, {}) ← {from}{line}", q.quantity.name, q.quantity.unit));
    report.computed.extend(words.map(|w| format!("{side} = {w}")));
}

impl SweepFrom {
    /// The columns that labels come from.
    fn label_columns(&self) -> impl Iterator<Item = &ColumnRef> {
        std::iter::once(&self.actuator).chain(&self.number).filter_map(Label::column)
    }

    /// Whose sweep begins with `row`, and which number it has where the mapping gives it.
    fn labels(
        &self,
        recording: &Recording,
        row: usize,
    ) -> Result<(ActuatorId, Option<u32>), StoreError> {
        let actuator = self.actuator.value("actuator", recording, row, identity::id)?;
        let number = self.number.as_ref().map(|label| {
            label.value("sweep", recording, row, |text| identity::number("sweep", text))
        });
        Ok((actuator, number.transpose()?))
    }
}

/// The one sweep of a wide file: a sample a cell, or a sample a column where it is reduced.
fn wide(
    context: &Context,
    sweep: &SweepFrom,
    form: &Wide,
    recording: &Recording,
) -> Result<(Vec<Piece>, FileReport), Errors> {
    let columns = header_values(&form.pattern, recording)?;
    let places: Vec<usize> = columns.iter().map(|(place, _)| *place).collect();
    let label_columns = all(sweep.label_columns().map(|c| recording.find(c)))?;
    let rows = recording.rows(&context.mapping.file, &places, &label_columns)?;
    let samples = all(columns.iter().map(|(place, value)| {
        let cells = recording.numbers(*place, &rows.kept)?;
        let cells = if form.reduce == Some(Reduce::Mean) { vec![mean(&cells)] } else { cells };
        Ok::<_, StoreError>(cells.into_iter().map(|cell| (*value, cell)).collect::<Vec<_>>())
    }))?;
    let (headers, cells): (Vec<f64>, Vec<f64>) = samples.into_iter().flatten().unzip();
    let used = [places, label_columns].concat();
    let mut report = context.file_report(recording, &rows, rows.kept.len(), &used)?;
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
        [("command", &sweep.command, &mut command), ("response", &sweep.response, &mut response)]
    {
        q.line.apply_to_all(values, 1.0);
        let from = if side == cells_are { "the cells" } else { "the number in the header" };
        note(&mut report, side, &format!("{from} of the columns '{}'", form.pattern), q);
    }
    // A wide file is one sweep: any row says whose.
    let (actuator, number) = sweep.labels(recording, rows.kept[0])?;
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
    let values = values.collect::<Result<Vec<_>, _>>()?;
    if values.is_empty() {
        let what = format!("no header matches the pattern '{pattern}'");
        return Err(recording.error(what, "mend the pattern in [wide], or header in [file]"));
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::super::world::World;
    use zwidth_store::{Sweep, read_sweep};

    const PAIRS: &str = "
kind = \"sweeps\"
[sweep]
actuator = \"brake\"
[command]
name = \"voltage\"
unit = \"V\"
from = \"u\"
[response]
name = \"brake torque\"
unit = \"mN·m\"
from = \"adc\"
zero = \"first\"
scale = 0.5
sign = -1
";

    fn sweep(world: &World, number: u32) -> Sweep {
        read_sweep(&world.layout.sweep(&"brake".parse().unwrap(), number)).unwrap()
    }

    #[test]
    fn a_row_a_sample_keeps_the_units_named_and_says_what_was_done() {
        let world = World::new();
        let file = world.file("a.csv", "u,adc,x\n0,100,1\n1,98,1\n2,90,1\n");
        let report = world.import(PAIRS, &[file]).unwrap();
        assert_eq!((report.sweeps, report.trials, report.sessions), (1, 0, 0));
        let sweep = sweep(&world, 1);
        assert_eq!((sweep.command.unit.as_str(), sweep.response.unit.as_str()), ("V", "mN·m"));
        assert_eq!(sweep.command_values, [0.0, 1.0, 2.0]);
        assert_eq!(sweep.response_values, [-0.0, 1.0, 5.0]);
        assert_eq!(sweep.t_s, None);
        assert_eq!(sweep.file["made_by_import"], "response = −0.5 (x − first x)");
        assert_eq!(report.files[0].columns_dropped[0].column, "x");
        world.load();
    }

    #[test]
    fn sweeps_are_numbered_in_file_order_or_by_the_mapping_and_may_have_a_time() {
        let world = World::new();
        let file = |n: &str, last| world.file(n, format!("u,adc,ms,n\n0,1,0,7\n1,{last},500,7\n"));
        let files = [file("a.csv", 1), file("b.csv", 2), file("c.csv", 3), file("d.csv", 4)];
        let map = format!("{PAIRS}[time]\nfrom = \"ms\"\nunit = \"ms\"\n");
        world.import(&map, &files[..2]).unwrap();
        assert_eq!(sweep(&world, 2).t_s.unwrap(), [0.0, 0.5]);
        let given = PAIRS.replace("[command]", "sweep = { column = \"n\" }\n[command]");
        world.import(&given, &files[2..3]).unwrap();
        assert_eq!(sweep(&world, 7).sweep, 7);
        let errors = world.import(&given, &files[3..]).unwrap_err();
        assert!(errors[0].what.contains("duplicate sweep"), "{errors:?}");
    }

    #[test]
    fn bad_sweeps_are_refused_with_column_and_row() {
        let world = World::new();
        let timed = format!("{PAIRS}[time]\nfrom = \"t\"\nunit = \"s\"\n");
        let path = PAIRS.replace("\"brake\"", "\"../x\"");
        let wild = WIDE.replace("-?[0-9.]+", ".+");
        for (map, csv, words, at) in [
            (PAIRS, "u,adc\n0,1\n1,x\n", "'x' is not a number (line 3)", Some(("adc", 2))),
            (PAIRS, "u,adc\n", "0 rows", None),
            (timed.as_str(), "u,adc,t\n0,1,1\n1,1,0.5\n", "time runs backwards", Some(("t", 2))),
            (timed.as_str(), "u,adc,t\n0,1,1\n1,1,1e9\n", "more than a day", Some(("t", 2))),
            (path.as_str(), "u,adc\n0,1\n", "'../x' is not a valid actuator id", None),
            (WIDE, "deg_1_1,deg_2_2\n1,2\nNaN,2\n", "NaN is not a number", Some(("deg_1_1", 2))),
            (WIDE, "a,b\n1,2\n", "no header matches", None),
            (wild.as_str(), "deg_x_1\n1\n", "'x' in the header is not a number", None),
        ] {
            world.refuses(map, &world.file("a.csv", csv), words, at);
        }
    }

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
        assert_eq!(sweep(&world, 1).command_values, [-1.5, -1.5, 2.0, 2.0]);
        assert_eq!(sweep(&world, 1).response_values, [2.0, 3.0, 4.0, 6.0]);
        assert_eq!(report.files[0].rows_dropped[0].why, "after the first 2 (rows = 2)");

        let world = World::new();
        let mean = WIDE.replace("[command]", "reduce = \"mean\"\n[command]");
        world.import(&mean, &[world.file("a.csv", csv)]).unwrap();
        assert_eq!(sweep(&world, 1).command_values, [-1.5, 2.0]);
        assert_eq!(sweep(&world, 1).response_values, [2.5, 5.0]);
        let made = &sweep(&world, 1).file["made_by_import"];
        assert!(made.contains("response = mean of 2 rows of each column"), "{made}");
    }
}
