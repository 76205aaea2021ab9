//! How a run goes: the same bytes whatever the folder and the threads, its lines, `--only`,
//! `--dry-run`, `--fresh`, and the choices of study.toml for figures.

use crate::binary::{binary, ran, zwidth, zwidth_line};
use crate::folders::{copy, listing};
use crate::provenance::{FIGURE, only};
use crate::shipped;
use crate::small::{Study, repeats};
use std::fs;
use std::path::Path;
use std::process::Command;
use zwidth_store::file_blake3;

#[test]
fn the_whole_tree_is_the_same_bytes_from_any_folder_on_any_number_of_threads() {
    let study = Study::new("demo");
    study.session("P01", &repeats("spring", "hybrid", 1..=3));
    study.session("P02", &repeats("spring_wall", "active", 1..=3));
    study.sweep();
    let results = |root: &Path| [listing(&root.join("derived")), listing(&root.join("reports"))];
    zwidth(study.root(), &["--threads", "1", "run"]).exits(0);
    let first = results(study.root());
    assert!(first.iter().all(|l| l.len() > 10), "{first:#?}");
    for threads in ["2", "7"] {
        let elsewhere = tempfile::tempdir().unwrap();
        let other = elsewhere.path().join("a folder with another, longer name");
        copy(&study.root().join("raw"), &other.join("raw"));
        let mut command = Command::new(binary());
        command.args(["--threads", threads, "run"]).current_dir(&other).env_remove("ZWIDTH_ROOT");
        ran(&command.output().unwrap()).exits(0);
        assert_eq!(results(&other), first, "{threads} threads");
        // In pieces, in another order, and again: the same.
        fs::remove_dir_all(other.join("reports")).unwrap();
        zwidth(&other, &["--threads", threads, "run", "--only", "figures"]).exits(0);
        zwidth(&other, &["--threads", threads, "run"]).exits(0);
        zwidth(&other, &["--threads", threads, "run", "--fresh"]).exits(0);
        assert_eq!(results(&other), first, "{threads} threads, again");
    }
}

#[test]
fn a_pipe_gets_plain_lines_one_a_stage_and_quiet_people_none() {
    let study = Study::new("demo");
    study.session("P01", &repeats("spring", "hybrid", 1..=3));
    let run = zwidth(study.root(), &["run"]).exits(0);
    assert!(!run.err.contains('\u{1b}') && !run.err.contains('\r'), "{run:#?}");
    let stages: Vec<&str> =
        run.err.lines().filter_map(|line| line.split_whitespace().next()).collect();
    // Without a calibration nothing can be replayed.
    let expect =
        ["metrics", "average", "trade", "trials", "figures", "report", "tables", "summary", "page"];
    assert_eq!(stages, expect);
    let quiet = zwidth(study.root(), &["--quiet", "run", "--fresh"]).exits(0);
    assert_eq!((quiet.err.as_str(), quiet.out.lines().count()), ("", 2), "{quiet:#?}");
}

/// A part of them is done, and of none of them nothing.
#[test]
fn of_several_studies_that_all_fail_a_run_fails_and_where_one_goes_on_it_is_done_in_part() {
    let study = Study::new("demo");
    study.session("P01", &repeats("spring", "hybrid", 1..=3));
    let bad = |name: &str| {
        let folder = study.root().join("raw").join(name);
        fs::create_dir_all(&folder).unwrap();
        fs::write(folder.join("study.toml"), "no study").unwrap();
    };
    ["bad", "worse"].into_iter().for_each(bad);
    zwidth(study.root(), &["run", "bad", "worse"]).exits(1).says(&["raw/bad", "raw/worse"]);
    zwidth(study.root(), &["run", "--only", "metrics"]).exits(3).says(&["raw/bad", "raw/worse"]);
    assert!(study.layout().derived().join("metrics.parquet").exists());
}

/// A full disk behind `>`: what a script reads would be cut off, and it would not know.
#[test]
#[cfg(target_os = "linux")]
fn results_that_cannot_be_printed_are_an_error_and_a_reader_that_went_away_is_none() {
    let study = Study::new("demo");
    study.session("P01", &repeats("spring", "hybrid", 1..=3));
    let printing = |out: std::process::Stdio| {
        let mut command = Command::new(binary());
        command.arg("--root").arg(study.root()).args(["--json", "list", "demo"]);
        command.env_remove("ZWIDTH_ROOT").stdout(out);
        ran(&command.output().unwrap())
    };
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let full = printing(full.into()).exits(1).one_error();
    full.says(&["what is printed could not be written", "No space left"]);
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    assert_eq!(printing(writer.into()).exits(0).err, "");
}

#[test]
fn a_wrong_name_after_only_gets_the_names_near_it() {
    let root = shipped::folder();
    for (typed, near) in [
        ("metric", "did you mean metrics"),
        ("mode.P01.S01.spring", "did you mean modes.P01.S01.spring, modes.P01.S01.spring_wall"),
        ("replay.agreemnt", "did you mean replay.agreement"),
    ] {
        zwidth(root, &["run", "--only", typed]).exits(1).one_error().says(&[typed, near]);
    }
    let far = zwidth(root, &["run", "--only", "xyz"]).exits(1).one_error();
    assert!(!far.err.contains("did you mean"), "{far:#?}");
}

#[test]
fn dry_and_fresh_together_list_every_job_and_why_and_make_nothing() {
    let root = shipped::finished();
    let before = listing(root.path());
    let dry = zwidth(root.path(), &["run", "--dry-run", "--fresh", "--json"]).exits(0);
    let made = dry.json()[0]["made"].as_array().unwrap().clone();
    let up_to_date = zwidth(root.path(), &["run", "--json"]).json()[0]["up_to_date"].as_u64();
    assert_eq!(made.len() as u64, up_to_date.unwrap());
    assert!(made.iter().all(|e| e["why"] == "asked to be made again"), "{made:#?}");
    // Of one figure alone: with what it needs, and no more.
    let one = zwidth_line(root.path(), "run --dry-run --fresh --only loops.P01.S01 --json");
    let one = one.exits(0).made();
    let of = |stage: &str| one.iter().filter(|name| name.starts_with(stage)).count();
    assert_eq!((one.len(), of("metrics "), of("average P01 S01 ")), (7, 0, 6), "{one:?}");
    assert_eq!(listing(root.path()), before);
}

#[test]
fn a_study_chooses_per_figure_how_repeats_are_averaged() {
    let root = shipped::finished();
    let toml = root.path().join("raw/thesis-twin/study.toml");
    let text = fs::read_to_string(&toml).unwrap();
    let choose = |choice: &str| {
        let chosen = format!("[figures]\n{choice}\n\n# What is rendered.");
        fs::write(&toml, text.replacen("# What is rendered.", &chosen, 1)).unwrap();
    };
    let before = file_blake3(&root.path().join(FIGURE)).unwrap();
    choose("modes.P01.S01.spring.alignment = \"landmarks\"");
    let ran = zwidth(root.path(), &["run", "--json"]).exits(0);
    assert_eq!(
        ran.made(),
        ["captions", "figure modes.P01.S01.spring", "page", "summary"],
        "only that figure, and the pages that show it"
    );
    let svg = fs::read_to_string(root.path().join(FIGURE)).unwrap();
    assert!(svg.contains("by landmarks") && svg.contains("spring.hybrid.landmarks.parquet"));
    let traced = only(root.path(), &["trace", FIGURE]);
    let inputs = traced["jobs"][0]["inputs"].as_object().unwrap();
    let of = |kind: &str| inputs.keys().filter(|path| path.ends_with(kind)).count();
    assert_eq!(
        (of(".landmarks.parquet"), of(".loop.parquet")),
        (3, 3),
        "force stands at the angle"
    );
    // At onset is the default, and the same bytes as without a choice.
    for choice in ["modes.alignment = \"onset\"", ""] {
        choose(choice);
        zwidth(root.path(), &["run"]).exits(0);
        assert_eq!(file_blake3(&root.path().join(FIGURE)).unwrap(), before);
    }
    // A choice that no figure can follow is an error; one that no figure of the study follows is
    // told.
    choose("alignment = \"landmark\"");
    let words = ["study.toml", "\"onset\" or \"landmarks\""];
    zwidth(root.path(), &["run"]).exits(1).one_error().says(&words);
    choose("loops.alignment = \"landmarks\"");
    zwidth(root.path(), &["run"]).exits(3).says(&["figures.loops", "averaged at the angle"]);
    choose("modes.P09.alignment = \"landmarks\"");
    zwidth(root.path(), &["run"]).exits(3).says(&["figures.modes.P09", "no such figure"]);
}
