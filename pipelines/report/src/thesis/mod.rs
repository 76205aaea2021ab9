//! The thesis' statements (§5.3.1–§5.3.3, §5.4, §6.1, §6.2.1), each judged by a study's own tables.
//!
//! A statement is data: its place in the thesis, its mode and environment, and a rule over numbers.
//! Modes are found by their law and environments by their kind, so the rules apply to any study;
//! whatever a study lacks is "not measured". If several people took part, they are the units, else
//! the trials of the only one; the row says which.

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

pub(crate) use asked::statement_metrics;
pub use asked::{replayed, replayed_columns};
pub use told::{Told, told};

use crate::evidence::{Derived, Verdict};
use judge::judge;
use std::collections::BTreeMap;
use zwidth_results::JudgedStatement;
use zwidth_tables::TableError;

/// The thesis' statements, one row each, in the order of its text: verdict, value with interval,
/// unit, n, unit of analysis, and the figure or table that shows it.
///
/// A statement is supported if the whole interval lies in its range, contradicted if none of it
/// does, and undecided otherwise; it is not measured if the study has no number, with the reason.
/// Intervals are Student's t at the study's level, over participants' means (differences within
/// participants); with one participant they are Welch's over the trials, which describe nobody
/// else.
///
/// # Errors
/// Metrics or replays that lack a column.
pub fn statements(derived: &Derived) -> Result<Vec<JudgedStatement>, TableError> {
    let mut verdicts: BTreeMap<&str, Verdict> = BTreeMap::new();
    let mut rows = Vec::new();
    // In the order of the list: a statement that rests on others stands after them.
    for statement in statements::ALL {
        let judged = judge(statement, &verdicts, derived)?;
        verdicts.insert(statement.key, judged.verdict);
        rows.push(judged);
    }
    Ok(rows)
}

/// The note below the table of statements.
pub const HOW_JUDGED: &str = "A statement is supported if the whole interval lies within what is asked, contradicted if no part of it \
     does, and undecided otherwise. Intervals are not adjusted for the number of statements.";
