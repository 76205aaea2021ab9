//! `cargo xtask stale`: each field of `study.toml`, of a session's record and of each stage's
//! parameters is changed in turn. What a run then leaves as it was must be what a run from nothing
//! makes, byte for byte (apart from the origin of the files).

use anyhow::{Context as _, bail, ensure};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use zwidth_store::file_blake3;

/// The study: the template with few repeats, and with something for every stage.
const STUDY: &str = "stale";
const CHANGES: [(&str, &str); 3] = [
    ("\nrepeats = 6\n", "\nrepeats = 2\n"),
    ("\nrate_hz = 1000.0\n", "\nrate_hz = 120.0\n"),
    (
        "[[modes]]\nid = \"active\"",
        "[[environments]]\nid = \"free\"\nlabel = \"Free\"\nkind = \"free\"\n\n[[modes]]\nid = \"active\"",
    ),
];
/// Words that a field may have besides its own.
const WORDS: [&str; 10] = [
    "landmarks",
    "onset",
    "constrained",
    "williams",
    "difference",
    "second_order",
    "linear",
    "free",
    "spring",
    "none",
];
/// Elements of a list that are changed: the first and the last.
const ENDS: usize = 2;

/// Hash of each file below `derived/` and `reports/` but the records, by its path.
type Hashes = BTreeMap<PathBuf, String>;

/// What came of all changes.
#[derive(Default)]
struct Tally {
    changed: usize,
    refused: usize,
    stale: Vec<String>,
    /// Jobs made again though they came out the same, by field: how many of which stage.
    needless: BTreeMap<String, BTreeMap<String, usize>>,
}

/// Changes every field in turn, or one in so many; fails if any result is stale.
pub(crate) fn stale(program: &Path, scratch: &Path, one_in: usize) -> anyhow::Result<()> {
    ensure!(one_in > 0, "one field in how many? At least 1");
    if scratch.exists() {
        std::fs::remove_dir_all(scratch)?;
    }
    let base = scratch.join("base");
    let study = lay_down(program, &base)?;
    run(program, &base, &[])?;
    let mut tally = Tally::default();
    for (name, text) in toml_changes(&study)?.into_iter().step_by(one_in) {
        one(program, scratch, &format!("study.toml {name}"), "study.toml", &text, &mut tally)?;
    }
    let record = "sessions/P01_S01.json";
    let text = std::fs::read_to_string(base.join("raw").join(STUDY).join(record))?;
    for (name, text) in json_changes(&text)?.into_iter().step_by(one_in) {
        one(program, scratch, &format!("session {name}"), record, &text, &mut tally)?;
    }
    let parameters = parameters(program, scratch)?;
    std::fs::remove_dir_all(scratch)?;
    tell(&tally, parameters)
}

fn tell(tally: &Tally, parameters: usize) -> anyhow::Result<()> {
    for (field, stages) in &tally.needless {
        let stages: Vec<String> = stages.iter().map(|(stage, n)| format!("{n} {stage}")).collect();
        println!("needless: {field}: {}", stages.join(", "));
    }
    tally.stale.iter().for_each(|stale| println!("stale: {stale}"));
    println!(
        "{} fields changed ({} more were refused), {parameters} parameters; {} stale results",
        tally.changed,
        tally.refused,
        tally.stale.len()
    );
    ensure!(tally.stale.is_empty(), "results are stale: a parameter is missing from a job's key");
    Ok(())
}

/// Writes the study and records it with the simulated device; its `study.toml`.
fn lay_down(program: &Path, root: &Path) -> anyhow::Result<toml::Table> {
    let mut text = zwidth_study::template(&STUDY.parse()?);
    for (from, to) in CHANGES {
        ensure!(text.contains(from), "the template of a study lost '{from}'");
        text = text.replace(from, to);
    }
    let study: toml::Table = text.parse()?;
    let folder = root.join("raw").join(STUDY);
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("study.toml"), toml::to_string(&study)?)?;
    let twin = ["--quiet", "twin", STUDY, "--participants", "1", "--sessions", "1", "--seed", "1"];
    let made = Command::new(program).arg("--root").arg(root).args(twin).output()?;
    ensure!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    Ok(study)
}

fn run(program: &Path, root: &Path, options: &[&str]) -> anyhow::Result<Output> {
    let mut command = Command::new(program);
    command.arg("--root").arg(root).args(["--json", "run", "--without-origin"]);
    Ok(command.args(options).arg(STUDY).output()?)
}

/// One change, of a file below `raw/`: a run on what was there, against a run from nothing.
fn one(
    program: &Path,
    scratch: &Path,
    name: &str,
    file: &str,
    text: &str,
    tally: &mut Tally,
) -> anyhow::Result<()> {
    let base = scratch.join("base");
    let again = scratch.join("again");
    let anew = scratch.join("anew");
    for (root, folders) in [(&again, ["raw", "derived", "reports"].as_slice()), (&anew, &["raw"])] {
        if root.exists() {
            std::fs::remove_dir_all(root)?;
        }
        folders.iter().try_for_each(|folder| link(&base.join(folder), &root.join(folder)))?;
        let changed = root.join("raw").join(STUDY).join(file);
        std::fs::remove_file(&changed)?;
        std::fs::write(&changed, text)?;
    }
    let output = run(program, &again, &[])?;
    let fresh = run(program, &anew, &[])?;
    if output.status.code() != fresh.status.code() {
        tally.stale.push(format!("{name}: exit {} and {}", output.status, fresh.status));
        return Ok(());
    }
    if !matches!(output.status.code(), Some(0 | 3)) {
        tally.refused += 1;
        return Ok(());
    }
    tally.changed += 1;
    let now = hashes(&again)?;
    let expected = hashes(&anew)?;
    let paths: BTreeSet<&PathBuf> = now.keys().chain(expected.keys()).collect();
    let differ: Vec<String> = paths
        .into_iter()
        .filter(|path| now.get(*path) != expected.get(*path))
        .map(|path| path.display().to_string())
        .collect();
    if !differ.is_empty() {
        tally.stale.push(format!("{name}: {}", differ.join(", ")));
    }
    let needless = needless(&base, &again, &output)?;
    if !needless.is_empty() {
        tally.needless.insert(name.to_owned(), needless);
    }
    Ok(())
}

/// How many jobs of each stage were made again and came out the same.
fn needless(base: &Path, again: &Path, output: &Output) -> anyhow::Result<BTreeMap<String, usize>> {
    let records = |root: &Path| -> anyhow::Result<Value> {
        let file = root.join("derived").join(STUDY).join("records.json");
        Ok(serde_json::from_slice(&std::fs::read(file)?)?)
    };
    let before = records(base)?;
    let after = records(again)?;
    let said: Value = serde_json::from_slice(&output.stdout)?;
    let mut found = BTreeMap::new();
    let made = said[0]["made"].as_array().context("run --json lists no jobs")?;
    for job in made {
        let name = job["name"].as_str().unwrap_or_default();
        let same = before[name]["outputs"] == after[name]["outputs"];
        if same && before.get(name).is_some() {
            *found.entry(job["stage"].as_str().unwrap_or_default().to_owned()).or_default() += 1;
        }
    }
    Ok(found)
}

/// Changes each parameter in the record of a job of each stage: a run must see it, and name it.
fn parameters(program: &Path, scratch: &Path) -> anyhow::Result<usize> {
    let root = scratch.join("base");
    let file = root.join("derived").join(STUDY).join("records.json");
    let records: BTreeMap<String, Value> = serde_json::from_slice(&std::fs::read(&file)?)?;
    let mut seen = BTreeSet::new();
    let mut changed = 0;
    for (name, record) in &records {
        let stage = record["stage"].as_str().unwrap_or_default();
        let text = record["parameters"].as_str().unwrap_or_default();
        let Ok(parameters) = serde_json::from_str::<Value>(text) else { continue };
        for (field, other) in changes(&parameters) {
            if !seen.insert((stage.to_owned(), without_numbers(&field))) {
                continue;
            }
            let mut records = records.clone();
            let record = records.get_mut(name).context("a record is gone")?;
            record["parameters"] = Value::String(serde_json::to_string(&other)?);
            std::fs::write(&file, serde_json::to_vec(&records)?)?;
            let said: Value = serde_json::from_slice(&run(program, &root, &["--dry-run"])?.stdout)?;
            let made = said[0]["made"].as_array().context("run --json lists no jobs")?;
            let is_named = |job: &Value| {
                job["name"].as_str() == Some(name)
                    && job["why"].as_str().is_some_and(|why| why.contains("parameter"))
            };
            ensure!(made.iter().any(is_named), "{name}: {field} changed, and it is not made again");
            changed += 1;
        }
    }
    Ok(changed)
}

/// A field's name without the places in lists.
fn without_numbers(field: &str) -> String {
    field.chars().filter(|c| !c.is_ascii_digit()).collect()
}

/// Every text of a study with one field changed or left out.
fn toml_changes(study: &toml::Table) -> anyhow::Result<Vec<(String, String)>> {
    let value = serde_json::to_value(study)?;
    let mut texts = Vec::new();
    for (name, other) in changes(&value) {
        if let Ok(text) = toml::to_string(&other) {
            texts.push((name, text));
        }
    }
    Ok(texts)
}

fn json_changes(text: &str) -> anyhow::Result<Vec<(String, String)>> {
    let value: Value = serde_json::from_str(text)?;
    changes(&value)
        .into_iter()
        .map(|(name, other)| Ok((name, serde_json::to_string_pretty(&other)?)))
        .collect()
}

/// The value with each of its fields changed in turn, in every way of [`others`].
fn changes(value: &Value) -> Vec<(String, Value)> {
    match value {
        Value::Object(fields) => {
            let mut found = Vec::new();
            for (key, inner) in fields {
                let put = |inner: Option<Value>| {
                    let mut fields = fields.clone();
                    match inner {
                        Some(inner) => _ = fields.insert(key.clone(), inner),
                        None => _ = fields.remove(key),
                    }
                    Value::Object(fields)
                };
                found.push((format!("{key} left out"), put(None)));
                found.extend(changes(inner).into_iter().map(|(name, inner)| {
                    let dot = if name.starts_with([' ', '[']) { "" } else { "." };
                    (format!("{key}{dot}{name}"), put(Some(inner)))
                }));
            }
            found
        }
        Value::Array(items) => {
            let ends = (0..items.len()).filter(|i| *i < 1 || *i + ENDS > items.len());
            let mut found = Vec::new();
            for i in ends {
                found.extend(changes(&items[i]).into_iter().map(|(name, inner)| {
                    let mut items = items.clone();
                    items[i] = inner;
                    let dot = if name.starts_with([' ', '[']) { "" } else { "." };
                    (format!("[{i}]{dot}{name}"), Value::Array(items))
                }));
            }
            found
        }
        leaf => others(leaf).into_iter().map(|other| (format!(" = {other}"), other)).collect(),
    }
}

/// Other values that a field may have.
fn others(leaf: &Value) -> Vec<Value> {
    match leaf {
        Value::Bool(is) => vec![Value::Bool(!is)],
        Value::Number(n) if n.is_f64() => {
            let x = n.as_f64().unwrap_or_default();
            // No number of a study is its own image, 0.0946….
            vec![Value::from(0.87 * x + 0.0123)]
        }
        Value::Number(n) => vec![Value::from(n.as_i64().unwrap_or_default() + 1)],
        Value::String(text) if WORDS.contains(&text.as_str()) => {
            WORDS.iter().filter(|word| *word != text).map(|word| Value::from(*word)).collect()
        }
        Value::String(text) => vec![Value::from(format!("{text}x"))],
        _ => vec![Value::from("x")],
    }
}

/// The same files under another root, as hard links: results are replaced, never written into.
fn link(from: &Path, to: &Path) -> anyhow::Result<()> {
    if !from.exists() {
        bail!("{} was not made", from.display());
    }
    std::fs::create_dir_all(to)?;
    for entry in std::fs::read_dir(from)? {
        let path = entry?.path();
        let other = to.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            link(&path, &other)?;
        } else {
            std::fs::hard_link(&path, &other)?;
        }
    }
    Ok(())
}

fn hashes(root: &Path) -> anyhow::Result<Hashes> {
    let mut found = Hashes::new();
    let mut folders = vec![root.join("derived"), root.join("reports")];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder)? {
            let path = entry?.path();
            if path.is_dir() {
                folders.push(path);
            } else if !path.ends_with("records.json") {
                found.insert(path.strip_prefix(root)?.to_owned(), file_blake3(&path)?);
            }
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_field_is_changed_and_left_out_once() {
        let value = json!({"a": {"x": 1.0}, "b": [{"on": true}, {"on": false}], "c": "free"});
        let names: Vec<String> = changes(&value).into_iter().map(|(name, _)| name).collect();
        for name in ["a left out", "a.x left out", "b[0].on = false", "b[1].on = true"] {
            assert!(names.iter().any(|n| n == name), "{name}: {names:?}");
        }
        assert_eq!(names.iter().filter(|n| n.starts_with("c = ")).count(), WORDS.len() - 1);
        assert!(changes(&value).iter().all(|(_, other)| *other != value));
    }
}
