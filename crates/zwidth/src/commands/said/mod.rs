//! `zwidth exclude`, `note`, `answer`: what is said of a session after it was recorded. Each is an
//! event that is added to its log; nothing that stands there changes.

mod answers;

use super::recover::{lock, now, put_in_order_and_tell};
use super::{join_findings, session, study};
use crate::args::{Answer, Exclude, Note, Said};
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use std::path::Path;
use zwidth_store::{Entered, Raw, RealFiles, SessionLog, StudyData, TrialEntry, append_events};
use zwidth_study::{Event, QuestionId};

pub(crate) fn exclude(root: &Path, command: &Exclude, screen: &Screen) -> anyhow::Result<Exit> {
    let reason = text(&command.reason, "an exclusion needs its reason")?;
    add(root, &command.said, screen, &|data, log| {
        let entry = recorded(data, log, command.trial)?;
        let done_again = entry.is_some_and(|entry| entry.superseded_by.is_some());
        let missing = entry.is_some_and(|entry| entry.counts() || entry.sealed.is_some());
        let Said { study, participant, session, .. } = &command.said;
        let again = match log.record.order {
            Some(_) if missing && !done_again => format!(
                "; it is missing until it is done again: `zwidth acquire {study} -p {participant} -s {session}`"
            ),
            _ => String::new(),
        };
        let event = Event::Excluded { trial: command.trial, reason: reason.clone() };
        Ok((event, format!("trial {} is excluded{again}", command.trial)))
    })
}

pub(crate) fn note(root: &Path, command: &Note, screen: &Screen) -> anyhow::Result<Exit> {
    let text = text(&command.text, "the note is empty")?;
    add(root, &command.said, screen, &|_, log| {
        if let Some(trial) = command.trial {
            known(log, trial)?;
        }
        let event = Event::Note { trial: command.trial, text: text.clone() };
        let of = command.trial.map_or("the session".to_owned(), |trial| format!("trial {trial}"));
        Ok((event, format!("the note is kept with {of}")))
    })
}

pub(crate) fn answer(root: &Path, command: &Answer, screen: &Screen) -> anyhow::Result<Exit> {
    let Answer { study, participant, session, by, trial, question, value, from, .. } = command;
    if let Some(from) = from {
        return answers::from_table(root, command, from, screen);
    }
    let (Some(participant), Some(session)) = (participant.clone(), session.clone()) else {
        bail!("name the participant and the session: -p P01 -s S01");
    };
    let (Some(trial), Some(value)) = (*trial, *value) else {
        bail!("name the trial (--trial N) and the answer");
    };
    let said = Said { study: study.clone(), participant, session, by: by.clone() };
    add(root, &said, screen, &|data, log| {
        let Given { event, question, before, but } =
            given(data, log, trial, question.as_ref(), value)?;
        let before = before.map(|value| format!(", in place of {value}, which is kept"));
        let but = but.map(|why| format!("; the trial itself does not count: {why}"));
        let said = format!(
            "trial {trial}: {question} is answered with {value}{}{}",
            before.unwrap_or_default(),
            but.unwrap_or_default()
        );
        Ok((event, said))
    })
}

/// An answer that may be given.
struct Given {
    event: Event,
    question: QuestionId,
    /// The answer that counted so far.
    before: Option<i16>,
    /// Why the trial itself does not count.
    but: Option<String>,
}

/// The answer to a question, the only one that is asked where none is named, after a trial.
fn given(
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

/// What makes an event of a session as it stands, and what is told of it.
type Making<'a> = dyn Fn(&StudyData, &SessionLog) -> anyhow::Result<(Event, String)> + 'a;

/// Adds an event to a session that nobody records.
fn add(root: &Path, said: &Said, screen: &Screen, making: &Making<'_>) -> anyhow::Result<Exit> {
    let layout = study(root, said.study.clone())?;
    let lock = lock(&layout, "an event command")?;
    put_in_order_and_tell(&layout, &lock, screen);
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    let log = session(&data, &said.participant, &said.session)?;
    let (event, told) = making(&data, log)?;
    let utc = now();
    let entered = Entered { utc: &utc, by: said.by.as_ref() };
    append_events(&Raw::adds(&RealFiles, &layout, &lock), &log.events_path, entered, &[event])?;
    screen.result(format!("{} {}: {told}", said.participant, said.session));
    Ok(Exit::Fine)
}

fn text(text: &str, empty: &'static str) -> anyhow::Result<String> {
    let text = text.trim();
    if text.is_empty() { bail!(empty) } else { Ok(text.to_owned()) }
}

/// A trial that the session has.
fn known(log: &SessionLog, trial: u32) -> anyhow::Result<()> {
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
fn recorded<'a>(
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
