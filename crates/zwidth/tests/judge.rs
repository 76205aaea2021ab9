//! `zwidth judge` as a person types it.

#![allow(clippy::unwrap_used)] // helpers outside of a test function are test code too

mod common;

use common::{fresh, text, zwidth};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The scene that comes along, and a trajectory of it with this angle in degrees at each time in s.
fn laid_down(
    name: &str,
    header: &str,
    angle_deg: impl Fn(f64) -> f64,
) -> (PathBuf, String, String) {
    let root = fresh(name);
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/stick.toml");
    let mut rows = format!("{header}\n");
    for i in 0..=2000 {
        let t = 1e-3 * f64::from(i);
        let _ = writeln!(rows, "{t:.3},{:.6}", angle_deg(t));
    }
    let trajectory = root.join("theirs.csv");
    std::fs::write(&trajectory, rows).unwrap();
    (root, scene.to_str().unwrap().to_owned(), trajectory.to_str().unwrap().to_owned())
}

#[test]
fn a_lever_that_creeps_is_told_with_its_speed_and_what_to_change_and_one_that_stands_passes() {
    let (root, scene, theirs) = laid_down("judge_creep", "t_s,theta_deg", |t| 3.0 * t);
    let judge = ["judge", &scene, "--trajectory", &theirs];
    let output = zwidth(&root, &judge);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(3), "{said}{}", text(&output.stderr));
    assert!(said.contains("creeps") && said.contains("at 3.0000°/s"), "{said}");
    assert!(!said.contains("noslip"), "nobody said which program it was: {said}");
    let named = zwidth(&root, &[&judge[..], &["--engine", "MuJoCo"]].concat());
    assert!(text(&named.stdout).contains("noslip_iterations"), "{}", text(&named.stdout));
    let json = zwidth(&root, &[&["--json"], &judge[..]].concat());
    let found: serde_json::Value = serde_json::from_str(&text(&json.stdout)).unwrap();
    let creep = found["tables"][1]["rows"][0]["creep_rad_s"].as_f64().unwrap();
    assert!((creep.to_degrees() - 3.0).abs() < 1e-4, "{creep}");
    let (root, scene, theirs) = laid_down("judge_stand", "t_s,theta_deg", |_| 0.0);
    let output = zwidth(&root, &["judge", &scene, "--trajectory", &theirs]);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
    assert!(text(&output.stdout).contains("stands"), "{}", text(&output.stdout));
}

#[test]
fn a_file_that_is_no_trajectory_of_the_scene_is_one_error() {
    for (name, header, angle, words) in [
        ("judge_no_angle", "t_s,something", 0.0, "no column of the angle was found"),
        ("judge_ms", "t_ms,theta_deg", 0.0, "it ends at 0.002 s, and the scene at 2 s"),
        ("judge_start", "t_s,theta_deg", 5.0, "it starts with θ = 0.087"),
    ] {
        let (root, scene, theirs) = laid_down(name, header, |_| angle);
        let output = zwidth(&root, &["judge", &scene, "--trajectory", &theirs]);
        let said = text(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains(words) && said.contains("theirs.csv"), "{said}");
    }
}

#[test]
fn trajectories_of_a_table_stand_beside_our_solvers() {
    let (root, scene, _) = laid_down("judge_table", "t_s,theta_deg", |t| 3.0 * t);
    let short = root.join("short.toml");
    let scene =
        std::fs::read_to_string(scene).unwrap().replace("duration_s = 2.0", "duration_s = 0.2");
    std::fs::write(&short, scene).unwrap();
    let table = root.join("table.csv");
    std::fs::write(
        &table,
        "name,setting,file,cost_s\nsmooth,1 ms,theirs.csv,0.01\nlost,,none.csv,\n",
    )
    .unwrap();
    let [short, table] = [short, table].map(|path| path.to_str().unwrap().to_owned());
    let output = zwidth(&root, &["trade", &short, "--trajectories", &table]);
    let said = text(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{said}{}", text(&output.stderr));
    assert!(said.contains("smooth, 1 ms: creeps") && said.contains("Not judged: "), "{said}");
    assert!(said.contains("Under half its friction the lever stands by exact"), "{said}");
    for name in ["others.svg", "others.csv", "others.faults.csv", "trade.creep.csv"] {
        assert!(root.join(format!("reports/trade/short.{name}")).exists(), "{name}");
    }
}
