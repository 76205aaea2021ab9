//! What the stage is given: a row for each presentation that was answered.

use serde::Serialize;
use zwidth_study::{
    EnvironmentId, ModeId, ParticipantId, QuestionId, SessionId, Source, Task, TaskLevel,
};

/// What was answered about the level of a presentation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Response {
    /// It was more, the answer was right, yes; of one who sets the level: less of it is wanted.
    Positive,
    /// It was less, the answer was wrong, no; of one who sets the level: more of it is wanted.
    Negative,
    /// Of one who sets the level: it is right.
    Set,
}

/// A presentation that was answered, and whose answer counts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answered {
    /// Who answered.
    pub participant: ParticipantId,
    /// In which session.
    pub session: SessionId,
    /// The trial after which it was answered.
    pub trial: u32,
    /// The task.
    pub task: QuestionId,
    /// What was rendered.
    pub environment: EnvironmentId,
    /// How it was rendered.
    pub mode: ModeId,
    /// The presentation, counted from 1 for each task and mode.
    pub presentation: u32,
    /// Which of several sequences that take turns, from 0.
    pub track: u8,
    /// What was compared with the standard.
    pub level: TaskLevel,
    /// What was answered.
    pub response: Response,
    /// Where it is from.
    pub source: Source,
}

/// The answers of one person in one session and mode, in the order of presentations.
pub(crate) struct Own<'a> {
    pub(crate) task: &'a Task,
    pub(crate) answers: Vec<&'a Answered>,
}
