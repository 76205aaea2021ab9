//! `[[questions]]` of a `study.toml`: the scale of each, and the way back.

use super::check::Check;
use super::shape::QuestionTable;
use crate::{AnswerScale, NumberScale, Question, Schema};

/// An answer lies no farther from 0 on a scale's lower end.
const FARTHEST: i16 = 1_000;
/// No two neighbours of a scale lie farther apart.
const LONGEST_STEP: i16 = 100;

impl Check<'_> {
    /// The questions, each with its scale. What is pooled must be answered on one scale.
    pub(super) fn questions(
        &mut self,
        tables: Vec<QuestionTable>,
        schema: Schema,
    ) -> Vec<Question> {
        let mut questions: Vec<Question> = Vec::new();
        for (i, table) in tables.into_iter().enumerate() {
            let key = format!("questions[{i}]");
            let scale = self.scale(&key, &table, schema);
            let QuestionTable { id, text, group, reversed, .. } = table;
            let question = Question { id, text, group, scale, reversed };
            let of_group = |q: &&Question| q.group.is_some() && q.group == question.group;
            let first = questions.iter().find(of_group);
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

    /// The scale of a question: a named one, or so many points.
    fn scale(&mut self, key: &str, table: &QuestionTable, schema: Schema) -> AnswerScale {
        let Some(points) = table.points else {
            let given = [
                ("from", table.from.is_some()),
                ("step", table.step.is_some()),
                ("labels", !table.labels.is_empty()),
            ];
            for (name, _) in given.into_iter().filter(|(_, given)| *given) {
                let what = "is not used without points, the number of answers; add points";
                self.error(&format!("{key}.{name}"), what.to_owned());
            }
            return table.scale.clone().unwrap_or_default();
        };
        if table.scale.is_some() {
            let what = "is not used beside points; leave one of them out";
            self.error(&format!("{key}.scale"), what.to_owned());
        }
        if schema == Schema::One {
            let what = "trial files of schema 1 hold answers from 1 to 5; a new study with schema = 2 has others";
            self.error(&format!("{key}.points"), what.to_owned());
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
                self.error(&format!("{key}.labels[{i}]"), what.to_owned());
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
            named => (Some(named.clone()), None),
        };
        Self {
            id: question.id.clone(),
            text: question.text.clone(),
            group: question.group.clone(),
            scale,
            reversed: question.reversed,
            points: numbers.as_ref().map(|n| n.points.into()),
            from: numbers.as_ref().map(|n| n.from.into()),
            step: numbers.as_ref().map(|n| n.step.into()),
            labels: numbers.map(|n| n.labels).unwrap_or_default(),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::{AnswerScale, Study, StudyId, template};

    /// The template with these lines in its first question.
    fn asked(lines: &str) -> Result<Study, Vec<crate::StudyError>> {
        let text = template(&StudyId::new("demo").unwrap());
        Study::from_toml(&text.replacen("[[questions]]", &format!("[[questions]]\n{lines}"), 1))
    }

    fn scale(lines: &str) -> AnswerScale {
        asked(lines).unwrap().questions[0].scale.clone()
    }

    #[test]
    fn a_question_may_have_any_number_of_points_from_any_number_on() {
        let seven = scale("points = 7\nfrom = -3\nlabels = [\"bad\", \"neither\", \"good\"]");
        assert_eq!(seven.answers(), [-3, -2, -1, 0, 1, 2, 3]);
        assert_eq!(
            [-3, -2, 0, 3].map(|a| seven.worded(a)),
            ["-3 (bad)", "-2", "0 (neither)", "3 (good)"]
        );
        let load = scale("points = 21\nfrom = 0\nstep = 5");
        assert_eq!((load.lowest(), load.highest(), load.is_ordinal()), (0, 100, false));
        assert_eq!(scale("points = 7").answers(), [1, 2, 3, 4, 5, 6, 7]);
        assert_eq!(scale("points = 101\nfrom = 0").highest(), 100);
    }

    #[test]
    fn a_scale_by_its_numbers_survives_a_round_trip() {
        let study = asked("points = 7\nfrom = 0\nlabels = [\"low\", \"high\"]").unwrap();
        assert_eq!(Study::from_toml(&study.to_toml().unwrap()).unwrap(), study);
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
            let errors = asked(lines).unwrap_err();
            let key = format!("questions[0].{key}");
            let found =
                errors.iter().find(|e| e.key == key).unwrap_or_else(|| panic!("{errors:?}"));
            assert!(found.problem.contains(words) && found.line > 1, "{found}");
        }
    }

    #[test]
    fn an_environment_may_ask_several_questions_each_once() {
        let text = template(&StudyId::new("demo").unwrap());
        let with = |questions: &str| {
            Study::from_toml(&text.replacen("question = \"felt_spring\"", questions, 1))
        };
        let study = with("questions = [\"felt_wall\", \"felt_spring\"]").unwrap();
        let asked: Vec<&str> = study.environments[0].questions().map(|q| q.as_str()).collect();
        assert_eq!(asked, ["felt_wall", "felt_spring"]);
        assert_eq!(Study::from_toml(&study.to_toml().unwrap()).unwrap(), study);
        for (questions, key, words) in [
            ("questions = [\"felt_wall\", \"heat\"]", "questions[1]", "is not the id"),
            ("questions = [\"felt_wall\", \"felt_wall\"]", "questions[1]", "stands twice"),
            (
                "question = \"felt_wall\"\nquestions = [\"felt_spring\"]",
                "question",
                "beside questions",
            ),
        ] {
            let errors = with(questions).unwrap_err();
            let key = format!("environments[0].{key}");
            let found =
                errors.iter().find(|e| e.key == key).unwrap_or_else(|| panic!("{errors:?}"));
            assert!(found.problem.contains(words), "{found}");
        }
    }

    #[test]
    fn a_study_of_schema_1_has_the_answers_that_its_trial_files_hold() {
        let text = template(&StudyId::new("demo").unwrap());
        let text = text.replace("schema = 2", "schema = 1");
        let errors =
            Study::from_toml(&text.replacen("[[questions]]", "[[questions]]\npoints = 7", 1));
        assert!(errors.unwrap_err()[0].problem.contains("a new study with schema = 2"));
    }

    #[test]
    fn what_is_pooled_is_answered_on_one_scale() {
        let text = template(&StudyId::new("demo").unwrap());
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
