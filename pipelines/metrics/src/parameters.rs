//! What the metrics of a trial depend on besides its samples.

use serde::Serialize;
use zwidth_store::Signal;
use zwidth_study::{
    Analysis, Axes, CURRENT_BRAKE, CURRENT_MOTOR, ChannelId, Environment, Mode, OwnMetric,
    REFERENCE, Resistances, Scene, Study,
};

/// The signals that [`crate::trial_metrics`] looks at, besides axes and those of the study's own metrics; currents
/// and references are channels.
pub const SIGNALS: [Signal; 9] = [
    Signal::Time,
    Signal::Theta,
    Signal::ThetaDot,
    Signal::ForceEx,
    Signal::VoltageMotor,
    Signal::VoltageBrake,
    Signal::ForceAge,
    Signal::ForceCmd,
    Signal::StateBits,
];

/// Those that it looks at too in a study with axes.
const AXES: [Signal; 6] =
    [Signal::X, Signal::Y, Signal::Z, Signal::ForceX, Signal::ForceY, Signal::ForceZ];

/// Everything that the metrics of a condition's trials depend on besides the trials.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameters {
    /// Thresholds, grid and confidence level.
    pub analysis: Analysis,
    /// What is rendered.
    pub scene: Scene,
    /// Lever length L, m.
    pub lever_m: Option<f64>,
    /// Work space, lower end, rad.
    pub theta_min_rad: Option<f64>,
    /// Work space, upper end, rad.
    pub theta_max_rad: Option<f64>,
    /// Rate at which the force sensor gives new values, Hz.
    pub force_rate_hz: Option<f64>,
    /// Longest a trial may take, s.
    pub trial_limit_s: f64,
    /// Whether the mode uses a motor.
    pub uses_motor: bool,
    /// Whether the mode uses a brake.
    pub uses_brake: bool,
    /// Resistances of the actuators' windings.
    pub resistances: Resistances,
    /// The axes of space, if the study has several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axes: Option<Axes>,
    /// The study's own metrics.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub own: Vec<OwnMetric>,
}

impl Parameters {
    /// Whether the mode has a brake and no motor.
    pub(crate) fn brakes_only(&self) -> bool {
        self.uses_brake && !self.uses_motor
    }

    /// The signals that [`crate::trial_metrics`] looks at.
    pub fn signals(&self) -> Vec<Signal> {
        let own = self.own.iter().filter_map(|own| Signal::from_name(&own.of));
        let axes = AXES.into_iter().filter(|_| self.axes.is_some());
        SIGNALS.into_iter().chain(axes).chain(own).collect()
    }

    /// The channels that it looks at, where a trial has them.
    pub fn channels(&self) -> Vec<ChannelId> {
        let own = self.own.iter().map(|own| own.of.as_str());
        let names = [CURRENT_MOTOR, CURRENT_BRAKE, REFERENCE].into_iter().chain(own);
        // A signal's name is no channel's, and none of the others is lost.
        names.filter_map(|name| ChannelId::new(name).ok()).collect()
    }

    /// Those of a condition of a study.
    pub fn of(study: &Study, environment: &Environment, mode: &Mode) -> Self {
        let device = &study.device;
        Self {
            analysis: study.analysis,
            scene: environment.scene,
            lever_m: device.lever_m,
            theta_min_rad: device.theta_min_rad,
            theta_max_rad: device.theta_max_rad,
            force_rate_hz: device.force_rate_hz,
            trial_limit_s: study.design.trial_limit_s,
            uses_motor: mode.motor_max_v.is_some(),
            uses_brake: mode.brake_max_v.is_some(),
            resistances: study.resistances,
            axes: study.axes.clone(),
            own: study.metrics.clone(),
        }
    }
}

/// The plant as it was identified, M L θ̈ + B θ̇ + F_C sgn θ̇ at the lever's end, and how well it
/// is known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Plant {
    /// M: mass felt at the lever's end, kg.
    pub mass_kg: f64,
    /// B: viscous damping there, N·s/rad.
    pub damping_ns_per_rad: f64,
    /// F_C: dry friction there, in motion, N.
    pub friction_n: f64,
    /// Covariance of the three, in this order and in their units.
    pub covariance: [[f64; 3]; 3],
    /// Its degrees of freedom.
    pub df: f64,
}
