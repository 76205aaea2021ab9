//! A device for tests: it moves as commanded, keeps what was written to it, and can fail in every
//! way. The module also has a clock that two threads can share.

use crate::angle::rad_per_count;
use crate::{Angle, Capabilities, Clock, Cue, Device, DeviceError, Judged, Person, Reading};
use std::f64::consts::{FRAC_PI_4, PI};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;
use zwidth_study::{Extra, Moment, Source, Voltages};

/// What goes wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// The cable is pulled: nothing can be read or written any more. The board still has its
    /// watchdog.
    Unplugged,
    /// The angle sensor gives no new value.
    AngleStops,
    /// The force sensor gives no new value.
    ForceStops,
    /// The angle is not a number; needs a device that gives angles.
    AngleNan,
    /// The force is not a number.
    ForceNan,
    /// The angle is off by so much, rad.
    AngleOff(f64),
    /// The force is this, N.
    Force(f64),
    /// The device's own code fails.
    Panic,
}

/// Where the lever is, rad, and what the user pushes with, N, so many seconds after a trial's
/// begin.
pub type Motion = fn(f64) -> (f64, f64);

/// A device for tests.
#[derive(Debug, Clone)]
pub struct Mock {
    /// What it claims to be.
    pub capabilities: Capabilities,
    /// How it moves.
    pub motion: Motion,
    /// What goes wrong from which host time on, s.
    pub faults: Vec<(f64, Fault)>,
    /// Everything written, with its host time, s.
    pub writes: Vec<(f64, Voltages)>,
    /// The moments that it was to show.
    pub moments: Vec<Moment>,
    began_s: f64,
}

/// Writes the mock keeps without allocating: a minute at 1 kHz.
const WRITES: usize = 60_000;

/// Moments the mock keeps without allocating: those of a long session.
const MOMENTS: usize = 1_000;

/// What the prototype with a watchdog on its board would claim (thesis §4.2).
pub fn capabilities() -> Capabilities {
    Capabilities {
        name: "mock 1".to_owned(),
        rate_hz: 1000.0,
        force_rate_hz: 80.0,
        counts_per_turn: Some(4096),
        shaft_per_lever: 75.0 / 11.0,
        motor_max_v: 16.0,
        brake_max_v: 8.0,
        watchdog_s: Some(0.05),
        shows_moments: true,
        source: Source::Twin,
        channels: Vec::new(),
    }
}

/// Forward by 60° and back within 2 s, and at rest from then on; a push of up to 3 N on the way.
pub fn forward_and_back(t_s: f64) -> (f64, f64) {
    let phase = PI * t_s.clamp(0.0, 2.0);
    let share = 0.5 * (1.0 - libm::cos(phase));
    (-FRAC_PI_4 + PI / 3.0 * share, 3.0 * share)
}

impl Default for Mock {
    fn default() -> Self {
        Self::new(forward_and_back)
    }
}

impl Mock {
    /// A sound device that moves like this.
    pub fn new(motion: Motion) -> Self {
        Self {
            capabilities: capabilities(),
            motion,
            faults: Vec::new(),
            writes: Vec::with_capacity(WRITES),
            moments: Vec::with_capacity(MOMENTS),
            began_s: 0.0,
        }
    }

    /// The same, which rests as it begins until its first trial does: whoever reads on between
    /// homing and a trial would see it move, and then jump back.
    #[must_use]
    #[cfg(test)]
    pub(crate) fn resting(self) -> Self {
        Self { began_s: f64::MAX, ..self }
    }

    /// The same, with a fault from a host time on, s.
    #[must_use]
    pub fn failing(mut self, from_s: f64, fault: Fault) -> Self {
        self.faults.push((from_s, fault));
        self
    }

    /// What the board gives its actuators at a host time, s: what was last written, unless its
    /// watchdog has run out.
    pub fn output(&self, now_s: f64) -> Voltages {
        let last = self.writes.iter().rev().find(|(at_s, _)| *at_s <= now_s);
        let Some((at_s, voltages)) = last else { return Voltages::OFF };
        let is_fresh = self.capabilities.watchdog_s.is_none_or(|wait_s| now_s - at_s < wait_s);
        if is_fresh { *voltages } else { Voltages::OFF }
    }

    /// When this fault began, if it has.
    fn since(&self, now_s: f64, fault: Fault) -> Option<f64> {
        self.faults
            .iter()
            .find(|(from_s, f)| *f == fault && *from_s <= now_s)
            .map(|(from_s, _)| *from_s)
    }

    fn connected(&self, now_s: f64) -> Result<(), DeviceError> {
        if self.since(now_s, Fault::Unplugged).is_none() {
            return Ok(());
        }
        let device = self.capabilities.name.clone();
        Err(DeviceError::Lost { device, what: "unplugged".to_owned() })
    }

    fn angle(&self, theta_rad: f64) -> Angle {
        match self.capabilities.counts_per_turn {
            None => Angle::Lever(theta_rad),
            Some(counts) => {
                let rad_per_count = rad_per_count(counts, self.capabilities.shaft_per_lever);
                let total = ((theta_rad + FRAC_PI_4) / rad_per_count).round() as i64;
                Angle::Counts(total.rem_euclid(i64::from(counts)) as u16)
            }
        }
    }

    /// Lever angle and force at a time, faults of the values themselves included.
    fn state(&self, now_s: f64) -> (f64, f64) {
        let (mut theta_rad, mut force_n) = (self.motion)(now_s - self.began_s);
        for (_, fault) in self.faults.iter().filter(|(from_s, _)| *from_s <= now_s) {
            match fault {
                Fault::AngleOff(off_rad) => theta_rad += off_rad,
                Fault::AngleNan => theta_rad = f64::NAN,
                Fault::Force(false_n) => force_n = *false_n,
                Fault::ForceNan => force_n = f64::NAN,
                _ => {}
            }
        }
        (theta_rad, force_n)
    }
}

impl Device for Mock {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        self.connected(now_s)?;
        Ok(reading(self.angle(-FRAC_PI_4)))
    }

    #[expect(clippy::panic, reason = "a fault that is asked for")]
    fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
        self.connected(now_s)?;
        if self.since(now_s, Fault::Panic).is_some() {
            panic!("the mock was asked to");
        }
        let angle_s = self.since(now_s, Fault::AngleStops).unwrap_or(now_s);
        let force_s = self.since(now_s, Fault::ForceStops).unwrap_or(now_s);
        let (theta_rad, _) = self.state(angle_s);
        let (_, force_n) = self.state(force_s);
        Ok(Reading {
            angle_age_s: now_s - angle_s,
            force_n,
            force_age_s: Some(now_s - force_s),
            ..reading(self.angle(theta_rad))
        })
    }

    fn write(&mut self, now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
        self.connected(now_s)?;
        self.writes.push((now_s, voltages));
        Ok(())
    }

    fn begin(&mut self, now_s: f64, _cue: &Cue<'_>) {
        self.began_s = now_s;
    }

    fn mark(&mut self, moment: Moment) {
        self.moments.push(moment);
    }

    fn judge(&mut self, judged: &Judged) -> Option<i16> {
        Some(Person::typical(1).judge(judged))
    }
}

/// A clock that goes on with the deadlines that its loop waits for, and that others can watch: no
/// machine is too slow for it, and no deadline is missed.
#[derive(Debug, Clone, Default)]
pub struct SharedClock(Arc<(Mutex<f64>, Condvar)>);

/// Between two deadlines others come to their turn, also where the loop's thread comes before them.
const TURN: Duration = Duration::from_micros(20);

/// A loop that has not gone on by then is none.
const NOBODY: Duration = Duration::from_secs(20);

impl SharedClock {
    /// Now, s.
    pub fn is_s(&self) -> f64 {
        *self.lock()
    }

    /// Stands still until the loop of another thread has run for this time, s; returns from when
    /// until when. Without such a loop the time passes all the same.
    pub fn stand(&self, for_s: f64) -> (f64, f64) {
        let now_s = self.lock();
        let from_s = *now_s;
        let until_s = *now_s + for_s;
        let waited = self.0.1.wait_timeout_while(now_s, NOBODY, |now_s| *now_s < until_s);
        let (mut now_s, _) = waited.unwrap_or_else(PoisonError::into_inner);
        *now_s = now_s.max(until_s);
        (from_s, until_s)
    }

    fn lock(&self) -> MutexGuard<'_, f64> {
        self.0.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Clock for SharedClock {
    fn now_s(&mut self) -> f64 {
        self.is_s()
    }

    fn wait_until(&mut self, deadline_s: f64) -> f64 {
        thread::park_timeout(TURN);
        let mut now_s = self.lock();
        *now_s = now_s.max(deadline_s);
        self.0.1.notify_all();
        *now_s
    }
}

/// A reading of an angle of just now, and of no force.
pub(crate) fn reading(angle: Angle) -> Reading {
    Reading {
        t_device_s: None,
        angle,
        angle_age_s: 0.0,
        force_n: 0.0,
        force_age_s: Some(0.0),
        extra: Extra::default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ON: Voltages = Voltages { motor_v: -8.0, brake_v: 0.0 };

    #[test]
    fn a_program_that_is_killed_leaves_0_v_within_the_boards_watchdog() {
        let mut mock = Mock::default();
        mock.write(1.0, ON).unwrap(); // and nobody ever writes again
        assert_eq!(mock.output(1.049), ON);
        assert_eq!(mock.output(1.0501), Voltages::OFF);
        mock.capabilities.watchdog_s = None;
        assert_eq!(mock.output(1e6), ON);
    }

    #[test]
    fn an_unplugged_device_neither_reads_nor_writes() {
        let mut mock = Mock::default().failing(1.0, Fault::Unplugged);
        assert!(mock.read(0.9).is_ok() && mock.write(0.9, ON).is_ok());
        assert!(mock.read(1.0).is_err() && mock.write(1.0, Voltages::OFF).is_err());
    }
}
