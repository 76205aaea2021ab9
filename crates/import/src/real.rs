//! The four real sets, with the mappings in `studies/`. They are outside the project: these tests
//! read them if `ZWIDTH_REAL_DATA` names their folder.

use super::world::World;
use super::{Report, convert};
use std::path::{Path, PathBuf};
use zwidth_store::{Signal, Sweep, read_sweep};

/// The study of that name, with its real recordings `files` imported by `map`.
fn imported(study: &str, map: &str, files: &[PathBuf]) -> (World, Report) {
    let data = std::env::var_os("ZWIDTH_REAL_DATA").expect("ZWIDTH_REAL_DATA names a folder");
    let ours = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../studies").join(study);
    let text = |name: &str| std::fs::read_to_string(ours.join(name)).unwrap();
    let world = World::with(&text("study.toml"));
    // Cargo runs tests in the crate's folder; a relative path is meant from the workspace's.
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(data);
    let files: Vec<PathBuf> = files.iter().map(|f| data.join(f)).collect();
    let report = world.import(&text(map), &files).unwrap_or_else(|e| panic!("{e:#?}"));
    world.load();
    (world, report)
}

fn sweep(world: &World, actuator: &str) -> Sweep {
    read_sweep(&world.layout.sweep(&actuator.parse().unwrap(), 1)).unwrap()
}

/// Ordinary least squares y = a + b x.
fn line(x: &[f64], y: &[f64]) -> (f64, f64) {
    let mx = convert::mean(x);
    let my = convert::mean(y);
    let sxy: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    let sxx: f64 = x.iter().map(|x| (x - mx) * (x - mx)).sum();
    (my - sxy / sxx * mx, sxy / sxx)
}

fn near(found: f64, expect: f64, within: f64) {
    assert!((found - expect).abs() <= within, "{found} is not {expect} within {within}");
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn ethz_gives_twelve_trials_of_torque_acceleration_and_velocity_at_200_hz() {
    let sessions = [9, 10, 11, 12];
    let modes = ["uncontrolled", "fg_compensated", "force_feedback"];
    let file = |s: u8, m: &str| {
        PathBuf::from(format!("ethz_haptic_paddle/transparency/session_{s}/{m}.csv"))
    };
    let files: Vec<PathBuf> = sessions.iter().flat_map(|s| modes.map(|m| file(*s, m))).collect();
    let (world, report) = imported("ethz", "map-transparency.toml", &files);
    assert_eq!((report.trials, report.sessions), (12, 4));
    assert_eq!(report.files.iter().map(|f| f.rows_kept).sum::<usize>(), 56_121);
    // The last of its session by the names of the files.
    let trial = world.trial("P01", "S09", 3);
    assert_eq!((trial.meta.mode.as_str(), trial.samples.len()), ("uncontrolled", 5039));
    for lacking in [Signal::Theta, Signal::ForceEx] {
        assert_eq!(trial.samples.get(lacking), None);
    }
    near(trial.samples.get(Signal::Time).unwrap()[200], 1.0, 1e-15);
    near(trial.samples.get(Signal::TorqueEx).unwrap()[2], 57e-6, 1e-18);
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn ethz_motor_has_the_published_line() {
    let files = ["ethz_haptic_paddle/motor/motor_voltage_current_torque.csv".into()];
    let (world, report) = imported("ethz", "map-motor.toml", &files);
    let dropped = &report.files[0].columns_dropped[0];
    assert_eq!(dropped.why, "computed from the current, not measured");
    let sweep = sweep(&world, "motor");
    assert_eq!((sweep.command.unit.as_str(), sweep.response.unit.as_str()), ("V", "A"));
    let (a, b) = line(&sweep.command_values, &sweep.response_values);
    near(b, -0.42852, 5e-6);
    near(a, 1.06768, 5e-6);
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn ethz_load_cell_has_the_published_line() {
    let files = ["ethz_haptic_paddle/force_sensor/transfer_function_put_together.csv".into()];
    let (world, report) = imported("ethz", "map-load-cell.toml", &files);
    assert_eq!((report.files[0].rows_read, report.files[0].rows_kept), (2482, 1414));
    let sweep = sweep(&world, "load_cell");
    assert_eq!(sweep.command_values.len(), 7);
    assert!(sweep.file["made_by_import"].contains("command = mean of 1414 rows"));
    let (a, b) = line(&sweep.command_values, &sweep.response_values);
    near(b, 3.5855, 5e-5);
    near(a + b * 0.118_712, 0.057_404, 5e-6);
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn tsa_gives_six_springs_that_are_a_little_stiffer_than_commanded() {
    let stiffness = ["0.1", "0.2", "0.6", "1", "2", "3.5"];
    let files = stiffness.map(|k| PathBuf::from(format!("tsa_virtual_spring/K_{k}.csv")));
    let (world, report) = imported("tsa", "map.toml", &files);
    assert_eq!((report.trials, report.sessions), (6, 1));
    for (n, k) in (1..).zip(stiffness) {
        let samples = world.trial("P01", "S01", n).samples;
        let of = |signal| samples.get(signal).unwrap();
        let (x, f) = (of(Signal::Theta), of(Signal::ForceEx));
        let top = (0..x.len()).max_by(|a, b| x[*a].total_cmp(&x[*b])).unwrap();
        let loading: Vec<usize> = (0..=top).filter(|i| x[*i] > 0.5e-3).collect();
        let pick = |values: &[f64]| loading.iter().map(|i| values[*i] * 1e3).collect::<Vec<_>>();
        let (_, slope) = line(&pick(x), &pick(f));
        let excess = slope * 1e-3 - k.parse::<f64>().unwrap();
        // 0.17 … 0.21 N/mm, as rounded to two digits.
        assert!((0.165..0.215).contains(&excess), "K = {k}: {excess}");
        let (_, commanded) = line(&pick(x), &pick(of(Signal::ForceCmd)));
        near(commanded * 1e-3, k.parse().unwrap(), 0.15 * k.parse::<f64>().unwrap());
        assert!(samples.get(Signal::ThetaDot).unwrap().iter().all(|v| v.abs() < 1.0));
    }
    let made = &world.trial("P01", "S01", 1).file["made_by_import"];
    assert!(made.contains("theta_dot_rad_s = derivative of theta_rad"), "{made}");
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn brake_b5zd_gives_one_sweep_of_counts_against_torque() {
    let files = ["brake_b5zd/test_rig_treadmill.csv".into()];
    let (world, _) = imported("brake_b5zd", "map.toml", &files);
    let sweep = sweep(&world, "brake");
    assert_eq!((sweep.command.unit.as_str(), sweep.response.unit.as_str()), ("counts", "mN·m"));
    assert_eq!(sweep.response_values.len(), 6554);
    near(sweep.response_values[0], 0.0, 0.0);
    near(sweep.response_values.iter().copied().fold(0.0, f64::max), 47.0, 0.5);
    let (a, b) = line(&sweep.command_values, &sweep.response_values);
    let squares = sweep
        .command_values
        .iter()
        .zip(&sweep.response_values)
        .map(|(x, y)| (y - a - b * x).powi(2));
    near((squares.sum::<f64>() / 6554.0).sqrt(), 3.09, 0.005);
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn likert_vr_shoes_gives_3600_answers_in_80_trials_without_samples() {
    let files = ["likert_vr_shoes/UXdata2023-04-28.csv".into()];
    let (world, report) = imported("likert_vr_shoes", "map.toml", &files);
    assert_eq!((report.trials, report.sessions, report.answers), (0, 20, 3600));
    assert_eq!(report.files[0].columns_dropped.len(), 17);
    let data = world.load();
    assert_eq!(data.study.questions.iter().filter(|q| q.reversed).count(), 17);
    let answers = data.answers;
    assert_eq!(answers.len(), 3600);
    // The file's first row: participant 1, STF first; 5 to the first item, 1 to the second.
    let first = answers.iter().find(|a| a.question.as_str() == "q01").unwrap();
    assert_eq!((first.participant.as_str(), first.trial, first.value), ("P01", 1, 5.into()));
    assert_eq!(first.condition.mode.as_str(), "STF");
}
