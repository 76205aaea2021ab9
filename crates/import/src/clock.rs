//! Times written as clock times and durations: `10:00:00.040`, `0 days 00:00:00.04`, `0.04 sec`,
//! `2026-01-31 10:00:00.04`, `PT0.04S`.

use super::mapping::CellForm;
use super::recording::number;
use super::table::{Cell, Cells};
use arrow::array::Float64Array;
use jiff::civil::{DateTime, Time};
use jiff::{Span, SpanRelativeTo, Timestamp};

/// A column of times that are not numbers in the mapping's unit.
#[derive(Debug)]
pub(super) enum Clock {
    /// Clock texts, as seconds: of the day, since 1970, or of a duration.
    Seconds(Float64Array),
    /// Whole numbers too long for a double, less the first of them, in the unit of the mapping.
    LessTheFirst(Float64Array),
}

/// A column of times, if it does not hold numbers as they are read elsewhere. Where the mapping takes
/// times from the first sample on, `from_first`, so are they here, before digits are lost: a double holds
/// nanoseconds since 1970 to a quarter of a microsecond.
///
/// # Errors
/// The row (from 0) whose cell is written otherwise than the first.
pub(super) fn clock(
    cells: &Cells,
    form: &CellForm,
    from_first: bool,
) -> Result<Option<Clock>, usize> {
    if !matches!(cells, Cells::Text(_)) {
        return Ok(None);
    }
    let mut texts = (0..cells.len()).filter_map(|row| clock_text(cells, form, row));
    let Some(first) = texts.next() else { return Ok(None) };
    // Every cell; or the row of the first that is written otherwise.
    let read = |parse: &dyn Fn(&str) -> Option<f64>| -> Result<Float64Array, usize> {
        let values = (0..cells.len()).map(|row| match clock_text(cells, form, row) {
            None => Ok(None),
            Some(text) => parse(text).map(Some).ok_or(row),
        });
        values.collect::<Result<Vec<Option<f64>>, usize>>().map(Float64Array::from)
    };
    if number(first, form.decimal_comma).is_ok() {
        // A number that a double holds is read as others are.
        let origin = first
            .parse::<i128>()
            .ok()
            .filter(|number| from_first && number.unsigned_abs() > 1 << f64::MANTISSA_DIGITS);
        let Some(origin) = origin else { return Ok(None) };
        let values = read(&|text| Some((text.parse::<i128>().ok()? - origin) as f64));
        // Other cells than whole numbers are read, or refused, as they are elsewhere.
        return Ok(values.ok().map(Clock::LessTheFirst));
    }
    let Some(origin) = nanoseconds(first) else { return Ok(None) };
    let origin = if from_first { origin } else { 0 };
    let values = read(&|text| Some((nanoseconds(text)? - origin) as f64 / 1e9))?;
    Ok(Some(Clock::Seconds(values)))
}

/// The text in a cell, unless it stands for a missing value.
fn clock_text<'a>(cells: &'a Cells, form: &CellForm, row: usize) -> Option<&'a str> {
    match cells.cell(row) {
        Cell::Text(text) if number(text, form.decimal_comma) == Ok(None) => None,
        cell if form.is_missing(&cell) => None,
        Cell::Text(text) => Some(text),
        Cell::Empty | Cell::Number(_) => None,
    }
}

/// A clock text in ns: of the day, since 1970 (in UTC, where it does not say another zone), or of a
/// duration of days of 24 hours.
fn nanoseconds(text: &str) -> Option<i128> {
    if let Ok(moment) = text.parse::<Timestamp>() {
        return Some(moment.as_nanosecond());
    }
    if let Ok(local) = text.parse::<DateTime>() {
        return Some(jiff::tz::TimeZone::UTC.to_timestamp(local).ok()?.as_nanosecond());
    }
    if let Ok(time_of_day) = text.parse::<Time>() {
        return Some(time_of_day.duration_since(Time::midnight()).as_nanos());
    }
    let span = text.parse::<Span>().ok()?;
    Some(span.to_duration(SpanRelativeTo::days_are_24_hours()).ok()?.as_nanos())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clocks_and_durations_of_many_programs_are_read() {
        for (text, expect) in [
            ("10:00:00.040", 36_000_040_000_000),
            ("10:00:00,040", 36_000_040_000_000),
            ("9:05:01", 32_701_000_000_000),
            ("36:00:00", 129_600_000_000_000),
            ("0 days 00:00:00.040000", 40_000_000),
            ("1 days 00:00:00", 86_400_000_000_000),
            ("0.04 sec", 40_000_000),
            ("40 ms", 40_000_000),
            ("1.5 min", 90_000_000_000),
            ("0 hr", 0),
            ("PT0.04S", 40_000_000),
            ("P0DT0H0M0.04S", 40_000_000),
            ("1970-01-02 00:00:00.5", 86_400_500_000_000),
            ("1970-01-01T01:00:00+01:00", 0),
            ("1970-01-01T00:00:00.000000001Z", 1),
        ] {
            assert_eq!(nanoseconds(text), Some(expect), "{text}");
        }
        for text in ["active", "", "1,2", "10h?", "4 N"] {
            assert_eq!(nanoseconds(text), None, "{text}");
        }
    }
}
