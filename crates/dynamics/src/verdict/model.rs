//! The model that a verdict is about.

use crate::error::Result;
use crate::scene::finger::FingerLaw;
use crate::solve::{Grid, Solver};
use crate::system::direct::Law;
use crate::system::row::MOST;
use crate::system::{OMEGA, RestRule, System};
use crate::trajectory::Trajectory;

/// A model that any solver moves with a step of its own.
pub trait Model: Sync {
    /// The plant, by whose regions a method's stability is judged.
    fn plant(&self) -> &System;

    /// A run over the scene's duration. Whatever times the model has of its own, such as a
    /// controller's period, stay as they are whatever the step.
    ///
    /// # Errors
    /// As [`Solver::run`].
    fn run(&self, solver: &dyn Solver, step_s: f64) -> Result<Trajectory>;

    /// The step that the method really takes.
    fn method_step_s(&self, step_s: f64) -> f64 {
        step_s
    }

    /// Whether nothing takes energy out of the motion or puts it in, as far as a run shows.
    fn is_conservative(&self, run: &Trajectory) -> bool;

    /// The same model with the other rule for the command at rest; none where that makes no
    /// difference.
    fn with_other_rest_rule(&self) -> Option<Box<dyn Model + '_>> {
        None
    }
}

impl Model for System {
    fn plant(&self) -> &System {
        self
    }

    fn run(&self, solver: &dyn Solver, step_s: f64) -> Result<Trajectory> {
        solver.run(self, &Grid::filling(self.scene.duration_s, step_s))
    }

    /// Whether the force on the lever is the same whichever way it moves and however fast, and
    /// nothing else loses energy: at up to 64 states of the run.
    fn is_conservative(&self, run: &Trajectory) -> bool {
        /// States that are looked at.
        const STATES: usize = 64;
        let scene = &self.scene;
        let lags = scene.motor.lag_s.is_some() || scene.brake.lag_on_off_s.is_some();
        let finger = scene.finger.is_none_or(|finger| {
            finger.law == FingerLaw::Consistent
                && finger.damping_ns_per_m <= 0.0
                && finger.length_m.is_none()
        });
        let inside = scene
            .plant
            .stops_rad
            .is_none_or(|[low, high]| run.theta_rad().all(|theta| low < theta && theta < high));
        let stride = run.len().div_ceil(STATES).max(1);
        !lags
            && finger
            && inside
            && (0..run.len()).step_by(stride).all(|i| self.ignores_velocity(run.state(i)))
    }

    fn with_other_rest_rule(&self) -> Option<Box<dyn Model + '_>> {
        let lags = self.scene.motor.lag_s.is_some() || self.scene.brake.lag_on_off_s.is_some();
        let other = match self.rest_rule {
            RestRule::Release => RestRule::Compress,
            RestRule::Compress => RestRule::Release,
        };
        (lags && self.scene.mode.takes_over())
            .then(|| Box::new(self.clone().with_rest_rule(other)) as Box<dyn Model>)
    }
}

impl System {
    /// Whether θ̈ at a state does not depend on θ̇.
    fn ignores_velocity(&self, z: &[f64]) -> bool {
        /// Relative size of a difference that is rounding.
        const ROUNDING: f64 = 1e-9;
        let [up, down] = [1.0, -1.0].map(|direction| {
            let mut z = z.to_vec();
            // At 1 rad/s at least: damping would not show on a state at rest.
            z[OMEGA] = direction * z[OMEGA].abs().max(1.0);
            let mut slope = [0.0; MOST];
            self.slope(&z, Law { direction, held: false }, &mut slope);
            slope[OMEGA]
        });
        (up - down).abs() <= ROUNDING * (up.abs() + down.abs())
    }
}
