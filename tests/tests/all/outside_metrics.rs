//! Metrics that other programs computed: `zwidth metric`, from a table to claims, page and methods.

use crate::acquire::{Desk, TRIALS};
use crate::binary::{Ran, zwidth, zwidth_line};
use crate::folders::{edit, listing};
use crate::formulas::{near, ran};
use crate::own_metrics::{STUDY, grips_of};
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

/// The study of grips, whose study.toml names the metric of the other program as this.
fn grips(root: &Path, compare: &str) {
    grips_of(root, &STUDY.replace("primary = \"grip_max_n\"", compare));
}

/// A table of these columns, and rows.
fn table(root: &Path, text: &str) -> String {
    let path = root.join("grip.csv");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Values by condition: in the firm mode 1, 2 … 5, in the soft one 2, 4 … 10.
fn values() -> String {
    let mut text = "participant,session,environment,mode,repeat,value\n".to_owned();
    for person in 1..=5 {
        writeln!(text, "P{person:02},S01,task,firm,1,{person}").unwrap();
        writeln!(text, "P{person:02},S01,task,soft,1,{}", 2 * person).unwrap();
    }
    text
}

fn metric(root: &Path, more: &[&str]) -> Ran {
    zwidth(root, &[&["metric", "grips"], more].concat())
}

/// Gives the values of a table as the metric `grip_peak`, in newtons.
fn give(root: &Path, text: &str, more: &[&str]) -> Ran {
    let path = table(root, text);
    let named = ["--from", &path, "--id", "grip_peak", "--unit", "N", "--label", "best grip"];
    metric(root, &[&named, more].concat())
}

/// The rows of a table of `compare --json`.
fn compared(root: &Path, name: &str) -> Value {
    let tables = ran(root, "compare grips --metric own_grip_peak_n --json").json();
    let mut all = tables.as_array().unwrap().iter();
    all.find(|table| table["table"] == name).map_or(Value::Null, |table| table["rows"].clone())
}

#[test]
fn values_of_another_program_are_a_metric_like_any_other() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    grips(
        root,
        "metrics = [\"grip_max_n\", \"own_grip_peak_n\"]\nbounds = { own_grip_peak_n = 20.0 }",
    );
    zwidth_line(root, "verify grips").prints(&["no values of 'own_grip_peak_n' are there"]);
    let more = ["--program", "grip.py 1.2", "--better", "lower", "--by", "E1"];
    give(root, &values(), &more).exits(0).prints(&[
        "table 1 of own_grip_peak_n is given: 10 values of trials",
        "raw/grips/own/grip_peak.0001.parquet",
    ]);
    give(root, &values(), &more).exits(0).prints(&["is of this file, and is not given twice"]);
    // Soft less firm is each person's number: mean 3, SD √2.5, t = 3 / √(2.5 / 5).
    let row = &compared(root, "contrasts_own_grip_peak_n")[0];
    near(row, "difference_n", 3.0);
    near(row, "statistic", 3.0 / 0.5_f64.sqrt());
    near(row, "bound_n", 20.0);
    assert_eq!((&row["n"], &row["jnd_n"]), (&5.into(), &Value::Null), "{row}");
    zwidth_line(root, "power grips --metric own_grip_peak_n --difference 3")
        .exits(0)
        .prints(&["own_grip_peak_n"]);
    ran(root, "methods grips").prints(&["best grip: computed outside of zwidth by grip.py 1.2"]);
    ran(root, "run grips");
    let page = fs::read_to_string(root.join("reports/grips/index.html")).unwrap();
    assert!(page.contains("best grip"));
    let figure = "reports/grips/figures/compare.own_grip_peak_n.svg";
    assert!(root.join(figure).exists());
    zwidth(root, &["trace", figure]).exits(0).prints(&[
        "raw/grips/own/grip_peak.0001.parquet",
        "computed outside of zwidth by grip.py 1.2",
        "grip.csv, given",
        "raw/grips/own.events.jsonl",
    ]);
    zwidth_line(root, "list grips")
        .prints(&["metric own_grip_peak_n of another program, 10 trials"]);
    zwidth_line(root, "run grips --dry-run").prints(&["up to date"]);

    // A later table counts in place of the first, as a whole: P05 has no row in it, and P04 no value in one mode.
    let later = values().replace(",8\n", ",\n");
    let later: String = later
        .lines()
        .filter(|line| !line.starts_with("P05"))
        .map(|line| format!("{line}\n"))
        .collect();
    let words = "7 values of trials, 1 trial without one; 2 trials that count have no row in it";
    give(root, &later, &[]).exits(0).prints(&["table 2 of own_grip_peak_n is given", words]);
    zwidth_line(root, "why derived/grips/metrics.parquet").prints(&["grip_peak.0002.parquet"]);
    let row = &compared(root, "contrasts_own_grip_peak_n")[0];
    near(row, "difference_n", 2.0);
    assert_eq!(row["n"], 3, "{row}");
    let list = metric(root, &["--list", "--json"]).exits(0).json();
    assert_eq!(list[0]["why_not"], "table 2 took its place");
    assert_eq!((&list[1]["why_not"], &list[1]["trials"]), (&Value::Null, &8.into()));

    metric(root, &["--withdraw", "grip_peak", "wrong channel"]).exits(0);
    zwidth_line(root, "compare grips --metric own_grip_peak_n")
        .exits(1)
        .one_error()
        .says(&["grips does not compare it"]);
    metric(root, &["--list"]).prints(&["does not count: withdrawn: wrong channel"]);
    metric(root, &["--withdraw", "grip_peak", "again"]).exits(1).one_error();
}

#[test]
fn a_metric_is_primary_only_if_every_session_began_with_a_study_that_says_so() {
    for (before, after, role, says) in [
        ("primary = \"own_grip_peak_n\"", None, "primary", "Primary metric."),
        (
            "primary = \"grip_max_n\"",
            Some("primary = \"own_grip_peak_n\""),
            "exploratory, chosen after the data",
            "Chosen after the data: the study.toml of session S01 of P01 does not name it.",
        ),
        (
            "metrics = [\"own_grip_peak_n\"]",
            Some("primary = \"own_grip_peak_n\""),
            "exploratory, chosen after the data",
            "Made primary after the data: the study.toml of session S01 of P01 does not name it as primary.",
        ),
        (
            "primary = \"grip_max_n\"\nmetrics = [\"own_grip_peak_n\"]",
            None,
            "exploratory",
            "Exploratory: not the primary metric.",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        grips(root, before);
        if let Some(after) = after {
            edit(&root.join("raw/grips/study.toml"), before, after);
        }
        give(root, &values(), &[]).exits(0);
        ran(root, "run grips");
        let compared = root.join("derived/grips/compare/compared.parquet");
        let compared = zwidth_tables::Table::from_parquet(&compared).unwrap();
        let metrics = compared.texts("metric").unwrap();
        let own = metrics.iter().position(|id| id.as_deref() == Some("own_grip_peak_n")).unwrap();
        assert_eq!(
            compared.texts("role").unwrap()[own].as_deref(),
            Some(role),
            "{before}, {after:?}"
        );
        let table = zwidth_line(root, "table grips contrasts_own_grip_peak_n").exits(0);
        assert!(table.out.contains(says), "{before}, {after:?}: {}", table.out);
        let summary = fs::read_to_string(root.join("reports/grips/summary.md")).unwrap();
        let is_after = role.contains("chosen after");
        let told = ["Chosen after the data, best grip", "chosen after the data"];
        assert_eq!(told.iter().any(|words| summary.contains(words)), is_after, "{summary}");
    }
}

#[test]
fn a_bound_that_is_a_share_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    grips(root, "primary = \"own_grip_peak_n\"\nbounds = { own_grip_peak_n = { weber = 0.1 } }");
    give(root, &values(), &[]).exits(0);
    zwidth_line(root, "verify grips").prints(&["own_grip_peak_n", "give a number in its unit"]);
    let row = &compared(root, "contrasts_own_grip_peak_n")[0];
    assert_eq!((&row["n"], &row["bound_n"]), (&5.into(), &Value::Null), "{row}");
}

#[test]
fn what_is_no_table_of_values_is_refused_with_one_error_and_nothing_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    grips(root, "");
    let raw = root.join("raw");
    let before = listing(&raw);
    let head = "participant,session,trial,value\nP02,S01,1,7\n";
    for (row, words) in [
        (
            "P01,S01,1,nan",
            "'nan' is not a finite number; a trial without a value has an empty cell",
        ),
        ("P01,S01,1,inf", "'inf' is not a finite number"),
        ("P01,S01,9,1", "the session has no trial 9: they are 1 to 2"),
        ("P01,S02,1,1", "there is no session S02 of P01"),
        ("P02,S01,1,8", "trial 1 of P02 S01 has a value in line 2 too"),
        ("P01,S01,1,strong", "'strong' is not a number"),
    ] {
        let told = give(root, &format!("{head}{row}\n"), &[]).exits(1).one_error();
        told.says(&[words, "grip.csv", "line 3"]);
    }
    give(root, "participant,session,trial,value\n", &[]).exits(1).one_error().says(&["no rows"]);
    give(root, "participant,session,trial\nP01,S01,1\n", &[])
        .exits(1)
        .one_error()
        .says(&["there is no column 'grip_peak'; the table has participant, session, trial"]);
    let path = table(root, head);
    let named = |id: &str, unit: &str, label: &str| {
        metric(root, &["--from", &path, "--id", id, "--unit", unit, "--label", label])
    };
    named("grip", "newton", "grip").exits(1).one_error().says(&["'newton' is not a unit"]);
    named("grip", "N", " ").exits(1).one_error().says(&["one line of text"]);
    named("own_grip", "N", "grip").exits(1).one_error().says(&["leave it out"]);
    named("Grip", "N", "grip").exits(2).says(&["use lower case"]);
    give(root, head, &["--better", "more"]).exits(2);
    give(root, head, &["--program", ""]).exits(1).one_error().says(&["one line of text"]);
    metric(root, &["--from", &path]).exits(2).says(&["--id"]);
    metric(root, &[]).exits(2);
    metric(root, &["--withdraw", "grip_peak", "x"])
        .exits(1)
        .one_error()
        .says(&["no table of a metric grip_peak counts", "nothing to withdraw"]);
    metric(root, &["--list"]).exits(0).prints(&["no metric of another program was given"]);
    give(root, head, &["--dry-run"]).exits(0).prints(&[
        "table 1 of own_grip_peak_n would be given: 1 value of trials",
        "nothing was written",
    ]);
    assert_eq!(listing(&raw), before);

    give(root, head, &[]).exits(0);
    let before = listing(&raw);
    named("grip_peak", "mN", "grip").exits(1).one_error().says(&["has the unit N, not mN"]);
    assert_eq!(listing(&raw), before);
}

#[test]
fn a_trial_that_is_excluded_keeps_its_value_and_enters_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    grips(root, "");
    zwidth(root, &["exclude", "grips", "-p", "P01", "-s", "S01", "--trial", "1", "slipped"])
        .exits(0);
    give(root, &values(), &[]).exits(0).prints(&["1 trial that do not count: excluded: slipped"]);
    assert_eq!(compared(root, "contrasts_own_grip_peak_n")[0]["n"], 4);
    let kept =
        zwidth_tables::Table::from_parquet(&root.join("raw/grips/own/grip_peak.0001.parquet"));
    assert_eq!(kept.unwrap().height(), 10);
}

#[test]
fn of_a_sealed_session_trials_are_named_by_number_alone() {
    let desk = Desk::new(true);
    desk.acquire(&("start\n3\n".repeat(TRIALS) + "quit\n"), &[]).exits(0);
    let give = |text: &str| {
        let path = table(desk.root(), text);
        let named = ["--id", "grip", "--unit", "N", "--label", "grip"];
        zwidth(desk.root(), &[&["metric", "small", "--from", &path], &named[..]].concat())
    };
    let alone = "participant,session,trial,value\nP01,S01,2,1.5\nP01,S01,3,2.5\n";
    for mode in ["active", "passive", "hybrid"] {
        let text = format!("participant,session,trial,mode,value\nP01,S01,2,{mode},1.5\n");
        let told = give(&text).exits(1).one_error();
        told.says(&["the session's modes are sealed: name its trials by number alone"]);
        let text = format!(
            "participant,session,environment,mode,repeat,value\nP01,S01,spring,{mode},1,1\n"
        );
        give(&text).exits(1).one_error().says(&["the session's modes are sealed"]);
    }
    give(alone).exits(0).prints(&["2 trials that do not count: "]);
    desk.verify();
    desk.unseal().exits(0);
    zwidth(desk.root(), &["run", "small", "--only", "metrics"]).exits(0);
    let metrics = desk.root().join("derived/small/metrics.parquet");
    let metrics = zwidth_tables::Table::from_parquet(&metrics).unwrap();
    let trials = metrics.integers("trial").unwrap().into_iter().flatten();
    let values = trials.zip(metrics.floats("own_grip_n").unwrap());
    let values: Vec<_> = values.filter_map(|(trial, value)| Some((trial, value?))).collect();
    assert_eq!(values, [(2, 1.5), (3, 2.5)]);
}
