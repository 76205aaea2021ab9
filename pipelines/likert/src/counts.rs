//! Counts of the points of a scale.

use std::collections::BTreeSet;
use zwidth_study::{AnswerScale, ParticipantId};

/// How often each point was chosen, and by whom.
#[derive(Debug, Clone)]
pub(crate) struct Counts {
    /// Of each point, from 1 on.
    of: Vec<usize>,
    pub(crate) participants: BTreeSet<ParticipantId>,
}

impl Counts {
    /// No answer yet, on a scale.
    pub(crate) fn on(scale: AnswerScale) -> Self {
        Self { of: vec![0; scale.points().into()], participants: BTreeSet::new() }
    }

    /// How often this point was chosen; none off the scale.
    pub(crate) fn of_point(&self, point: u8) -> Option<usize> {
        self.of.get(usize::from(point).checked_sub(1)?).copied()
    }

    /// Counts one answer as scored, which is on the scale.
    pub(crate) fn add(&mut self, scored: u8, participant: &ParticipantId) {
        self.of[usize::from(scored) - 1] += 1;
        self.participants.insert(participant.clone());
    }

    /// Counts all that `other`, of the same scale, counts.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.of.iter_mut().zip(&other.of).for_each(|(count, more)| *count += more);
        self.participants.extend(other.participants.iter().cloned());
    }

    pub(crate) fn n(&self) -> usize {
        self.of.iter().sum()
    }

    /// The lower and the upper median: the two middle answers, the same one for odd n. `None`
    /// without answers.
    pub(crate) fn medians(&self) -> Option<(i64, i64)> {
        let n = self.n();
        Some((self.ranked(n.checked_sub(1)? / 2)?, self.ranked(n / 2)?))
    }

    /// The answer at `rank` (from 0) of all answers in rising order.
    fn ranked(&self, rank: usize) -> Option<i64> {
        let mut below = 0;
        (1..).zip(&self.of).find_map(|(point, count)| {
            below += count;
            (rank < below).then_some(point)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(answers: &[u8], expect: Option<(i64, i64)>) {
        let mut counts = Counts::on(AnswerScale::FivePoint);
        for &answer in answers {
            counts.add(answer, &ParticipantId::new("P01").unwrap());
        }
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
}
