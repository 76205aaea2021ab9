//! The record of what a job made from what.

use crate::Job;
use crate::hashes::Hashes;
use crate::results::{Results, relative};
use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;
use std::path::Path;
use zwidth_store::Layout;

/// The record of a job that succeeded. Paths are relative to the root, hashes are BLAKE3 of
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
            parameters: job.parameters(),
            inputs: hashes.of(root, &job.inputs()),
            origins: hashes.of(root, &job.origins),
            ..Self::default()
        }
    }

    /// The first file it names that a record of this study must not name, and why.
    pub(crate) fn names_elsewhere(&self, layout: &Layout) -> Option<String> {
        let outputs = self.outputs.keys().map(|path| (path, Results::named(layout, path).err()));
        let inputs = self.inputs.keys().chain(self.origins.keys());
        let inputs = inputs.map(|path| (path, relative(path).err()));
        outputs
            .chain(inputs)
            .find_map(|(path, why)| Some(format!("it names {path:?}, and {}", why?)))
    }
}

/// An object whose keys stand once: where one stands twice, readers differ in which of the two they
/// believe.
pub(crate) fn each_once<'de, D, V>(reader: D) -> Result<BTreeMap<String, V>, D::Error>
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
                // Looked up first: `insert` would take the second and drop the first.
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
pub(crate) fn in_words(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.strip_prefix("duplicate field `").and_then(|rest| rest.split_once('`')) {
        Some((key, place)) => format!("{key:?} stands twice{place}"),
        None => text,
    }
}
