//! A scene whose commands are held by a digital controller, moved exactly from moment to moment.
//!
//! The command is one more entry of the augmented state. While the motor is in charge, the scene is
//! that of the mode `active`; while the brake is, that of `passive`. Both have the same entries, so
//! the state is passed on as it is. Regions are prepared when they are first met, and kept.

use super::Exact;
use super::compiled::Reach;
use super::run::Stepped;
use crate::error::{DynamicsError, Result, finite};
use crate::scene::ModelScene;
use crate::scene::actuators::{BrakeLaw, DriveMode};
use crate::scene::environment::Environment;
use crate::system::command::Actuator;
use crate::system::region::{Contact, Side};
use crate::system::row::MOST;
use crate::system::{OMEGA, System, THETA};
use crate::trajectory::{Forces, WorkCounts};

/// The command of a digital controller, held until the next one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HeldCommand {
    /// Whether the motor is in charge, not the brake.
    pub by_motor: bool,
    /// Resisting force u of the motor, which gives −u, or level of the brake, N.
    pub force_n: f64,
}

/// A scene made for commands that are held: what it is made of, apart from what moves.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldScene {
    /// The scene with its own law, which commands are taken from.
    law: System,
    motor: System,
    brake: System,
}

impl HeldScene {
    /// Checks a scene; curved terms become chords of at most `chord_rad` ([`System::by_chords`]).
    ///
    /// # Errors
    /// A parameter that makes no sense; the thesis' brake, which has no level that could be held; a
    /// term with an input of its own.
    pub fn new(scene: &ModelScene, chord_rad: f64) -> Result<Self> {
        if scene.brake.law == BrakeLaw::Thesis {
            let what = "a held command needs the level of a set-valued brake";
            let remedy = "set brake.law to \"coulomb\"";
            return Err(DynamicsError::Combination { what, remedy });
        }
        if scene.terms.input().is_some() {
            let what = "a scene with held commands has no room for a term with an input of its own";
            return Err(DynamicsError::Combination { what, remedy: "leave the moved spring out" });
        }
        let [motor, brake] = [DriveMode::Active, DriveMode::Passive].map(|mode| {
            let environment = Environment::free();
            let scene = ModelScene { mode, environment, ..scene.clone() };
            System::laid_out(scene, true)?.straightened(chord_rad)
        });
        Ok(Self { law: System::new(scene.clone())?, motor: motor?, brake: brake? })
    }

    /// Entries of the augmented state.
    pub fn entries(&self) -> usize {
        self.motor.layout.n
    }

    /// The command of the scene's environment and mode at an angle (rad) and a velocity (rad/s),
    /// clamped as the actuators are. `compressing` decides which of the mode's actuators is in
    /// charge.
    pub fn asked(&self, theta_rad: f64, theta_dot_rad_s: f64, compressing: bool) -> HeldCommand {
        let mut z = [0.0; MOST];
        (z[THETA], z[OMEGA]) = (theta_rad, theta_dot_rad_s);
        let side = if compressing { Side::Up } else { Side::Down };
        let (actuator, force_n) = self.law.commanded_value(&z, side);
        HeldCommand { by_motor: actuator == Actuator::Motor, force_n }
    }

    /// The scene at its start with nothing commanded; `longest_s` is the longest time that it will
    /// be moved by at once.
    ///
    /// # Errors
    /// A state that is not finite.
    pub fn start(&self, longest_s: f64) -> Result<HeldRun<'_>> {
        // A controller's moves have one length: pieces are then halves of it, and leave nothing
        // over.
        let reach = Reach { longest_s, even: true };
        let [motor, brake] =
            [&self.motor, &self.brake].map(|system| system.stepped(Exact::default(), reach));
        let (z, _) = self.motor.start();
        let held = HeldCommand { by_motor: true, force_n: 0.0 };
        let mut run =
            HeldRun { motor, brake, held, t_s: 0.0, moves: 0, scene: self, reach_s: longest_s };
        run.motor.take_up(0.0, &z, Contact::Free)?;
        Ok(run)
    }
}

/// A scene on its way.
pub struct HeldRun<'a> {
    scene: &'a HeldScene,
    motor: Box<dyn Stepped + 'a>,
    brake: Box<dyn Stepped + 'a>,
    held: HeldCommand,
    t_s: f64,
    reach_s: f64,
    moves: u64,
}

impl HeldRun<'_> {
    /// Now, s.
    pub fn t_s(&self) -> f64 {
        self.t_s
    }

    /// θ, rad.
    pub fn theta_rad(&self) -> f64 {
        self.now().state()[THETA]
    }

    /// θ̇, rad/s.
    pub fn theta_dot_rad_s(&self) -> f64 {
        self.now().state()[OMEGA]
    }

    /// F_ex, N.
    pub fn force_ex_n(&self) -> f64 {
        self.now().state()[self.system().layout.force]
    }

    /// The forces by part.
    pub fn forces(&self) -> Forces {
        let stepped = self.now();
        self.system().forces(stepped.region(), stepped.state())
    }

    /// Commands this from now on.
    ///
    /// # Errors
    /// A command that is not finite; a state that is not.
    pub fn hold(&mut self, command: HeldCommand) -> Result<()> {
        finite("command.force_n", command.force_n)?;
        if command == self.held {
            return Ok(());
        }
        let mut z = [0.0; MOST];
        let contact = self.now().region().contact;
        let state = self.now().state();
        z[..state.len()].copy_from_slice(state);
        if let Some(at) = self.system().layout.held {
            z[at] = command.force_n;
        }
        // Read before and taken up after the change: another command may be another actuator's run.
        self.held = command;
        let t_s = self.t_s;
        self.now_mut().take_up(t_s, &z, contact)
    }

    /// Moves on until a moment, s; not beyond the end requested at the start.
    ///
    /// # Errors
    /// A state that is no longer finite, or a work limit.
    pub fn advance(&mut self, to_s: f64) -> Result<()> {
        while self.t_s < to_s {
            // What is a multiple of the reach up to rounding is that many equal moves.
            let next_s = if to_s - self.t_s > self.reach_s * (1.0 + 1e-9) {
                self.t_s + self.reach_s
            } else {
                to_s
            };
            let from_s = self.t_s;
            self.now_mut().advance(from_s, next_s)?;
            self.t_s = next_s;
            self.moves += 1;
        }
        Ok(())
    }

    /// Moves, products with a flow matrix, and exponentials so far.
    pub fn work(&self) -> WorkCounts {
        let [motor, brake] = [self.motor.counts(), self.brake.counts()];
        WorkCounts {
            steps: self.moves,
            rejected: 0,
            evaluations: self.moves + motor[0] + brake[0],
            factorisations: motor[1] + brake[1],
        }
    }

    fn system(&self) -> &System {
        if self.held.by_motor { &self.scene.motor } else { &self.scene.brake }
    }

    fn now(&self) -> &dyn Stepped {
        if self.held.by_motor { &*self.motor } else { &*self.brake }
    }

    fn now_mut(&mut self) -> &mut dyn Stepped {
        if self.held.by_motor { &mut *self.motor } else { &mut *self.brake }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::input::Input;
    use crate::scene::table3;
    use crate::{Brake, Friction, Gravity, Grid, Solver};

    fn scene(mode: DriveMode) -> ModelScene {
        let mut scene = table3::scene(mode, Input::constant(1.0));
        scene.environment = Environment::spring(4.0, 0.0, -0.785);
        scene.plant.stops_rad = None;
        scene
    }

    fn command(by_motor: bool, force_n: f64) -> HeldCommand {
        HeldCommand { by_motor, force_n }
    }

    /// 1 N of the user and 0.4 N of the motor against it: θ = θ₀ + ½ (0.6/0.005) t².
    #[test]
    fn a_held_force_accelerates_a_free_lever_as_a_parabola() {
        let held = HeldScene::new(&scene(DriveMode::Active), 0.1).unwrap();
        let mut run = held.start(0.01).unwrap();
        run.hold(command(true, 0.4)).unwrap();
        run.advance(0.05).unwrap();
        let expect = held.law.scene.start.theta_rad + 0.5 * (0.6 / 0.005) * 0.05 * 0.05;
        assert!((run.theta_rad() - expect).abs() < 1e-13, "{}", run.theta_rad() - expect);
        assert!((run.theta_dot_rad_s() - 120.0 * 0.05).abs() < 1e-12);
        let forces = run.forces();
        assert!((forces.motor_n + 0.4).abs() < 1e-15 && (forces.external_n - 1.0).abs() < 1e-15);
    }

    #[test]
    fn a_brake_that_is_held_above_the_push_stops_the_lever_and_below_it_slips() {
        let held = HeldScene::new(&scene(DriveMode::Passive), 0.1).unwrap();
        let mut run = held.start(0.01).unwrap();
        run.advance(0.02).unwrap();
        run.hold(command(false, 5.0)).unwrap();
        run.advance(0.2).unwrap();
        assert!(run.theta_dot_rad_s().abs() < 1e-300);
        assert!((run.forces().brake_n + 1.0).abs() < 1e-12);
        let rest_rad = run.theta_rad();
        run.hold(command(false, 0.5)).unwrap();
        run.advance(0.25).unwrap();
        assert!((run.theta_rad() - rest_rad - 0.5 * 100.0 * 0.05 * 0.05).abs() < 1e-12);
    }

    /// From the motor to the brake and back, with a lag: the motor's force decays by itself.
    #[test]
    fn a_lagging_motor_goes_on_while_the_brake_is_in_charge() {
        let mut scene = scene(DriveMode::Hybrid);
        scene.motor.lag_s = Some(0.02);
        let held = HeldScene::new(&scene, 0.1).unwrap();
        let mut run = held.start(0.01).unwrap();
        run.hold(command(true, 2.0)).unwrap();
        run.advance(0.01).unwrap();
        let reached = -2.0 * (1.0 - (-0.5_f64).exp());
        assert!((run.forces().motor_n - reached).abs() < 1e-12);
        run.hold(command(false, 0.0)).unwrap();
        run.advance(0.03).unwrap();
        assert!((run.forces().motor_n - reached * (-1.0_f64).exp()).abs() < 1e-12);
    }

    #[test]
    fn commands_that_follow_the_law_often_enough_come_to_the_law_itself() {
        let mut scene = scene(DriveMode::Active);
        scene.friction = Some(Friction { static_n: 0.1, kinetic_n: 0.1, viscous_ns_per_rad: 0.2 });
        scene.terms.set(Gravity { mass_kg: 0.02, radius_m: 0.04 });
        let chord_rad = 5_f64.to_radians();
        let system = System::by_chords(scene.clone(), chord_rad).unwrap();
        let truth = Exact::default().run(&system, &Grid::filling(1.0, 0.01)).unwrap();
        let end_rad = truth.state(truth.len() - 1)[THETA];
        let held = HeldScene::new(&scene, chord_rad).unwrap();
        let off = |tick_s: f64| {
            let mut run = held.start(tick_s).unwrap();
            for k in 0..(1.0 / tick_s).round() as u32 {
                run.hold(held.asked(run.theta_rad(), run.theta_dot_rad_s(), true)).unwrap();
                run.advance(f64::from(k + 1) * tick_s).unwrap();
            }
            (run.theta_rad() - end_rad).abs()
        };
        let (coarse, fine) = (off(1e-3), off(1e-4));
        assert!(fine < 0.2 * coarse + 1e-9 && coarse < 0.02, "{coarse} {fine}");
    }

    #[test]
    fn the_thesis_brake_has_no_level_that_could_be_held() {
        let mut scene = scene(DriveMode::Hybrid);
        scene.brake = Brake { law: BrakeLaw::Thesis, ..scene.brake };
        let error = HeldScene::new(&scene, 0.1).unwrap_err().to_string();
        assert!(error.contains("brake.law"), "{error}");
    }
}
