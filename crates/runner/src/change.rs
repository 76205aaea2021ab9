//! Why a job must be made again: what differs between the record of its last success and now.

use crate::hashes::TO_BE_MADE;
use crate::record::Record;
use serde::Serialize;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt;

/// The most parameters that are named if several differ.
const NAMED: usize = 3;

/// One thing that differs. Hashes are BLAKE3 of contents; `None` where there was, or is, no such
/// file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum Change {
    /// There is no record: never made, or it failed the last time.
    NeverMade,
    /// Somebody asked for it.
    Asked,
    /// The stage has another version of its algorithm.
    Version {
        /// The version that made it.
        recorded: u32,
        /// The present one.
        now: u32,
    },
    /// Parameters differ.
    Parameters {
        /// The parameters that differ.
        fields: Vec<Field>,
    },
    /// An input differs.
    Input(FileChange),
    /// An output differs: if it is missing or was edited, it is made again.
    Output(FileChange),
}

/// A parameter that differs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Field {
    /// Where it is: `analysis.confidence`, `trials[2].mode`; empty for all parameters together.
    pub name: String,
    /// What it was; `None` where there was none.
    pub recorded: Option<Value>,
    /// What it is; `None` where there is none.
    pub now: Option<Value>,
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let [recorded, now] = [&self.recorded, &self.now]
            .map(|value| value.as_ref().map_or("nothing".to_owned(), shorten));
        let name = if self.name.is_empty() { "all of them" } else { &self.name };
        write!(f, "{name}: {recorded} is now {now}")
    }
}

/// Letters of a value that people are shown.
const SHOWN: usize = 80;

fn shorten(value: &Value) -> String {
    let text = value.to_string();
    // By letters: a slice that ends inside one would panic.
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// A file that differs. Hashes are BLAKE3 of contents; `None` where there was, or is, no such file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct FileChange {
    /// The file, relative to the root.
    pub path: String,
    /// Its content when the job was last made.
    pub recorded: Option<String>,
    /// Its content now.
    pub now: Option<String>,
    /// What became of it.
    pub how: How,
}

/// What became of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum How {
    /// Its content has changed.
    Changed,
    /// The job did not have it before, or it was missing.
    New,
    /// It is not there.
    Missing,
    /// The job does not have it any more.
    Dropped,
    /// It is made again first. Only then is it known whether its content differs.
    ToBeMade,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::NeverMade => f.write_str("never made"),
            Self::Asked => f.write_str("asked to be made again"),
            Self::Version { recorded, now } => {
                write!(f, "algorithm version {recorded} is now {now}")
            }
            Self::Parameters { fields } => match names(fields).as_slice() {
                [one] if !one.is_empty() => write!(f, "parameter {one} changed"),
                names if (2..=NAMED).contains(&names.len()) => {
                    write!(f, "parameters {} changed", names.join(", "))
                }
                names => write!(f, "{} of its parameters changed", names.len()),
            },
            Self::Input(file) => write!(f, "input {} {}", file.path, file.how),
            Self::Output(file) => write!(f, "output {} {}", file.path, file.how),
        }
    }
}

/// The names of parameters, each once: one that differs in several items of a list, such as
/// `[2].analysis.confidence` of the third condition, without the item's number.
fn names(fields: &[Field]) -> Vec<&str> {
    // `analysis.confidence` of `[2].analysis.confidence`.
    let without_item = fields.iter().map(|Field { name, .. }| {
        let item = name.strip_prefix('[').and_then(|rest| rest.split_once("]."));
        item.map_or(name.as_str(), |(_, field)| field)
    });
    let without_item: Vec<&str> = without_item.collect();
    let mut names = Vec::new();
    for (field, own) in fields.iter().zip(&without_item) {
        let items = without_item.iter().filter(|other| *other == own).count();
        let name = if items > 1 { own } else { field.name.as_str() };
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

impl fmt::Display for How {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Changed => "changed",
            Self::New => "is new",
            Self::Missing => "is missing",
            Self::Dropped => "is no longer part of it",
            Self::ToBeMade => "is made again first",
        })
    }
}

/// Everything that differs, in the order version, parameters, inputs, outputs; nothing if the job
/// is up to date. `outputs` are the present ones.
pub(crate) fn changes(
    before: Option<&Record>,
    now: &Record,
    outputs: &BTreeMap<String, String>,
) -> Vec<Change> {
    let Some(before) = before else { return vec![Change::NeverMade] };
    let mut changes = key_changes(before, now);
    changes.extend(differences(&before.outputs, outputs).map(Change::Output));
    changes
}

/// The first of [`changes`]. `outputs` is called only if nothing else differs: it reads every output.
pub(crate) fn first_change(
    before: &Record,
    now: &Record,
    outputs: impl Fn() -> BTreeMap<String, String>,
) -> Option<Change> {
    let first = key_changes(before, now).into_iter().next();
    first.or_else(|| differences(&before.outputs, &outputs()).next().map(Change::Output))
}

/// What differs in the version, the parameters and the inputs.
fn key_changes(before: &Record, now: &Record) -> Vec<Change> {
    let mut changes = Vec::new();
    if before.version != now.version {
        changes.push(Change::Version { recorded: before.version, now: now.version });
    }
    let mut fields = Vec::new();
    if before.stage != now.stage {
        let recorded = Some(json!(before.stage));
        let now = Some(json!(now.stage));
        fields.push(Field { name: "stage".to_owned(), recorded, now });
    }
    if before.parameters != now.parameters {
        // Whoever can write a record can write anything there: what is no JSON is a text.
        let [recorded, now] = [&before.parameters, &now.parameters]
            .map(|text| serde_json::from_str(text).unwrap_or_else(|_| json!(text)));
        compare("", Some(&recorded), Some(&now), &mut fields);
    }
    if !fields.is_empty() {
        changes.push(Change::Parameters { fields });
    }
    changes.extend(differences(&before.inputs, &now.inputs).map(Change::Input));
    changes
}

/// Adds the fields below `name` in which two values differ.
fn compare(name: &str, recorded: Option<&Value>, now: Option<&Value>, fields: &mut Vec<Field>) {
    match (recorded, now) {
        (Some(Value::Object(a)), Some(Value::Object(b))) => {
            let dot = if name.is_empty() { "" } else { "." };
            for key in a.keys().chain(b.keys().filter(|key| !a.contains_key(*key))) {
                compare(&format!("{name}{dot}{key}"), a.get(key), b.get(key), fields);
            }
        }
        (Some(Value::Array(a)), Some(Value::Array(b))) => {
            for i in 0..a.len().max(b.len()) {
                compare(&format!("{name}[{i}]"), a.get(i), b.get(i), fields);
            }
        }
        (recorded, now) if recorded != now => {
            let recorded = recorded.cloned();
            let now = now.cloned();
            fields.push(Field { name: name.to_owned(), recorded, now });
        }
        _ => {}
    }
}

/// The files that differ: first those of now, then those that are no longer part of the job.
fn differences<'a>(
    before: &'a BTreeMap<String, String>,
    now: &'a BTreeMap<String, String>,
) -> impl Iterator<Item = FileChange> + 'a {
    let differ = now.iter().filter(|(path, hash)| before.get(*path) != Some(hash));
    let differ = differ.map(|(path, hash)| {
        let recorded = before.get(path).and_then(|hash| content(hash));
        let how = match (&recorded, hash.as_str()) {
            (_, "") => How::Missing,
            (_, TO_BE_MADE) => How::ToBeMade,
            (None, _) => How::New,
            (Some(_), _) => How::Changed,
        };
        let now = content(hash).filter(|_| how != How::ToBeMade);
        FileChange { path: path.clone(), recorded, now, how }
    });
    let dropped = before.iter().filter(|(path, _)| !now.contains_key(*path)).map(|(path, hash)| {
        FileChange { path: path.clone(), recorded: content(hash), now: None, how: How::Dropped }
    });
    differ.chain(dropped)
}

/// The hash of a file that exists: a missing file's is empty.
fn content(hash: &str) -> Option<String> {
    (!hash.is_empty()).then(|| hash.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(inputs: &[(&str, &str)]) -> Record {
        let inputs = inputs.iter().map(|(p, h)| ((*p).to_owned(), (*h).to_owned())).collect();
        Record { version: 1, inputs, ..Record::default() }
    }

    #[test]
    fn parameters_are_told_by_the_fields_that_differ() {
        let with = |parameters: &str| Record { parameters: parameters.to_owned(), ..record(&[]) };
        let told = |before: &str, now: &str| match changes(
            Some(&with(before)),
            &with(now),
            &BTreeMap::new(),
        )
        .as_slice()
        {
            [change @ Change::Parameters { fields }] => {
                let fields = fields.iter().map(ToString::to_string).collect::<Vec<_>>();
                (change.to_string(), fields)
            }
            other => panic!("{other:?}"),
        };
        let (change, fields) = told(
            r#"{"analysis":{"confidence":0.95,"grid_points":401},"trials":[1,2]}"#,
            r#"{"analysis":{"confidence":0.9,"grid_points":401},"trials":[1,2]}"#,
        );
        assert_eq!(change, "parameter analysis.confidence changed");
        assert_eq!(fields, ["analysis.confidence: 0.95 is now 0.9"]);
        let (change, fields) = told(r#"{"a":1,"t":[1,2]}"#, r#"{"t":[1,3,4],"b":null}"#);
        assert_eq!(change, "4 of its parameters changed");
        let expect = [
            "a: 1 is now nothing",
            "t[1]: 2 is now 3",
            "t[2]: nothing is now 4",
            "b: nothing is now null",
        ];
        assert_eq!(fields, expect);
        let of_two = |level: f64, grid: u32| {
            let one =
                |grid| format!(r#"{{"analysis":{{"confidence":{level},"grid_points":{grid}}}}}"#);
            format!("[{},{}]", one(grid), one(401))
        };
        let (change, fields) = told(&of_two(0.95, 401), &of_two(0.9, 401));
        assert_eq!((change.as_str(), fields.len()), ("parameter analysis.confidence changed", 2));
        let change = told(&of_two(0.95, 401), &of_two(0.95, 201)).0;
        assert_eq!(change, "parameter [0].analysis.grid_points changed");
        assert_eq!(told("level 0.9", "{}").1, ["all of them: \"level 0.9\" is now {}"]);
    }

    #[test]
    fn every_difference_is_told_with_both_hashes_not_only_the_first() {
        let before = record(&[("a", "1"), ("b", "2"), ("c", "3"), ("e", "5")]);
        let now = Record {
            version: 2,
            ..record(&[("a", "9"), ("b", ""), ("d", "4"), ("e", TO_BE_MADE)])
        };
        let none = BTreeMap::new();
        let words: Vec<String> =
            changes(Some(&before), &now, &none).iter().map(ToString::to_string).collect();
        let expect = [
            "algorithm version 1 is now 2",
            "input a changed",
            "input b is missing",
            "input d is new",
            "input e is made again first",
            "input c is no longer part of it",
        ];
        assert_eq!(words, expect);
        let hash = |h: &str| Some(h.to_owned());
        let file = FileChange {
            path: "a".to_owned(),
            recorded: hash("1"),
            now: hash("9"),
            how: How::Changed,
        };
        assert_eq!(changes(Some(&before), &now, &none)[1], Change::Input(file));
        assert!(changes(Some(&now), &now, &none).is_empty());
        assert_eq!(changes(None, &now, &none), [Change::NeverMade]);
    }
}
