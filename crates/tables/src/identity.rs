//! The columns that say which trial a row is about.

use crate::{Column, Table, TableError};
use zwidth_study::TrialMeta;

/// Participant, session, trial, repeat, environment, mode and source: the first columns of every
/// table with one row per trial.
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

/// The rows of several tables of one form about trials, in the order of participant, session and
/// trial; `None` without tables.
///
/// # Errors
/// Tables whose columns differ, or that do not say which trial a row is about.
pub fn of_trials(name: &str, title: &str, tables: Vec<Table>) -> Result<Option<Table>, TableError> {
    let Some(all) = Table::concat(name, title, tables)? else { return Ok(None) };
    let people = [all.texts("participant")?, all.texts("session")?];
    let trials = all.integers("trial")?;
    Ok(Some(all.sorted(|row| (&people[0][row], &people[1][row], trials[row]))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_trials_of_several_conditions_come_together_in_their_order() {
        let part = |people: [&str; 2], trials: [i64; 2]| {
            let texts = |name, values: [&str; 2]| {
                Column::text(name, "", values.map(|v| Some(v.to_owned())))
            };
            let trials = Column::integer("trial", "1", "", trials.map(Some));
            let columns =
                vec![texts("participant", people), texts("session", ["S01", "S01"]), trials];
            Table::new("metrics", "", columns).unwrap()
        };
        let parts = vec![part(["P01", "P02"], [10, 3]), part(["P02", "P01"], [4, 9])];
        let all = of_trials("all", "", parts).unwrap().unwrap();
        assert_eq!(all.integers("trial").unwrap(), [9, 10, 3, 4].map(Some));
        let people: Vec<_> = all.texts("participant").unwrap().into_iter().flatten().collect();
        assert_eq!(people, ["P01", "P01", "P02", "P02"]);
        assert!(of_trials("all", "", Vec::new()).unwrap().is_none());
    }
}
