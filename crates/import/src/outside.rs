//! Values of metrics that another program computed: a table with one row per trial and fixed column
//! names, without a mapping file, checked against the trials that there are.

use super::guess_read::{Looked, look};
use super::known_trials::StudyTrials;
use super::mapping::CellForm;
use super::named_trial::{Header, TrialColumns};
use super::recording::{Recording, number};
use super::table::Cell;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_results::OutsideValue;
use zwidth_store::{FirstErrors, StoreError};
use zwidth_study::{OutsideMetric, ParticipantId, SessionId};

/// The remedy for a wrong row.
const MEND: &str = "mend the row, or remove it; nothing was written";
/// The remedy for a column that is missing.
const NAMES: &str = "name the columns participant, session, trial (or environment, mode and repeat) and value in its first line";

/// The values of `metrics` in a table of any format that an import reads, one list for each, with a row for each row of the
/// table in its order. The table has the columns participant, session, trial (or environment, mode and repeat), in any order
/// and among others, and one for each metric, which bears its id or the name of its column. That of a single metric may be
/// called `value`, or be the only other one. A cell that is empty, or holds a mark of a missing value (`NA`), is no value.
///
/// # Errors
/// A file that cannot be read or has no rows; a column that is missing; each row that names no recorded trial of `trials`, names
/// one that a row before it named, says something of it that is not so, or has a value that is no finite number. `session` is
/// the one of a table without such a column.
pub fn outside_values(
    path: &Path,
    metrics: &[OutsideMetric],
    trials: &StudyTrials,
    session: Option<&SessionId>,
) -> Result<Vec<Vec<OutsideValue>>, FirstErrors> {
    // There is no mapping: as for a guess, the text itself shows how it is written.
    let Looked { table, written, .. } = look(path)?;
    let decimal_comma = written.is_some_and(|written| written.decimal_comma);
    let cells = CellForm { decimal_comma, ..CellForm::default() };
    let recording = Recording::part(path, table, cells, BTreeMap::new());
    let header = Header::of(&recording, NAMES);
    let twice = header.names.iter().enumerate().find(|(i, name)| header.names[..*i].contains(name));
    if let Some((_, name)) = twice {
        let what = format!("two columns are called '{name}', but for capital letters");
        return Err(recording.error(what, "give each column a name of its own").into());
    }
    let named = TrialColumns::of(&header)?;
    let columns = metrics.iter().map(|metric| column_of(&header, metric, metrics.len() == 1));
    let columns = columns.collect::<Result<Vec<usize>, _>>()?;
    let mut values: Vec<Vec<OutsideValue>> = vec![Vec::new(); metrics.len()];
    let mut seen: BTreeMap<(ParticipantId, SessionId, u32), usize> = BTreeMap::new();
    let mut errors = FirstErrors::default();
    let mut bad = recording.table.bad.iter().peekable();
    // A column of numbers may be shorter than the others: what is not there is no value.
    let rows = recording.table.columns.iter().map(super::table::Cells::len).max().unwrap_or(0);
    let at = columns.first().copied().unwrap_or(0);
    for row in 0..rows {
        let wrong = |what: &str| recording.cell_error(at, row, what, MEND);
        // Bad rows are in order: each is looked at once.
        if let Some((_, why)) = bad.next_if(|(bad, _)| *bad == row) {
            errors.push(wrong(why));
            continue;
        }
        let found = named.row(&recording, row, MEND).and_then(|named| {
            let (session, trial) = trials.find(&named, session).map_err(|why| wrong(&why))?;
            Ok((named.participant, session, trial))
        });
        let key = match found {
            Ok(key) => key,
            Err(error) => {
                errors.push(error);
                continue;
            }
        };
        if let Some(first) = seen.insert(key.clone(), row) {
            let (participant, session, trial) = &key;
            let first = recording.row_name(first);
            errors.push(wrong(&format!(
                "trial {trial} of {participant} {session} has a value in {first} too"
            )));
            continue;
        }
        for (own, column) in values.iter_mut().zip(&columns) {
            match value(&recording, *column, row) {
                Ok(value) => {
                    let (participant, session, trial) = key.clone();
                    own.push(OutsideValue { participant, session, trial, value });
                }
                Err(why) => errors.push(recording.cell_error(*column, row, &why, MEND)),
            }
        }
    }
    if rows == 0 {
        errors.push(recording.error("the table has no rows", "name the table of values"));
    }
    errors.none().map(|()| values)
}

/// The column of a metric.
fn column_of(header: &Header, metric: &OutsideMetric, is_only: bool) -> Result<usize, StoreError> {
    let OutsideMetric { id, column, .. } = metric;
    let named = header.find(id.as_str()).or_else(|| header.find(column.as_str()));
    let others = || {
        let is_other = |name: &&String| !TrialColumns::NAMES.contains(&name.as_str());
        header.names.iter().filter(is_other).collect::<Vec<_>>()
    };
    let of_only = || {
        let value = header.find("value");
        value.or_else(|| match others()[..] {
            [only] => header.find(only),
            _ => None,
        })
    };
    match named.or_else(|| is_only.then(of_only).flatten()) {
        Some(place) => Ok(place),
        None => header.needed(id.as_str()),
    }
}

/// The number in a cell; none in an empty one.
fn value(recording: &Recording, column: usize, row: usize) -> Result<Option<f64>, String> {
    let cell = recording.table.columns[column].cell(row);
    match cell {
        Cell::Empty => Ok(None),
        Cell::Number(value) if value.is_finite() => at_most(value),
        Cell::Number(value) => Err(not_finite(&value.to_string())),
        Cell::Text(text) if text.trim().eq_ignore_ascii_case("nan") => Err(not_finite(text)),
        Cell::Text(text) => match number(text, recording.has_decimal_comma(column, row))? {
            Some(value) => at_most(value),
            None => Ok(None),
        },
    }
}

/// The largest magnitude of a value: squares of larger ones, as in a standard deviation, are no numbers.
const LARGEST: f64 = 1e100;

fn at_most(value: f64) -> Result<Option<f64>, String> {
    match value.abs() <= LARGEST {
        true => Ok(Some(value)),
        false => {
            Err(format!("{value:e} is larger than any quantity that is measured ({LARGEST:e})"))
        }
    }
}

fn not_finite(value: &str) -> String {
    format!("'{value}' is not a finite number; a trial without a value has an empty cell")
}

#[cfg(test)]
mod tests {
    use super::super::world::World;
    use super::*;
    use zwidth_results::TrialKey;

    /// Trials 1 to 4 of P01 in S01, two repeats of a spring in two modes.
    fn trials() -> StudyTrials {
        let key = |trial: u32| TrialKey {
            participant: "P01".parse().unwrap(),
            session: "S01".parse().unwrap(),
            trial,
            repeat: trial.div_ceil(2),
            environment: "spring".parse().unwrap(),
            mode: ["hybrid", "active"][trial as usize % 2].parse().unwrap(),
            source: zwidth_study::Source::Recorded,
        };
        StudyTrials::of_keys(&[1, 2, 3, 4].map(key))
    }

    fn metric(id: &str) -> OutsideMetric {
        OutsideMetric::new(id.parse().unwrap(), "N", "grip").unwrap()
    }

    fn read(text: &str, metrics: &[&str]) -> Result<Vec<Vec<OutsideValue>>, FirstErrors> {
        let world = World::new();
        let path = world.file("values.csv", text);
        let metrics: Vec<OutsideMetric> = metrics.iter().map(|id| metric(id)).collect();
        outside_values(&path, &metrics, &trials(), None)
    }

    /// Trials and values of the one metric of a table.
    fn values(text: &str) -> Vec<(u32, Option<f64>)> {
        let mut all = read(text, &["grip_peak"]).unwrap_or_else(|e| panic!("{e:#?}"));
        all.remove(0).into_iter().map(|row| (row.trial, row.value)).collect()
    }

    /// The first error about a table.
    fn told(text: &str) -> String {
        read(text, &["grip_peak"]).err().unwrap()[0].to_string()
    }

    #[test]
    fn the_column_of_one_metric_is_its_id_its_column_value_or_the_only_other_one() {
        for name in ["grip_peak", "own_grip_peak_n", "Value", "whatever"] {
            let text = format!("participant,session,trial,{name}\nP01,S01,2,1.5\nP01,S01,1,-3\n");
            assert_eq!(values(&text), [(2, Some(1.5)), (1, Some(-3.0))], "{name}");
        }
        let text = "participant,session,trial,value,grip_peak\nP01,S01,2,0,1.5\n";
        assert_eq!(values(text), [(2, Some(1.5))]);
        let error = told("participant,session,trial,a,b\nP01,S01,2,0,1.5\n");
        assert!(error.contains("no column 'grip_peak'; the table has"), "{error}");
    }

    #[test]
    fn a_table_of_several_metrics_names_each_by_its_id() {
        let text = "participant,session,trial,b,a\nP01,S01,1,1,2\nP01,S01,2,,4\n";
        let [a, b] = &read(text, &["a", "b"]).unwrap()[..] else { panic!() };
        let values = |own: &[OutsideValue]| own.iter().map(|row| row.value).collect::<Vec<_>>();
        assert_eq!((values(a), values(b)), (vec![Some(2.0), Some(4.0)], vec![Some(1.0), None]));
        assert!(read("participant,session,trial,value\nP01,S01,1,1\n", &["a", "b"]).is_err());
    }

    #[test]
    fn a_trial_is_named_by_number_or_by_condition_and_repeat() {
        let text = "participant,session,environment,mode,repeat,value\nP01,S01,spring,active,2,7\n";
        assert_eq!(values(text), [(3, Some(7.0))]);
        let error = told("participant,session,trial,mode,value\nP01,S01,3,hybrid,7\n");
        assert!(error.contains("the table says mode hybrid, but trial 3 is of spring"), "{error}");
    }

    #[test]
    fn an_empty_cell_and_a_mark_of_a_missing_value_are_no_value() {
        for mark in ["", "NA", "null"] {
            let text = format!("participant,session,trial,value\nP01,S01,1,{mark}\nP01,S01,2,2\n");
            assert_eq!(values(&text), [(1, None), (2, Some(2.0))], "'{mark}'");
        }
    }

    #[test]
    fn what_is_no_value_of_one_recorded_trial_is_told_with_its_line() {
        for (row, words) in [
            ("P01,S01,9,1", "the session has no trial 9: they are 1 to 4"),
            ("P02,S01,1,1", "there is no session S01 of P02"),
            ("P01,S01,1,nan", "'nan' is not a finite number; a trial without a value"),
            ("P01,S01,1,inf", "'inf' is not a finite number"),
            ("P01,S01,1,-1e999", "'-1e999' is not a finite number"),
            ("P01,S01,1,much", "'much' is not a number"),
            ("P01,S01,1,-1e160", "-1e160 is larger than any quantity"),
            ("P01,S01,2,1", "trial 2 of P01 S01 has a value in line 2 too"),
            ("P01,S01,,1", "the cell is empty"),
        ] {
            let error = told(&format!("participant,session,trial,value\nP01,S01,2,2\n{row}\n"));
            assert!(error.contains(words) && error.contains("line 3"), "{row}: {error}");
            assert!(error.contains("nothing was written"), "{error}");
        }
        let error = told("participant,trial,value\nP01,1,1\n");
        assert!(error.contains("no column 'session': add it, or name one with -s"), "{error}");
        assert!(told("participant,session,trial,value\n").contains("the table has no rows"));
        let error = told("participant,session,trial,VALUE,Value\nP01,S01,1,1,2\n");
        assert!(
            error.contains("two columns are called 'value', but for capital letters"),
            "{error}"
        );
    }
}
