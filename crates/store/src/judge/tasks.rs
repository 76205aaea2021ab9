//! Answers to tasks: each answer that counts, with the level that was presented and what the answer says of it.

use crate::{SessionLog, StudyData};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use zwidth_study::{
    AnswerValue, Condition, Event, Kind, ModeId, ParticipantId, QuestionId, SessionId, Source,
    TaskLevel, TaskPlace,
};

/// One presentation of a task that was answered and counts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TaskAnswer {
    /// The person who answered.
    pub participant: ParticipantId,
    /// The session.
    pub session: SessionId,
    /// The environment that varied, and the mode.
    pub condition: Condition,
    /// The task.
    pub task: QuestionId,
    /// The presentation, counted from 1 for each task and mode of the session.
    pub presentation: u32,
    /// Which of several sequences that take turns, from 0.
    pub track: u8,
    /// The level that was compared with the standard, in the unit of what varies.
    pub level: TaskLevel,
    /// The trial before the answer: the last interval.
    pub trial: u32,
    /// Whether the answer says that the level was more than the standard, was the right one of two, was there, or is set
    /// right ([`zwidth_study::Asks::is_positive`]).
    pub is_positive: bool,
    /// The answer as given, a number of [`zwidth_study::Asks::answers`].
    pub value: AnswerValue,
    /// From the question to its answer, ms, if it was measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_ms: Option<u32>,
    /// Where it comes from.
    pub source: Source,
}

impl StudyData {
    /// Every answer to a task that counts, by participant, session and trial. None of a presentation of which an interval is
    /// superseded, excluded or incomplete, or practice; and none of a session that is still sealed.
    pub fn task_answers(&self) -> Vec<TaskAnswer> {
        if self.study.tasks.is_empty() {
            return Vec::new();
        }
        let entries = self.by_session();
        let mut all = Vec::new();
        for log in &self.sessions {
            let who = (&log.record.participant, &log.record.session);
            let of_session = entries.get(&who).map_or(&[][..], Vec::as_slice);
            let conditions = self.conditions(log, of_session);
            let counts =
                |trial: u32| conditions.get(&trial).is_some_and(|(_, why_not)| why_not.is_none());
            let presentations = Presentations::of(log);
            let from = self.answers.partition_point(|a| (&a.participant, &a.session) < who);
            let answers = self.answers[from..]
                .iter()
                .take_while(|answer| (&answer.participant, &answer.session) == who);
            for answer in answers {
                let Some(task) = self.study.task(&answer.question) else { continue };
                let Some(shown) = presentations.answered_after(answer.trial) else { continue };
                let place = shown.place;
                if place.task != task.id
                    || !place.is_last(task.asks)
                    || !shown.intervals.iter().all(|trial| counts(*trial))
                {
                    continue;
                }
                let positive = task.asks.is_positive(answer.value, place.is_standard);
                let (Some(level), Some(is_positive)) = (shown.level, positive) else { continue };
                all.push(TaskAnswer {
                    participant: answer.participant.clone(),
                    session: answer.session.clone(),
                    condition: answer.condition.clone(),
                    task: task.id.clone(),
                    presentation: place.presentation,
                    track: place.track,
                    level,
                    trial: answer.trial,
                    is_positive,
                    value: answer.value,
                    time_ms: answer.time_ms,
                    source: log.record.source,
                });
            }
        }
        all
    }
}

/// The presentations of a session, without practice.
pub(crate) struct Presentations<'l> {
    /// By trial.
    places: BTreeMap<u32, (&'l ModeId, &'l TaskPlace)>,
    /// The trials of each task, mode and presentation, without those that were done again.
    intervals: BTreeMap<(&'l QuestionId, &'l ModeId, u32), Vec<u32>>,
    /// The levels that the log has, by trial.
    levels: BTreeMap<u32, TaskLevel>,
    /// The trial in whose place another came, by that other.
    again: BTreeMap<u32, u32>,
}

/// A presentation that ends with a trial.
pub(crate) struct Shown<'l> {
    /// The place of that trial.
    pub(crate) place: &'l TaskPlace,
    /// The trials of its intervals, without those that were done again.
    pub(crate) intervals: &'l [u32],
    /// The level that was compared with the standard; none where nothing says it.
    pub(crate) level: Option<TaskLevel>,
}

impl<'l> Presentations<'l> {
    pub(crate) fn of(log: &'l SessionLog) -> Self {
        let mut levels = BTreeMap::new();
        let mut again = BTreeMap::new();
        for event in &log.events {
            match event {
                Event::Level { trial, level } => _ = levels.insert(*trial, *level),
                Event::Superseded { trial, by } => _ = again.insert(*by, *trial),
                _ => {}
            }
        }
        let replaced: BTreeSet<u32> = again.values().copied().collect();
        let mut places = BTreeMap::new();
        let mut intervals: BTreeMap<_, Vec<u32>> = BTreeMap::new();
        for planned in log.trials.iter().filter(|planned| planned.kind == Kind::Trial) {
            let Some(place) = &planned.task else { continue };
            places.insert(planned.trial, (&planned.mode, place));
            if !replaced.contains(&planned.trial) {
                let presentation = (&place.task, &planned.mode, place.presentation);
                intervals.entry(presentation).or_default().push(planned.trial);
            }
        }
        intervals.values_mut().for_each(|trials| trials.sort_unstable());
        Self { places, intervals, levels, again }
    }

    /// The presentation whose answer belongs to a trial.
    pub(crate) fn answered_after(&self, trial: u32) -> Option<Shown<'_>> {
        let (mode, place) = *self.places.get(&trial)?;
        let intervals = self.intervals.get(&(&place.task, mode, place.presentation));
        let intervals = intervals.map_or(&[][..], Vec::as_slice);
        let first = intervals.first().copied().unwrap_or(trial);
        Some(Shown { place, level: place.level.or_else(|| self.level(first)), intervals })
    }

    /// The level that the log has for a trial, or for the one in whose place it came.
    fn level(&self, mut trial: u32) -> Option<TaskLevel> {
        loop {
            if let Some(level) = self.levels.get(&trial) {
                return Some(*level);
            }
            let before = *self.again.get(&trial)?;
            // A trial comes in the place of an earlier one; a log that says otherwise ends here.
            if before >= trial {
                return None;
            }
            trial = before;
        }
    }
}
