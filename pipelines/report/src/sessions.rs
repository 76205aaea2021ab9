//! What the comparisons of repeats and of sessions say, in a sentence each.

use crate::compared::{ComparedMetric, Primaries};
use crate::findings::Finding;
use crate::gallery::Shown;
use zwidth_results::{Learning, Role, SessionChange, Sides};
use zwidth_study::{EnvironmentId, ModeId, Setup};
use zwidth_tables::Amount;

/// How participants changed from their first session to a later one, in a metric: one sentence, with
/// interval and n of each condition. There is no sentence if fewer than two participants came
/// again, because the change of one person concerns that person alone.
pub fn changes(
    study: &Setup,
    metric: &ComparedMetric,
    sessions: &[SessionChange],
) -> Option<Finding> {
    let told = sessions.iter().filter_map(|row| {
        // One person's change says nothing of the others.
        (row.n > 1).then_some(())?;
        let place = place(study, &row.environment, &row.mode)?;
        let values = [row.change, row.change_ci_low, row.change_ci_high, row.change_std_error];
        let change = change(study, metric, values)?;
        let sessions = metric.amounts(study).compared(&row.sessions.to_string());
        Some(format!("{place}, {sessions}: {change}, n = {} participants)", row.n))
    });
    let told: Vec<String> = told.collect();
    let role = match (metric.metric.role, metric.primary) {
        (Role::Primary, Primaries::Several) => "a primary metric, ",
        (Role::Primary, _) => "the primary metric, ",
        (Role::Exploratory, _) => "",
        (Role::ChosenAfter, _) => "a metric chosen after the data, ",
    };
    let what = format!("between sessions in {role}{}", metric.words(study.coordinate));
    finding(&what, &told, Shown::Sessions(metric.metric.metric.to_string()))
}

/// How a metric changed from each repeat to the next: one sentence, with interval and n of each
/// condition that has a test.
pub fn learned(study: &Setup, metric: &ComparedMetric, learning: &[Learning]) -> Option<Finding> {
    let mut told = Vec::new();
    for row in learning {
        let place = place(study, &row.environment, &row.mode)?;
        let values = [row.change, row.change_ci_low, row.change_ci_high, row.change_std_error];
        let change = change(study, metric, values);
        told.extend(
            change.map(|change| {
                format!("{place}: {change}, n = {} {})", row.n, row.unit_of_analysis)
            }),
        );
    }
    let what = format!("per repeat in {}", metric.words(study.coordinate));
    finding(&what, &told, Shown::Learning(metric.metric.metric.to_string()))
}

/// The sentence on some changes, if there are any.
fn finding(what: &str, changes: &[String], shown: Shown) -> Option<Finding> {
    let list = changes.join("; ");
    let text =
        format!("Exploratory, mean change {what}: {list}. Not adjusted for the number of changes.");
    (!changes.is_empty()).then(|| Finding::new(text, shown))
}

/// `Spring, Active`.
fn place(study: &Setup, environment: &EnvironmentId, mode: &ModeId) -> Option<String> {
    let environment = study.environments.iter().find(|e| e.id == *environment)?;
    let mode = study.modes.iter().find(|m| m.id == *mode)?;
    Some(format!("{}, {}", environment.label, mode.label))
}

/// `−0.120 N (−0.150 to −0.090`, of logarithms `0.887 times (0.861 to 0.914`: a change with its interval, from these two
/// and its standard error, which sets the digits.
fn change(
    study: &Setup,
    metric: &ComparedMetric,
    [change, low, high, error]: [Option<f64>; 4],
) -> Option<String> {
    let amounts = metric.amounts(study);
    let Amount { text, ends } = amounts.told(change?, low.zip(high), error, Sides::Values);
    Some(format!("{text} ({}", ends?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compared::tests::{ln_jnd, metric, without_results};
    use zwidth_results::UnitOfAnalysis;

    fn told(n: [usize; 2]) -> Option<String> {
        told_of(&metric("peak_n", "N", "peak force", UnitOfAnalysis::Participants), n)
    }

    fn told_of(peak: &zwidth_results::Compared, n: [usize; 2]) -> Option<String> {
        let change = |mode: &str, n: usize| {
            // Without a second participant there is no interval.
            let known = |value: f64| (n > 1).then_some(value);
            SessionChange {
                metric: peak.metric.clone(),
                unit: peak.unit.clone(),
                environment: "spring".parse().unwrap(),
                mode: mode.parse().unwrap(),
                sessions: "S02 − S01".parse().unwrap(),
                n,
                mean_later: 0.88,
                mean_earlier: 1.0,
                change: known(-0.12),
                change_std_error: known(0.01),
                change_ci_low: known(-0.15),
                change_ci_high: known(-0.09),
                df: None,
                p_value: None,
                limit_low: None,
                limit_high: None,
                icc_a1: None,
                icc_a1_ci_low: None,
                icc_a1_ci_high: None,
                icc_c1: None,
                icc_ak: None,
                icc_ck: None,
                sem: None,
                mdc: None,
                icc_a1_all: None,
                icc_a1_all_ci_low: None,
                icc_a1_all_ci_high: None,
                sem_all: None,
                remark: None,
            }
        };
        let rows = [change("active", n[0]), change("hybrid", n[1])];
        changes(&Setup::of(&zwidth_testing::study()), &without_results(peak), &rows)
            .map(|found| found.text.to_string())
    }

    #[test]
    fn changes_are_told_with_interval_and_number_of_participants() {
        assert_eq!(
            told([5, 1]).unwrap(),
            "Exploratory, mean change between sessions in the primary metric, peak force: Spring, Active, \
             S02 − S01: −0.120\u{a0}N (−0.150 to −0.090, n = 5 participants). Not adjusted for the number of changes."
        );
    }

    #[test]
    fn changes_of_a_jnd_are_ratios() {
        assert_eq!(
            told_of(&ln_jnd(), [5, 1]).unwrap(),
            "Exploratory, mean change between sessions in the primary metric, JND: Spring, Active, S02 / S01: 0.8869 times \
             (0.8607 to 0.9139, n = 5 participants). Not adjusted for the number of changes."
        );
    }

    #[test]
    fn one_participant_tells_nothing_of_people() {
        assert_eq!(told([1, 1]), None);
    }
}
