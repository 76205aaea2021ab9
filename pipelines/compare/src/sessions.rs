//! Sessions compared: how participants changed from one session to another, and how well one
//! session predicts another.

use crate::Parameters;
use crate::cells::Cells;
use crate::measure::Measure;
use std::collections::BTreeMap;
use zwidth_results::{SessionChange, SessionPair};
use zwidth_stats::Unestimable;
use zwidth_stats::agreement::{Agreement, agreement, bland_altman};
use zwidth_stats::incomplete::incomplete_agreement;
use zwidth_stats::null::Sampling;
use zwidth_stats::paired::{differences, mean_difference};

/// Tables drawn for the agreement of sessions that some participants lack.
const DRAWS: Sampling = Sampling { draws: 999, seed: 1 };
/// From this many participants on those who lack a session are left out of the agreement.
const MANY: usize = 100;

/// Each later session against the first one, in every condition.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Changes {
    pub(crate) rows: Vec<SessionChange>,
    /// Whether some agreement includes participants who lack a session.
    pub(crate) is_incomplete: bool,
}

pub(crate) fn changes(cells: &Cells, measure: &Measure, parameters: &Parameters) -> Changes {
    let mut changes = Changes::default();
    for (e, environment) in parameters.environments.iter().enumerate() {
        for (m, mode) in parameters.modes.iter().enumerate() {
            let all: Vec<usize> = (0..cells.sessions.len()).collect();
            // Of two sessions it would be what their row has already.
            let overall = if all.len() > 2 {
                agreement_of_all(&means(cells, e, m, &all), parameters.level).ok()
            } else {
                None
            };
            for later in 1..cells.sessions.len() {
                let means = means(cells, e, m, &[later, 0]);
                let pairs: Vec<[f64; 2]> =
                    means.iter().filter_map(|both| Some([both[0]?, both[1]?])).collect();
                if pairs.is_empty() {
                    continue;
                }
                let [mean_later, mean_earlier] = [0, 1].map(|side| {
                    pairs.iter().map(|pair| pair[side]).sum::<f64>() / pairs.len() as f64
                });
                let differences = differences(&pairs);
                let change = mean_difference(&differences, parameters.level);
                let limits = bland_altman(&differences, parameters.level).ok();
                let agreement = agreement_of_all(&means, parameters.level).ok();
                let tested = change.as_ref().ok();
                changes.is_incomplete |= pairs.len() < means.len() && means.len() < MANY;
                changes.rows.push(SessionChange {
                    metric: measure.parameters.metric.clone(),
                    unit: measure.unit.clone(),
                    environment: environment.clone(),
                    mode: mode.clone(),
                    sessions: SessionPair {
                        later: cells.sessions[later].clone(),
                        earlier: cells.sessions[0].clone(),
                    },
                    n: pairs.len(),
                    mean_later,
                    mean_earlier,
                    change: tested.map(|t| t.estimate),
                    change_std_error: tested.map(|t| t.std_error),
                    change_ci_low: tested.map(|t| t.ci_low),
                    change_ci_high: tested.map(|t| t.ci_high),
                    df: tested.map(|t| t.df),
                    p_value: tested.map(|t| t.p_value),
                    limit_low: limits.as_ref().map(|limits| limits.lower.estimate),
                    limit_high: limits.as_ref().map(|limits| limits.upper.estimate),
                    icc_a1: agreement.as_ref().map(|icc| icc.a1.estimate),
                    icc_a1_ci_low: agreement.as_ref().map(|icc| icc.a1.ci_low),
                    icc_a1_ci_high: agreement.as_ref().map(|icc| icc.a1.ci_high),
                    icc_c1: agreement.as_ref().map(|icc| icc.c1.estimate),
                    icc_ak: agreement.as_ref().map(|icc| icc.ak.estimate),
                    icc_ck: agreement.as_ref().map(|icc| icc.ck.estimate),
                    sem: agreement.as_ref().map(|icc| icc.sem),
                    mdc: agreement.as_ref().map(|icc| icc.mdc),
                    icc_a1_all: overall.as_ref().map(|icc| icc.a1.estimate),
                    icc_a1_all_ci_low: overall.as_ref().map(|icc| icc.a1.ci_low),
                    icc_a1_all_ci_high: overall.as_ref().map(|icc| icc.a1.ci_high),
                    sem_all: overall.as_ref().map(|icc| icc.sem),
                    remark: change.as_ref().err().map(|why| why.to_string().into()),
                });
            }
        }
    }
    changes
}

/// The agreement of sessions, a column each of everybody's `means`, by the mixed model: by its mean
/// squares where nobody lacks a session, which is the same.
fn agreement_of_all(means: &[Vec<Option<f64>>], level: f64) -> Result<Agreement, Unestimable> {
    let complete: Vec<Vec<f64>> =
        means.iter().filter_map(|row| row.iter().copied().collect()).collect();
    if complete.len() < means.len() && means.len() < MANY {
        return incomplete_agreement(means, level, DRAWS).map(|fit| fit.agreement);
    }
    agreement(&complete, level)
}

/// The means in some sessions, in their order, of everybody who has one of them.
fn means(
    cells: &Cells,
    environment: usize,
    mode: usize,
    sessions: &[usize],
) -> Vec<Vec<Option<f64>>> {
    let mut people: BTreeMap<usize, Vec<Option<f64>>> = BTreeMap::new();
    for cell in cells.of_condition(environment, mode) {
        let Some(place) = sessions.iter().position(|session| *session == cell.session) else {
            continue;
        };
        if cell.mean.is_some() {
            people.entry(cell.participant).or_insert_with(|| vec![None; sessions.len()])[place] =
                cell.mean;
        }
    }
    people.into_values().collect()
}
