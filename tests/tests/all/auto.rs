//! `[replay] model = "auto"` on a whole study: the ladder of its condition, its choice held against
//! the recordings, and the replays by that choice.

use crate::binary::{zwidth, zwidth_line};
use std::fs;
use std::path::Path;
use tempfile::TempDir;
use zwidth_tables::Table;

/// One condition, four short repeats: a ladder is a hundred models at 64 points.
const STUDY: &str = r#"
schema = 2
[study]
id = "auto"
title = "One condition"
[design]
repeats = 4
familiarisation = 0
trial_limit_s = 1.0
pause_s = 1.0
order = "constrained"
blinded = false
[coordinate]
kind = "rotational"
[device]
name = "simulated"
lever_m = 0.045
theta_min_deg = -45.0
theta_max_deg = 45.0
force_rate_hz = 80.0
[control]
rate_hz = 120.0
[replay]
model = "auto"
[[environments]]
id = "spring"
label = "Spring"
kind = "spring"
stiffness_n_per_rad = 4.0
rest_deg = -45.0
[[modes]]
id = "active"
label = "Active"
motor_max_v = 16.0
"#;

fn recorded() -> TempDir {
    let root = tempfile::tempdir().unwrap();
    let raw = root.path().join("raw/auto");
    fs::create_dir_all(&raw).unwrap();
    fs::write(raw.join("study.toml"), STUDY).unwrap();
    zwidth_line(root.path(), "twin auto --participants 1 --sessions 1 --seed 1").exits(0);
    root
}

fn table(root: &Path, name: &str) -> Table {
    Table::from_parquet(&root.join("derived/auto").join(name)).unwrap()
}

#[test]
fn a_study_s_recordings_say_whether_they_bear_its_ladder_out_and_are_replayed_by_its_choice() {
    let root = recorded();
    let root = root.path();
    let ran = zwidth(root, &["run", "auto", "--only", "ladder", "--json"]).exits(0);
    for job in ["ladder spring.active", "ladder held out spring.active", "ladder of the study"] {
        assert!(ran.made().contains(&job.to_owned()), "{job}: {ran:#?}");
    }
    let tried = table(root, "ladder/spring.active.held_out.parquet");
    let models: Vec<String> = tried.texts("model").unwrap().into_iter().flatten().collect();
    assert_eq!((models[0].as_str(), models[models.len() - 1].as_str()), ("choice", "fullest"));
    let errors = tried.floats("held_out_rmse_rad").unwrap();
    let felt = tried.floats("felt_share").unwrap();
    let (choice, fullest) = (errors[0].unwrap(), errors[models.len() - 1].unwrap());
    assert!(felt[0].unwrap() < 1.0, "{felt:?}: the choice is off by less than can be felt");
    assert!(choice < 1.1 * fullest, "{choice} rad, and {fullest} by the fullest");
    let without = models.iter().position(|model| model == "without friction").unwrap();
    assert!(errors[without].unwrap() > choice, "friction is missed: {errors:?}");
    let study = table(root, "ladder.parquet");
    assert_eq!(study.height(), 1);
    assert!(study.texts("recordings").unwrap()[0].is_some());
    zwidth(root, &["run", "auto", "--only", "replay"]).exits(0);
    let replays = table(root, "replay/P01.S01.spring.active.auto.parquet");
    assert_eq!(replays.height() % 4, 0, "a row a trial and a way of driving");
    assert!(replays.height() > 0);
}
