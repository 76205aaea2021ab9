//! The thesis' Table 3: its numbers, and the scenes made of it.

use super::ModelScene;
use super::actuators::{Brake, BrakeLaw, DriveMode, Motor};
use super::environment::Environment;
use super::finger::{Finger, FingerLaw};
use super::input::Input;
pub use super::numbers::*;
use super::plant::{Plant, Start};
use super::terms::Terms;

/// The spring of Table 3; it rests at the lower stop (inferred from the wall's 26.6° at 5 N).
pub fn spring() -> Environment {
    Environment::spring(OBJECT_STIFFNESS_N_PER_RAD, OBJECT_DAMPING_NS_PER_RAD, -HALF_STROKE_RAD)
}

/// The same spring with the wall at 26.6°.
#[cfg(test)]
pub(crate) fn spring_wall() -> Environment {
    spring().with_wall(WALL_RAD)
}

/// Table 3 without finger, at rest on the lower stop, F_m = 3.25 N, F_b = 13 N, set-valued brake.
pub fn scene(mode: DriveMode, input: Input) -> ModelScene {
    ModelScene {
        name: "table 3".to_owned(),
        mode,
        duration_s: DURATION_S,
        step_s: STEP_S,
        environment: spring(),
        plant: Plant {
            mass_kg: OBJECT_MASS_KG,
            lever_m: LEVER_M,
            stops_rad: Some([-HALF_STROKE_RAD, HALF_STROKE_RAD]),
        },
        motor: Motor { max_n: MOTOR_N, lag_s: None },
        brake: Brake {
            max_n: BRAKE_N,
            law: BrakeLaw::Coulomb,
            dead_zone_n: 0.0,
            lag_on_off_s: None,
            let_go_n: None,
        },
        input,
        start: Start { theta_rad: -HALF_STROKE_RAD, theta_dot_rad_s: 0.0 },
        finger: None,
        friction: None,
        terms: Terms::default(),
    }
}

/// Table 3's fingertip.
pub fn finger(law: FingerLaw) -> Finger {
    Finger {
        law,
        mass_kg: FINGER_MASS_KG,
        stiffness_n_per_m: FINGER_STIFFNESS_N_PER_M,
        damping_ns_per_m: FINGER_DAMPING_NS_PER_M,
        length_m: Some(FINGER_LENGTH_M),
    }
}

/// `scene` with Table 3's fingertip in the consistent form.
pub fn with_finger(scene: ModelScene) -> ModelScene {
    ModelScene { finger: Some(finger(FingerLaw::Consistent)), ..scene }
}

/// The linear two-mass model (1)–(4) with Table 3's numbers, in compression coordinates: q = L_O0 −
/// x1 is how far the object is pressed and p = L_F0 − (x2 − x1) how far the finger is. Then (3) and
/// (4) read M_O q̈ = F_O + F_F and M_F (q̈ + p̈) = F_ex − F_F: the rotational model with the
/// consistent finger, a lever of 1 m, an object that rests at 0, no stops, and metres for radians.
/// Brake to motor is 4 : 1. L_O0 drops out; the largest brake force is not given in the thesis.
pub fn linear(mode: DriveMode, input: Input, brake_n: f64) -> ModelScene {
    /// Largest brake force over largest motor force (1).
    const FORCE_RATIO: f64 = 4.0;
    let mut scene = with_finger(scene(mode, input));
    scene.name = "table 3, linear".to_owned();
    scene.environment =
        Environment::spring(OBJECT_STIFFNESS_N_PER_RAD, OBJECT_DAMPING_NS_PER_RAD, 0.0);
    scene.plant.stops_rad = None;
    scene.start = Start::default();
    scene.brake.max_n = brake_n;
    scene.motor.max_n = brake_n / FORCE_RATIO;
    if let Some(finger) = &mut scene.finger {
        finger.length_m = None;
    }
    scene
}
