//! `zwidth trade` as a person types it.

#![allow(clippy::unwrap_used)] // helpers outside of a test function are test code too

mod common;

use common::{fresh, text, zwidth};
use std::path::{Path, PathBuf};

/// A fifth of a second of the thesis' sine, in a folder of its own.
fn laid_down(name: &str) -> (PathBuf, PathBuf) {
    let root = fresh(name);
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/sine.toml");
    let text = std::fs::read_to_string(scene).unwrap();
    let short = text
        .replace("duration_s = 4.0", "duration_s = 0.2")
        .replace("step_s = 0.0083", "step_s = 0.002");
    let path = root.join("short.toml");
    std::fs::write(&path, short).unwrap();
    (root, path)
}

#[test]
fn a_scene_gives_tables_a_figure_times_and_a_scene_file_that_runs_and_is_not_made_twice() {
    let (root, scene) = laid_down("trade_short");
    let scene = scene.to_str().unwrap();
    let first = zwidth(&root, &["trade", scene]);
    assert_eq!(first.status.code(), Some(0), "{}", text(&first.stderr));
    assert!(text(&first.stdout).contains("Yardstick proven"), "{}", text(&first.stdout));
    let reports = root.join("reports/trade");
    for name in
        ["trade.svg", "trade.parquet", "trade.summary.csv", "timing.csv", "recommended.toml"]
    {
        assert!(reports.join(format!("short.{name}")).exists(), "{name}");
    }
    let recommended = reports.join("short.recommended.toml");
    let run = zwidth(&root, &["simulate", recommended.to_str().unwrap()]);
    assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
    let again = zwidth(&root, &["trade", scene]);
    assert!(text(&again.stdout).contains("short: up to date"), "{}", text(&again.stdout));
}

#[test]
fn a_scene_that_makes_no_sense_is_one_error_that_names_what_is_wrong() {
    let (root, scene) = laid_down("trade_bad");
    let wrong = std::fs::read_to_string(&scene).unwrap().replace("mass_kg = 0.005", "mass_kg = -1");
    std::fs::write(&scene, wrong).unwrap();
    let output = zwidth(&root, &["trade", scene.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(1));
    assert!(text(&output.stderr).contains("plant.mass_kg is -1"), "{}", text(&output.stderr));
}
