//! What was answered after a recorded trial, and what of a task it presented: from columns of the recording, or of a log
//! that is joined to it.

use super::context::Context;
use super::errors::{Errors, all};
use super::given::{Answer, Place, read_answer, tell_middles};
use super::identity::Identity;
use super::likert::wide_questions;
use super::mapping::{AnswerForm, Beside, Missing};
use super::presented::{Presentation, place};
use super::psychometric::{Noticed, OfTask, read_row};
use super::recording::Recording;
use super::report::FileReport;
use super::shape::{AnswerFrom, JsonKey};
use std::collections::BTreeMap;
use zwidth_store::StoreError;
use zwidth_study::{Event, PlannedTrial, QuestionId};

/// What is said of a trial besides its samples and its labels.
#[derive(Debug, Clone, Default)]
pub(super) struct Said {
    answers: Vec<(QuestionId, Answer)>,
    presentation: Option<Presentation>,
}

/// Reads what is said of the trials of one recording.
pub(super) struct Sayings<'a> {
    context: &'a Context<'a>,
    beside: &'a Beside,
    tasks: BTreeMap<QuestionId, OfTask<'a>>,
    noticed: Noticed,
    presentations: usize,
}

impl<'a> Sayings<'a> {
    pub(super) fn new(context: &'a Context<'a>, beside: &'a Beside) -> Self {
        let (tasks, noticed) = (BTreeMap::new(), Noticed::default());
        Self { context, beside, tasks, noticed, presentations: 0 }
    }

    /// What is said of the trial that begins with a row.
    ///
    /// # Errors
    /// A question or a task that the study does not have, a cell that is no answer.
    pub(super) fn of(
        &mut self,
        recording: &Recording,
        row: usize,
        identity: &Identity,
    ) -> Result<Said, Errors> {
        Ok(Said {
            answers: self.answers(recording, row)?,
            presentation: self.presentation(recording, row, identity)?,
        })
    }

    fn answers(
        &self,
        recording: &Recording,
        row: usize,
    ) -> Result<Vec<(QuestionId, Answer)>, Errors> {
        let Some(questionnaire) = &self.beside.questions else { return Ok(Vec::new()) };
        let AnswerForm::Wide(trials) = &questionnaire.form else { return Ok(Vec::new()) };
        let mut answers = Vec::new();
        for question in trials.iter().map(|trial| wide_questions(self.context, trial)) {
            let read = question?.into_iter().map(|question| {
                let key = match &question.from {
                    AnswerFrom::Cell(_) => None,
                    AnswerFrom::Json(JsonKey { key, .. }) => Some(key.as_str()),
                };
                let time =
                    question.time.as_ref().map(|column| recording.find(column)).transpose()?;
                let place =
                    Place { row, answer: recording.find(question.from.column())?, key, time };
                let answer =
                    read_answer(self.context, questionnaire, recording, &question.id, place)?;
                Ok::<_, Errors>(answer.map(|answer| (question.id.clone(), answer)))
            });
            answers.extend(all(read)?.into_iter().flatten());
        }
        Ok(answers)
    }

    fn presentation(
        &mut self,
        recording: &Recording,
        row: usize,
        identity: &Identity,
    ) -> Result<Option<Presentation>, Errors> {
        let Some(from) = &self.beside.task else { return Ok(None) };
        let level = recording.find(&from.level)?;
        let drops = recording.form_of(level).missing == Missing::Drop;
        if drops && recording.number(level, row) == Ok(None) {
            return Ok(None);
        }
        let rows =
            read_row(self.context, from, &mut self.tasks, recording, row, &mut self.noticed)?;
        let Some(presentation) = rows.into_iter().next() else { return Ok(None) };
        if presentation.identity.environment != identity.environment {
            let what = format!(
                "the task '{}' is of {}, and the trial of {}",
                presentation.task, presentation.identity.environment, identity.environment
            );
            let remedy = "mend environment in [trial], or id in [task]";
            return Err(recording.row_error(row, &what, remedy).into());
        }
        self.presentations += 1;
        Ok(Some(presentation))
    }

    /// Tells what was passed over or taken for granted in what is said of these trials.
    pub(super) fn tell(&self, report: &mut FileReport, said: &[Said]) {
        tell_middles(self.context, report, said.iter().flat_map(|said| &said.answers));
        self.noticed.tell(report, self.presentations);
    }
}

impl Said {
    /// The answers to a trial of this number.
    pub(super) fn events(&self, trial: u32) -> impl Iterator<Item = Event> {
        let answers = self.answers.iter().map(move |(question, answer)| Event::Answer {
            trial,
            question: question.clone(),
            value: answer.value,
            time_ms: answer.time_ms,
        });
        let of_task = self.presentation.iter().map(move |shown| Event::Answer {
            trial,
            question: shown.task.clone(),
            value: shown.value,
            time_ms: shown.time_ms,
        });
        answers.chain(of_task)
    }
}

/// Gives each trial that presented something of a task its place in it.
///
/// # Errors
/// Those of [`place`].
pub(super) fn place_presented(
    context: &Context,
    said: &[Said],
    planned: &mut [PlannedTrial],
) -> Result<(), StoreError> {
    let shown = said.iter().zip(&*planned).filter_map(|(said, planned)| {
        said.presentation.as_ref().map(|shown| (shown, planned.clone()))
    });
    let (presentations, mut own): (Vec<&Presentation>, Vec<PlannedTrial>) = shown.unzip();
    place(context, &presentations, &mut own)?;
    let mut own = own.into_iter();
    for (said, planned) in said.iter().zip(planned) {
        if said.presentation.is_some()
            && let Some(placed) = own.next()
        {
            *planned = placed;
        }
    }
    Ok(())
}
