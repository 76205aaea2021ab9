//! The forces by part, on the lever's end, from a state and its region.

use super::System;
use super::flow::LeverForces;
use super::region::{Contact, Motion, Region, Side};
use crate::trajectory::Forces;

impl System {
    /// Every part of the force on the lever, N; above 0 pushes to +θ.
    pub(crate) fn forces(&self, region: &Region, z: &[f64]) -> Forces {
        let side = match region.motion {
            Motion::Forward => Side::Up,
            Motion::Backward | Motion::Rest => Side::Down,
        };
        let rows = self.lever_forces(region, side);
        let mut forces = Forces {
            external_n: z[self.layout.force],
            tip_n: rows.tip.dot(z),
            tissue_n: self.tissue_n(z),
            motor_n: rows.motor.dot(z),
            brake_n: rows.signed_brake.dot(z) - side.sign() * rows.level.dot(z),
            friction_n: rows.viscous.dot(z),
            terms_n: self.terms_n(z),
            stop_n: 0.0,
        };
        match region.motion {
            Motion::Rest => self.share_at_rest(region, &rows, z, &mut forces),
            Motion::Forward | Motion::Backward => {
                forces.friction_n -=
                    side.sign() * self.scene.friction.map_or(0.0, |friction| friction.kinetic_n);
                if region.contact != Contact::Free {
                    // What the rigid finger's own inertia takes of the user's force.
                    let dragged = self.moving_inertia::<f64>(region.contact) - self.inertia();
                    forces.tip_n -= dragged * self.value(&self.acceleration_in(region), z);
                }
            }
        }
        forces
    }

    /// K_F x2 + B_F ẋ2, N; without a finger the user's force itself.
    #[inline]
    pub(super) fn tissue_n(&self, z: &[f64]) -> f64 {
        match (&self.scene.finger, self.layout.finger) {
            (Some(finger), Some(at)) => {
                finger.stiffness_n_per_m * z[at] + finger.damping_ns_per_m * z[at + 1]
            }
            _ => z[self.layout.force],
        }
    }

    /// At rest the set-valued forces give what is needed: the actuators between the two forces they
    /// would have on either side of rest (so they share as fast switching would), then
    /// friction, then the stop.
    fn share_at_rest(&self, region: &Region, down: &LeverForces, z: &[f64], forces: &mut Forces) {
        let up = self.lever_forces(region, Side::Up);
        let above = [up.motor.dot(z), up.signed_brake.dot(z) - up.level.dot(z)];
        let below = match region.held {
            true => [above[0], up.level.dot(z)],
            false => [down.motor.dot(z), down.signed_brake.dot(z) + down.level.dot(z)],
        };
        let needed = -(forces.tip_n + forces.terms_n);
        let a = above[0] + above[1];
        let b = below[0] + below[1];
        let actuated = needed.max(a.min(b)).min(a.max(b));
        // Where both sides have the same force there is nothing to share.
        let width = a - b;
        let share = if width.abs() > 0.0 { (actuated - b) / width } else { 0.0 };
        forces.motor_n = share * above[0] + (1.0 - share) * below[0];
        forces.brake_n = share * above[1] + (1.0 - share) * below[1];
        let stiction = self.scene.friction.map_or(0.0, |friction| friction.static_n);
        forces.friction_n = (needed - actuated).clamp(-stiction, stiction);
        forces.stop_n = needed - actuated - forces.friction_n;
        if region.stop.is_none() {
            // Only rounding is left of what the lever's own set-valued forces do not hold.
            forces.friction_n += forces.stop_n * f64::from(u8::from(stiction > 0.0));
            forces.stop_n = 0.0;
        }
    }
}
