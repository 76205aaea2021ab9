//! Stage: modes, participants and sessions compared, one metric at a time.
//!
//! [`compare`] turns the table of metrics (one row per trial) into tables of one metric. Nothing
//! here reads a file or a clock.
//!
//! # What is estimated
//! The unweighted mean over participants of (mean in one mode − mean in the other), sessions
//! averaged with equal weight, per environment. Repeats of one person are not people: with several
//! participants n counts participants, and each contributes one difference, tested by Student's t
//! with n − 1 degrees of freedom (the differences carry their own variance, so no sphericity is
//! assumed). With one participant, n counts trials, everything is said "within this participant",
//! and claims rest on randomisation over the orders that the design could have drawn; Welch's
//! interval (sessions as strata) stands beside as a description.
//!
//! # Families
//! The contrasts of the primary metric over all environments are one family of claims, adjusted
//! after Holm. Every other metric is a family of its own, and exploratory. Intervals are not
//! adjusted.

mod answers;
mod cells;
mod columns;
mod contrasts;
mod differences;
mod drawn;
mod error;
mod learning;
mod means;
mod measure;
mod models;
mod notes;
mod omnibus;
mod orders;
mod parameters;
mod people;
mod preregistered;
mod quantity;
mod repeats;
mod sessions;
#[cfg(test)]
mod tests;
mod together;
mod unit;

pub use answers::{AnswerParameters, AnswersCompared, compare_answers};
pub use drawn::{DrawnOrder, SessionOrder};
pub use error::CompareError;
pub use measure::Measure;
pub use parameters::{Noticed, Parameters};
pub use preregistered::Preregistered;
pub use together::together;

use cells::Cells;
use unit::Unit;
use zwidth_tables::{NoteKind, Table};

/// Version of the algorithms here: a change of any number they give raises it.
pub const VERSION: u32 = 10;

/// The columns of the metrics that a comparison reads besides the metric.
pub const COLUMNS: [&str; 6] = ["participant", "session", "trial", "environment", "mode", "repeat"];

/// The tables of one metric.
#[derive(Debug, Clone)]
pub struct Compared {
    /// Each participant's mean by session and condition.
    pub cells: Table,
    /// Mean over the units of analysis by condition.
    pub means: Table,
    /// Differences between modes.
    pub contrasts: Table,
    /// Whether any mode differs from another.
    pub omnibus: Table,
    /// The same by mixed models.
    pub models: Table,
    /// Each participant's differences.
    pub participants: Table,
    /// Changes between sessions.
    pub sessions: Table,
    /// Changes from repeat to repeat.
    pub learning: Table,
    /// Means at each repeat.
    pub repeats: Table,
    /// Differences between modes against other orders of the trials.
    pub orders: Table,
    /// What these differences are in the other orders.
    pub redrawn: Table,
}

/// Compares the modes, participants and sessions of one metric. `metrics` has one row per trial.
///
/// # Errors
/// A table that lacks a column; a level or bound that cannot be one.
pub fn compare(metrics: &Table, parameters: &Parameters) -> Result<Compared, CompareError> {
    let measure = &Measure::of(metrics, &parameters.metric)?;
    let cells = Cells::of(metrics, measure, parameters)?;
    let unit = &Unit::of(&cells);
    let orders = orders::sharp_nulls(metrics, measure, parameters, orders::SAMPLING)?;
    let contrasts = contrasts::rows(&cells, &orders, unit, measure, parameters)?;
    let means = means::rows(&cells, unit, parameters)?;
    let noted = |table: Table, notes: Vec<(NoteKind, String)>| {
        notes.into_iter().fold(table, |table, (kind, note)| table.with_note_of(kind, note))
    };
    let marked = |table: Table| table.with_mark(parameters.simulated);
    Ok(Compared {
        cells: marked(cells.table(measure, parameters)?),
        means: marked(noted(
            means::table(&means, unit, measure, parameters)?,
            notes::means(&means, unit, parameters),
        )),
        contrasts: marked(noted(
            contrasts::table(&contrasts, unit, measure, parameters)?,
            notes::contrasts(&contrasts, &cells, unit, measure, parameters),
        )),
        omnibus: marked(omnibus::table(&cells, measure, parameters)?),
        models: marked(models::table(metrics, unit, measure, parameters)?),
        participants: marked(people::table(&contrasts, &cells, measure, parameters)?),
        sessions: marked(sessions::table(&cells, measure, parameters)?),
        learning: marked(learning::table(metrics, unit, measure, parameters)?),
        repeats: marked(repeats::table(metrics, unit, measure, parameters)?),
        orders: marked(orders::table(&orders, measure, parameters)?),
        redrawn: marked(orders::redrawn_table(&orders, measure, parameters)?),
    })
}
