//! The exits from a region: functionals that are not below zero while the region holds.

use super::command::Actuator;
use super::region::{Branch, Contact, Region, Side};
use super::row::{Functional, Row};
use super::transition::EventKind;
use super::{OMEGA, System, THETA};
use crate::scene::finger::FingerLaw;

/// The region holds while the value is not below zero; then `kind` happens.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Guard {
    pub(crate) value: Functional,
    pub(crate) kind: EventKind,
}

/// Most guards of a region: four of the lever and actuators, two of a finger.
const MOST_GUARDS: usize = 6;

impl System {
    /// Velocity, the next zone or stop ahead, and the limits of the command.
    pub(crate) fn moving_guards(&self, region: &Region, side: Side) -> Vec<Guard> {
        let sign = side.sign();
        let mut guards = Vec::with_capacity(MOST_GUARDS);
        guards.push(guard(Row::entry(OMEGA, sign), EventKind::Reversal));
        if let Some((angle, kind)) = self.ahead(region, side) {
            let distance = self.constant(sign * angle).minus(Row::entry(THETA, sign));
            guards.push(guard(distance, kind));
        }
        let (command, branch) = self.commanded(region, side);
        let above = command.row.minus(self.constant(command.low));
        let below = self.constant(command.high).minus(command.row);
        match branch {
            _ if command.actuator == Actuator::Nobody => {}
            Branch::Low => guards.push(guard(above.times(-1.0), EventKind::Unsaturated)),
            Branch::High => guards.push(guard(below.times(-1.0), EventKind::Unsaturated)),
            Branch::Linear => {
                if command.low.is_finite() {
                    guards.push(guard(above, EventKind::SaturatedLow));
                }
                if command.high.is_finite() {
                    guards.push(guard(below, EventKind::SaturatedHigh));
                }
            }
        }
        guards
    }

    /// The nearest angle on a side at which something changes.
    fn ahead(&self, region: &Region, side: Side) -> Option<(f64, EventKind)> {
        let zones = &self.scene.environment.zones;
        let here = usize::from(region.zone_up);
        let edge = match side {
            Side::Up => zones.get(here + 1).map(|zone| zone.from_rad),
            Side::Down => (here > 0).then(|| zones[here].from_rad),
        };
        let stop =
            self.scene.plant.stops_rad.map(|[low, high]| if side == Side::Up { high } else { low });
        match (edge, stop) {
            (Some(edge), Some(stop)) if (edge - stop) * side.sign() < 0.0 => {
                Some((edge, EventKind::Zone))
            }
            // A zone's edge on the stop or beyond it is never crossed.
            (_, Some(stop)) => Some((stop, EventKind::Stop)),
            (Some(edge), None) => Some((edge, EventKind::Zone)),
            (None, None) => None,
        }
    }

    /// Net force if the lever at rest were to move to a side: it does so once this points there.
    pub(crate) fn departing_force(&self, region: &Region, side: Side) -> Functional {
        let mut forces = self.lever_forces(region, side);
        if self.layout.brake.is_some() && side == Side::Up && region.motor_holds {
            // A lagging brake lets the motor hold until the lever really moves; without this the
            // two would hand over to each other infinitely often.
            forces.motor = self.lever_forces(region, Side::Down).motor;
        }
        let stiction = self.constant(self.scene.friction.map_or(0.0, |friction| friction.static_n));
        let dry = forces.level.plus(stiction).times(-side.sign());
        Functional { row: self.single_valued::<f64>(&forces).plus(dry), curved: 1.0 }
    }

    /// A lever at rest leaves once the net force for motion points that way: the set-valued force
    /// (brake, friction, and what lies between the motor's and the brake's force) is used up.
    pub(crate) fn rest_guards(&self, region: &Region) -> Vec<Guard> {
        let mut guards = Vec::with_capacity(MOST_GUARDS);
        if region.stop != Some(Side::Up) {
            let up = self.departing_force(region, Side::Up);
            let value = Functional { row: up.row.times(-1.0), curved: -up.curved };
            guards.push(Guard { value, kind: EventKind::DepartUp });
        }
        if region.stop != Some(Side::Down) && !region.held {
            let value = self.departing_force(region, Side::Down);
            guards.push(Guard { value, kind: EventKind::DepartDown });
        }
        if let Some(threshold) = self.let_go_n() {
            let above = Row::entry(self.layout.force, 1.0).minus(self.constant(threshold));
            let sign = if region.held { 1.0 } else { -1.0 };
            guards.push(guard(above.times(sign), EventKind::LetGo));
        }
        guards
    }

    /// The let-go threshold, where it has a meaning: a hybrid drive.
    pub(crate) fn let_go_n(&self) -> Option<f64> {
        self.scene.brake.let_go_n.filter(|_| self.scene.mode.takes_over())
    }

    /// The tissue bottoms at ±L_F0, and lifts off once its rigid stop would have to pull.
    pub(crate) fn finger_guards(&self, region: &Region) -> Vec<Guard> {
        let (Some(finger), Some(at)) = (self.scene.finger, self.layout.finger) else {
            return Vec::new();
        };
        let Some(length) = finger.length_m else { return Vec::new() };
        if let Some(value) = self.stop_press(region) {
            return vec![Guard { value, kind: EventKind::LiftedOff }];
        }
        let limit = self.constant(length);
        [limit.minus(Row::entry(at, 1.0)), limit.plus(Row::entry(at, 1.0))]
            .map(|row| guard(row, EventKind::Bottomed))
            .to_vec()
    }

    /// Force between the finger and its rigid stop where it lies on it: ±(F_ex − M_F L θ̈) − K_F
    /// L_F0.
    pub(crate) fn stop_press(&self, region: &Region) -> Option<Functional> {
        let finger = self.scene.finger?;
        let sign = match region.contact {
            Contact::Free => return None,
            Contact::Pressed => 1.0,
            Contact::Stretched => -1.0,
        };
        let dragged = match finger.law {
            FingerLaw::Consistent => finger.mass_kg * self.scene.plant.lever_m,
            FingerLaw::Thesis => 0.0,
        };
        let acceleration = self.acceleration_in(region);
        let through = Row::entry(self.layout.force, 1.0).minus(acceleration.row.times(dragged));
        let stop = self.constant(finger.stiffness_n_per_m * finger.length_m?);
        let row = through.times(sign).minus(stop);
        Some(Functional { row, curved: -sign * dragged * acceleration.curved })
    }
}

fn guard(row: Row, kind: EventKind) -> Guard {
    Guard { value: row.into(), kind }
}
