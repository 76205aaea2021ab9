//! A plant in the loop of a digital controller; any solver can move it from tick to tick.

use serde::Serialize;

use super::model::Model;
use crate::error::{DynamicsError, Result, finite, not_negative, positive};
use crate::scene::ModelScene;
use crate::scene::parameter::Parameter;
use crate::scene::plant::{Plant, Start};
use crate::scene::terms::{Affine, Term};
use crate::solve::{Grid, Solver};
use crate::system::transition::EventKind;
use crate::system::{OMEGA, System, THETA};
use crate::trajectory::Trajectory;

/// A virtual spring and damper with a zero-order hold: at each tick
/// u = K (θ − θ_rest) + B (θ − θ_before) / T, and from so many ticks later on, for one period,
/// the force −clamp(u, −max, max) at the lever's end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// T, s.
    pub period_s: f64,
    /// K, N/rad.
    pub stiffness_n_per_rad: f64,
    /// B, N s/rad, on the backward difference of θ.
    pub damping_ns_per_rad: f64,
    /// θ_rest, rad.
    pub rest_rad: f64,
    /// Whether it is a wall: u = 0 below θ_rest, and u ≥ 0 above.
    pub one_sided: bool,
    /// Ticks between a measurement and its force; 0 acts at once.
    pub delay_ticks: usize,
    /// Largest force, N.
    pub max_n: f64,
}

impl Controller {
    fn check(&self) -> Result<()> {
        positive("controller.period_s", self.period_s)?;
        not_negative("controller.stiffness_n_per_rad", self.stiffness_n_per_rad)?;
        finite("controller.damping_ns_per_rad", self.damping_ns_per_rad)?;
        finite("controller.rest_rad", self.rest_rad)?;
        not_negative("controller.max_n", self.max_n)
    }

    /// The force that follows from a measurement, N.
    fn force_n(&self, theta: f64, before: f64) -> f64 {
        let pressed = theta - self.rest_rad;
        let rate = (theta - before) / self.period_s;
        let u = self.stiffness_n_per_rad * pressed + self.damping_ns_per_rad * rate;
        let low = if self.one_sided { 0.0 } else { -self.max_n };
        if self.one_sided && pressed <= 0.0 { 0.0 } else { -u.max(low).min(self.max_n) }
    }
}

/// A scene whose lever a [`Controller`] pushes on top of all that the scene has. The controller's
/// period is its own, whatever the solver's step: a step that does not divide it ends it with a
/// shorter one.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledLoop {
    plant: System,
    controller: Controller,
}

impl SampledLoop {
    /// Checks scene and controller.
    ///
    /// # Errors
    /// A parameter that makes no sense; a finger or a lag, whose states a tick would lose.
    pub fn new(scene: ModelScene, controller: Controller) -> Result<Self> {
        controller.check()?;
        let lags = scene.motor.lag_s.is_some() || scene.brake.lag_on_off_s.is_some();
        if lags || scene.finger.is_some() {
            let what = "a sampled loop goes on from tick to tick with θ and θ̇ alone";
            let remedy = "leave out finger and lags";
            return Err(DynamicsError::Combination { what, remedy });
        }
        Ok(Self { plant: System::new(held(scene, 0.0))?, controller })
    }
}

impl Model for SampledLoop {
    fn plant(&self) -> &System {
        &self.plant
    }

    fn run(&self, solver: &dyn Solver, step_s: f64) -> Result<Trajectory> {
        let Controller { period_s, delay_ticks, .. } = self.controller;
        let ticks = Grid::filling(self.plant.scene.duration_s, period_s);
        let ticks_s: Vec<f64> = (0..ticks.samples()).map(|k| ticks.time(k)).collect();
        let mut before = self.plant.scene.start.theta_rad;
        let mut commands: Vec<f64> = Vec::with_capacity(ticks.samples());
        tick_by_tick(&self.plant, &ticks_s, solver, step_s, |k, start| {
            commands.push(self.controller.force_n(start.theta_rad, before));
            before = start.theta_rad;
            // The scene under a force that is held, from a state on.
            let force_n = k.checked_sub(delay_ticks).map_or(0.0, |at| commands[at]);
            System::new(ModelScene { start, ..held(self.plant.scene.clone(), force_n) })
        })
    }

    fn method_step_s(&self, step_s: f64) -> f64 {
        step_s.min(self.controller.period_s)
    }

    /// A hold gives energy.
    fn is_conservative(&self, _: &Trajectory) -> bool {
        false
    }
}

/// Moves a plant from tick to tick, each by the system that `tick` makes of its number and of the
/// state there, with steps of `step_s`, the last one before a tick shorter where it must be.
pub(super) fn tick_by_tick(
    plant: &System,
    ticks_s: &[f64],
    solver: &dyn Solver,
    step_s: f64,
    mut tick: impl FnMut(usize, Start) -> Result<System>,
) -> Result<Trajectory> {
    positive("grid.step_s", step_s)?;
    let mut start = plant.scene.start;
    let mut out = Trajectory::new(plant.layout, ticks_s.len());
    for (k, pair) in ticks_s.windows(2).enumerate() {
        let steps = Grid::filling(pair[1] - pair[0], step_s);
        let mut times: Vec<f64> = (0..steps.samples()).map(|i| pair[0] + steps.time(i)).collect();
        // The next tick itself, which a sum of steps may miss by its rounding.
        times.pop();
        times.push(pair[1]);
        let run = solver.run(&tick(k, start)?, &Grid::Times(times))?;
        let last = run.state(run.len() - 1);
        start = Start { theta_rad: last[THETA], theta_dot_rad_s: last[OMEGA] };
        append(&mut out, &run, k + 2 == ticks_s.len());
    }
    Ok(out)
}

/// Adds the run of a tick, whose last sample is the next one's first.
fn append(out: &mut Trajectory, run: &Trajectory, whole: bool) {
    let samples = run.len() - usize::from(!whole);
    for i in 0..samples {
        let number = out.region_number(&run.regions[usize::from(run.region[i])]);
        out.t_s.push(run.t_s[i]);
        out.states.extend_from_slice(run.state(i));
        out.region.push(number);
    }
    // Each tick's run begins with an event of its input; only the first is one of the whole run.
    let first = out.events.is_empty();
    let ticks = run.events.iter().filter(|event| first || event.kind != EventKind::Input);
    out.events.extend(ticks);
    out.work.steps += run.work.steps;
    out.work.rejected += run.work.rejected;
    out.work.evaluations += run.work.evaluations;
    out.work.factorisations += run.work.factorisations;
}

/// A force that is held between two ticks.
#[derive(Debug, Serialize)]
struct Held {
    force_n: f64,
}

impl Term for Held {
    fn name(&self) -> &'static str {
        "held"
    }

    fn about(&self) -> &'static str {
        "force of the controller"
    }

    fn parameters(&self) -> Vec<Parameter> {
        vec![Parameter::any("force_n", self.force_n, 1.0)]
    }

    fn affine(&self, _: &Plant) -> Affine {
        Affine { constant_n: self.force_n, ..Affine::default() }
    }
}

pub(super) fn held(mut scene: ModelScene, force_n: f64) -> ModelScene {
    scene.terms.set(Held { force_n });
    scene
}
