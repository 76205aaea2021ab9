//! `zwidth compare` and `zwidth power` as a user types them.

use crate::binary::{Ran, zwidth};
use crate::shipped;
use std::fs;

/// What stands on the standard output.
fn prints(ran: &Ran, words: &[&str]) {
    words.iter().for_each(|word| assert!(ran.out.contains(word), "'{word}' is not in {ran:?}"));
}

#[test]
fn compare_makes_what_is_missing_and_says_whom_it_speaks_of() {
    let root = shipped::raw();
    let ran = zwidth(root.path(), &["compare", "thesis-twin"]).exits(0);
    prints(
        &ran,
        &[
            "Means by condition",
            "Modes compared",
            "trials of P01",
            "nothing is said of anybody else",
        ],
    );
    assert!(root.path().join("derived/thesis-twin/compare/contrasts_loop_area_j.parquet").exists());
}

#[test]
fn compare_gives_machines_every_row_in_si_units() {
    let ran = zwidth(shipped::finished().path(), &["compare", "thesis-twin", "--json"]).exits(0);
    let json = ran.json();
    let names: Vec<&str> =
        json.as_array().unwrap().iter().map(|t| t["table"].as_str().unwrap()).collect();
    let tables = ["means", "contrasts", "omnibus", "orders"];
    assert_eq!(names, tables.map(|table| format!("{table}_discrepancy_user_mean_n")));
    assert!(json[1]["rows"][0]["difference_n"].as_f64().unwrap().is_finite());
}

#[test]
fn a_metric_that_is_not_compared_is_named_with_those_that_are() {
    let root = shipped::finished();
    zwidth(root.path(), &["compare", "thesis-twin", "--metric", "loop_area"])
        .exits(1)
        .says(&["--metric loop_area", "loop_area_j"]);
}

#[test]
fn answers_are_compared_without_a_mean() {
    let root = shipped::finished();
    let ran = zwidth(root.path(), &["compare", "thesis-twin", "--by", "answer"]).exits(0);
    prints(&ran, &["Answers compared", "superiority", "never answers"]);
}

#[test]
fn one_session_has_no_sessions_to_compare_and_says_so() {
    let root = shipped::finished();
    zwidth(root.path(), &["compare", "thesis-twin", "--by", "session"])
        .exits(3)
        .says(&["there is nothing to compare"]);
}

#[test]
fn one_participant_tells_no_spread_and_assumed_spreads_give_a_plan_that_is_not_written_over() {
    let root = shipped::finished();
    let difference = ["power", "thesis-twin", "--difference", "0.1"];
    zwidth(root.path(), &difference).exits(1).says(&["give --participant-mode-sd"]);
    let plan = root.path().join("raw/thesis-twin/plan.json");
    let assumed =
        ["--participant-mode-sd", "0.1", "--residual-sd", "0.2", "--studies", "200", "--plan"];
    let arguments = [&difference[..], &assumed].concat();
    prints(&zwidth(root.path(), &arguments).exits(0), &["power of 80 %", "200 simulated studies"]);
    let written = fs::read(&plan).unwrap();
    zwidth(root.path(), &arguments).exits(1).says(&["exists already; move it elsewhere"]);
    assert_eq!(fs::read(plan).unwrap(), written);
}

#[test]
fn a_plan_beside_the_data_says_whether_the_analysis_is_the_planned_one() {
    let root = shipped::finished();
    let plan = ["power", "thesis-twin", "--difference", "0.1", "--participant-mode-sd", "0.1"];
    let plan = [&plan[..], &["--residual-sd", "0.2", "--studies", "200", "--plan"]].concat();
    zwidth(root.path(), &plan).exits(0);
    let compare = ["compare", "thesis-twin"];
    let ran = zwidth(root.path(), &compare).exits(0);
    prints(&ran, &["As planned (plan.json", "Participants: 12 planned, 1 with trials"]);
    prints(&ran, &["The plan was written when 36 trials were there already."]);
    let path = root.path().join("raw/thesis-twin/study.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("{text}\n[compare]\nalpha = 0.01\n")).unwrap();
    let ran = zwidth(root.path(), &compare).exits(0);
    prints(&ran, &["Not as planned (plan.json", "alpha was 0.05, is 0.01"]);
    let plan = root.path().join("raw/thesis-twin/plan.json");
    fs::write(&plan, "{").unwrap();
    prints(&zwidth(root.path(), &compare).exits(0), &["the file holds no plan"]);
    fs::remove_file(&plan).unwrap();
    std::process::Command::new("mkfifo").arg(&plan).status().unwrap();
    prints(&zwidth(root.path(), &compare).exits(0), &["Not as planned", "the file cannot be read"]);
}

#[test]
fn a_metric_of_study_toml_that_there_is_not_is_told() {
    let root = shipped::finished();
    let path = root.path().join("raw/thesis-twin/study.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("{text}\n[compare]\nmetrics = [\"softness_n\"]\n")).unwrap();
    zwidth(root.path(), &["run", "thesis-twin", "--only", "compare"])
        .exits(3)
        .says(&["there is no metric 'softness_n'"]);
}
