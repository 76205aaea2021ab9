//! `[figures]` of a `study.toml`: tables within tables along the dots of a figure's id.

use super::check::Check;
use crate::{Alignment, Figures};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// The one key of these tables that holds a choice.
const ALIGNMENT: &str = "alignment";

impl Check<'_> {
    pub(super) fn figures(&mut self, table: &Table, environments: &[&str]) -> Figures {
        let mut figures = Figures::default();
        self.choices(table, "", environments, &mut figures.alignment);
        figures
    }

    /// The choices of `table`, which is for figures whose id begins with `id`.
    fn choices(
        &mut self,
        table: &Table,
        id: &str,
        environments: &[&str],
        found: &mut BTreeMap<String, Alignment>,
    ) {
        for (key, value) in table {
            let inner = if id.is_empty() { key.clone() } else { format!("{id}.{key}") };
            let at = format!("figures.{inner}");
            match value {
                Value::Table(table) => match unknown(&inner, environments) {
                    None => self.choices(table, &inner, environments, found),
                    Some(problem) => self.error(&at, problem),
                },
                value if key == ALIGNMENT => match alignment(value) {
                    Some(alignment) => _ = found.insert(id.to_owned(), alignment),
                    None => self.error(&at, format!("{value} must be {}", words())),
                },
                _ => self
                    .error(&at, format!("has no meaning here; a figure has the key {ALIGNMENT}")),
            }
        }
    }
}

fn alignment(value: &Value) -> Option<Alignment> {
    Alignment::ALL.into_iter().find(|a| value.as_str() == Some(a.as_str()))
}

/// `"onset" or "landmarks"`.
fn words() -> String {
    Alignment::ALL.map(|a| format!("\"{}\"", a.as_str())).join(" or ")
}

/// Why no figure's id begins so, if none can.
fn unknown(id: &str, environments: &[&str]) -> Option<String> {
    let parts: Vec<&str> = id.split('.').collect();
    match parts.as_slice() {
        [kind, ..] if !Figures::WITH_MEANS.contains(kind) => Some(format!(
            "there is no such figure with a mean; there are {}",
            Figures::WITH_MEANS.join(", ")
        )),
        ["modes", _, _, environment] if !environments.contains(environment) => Some(format!(
            "there is no such environment; the figures are modes.PARTICIPANT.SESSION.{{{}}}",
            environments.join(", ")
        )),
        ["modes", _, _, _, _, ..] | ["loops", _, _, _, ..] => Some(
            "no figure's id is as long; it is as its file's name without the extension".to_owned(),
        ),
        _ => None,
    }
}

/// Back to the tables of the file.
pub(super) fn table(figures: &Figures) -> Table {
    let mut all = Table::new();
    for (id, alignment) in figures.choices() {
        let mut here = &mut all;
        for part in id.split('.').filter(|part| !part.is_empty()) {
            let inner = here.entry(part).or_insert_with(|| Value::Table(Table::new()));
            // Never: no file gives a choice and a table the same name.
            let Value::Table(inner) = inner else { return all };
            here = inner;
        }
        here.insert(ALIGNMENT.to_owned(), Value::String(alignment.as_str().to_owned()));
    }
    all
}
