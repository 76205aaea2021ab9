//! What stands below the tables: of whom they speak, how claims were tested, who is missing.

use crate::cells::Cells;
use crate::unit::Unit;
use crate::{Parameters, columns, contrasts, means};
use zwidth_stats::design_guard;
use zwidth_study::Families;
use zwidth_tables::{NoteKind, Table};

/// Says below a table that what it is made from was simulated, where any of it was.
pub(crate) fn mark(table: Table, simulated: bool) -> Table {
    let note = "SYNTHETIC: made from simulated data, nothing of those was measured.";
    if simulated { table.with_note_of(NoteKind::Care, note) } else { table }
}

/// Notes on means.
pub(crate) fn means(
    rows: &[means::Row],
    unit: &Unit,
    parameters: &Parameters,
) -> Vec<(NoteKind, String)> {
    let incomplete = rows.iter().filter(|row| row.trials[1] < row.trials[0]).map(|row| {
        let [all, with] = row.trials;
        let (environment, mode) =
            (&parameters.environments[row.environment], &parameters.modes[row.mode]);
        let text = format!(
            "{environment} × {mode}: {with} of {all} trials have the metric; the mean is among those."
        );
        (NoteKind::Care, text)
    });
    [(NoteKind::General, of_whom(unit))].into_iter().chain(incomplete).collect()
}

/// Notes on contrasts.
pub(crate) fn contrasts(
    rows: &[contrasts::Row],
    cells: &Cells,
    unit: &Unit,
    parameters: &Parameters,
) -> Vec<(NoteKind, String)> {
    let together = match parameters.families {
        Families::Metric => "The rows of this table are one family of claims",
        Families::Environment => "The rows of one environment are one family of claims",
    };
    let family = format!(
        "{} {together}, adjusted after Holm; intervals are not adjusted.",
        if parameters.primary { "Primary metric." } else { "Exploratory: not the primary metric." }
    );
    let test = match unit {
        Unit::Participants => {
            "Test: Student's t of the participants' differences, n − 1 degrees of freedom."
        }
        Unit::Trials { .. } => "Test: Welch's, sessions as strata.",
    };
    let general = [of_whom(unit), test.to_owned(), family];
    let general = general.into_iter().map(|text| (NoteKind::General, text));
    let guard = guard(rows, unit, parameters).into_iter().map(|text| (NoteKind::Limit, text));
    general
        .chain(guard)
        .chain(rows.iter().filter_map(|row| left_out(row, cells, parameters)))
        .collect()
}

/// What the exact tests can reach with so few participants.
fn guard(rows: &[contrasts::Row], unit: &Unit, parameters: &Parameters) -> Option<String> {
    let fewest = rows.iter().map(|row| row.differences.len()).min()?;
    if *unit != Unit::Participants {
        return None;
    }
    let reached = design_guard::check(fewest, parameters.contrasts.len(), parameters.alpha);
    reached.err().map(|why| format!("Exact tests: {why}"))
}

/// Who took part and has not both modes of a contrast.
fn left_out(
    row: &contrasts::Row,
    cells: &Cells,
    parameters: &Parameters,
) -> Option<(NoteKind, String)> {
    let has = |who: usize| row.differences.iter().any(|one| one.participant == who);
    let missing: Vec<&str> = (0..cells.participants.len())
        .filter(|who| !has(*who))
        .map(|who| cells.participants[who].as_str())
        .collect();
    let environment = &parameters.environments[row.environment];
    (!missing.is_empty()).then(|| {
        let text = format!(
            "{environment}, {}: without {}, who lack one of the modes.",
            columns::name(&row.contrast),
            missing.join(", ")
        );
        (NoteKind::LeftOut, text)
    })
}

fn of_whom(unit: &Unit) -> String {
    match unit {
        Unit::Participants => {
            "n counts participants: each one's repeats are averaged, then their sessions with equal \
             weight."
                .to_owned()
        }
        Unit::Trials { of } => format!(
            "Within {of}: n counts trials, and nothing is said of anybody else."
        ),
    }
}
