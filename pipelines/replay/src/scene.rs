//! The model of a trial: environment, mode, work space and actuators from the study, and the plant
//! from parameters.

use crate::WhyNot;
use serde::Serialize;
use zwidth_dynamics::{
    Brake, BrakeLaw, DriveMode, Environment, Friction, Input, ModelScene, Motor, Plant, Series,
    Start, Terms,
};
use zwidth_study::{ActuatorKind, Calibration, ForceLaw, ModeLaw, Scene, Study};

/// Lags below this count as no lag, s: far below any sample's interval.
const LEAST_LAG_S: f64 = 1e-6;

/// The unknown numbers of the plant.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parameters {
    /// M_O: mass felt at the lever's end, kg.
    pub mass_kg: f64,
    /// B_O: viscous damping at the lever's end, N s/rad.
    pub damping_ns_per_rad: f64,
    /// Dry friction at the lever's end, at rest and in motion, N.
    pub friction_n: f64,
    /// Time constant with which the motor's force follows its command, s; 0 is at once.
    pub motor_lag_s: f64,
    /// Time constant with which the brake's level rises, s.
    pub brake_on_s: f64,
    /// Time constant with which it falls, s.
    pub brake_off_s: f64,
}

impl Parameters {
    /// The thesis' choice "by trial and error" (Fig. 24): M_O = 0.1 kg, B_O = 1 N s/rad, no dry
    /// friction and no lags.
    pub const BY_EYE: Self = Self {
        mass_kg: 0.1,
        damping_ns_per_rad: 1.0,
        friction_n: 0.0,
        motor_lag_s: 0.0,
        brake_on_s: 0.0,
        brake_off_s: 0.0,
    };

    /// This plant with actuators that follow at once.
    pub(crate) fn without_lags(&self) -> Self {
        Self { motor_lag_s: 0.0, brake_on_s: 0.0, brake_off_s: 0.0, ..*self }
    }

    /// Friction as the model has it.
    pub(crate) fn friction(&self) -> Friction {
        Friction {
            static_n: self.friction_n,
            kinetic_n: self.friction_n,
            viscous_ns_per_rad: self.damping_ns_per_rad,
        }
    }

    /// The motor's lag, s, if the model has one.
    pub(crate) fn motor_lag_s(&self) -> Option<f64> {
        Some(self.motor_lag_s).filter(|lag| *lag >= LEAST_LAG_S)
    }

    /// The brake's two lags, s, if the model has any. If only one of them is 0, the model takes the
    /// shortest lag instead.
    pub(crate) fn brake_lag_on_off_s(&self) -> Option<[f64; 2]> {
        let lags = [self.brake_on_s, self.brake_off_s];
        lags.iter().any(|lag| *lag >= LEAST_LAG_S).then(|| lags.map(|lag| lag.max(LEAST_LAG_S)))
    }

    /// The scene with this plant.
    pub(crate) fn put(&self, scene: &ModelScene) -> ModelScene {
        let plant = Plant { mass_kg: self.mass_kg, ..scene.plant };
        let motor = Motor { lag_s: self.motor_lag_s(), ..scene.motor };
        let brake = Brake { lag_on_off_s: self.brake_lag_on_off_s(), ..scene.brake };
        ModelScene { plant, motor, brake, friction: Some(self.friction()), ..scene.clone() }
    }
}

/// What a condition's trials rendered and how: everything that their model depends on besides the
/// trials and the plant.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rendering {
    /// The rendered scene.
    pub rendered: Scene,
    /// By how much it was rendered late, s.
    #[serde(skip_serializing_if = "is_at_once")]
    pub delay_s: f64,
    /// Highest motor voltage of the mode, V; 0 if it does not use one.
    pub motor_max_v: f64,
    /// Highest brake voltage of the mode, V; 0 if it does not use one.
    pub brake_max_v: f64,
    /// The law by which motor and brake are in charge.
    pub law: Option<ModeLaw>,
    /// Lever length L, m.
    pub lever_m: Option<f64>,
    /// The ends of the work space, rad.
    pub stops_rad: Option<[f64; 2]>,
    /// Below this force of the user a hybrid drive lets the brake go, N.
    pub let_go_n: f64,
    /// The calibration in force.
    pub calibration: Option<Calibration>,
}

fn is_at_once(delay_s: &f64) -> bool {
    *delay_s == 0.0
}

impl Rendering {
    /// The rendering of a condition of a study, with the session's calibration.
    pub fn of(
        study: &Study,
        environment: &zwidth_study::Environment,
        mode: &zwidth_study::Mode,
        calibration: Option<Calibration>,
    ) -> Self {
        let device = &study.device;
        Self {
            rendered: environment.scene,
            delay_s: environment.delay_s,
            motor_max_v: mode.motor_max_v.unwrap_or(0.0),
            brake_max_v: mode.brake_max_v.unwrap_or(0.0),
            law: mode.law(),
            lever_m: device.lever_m,
            stops_rad: device.theta_min_rad.zip(device.theta_max_rad).map(|(a, b)| [a, b]),
            let_go_n: study.control.let_go_n,
            calibration,
        }
    }

    /// Which actuators the mode uses; a mode without actuators has a motor that gives nothing.
    fn mode(&self) -> DriveMode {
        let Some(law) = self.law else { return DriveMode::Active };
        let by_motor = law.drives().map(|drive| drive == ActuatorKind::Motor);
        let mut modes = DriveMode::ALL.into_iter();
        modes.find(|mode| mode.by_motor() == by_motor).unwrap_or(DriveMode::Active)
    }

    fn environment(&self) -> Result<Environment, WhyNot> {
        let ForceLaw { constant_n, stiffness_n_per_rad, damping_ns_per_rad, rest_rad, wall_rad } =
            self.rendered.law().ok_or(WhyNot::NotRendered)?;
        let base = match self.rendered {
            Scene::Free => Environment::free(),
            // No scene has both a constant force and a spring.
            Scene::Force { .. } => Environment::force(constant_n),
            _ => Environment::spring(stiffness_n_per_rad, damping_ns_per_rad, rest_rad),
        };
        Ok(match wall_rad {
            Some(wall_rad) => base.with_wall(wall_rad),
            None => base,
        })
    }

    /// The forces that voltages command from each sample on, by the calibration, N: the motor's
    /// force (above 0 pushes to +θ) and the brake's level.
    pub(crate) fn commands_n(
        &self,
        samples: usize,
        [motor_v, brake_v]: [Option<&[f64]>; 2],
    ) -> Result<[Vec<f64>; 2], WhyNot> {
        // An actuator that the mode does not use needs no voltages, and without any no calibration.
        let used = [self.motor_max_v > 0.0, self.brake_max_v > 0.0];
        if (used[0] && motor_v.is_none()) || (used[1] && brake_v.is_none()) {
            return Err(WhyNot::NoVoltages);
        }
        if self.calibration.is_none() && (used[0] || used[1]) {
            return Err(WhyNot::NoCalibration);
        }
        let calibration = self.calibration.as_ref();
        let motor_n: Option<Vec<f64>> = calibration
            .zip(motor_v)
            .map(|(c, voltages)| voltages.iter().map(|v| c.motor.force_n(*v)).collect());
        // A brake resists whatever its voltage's sign.
        let brake_n: Option<Vec<f64>> = calibration
            .zip(brake_v)
            .map(|(c, voltages)| voltages.iter().map(|v| c.brake.force_n(*v).abs()).collect());
        Ok([motor_n, brake_n].map(|force_n| force_n.unwrap_or_else(|| vec![0.0; samples])))
    }

    /// The scene, from the recorded start on, with the user's force; the plant is the thesis' until
    /// parameters are put in. A start that lies outside the stops by the sensor's step is moved
    /// onto them.
    pub(crate) fn scene(
        &self,
        input: Series,
        start: Start,
        duration_s: f64,
    ) -> Result<ModelScene, WhyNot> {
        let lever_m = self.lever_m.ok_or(WhyNot::NoLever)?;
        // The most that motor and brake give in this mode; a free environment asks nothing of them.
        let (motor_n, brake_n) = match (self.rendered, &self.calibration) {
            (Scene::Free, _) => (0.0, 0.0),
            (_, None) => return Err(WhyNot::NoCalibration),
            (_, Some(c)) => (c.motor.force_n(self.motor_max_v), c.brake.force_n(self.brake_max_v)),
        };
        let theta_rad =
            self.stops_rad.map_or(start.theta_rad, |[low, high]| start.theta_rad.clamp(low, high));
        Ok(ModelScene {
            name: "replay".to_owned(),
            mode: self.mode(),
            duration_s,
            // `exact`, which runs it, takes no steps: any positive one will do.
            step_s: duration_s,
            environment: self.environment()?,
            plant: Plant {
                mass_kg: Parameters::BY_EYE.mass_kg,
                lever_m,
                stops_rad: self.stops_rad,
            },
            motor: Motor { max_n: motor_n, lag_s: None },
            brake: Brake {
                max_n: brake_n,
                law: BrakeLaw::Coulomb,
                dead_zone_n: 0.0,
                lag_on_off_s: None,
                let_go_n: Some(self.let_go_n),
            },
            input: Input::Series(input),
            start: Start { theta_rad, ..start },
            finger: None,
            friction: None,
            terms: Terms::default(),
        })
    }
}
