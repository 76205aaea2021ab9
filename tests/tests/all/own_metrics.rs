//! A metric of a study's own, from recordings by formula to the table and the methods text.

use crate::binary::zwidth_line;
use crate::formulas::{import, ran, record};
use serde_json::Value;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

pub(crate) const STUDY: &str = r#"
schema = 2
[study]
id = "grips"
title = "Grips"
[design]
repeats = 1
trial_limit_s = 60.0
[device]
name = "handle"
[[environments]]
id = "task"
label = "Task"
kind = "none"
[[modes]]
id = "firm"
label = "Firm"
[[modes]]
id = "soft"
label = "Soft"
[[channels]]
id = "grip_n"
unit = "N"
description = "force of the grip"
[[metrics]]
id = "grip_max_n"
of = "grip_n"
statistic = "max"
over = "recording"
label = "largest grip"
unit = "N"
better = "lower"
[compare]
primary = "grip_max_n"
"#;

/// Five people whose grips swell to 3 N and a tenth of their number where the handle is firm, and to 2 N
/// and as much where it is soft, but for P03, who swells by half a newton more there.
fn grips(root: &Path) {
    grips_of(root, STUDY);
}

/// The same recordings in a study of that text.
pub(crate) fn grips_of(root: &Path, study: &str) {
    for person in 1..=5 {
        for (mode, largest) in [("firm", 3.0), ("soft", if person == 3 { 2.5 } else { 2.0 })] {
            let largest = largest + 0.1 * f64::from(person);
            let who = format!("P{person:02}");
            record(root, [&who, mode, "1"], 20.0, |t| largest * (PI * t).sin());
        }
    }
    import(root, "grips", study, "[[channel]]\nto = \"grip_n\"");
}

#[test]
fn a_metric_of_a_studys_own_is_compared_said_and_made_again_when_its_rule_changes() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    grips(root);
    let compared = || -> Value {
        let tables = ran(root, "compare grips --json").json();
        let all = tables.as_array().unwrap().iter();
        let found = all.clone().find(|t| t["table"] == "contrasts_grip_max_n").unwrap();
        found["rows"][0].clone()
    };
    let row = compared();
    let number = |row: &Value, column: &str| row[column].as_f64().unwrap();
    // Soft less firm: −1, but for P03's −0.5.
    assert!((number(&row, "difference_n") + 0.9).abs() < 1e-9, "{row}");
    assert!((number(&row, "statistic") + 9.0).abs() < 1e-6, "{row}");
    assert_eq!(row["n"], 5);
    ran(root, "methods grips").prints(&["largest grip: maximum of grip"]);
    // The mean of a half sine is 2/π of its largest value, by trapezoids a little less.
    let study = STUDY.replace("statistic = \"max\"", "statistic = \"mean\"");
    fs::write(root.join("raw/grips/study.toml"), study).unwrap();
    let mean = number(&compared(), "difference_n") / -0.9;
    assert!((mean - 2.0 / PI).abs() < 3e-4, "{mean}");
}

#[test]
fn a_metric_whose_name_is_taken_is_told_and_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    grips(root);
    let study = STUDY.replace("grip_max_n", "recording_s");
    fs::write(root.join("raw/grips/study.toml"), study).unwrap();
    let verified = zwidth_line(root, "verify grips").exits(1);
    verified.prints(&["'recording_s' is a column of the tables already"]);
}
