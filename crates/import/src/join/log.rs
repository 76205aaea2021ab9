//! The row of a log that belongs to each row of a recording: by the number of the trial, or by time.

use super::super::check_beside::LOG;
use super::super::errors::Errors;
use super::super::identity::counted;
use super::super::label::Label;
use super::super::mapping::{At, ClockFrom, LogFrom, RowBy};
use super::super::recording::{JoinedColumn, Recording};
use super::super::spelling::plain;
use super::super::table::{Cells, ColumnRef, NO_ROW};
use super::named::{Named, add};
use super::times::{self, lasts, span};

use std::collections::BTreeMap;
use std::sync::Arc;
use zwidth_store::StoreError;

/// The use that a recording makes of a log.
#[derive(Debug)]
pub(super) struct LogUse {
    pub(super) log: Arc<Recording>,
    /// The rows that may be those of trials, each with what it is found by, in words.
    pub(super) rows: BTreeMap<u32, String>,
    /// The row of each row of the recording.
    pub(super) of: Arc<Vec<u32>>,
    /// Whether rows without a trial are left as they are.
    pub(super) drops_unmatched: bool,
}

impl LogUse {
    /// The row of the log that belongs to a row of the recording, in words.
    pub(super) fn words(&self, row: usize) -> Option<String> {
        let row = self.of.get(row).filter(|row| **row != NO_ROW)?;
        let by = self.rows.get(row).map(|by| format!(" ({by})")).unwrap_or_default();
        Some(format!("{} of the log {}{by}", self.log.row_name(*row as usize), self.log.blake3))
    }
}

/// Adds the columns of a log to a recording, of which `labels` part the trials as far as it says so itself.
///
/// # Errors
/// Two rows for a trial, none for one, none within the recording.
pub(super) fn join(
    named: &Named,
    from: &LogFrom,
    recording: &mut Recording,
    log: &Arc<Recording>,
    labels: &[usize],
    times: &[f64],
    height: usize,
) -> Result<LogUse, Errors> {
    let candidates = candidates(from, recording, log)?;
    let (of, rows) = match &from.by {
        RowBy::Number { column, add, recording: label } => {
            let keys = numbers(log, column, *add, &candidates)?;
            let words = keys.iter().map(|(number, row)| {
                let there = number - add;
                (*row, format!("{column} = {there}"))
            });
            let words: BTreeMap<u32, String> = words.collect();
            let numbers = trials_of(named, recording, label.as_ref(), labels, height)?;
            (by_number(from, recording, log, &keys, &numbers, column, *add)?, words)
        }
        RowBy::Time { clock, offset_s, at, until } => {
            let moments = moments(log, clock, *offset_s, until.as_ref(), &candidates)?;
            let words = moments
                .iter()
                .map(|moment| (moment.row, format!("at {:.6} s of the recording", moment.begin)));
            let words: BTreeMap<u32, String> = words.collect();
            let at = *at;
            (by_time(from, recording, log, &moments, at, labels, times)?, words)
        }
    };
    let of = Arc::new(of);
    if matches!(&from.by, RowBy::Time { at: At::Begin | At::End, .. }) {
        recording.joined.keep(height, |row| of[row] != NO_ROW);
    }
    recording.joined.parts = Some(Arc::clone(&of));
    for (name, column) in named.of(LOG) {
        if recording.table.names.iter().flatten().any(|other| other == name)
            && is_joined(recording, name)
        {
            continue;
        }
        let place = log.find(&column)?;
        let cells = Cells::Joined {
            cells: Arc::new(log.table.columns[place].clone()),
            rows: Arc::clone(&of),
        };
        let unit = log.table.units.get(&place).cloned();
        let own = add(recording, name, cells, unit)?;
        let joined = JoinedColumn { log: Arc::clone(log), place, rows: Arc::clone(&of) };
        recording.joined.columns.insert(own, joined);
    }
    Ok(LogUse { log: Arc::clone(log), rows, of, drops_unmatched: from.drops_unmatched })
}

/// Whether a column of this name was joined already: several labels may come from one.
fn is_joined(recording: &Recording, name: &str) -> bool {
    let names = recording.table.names.iter().flatten().enumerate();
    let mut places = names.filter(|(_, other)| *other == name).map(|(place, _)| place);
    places.any(|place| recording.joined.columns.contains_key(&place))
}

/// The rows of a log that may be those of trials of a recording: by what the mapping says of their words.
fn candidates(
    from: &LogFrom,
    recording: &Recording,
    log: &Recording,
) -> Result<Vec<usize>, StoreError> {
    let height = log.table.columns.iter().map(Cells::len).max().unwrap_or(0);
    let mut rows: Vec<usize> = (0..height).collect();
    let cell = |place: usize, row: usize| log.table.columns[place].cell(row).to_string();
    for (column, label) in &from.only {
        let word = label.value("label", recording, 0, |word| Ok(word.to_owned()))?;
        let place = log.find(column)?;
        let before = rows.len();
        rows.retain(|row| is_same(cell(place, *row).trim(), &word));
        if rows.is_empty() && before > 0 {
            let what =
                format!("no row has '{word}', which is that of {}", recording.path.display());
            let remedy = "mend what `where` in [log] says, or leave the recording out";
            return Err(log.error(what, remedy).column(column.to_string()));
        }
    }
    for (column, words) in &from.when {
        let place = log.find(column)?;
        rows.retain(|row| words.iter().any(|word| is_same(cell(place, *row).trim(), word)));
    }
    if rows.is_empty() {
        let remedy = "check `when` in [log], or leave the recording out";
        return Err(log.error("it has no row that may be that of a trial", remedy));
    }
    Ok(rows)
}

/// Whether two words say the same: `7`, `07` and `7.0` do.
fn is_same(a: &str, b: &str) -> bool {
    let [a, b] = [plain(a), plain(b)];
    let numbers = a.parse::<f64>().ok().zip(b.parse::<f64>().ok());
    a == b || numbers.is_some_and(|(a, b)| a.to_bits() == b.to_bits())
}

/// The rows by their numbers of trials, as the recordings count them. A row without one is of another screen.
fn numbers(
    log: &Recording,
    column: &ColumnRef,
    add: i64,
    candidates: &[usize],
) -> Result<BTreeMap<i64, u32>, StoreError> {
    let place = log.find(column)?;
    let mut rows = BTreeMap::new();
    for row in candidates {
        let remedy = "mend the cell, or name another column as trial in [log]";
        let number =
            log.number(place, *row).map_err(|what| log.cell_error(place, *row, &what, remedy))?;
        let Some(number) = number else { continue };
        let whole = counted("trial", &number.to_string());
        let whole = whole.map_err(|what| log.cell_error(place, *row, &what, remedy))?;
        let number = i64::from(whole) + add;
        if let Some(first) = rows.insert(number, *row as u32) {
            let what = format!(
                "{} has the number {whole} too: a trial has one row",
                log.row_name(first as usize)
            );
            let remedy = "name the participant or the block in `where` of [log], the screen in `when`, or remove a row";
            return Err(log.cell_error(place, *row, &what, remedy));
        }
    }
    Ok(rows)
}

/// The number of the trial of each row of a recording: that of its label, or counted within the file.
fn trials_of(
    named: &Named,
    recording: &Recording,
    label: Option<&Label>,
    labels: &[usize],
    height: usize,
) -> Result<Vec<i64>, StoreError> {
    let rows: Vec<usize> = (0..height).collect();
    let mut numbers = Vec::with_capacity(height);
    if let Some(label) = label {
        let parting: Vec<usize> =
            label.column().map(|column| recording.find(column)).transpose()?.into_iter().collect();
        for piece in recording.pieces(&rows, &parting) {
            let number = label
                .value("number of a trial", recording, piece[0], |text| counted("trial", text))?;
            numbers.extend(piece.iter().map(|_| i64::from(number)));
        }
        return Ok(numbers);
    }
    let time = named.plan.time.filter(|_| named.splits_at);
    let time = time.map(|time| recording.find(time.from)).transpose()?;
    let mut number = 0;
    for piece in recording.pieces(&rows, labels) {
        let parts: Vec<&[usize]> = match time {
            Some(time) => recording.restarts(piece, time).collect(),
            None => vec![piece],
        };
        for part in parts {
            number += 1;
            numbers.extend(part.iter().map(|_| number));
        }
    }
    Ok(numbers)
}

fn by_number(
    from: &LogFrom,
    recording: &Recording,
    log: &Recording,
    keys: &BTreeMap<i64, u32>,
    numbers: &[i64],
    column: &ColumnRef,
    add: i64,
) -> Result<Vec<u32>, StoreError> {
    let missing = numbers.iter().position(|number| !keys.contains_key(number));
    if let Some(row) = missing.filter(|_| !from.drops_unmatched) {
        let number = numbers[row];
        let there = match (keys.keys().next(), keys.keys().next_back()) {
            (Some(first), Some(last)) => {
                format!("has {} to {} in {column}", first - add, last - add)
            }
            _ => format!("has no number in {column}"),
        };
        let what = format!(
            "its trial {number} has no row in the log {}, which {there}{}",
            log.path.display(),
            if add == 0 { String::new() } else { format!(", to which {add} is added") }
        );
        // The usual reason: one of the two counts from 0.
        let remedy = match (keys.keys().next(), keys.keys().next_back()) {
            (_, Some(last)) if last + 1 == number && keys.contains_key(&(number - 1)) => {
                format!(
                    "if the log counts from 0 and the recordings from 1, set add = {} in [log]",
                    add + 1
                )
            }
            (Some(first), _) if first - 1 == number && keys.contains_key(&(number + 1)) => {
                format!(
                    "if the log counts from 1 and the recordings from 0, set add = {} in [log]",
                    add - 1
                )
            }
            _ => {
                "leave the recording out, or keep it without a row by unmatched = \"drop\" in [log]"
                    .to_owned()
            }
        };
        return Err(recording.row_error(row, &what, &remedy));
    }
    Ok(numbers.iter().map(|number| keys.get(number).copied().unwrap_or(NO_ROW)).collect())
}

/// When a row of a log was, on the clock of the recording, s.
struct Moment {
    begin: f64,
    end: f64,
    row: u32,
}

/// The rows by their times. A row without one is of another screen.
fn moments(
    log: &Arc<Recording>,
    clock: &ClockFrom,
    offset_s: f64,
    until: Option<&ColumnRef>,
    candidates: &[usize],
) -> Result<Vec<Moment>, StoreError> {
    let place =
        times::column(clock).map(|column| log.find(column)).transpose()?.unwrap_or_default();
    let height = log.table.columns[place].len();
    // Times may be texts of clocks, which are read in the place of the column.
    let mut own = log.alone(place);
    let begins = times::of_file(&mut own, clock, offset_s, height)?;
    let ends = match (until, clock) {
        (Some(until), ClockFrom::Column { unit, from_first, .. }) => {
            let end = log.find(until)?;
            let mut own = log.alone(end);
            // From the same zero as the beginnings: the first of these.
            let clock = ClockFrom::Column { from: until.clone(), unit, from_first: false };
            let ends = times::of_file(&mut own, &clock, offset_s, height)?;
            let zero = if *from_first { own_zero(log, place, unit.to_si) } else { 0.0 };
            Some(ends.into_iter().map(|end| end - zero).collect::<Vec<f64>>())
        }
        _ => None,
    };
    let mut moments = Vec::new();
    for row in candidates {
        let begin = begins[*row];
        if begin.is_nan() {
            continue;
        }
        let end = ends.as_ref().map_or(f64::INFINITY, |ends| ends[*row]);
        if end.is_nan() || end < begin {
            let what = "the trial ends before it begins, or has no end";
            return Err(log.row_error(*row, what, "check time and until in [log]"));
        }
        moments.push(Moment { begin, end, row: *row as u32 });
    }
    moments.sort_by(|a, b| a.begin.total_cmp(&b.begin));
    if let Some(pair) = moments.windows(2).find(|pair| pair[0].begin >= pair[1].begin) {
        let first = log.row_name(pair[0].row as usize);
        let what = format!("{first} has the same time: a trial has one row");
        let remedy = "name the screen in `when` of [log], or remove a row";
        return Err(log.row_error(pair[1].row as usize, &what, remedy));
    }
    Ok(moments)
}

/// The first time in a column, s.
fn own_zero(log: &Recording, place: usize, to_si: f64) -> f64 {
    let rows = 0..log.table.columns[place].len();
    let mut known = rows.filter_map(|row| log.number(place, row).ok().flatten());
    known.next().unwrap_or(0.0) * to_si
}

fn by_time(
    from: &LogFrom,
    recording: &Recording,
    log: &Recording,
    moments: &[Moment],
    at: At,
    labels: &[usize],
    times: &[f64],
) -> Result<Vec<u32>, StoreError> {
    let Some([first, last]) = span(times) else {
        return Err(recording
            .error("it has no times, by which its log is to be joined", "name them in [time]"));
    };
    let inside = |from: f64, to: f64| {
        let begin = moments.partition_point(|moment| moment.begin < from);
        let end = moments.partition_point(|moment| moment.begin <= to);
        &moments[begin..end]
    };
    let own = inside(first, last);
    if own.is_empty() {
        let of_log = match (moments.first(), moments.last()) {
            (Some(first), Some(last)) => lasts([first.begin, last.begin]),
            _ => "no time at all".to_owned(),
        };
        let what = format!(
            "no row of the log {} lies within it: it lasts from {}, and the log, with offset_s, from {of_log}",
            log.path.display(),
            lasts([first, last])
        );
        let remedy = "check offset_s and unit in [log], and that the log is that of this recording";
        return Err(recording.error(what, remedy));
    }
    let row_at = |time: f64| {
        let moment = match at {
            At::Begin => {
                let next = own.partition_point(|moment| moment.begin <= time);
                next.checked_sub(1).map(|i| &own[i]).filter(|moment| time <= moment.end)
            }
            At::End | At::Within => own.get(own.partition_point(|moment| moment.begin < time)),
        };
        moment.map_or(NO_ROW, |moment| moment.row)
    };
    if at != At::Within {
        let row_of = |time: &f64| if time.is_nan() { NO_ROW } else { row_at(*time) };
        return Ok(times.iter().map(row_of).collect());
    }
    let rows: Vec<usize> = (0..times.len()).collect();
    let mut of = Vec::with_capacity(rows.len());
    for piece in recording.pieces(&rows, labels) {
        let here = span(&times[piece[0]..=piece[piece.len() - 1]]);
        let row = match here.map(|[first, last]| inside(first, last)).unwrap_or_default() {
            [only] => only.row,
            [] if from.drops_unmatched => NO_ROW,
            [] => {
                let what = format!("the trial has no row in the log {}", log.path.display());
                let remedy = "leave the recording out, or keep it without a row by unmatched = \"drop\" in [log]";
                return Err(recording.row_error(piece[0], &what, remedy));
            }
            [first, second, ..] => {
                let [first, second] =
                    [first, second].map(|moment| log.row_name(moment.row as usize));
                let what = format!(
                    "two rows of the log {} lie within the trial: {first} and {second}",
                    log.path.display()
                );
                let remedy = "name the screen in `when` of [log]; if each row is a trial, set at = \"begin\"";
                return Err(recording.row_error(piece[0], &what, remedy));
            }
        };
        of.extend(piece.iter().map(|_| row));
    }
    Ok(of)
}
