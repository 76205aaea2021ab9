//! `zwidth exclude`, `note`, `answer`: remarks on a session after it was recorded. Each is an event
//! that is added to its log; existing lines never change.

pub(crate) mod answers;
mod given;

use super::recover::{lock, now, put_in_order_and_tell};
use super::{join_findings, session, study};
use crate::commands::said::answers::AnswerArgs;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::bail;
use given::{NewAnswer, NumberedSession};
use std::collections::BTreeSet;
use std::path::Path;
use zwidth_store::{Entered, Raw, RealFiles, SessionLog, StudyData, commit_events};
use zwidth_study::{Event, ExperimenterId, ParticipantId, SessionId, StudyId};

/// A session that was recorded, and who says something of it.
#[derive(Debug, clap::Args)]
pub(crate) struct SessionArgs {
    /// The study
    pub(crate) study: StudyId,
    /// The participant
    #[arg(long, short, value_name = "P01")]
    pub(crate) participant: ParticipantId,
    /// The session
    #[arg(long, short, value_name = "S01")]
    pub(crate) session: SessionId,
    /// Your code, which is kept with it; no name
    #[arg(long, value_name = "E1")]
    pub(crate) by: Option<ExperimenterId>,
}

#[derive(Debug, clap::Args)]
pub(crate) struct NoteArgs {
    #[command(flatten)]
    pub(crate) session: SessionArgs,
    /// The trial's number [default: a remark on the session]
    #[arg(long, value_name = "N")]
    pub(crate) trial: Option<u32>,
    /// The remark
    pub(crate) text: String,
}

#[derive(Debug, clap::Args)]
pub(crate) struct ExcludeArgs {
    #[command(flatten)]
    pub(crate) session: SessionArgs,
    /// The trial's number, or several, separated by commas: all are excluded, or none
    #[arg(long, value_name = "N[,N…]", required = true, value_delimiter = ',')]
    pub(crate) trial: Vec<u32>,
    /// Why they do not count
    pub(crate) reason: String,
}

pub(crate) fn exclude(root: &Path, command: &ExcludeArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let reason = text(&command.reason, "an exclusion needs its reason")?;
    let trials: BTreeSet<u32> = command.trial.iter().copied().collect();
    add(root, &command.session, screen, &|data, log| {
        let session = NumberedSession::of(data, log);
        let mut missing = false;
        for trial in &trials {
            let entry = session.recorded(*trial)?;
            let done_again = entry.is_some_and(|entry| entry.superseded_by.is_some());
            let counted = entry.is_some_and(|entry| entry.counts() || entry.sealed.is_some());
            missing |= counted && !done_again;
        }
        let SessionArgs { study, participant, session, .. } = &command.session;
        let numbers = trials.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
        let (excluded, are_missing) = match trials.len() {
            1 => (format!("trial {numbers} is excluded"), "it is missing until it is"),
            _ => (format!("trials {numbers} are excluded"), "they are missing until they are"),
        };
        let again = match log.record.order {
            Some(_) if missing => {
                format!(
                    "; {are_missing} done again: `zwidth acquire {study} -p {participant} -s {session}`"
                )
            }
            _ => String::new(),
        };
        let events =
            trials.iter().map(|trial| Event::Excluded { trial: *trial, reason: reason.clone() });
        Ok((events.collect(), excluded + &again))
    })
}

pub(crate) fn note(root: &Path, command: &NoteArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let text = text(&command.text, "the note is empty")?;
    add(root, &command.session, screen, &|data, log| {
        if let Some(trial) = command.trial {
            NumberedSession::of(data, log).planned(trial)?;
        }
        let event = Event::Note { trial: command.trial, text: text.clone() };
        let subject =
            command.trial.map_or("the session".to_owned(), |trial| format!("trial {trial}"));
        Ok((vec![event], format!("the note is kept with {subject}")))
    })
}

pub(crate) fn answer(root: &Path, command: &AnswerArgs, screen: &Screen) -> anyhow::Result<Exit> {
    let AnswerArgs { study, participant, session, by, trial, question, value, from, .. } = command;
    if let Some(from) = from {
        return answers::from_table(root, command, from, screen);
    }
    let (Some(participant), Some(session)) = (participant.clone(), session.clone()) else {
        bail!("name the participant and the session: -p P01 -s S01");
    };
    let (Some(trial), Some(value)) = (*trial, *value) else {
        bail!("name the trial (--trial N) and the answer");
    };
    let target = SessionArgs { study: study.clone(), participant, session, by: by.clone() };
    add(root, &target, screen, &|data, log| {
        let NewAnswer { event, question, before, but } =
            NumberedSession::of(data, log).answer(data, trial, question.as_ref(), value)?;
        let before = before.map(|value| format!(", in place of {value}, which is kept"));
        let but = but.map(|why| format!("; the trial itself does not count: {why}"));
        let message = format!(
            "trial {trial}: {question} is answered with {value}{}{}",
            before.unwrap_or_default(),
            but.unwrap_or_default()
        );
        Ok((vec![event], message))
    })
}

/// Makes the events from the session as it stands, and the message about them.
type Making<'a> = dyn Fn(&StudyData, &SessionLog) -> anyhow::Result<(Vec<Event>, String)> + 'a;

/// Adds events to a session that nobody records: all of them, or none.
fn add(
    root: &Path,
    target: &SessionArgs,
    screen: &Screen,
    making: &Making<'_>,
) -> anyhow::Result<Exit> {
    let layout = study(root, target.study.clone())?;
    let lock = lock(&layout, "an event command")?;
    put_in_order_and_tell(&layout, &lock, screen);
    let data = StudyData::load(&layout).map_err(|findings| join_findings(&findings))?;
    let log = session(&data, &target.participant, &target.session)?;
    let (events, message) = making(&data, log)?;
    let utc = now();
    let entered = Entered { utc: &utc, by: target.by.as_ref() };
    let raw = Raw::adds(&RealFiles, &layout, &lock);
    commit_events(&raw, &layout, entered, &[(&log.events_path, &events)])?;
    screen.result(format!("{} {}: {message}", target.participant, target.session));
    Ok(Exit::Fine)
}

fn text(text: &str, empty: &'static str) -> anyhow::Result<String> {
    let text = text.trim();
    if text.is_empty() { bail!(empty) } else { Ok(text.to_owned()) }
}
