//! What may be said of a trial of a session, and what an answer to it is.

use anyhow::{Context as _, bail};
use zwidth_store::{SessionLog, StudyData, TrialEntry};
use zwidth_study::{Event, QuestionId};

/// An answer that may be given.
pub(super) struct Given {
    pub(super) event: Event,
    pub(super) question: QuestionId,
    /// The answer that counted so far.
    pub(super) before: Option<i16>,
    /// Why the trial itself does not count.
    pub(super) but: Option<String>,
}

/// The answer to a question, the only one that is asked where none is named, after a trial.
pub(super) fn given(
    data: &StudyData,
    log: &SessionLog,
    trial: u32,
    named: Option<&QuestionId>,
    value: i16,
) -> anyhow::Result<Given> {
    let entry = recorded(data, log, trial)?;
    let id = question(data, log, trial, named)?;
    let asked = data.study.question(&id).with_context(|| format!("{id} is not in study.toml"))?;
    if !asked.scale.has(value) {
        bail!("{value} is no answer to {id}: {}", asked.scale.range());
    }
    Ok(Given {
        before: before(log, entry, &id, trial),
        but: entry.filter(|entry| entry.sealed.is_none()).and_then(TrialEntry::why_not),
        event: Event::Answer { trial, question: id.clone(), value, time_ms: None },
        question: id,
    })
}

/// A trial that the session has.
pub(super) fn known(log: &SessionLog, trial: u32) -> anyhow::Result<()> {
    if log.trials.iter().any(|t| t.trial == trial) {
        return Ok(());
    }
    let numbers = log.trials.iter().map(|t| t.trial);
    bail!(
        "the session has no trial {trial}: they are {} to {}",
        numbers.clone().min().unwrap_or(0),
        numbers.max().unwrap_or(0)
    )
}

/// A trial that was recorded, or answered without samples; its file, if it can be read.
pub(super) fn recorded<'a>(
    data: &'a StudyData,
    log: &SessionLog,
    trial: u32,
) -> anyhow::Result<Option<&'a TrialEntry>> {
    known(log, trial)?;
    let of_session = |t: &&TrialEntry| {
        let m = &t.meta;
        (&m.participant, &m.session) == (&log.record.participant, &log.record.session)
    };
    let entry = data.trials.iter().filter(of_session).find(|t| t.meta.trial == trial);
    let is_logged =
        |e: &Event| matches!(e, Event::Recorded { trial: recorded, .. } if *recorded == trial);
    let ended = log.record.order.is_none() || log.events.iter().any(is_logged);
    if entry.is_none() && !ended {
        bail!("trial {trial} is still to be done");
    }
    Ok(entry)
}

/// The question that is answered: one that is asked after the trial.
fn question(
    data: &StudyData,
    log: &SessionLog,
    trial: u32,
    named: Option<&QuestionId>,
) -> anyhow::Result<QuestionId> {
    let planned = log.trials.iter().find(|t| t.trial == trial);
    let environment = planned.and_then(|t| data.study.environment(&t.environment));
    let asked: Vec<&QuestionId> = environment.iter().flat_map(|e| e.questions()).collect();
    let list = || asked.iter().map(|id| id.as_str()).collect::<Vec<_>>().join(", ");
    match (named, asked.as_slice()) {
        (Some(id), asked) if asked.contains(&id) => Ok(id.clone()),
        (None, [only]) => Ok((*only).clone()),
        (_, []) => bail!(
            "nothing is asked after trial {trial}: name a question of [[questions]] in its environment of study.toml, question = \"…\""
        ),
        (Some(id), _) => {
            bail!("{id} is not asked after trial {trial}: name one of {}", list())
        }
        (None, _) => bail!("say which question is answered, with --question: {}", list()),
    }
}

/// The answer that counted so far.
fn before(
    log: &SessionLog,
    entry: Option<&TrialEntry>,
    asked: &QuestionId,
    of: u32,
) -> Option<i16> {
    let one = |event: &Event| match event {
        Event::Answer { trial, question, value, .. } if *trial == of && question == asked => {
            Some(*value)
        }
        _ => None,
    };
    log.events.iter().rev().find_map(one).or_else(|| entry?.meta.likert)
}
