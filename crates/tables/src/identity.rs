//! The columns that say which trial a row is about.

use crate::Column;
use zwidth_study::TrialMeta;

/// Participant, session, trial, repeat, environment, mode and source: the first columns of every table
/// with one row a trial.
pub fn identity(trials: &[&TrialMeta]) -> Vec<Column> {
    let text = |name, description, get: fn(&TrialMeta) -> &str| {
        Column::text(name, description, trials.iter().map(|t| Some(get(t).to_owned())))
    };
    let number = |name, description, get: fn(&TrialMeta) -> u32| {
        Column::integer(name, "1", description, trials.iter().map(|t| Some(i64::from(get(t)))))
    };
    vec![
        text("participant", "participant's code", |t| t.participant.as_str()),
        text("session", "session", |t| t.session.as_str()),
        number("trial", "number within the session", |t| t.trial),
        number("repeat", "repeat of the condition", |t| t.repeat),
        text("environment", "what was rendered", |t| t.environment.as_str()),
        text("mode", "how it was rendered", |t| t.mode.as_str()),
        text("source", "recorded, twin or imported", |t| t.source.as_str()),
    ]
}
