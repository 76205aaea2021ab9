//! Learning: how a metric changes from one repeat of a condition to the next.

use crate::Parameters;
use crate::measure::Measure;
use crate::trials::Trials;
use std::collections::BTreeMap;
use zwidth_results::{Learning, UnitOfAnalysis};
use zwidth_stats::paired::mean_difference;
use zwidth_stats::{Tested, Unestimable, line};

/// The points (repeat, value) of one participant in one condition, a list per session.
type Sessions = BTreeMap<usize, Vec<[f64; 2]>>;

/// The change per repeat in every condition: the mean over participants of each one's slope; of one
/// participant, the slope of the trials. Each session has a level of its own.
pub(crate) fn changes(
    trials: &Trials,
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<Learning> {
    let mut rows = Vec::new();
    for (e, environment) in parameters.environments.iter().enumerate() {
        for (m, mode) in parameters.modes.iter().enumerate() {
            let mut people: BTreeMap<usize, Sessions> = BTreeMap::new();
            for trial in trials.of_condition(e, m) {
                if let Some(value) = trial.value {
                    let sessions = people.entry(trial.participant).or_default();
                    sessions.entry(trial.session).or_default().push([trial.repeat.into(), value]);
                }
            }
            if people.is_empty() {
                continue;
            }
            let (n, change) = change(&people, unit, parameters.level);
            let tested = change.as_ref().ok();
            rows.push(Learning {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                environment: environment.clone(),
                mode: mode.clone(),
                unit_of_analysis: unit.clone(),
                n,
                change: tested.map(|t| t.estimate),
                change_std_error: tested.map(|t| t.std_error),
                change_ci_low: tested.map(|t| t.ci_low),
                change_ci_high: tested.map(|t| t.ci_high),
                df: tested.map(|t| t.df),
                p_value: tested.map(|t| t.p_value),
                remark: change.as_ref().err().map(|why| why.to_string().into()),
            });
        }
    }
    rows
}

/// The number of units and their change per repeat, in one condition that somebody has.
fn change(
    people: &BTreeMap<usize, Sessions>,
    unit: &UnitOfAnalysis,
    level: f64,
) -> (usize, Result<Tested, Unestimable>) {
    let lists = |sessions: &Sessions| sessions.values().cloned().collect::<Vec<_>>();
    match unit {
        UnitOfAnalysis::Participants => {
            let slopes: Vec<f64> =
                people.values().filter_map(|sessions| line::slope(&lists(sessions))).collect();
            (slopes.len(), mean_difference(&slopes, level))
        }
        UnitOfAnalysis::TrialsOf(_) => {
            let trials = people.values().flat_map(BTreeMap::values).map(Vec::len).sum();
            let none = Unestimable::TooFew { units: "trials", found: 0, needed: 3 };
            let sessions = people.values().next();
            (trials, sessions.map_or(Err(none), |own| line::common_slope(&lists(own), level)))
        }
    }
}
