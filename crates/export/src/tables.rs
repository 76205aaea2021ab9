//! Tables as they leave: rows that count, no names of files, and where the numbers come from in each row.

use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{Column, Field, Type, Values};
use zwidth_store::StudyData;
use zwidth_study::Source;
use zwidth_tables::{Table, TableError};

/// Columns that say where a file lies or why a row does not count: those that count have none.
const INSIDE: [&str; 5] = ["path", "why_not", "counts", "kind", "status"];

/// Where the numbers come from that count: of a trial, a session, a participant, the study.
pub(crate) struct Sources(BTreeMap<Key, BTreeSet<&'static str>>);

/// Participant, session and trial, as far as a row has them.
type Key = (Option<String>, Option<String>, Option<i64>);

impl Sources {
    pub(crate) fn of(data: &StudyData) -> Self {
        let mut sources = BTreeMap::<Key, BTreeSet<&'static str>>::new();
        let mut add = |participant: &str, session: &str, trial: u32, source: Source| {
            let participant = Some(participant.to_owned());
            let session = Some(session.to_owned());
            for key in [
                (participant.clone(), session.clone(), Some(trial.into())),
                (participant.clone(), session.clone(), None),
                (participant, None, None),
                (None, None, None),
            ] {
                sources.entry(key).or_default().insert(source.as_str());
            }
        };
        for entry in data.counting() {
            let meta = &entry.meta;
            add(meta.participant.as_str(), meta.session.as_str(), meta.trial, meta.source);
        }
        // Of answers alone the session says it.
        for answer in &data.answers {
            if let Some(log) = data.session(&answer.participant, &answer.session) {
                let (participant, session) = (&answer.participant, &answer.session);
                add(participant.as_str(), session.as_str(), answer.trial, log.record.source);
            }
        }
        Self(sources)
    }

    /// Those of the study, or of a part of it, as one text.
    pub(crate) fn told(&self, key: &Key) -> Option<String> {
        let words: Vec<&str> = self.0.get(key)?.iter().copied().collect();
        Some(words.join(" and "))
    }

    fn column(&self, table: &Table) -> Column {
        let texts = |name: &str| -> Option<Vec<Option<String>>> { table.texts(name).ok() };
        let participants = texts("participant");
        let sessions = participants.as_ref().and_then(|_| texts("session"));
        let trials = sessions.as_ref().and_then(|_| table.integers("trial").ok());
        let told = (0..table.height()).map(|row| {
            let key = (
                participants.as_ref().and_then(|all| all[row].clone()),
                sessions.as_ref().and_then(|all| all[row].clone()),
                trials.as_ref().and_then(|all| all[row]),
            );
            // A row of somebody without any trial that counts is of none.
            self.told(&key).or_else(|| self.told(&(None, None, None))).map(Into::into)
        });
        let field = Field {
            name: "source".into(),
            unit: "1".into(),
            description: "where its numbers come from: recorded, imported, twin or simulated; the last two were not measured"
                .into(),
            kind: Type::Text,
        };
        Column { field, values: Values::Text(told.collect()) }
    }
}

/// A derived table as it leaves: rows that count, without notes and what is of the inside, and with a
/// column `source`.
///
/// # Errors
/// Those of a table.
pub(crate) fn outward(table: &Table, sources: &Sources) -> Result<Table, TableError> {
    let table = match table.flags("counts") {
        Ok(counts) => {
            let rows = (0..).zip(counts).filter(|(_, counts)| *counts == Some(true));
            table.rows(&rows.map(|(row, _)| row).collect::<Vec<usize>>())
        }
        Err(_) => table.clone(),
    };
    let is_inside = |column: &&Column| INSIDE.contains(&column.field.name.as_ref());
    let has_source = table.column("source").is_ok();
    let own = (!has_source).then(|| sources.column(&table));
    let columns = table.columns().iter().filter(|column| !is_inside(column)).cloned().chain(own);
    Table::new(table.name(), table.title(), columns.collect())
}

/// Trials whose times are counted from elsewhere than their beginning: participant, session and number,
/// and the time of their first sample, s.
pub(crate) type Late = BTreeMap<(String, String, i64), f64>;

/// Columns with moments of a trial, as its samples count time.
const MOMENTS: [&str; 4] = ["t_s", "onset_s", "reversal_s", "end_s"];

/// A table with the moments of late trials counted from their first sample, as their samples are.
///
/// # Errors
/// Those of a table.
pub(crate) fn from_beginnings(table: &Table, late: &Late) -> Result<Table, TableError> {
    let keys = (table.texts("participant"), table.texts("session"), table.integers("trial"));
    let (Ok(people), Ok(sessions), Ok(trials)) = keys else { return Ok(table.clone()) };
    let begin_s = |row: usize| {
        let key = (people[row].clone()?, sessions[row].clone()?, trials[row]?);
        late.get(&key).copied()
    };
    let columns = table.columns().iter().map(|column| match &column.values {
        Values::Float(moments) if MOMENTS.contains(&column.field.name.as_ref()) => {
            let moments = (0..).zip(moments).map(|(row, moment)| match begin_s(row) {
                Some(begin_s) => moment.map(|moment| moment - begin_s),
                None => *moment,
            });
            Column { field: column.field.clone(), values: Values::Float(moments.collect()) }
        }
        _ => column.clone(),
    });
    Table::new(table.name(), table.title(), columns.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_of_a_trial_that_begins_at_ten_o_clock_are_counted_from_its_beginning() {
        let columns = vec![
            Column::text("participant", "", ["P01", "P01"].map(Some)),
            Column::text("session", "", ["S01", "S01"].map(Some)),
            Column::integer("trial", "1", "", [Some(1), Some(2)]),
            Column::float("onset_s", "s", "", [Some(36_000.5), Some(0.5)]),
            Column::float("duration_s", "s", "", [Some(2.0), Some(2.0)]),
        ];
        let table = Table::new("metrics", "", columns).unwrap();
        let late = Late::from([(("P01".to_owned(), "S01".to_owned(), 1), 36_000.0)]);
        let found = from_beginnings(&table, &late).unwrap();
        assert_eq!(found.floats("onset_s").unwrap(), [Some(0.5), Some(0.5)]);
        assert_eq!(found.floats("duration_s").unwrap(), [Some(2.0), Some(2.0)]);
    }
}
