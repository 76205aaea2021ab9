//! Everybody's own difference between two modes: one row per participant, environment and contrast.

use crate::cells::{Cells, whole};
use crate::contrasts::Row;
use crate::differences::Difference;
use crate::measure::Measure;
use crate::{CompareError, Parameters};
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
    let texts = |name, description, of: &dyn Fn(&Row, &Difference) -> String| {
        Column::text(name, description, all.iter().map(|(row, one)| Some(of(row, one))))
    };
    let counts = |name, description, of: fn(&Difference) -> usize| {
        Column::integer(name, "1", description, all.iter().map(|(_, one)| whole(of(one))))
    };
    let within = |of: fn(&Tested) -> f64| {
        all.iter().map(move |(_, one)| one.within.as_ref().ok().map(of)).collect::<Vec<_>>()
    };
    let columns = vec![
        texts("environment", "what was rendered", &|row, _| {
            parameters.environments[row.environment].to_string()
        }),
        texts("contrast", "the modes compared: the one minus the other", &|row, _| {
            format!("{} − {}", row.contrast.mode, row.contrast.against)
        }),
        texts("participant", "who", &|_, one| cells.participants[one.participant].clone()),
        counts("sessions", "sessions that have both modes", |one| one.sessions),
        counts("trials", "trials of the one mode", |one| one.trials[0]),
        counts("trials_with", "trials of the other mode", |one| one.trials[1]),
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
    Ok(Table::new(&format!("participants_{}", measure.name), &title, columns)?)
}
