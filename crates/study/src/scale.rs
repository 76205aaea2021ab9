//! What may be answered to a question: the one list of scales.

use crate::{AnswerValue, Asks};
use serde::{Deserialize, Serialize};

/// A scale of answers: whole numbers at equal distances, from the most unfavourable to the most
/// favourable, each with its word if it has one. On a line, every number between them is an answer
/// too ([`AnswerScale::is_line`]).
#[derive(Debug, Clone, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AnswerScale {
    /// Five points of agreement (thesis §5.2.3).
    #[default]
    FivePoint,
    /// The study's own: so many points, from a number on (`points`, `from`, `step`, `labels` in
    /// `study.toml`).
    #[serde(skip_deserializing)]
    Numbers(NumberScale),
    /// The study's modes by their labels, numbered from 1 in the order of `study.toml`, and 0 for
    /// [`AnswerScale::DO_NOT_KNOW`] (`asks = "mode"`). Nominal: its numbers are names, with no
    /// order and no mean.
    #[serde(skip_deserializing)]
    Modes(Vec<String>),
    /// Which of two a person chose, by what they are called, numbered 1 and 2 (`pairs` of a score).
    /// Nominal, too.
    #[serde(skip_deserializing)]
    Pair([String; 2]),
    /// The answers to the question of a task, numbered from 1 ([`Asks::answers`]). Nominal, too.
    #[serde(skip_deserializing)]
    Task(Asks),
}

/// A scale by its numbers: −3 to 3, 0 to 6, 0 to 100 in steps of 5.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct NumberScale {
    /// How many answers there are.
    pub points: u8,
    /// The lowest answer.
    pub from: i16,
    /// From an answer to the next one.
    pub step: i16,
    /// Words: none, one for each end, one for each end and the middle, or one for each answer.
    pub labels: Vec<String>,
}

impl AnswerScale {
    /// Every scale that has a name.
    pub const NAMED: [Self; 1] = [Self::FivePoint];

    /// The word of the answer 0 to the question which mode it was.
    pub const DO_NOT_KNOW: &str = "do not know";

    /// The most points of a scale: a visual analogue from 0 to 100.
    pub const MOST_POINTS: u8 = 101;

    /// The most points of a scale whose answers are counted one by one, and modelled as ordered
    /// categories (0 to 10). A longer one is summarised by quartiles and means, as a quantity. The
    /// limit is this program's own choice: nobody reads a bar of more boxes, and few studies have
    /// an answer for each threshold of a longer model.
    pub const MOST_CATEGORIES: u8 = 11;

    /// The answers of [`AnswerScale::FivePoint`] in words, from 1 on.
    const AGREEMENT: [&str; 5] =
        ["strongly disagree", "disagree", "neutral", "agree", "strongly agree"];

    /// Its name in prose: `five-point scale`, `scale from -3 to 3`.
    pub fn name(&self) -> String {
        match self {
            Self::FivePoint => "five-point scale".to_owned(),
            Self::Numbers(_) => format!("scale from {}", self.range()),
            Self::Modes(labels) => format!("{} or “{}”", labels.join(", "), Self::DO_NOT_KNOW),
            Self::Pair(labels) => format!("“{}” or “{}”", labels[0], labels[1]),
            Self::Task(asks) => {
                let words: Vec<String> =
                    asks.answers().iter().map(|word| format!("“{word}”")).collect();
                words.join(" or ")
            }
        }
    }

    /// How many answers there are.
    pub fn points(&self) -> u8 {
        match self {
            Self::FivePoint => Self::AGREEMENT.len() as u8,
            Self::Numbers(scale) => scale.points,
            // No study with more modes than that may ask for them.
            Self::Modes(labels) => u8::try_from(labels.len() + 1).unwrap_or(Self::MOST_POINTS),
            Self::Pair(_) => 2,
            Self::Task(asks) => u8::try_from(asks.answers().len()).unwrap_or(Self::MOST_POINTS),
        }
    }

    /// The lowest answer, and from an answer to the next one.
    fn form(&self) -> (i16, i16) {
        match self {
            Self::Numbers(scale) => (scale.from, scale.step),
            Self::Modes(_) => (0, 1),
            Self::FivePoint | Self::Pair(_) | Self::Task(_) => (1, 1),
        }
    }

    /// From an answer to the next one.
    pub fn step(&self) -> i16 {
        self.form().1
    }

    /// The answer at a place, counted from 1.
    pub fn answer_at(&self, place: u8) -> i16 {
        let (from, step) = self.form();
        from.saturating_add((i16::from(place) - 1).saturating_mul(step))
    }

    /// The lowest answer.
    pub fn lowest(&self) -> i16 {
        self.answer_at(1)
    }

    /// The highest answer.
    pub fn highest(&self) -> i16 {
        self.answer_at(self.points())
    }

    /// Every whole answer, in rising order.
    pub fn answers(&self) -> Vec<i16> {
        (1..=self.points()).map(|place| self.answer_at(place)).collect()
    }

    /// The place of an answer, counted from 1; `None` if it is not an answer, or lies between two
    /// places of a line.
    pub fn place(&self, answer: impl Into<AnswerValue>) -> Option<u8> {
        let whole = answer.into().whole()?;
        (1..=self.points()).find(|place| self.answer_at(*place) == whole)
    }

    /// Whether this is an answer.
    pub fn has(&self, answer: impl Into<AnswerValue>) -> bool {
        let answer = answer.into();
        match self.is_line() {
            true => AnswerValue::from(self.lowest()) <= answer && answer <= self.highest().into(),
            false => self.place(answer).is_some(),
        }
    }

    /// Whether any number from its lowest to its highest is an answer: a slider gives such numbers
    /// (47.273), and nobody counts them one by one. Steps of another length are the study's own,
    /// and numbers between them were not offered.
    pub fn is_line(&self) -> bool {
        !self.is_short() && !self.is_nominal() && self.step() == 1
    }

    /// Whether its answers are counted one by one, and modelled as ordered categories
    /// ([`AnswerScale::MOST_CATEGORIES`]).
    pub fn is_ordinal(&self) -> bool {
        self.is_short() && !self.is_nominal()
    }

    /// Whether its answers are names, with no order: they are in no tally, median or model.
    pub fn is_nominal(&self) -> bool {
        matches!(self, Self::Modes(_) | Self::Pair(_) | Self::Task(_))
    }

    /// Whether a screen shows every answer, and not the ends alone.
    pub fn is_short(&self) -> bool {
        self.points() <= Self::MOST_CATEGORIES
    }

    /// The highest answer on any scale that has a name.
    pub fn most_points() -> u8 {
        Self::NAMED.iter().map(Self::points).max().unwrap_or_default()
    }

    /// The range of its answers in words: `1 to 5`, `0 to 100 in steps of 5`.
    pub fn range(&self) -> String {
        let ends = format!("{} to {}", self.lowest(), self.highest());
        match self.form() {
            (_, 1) => ends,
            (_, step) => format!("{ends} in steps of {step}"),
        }
    }

    /// What an answer must be, in words: `a whole number from 1 to 5`, `a number from 0 to 100`.
    pub fn must_be(&self) -> String {
        let number = if self.is_line() { "a number" } else { "a whole number" };
        format!("{number} from {}", self.range())
    }

    /// The word of an answer; `None` off the scale, or if the answer has no word.
    pub fn word(&self, answer: impl Into<AnswerValue>) -> Option<&str> {
        let place = usize::from(self.place(answer)?) - 1;
        match self {
            Self::FivePoint => Self::AGREEMENT.get(place).copied(),
            Self::Numbers(scale) => scale.word(place),
            Self::Modes(labels) => match place.checked_sub(1) {
                None => Some(Self::DO_NOT_KNOW),
                Some(mode) => labels.get(mode).map(String::as_str),
            },
            Self::Pair(labels) => labels.get(place).map(String::as_str),
            Self::Task(asks) => asks.answers().get(place).copied(),
        }
    }

    /// An answer with its word: `4 (agree)`; the number alone if it has no word.
    pub fn worded(&self, answer: impl Into<AnswerValue>) -> String {
        let answer = answer.into();
        match self.word(answer) {
            Some(word) => format!("{answer} ({word})"),
            None => answer.to_string(),
        }
    }

    /// Whether each answer has a word.
    pub fn has_all_words(&self) -> bool {
        self.answers().into_iter().all(|answer| self.word(answer).is_some())
    }

    /// The answer as it counts: lowest + highest − a where the question is reversed.
    pub fn score(&self, answer: impl Into<AnswerValue>, reversed: bool) -> AnswerValue {
        let answer = answer.into();
        if reversed { answer.turned(self.ends_together()) } else { answer }
    }

    /// Lowest + highest: what a reversed answer is taken from, and twice the middle.
    pub fn ends_together(&self) -> i16 {
        self.lowest() + self.highest()
    }
}

impl NumberScale {
    /// The word at a place, counted from 0.
    fn word(&self, place: usize) -> Option<&str> {
        let last = usize::from(self.points) - 1;
        let at = match self.labels.len() {
            0 => None,
            all if all == last + 1 => Some(place),
            // At equal distances: two words stand at the ends, three at the ends and the middle.
            ends => (0..ends).find(|at| at * last == place * (ends - 1)),
        };
        at.and_then(|at| self.labels.get(at)).map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(points: u8, from: i16, step: i16, labels: &[&str]) -> AnswerScale {
        let labels = labels.iter().map(|label| (*label).to_owned()).collect();
        AnswerScale::Numbers(NumberScale { points, from, step, labels })
    }

    fn scales() -> Vec<AnswerScale> {
        let own = [numbers(7, -3, 1, &[]), numbers(21, 0, 5, &[]), numbers(101, 0, 1, &[])];
        AnswerScale::NAMED.into_iter().chain(own).collect()
    }

    #[test]
    fn every_named_scale_has_a_word_for_each_answer_and_a_key_of_one_digit() {
        for scale in AnswerScale::NAMED {
            assert!((2..10).contains(&scale.points()), "{scale:?}");
            assert!(scale.has_all_words());
        }
    }

    #[test]
    fn every_answer_has_its_place_and_what_lies_off_the_scale_or_between_its_steps_has_none() {
        for scale in scales() {
            let answers = scale.answers();
            assert_eq!(answers.len(), usize::from(scale.points()));
            for (place, answer) in (1..).zip(&answers) {
                assert_eq!((scale.place(*answer), scale.answer_at(place)), (Some(place), *answer));
            }
            assert!(!scale.has(scale.lowest() - 1) && !scale.has(scale.highest() + 1));
            assert_eq!(scale.word(scale.highest() + 1), None);
        }
        assert!(!numbers(21, 0, 5, &[]).has(7));
    }

    #[test]
    fn a_reversed_answer_counts_from_the_other_end_and_twice_reversed_as_given() {
        for scale in scales() {
            for answer in scale.answers() {
                assert_eq!(scale.score(answer, false), answer.into());
                assert_eq!(scale.score(scale.score(answer, true), true), answer.into());
            }
            assert_eq!(scale.score(scale.lowest(), true), scale.highest().into());
        }
        assert_eq!(numbers(7, -3, 1, &[]).score(2, true), (-2).into());
        assert_eq!(numbers(21, 0, 5, &[]).score(5, true), 95.into());
        let [given, turned] = ["47.25", "52.75"].map(|text| text.parse::<AnswerValue>().unwrap());
        assert_eq!(numbers(101, 0, 1, &[]).score(given, true), turned);
    }

    #[test]
    fn words_stand_at_each_answer_or_at_the_ends_and_the_middle() {
        let words = |scale: AnswerScale| -> Vec<String> {
            scale.answers().into_iter().map(|answer| scale.worded(answer)).collect()
        };
        assert_eq!(
            words(numbers(3, 0, 1, &["no", "some", "much"])),
            ["0 (no)", "1 (some)", "2 (much)"]
        );
        assert_eq!(words(numbers(3, -1, 1, &["bad", "good"])), ["-1 (bad)", "0", "1 (good)"]);
        let ends_and_middle = words(numbers(5, -2, 1, &["bad", "neither", "good"]));
        assert_eq!(ends_and_middle, ["-2 (bad)", "-1", "0 (neither)", "1", "2 (good)"]);
        assert_eq!(words(numbers(2, 0, 1, &[])), ["0", "1"]);
    }

    #[test]
    fn a_scale_is_told_by_its_ends_and_its_step() {
        assert_eq!(AnswerScale::FivePoint.range(), "1 to 5");
        assert_eq!(numbers(7, -3, 1, &[]).name(), "scale from -3 to 3");
        assert_eq!(numbers(21, 0, 5, &[]).name(), "scale from 0 to 100 in steps of 5");
    }

    #[test]
    fn every_number_within_a_line_is_an_answer_and_whole_places_alone_on_any_other_scale() {
        let has =
            |scale: AnswerScale, given: &str| scale.has(given.parse::<AnswerValue>().unwrap());
        for given in ["0", "0.001", "47.273", "99.999", "100"] {
            assert!(has(numbers(101, 0, 1, &[]), given), "{given}");
        }
        assert!(!has(numbers(101, 0, 1, &[]), "-0.001"));
        assert!(!has(numbers(101, 0, 1, &[]), "100.001"));
        assert!(has(numbers(12, -3, 1, &[]), "-2.5"));
        let modes = AnswerScale::Modes((0..20).map(|mode| mode.to_string()).collect());
        for whole in [AnswerScale::FivePoint, numbers(11, 0, 1, &[]), numbers(21, 0, 5, &[]), modes]
        {
            assert!(!has(whole.clone(), "3.5") && !whole.is_line(), "{whole:?}");
        }
        assert!(!has(numbers(21, 0, 5, &[]), "47"));
        let line = numbers(101, 0, 1, &["no", "yes"]);
        let words =
            ["0", "47.273", "100"].map(|given| line.worded(given.parse::<AnswerValue>().unwrap()));
        assert_eq!(words, ["0 (no)", "47.273", "100 (yes)"]);
        assert_eq!(line.must_be(), "a number from 0 to 100");
        let steps = "a whole number from 0 to 100 in steps of 5";
        assert_eq!(numbers(21, 0, 5, &[]).must_be(), steps);
    }

    #[test]
    fn up_to_eleven_points_are_categories_and_more_are_a_quantity() {
        assert!(numbers(11, 0, 1, &[]).is_ordinal() && !numbers(12, 0, 1, &[]).is_ordinal());
    }

    #[test]
    fn the_modes_are_numbered_from_1_and_0_is_not_to_know() {
        let scale = AnswerScale::Modes(["Motor", "Brake"].map(str::to_owned).to_vec());
        let words: Vec<String> = scale.answers().into_iter().map(|a| scale.worded(a)).collect();
        assert_eq!(words, ["0 (do not know)", "1 (Motor)", "2 (Brake)"]);
        assert_eq!((scale.range().as_str(), scale.has(3), scale.has(-1)), ("0 to 2", false, false));
        assert_eq!(scale.name(), "Motor, Brake or “do not know”");
        assert!(scale.is_nominal() && !scale.is_ordinal() && scale.is_short());
        assert!(scales().iter().all(|scale| !scale.is_nominal()));
    }

    #[test]
    fn every_named_scale_has_a_word_in_files_of_its_own() {
        let words = AnswerScale::NAMED.map(|scale| serde_json::to_string(&scale).unwrap());
        assert_eq!(words.iter().collect::<std::collections::BTreeSet<_>>().len(), words.len());
        assert!(words.contains(&"\"five_point\"".to_owned()));
    }
}
