//! A session whose record or event log is not whole has no trials that count: nobody knows which of
//! them were superseded or excluded.

use crate::binary::zwidth;
use crate::folders::truncate;
use crate::small::{Draft, Study, UTC, draft, repeats};
use std::fs;
use zwidth_store::{RealFiles, append_events};
use zwidth_study::Event;
use zwidth_tables::Table;

/// Two sessions of two trials; in the second session the first trial was done again.
fn study() -> Study {
    let study = Study::new("logs");
    study.session("P01", &repeats("spring", "hybrid", 1..=2));
    let superseded = vec![Event::Superseded { trial: 1, by: 2 }];
    let drafts = [
        Draft { events: superseded, ..draft(1, "spring", "hybrid") },
        draft(2, "spring", "hybrid"),
    ];
    study.session("P02", &drafts);
    study
}

/// After `damage` only the first participant's trials count, every run says what is wrong with
/// `file`, and `verify` finds it.
#[track_caller]
fn check(damage: impl Fn(&Study), file: &str, words: &str) {
    let study = study();
    damage(&study);
    for _ in 0..2 {
        zwidth(study.root(), &["run", "--only", "metrics"]).exits(3).says(&[
            "left out: ",
            file,
            words,
        ]);
    }
    let metrics = Table::from_parquet(&study.layout().derived().join("metrics.parquet")).unwrap();
    let participants: Vec<_> =
        metrics.texts("participant").unwrap().into_iter().flatten().collect();
    assert_eq!(participants, ["P01", "P01"]);
    let found = zwidth(study.root(), &["verify"]).exits(1);
    assert!(found.out.contains(file) && found.out.contains(words), "{found:#?}");
    let list = zwidth(study.root(), &["list"]).exits(3);
    assert!(list.out.contains("unreadable: ") && list.out.contains(words), "{list:#?}");
}

fn edit(path: &std::path::Path, from: &str, to: &str) {
    let text = fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "{text}");
    fs::write(path, text.replace(from, to)).unwrap();
}

#[test]
fn two_whole_sessions_give_three_trials() {
    let study = study();
    zwidth(study.root(), &["run", "--only", "metrics"]).exits(0);
    let metrics = Table::from_parquet(&study.layout().derived().join("metrics.parquet")).unwrap();
    assert_eq!(metrics.height(), 3);
}

#[test]
fn a_changed_event_keeps_the_session_out() {
    let change = |s: &Study| edit(&s.events("P02"), "\"by\":2", "\"by\":1");
    check(change, "P02_S01.events.jsonl, row 3", "the checksum does not match");
}

#[test]
fn a_cut_event_keeps_the_session_out() {
    let cut = |s: &Study| {
        let first = fs::read_to_string(s.events("P02")).unwrap().find('\n').unwrap();
        truncate(&s.events("P02"), first + 40);
    };
    check(cut, "P02_S01.events.jsonl, row 2", "not a readable event");
}

#[test]
fn a_missing_log_keeps_the_session_out() {
    let remove = |s: &Study| fs::remove_file(s.events("P02")).unwrap();
    check(
        remove,
        "P02_S01.events.jsonl",
        "the log has 0 lines where its head counts 4: the others are gone",
    );
}

#[test]
fn a_log_without_its_end_keeps_the_session_out() {
    let shorten = |s: &Study| {
        let text = fs::read_to_string(s.events("P02")).unwrap();
        let kept: Vec<&str> = text.lines().take(2).collect();
        fs::write(s.events("P02"), kept.join("\n") + "\n").unwrap();
    };
    check(
        shorten,
        "P02_S01.events.jsonl",
        "the log has 2 lines where its head counts 4: the others are gone",
    );
}

#[test]
fn a_damaged_record_keeps_the_session_out() {
    check(|s| truncate(&s.record("P02"), 100), "P02_S01.json", "not a session record");
}

#[test]
fn a_missing_record_keeps_the_session_out() {
    check(|s| fs::remove_file(s.record("P02")).unwrap(), "P02_S01.json", "cannot read");
}

#[test]
fn a_record_of_an_unknown_version_keeps_the_session_out() {
    let version =
        |s: &Study| edit(&s.record("P02"), "\"schema_version\": 1", "\"schema_version\": 2");
    check(version, "P02_S01.json", "schema version 2 is unknown");
}

#[test]
fn a_record_under_another_sessions_name_keeps_the_session_out() {
    let swap = |s: &Study| edit(&s.record("P02"), "\"P02\"", "\"P01\"");
    check(swap, "P02_S01.json", "it is the record of P01 S01");
}

#[test]
fn answers_that_make_no_sense_are_findings_with_their_row_and_give_no_tally() {
    let answer = |trial, question: &str, value: i16| Event::Answer {
        trial,
        question: question.parse().unwrap(),
        value: value.into(),
        time_ms: None,
    };
    for (event, words) in [
        (answer(1, "felt_spring", 9), "the answer to trial 1 is 9; answers are 1 to 5"),
        (answer(1, "felt_heat", 3), "question 'felt_heat' is not in study.toml"),
    ] {
        let study = study();
        append_events(&RealFiles, &study.events("P01"), UTC, &[answer(1, "felt_spring", 4), event])
            .unwrap();
        let found = zwidth(study.root(), &["verify"]).exits(1);
        assert!(
            found.out.contains("P01_S01.events.jsonl, row 5: ") && found.out.contains(words),
            "{found:#?}"
        );
        zwidth(study.root(), &["run", "--only", "likert tallies"])
            .exits(3)
            .says(&["likert tallies could not be made"]);
        assert!(!study.layout().derived().join("likert.parquet").exists());
    }
}

#[test]
fn a_trial_that_was_recorded_and_is_gone_is_told() {
    let study = study();
    fs::remove_file(study.trial("P01", 2)).unwrap();
    let words =
        ["left out: ", "trial-002.parquet", "belongs to the session, but its file is missing"];
    zwidth(study.root(), &["run", "--only", "metrics"]).exits(3).says(&words);
}
