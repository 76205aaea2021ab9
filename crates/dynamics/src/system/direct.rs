//! The equations as the thesis writes them: one right-hand side that switches on the sign of θ̇.
//!
//! Fixed-step methods use it, once per stage or once per step. Nothing here looks for events.

use super::command::Actuator;
use super::region::{Contact, Region, Side};
use super::{OMEGA, System, THETA};
use crate::scene::environment::Demand;
use crate::scene::finger::{Finger, FingerLaw};

impl System {
    /// ż by a law; the input entries of `out` are left alone.
    #[inline]
    pub(crate) fn slope(&self, z: &[f64], law: Law, out: &mut [f64]) {
        let force = self.force(z, law);
        out[THETA] = z[OMEGA];
        out[OMEGA] = (force.lever + force.tip) / self.inertia();
        if let (Some(finger), Some(at)) = (&self.scene.finger, self.layout.finger) {
            self.finger_slope(finger, at, &force, z, out);
        }
        if let (Some(at), Some(lag)) = (self.layout.motor, self.scene.motor.lag_s) {
            out[at] = (force.motor_command - z[at]) / lag;
        }
        if let (Some(at), Some([on, off])) = (self.layout.brake, self.scene.brake.lag_on_off_s) {
            let lag = if force.engaged { on } else { off };
            out[at] = (force.level_command - z[at]) / lag;
        }
    }

    /// Finger free: (11). Finger rigid: both masses as one (consistent), or F_ex passed through
    /// (thesis).
    fn finger_slope(&self, finger: &Finger, at: usize, force: &Direct, z: &[f64], out: &mut [f64]) {
        let lever = self.scene.plant.lever_m;
        let external = z[self.layout.force];
        let drag = if finger.law == FingerLaw::Consistent { finger.mass_kg * lever } else { 0.0 };
        let length = finger.length_m.unwrap_or(f64::INFINITY);
        if z[at].abs() >= length {
            let rigid = (force.lever + external) / (self.inertia() + drag);
            let sign = z[at].signum();
            let press = sign * (external - drag * rigid) - finger.stiffness_n_per_m * length;
            if press > 0.0 && sign * z[at + 1] >= 0.0 {
                out[OMEGA] = rigid;
                out[at] = 0.0;
                out[at + 1] = 0.0;
                return;
            }
        }
        out[at] = z[at + 1];
        out[at + 1] = (external - force.tip) / finger.mass_kg - drag / finger.mass_kg * out[OMEGA];
    }

    /// The forces on the lever by a law.
    #[inline]
    fn force(&self, z: &[f64], law: Law) -> Direct {
        let direction = law.direction;
        // While the let-go rule keeps the brake on, the lever is commanded as one that compresses.
        let (actuator, value) =
            self.commanded_value(z, if law.held { Side::Up } else { side(direction) });
        let motor_command = if actuator == Actuator::Motor { -value } else { 0.0 };
        let level_command = if actuator == Actuator::Brake { value } else { 0.0 };
        let motor = self.layout.motor.map_or(motor_command, |at| z[at]);
        let level = self.layout.brake.map_or(level_command, |at| z[at]);
        let signed = if actuator == Actuator::SignedBrake { -value } else { 0.0 };
        let mut lever = motor + signed - direction * level;
        if let Some(friction) = &self.scene.friction {
            lever -= direction * friction.kinetic_n + friction.viscous_ns_per_rad * z[OMEGA];
        }
        lever += self.terms_n(z);
        let tip = self.tissue_n(z);
        Direct { lever, tip, motor_command, level_command, engaged: actuator == Actuator::Brake }
    }

    /// The actuator that acts on a side, and its clamped command.
    #[inline]
    pub(crate) fn commanded_value(&self, z: &[f64], side: Side) -> (Actuator, f64) {
        let scene = &self.scene;
        let actuator = super::command::actuator(scene.mode, scene.brake.law, side);
        let zone = self.zone(z[THETA], Side::Up);
        if actuator == Actuator::Nobody {
            return (actuator, 0.0);
        }
        let (low, high, offset) = self.limits(actuator);
        let damped = actuator != Actuator::Brake || side == Side::Up;
        let commanded = match scene.environment.zones[usize::from(zone)].demand {
            Demand::Spring { stiffness_n_per_rad: k, damping_ns_per_rad: b, rest_rad } => {
                k * (z[THETA] - rest_rad) + if damped { b * z[OMEGA] } else { 0.0 } - offset
            }
            Demand::Force { force_n } => force_n - offset,
            Demand::Full => high,
            // A brake cannot push: resisting with all it has is the most it can do.
            Demand::FullUp if actuator == Actuator::Brake => high,
            Demand::FullUp => low,
        };
        (actuator, commanded.max(low).min(high))
    }

    /// Whether the brake is kept on after a step: it engages while θ̇ > 0 and lets go once θ̇ ≤ 0
    /// and the user's force is below the threshold.
    #[inline]
    pub(crate) fn keeps_brake(&self, held: bool, z: &[f64]) -> bool {
        let Some(threshold) = self.let_go_n() else { return false };
        z[OMEGA] > 0.0 || (held && z[self.layout.force] >= threshold)
    }

    /// After a step: back inside the stops and the tissue, velocities into them lost.
    #[inline]
    pub(crate) fn constrain(&self, z: &mut [f64]) {
        if let (Some(finger), Some(at)) = (&self.scene.finger, self.layout.finger) {
            let length = finger.length_m.unwrap_or(f64::INFINITY);
            if z[at].abs() >= length && z[at] * z[at + 1] >= 0.0 {
                self.press_finger(z);
            }
        }
        let Some([low, high]) = self.scene.plant.stops_rad else { return };
        if z[THETA] > high || z[THETA] < low {
            let into = if z[THETA] > high { z[OMEGA] > 0.0 } else { z[OMEGA] < 0.0 };
            z[THETA] = z[THETA].clamp(low, high);
            if into {
                self.stop_lever(Contact::Free, z);
            }
        }
    }

    /// The region of a state of which only its numbers are known, for its forces by part.
    pub(crate) fn sampled_region(&self, z: &[f64]) -> Region {
        if z[OMEGA] == 0.0 { self.first_region(z) } else { self.direct_region(z) }
    }

    /// The region a fixed-step state stands in, for its forces by part.
    pub(crate) fn direct_region(&self, z: &[f64]) -> Region {
        let side = side(z[OMEGA]);
        let length = self.scene.finger.and_then(|finger| finger.length_m).unwrap_or(f64::INFINITY);
        let contact = match self.layout.finger {
            Some(at) if z[at] >= length => Contact::Pressed,
            Some(at) if z[at] <= -length => Contact::Stretched,
            _ => Contact::Free,
        };
        let zone = self.zone(z[THETA], Side::Up);
        self.region_in(side, zone, contact, z)
    }
}

/// What the switching right-hand side switches on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Law {
    /// Sign of θ̇, 0 at rest.
    pub(crate) direction: f64,
    /// The let-go rule keeps the brake on, whatever the direction.
    pub(crate) held: bool,
}

/// Sign of a velocity, 0 at rest.
#[inline]
pub(crate) fn direction(omega: f64) -> f64 {
    f64::from(i8::from(omega > 0.0) - i8::from(omega < 0.0))
}

/// The side whose law holds: compressing while θ̇ > 0, holding or releasing otherwise.
#[inline]
fn side(direction: f64) -> Side {
    if direction > 0.0 { Side::Up } else { Side::Down }
}

/// Forces on the lever, N: all but the tip's, the tip's, and the commands of lagging actuators.
struct Direct {
    lever: f64,
    tip: f64,
    motor_command: f64,
    level_command: f64,
    engaged: bool,
}
