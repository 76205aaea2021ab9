//! The guard between any control law and the device: no voltage reaches an actuator unless the
//! guard lets it through.
//!
//! The guard knows where the lever is ([`Guard::home`]), which voltages the trial's mode may use
//! ([`Guard::arm`]), judges every reading ([`Guard::see`]) and clamps every command
//! ([`Guard::permit`]). Whatever it finds wrong is a [`Trip`], after which the loop goes to 0 V.

mod refuse;
mod trip;

pub use refuse::{FORCE_RATE_HZ, MOTOR_FORCE_N};
pub use trip::{Refusal, Trip};

use refuse::{Request, exceeds};

use crate::angle::rad_per_count;
use crate::error::positive;
use crate::{Capabilities, Device, DeviceError, Homed, Reading};
use zwidth_study::{Calibration, Flags, Mode, Study, Voltages};

/// A sensor or a loop may be away for this long, s: the watchdog of the board waits as long.
pub const AWAY_S: f64 = 0.05;

/// …or for so many nominal periods, if that is longer.
const AWAY_PERIODS: f64 = 3.0;

/// Lost time is forgiven at this rate, s per s: more than one deadline in twenty, missed for long,
/// trips.
const FORGIVEN: f64 = 0.05;

/// How far outside its work space the lever may seem to be, rad: 2°. Stops give a little; a lost
/// turn is 52.8°.
const OUTSIDE_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// The angle sensor has proved itself once the lever has moved by this much since it was homed,
/// rad: 0.1°, eight counts of the prototype's sensor. Before, the motor stays off. A spring that
/// rests where the lever is homed demands next to nothing by then.
const PROOF_RAD: f64 = 0.1 * std::f64::consts::PI / 180.0;

/// The force value is marked as stale beyond so many of its periods.
const STALE_PERIODS: f64 = 2.0;

/// Ages closer than this are of the same angle value, s.
const SAME_S: f64 = 1e-6;

/// What a trial must stay within.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Work space, lower end, where the lever is homed, rad.
    pub theta_min_rad: f64,
    /// Work space, upper end, rad.
    pub theta_max_rad: f64,
    /// Highest user force, N; and no mode's motor may give more.
    pub force_n: f64,
}

impl Limits {
    /// The limits a study sets.
    ///
    /// # Errors
    /// A study that does not say where the work space ends, or a force limit that is none.
    pub fn of(study: &Study) -> Result<Self, DeviceError> {
        let device = &study.device;
        let no_min = DeviceError::Missing { key: "device.theta_min_deg" };
        let no_max = DeviceError::Missing { key: "device.theta_max_deg" };
        Ok(Self {
            theta_min_rad: device.theta_min_rad.ok_or(no_min)?,
            theta_max_rad: device.theta_max_rad.ok_or(no_max)?,
            force_n: positive("control.force_limit_n", study.control.force_limit_n)?,
        })
    }
}

/// What a reading says once it has been judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// When the angle was taken, host time, s.
    pub t_angle_s: f64,
    /// Lever angle, rad.
    pub theta_rad: f64,
    /// [`Flags::STALE_ANGLE`], [`Flags::STALE_FORCE`] and [`Flags::OUTSIDE`] where they hold.
    pub flags: Flags,
}

/// The safety layer of one device. It begins with nothing allowed.
#[derive(Debug, Clone, PartialEq)]
pub struct Guard {
    capabilities: Capabilities,
    limits: Limits,
    no_watchdog: bool,
    tracking: Option<Tracking>,
    /// Voltages the armed mode may use.
    ceiling: Option<Voltages>,
    /// Time lost to missed deadlines and not yet forgiven, s.
    lost_s: f64,
}

/// A homed angle and what is known of it.
#[derive(Debug, Clone, PartialEq)]
struct Tracking {
    homed: Homed,
    t_s: f64,
    theta_rad: f64,
    proved: bool,
}

impl Guard {
    /// For a device. `no_watchdog`: the motor of a device without a watchdog is allowed all the
    /// same; every trial is marked ([`crate::TrialRun::unwatched`]).
    pub fn new(capabilities: &Capabilities, limits: Limits, no_watchdog: bool) -> Self {
        let capabilities = capabilities.clone();
        Self { capabilities, limits, no_watchdog, tracking: None, ceiling: None, lost_s: 0.0 }
    }

    /// Both actuators off, then the reading at the lower stop: from here on the turn of the shaft
    /// is known. The motor stays off until the lever has moved, unless the angle sensor has
    /// proved itself before and was not lost since.
    ///
    /// # Errors
    /// A device that is lost, or a lever that is not at its stop.
    pub fn home(&mut self, device: &mut dyn Device, now_s: f64) -> Result<(), DeviceError> {
        let proved = self.tracking.take().is_some_and(|tracking| tracking.proved);
        self.ceiling = None;
        let written = device.write(now_s, Voltages::OFF);
        let reading = device.home(now_s)?;
        // Homing connects a lost device anew, so what could not be written before may be now.
        written.or_else(|_| device.write(now_s, Voltages::OFF))?;
        let stop_rad = self.limits.theta_min_rad;
        let t_s = now_s - reading.angle_age_s;
        let homed = Homed::at_stop(&self.capabilities, stop_rad, t_s, &reading)?;
        self.tracking = Some(Tracking { homed, t_s, theta_rad: stop_rad, proved });
        Ok(())
    }

    /// What trials must stay within.
    pub(crate) fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Whether the turn of the shaft is known.
    pub(crate) fn is_homed(&self) -> bool {
        self.tracking.is_some()
    }

    /// Whether a mode may be used on this device at all: call this before a session begins.
    ///
    /// # Errors
    /// The first reason against it.
    pub fn admit(&self, mode: &Mode, calibration: &Calibration) -> Result<(), Refusal> {
        self.refuse(&Request::of_mode(mode), calibration)
    }

    /// Allows the voltages of a mode, for the next trial only.
    ///
    /// # Errors
    /// A mode that is not to be used on this device.
    pub fn arm(&mut self, mode: &Mode, calibration: &Calibration) -> Result<(), Refusal> {
        self.allow(&Request::of_mode(mode), calibration)
    }

    /// Allows voltages for a step of the device check, which switches on nothing.
    pub(crate) fn arm_for_check(
        &mut self,
        most: Voltages,
        calibration: &Calibration,
    ) -> Result<(), Refusal> {
        self.allow(&Request { name: "check", most, switches_on_force: false }, calibration)
    }

    fn allow(&mut self, request: &Request<'_>, calibration: &Calibration) -> Result<(), Refusal> {
        self.ceiling = None;
        // After the ceiling is gone: a refusal leaves nothing allowed.
        self.refuse(request, calibration)?;
        (self.ceiling, self.lost_s) = (Some(request.most), 0.0);
        Ok(())
    }

    /// The first reason against voltages. The motor may give no more than the limit of the study,
    /// and never more than [`MOTOR_FORCE_N`].
    fn refuse(&self, request: &Request<'_>, calibration: &Calibration) -> Result<(), Refusal> {
        let device = &self.capabilities.name;
        let mode = request.name;
        let Voltages { motor_v, brake_v } = request.most;
        // Nothing on the board would turn the motor off if this program or its cable were gone.
        if motor_v > 0.0 && self.capabilities.watchdog_s.is_none() && !self.no_watchdog {
            return Err(Refusal(format!(
                "{device} has no watchdog, and mode {mode} uses the motor: put the firmware with a watchdog on the board, or \
                 take the risk with --no-watchdog"
            )));
        }
        for (actuator, asked_v, most_v) in [
            ("motor", motor_v, self.capabilities.motor_max_v),
            ("brake", brake_v, self.capabilities.brake_max_v),
        ] {
            if asked_v < 0.0 || exceeds(asked_v, most_v) {
                return Err(Refusal(format!(
                    "mode {mode} asks for {asked_v} V of the {actuator}, and {device} gives 0 to {most_v} V: correct {actuator}_max_v"
                )));
            }
        }
        let force_n = calibration.motor.force_n(motor_v);
        let most_n = self.limits.force_n.min(MOTOR_FORCE_N);
        if exceeds(force_n, most_n) {
            return Err(Refusal(format!(
                "mode {mode}: {motor_v} V give {force_n:.2} N of motor force, more than the {most_n} N allowed: lower motor_max_v"
            )));
        }
        let found_hz = self.capabilities.force_rate_hz;
        if request.switches_on_force && exceeds(FORCE_RATE_HZ, found_hz) {
            return Err(Refusal(format!(
                "mode {mode} switches on the force, which {device} measures {found_hz} times per second; {FORCE_RATE_HZ} are needed: \
                 set the amplifier to its faster rate"
            )));
        }
        Ok(())
    }

    /// Whether a mode is allowed.
    #[cfg(test)]
    pub(crate) fn is_armed(&self) -> bool {
        self.ceiling.is_some()
    }

    /// Whether a motor may run that no watchdog watches.
    pub(crate) fn unwatched(&self) -> bool {
        let motor = self.ceiling.is_some_and(|ceiling| ceiling.motor_v > 0.0);
        self.no_watchdog && self.capabilities.watchdog_s.is_none() && motor
    }

    /// Allows no voltage until it is armed again.
    pub(crate) fn disarm(&mut self) {
        self.ceiling = None;
    }

    /// Forgets the turn of the shaft.
    pub(crate) fn lose(&mut self) {
        self.tracking = None;
    }

    /// Judges a reading; `elapsed_s` since the one before, of which `missed_s` went by in missed
    /// deadlines. A force of unknown age counts as new.
    ///
    /// # Errors
    /// What is wrong with it. The loop then goes to 0 V, and where the turn may be lost, homing is
    /// asked for again.
    pub(crate) fn see(
        &mut self,
        now_s: f64,
        elapsed_s: f64,
        missed_s: f64,
        reading: &Reading,
    ) -> Result<Seen, Trip> {
        let in_time = self.keep_time(elapsed_s, missed_s);
        // The angle first: whatever else is wrong, its turn is to stay known.
        let seen = self.fresh(reading).and_then(|()| self.judge(now_s, reading));
        let seen = seen.and_then(|seen| in_time.map(|()| seen));
        if seen.as_ref().is_err_and(Trip::needs_homing) {
            self.lose();
        }
        seen
    }

    /// The voltages that may go out, and whether that is less than was asked for.
    ///
    /// # Errors
    /// A voltage that is not a number; a guard that is not armed or not homed.
    pub(crate) fn permit(&self, commanded: Voltages) -> Result<(Voltages, bool), Trip> {
        let tracking = self.tracking.as_ref().ok_or(Trip::NotHomed)?;
        let ceiling = self.ceiling.ok_or(Trip::NotArmed)?;
        if !(commanded.motor_v.is_finite() && commanded.brake_v.is_finite()) {
            return Err(Trip::NotFinite { what: "a commanded voltage" });
        }
        // A dead sensor shows a lever at rest, and a motor would drive it away unseen.
        let motor_max_v = if tracking.proved { ceiling.motor_v } else { 0.0 };
        let permitted = Voltages {
            motor_v: commanded.motor_v.clamp(-motor_max_v, motor_max_v),
            brake_v: commanded.brake_v.clamp(0.0, ceiling.brake_v),
        };
        Ok((permitted, permitted != commanded))
    }

    /// Counts lost time in a leaky bucket.
    pub(crate) fn keep_time(&mut self, elapsed_s: f64, missed_s: f64) -> Result<(), Trip> {
        let limit_s = away_s(self.capabilities.rate_hz);
        // Forgiven first, so that what was missed just now counts in full.
        self.lost_s = (self.lost_s - FORGIVEN * elapsed_s).max(0.0) + missed_s;
        if self.lost_s > limit_s {
            Err(Trip::Deadlines { lost_s: self.lost_s, limit_s })
        } else {
            Ok(())
        }
    }

    /// Checks that all values are finite, and that no sensor is too old.
    fn fresh(&self, reading: &Reading) -> Result<(), Trip> {
        let force_age_s = reading.force_age_s.unwrap_or(0.0);
        finite("the force", reading.force_n)?;
        finite("the age of the force", force_age_s)?;
        finite("the age of the angle", reading.angle_age_s)?;
        young("angle", reading.angle_age_s, self.capabilities.rate_hz)?;
        young("force", force_age_s, self.capabilities.force_rate_hz)
    }

    /// Where the lever is, and whether it may be there.
    fn judge(&mut self, now_s: f64, reading: &Reading) -> Result<Seen, Trip> {
        let stop_rad = self.limits.theta_min_rad;
        let limit_n = self.limits.force_n;
        let tracking = self.tracking.as_mut().ok_or(Trip::NotHomed)?;
        let t_s = now_s - reading.angle_age_s;
        let is_same = t_s <= tracking.t_s + SAME_S;
        if !is_same {
            let theta_rad = tracking.homed.follow(t_s, reading.angle)?;
            finite("the angle", theta_rad)?;
            tracking.proved |= (theta_rad - stop_rad).abs() > PROOF_RAD;
            (tracking.t_s, tracking.theta_rad) = (t_s, theta_rad);
        }
        let t_angle_s = tracking.t_s;
        let theta_rad = tracking.theta_rad;
        if !self.is_inside(theta_rad, OUTSIDE_RAD) {
            return Err(Trip::Outside { theta_rad });
        }
        if exceeds(reading.force_n.abs(), limit_n) {
            return Err(Trip::Force { force_n: reading.force_n, limit_n });
        }
        let stale_s = STALE_PERIODS / self.capabilities.force_rate_hz;
        let flags = Flags::default()
            .with(Flags::STALE_ANGLE, is_same)
            .with(Flags::STALE_FORCE, reading.force_age_s.is_some_and(|age_s| age_s > stale_s))
            // Less than a count outside is the rounding of a sensor at the stop.
            .with(Flags::OUTSIDE, !self.is_inside(theta_rad, self.capabilities.resolution_rad()));
        Ok(Seen { t_angle_s, theta_rad, flags })
    }

    /// Whether an angle lies in the work space, or no more than so much outside.
    fn is_inside(&self, theta_rad: f64, outside_rad: f64) -> bool {
        let Limits { theta_min_rad, theta_max_rad, .. } = self.limits;
        (theta_min_rad - outside_rad..=theta_max_rad + outside_rad).contains(&theta_rad)
    }
}

impl Capabilities {
    /// What one count of the angle sensor is at the lever, rad; 0 for a device that gives angles.
    pub(crate) fn resolution_rad(&self) -> f64 {
        self.counts_per_turn.map_or(0.0, |counts| rad_per_count(counts, self.shaft_per_lever))
    }
}

fn finite(what: &'static str, value: f64) -> Result<(), Trip> {
    if value.is_finite() { Ok(()) } else { Err(Trip::NotFinite { what }) }
}

/// How long something of such a rate may be away, s.
fn away_s(rate_hz: f64) -> f64 {
    AWAY_S.max(AWAY_PERIODS / rate_hz)
}

fn young(sensor: &'static str, age_s: f64, rate_hz: f64) -> Result<(), Trip> {
    let limit_s = away_s(rate_hz);
    if age_s > limit_s { Err(Trip::Stale { sensor, age_s, limit_s }) } else { Ok(()) }
}
