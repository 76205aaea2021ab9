//! Facts about the committed scenes: they give what the thesis says about its figures.

use crate::{DEFAULT_TOLERANCE, Run, bow_tie, model_events, model_run, simulate, solver};
use std::path::{Path, PathBuf};
use zwidth_dynamics::{DriveMode, FingerLaw, Input, ModelScene, RunVerdict, table3};
use zwidth_results::ModelSample;
use zwidth_tables::Table;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

fn scene(stem: &str) -> ModelScene {
    ModelScene::from_toml(&std::fs::read_to_string(folder().join(format!("{stem}.toml"))).unwrap())
        .unwrap()
}

fn stems() -> Vec<String> {
    let files = std::fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path());
    let scenes = files.filter(|path| path.extension().is_some_and(|e| e == "toml"));
    let mut stems: Vec<String> =
        scenes.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    stems.sort();
    stems
}

/// The scene whose lever sticks.
pub(crate) fn sticking() -> ModelScene {
    table3::scene(DriveMode::Hybrid, Input::sine(2.15))
}

pub(crate) fn run(scene: ModelScene, name: &str) -> Run {
    simulate(scene, solver(name, DEFAULT_TOLERANCE).unwrap().as_ref()).unwrap()
}

fn column(run: &Run, get: fn(&ModelSample) -> f64) -> Vec<f64> {
    model_run(run).samples.iter().map(get).collect()
}

/// Runs a scene exactly and sees to it that its table can be made: that refuses what is not finite.
fn check(stem: &str, scene: ModelScene) {
    let samples = (scene.duration_s / scene.step_s).ceil() as usize + 1;
    let run = run(scene, "exact");
    assert_eq!(Table::of_run(&model_run(&run)).unwrap().height(), samples, "{stem}");
    assert!(Table::of_rows(&model_events(&run)).unwrap().height() > 0, "{stem}");
}

#[test]
fn every_committed_scene_runs_exactly_with_either_law_of_the_finger() {
    let stems = stems();
    assert!(stems.len() >= 7, "{stems:?}");
    for stem in stems {
        for law in [FingerLaw::Thesis, FingerLaw::Consistent] {
            let mut scene = scene(&stem);
            if let Some(finger) = &mut scene.finger {
                finger.law = law;
            }
            check(&stem, scene);
        }
    }
    bow_tie(&scene("two_actuators")).unwrap();
}

#[test]
fn the_finger_s_force_is_the_user_s_until_the_tissue_is_fully_pressed_and_flattens_there() {
    let run = run(scene("sine_finger"), "exact");
    let user = column(&run, |sample| sample.force_ex_n);
    let tissue = column(&run, |sample| sample.force_tissue_n.unwrap());
    let limit = 584.6 * 0.006;
    let highest = tissue.iter().copied().fold(0.0, f64::max);
    assert!((highest - limit).abs() < 0.15 * limit && user.iter().any(|f| *f > 4.29), "{highest}");
    let bottomed = tissue.iter().filter(|f| (**f - limit).abs() < 1e-9).count();
    assert!(bottomed > 100, "only {bottomed} samples lie on the stop");
}

#[test]
fn with_the_thesis_method_the_lever_swings_between_10_and_18_degrees() {
    let theta = column(&run(scene("sine_finger"), "rk4_per_step"), |sample| sample.theta_rad);
    let highest = theta.iter().copied().fold(f64::MIN, f64::max).to_degrees();
    assert!((16.0..19.0).contains(&highest), "{highest}");
}

/// The angles, °, between which the drive turns from brake to motor and back, and how often it
/// does.
fn turns(stem: &str, solver: &str) -> (f64, f64, usize) {
    let run = run(scene(stem), solver);
    let theta = column(&run, |sample| sample.theta_rad);
    let motor = column(&run, |sample| sample.force_motor_n);
    let pulls: Vec<bool> = motor.iter().map(|force| *force != 0.0).collect();
    let turned = (1..pulls.len()).filter(|i| pulls[*i] != pulls[*i - 1] && theta[*i] > 0.0);
    let angles: Vec<f64> = turned.map(|i| theta[i].to_degrees()).collect();
    let (low, high) = angles.iter().fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(*x), b.max(*x)));
    (low, high, angles.len())
}

#[test]
fn figure_11_oscillates_between_10_and_17_degrees_by_the_thesis_method_and_not_by_the_exact_one() {
    let (low, high, count) = turns("figure_11", "rk4_per_step");
    assert!((low - 10.26).abs() < 0.3 && (high - 17.25).abs() < 0.05, "{low} to {high}");
    assert!(count > 30, "{count}");
    let (.., count) = turns("figure_11", "exact");
    assert!(count <= 3, "{count}");
}

#[test]
fn the_study_that_comes_along_has_the_scenes_word_for_word() {
    let study = folder().join("../raw/thesis-twin/scenes");
    let files: Vec<PathBuf> =
        std::fs::read_dir(study).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 8);
    for path in files {
        let read = |path: &Path| std::fs::read_to_string(path).unwrap();
        assert_eq!(read(&path), read(&folder().join(path.file_name().unwrap())), "{path:?}");
    }
}

#[test]
fn a_sudden_drop_of_the_force_leaves_no_oscillation() {
    let run = run(scene("step"), "exact");
    assert_eq!(run.judgement.swings.map(|swings| swings.count), [0; 3]);
    assert_eq!(run.judgement.verdict, RunVerdict::Smooth);
}
