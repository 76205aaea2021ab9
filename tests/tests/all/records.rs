//! What `derived/<study>/records.json` names is not believed: a run writes and removes below the
//! study's own two folders alone, and takes away nothing but what an earlier run made.

use crate::binary::{Ran, zwidth};
use crate::folders::listing;
use crate::small::{Study, repeats};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use zwidth_store::file_blake3;

/// A study that was run, a second study's results beside it, and a folder outside of the data.
struct World {
    study: Study,
    outside: tempfile::TempDir,
}

impl World {
    fn new() -> Self {
        let study = Study::new("ours");
        study.session("P01", &repeats("spring", "hybrid", 1..=3));
        zwidth(study.root(), &["run"]).exits(0);
        let theirs = study.root().join("derived/theirs");
        fs::create_dir_all(&theirs).unwrap();
        fs::write(theirs.join("a.parquet"), "a result of theirs").unwrap();
        let outside = tempfile::tempdir().unwrap();
        fs::write(outside.path().join("thesis.tex"), "a year's work").unwrap();
        Self { study, outside }
    }

    fn root(&self) -> &Path {
        self.study.root()
    }

    fn records(&self) -> PathBuf {
        self.root().join("derived/ours/records.json")
    }

    /// Everything but what a run may write: raw data, the other study, what lies outside.
    fn others(&self) -> [BTreeMap<String, String>; 3] {
        [
            self.study.raw(),
            listing(&self.root().join("derived/theirs")),
            listing(self.outside.path()),
        ]
    }

    /// Adds the record of a job that is no longer planned, with an output of that name and content.
    fn add_record(&self, path: &str, blake3: &str) {
        let mut records: Value =
            serde_json::from_slice(&fs::read(self.records()).unwrap()).unwrap();
        records["figure of before"] = json!({
            "stage": "figures", "version": 1, "parameters": "", "inputs": {}, "outputs": { path: blake3 },
            "problems": [], "origin": ""
        });
        fs::write(self.records(), records.to_string()).unwrap();
    }

    fn run(&self) -> Ran {
        zwidth(self.root(), &["run", "ours"])
    }
}

/// A record that names `path`, with the very hash of `file`, removes nothing and is told; the run
/// is done all the same.
#[track_caller]
fn check(path: impl Fn(&World) -> String, file: impl Fn(&World) -> PathBuf) {
    let world = World::new();
    let (path, file) = (path(&world), file(&world));
    world.add_record(&path, &file_blake3(&file).unwrap());
    let (before, results) = (world.others(), listing(&world.root().join("reports")));
    let words = [
        "read with care: ",
        "records.json",
        "figure of before",
        "is ignored",
        "find out what wrote the record",
    ];
    world.run().exits(3).says(&words).says(&[&path]);
    assert_eq!(world.others(), before, "{path}");
    assert_eq!(listing(&world.root().join("reports")), results, "{path}");
    // The record is gone from the records, and so is the remark.
    world.run().exits(0);
}

#[test]
fn a_record_with_an_absolute_path_removes_nothing() {
    let file = |world: &World| world.outside.path().join("thesis.tex");
    check(|world| file(world).to_str().unwrap().to_owned(), file);
}

#[test]
fn a_record_that_names_a_raw_file_or_the_study_removes_nothing() {
    check(|_| "raw/ours/study.toml".to_owned(), |world| world.study.layout().study_toml());
    let trial = "raw/ours/trials/participant=P01/session=S01/trial-002.parquet";
    check(|_| trial.to_owned(), |world| world.study.trial("P01", 2));
    let log = "derived/ours/../../raw/ours/sessions/P01_S01.events.jsonl";
    check(|_| log.to_owned(), |world| world.study.events("P01"));
}

#[test]
fn a_record_that_leads_up_and_out_removes_nothing() {
    let file = |world: &World| world.outside.path().join("thesis.tex");
    let up = |world: &World| {
        let name = world.outside.path().file_name().unwrap().to_str().unwrap().to_owned();
        format!("derived/ours/../../../{name}/thesis.tex")
    };
    check(up, file);
}

#[test]
fn a_record_that_names_a_result_of_another_study_removes_nothing() {
    let file = |world: &World| world.root().join("derived/theirs/a.parquet");
    check(|_| "derived/theirs/a.parquet".to_owned(), file);
}

#[cfg(unix)]
#[test]
fn a_link_on_the_way_to_what_a_record_names_is_not_followed() {
    let world = World::new();
    std::os::unix::fs::symlink(world.outside.path(), world.root().join("reports/ours/linked"))
        .unwrap();
    let hash = file_blake3(&world.outside.path().join("thesis.tex")).unwrap();
    world.add_record("reports/ours/linked/thesis.tex", &hash);
    let before = world.others();
    world.run().exits(3).says(&["read with care: ", "reports/ours/linked: it is a link"]);
    assert_eq!(world.others(), before);
}

#[cfg(unix)]
#[test]
fn a_results_folder_that_is_a_link_is_refused_before_anything_is_written_through_it() {
    for folder in ["derived/ours", "reports/ours/figures", "reports"] {
        let world = World::new();
        let folder = world.root().join(folder);
        fs::remove_dir_all(&folder).unwrap();
        std::os::unix::fs::symlink(world.outside.path(), &folder).unwrap();
        let before = world.others();
        let ran = zwidth(world.root(), &["--quiet", "run", "ours"]).exits(1).one_error();
        ran.says(&["it is a link", "name that with --root"]);
        assert_eq!(world.others(), before);
    }
}

#[test]
fn what_an_earlier_run_made_is_removed_and_what_a_person_changed_since_stays() {
    let world = World::new();
    let made = world.root().join("reports/ours/figures/old.svg");
    fs::write(&made, "made").unwrap();
    let hash = file_blake3(&made).unwrap();
    world.add_record("reports/ours/figures/old.svg", &hash);
    fs::write(&made, "made, and drawn over by hand").unwrap();
    world.run().exits(3).says(&["old.svg", "was changed since it was made, and so it stays"]);
    assert!(made.exists());
    world.add_record("reports/ours/figures/old.svg", &file_blake3(&made).unwrap());
    world.run().exits(0);
    assert!(!made.exists(), "what is as it was made goes");
}

#[test]
fn records_with_a_repeated_key_are_not_believed_and_everything_is_made_again() {
    let world = World::new();
    let text = fs::read_to_string(world.records()).unwrap();
    let twice = text.replacen("\"stage\":", "\"stage\":\"x\",\"stage\":", 1);
    fs::write(world.records(), twice).unwrap();
    let results = listing(&world.root().join("reports"));
    world.run().exits(3).says(&[
        "records.json",
        "\"stage\" stands twice",
        "everything is made again",
    ]);
    assert_eq!(fs::read_to_string(world.records()).unwrap(), text);
    assert_eq!(listing(&world.root().join("reports")), results);
}

#[test]
fn records_of_thirty_thousand_keys_are_read_and_those_that_go_down_for_ever_are_not() {
    let world = World::new();
    let text = fs::read_to_string(world.records()).unwrap();
    let many: BTreeMap<String, u32> = (0..30_000).map(|i| (i.to_string(), i)).collect();
    for bad in [serde_json::to_string(&many).unwrap(), "{\"a\":".repeat(100_000)] {
        fs::write(world.records(), bad).unwrap();
        world.run().exits(3).says(&["everything is made again"]);
        assert_eq!(fs::read_to_string(world.records()).unwrap(), text);
    }
}

#[test]
fn half_written_files_of_runs_that_were_cut_short_are_swept_and_nothing_else_is() {
    let world = World::new();
    let at = |path: &str| world.root().join(path);
    let litter = [
        "derived/ours/.metrics.parquet.4000000000.tmp",
        "reports/ours/figures/.a.svg.4000000000.tmp",
    ];
    let kept = [
        "derived/theirs/.a.parquet.4000000000.tmp",
        "reports/ours/notes.tmp",
        "raw/ours/.study.toml.4000000000.tmp",
    ];
    litter.iter().chain(&kept).for_each(|path| fs::write(at(path), "half").unwrap());
    // In raw/ it is `recover` that sweeps; a run tells of it.
    world.run().exits(3).says(&["left out: ", ".study.toml.4000000000.tmp", "zwidth recover ours"]);
    assert!(
        litter.iter().all(|path| !at(path).exists()) && kept.iter().all(|path| at(path).exists())
    );
    zwidth(world.root(), &["recover", "ours"]).exits(0);
    world.run().exits(0);
}
