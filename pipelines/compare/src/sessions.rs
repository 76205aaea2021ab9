//! Sessions compared: how participants changed from one session to another, and how well one
//! session tells another.

use crate::cells::{Cell, Cells, whole};
use crate::measure::Measure;
use crate::{CompareError, Parameters, columns};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_stats::agreement::{Agreement, BlandAltman, agreement, bland_altman};
use zwidth_stats::incomplete::incomplete_agreement;
use zwidth_stats::null::Sampling;
use zwidth_stats::paired::{differences, mean_difference};
use zwidth_stats::{Tested, Unestimable};
use zwidth_tables::{Column, Table};

/// Tables drawn for the agreement of sessions that some participants lack.
const DRAWS: Sampling = Sampling { draws: 999, seed: 1 };
/// From this many participants on those who lack a session are left out of the agreement.
const MANY: usize = 100;

/// Two sessions of one condition.
#[derive(Debug, Clone, PartialEq)]
struct Row {
    environment: usize,
    mode: usize,
    /// Indices among [`Cells::sessions`], the earlier first.
    sessions: [usize; 2],
    /// Everybody's means in the two sessions, the later first.
    pairs: Vec<[f64; 2]>,
    /// Later minus earlier, participants as units.
    change: Result<Tested, Unestimable>,
    /// Of the changes.
    limits: Option<BlandAltman>,
    /// Of the two sessions.
    agreement: Option<Agreement>,
    /// Whether it takes in those who lack one of them.
    is_incomplete: bool,
    /// Of all sessions of the condition, where there are three or more.
    overall: Option<Agreement>,
}

/// Each later session against the first one, in every condition, as a table.
pub(crate) fn table(
    cells: &Cells,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let mut rows = Vec::new();
    for environment in 0..parameters.environments.len() {
        for mode in 0..parameters.modes.len() {
            let all: Vec<usize> = (0..cells.sessions.len()).collect();
            let overall = if all.len() > 2 {
                let everybody = means(cells, environment, mode, &all);
                agreement_of_all(&everybody, parameters.level).ok()
            } else {
                None
            };
            for later in 1..cells.sessions.len() {
                let means = means(cells, environment, mode, &[later, 0]);
                let row = row(&means, parameters.level);
                if !row.pairs.is_empty() {
                    let sessions = [0, later];
                    rows.push(Row { environment, mode, sessions, overall, ..row });
                }
            }
        }
    }
    as_table(&rows, cells, measure, parameters)
}

/// The agreement of sessions, a column each of everybody's `means`, by the mixed model: by its mean
/// squares where nobody lacks a session, which is the same.
fn agreement_of_all(means: &[Vec<Option<f64>>], level: f64) -> Result<Agreement, Unestimable> {
    let complete: Vec<Vec<f64>> =
        means.iter().filter_map(|row| row.iter().copied().collect()).collect();
    if complete.len() < means.len() && means.len() < MANY {
        return incomplete_agreement(means, level, DRAWS).map(|found| found.agreement);
    }
    agreement(&complete, level)
}

fn row(means: &[Vec<Option<f64>>], level: f64) -> Row {
    let pairs: Vec<[f64; 2]> = means.iter().filter_map(|both| Some([both[0]?, both[1]?])).collect();
    let changes = differences(&pairs);
    let is_incomplete = pairs.len() < means.len() && means.len() < MANY;
    let agreement = agreement_of_all(means, level);
    Row {
        environment: 0,
        mode: 0,
        sessions: [0, 0],
        change: mean_difference(&changes, level),
        limits: bland_altman(&changes, level).ok(),
        agreement: agreement.ok(),
        is_incomplete,
        overall: None,
        pairs,
    }
}

/// The means in some sessions, in their order, of everybody who has one of them.
fn means(
    cells: &Cells,
    environment: usize,
    mode: usize,
    sessions: &[usize],
) -> Vec<Vec<Option<f64>>> {
    let in_session = |session: &usize| -> BTreeMap<usize, f64> {
        let here = cells.of_condition(environment, mode).filter(|c| c.session == *session);
        here.filter_map(|c: &Cell| Some((c.participant, c.mean?))).collect()
    };
    let by_session: Vec<BTreeMap<usize, f64>> = sessions.iter().map(in_session).collect();
    let everybody: BTreeSet<usize> = by_session.iter().flat_map(|s| s.keys().copied()).collect();
    let one = |who| by_session.iter().map(|means| means.get(&who).copied()).collect();
    everybody.into_iter().map(one).collect()
}

fn as_table(
    rows: &[Row],
    cells: &Cells,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let texts = |name, description, of: &dyn Fn(&Row) -> Option<String>| {
        Column::text(name, description, rows.iter().map(of))
    };
    let tested = |of: fn(&Tested) -> f64| {
        rows.iter().map(move |row| row.change.as_ref().ok().map(of)).collect::<Vec<_>>()
    };
    let over = |side: usize| {
        rows.iter().map(move |row| {
            Some(row.pairs.iter().map(|pair| pair[side]).sum::<f64>() / row.pairs.len() as f64)
        })
    };
    let limits = |of: fn(&BlandAltman) -> f64| {
        rows.iter().map(move |row| row.limits.as_ref().map(of)).collect::<Vec<_>>()
    };
    let agreeing = |of: fn(&Agreement) -> f64| {
        rows.iter().map(move |row| row.agreement.as_ref().map(of)).collect::<Vec<_>>()
    };
    let number = |name, description, values| Column::float(name, "1", description, values);
    let change: Vec<Option<Tested>> = rows.iter().map(|row| row.change.clone().ok()).collect();
    let mut all = vec![
        columns::environments(parameters, rows.iter().map(|row| row.environment)),
        columns::modes(parameters, rows.iter().map(|row| row.mode)),
        texts("sessions", "the sessions compared: the later minus the earlier", &|row| {
            let [earlier, later] = row.sessions.map(|session| &cells.sessions[session]);
            Some(format!("{later} − {earlier}"))
        }),
        Column::integer(
            "n",
            "1",
            "participants with both sessions",
            rows.iter().map(|row| whole(row.pairs.len())),
        ),
        measure.column("mean_later", "mean in the later session", over(0)),
        measure.column("mean_earlier", "mean in the earlier session", over(1)),
    ];
    all.extend(columns::tested(measure, "change", "mean change", &change));
    all.extend([
        Column::float("df", "1", "degrees of freedom", tested(|t| t.df)),
        Column::float("p_value", "1", "p value of no change, not adjusted", tested(|t| t.p_value)),
        measure.column(
            "limit_low",
            "lower limit of agreement of single changes (Bland–Altman)",
            limits(|l| l.lower.estimate),
        ),
        measure.column("limit_high", "upper limit of agreement", limits(|l| l.upper.estimate)),
        number(
            "icc_a1",
            "ICC(A,1) [ICC(2,1)]: absolute agreement of single sessions",
            agreeing(|a| a.a1.estimate),
        ),
        number("icc_a1_ci_low", "lower end of its interval", agreeing(|a| a.a1.ci_low)),
        number("icc_a1_ci_high", "upper end of its interval", agreeing(|a| a.a1.ci_high)),
        number(
            "icc_c1",
            "ICC(C,1) [ICC(3,1)]: consistency of single sessions",
            agreeing(|a| a.c1.estimate),
        ),
        number(
            "icc_ak",
            "ICC(A,k) [ICC(2,k)]: absolute agreement of their means",
            agreeing(|a| a.ak.estimate),
        ),
        number(
            "icc_ck",
            "ICC(C,k) [ICC(3,k)]: consistency of their means",
            agreeing(|a| a.ck.estimate),
        ),
        measure.column("sem", "standard error of measurement", agreeing(|a| a.sem)),
        measure.column("mdc", "minimal detectable change, 95 %", agreeing(|a| a.mdc)),
    ]);
    if rows.iter().any(|row| row.overall.is_some()) {
        let overall = |of: fn(&Agreement) -> f64| {
            rows.iter().map(move |row| row.overall.as_ref().map(of)).collect::<Vec<_>>()
        };
        all.extend([
            number(
                "icc_a1_all",
                "ICC(A,1) [ICC(2,1)] of all sessions of the condition together",
                overall(|a| a.a1.estimate),
            ),
            number("icc_a1_all_ci_low", "lower end of its interval", overall(|a| a.a1.ci_low)),
            number("icc_a1_all_ci_high", "upper end of its interval", overall(|a| a.a1.ci_high)),
            measure.column(
                "sem_all",
                "standard error of measurement of all sessions together",
                overall(|a| a.sem),
            ),
        ]);
    }
    all.push(texts("remark", "why there is no test", &|row| {
        row.change.as_ref().err().map(ToString::to_string)
    }));
    let title = format!("Sessions compared: {}", measure.description);
    let table = Table::new(&format!("sessions_{}", measure.name), &title, all)?;
    let note = "Agreement takes in those who lack a session, by a mixed model of everybody's means, \
                with intervals by a parametric bootstrap (999); changes are of those who came to both.";
    let everything = "icc_a1_all is one number per condition: of all its sessions, by the mixed model \
                      with participants and sessions as random effects (by its mean squares where nobody \
                      lacks a session, which is the same).";
    let is_overall = rows.iter().any(|row| row.overall.is_some());
    let table = if is_overall { table.with_note(everything) } else { table };
    let is_incomplete = rows.iter().any(|row| row.is_incomplete);
    let table = if is_incomplete { table.with_note(note) } else { table };
    let is_negative =
        rows.iter().flat_map(|row| [&row.agreement, &row.overall]).flatten().any(is_negative);
    Ok(if is_negative { table.with_note(NEGATIVE) } else { table })
}

/// What is said where an intraclass correlation is below 0.
const NEGATIVE: &str = "An ICC below 0 means that participants differed less from each other than from \
                        themselves in another session (chance alone can do that where participants are \
                        alike): one session tells nothing of another. It stands as it \
                        was computed; read it as 0.";

fn is_negative(agreement: &Agreement) -> bool {
    let Agreement { a1, c1, ak, ck, .. } = agreement;
    [a1, c1, ak, ck].into_iter().any(|icc| icc.estimate < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two sessions in which the order of the participants turns round.
    #[test]
    fn an_icc_below_zero_is_recognised_as_it_was_computed() {
        let table = |pairs: [[f64; 2]; 3]| pairs.map(|pair| pair.map(Some).to_vec());
        let turned = table([[1.0, 3.0], [2.0, 2.5], [3.0, 1.2]]);
        let found = row(&turned, 0.95).agreement.unwrap();
        assert!(found.c1.estimate < 0.0, "{found:?}");
        assert!(is_negative(&found));
        let alike = table([[1.0, 1.1], [2.0, 2.2], [3.0, 2.9]]);
        assert!(!is_negative(&row(&alike, 0.95).agreement.unwrap()));
    }
}
