//! A voltage that goes up and down again at a rig, with all of safety in place: a sweep; and
//! readings at 0 V beside it.

use crate::timing::Pace;
use crate::trial::Output;
use crate::{Reading, Station, Trip};
use std::sync::atomic::{AtomicBool, Ordering};
use zwidth_study::{ActuatorKind, Calibration, Voltages};

/// Ages closer than this are of one and the same value, s.
const SAME_S: f64 = 1e-6;

/// A clamped lever that moves this far is not clamped, rad: 2°. The voltage goes at once.
const LOOSE_RAD: f64 = 2.0 * std::f64::consts::PI / 180.0;

/// Whoever watches a motor must say so at least this often, s: a held key begins to repeat after
/// 0.25 to 0.66 s.
pub(crate) const WATCHED_S: f64 = 1.0;

/// How the voltage of a sweep goes: in straight lines up to its top and down again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ramp {
    /// Whose voltage. A motor pushes towards −θ, against what holds the lever there; a brake is
    /// pushed through by a hand.
    pub actuator: ActuatorKind,
    /// Highest voltage, V.
    pub top_v: f64,
    /// How long it takes up and down, s.
    pub lasts_s: f64,
}

impl Ramp {
    /// ∫U² dt, V² s: what warms a winding.
    pub fn v2_s(&self) -> f64 {
        self.top_v * self.top_v * self.lasts_s / 3.0
    }

    /// The size of the voltage so long after its beginning, V.
    pub fn voltage_v(&self, t_s: f64) -> f64 {
        let share = (t_s / self.lasts_s).clamp(0.0, 1.0);
        self.top_v * (1.0 - (2.0 * share - 1.0).abs())
    }

    fn voltages(&self, voltage_v: f64) -> Voltages {
        match self.actuator {
            ActuatorKind::Motor => Voltages { motor_v: -voltage_v, brake_v: 0.0 },
            ActuatorKind::Brake => Voltages { motor_v: 0.0, brake_v: voltage_v },
        }
    }

    fn most(&self) -> Voltages {
        let Voltages { motor_v, brake_v } = self.voltages(self.top_v);
        Voltages { motor_v: motor_v.abs(), brake_v }
    }
}

/// A new value of the force sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weighed {
    /// When the sensor took it, since the beginning, s.
    pub t_s: f64,
    /// Size of the voltage at that time, V.
    pub voltage_v: f64,
    /// The force, N.
    pub force_n: f64,
    /// The lever's angle when the value was read, rad; none of a lever whose turn is not known.
    pub theta_rad: Option<f64>,
}

/// How a ramp ended; always at 0 V.
#[derive(Debug, Clone, PartialEq)]
pub enum RampEnd {
    /// As planned.
    Whole,
    /// Somebody stopped it.
    Stopped,
    /// Nobody watched the motor any more.
    Unwatched,
    /// The clamped lever moved.
    Loose,
    /// The guard gave less than was asked for.
    HeldBack,
    /// Safety took the voltages away.
    Tripped(Trip),
}

/// A ramp that has run.
#[derive(Debug, Clone, PartialEq)]
pub struct Ramped {
    /// How it ended.
    pub end: RampEnd,
    /// Every value of the force sensor that came meanwhile.
    pub values: Vec<Weighed>,
}

/// Picks the readings that bring a new force.
struct NewForces {
    start_s: f64,
    last_s: f64,
}

impl NewForces {
    /// Values that were taken before `start_s` are not new.
    fn since(start_s: f64) -> Self {
        Self { start_s, last_s: start_s - SAME_S }
    }

    /// When the force was taken since the start, s, if no reading before had it.
    fn new_at(&mut self, now_s: f64, reading: &Reading) -> Option<f64> {
        let t_s = now_s - reading.force_age_s.unwrap_or(0.0);
        let is_new = t_s > self.last_s + SAME_S;
        self.last_s = self.last_s.max(t_s);
        is_new.then_some(t_s - self.start_s)
    }
}

impl Station<'_> {
    /// The values of the force sensor for so long, with both actuators off. A turn that is known
    /// stays known.
    ///
    /// # Errors
    /// A device that is lost, or an angle that cannot be believed any more.
    pub fn weigh(&mut self, for_s: f64, stop: &AtomicBool) -> Result<Vec<Weighed>, Trip> {
        let start_s = self.clock.now_s();
        let mut pace = Pace::new(start_s, 1.0 / self.rate_hz);
        let mut forces = NewForces::since(start_s);
        let mut values = Vec::new();
        let is_homed = self.guard.is_homed();
        let mut output = Output::new(&mut *self.device, &mut self.guard, start_s);
        loop {
            let tick = pace.wait(&mut *self.clock);
            if tick.now_s >= start_s + for_s || stop.load(Ordering::Relaxed) {
                return Ok(values);
            }
            let looked = if is_homed {
                output.look_unhurried(&tick).map(|(reading, seen)| (reading, Some(seen.theta_rad)))
            } else {
                output.read(&tick).map(|reading| (reading, None))
            };
            // In every tick, whatever was seen: a board's watchdog waits for a write.
            output.off(self.clock.now_s())?;
            let (reading, theta_rad) = match looked {
                Ok(looked) => looked,
                // Without a voltage a large force does no harm.
                Err(trip) if !trip.needs_homing() => continue,
                Err(trip) => return Err(trip),
            };
            if let Some(t_s) = forces.new_at(tick.now_s, &reading) {
                values.push(Weighed { t_s, voltage_v: 0.0, force_n: reading.force_n, theta_rad });
            }
        }
    }

    /// Drives one actuator up and down. `watched` is asked in every tick of a motor's ramp whether
    /// somebody has said since the last time that they watch it; without that for a second it goes
    /// to 0 V. A motor's lever must be clamped: where it moves, the ramp ends.
    pub fn ramp(
        &mut self,
        ramp: &Ramp,
        calibration: &Calibration,
        watched: &mut dyn FnMut() -> bool,
        stop: &AtomicBool,
    ) -> Ramped {
        let mut values = Vec::with_capacity((ramp.lasts_s * self.rate_hz) as usize);
        let ended = self.run_ramp(ramp, calibration, watched, stop, &mut values);
        let end = ended.unwrap_or_else(|trip| RampEnd::Tripped(self.cause(trip)));
        Ramped { end, values }
    }

    fn run_ramp(
        &mut self,
        ramp: &Ramp,
        calibration: &Calibration,
        watched: &mut dyn FnMut() -> bool,
        stop: &AtomicBool,
        values: &mut Vec<Weighed>,
    ) -> Result<RampEnd, Trip> {
        self.guard.arm_for_check(ramp.most(), calibration)?;
        let is_motor = ramp.actuator == ActuatorKind::Motor;
        let start_s = self.clock.now_s();
        let mut pace = Pace::new(start_s, 1.0 / self.rate_hz);
        let mut forces = NewForces::since(start_s);
        let mut output = Output::new(&mut *self.device, &mut self.guard, start_s);
        let mut watched_s = start_s;
        let mut clamped_rad = None;
        loop {
            let tick = pace.wait(&mut *self.clock);
            if stop.load(Ordering::Relaxed) {
                return Ok(RampEnd::Stopped);
            }
            if watched() {
                watched_s = tick.now_s;
            }
            if is_motor && tick.now_s - watched_s > WATCHED_S {
                return Ok(RampEnd::Unwatched);
            }
            let (reading, seen) = output.look(&tick)?;
            let from_rad = *clamped_rad.get_or_insert(seen.theta_rad);
            if is_motor && (seen.theta_rad - from_rad).abs() > LOOSE_RAD {
                return Ok(RampEnd::Loose);
            }
            if let Some(t_s) = forces.new_at(tick.now_s, &reading) {
                // Of the time at which the sensor took it: a slow loop reads it later.
                let voltage_v = ramp.voltage_v(t_s);
                let theta_rad = Some(seen.theta_rad);
                values.push(Weighed { t_s, voltage_v, force_n: reading.force_n, theta_rad });
            }
            let t_s = tick.now_s - start_s;
            if t_s >= ramp.lasts_s {
                return Ok(RampEnd::Whole);
            }
            let (_, is_less) =
                output.command(self.clock.now_s(), ramp.voltages(ramp.voltage_v(t_s)))?;
            if is_less {
                return Ok(RampEnd::HeldBack);
            }
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::trial::tests::LIMITS;
    use crate::{
        Device as _, Faults, Fixture, Guard, Hands, Limits, SimulatedClock, TwinParameters,
    };

    const MOTOR: Ramp = Ramp { actuator: ActuatorKind::Motor, top_v: 16.0, lasts_s: 8.0 };
    const BRAKE: Ramp = Ramp { actuator: ActuatorKind::Brake, top_v: 8.0, lasts_s: 8.0 };

    /// What is done with a homed lever at the simulated fixture, behind hands that do this for so long, s, and watched for so
    /// many ticks; and what is out after it.
    pub(crate) fn at_bench<T>(
        faults: Faults,
        hands: &[(Hands, f64)],
        watched_for: u32,
        work: impl FnOnce(&mut Station<'_>, &mut dyn FnMut() -> bool, &AtomicBool) -> T,
    ) -> (T, Voltages) {
        let (mut fixture, handle) = Fixture::new(TwinParameters::default(), faults, 3).unwrap();
        let mut clock = SimulatedClock::new(1);
        let stop = AtomicBool::new(false);
        let limits = Limits { force_n: 20.0, ..LIMITS };
        let guard = Guard::new(fixture.capabilities(), limits, false);
        let mut station = Station::new(&mut fixture, &mut clock, guard, 1000.0);
        station.home().unwrap();
        for (does, for_s) in hands {
            handle.set(*does);
            station.weigh(*for_s, &stop).unwrap();
        }
        let mut ticks = 0;
        let mut watched = || {
            ticks += 1;
            ticks < watched_for
        };
        let done = work(&mut station, &mut watched, &stop);
        drop(station);
        (done, fixture.voltages())
    }

    /// A ramp whose lever is clamped at 0, or pushed over the whole stroke.
    fn run(ramp: Ramp, faults: Faults, watched_for: u32) -> (Ramped, Voltages) {
        let hands: &[(Hands, f64)] = match ramp.actuator {
            ActuatorKind::Motor => &[(Hands::Clamp(0.0), 4.0)],
            // It is pushed as soon as it begins.
            ActuatorKind::Brake => &[(Hands::Away, 4.0), (Hands::Push, 0.0)],
        };
        at_bench(faults, hands, watched_for, |station, watched, stop| {
            station.ramp(&ramp, &Calibration::thesis(), watched, stop)
        })
    }

    #[test]
    fn a_motor_at_a_clamped_lever_gives_0_26_n_per_volt_and_ends_at_0_v() {
        let (ramped, voltages) = run(MOTOR, Faults::default(), u32::MAX);
        assert_eq!((&ramped.end, voltages), (&RampEnd::Whole, Voltages::OFF));
        assert!((638..=641).contains(&ramped.values.len()), "{}", ramped.values.len());
        let top = ramped.values.iter().filter(|value| value.voltage_v > 15.8);
        assert!(top.clone().count() > 6);
        for value in top {
            // Friction holds some of it back on the way up.
            assert!((value.force_n - 0.26 * value.voltage_v + 0.1).abs() < 0.12, "{value:?}");
        }
    }

    #[test]
    fn a_brake_that_is_pushed_through_gives_13_n_at_8_v() {
        let (ramped, voltages) = run(BRAKE, Faults::default(), 0);
        assert_eq!((&ramped.end, voltages), (&RampEnd::Whole, Voltages::OFF));
        let largest = ramped.values.iter().map(|value| value.force_n).fold(0.0, f64::max);
        assert!((largest - 13.15).abs() < 0.1, "{largest}");
    }

    #[test]
    fn a_motor_that_nobody_watches_goes_to_0_v_within_a_second_and_two_ticks() {
        let (ramped, voltages) = run(MOTOR, Faults::default(), 2000);
        assert_eq!((&ramped.end, voltages), (&RampEnd::Unwatched, Voltages::OFF));
        let last_s = ramped.values.last().unwrap().t_s;
        assert!((2.9..3.01).contains(&last_s), "{last_s}");
    }

    #[test]
    fn a_lever_that_comes_off_its_clamp_ends_it_at_0_v() {
        let faults = Faults { loose_above_n: Some(2.0), ..Faults::default() };
        let (ramped, voltages) = run(MOTOR, faults, u32::MAX);
        assert_eq!((&ramped.end, voltages), (&RampEnd::Loose, Voltages::OFF));
    }

    #[test]
    fn a_motor_whose_lever_has_not_moved_since_it_was_homed_is_held_back() {
        let (mut fixture, _hands) =
            Fixture::new(TwinParameters::default(), Faults::default(), 3).unwrap();
        let mut clock = SimulatedClock::new(1);
        let guard = Guard::new(fixture.capabilities(), LIMITS, false);
        let mut station = Station::new(&mut fixture, &mut clock, guard, 1000.0);
        station.home().unwrap();
        let stop = AtomicBool::new(false);
        let ramped = station.ramp(&MOTOR, &Calibration::thesis(), &mut || true, &stop);
        assert_eq!(ramped.end, RampEnd::HeldBack);
    }
}
