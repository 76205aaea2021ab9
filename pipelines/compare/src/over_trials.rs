//! Means of modes adjusted for practice: everybody's own line over their trials, besides the modes.

use crate::Parameters;
use crate::measure::Measure;
use crate::trials::{Trial, Trials};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{TrialSlope, UnitOfAnalysis};
use zwidth_stats::over_trials::{Line, TrialPoint, WeighedCondition, inflation, moved};
use zwidth_stats::paired;
use zwidth_study::OverTrials;

/// Everybody's lines, by participant and environment.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Lines(BTreeMap<[usize; 2], Line>);

impl Lines {
    /// The lines over what `over` names of the trials. Who did each mode once in a session has none.
    pub(crate) fn of(trials: &Trials, over: OverTrials) -> Self {
        let mut people: BTreeMap<[usize; 2], Vec<TrialPoint>> = BTreeMap::new();
        for trial in &trials.trials {
            let own = people.entry([trial.participant, trial.environment]).or_default();
            own.extend(point(trial, over));
        }
        let lines = people.into_iter().filter_map(|(who, own)| Some((who, Line::of(&own)?)));
        Self(lines.collect())
    }

    /// The values of trials in the middle of their session, along everybody's own line; none of who has no line, unless
    /// nobody has one there: then they are as they were.
    pub(crate) fn adjusted(&self, trials: &Trials, over: OverTrials) -> Vec<Option<f64>> {
        let with_lines: BTreeSet<usize> = self.0.keys().map(|[_, place]| *place).collect();
        let value = |trial: &Trial| {
            if !with_lines.contains(&trial.environment) {
                return trial.value;
            }
            let line = self.0.get(&[trial.participant, trial.environment])?;
            line.adjusted(&point(trial, over)?)
        };
        trials.trials.iter().map(value).collect()
    }

    /// Environments, among these of participants, in which nobody has a line, and how many participants have none where
    /// others do.
    pub(crate) fn lacking(
        &self,
        places: impl Iterator<Item = [usize; 2]>,
    ) -> (BTreeSet<usize>, usize) {
        let with_lines: BTreeSet<usize> = self.0.keys().map(|[_, place]| *place).collect();
        let without = places.filter(|place| !self.0.contains_key(place));
        let (left_out, nobody): (Vec<_>, Vec<_>) =
            without.partition(|[_, environment]| with_lines.contains(environment));
        let people: BTreeSet<usize> = left_out.into_iter().map(|[who, _]| who).collect();
        (nobody.into_iter().map(|[_, environment]| environment).collect(), people.len())
    }

    /// How many times the lines make the variance of a weighted sum of conditions larger by what the orders of these
    /// people have in common.
    pub(crate) fn inflation(&self, people: &[usize], weights: &[WeighedCondition]) -> f64 {
        let of_person = |who: &usize| moved(weights, |place| self.0.get(&[*who, place]));
        inflation(&people.iter().filter_map(of_person).collect::<Vec<_>>())
    }
}

/// A trial that has the metric, with what the line is over.
fn point(trial: &Trial, over: OverTrials) -> Option<TrialPoint> {
    let place = match over {
        OverTrials::Trial => trial.number,
        OverTrials::Repeat => trial.repeat,
    };
    Some(TrialPoint {
        session: trial.session,
        mode: trial.mode,
        place: place.into(),
        number: trial.number.into(),
        value: trial.value?,
    })
}

/// How the metric changes along everybody's line: Student's t over participants, in each environment.
pub(crate) fn slopes(
    lines: Option<&Lines>,
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<TrialSlope> {
    let Some((over, lines)) = parameters.over.zip(lines) else { return Vec::new() };
    let rows = parameters.environments.iter().enumerate().filter_map(|(place, environment)| {
        let own = lines.0.iter().filter(|([_, own], _)| *own == place);
        let slopes: Vec<f64> = own.map(|(_, line)| line.slope).collect();
        if slopes.is_empty() {
            return None;
        }
        let found = paired::mean_difference(&slopes, parameters.level);
        let tested = found.as_ref().ok().filter(|_| *unit == UnitOfAnalysis::Participants);
        Some(TrialSlope {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: environment.clone(),
            over,
            n: slopes.len(),
            change_each: slopes.iter().sum::<f64>() / slopes.len() as f64,
            change_each_std_error: tested.map(|t| t.std_error),
            change_each_ci_low: tested.map(|t| t.ci_low),
            change_each_ci_high: tested.map(|t| t.ci_high),
            statistic: tested.map(|t| t.statistic),
            df: tested.map(|t| t.df),
            p_value: tested.map(|t| t.p_value),
        })
    });
    rows.collect()
}

#[cfg(test)]
mod tests {
    use crate::tests::{Trial, metrics, parameters};
    use crate::{Comparison, Groups, Parameters, compare};
    use zwidth_results::{GroupDifference, GroupEffect, Sentence, Verdict};
    use zwidth_study::{GroupsCompared, OverTrials};

    /// Six people who become better from trial to trial, with trials in modes in that order.
    fn practised(order: [&'static str; 6]) -> Comparison {
        practised_in([order, order])
    }

    /// Of whom every second one has the other order.
    fn practised_in(orders: [[&'static str; 6]; 2]) -> Comparison {
        practised_of([orders; 3].concat(), None)
    }

    /// People with these orders.
    fn practised_of(orders: Vec<[&'static str; 6]>, groups: Option<Groups>) -> Comparison {
        const CODES: [&str; 20] = [
            "P01", "P02", "P03", "P04", "P05", "P06", "P07", "P08", "P09", "P10", "P11", "P12",
            "P13", "P14", "P15", "P16", "P17", "P18", "P19", "P20",
        ];
        let mut trials: Vec<Trial> = Vec::new();
        for (person, (who, order)) in CODES.into_iter().zip(orders).enumerate() {
            for (place, mode) in order.into_iter().enumerate() {
                let (person, place) = (person as f64, place as f64);
                let noise = 0.02 * (7.0 * person + 3.0 * place).sin();
                let value = 5.0 - (0.3 + 0.01 * person) * place + noise;
                trials.push((who, "S01", mode, 1, Some(value)));
            }
        }
        let over = Some(OverTrials::Trial);
        compare(&metrics(&trials), &Parameters { over, groups, ..parameters() }).unwrap()
    }

    /// Groups of the people from P01 on, by the place of everybody's level.
    fn groups(levels: &[&str], contrasts: &[&str], of: &[usize]) -> Groups {
        let compared = GroupsCompared {
            column: "group".parse().unwrap(),
            contrasts: contrasts.iter().map(|contrast| contrast.parse().unwrap()).collect(),
            levels: levels.iter().map(|level| level.parse().unwrap()).collect(),
            assigned: false,
        };
        let code = |who: usize| format!("P{who:02}").parse().unwrap();
        let levels_of = (1..).map(code).zip(of.iter().copied()).collect();
        Groups { compared, levels_of, blocks: [].into() }
    }

    /// The difference between two groups in the first contrast of modes.
    fn between<'a>(found: &'a Comparison, groups: &str) -> &'a GroupDifference {
        let effect = GroupEffect::Of(found.contrasts[0].contrast.clone());
        let is_asked =
            |row: &&GroupDifference| row.effect == effect && row.groups.to_string() == groups;
        found.groups.iter().find(is_asked).unwrap()
    }

    fn is_refused_for_order(remark: Option<&Sentence>) -> bool {
        remark.is_some_and(|remark| remark.to_string().contains("11.7 times larger"))
    }

    #[test]
    fn practice_is_no_difference_between_modes_whose_trials_alternate() {
        let [h, a] = ["hybrid", "active"];
        let found = practised([a, h, h, a, a, h]);
        let row = &found.contrasts[0];
        assert!(row.difference.abs() < 0.02 && row.verdict == Verdict::Undecided, "{row:?}");
        assert!((found.over_trials[0].change_each + 0.325).abs() < 0.02);
        assert!(
            found.notes.iter().any(|note| note.note.to_string().starts_with("Means are adjusted"))
        );
    }

    #[test]
    fn modes_in_blocks_cannot_be_told_from_practice() {
        let [h, p, a] = ["hybrid", "passive", "active"];
        let found = practised([a, a, p, p, h, h]);
        let [far, near] = &found.contrasts[..] else { panic!("{:?}", found.contrasts) };
        // 1 + 4² / (3 · ½) / (½ + ½), and with neighbours 2² in the place of 4².
        let remark = far.remark.as_ref().unwrap().to_string();
        assert!(
            remark.contains("the variance beside a line over trials 11.7 times larger"),
            "{remark}"
        );
        assert_eq!((far.verdict, far.p_adjusted), (Verdict::NotTested, None));
        assert!(far.p_value.is_some() && near.remark.is_none() && near.p_adjusted.is_some());
    }

    #[test]
    fn orders_that_balance_each_other_leave_no_practice_in_a_difference_unless_they_are_those_of_groups()
     {
        let [h, p, a] = ["hybrid", "passive", "active"];
        let orders = [[a, a, p, p, h, h], [h, h, p, p, a, a]];
        let found = practised_in(orders);
        let row = &found.contrasts[0];
        assert!(row.remark.is_none() && row.p_adjusted.is_some(), "{row:?}");
        // Every second one is of the other group, and all of a group have one order.
        let groups = groups(&["odd", "even"], &["even − odd"], &[0, 1].repeat(4));
        let found = practised_of([orders; 4].concat(), Some(groups));
        let row = &found.contrasts[0];
        let remark = row.remark.as_ref().unwrap().to_string();
        assert!(remark.contains("11.7 times larger"), "{remark}");
        assert!(is_refused_for_order(between(&found, "even − odd").remark.as_ref()));
    }

    #[test]
    fn a_small_third_group_leaves_groups_of_one_order_each_without_a_claim() {
        let [h, p, a] = ["hybrid", "passive", "active"];
        let [up, down] = [[a, a, p, p, h, h], [h, h, p, p, a, a]];
        let orders = [vec![up; 8], vec![down; 8], vec![up; 2]].concat();
        let of = [vec![0; 8], vec![1; 8], vec![2; 2]].concat();
        let found = practised_of(
            orders,
            Some(groups(&["one", "two", "three"], &["two − one", "three − one"], &of)),
        );
        let remark = found.contrasts[0].remark.as_ref().unwrap().to_string();
        assert!(remark.contains("three has 2 participants"), "{remark}");
        let row = between(&found, "two − one");
        assert!(is_refused_for_order(row.remark.as_ref()), "{row:?}");
        assert_eq!((row.p_adjusted, row.verdict), (None, Some(Verdict::NotTested)));
    }

    #[test]
    fn the_one_order_of_a_third_group_refuses_no_difference_between_groups_whose_orders_balance() {
        let [h, p, a] = ["hybrid", "passive", "active"];
        let [up, down] = [[a, a, p, p, h, h], [h, h, p, p, a, a]];
        let orders = [[up, down].repeat(8), vec![up; 4]].concat();
        let of = [vec![0; 8], vec![1; 8], vec![2; 4]].concat();
        let found = practised_of(
            orders,
            Some(groups(&["one", "two", "three"], &["two − one", "three − one"], &of)),
        );
        // The difference between modes is over all groups, so the worst of them counts.
        assert!(is_refused_for_order(found.contrasts[0].remark.as_ref()));
        let row = between(&found, "two − one");
        assert!(row.remark.is_none() && row.p_adjusted.is_some(), "{row:?}");
        let row = between(&found, "three − one");
        assert!(is_refused_for_order(row.remark.as_ref()) && row.p_adjusted.is_none(), "{row:?}");
    }

    #[test]
    fn one_order_for_everybody_is_said_and_two_are_not() {
        let [h, a] = ["hybrid", "active"];
        let (first, second) = ([a, a, a, h, h, h], [h, h, h, a, a, a]);
        let said = |found: &Comparison| {
            let words = "spring: everybody had the modes in the same order";
            found.notes.iter().filter(|note| note.note.to_string().starts_with(words)).count()
        };
        // Below means, contrasts, effects, their analysis of variance, and groups.
        assert_eq!(said(&practised_in([first, first])), 5);
        assert_eq!(said(&practised_in([first, second])), 0);
    }

    #[test]
    fn who_did_each_mode_once_has_no_line() {
        let once = |who: &'static str| -> [Trial; 2] {
            [(who, "S01", "active", 1, Some(1.0)), (who, "S01", "hybrid", 1, Some(2.0))]
        };
        let trials = [once("P01"), once("P02")].concat();
        let over = Some(OverTrials::Repeat);
        let found = compare(&metrics(&trials), &Parameters { over, ..parameters() }).unwrap();
        // Nobody has one: the values stay as they are, and the note says so.
        assert!(found.contrasts[0].n == 2 && found.over_trials.is_empty());
        let notes: Vec<String> = found.notes.iter().map(|note| note.note.to_string()).collect();
        assert!(
            notes.iter().any(|note| note.starts_with("spring: nobody has a line")),
            "{notes:?}"
        );
        // Where others have one, who has none is left out.
        let mut more = trials.clone();
        more.extend([
            ("P01", "S01", "active", 2, Some(1.5)),
            ("P01", "S01", "hybrid", 2, Some(2.0)),
        ]);
        let found = compare(&metrics(&more), &Parameters { over, ..parameters() }).unwrap();
        assert_eq!((found.contrasts[0].n, found.over_trials[0].n), (1, 1));
        let notes: Vec<String> = found.notes.iter().map(|note| note.note.to_string()).collect();
        assert!(
            notes.iter().any(|note| note.starts_with("1 participant without a line")),
            "{notes:?}"
        );
    }
}
