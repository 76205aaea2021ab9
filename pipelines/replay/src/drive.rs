//! A trial prepared for replay: its recording, and its model.

use crate::closed_loop::{self, Held};
use crate::scene::{Parameters, Rendering};
use crate::updates::input;
use crate::{ReplayError, WhyNot};
use zwidth_dynamics::{DynamicsError, Exact, Grid, ModelScene, Solver, Start, System};
use zwidth_numerics::series::{central_differences, interpolate};
use zwidth_results::Causality;
use zwidth_store::{Signal, Trial};

/// A trial as it was recorded, and the model of it; the model's plant is chosen at each run.
#[derive(Debug, Clone)]
pub struct Drive {
    /// Time of the first sample, s; everything else counts from there.
    pub(crate) began_s: f64,
    recorded: Course,
    pub(crate) scene: ModelScene,
    held: Result<Held, WhyNot>,
    is_delayed: bool,
}

/// Motion and forces against time: all as long as `t_s`.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    /// Time since the first sample, s.
    pub t_s: Vec<f64>,
    /// θ, rad.
    pub theta_rad: Vec<f64>,
    /// θ̇, rad/s: recorded, or by central differences if it was not.
    pub theta_dot_rad_s: Vec<f64>,
    /// F_ex, N; above 0 pushes into the object.
    pub force_ex_n: Vec<f64>,
    /// The actuators' force against the user, N; above 0 resists a push into the object. For a
    /// recording it is the commanded force. `None` if it was not recorded, and in closed loop.
    pub feedback_n: Option<Vec<f64>>,
}

impl Drive {
    /// Prepares a trial: its force becomes the model's input, its first sample the model's start.
    ///
    /// # Errors
    /// [`ReplayError::WhyNot`] where the recording or what is known of it lacks what every
    /// causality needs; columns of unequal length.
    pub fn new(trial: &Trial, rendering: &Rendering) -> Result<Self, ReplayError> {
        let absolute = trial.samples.get(Signal::Time).unwrap_or_default();
        if absolute.len() < 3 {
            return Err(WhyNot::TooShort.into());
        }
        let began_s = absolute[0];
        let t_s: Vec<f64> = absolute.iter().map(|t| t - began_s).collect();
        let column = |signal| column(trial, signal, t_s.len());
        let theta = column(Signal::Theta)?.ok_or(WhyNot::NoAngle)?;
        let force = column(Signal::ForceEx)?.ok_or(WhyNot::NoForce)?;
        let series = input(&t_s, force, column(Signal::ForceAge)?);
        let theta_dot = match column(Signal::ThetaDot)? {
            Some(recorded) => recorded.to_vec(),
            None => central_differences(&t_s, theta)?,
        };
        let voltages = [column(Signal::VoltageMotor)?, column(Signal::VoltageBrake)?];
        // Needed in closed loop alone: what is missing is an error there.
        let held = closed_loop::held(rendering, &t_s, voltages, &series);
        let start = Start { theta_rad: theta[0], theta_dot_rad_s: theta_dot[0] };
        // After the last update of the sensor the force is held.
        let last_n = series.value.last().copied().unwrap_or(0.0);
        let force_ex_n = t_s
            .iter()
            .map(|t| interpolate(&series.t_s, &series.value, *t).unwrap_or(last_n))
            .collect();
        let scene = rendering.scene(series, start, t_s[t_s.len() - 1])?;
        let feedback_n = column(Signal::ForceCmd)?.map(<[f64]>::to_vec);
        let theta_rad = theta.to_vec();
        let recorded =
            Course { t_s, theta_rad, theta_dot_rad_s: theta_dot, force_ex_n, feedback_n };
        let is_delayed = rendering.delay_s > 0.0;
        Ok(Self { began_s, recorded, scene, held, is_delayed })
    }

    /// The model's scene, with the thesis' plant.
    pub fn scene(&self) -> &ModelScene {
        &self.scene
    }

    /// The recorded course; its force is that between the sensor's updates.
    pub fn recorded(&self) -> &Course {
        &self.recorded
    }

    /// The model's course, at the recording's times.
    ///
    /// # Errors
    /// [`ReplayError::WhyNot`] in closed loop where the actuators' commands are not known, else where the environment
    /// was rendered late: what commands were given when is known in closed loop alone;
    /// parameters that make no model, or a model that diverges.
    pub fn run(
        &self,
        causality: Causality,
        parameters: &Parameters,
    ) -> Result<Course, ReplayError> {
        let Course { t_s, theta_rad, force_ex_n, .. } = &self.recorded;
        match causality {
            Causality::ForceDriven | Causality::PositionDriven if self.is_delayed => {
                Err(WhyNot::Delayed.into())
            }
            Causality::ForceDriven => {
                let system = System::new(parameters.put(&self.scene))?;
                let run = Exact::default().run(&system, &Grid::Times(t_s.clone()))?;
                let feedback_n = (0..run.len()).map(|i| {
                    let forces = run.forces(&system, i);
                    -(forces.motor_n + forces.brake_n)
                });
                Ok(Course {
                    t_s: t_s.clone(),
                    theta_rad: run.theta_rad().collect(),
                    theta_dot_rad_s: run.theta_dot_rad_s().collect(),
                    force_ex_n: force_ex_n.clone(),
                    feedback_n: Some(feedback_n.collect()),
                })
            }
            Causality::PositionDriven => {
                // What a lag holds is a state, and a prescribed motion has none.
                let system = System::new(parameters.without_lags().put(&self.scene))?;
                let theta_dot = central_differences(t_s, theta_rad)?;
                let theta_ddot = central_differences(t_s, &theta_dot)?;
                let forces: Vec<_> = (0..t_s.len())
                    .map(|i| system.prescribed(theta_rad[i], theta_dot[i], theta_ddot[i]))
                    .collect();
                Ok(Course {
                    t_s: t_s.clone(),
                    theta_rad: theta_rad.clone(),
                    theta_dot_rad_s: theta_dot,
                    force_ex_n: forces.iter().map(|f| f.external_n).collect(),
                    feedback_n: Some(forces.iter().map(|f| -(f.motor_n + f.brake_n)).collect()),
                })
            }
            Causality::ClosedLoop => {
                let held = self.held.as_ref().map_err(|why| *why)?;
                let (theta_rad, theta_dot_rad_s) =
                    closed_loop::run(held, t_s, &self.scene, parameters)?;
                let (t_s, force_ex_n) = (t_s.clone(), force_ex_n.clone());
                Ok(Course { t_s, theta_rad, theta_dot_rad_s, force_ex_n, feedback_n: None })
            }
        }
    }
}

/// Samples at least this far apart are judged, s: those between say nothing new of a movement of
/// the hand.
const LEAST_STEP_S: f64 = 0.004;

/// θ (rad) of a scene's model with these parameters driven by force, at any times: from 0 on,
/// increasing.
pub(crate) fn theta_at(
    scene: &ModelScene,
    t_s: &[f64],
    parameters: &Parameters,
) -> Result<Vec<f64>, DynamicsError> {
    let system = System::new(parameters.put(scene))?;
    Ok(Exact::default().run(&system, &Grid::Times(t_s.to_vec()))?.theta_rad().collect())
}

/// A trial at which a plant is judged: the error of the replay driven by force, at some of the
/// recording's samples: those that say something new of the movement. It keeps nothing of the
/// others, for a fit holds a thousand trials at once.
#[derive(Debug, Clone)]
pub struct Judged {
    scene: ModelScene,
    t_s: Vec<f64>,
    theta_rad: Vec<f64>,
}

impl Judged {
    /// Takes samples of the recording, each at least 4 ms after the one before.
    pub fn new(drive: Drive) -> Self {
        let mut t_s = Vec::new();
        let mut theta_rad = Vec::new();
        let recorded = drive.recorded();
        for (t, theta) in recorded.t_s.iter().zip(&recorded.theta_rad) {
            if t_s.last().is_none_or(|last| t - last >= LEAST_STEP_S) {
                t_s.push(*t);
                theta_rad.push(*theta);
            }
        }
        Self { scene: drive.scene, t_s, theta_rad }
    }

    /// Root mean square error of θ, rad; `None` where the model does not run.
    pub fn rmse_rad(&self, plant: &Parameters) -> Option<f64> {
        let replayed = theta_at(&self.scene, &self.t_s, plant).ok()?;
        let squares: f64 =
            replayed.iter().zip(&self.theta_rad).map(|(r, o)| (r - o) * (r - o)).sum();
        Some((squares / self.theta_rad.len() as f64).sqrt())
    }
}

/// A column of a trial, as long as its time; `None` if it was not recorded.
pub(crate) fn column(
    trial: &Trial,
    signal: Signal,
    expected: usize,
) -> Result<Option<&[f64]>, ReplayError> {
    match trial.samples.get(signal) {
        Some(values) if values.len() != expected => {
            Err(ReplayError::Ragged { column: signal.name(), expected, found: values.len() })
        }
        values => Ok(values),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{rendering, simulated};

    #[test]
    fn the_angle_at_other_times_is_that_of_the_whole_run() {
        let trial = simulated("hybrid", &Parameters::BY_EYE);
        let drive = Drive::new(&trial, &rendering("hybrid")).unwrap();
        let whole = drive.run(Causality::ForceDriven, &Parameters::BY_EYE).unwrap();
        let every: Vec<usize> = (0..whole.t_s.len()).step_by(7).collect();
        let times: Vec<f64> = every.iter().map(|i| whole.t_s[*i]).collect();
        let found = theta_at(&drive.scene, &times, &Parameters::BY_EYE).unwrap();
        for (found, i) in found.iter().zip(every) {
            assert!((found - whole.theta_rad[i]).abs() < 1e-9, "{found} at sample {i}");
        }
    }
}
