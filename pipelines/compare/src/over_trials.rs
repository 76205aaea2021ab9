//! Means of modes adjusted for practice: everybody's own line over their trials, besides the modes.

use crate::Parameters;
use crate::measure::Measure;
use crate::trials::{Trial, Trials};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{TrialSlope, UnitOfAnalysis};
use zwidth_stats::paired;
use zwidth_study::OverTrials;

/// Modes whose order inflates the variance of a difference by more than this cannot be told apart from practice.
pub(crate) const MOST_INFLATED: f64 = 5.0;

/// The weight of a condition: of a session (of all of them if none is named), in an environment and a mode.
pub(crate) type Weighed = (Option<usize>, [usize; 2], f64);

/// A participant's line in an environment.
#[derive(Debug, Clone, PartialEq)]
struct Line {
    /// Change of the metric from trial to trial, over all sessions: modes have means of their own in each.
    slope: f64,
    /// The middle of each session's trials with the metric.
    centres: BTreeMap<usize, f64>,
    /// Sum of squares of the trials' numbers about the mean of their session and mode. Whatever the line is over, the
    /// numbers say how far modes and practice hang together.
    squares: f64,
    /// Trials with the metric in each session and mode, and the middle of their numbers.
    cells: BTreeMap<[usize; 2], (usize, f64)>,
}

/// Everybody's lines, by participant and environment.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Lines(BTreeMap<[usize; 2], Line>);

impl Lines {
    /// The lines over what `over` names of the trials. Who did each mode once in a session has none.
    pub(crate) fn of(trials: &Trials, over: OverTrials) -> Self {
        let mut people: BTreeMap<[usize; 2], Vec<(&Trial, f64)>> = BTreeMap::new();
        for trial in &trials.trials {
            let own = people.entry([trial.participant, trial.environment]).or_default();
            own.extend(trial.value.map(|value| (trial, value)));
        }
        let lines = people.into_iter().filter_map(|(who, own)| Some((who, Line::of(&own, over)?)));
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
            Some(
                trial.value?
                    - line.slope * (place(trial, over) - line.centres.get(&trial.session)?),
            )
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

    /// How many times the line makes the variance of a weighted sum of somebody's conditions larger, mean over
    /// participants.
    pub(crate) fn inflation(
        &self,
        people: impl Iterator<Item = usize>,
        weights: &[Weighed],
    ) -> f64 {
        let each: Vec<f64> = people.filter_map(|who| self.inflation_of(who, weights)).collect();
        each.iter().sum::<f64>() / each.len().max(1) as f64
    }

    fn inflation_of(&self, participant: usize, weights: &[Weighed]) -> Option<f64> {
        let mut without = 0.0;
        // By environment: each has a line of its own.
        let mut moved: BTreeMap<usize, f64> = BTreeMap::new();
        for (session, [environment, mode], weight) in weights {
            let line = self.0.get(&[participant, *environment])?;
            let own = line.cells.iter().filter(|([own_session, own_mode], _)| {
                own_mode == mode && session.is_none_or(|session| session == *own_session)
            });
            let own: Vec<_> = own.collect();
            let share = weight / own.len().max(1) as f64;
            for ([session, _], (n, middle)) in own {
                without += share * share / *n as f64;
                *moved.entry(*environment).or_default() += share * (middle - line.middle(*session));
            }
        }
        let by_lines: f64 = moved
            .iter()
            .filter_map(|(environment, moved)| {
                Some(moved * moved / self.0.get(&[participant, *environment])?.squares)
            })
            .sum();
        (without > 0.0).then(|| 1.0 + by_lines / without)
    }
}

impl Line {
    fn of(trials: &[(&Trial, f64)], over: OverTrials) -> Option<Self> {
        // Place, number and value of each trial.
        let mut cells: BTreeMap<[usize; 2], Vec<[f64; 3]>> = BTreeMap::new();
        let mut sessions: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for (trial, value) in trials {
            let place = place(trial, over);
            let own = cells.entry([trial.session, trial.mode]).or_default();
            own.push([place, f64::from(trial.number), *value]);
            sessions.entry(trial.session).or_default().push(place);
        }
        let (mut along, mut products, mut squares) = (0.0, 0.0, 0.0);
        let mut middles = BTreeMap::new();
        for (cell, points) in cells {
            let [x, number, y] = [0, 1, 2].map(|i| mean(points.iter().map(|point| point[i])));
            for point in &points {
                along += (point[0] - x).powi(2);
                squares += (point[1] - number).powi(2);
                products += (point[0] - x) * (point[2] - y);
            }
            middles.insert(cell, (points.len(), number));
        }
        let centres = sessions.into_iter().map(|(id, places)| (id, mean(places.iter().copied())));
        (along > 0.0 && squares > 0.0).then(|| Self {
            slope: products / along,
            centres: centres.collect(),
            squares,
            cells: middles,
        })
    }

    /// The middle of the numbers of a session's trials.
    fn middle(&self, session: usize) -> f64 {
        let own = self.cells.iter().filter(|([id, _], _)| *id == session).map(|(_, cell)| cell);
        let [sum, n] = own.fold([0.0, 0.0], |[sum, n], (count, middle)| {
            [sum + *count as f64 * middle, n + *count as f64]
        });
        sum / n
    }
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

fn place(trial: &Trial, over: OverTrials) -> f64 {
    f64::from(match over {
        OverTrials::Trial => trial.number,
        OverTrials::Repeat => trial.repeat,
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
    use crate::{Comparison, Parameters, compare};
    use zwidth_results::Verdict;
    use zwidth_study::OverTrials;

    /// Six people who become better from trial to trial, with trials in modes in that order.
    fn practised(order: [&'static str; 6]) -> Comparison {
        const CODES: [&str; 6] = ["P01", "P02", "P03", "P04", "P05", "P06"];
        let mut trials: Vec<Trial> = Vec::new();
        for (person, who) in CODES.into_iter().enumerate() {
            for (place, mode) in order.into_iter().enumerate() {
                let (person, place) = (person as f64, place as f64);
                let noise = 0.02 * (7.0 * person + 3.0 * place).sin();
                let value = 5.0 - (0.3 + 0.01 * person) * place + noise;
                trials.push((who, "S01", mode, 1, Some(value)));
            }
        }
        let over = Some(OverTrials::Trial);
        compare(&metrics(&trials), &Parameters { over, ..parameters() }).unwrap()
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
