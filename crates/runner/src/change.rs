//! Why a job must be made again: what differs between the record of its last success and now.

use crate::hashes::TO_BE_MADE;
use crate::record::Record;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt;

/// One thing that differs. Hashes are BLAKE3 of contents; `None` where there was, or is, no such
/// file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum Change {
    /// There is no record: never made, or it failed the last time.
    NeverMade,
    /// Somebody asked for it.
    Asked,
    /// The stage's algorithm is another.
    Version {
        /// The version that made it.
        recorded: u32,
        /// The present one.
        now: u32,
    },
    /// The parameters differ.
    Parameters {
        /// Those that it was made with.
        recorded: String,
        /// The present ones.
        now: String,
    },
    /// An input.
    Input(FileChange),
    /// An output: a missing or an edited one is made again.
    Output(FileChange),
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
    /// Its content is another.
    Changed,
    /// The job did not have it before, or it was missing.
    New,
    /// It is not there.
    Missing,
    /// The job does not have it any more.
    Dropped,
    /// It is itself made again first; whether its content will differ shows then.
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
            Self::Parameters { .. } => f.write_str("its parameters changed"),
            Self::Input(file) => write!(f, "input {} {}", file.path, file.how),
            Self::Output(file) => write!(f, "output {} {}", file.path, file.how),
        }
    }
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
    let mut changes = of_what_goes_in(before, now);
    changes.extend(differences(&before.outputs, outputs).map(Change::Output));
    changes
}

/// The first of these; outputs are asked for only where nothing else differs.
pub(crate) fn first_change(
    before: &Record,
    now: &Record,
    outputs: impl Fn() -> BTreeMap<String, String>,
) -> Option<Change> {
    let first = of_what_goes_in(before, now).into_iter().next();
    first.or_else(|| differences(&before.outputs, &outputs()).next().map(Change::Output))
}

fn of_what_goes_in(before: &Record, now: &Record) -> Vec<Change> {
    let mut changes = Vec::new();
    if before.version != now.version {
        changes.push(Change::Version { recorded: before.version, now: now.version });
    }
    if before.parameters != now.parameters || before.stage != now.stage {
        let (recorded, now) = (before.parameters.clone(), now.parameters.clone());
        changes.push(Change::Parameters { recorded, now });
    }
    changes.extend(differences(&before.inputs, &now.inputs).map(Change::Input));
    changes
}

/// The files that differ: first those of now, then those that are no longer part of the job.
fn differences<'a>(
    before: &'a BTreeMap<String, String>,
    now: &'a BTreeMap<String, String>,
) -> impl Iterator<Item = FileChange> + 'a {
    let differ = now.iter().filter(|(path, hash)| before.get(*path) != Some(hash));
    let differ = differ.map(|(path, hash)| {
        let recorded = before.get(path).and_then(|hash| known(hash));
        let how = match (&recorded, hash.as_str()) {
            (_, "") => How::Missing,
            (_, TO_BE_MADE) => How::ToBeMade,
            (None, _) => How::New,
            (Some(_), _) => How::Changed,
        };
        let now = known(hash).filter(|_| how != How::ToBeMade);
        FileChange { path: path.clone(), recorded, now, how }
    });
    let dropped = before.iter().filter(|(path, _)| !now.contains_key(*path)).map(|(path, hash)| {
        FileChange { path: path.clone(), recorded: known(hash), now: None, how: How::Dropped }
    });
    differ.chain(dropped)
}

/// A missing file's hash is empty.
fn known(hash: &str) -> Option<String> {
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
