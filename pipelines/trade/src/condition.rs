//! A study's condition as a scene: what it renders, with which actuators, pushed as in the thesis.

use zwidth_dynamics::{
    Brake, BrakeLaw, DriveMode, Environment, Friction, Input, ModelScene, Motor, Plant, Start,
    Terms,
};
use zwidth_study::{ActuatorKind, Calibration, Mode, Scene, Study};

/// Mass at the lever's end, kg, and its viscous damping, N s/rad: the thesis' choice for its
/// prototype (Fig. 24).
const MASS_KG: f64 = 0.1;
const DAMPING_NS_PER_RAD: f64 = 1.0;
/// Length of a run, s, and ω of the push, rad/s: the thesis' (7).
const DURATION_S: f64 = 4.0;
/// The push goes up to this share of what the environment demands at the upper end of the work
/// space: past the wall of the thesis, and short of the stop.
const PUSH: f64 = 0.9;

/// The scene of a condition: the study's environment, limits, lever and work space, its
/// controller's tick as step, the plant of the thesis' Fig. 24, and its sine as push. None if the
/// study lacks what a model needs: a lever length, a work space, a mode's law, a spring that is
/// rendered at once.
pub fn condition_scene(
    study: &Study,
    environment: &zwidth_study::Environment,
    mode: &Mode,
    calibration: &Calibration,
) -> Option<ModelScene> {
    let device = &study.device;
    let stops_rad = [device.theta_min_rad?, device.theta_max_rad?];
    let is_model = environment.scene != Scene::Free && environment.delay_s == 0.0;
    let law = environment.scene.law().filter(|_| is_model)?;
    let by_motor = mode.law()?.drives().map(|drive| drive == ActuatorKind::Motor);
    let drive = DriveMode::ALL.into_iter().find(|drive| drive.by_motor() == by_motor)?;
    let spring = Environment::spring(law.stiffness_n_per_rad, law.damping_ns_per_rad, law.rest_rad);
    let peak_n = PUSH * law.stiffness_n_per_rad * (stops_rad[1] - law.rest_rad);
    (peak_n > 0.0)
        .then(|| ModelScene {
            name: format!("{}.{}", environment.id, mode.id),
            mode: drive,
            duration_s: DURATION_S,
            step_s: 1.0 / study.control.rate_hz,
            environment: law.wall_rad.map_or(spring.clone(), |wall| spring.with_wall(wall)),
            plant: Plant {
                mass_kg: MASS_KG,
                lever_m: device.lever_m.unwrap_or_default(),
                stops_rad: Some(stops_rad),
            },
            motor: Motor {
                max_n: calibration.motor.force_n(mode.motor_max_v.unwrap_or(0.0)),
                lag_s: None,
            },
            brake: Brake {
                max_n: calibration.brake.force_n(mode.brake_max_v.unwrap_or(0.0)),
                law: BrakeLaw::Coulomb,
                dead_zone_n: 0.0,
                lag_on_off_s: None,
                let_go_n: Some(study.control.let_go_n),
            },
            // a + a sin: its peak is twice its magnitude.
            input: Input::sine(0.5 * peak_n),
            start: Start { theta_rad: stops_rad[0], theta_dot_rad_s: 0.0 },
            finger: None,
            friction: Some(Friction {
                static_n: 0.0,
                kinetic_n: 0.0,
                viscous_ns_per_rad: DAMPING_NS_PER_RAD,
            }),
            terms: Terms::default(),
        })
        .filter(|scene| scene.plant.lever_m > 0.0 && law.stiffness_n_per_rad > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use zwidth_study::{StudyId, template};

    #[test]
    fn the_template_s_six_conditions_are_scenes_that_can_be_run() {
        let study = Study::from_toml(&template(&StudyId::new("demo").unwrap())).unwrap();
        let scenes: Vec<ModelScene> = study
            .environments
            .iter()
            .flat_map(|e| study.modes.iter().map(move |m| (e, m)))
            .filter_map(|(e, m)| condition_scene(&study, e, m, &Calibration::thesis()))
            .collect();
        assert_eq!(scenes.len(), 6);
        assert_eq!(scenes[0].name, "spring.active");
        assert!((scenes[0].motor.max_n - 4.16).abs() < 1e-12);
        let modes: Vec<&str> = scenes.iter().map(|scene| scene.mode.as_str()).collect();
        assert_eq!(modes[..3], ["active", "passive", "hybrid"]);
        for scene in scenes {
            assert!(zwidth_dynamics::System::new(scene).is_ok());
        }
    }
}
