//! Trials made by the model itself, for the tests of this crate.

use crate::scene::Rendering;
use crate::{Parameters, replay};
use zwidth_dynamics::{Exact, Grid, Series, Solver, Start, System};
use zwidth_results::{ModelPlant, ReplayedTrial};
use zwidth_store::{Samples, Signal, Trial, TrialFile};
use zwidth_study::{Analysis, Calibration, Scene, Spring, Study};

/// Time between samples, s.
pub(crate) const STEP_S: f64 = 0.005;
const REST_RAD: f64 = -core::f64::consts::FRAC_PI_4;

/// The template's study, its first environment a spring of 4 N/rad that rests at −45°.
pub(crate) fn study() -> Study {
    let mut study = zwidth_testing::study();
    study.environments[0].scene =
        Scene::Spring(Spring { stiffness_n_per_rad: 4.0, rest_rad: REST_RAD });
    study
}

/// Its first environment by a mode, as a session with the thesis' calibration renders it.
pub(crate) fn rendering(mode: &str) -> Rendering {
    let study = study();
    let mode = study.mode(&mode.parse().unwrap()).unwrap();
    Rendering::of(&study, &study.environments[0], mode, Some(calibration()))
}

pub(crate) fn calibration() -> Calibration {
    Calibration::thesis()
}

/// Uneven times over four seconds; a push that rises to 3.5 N and falls again, and half a second of
/// rest at both ends.
fn push() -> Series {
    let time = |i: u32| STEP_S * (f64::from(i) + if i.is_multiple_of(3) { 0.0 } else { 0.1 });
    let t_s: Vec<f64> = (0..=800).map(time).collect();
    let phase = |t: f64| core::f64::consts::TAU * (t - 0.5).clamp(0.0, 3.0) / 3.0;
    let value = t_s.iter().map(|t| 3.5 * (1.0 - libm::cos(phase(*t))) / 2.0).collect();
    Series { t_s, value }
}

/// A trial as the model records it: the push, its motion, and the voltages of what the actuators
/// give.
pub(crate) fn simulated(mode: &str, plant: &Parameters) -> Trial {
    let meta = zwidth_testing::meta(1, mode);
    let calibration = calibration();
    let push = push();
    let condition = rendering(mode);
    let start = Start { theta_rad: REST_RAD, theta_dot_rad_s: 0.0 };
    let scene = plant.put(&condition.scene(push.clone(), start, 4.0).unwrap());
    let system = System::new(scene).unwrap();
    let run = Exact::default().run(&system, &Grid::Times(push.t_s.clone())).unwrap();
    let forces: Vec<_> = (0..run.len()).map(|i| run.forces(&system, i)).collect();
    let spring = |theta: f64| 4.0 * (theta - REST_RAD);
    let brake = |theta: f64| {
        if mode == "passive" { calibration.brake.voltage_v(spring(theta)) } else { 0.0 }
    };
    let mut samples = Samples::default();
    samples.set(Signal::Time, push.t_s);
    samples.set(Signal::Theta, run.theta_rad().collect());
    samples.set(Signal::ThetaDot, run.theta_dot_rad_s().collect());
    samples.set(Signal::ForceEx, push.value);
    samples.set(
        Signal::VoltageMotor,
        forces.iter().map(|f| calibration.motor.voltage_v(f.motor_n)).collect(),
    );
    samples.set(Signal::VoltageBrake, run.theta_rad().map(brake).collect());
    Trial { meta, file: TrialFile::new(), samples }
}

/// A trial of given samples.
pub(crate) fn trial(mode: &str, samples: Samples) -> Trial {
    Trial { meta: zwidth_testing::meta(1, mode), file: TrialFile::new(), samples }
}

/// The same with a motion that was recorded so many samples late.
pub(crate) fn delayed(trial: &Trial, by: usize) -> Trial {
    let mut late = trial.clone();
    for signal in [Signal::Theta, Signal::ThetaDot] {
        let values = trial.samples.get(signal).unwrap();
        late.samples.set(signal, (0..values.len()).map(|i| values[i.saturating_sub(by)]).collect());
    }
    late
}

/// The same samples without one signal.
pub(crate) fn without(samples: &Samples, missing: Signal) -> Samples {
    let mut rest = Samples::default();
    for signal in Signal::all().filter(|s| *s != missing) {
        if let Some(values) = samples.get(signal) {
            rest.set(signal, values.to_vec());
        }
    }
    rest
}

/// A trial's replays in a rendering with a plant.
pub(crate) fn replayed_with(
    trial: &Trial,
    rendering: &Rendering,
    plant: &Parameters,
) -> Vec<ReplayedTrial> {
    replay(trial, rendering, &Analysis::default(), ModelPlant::ByEye, plant).unwrap()
}

/// Those as its mode renders, with the plant by eye.
pub(crate) fn replays(trial: &Trial) -> Vec<ReplayedTrial> {
    replayed_with(trial, &rendering(trial.meta.mode.as_str()), &Parameters::BY_EYE)
}
