//! Checks a mapping of a questionnaire: where its answers stand.

use super::check::Check;
use super::mapping::{Asked, Content, LongForm, Questionnaire};
use super::shape::{QuestionsShape, TrialShape};
use super::table::ColumnRef;
use super::unit::{self, Dimension, Unit};
use std::collections::BTreeMap;
use zwidth_study::QuestionId;

impl Check<'_> {
    pub(super) fn likert(
        &mut self,
        trial: Option<TrialShape>,
        shape: QuestionsShape,
        groups: &[&str],
    ) -> Option<Content> {
        let who = self.who(trial, groups);
        if who.as_ref().is_some_and(|w| w.likert.is_some()) {
            self.error("trial.likert", "is not used in a mapping of this kind; remove it");
        }
        let is_timed = shape.time.is_some() || !shape.times.is_empty();
        let time_unit = self.time_unit(shape.time_unit.as_deref(), is_timed);
        let translate = shape.translate.clone();
        let form = match (shape.question.is_some(), shape.answer.is_some()) {
            (false, false) => self.wide_form(shape),
            _ => self.long_form(shape, groups),
        };
        Some(Content::Likert {
            who: who?,
            asked: Questionnaire { form: form?, translate, time_unit },
        })
    }

    /// A column a question.
    fn wide_form(&mut self, shape: QuestionsShape) -> Option<Asked> {
        if shape.time.is_some() {
            let what = "belongs to a table with one row per answer; list the columns of times by question in \
                        [questions.times]";
            self.error("questions.time", what);
        }
        let columns = self.by_question("columns", shape.columns);
        Some(Asked::Wide { columns, times: self.by_question("times", shape.times) })
    }

    fn by_question(
        &mut self,
        table: &str,
        columns: BTreeMap<String, ColumnRef>,
    ) -> BTreeMap<QuestionId, ColumnRef> {
        let mut checked = BTreeMap::new();
        for (id, column) in columns {
            let key = format!("questions.{table}.{id}");
            if let Some(id) = self.keep(&key, QuestionId::new(id).map_err(|e| e.to_string())) {
                checked.insert(id, column);
            }
        }
        checked
    }

    /// A row an answer.
    fn long_form(&mut self, shape: QuestionsShape, groups: &[&str]) -> Option<Asked> {
        for (key, is_given) in
            [("columns", !shape.columns.is_empty()), ("times", !shape.times.is_empty())]
        {
            if is_given {
                let what = "is not used beside question and answer, which mean one row per answer; remove it";
                self.error(&format!("questions.{key}"), what);
            }
        }
        let question = self.required("questions.question", shape.question);
        let question = question.and_then(|q| self.keep("questions.question", q.check(groups)));
        let answer = self.required("questions.answer", shape.answer);
        Some(Asked::Long(LongForm { question: question?, answer: answer?, time: shape.time }))
    }

    /// The unit of the times that answers took; never guessed.
    fn time_unit(&mut self, text: Option<&str>, is_timed: bool) -> Option<&'static Unit> {
        let key = "questions.time_unit";
        match text {
            None if is_timed => self.error(key, "is missing; s, ms, µs, ns or min"),
            Some(_) if !is_timed => {
                self.error(key, "is not used without a column of times; remove it")
            }
            _ => {}
        }
        let text = text?;
        let found = unit::find(text).filter(|unit| unit.dimension == Dimension::Time);
        self.keep(
            key,
            found.ok_or_else(|| format!("'{text}' is not a unit of time: s, ms, µs, ns or min")),
        )
    }
}
