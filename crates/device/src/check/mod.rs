//! The device check before a session: does the device now do what it claims?
//!
//! There are four steps, each with something for a person to do first ([`Step`]). The findings of a
//! step are a pure function of its readings ([`at_rest`], [`loaded`], [`by_hand`]) or of how far
//! the lever went ([`actuators`]).

mod actuators;
mod finding;
mod readings;

pub use actuators::{Travel, actuators};
pub use finding::Finding;
pub use readings::{Look, at_rest, by_hand, loaded, tare_n, timing};

use crate::timing::Pace;
use crate::{Clock, Cue, Device, DeviceError, Guard, Timing, Trip, watch};
use std::sync::atomic::{AtomicBool, Ordering};
use zwidth_study::{Calibration, Environment, Scene, Voltages};

/// A step of the check, and what a person does before it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Step {
    /// Lever against its lower stop, hands off.
    Rest,
    /// This mass, kg, hung from the load cell so that it pulls towards +θ.
    Load(f64),
    /// Lever against its lower stop; then, for four seconds, all the way to the upper stop and
    /// back.
    Hand,
    /// Lever against its lower stop, hands off: it will move a little.
    Actuators,
}

/// Length of a step at rest, s: 160 values of the force sensor.
const REST_S: f64 = 2.0;

/// Length of the step by hand, s: a trial's.
const HAND_S: f64 = 4.0;

/// The steps in their order; a mass is asked for only if one is known.
pub fn steps(mass_kg: Option<f64>) -> Vec<Step> {
    let load = mass_kg.map(Step::Load);
    [Some(Step::Rest), load, Some(Step::Hand), Some(Step::Actuators)]
        .into_iter()
        .flatten()
        .collect()
}

/// Checks a device at such a rate. `ask` says what a person is to do and returns when it is done,
/// or false to leave a step out. Ends early, without an error, when `stop` is set.
///
/// # Errors
/// A device that is lost, or anything else that would end a trial.
#[expect(clippy::too_many_arguments, reason = "all of the device's surroundings take part")]
pub fn check_device(
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    guard: &mut Guard,
    calibration: &Calibration,
    rate_hz: f64,
    mass_kg: Option<f64>,
    stop: &AtomicBool,
    ask: &mut dyn FnMut(Step) -> bool,
) -> Result<Vec<Finding>, Trip> {
    let mut findings = Vec::new();
    for step in steps(mass_kg) {
        if !stop.load(Ordering::Relaxed) && ask(step) {
            let tare_n = tare_n(&findings);
            let more =
                check_step(device, clock, guard, calibration, rate_hz, (step, tare_n), stop)?;
            findings.extend(more);
        }
    }
    Ok(findings)
}

/// One step of the check, and the force without a load, N ([`tare_n`]). One that is stopped finds
/// nothing.
///
/// # Errors
/// As [`check_device`].
pub fn check_step(
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    guard: &mut Guard,
    calibration: &Calibration,
    rate_hz: f64,
    (step, tare_n): (Step, f64),
    stop: &AtomicBool,
) -> Result<Vec<Finding>, Trip> {
    let capabilities = device.capabilities().clone();
    let findings = match step {
        Step::Rest => {
            let (looks, kept) = look(device, clock, rate_hz, REST_S, stop)?;
            [timing(&kept, rate_hz), at_rest(&capabilities, rate_hz, &looks)].concat()
        }
        Step::Load(mass_kg) => {
            let (looks, _) = look(device, clock, rate_hz, REST_S, stop)?;
            loaded(&looks, tare_n, mass_kg)
        }
        Step::Hand => {
            let start_s = clock.now_s();
            guard.home(device, start_s)?;
            // A device with a participant of its own is told to begin a trial in free space,
            // numbered 0. Always: the word is a valid id.
            if let Ok(id) = "free".parse() {
                let environment = Environment {
                    id,
                    label: "free motion".to_owned(),
                    scene: Scene::Free,
                    delay_s: 0.0,
                    question: None,
                    further: Vec::new(),
                    factors: zwidth_study::Levels::new(),
                };
                let cue = Cue { trial: 0, environment: &environment, limit_s: HAND_S };
                device.begin(start_s, &cue);
            }
            let mut looks = Vec::new();
            watch(
                device,
                clock,
                guard,
                rate_hz,
                start_s + HAND_S,
                stop,
                &mut |t_s, reading, _| {
                    looks.push(Look { t_s, reading: *reading });
                },
            )?;
            by_hand(&capabilities, guard.limits(), &looks)
        }
        Step::Actuators => {
            // A stop ends it by itself; what it has found by then counts.
            return actuators::drive(device, clock, guard, calibration, rate_hz, stop);
        }
    };
    // A step that was cut short has too few readings to judge a device by.
    Ok(if stop.load(Ordering::Relaxed) { Vec::new() } else { findings })
}

/// Reads for so long, or until it is stopped, with both actuators off.
fn look(
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    rate_hz: f64,
    for_s: f64,
    stop: &AtomicBool,
) -> Result<(Vec<Look>, Timing), DeviceError> {
    let start_s = clock.now_s();
    let mut pace = Pace::new(start_s, 1.0 / rate_hz);
    let mut looks = Vec::new();
    let mut timing = Timing::default();
    loop {
        let tick = pace.wait(clock);
        if tick.now_s >= start_s + for_s || stop.load(Ordering::Relaxed) {
            return Ok((looks, timing));
        }
        let reading = device.read(tick.now_s)?;
        // As in a trial, so that the tick's time has a write in it.
        device.write(clock.now_s(), Voltages::OFF)?;
        timing.woke(&tick);
        timing.ran(clock.now_s() - tick.now_s);
        looks.push(Look { t_s: tick.now_s, reading });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mock::Mock;
    use crate::trial::tests::LIMITS;
    use crate::{Capabilities, Person, Reading, SimulatedClock, Twin, TwinParameters};

    /// The findings at 1 kHz, with the jitter of a seed.
    fn check(
        device: &mut dyn Device,
        seed: u64,
        mass_kg: Option<f64>,
        stop: &AtomicBool,
        ask: &mut dyn FnMut(Step) -> bool,
    ) -> Vec<Finding> {
        let mut guard = Guard::new(device.capabilities(), LIMITS, false);
        let mut clock = SimulatedClock::new(seed);
        let calibration = Calibration::thesis();
        check_device(device, &mut clock, &mut guard, &calibration, 1000.0, mass_kg, stop, ask)
            .unwrap()
    }

    fn run(mass_kg: Option<f64>, stop: bool) -> (Vec<Step>, Vec<Finding>) {
        let mut device = Mock::default();
        let mut asked = Vec::new();
        let mut ask = |step| {
            asked.push(step);
            !matches!(step, Step::Actuators | Step::Rest) // the mock is not at rest, and has no motor
        };
        let found = check(&mut device, 1, mass_kg, &AtomicBool::new(stop), &mut ask);
        assert!(device.writes.iter().all(|(_, voltages)| *voltages == Voltages::OFF));
        (asked, found)
    }

    #[test]
    fn each_step_is_asked_for_in_turn_and_a_mass_only_if_there_is_one() {
        let (asked, found) = run(None, false);
        assert_eq!(asked, [Step::Rest, Step::Hand, Step::Actuators]);
        let failed: Vec<_> = found.iter().filter(|f| !f.check.ok).collect();
        assert!(found.len() >= 4 && failed.is_empty(), "{failed:?}");
        assert_eq!(run(Some(0.2), false).0[1], Step::Load(0.2));
    }

    #[test]
    fn the_twin_passes_every_check_at_its_own_rate() {
        for seed in 1..4 {
            let person = Person::typical(seed);
            let mut device = Twin::new(TwinParameters::default(), person, seed).unwrap();
            let found = check(&mut device, seed, None, &AtomicBool::new(false), &mut |_| true);
            let failed: Vec<_> = found.into_iter().filter(|f| !f.check.ok).collect();
            assert!(failed.is_empty(), "{failed:#?}");
        }
    }

    /// A device at which somebody hits the stop key as soon as an actuator is on.
    struct Stopped<'a> {
        twin: Twin,
        stop: &'a AtomicBool,
        /// Writes since the stop, and the last voltages.
        after: Vec<Voltages>,
    }

    impl Device for Stopped<'_> {
        fn capabilities(&self) -> &Capabilities {
            self.twin.capabilities()
        }
        fn home(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
            self.twin.home(now_s)
        }
        fn read(&mut self, now_s: f64) -> Result<Reading, DeviceError> {
            self.twin.read(now_s)
        }
        fn write(&mut self, now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
            if self.stop.load(Ordering::Relaxed) {
                self.after.push(voltages);
            }
            self.stop.fetch_or(voltages != Voltages::OFF, Ordering::Relaxed);
            self.twin.write(now_s, voltages)
        }
        fn begin(&mut self, now_s: f64, cue: &Cue<'_>) {
            self.twin.begin(now_s, cue);
        }
    }

    #[test]
    fn a_stop_while_an_actuator_is_on_ends_at_0_v_with_the_next_write() {
        let stop = AtomicBool::new(false);
        let twin = Twin::new(TwinParameters::default(), Person::typical(1), 1).unwrap();
        let mut device = Stopped { twin, stop: &stop, after: Vec::new() };
        check(&mut device, 1, None, &stop, &mut |_| true);
        assert!(
            !device.after.is_empty() && device.after.iter().all(|v| *v == Voltages::OFF),
            "{:?}",
            device.after
        );
    }

    #[test]
    fn a_stop_asks_for_nothing_more() {
        assert_eq!(run(None, true), (Vec::new(), Vec::new()));
    }
}
