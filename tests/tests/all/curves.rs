//! Whole curves compared, from recordings by formula to the test, the figure and the sentence.

use crate::formulas::{import, ran, record, u};
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
    let methods = ran(root, "methods curves").out;
    assert!(methods.contains("Whole curves (user's force over the angle; "), "{methods}");
    // A curve that study.toml leaves out is compared no more.
    let study = STUDY.replace("curves = [", "curves = [] #");
    fs::write(root.join("raw/curves/study.toml"), study).unwrap();
    ran(root, "run curves --quiet");
    assert!(!ran(root, "methods curves").out.contains("Whole curves"));
}
