//! From region to region: what an event does to the state, and which region holds then.

use super::region::{Branch, Contact, Motion, Region, Side};
use super::{OMEGA, RestRule, System, THETA};
use crate::scene::finger::FingerLaw;
use zwidth_study::worded;

worded! {
    /// Why a region is left.
    EventKind {
        /// θ̇ reaches zero.
        Reversal = "reversal",
        /// The lever enters the next zone of the environment.
        Zone = "next zone",
        /// The lever hits a stop.
        Stop = "stop",
        /// The actuator in charge reaches its lower limit.
        SaturatedLow = "lower limit",
        /// The actuator in charge reaches its upper limit.
        SaturatedHigh = "upper limit",
        /// The actuator in charge leaves its limit.
        Unsaturated = "off the limit",
        /// A lever at rest starts forward.
        DepartUp = "departs forward",
        /// A lever at rest starts backward.
        DepartDown = "departs backward",
        /// The user's force crosses the brake's let-go threshold.
        LetGo = "brake's let-go threshold",
        /// The finger's tissue is fully pressed.
        Bottomed = "tissue fully pressed",
        /// The finger's tissue springs back.
        LiftedOff = "tissue springs back",
        /// An input jumps.
        Input = "input jumps",
    }
}

impl System {
    /// How the lever moves at t = 0.
    pub fn first_motion(&self) -> Motion {
        self.first_region(&self.start().0).motion
    }

    /// The region that holds at the start.
    pub(crate) fn first_region(&self, z: &[f64]) -> Region {
        self.settle(z, Contact::Free, None)
    }

    /// Carries an event out: snaps the state to where the event happened, applies impacts, and
    /// finds the next region.
    pub(crate) fn transit(&self, region: &Region, kind: EventKind, z: &mut [f64]) -> Region {
        let moving = if region.motion == Motion::Forward { Side::Up } else { Side::Down };
        match kind {
            EventKind::Reversal => {
                z[OMEGA] = 0.0;
                self.settle(z, region.contact, None)
            }
            EventKind::Zone => self.enter_zone(region, moving, z),
            EventKind::Stop => {
                // The lever stops dead; a finger on soft tissue keeps its own velocity.
                if let Some([low, high]) = self.scene.plant.stops_rad {
                    z[THETA] = if moving == Side::Up { high } else { low };
                }
                let contact = self.stop_lever(region.contact, z);
                self.settle(z, contact, None)
            }
            EventKind::SaturatedLow => on_branch(region, moving, Branch::Low),
            EventKind::SaturatedHigh => on_branch(region, moving, Branch::High),
            EventKind::Unsaturated => on_branch(region, moving, Branch::Linear),
            EventKind::DepartUp => self.moving_region(Side::Up, region.contact, z),
            EventKind::DepartDown => self.moving_region(Side::Down, region.contact, z),
            EventKind::LetGo => self.settle(z, region.contact, Some(!region.held)),
            EventKind::Bottomed => {
                let contact = self.press_finger(z);
                // A stop that the lever leans on takes what the finger would push into it.
                if region.stop.is_some_and(|side| z[OMEGA] * side.sign() > 0.0) {
                    z[OMEGA] = 0.0;
                }
                self.settle(z, contact, None)
            }
            // The tissue springs back; the lever goes on as it did.
            EventKind::LiftedOff => match region.motion {
                Motion::Rest => self.region_with(z, Contact::Free, Some(region.held)),
                _ => Region { contact: Contact::Free, ..*region },
            },
            EventKind::Input => self.settle(z, region.contact, None),
        }
    }

    /// The region that holds in a state. A rigid finger that would have to pull lifts off.
    pub(crate) fn settle(&self, z: &[f64], contact: Contact, held: Option<bool>) -> Region {
        let region = self.region_with(z, contact, held);
        let pulls = self.stop_press(&region).is_some_and(|press| self.value(&press, z) < 0.0);
        if pulls { self.region_with(z, Contact::Free, held) } else { region }
    }

    fn region_with(&self, z: &[f64], contact: Contact, held: Option<bool>) -> Region {
        if z[OMEGA] > 0.0 {
            return self.moving_region(Side::Up, contact, z);
        }
        if z[OMEGA] < 0.0 {
            return self.moving_region(Side::Down, contact, z);
        }
        let rest = self.rest_region(contact, held, z);
        let departs_down = rest.stop != Some(Side::Down)
            && !rest.held
            && self.departing_n(&rest, Side::Down, z) < 0.0;
        if departs_down {
            self.moving_region(Side::Down, contact, z)
        } else if rest.stop != Some(Side::Up) && self.departing_n(&rest, Side::Up, z) > 0.0 {
            self.moving_region(Side::Up, contact, z)
        } else {
            rest
        }
    }

    /// Net force on a lever at rest if it were to move to a side, N.
    fn departing_n(&self, rest: &Region, side: Side, z: &[f64]) -> f64 {
        self.value(&self.departing_force(rest, side), z)
    }

    /// The region of motion to a side.
    pub(crate) fn moving_region(&self, side: Side, contact: Contact, z: &[f64]) -> Region {
        self.region_in(side, self.zone(z[THETA], side), contact, z)
    }

    /// The same in a zone.
    pub(super) fn region_in(&self, side: Side, zone: u16, contact: Contact, z: &[f64]) -> Region {
        let motion = if side == Side::Up { Motion::Forward } else { Motion::Backward };
        let region = Region {
            motion,
            zone_up: zone,
            zone_down: zone,
            branch_up: Branch::Linear,
            branch_down: Branch::Linear,
            contact,
            stop: None,
            held: false,
            motor_holds: false,
            motor_share: 0.0,
        };
        on_branch(&region, side, self.command(side, zone).branch(z))
    }

    /// The region of rest at an angle; its forces on both sides decide when it is left.
    pub(crate) fn rest_region(&self, contact: Contact, held: Option<bool>, z: &[f64]) -> Region {
        let theta = z[THETA];
        let zone_up = self.zone(theta, Side::Up);
        let zone_down = self.zone(theta, Side::Down);
        let stop = match self.scene.plant.stops_rad {
            Some([_, high]) if theta >= high => Some(Side::Up),
            Some([low, _]) if theta <= low => Some(Side::Down),
            _ => None,
        };
        let above = self.let_go_n().is_some_and(|threshold| z[self.layout.force] >= threshold);
        let rest = Region {
            motion: Motion::Rest,
            zone_up,
            zone_down,
            branch_up: self.command(Side::Up, zone_up).branch(z),
            branch_down: self.command(Side::Down, zone_down).branch(z),
            contact,
            stop,
            held: held.unwrap_or(above),
            motor_holds: false,
            motor_share: 0.0,
        };
        let engaged = rest.held || self.rest_rule == RestRule::Compress;
        if !self.scene.mode.takes_over() || engaged {
            return rest;
        }
        let (command, branch) = self.commanded(&rest, Side::Down);
        let command_n = command.on(branch, self).dot(z);
        // Known before the share: it decides which forces the cone is made of.
        let rest = Region { motor_holds: command_n > 0.0, ..rest };
        if self.layout.motor.is_none() || self.layout.brake.is_some() {
            return rest;
        }
        // The motor's share: its command over the width of the cone of forces that hold the lever.
        let cone = self.departing_n(&rest, Side::Down, z) - self.departing_n(&rest, Side::Up, z);
        let motor_share = if cone > 0.0 && command_n > 0.0 { command_n / cone } else { 0.0 };
        Region { motor_share, ..rest }
    }

    /// Across an edge of the environment. Where the forces on both sides push back to the edge,
    /// ever smaller bounces follow; once they are too small to see the lever rests there.
    fn enter_zone(&self, region: &Region, side: Side, z: &mut [f64]) -> Region {
        /// A bounce of less than this is rest, rad: a millionth of a step of the device's angle
        /// sensor.
        const NO_BOUNCE_RAD: f64 = 2e-10;
        let zones = &self.scene.environment.zones;
        let edge = usize::from(region.zone_up) + usize::from(side == Side::Up);
        z[THETA] = zones[edge].from_rad;
        let rest = self.rest_region(region.contact, None, z);
        let up = self.departing_n(&rest, Side::Up, z);
        let down = self.departing_n(&rest, Side::Down, z);
        // ½ M_O L θ̇² = F × bounce gives the bounce's length; the 2 stands on the other side.
        let bounce = z[OMEGA] * z[OMEGA] * self.inertia();
        if up < 0.0 && down > 0.0 && bounce < 2.0 * NO_BOUNCE_RAD * down.min(-up) {
            z[OMEGA] = 0.0;
            return rest;
        }
        self.moving_region(side, region.contact, z)
    }

    /// θ̇ becomes 0; ẋ2, which is measured from the lever, changes by as much where the finger is
    /// free to.
    pub(crate) fn stop_lever(&self, contact: Contact, z: &mut [f64]) -> Contact {
        /// A finger this close to its rigid stop, as a share of L_F0, and moving into it bottoms
        /// together with the lever: else the two would hit their stops in turn for ever.
        const NEAR: f64 = 1e-9;
        let velocity = self.scene.plant.lever_m * z[OMEGA];
        z[OMEGA] = 0.0;
        let (Some(finger), Some(at)) = (self.scene.finger, self.layout.finger) else {
            return contact;
        };
        if finger.law != FingerLaw::Consistent {
            return contact;
        }
        let pressed_on = match contact {
            Contact::Free => finger
                .length_m
                .is_some_and(|length| z[at] * velocity.signum() >= length * (1.0 - NEAR)),
            Contact::Pressed => velocity > 0.0,
            Contact::Stretched => velocity < 0.0,
        };
        if pressed_on {
            let contact = self.press_finger(z);
            // The stop takes the finger's momentum too.
            z[OMEGA] = 0.0;
            return contact;
        }
        z[at + 1] += velocity;
        Contact::Free
    }

    /// Sets the finger on its rigid stop, inelastically: its momentum is shared with the lever
    /// (consistent law), or lost (thesis).
    pub(crate) fn press_finger(&self, z: &mut [f64]) -> Contact {
        let (Some(finger), Some(at)) = (self.scene.finger, self.layout.finger) else {
            return Contact::Free;
        };
        let contact = if z[at] > 0.0 { Contact::Pressed } else { Contact::Stretched };
        let sign = if contact == Contact::Pressed { 1.0 } else { -1.0 };
        z[at] = sign * finger.length_m.unwrap_or(z[at].abs());
        if finger.law == FingerLaw::Consistent {
            let share = finger.mass_kg / (finger.mass_kg + self.scene.plant.mass_kg);
            z[OMEGA] += share * z[at + 1] / self.scene.plant.lever_m;
        }
        z[at + 1] = 0.0;
        contact
    }
}

/// The region with the command of a side on another line.
fn on_branch(region: &Region, side: Side, branch: Branch) -> Region {
    match side {
        Side::Up => Region { branch_up: branch, ..*region },
        Side::Down => Region { branch_down: branch, ..*region },
    }
}

#[cfg(test)]
mod tests {
    use crate::{DriveMode, Input, Motion, System, table3};

    #[test]
    fn a_lever_first_moves_as_it_was_set_going_or_as_it_is_pushed() {
        let first = |push_n: f64, theta_dot_rad_s: f64| {
            let mut scene = table3::scene(DriveMode::Hybrid, Input::constant(push_n));
            scene.start.theta_rad = 0.0;
            scene.start.theta_dot_rad_s = theta_dot_rad_s;
            System::new(scene).unwrap().first_motion()
        };
        // The spring asks for π N: the brake holds so much, the motor pushes with it.
        assert_eq!(first(3.2, 0.0), Motion::Forward);
        assert_eq!(first(3.1, 0.0), Motion::Backward);
        assert_eq!(first(3.2, -0.1), Motion::Backward);
        assert_eq!(first(3.1, 0.1), Motion::Forward);
        let mut scene = table3::scene(DriveMode::Hybrid, Input::constant(3.2));
        scene.start.theta_rad = 0.1; // the spring asks for more than the motor has
        scene.motor.max_n = 3.0;
        assert_eq!(System::new(scene).unwrap().first_motion(), Motion::Rest);
    }
}
