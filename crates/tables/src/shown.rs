//! A table as people see it, before any format: headings and rounded cells.

use std::collections::BTreeMap;

use crate::heading::{Part, bracketed, quantity, words};
use crate::layout::{Layout, layout};
use crate::rounding::{Decimal, rounded};
use crate::width::{Room, longest_word, widest_cell};
use crate::{Column, Field, Table, Values};

/// What stands where there is no value.
pub(crate) const MISSING: &str = "–";
/// What follows the words of an estimate that has its standard deviation beside it.
pub(crate) const WITH_SD: &str = " ± SD";
/// How names of ratios begin.
const RATIO: &str = "odds_ratio";
/// How names of p values begin.
const P_VALUE: &str = "p_";
/// A space at which no line breaks.
const NO_BREAK: char = '\u{a0}';

/// One cell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Cell {
    Missing,
    Text(String),
    Number(Decimal),
    /// Numbers that people read as one: `4.052 ± 0.002`, `[3.9, 4.2]`.
    Joined(String),
}

impl Cell {
    /// The cell in Unicode, escaped; digits alone need no escape.
    pub(crate) fn escaped(&self, escape: fn(&str) -> String) -> String {
        match self {
            Self::Number(number) if number.exponent.is_none() && !number.below => number.typeset(),
            _ => escape(&self.typeset()),
        }
    }

    /// The cell in Unicode, not yet escaped.
    pub(crate) fn typeset(&self) -> String {
        match self {
            Self::Missing => MISSING.to_owned(),
            Self::Text(text) | Self::Joined(text) => text.clone(),
            Self::Number(number) => number.typeset(),
        }
    }
}

/// One column.
#[derive(Debug, Clone)]
pub(crate) struct Shown {
    pub(crate) words: String,
    /// The unit in brackets, unless it is 1.
    pub(crate) unit: Option<String>,
    pub(crate) description: String,
    /// Whether its cells are numbers.
    pub(crate) numeric: bool,
    /// Whether these are other than whole by their kind.
    pub(crate) fractional: bool,
    pub(crate) cells: Vec<Cell>,
    /// Room for its numbers.
    pub(crate) room: Room,
    /// Width of the widest cell, in digits.
    pub(crate) widest: f64,
    /// Width of the longest word of a cell.
    pub(crate) longest_word: f64,
}

impl Shown {
    /// Words and unit.
    pub(crate) fn heading(&self) -> String {
        match &self.unit {
            Some(unit) => format!("{} {unit}", self.words),
            None => self.words.clone(),
        }
    }
}

/// A table as people see it, made once for all formats.
pub(crate) struct Seen<'a> {
    pub(crate) table: &'a Table,
    pub(crate) columns: &'a [Shown],
    pub(crate) layout: &'a Layout<'a>,
}

impl Seen<'_> {
    /// What is written of a table.
    // Takes a function and does not return `Seen`: the layout borrows from columns that end here.
    pub(crate) fn of<T>(table: &Table, digits: Option<usize>, write: impl FnOnce(&Seen) -> T) -> T {
        let columns = shown(table, digits);
        let layout = &layout(&columns);
        write(&Seen { table, columns: &columns, layout })
    }
}

/// The columns of a table, rounded to so many significant digits, or by what is known of their
/// uncertainty; an estimate with its standard deviation is one column, and so are the ends of an interval.
pub(crate) fn shown(table: &Table, digits: Option<usize>) -> Vec<Shown> {
    let all = table.columns();
    all.iter().filter_map(|column| show(column, all, digits)).collect()
}

/// The rows of columns, each cell as `set` writes it, given its column's number: once, where the
/// same text comes back in a column.
pub(crate) fn rows<'a>(
    columns: impl IntoIterator<Item = &'a Shown>,
    set: impl Fn(usize, &Cell) -> String,
) -> Vec<Vec<String>> {
    let mut rows: Vec<Vec<String>> = Vec::new();
    for (k, column) in columns.into_iter().enumerate() {
        rows.resize_with(column.cells.len(), Vec::new);
        let mut texts: BTreeMap<&str, String> = BTreeMap::new();
        for (row, cell) in rows.iter_mut().zip(&column.cells) {
            row.push(match cell {
                Cell::Text(text) => texts.entry(text).or_insert_with(|| set(k, cell)).clone(),
                _ => set(k, cell),
            });
        }
    }
    rows
}

/// One line, without control signs: what a cell, a title or a note can hold in any format.
pub(crate) fn one_line(text: &str) -> String {
    let spaced: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    spaced.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// A column as people see it; `None` where another column has it in its cells.
fn show(column: &Column, all: &[Column], digits: Option<usize>) -> Option<Shown> {
    let field = &column.field;
    let words = words(&field.name, &field.unit);
    let whole = match &column.values {
        Values::Float(values) => return show_numbers(column, values, words, all, digits),
        Values::Integer(values) => cells(values, |v| Cell::Number(Decimal::integer(*v))),
        Values::Text(values) => cells(values, |v| Cell::Text(one_line(v))),
        Values::Flag(values) => {
            cells(values, |v| Cell::Text(if *v { "yes" } else { "no" }.to_owned()))
        }
    };
    Some(of_cells(column, words, whole))
}

fn show_numbers(
    column: &Column,
    values: &[Option<f64>],
    words: String,
    all: &[Column],
    digits: Option<usize>,
) -> Option<Shown> {
    let field = &column.field;
    let part = quantity(field).1;
    let beside = match part {
        Part::Estimate => Some(Part::Sd),
        Part::Sd => Some(Part::Estimate),
        Part::CiLow => Some(Part::CiHigh),
        Part::CiHigh => Some(Part::CiLow),
        Part::StdError => None,
    };
    match (part, beside.and_then(|part| partner(field, part, all))) {
        (Part::Sd | Part::CiHigh, Some(_)) => None,
        (Part::Estimate, Some(sds)) => {
            Some(of_cells(column, words + WITH_SD, with_sd(values, sds, digits)))
        }
        (Part::CiLow, Some(highs)) => {
            let common = words.trim_end_matches("low").trim_end().to_owned();
            Some(of_cells(
                column,
                common,
                intervals(values, highs, &uncertainties(field, all), digits),
            ))
        }
        (Part::Estimate, None) if field.unit == "1" && field.name.starts_with(P_VALUE) => {
            let p_values = cells(values, |p| Cell::Number(Decimal::p_value(*p)));
            Some(of_cells(column, words, p_values))
        }
        _ => Some(of_cells(column, words, numbers(values, &uncertainties(field, all), digits))),
    }
}

fn of_cells(column: &Column, words: String, cells: Vec<Cell>) -> Shown {
    let field = &column.field;
    let room = Room::of(&cells);
    Shown {
        room,
        widest: widest_cell(&cells, room),
        longest_word: cells.iter().map(|c| longest_word(&c.typeset())).fold(0.0, f64::max),
        words,
        unit: bracketed(field),
        description: field.description.to_string(),
        numeric: matches!(column.values, Values::Float(_) | Values::Integer(_)),
        fractional: matches!(column.values, Values::Float(_)),
        cells,
    }
}

/// `4.052 ± 0.002`: both to the place of two digits of the standard deviation.
fn with_sd(values: &[Option<f64>], sds: &[Option<f64>], digits: Option<usize>) -> Vec<Cell> {
    let number = |value, sd| rounded(value, sd, digits).typeset();
    let rows = values.iter().zip(sds).map(|(value, sd)| match (value, sd) {
        (Some(value), Some(sd)) => Cell::Joined(format!(
            "{}{NO_BREAK}±{NO_BREAK}{}",
            number(*value, Some(*sd)),
            number(*sd, Some(*sd))
        )),
        (Some(value), None) => Cell::Joined(number(*value, None)),
        (None, _) => Cell::Missing,
    });
    rows.collect()
}

/// `[3.9, 4.2]`; an end that is not there is `–`.
fn intervals(
    lows: &[Option<f64>],
    highs: &[Option<f64>],
    uncertainties: &[Option<f64>],
    digits: Option<usize>,
) -> Vec<Cell> {
    let number = |end, uncertainty| rounded(end, uncertainty, digits).typeset();
    let rows = lows.iter().zip(highs).enumerate().map(|(row, ends)| match ends {
        (None, None) => Cell::Missing,
        (low, high) => {
            let uncertainty = uncertainties.get(row).copied().flatten();
            let [low, high] = [low, high]
                .map(|end| end.map_or(MISSING.to_owned(), |end| number(end, uncertainty)));
            Cell::Joined(format!("[{low},{NO_BREAK}{high}]"))
        }
    });
    rows.collect()
}

fn cells<T>(values: &[Option<T>], cell: impl Fn(&T) -> Cell) -> Vec<Cell> {
    values.iter().map(|v| v.as_ref().map_or(Cell::Missing, &cell)).collect()
}

fn numbers(
    values: &[Option<f64>],
    uncertainties: &[Option<f64>],
    digits: Option<usize>,
) -> Vec<Cell> {
    let cells = values.iter().enumerate().map(|(i, v)| {
        let uncertainty = uncertainties.get(i).copied().flatten();
        v.map_or(Cell::Missing, |v| Cell::Number(rounded(v, uncertainty, digits)))
    });
    cells.collect()
}

/// Row by row, the uncertainty of the quantity that `field` is part of: its standard error, or else
/// half its interval. None of a ratio: the ends of its interval may lie decades apart, so each
/// number has digits of its own.
fn uncertainties(field: &Field, all: &[Column]) -> Vec<Option<f64>> {
    if field.name.starts_with(RATIO) {
        return Vec::new();
    }
    let [std_errors, low, high] = [Part::StdError, Part::CiLow, Part::CiHigh]
        .map(|part| partner(field, part, all).unwrap_or_default());
    let height = std_errors.len().max(low.len());
    let at = |values: &[Option<f64>], row: usize| values.get(row).copied().flatten();
    let uncertainties = (0..height).map(|row| {
        // A standard error of 0 says nothing about digits.
        let std_error = at(std_errors, row).filter(|u| *u > 0.0);
        std_error.or_else(|| Some((at(high, row)? - at(low, row)?).abs() / 2.0))
    });
    uncertainties.collect()
}

/// The column that plays `part` in the quantity of `field`, if there is one.
fn partner<'a>(field: &Field, part: Part, all: &'a [Column]) -> Option<&'a [Option<f64>]> {
    let wanted = (quantity(field).0, part);
    let column = all.iter().find(|c| c.field.unit == field.unit && quantity(&c.field) == wanted);
    match column.map(|c| &c.values) {
        Some(Values::Float(values)) => Some(values),
        _ => None,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A small table with all there is: numbers with an uncertainty, nulls, signs that every format
    /// must escape, a note.
    pub(crate) fn sample() -> Table {
        let columns = vec![
            Column::text("mode", "the mode", [Some("a|b & <c>"), None]),
            Column::integer("trial", "1", "its number", [Some(-3), Some(12)]),
            Column::float("slope_n_per_rad", "N/rad", "the slope", [Some(-4.1234), Some(5.0)]),
            Column::float("slope_std_error_n_per_rad", "N/rad", "its error", [Some(0.0321), None]),
            Column::flag("wall_reached", "whether", [Some(true), None]),
        ];
        Table::new("spring_rendering", "Slope, 100 %", columns)
            .unwrap()
            .with_note("Unit: one_trial.")
    }

    fn texts(table: &Table, column: usize) -> Vec<String> {
        shown(table, None)[column].cells.iter().map(Cell::typeset).collect()
    }

    #[test]
    fn an_estimate_is_rounded_by_its_standard_error_row_by_row() {
        assert_eq!(texts(&sample(), 2), ["−4.123", "5"]);
        assert_eq!(texts(&sample(), 3), ["0.032", "–"]);
    }

    #[test]
    fn each_number_of_a_ratio_has_its_own_digits() {
        let float = |name, value| Column::float(name, "1", "", [Some(value)]);
        let columns = vec![
            float("odds_ratio", 27.871),
            float("odds_ratio_ci_low", 0.27213),
            float("odds_ratio_ci_high", 9.0834e6),
        ];
        let table = Table::new("answers", "", columns).unwrap();
        assert_eq!(texts(&table, 0), ["27.87"]);
        assert_eq!(texts(&table, 1), ["[0.2721,\u{a0}9.083\u{a0}×\u{a0}10⁶]"]);
    }

    #[test]
    fn a_small_p_value_is_below_a_thousandth_and_never_nothing() {
        let p = [Some(0.0), Some(3e-165), Some(0.000_999_99), Some(0.001), Some(0.0942), None];
        let columns = vec![
            Column::float("p_adjusted", "1", "", p),
            Column::float("pressure_pa", "Pa", "", p),
            Column::float("p_std_error", "1", "", p),
        ];
        let table = Table::new("t", "", columns).unwrap();
        let below = "<\u{a0}0.001";
        assert_eq!(texts(&table, 0), [below, below, below, "0.001", "0.0942", "–"]);
        assert_eq!(texts(&table, 1)[0], "0");
        assert_eq!(texts(&table, 2)[0], "0", "the error of something that is called p");
    }

    #[test]
    fn an_interval_rounds_where_there_is_no_standard_error() {
        let columns = vec![
            Column::float("estimate", "1", "", [Some(1.234_56)]),
            Column::float("ci_low", "1", "", [Some(1.0)]),
            Column::float("ci_high", "1", "", [Some(1.5)]),
        ];
        let table = Table::new("t", "", columns).unwrap();
        assert_eq!([0, 1].map(|c| texts(&table, c).remove(0)), ["1.23", "[1.00,\u{a0}1.50]"]);
    }

    #[test]
    fn a_mean_with_its_standard_deviation_is_one_column_and_so_is_an_interval() {
        let n = |name, values| Column::float(name, "N", "", values);
        let columns = vec![
            n("mean_n", [Some(4.052_34), Some(3.0), None]),
            n("sd_n", [Some(0.002_1), None, None]),
            n("ci_low_n", [Some(4.01), None, None]),
            n("ci_high_n", [Some(4.09), Some(3.5), None]),
            n("participant_sd_n", [Some(0.2), Some(0.3), None]),
        ];
        let table = Table::new("t", "", columns).unwrap();
        let headings: Vec<_> = shown(&table, None).iter().map(Shown::heading).collect();
        assert_eq!(headings, ["mean ± SD (N)", "CI (N)", "participant SD (N)"]);
        assert_eq!(texts(&table, 0), ["4.0523\u{a0}±\u{a0}0.0021", "3", "–"]);
        assert_eq!(texts(&table, 1), ["[4.010,\u{a0}4.090]", "[–,\u{a0}3.5]", "–"]);
    }

    #[test]
    fn a_standard_error_of_another_unit_is_of_another_quantity() {
        let columns = vec![
            Column::float("slope_n_per_rad", "N/rad", "", [Some(1.234_56)]),
            Column::float("slope_std_error_n_per_mm", "N/mm", "", [Some(0.1)]),
        ];
        assert_eq!(texts(&Table::new("t", "", columns).unwrap(), 0), ["1.235"]);
    }

    #[test]
    fn a_line_break_or_a_control_sign_becomes_a_space() {
        assert_eq!(one_line(" a\r\nb\u{0}c\t d "), "a b c d");
    }
}
