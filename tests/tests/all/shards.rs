//! Shards: shared out, merged and run is the same bytes as a run on one machine; a dead shard is
//! found and made again alone; one from other inputs or another version is refused by name.

use crate::binary::{Ran, binary, ran, zwidth};
use crate::folders::{copy, files, listing};
use crate::shipped;
use crate::small::{Study, draft, repeats};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

const STUDY: &str = "thesis-twin";

/// Everything that a run made.
fn results(root: &Path) -> [BTreeMap<String, String>; 2] {
    [listing(&root.join("derived").join(STUDY)), listing(&root.join("reports").join(STUDY))]
}

/// Makes all tables of trials that shards have left, and says what that took.
fn run_tables(root: &Path) -> Vec<String> {
    let stages = ["average", "metrics", "replay"];
    let made = |stage| zwidth(root, &["run", STUDY, "--only", stage, "--json"]).exits(0).made();
    stages.into_iter().flat_map(made).collect()
}

/// Holds the tables of trials, byte for byte, against those of a run on one machine.
fn compare_tables(root: &Path) {
    let tables = |root: &Path| {
        let mut all = listing(&root.join("derived").join(STUDY));
        let parts = ["average", "metrics", "replay", "courses", "identify", "conditions"];
        all.retain(|path, _| parts.iter().any(|part| path.starts_with(part)));
        all
    };
    let whole = tables(shipped::folder());
    assert!(whole.len() > 40, "{whole:#?}");
    assert_eq!(tables(root), whole);
    assert!(!root.join("derived").join(STUDY).join("shards").exists());
}

fn shard(root: &Path, shard: &str) -> Ran {
    zwidth(root, &["--threads", "1", "run", STUDY, "--shard", shard, "--json"])
}

fn manifest(root: &Path, name: &str) -> PathBuf {
    root.join("derived").join(STUDY).join("shards").join(format!("{name}.json"))
}

/// Jobs of which a shard makes one for each condition or environment of a session.
fn is_of_a_part(name: &str) -> bool {
    ["metrics P01", "average P01", "replay P01", "courses P01"].iter().any(|p| name.starts_with(p))
}

/// Runs all shards, at most so many at a time.
fn all_shards(root: &Path, of: usize, at_a_time: usize) {
    let numbers: Vec<usize> = (1..=of).collect();
    for some in numbers.chunks(at_a_time) {
        let spawn = |number: &usize| {
            let mut command = Command::new(binary());
            command.arg("--root").arg(root).args(["--threads", "1", "--quiet", "run", STUDY]);
            command.args(["--shard", &format!("{number}/{of}")]).env_remove("ZWIDTH_ROOT");
            command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
        };
        let running: Vec<_> = some.iter().map(spawn).collect();
        for child in running {
            let done = ran(&child.wait_with_output().unwrap()).exits(0);
            assert_eq!(done.err, "");
        }
    }
}

#[test]
fn shared_out_merged_and_run_is_the_same_bytes_as_one_run() {
    for (of, at_a_time) in [(1, 1), (2, 2), (7, 7), (64, 4)] {
        let root = shipped::raw();
        all_shards(root.path(), of, at_a_time);
        let manifests = files(&root.path().join("derived"), "json");
        assert_eq!(manifests.len(), of, "a manifest each, and no records");
        let missing = zwidth(root.path(), &["shards", STUDY, "--missing"]).exits(0);
        assert_eq!(missing.out, "", "of {of}");
        let early = zwidth(root.path(), &["run", STUDY, "--dry-run", "--only", "average"]).exits(0);
        early.says(&[&format!("{of} shard"), "not merged", "zwidth merge"]);
        let merged = zwidth(root.path(), &["merge", STUDY, "--json"]).exits(0).json();
        assert_eq!((&merged["copied"], &merged["jobs"]), (&0.into(), &13.into()), "{merged}");
        // What needs the plant, which all trials give, is not of the first round.
        let made = run_tables(root.path());
        let again: Vec<&String> = made.iter().filter(|name| is_of_a_part(name)).collect();
        let late = |n: &&String| {
            n.contains("with the plant") || n.contains("fitted") || n.starts_with("courses")
        };
        assert!(again.len() == 9 && again.iter().all(late), "{again:#?}");
        compare_tables(root.path());
    }
}

#[test]
fn a_second_round_makes_what_rests_on_all_trials_and_then_nothing_of_trials_is_left() {
    let root = shipped::raw();
    let round = || {
        all_shards(root.path(), 3, 3);
        zwidth(root.path(), &["merge", STUDY, "--json"]).exits(0).json()["jobs"].as_u64().unwrap()
    };
    assert_eq!(round(), 13);
    zwidth(root.path(), &["run", STUDY, "--only", "identify"]).exits(0);
    let missing = zwidth(root.path(), &["shards", STUDY, "--missing", "--of", "3", "--json"]);
    let missing = missing.exits(3).json();
    let names: Vec<&str> = (missing.as_array().unwrap().iter())
        .flat_map(|shard| shard["missing"].as_array().unwrap())
        .map(|name| name.as_str().unwrap())
        .collect();
    assert!(names.len() == 9 && names.iter().all(|n| is_of_a_part(n)), "{names:?}");
    assert_eq!(round(), 22, "with those of the first");
    let made = zwidth(root.path(), &["run", STUDY, "--json"]).exits(0).made();
    assert!(!made.iter().any(|name| is_of_a_part(name)), "{made:#?}");
    assert_eq!(results(root.path()), results(shipped::folder()), "records and figures, too");
}

#[test]
fn shards_made_in_folders_of_their_own_are_merged_from_there_and_stay_as_they_are() {
    let root = shipped::raw();
    let elsewhere: Vec<TempDir> = (1..=2).map(|_| shipped::raw()).collect();
    shard(elsewhere[0].path(), "1/2").exits(0);
    shard(elsewhere[1].path(), "2/2").exits(0);
    let before: Vec<_> = elsewhere.iter().map(|folder| listing(folder.path())).collect();
    let from = [elsewhere[0].path().to_str().unwrap(), elsewhere[1].path().to_str().unwrap()];
    let half = ["shards", STUDY, "--missing", "--from", from[0]];
    assert!(zwidth(root.path(), &half).exits(3).out.starts_with("2/2  "));
    let merge = ["merge", STUDY, "--json", "--from", from[0], from[1]];
    let merged = zwidth(root.path(), &merge).exits(0).json();
    assert_eq!(merged["jobs"], 13, "{merged}");
    assert!(merged["copied"].as_u64().unwrap() > 13, "{merged}");
    assert_eq!(elsewhere.iter().map(|f| listing(f.path())).collect::<Vec<_>>(), before);
    run_tables(root.path());
    compare_tables(root.path());
}

#[test]
fn a_folder_that_is_named_twice_has_its_shards_once_and_one_without_manifests_is_refused() {
    let (root, other) = (shipped::raw(), shipped::raw());
    shard(root.path(), "1/1").exits(0);
    shard(other.path(), "1/1").exits(0);
    let (own, from) = (root.path().to_str().unwrap(), other.path().to_str().unwrap());
    let twice = format!("{from}/.");
    let merge = ["merge", STUDY, "--json", "--from", own, from, &twice];
    let merged = zwidth(root.path(), &merge).exits(0).json();
    assert_eq!((&merged["jobs"], &merged["merged"]), (&13.into(), &serde_json::json!(["1/1"])));
    // Its manifests are gone: they were merged.
    let third = shipped::raw();
    let again = zwidth(third.path(), &["merge", STUDY, "--from", own]).exits(1).one_error();
    again.says(&["there are no shards of thesis-twin in", "after a merge there", "--shard I/N"]);
}

#[test]
fn a_shard_that_died_is_found_and_made_again_alone() {
    let root = shipped::raw();
    let mut command = Command::new(binary());
    command.arg("--root").arg(root.path()).args(["--threads", "1", "run", STUDY, "--shard", "1/1"]);
    command.env_remove("ZWIDTH_ROOT").stdout(Stdio::null()).stderr(Stdio::null());
    let mut killed = command.spawn().unwrap();
    let derived = root.path().join("derived");
    // Killed as soon as it has made something.
    while files(&derived, "parquet").is_empty() && killed.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    let missing = zwidth(root.path(), &["shards", STUDY, "--missing", "--of", "1"]).exits(3);
    assert!(
        missing.out.starts_with("1/1  ") && missing.out.contains("are missing"),
        "{missing:#?}"
    );
    let merged = zwidth(root.path(), &["merge", STUDY]).exits(3);
    assert!(merged.out.contains("no shard") || merged.err.contains("1/1  "), "{merged:#?}");
    shard(root.path(), "1/1").exits(0);
    zwidth(root.path(), &["merge", STUDY]).exits(0);
    run_tables(root.path());
    compare_tables(root.path());
}

#[test]
fn of_many_shards_the_one_that_is_missing_is_named_and_made_alone() {
    let root = shipped::raw();
    for number in ["1/3", "2/3", "3/3"] {
        shard(root.path(), number).exits(0);
    }
    let all = zwidth(root.path(), &["shards", STUDY, "--json"]).exits(0).json();
    let largest = all.as_array().unwrap().iter().max_by_key(|s| s["jobs"].as_u64()).unwrap();
    let dead = largest["shard"].as_str().unwrap();
    let name = dead.replace('/', "-of-");
    fs::remove_file(manifest(root.path(), &name)).unwrap();
    let missing = zwidth(root.path(), &["shards", STUDY, "--missing"]).exits(3);
    assert_eq!(missing.out.lines().count(), 1, "{missing:#?}");
    assert!(missing.out.starts_with(&format!("{dead}  ")), "{missing:#?}");
    // What is there is merged; what is missing is told.
    let merged = zwidth(root.path(), &["merge", STUDY]).exits(3).says(&[dead, "are missing"]);
    assert!(merged.out.contains("2 shards merged"), "{merged:#?}");
    shard(root.path(), dead).exits(0);
    zwidth(root.path(), &["merge", STUDY]).exits(0);
    let made = zwidth(root.path(), &["run", STUDY, "--json", "--only", "average"]).exits(0).made();
    assert!(made.is_empty(), "{made:?}");
}

/// A study of two conditions whose spring gives this force.
fn study(force_n: f64) -> Study {
    let study = Study::new("demo");
    let mut drafts = repeats("spring", "hybrid", 1..=2);
    drafts.extend((3..=4).map(|n| draft(n, "spring", "active")));
    drafts.iter_mut().for_each(|draft| draft.force_n = Some(force_n));
    study.session("P01", &drafts);
    study
}

#[test]
fn a_shard_from_other_inputs_or_parameters_is_refused_by_name() {
    let (ours, theirs) = (study(1.0), study(2.0));
    // Such a force is read with care.
    zwidth(theirs.root(), &["run", "demo", "--shard", "1/1"]).exits(3);
    let from = theirs.root().to_str().unwrap();
    let before = listing(ours.root());
    let merge = ["merge", "demo", "--from", from];
    let refused = zwidth(ours.root(), &merge).exits(1);
    let rerun = format!("zwidth --root {from} run demo --shard 1/1");
    let words =
        ["shard 1/1 is refused", "from other inputs", "raw/demo/trials/", "1-of-1.json", &rerun];
    let refused = refused.says(&words);
    assert_eq!(refused.err.matches("error: ").count(), 1, "{refused:#?}");
    let after = listing(ours.root());
    let made: Vec<_> = after.keys().filter(|path| !before.contains_key(*path)).collect();
    assert!(made.iter().all(|path| after[*path].is_empty()), "no file: {made:?}");
    // The same inputs, analysed otherwise.
    let other = study(1.0);
    let toml = other.layout().study_toml();
    let text = fs::read_to_string(&toml).unwrap();
    fs::write(&toml, text.replace("onset_deg_s = 10.0", "onset_deg_s = 11.0")).unwrap();
    zwidth(other.root(), &["run", "demo", "--shard", "1/1"]).exits(3);
    let from = other.root().to_str().unwrap();
    let refused = zwidth(ours.root(), &["merge", "demo", "--from", from]).exits(1);
    refused.says(&["shard 1/1 is refused", "with other parameters", "onset"]);
}

#[test]
fn a_shard_of_another_version_and_a_damaged_manifest_are_refused_and_the_others_merged() {
    let root = shipped::raw();
    shard(root.path(), "1/2").exits(0);
    shard(root.path(), "2/2").exits(0);
    let path = manifest(root.path(), "1-of-2");
    let text = fs::read_to_string(&path).unwrap();
    let program = format!("\"zwidth\":\"{}\"", env!("CARGO_PKG_VERSION"));
    let stage = text.split_once("\"version\":").unwrap().1.split_once(',').unwrap().0;
    let result = files(&root.path().join("derived").join(STUDY).join("average"), "parquet");
    let hash = zwidth_store::file_blake3(&result[0]).unwrap();
    for (damaged, words) in [
        (text.replace(&program, "\"zwidth\":\"0.0.9\""), "zwidth \"0.0.9\" made it"),
        (
            text.replace(&format!("\"version\":{stage},"), "\"version\":999,"),
            "by another version: algorithm version 999 is now",
        ),
        (text[..text.len() / 2].to_owned(), "its manifest is damaged"),
        (String::new(), "its manifest is damaged"),
        (text.replace("derived/thesis-twin/", "derived/../raw/"), "its manifest is damaged"),
    ] {
        let tried = shipped::raw();
        copy(&root.path().join("derived"), &tried.path().join("derived"));
        fs::write(manifest(tried.path(), "1-of-2"), &damaged).unwrap();
        let merged = zwidth(tried.path(), &["merge", STUDY]).exits(3);
        let errors: Vec<&str> = merged.err.lines().filter(|l| l.starts_with("error: ")).collect();
        let [error] = errors.as_slice() else { panic!("{merged:#?}") };
        let run_again = " run thesis-twin --shard 1/2`";
        for word in ["shard 1/2 is refused", "1-of-2.json", words, run_again] {
            assert!(error.contains(word), "{word}: {error}");
        }
        assert!(merged.out.contains("1 shard merged"), "{merged:#?}");
        // Run again alone it is written anew, and merged.
        let again = shard(tried.path(), "1/2");
        assert!(matches!(again.code, Some(0 | 3)), "{again:#?}");
        zwidth(tried.path(), &["merge", STUDY]).exits(0);
    }
    // A result that is no longer what the shard made.
    let (own, other) = if text.contains(&hash) { ("1/2", "2/2") } else { ("2/2", "1/2") };
    fs::write(&result[0], "another").unwrap();
    let merged = zwidth(root.path(), &["merge", STUDY]).exits(3);
    let words = [format!("shard {own} is refused"), "is not the one it made".to_owned()];
    assert!(words.iter().all(|word| merged.err.contains(word)), "{merged:#?}");
    assert!(!merged.err.contains(&format!("shard {other} is refused")), "{merged:#?}");
}

#[test]
fn what_no_shard_can_be_is_refused_before_anything_is_made() {
    let root = shipped::raw();
    let before = listing(root.path());
    for bad in ["0/7", "8/7", "7", "a/b", "1/0", "-1/3"] {
        zwidth(root.path(), &["run", STUDY, &format!("--shard={bad}")]).exits(2).says(&["3/7"]);
    }
    zwidth(root.path(), &["run", STUDY, "--shard", "1/2", "--only", "metrics"]).exits(2);
    zwidth(root.path(), &["shards", STUDY, "--of", "0"]).exits(2);
    for command in ["merge", "shards"] {
        let nowhere = zwidth(root.path(), &[command, STUDY, "--from", "/nowhere"]);
        nowhere.exits(1).one_error().says(&["there are no shards of thesis-twin in /nowhere"]);
        zwidth(root.path(), &[command, "none"]).exits(1).one_error().says(&["no study 'none'"]);
    }
    assert_eq!(listing(root.path()), before);
}
