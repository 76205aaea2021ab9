//! The record of what was made from what.

use crate::Job;
use crate::hashes::Hashes;
use crate::provenance::origin;
use crate::results::{Results, relative};
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::path::Path;
use std::sync::Arc;
use zwidth_store::{Layout, MOST_BYTES, StoreError};

/// What is kept of a job that succeeded. Paths are relative to the root, hashes are BLAKE3 of
/// contents.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Record {
    /// The job's stage.
    pub stage: String,
    /// The stage's algorithm version.
    pub version: u32,
    /// The job's parameters, as canonical text ([`Job::parameters`]).
    pub parameters: String,
    /// What it read: path → hash; empty for a file that was missing.
    #[serde(deserialize_with = "each_once")]
    pub inputs: BTreeMap<String, String>,
    /// The files from which its parameters came at the last run: path → hash.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty", deserialize_with = "each_once")]
    pub origins: BTreeMap<String, String>,
    /// What it made: path → hash.
    #[serde(deserialize_with = "each_once")]
    pub outputs: BTreeMap<String, String>,
    /// What had to be left out.
    pub problems: Vec<String>,
    /// What is to be read with care.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub care: Vec<String>,
    /// The origin that each of its outputs carries ([`crate::ORIGIN`]).
    pub origin: String,
}

impl Record {
    /// The record of a job as it would be written now, before its outputs are made.
    pub(crate) fn now(job: &Job, root: &Path, hashes: &Hashes) -> Self {
        Self {
            stage: job.stage.name.to_owned(),
            version: job.stage.version,
            parameters: job.parameters.clone(),
            inputs: hashes.of(root, &job.inputs),
            origins: hashes.of(root, &job.origins),
            ..Self::default()
        }
    }

    /// The first file it names that a record of this study must not name, and why.
    pub(crate) fn names_elsewhere(&self, layout: &Layout) -> Option<String> {
        let outputs = self.outputs.keys().map(|path| (path, Results::named(layout, path).err()));
        let inputs = self.inputs.keys().chain(self.origins.keys());
        let inputs = inputs.map(|path| (path, relative(path).err()));
        let found = outputs.chain(inputs).find_map(|(path, why)| Some((path, why?)));
        found.map(|(path, why)| format!("it names {path:?}, and {why}"))
    }

    /// The same with its origin.
    pub(crate) fn with_origin(mut self, name: &str) -> Self {
        self.origin = origin(name, &self);
        self
    }
}

/// The records of a study's jobs, by job name. A copy shares them.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Records(
    #[serde(deserialize_with = "each_once")] pub(crate) BTreeMap<String, Arc<Record>>,
);

/// Largest file of records that is read, bytes (1 GiB): some three hundred thousand jobs.
pub(crate) const MOST_RECORDS: u64 = MOST_BYTES;

/// An object whose keys stand once: where one stands twice, readers differ in which of the two they
/// believe.
fn each_once<'de, D, V>(reader: D) -> Result<BTreeMap<String, V>, D::Error>
where
    D: Deserializer<'de>,
    V: Deserialize<'de>,
{
    struct Once<V>(PhantomData<V>);

    impl<'de, V: Deserialize<'de>> Visitor<'de> for Once<V> {
        type Value = BTreeMap<String, V>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("an object")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut object: A) -> Result<Self::Value, A::Error> {
            let mut all = BTreeMap::new();
            while let Some((key, value)) = object.next_entry::<String, V>()? {
                if all.contains_key(&key) {
                    return Err(A::Error::custom(format!("{key:?} stands twice")));
                }
                all.insert(key, value);
            }
            Ok(all)
        }
    }

    reader.deserialize_map(Once(PhantomData))
}

/// What is wrong with a file of records: of a record's own fields, serde says in other words than
/// [`each_once`] that one stands twice.
fn in_words(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.strip_prefix("duplicate field `").and_then(|rest| rest.split_once('`')) {
        Some((key, place)) => format!("{key:?} stands twice{place}"),
        None => text,
    }
}

impl Records {
    /// Reads the records of a study, and says which of them are not believed. A missing file gives
    /// no records, and so does one that cannot be understood: then everything is made again, which
    /// is always right. A record is ignored if it names an output that is not a result of the
    /// study, or an input outside of the data folder.
    ///
    /// # Errors
    /// A link on the way to the file.
    pub fn read(results: &Results) -> Result<(Self, Vec<StoreError>), StoreError> {
        let path = Results::records_file(results.layout());
        let distrusted = |what: String| {
            let what = format!(
                "the records of earlier runs cannot be read, so everything is made again: {what}"
            );
            StoreError::new(&path, what, "you need not do anything; the file is written anew")
        };
        let Some(bytes) = results.read(&path, MOST_RECORDS)? else {
            return Ok(Default::default());
        };
        let bytes = match bytes {
            Ok(bytes) => bytes,
            Err(error) => return Ok((Self::default(), vec![distrusted(error.what)])),
        };
        let read = std::str::from_utf8(&bytes).map_err(|e| e.to_string());
        let read =
            read.and_then(|text| serde_json::from_str::<Self>(text).map_err(|e| in_words(&e)));
        let Self(all) = match read {
            Ok(records) => records,
            Err(what) => return Ok((Self::default(), vec![distrusted(what)])),
        };
        let (mut believed, mut remarks) = (BTreeMap::new(), Vec::new());
        for (job, record) in all {
            match record.names_elsewhere(results.layout()) {
                None => _ = believed.insert(job, record),
                Some(why) => {
                    let what = format!("the record of {job:?} is ignored: {why}");
                    let remedy = "nothing is lost: its results are made again; find out what wrote the record";
                    remarks.push(StoreError::new(&path, what, remedy));
                }
            }
        }
        Ok((Self(believed), remarks))
    }

    /// Writes the records, as a whole. Those of a thousand participants are a hundred megabytes,
    /// written while stages run: their text is never in memory whole.
    pub(crate) fn write(&self, results: &Results) -> Result<(), StoreError> {
        let path = Results::records_file(results.layout());
        results.write_by(&path, |out| Ok(serde_json::to_writer(out, self)?))
    }

    /// The record of the job of that name.
    pub fn get(&self, name: &str) -> Option<&Record> {
        self.0.get(name).map(Arc::as_ref)
    }

    /// Every job's name and record, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Record)> {
        self.0.iter().map(|(name, record)| (name.as_str(), record.as_ref()))
    }

    /// The job that made the file at `path`, relative to the root.
    pub fn maker(&self, path: &str) -> Option<(&str, &Record)> {
        self.iter().find(|(_, record)| record.outputs.contains_key(path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use zwidth_store::RealFiles;

    /// What is read of records with this text, and what is said of them.
    fn read(text: &str) -> (Records, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), "s".parse().unwrap());
        fs::create_dir_all(layout.derived()).unwrap();
        fs::write(Results::records_file(&layout), text).unwrap();
        let (records, remarks) = Records::read(&Results::new(&layout, &RealFiles)).unwrap();
        (records, remarks.into_iter().map(|remark| remark.what).collect())
    }

    fn record(input: &str, output: &str) -> String {
        format!(
            r#"{{"stage":"a","version":1,"parameters":"","inputs":{{{input:?}:""}},"outputs":{{{output:?}:"00"}},
               "problems":[],"origin":""}}"#
        )
    }

    #[test]
    fn a_record_that_names_a_file_elsewhere_is_passed_by_and_the_others_are_not() {
        let good = record("raw/s/a", "derived/s/a");
        for (bad, path) in [
            (record("raw/s/a", "/etc/passwd"), "/etc/passwd"),
            (record("raw/s/a", "derived/t/a"), "derived/t/a"),
            (record("../../a", "derived/s/a"), "../../a"),
        ] {
            let (records, remarks) = read(&format!(r#"{{"bad\u001b[2J": {bad}, "good": {good}}}"#));
            assert_eq!(records.iter().map(|(job, _)| job).collect::<Vec<_>>(), ["good"]);
            assert!(
                matches!(remarks.as_slice(), [one] if one.contains(path) && !one.contains('\u{1b}')),
                "{remarks:?}"
            );
        }
    }

    #[test]
    fn records_in_which_a_key_stands_twice_or_that_are_no_records_are_not_believed() {
        let good = record("raw/s/a", "derived/s/a");
        let (records, remarks) = read(&format!(r#"{{"good": {good}, "good": {good}}}"#));
        assert_eq!(records, Records::default());
        assert!(remarks[0].contains("\"good\" stands twice"), "{remarks:?}");
        let twice = good.replace(r#"{"raw/s/a":"""#, r#"{"raw/s/a":"","raw/s/a":"""#);
        let (records, remarks) = read(&format!(r#"{{"good": {twice}}}"#));
        assert_eq!(records, Records::default());
        assert!(remarks[0].contains("\"raw/s/a\" stands twice"), "{remarks:?}");
        for text in ["", "[]", "{\"a\": 1}", "\u{0}"] {
            let (records, remarks) = read(text);
            assert_eq!((records, remarks.len()), (Records::default(), 1), "{text:?}");
        }
        assert_eq!(read("{}"), (Records::default(), Vec::new()));
    }
}
