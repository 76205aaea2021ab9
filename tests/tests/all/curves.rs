//! Whole curves compared, from recordings by formula to the test, the figure and the sentence.

use crate::binary::zwidth_line;
use crate::formulas::{import, import_of_environments, ran, record, u};
use serde_json::Value;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;
use zwidth_tables::Table;

const STUDY: &str = r#"
schema = 2
[study]
id = "curves"
title = "Curves by formula"
[design]
repeats = 1
trial_limit_s = 60.0
[device]
name = "lever"
lever_m = 0.1
[[environments]]
id = "task"
label = "Spring"
kind = "spring"
stiffness_n_per_rad = 3.0
rest_deg = 0.0
[[modes]]
id = "active"
label = "Active"
[[modes]]
id = "hybrid"
label = "Hybrid"
[compare]
primary = "force_mean_n"
metrics = []
curves = ["force_over_angle", "force_over_time", "velocity_over_angle"]
"#;

/// The difference of a person's forces at a node of 51: that of the stored curves, of which crates/stats has the
/// numbers of spm1d.
fn difference(person: u64, node: f64) -> f64 {
    let waves = (1..=4)
        .map(|k| u(&[person, k]) * (k as f64 * PI * node / 50.0 + 6.0 * u(&[person, k, 1])).cos());
    0.7 * (-(node - 18.0).powi(2) / 60.0).exp() + 0.2 * u(&[person]) + 0.6 * waves.sum::<f64>()
}

fn table(root: &Path, name: &str) -> Table {
    let folder = root.join("derived/curves/compare");
    Table::from_parquet(&folder.join(name).with_extension("parquet")).unwrap()
}

fn number(table: &Table, column: &str, row: usize) -> f64 {
    table.floats(column).unwrap()[row].unwrap()
}

#[test]
fn whole_curves_of_forces_are_compared_over_angle_and_time() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    for person in 1..=8_u64 {
        for mode in ["active", "hybrid"] {
            let who = format!("P{person:02}");
            record(root, [&who, mode, "1"], 30.0, |t| {
                let angle = 30.0 * (PI * t).sin().powi(2);
                let more =
                    if mode == "hybrid" { difference(person, angle / 30.0 * 50.0) } else { 0.0 };
                0.05 * angle + 0.3 * u(&[person, 9]) + more
            });
        }
    }
    import(root, "curves", STUDY, "[[column]]\nto = \"force_ex_n\"");
    ran(root, "run curves --quiet");
    let tests = table(root, "curve_tests");
    let verdicts = tests.texts("verdict").unwrap();
    let verdicts: Vec<&str> = verdicts.iter().map(|own| own.as_deref().unwrap()).collect();
    // The lever moves alike in both modes.
    assert_eq!(verdicts, ["different", "different", "not tested"]);
    let remarks = tests.texts("remark").unwrap();
    assert!(remarks[2].as_ref().unwrap().contains("are equal"), "{remarks:?}");
    for row in [0, 1] {
        assert!((number(&tests, "p_adjusted", row) - 2.0 / 256.0).abs() < 1e-12);
    }
    // Node 19 of 51 over 30° is 11.4°; samples lie coarser than nodes.
    let found = ["largest_t", "theta_rad", "band_t"].map(|name| number(&tests, name, 0));
    assert!((found[0] - 8.99).abs() < 0.4 && (found[1].to_degrees() - 11.4).abs() < 1.0);
    assert!((found[2] - 3.953).abs() < 0.1, "{found:?}");
    let runs = table(root, "curve_runs");
    let [low, high] = ["theta_low_rad", "theta_high_rad"]
        .map(|name| number(&runs, name, 0).to_degrees() / 30.0 * 50.0);
    assert!((low - 11.0).abs() < 1.0 && (high - 25.0).abs() < 1.0, "{low} {high}");
    let reports = root.join("reports/curves");
    let summary = fs::read_to_string(reports.join("summary.md")).unwrap();
    assert!(
        summary.contains(
            "user's force over the angle, Hybrid − Active: there is a difference somewhere"
        )
    );
    assert!(reports.join("figures/curves.force_over_angle.task.pdf").exists());
    power(root);
    let methods = ran(root, "methods curves").out;
    assert!(methods.contains("Whole curves (user's force over the angle; "), "{methods}");
    // A curve that study.toml leaves out is compared no more.
    let study = STUDY.replace("curves = [", "curves = [] #");
    fs::write(root.join("raw/curves/study.toml"), study).unwrap();
    ran(root, "run curves --quiet");
    assert!(!ran(root, "methods curves").out.contains("Whole curves"));
}

/// A difference along a whole curve is planned with the curves of the eight people.
fn power(root: &Path) {
    let line = "power curves --curve force_over_angle --difference 0.16 --studies 100";
    let found = |more: &str| -> Value {
        serde_json::from_str(&ran(root, &format!("{line} --json{more}")).out).unwrap()
    };
    let (all, part) = (found(""), found(" --between 10,12"));
    assert_eq!(all["metric"], "force_over_angle");
    assert_eq!((&all["alpha"], &all["participant_sd"]), (&Value::from(0.05), &Value::Null));
    let source = all["source"].as_str().unwrap();
    assert!(source.contains("Hybrid − Active: what 8 participants differ in most; SYNTHETIC"));
    let from = part["between"][0].as_f64().unwrap();
    assert!((from.to_degrees() - 10.0).abs() < 1e-12, "{from}");
    let [of_all, of_part] = [all, part]
        .map(|own| ["power", "smallest_difference"].map(|key| own[key].as_f64().unwrap()));
    assert!(of_all[0] > of_part[0] && of_all[1] < of_part[1], "{of_all:?} {of_part:?}");
    let told = ran(root, &format!("{line} --between 10,12"));
    told.prints(&[
        "if two modes differ by 0.16 between 10° and 12°",
        "tested by flipped signs at a level of 0.05",
    ]);
    for (more, why) in [
        ("--between 80,90", "no place that all participants reach"),
        ("--between 12,10", "the smaller one first"),
        ("--participants 500", "at most 200"),
        ("--effect motor", "curves compares no effects"),
    ] {
        zwidth_line(root, &format!("{line} {more}")).exits(1).says(&[why]);
    }
    zwidth_line(root, "power curves --curve theta_over_time --difference 1")
        .exits(1)
        .says(&["curves does not compare theta_over_time"]);
}

/// One mode in two environments: nothing is compared within them, and the one with the other all the same.
#[test]
fn curves_of_one_mode_are_compared_over_environments() {
    let root = tempfile::tempdir().unwrap();
    let root = root.path();
    for person in 1..=6_u64 {
        for (environment, more) in [("soft", 0.0), ("hard", 1.0)] {
            let who = format!("P{person:02}");
            record(root, [&who, environment, "1"], 30.0, |t| {
                let angle = 30.0 * (PI * t).sin().powi(2);
                0.05 * angle
                    + 0.1 * u(&[person, 7])
                    + more * (1.0 + 0.2 * u(&[person, 9])) * angle / 30.0
            });
        }
    }
    let of = |id: &str| {
        format!(
            "[[environments]]\nid = \"{id}\"\nlabel = \"{id}\"\nkind = \"spring\"\nstiffness_n_per_rad = 3.0\nrest_deg = 0.0\n"
        )
    };
    let environment =
        &STUDY[STUDY.find("[[environments]]").unwrap()..STUDY.find("[[modes]]").unwrap()];
    let study = STUDY
        .replace(environment, &(of("soft") + &of("hard")))
        .replace("[[modes]]\nid = \"hybrid\"\nlabel = \"Hybrid\"\n", "");
    let weighted = "[[compare.weighted]]\nid = \"harder\"\nweights = { \"hard/active\" = 1, \"soft/active\" = -1 }\n";
    import_of_environments(root, "curves", &(study + weighted), "active");
    ran(root, "run curves --quiet");
    let tests = table(root, "curve_tests");
    let effects = tests.texts("effect").unwrap();
    assert_eq!(effects[0].as_deref(), Some("contrast harder"), "{effects:?}");
    assert_eq!(tests.texts("environment").unwrap()[0], None);
    assert_eq!(tests.texts("verdict").unwrap()[0].as_deref(), Some("different"));
    let figure = "reports/curves/figures/curves.force_over_angle.several.environments.pdf";
    assert!(root.join(figure).exists());
    let summary = fs::read_to_string(root.join("reports/curves/summary.md")).unwrap();
    assert!(
        summary.contains("Over several environments, user's force over the angle, contrast harder")
    );
}
