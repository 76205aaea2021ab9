//! Answers of a questionnaire to trials of existing sessions: another questionnaire of the same
//! session, or the same table again after people were added.

use super::context::Context;
use super::errors::Errors;
use super::given::Answered;
use super::identity::{FromZero, Identity};
use std::collections::BTreeMap;
use std::path::PathBuf;
use zwidth_store::{SessionLog, StoreError, StudyData};
use zwidth_study::{AnswerValue, Event, QuestionId};

/// The study as it is, and what its trials are answered with.
pub(super) struct ExistingAnswers {
    data: StudyData,
    from_zero: FromZero,
    /// Each answer so far, of the study and of this import: the log of its session, its trial, its
    /// question.
    answers: BTreeMap<(PathBuf, u32, QuestionId), AnswerValue>,
    /// New events for each log.
    pub(super) events: BTreeMap<PathBuf, Vec<Event>>,
}

impl ExistingAnswers {
    /// # Errors
    /// The study cannot be read.
    pub(super) fn load(context: &Context, identities: &[Identity]) -> Result<Self, Errors> {
        let data = StudyData::load_from(context.files, context.layout);
        let data = data.map_err(|errors| errors.into_iter().collect::<Errors>())?;
        let mut answers = BTreeMap::new();
        for log in &data.sessions {
            for event in &log.events {
                if let Event::Answer { trial, question, value, .. } = event {
                    answers.insert((log.events_path.clone(), *trial, question.clone()), *value);
                }
            }
        }
        for entry in &data.trials {
            let meta = &entry.meta;
            let environment = data.study.environment(&meta.environment);
            let question = environment.and_then(|e| e.question.as_ref());
            if let (Some(question), Some(value)) = (question, meta.likert) {
                let log = context.layout.events(&meta.participant, &meta.session);
                // Not over an answer in the log: one that was mended is there, and a trial's file never changes.
                answers.entry((log, meta.trial, question.clone())).or_insert(value.into());
            }
        }
        let from_zero = FromZero::of(identities);
        Ok(Self { data, from_zero, answers, events: BTreeMap::new() })
    }

    /// Answers the trial that the labels name with what it is not answered with yet; how many answers
    /// that are.
    ///
    /// # Errors
    /// A session or a trial that cannot be told, and an answer that differs from the one that is there.
    pub(super) fn answer(
        &mut self,
        context: &Context,
        row: &Answered,
    ) -> Result<usize, StoreError> {
        let Identity { participant, session, file, .. } = &row.identity;
        let path = context.layout.events(participant, session);
        let log =
            self.data.sessions.iter().find(|log| log.events_path == path).ok_or_else(|| {
                let what =
                    format!("session {session} of {participant} is there, and cannot be read");
                StoreError::new(file, what, "see `zwidth verify`")
            })?;
        let trial = trial_of(log, &row.identity, self.from_zero)?;
        let mut new = Vec::new();
        for (question, answer) in &row.answers {
            let (value, time_ms) = (answer.value, answer.time_ms);
            let key = (path.clone(), trial, question.clone());
            match self.answers.get(&key) {
                Some(existing) if *existing == value => {}
                Some(existing) => {
                    let what = format!(
                        "trial {trial} of {participant} {session} has the answer {existing} to '{question}' already, and here {value}"
                    );
                    let remedy = "leave the row out, or mend the answer with `zwidth answer`";
                    return Err(StoreError::new(file, what, remedy));
                }
                None => {
                    self.answers.insert(key, value);
                    new.push(Event::Answer { trial, question: question.clone(), value, time_ms });
                }
            }
        }
        let answers = new.len();
        if answers > 0 {
            self.events.entry(path).or_default().extend(new);
        }
        Ok(answers)
    }
}

/// The number of the trial that labels name, in an existing session.
///
/// # Errors
/// There is none, or more than one; it is not known which one it is, or it is still to be done.
fn trial_of(log: &SessionLog, i: &Identity, from_zero: FromZero) -> Result<u32, StoreError> {
    let Identity { participant, session, environment, mode, file, .. } = i;
    let session = format!("{participant} {session}");
    if log.is_sealed() {
        // Whoever could name the trials by their modes would know which mode each trial had.
        let what = format!("the modes of {session} are sealed");
        let remedy = "give its answers by the numbers of its trials: `zwidth answer --from`";
        return Err(StoreError::new(file, what, remedy));
    }
    // Their numbers are what they were when the session was imported.
    let trial = from_zero.trial || log.record.counted_from_zero;
    let [number, repeat] = FromZero { trial, ..from_zero }.numbers(i);
    let is_superseded = |trial: u32| {
        log.events.iter().any(|e| matches!(e, Event::Superseded { trial: t, .. } if *t == trial))
    };
    let meant = log.trials.iter().filter(|t| {
        (&t.environment, &t.mode, t.kind) == (environment, mode, i.kind)
            && number.is_none_or(|number| number == t.trial)
            && repeat.is_none_or(|repeat| repeat == t.repeat)
            && !is_superseded(t.trial)
    });
    let meant: Vec<u32> = meant.map(|t| t.trial).collect();
    let named = [("trial", number), ("repeat", repeat)];
    let named = named.map(|(what, number)| number.map(|n| format!(", {what} {n}")));
    let named: String = named.into_iter().flatten().collect();
    let [trial] = meant[..] else {
        let (what, remedy) = match meant.len() {
            0 => (
                format!(
                    "{session} is there, and has no trial of {environment}, {mode}{named}: a session keeps the trials \
                     that it began with"
                ),
                "give all conditions of a row in one mapping, with [[condition]], or name another session",
            ),
            n => (
                format!("{session} has {n} trials of {environment}, {mode}{named}"),
                "name the trial or the repeat in [trial]",
            ),
        };
        return Err(StoreError::new(file, what, remedy));
    };
    let is_recorded = |e: &Event| matches!(e, Event::Recorded { trial: t, .. } if *t == trial);
    // Sessions of other people's recordings have no order that was drawn, and all their trials.
    if log.record.order.is_some() && !log.events.iter().any(is_recorded) {
        let what = format!("trial {trial} of {session} is still to be done");
        return Err(StoreError::new(file, what, "record it first"));
    }
    Ok(trial)
}
