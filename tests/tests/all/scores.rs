//! Scores of questionnaires, from a table by formula to the comparison of modes.

use crate::acquire::{Desk, TRIALS};
use crate::binary::zwidth;
use crate::folders::append;
use crate::formulas::{near, ran, u};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use zwidth_tables::Table;

const SCALES: [&str; 6] =
    ["mental", "physical", "temporal", "performance", "effort", "frustration"];

const MAP: &str = r#"
kind = "likert"
simulated = true
[file]
missing = "drop"
[trial]
participant = { column = "participant" }
session = "S01"
environment = "task"
mode = { column = "mode" }
[questions.columns]
"#;

/// The places of each two of the six, the first in the alphabet first, and the id of the question about them.
fn pairs() -> Vec<(usize, usize, String)> {
    let each = (0..6).flat_map(|a| (0..6).map(move |b| (a, b)));
    let pairs = each.filter(|(a, b)| SCALES[*a] < SCALES[*b]);
    pairs.map(|(a, b)| (a, b, format!("{}_or_{}", SCALES[a], SCALES[b]))).collect()
}

fn ids(of: impl Iterator<Item = String>) -> String {
    of.map(|id| format!("\"{id}\"")).collect::<Vec<_>>().join(", ")
}

/// A study of two modes with the System Usability Scale and both forms of the TLX.
fn study() -> String {
    let mut study = r#"
schema = 2
[study]
id = "scales"
title = "Scales by formula"
[design]
repeats = 1
trial_limit_s = 60.0
[device]
name = "lever"
[[environments]]
id = "task"
label = "Task"
kind = "none"
[[modes]]
id = "active"
label = "Active"
[[modes]]
id = "hybrid"
label = "Hybrid"
"#
    .to_owned();
    for i in 1..=10 {
        let reversed = if i % 2 == 0 { "reversed = true\n" } else { "" };
        write!(study, "[[questions]]\nid = \"sus_{i}\"\ntext = \"Usability {i}\"\n{reversed}")
            .unwrap();
    }
    for scale in SCALES {
        write!(
            study,
            "[[questions]]\nid = \"{scale}\"\ntext = \"{scale}\"\npoints = 21\nstep = 5\nfrom = 0\n"
        )
        .unwrap();
        write!(study, "[[questions]]\nid = \"w_{scale}\"\ntext = \"weight of {scale}\"\npoints = 6\nfrom = 0\n")
            .unwrap();
    }
    let sus = ids((1..=10).map(|i| format!("sus_{i}")));
    let items = ids(SCALES.iter().map(ToString::to_string));
    let weights = ids(SCALES.iter().map(|scale| format!("w_{scale}")));
    write!(
        study,
        "[[scores]]\nid = \"usability\"\nkind = \"sus\"\nquestions = [{sus}]\nlabel = \"Usability\"\n\
         [[scores]]\nid = \"workload_raw\"\nkind = \"nasa_tlx_raw\"\nquestions = [{items}]\n\
         [[scores]]\nid = \"workload\"\nkind = \"nasa_tlx\"\nquestions = [{items}]\nweights = [{weights}]\n\
         label = \"Workload\"\n\
         [[scores]]\nid = \"workload_pairs\"\nkind = \"nasa_tlx\"\nquestions = [{items}]\npairs = \"Which of the two?\"\n\
         [compare]\nprimary = \"score_workload\"\n"
    )
    .unwrap();
    study
}

/// Ten people's answers; whoever `lacks` gave no last answer.
fn answers(lacks: Option<u64>) -> String {
    let items: Vec<String> = (1..=10)
        .map(|i| format!("sus_{i}"))
        .chain(SCALES.iter().map(ToString::to_string))
        .chain(SCALES.iter().map(|scale| format!("w_{scale}")))
        .chain(pairs().into_iter().map(|(.., id)| id))
        .collect();
    let mut table = format!("participant,mode,{}\n", items.join(","));
    for p in 1..=10_u64 {
        for (m, mode) in [(0_u64, "active"), (1, "hybrid")] {
            let g = 1.8 * u(&[p, 1]) + 0.7 * u(&[p, 2, m]) + 0.4 * m as f64;
            let mut values: Vec<f64> = Vec::new();
            for i in 1..=10_u64 {
                let s = g + 1.2 * u(&[p, 20 + i, m + 1]);
                let middle = if i % 2 == 1 { 3.3 + s } else { 3.0 - s };
                values.push((middle + 0.5).floor().clamp(1.0, 5.0));
            }
            for i in 0..6_u64 {
                let value = 10.0 - 3.0 * g + 10.0 * u(&[p, 40 + i, m + 1]) + 0.5;
                values.push((5.0 * value.floor()).clamp(0.0, 100.0));
            }
            let chosen: Vec<f64> = (0..6).map(|i| u(&[p, 60 + i])).collect();
            for own in &chosen {
                values.push(chosen.iter().filter(|other| *other < own).count() as f64);
            }
            let mut cells: Vec<String> = values.iter().map(ToString::to_string).collect();
            // The same choices one by one: by number, or by what was chosen.
            cells.extend(pairs().into_iter().map(|(a, b, _)| match chosen[a] > chosen[b] {
                true if m == 0 => "1".to_owned(),
                false if m == 0 => "2".to_owned(),
                true => SCALES[a].to_uppercase(),
                false => SCALES[b].to_owned(),
            }));
            if lacks == Some(p) && m == 1 {
                cells[17].clear();
                cells[22].clear();
            }
            writeln!(table, "P{p:02},{mode},{}", cells.join(",")).unwrap();
        }
    }
    table
}

/// A study in a folder, with its answers imported.
fn imported(root: &Path, table: &str) {
    let raw = root.join("raw/scales");
    fs::create_dir_all(&raw).unwrap();
    fs::write(raw.join("study.toml"), study()).unwrap();
    let columns = table.lines().next().unwrap().split(',').skip(2);
    let columns: String = columns.map(|id| format!("{id} = \"{id}\"\n")).collect();
    fs::write(root.join("map.toml"), format!("{MAP}{columns}")).unwrap();
    fs::write(root.join("answers.csv"), table).unwrap();
    let [map, answers] =
        ["map.toml", "answers.csv"].map(|name| root.join(name).display().to_string());
    let done = zwidth(root, &["import", "scales", "--map", &map, &answers]);
    assert!(matches!(done.code, Some(0 | 3)), "{}", done.err);
}

/// R and SciPy: `t.test` of everybody's differences, α by definition and pingouin.
#[test]
fn scores_are_compared_as_metrics_and_their_reliability_is_told() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    imported(root, &answers(None));
    let tables: Value =
        serde_json::from_str(&ran(root, "compare scales --metric score_workload --json").out)
            .unwrap();
    let contrasts = |tables: &Value, metric: &str| -> Value {
        let name = format!("contrasts_{metric}");
        let table = tables.as_array().unwrap().iter().find(|table| table["table"] == name.as_str());
        table.unwrap_or_else(|| panic!("{tables}"))["rows"][0].clone()
    };
    let row = contrasts(&tables, "score_workload");
    near(&row, "difference", -8.56666667);
    near(&row, "difference_std_error", 2.7826846);
    near(&row, "p_value", 0.013170526);
    near(&row, "mean_first", 44.1333333);
    near(&row, "mean_second", 52.7);
    for (metric, expected) in [
        ("score_usability", [14.0, 3.6930866, 0.0042769536]),
        ("score_workload_raw", [-8.33333333, 2.4876237, 0.0085246659]),
        ("score_workload_pairs", [-8.56666667, 2.7826846, 0.013170526]),
    ] {
        let line = format!("compare scales --metric {metric} --json");
        let tables: Value = serde_json::from_str(&ran(root, &line).out).unwrap();
        let row = contrasts(&tables, metric);
        for (column, expected) in
            ["difference", "difference_std_error", "p_value"].into_iter().zip(expected)
        {
            near(&row, column, expected);
        }
    }
    ran(root, "run scales --quiet");
    let derived = root.join("derived/scales");
    let scores = Table::from_parquet(&derived.join("scores.parquet")).unwrap();
    let values = scores.floats("value").unwrap();
    let of = scores.texts("score").unwrap();
    // P01 in the active mode stands first of each.
    for (score, expected) in [
        ("usability", 30.0),
        ("workload_raw", 61.6666667),
        ("workload", 63.6666667),
        ("workload_pairs", 63.6666667),
    ] {
        let first = of.iter().position(|own| own.as_deref() == Some(score)).unwrap();
        assert!((values[first].unwrap() - expected).abs() < 1e-6, "{score}: {:?}", values[first]);
    }
    // Weights are among the answers, and no ratings.
    let asked = |table: &str| -> BTreeSet<String> {
        let table = Table::from_parquet(&derived.join(table)).unwrap();
        table.texts("question").unwrap().into_iter().flatten().collect()
    };
    let rated: BTreeSet<String> =
        (1..=10).map(|i| format!("sus_{i}")).chain(SCALES.map(str::to_owned)).collect();
    assert_eq!(asked("likert.parquet"), rated);
    assert_eq!(asked("answers.parquet").len(), 16 + 6 + 15);
    let alpha = Table::from_parquet(&derived.join("reliability.parquet")).unwrap();
    assert!((alpha.floats("alpha").unwrap()[0].unwrap() - 0.920056348).abs() < 1e-6);
    let summary = fs::read_to_string(root.join("reports/scales/summary.md")).unwrap();
    assert!(summary.contains("Workload"), "{summary}");
    assert!(root.join("reports/scales/figures/compare.score_workload.pdf").exists());
    let methods = ran(root, "methods scales").out;
    assert!(methods.contains("Workload (weighted NASA-TLX)"), "{methods}");
}

#[test]
fn a_score_with_a_missing_weight_is_none_and_says_so() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    imported(root, &answers(Some(4)));
    ran(root, "run scales --quiet");
    let scores = Table::from_parquet(&root.join("derived/scales/scores.parquet")).unwrap();
    let remarks: Vec<String> = scores.texts("remark").unwrap().into_iter().flatten().collect();
    assert_eq!(remarks, ["5 of 6 weights are answered", "14 of 15 pairs are answered"]);
    let line = "compare scales --metric score_workload --by participant --json";
    let tables: Value = serde_json::from_str(&ran(root, line).out).unwrap();
    assert_eq!(tables[0]["rows"].as_array().unwrap().len(), 9, "{tables}");
}

/// A session of which every trial is rated by the TLX, and whose pairs were asked after the last one.
fn weighed() -> Desk {
    let desk = Desk::new(false);
    let items = ids(SCALES.iter().map(ToString::to_string));
    for id in ["felt_spring", "felt_wall"] {
        desk.edit_study(&format!("question = \"{id}\""), &format!("questions = [{items}]"));
    }
    let mut more = String::new();
    for scale in SCALES {
        write!(more, "[[questions]]\nid = \"{scale}\"\ntext = \"{scale}\"\n").unwrap();
    }
    write!(
        more,
        "[[scores]]\nid = \"load\"\nkind = \"nasa_tlx\"\nquestions = [{items}]\npairs = \"Which of the two?\"\n"
    )
    .unwrap();
    append(&desk.root().join("raw/small/study.toml"), &more);
    let trials = "start\n1\n2\n3\n4\n5\n1\n".repeat(TRIALS);
    let lines = trials + &"2\n".repeat(15) + "quit\n";
    desk.acquire(&lines, &[]).exits(0);
    desk
}

/// The trials that count, each with its score.
fn loads(desk: &Desk) -> Vec<(i64, Option<f64>)> {
    zwidth(desk.root(), &["run", "--only", "likert"]).exits(0);
    let scores = Table::from_parquet(&desk.root().join("derived/small/scores.parquet")).unwrap();
    let trials = scores.integers("trial").unwrap().into_iter().flatten();
    let mut rows: Vec<_> = trials.zip(scores.floats("value").unwrap()).collect();
    rows.sort_by_key(|(trial, _)| *trial);
    rows
}

#[test]
fn pairs_outlive_the_trial_that_they_followed_and_another_order_of_the_list() {
    let desk = weighed();
    let before = loads(&desk);
    assert_eq!(before.len(), 6);
    assert!(before.iter().all(|(_, load)| load.is_some()), "{before:?}");
    let last = ["--trial", "7", "the phone rang"];
    let session = ["exclude", "small", "-p", "P01", "-s", "S01"];
    zwidth(desk.root(), &[&session[..], &last].concat()).exits(0);
    assert_eq!(loads(&desk), before[..5]);
    let list = |of: Vec<&str>| ids(of.into_iter().map(str::to_owned));
    let [forwards, backwards] = [SCALES.to_vec(), SCALES.into_iter().rev().collect()].map(list);
    desk.edit_study(
        &format!("questions = [{forwards}]\npairs"),
        &format!("questions = [{backwards}]\npairs"),
    );
    desk.verify();
    let turned = loads(&desk);
    assert_eq!(turned.len(), 5);
    for ((_, found), (_, expected)) in turned.iter().zip(&before) {
        assert!((found.unwrap() - expected.unwrap()).abs() < 1e-9, "{turned:?} {before:?}");
    }
}

#[test]
fn a_pair_is_answered_later_with_the_trial_that_has_the_others_alone() {
    let desk = weighed();
    let answer = |trial: &str| {
        let session = ["answer", "small", "-p", "P01", "-s", "S01"];
        let pair = ["--question", "effort_or_mental", "--trial", trial, "1"];
        zwidth(desk.root(), &[&session[..], &pair].concat())
    };
    let words = "the pairs of score load are asked once in the session, and belong to trial 7";
    answer("4").exits(1).one_error().says(&[words]);
    answer("7").exits(0).prints(&["trial 7: effort_or_mental is answered with 1"]);
    let loads = loads(&desk);
    assert!(loads.len() == 6 && loads.iter().all(|(_, load)| load.is_some()), "{loads:?}");
}
