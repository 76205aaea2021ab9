//! What a row says of a presentation of a task, as the answer that is kept.

use zwidth_study::{Asks, Task, TaskLevel};

/// What a row says of an answer: what was pressed, what it was about, and how others judged it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Said {
    /// The place of what was answered, from 1 ([`Asks::answers`]).
    pub(super) answer: Option<i16>,
    /// The interval, 1 or 2, that held the level, and not the standard.
    pub(super) comparison: Option<i16>,
    /// Whether the answer was positive ([`Asks::is_positive`]).
    pub(super) positive: Option<bool>,
    /// Whether the answer was right.
    pub(super) correct: Option<bool>,
}

/// The answer that is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Judged {
    pub(super) value: i16,
    /// Whether the last of two intervals held the standard.
    pub(super) is_standard: Option<bool>,
    /// Nothing says which interval held the standard: it is taken for the first.
    pub(super) is_taken: bool,
    /// At the standard nothing is right or wrong, and what the row says of it was passed over.
    pub(super) is_unjudged: bool,
}

/// The answer that a row gives, if what it says agrees.
///
/// # Errors
/// It contradicts itself, or does not say enough.
pub(super) fn judge(task: &Task, level: TaskLevel, said: Said) -> Result<Judged, String> {
    let asks = task.asks;
    let has_two = asks.intervals() > 1;
    if !has_two && said.comparison.is_some() {
        return Err(format!(
            "'{}' has one interval in each presentation, so no interval holds the standard",
            task.id
        ));
    }
    let mut found: Vec<(&str, bool)> = Vec::new();
    if let Some(answer) = said.answer {
        let last_is_standard = said.comparison.map(|interval| interval == 1);
        found.extend(asks.is_positive(answer.into(), last_is_standard).map(|is| ("answer", is)));
    }
    found.extend(said.positive.map(|is| ("positive", is)));
    let mut is_unjudged = false;
    if let Some(correct) = said.correct {
        match right_is_positive(task, level) {
            Ok(right) => found.push(("correct", correct == right)),
            Err(why) if found.is_empty() => return Err(why),
            Err(_) => is_unjudged = true,
        }
    }
    if let [(first, is), others @ ..] = found.as_slice()
        && let Some((other, _)) = others.iter().find(|(_, other)| other != is)
    {
        let [is, is_not] = [*is, !*is].map(|is| words(asks, is));
        return Err(format!("'{first}' means {is}, and '{other}' means {is_not}"));
    }
    // A level that somebody set is right.
    let set = (asks == Asks::Set && said == Said::default()).then_some(true);
    let Some(is_positive) = found.first().map(|(_, is)| *is).or(set) else {
        return Err(match said.answer {
            Some(_) => "it is known which interval was chosen, and not which one held the standard"
                .to_owned(),
            None => "nothing says what was answered".to_owned(),
        });
    };
    if !has_two {
        let value = match (said.answer, asks, is_positive) {
            (Some(answer), ..) => answer,
            (None, Asks::Set, true) => 3,
            (None, Asks::Set, false) => {
                return Err("it is not known whether the level was to be more or less".to_owned());
            }
            (None, _, true) => 1,
            (None, _, false) => 2,
        };
        return Ok(Judged { value, is_standard: None, is_taken: false, is_unjudged });
    }
    // The one that was chosen, and whether it was chosen rightly, say which one held the level.
    let chosen = said.answer.map(|answer| if is_positive { answer } else { 3 - answer });
    let comparison = said.comparison.or(chosen);
    let interval = comparison.unwrap_or(2);
    Ok(Judged {
        value: if is_positive { interval } else { 3 - interval },
        is_standard: Some(interval == 1),
        is_taken: comparison.is_none(),
        is_unjudged,
    })
}

/// Whether the right answer at a level is the positive one.
///
/// # Errors
/// Nothing is right or wrong there.
pub(super) fn right_is_positive(task: &Task, level: TaskLevel) -> Result<bool, String> {
    let standard = task.standard.ok_or_else(|| {
        format!("'{}' has no standard in study.toml, so that nothing is right or wrong", task.id)
    });
    match task.asks {
        Asks::OneOfTwo => Ok(true),
        Asks::YesNo => Ok(level != standard?),
        Asks::MoreOfTwo | Asks::MoreLess => match standard? {
            standard if standard == level => Err(format!(
                "the level {} is the standard of '{}', where no answer is right or wrong",
                level.value(),
                task.id
            )),
            standard => Ok(level > standard),
        },
        Asks::Set => Err("where a level is set no answer is right or wrong".to_owned()),
    }
}

/// What a positive answer says, or one that is not.
fn words(asks: Asks, is_positive: bool) -> &'static str {
    match (asks, is_positive) {
        (Asks::MoreOfTwo, true) => "that there was more in the interval with the level",
        (Asks::MoreOfTwo, false) => "that there was more in the interval with the standard",
        (Asks::OneOfTwo, true) => "a right answer",
        (Asks::OneOfTwo, false) => "a wrong answer",
        (Asks::YesNo, true) => "yes",
        (Asks::YesNo, false) => "no",
        (Asks::MoreLess, true) => "more",
        (Asks::MoreLess, false) => "less",
        (Asks::Set, true) => "that the level is right",
        (Asks::Set, false) => "that the level is not right yet",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::{Method, TaskFit};

    fn task(asks: Asks) -> Task {
        Task {
            id: "stiffer".parse().unwrap(),
            text: "Which one?".to_owned(),
            asks,
            environment: "spring".parse().unwrap(),
            varies: "stiffness_n_per_rad".to_owned(),
            standard: TaskLevel::nearest(4.0),
            method: Method::Constant { levels: Vec::new(), trials: 1 },
            catch: 0.0,
            feedback: false,
            fit: TaskFit::default(),
            estimate: zwidth_study::TaskEstimate::Likelihood,
        }
    }

    /// The value that is kept, and whether the last interval is the standard's.
    fn kept(asks: Asks, level: f64, said: Said) -> (i16, Option<bool>) {
        let judged = judge(&task(asks), TaskLevel::nearest(level).unwrap(), said).unwrap();
        // Whatever is kept is read again as it was meant.
        (judged.value, judged.is_standard)
    }

    #[test]
    fn what_is_kept_is_read_as_what_was_said() {
        let answers = [None, Some(1), Some(2)];
        for asks in [Asks::MoreOfTwo, Asks::OneOfTwo] {
            for (level, right_is_positive) in [(5.0, true), (3.0, asks == Asks::OneOfTwo)] {
                for answer in answers {
                    for correct in [true, false] {
                        let said = Said { answer, correct: Some(correct), ..Said::default() };
                        let (value, is_standard) = kept(asks, level, said);
                        let is_positive = asks.is_positive(value.into(), is_standard);
                        assert_eq!(is_positive, Some(correct == right_is_positive));
                        assert!(answer.is_none_or(|answer| answer == value));
                    }
                }
            }
        }
    }

    #[test]
    fn the_interval_of_the_level_and_the_chosen_one_say_what_was_more() {
        for (answer, comparison, expect) in
            [(1, 1, (1, Some(true))), (2, 1, (2, Some(true))), (1, 2, (1, Some(false)))]
        {
            let said =
                Said { answer: Some(answer), comparison: Some(comparison), ..Said::default() };
            assert_eq!(kept(Asks::MoreOfTwo, 5.0, said), expect);
        }
        let positive = Said { positive: Some(false), ..Said::default() };
        assert_eq!(kept(Asks::MoreOfTwo, 4.0, positive), (1, Some(false)));
        assert_eq!(kept(Asks::YesNo, 4.0, positive), (2, None));
        assert_eq!(kept(Asks::Set, 4.0, Said::default()), (3, None));
    }

    #[test]
    fn right_and_wrong_mean_what_the_task_asks() {
        let right = |is| Said { correct: Some(is), ..Said::default() };
        for (asks, level, correct, value) in [
            (Asks::YesNo, 4.0, true, 2),
            (Asks::YesNo, 4.0, false, 1),
            (Asks::YesNo, 4.5, true, 1),
            (Asks::MoreLess, 3.0, true, 2),
            (Asks::MoreLess, 5.0, true, 1),
        ] {
            assert_eq!(kept(asks, level, right(correct)), (value, None), "{asks:?} {level}");
        }
    }

    #[test]
    fn what_contradicts_itself_or_says_too_little_is_refused_in_words() {
        let said =
            |answer, comparison, positive, correct| Said { answer, comparison, positive, correct };
        for (asks, level, said, words) in [
            (
                Asks::OneOfTwo,
                5.0,
                said(Some(1), Some(1), None, Some(false)),
                "'answer' means a right answer, and 'correct' means a wrong answer",
            ),
            (
                Asks::MoreLess,
                3.0,
                said(None, None, Some(true), Some(true)),
                "'positive' means more, and 'correct' means less",
            ),
            (Asks::MoreOfTwo, 5.0, said(Some(1), None, None, None), "which one held the standard"),
            (
                Asks::MoreOfTwo,
                4.0,
                said(None, None, None, Some(true)),
                "the level 4 is the standard",
            ),
            (Asks::YesNo, 5.0, said(Some(1), Some(2), None, None), "has one interval"),
            (Asks::YesNo, 5.0, Said::default(), "nothing says what was answered"),
            (Asks::Set, 5.0, said(None, None, None, Some(true)), "no answer is right or wrong"),
            (Asks::Set, 5.0, said(None, None, Some(false), None), "more or less"),
        ] {
            let error = judge(&task(asks), TaskLevel::nearest(level).unwrap(), said).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }

    #[test]
    fn at_the_standard_a_judgement_of_others_is_passed_over_where_the_answer_is_known() {
        let said =
            Said { answer: Some(1), comparison: Some(2), correct: Some(true), ..Said::default() };
        let judged = judge(&task(Asks::MoreOfTwo), TaskLevel::nearest(4.0).unwrap(), said).unwrap();
        assert_eq!((judged.value, judged.is_unjudged), (1, true));
    }
}
