//! The two workspaces have lock files of their own, and must build the same stages of the same
//! packages: another version of one may give other bytes.

use crate::studies::workspace;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

/// The versions of each package.
fn locked(folder: &Path) -> BTreeMap<String, BTreeSet<String>> {
    let text = fs::read_to_string(folder.join("Cargo.lock")).unwrap();
    let mut versions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in text.split("[[package]]").skip(1) {
        let value = |key: &str| {
            let line = package.lines().find_map(|line| line.strip_prefix(key)).unwrap();
            line.trim_matches('"').to_owned()
        };
        versions.entry(value("name = \"")).or_default().insert(value("version = \""));
    }
    versions
}

#[test]
fn whatever_both_workspaces_build_has_a_version_in_common() {
    let (ours, theirs) = (locked(Path::new(env!("CARGO_MANIFEST_DIR"))), locked(&workspace()));
    let apart: Vec<_> = ours
        .iter()
        .filter(|(name, versions)| theirs.get(*name).is_some_and(|t| t.is_disjoint(versions)))
        .map(|(name, versions)| (name, versions, &theirs[name]))
        .collect();
    assert!(apart.is_empty(), "copy Cargo.lock to cluster/ and build there: {apart:?}");
    assert!(ours.contains_key("parquet") && ours.contains_key("zstd"));
}
