//! Counts of the answers on a scale, with their middle and spread.

use std::collections::BTreeMap;
use zwidth_numerics::moments::Moments;
use zwidth_numerics::order::quantile_by;
use zwidth_study::{AnswerScale, AnswerValue, ParticipantId};

/// How often each answer was given, and by whom.
#[derive(Debug, Clone)]
pub(crate) struct Counts {
    scale: AnswerScale,
    /// Of each answer that was given, as scored: on a line it may lie between two points.
    answers: BTreeMap<AnswerValue, usize>,
    /// Who gave them, with the sum and the number of theirs.
    pub(crate) participants: BTreeMap<ParticipantId, (f64, usize)>,
}

impl Counts {
    /// No answer yet, on a scale.
    pub(crate) fn on(scale: &AnswerScale) -> Self {
        Self { scale: scale.clone(), answers: BTreeMap::new(), participants: BTreeMap::new() }
    }

    /// The scale of the answers.
    pub(crate) fn scale(&self) -> &AnswerScale {
        &self.scale
    }

    /// How often the answer at this place of the scale was chosen, the lowest being the first;
    /// `None` off the scale.
    pub(crate) fn of_point(&self, place: u8) -> Option<usize> {
        let answer = self.scale.answer_at(place).into();
        self.scale.has(answer).then(|| self.answers.get(&answer).copied().unwrap_or(0))
    }

    /// Counts one answer as scored, which is on the scale.
    pub(crate) fn add(&mut self, scored: AnswerValue, participant: &ParticipantId) {
        *self.answers.entry(scored).or_default() += 1;
        let (sum, n) = self.participants.entry(participant.clone()).or_default();
        (*sum, *n) = (*sum + scored.get(), *n + 1);
    }

    /// Counts all that `other`, of the same scale, counts.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (answer, more) in &other.answers {
            *self.answers.entry(*answer).or_default() += more;
        }
        for (participant, (more, others)) in &other.participants {
            let (sum, n) = self.participants.entry(participant.clone()).or_default();
            (*sum, *n) = (*sum + more, *n + others);
        }
    }

    pub(crate) fn n(&self) -> usize {
        self.answers.values().sum()
    }

    /// The lower and the upper median: the two middle answers, the same one for odd n. `None`
    /// without answers.
    pub(crate) fn medians(&self) -> Option<(AnswerValue, AnswerValue)> {
        let n = self.n();
        Some((self.ranked(n.checked_sub(1)? / 2)?, self.ranked(n / 2)?))
    }

    /// The answer at `rank` (from 0) of all answers in rising order.
    fn ranked(&self, rank: usize) -> Option<AnswerValue> {
        let mut below = 0;
        self.answers.iter().find_map(|(answer, count)| {
            below += count;
            (rank < below).then_some(*answer)
        })
    }

    /// The quantile at `share`, as [`zwidth_numerics::order::quantile`]. `None` without answers.
    pub(crate) fn quantile(&self, share: f64) -> Option<f64> {
        quantile_by(self.n(), share, |rank| self.ranked(rank).map(AnswerValue::get))
    }

    /// The mean of people's means; of one person's answers where there is one. `None` without
    /// answers.
    pub(crate) fn mean(&self) -> Option<f64> {
        let moments = self.moments();
        (moments.n > 0.0).then_some(moments.mean)
    }

    /// The standard deviation between people's means, or of one person's answers (divisor n − 1);
    /// `None` for fewer than two.
    pub(crate) fn sd(&self) -> Option<f64> {
        self.moments().sd()
    }

    /// The moments of people's means; of one person's answers where there is one.
    fn moments(&self) -> Moments {
        // Each number with its weight. Repeats are not people: somebody who answered more often does
        // not count for more.
        let weighted: Vec<(f64, f64)> = match self.participants.len() {
            0 | 1 => self.answers.iter().map(|(answer, n)| (answer.get(), *n as f64)).collect(),
            _ => self.participants.values().map(|(sum, n)| (sum / *n as f64, 1.0)).collect(),
        };
        Moments::of_weighted(weighted.into_iter())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(answers: &[i16], expect: Option<(i16, i16)>) {
        let mut counts = Counts::on(&AnswerScale::FivePoint);
        for &answer in answers {
            counts.add(answer.into(), &ParticipantId::new("P01").unwrap());
        }
        let expect = expect.map(|(low, high)| (low.into(), high.into()));
        assert_eq!(counts.medians(), expect, "{answers:?}");
        assert_eq!(
            (counts.n(), counts.participants.len()),
            (answers.len(), usize::from(!answers.is_empty()))
        );
    }

    #[test]
    fn the_median_is_the_middle_answer_or_the_two_middle_ones() {
        check(&[], None);
        check(&[4], Some((4, 4)));
        check(&[5, 1], Some((1, 5)));
        check(&[3, 1, 5], Some((3, 3)));
        check(&[5, 5, 2, 1], Some((2, 5)));
        check(&[2, 2, 2, 5, 5], Some((2, 2)));
    }

    /// NumPy: `np.quantile([-3, -1, 0, 0, 2, 3], [0.25, 0.5, 0.75])`, `np.mean`, `np.std(ddof=1)`.
    #[test]
    fn quartiles_mean_and_deviation_are_those_of_numpy() {
        let labels = Vec::new();
        let scale = zwidth_study::NumberScale { points: 7, from: -3, step: 1, labels };
        let mut counts = Counts::on(&AnswerScale::Numbers(scale));
        assert_eq!((counts.quantile(0.5), counts.mean(), counts.sd()), (None, None, None));
        for answer in [3, 0, -3, 2, 0, -1_i16] {
            counts.add(answer.into(), &ParticipantId::new("P01").unwrap());
        }
        let quartiles = [0.25, 0.5, 0.75].map(|share| counts.quantile(share).unwrap());
        assert_eq!(quartiles.map(f64::to_bits), [-0.75, 0.0, 1.5].map(f64::to_bits));
        assert!((counts.mean().unwrap() - 1.0 / 6.0).abs() < 1e-15);
        assert!((counts.sd().unwrap() - 2.136_976_056_643_281).abs() < 1e-14);
        assert_eq!(counts.medians(), Some((0.into(), 0.into())));
    }

    /// Ten people of whom everybody answered six items alike scatter as ten numbers, not as sixty.
    #[test]
    fn mean_and_deviation_of_several_people_are_those_of_their_means() {
        let labels = Vec::new();
        let scale = zwidth_study::NumberScale { points: 101, from: 0, step: 1, labels };
        let mut counts = Counts::on(&AnswerScale::Numbers(scale));
        for (who, answers) in [("P01", [10, 30]), ("P02", [40, 60]), ("P03", [80, 80_i16])] {
            let who = ParticipantId::new(who).unwrap();
            answers.iter().for_each(|answer| counts.add((*answer).into(), &who));
        }
        assert!((counts.mean().unwrap() - 50.0).abs() < 1e-12);
        assert!((counts.sd().unwrap() - 30.0).abs() < 1e-12);
    }
}
