//! Practice apart from modes: somebody's own line over their trials, besides the means of the modes.

use std::collections::BTreeMap;

/// Modes whose order inflates the variance of a difference by more than this cannot be told apart from practice.
pub const MOST_INFLATED: f64 = 5.0;

/// A trial of somebody in an environment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrialPoint {
    /// Its session, any number.
    pub session: usize,
    /// Its mode, likewise.
    pub mode: usize,
    /// What the line is over: the number of the trial, or of the repeat.
    pub place: f64,
    /// The number of the trial in its session.
    pub number: f64,
    /// The metric.
    pub value: f64,
}

/// A condition in a weighted sum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeighedCondition {
    /// Its session; all of them with the same weight if none is named.
    pub session: Option<usize>,
    /// Its environment.
    pub environment: usize,
    /// Its mode.
    pub mode: usize,
    /// Its weight.
    pub weight: f64,
}

/// A participant's line in an environment: least squares besides a mean for each session and mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// Change of the metric from one place to the next, over all sessions.
    pub slope: f64,
    /// The middle of each session's places.
    centres: BTreeMap<usize, f64>,
    /// Sum of squares of the trials' numbers about the mean of their session and mode. Whatever the line is over, the
    /// numbers say how far modes and practice hang together.
    squares: f64,
    /// Trials in each session and mode, and the middle of their numbers.
    cells: BTreeMap<[usize; 2], (usize, f64)>,
}

impl Line {
    /// The line of somebody's trials in an environment; none of who did each mode once in a session.
    pub fn of(trials: &[TrialPoint]) -> Option<Self> {
        let mut cells: BTreeMap<[usize; 2], Vec<&TrialPoint>> = BTreeMap::new();
        let mut sessions: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for trial in trials {
            cells.entry([trial.session, trial.mode]).or_default().push(trial);
            sessions.entry(trial.session).or_default().push(trial.place);
        }
        let (mut along, mut products, mut squares) = (0.0, 0.0, 0.0);
        let mut middles = BTreeMap::new();
        for (cell, trials) in cells {
            let x = mean(trials.iter().map(|trial| trial.place));
            let number = mean(trials.iter().map(|trial| trial.number));
            let y = mean(trials.iter().map(|trial| trial.value));
            for trial in &trials {
                along += (trial.place - x).powi(2);
                squares += (trial.number - number).powi(2);
                products += (trial.place - x) * (trial.value - y);
            }
            middles.insert(cell, (trials.len(), number));
        }
        let centres = sessions.into_iter().map(|(id, places)| (id, mean(places.iter().copied())));
        (along > 0.0 && squares > 0.0).then(|| Self {
            slope: products / along,
            centres: centres.collect(),
            squares,
            cells: middles,
        })
    }

    /// The value of a trial in the middle of its session, along the line; none in a session that the line has no trial of.
    pub fn adjusted(&self, trial: &TrialPoint) -> Option<f64> {
        Some(trial.value - self.slope * (trial.place - self.centres.get(&trial.session)?))
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

/// How far somebody's lines move a weighted sum of their conditions, by environment: m/√(S v). m is how far apart the weights
/// have the trials along the line, S that line's sum of squares, and v the variance of the sum without lines, in units of that of
/// a trial: beside one line alone its variance is 1 + m²/(S v) times as large. None if they have no line in one of the
/// environments, or none of the conditions.
pub fn moved<'a>(
    weights: &[WeighedCondition],
    line_in: impl Fn(usize) -> Option<&'a Line>,
) -> Option<BTreeMap<usize, f64>> {
    let mut without = 0.0;
    // By environment: each has a line of its own.
    let mut moved: BTreeMap<usize, f64> = BTreeMap::new();
    for condition in weights {
        let line = line_in(condition.environment)?;
        let own = line.cells.iter().filter(|([session, mode], _)| {
            *mode == condition.mode && condition.session.is_none_or(|only| only == *session)
        });
        let own: Vec<_> = own.collect();
        let share = condition.weight / own.len().max(1) as f64;
        for ([session, _], (n, middle)) in own {
            without += share * share / *n as f64;
            *moved.entry(condition.environment).or_default() +=
                share * (middle - line.middle(*session));
        }
    }
    for (environment, moved) in &mut moved {
        *moved /= (line_in(*environment)?.squares * without).sqrt();
    }
    (without > 0.0).then_some(moved)
}

/// How many times lines make the variance of a weighted sum larger by what people's orders have in common: 1 + Σ m̄², where m̄
/// is the mean over these people of how far an environment's line moves the sum. Where all have one order it is that
/// of everybody's own line. Where orders balance each other it is 1, because what a line leaves of practice then has
/// different signs: it is in people's scatter, by which their mean is tested, and not in the mean (docs/statistics-tried.md).
pub fn inflation(people: &[BTreeMap<usize, f64>]) -> f64 {
    let mut sums: BTreeMap<usize, f64> = BTreeMap::new();
    for (environment, moved) in people.iter().flatten() {
        *sums.entry(*environment).or_default() += moved;
    }
    1.0 + sums.values().map(|sum| (sum / people.len() as f64).powi(2)).sum::<f64>()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let n = values.len() as f64;
    values.sum::<f64>() / n
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trials(modes: &[usize], value: impl Fn(usize, f64) -> f64) -> Vec<TrialPoint> {
        let trial = |(number, mode): (usize, &usize)| {
            let number = number as f64;
            TrialPoint {
                session: 0,
                mode: *mode,
                place: number,
                number,
                value: value(*mode, number),
            }
        };
        modes.iter().enumerate().map(trial).collect()
    }

    fn difference(weight: f64, mode: usize) -> WeighedCondition {
        WeighedCondition { session: None, environment: 0, mode, weight }
    }

    #[test]
    fn a_line_is_found_beside_the_modes_and_its_values_lie_in_the_middle() {
        let own = trials(&[0, 1, 1, 0, 0, 1], |mode, number| 3.0 * mode as f64 - 0.5 * number);
        let line = Line::of(&own).unwrap();
        assert!((line.slope + 0.5).abs() < 1e-12);
        for trial in &own {
            let expected = 3.0 * trial.mode as f64 - 0.5 * 2.5;
            assert!((line.adjusted(trial).unwrap() - expected).abs() < 1e-12);
        }
        assert_eq!(line.adjusted(&TrialPoint { session: 1, ..own[0] }), None);
        // Middles of the numbers: 7/3 of the first mode, 8/3 of the second.
        assert_eq!(Line::of(&trials(&[0, 1], |_, number| number)), None);
    }

    /// Var(difference) over σ²: the diagonal of (XᵀX)⁻¹ with columns of both modes and the number, by hand 1/n + 1/n + d²/S.
    #[test]
    fn blocks_inflate_by_the_square_of_their_distance_over_the_squares_within() {
        let weights = [difference(1.0, 1), difference(-1.0, 0)];
        let moved_by = |modes: &[usize]| {
            let line = Line::of(&trials(modes, |_, _| 0.0)).unwrap();
            moved(&weights, |_| Some(&line)).unwrap()
        };
        let of = |modes: &[usize]| inflation(&[moved_by(modes)]);
        // Three trials each, 3 apart; within each block 1 + 0 + 1.
        let expected = 1.0 + 3.0 * 3.0 / 4.0 / (1.0 / 3.0 + 1.0 / 3.0);
        assert!((of(&[0, 0, 0, 1, 1, 1]) - expected).abs() < 1e-12);
        assert!((of(&[0, 1, 1, 0]) - 1.0).abs() < 1e-12, "middles are the same");
        let line = Line::of(&trials(&[0, 0, 1, 1], |_, _| 0.0)).unwrap();
        assert_eq!(moved(&weights, |_| None), None);
        assert_eq!(moved(&[difference(1.0, 7)], |_| Some(&line)), None);
        // Of two people with opposite orders nothing is left; of three a third of the distance, 1 in the place of 3.
        let [one, other] = [[0, 0, 0, 1, 1, 1], [1, 1, 1, 0, 0, 0]].map(|modes| moved_by(&modes));
        assert!((inflation(&[one.clone(), one.clone()]) - expected).abs() < 1e-12);
        assert!((inflation(&[one.clone(), other.clone()]) - 1.0).abs() < 1e-12);
        let third = 1.0 + (expected - 1.0) / 9.0;
        assert!((inflation(&[one.clone(), other, one]) - third).abs() < 1e-12);
    }
}
