//! What a study requires of a trial's samples.

use serde::Serialize;
use zwidth_study::{Coordinate, EnvironmentId, Scene, Study};

/// What a study requires of a trial's samples.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Asked {
    /// Work space, lower end, rad.
    pub theta_min_rad: Option<f64>,
    /// Work space, upper end, rad.
    pub theta_max_rad: Option<f64>,
    /// Longest a trial may take, s.
    pub trial_limit_s: f64,
    /// From this speed on a movement begins, rad/s.
    pub onset_rad_s: f64,
    /// What the coordinate is.
    pub coordinate: Coordinate,
    /// Lever length L, m.
    pub lever_m: Option<f64>,
    /// What is rendered.
    pub scene: Scene,
}

impl Asked {
    /// What this study does in one of its environments.
    pub fn of(study: &Study, environment: &EnvironmentId) -> Self {
        let zwidth_study::Device { theta_min_rad, theta_max_rad, lever_m, .. } = study.device;
        Self {
            theta_min_rad,
            theta_max_rad,
            trial_limit_s: study.design.trial_limit_s,
            onset_rad_s: study.analysis.onset_rad_s,
            coordinate: study.coordinate,
            lever_m,
            scene: study.environment(environment).map_or(Scene::None, |e| e.scene),
        }
    }

    /// An angle as people read it: `22.07°`, or `12.50 mm` along a slide.
    pub(crate) fn place(&self, theta_rad: f64) -> String {
        match self.coordinate {
            Coordinate::Rotational => format!("{:.2}°", theta_rad.to_degrees()),
            Coordinate::Linear { lever_m } => format!("{:.2} mm", 1e3 * lever_m * theta_rad),
        }
    }
}
