//! A folder that cannot be written, and a disk that is full: one clear error, nothing half-written.
//!
//! Both are made in a mount namespace of an unprivileged user (`unshare -Urm`); where the system
//! does not allow one, these tests say so and pass.

use crate::binary::{Ran, binary, ran};
use crate::folders::{files, listing};
use crate::small::{Study, repeats};
use std::fs;
use std::path::Path;
use std::process::Command;
use zwidth_tables::Table;

/// Makes `$1` read-only for what follows.
const READ_ONLY: &str = "mount --bind \"$1\" \"$1\" && mount -o remount,bind,ro \"$1\"";

/// Runs `script` in a mount namespace of its own; `None` where there is none to be had.
fn in_namespace(script: &str, arguments: &[&Path]) -> Option<Ran> {
    let unshare = || {
        let mut command = Command::new("unshare");
        command.args(["-Urm", "sh", "-c"]);
        command
    };
    let possible = unshare().arg("mount -t tmpfs none /tmp").output();
    if !possible.is_ok_and(|o| o.status.success()) {
        println!("skipped: this system gives no mount namespace (unshare -Urm)");
        return None;
    }
    let output = unshare()
        .arg(format!("set -e; {script}"))
        .arg("sh")
        .args(arguments)
        .env_remove("ZWIDTH_ROOT")
        .output();
    Some(ran(&output.unwrap()))
}

/// A recording of `n` samples, as text.
fn recording(n: u32) -> String {
    let rows = (0..n).map(|i| format!("{},{}\n", f64::from(i) * 1e-3, (f64::from(i) * 0.7).sin()));
    "t,f\n".to_owned() + &rows.collect::<String>()
}

const MAP: &str = r#"
kind = "trials"
[trial]
participant = "P07"
session = "S01"
environment = "spring"
mode = "hybrid"
[time]
from = "t"
unit = "s"
[[column]]
to = "force_ex_n"
from = "f"
unit = "N"
"#;

/// A study of three trials, with a mapping and three recordings beside `raw/`.
fn study() -> Study {
    let study = Study::new("disk");
    study.session("P01", &repeats("spring", "hybrid", 1..=3));
    fs::write(study.root().join("map.toml"), MAP).unwrap();
    for (name, rows) in [("a.csv", 20_000), ("b.csv", 20_001), ("c.csv", 20_002)] {
        fs::write(study.root().join(name), recording(rows)).unwrap();
    }
    study
}

#[test]
fn an_import_into_a_read_only_folder_is_one_error() {
    let study = study();
    let before = listing(study.root());
    let script =
        format!("{READ_ONLY}; cd \"$1\"; \"$2\" import disk --map map.toml a.csv b.csv c.csv");
    let Some(ran) = in_namespace(&script, &[study.root(), &binary()]) else { return };
    ran.exits(1).one_error().says(&[
        "raw/disk/",
        "Read-only",
        "nothing was imported",
        "choose another with --root",
    ]);
    assert_eq!(listing(study.root()), before);
}

#[test]
fn a_run_in_a_read_only_folder_is_one_error() {
    let study = study();
    let before = listing(study.root());
    let Some(ran) = in_namespace(
        &format!("{READ_ONLY}; \"$2\" --root \"$1\" run -q"),
        &[study.root(), &binary()],
    ) else {
        return;
    };
    ran.exits(1).one_error().says(&["derived/disk", "Read-only", "choose another with --root"]);
    assert_eq!(listing(study.root()), before);
}

/// Copies the study onto a disk with so much room left, runs `command` there (`$2` is the program),
/// and copies what there is then into the folder that is returned.
fn on_a_small_disk(
    study: &Study,
    room_kib: u32,
    command: &str,
) -> Option<(Ran, tempfile::TempDir)> {
    let (disk, after) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let script = format!(
        "mount -t tmpfs none \"$1\"; cp -r \"$3\"/. \"$1\"; cd \"$1\"; \
         used=$(df -k . | awk 'END {{ print $3 }}'); mount -o remount,size=$((used + {room_kib}))k \"$1\"; \
         code=0; ( {command} ) || code=$?; cp -r \"$1\"/. \"$4\"; exit $code"
    );
    let ran = in_namespace(&script, &[disk.path(), &binary(), study.root(), after.path()])?;
    Some((ran, after))
}

#[test]
fn an_import_onto_a_full_disk_is_one_error_and_takes_back_what_it_wrote() {
    let study = study();
    let before = listing(study.root());
    let import = "\"$2\" import disk --map map.toml a.csv b.csv c.csv";
    // Each of the three trials has 144 kB.
    for (room_kib, words) in [
        (100, "nothing was imported"),
        (200, "the file written before was removed again"),
        (350, "the 2 files written"),
    ] {
        let Some((ran, after)) = on_a_small_disk(&study, room_kib, import) else { return };
        ran.exits(1).one_error().says(&["raw/disk/", "No space left", words, "free some space"]);
        assert_eq!(listing(after.path()), before, "{room_kib} KiB");
    }
}

#[test]
fn a_run_onto_a_full_disk_is_one_error_and_leaves_whole_files_only() {
    let study = study();
    let Some((ran, after)) = on_a_small_disk(&study, 300, "\"$2\" run -q") else { return };
    ran.exits(1).one_error().says(&["No space left", "free some space and run the command again"]);
    assert_eq!(listing(&after.path().join("raw")), study.raw());
    let unfinished = listing(after.path()).into_keys().find(|name| name.ends_with(".tmp"));
    assert_eq!(unfinished, None);
    for path in files(&after.path().join("derived"), "parquet") {
        Table::from_parquet(&path).unwrap();
    }
}

#[test]
fn after_room_was_made_the_same_command_finishes() {
    let study = study();
    // The first run fails on the full disk; the second finds it grown, and makes what is missing.
    let script = "if \"$2\" run -q; then exit 9; fi; mount -o remount,size=64m \"$1\"; \"$2\" run -q >&2; \"$2\" run --json";
    let Some((ran, after)) = on_a_small_disk(&study, 300, script) else { return };
    assert!(ran.exits(0).made().is_empty());
    assert!(after.path().join("reports/disk/summary.md").exists());
    assert_eq!(listing(&after.path().join("raw")), study.raw());
}
