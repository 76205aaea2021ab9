//! Files of the store that are damaged, foreign or misplaced: `verify` finds each, `run` tells it
//! and goes on.

use crate::binary::zwidth;
use crate::folders::{flip_bit, truncate};
use crate::small::{Study, repeats};
use std::fs;
use std::path::Path;
use zwidth_store::{read_parquet, read_sweep, write_parquet};

/// Three trials of one condition, and a sweep.
fn study() -> Study {
    let study = Study::new("files");
    study.session("P01", &repeats("spring", "hybrid", 1..=3));
    study.sweep();
    study
}

/// After `damage` to trial 2, `verify` finds it and `run` leaves it out, both with these words.
#[track_caller]
fn check(damage: impl Fn(&Path), words: &[&str]) {
    let study = study();
    damage(&study.trial("P01", 2));
    let raw = study.raw();
    let words = [words, &["trial-002.parquet"]].concat();
    zwidth(study.root(), &["verify"]).exits(1).prints(&words);
    zwidth(study.root(), &["run", "--only", "metrics"]).exits(3).says(&words);
    assert_eq!(study.derived("metrics").integers("trial").unwrap(), [Some(1), Some(3)]);
    assert_eq!(study.raw(), raw, "verify and run change nothing under raw/");
}

fn length(path: &Path) -> usize {
    fs::metadata(path).unwrap().len() as usize
}

#[test]
fn a_whole_study_has_no_findings() {
    zwidth(study().root(), &["verify"]).exits(0);
}

#[test]
fn a_truncated_trial_is_found_and_left_out() {
    check(|path| truncate(path, 0), &["the file is empty", "restore the file"]);
    let words = ["not a readable Parquet file", "restore the file"];
    check(|path| truncate(path, length(path) / 2), &words);
    check(|path| truncate(path, length(path) - 1), &words);
}

#[test]
fn a_flipped_bit_in_samples_or_footer_is_found_and_left_out() {
    for byte in [60, 200, 1000] {
        check(|path| flip_bit(path, byte), &["restore the file"]);
    }
    let version = |path: &Path| flip_bit(path, find(path, b"force_ex_n") + 2);
    check(version, &["restore the file"]);
}

#[test]
fn no_flipped_bit_of_a_trial_escapes_verify() {
    let study = study();
    let path = study.trial("P01", 2);
    let good = fs::read(&path).unwrap();
    for byte in (0..good.len()).step_by(good.len() / 40) {
        flip_bit(&path, byte);
        let found = zwidth(study.root(), &["verify"]).exits(1);
        assert!(found.out.contains("trial-002.parquet"), "byte {byte}: {found:#?}");
        fs::write(&path, &good).unwrap();
    }
}

#[test]
fn no_flipped_bit_makes_another_sweep_of_a_sweep() {
    let study = study();
    let path = study.sweep_file();
    let (good, sweep) = (fs::read(&path).unwrap(), read_sweep(&path).unwrap());
    for byte in 0..good.len() {
        flip_bit(&path, byte);
        if let Ok(found) = read_sweep(&path) {
            assert_eq!(found, sweep, "byte {byte}");
        }
        fs::write(&path, &good).unwrap();
    }
}

#[test]
fn a_damaged_sweep_is_found_and_told_while_the_trials_are_analysed() {
    let study = study();
    truncate(&study.sweep_file(), 300);
    zwidth(study.root(), &["verify"]).exits(1).prints(&["sweep-01.parquet", "restore the file"]);
    let words = ["left out: ", "sweep-01.parquet", "not a readable Parquet file"];
    zwidth(study.root(), &["run"]).exits(3).says(&words);
    assert!(study.layout().derived().join("metrics.parquet").exists());
}

#[test]
fn a_damaged_table_is_told_with_what_makes_it_again() {
    let study = study();
    let run = || drop(zwidth(study.root(), &["run", "--only", "metrics"]).exits(0));
    run();
    let path = study.layout().derived().join("metrics.parquet");
    let whole = fs::read(&path).unwrap();
    let words = ["metrics.parquet", "remove the file, and `zwidth run` makes it again"];
    for bytes in [0, whole.len() / 2, whole.len() - 1] {
        truncate(&path, bytes);
        zwidth(study.root(), &["table", "files", "metrics"]).exits(1).says(&words);
        fs::remove_file(&path).unwrap();
        run();
        assert_eq!(fs::read(&path).unwrap(), whole);
    }
}

#[test]
fn a_sweep_of_which_the_schema_alone_is_damaged_is_left_out_and_its_actuator_has_no_sweep() {
    let study = study();
    let path = study.sweep_file();
    let mut bytes = fs::read(&path).unwrap();
    let schema = find(&path, b"ARROW:schema");
    bytes[schema + 40] = b'!'; // no sign of base64
    fs::write(&path, bytes).unwrap();
    zwidth(study.root(), &["run"]).exits(3).says(&["left out: ", "sweep-01.parquet"]);
    assert!(!study.layout().derived().join("characterise").exists());
}

/// Where these bytes begin in a file.
fn find(path: &Path, bytes: &[u8]) -> usize {
    let content = fs::read(path).unwrap();
    content.windows(bytes.len()).position(|w| w == bytes).unwrap()
}

#[test]
fn an_unknown_schema_version_is_refused_by_its_number() {
    let version = |path: &Path| {
        // The value follows its key after two bytes: the type of the field, and its length.
        let at = find(path, b"schema_version") + "schema_version".len() + 2;
        let mut bytes = fs::read(path).unwrap();
        assert_eq!(bytes[at], b'2');
        bytes[at] = b'9';
        fs::write(path, bytes).unwrap();
    };
    check(
        version,
        &["schema version 9 is unknown", "sweeps of version 1 and trials of versions 2 and 3"],
    );
}

#[test]
fn a_parquet_file_without_rows_and_one_of_a_stranger_are_refused() {
    let empty = |path: &Path| {
        let (batch, footer) = read_parquet(path).unwrap();
        fs::write(path, write_parquet(&batch.slice(0, 0), footer, path).unwrap()).unwrap();
    };
    check(empty, &["the file has 0 rows"]);
    let stranger = |path: &Path| {
        let (batch, mut footer) = read_parquet(path).unwrap();
        footer.retain(|key, _| key != "kind");
        fs::write(path, write_parquet(&batch, footer, path).unwrap()).unwrap();
    };
    check(stranger, &["its metadata 'kind' are missing", "restore the file"]);
}

#[test]
fn a_trial_without_one_of_its_columns_is_refused() {
    let without = |path: &Path| {
        let (mut batch, footer) = read_parquet(path).unwrap();
        let place = batch.schema().index_of("theta_rad").unwrap();
        batch.remove_column(place);
        fs::write(path, write_parquet(&batch, footer, path).unwrap()).unwrap();
    };
    check(without, &["column theta_rad", "the column is missing", "zwidth import"]);
}

#[test]
fn a_trial_that_lies_twice_or_in_the_wrong_place_is_found() {
    let study = study();
    let copy = study.trial("P01", 9);
    fs::copy(study.trial("P01", 2), &copy).unwrap();
    let words = ["trial-009.parquet", "trial 2 by its footer", "a trial must not exist twice"];
    zwidth(study.root(), &["verify"]).exits(1).prints(&words);
    zwidth(study.root(), &["run", "--only", "metrics"]).exits(3).says(&words);
    assert_eq!(study.derived("metrics").height(), 3);
}

#[test]
fn verify_lists_every_finding_and_not_only_the_first() {
    let study = study();
    truncate(&study.trial("P01", 1), 50);
    flip_bit(&study.trial("P01", 3), 60);
    fs::write(study.trial("P01", 2).with_file_name("notes.txt"), "a note").unwrap();
    let found = zwidth(study.root(), &["verify", "--json"]).exits(1).json();
    let files: Vec<_> =
        found.as_array().unwrap().iter().map(|f| f["file"].as_str().unwrap().to_owned()).collect();
    for name in ["trial-001.parquet", "trial-003.parquet", "notes.txt"] {
        assert_eq!(files.iter().filter(|f| f.ends_with(name)).count(), 1, "{name} in {found:#}");
    }
}

#[cfg(unix)]
#[test]
fn a_pipe_a_device_or_a_link_is_no_scene_no_calibration_and_no_twin_and_nobody_waits_for_it() {
    use std::os::unix::fs::symlink;
    let study = study();
    let pipe = study.root().join("pipe.toml");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    symlink("/dev/zero", study.root().join("zero.toml")).unwrap();
    for scene in ["pipe.toml", "zero.toml"] {
        let path = study.root().join(scene);
        let words = [scene, "is a pipe, socket or device"];
        zwidth(study.root(), &["simulate", path.to_str().unwrap()]).exits(1).says(&words);
    }
    for name in ["calibration.toml", "twin.toml"] {
        let path = study.layout().raw().join(name);
        for target in ["/dev/zero", "nowhere"] {
            symlink(target, &path).unwrap();
            let checked = zwidth(study.root(), &["check", "files", "--fast"]).exits(1);
            checked.one_error().says(&[name, "cannot read"]);
            fs::remove_file(&path).unwrap();
        }
    }
}
