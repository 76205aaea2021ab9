//! Do motor and brake respond, and in the right direction?

use super::finding::Finding;
use crate::timing::Pace;
use crate::trial::Output;
use crate::{Clock, Device, Guard, Trip};
use std::sync::atomic::{AtomicBool, Ordering};
use zwidth_study::{Calibration, Voltages};

/// The motor is given this voltage, V: 0.52 N on the prototype, above any friction assumed for it.
const MOTOR_V: f64 = 2.0;

/// …for this long, s: the lever is then some degrees from its stop.
const PULSE_S: f64 = 0.04;

/// The brake is given this long to take hold, or the lever to come to rest, s.
const SETTLE_S: f64 = 0.3;

/// A lever that moves has moved by this much, rad (0.6°).
const MOVED_RAD: f64 = 0.01;

/// A brake that holds leaves no more than this share of the way.
const HELD: f64 = 0.2;

/// How far the lever went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// By a push of the motor towards +θ, rad.
    pub free_rad: f64,
    /// By the same push with the brake on, rad.
    pub braked_rad: f64,
}

/// The findings of both pushes.
pub fn actuators(travel: Travel) -> Vec<Finding> {
    let motor = "way of the lever by a push of the motor towards the upper stop; if too short, check supply and cables; if \
                 below 0, the motor's leads are swapped";
    let brake = "share of that way left with the brake on; if much is, check the brake's supply and its air gap";
    // Not divided by next to nothing where the lever did not move.
    let left = travel.braked_rad.abs() / travel.free_rad.abs().max(MOVED_RAD);
    let moved = travel.free_rad >= MOVED_RAD;
    vec![
        Finding::new("motor responds", travel.free_rad, "rad", moved, motor),
        Finding::new("brake responds", left, "1", moved && left <= HELD, brake),
    ]
}

/// Homes, and pushes with the motor, without and with the brake. The lever must have been moved by
/// hand before, or the motor stays off. A stop ends it at 0 V, and nothing is found.
pub(super) fn drive(
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    guard: &mut Guard,
    calibration: &Calibration,
    rate_hz: f64,
    stop: &AtomicBool,
) -> Result<Vec<Finding>, Trip> {
    guard.home(device, clock.now_s())?;
    let brake_v = device.capabilities().brake_max_v;
    // Holds voltages for a while, with all of safety in place; where the lever is in the end, rad.
    // Stopped, nothing is held and it is nowhere.
    let mut hold = |voltages: Voltages, for_s: f64| -> Result<Option<f64>, Trip> {
        guard.arm_for_check(voltages, calibration)?;
        let start_s = clock.now_s();
        let mut output = Output::new(device, guard, start_s);
        let mut pace = Pace::new(start_s, 1.0 / rate_hz);
        loop {
            let tick = pace.wait(clock);
            if stop.load(Ordering::Relaxed) {
                output.off(clock.now_s())?;
                return Ok(None);
            }
            let (_, seen) = output.look(&tick)?;
            if tick.now_s >= start_s + for_s {
                return Ok(Some(seen.theta_rad));
            }
            output.command(clock.now_s(), voltages)?;
        }
    };
    let Some(start_rad) = hold(Voltages::OFF, SETTLE_S)? else { return Ok(Vec::new()) };
    hold(Voltages { motor_v: MOTOR_V, brake_v: 0.0 }, PULSE_S)?;
    let Some(pushed_rad) = hold(Voltages::OFF, SETTLE_S)? else { return Ok(Vec::new()) };
    // The brake first: it takes longer to take hold than the push lasts.
    hold(Voltages { motor_v: 0.0, brake_v }, SETTLE_S)?;
    let Some(braked_rad) = hold(Voltages { motor_v: MOTOR_V, brake_v }, PULSE_S)? else {
        return Ok(Vec::new());
    };
    Ok(actuators(Travel { free_rad: pushed_rad - start_rad, braked_rad: braked_rad - pushed_rad }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ok(free_rad: f64, braked_rad: f64) -> Vec<bool> {
        actuators(Travel { free_rad, braked_rad }).iter().map(|f| f.check.ok).collect()
    }

    #[test]
    fn a_motor_that_moves_and_a_brake_that_holds_are_sound() {
        assert_eq!(ok(0.1, 0.001), [true, true]);
    }

    #[test]
    fn a_motor_that_does_not_move_or_moves_the_wrong_way_is_found_and_says_nothing_of_the_brake() {
        assert_eq!(ok(0.001, 0.0), [false, false]);
        assert_eq!(ok(-0.1, 0.0), [false, false]);
    }

    #[test]
    fn a_brake_that_slips_is_found() {
        assert_eq!(ok(0.1, 0.05), [true, false]);
    }
}
