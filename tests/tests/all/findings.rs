//! What `verify` finds reaches whoever reads a result: each finding is a warning of `run`, stands
//! in the summary, and in the exit code. So a run never looks complete when the log says that more
//! was recorded.

use crate::binary::{zwidth, zwidth_line};
use crate::folders::{edit, truncate};
use crate::small::{Draft, Study, draft, repeats};
use std::fs;
use zwidth_study::{Event, Status};

/// Three trials of one condition, and a sweep.
fn study() -> Study {
    let study = Study::new("found");
    study.session("P01", &repeats("spring", "hybrid", 1..=3));
    study.sweep();
    study
}

/// The lines of one section of the summary.
fn section(summary: &str, title: &str) -> String {
    let from =
        summary.split_once(&format!("## {title}\n")).map(|(_, rest)| rest).unwrap_or_default();
    from.split("\n## ").next().unwrap_or_default().to_owned()
}

/// After `damage` every run says these words on standard error and exits with 3, the section of the
/// summary has them, `verify` finds the same, and `list` goes on.
#[track_caller]
fn check(study: &Study, title: &str, words: &[&str]) {
    let found = zwidth(study.root(), &["verify"]).exits(1);
    for _ in 0..2 {
        let label = if title == "Left out" { "left out: " } else { "read with care: " };
        zwidth(study.root(), &["run"]).exits(3).says(&[label]).says(words);
        let summary = study.summary();
        let section = section(&summary, title);
        for word in words {
            assert!(section.contains(word), "'{word}' is not under '{title}' of {summary}");
            assert!(found.out.contains(word), "'{word}' is not in {found:#?}");
        }
        assert!(title != "Left out" || !summary.contains("Nothing was left out"), "{summary}");
        assert!(
            !summary.contains(study.root().to_str().unwrap()),
            "a path of the machine is in {summary}"
        );
    }
}

#[track_caller]
fn damaged(damage: impl Fn(&Study), words: &[&str]) -> Study {
    let study = study();
    zwidth(study.root(), &["run"]).exits(0);
    let before = study.summary();
    assert!(words.iter().all(|word| !before.contains(word)), "{before}");
    damage(&study);
    check(&study, "Left out", words);
    study
}

#[test]
fn a_trial_that_is_gone_is_told_by_run_and_summary() {
    let words = ["trial-002.parquet", "belongs to the session, but its file is missing"];
    let remove = |s: &Study| fs::remove_file(s.trial("P01", 2)).unwrap();
    let study = damaged(remove, &words);
    // A run that makes everything again says it too: of one damage, for all are collected alike.
    zwidth(study.root(), &["run", "--fresh"]).exits(3).says(&["left out: "]).says(&words);
    let replace = |s: &Study| {
        remove(s);
        fs::create_dir(s.trial("P01", 2)).unwrap();
    };
    damaged(replace, &words);
}

#[test]
fn an_edited_record_and_one_with_a_repeated_key_are_told_by_run_and_summary() {
    let rename = |s: &Study| edit(&s.record("P01"), "zwidth tests", "zwidth 9.9.9");
    damaged(rename, &["P01_S01.json", "not the one that the session began with"]);
    let repeat =
        |s: &Study| edit(&s.record("P01"), "\"trials\"", "\"software\": \"other\", \"trials\"");
    damaged(repeat, &["P01_S01.json", "\"software\" stands twice"]);
}

#[test]
fn a_log_cut_at_the_end_of_a_line_and_one_with_a_repeated_key_are_told_by_run_and_summary() {
    let cut = |s: &Study| {
        let text = fs::read_to_string(s.events("P01")).unwrap();
        truncate(&s.events("P01"), text.trim_end().rfind('\n').unwrap() + 1);
    };
    damaged(cut, &["P01_S01.events.jsonl", "the log has 3 lines where its head counts 4"]);
    let repeat = |s: &Study| edit(&s.events("P01"), "{\"utc\"", "{\"blake3\":\"\",\"utc\"");
    damaged(repeat, &["P01_S01.events.jsonl", "\"blake3\" stands twice"]);
}

#[test]
fn a_changed_and_a_deleted_sweep_are_told_by_run_and_summary() {
    let cut = |s: &Study| truncate(&s.sweep_file(), 300);
    damaged(cut, &["sweep-01.parquet", "not a readable Parquet file"]);
    let remove = |s: &Study| fs::remove_file(s.sweep_file()).unwrap();
    damaged(remove, &["sweep-01.parquet", "its file is missing"]);
}

#[test]
fn a_journal_that_waits_for_recover_is_told_by_run_and_summary() {
    let leave = |s: &Study| {
        let journal = s.layout().journals().join("P01_S01.trial-004.journal");
        fs::create_dir_all(s.layout().journals()).unwrap();
        fs::write(journal, "zwidth journal 2\n").unwrap();
    };
    damaged(leave, &["P01_S01.trial-004.journal", "a trial was cut short here"]);
}

#[test]
fn what_counts_all_the_same_is_to_be_read_with_care_in_run_and_summary() {
    let twice = Study::new("found");
    twice.session(
        "P01",
        &[draft(1, "spring", "hybrid"), Draft { repeat: 1, ..draft(2, "spring", "hybrid") }],
    );
    check(&twice, "Read with care", &["trials 1 and 2 both count as repeat 1 of spring × hybrid"]);

    let stray = study();
    fs::write(stray.trial("P01", 2).with_file_name("notes.txt"), "a note").unwrap();
    check(&stray, "Read with care", &["notes.txt", "only Parquet files belong in this tree"]);

    let narrow = study();
    edit(&narrow.layout().study_toml(), "theta_max_deg = 45.0", "theta_max_deg = 20.0");
    check(&narrow, "Read with care", &["22.07° is more than 2° outside of the work space"]);
    let told = section(&narrow.summary(), "Read with care");
    assert!(told.contains("P01 S01 trial 3, theta_rad, row "), "{told}");

    let short = study();
    edit(&short.layout().study_toml(), "trial_limit_s = ", "trial_limit_s = 1.0 # ");
    check(&short, "Read with care", &["longer than design.trial_limit_s = 1 s"]);
}

#[test]
fn whether_a_recording_can_be_is_asked_of_trials_that_count() {
    let held = |status, events| Draft {
        status,
        events,
        force_n: Some(3.0),
        ..draft(1, "spring", "hybrid")
    };
    let kept = |draft| {
        let study = Study::new("found");
        study.session("P01", &[draft]);
        study
    };
    let complete = kept(held(Status::Complete, Vec::new()));
    check(&complete, "Read with care", &["it is 3 throughout, while theta_rad changes"]);
    for figure in ["modes.P01.S01.spring", "loops.P01.S01"] {
        let caption = complete.layout().reports().join(format!("figures/{figure}.txt"));
        let caption = fs::read_to_string(caption).unwrap();
        let note = "(force_ex_n): it is 3 throughout, while theta_rad changes";
        assert!(caption.contains("Read with care trial") && caption.contains(note), "{caption}");
    }

    let excluded = Event::Excluded { trial: 1, reason: "a loose plug".to_owned() };
    for (status, events) in [(Status::Incomplete, Vec::new()), (Status::Complete, vec![excluded])] {
        zwidth(kept(held(status, events)).root(), &["verify"]).exits(0);
    }
}

#[test]
fn a_study_toml_that_cannot_be_read_hides_no_other_finding() {
    let study = study();
    truncate(&study.trial("P01", 2), 50);
    truncate(&study.sweep_file(), 50);
    fs::write(study.trial("P01", 1).with_file_name("notes.txt"), "a note").unwrap();
    edit(&study.layout().study_toml(), "theta_max_deg = 45.0", "theta_max_deg = \"much\"");
    let words = ["study.toml", "trial-002.parquet", "sweep-01.parquet", "notes.txt"];
    zwidth(study.root(), &["verify"]).exits(1).prints(&words);
    for command in ["run", "list", "table found"] {
        zwidth_line(study.root(), command).exits(1).says(&words[..3]);
    }
}

#[test]
fn a_study_that_lost_its_study_toml_is_missed_and_the_others_are_looked_at() {
    let study = study();
    let other = study.root().join("raw/other");
    fs::create_dir_all(other.join("sessions")).unwrap();
    for command in ["run", "list"] {
        zwidth(study.root(), &[command]).exits(3).says(&["raw/other/study.toml", "cannot read"]);
    }
    let words = ["raw/other/study.toml", "found: no findings"];
    zwidth(study.root(), &["verify"]).exits(1).prints(&words);
}

#[test]
fn a_study_in_a_folder_whose_name_is_no_id_is_told_and_not_passed_by() {
    let study = study();
    let odd = study.root().join("raw/my study");
    fs::create_dir(&odd).unwrap();
    fs::copy(study.layout().study_toml(), odd.join("study.toml")).unwrap();
    for command in ["run", "list"] {
        let words = ["\"my study\" is left out", "rename the folder"];
        zwidth(study.root(), &[command]).exits(3).says(&words);
    }
    zwidth(study.root(), &["verify"]).exits(1).prints(&["\"my study\" is left out"]);
    zwidth(study.root(), &["verify", "found"]).exits(0);
}

#[test]
fn a_table_that_cannot_be_read_hides_no_other_table() {
    let study = study();
    zwidth(study.root(), &["run"]).exits(0);
    truncate(&study.layout().derived().join("metrics.parquet"), 100);
    zwidth(study.root(), &["table", "found"])
        .exits(3)
        .says(&["unreadable: ", "metrics.parquet"])
        .prints(&["conditions"]);
    zwidth(study.root(), &["table", "found", "conditions"]).exits(0);
    zwidth(study.root(), &["table", "found", "metrics"])
        .exits(1)
        .says(&["unreadable: ", "that can be read"]);
}

#[test]
fn nothing_was_left_out_is_not_said_where_nothing_counts() {
    let study = Study::new("found");
    zwidth(study.root(), &["run"]).exits(0);
    let empty = study.summary();
    assert!(
        !empty.contains("Nothing was left out") && empty.contains("nothing could be left out"),
        "{empty}"
    );
}

#[test]
fn ids_that_differ_only_by_case_or_are_names_of_devices_are_refused() {
    let study = study();
    for (line, words) in [
        ("new FOUND", "differs from 'found' only by case"),
        ("twin Found --participants 1 --sessions 1", "differs from 'found' only by case"),
        (
            "acquire found -s S02 --plain --auto --fast -p p01",
            "the participant 'p01' differs from 'P01' only by case",
        ),
    ] {
        zwidth_line(study.root(), line).exits(1).one_error().says(&[words]);
    }
    for line in ["new con", "verify NUL", "acquire found -s S02 --plain --auto --fast -p COM1"] {
        zwidth_line(study.root(), line).exits(2).says(&["Windows keeps this name for a device"]);
    }
    assert!(!study.root().join("raw/FOUND").exists() && !study.root().join("raw/Found").exists());
}

#[test]
fn a_number_of_threads_out_of_reach_is_one_error() {
    let study = study();
    for threads in ["0", "100000", "-1", "18446744073709551616"] {
        let ran = zwidth(study.root(), &[&format!("--threads={threads}"), "run"]).exits(2);
        assert!(ran.err.contains("--threads") && ran.out.is_empty(), "{ran:#?}");
    }
    assert!(!study.layout().derived().exists());
    zwidth(study.root(), &["--threads", "64", "run"]).exits(0);
}
