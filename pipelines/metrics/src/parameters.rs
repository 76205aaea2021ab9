//! What the metrics of a trial depend on besides its samples.

use serde::Serialize;
use zwidth_study::{Analysis, Environment, Mode, Scene, Study};

/// Everything that the metrics of a condition's trials depend on besides the trials.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
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
    /// Whether the mode has a brake and no motor.
    pub brakes_only: bool,
}

impl Parameters {
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
            brakes_only: mode.brake_max_v.is_some() && mode.motor_max_v.is_none(),
        }
    }
}
