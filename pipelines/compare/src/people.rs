//! Each participant's own difference between two modes: one row per participant, environment and
//! contrast.

use crate::Parameters;
use crate::cells::Cells;
use crate::contrasts::Row;
use crate::measure::Measure;
use zwidth_results::PersonDifference;

/// The differences of everybody, in the order of the contrasts and then of participants.
pub(crate) fn differences(
    rows: &[Row],
    cells: &Cells,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<PersonDifference> {
    let mut all = Vec::new();
    for row in rows {
        for one in &row.differences {
            let within = one.within.as_ref().ok();
            all.push(PersonDifference {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                environment: parameters.environments[row.claim.environment].clone(),
                contrast: row.contrast.clone(),
                participant: cells.participants[one.participant].clone(),
                sessions: one.sessions,
                trials_first: one.trials[0],
                trials_second: one.trials[1],
                difference: one.estimate,
                difference_std_error: within.map(|t| t.std_error),
                difference_ci_low: within.map(|t| t.ci_low),
                difference_ci_high: within.map(|t| t.ci_high),
            });
        }
    }
    all
}
