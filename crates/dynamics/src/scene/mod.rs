//! A scene: environment, mode, plant, actuators, input, and the additional terms of a model. A
//! plain value.

pub(crate) mod actuators;
pub(crate) mod environment;
mod file;
pub(crate) mod finger;
pub(crate) mod friction;
pub(crate) mod input;
mod numbers;
pub(crate) mod parameter;
pub(crate) mod plant;
pub mod table3;
pub mod terms;

use actuators::{Brake, DriveMode, Motor};
use environment::Environment;
use finger::Finger;
use friction::Friction;
use input::Input;
use parameter::Parameter;
use plant::{Plant, Start};
use serde::{Deserialize, Serialize};
use terms::Terms;

use crate::error::{DynamicsError, Result, positive};

/// What is simulated. Parts that are `None` and absent terms are left out of the equations and cost
/// nothing.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(remote = "Self", deny_unknown_fields)]
pub struct ModelScene {
    /// What a listing calls it.
    pub name: String,
    /// Which actuators render the environment.
    pub mode: DriveMode,
    /// Length of the run T, s; above 0.
    pub duration_s: f64,
    /// Time between samples h, s; above 0. Fixed-step methods step by it.
    pub step_s: f64,
    /// The rendered object.
    pub environment: Environment,
    /// The moving mass and its stops.
    pub plant: Plant,
    /// The motor.
    pub motor: Motor,
    /// The brake.
    pub brake: Brake,
    /// Force of the user on the lever's end F_ex, N; above 0 pushes into the object (+θ).
    pub input: Input,
    /// State at t = 0.
    #[serde(default)]
    pub start: Start,
    /// The user's finger between F_ex and the lever.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub finger: Option<Finger>,
    /// Dry and viscous friction of the drive train.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<Friction>,
    /// Further single-valued forces on the lever, in a file under their names: its weight, a moved
    /// spring, …
    #[serde(flatten, skip_deserializing)]
    pub terms: Terms,
}

impl ModelScene {
    /// Reads a scene from TOML text.
    ///
    /// # Errors
    /// [`DynamicsError::Toml`] if the text is no scene; its values are checked by
    /// [`crate::System::new`].
    pub fn from_toml(text: &str) -> Result<Self> {
        toml::from_str(text).map_err(|e| DynamicsError::Toml(e.to_string()))
    }

    /// The scene as TOML text, which [`ModelScene::from_toml`] reads back.
    ///
    /// # Errors
    /// [`DynamicsError::Toml`] if a value cannot be written.
    pub fn to_toml(&self) -> Result<String> {
        toml::to_string(self).map_err(|e| DynamicsError::Toml(e.to_string()))
    }

    /// The parameter furthest (in powers of ten) from the size it has in Table 3 or in a usual
    /// device, for errors of extreme runs.
    pub(crate) fn suspect(&self) -> String {
        let mut list = vec![
            ("plant.mass_kg", self.plant.mass_kg, numbers::OBJECT_MASS_KG),
            ("plant.lever_m", self.plant.lever_m, numbers::LEVER_M),
            ("start.theta_rad", self.start.theta_rad, numbers::HALF_STROKE_RAD),
            ("start.theta_dot_rad_s", self.start.theta_dot_rad_s, numbers::VELOCITY_RAD_S),
            ("step_s", self.step_s, numbers::STEP_S),
            ("duration_s", self.duration_s, numbers::DURATION_S),
        ];
        self.environment.list(&mut list);
        let mut parts = [self.motor.parameters(), self.brake.parameters()].concat();
        parts.extend(self.finger.iter().flat_map(Finger::parameters));
        parts.extend(self.friction.iter().flat_map(Friction::parameters));
        list.extend(parts.iter().map(|p| (p.name, p.value, p.usual)));
        let mut list: Vec<_> =
            list.into_iter().map(|(name, value, usual)| (name.to_owned(), value, usual)).collect();
        self.input.list("input", numbers::FORCE_N, &mut list);
        list.extend(self.terms.list());
        let distances = list.into_iter().map(|(name, value, usual)| {
            // A part that is 0 is left out rather than infinitely small.
            let share = (value / usual).abs();
            (if share > 0.0 { libm::log10(share).abs() } else { 0.0 }, name, value)
        });
        let furthest = distances.max_by(|a, b| a.0.total_cmp(&b.0));
        furthest.map_or_else(String::new, |(_, name, value)| format!("{name} = {value}"))
    }

    /// Every parameter checked; the first that makes no sense is named.
    pub(crate) fn check(&self) -> Result<()> {
        positive("duration_s", self.duration_s)?;
        positive("step_s", self.step_s)?;
        self.environment.check()?;
        self.plant.check()?;
        self.motor.parameters().iter().try_for_each(Parameter::checked)?;
        self.brake.parameters().iter().try_for_each(Parameter::checked)?;
        self.input.check("input", self.duration_s)?;
        self.start.check(&self.plant)?;
        self.finger.iter().flat_map(Finger::parameters).try_for_each(|p| p.checked())?;
        self.friction.as_ref().map_or(Ok(()), Friction::check)?;
        self.terms.check(&self.plant, self.duration_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_scene_survives_toml() {
        let scene = table3::with_finger(table3::scene(DriveMode::Hybrid, Input::sine(2.15)));
        let text = scene.to_toml().unwrap();
        assert_eq!(ModelScene::from_toml(&text).unwrap(), scene);
    }

    #[test]
    fn a_scene_written_by_hand_is_read() {
        let scene = ModelScene::from_toml(
            r#"
            name = "sponge with a wall, recorded push"
            mode = "hybrid"
            duration_s = 2.0
            step_s = 0.001
            plant = { mass_kg = 0.005, lever_m = 0.045, stops_rad = [-0.7854, 0.7854] }
            motor = { max_n = 2.08 }
            brake = { max_n = 13.0, law = "coulomb", let_go_n = 1.0 }
            start = { theta_rad = -0.7854 }
            friction = { static_n = 0.2, kinetic_n = 0.15, viscous_ns_per_rad = 0.02 }
            input.series = { t_s = [0.0, 0.8, 1.1], value = [0.0, 5.0, 2.0] }

            [environment]
            name = "sponge_wall"
            [[environment.zones]]
            demand.spring = { stiffness_n_per_rad = 2.0, damping_ns_per_rad = 3.0, rest_rad = -0.7854 }
            [[environment.zones]]
            from_rad = 0.464
            demand = "full"
            "#,
        );
        assert!(crate::System::new(scene.unwrap()).is_ok());
    }

    #[test]
    fn an_unknown_word_is_an_error_that_names_it() {
        let text = table3::scene(DriveMode::Active, Input::step(1.0)).to_toml().unwrap();
        let text = text.replace("lever_m", "lever_mm");
        let error = ModelScene::from_toml(&text).unwrap_err().to_string();
        assert!(error.contains("lever_mm"), "{error}");
    }

    #[test]
    fn a_wrong_value_is_named_with_its_unit() {
        let mut scene = table3::scene(DriveMode::Active, Input::step(1.0));
        scene.plant.mass_kg = f64::NAN;
        let error = scene.check().unwrap_err().to_string();
        assert!(error.contains("plant.mass_kg is NaN"), "{error}");
    }

    /// The suspect of a usual scene after one change.
    fn blamed(change: impl Fn(&mut ModelScene)) -> String {
        let mut scene = table3::with_finger(table3::scene(DriveMode::Hybrid, Input::sine(2.15)));
        scene.friction =
            Some(Friction { static_n: 0.2, kinetic_n: 0.15, viscous_ns_per_rad: 0.02 });
        scene.motor.lag_s = Some(0.01);
        scene.brake.lag_on_off_s = Some([0.015, 0.010]);
        scene.start.theta_dot_rad_s = 1.0;
        change(&mut scene);
        scene.suspect()
    }

    #[test]
    fn an_error_blames_the_parameter_that_is_extreme_inputs_lags_and_the_start_included() {
        let pull = |rate| terms::pull::Pull {
            stiffness_n_per_rad: 1.0,
            displacement: Input::Line { value: 0.0, rate },
        };
        let series =
            |value| Input::Series(input::Series { t_s: vec![0.0, 1.0], value: vec![0.0, value] });
        let sine = |magnitude, omega_rad_s| Input::Sine { magnitude, omega_rad_s };
        for far in [1e-9, 1e9] {
            for (name, found) in [
                ("motor.lag_s", blamed(|s| s.motor.lag_s = Some(far))),
                ("brake.lag_on_off_s[0]", blamed(|s| s.brake.lag_on_off_s = Some([far, 0.01]))),
                ("brake.lag_on_off_s[1]", blamed(|s| s.brake.lag_on_off_s = Some([0.01, far]))),
                ("input.sine.magnitude", blamed(|s| s.input = sine(far, 1.6))),
                ("input.sine.omega_rad_s", blamed(|s| s.input = sine(2.0, far))),
                (
                    "input.step.period_s",
                    blamed(|s| s.input = Input::Step { magnitude: 1.0, period_s: far }),
                ),
                (
                    "input.ramp.magnitude",
                    blamed(|s| s.input = Input::Ramp { magnitude: far, period_s: 4.0 }),
                ),
                ("input.line.value", blamed(|s| s.input = Input::constant(far))),
                ("input.series.value[1]", blamed(|s| s.input = series(far))),
                ("pull.displacement.line.rate", blamed(|s| s.terms.set(pull(far)))),
                ("start.theta_dot_rad_s", blamed(|s| s.start.theta_dot_rad_s = far)),
                ("friction.kinetic_n", blamed(|s| s.friction.as_mut().unwrap().kinetic_n = far)),
                ("finger.mass_kg", blamed(|s| s.finger.as_mut().unwrap().mass_kg = far)),
                ("plant.mass_kg", blamed(|s| s.plant.mass_kg = far)),
                ("brake.max_n", blamed(|s| s.brake.max_n = far)),
            ] {
                assert!(found.starts_with(&format!("{name} = ")), "{name}: {found}");
            }
        }
    }
}
