//! `[[questions]]` of a `study.toml`: the scale of each, and the way back.

use super::check::Check;
use super::shape::{Asks, QuestionTable};
use crate::{AnswerScale, NumberScale, Question};

/// An answer lies no farther from 0 on a scale's lower end.
const FARTHEST: i16 = 1_000;
/// No two neighbours of a scale lie farther apart.
const LONGEST_STEP: i16 = 100;
/// The fewest modes with which a question can ask for the mode: nobody chooses one of one.
const LEAST_MODES: usize = 2;
/// The most modes of a study that asks which one it was: with 0 they are the answers of a scale.
const MOST_MODES: usize = AnswerScale::MOST_POINTS as usize - 1;

impl Check<'_> {
    /// The questions, each with its scale. What is pooled must be answered on one scale. `modes` are
    /// the labels of the study's modes, in its order.
    pub(super) fn questions(
        &mut self,
        tables: Vec<QuestionTable>,
        modes: &[&str],
    ) -> Vec<Question> {
        let mut questions: Vec<Question> = Vec::new();
        for (i, table) in tables.into_iter().enumerate() {
            let key = format!("questions[{i}]");
            let scale = match table.asks {
                Some(Asks::Mode) => self.modes_asked(&key, &table, modes),
                None => self.scale(&key, &table),
            };
            if scale.is_nominal() && questions.iter().any(Question::asks_mode) {
                let what = "stands twice: one question per study asks for the mode";
                self.error(&format!("{key}.asks"), what);
            }
            if table.label.as_deref().is_some_and(|label| label.trim().is_empty()) {
                self.error(&format!("{key}.label"), "is empty; name it, or leave the key out");
            }
            let QuestionTable { id, text, label, group, reversed, .. } = table;
            let question = Question { id, text, group, scale, reversed, label, is_weight: false };
            let first = questions.iter().find(|q| q.group.is_some() && q.group == question.group);
            if let Some(first) = first.filter(|first| first.scale != question.scale) {
                let what = format!(
                    "differs from that of '{}', which is of the same group: answers on different \
                     scales cannot be counted together",
                    first.id
                );
                self.error(&format!("{key}.scale"), what);
            }
            questions.push(question);
        }
        questions
    }

    /// The answers to the question which mode it was: the modes, and 0.
    fn modes_asked(&mut self, key: &str, table: &QuestionTable, modes: &[&str]) -> AnswerScale {
        let beside = [
            ("scale", table.scale.is_some()),
            ("points", table.points.is_some()),
            ("from", table.from.is_some()),
            ("step", table.step.is_some()),
            ("labels", !table.labels.is_empty()),
            ("label", table.label.is_some()),
            ("group", table.group.is_some()),
            ("reversed", table.reversed),
        ];
        for (name, _) in beside.into_iter().filter(|(_, is_present)| *is_present) {
            let what = "is not used beside asks, whose answers are the study's modes; leave it out";
            self.error(&format!("{key}.{name}"), what);
        }
        let at = format!("{key}.asks");
        let n = modes.len();
        if n < LEAST_MODES {
            let what = "the study has one mode: it can be asked for from two modes on";
            self.error(&at, what);
        }
        if n > MOST_MODES {
            let what = format!(
                "the study has {n} modes; at most {MOST_MODES} can be answers to a question"
            );
            self.error(&at, what);
        }
        let twice = modes.iter().enumerate().find(|(i, label)| modes[..*i].contains(label));
        if let Some((i, label)) = twice {
            let what = format!(
                "'{label}' is the label of two modes, which a question asks to tell apart; give each its own"
            );
            self.error(&format!("modes[{i}].label"), what);
        }
        AnswerScale::Modes(modes.iter().map(|label| (*label).to_owned()).collect())
    }

    /// The scale of a question: a named one, or a number of points.
    fn scale(&mut self, key: &str, table: &QuestionTable) -> AnswerScale {
        let Some(points) = table.points else {
            let without_points = [
                ("from", table.from.is_some()),
                ("step", table.step.is_some()),
                ("labels", !table.labels.is_empty()),
            ];
            for (name, _) in without_points.into_iter().filter(|(_, is_present)| *is_present) {
                let what = "is not used without points, the number of answers; add points";
                self.error(&format!("{key}.{name}"), what);
            }
            return table.scale.clone().unwrap_or_default();
        };
        if table.scale.is_some() {
            let what = "is not used beside points; leave one of them out";
            self.error(&format!("{key}.scale"), what);
        }
        let most = i16::from(AnswerScale::MOST_POINTS);
        let points = self.whole(&format!("{key}.points"), points, [2, most]);
        let from = table.from.unwrap_or(1);
        let from = self.whole(&format!("{key}.from"), from, [-FARTHEST, FARTHEST]);
        let step = self.whole(&format!("{key}.step"), table.step.unwrap_or(1), [1, LONGEST_STEP]);
        self.labels(key, &table.labels, usize::from(points.unsigned_abs()));
        // Within `MOST_POINTS`, which is a u8.
        let points = u8::try_from(points).unwrap_or(AnswerScale::MOST_POINTS);
        AnswerScale::Numbers(NumberScale { points, from, step, labels: table.labels.clone() })
    }

    /// A whole number between two, or the nearer of them.
    fn whole(&mut self, key: &str, value: i64, [least, most]: [i16; 2]) -> i16 {
        let held = value.clamp(least.into(), most.into());
        if held != value {
            self.error(key, format!("{value} must be from {least} to {most}"));
        }
        i16::try_from(held).unwrap_or(least)
    }

    /// Words for no answer, for the ends, for ends and middle, or for each answer.
    fn labels(&mut self, key: &str, labels: &[String], points: usize) {
        for (i, label) in labels.iter().enumerate() {
            self.line(&format!("{key}.labels[{i}]"), label);
            if label.trim().is_empty() {
                let what = "is empty; name the two ends alone where not every answer has a word";
                self.error(&format!("{key}.labels[{i}]"), what);
            }
        }
        let n = labels.len();
        let middle = if points % 2 == 1 { ", 3 (both ends and the middle)" } else { "" };
        if n != 0 && n != 2 && n != points && (n != 3 || points.is_multiple_of(2)) {
            let what =
                format!("{n} words for {points} points; give 2 (both ends){middle} or {points}");
            self.error(&format!("{key}.labels"), what);
        }
    }
}

impl QuestionTable {
    /// The table of a question.
    pub(super) fn of(question: &Question) -> Self {
        let (scale, numbers) = match &question.scale {
            AnswerScale::Numbers(scale) => (None, Some(scale.clone())),
            AnswerScale::Modes(_) | AnswerScale::Pair(_) | AnswerScale::Task(_) => (None, None),
            AnswerScale::FivePoint => (Some(AnswerScale::FivePoint), None),
        };
        let asks = question.asks_mode().then_some(Asks::Mode);
        Self {
            id: question.id.clone(),
            text: question.text.clone(),
            label: question.label.clone(),
            group: question.group.clone(),
            scale,
            reversed: question.reversed,
            points: numbers.as_ref().map(|n| n.points.into()),
            from: numbers.as_ref().map(|n| n.from.into()),
            step: numbers.as_ref().map(|n| n.step.into()),
            labels: numbers.map(|n| n.labels).unwrap_or_default(),
            asks,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::tests::{check_refused, check_round_trip, text};
    use crate::{AnswerScale, Study, StudyError};

    /// The template with these lines in its first question.
    fn asked(lines: &str) -> Result<Study, Vec<StudyError>> {
        Study::from_toml(&text().replacen("[[questions]]", &format!("[[questions]]\n{lines}"), 1))
    }

    /// A text is refused: for this key, in these words, whatever is wrong with it besides.
    #[track_caller]
    fn check_among(read: Result<Study, Vec<StudyError>>, key: &str, words: &str) {
        let errors = read.unwrap_err();
        let found = errors.iter().find(|e| e.key == key).unwrap_or_else(|| panic!("{errors:?}"));
        assert!(found.problem.contains(words) && found.line > 1, "{found}");
    }

    fn scale(lines: &str) -> AnswerScale {
        asked(lines).unwrap().questions[0].scale.clone()
    }

    #[test]
    fn a_question_may_have_any_number_of_points_from_any_number_on() {
        let seven = scale("points = 7\nfrom = -3\nlabels = [\"bad\", \"neither\", \"good\"]");
        assert_eq!(seven.answers(), [-3, -2, -1, 0, 1, 2, 3]);
        let worded = [-3, -2, 0, 3].map(|a| seven.worded(a));
        assert_eq!(worded, ["-3 (bad)", "-2", "0 (neither)", "3 (good)"]);
        let load = scale("points = 21\nfrom = 0\nstep = 5");
        assert_eq!((load.lowest(), load.highest(), load.is_ordinal()), (0, 100, false));
        assert_eq!(scale("points = 7").answers(), [1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(scale("points = 101\nfrom = 0").highest(), 100);
    }

    #[test]
    fn a_scale_by_its_numbers_survives_a_round_trip() {
        let study = asked("points = 7\nfrom = 0\nlabels = [\"low\", \"high\"]").unwrap();
        check_round_trip(&study);
    }

    #[test]
    fn a_question_may_ask_which_mode_it_was() {
        let study = asked("asks = \"mode\"").unwrap();
        let labels: Vec<String> = study.modes.iter().map(|mode| mode.label.clone()).collect();
        assert_eq!(study.questions[0].scale, AnswerScale::Modes(labels));
        assert!(!study.questions[0].is_rating() && study.questions[1].is_rating());
        assert!(!study.trial_form().likert);
        check_round_trip(&study);
    }

    #[test]
    fn a_question_for_the_mode_has_no_scale_of_its_own() {
        for (key, value) in [
            ("points", "3"),
            ("scale", "\"five_point\""),
            ("from", "0"),
            ("step", "2"),
            ("label", "\"a\""),
            ("labels", "[\"a\", \"b\"]"),
            ("group", "\"g\""),
            ("reversed", "true"),
        ] {
            let read = asked(&format!("asks = \"mode\"\n{key} = {value}"));
            check_refused(read, &format!("questions[0].{key}"), "is not used beside asks");
        }
        check_refused(asked("asks = \"force\""), "asks", "expected `mode`");
    }

    #[test]
    fn a_mode_is_asked_for_once_and_of_modes_that_can_be_told_apart() {
        let text = text().replacen("[[questions]]", "[[questions]]\nasks = \"mode\"", 1);
        let check = |text: &str, key, words| check_refused(Study::from_toml(text), key, words);
        let twice = text.replace("\"mode\"", "'mode'").replacen(
            "[[questions]]\nid",
            "[[questions]]\nasks = \"mode\"\nid",
            1,
        );
        check(&twice, "questions[1].asks", "stands twice");
        let same = text.replace("label = \"Passive\"", "label = \"Active\"");
        check(&same, "modes[1].label", "the label of two modes");
        let from = text.find("[[modes]]\nid = \"passive\"").unwrap();
        let to = text.find("[[questions]]").unwrap();
        let one = format!("{}{}", &text[..from], &text[to..]);
        check(&one, "questions[0].asks", "from two modes on");
    }

    #[test]
    fn a_scale_that_cannot_be_is_refused_with_its_key() {
        for (lines, key, words) in [
            ("points = 1", "points", "from 2 to 101"),
            ("points = 102", "points", "from 2 to 101"),
            ("points = -7", "points", "from 2 to 101"),
            ("points = 9223372036854775807", "points", "from 2 to 101"),
            ("points = 7\nfrom = 5000", "from", "-1000 to 1000"),
            ("points = 7\nstep = 0", "step", "from 1 to 100"),
            ("from = 0", "from", "without points"),
            ("labels = [\"a\", \"b\"]", "labels", "without points"),
            ("points = 7\nscale = \"five_point\"", "scale", "beside points"),
            ("points = 7\nlabels = [\"a\", \"b\", \"c\", \"d\"]", "labels", "4 words for 7 points"),
            ("points = 4\nlabels = [\"a\", \"b\", \"c\"]", "labels", "give 2 (both ends) or 4"),
            ("points = 2\nlabels = [\"a\", \" \"]", "labels[1]", "is empty"),
            ("points = 2\nlabels = [\"a\\n\", \"b\"]", "labels[0]", "breaks a line"),
        ] {
            check_among(asked(lines), &format!("questions[0].{key}"), words);
        }
    }

    #[test]
    fn an_environment_may_ask_several_questions_each_once() {
        let with = |questions: &str| {
            Study::from_toml(&text().replacen("question = \"felt_spring\"", questions, 1))
        };
        let study = with("questions = [\"felt_wall\", \"felt_spring\"]").unwrap();
        let asked: Vec<&str> = study.environments[0].questions().map(|q| q.as_str()).collect();
        assert_eq!(asked, ["felt_wall", "felt_spring"]);
        check_round_trip(&study);
        for (questions, key, words) in [
            ("questions = [\"felt_wall\", \"heat\"]", "questions[1]", "is not the id"),
            ("questions = [\"felt_wall\", \"felt_wall\"]", "questions[1]", "stands twice"),
            (
                "question = \"felt_wall\"\nquestions = [\"felt_spring\"]",
                "question",
                "beside questions",
            ),
        ] {
            check_among(with(questions), &format!("environments[0].{key}"), words);
        }
    }

    #[test]
    fn what_is_pooled_is_answered_on_one_scale() {
        let text = text();
        let (before, after) = text.split_once("[[questions]]").unwrap();
        let with = |scales: [&str; 2]| {
            let (first, second) = after.split_once("[[questions]]").unwrap();
            let [a, b] = scales.map(|scale| format!("[[questions]]\ngroup = \"g\"\n{scale}"));
            Study::from_toml(&format!("{before}{a}{first}{b}{second}"))
        };
        assert!(with(["points = 7\n", "points = 7\n"]).is_ok());
        let errors = with(["points = 7\n", ""]).unwrap_err();
        assert!(errors[0].problem.contains("cannot be counted together"), "{errors:?}");
    }
}
