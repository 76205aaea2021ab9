//! The affine flow of a region, put together from the forces on the lever and on the finger.

use super::command::{Actuator, Command};
use super::guards::Guard;
use super::region::{Branch, Contact, Motion, Region, Side};
use super::row::{MOST, Row};
use super::{OMEGA, System, THETA};
use crate::scene::finger::{Finger, FingerLaw};

/// A functional of the state with a part in sin θ: `row · z + sine · sin θ`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Functional {
    pub(crate) row: Row,
    pub(crate) sine: f64,
}

impl Functional {
    pub(crate) fn of(&self, z: &[f64]) -> f64 {
        let linear = self.row.of(z);
        if self.sine == 0.0 { linear } else { linear + self.sine * libm::sin(z[THETA]) }
    }
}

impl From<Row> for Functional {
    fn from(row: Row) -> Self {
        Self { row, sine: 0.0 }
    }
}

/// ż = A z, and in the rows of θ̇ and ẋ2 a part in sin θ; the region's guards.
#[derive(Debug, Clone)]
pub(crate) struct Flow {
    pub(crate) rows: [Row; MOST],
    pub(crate) sine: [f64; MOST],
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
    /// The moved spring.
    pub(crate) pull: Row,
}

impl LeverForces {
    /// All but the set-valued ones.
    pub(crate) fn single_valued(&self) -> Row {
        self.tip.plus(self.motor).plus(self.signed_brake).plus(self.viscous).plus(self.pull)
    }
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
        let to = |actuator, factor| {
            if command.actuator == actuator { value.times(factor) } else { Row::ZERO }
        };
        let lagged = |at: Option<usize>, row: Row| at.map_or(row, |i| Row::entry(i, 1.0));
        let viscous = self.scene.friction.map_or(0.0, |friction| friction.viscous_ns_per_rad);
        LeverForces {
            tip: self.tip(region.contact),
            motor: lagged(self.layout.motor, to(Actuator::Motor, -1.0)),
            signed_brake: to(Actuator::SignedBrake, -1.0),
            level: lagged(self.layout.brake, to(Actuator::Brake, 1.0)),
            viscous: Row::entry(OMEGA, -viscous),
            pull: self.pull_force(),
        }
    }

    /// Force on the lever's end: the user's, or the tissue's K_F x2 + B_F ẋ2 (9).
    fn tip(&self, contact: Contact) -> Row {
        match (&self.scene.finger, self.layout.finger) {
            (Some(finger), Some(at)) if contact == Contact::Free => {
                Row::entry(at, finger.stiffness_n_per_m).plus(Row::entry(at + 1, finger.damping_ns_per_m))
            }
            _ => Row::entry(self.layout.force, 1.0),
        }
    }

    fn pull_force(&self) -> Row {
        match (&self.scene.pull, self.layout.pull) {
            (Some(pull), Some(at)) => {
                let k = pull.stiffness_n_per_rad;
                Row::entry(at, k).plus(Row::entry(THETA, -k))
            }
            _ => Row::ZERO,
        }
    }

    /// Gravity's force at the lever's end per sin θ, N.
    pub(crate) fn gravity_n(&self) -> f64 {
        self.scene.gravity.map_or(0.0, |gravity| gravity.torque_nm() / self.scene.plant.lever_m)
    }

    /// Inertia of the lever, with the finger's mass once its tissue is rigid, kg m.
    pub(crate) fn moving_inertia(&self, contact: Contact) -> f64 {
        let finger = self.scene.finger.filter(|f| f.law == FingerLaw::Consistent && contact != Contact::Free);
        self.inertia() + finger.map_or(0.0, |f| f.mass_kg * self.scene.plant.lever_m)
    }

    /// θ̈ of a region in motion (10).
    fn acceleration(&self, region: &Region, side: Side) -> Functional {
        let forces = self.lever_forces(region, side);
        let kinetic = self.constant(self.scene.friction.map_or(0.0, |friction| friction.kinetic_n));
        let dry = forces.level.plus(kinetic).times(-side.sign());
        let inertia = self.moving_inertia(region.contact);
        let row = forces.single_valued().plus(dry).times(1.0 / inertia);
        Functional { row, sine: self.gravity_n() / inertia }
    }

    /// The flow of a region and the ways out of it.
    pub(crate) fn flow(&self, region: &Region) -> Flow {
        let mut rows = [Row::ZERO; MOST];
        let mut sine = [0.0; MOST];
        let moving = match region.motion {
            Motion::Forward => Some(Side::Up),
            Motion::Backward => Some(Side::Down),
            Motion::Rest => None,
        };
        let acceleration = moving.map_or(Row::ZERO.into(), |side| self.acceleration(region, side));
        if moving.is_some() {
            rows[THETA] = Row::entry(OMEGA, 1.0);
            rows[OMEGA] = acceleration.row;
            sine[OMEGA] = acceleration.sine;
        }
        if let (Some(finger), Some(at)) = (&self.scene.finger, self.layout.finger) {
            self.finger_rows(finger, at, region.contact, acceleration, &mut rows, &mut sine);
        }
        self.lag_rows(region, &mut rows, &mut sine);
        self.input_rows(&mut rows);
        let mut guards = match moving {
            Some(side) => self.moving_guards(region, side),
            None => self.rest_guards(region),
        };
        guards.extend(self.finger_guards(region, acceleration));
        Flow { rows, sine, guards }
    }

    /// M_F ẍ2 = F_F + F_ex (11), and in the consistent law − M_F L θ̈.
    fn finger_rows(
        &self,
        finger: &Finger,
        at: usize,
        contact: Contact,
        acceleration: Functional,
        rows: &mut [Row; MOST],
        sine: &mut [f64; MOST],
    ) {
        if contact != Contact::Free {
            return;
        }
        rows[at] = Row::entry(at + 1, 1.0);
        let net = Row::entry(self.layout.force, 1.0).minus(self.tip(contact));
        rows[at + 1] = net.times(1.0 / finger.mass_kg);
        if finger.law == FingerLaw::Consistent {
            let lever = self.scene.plant.lever_m;
            rows[at + 1] = rows[at + 1].minus(acceleration.row.times(lever));
            sine[at + 1] = -lever * acceleration.sine;
        }
    }

    /// τ ẋ = command − x for the motor's force and the brake's level. A lever at rest is commanded as one
    /// that holds or releases, unless the let-go rule keeps the brake on; where the brake does part of the
    /// holding by fast switching, a lagging motor is off for its share of the time.
    fn lag_rows(&self, region: &Region, rows: &mut [Row; MOST], sine: &mut [f64; MOST]) {
        let up = region.motion == Motion::Forward || (region.motion == Motion::Rest && region.held);
        let (command, branch) = self.commanded(region, if up { Side::Up } else { Side::Down });
        let value = command.on(branch, self);
        if let (Some(at), Some(lag)) = (self.layout.motor, self.scene.motor.lag_s) {
            let target = if command.actuator == Actuator::Motor { value.times(-1.0) } else { Row::ZERO };
            let brake_holds = self.departing_force(region, Side::Down);
            let shared = target.plus(brake_holds.row.times(region.motor_share));
            rows[at] = shared.minus(Row::entry(at, 1.0)).times(1.0 / lag);
            sine[at] = region.motor_share * brake_holds.sine / lag;
        }
        if let (Some(at), Some([on, off])) = (self.layout.brake, self.scene.brake.lag_on_off_s) {
            let engaged = command.actuator == Actuator::Brake;
            let (target, lag) = if engaged { (value, on) } else { (Row::ZERO, off) };
            rows[at] = target.minus(Row::entry(at, 1.0)).times(1.0 / lag);
        }
    }

    /// x¨ = −ω² (x − mean) for each input.
    fn input_rows(&self, rows: &mut [Row; MOST]) {
        let mut write = |at: usize, (omega, mean): (f64, f64)| {
            rows[at] = Row::entry(at + 1, 1.0);
            let square = omega * omega;
            rows[at + 1] = Row::entry(at, -square).plus(self.constant(square * mean));
        };
        write(self.layout.force, self.scene.input.swing());
        if let (Some(at), Some(pull)) = (self.layout.pull, &self.scene.pull) {
            write(at, pull.displacement.swing());
        }
    }

    /// θ̈ in a region; zero at rest.
    pub(crate) fn acceleration_in(&self, region: &Region) -> Functional {
        match region.motion {
            Motion::Forward => self.acceleration(region, Side::Up),
            Motion::Backward => self.acceleration(region, Side::Down),
            Motion::Rest => Row::ZERO.into(),
        }
    }
}
