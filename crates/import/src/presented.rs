//! Presentations of tasks, placed: numbered in their session, and held against the sessions that are there.

use super::context::Context;
use super::errors::Errors;
use super::identity::Identity;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_store::{StoreError, read_events, readable_records};
use zwidth_study::{
    AnswerValue, Event, Kind, ModeId, ParticipantId, PlannedTrial, QuestionId, SessionId,
    TaskLevel, TaskPlace,
};

/// One presentation of a task that was answered.
#[derive(Debug, Clone)]
pub(super) struct Presentation {
    pub(super) identity: Identity,
    pub(super) task: QuestionId,
    pub(super) level: TaskLevel,
    pub(super) is_set: bool,
    pub(super) value: AnswerValue,
    pub(super) is_standard: Option<bool>,
    pub(super) time_ms: Option<u32>,
    /// What the table calls the sequence that it is of.
    pub(super) track: Option<String>,
}

/// Gives each trial its place in its task: presentations are numbered by the order of their trials, for each task and mode.
///
/// # Errors
/// More sequences of a task than have numbers.
pub(super) fn place(
    context: &Context,
    presentations: &[&Presentation],
    planned: &mut [PlannedTrial],
) -> Result<(), StoreError> {
    let mut order: Vec<usize> = (0..planned.len()).collect();
    order.sort_by_key(|i| {
        let Identity { participant, session, .. } = &presentations[*i].identity;
        (participant, session, planned[*i].trial)
    });
    let mut numbers: BTreeMap<_, u32> = BTreeMap::new();
    let mut sequences: BTreeMap<_, (Vec<&str>, usize)> = BTreeMap::new();
    for i in order {
        let row = presentations[i];
        let Identity { participant, session, mode, kind, .. } = &row.identity;
        let key = (participant, session, &row.task, mode, *kind);
        let number = numbers.entry(key).or_default();
        *number += 1;
        let (tracks, settings) = sequences.entry(key).or_default();
        let track = match &row.track {
            Some(name) => tracks.iter().position(|track| track == name).unwrap_or_else(|| {
                tracks.push(name);
                tracks.len() - 1
            }),
            // A level that is right ends one setting, and the next one begins.
            None => *settings,
        };
        *settings += usize::from(row.is_set);
        let track = u8::try_from(track).map_err(|_| {
            let what = format!("'{}' has more than 256 sequences in one mode", row.task);
            StoreError::new(&row.identity.file, what, "name several sessions, or leave track out")
        })?;
        let asks = context.study.task(&row.task).map(|task| task.asks);
        planned[i].task = Some(TaskPlace {
            task: row.task.clone(),
            presentation: *number,
            track,
            interval: asks.map_or(1, zwidth_study::Asks::intervals),
            level: Some(row.level),
            is_standard: row.is_standard,
        });
    }
    Ok(())
}

/// An answer, by what it rests on.
type Told = (ModeId, Kind, QuestionId, TaskLevel, Option<bool>, AnswerValue, Option<u32>);

/// The sessions of the study that have the very answers of these tables already.
///
/// # Errors
/// A session that is there with other answers.
pub(super) fn existing<'a>(
    context: &Context,
    rows: impl Iterator<Item = &'a Presentation>,
) -> Result<BTreeSet<(ParticipantId, SessionId)>, Errors> {
    let mut sessions: BTreeMap<(&ParticipantId, &SessionId), Vec<&Presentation>> = BTreeMap::new();
    for row in rows {
        let key = (&row.identity.participant, &row.identity.session);
        sessions.entry(key).or_default().push(row);
    }
    sessions.retain(|(participant, session), _| {
        context.files.kind(&context.layout.session(participant, session)).is_some()
    });
    if sessions.is_empty() {
        return Ok(BTreeSet::new());
    }
    let records = readable_records(context.files, context.layout)?;
    let mut errors = Errors::default();
    let mut same = BTreeSet::new();
    for ((participant, session), mut rows) in sessions {
        rows.sort_by_key(|row| row.identity.trial);
        let here: Vec<Told> = rows.iter().map(|row| told(row)).collect();
        let record = records
            .iter()
            .find(|record| (&record.participant, &record.session) == (participant, session));
        let there = match record {
            Some(record) => answers(context, participant, session, &record.trials)?,
            None => Vec::new(),
        };
        if here == there {
            same.insert((participant.clone(), session.clone()));
            continue;
        }
        let what = format!("session {session} of {participant} is there, with other answers");
        let remedy = "sessions are imported whole, all tasks and files in one command: choose another session id, or \
                      remove the session and import it again";
        errors.push(StoreError::new(&rows[0].identity.file, what, remedy));
    }
    errors.none().map(|()| same)
}

fn told(row: &Presentation) -> Told {
    let Identity { mode, kind, .. } = &row.identity;
    let Presentation { task, level, is_standard, value, time_ms, .. } = row;
    (mode.clone(), *kind, task.clone(), *level, *is_standard, *value, *time_ms)
}

/// The answers to tasks that a session of the study was imported with.
fn answers(
    context: &Context,
    participant: &ParticipantId,
    session: &SessionId,
    trials: &[PlannedTrial],
) -> Result<Vec<Told>, StoreError> {
    let mut given = BTreeMap::new();
    for event in read_events(&context.layout.events(participant, session))? {
        if let Event::Answer { trial, question, value, time_ms } = event {
            // The first is the one that was imported; later ones mend it.
            given.entry((trial, question)).or_insert((value, time_ms));
        }
    }
    let mut trials: Vec<&PlannedTrial> = trials.iter().collect();
    trials.sort_by_key(|planned| planned.trial);
    let told = trials.into_iter().filter_map(|planned| {
        let place = planned.task.as_ref()?;
        let (value, time_ms) = given.get(&(planned.trial, place.task.clone()))?;
        let PlannedTrial { mode, kind, .. } = planned;
        let (level, is_standard) = (place.level?, place.is_standard);
        let task = place.task.clone();
        Some((mode.clone(), *kind, task, level, is_standard, *value, *time_ms))
    });
    Ok(told.collect())
}
