//! Facts of recordings made by others, in the folder that `ZWIDTH_REAL_DATA` names.

use crate::characteristic::tests::settings;
use crate::{Characteristic, Settings, Sweep, characterise, first_order};
use std::path::PathBuf;
use zwidth_results::{CandidateVerdict, CurveModel};

/// Rows of numbers of a comma-separated file under the folder of real recordings; `skip` header
/// lines; empty cells end a row.
fn rows(file: &str, skip: usize) -> Vec<Vec<f64>> {
    let folder = std::env::var_os("ZWIDTH_REAL_DATA").expect("ZWIDTH_REAL_DATA names a folder");
    let text = std::fs::read_to_string(PathBuf::from(folder).join(file)).unwrap();
    let parse = |line: &str| line.split(',').map_while(|cell| cell.trim().parse().ok()).collect();
    text.lines().skip(skip).filter(|line| !line.trim().is_empty()).map(parse).collect()
}

fn column(rows: &[Vec<f64>], j: usize) -> Vec<f64> {
    rows.iter().map(|row| row[j]).collect()
}

fn check(command: &[f64], response: &[f64], units: (&str, &str)) -> Characteristic {
    let settings = Settings {
        command_unit: units.0.to_owned(),
        response_unit: units.1.to_owned(),
        ..settings(400, 1)
    };
    let found = characterise(&[Sweep { command, response }], &settings).unwrap();
    for candidate in &found.candidates {
        let name = candidate.name.as_str();
        println!("{name}: {:?}, {} {:?}", candidate.verdict, candidate.reason, candidate.quality);
        for p in &candidate.parameters {
            println!(
                "  {} = {} {} [{:?}, {:?}] {:?}",
                p.parameter.as_str(),
                p.estimate,
                p.unit,
                p.ci_low,
                p.ci_high,
                p.note
            );
        }
    }
    println!("noise {:?}; {}", found.noise, found.reason);
    found
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_motor_of_the_haptic_paddle_has_the_published_line() {
    let rows = rows("ethz_haptic_paddle/motor/motor_voltage_current_torque.csv", 1);
    let (voltage, current) = (column(&rows, 0), column(&rows, 1));
    let line = first_order(&[Sweep { command: &voltage, response: &current }], 0.95).unwrap();
    assert!((line.slope.estimate + 0.42852).abs() < 5e-6);
    assert!((line.intercept.estimate - 1.06768).abs() < 5e-6);
    let found = check(&voltage, &current, ("V", "A"));
    assert_eq!(found.candidates[found.chosen].name, CurveModel::Line);
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_load_cell_of_the_haptic_paddle_has_the_published_line() {
    let rows = rows("ethz_haptic_paddle/force_sensor/transfer_function_put_together.csv", 1);
    let masses_kg = [0.0, 0.085, 0.196, 0.482, 0.553, 0.718, 1.062];
    let used = &rows[..1414];
    let volts: Vec<f64> = (0..7).map(|j| column(used, j).iter().sum::<f64>() / 1414.0).collect();
    let force_n = masses_kg.map(|m| m * 9.81);
    let line = first_order(&[Sweep { command: &volts, response: &force_n }], 0.95).unwrap();
    assert!((line.slope.estimate - 3.5855).abs() < 5e-5);
    assert!((line.intercept.estimate - (0.057404 - 3.5855 * 0.118712)).abs() < 5e-5);
    let found = check(&volts, &force_n, ("V", "N"));
    assert_eq!(found.candidates[found.chosen].name, CurveModel::Line);
    assert_eq!(found.candidates[3].verdict, CandidateVerdict::NotFitted);
}

#[test]
#[ignore = "needs recordings made by others: set ZWIDTH_REAL_DATA, add --include-ignored"]
fn the_particle_brake_is_a_power_law_above_a_break() {
    let rows = rows("brake_b5zd/test_rig_treadmill.csv", 0);
    let (counts, adc) = (column(&rows, 0), column(&rows, 1));
    let torque_mnm: Vec<f64> =
        adc.iter().map(|a| -(20.0 / 4095.0) * (a - adc[0]) * 7.0616).collect();
    let found = check(&counts, &torque_mnm, ("counts", "mN·m"));
    let named = |name: &str| found.candidates.iter().find(|c| c.name.as_str() == name).unwrap();
    for (name, rms, verdict) in [
        ("line", 3.086, CandidateVerdict::Rejected),
        ("hinge", 1.340, CandidateVerdict::Rejected),
        ("power_law", 0.326, CandidateVerdict::Chosen),
    ] {
        let candidate = named(name);
        assert!((candidate.quality.unwrap().rms - rms).abs() < 5e-4, "{candidate:?}");
        assert_eq!(candidate.verdict, verdict);
    }
    assert!(found.candidates.iter().all(|c| !c.name.has_hysteresis()), "one upward sweep");
}
