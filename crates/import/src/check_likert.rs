//! Checks a mapping of a questionnaire: where its answers are.

use super::check::Check;
use super::mapping::{AnswerForm, Content, LongForm, Questionnaire, RowTrial};
use super::shape::{ConditionShape, QuestionsShape, TrialShape};
use super::unit::{self, Dimension, Unit};
use std::collections::BTreeMap;
use zwidth_study::QuestionId;

impl Check<'_> {
    pub(super) fn likert(
        &mut self,
        trial: Option<TrialShape>,
        shape: QuestionsShape,
        conditions: Vec<ConditionShape>,
        groups: &[&str],
    ) -> Option<Content> {
        if trial.as_ref().is_some_and(|trial| trial.likert.is_some()) {
            self.error("trial.likert", "is not used in a mapping of this kind; remove it");
        }
        let has_times = conditions.iter().any(|condition| !condition.times.is_empty());
        let is_timed = has_times || shape.time.is_some() || !shape.times.is_empty();
        let time_unit = self.time_unit("questions.time_unit", shape.time_unit.as_deref(), is_timed);
        let translate = shape.translate.clone();
        let lowest = shape.lowest;
        let one_each =
            "is not used beside question and answer, which mean one row per answer; remove it";
        let is_long = shape.question.is_some() || shape.answer.is_some();
        let form = match (is_long, conditions.is_empty()) {
            (false, false) => self.conditions(trial, &shape, conditions, groups)?,
            // A column a question.
            (false, true) => {
                if shape.time.is_some() {
                    let what = "belongs to a table with one row per answer; list the columns of times by question in \
                                [questions.times]";
                    self.error("questions.time", what);
                }
                let who = self.who(trial, groups);
                let columns = self.by_question("questions.columns", shape.columns);
                let times = self.by_question("questions.times", shape.times);
                AnswerForm::Wide(vec![RowTrial { who: who?, columns, times }])
            }
            // A row an answer.
            (true, has_no_conditions) => {
                if !has_no_conditions {
                    self.error("condition", one_each);
                }
                let who = self.who(trial, groups);
                for (key, is_present) in
                    [("columns", !shape.columns.is_empty()), ("times", !shape.times.is_empty())]
                {
                    if is_present {
                        self.error(&format!("questions.{key}"), one_each);
                    }
                }
                let question = self.required("questions.question", shape.question);
                let question = question.and_then(|q| self.label("questions.question", q, groups));
                let answer = self.required("questions.answer", shape.answer);
                let form = LongForm { question: question?, answer: answer?, time: shape.time };
                AnswerForm::Long(Box::new((who?, form)))
            }
        };
        Some(Content::Likert(Questionnaire { form, translate, lowest, time_unit }))
    }

    /// Several conditions in a row: each has columns of its own, and the labels of `[trial]` where it
    /// has none.
    fn conditions(
        &mut self,
        trial: Option<TrialShape>,
        shape: &QuestionsShape,
        conditions: Vec<ConditionShape>,
        groups: &[&str],
    ) -> Option<AnswerForm> {
        for (key, is_present) in [
            ("columns", !shape.columns.is_empty()),
            ("times", !shape.times.is_empty()),
            ("time", shape.time.is_some()),
        ] {
            if is_present {
                let what =
                    "is not used beside [[condition]]; list the columns of each condition there";
                self.error(&format!("questions.{key}"), what);
            }
        }
        let trial = self.required("trial", trial)?;
        let mut trials = Vec::new();
        for (i, condition) in conditions.into_iter().enumerate() {
            let key = format!("condition[{i}]");
            let own = [
                ("environment", &condition.environment),
                ("mode", &condition.mode),
                ("repeat", &condition.repeat),
                ("trial", &condition.trial),
            ];
            // Told at its own key, and not as one of [trial].
            let wrong = self.errors.len();
            for (name, label) in own {
                // Below, `who` checks the label again, but under the key of [trial].
                self.optional(&format!("{key}.{name}"), label.clone(), groups);
            }
            if self.errors.len() > wrong {
                return None;
            }
            if condition.columns.is_empty() {
                self.error(&format!("{key}.columns"), "lists no column");
            }
            let columns = self.by_question(&format!("{key}.columns"), condition.columns);
            let times = self.by_question(&format!("{key}.times"), condition.times);
            let labels = TrialShape {
                environment: condition.environment.or_else(|| trial.environment.clone()),
                mode: condition.mode.or_else(|| trial.mode.clone()),
                repeat: condition.repeat.or_else(|| trial.repeat.clone()),
                trial: condition.trial.or_else(|| trial.trial.clone()),
                ..trial.clone()
            };
            let who = self.who(Some(labels), groups)?;
            trials.push(RowTrial { who, columns, times });
        }
        Some(AnswerForm::Wide(trials))
    }

    fn by_question<T>(
        &mut self,
        table: &str,
        columns: BTreeMap<String, T>,
    ) -> BTreeMap<QuestionId, T> {
        let mut checked = BTreeMap::new();
        for (id, column) in columns {
            let key = format!("{table}.{id}");
            if let Some(id) = self.keep(&key, QuestionId::new(id).map_err(|e| e.to_string())) {
                checked.insert(id, column);
            }
        }
        checked
    }

    /// The unit of the times that answers took; never guessed.
    pub(super) fn time_unit(
        &mut self,
        key: &str,
        text: Option<&str>,
        is_timed: bool,
    ) -> Option<&'static Unit> {
        match text {
            None if is_timed => self.error(key, "is missing; s, ms, µs, ns or min"),
            Some(_) if !is_timed => {
                self.error(key, "is not used without a column of times; remove it")
            }
            _ => {}
        }
        let text = text?;
        let unit = unit::find(text).filter(|unit| unit.dimension == Dimension::Time);
        self.keep(
            key,
            unit.ok_or_else(|| format!("'{text}' is not a unit of time: s, ms, µs, ns or min")),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::tests::check;

    #[test]
    fn conditions_have_columns_and_a_mode_each() {
        let good = "kind = \"likert\"\n[trial]\nparticipant = \"P01\"\nsession = \"S01\"\nenvironment = \"spring\"\n\
            [[condition]]\nmode = \"active\"\ncolumns = { a = 1 }\n";
        let long = "[questions]\nquestion = { column = \"q\" }\nanswer = \"a\"\n[[cond";
        let other_kind = "condition: is not used in a mapping of this kind";
        let listed = "[questions.columns]\nb = 2\n[[cond";
        for (from, to, line, words) in [
            ("mode = \"active\"\n", "", 2, "trial.mode: is missing"),
            ("{ a = 1 }", "{ }", 8, "lists no column"),
            ("\"active\"", "{ name = \"m\" }", 7, "condition[0].mode: 'm' is not a named group"),
            ("[[cond", listed, 6, "is not used beside [[condition]]"),
            ("[[cond", long, 9, "mean one row per answer"),
            ("\"likert\"", "\"sweeps\"", 6, other_kind),
            ("a = 1", "a = { column = 1, path = \"x\" }", 8, "for JSON in its cells"),
        ] {
            check(good, from, to, line, words);
        }
    }
}
