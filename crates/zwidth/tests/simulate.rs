//! `zwidth simulate` as a person types it: exit codes, and files where they belong.

#![allow(clippy::unwrap_used)] // helpers outside of a test function are test code too

mod common;

use common::{fresh, text, zwidth};
use std::path::{Path, PathBuf};
use std::process::Output;

fn scene(stem: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(format!("{stem}.toml"))
}

fn simulate(root: &Path, arguments: &[&str]) -> Output {
    zwidth(root, &[&["simulate"], arguments].concat())
}

#[test]
fn two_scenes_give_their_own_files_and_those_they_share() {
    let root = fresh("two_scenes");
    let scenes = [scene("ramp"), scene("step")].map(|path| path.to_str().unwrap().to_owned());
    let output = simulate(&root, &[&scenes[0], &scenes[1]]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(text(&output.stdout).contains("verdict   smooth"));
    let reports = root.join("reports/simulate");
    for name in ["ramp", "step", "ramp+step", "ramp+step.inputs"] {
        for extension in ["svg", "pdf", "png"] {
            assert!(reports.join(format!("{name}.{extension}")).exists(), "{name}.{extension}");
        }
    }
    for name in ["ramp.trajectory", "ramp.events", "step.trajectory", "step.events"] {
        assert!(
            reports.join(format!("{name}.parquet")).exists()
                && reports.join(format!("{name}.csv")).exists()
        );
    }
    let svg = std::fs::read_to_string(reports.join("ramp.svg")).unwrap();
    assert!(svg.contains("aria-label=\"SIMULATION: a model run\""), "the figure says what it is");
    assert!(svg.contains("stiffness_n_per_rad"), "the scene stands in the figure, word for word");
}

#[test]
fn a_bad_scene_among_good_ones_is_told_with_file_and_line_and_skipped() {
    let root = fresh("bad_scene");
    let good = scene("step");
    let bad = root.join("bad.toml");
    let wrong = std::fs::read_to_string(&good).unwrap().replace("mass_kg = 0.005", "mass_kg = -1");
    std::fs::write(&bad, &wrong).unwrap();
    let line = wrong.lines().position(|line| line.starts_with("mass_kg")).unwrap() + 1;
    let expect = format!("bad.toml:{line}: plant.mass_kg is -1");
    let both = simulate(&root, &[good.to_str().unwrap(), bad.to_str().unwrap()]);
    assert_eq!(both.status.code(), Some(3));
    assert!(text(&both.stderr).contains(&expect), "{}", text(&both.stderr));
    assert!(root.join("reports/simulate/step.png").exists());
    let alone = simulate(&root, &[bad.to_str().unwrap()]);
    assert_eq!(alone.status.code(), Some(1));
    assert!(text(&alone.stderr).contains(&expect));
}

#[test]
fn bad_arguments_end_with_two() {
    let root = fresh("bad_arguments");
    let good = scene("step");
    for arguments in [["--solver", "rk5"], ["--step", "0"], ["--tolerance", "nan"]] {
        let output = simulate(&root, &[&arguments[..], &[good.to_str().unwrap()]].concat());
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn a_bow_tie_is_drawn_instead_of_a_run() {
    let root = fresh("bow_tie");
    let scene = scene("two_actuators");
    let out = root.join("elsewhere");
    let output =
        simulate(&root, &[scene.to_str().unwrap(), "--bow-tie", "--out", out.to_str().unwrap()]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert!(out.join("two_actuators.bow_tie.png").exists());
    assert!(!out.join("two_actuators.png").exists());
}
