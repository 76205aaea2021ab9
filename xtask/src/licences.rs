//! The notices of what is linked into the program, from the packages themselves, for `zwidth licences`.

use anyhow::{Context as _, bail};
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Where they are kept: the program has its bytes.
const FILE: &str = "crates/zwidth/licences.gz";
/// What the names of files with notices begin with, in capitals.
const NOTICES: [&str; 6] = ["LICEN", "COPYING", "COPYRIGHT", "NOTICE", "UNLICEN", "PATENTS"];
/// Folders of a package of which nothing is linked.
const NOT_LINKED: [&str; 7] = ["tests", "test", "examples", "benches", "fuzz", "doc", "docs"];
/// Some packages are packed without a text. They may be taken under this one, which names no holder.
const WITHOUT_HOLDER: &str = "Apache-2.0";
/// How its text begins, blanks aside.
const APACHE: &str = "Apache License Version 2.0, January 2004";

/// A package that is linked.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Linked {
    name: String,
    version: String,
    licence: String,
    folder: PathBuf,
}

impl Linked {
    fn of(package: &Value) -> anyhow::Result<Self> {
        let text = |key: &str| {
            let text = package[key].as_str().map(str::to_owned);
            text.with_context(|| {
                format!("cargo metadata: a package without {key}: {}", package["id"])
            })
        };
        let manifest = PathBuf::from(text("manifest_path")?);
        Ok(Self {
            name: text("name")?,
            version: text("version")?,
            licence: text("license").unwrap_or_else(|_| "see its text".to_owned()),
            folder: manifest.parent().unwrap_or(&manifest).to_owned(),
        })
    }

    /// The line that names it.
    fn title(&self) -> String {
        format!("{} {} ({})", self.name, self.version, self.licence)
    }
}

/// Writes the notices.
pub(crate) fn write() -> anyhow::Result<()> {
    let packages = linked()?;
    let text = notices(&packages)?;
    // No time and no name of a file: the same packages give the same bytes.
    let mut packed = GzEncoder::new(Vec::new(), Compression::best());
    packed.write_all(text.as_bytes())?;
    let bytes = packed.finish()?;
    fs::write(FILE, &bytes).with_context(|| format!("cannot write {FILE}"))?;
    println!("{FILE}: {} packages, {} bytes of {}", packages.len(), bytes.len(), text.len());
    Ok(())
}

/// The packages of others that are linked into the program, on any system, by name. Macros run when it is built, and are not.
fn linked() -> anyhow::Result<Vec<Linked>> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let asked =
        Command::new(cargo).args(["metadata", "--format-version", "1", "--locked"]).output()?;
    if !asked.status.success() {
        bail!("cargo metadata: {}", String::from_utf8_lossy(&asked.stderr));
    }
    let metadata: Value = serde_json::from_slice(&asked.stdout)?;
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let packages: BTreeMap<String, Value> = list(&metadata["packages"])
        .into_iter()
        .map(|package| (package["id"].to_string(), package))
        .collect();
    let nodes: BTreeMap<String, Value> = list(&metadata["resolve"]["nodes"])
        .into_iter()
        .map(|node| (node["id"].to_string(), node))
        .collect();
    let is_macro = |package: &Value| {
        let kinds = list(&package["targets"]).into_iter().flat_map(|target| list(&target["kind"]));
        kinds.into_iter().any(|kind| kind == "proc-macro")
    };
    let program = packages.iter().find(|(_, package)| package["name"] == "zwidth");
    let (program, _) = program.context("cargo metadata has no package zwidth")?;
    let mut seen = BTreeSet::new();
    let mut open = vec![program.clone()];
    let mut found = Vec::new();
    while let Some(id) = open.pop() {
        let package = packages.get(&id).with_context(|| format!("cargo metadata lacks {id}"))?;
        if is_macro(package) || !seen.insert(id.clone()) {
            continue;
        }
        // Those of this workspace have no source.
        if package["source"].is_string() {
            found.push(Linked::of(package)?);
        }
        for needed in list(&nodes[&id]["deps"]) {
            // A kind that is null is neither of a build script nor of tests.
            if list(&needed["dep_kinds"]).iter().any(|kind| kind["kind"].is_null()) {
                open.push(needed["pkg"].to_string());
            }
        }
    }
    found.sort();
    Ok(found)
}

/// Every package with the numbers of its texts, then each text once.
fn notices(packages: &[Linked]) -> anyhow::Result<String> {
    let mut texts: Vec<String> = Vec::new();
    let mut own: Vec<Vec<usize>> = Vec::new();
    let mut has_own_text = Vec::new();
    for package in packages {
        let mut numbers = BTreeSet::new();
        let files = files(&package.folder)?;
        // Those below are of what it brings.
        has_own_text.push(files.iter().any(|file| file.parent() == Some(&package.folder)));
        for file in files {
            let bytes =
                fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
            let text = String::from_utf8_lossy(&bytes).replace("\r\n", "\n").trim().to_owned();
            let known = texts.iter().position(|other| *other == text);
            numbers.insert(known.unwrap_or_else(|| {
                texts.push(text);
                texts.len() - 1
            }));
        }
        own.push(numbers.into_iter().collect());
    }
    let plain = |text: &String| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let apache = texts.iter().position(|text| plain(text).starts_with(APACHE));
    let mut all = "zwidth is made of its own code and of these packages. Behind each stand the numbers of its texts, \
                   which follow.\nIts font is Noto Sans (Copyright 2012 Google Inc.), under the SIL Open Font License: \
                   the text of notosans.\n\n"
        .to_owned();
    for ((package, numbers), has_own_text) in packages.iter().zip(&own).zip(has_own_text) {
        let title = package.title();
        let mut numbers: Vec<String> =
            numbers.iter().map(|number| (number + 1).to_string()).collect();
        if !has_own_text {
            let is_under_it = package.licence.contains(WITHOUT_HOLDER);
            let Some(apache) = apache.filter(|_| is_under_it) else {
                bail!("{title} has no text in {}", package.folder.display());
            };
            numbers.push(format!("{} (packed without a text of its own)", apache + 1));
        }
        all += &format!("{title}: {}\n", numbers.join(", "));
    }
    for (place, text) in texts.iter().enumerate() {
        all += &format!("\n──── {} ────\n\n{text}\n", place + 1);
    }
    Ok(all)
}

/// The files with notices of a package, also those of sources in C and of fonts that it brings.
fn files(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    let entries =
        fs::read_dir(folder).with_context(|| format!("cannot list {}", folder.display()))?;
    for entry in entries {
        let entry = entry?;
        let name = entry.file_name().to_string_lossy().to_uppercase();
        let is_code = name.ends_with(".RS") || name.ends_with(".C") || name.ends_with(".H");
        if entry.file_type()?.is_dir() {
            if !NOT_LINKED.contains(&name.to_lowercase().as_str()) {
                found.extend(files(&entry.path())?);
            }
        } else if NOTICES.iter().any(|start| name.starts_with(start)) && !is_code {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::read::GzDecoder;
    use std::io::Read as _;

    /// The notices as they are kept.
    fn kept() -> anyhow::Result<String> {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(FILE);
        let mut text = String::new();
        GzDecoder::new(fs::File::open(file)?).read_to_string(&mut text)?;
        Ok(text)
    }

    #[test]
    fn the_notices_name_every_package_that_is_linked_and_no_other() {
        let kept = kept().unwrap();
        let (head, _) = kept.split_once("\n──── 1 ────\n").unwrap();
        let named: Vec<&str> =
            head.lines().skip(3).filter_map(|line| Some(line.rsplit_once(": ")?.0)).collect();
        let linked: Vec<String> = linked().unwrap().iter().map(Linked::title).collect();
        assert_eq!(named, linked, "make them again: cargo xtask licences");
        assert!(linked.len() > 200);
    }

    #[test]
    fn every_number_has_its_text_and_the_font_has_its_own() {
        let kept = kept().unwrap();
        let (head, texts) = kept.split_once("\n──── 1 ────\n").unwrap();
        let numbers = head.lines().filter_map(|line| line.rsplit_once("): "));
        for number in numbers.flat_map(|(_, numbers)| numbers.split(", ")) {
            let number = number.split(' ').next().unwrap_or_default();
            if let Ok(number) = number.parse::<usize>() {
                assert!(
                    number == 1 || texts.contains(&format!("\n──── {number} ────\n")),
                    "{number}"
                );
            }
        }
        let words = kept.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.contains("SIL Open Font License, Version 1.1"));
        assert!(
            words.contains("PERMISSION & CONDITIONS Permission is hereby granted, free of charge")
        );
    }
}
