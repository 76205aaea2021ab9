//! Counts of the answers on a scale, and what they say of the middle and the spread.

use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::{AnswerScale, AnswerValue, ParticipantId};

/// How often each answer was given, and by whom.
#[derive(Debug, Clone)]
pub(crate) struct Counts {
    scale: AnswerScale,
    /// Of each answer that was given, as scored: on a line it may lie between two points.
    of: BTreeMap<AnswerValue, usize>,
    pub(crate) participants: BTreeSet<ParticipantId>,
}

impl Counts {
    /// No answer yet, on a scale.
    pub(crate) fn on(scale: &AnswerScale) -> Self {
        Self { scale: scale.clone(), of: BTreeMap::new(), participants: BTreeSet::new() }
    }

    /// The scale of the answers.
    pub(crate) fn scale(&self) -> &AnswerScale {
        &self.scale
    }

    /// How often the answer at this place of the scale was chosen, the lowest being the first;
    /// `None` off the scale.
    pub(crate) fn of_point(&self, place: u8) -> Option<usize> {
        let answer = self.scale.answer_at(place).into();
        self.scale.has(answer).then(|| self.of.get(&answer).copied().unwrap_or(0))
    }

    /// Counts one answer as scored, which is on the scale.
    pub(crate) fn add(&mut self, scored: AnswerValue, participant: &ParticipantId) {
        *self.of.entry(scored).or_default() += 1;
        self.participants.insert(participant.clone());
    }

    /// Counts all that `other`, of the same scale, counts.
    pub(crate) fn merge(&mut self, other: &Self) {
        for (answer, more) in &other.of {
            *self.of.entry(*answer).or_default() += more;
        }
        self.participants.extend(other.participants.iter().cloned());
    }

    pub(crate) fn n(&self) -> usize {
        self.of.values().sum()
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
        self.of.iter().find_map(|(answer, count)| {
            below += count;
            (rank < below).then_some(*answer)
        })
    }

    /// The quantile at `share`, between the two answers beside rank (n − 1) · share by how far it
    /// lies from each (Hyndman & Fan 1996, Am. Stat. 50:361, definition 7: that of R and NumPy).
    pub(crate) fn quantile(&self, share: f64) -> Option<f64> {
        let rank = self.n().checked_sub(1)? as f64 * share;
        let low = self.ranked(rank as usize)?.get();
        let high = self.ranked(rank.ceil() as usize)?.get();
        Some(low + (high - low) * rank.fract())
    }

    /// Each answer with how often it was given.
    fn answers(&self) -> impl Iterator<Item = (f64, f64)> {
        self.of.iter().map(|(answer, n)| (answer.get(), *n as f64))
    }

    /// The mean; `None` without answers.
    pub(crate) fn mean(&self) -> Option<f64> {
        let sum: f64 = self.answers().map(|(answer, n)| answer * n).sum();
        (self.n() > 0).then(|| sum / self.n() as f64)
    }

    /// The standard deviation (divisor n − 1); `None` for fewer than two answers.
    pub(crate) fn sd(&self) -> Option<f64> {
        let mean = self.mean().filter(|_| self.n() > 1)?;
        let squares: f64 =
            self.answers().map(|(answer, n)| n * (answer - mean) * (answer - mean)).sum();
        Some((squares / (self.n() - 1) as f64).sqrt())
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
}
