//! The manifest of a shard: what it made, from which inputs, with which version and parameters.
//!
//! A shard writes its own outputs and its own manifest, and nothing else, so shards that run at the
//! same time never write the same file. Each file is written whole, or not at all.

use crate::{Records, Results, Shard};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use zwidth_store::{Layout, MOST_BYTES, StoreError, hex_blake3};

/// The version of the program: results of another version are not merged.
pub const PROGRAM: &str = env!("CARGO_PKG_VERSION");

/// What a shard says of itself.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Manifest {
    /// The version of the program that made it.
    pub(crate) zwidth: String,
    /// The study.
    pub(crate) study: String,
    pub(crate) shard: Shard,
    /// What it made, and what of its own it found made.
    pub(crate) records: Records,
}

/// A manifest's file.
pub(crate) struct ManifestFile {
    pub(crate) path: PathBuf,
    /// The shard, by the file's name.
    pub(crate) shard: Shard,
    /// BLAKE3 of the file's content; empty where it cannot be read.
    pub(crate) blake3: String,
    /// Its content, or why that cannot be used.
    pub(crate) manifest: Result<Manifest, StoreError>,
}

impl Manifest {
    /// What a shard of this study says of itself with these records.
    pub(crate) fn new(layout: &Layout, shard: Shard, records: Records) -> Self {
        let study = layout.study().to_string();
        Self { zwidth: PROGRAM.to_owned(), study, shard, records }
    }

    /// Writes it whole.
    pub(crate) fn write(&self, results: &Results) -> Result<(), StoreError> {
        let path = file(results.layout(), self.shard);
        let text = serde_json::to_vec(self).map_err(|e| {
            StoreError::new(&path, e.to_string(), "this is a defect of zwidth; please report it")
        })?;
        results.write(&path, &text)
    }

    /// Reads the manifest of a shard; `None` if there is none.
    ///
    /// # Errors
    /// A link on the way to it.
    pub(crate) fn read(
        results: &Results,
        shard: Shard,
    ) -> Result<Option<ManifestFile>, StoreError> {
        let path = file(results.layout(), shard);
        let Some(bytes) = results.read(&path, MOST_BYTES)? else { return Ok(None) };
        let blake3 = bytes.as_ref().map_or_else(|_| String::new(), |bytes| hex_blake3(bytes));
        let manifest = match bytes {
            Ok(bytes) => parsed(results.layout(), shard, &path, &bytes),
            Err(error) => Err(refusal(results.layout(), shard, &path, &error.what)),
        };
        Ok(Some(ManifestFile { path, shard, blake3, manifest }))
    }

    /// All manifests of a study, by shard.
    ///
    /// # Errors
    /// A link on the way to them; a folder that cannot be listed.
    pub(crate) fn all(results: &Results) -> Result<Vec<ManifestFile>, StoreError> {
        let names = results.list(&folder(results.layout()))?;
        let mut shards: Vec<Shard> = names.iter().filter_map(|path| named(path)).collect();
        shards.sort_by_key(|shard| (shard.of(), shard.number()));
        let files = shards.into_iter().map(|shard| Self::read(results, shard));
        // One may be merged by another run between listing and reading: then it is none.
        files.filter_map(Result::transpose).collect()
    }
}

/// How many shards of a study have left a manifest in its own folder, which no merge has taken in.
///
/// # Errors
/// A link on the way to them; a folder that cannot be listed.
pub fn waiting(results: &Results) -> Result<usize, StoreError> {
    let names = results.list(&folder(results.layout()))?;
    Ok(names.iter().filter(|path| named(path).is_some()).count())
}

/// Where manifests lie.
pub(crate) fn folder(layout: &Layout) -> PathBuf {
    layout.derived().join("shards")
}

/// `derived/<study>/shards/3-of-7.json`.
fn file(layout: &Layout, shard: Shard) -> PathBuf {
    folder(layout).join(file_name(shard))
}

fn file_name(shard: Shard) -> String {
    format!("{}-of-{}.json", shard.number(), shard.of())
}

/// The shard that a file is the manifest of, by its name.
fn named(path: &Path) -> Option<Shard> {
    let name = path.file_name()?.to_str()?;
    let (number, of) = name.strip_suffix(".json")?.split_once("-of-")?;
    let shard = format!("{number}/{of}").parse().ok()?;
    (file_name(shard) == name).then_some(shard)
}

/// The content of a manifest, if it can be the manifest of this shard.
fn parsed(
    layout: &Layout,
    shard: Shard,
    path: &Path,
    bytes: &[u8],
) -> Result<Manifest, StoreError> {
    let damaged =
        |what: String| refusal(layout, shard, path, &format!("its manifest is damaged: {what}"));
    let text = std::str::from_utf8(bytes).map_err(|e| damaged(e.to_string()))?;
    let manifest: Manifest = serde_json::from_str(text).map_err(|e| damaged(e.to_string()))?;
    let Manifest { zwidth, study, shard: own, records } = &manifest;
    if *own != shard || study != layout.study().as_str() {
        return Err(damaged(format!("it says that it is shard {own} of the study {study:?}")));
    }
    if zwidth != PROGRAM {
        let why = format!("zwidth {zwidth:?} made it, and this is zwidth {PROGRAM}");
        return Err(refusal(layout, shard, path, &why));
    }
    // As with the study's own records: whoever can write a manifest could have any file removed.
    let elsewhere = records.iter().find_map(|(job, record)| {
        record.names_elsewhere(layout).map(|why| format!("the job {job:?}: {why}"))
    });
    elsewhere.map_or(Ok(manifest), |why| Err(damaged(why)))
}

/// The error that refuses a shard, and says what to do about it.
pub(crate) fn refusal(layout: &Layout, shard: Shard, path: &Path, why: &str) -> StoreError {
    let again = layout.command(&["run", layout.study().as_str(), "--shard", &shard.to_string()]);
    let remedy = format!("run it again (`{again}`), or remove this manifest");
    StoreError::new(path, format!("shard {shard} is refused: {why}"), remedy)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use zwidth_store::RealFiles;

    fn read_as(text: &str, name: &str) -> Vec<(String, Result<Manifest, String>)> {
        let folder_ = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder_.path(), "s".parse().unwrap());
        fs::create_dir_all(folder(&layout)).unwrap();
        fs::write(folder(&layout).join(name), text).unwrap();
        let found = Manifest::all(&Results::new(&layout, &RealFiles)).unwrap();
        let told = |m: Result<Manifest, StoreError>| m.map_err(|e| e.to_string());
        found.into_iter().map(|f| (f.shard.to_string(), told(f.manifest))).collect()
    }

    fn text(shard: &str, study: &str, version: &str) -> String {
        format!(r#"{{"zwidth":"{version}","study":"{study}","shard":"{shard}","records":{{}}}}"#)
    }

    #[test]
    fn a_manifest_is_found_by_its_name_and_comes_back_as_it_was_written() {
        let folder_ = tempfile::tempdir().unwrap();
        let layout = Layout::new(folder_.path(), "s".parse().unwrap());
        let results = Results::new(&layout, &RealFiles);
        for (number, of) in [(10, 64), (9, 64), (1, 2)] {
            let shard = Shard::new(number, of).unwrap();
            Manifest::new(&layout, shard, Records::default()).write(&results).unwrap();
        }
        let found = Manifest::all(&results).unwrap();
        let shards: Vec<String> = found.iter().map(|f| f.shard.to_string()).collect();
        assert_eq!(shards, ["1/2", "9/64", "10/64"]);
        assert!(found.iter().all(|f| f.manifest.as_ref().is_ok_and(|m| m.shard == f.shard)));
        let none = Manifest::read(&results, Shard::new(2, 2).unwrap()).unwrap();
        assert!(none.is_none());
    }

    #[test]
    fn whichever_bit_of_a_manifest_is_wrong_it_is_read_or_refused_by_its_shard() {
        let record = r#"{"stage":"a","version":1,"parameters":"{}","inputs":{"raw/s/a":"00"},
            "outputs":{"derived/s/a":"00"},"problems":[],"origin":""}"#;
        let whole = text("3/7", "s", PROGRAM).replace("{}}", &format!("{{\"a\":{record}}}}}"));
        let (folder_, shard) = (tempfile::tempdir().unwrap(), Shard::new(3, 7).unwrap());
        let layout = Layout::new(folder_.path(), "s".parse().unwrap());
        let path = file(&layout, shard);
        let read = |bytes: &[u8]| parsed(&layout, shard, &path, bytes);
        assert_eq!(read(whole.as_bytes()).unwrap().records.iter().count(), 1);
        let cut = (0..whole.len()).map(|length| whole.as_bytes()[..length].to_vec());
        let flipped = (0..8 * whole.len()).map(|bit| {
            let mut bytes = whole.clone().into_bytes();
            bytes[bit / 8] ^= 1 << (bit % 8);
            bytes
        });
        for bytes in cut.chain(flipped) {
            if let Err(error) = read(&bytes) {
                assert!(error.what.starts_with("shard 3/7 is refused: "), "{error}");
            }
        }
    }

    #[test]
    fn a_damaged_a_strange_and_an_older_manifest_are_refused_by_the_shard_they_are_of() {
        assert!(read_as(&text("3/7", "s", PROGRAM), "3-of-7.json")[0].1.is_ok());
        for (text, words) in [
            (text("3/7", "s", "0.0.9"), "zwidth \"0.0.9\" made it, and this is zwidth"),
            (text("2/7", "s", PROGRAM), "is damaged: it says that it is shard 2/7"),
            (text("3/7", "t", PROGRAM), "of the study \"t\""),
            ("{".to_owned(), "its manifest is damaged"),
            (String::new(), "its manifest is damaged"),
        ] {
            let found = read_as(&text, "3-of-7.json");
            let (shard, Err(error)) = &found[0] else { panic!("{found:?}") };
            assert_eq!(shard, "3/7");
            assert!(error.contains("shard 3/7 is refused") && error.contains(words), "{error}");
            assert!(error.contains(" run s --shard 3/7`"), "{error}");
        }
        for other in ["3-of-7", "8-of-7.json", "03-of-7.json", ".3-of-7.json.17.tmp", "a.json"] {
            assert!(read_as(&text("3/7", "s", PROGRAM), other).is_empty(), "{other}");
        }
    }
}
