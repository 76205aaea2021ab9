//! Everybody's own difference between two modes: one row per participant, environment and contrast.

use crate::cells::{Cells, whole};
use crate::contrasts::Row;
use crate::differences::Difference;
use crate::measure::Measure;
use crate::{CompareError, Parameters, columns};
use zwidth_stats::Tested;
use zwidth_tables::{Column, Table};

/// The differences of everybody as a table, in the order of the contrasts and then of participants.
pub(crate) fn table(
    rows: &[Row],
    cells: &Cells,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let all: Vec<(&Row, &Difference)> =
        rows.iter().flat_map(|row| row.differences.iter().map(move |of| (row, of))).collect();
    let counts = |name, description, of: fn(&Difference) -> usize| {
        Column::integer(name, "1", description, all.iter().map(|(_, one)| whole(of(one))))
    };
    let within = |of: fn(&Tested) -> f64| {
        all.iter().map(move |(_, one)| one.within.as_ref().ok().map(of)).collect::<Vec<_>>()
    };
    let table = vec![
        columns::environments(parameters, all.iter().map(|(row, _)| row.environment)),
        columns::contrasts(all.iter().map(|(row, _)| &row.contrast)),
        Column::text(
            "participant",
            "who",
            all.iter().map(|(_, one)| Some(cells.participants[one.participant].as_str())),
        ),
        counts("sessions", "sessions that have both modes", |one| one.sessions),
        counts("trials_first", "trials of the contrast's first mode", |one| one.trials[0]),
        counts("trials_second", "trials of its second mode", |one| one.trials[1]),
        measure.column(
            "difference",
            "this participant's mean difference",
            all.iter().map(|(_, one)| Some(one.estimate)),
        ),
        measure.column(
            "difference_std_error",
            "its standard error within this participant, repeats as units (Welch)",
            within(|t| t.std_error),
        ),
        measure.column(
            "difference_ci_low",
            "lower end of its interval within this participant",
            within(|t| t.ci_low),
        ),
        measure.column(
            "difference_ci_high",
            "upper end of its interval within this participant",
            within(|t| t.ci_high),
        ),
    ];
    let title = format!("Participants compared: {}", measure.description);
    Ok(Table::new(&format!("participants_{}", measure.name), &title, table)?)
}
