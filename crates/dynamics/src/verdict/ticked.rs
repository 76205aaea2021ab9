//! A plant in the loop of any digital controller, at times of its own: a recorded trial as a model
//! that any solver can move from tick to tick.

use super::model::Model;
use super::sampled::{held, tick_by_tick};
use crate::error::{DynamicsError, Result, check};
use crate::scene::ModelScene;
use crate::scene::friction::Friction;
use crate::scene::input::Input;
use crate::scene::plant::Start;
use crate::solve::{Grid, Solver};
use crate::system::System;
use crate::trajectory::Trajectory;

/// What acts on the lever's end from one tick to the next, N.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeldForces {
    /// The motor's force; above 0 pushes to +θ.
    pub pushing_n: f64,
    /// The brake's level: a set-valued force that resists whatever motion there is.
    pub brake_n: f64,
}

/// A digital controller, with the actuators behind it.
pub trait TickController: Clone + Sync {
    /// What acts from tick `number` (from 0) to the next; it sees θ there.
    fn tick(&mut self, number: usize, theta_rad: f64) -> HeldForces;
}

/// A scene's lever with its friction and stops, moved by a user's force and by a controller whose
/// ticks are given: they stay what they are, whatever the solver's step.
///
/// The user's force runs in straight lines from tick to tick. A step that does not divide a tick
/// ends it with a shorter one. Environment and actuators of the scene are not used: the controller
/// stands for both.
#[derive(Debug, Clone)]
pub struct TickedLoop<C> {
    plant: System,
    ticks_s: Vec<f64>,
    force_n: Vec<f64>,
    controller: C,
}

impl<C: TickController> TickedLoop<C> {
    /// Checks scene, ticks (s, from 0 on, increasing) and the user's force at each, N.
    ///
    /// # Errors
    /// A parameter that makes no sense; fewer than two ticks; forces of another number; a finger, a
    /// lag or an input of a term, whose states a tick would lose.
    pub fn new(
        scene: ModelScene,
        (ticks_s, force_n): (Vec<f64>, Vec<f64>),
        controller: C,
    ) -> Result<Self> {
        let lags = scene.motor.lag_s.is_some() || scene.brake.lag_on_off_s.is_some();
        if lags || scene.finger.is_some() || scene.terms.input().is_some() {
            let what = "a ticked loop goes on from tick to tick with θ and θ̇ alone";
            let remedy = "leave out finger, lags and moved springs";
            return Err(DynamicsError::Combination { what, remedy });
        }
        check("ticks", ticks_s.len() as f64, ticks_s.len() > 1, "at least 2")?;
        let same = ticks_s.len() == force_n.len();
        check("forces", force_n.len() as f64, same, "as many as ticks")?;
        Grid::Times(ticks_s.clone()).check()?;
        let duration_s = ticks_s[ticks_s.len() - 1];
        // Friction even where the scene has none: the brake's level is added to it at each tick.
        let none = Friction { static_n: 0.0, kinetic_n: 0.0, viscous_ns_per_rad: 0.0 };
        let friction = Some(scene.friction.unwrap_or(none));
        let input = Input::constant(0.0);
        let environment = crate::scene::environment::Environment::free();
        let scene = ModelScene { duration_s, friction, input, environment, ..scene };
        Ok(Self { plant: System::new(held(scene, 0.0))?, ticks_s, force_n, controller })
    }

    /// The scene from tick `k` to the next, from a state on.
    fn tick(&self, k: usize, start: Start, forces: HeldForces) -> Result<System> {
        let mut scene = held(self.plant.scene.clone(), forces.pushing_n);
        let from_s = self.ticks_s[k];
        let to_s = self.ticks_s[k + 1];
        let rate = (self.force_n[k + 1] - self.force_n[k]) / (to_s - from_s);
        // A line's value is that at t = 0, from which a tick is far.
        scene.input = Input::Line { value: self.force_n[k] - rate * from_s, rate };
        // The brake's level joins the dry friction, which is set-valued in the same way.
        if let Some(friction) = &mut scene.friction {
            friction.static_n += forces.brake_n;
            friction.kinetic_n += forces.brake_n;
        }
        // A stop that was met to rounding is not passed.
        scene.start = start;
        if let Some([low, high]) = scene.plant.stops_rad {
            scene.start.theta_rad = start.theta_rad.clamp(low, high);
        }
        System::new(scene)
    }
}

impl<C: TickController> Model for TickedLoop<C> {
    fn plant(&self) -> &System {
        &self.plant
    }

    fn run(&self, solver: &dyn Solver, step_s: f64) -> Result<Trajectory> {
        let mut controller = self.controller.clone();
        tick_by_tick(&self.plant, &self.ticks_s, solver, step_s, |k, start| {
            self.tick(k, start, controller.tick(k, start.theta_rad))
        })
    }

    fn method_step_s(&self, step_s: f64) -> f64 {
        let longest_s = self.ticks_s.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        step_s.min(longest_s)
    }

    /// A hold gives energy.
    fn is_conservative(&self, _: &Trajectory) -> bool {
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::actuators::DriveMode;
    use crate::scene::environment::Environment;
    use crate::{Controller, Exact, MoreauJean, Reference, RunVerdict, SampledLoop, table3};

    const PERIOD_S: f64 = 8.3e-3;

    /// The simulated device without friction: 0.0972 kg, 2.6 N s/m, on a lever of 1 m.
    fn device() -> ModelScene {
        let mut scene = table3::scene(DriveMode::Active, Input::constant(0.0));
        scene.environment = Environment::free();
        (scene.plant.mass_kg, scene.plant.lever_m) = (0.0972, 1.0);
        scene.plant.stops_rad = None;
        scene.friction = Some(Friction { static_n: 0.0, kinetic_n: 0.0, viscous_ns_per_rad: 2.6 });
        scene.start = Start { theta_rad: 1e-3, theta_dot_rad_s: 0.0 };
        scene.duration_s = 2.0;
        scene
    }

    /// A spring, and a brake at one level.
    #[derive(Debug, Clone, Copy)]
    struct Spring {
        stiffness: f64,
        brake_n: f64,
    }

    impl TickController for Spring {
        fn tick(&mut self, _: usize, theta_rad: f64) -> HeldForces {
            HeldForces { pushing_n: -self.stiffness * theta_rad, brake_n: self.brake_n }
        }
    }

    fn ticked(spring: Spring, force_n: f64) -> TickedLoop<Spring> {
        let ticks_s: Vec<f64> = (0..=240).map(|k| f64::from(k) * PERIOD_S).collect();
        let force_n = vec![force_n; ticks_s.len()];
        TickedLoop::new(device(), (ticks_s, force_n), spring).unwrap()
    }

    #[test]
    fn even_ticks_are_the_sampled_loop() {
        let ticked = ticked(Spring { stiffness: 600.0, brake_n: 0.0 }, 0.0);
        let controller = Controller {
            period_s: PERIOD_S,
            stiffness_n_per_rad: 600.0,
            damping_ns_per_rad: 0.0,
            rest_rad: 0.0,
            one_sided: false,
            delay_ticks: 0,
            max_n: 1e9,
        };
        let mut scene = device();
        scene.duration_s = 240.0 * PERIOD_S;
        let sampled = SampledLoop::new(scene, controller).unwrap();
        let [a, b] = [&ticked as &dyn Model, &sampled]
            .map(|model| model.run(&Exact::default(), 1e-3).unwrap());
        let far = a.theta_rad().zip(b.theta_rad()).map(|(a, b)| (a - b).abs());
        assert!(far.fold(0.0, f64::max) < 1e-13);
    }

    /// The lifted map's limit is 650.6 N/m.
    #[test]
    fn a_spring_grows_above_its_limit_and_dies_out_below_whatever_the_solvers_step() {
        for (stiffness, verdict) in [(560.0, RunVerdict::Transient), (760.0, RunVerdict::Growing)] {
            let ticked = ticked(Spring { stiffness, brake_n: 0.0 }, 0.0);
            let judged = Reference::of(&ticked).judge(&MoreauJean::default(), PERIOD_S / 4.0);
            assert_eq!(judged.verdict, verdict, "{stiffness}: {judged:?}");
        }
    }

    #[test]
    fn a_brake_above_the_push_holds_the_lever_and_one_below_it_lets_it_slip() {
        let moved = |brake_n: f64| {
            let spring = Spring { stiffness: 0.0, brake_n };
            let run = ticked(spring, 1.0).run(&Exact::default(), 1e-3).unwrap();
            run.theta_rad().last().unwrap() - 1e-3
        };
        assert!(moved(1.5).abs() < 1e-15);
        // F − brake = 0.5 N against 2.6 N s/m: x = (0.5/b)(t − (m/b)(1 − e^(−bt/m)))
        let (t, tau) = (240.0 * PERIOD_S, 0.0972 / 2.6);
        let expect = 0.5 / 2.6 * (t - tau * (1.0 - libm::exp(-t / tau)));
        assert!((moved(0.5) - expect).abs() < 1e-12, "{} {expect}", moved(0.5));
    }

    #[test]
    fn forces_of_another_number_and_lags_are_refused() {
        let spring = Spring { stiffness: 1.0, brake_n: 0.0 };
        let new = |scene, ticks: Vec<f64>, forces| {
            TickedLoop::new(scene, (ticks, forces), spring).unwrap_err().to_string()
        };
        assert!(new(device(), vec![0.0, 0.1], vec![0.0]).contains("forces"));
        assert!(new(device(), vec![0.0], vec![0.0]).contains("ticks"));
        assert!(new(device(), vec![0.0, 0.0], vec![0.0; 2]).contains("grid.times[1]"));
        let mut scene = device();
        scene.motor.lag_s = Some(0.01);
        assert!(new(scene, vec![0.0, 0.1], vec![0.0; 2]).contains("lags"));
    }
}
