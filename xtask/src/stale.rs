//! `cargo xtask stale`: each field of `study.toml`, of a session's record and of each stage's
//! parameters is changed in turn. What a run then leaves as it was must be what a run from nothing
//! makes, byte for byte (apart from the origin of the files).

use crate::shell::{hashed, lay_down, program, remove, scratch};
use crate::soak::changed;
use anyhow::{Context as _, ensure};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::{Command, Output};

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
const WORDS: &str =
    "landmarks onset constrained williams difference second_order linear free spring none";
/// Elements of a list that are changed: the first and the last.
const ENDS: usize = 2;

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
pub(crate) fn stale(one_in: usize) -> anyhow::Result<()> {
    ensure!(one_in > 0, "one field in how many? At least 1");
    let program = &program()?;
    let scratch = &scratch("stale");
    remove(scratch)?;
    let base = scratch.join("base");
    let study = recorded(program, &base)?;
    run(program, &base, &[])?;
    let mut tally = Tally::default();
    // A change that TOML cannot say is none.
    let changed = changes(&serde_json::to_value(&study)?);
    let texts =
        changed.into_iter().filter_map(|(name, to)| Some((name, toml::to_string(&to).ok()?)));
    for (name, text) in texts.step_by(one_in) {
        one(program, scratch, &format!("study.toml {name}"), "study.toml", &text, &mut tally)?;
    }
    let record = "sessions/P01_S01.json";
    let text = std::fs::read(base.join("raw").join(STUDY).join(record))?;
    for (name, to) in changes(&serde_json::from_slice(&text)?).into_iter().step_by(one_in) {
        let text = serde_json::to_string_pretty(&to)?;
        one(program, scratch, &format!("session {name}"), record, &text, &mut tally)?;
    }
    let parameters = parameters(program, scratch)?;
    std::fs::remove_dir_all(scratch)?;
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
fn recorded(program: &Path, root: &Path) -> anyhow::Result<toml::Table> {
    let text = changed(zwidth_study::template(&STUDY.parse()?), &CHANGES)?;
    let study: toml::Table = text.parse()?;
    let folder = root.join("raw").join(STUDY);
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("study.toml"), toml::to_string(&study)?)?;
    let twin = format!("--quiet twin {STUDY} --participants 1 --sessions 1 --seed 1");
    let made = Command::new(program).arg("--root").arg(root).args(twin.split(' ')).output()?;
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
        remove(root)?;
        // Hard links: results are replaced, never written into.
        for folder in folders {
            let from = base.join(folder);
            lay_down(&from, &root.join(folder), std::fs::hard_link)
                .with_context(|| format!("{} was not made", from.display()))?;
        }
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
    let (now, expected) = (hashed(&again)?, hashed(&anew)?);
    let paths: BTreeSet<&String> = now.keys().chain(expected.keys()).collect();
    let results = paths.into_iter().filter(|path| !path.ends_with("/records.json"));
    let differ = results.filter(|path| now.get(*path) != expected.get(*path));
    let differ: Vec<&str> = differ.map(String::as_str).collect();
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

/// The value with each of its fields changed in turn, in every way of [`others`].
fn changes(value: &Value) -> Vec<(String, Value)> {
    let dot = |name: &str| if name.starts_with([' ', '[']) { "" } else { "." };
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
                found.extend(
                    changes(inner).into_iter().map(|(name, inner)| {
                        (format!("{key}{}{name}", dot(&name)), put(Some(inner)))
                    }),
                );
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
                    (format!("[{i}]{}{name}", dot(&name)), Value::Array(items))
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
        Value::String(text) if WORDS.split(' ').any(|word| word == text) => {
            WORDS.split(' ').filter(|word| *word != text).map(Value::from).collect()
        }
        Value::String(text) => vec![Value::from(format!("{text}x"))],
        _ => vec![Value::from("x")],
    }
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
        let words = WORDS.split(' ').count();
        assert_eq!(names.iter().filter(|n| n.starts_with("c = ")).count(), words - 1);
        assert!(changes(&value).iter().all(|(_, other)| *other != value));
    }
}
