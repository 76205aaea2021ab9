//! Random codes in the place of participants' own, and the key that leads back.

use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{Column, Values};
use zwidth_study::{IdError, ParticipantId};
use zwidth_tables::{Table, TableError};

/// The random code of each participant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Codes(BTreeMap<ParticipantId, ParticipantId>);

/// Columns of sentences: they may name people and files, and are left out where people are renamed.
const PROSE: [&str; 5] = ["remark", "note", "why", "what", "file_blake3"];

impl Codes {
    /// Draws a code of its own for each of these people: `p` and eight hexadecimal digits.
    ///
    /// # Errors
    /// Those of `random`.
    pub fn draw<E: From<IdError>>(
        people: impl IntoIterator<Item = ParticipantId>,
        mut random: impl FnMut() -> Result<u32, E>,
    ) -> Result<Self, E> {
        let people: BTreeSet<ParticipantId> = people.into_iter().collect();
        let mut codes = BTreeMap::new();
        let mut taken = BTreeSet::new();
        for person in &people {
            loop {
                let code = ParticipantId::new(format!("p{:08x}", random()?))?;
                // A code that is somebody's own would lead to them.
                if !people.contains(&code) && taken.insert(code.clone()) {
                    codes.insert(person.clone(), code);
                    break;
                }
            }
        }
        Ok(Self(codes))
    }

    /// The code of somebody.
    pub(crate) fn of(&self, person: &ParticipantId) -> Option<&ParticipantId> {
        self.0.get(person)
    }

    /// The key, as CSV: who stays with the data can tell by it who is who.
    pub fn key(&self) -> String {
        let lines = self.0.iter().map(|(person, code)| format!("{person},{code}\r\n"));
        std::iter::once("participant,code\r\n".to_owned()).chain(lines).collect()
    }

    /// A table with codes in the place of participants, its rows in their order, without columns that
    /// may say who somebody is; and the names of these, if there were any.
    ///
    /// # Errors
    /// Those of a table.
    pub(crate) fn rename(&self, table: &Table) -> Result<(Table, Vec<String>), TableError> {
        let own: BTreeMap<&str, &str> =
            self.0.iter().map(|(person, code)| (person.as_str(), code.as_str())).collect();
        let mut columns = Vec::new();
        let mut left_out = Vec::new();
        for column in table.columns() {
            let name = &column.field.name;
            match &column.values {
                _ if PROSE.contains(&name.as_ref()) => left_out.push(name.to_string()),
                // What people call a metric of their own may name one of them.
                _ if names(&own, &column.field.description) => left_out.push(name.to_string()),
                Values::Text(texts) if name == "participant" => {
                    let codes = texts.iter().map(|text| {
                        let text = text.as_deref()?;
                        own.get(text).map(|code| (*code).into())
                    });
                    let values = Values::Text(codes.collect());
                    columns.push(Column { field: column.field.clone(), values });
                }
                Values::Text(texts) if texts.iter().flatten().any(|text| names(&own, text)) => {
                    left_out.push(name.to_string());
                }
                _ => columns.push(column.clone()),
            }
        }
        let table = Table::new(table.name(), table.title(), columns)?;
        let order: Option<Vec<String>> = table
            .words("participant")
            .ok()
            .map(|people| people.map(|person| person.unwrap_or_default().to_owned()).collect());
        // In the old order of their codes people could be counted off.
        let table = match order {
            Some(order) => table.sorted(|row| order.get(row).cloned()),
            None => table,
        };
        Ok((table, left_out))
    }
}

/// Whether a text has a participant's own code as one of its words.
fn names(own: &BTreeMap<&str, &str>, text: &str) -> bool {
    let is_apart = |c: char| !(c.is_ascii_alphanumeric() || c == '_' || c == '-');
    text.split(is_apart).any(|word| own.contains_key(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn codes(drawn: &[u32]) -> Codes {
        let mut drawn = drawn.iter().copied();
        let people = ["P01", "P02"].map(|id| id.parse().unwrap());
        Codes::draw::<IdError>(people, || Ok(drawn.next().unwrap())).unwrap()
    }

    #[test]
    fn everybody_has_a_code_of_their_own_and_the_key_leads_back() {
        let key = "participant,code\r\nP01,p000000ff\r\nP02,p00000001\r\n";
        assert_eq!(codes(&[255, 255, 1]).key(), key);
    }

    #[test]
    fn rows_stand_in_the_order_of_the_codes_and_what_names_somebody_is_left_out() {
        let columns = vec![
            Column::text("participant", "who", ["P01", "P02"].map(Some)),
            Column::text("group", "", ["novice", "expert"].map(Some)),
            Column::text("beside", "", [Some("as P01's"), None]),
            Column::text("remark", "", [Some("few"), None]),
            Column::text("close", "", [Some("P011"), Some("P0")]),
        ];
        let table = Table::new("t", "T", columns).unwrap().with_note("P01 was late");
        let (renamed, left_out) = codes(&[2, 1]).rename(&table).unwrap();
        assert_eq!(left_out, ["beside", "remark"]);
        let words = |column: &str| -> Vec<String> {
            renamed.words(column).unwrap().flatten().map(str::to_owned).collect()
        };
        assert_eq!(words("participant"), ["p00000001", "p00000002"]);
        assert_eq!(words("group"), ["expert", "novice"]);
        assert_eq!(words("close"), ["P0", "P011"]);
        assert!(renamed.notes().is_empty());
    }
}
