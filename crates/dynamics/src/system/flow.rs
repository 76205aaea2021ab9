//! The affine flow of a region, put together from the forces on the lever and on the finger.

use super::command::{Actuator, Command};
use super::guards::Guard;
use super::region::{Branch, Contact, Motion, Region, Side};
use super::row::{Functional, MOST, Row};
use super::{OMEGA, RestRule, System, THETA};
use crate::affine::Number;
use crate::scene::finger::FingerLaw;
use crate::scene::input::Input;
use zwidth_numerics::expm::Pair;

/// ż = A z, and in some rows the terms' curved force so many times; the region's guards.
#[derive(Debug, Clone)]
pub(crate) struct Flow {
    pub(crate) rows: [Row; MOST],
    pub(crate) curved: [f64; MOST],
    pub(crate) guards: Vec<Guard>,
}

/// The forces on the lever in a region, as functionals; up is positive.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LeverForces {
    /// The finger or the user.
    pub(crate) tip: Row,
    /// The motor.
    pub(crate) motor: Row,
    /// The thesis' brake.
    pub(crate) signed_brake: Row,
    /// Level of the set-valued brake, not below zero.
    pub(crate) level: Row,
    /// Viscous friction.
    pub(crate) viscous: Row,
    /// The terms' curved parts, where they are straight lines.
    pub(crate) chords: Row,
}

impl System {
    /// Command and line that hold for motion on a side of a region.
    pub(crate) fn commanded(&self, region: &Region, side: Side) -> (Command, Branch) {
        match side {
            Side::Up => (self.command(side, region.zone_up), region.branch_up),
            Side::Down => (self.command(side, region.zone_down), region.branch_down),
        }
    }

    /// The forces if the lever moves (or were to move) to a side.
    pub(crate) fn lever_forces(&self, region: &Region, side: Side) -> LeverForces {
        let (command, branch) = self.commanded(region, side);
        let value = command.on(branch, self);
        let viscous = self.scene.friction.map_or(0.0, |friction| friction.viscous_ns_per_rad);
        let mut forces = LeverForces {
            tip: self.tip(region.contact),
            motor: Row::ZERO,
            signed_brake: Row::ZERO,
            level: Row::ZERO,
            viscous: Row::entry(OMEGA, -viscous),
            chords: self.chord(region, side),
        };
        match command.actuator {
            Actuator::Nobody => {}
            Actuator::Motor => forces.motor = value.times(-1.0),
            Actuator::SignedBrake => forces.signed_brake = value.times(-1.0),
            Actuator::Brake => forces.level = value,
        }
        // A lagging actuator gives what its entry of the state says, whatever it is commanded.
        if let Some(at) = self.layout.motor {
            forces.motor = Row::entry(at, 1.0);
        }
        if let Some(at) = self.layout.brake {
            forces.level = Row::entry(at, 1.0);
        }
        forces
    }

    /// Force on the lever's end: the user's, or the tissue's K_F x2 + B_F ẋ2 (9).
    fn tip(&self, contact: Contact) -> Row {
        match (&self.scene.finger, self.layout.finger) {
            (Some(finger), Some(at)) if contact == Contact::Free => {
                Row::entry(at, finger.stiffness_n_per_m)
                    .plus(Row::entry(at + 1, finger.damping_ns_per_m))
            }
            _ => Row::entry(self.layout.force, 1.0),
        }
    }

    /// The single-valued forces of a side together, but for the terms' curved part.
    pub(crate) fn single_valued<T: Number>(&self, forces: &LeverForces) -> Row<T> {
        let own = [forces.tip, forces.motor, forces.signed_brake, forces.viscous, forces.chords];
        own.iter().chain(&self.terms).fold(Row::zero(), |sum, row| sum.plus(row.lifted()))
    }

    /// M_O L: what a force at the lever's end accelerates, kg m; with the finger's mass once its
    /// tissue is rigid.
    pub(crate) fn moving_inertia<T: Number>(&self, contact: Contact) -> T {
        let lever = T::from(self.scene.plant.lever_m);
        let finger = self
            .scene
            .finger
            .filter(|f| f.law == FingerLaw::Consistent && contact != Contact::Free);
        (T::from(self.scene.plant.mass_kg) + T::from(finger.map_or(0.0, |f| f.mass_kg))) * lever
    }

    /// θ̈ of a region (10); zero at rest.
    fn acceleration<T: Number>(&self, region: &Region) -> Row<T> {
        let Some(side) = region.side() else { return Row::zero() };
        let forces = self.lever_forces(region, side);
        let kinetic = self.constant(self.scene.friction.map_or(0.0, |friction| friction.kinetic_n));
        let dry = forces.level.plus(kinetic).times(-side.sign());
        self.single_valued::<T>(&forces)
            .plus(dry.lifted())
            .over(self.moving_inertia(region.contact))
    }

    /// θ̈ in a region with its curved part.
    pub(crate) fn acceleration_in(&self, region: &Region) -> Functional {
        let moves = region.motion != Motion::Rest;
        let curved = if moves { 1.0 / self.moving_inertia::<f64>(region.contact) } else { 0.0 };
        Functional { row: self.acceleration(region), curved }
    }

    /// The flow of a region and the ways out of it.
    pub(crate) fn flow(&self, region: &Region) -> Flow {
        let mut guards = match region.side() {
            Some(side) => self.moving_guards(region, side),
            None => self.rest_guards(region),
        };
        guards.extend(self.finger_guards(region));
        Flow { rows: self.rows(region), curved: self.curved(region), guards }
    }

    /// What rounding took from the coefficients of a region's flow, such as K_O/(M_O L).
    pub(crate) fn rest(&self, region: &Region) -> [[f64; MOST]; MOST] {
        self.rows::<Pair>(region).map(|row| row.0.map(|x| x.low))
    }

    /// A of ż = A z in a region.
    fn rows<T: Number>(&self, region: &Region) -> [Row<T>; MOST] {
        let mut rows = [Row::zero(); MOST];
        let acceleration = self.acceleration(region);
        if region.motion != Motion::Rest {
            rows[THETA] = Row::entry(OMEGA, T::from(1.0));
            rows[OMEGA] = acceleration;
        }
        if let (Some(finger), Some(at)) = (&self.scene.finger, self.layout.finger)
            && region.contact == Contact::Free
        {
            rows[at] = Row::entry(at + 1, T::from(1.0));
            // M_F ẍ2 = F_F + F_ex (11), and in the consistent law − M_F L θ̈.
            let net = Row::entry(self.layout.force, 1.0).minus(self.tip(Contact::Free));
            let row = net.lifted().over(T::from(finger.mass_kg));
            rows[at + 1] = match finger.law {
                FingerLaw::Consistent => {
                    row.minus(acceleration.times(T::from(self.scene.plant.lever_m)))
                }
                FingerLaw::Thesis => row,
            };
        }
        // τ ẋ = command − x for the motor's force and the brake's level. A lever at rest is
        // commanded as one that holds or releases, unless the let-go rule keeps the brake on; where
        // the brake does part of the holding by fast switching, a lagging motor is off for its
        // share of the time.
        let engaged = region.held || self.rest_rule == RestRule::Compress;
        let up = region.motion == Motion::Forward || (region.motion == Motion::Rest && engaged);
        let (command, branch) = self.commanded(region, if up { Side::Up } else { Side::Down });
        let value = command.on(branch, self);
        if let (Some(at), Some(lag)) = (self.layout.motor, self.scene.motor.lag_s) {
            let target =
                if command.actuator == Actuator::Motor { value.times(-1.0) } else { Row::ZERO };
            let brake_holds = self.departing_force(region, Side::Down);
            let shared = target.plus(brake_holds.row.times(region.motor_share));
            rows[at] = shared.minus(Row::entry(at, 1.0)).lifted().over(T::from(lag));
        }
        if let (Some(at), Some([on, off])) = (self.layout.brake, self.scene.brake.lag_on_off_s) {
            let engaged = command.actuator == Actuator::Brake;
            let (target, lag) = if engaged { (value, on) } else { (Row::ZERO, off) };
            rows[at] = target.minus(Row::entry(at, 1.0)).lifted().over(T::from(lag));
        }
        // x¨ = −ω² (x − mean) for each input.
        let force = (self.layout.force, self.scene.input.swing());
        let term = self.layout.term.zip(self.scene.terms.input().map(Input::swing));
        for (at, (omega, mean)) in std::iter::once(force).chain(term) {
            rows[at] = Row::entry(at + 1, T::from(1.0));
            // Squared as `T`: the product of two doubles would be rounded before it is lifted.
            let square = T::from(omega) * T::from(omega);
            let pulled = self.constant(mean).minus(Row::entry(at, 1.0));
            rows[at + 1] = pulled.lifted().times(square);
        }
        rows
    }

    /// How many times the terms' curved force stands in each row.
    pub(crate) fn curved(&self, region: &Region) -> [f64; MOST] {
        let mut curved = [0.0; MOST];
        if !self.curved {
            return curved;
        }
        curved[OMEGA] = self.acceleration_in(region).curved;
        if let (Some(finger), Some(at)) = (&self.scene.finger, self.layout.finger)
            && region.contact == Contact::Free
            && finger.law == FingerLaw::Consistent
        {
            curved[at + 1] = -self.scene.plant.lever_m * curved[OMEGA];
        }
        if let (Some(at), Some(lag)) = (self.layout.motor, self.scene.motor.lag_s) {
            curved[at] = region.motor_share / lag;
        }
        curved
    }
}
