//! The thesis' statements (§5.3.1–§5.3.3, §5.4, §6.1, §6.2.1), each judged by a study's own tables.
//!
//! A statement is data: where the thesis has it, which mode and environment it is of, and a rule
//! over numbers. Modes are found by their law and environments by what they are, so that any study
//! can be asked; what it does not hold is "not measured". Where several people took part they are
//! the units, else the trials of the one are, and the row says so.

mod asked;
mod estimate;
mod forces;
mod judge;
mod judged;
mod rule;
mod statements;
#[cfg(test)]
mod tests;
mod told;

pub(crate) use asked::asked_metrics;
pub use asked::{replayed, replayed_columns};
pub use judged::Derived;
pub use told::{Told, told};

use crate::evidence::{Verdict, notes};
use judge::judge;
use judged::Judged;
use rule::Statement;
use std::collections::BTreeMap;
use zwidth_tables::{Column, NoteKind, Table, TableError};

/// The thesis' statements, one row each, in the order of its text: verdict, value with interval,
/// unit, n, unit of analysis, and the figure or table that shows it.
///
/// Supported where the whole interval lies in the range that is asked for, contradicted where none
/// of it does, undecided else; not measured where the study has no number, and why. Intervals are
/// Student's t at the study's level, over participants' means (differences within participants); of
/// one participant Welch's over the trials, which speaks of nobody else.
///
/// # Errors
/// Tables that lack a column.
pub fn thesis_table(derived: &Derived) -> Result<Table, TableError> {
    let mut verdicts: BTreeMap<&str, Verdict> = BTreeMap::new();
    let mut rows: Vec<(&Statement, Judged)> = Vec::new();
    for statement in statements::ALL {
        let judged = judge(statement, &verdicts, derived)?;
        verdicts.insert(statement.key, judged.evidence.verdict);
        rows.push((statement, judged));
    }
    let title = "The thesis' statements, judged by this study";
    let table = Table::new("thesis", title, columns(&rows, derived))?;
    let table = notes(derived.known.metrics)?.into_iter().fold(table, Table::with_note);
    Ok(table
        .with_note(
            "A statement is supported if the whole interval lies within what is asked, contradicted if no part of it \
             does, and undecided otherwise. Intervals are not adjusted for the number of statements.",
        )
        .with_note_of(NoteKind::General, derived.basis.footnote()))
}

fn columns(rows: &[(&Statement, Judged)], derived: &Derived) -> Vec<Column> {
    let given = |text: &str| (!text.is_empty()).then(|| text.to_owned());
    let planned = |name, about, get: fn(&Statement) -> &str| {
        Column::text(name, about, rows.iter().map(|(s, _)| given(get(s))))
    };
    let text = |name, about, get: fn(&Judged) -> &str| {
        Column::text(name, about, rows.iter().map(|(_, j)| given(get(j))))
    };
    let number = |name, about, get: fn(&Judged) -> Option<f64>| {
        Column::float(name, "1", about, rows.iter().map(|(_, j)| get(j)))
    };
    let shown = rows.iter().map(|(_, judged)| {
        let measured = judged.evidence.verdict != Verdict::NotMeasured;
        measured.then(|| derived.gallery.file(&judged.shown))
    });
    let n = rows.iter().map(|(_, judged)| judged.n.and_then(|n| i64::try_from(n).ok()));
    vec![
        planned("key", "the statement's word", |s| s.key),
        planned("source", "where the thesis has it", |s| s.source),
        planned("statement", "what the thesis says, in short", |s| s.text),
        text("verdict", "what this study says of it", |j| j.evidence.verdict.as_str()),
        text("metric", "this study's number", |j| &j.evidence.metric),
        number("value", "its value, in the unit beside it", |j| j.evidence.value),
        number("ci_low", "lower end of its interval", |j| j.interval.map(|ends| ends[0])),
        number("ci_high", "upper end of its interval", |j| j.interval.map(|ends| ends[1])),
        text("unit", "their unit", |j| &j.evidence.unit),
        Column::integer("n", "1", "units of analysis", n),
        text("unit_of_analysis", "what n counts", |j| &j.over),
        text("asked", "what the value must be, and why", |j| &j.asked),
        Column::text("shown", "the figure or table that shows it", shown),
        text("remark", "what is to be said of it, or why it is not measured", |j| {
            &j.evidence.remark
        }),
    ]
}
