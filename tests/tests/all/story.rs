//! The thesis' story (§5.3), read from the tables that the main job derives of simulated studies:
//! on the study that comes along, and with each assumed number of the simulated device at either
//! end of its range.

use crate::binary::{zwidth, zwidth_line};
use crate::shipped;
use std::fs;
use std::path::Path;
use zwidth_device::TwinParameters;
use zwidth_store::{Layout, Signal, StudyData, read_trial};
use zwidth_study::{StudyId, template};
use zwidth_tables::Table;

/// What the motor gives at 16 V, N.
const MOTOR_N: f64 = 4.16;
/// A count of the angle sensor, at the lever, rad.
const COUNT_RAD: f64 = std::f64::consts::TAU / 4096.0 * 11.0 / 75.0;

/// The metrics of a study's trials.
struct Metrics {
    table: Table,
    of: Vec<(String, String)>,
}

impl Metrics {
    fn read(root: &Path, study: &str) -> Self {
        let table =
            Table::from_parquet(&root.join(format!("derived/{study}/metrics.parquet"))).unwrap();
        let words =
            |name| table.texts(name).unwrap().into_iter().map(Option::unwrap).collect::<Vec<_>>();
        let of = words("environment").into_iter().zip(words("mode")).collect();
        Self { table, of }
    }

    /// A number of every trial of a condition; null where it does not apply.
    fn of(&self, environment: &str, mode: &str, name: &str) -> Vec<Option<f64>> {
        let all = match self.table.floats(name) {
            Ok(numbers) => numbers,
            Err(_) => self
                .table
                .integers(name)
                .unwrap()
                .into_iter()
                .map(|n| n.map(|n| n as f64))
                .collect(),
        };
        let mine = self.of.iter().zip(all).filter(|((e, m), _)| e == environment && m == mode);
        let found: Vec<Option<f64>> = mine.map(|(_, number)| number).collect();
        assert!(!found.is_empty(), "{environment} {mode}");
        found
    }

    /// The same where every trial has it.
    fn all(&self, environment: &str, mode: &str, name: &str) -> Vec<f64> {
        self.of(environment, mode, name)
            .into_iter()
            .map(|x| x.unwrap_or_else(|| panic!("{name} is null")))
            .collect()
    }

    fn mean(&self, environment: &str, mode: &str, name: &str) -> f64 {
        let all = self.all(environment, mode, name);
        all.iter().sum::<f64>() / all.len() as f64
    }
}

/// Tells whether the tables of a study tell the story; `what` names it.
fn tells_the_story(root: &Path, study: &str, twin: &TwinParameters, rate_hz: f64, what: &str) {
    let metrics = Metrics::read(root, study);
    let each = |e: &str, m: &str, name: &str, holds: &dyn Fn(f64) -> bool| {
        let all = metrics.all(e, m, name);
        assert!(all.iter().all(|x| holds(*x)), "{what}: {e} {m}: {name} {all:?}");
    };
    for mode in ["active", "hybrid"] {
        for environment in ["spring", "spring_wall"] {
            each(environment, mode, "movements_backward", &|n| n >= 1.0);
        }
    }
    // Active, spring: the user feels the motor's 4.16 N, and friction and damping on top while
    // going in, which may fall too fast with the velocity to leave a plateau.
    let drag_n = twin.friction_static_n + 1.0;
    let is_motors = |n: &f64| *n > MOTOR_N - 0.02 && *n < MOTOR_N + drag_n;
    let felt = largest(root, study, "spring", "active", Signal::ForceEx);
    assert!(felt.iter().all(is_motors), "{what}: {felt:?}");
    let plateaus = metrics.of("spring", "active", "saturation_force_n");
    assert!(plateaus.iter().flatten().all(is_motors), "{what}: {plateaus:?}");
    // Passive: no way back, and hence nothing to compare; the work stays in the device.
    for environment in ["spring", "spring_wall"] {
        each(environment, "passive", "movements_backward", &|n| n == 0.0);
        each(environment, "passive", "returned_energy_share", &|share| share < 0.05);
        assert!(
            metrics
                .of(environment, "passive", "discrepancy_user_step_n")
                .iter()
                .all(Option::is_none),
            "{what}"
        );
    }
    // Hybrid, spring: the weaker motor takes over at the reversal.
    let step = |mode| metrics.mean("spring", mode, "discrepancy_user_step_n");
    assert!(
        step("hybrid") > step("active") + 1.0,
        "{what}: {} against {}",
        step("hybrid"),
        step("active")
    );
    // The wall: the motor is pushed past it by degrees; the brake holds.
    each("spring_wall", "active", "wall_past_max_rad", &|past| past > 2_f64.to_radians());
    for mode in ["passive", "hybrid"] {
        let past = metrics.all("spring_wall", mode, "wall_past_max_rad");
        let approach = metrics.all("spring_wall", mode, "wall_impact_velocity_rad_s");
        for (past_rad, approach_rad_s) in past.into_iter().zip(approach) {
            let most_rad = approach_rad_s * (twin.brake_on_s + 2.0 / rate_hz) + COUNT_RAD;
            assert!(
                past_rad <= most_rad,
                "{what}: {mode}: {past_rad} rad past the wall, {most_rad} allowed"
            );
        }
        each("spring_wall", mode, "wall_dwell_s", &|s| s > 0.1);
    }
}

/// The largest value of a signal in every trial of a condition.
fn largest(root: &Path, study: &str, environment: &str, mode: &str, signal: Signal) -> Vec<f64> {
    let layout = Layout::new(root, StudyId::new(study).unwrap());
    let data = StudyData::load(&layout).unwrap();
    let mine = data
        .counting()
        .filter(|t| t.meta.environment.as_str() == environment && t.meta.mode.as_str() == mode);
    let of = |path: &Path| {
        let trial = read_trial(path, [signal]).unwrap();
        trial.samples.get(signal).unwrap().iter().copied().fold(0.0, f64::max)
    };
    mine.map(|t| of(&t.path)).collect()
}

#[test]
fn the_study_that_comes_along_tells_the_thesis_story() {
    let root = shipped::folder();
    tells_the_story(root, "thesis-twin", &TwinParameters::default(), 120.0, "as it is");
    // What the voltages stand for is the calibration's last knot, to the last digit that a recording
    // keeps of a force (half of 2⁻⁴⁰ N).
    let saturated = largest(root, "thesis-twin", "spring", "active", Signal::ForceCmd);
    assert!(saturated.iter().all(|n| (n - MOTOR_N).abs() <= 0.5_f64.powi(41)), "{saturated:?}");
    assert_eq!(saturated.len(), 6);
    let hybrid = Metrics::read(root, "thesis-twin");
    let past = hybrid.all("spring_wall", "hybrid", "wall_past_max_rad");
    assert!(past.iter().all(|rad| *rad < 1_f64.to_radians()), "{past:?}");
}

/// A simulated study of each condition once, with one number of the device changed; derived as far
/// as the metrics.
fn study_with(twin_toml: &str, seed: u32, rate_hz: f64) -> tempfile::TempDir {
    let root = tempfile::tempdir().unwrap();
    let folder = root.path().join("raw/other");
    fs::create_dir_all(&folder).unwrap();
    let mut text = template(&StudyId::new("other").unwrap());
    let mut lever = String::from("lever_m = 0.045");
    if twin_toml.starts_with("lever_m") {
        lever = twin_toml.to_owned();
    } else {
        fs::write(folder.join("twin.toml"), twin_toml).unwrap();
    }
    for (from, to) in [
        ("repeats = 6", "repeats = 1".to_owned()),
        ("familiarisation = 3", "familiarisation = 0".to_owned()),
        ("lever_m = 0.045", lever),
        ("rate_hz = 1000.0", format!("rate_hz = {rate_hz:?}")),
    ] {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, &to);
    }
    fs::write(folder.join("study.toml"), text).unwrap();
    let twin = format!("twin other --participants 1 --sessions 1 --seed {seed}");
    zwidth_line(root.path(), &twin).exits(0);
    zwidth(root.path(), &["run", "other", "--only", "metrics of the study"]).exits(0);
    root
}

#[test]
fn the_story_holds_at_either_end_of_every_assumed_number() {
    for (i, parameter) in TwinParameters::table().into_iter().enumerate() {
        for (end, value) in parameter.range.into_iter().enumerate() {
            let mut twin = TwinParameters::default();
            *(parameter.field)(&mut twin) = value;
            let rate_hz = if i % 2 == 0 { 120.0 } else { 1000.0 };
            let line = format!("{} = {value:?}", parameter.name);
            let root = study_with(&line, (2 * i + end) as u32, rate_hz);
            tells_the_story(root.path(), "other", &twin, rate_hz, &line);
        }
    }
}
