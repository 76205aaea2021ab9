//! `[figures]` of a `study.toml`: tables within tables along the dots of a figure's id.

use super::check::Check;
use super::scenes::is_below;
use crate::{Alignment, Figures, OwnFigures, ParticipantId, SessionId};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// The key of these tables that holds a choice for means.
const ALIGNMENT: &str = "alignment";
/// The key, of all figures alone, that says which sessions have figures of their own.
const SESSIONS: &str = "sessions";
/// The key, likewise, that names the files of the font.
const FONT: &str = "font";
/// The word for all sessions.
const ALL: &str = "all";

impl Check<'_> {
    pub(super) fn figures(&mut self, table: &Table, environments: &[&str]) -> Figures {
        let mut figures = Figures::default();
        let mut table = table.clone();
        if let Some(value) = table.remove(SESSIONS) {
            figures.own = self.own(&value);
        }
        if let Some(value) = table.remove(FONT) {
            figures.font = self.font(value);
        }
        self.choices(&table, "", environments, &mut figures.alignment);
        figures
    }

    fn own(&mut self, value: &Value) -> OwnFigures {
        let own = match value {
            Value::String(word) if word == ALL => Some(OwnFigures::All),
            Value::Array(names) => {
                names.iter().map(named).collect::<Option<Vec<_>>>().map(OwnFigures::Of)
            }
            _ => None,
        };
        own.unwrap_or_else(|| {
            let key = format!("figures.{SESSIONS}");
            let what = format!("must be \"{ALL}\" or a list such as [\"P01.S01\"]");
            self.error(&key, format!("{value} {what}"));
            OwnFigures::default()
        })
    }

    /// The files of a font: a list, or one alone.
    fn font(&mut self, value: Value) -> Vec<String> {
        let list = if let Value::Array(list) = value { list } else { vec![value] };
        let files = list.iter().map(|value| {
            value.as_str().filter(|file| is_below(file, &["ttf", "otf"])).map(str::to_owned)
        });
        let files = files.collect::<Option<Vec<String>>>();
        files.filter(|files| (1..=Figures::MOST_FONT_FILES).contains(&files.len())).unwrap_or_else(
            || {
                let list = Value::Array(list);
                let what = "must be a font file in the study's folder such as \"fonts/My-Font.ttf\" (or .otf; \
                            letters, digits, '.', '_' and '-'), or a list of up to three: upright, italic, bold";
                self.error(&format!("figures.{FONT}"), format!("{list} {what}"));
                Vec::new()
            },
        )
    }

    /// The choices of `table`, which is for figures whose id begins with `id`.
    fn choices(
        &mut self,
        table: &Table,
        id: &str,
        environments: &[&str],
        choices: &mut BTreeMap<String, Alignment>,
    ) {
        for (key, value) in table {
            let inner = if id.is_empty() { key.clone() } else { format!("{id}.{key}") };
            let at = format!("figures.{inner}");
            match value {
                Value::Table(table) => match unknown(&inner, environments) {
                    None => self.choices(table, &inner, environments, choices),
                    Some(problem) => self.error(&at, problem),
                },
                value if key == ALIGNMENT => match value.as_str().and_then(Alignment::from_word) {
                    Some(alignment) => _ = choices.insert(id.to_owned(), alignment),
                    None => {
                        // `"onset" or "landmarks"`.
                        let words = Alignment::ALL.map(|a| format!("\"{}\"", a.as_str()));
                        self.error(&at, format!("{value} must be {}", words.join(" or ")));
                    }
                },
                _ => self.error(&at, format!("is not used here; a figure has the key {ALIGNMENT}")),
            }
        }
    }
}

/// Participant and session of `P01.S01`.
fn named(value: &Value) -> Option<[String; 2]> {
    let (participant, session) = value.as_str()?.split_once('.')?;
    let ids = (ParticipantId::new(participant).ok()?, SessionId::new(session).ok()?);
    Some([ids.0.to_string(), ids.1.to_string()])
}

/// Why no figure can have an id that begins so; `None` if one can.
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
    match &figures.own {
        OwnFigures::OfSmallStudies => {}
        OwnFigures::All => _ = all.insert(SESSIONS.to_owned(), Value::String(ALL.to_owned())),
        OwnFigures::Of(named) => {
            let names = named.iter().map(|[p, s]| Value::String(format!("{p}.{s}")));
            all.insert(SESSIONS.to_owned(), Value::Array(names.collect()));
        }
    }
    if !figures.font.is_empty() {
        let files = figures.font.iter().map(|file| Value::String(file.clone()));
        all.insert(FONT.to_owned(), Value::Array(files.collect()));
    }
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
