//! What stands below the tables: of whom they speak, how claims were tested, who is missing.

use crate::cells::{Cell, Cells};
use crate::measure::Measure;
use crate::unit::Unit;
use crate::{Parameters, columns, contrasts, means};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_stats::{design_guard, sign_flip};
use zwidth_study::Families;
use zwidth_tables::NoteKind;

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
    measure: &Measure,
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
            "Test: Student's t of the participants' differences, n − 1 degrees of freedom. The \
             sharp null beside it: that no trial of anyone depended on mode, by other orders that \
             the design could have drawn; it is no test of the average difference."
        }
        Unit::Trials { .. } => {
            "Test: the sharp null, that no trial depended on mode, by other orders that the design \
             could have drawn. Intervals: Welch's, sessions as strata, as a description."
        }
    };
    let general = [of_whom(unit), test.to_owned(), family];
    let general = general.into_iter().map(|text| (NoteKind::General, text));
    let guard = guard(rows, unit, parameters).into_iter().map(|text| (NoteKind::Limit, text));
    let plan = parameters.preregistered.as_ref().map(|plan| plan.note(cells.participants.len()));
    general
        .chain(jnd(rows, measure, parameters).into_iter().flatten())
        .chain(plan)
        .chain(reached(rows, parameters.alpha))
        .chain(guard)
        .chain(rows.iter().filter_map(|row| zeros(row, unit, parameters)))
        .chain(not_randomised(rows, parameters))
        .chain(rows.iter().filter_map(|row| left_out(row, cells, parameters)))
        .collect()
}

/// What is taken for just noticed, where it is known, and what is said of sizes.
fn jnd(
    rows: &[contrasts::Row],
    measure: &Measure,
    parameters: &Parameters,
) -> Option<[(NoteKind, String); 2]> {
    rows.iter().find(|row| row.jnd.is_some())?;
    let noticed = parameters.noticed.as_ref()?;
    let source = noticed.perception.source(&measure.unit)?;
    let from = match noticed.commanded.iter().any(Option::is_some) {
        true => ", from the commanded value",
        false if matches!(measure.unit.as_str(), "rad" | "m") => "",
        false => ", from the mean of the mode compared with",
    };
    let jnd = format!("JND, the difference that is just noticed: {source}{from}.");
    let sizes = "An interval wholly beyond ± 1 JND is called felt, one wholly within it below what is \
                 felt, any other one may be felt: a description, no claim.";
    Some([(NoteKind::Jnd, jnd), (NoteKind::General, sizes.to_owned())])
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

/// How far differences of zero raise the smallest p value of the exact tests.
fn zeros(row: &contrasts::Row, unit: &Unit, parameters: &Parameters) -> Option<(NoteKind, String)> {
    let (n, zeros) = (row.differences.len(), row.zeros());
    if *unit != Unit::Participants || zeros == 0 {
        return None;
    }
    let [without, with] = [n, n - zeros].map(|n| sign_flip::smallest_p(n).to_string());
    let environment = &parameters.environments[row.environment];
    let contrast = columns::name(&row.contrast);
    let text = format!(
        "{environment}, {contrast}: {zeros} of {n} differences {} 0, and a zero has no sign. So no \
         exact test (sign flip, signed rank) has a p below {with}; without zeros it could be {without}.",
        if zeros == 1 { "is" } else { "are" }
    );
    Some((NoteKind::Limit, text))
}

/// The smallest p value that the design's orders reach, and the claims that they cannot carry.
fn reached(rows: &[contrasts::Row], alpha: f64) -> Vec<(NoteKind, String)> {
    let tests = rows.iter().filter_map(|row| row.sharp_null.as_ref().ok());
    let Some(smallest) = tests.map(|test| test.smallest_p).min_by(f64::total_cmp) else {
        return Vec::new();
    };
    let adjusted = rows.iter().filter_map(|row| row.smallest_p_adjusted).min_by(f64::total_cmp);
    let adjusted = adjusted.map(|p| format!(", {p:.4} after Holm")).unwrap_or_default();
    let text =
        format!("Sharp null: the design's orders reach p = {smallest:.4} at best{adjusted}.");
    let refused = rows.iter().filter(|row| row.out_of_reach(alpha).is_some()).count();
    let refusal = (refused > 0).then(|| {
        let text = format!(
            "No claim can be made of {refused} of {} contrasts: however large the effect, the \
             design's orders bring no adjusted p below {alpha}. More repeats, or order = \
             \"constrained\" in study.toml, would give more orders.",
            rows.len()
        );
        (NoteKind::Limit, text)
    });
    [(NoteKind::General, text)].into_iter().chain(refusal).collect()
}

/// Environments without a test of the sharp null, and why.
fn not_randomised(rows: &[contrasts::Row], parameters: &Parameters) -> Vec<(NoteKind, String)> {
    let of_environment = rows.chunk_by(|a, b| a.environment == b.environment);
    of_environment.filter_map(|rows| why_not_randomised(rows.first()?, parameters)).collect()
}

fn why_not_randomised(row: &contrasts::Row, parameters: &Parameters) -> Option<(NoteKind, String)> {
    let why = row.sharp_null.as_ref().err()?;
    let environment = &parameters.environments[row.environment];
    Some((NoteKind::Care, format!("{environment}: no test of the sharp null: {why}.")))
}

/// Who took part and has not both modes of a contrast, and what each of them lacks.
fn left_out(
    row: &contrasts::Row,
    cells: &Cells,
    parameters: &Parameters,
) -> Option<(NoteKind, String)> {
    let compared: BTreeSet<usize> = row.differences.iter().map(|one| one.participant).collect();
    // Those who lack the same stand together.
    let mut lacking: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for (participant, name) in cells.participants.iter().enumerate() {
        if !compared.contains(&participant) {
            let what = lacks(participant, row, cells, parameters)?;
            lacking.entry(what).or_default().push(name);
        }
    }
    let environment = &parameters.environments[row.environment];
    let contrast = columns::name(&row.contrast);
    let groups: Vec<String> =
        lacking.iter().map(|(what, names)| format!("{} ({what})", names.join(", "))).collect();
    (!groups.is_empty()).then(|| {
        let text = format!("{environment}, {contrast}: without {}.", groups.join("; "));
        (NoteKind::LeftOut, text)
    })
}

/// What a participant lacks of a contrast; `None` for modes that the study does not have.
fn lacks(
    participant: usize,
    row: &contrasts::Row,
    cells: &Cells,
    parameters: &Parameters,
) -> Option<String> {
    let mut missing = Vec::new();
    for mode in parameters.modes_of(&row.contrast)? {
        let own = cells.of_condition(row.environment, mode);
        let own: Vec<&Cell> = own.filter(|cell| cell.participant == participant).collect();
        let name = &parameters.modes[mode];
        if own.iter().map(|cell| cell.trials).sum::<usize>() == 0 {
            missing.push(format!("no trial of {name}"));
        } else if own.iter().all(|cell| cell.mean.is_none()) {
            missing.push(format!("no trial of {name} with {}", parameters.metric));
        }
    }
    if missing.is_empty() {
        missing.push("no session with both modes".to_owned());
    }
    Some(missing.join(", "))
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
