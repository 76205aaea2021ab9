//! What the comparisons of repeats and of sessions say, in a sentence each.

use crate::compared::ComparedMetric;
use crate::findings::Finding;
use crate::gallery::Shown;
use zwidth_results::{Learning, Role, SessionChange};
use zwidth_study::Setup;
use zwidth_tables::{number, shown_unit, with_unit};

/// How participants changed from their first session to a later one, in a metric: one sentence, with
/// interval and n of each condition. There is no sentence if fewer than two participants came
/// again, because the change of one person concerns that person alone.
pub fn changes(
    study: &Setup,
    metric: &ComparedMetric,
    sessions: &[SessionChange],
) -> Option<Finding> {
    let (unit, factor) = shown_unit(&metric.metric.unit, study.coordinate);
    let changes = sessions.iter().filter_map(|row| {
        let environment = study.environments.iter().find(|e| e.id == row.environment)?;
        let mode = study.modes.iter().find(|m| m.id == row.mode)?;
        let error = row.change_std_error.map(|error| error * factor);
        let shown = |value: f64| number(value * factor, error);
        // One person's change says nothing of the others.
        (row.n > 1).then_some(())?;
        Some(format!(
            "{}, {}, {}: {} ({} to {}, n = {} participants)",
            environment.label,
            mode.label,
            row.sessions,
            with_unit(&shown(row.change?), &unit),
            shown(row.change_ci_low?),
            shown(row.change_ci_high?),
            row.n,
        ))
    });
    let changes: Vec<String> = changes.collect();
    if changes.is_empty() {
        return None;
    }
    let role = match metric.metric.role {
        Role::Primary => "the primary metric, ",
        Role::Exploratory => "",
    };
    let text = format!(
        "Exploratory, mean change between sessions in {role}{}: {}. Not adjusted for the number of changes.",
        metric.words(study.coordinate),
        changes.join("; ")
    );
    Some(Finding::new(text, Shown::Sessions(metric.metric.metric.to_string())))
}

/// How a metric changed from each repeat to the next: one sentence, with interval and n of each
/// condition that has a test.
pub fn learned(study: &Setup, metric: &ComparedMetric, learning: &[Learning]) -> Option<Finding> {
    let (unit, factor) = shown_unit(&metric.metric.unit, study.coordinate);
    let mut told = Vec::new();
    for row in learning {
        let environment = study.environments.iter().find(|e| e.id == row.environment)?;
        let mode = study.modes.iter().find(|m| m.id == row.mode)?;
        let (Some(change), Some(low), Some(high)) =
            (row.change, row.change_ci_low, row.change_ci_high)
        else {
            continue;
        };
        let error = row.change_std_error.map(|error| error * factor);
        told.push(format!(
            "{}, {}: {} ({} to {}, n = {} {})",
            environment.label,
            mode.label,
            with_unit(&number(change * factor, error), &unit),
            number(low * factor, error),
            number(high * factor, error),
            row.n,
            row.unit_of_analysis,
        ));
    }
    if told.is_empty() {
        return None;
    }
    let text = format!(
        "Exploratory, mean change per repeat in {}: {}. Not adjusted for the number of changes.",
        metric.words(study.coordinate),
        told.join("; ")
    );
    Some(Finding::new(text, Shown::Learning(metric.metric.metric.to_string())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compared::tests::metric;
    use zwidth_results::UnitOfAnalysis;

    fn told(n: [usize; 2]) -> Option<String> {
        let peak = metric("peak_n", "N", "peak force", UnitOfAnalysis::Participants);
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
        let metric = ComparedMetric {
            metric: &peak,
            is_primary_by_default: false,
            means: &[],
            contrasts: &[],
            redrawn: &[],
        };
        let rows = [change("active", n[0]), change("hybrid", n[1])];
        changes(&Setup::of(&zwidth_testing::study()), &metric, &rows)
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
    fn one_participant_tells_nothing_of_people() {
        assert_eq!(told([1, 1]), None);
    }
}
