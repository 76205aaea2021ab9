//! The lever's angle from a sensor that turns with the shaft and forgets its turns.
//!
//! One turn of the shaft is 52.8° of the prototype's lever (thesis §4.2), so a count alone gives
//! the angle only up to multiples of 52.8°. [`Homed`] fixes the turn at the lower stop; [`Unwrap`]
//! counts turns from there.

use crate::error::unable;
use crate::{Angle, Capabilities, DeviceError, Reading};
use std::f64::consts::TAU;

/// A step further than this from the predicted one is refused, turns: half of the half turn at
/// which a step and its alias are equally short.
const REFUSED_TURN: f64 = 0.25;

/// A speed is taken over at least this long, s. Two readings that lie microseconds apart, as at the
/// change from one loop to the next, would make one count of the sensor tens of turns a second.
const SPEED_OVER_S: f64 = 0.5e-3;

/// How far from its stop the lever may be when it is homed by a sensor that gives angles, rad: 2°,
/// the same as it may later lie outside the work space.
const HOME_RAD: f64 = 2.0 * TAU / 360.0;

/// Why an angle is not to be believed any more.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum AngleFault {
    /// The step is too far from the predicted one.
    #[error(
        "the angle moved {step_turns:.3} turns of the shaft where {predicted_turns:.3} were expected, more than {REFUSED_TURN} \
         turns off: the turns can no longer be counted"
    )]
    Jump {
        /// The step as the shortest one, turns of the shaft.
        step_turns: f64,
        /// The step at the speed of the one before, turns of the shaft.
        predicted_turns: f64,
    },
    /// A code the sensor does not have.
    #[error("the angle sensor gave {raw}, and its largest code is {last}")]
    Code {
        /// The code.
        raw: u16,
        /// The last code there is.
        last: i64,
    },
    /// The sensor gave an angle where it gave counts at homing, or the other way round.
    #[error("the angle sensor switched between counts and angles")]
    Kind,
}

/// Counts turns: a count that wraps becomes one that does not.
///
/// The step between two readings is taken as the one below half a turn, and refused when it lies
/// more than a quarter of a turn from the predicted step (at the speed of the last half millisecond
/// or more). So every motion is unwrapped exactly whose steps stay below half a turn and differ by
/// less than a quarter from one to the next; on the prototype half a turn is 26.4° of lever,
/// 3,180°/s at 8.3 ms. A faster step may alias, and is refused unless its alias happens to lie near
/// the predicted step, which no sensor of this kind can tell.
#[derive(Debug, Clone, PartialEq)]
pub struct Unwrap {
    per_turn: i64,
    t_s: f64,
    raw: i64,
    total: i64,
    /// Counts a second.
    speed: f64,
    /// When that speed was taken, s, and the total then.
    speed_at: (f64, i64),
}

impl Unwrap {
    /// Starts at rest at a count, which is also the total there.
    ///
    /// # Errors
    /// A code the sensor does not have.
    pub(crate) fn start(counts_per_turn: u32, t_s: f64, raw: u16) -> Result<Self, AngleFault> {
        let per_turn = i64::from(counts_per_turn);
        let raw = code(raw, per_turn)?;
        Ok(Self { per_turn, t_s, raw, total: raw, speed: 0.0, speed_at: (t_s, raw) })
    }

    /// Follows to the count of a later reading; the count without wraps.
    ///
    /// # Errors
    /// A step too far from the predicted one, or a code the sensor does not have. The state stays
    /// as it was.
    pub(crate) fn follow(&mut self, t_s: f64, raw: u16) -> Result<i64, AngleFault> {
        let raw = code(raw, self.per_turn)?;
        let step = shortest(raw - self.raw, self.per_turn);
        let elapsed_s = t_s - self.t_s;
        let per_turn = self.per_turn as f64;
        let step_turns = step as f64 / per_turn;
        let predicted_turns = self.speed * elapsed_s / per_turn;
        // Before anything is stored: a refused reading must leave the count as it was.
        if (step_turns - predicted_turns).abs() > REFUSED_TURN {
            return Err(AngleFault::Jump { step_turns, predicted_turns });
        }
        (self.t_s, self.raw, self.total) = (t_s, raw, self.total + step);
        let over_s = t_s - self.speed_at.0;
        if over_s >= SPEED_OVER_S {
            self.speed = (self.total - self.speed_at.1) as f64 / over_s;
            self.speed_at = (t_s, self.total);
        }
        Ok(self.total)
    }
}

fn code(raw: u16, per_turn: i64) -> Result<i64, AngleFault> {
    let code = i64::from(raw);
    if code < per_turn { Ok(code) } else { Err(AngleFault::Code { raw, last: per_turn - 1 }) }
}

/// The same step plus whole turns, in [−½, ½) turn.
pub(crate) fn shortest(step: i64, per_turn: i64) -> i64 {
    let half = per_turn / 2;
    (step + half).rem_euclid(per_turn) - half
}

/// How much of the half turn that may lie between two readings was never used: 1 for a lever at
/// rest, 0 at the limit beyond which turns are lost. From the largest step, counts.
pub(crate) fn unwrap_margin(largest_step: i64, counts_per_turn: u32) -> f64 {
    1.0 - largest_step.abs() as f64 / (0.5 * f64::from(counts_per_turn))
}

/// A sensor whose turn is known: readings become angles of the lever.
#[derive(Debug, Clone, PartialEq)]
pub struct Homed {
    stop_rad: f64,
    sensor: Sensor,
}

#[derive(Debug, Clone, PartialEq)]
enum Sensor {
    /// Counts on the shaft.
    Shaft { unwrap: Unwrap, at_stop: i64, rad_per_count: f64 },
    /// Angles of the lever.
    Lever,
}

impl Homed {
    /// From the reading at the lower stop, which lies at `stop_rad`.
    ///
    /// # Errors
    /// A reading that does not fit what the device says of its sensor, or an angle that is not at
    /// the stop.
    pub(crate) fn at_stop(
        capabilities: &Capabilities,
        stop_rad: f64,
        t_s: f64,
        reading: &Reading,
    ) -> Result<Self, DeviceError> {
        let device = &capabilities.name;
        let sensor = match (reading.angle, capabilities.counts_per_turn) {
            (Angle::Counts(raw), Some(counts)) => Sensor::Shaft {
                unwrap: Unwrap::start(counts, t_s, raw).map_err(|fault| {
                    let remedy = "check the angle sensor and its cable";
                    unable(device, &fault.to_string(), remedy)
                })?,
                at_stop: i64::from(raw),
                rad_per_count: rad_per_count(counts, capabilities.shaft_per_lever),
            },
            (Angle::Lever(theta_rad), None) if (theta_rad - stop_rad).abs() <= HOME_RAD => {
                Sensor::Lever
            }
            (Angle::Lever(theta_rad), None) => {
                let angle = theta_rad.to_degrees();
                let stop = stop_rad.to_degrees();
                let what =
                    format!("the lever is at {angle:.1} degrees, its lower stop at {stop:.1}");
                let remedy = "hold it against the stop and home again";
                return Err(unable(device, &what, remedy));
            }
            _ => {
                let what = AngleFault::Kind.to_string();
                let remedy = "correct what the board says of its angle sensor (docs/rig.md)";
                return Err(unable(device, &what, remedy));
            }
        };
        Ok(Self { stop_rad, sensor })
    }

    /// The lever's angle, rad.
    ///
    /// # Errors
    /// An angle that is not to be believed; home again.
    pub(crate) fn follow(&mut self, t_s: f64, angle: Angle) -> Result<f64, AngleFault> {
        match (&mut self.sensor, angle) {
            (Sensor::Shaft { unwrap, at_stop, rad_per_count }, Angle::Counts(raw)) => {
                let counts = unwrap.follow(t_s, raw)? - *at_stop;
                Ok(self.stop_rad + counts as f64 * *rad_per_count)
            }
            (Sensor::Lever, Angle::Lever(theta_rad)) => Ok(theta_rad),
            _ => Err(AngleFault::Kind),
        }
    }
}

/// What one count of a sensor on the shaft is at the lever, rad.
pub(crate) fn rad_per_count(counts_per_turn: u32, shaft_per_lever: f64) -> f64 {
    TAU / (f64::from(counts_per_turn) * shaft_per_lever)
}

#[cfg(test)]
mod tests;
