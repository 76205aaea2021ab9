//! The times by which files are joined.

use super::super::convert::Linear;
use super::super::mapping::{ClockFrom, Mend};
use super::super::mend::unwrap_times;
use super::super::plan::{Plan, TimeColumn};
use super::super::recording::Recording;
use super::super::table::ColumnRef;
use zwidth_store::StoreError;

/// The column of times, where there is one.
pub(super) fn column(clock: &ClockFrom) -> Option<&ColumnRef> {
    match clock {
        ClockFrom::Column { from, .. } => Some(from),
        ClockFrom::Rate { .. } => None,
    }
}

/// The times of a recording's rows as its mapping has them, s, counted from its first row where it says
/// `zero = "first"`; not a number where there is none.
///
/// # Errors
/// Times that run backwards: which of two moments is meant nobody knows.
pub(super) fn of_recording(
    recording: &Recording,
    plan: &Plan,
    height: usize,
) -> Result<Vec<f64>, StoreError> {
    if let Some(rate_hz) = plan.rate_hz {
        return Ok((0..height).map(|row| recording.table.place(row) as f64 / rate_hz).collect());
    }
    let Some((taken, time)) = plan.taken.first().zip(plan.time) else { return Ok(Vec::new()) };
    let place = recording.find(time.from)?;
    let rows: Vec<usize> =
        (0..height).filter(|row| matches!(recording.number(place, *row), Ok(Some(_)))).collect();
    let mut known = recording.numbers(place, &rows)?;
    if let Some(wrap) = time.mend.wrap {
        unwrap_times(&mut known, wrap, time.mend.counts_at_hz.is_some());
    }
    let line: &Linear = &taken.line;
    line.apply_to_all(&mut known, taken.factor);
    if let Some(at) = known.windows(2).position(|pair| pair[1] < pair[0]) {
        let what = "its times run backwards, and files are joined by times that go on";
        let remedy = "join the log by number, or give a file per trial";
        return Err(recording.cell_error(place, rows[at + 1], what, remedy));
    }
    let mut times = vec![f64::NAN; height];
    rows.iter().zip(known).for_each(|(row, time)| times[*row] = time);
    Ok(times)
}

/// The times of rows of another file, s, on the clock of the recording; not a number where there is none.
///
/// # Errors
/// A cell that is no time.
pub(super) fn of_file(
    file: &mut Recording,
    clock: &ClockFrom,
    offset_s: f64,
    height: usize,
) -> Result<Vec<f64>, StoreError> {
    let (from, unit, from_first) = match clock {
        ClockFrom::Rate { rate_hz } => {
            let times = (0..height).map(|row| file.table.place(row) as f64 / rate_hz + offset_s);
            return Ok(times.collect());
        }
        ClockFrom::Column { from, unit, from_first } => (from, *unit, *from_first),
    };
    file.read_clock(TimeColumn { from, unit, from_first, mend: Mend::default() }, from_first)?;
    let place = file.find(from)?;
    let mut first = None;
    let mut times = Vec::with_capacity(height);
    for row in 0..height {
        let time = file.number(place, row).map_err(|what| {
            file.cell_error(place, row, &what, "mend the cell, or name another column of times")
        })?;
        if first.is_none() {
            first = time;
        }
        let zero = if from_first { first } else { Some(0.0) };
        times.push(match time.zip(zero) {
            Some((time, zero)) => (time - zero) * unit.to_si + offset_s,
            None => f64::NAN,
        });
    }
    Ok(times)
}

/// The first and the last of these times; nothing if there is none.
pub(super) fn span(times: &[f64]) -> Option<[f64; 2]> {
    let mut known = times.iter().copied().filter(|time| !time.is_nan());
    let first = known.next()?;
    let last = known.next_back().unwrap_or(first);
    Some([first, last])
}

/// A span of times, in words.
pub(super) fn lasts([first, last]: [f64; 2]) -> String {
    format!("{first:.6} s to {last:.6} s")
}
