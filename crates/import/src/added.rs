//! Answers of a questionnaire to trials of existing sessions: another questionnaire of the same
//! session, or the same table again after people were added.

use super::context::Context;
use super::errors::Errors;
use super::given::Answered;
use super::identity::{FromZero, Identity};
use std::collections::BTreeMap;
use std::path::PathBuf;
use zwidth_store::{SessionLog, StoreError, StudyData};
use zwidth_study::{AnswerValue, Event, PlannedTrial, QuestionId};

/// The study as it is, and what its trials are answered with.
pub(super) struct There {
    data: StudyData,
    from_zero: FromZero,
    /// Each answer so far, of the study and of this import: the log of its session, its trial, its
    /// question.
    answers: BTreeMap<(PathBuf, u32, QuestionId), AnswerValue>,
    /// What the logs are to say.
    pub(super) events: BTreeMap<PathBuf, Vec<Event>>,
}

impl There {
    /// # Errors
    /// What keeps the study from being read.
    pub(super) fn load(context: &Context, identities: &[Identity]) -> Result<Self, Errors> {
        let data = StudyData::load_from(context.files, context.layout);
        let data = data.map_err(|found| found.into_iter().collect::<Errors>())?;
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
            let asked = data.study.environment(&meta.environment).and_then(|e| e.question.as_ref());
            if let (Some(question), Some(value)) = (asked, meta.likert) {
                let log = context.layout.events(&meta.participant, &meta.session);
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
        for (question, given) in &row.answers {
            let answer = (path.clone(), trial, question.clone());
            match self.answers.get(&answer) {
                Some(known) if *known == given.value => {}
                Some(known) => return Err(differs(row, trial, question, [*known, given.value])),
                None => {
                    self.answers.insert(answer, given.value);
                    let value = given.value;
                    let time_ms = given.time_ms;
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

/// The number of the trial that labels name, in a session that is there.
fn trial_of(log: &SessionLog, i: &Identity, from_zero: FromZero) -> Result<u32, StoreError> {
    let Identity { participant, session, environment, mode, file, .. } = i;
    let error = |what: String, remedy: &str| Err(StoreError::new(file, what, remedy));
    let session = format!("{participant} {session}");
    if log.is_sealed() {
        let what = format!("the modes of {session} are sealed");
        return error(
            what,
            "give its answers by the numbers of its trials: `zwidth answer --from`",
        );
    }
    // Their numbers are what they were when the session was imported.
    let trial = from_zero.trial || log.record.counted_from_zero;
    let [number, repeat] = FromZero { trial, ..from_zero }.numbers(i);
    let has = |is: &dyn Fn(&Event) -> bool| log.events.iter().any(is);
    let is_meant = |t: &&PlannedTrial| {
        (&t.environment, &t.mode, t.kind) == (environment, mode, i.kind)
            && number.is_none_or(|number| number == t.trial)
            && repeat.is_none_or(|repeat| repeat == t.repeat)
            && !has(&|e| matches!(e, Event::Superseded { trial, .. } if *trial == t.trial))
    };
    let meant: Vec<u32> = log.trials.iter().filter(is_meant).map(|t| t.trial).collect();
    let named = [("trial", number), ("repeat", repeat)];
    let named = named.map(|(what, number)| number.map(|n| format!(", {what} {n}")));
    let named: String = named.into_iter().flatten().collect();
    let [trial] = meant[..] else {
        return match meant.len() {
            0 => error(
                format!(
                    "{session} is there, and has no trial of {environment}, {mode}{named}: a session keeps the trials \
                     that it began with"
                ),
                "give all conditions of a row in one mapping, with [[condition]], or name another session",
            ),
            n => error(
                format!("{session} has {n} trials of {environment}, {mode}{named}"),
                "name the trial or the repeat in [trial]",
            ),
        };
    };
    // Sessions of other people's recordings have no order that was drawn, and all their trials.
    let is_done = log.record.order.is_none()
        || has(&|e| matches!(e, Event::Recorded { trial: done, .. } if *done == trial));
    match is_done {
        true => Ok(trial),
        false => {
            error(format!("trial {trial} of {session} is still to be done"), "record it first")
        }
    }
}

fn differs(
    row: &Answered,
    trial: u32,
    question: &QuestionId,
    [known, given]: [AnswerValue; 2],
) -> StoreError {
    let Identity { participant, session, file, .. } = &row.identity;
    let what = format!(
        "trial {trial} of {participant} {session} has the answer {known} to '{question}' already, and here {given}"
    );
    StoreError::new(file, what, "leave the row out, or mend the answer with `zwidth answer`")
}
