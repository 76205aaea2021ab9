//! What the actuators are commanded to do on each side, as clamped functionals.

use super::region::{Branch, Side};
use super::row::Row;
use super::{OMEGA, System, THETA};
use crate::scene::ModelScene;
use crate::scene::actuators::{BrakeLaw, DriveMode};
use crate::scene::environment::Demand;

/// Which force a command goes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Actuator {
    /// None: no force.
    Nobody,
    /// The motor, with the force −value.
    Motor,
    /// The brake of the thesis, with the force −value.
    SignedBrake,
    /// The set-valued brake, with the level value.
    Brake,
}

/// clamp(row · z, low, high) for one actuator.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Command {
    pub(crate) actuator: Actuator,
    pub(crate) row: Row,
    pub(crate) low: f64,
    pub(crate) high: f64,
}

impl Command {
    /// The line the clamped value is on.
    pub(crate) fn branch(&self, z: &[f64]) -> Branch {
        let value = self.row.dot(z);
        if value < self.low {
            Branch::Low
        } else if value > self.high {
            Branch::High
        } else {
            Branch::Linear
        }
    }

    /// The functional that holds on a line.
    pub(crate) fn on(&self, branch: Branch, system: &System) -> Row {
        match branch {
            Branch::Low => system.constant(self.low),
            Branch::Linear => self.row,
            Branch::High => system.constant(self.high),
        }
    }
}

/// The actuator that acts in a mode on a side (the table of the modes, [`DriveMode::by_motor`]).
pub(crate) fn actuator(mode: DriveMode, law: BrakeLaw, side: Side) -> Actuator {
    let [up, down] = mode.by_motor();
    match (side, law) {
        (Side::Up, _) if up => Actuator::Motor,
        (Side::Down, _) if down => Actuator::Motor,
        (Side::Up, BrakeLaw::Thesis) => Actuator::SignedBrake,
        (Side::Down, BrakeLaw::Thesis) => Actuator::Nobody,
        (_, BrakeLaw::Coulomb) => Actuator::Brake,
    }
}

impl System {
    /// The command on a side in a zone.
    pub(crate) fn command(&self, side: Side, zone: u16) -> Command {
        let scene = &self.scene;
        let actuator = actuator(scene.mode, scene.brake.law, side);
        // A held command is an entry of the state, without limits: its controller has clamped it.
        if let Some(at) = self.layout.held {
            return Command { row: Row::entry(at, 1.0), ..self.fixed(actuator, 0.0) };
        }
        let (low, high, dead_zone) = self.limits(actuator);
        // A brake that lets the lever slip backwards follows u(θ) alone: damping would ask it to
        // let go.
        let damped = !(actuator == Actuator::Brake && side == Side::Down);
        match scene.environment.zones[usize::from(zone)].demand {
            Demand::Spring { stiffness_n_per_rad: k, damping_ns_per_rad: b, rest_rad } => {
                let row = Row::entry(THETA, k)
                    .plus(Row::entry(OMEGA, if damped { b } else { 0.0 }))
                    .plus(self.constant(-k * rest_rad - dead_zone));
                Command { actuator, row, low, high }
            }
            Demand::Force { force_n } => {
                Command { actuator, row: self.constant(force_n - dead_zone), low, high }
            }
            Demand::Full => self.fixed(actuator, high),
            Demand::FullUp if actuator == Actuator::Brake => self.fixed(actuator, high),
            Demand::FullUp => self.fixed(actuator, low),
        }
    }

    /// The lowest and the highest value of an actuator's command, and its dead zone, N.
    #[inline]
    pub(super) fn limits(&self, actuator: Actuator) -> (f64, f64, f64) {
        let ModelScene { motor, brake, .. } = &self.scene;
        match actuator {
            Actuator::Nobody => (0.0, 0.0, 0.0),
            Actuator::Motor => (-motor.max_n, motor.max_n, 0.0),
            Actuator::SignedBrake => (-brake.max_n, brake.max_n, 0.0),
            Actuator::Brake => (0.0, brake.max_n, brake.dead_zone_n),
        }
    }

    /// The same value everywhere: a line without limits.
    fn fixed(&self, actuator: Actuator, value: f64) -> Command {
        Command { actuator, row: self.constant(value), low: f64::NEG_INFINITY, high: f64::INFINITY }
    }

    /// The zone just above (side up) or just below (side down) an angle.
    #[inline]
    pub(crate) fn zone(&self, theta: f64, side: Side) -> u16 {
        let zones = &self.scene.environment.zones[1..];
        let above = match side {
            Side::Up => zones.iter().take_while(|zone| theta >= zone.from_rad).count(),
            Side::Down => zones.iter().take_while(|zone| theta > zone.from_rad).count(),
        };
        above as u16
    }
}
