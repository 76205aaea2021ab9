//! The records of a study. Those of a thousand participants are a hundred megabytes of text, so
//! they stay in their file. Memory holds only the place of each record in the file, and the records
//! that were added since the file was written.

use crate::Results;
use crate::members::{Member, members};
use crate::record::{Record, each_once, in_words};
use rayon::prelude::*;
use serde::de::IgnoredAny;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io;
use std::sync::Arc;
use zwidth_store::{Content, Layout, StoreError};

/// Largest file of records that is read, bytes (16 GiB): of some five million trials.
const MOST_RECORDS: u64 = 1 << 34;

/// What the text of a record begins with.
const BEGINNING: &[u8] = b"{\"stage\":";

/// The records of a study's jobs, by job name. A copy shares them.
#[derive(Debug, Clone, Default)]
pub struct Records(pub(crate) BTreeMap<String, Kept>);

/// Where a record is.
#[derive(Debug, Clone)]
pub(crate) enum Kept {
    /// In memory.
    Here(Arc<Record>),
    /// In a file, from a byte on and of a length, as it would be written again.
    There(Arc<Content>, u64, usize),
}

impl Kept {
    pub(crate) fn here(record: Record) -> Self {
        Self::Here(Arc::new(record))
    }

    /// The record; `None` if the file was changed under us: then its job is made again.
    fn read(&self) -> Option<Arc<Record>> {
        match self {
            Self::Here(record) => Some(record.clone()),
            Self::There(file, from, length) => {
                serde_json::from_slice(&file.range(*from, *length).ok()?).ok()
            }
        }
    }

    /// The record as it is written; `None` if the file was changed under us.
    fn text(&self) -> Option<Vec<u8>> {
        match self {
            Self::Here(record) => serde_json::to_vec(record).ok(),
            Self::There(file, from, length) => {
                let text = file.range(*from, *length).ok()?;
                // That it is an object and begins as a record does is enough for the file to be
                // understood. To read it as one would take several times as long.
                let is_one = text.starts_with(BEGINNING)
                    && serde_json::from_slice::<IgnoredAny>(&text).is_ok();
                is_one.then(|| text.to_vec())
            }
        }
    }

    fn is(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Here(a), Self::Here(b)) => Arc::ptr_eq(a, b),
            (Self::There(a, from, _), Self::There(b, at, _)) => Arc::ptr_eq(a, b) && from == at,
            _ => false,
        }
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
        let Some(file) = results.open(&path, MOST_RECORDS)? else { return Ok(Default::default()) };
        let read = file
            .map_err(|error| error.what)
            .and_then(|file| read_records(&Arc::new(file), results.layout()));
        Ok(match read {
            Ok((records, ignored)) => {
                let remedy =
                    "nothing is lost: its results are made again; find out what wrote the record";
                let ignored = ignored.into_iter();
                (records, ignored.map(|what| StoreError::new(&path, what, remedy)).collect())
            }
            Err(what) => {
                let what = format!(
                    "the records of earlier runs cannot be read, so everything is made again: {what}"
                );
                let remedy = "you need not do anything; the file is written anew";
                (Self::default(), vec![StoreError::new(&path, what, remedy)])
            }
        })
    }

    /// Writes the records, as a whole, and gives them as they are in their new file. Their text is
    /// never in memory whole.
    pub(crate) fn write(&self, results: &Results) -> Result<Self, StoreError> {
        let path = Results::records_file(results.layout());
        let mut places = Vec::new();
        let written = results.write_by(&path, |out| -> io::Result<()> {
            let mut at = 0;
            for (name, kept) in &self.0 {
                let Some(text) = kept.text() else { continue };
                let before = if at == 0 { b"{" } else { b"," };
                let key = serde_json::to_vec(name)?;
                let parts = [&before[..], &key, b":", &text];
                parts.iter().try_for_each(|part| out.write_all(part))?;
                let from = at + (before.len() + key.len() + 1) as u64;
                places.push((name.clone(), from, text.len()));
                at = from + text.len() as u64;
            }
            out.write_all(if at == 0 { b"{}" } else { b"}" })
        })?;
        written.map_err(|e| StoreError::io(&path, "write", &e))?;
        // Whoever has removed it meanwhile has it written again from what is known here.
        let Some(Ok(file)) = results.open(&path, MOST_RECORDS)? else { return Ok(self.clone()) };
        let file = Arc::new(file);
        let mut records = BTreeMap::new();
        for (name, from, length) in places {
            records.insert(name, Kept::There(file.clone(), from, length));
        }
        Ok(Self(records))
    }

    /// Takes those of these records that have not changed since `before` from `written`, so that they
    /// need no memory.
    pub(crate) fn settle(&mut self, before: &Self, written: Self) {
        for (name, in_file) in written.0 {
            if let Some(kept) = self.0.get_mut(&name)
                && before.0.get(&name).is_some_and(|before| kept.is(before))
            {
                *kept = in_file;
            }
        }
    }

    /// The record of the job of that name.
    pub fn get(&self, name: &str) -> Option<Arc<Record>> {
        self.0.get(name)?.read()
    }

    /// Every job's name and record, by name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, Arc<Record>)> {
        self.0.iter().filter_map(|(name, kept)| Some((name.as_str(), kept.read()?)))
    }

    /// Every file that a job made, relative to the root, and BLAKE3 of what it made.
    pub fn outputs(&self) -> impl Iterator<Item = (String, String)> {
        self.iter().flat_map(|(_, record)| Arc::unwrap_or_clone(record).outputs)
    }

    /// The job that made the file at `path`, relative to the root.
    pub fn maker(&self, path: &str) -> Option<&str> {
        self.iter().find(|(_, record)| record.outputs.contains_key(path)).map(|(name, _)| name)
    }
}

/// The records of a file that are believed, and why the others are ignored.
fn read_records(file: &Arc<Content>, layout: &Layout) -> Result<(Records, Vec<String>), String> {
    // A record as it is kept, or why it is ignored.
    let read = |Member { name, value, from }: &Member| -> Result<Result<Kept, String>, String> {
        let record: Record = serde_json::from_str(value)
            .map_err(|error| format!("the record of {name:?}: {}", in_words(&error)))?;
        if let Some(why) = record.names_elsewhere(layout) {
            return Ok(Err(why));
        }
        // Only then is its text copied when records are saved; anything else is written anew.
        let is_as_written = serde_json::to_string(&record).is_ok_and(|text| text == *value);
        Ok(Ok(match is_as_written {
            true => Kept::There(file.clone(), *from, value.len()),
            false => Kept::here(record),
        }))
    };
    let mut all = BTreeMap::new();
    members(file, |members| {
        let read: Vec<_> = members.par_iter().map(read).collect();
        for (Member { name, .. }, read) in members.into_iter().zip(read) {
            match (all.entry(name), read?) {
                (Entry::Occupied(twice), _) => {
                    return Err(format!("{:?} stands twice", twice.key()));
                }
                (Entry::Vacant(place), kept) => _ = place.insert(kept),
            }
        }
        Ok(())
    })?;
    let mut records = BTreeMap::new();
    let mut ignored = Vec::new();
    for (name, kept) in all {
        match kept {
            Ok(kept) => _ = records.insert(name, kept),
            Err(why) => ignored.push(format!("the record of {name:?} is ignored: {why}")),
        }
    }
    Ok((Records(records), ignored))
}

impl PartialEq for Records {
    fn eq(&self, other: &Self) -> bool {
        self.iter().eq(other.iter())
    }
}

impl Eq for Records {}

impl Serialize for Records {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.iter())
    }
}

impl<'de> Deserialize<'de> for Records {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let all: BTreeMap<String, Record> = each_once(deserializer)?;
        Ok(Self(all.into_iter().map(|(name, record)| (name, Kept::here(record))).collect()))
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
    fn records_stay_in_the_file_in_which_they_are_written_and_are_written_again_as_they_stand_there()
     {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), "s".parse().unwrap());
        let results = Results::new(&layout, &RealFiles);
        let record = |version| Record { version, ..Record::default() };
        let names = ["b", "a\"}", "θ"];
        let mut records = Records::default();
        for (version, name) in (1..).zip(names) {
            records.0.insert(name.to_owned(), Kept::here(record(version)));
        }
        let written = records.write(&results).unwrap();
        let text = fs::read_to_string(Results::records_file(&layout)).unwrap();
        assert_eq!(text, serde_json::to_string(&records).unwrap());
        let (read, remarks) = Records::read(&results).unwrap();
        assert!(remarks.is_empty());
        for there in [&written, &read] {
            assert!(there.0.values().all(|kept| matches!(kept, Kept::There(..))));
            assert_eq!(there, &records);
        }
        // What has come since the file was begun stays as it is, and so does what has changed since.
        let mut since = records.clone();
        since.0.insert("b".to_owned(), Kept::here(record(7)));
        since.0.insert("new".to_owned(), Kept::here(record(8)));
        since.0.remove("θ");
        since.settle(&records, written);
        let here = since.0.iter().filter(|(_, kept)| matches!(kept, Kept::Here(_)));
        assert_eq!(here.map(|(name, _)| name.as_str()).collect::<Vec<_>>(), ["b", "new"]);
        let again = since.write(&results).unwrap();
        assert_eq!(again, since);
        let versions = again.iter().map(|(_, record)| record.version).collect::<Vec<_>>();
        assert_eq!(versions, [2, 7, 8]);
        assert_eq!(read, records, "of a file that another has replaced they are what they were");
    }

    #[test]
    fn records_that_are_not_as_they_would_be_written_are_written_so() {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), "s".parse().unwrap());
        let results = Results::new(&layout, &RealFiles);
        fs::create_dir_all(layout.derived()).unwrap();
        let text = format!("{{\n \"a\": {}}}", record("raw/s/a", "derived/s/a"));
        fs::write(Results::records_file(&layout), &text).unwrap();
        let (records, _) = Records::read(&results).unwrap();
        records.write(&results).unwrap();
        let written = fs::read_to_string(Results::records_file(&layout)).unwrap();
        assert_eq!(written, serde_json::to_string(&records).unwrap());
        assert!(written.len() < text.len() && !written.contains('\n'));
    }

    #[test]
    fn records_whose_file_is_changed_under_us_are_none_and_the_others_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder.path(), "s".parse().unwrap());
        let results = Results::new(&layout, &RealFiles);
        // So long that it stays on the disk.
        let long = Record { problems: vec!["x".repeat(1 << 24)], ..Record::default() };
        let all = ["a", "b", "c", "d"].map(|name| (name.to_owned(), Kept::here(Record::default())));
        let mut records = Records(all.into());
        records.0.insert("0".to_owned(), Kept::here(long));
        let mut there = records.write(&results).unwrap();
        let path = Results::records_file(&layout);
        let text = fs::read(&path).unwrap();
        let place = |name: &str| {
            let sought = format!("\"{name}\":{{");
            text.windows(sought.len()).position(|part| part == sought.as_bytes()).unwrap()
        };
        let mut other = text[..place("d")].to_vec();
        other[place("b") + 10] = b'}';
        other[place("c") + 4] = b'[';
        fs::write(&path, other).unwrap();
        there.0.insert("e".to_owned(), Kept::here(Record::default()));
        let names =
            |records: &Records| records.iter().map(|(name, _)| name.to_owned()).collect::<Vec<_>>();
        assert_eq!(names(&there), ["0", "a", "e"]);
        let again = there.write(&results).unwrap();
        assert_eq!(names(&again), ["0", "a", "e"]);
        let (read, remarks) = Records::read(&results).unwrap();
        assert_eq!((names(&read), remarks), (names(&again), Vec::new()));
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
