//! One version everywhere, and the same packages in every lock file: the command and the module of Python come in one wheel,
//! and another version of a package may give other bytes.

use crate::binary::{binary, ran};
use crate::folders::workspace;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::process::Command;

fn text(file: &str) -> String {
    fs::read_to_string(workspace().join(file)).unwrap()
}

/// The version that a manifest in TOML states in a section.
fn stated(file: &str, section: &[&str]) -> String {
    let manifest: toml::Table = toml::from_str(&text(file)).unwrap();
    let mut place = &toml::Value::Table(manifest);
    for key in section {
        place = &place[*key];
    }
    place["version"].as_str().unwrap().to_owned()
}

/// The versions of each package of a lock file.
fn locked(file: &str) -> BTreeMap<String, BTreeSet<String>> {
    let lock: toml::Table = toml::from_str(&text(file)).unwrap();
    let mut versions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in lock["package"].as_array().unwrap() {
        let [name, version] =
            ["name", "version"].map(|key| package[key].as_str().unwrap().to_owned());
        versions.entry(name).or_default().insert(version);
    }
    versions
}

#[test]
fn every_manifest_and_the_command_have_one_version() {
    let ours = stated("Cargo.toml", &["workspace", "package"]);
    for (file, section) in [
        ("pyproject.toml", "project"),
        ("python/Cargo.toml", "package"),
        ("cluster/Cargo.toml", "package"),
    ] {
        assert_eq!(stated(file, &[section]), ours, "{file}");
    }
    let citation = text("CITATION.cff");
    assert!(citation.lines().any(|line| line == format!("version: {ours}")), "CITATION.cff");
    for (file, package) in [
        ("Cargo.lock", "zwidth"),
        ("python/Cargo.lock", "zwidth-python"),
        ("python/Cargo.lock", "zwidth-store"),
        ("cluster/Cargo.lock", "zwidth-cluster"),
    ] {
        assert_eq!(locked(file)[package], BTreeSet::from([ours.clone()]), "{file}: {package}");
    }
    let command = ran(&Command::new(binary()).arg("--version").output().unwrap());
    assert_eq!(command.out.trim(), format!("zwidth {ours}"));
}

#[test]
fn what_the_module_is_built_of_is_what_the_command_is_built_of() {
    let (module, command) = (locked("python/Cargo.lock"), locked("Cargo.lock"));
    let apart: Vec<_> = module
        .iter()
        .filter(|(name, versions)| command.get(*name).is_some_and(|own| own.is_disjoint(versions)))
        .map(|(name, versions)| (name, versions, &command[name]))
        .collect();
    assert!(apart.is_empty(), "copy Cargo.lock to python/ and build there: {apart:?}");
    assert!(module.contains_key("parquet") && module.contains_key("pyo3"));
}
