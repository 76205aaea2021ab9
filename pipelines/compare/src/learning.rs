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
            let (n, tested) = change(people, unit, parameters.level);
            let remark = tested.as_ref().err().map(|why| why.to_string().into());
            let tested = tested.as_ref().ok();
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
                remark,
            });
        }
    }
    rows
}

/// The units of analysis in one condition that somebody has, and their change per repeat.
fn change(
    people: BTreeMap<usize, Sessions>,
    unit: &UnitOfAnalysis,
    level: f64,
) -> (usize, Result<Tested, Unestimable>) {
    let people: Vec<Vec<Vec<[f64; 2]>>> =
        people.into_values().map(|sessions| sessions.into_values().collect()).collect();
    match unit {
        UnitOfAnalysis::Participants => {
            let slopes: Vec<f64> = people.iter().filter_map(|own| line::slope(own)).collect();
            (slopes.len(), mean_difference(&slopes, level))
        }
        UnitOfAnalysis::TrialsOf(_) => {
            let none = Unestimable::TooFew { units: "trials", found: 0, needed: 3 };
            let tested = people.first().map_or(Err(none), |own| line::common_slope(own, level));
            (people.iter().flatten().map(Vec::len).sum(), tested)
        }
    }
}
