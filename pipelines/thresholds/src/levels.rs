//! The answers by level.

use crate::Response;
use crate::answered::Own;
use std::collections::BTreeMap;
use zwidth_results::LevelTally;
use zwidth_stats::psychometric::LevelAnswers;
use zwidth_study::TaskLevel;

/// How often each level was answered, and how often positively, from the lowest.
pub(crate) fn counts(own: &Own) -> BTreeMap<TaskLevel, [usize; 2]> {
    let mut counts: BTreeMap<TaskLevel, [usize; 2]> = BTreeMap::new();
    for answer in &own.answers {
        let [trials, positive] = counts.entry(answer.level).or_default();
        *trials += 1;
        *positive += usize::from(answer.response == Response::Positive);
    }
    counts
}

/// The same as statistics take it.
pub(crate) fn answers(own: &Own) -> Vec<LevelAnswers> {
    let counts = counts(own).into_iter();
    let levels = counts.map(|(level, [trials, positive])| LevelAnswers {
        level: level.value(),
        trials: trials as u64,
        positive: positive as u64,
    });
    levels.collect()
}

/// The rows of a person in a session and mode.
pub(crate) fn rows(own: &Own) -> Vec<LevelTally> {
    let Some(first) = own.answers.first() else { return Vec::new() };
    let rows = counts(own).into_iter().map(|(level, [trials, positive])| LevelTally {
        participant: first.participant.clone(),
        session: first.session.clone(),
        task: first.task.clone(),
        environment: first.environment.clone(),
        mode: first.mode.clone(),
        unit: own.task.unit().into(),
        level: level.value(),
        trials,
        positive,
        share: positive as f64 / trials as f64,
    });
    rows.collect()
}
