//! What may be answered to a question: the one list of scales.

use serde::{Deserialize, Serialize};

/// A scale of answers: whole numbers from 1 on, from the most unfavourable to the most favourable,
/// each with its word. It is ordinal, whatever its length.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(rename_all = "snake_case")]
pub enum AnswerScale {
    /// Five points of agreement (thesis §5.2.3).
    #[default]
    FivePoint,
}

impl AnswerScale {
    /// Every scale.
    pub const ALL: [Self; 1] = [Self::FivePoint];

    /// More points than a scale may have: a key of one digit answers.
    pub const POINTS_END: u8 = 10;

    /// Its name in prose, and its answers in words, from 1 on.
    const fn about(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::FivePoint => (
                "five-point scale",
                &["strongly disagree", "disagree", "neutral", "agree", "strongly agree"],
            ),
        }
    }

    /// Its name in prose: `five-point scale`.
    pub const fn name(self) -> &'static str {
        self.about().0
    }

    /// The answers in words, from 1 on.
    pub const fn words(self) -> &'static [&'static str] {
        self.about().1
    }

    /// The highest answer.
    pub const fn points(self) -> u8 {
        // A test holds it below `POINTS_END`.
        self.words().len() as u8
    }

    /// Whether this is an answer.
    pub fn has(self, answer: u8) -> bool {
        (1..=self.points()).contains(&answer)
    }

    /// The highest answer on any scale.
    pub fn most_points() -> u8 {
        Self::ALL.map(Self::points).into_iter().max().unwrap_or_default()
    }

    /// The range of its answers in words: `1 to 5`.
    pub fn range(self) -> String {
        format!("1 to {}", self.points())
    }

    /// The word of an answer; none off the scale.
    pub fn word(self, answer: u8) -> Option<&'static str> {
        self.words().get(usize::from(answer.checked_sub(1)?)).copied()
    }

    /// The answer as it counts: points + 1 − a where the question is reversed.
    pub fn score(self, answer: u8, reversed: bool) -> u8 {
        if reversed { self.points() + 1 - answer } else { answer }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scale_has_a_word_for_each_answer_and_a_key_of_one_digit() {
        for scale in AnswerScale::ALL {
            assert!((2..AnswerScale::POINTS_END).contains(&scale.points()), "{scale:?}");
            assert!((1..=scale.points()).all(|a| scale.has(a) && scale.word(a).is_some()));
            assert!(!scale.has(0) && !scale.has(scale.points() + 1));
            assert_eq!((scale.word(0), scale.word(scale.points() + 1)), (None, None));
        }
    }

    #[test]
    fn a_reversed_answer_counts_from_the_other_end_and_twice_reversed_as_given() {
        for scale in AnswerScale::ALL {
            for answer in 1..=scale.points() {
                assert_eq!(scale.score(answer, false), answer);
                assert_eq!(scale.score(scale.score(answer, true), true), answer);
            }
            assert_eq!(scale.score(1, true), scale.points());
        }
    }

    #[test]
    fn every_scale_has_a_word_in_files_of_its_own() {
        let words = AnswerScale::ALL.map(|scale| serde_json::to_string(&scale).unwrap());
        assert_eq!(words.iter().collect::<std::collections::BTreeSet<_>>().len(), words.len());
        assert!(words.contains(&"\"five_point\"".to_owned()));
    }
}
