//! One trial: the loop that real and simulated time, real and simulated devices all go through.
//!
//! A tick: wait for the deadline, read, judge, decide, write, hand over the sample. Nothing in it
//! allocates, locks or touches a disk (`tests/allocation.rs`), as long as the device and the sink
//! do not.

mod ending;
mod live;
mod moments;
mod output;

pub use live::{BatchSink, LiveRun, run_live};
pub(crate) use live::{Collected, POLL, panic_trip, run_caught};
pub use moments::Moments;

use crate::digits::{on_steps, on_ticks};
use crate::timing::{Pace, Tick};
use crate::{
    Capabilities, Clock, Controller, Cue, Device, DeviceError, Guard, Reading, Seen, Timing, Trip,
    Velocity,
};
use ending::Ending;
pub(crate) use output::Output;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use zwidth_study::{Environment, Flags, Sample, Study};

/// Where samples go, one by one. Break: they cannot be kept any more (a full disk), and the trial
/// ends at 0 V.
pub type Sink<'a> = dyn FnMut(&Sample) -> ControlFlow<()> + 'a;

/// The plan of a trial.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialPlan<'a> {
    /// What the device may know of it: number, environment, longest time.
    pub cue: Cue<'a>,
    /// The environment in place of the cue's: that of a task, at the level that is presented.
    pub varied: Option<Environment>,
    /// Ticks per second, Hz.
    pub rate_hz: f64,
    /// The velocity filter, at its beginning.
    pub velocity: Velocity,
    /// The device is to show the trial's moments on an output of its own ([`Device::mark`]).
    pub shows_moments: bool,
}

impl<'a> TrialPlan<'a> {
    /// A trial of a study on a device: at the study's rate, or at the device's if that is lower.
    ///
    /// # Errors
    /// A rate, a time limit or a filter that makes no sense.
    pub fn new(
        study: &Study,
        environment: &'a Environment,
        trial: u32,
        capabilities: &Capabilities,
    ) -> Result<Self, DeviceError> {
        use crate::error::positive;
        let limit_s = positive("design.trial_limit_s", study.design.trial_limit_s)?;
        let rate_hz = positive("control.rate_hz", study.control.rate_hz)?;
        Ok(Self {
            cue: Cue { trial, environment, limit_s },
            varied: None,
            rate_hz: rate_hz.min(positive("the device's rate", capabilities.rate_hz)?),
            velocity: Velocity::new(study.control.velocity)?,
            shows_moments: false,
        })
    }
}

/// How a trial ended. Always at 0 V.
#[derive(Debug, Clone, PartialEq)]
pub enum TrialEnd {
    /// Its time was up.
    Limit,
    /// The participant had moved and let go: no force on a lever at rest.
    LetGo,
    /// Someone asked: a key, Ctrl-C, SIGTERM, a terminal that hung up.
    Stopped,
    /// Safety took the voltages away.
    Tripped(Trip),
}

/// A trial that has run.
#[derive(Debug, Clone, PartialEq)]
pub struct TrialRun {
    /// How it ended.
    pub end: TrialEnd,
    /// When it began, host time, s: the zero of its samples' times; unknown after a panic.
    pub begun_s: Option<f64>,
    /// How well it kept its time.
    pub timing: Timing,
    /// The motor could run without a watchdog, as requested: the trial is to be marked.
    pub unwatched: bool,
}

impl TrialRun {
    /// A run of which only the end is known.
    pub(crate) fn tripped(trip: Trip) -> Self {
        Self {
            end: TrialEnd::Tripped(trip),
            begun_s: None,
            timing: Timing::default(),
            unwatched: false,
        }
    }
}

/// Runs one trial. However it ends (by a panic too), the last thing written is 0 V, and the guard
/// is disarmed.
///
/// The guard must be homed ([`Guard::home`]) and armed with the mode ([`Guard::arm`]); otherwise
/// the trial ends at once and says so. `stop` is checked in every tick.
pub fn run_trial(
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    controller: &mut Controller,
    guard: &mut Guard,
    plan: &TrialPlan<'_>,
    stop: &AtomicBool,
    sink: &mut Sink<'_>,
) -> TrialRun {
    // Asked now: the end of the trial disarms the guard, which then allows no motor.
    let unwatched = guard.unwatched();
    // Its buckets are allocated here, before the first tick, and so is what a late rendering keeps.
    let mut timing = Timing::default();
    let mut output = Output::new(device, guard, clock.now_s());
    output.shown = plan.shows_moments.then(Moments::default);
    controller.begin(plan.rate_hz);
    let end = ticks(&mut output, clock, controller, plan, stop, sink, &mut timing);
    let begun_s = Some(output.begun_s);
    // Writes 0 V before anything else is done.
    drop(output);
    TrialRun { end, begun_s, timing, unwatched }
}

fn ticks(
    output: &mut Output<'_>,
    clock: &mut dyn Clock,
    controller: &mut Controller,
    plan: &TrialPlan<'_>,
    stop: &AtomicBool,
    sink: &mut Sink<'_>,
    timing: &mut Timing,
) -> TrialEnd {
    let start_s = clock.now_s();
    let mut pace = Pace::new(start_s, 1.0 / plan.rate_hz);
    let mut velocity = plan.velocity.clone();
    let mut ending = Ending::default();
    let environment = plan.varied.as_ref().unwrap_or(plan.cue.environment);
    if let Err(trip) = output.begin(start_s, &Cue { environment, ..plan.cue }) {
        return TrialEnd::Tripped(trip);
    }
    loop {
        let tick = pace.wait(clock);
        timing.woke(&tick);
        if stop.load(Ordering::Relaxed) {
            return TrialEnd::Stopped;
        }
        if tick.now_s - start_s >= plan.cue.limit_s {
            // A machine that slept past the limit has recorded nothing since: no complete trial.
            return output.in_time(&tick).map_or_else(TrialEnd::Tripped, |()| TrialEnd::Limit);
        }
        let sample = match step(output, clock, controller, &mut velocity, &tick, start_s) {
            Ok(sample) => sample,
            Err(trip) => return TrialEnd::Tripped(trip),
        };
        output.show(&sample);
        if sink(&sample).is_break() {
            return TrialEnd::Tripped(Trip::Storage);
        }
        timing.ran(clock.now_s() - tick.now_s);
        if ending.let_go(&sample) {
            return TrialEnd::LetGo;
        }
    }
}

/// One tick: read, judge, decide, write.
fn step(
    output: &mut Output<'_>,
    clock: &mut dyn Clock,
    controller: &mut Controller,
    velocity: &mut Velocity,
    tick: &Tick,
    start_s: f64,
) -> Result<Sample, Trip> {
    let (reading, seen) = output.look(tick)?;
    // Rounded before the controller sees them, so that a replay of the recording decides alike.
    let theta_rad = on_steps(seen.theta_rad);
    let force_ex_n = on_steps(reading.force_n);
    let theta_dot_rad_s = on_steps(velocity.step(seen.t_angle_s, theta_rad));
    let (commanded, flags) = controller.step(theta_rad, theta_dot_rad_s, force_ex_n);
    let (voltages, clipped) = output.command(clock.now_s(), commanded)?;
    Ok(Sample {
        t_s: tick.now_s - start_s,
        t_device_s: reading.t_device_s.map(on_ticks),
        theta_rad,
        theta_dot_rad_s,
        force_ex_n,
        voltages,
        force_age_s: reading.force_age_s,
        theta_raw: reading.raw(),
        force_cmd_n: on_steps(controller.force_n(voltages)),
        flags: Flags(flags.0 | seen.flags.0)
            .with(Flags::DROPOUT, tick.missed > 0)
            .with(Flags::CLIPPED, clipped)
            .with(Flags::BRAKE_ON, voltages.brake_v != 0.0)
            .with(Flags::MOTOR_ON, voltages.motor_v != 0.0),
        extra: reading.extra,
    })
}

/// Reads on with both actuators off until `until_s`, so that the turn of the shaft stays known
/// between trials. `seen` gets every reading that can be believed, with its host time. Without a
/// voltage a late tick or a large force does no harm.
///
/// # Errors
/// What safety found, if it needs homing; a stop ends it without one.
pub fn watch(
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    guard: &mut Guard,
    rate_hz: f64,
    until_s: f64,
    stop: &AtomicBool,
    seen: &mut dyn FnMut(f64, &Reading, &Seen),
) -> Result<(), Trip> {
    let mut goes_on = |now_s| now_s < until_s && !stop.load(Ordering::Relaxed);
    read_on(device, clock, guard, rate_hz, &mut goes_on, seen)
}

/// [`watch`], for as long as `goes_on` says so at a tick's time, s.
pub(crate) fn read_on(
    device: &mut dyn Device,
    clock: &mut dyn Clock,
    guard: &mut Guard,
    rate_hz: f64,
    goes_on: &mut dyn FnMut(f64) -> bool,
    seen: &mut dyn FnMut(f64, &Reading, &Seen),
) -> Result<(), Trip> {
    let start_s = clock.now_s();
    let mut output = Output::new(device, guard, start_s);
    let mut pace = Pace::new(start_s, 1.0 / rate_hz);
    loop {
        let tick = pace.wait(clock);
        if !goes_on(tick.now_s) {
            return Ok(());
        }
        // No time counts as missed: a machine that stalls between trials must not lose the turn.
        let looked = output.look_unhurried(&tick);
        // In every tick, whatever was seen: a board's watchdog waits for a write.
        output.off(clock.now_s())?;
        match looked {
            Ok((reading, judged)) => seen(tick.now_s, &reading, &judged),
            Err(trip) if trip.needs_homing() => return Err(trip),
            Err(_) => {}
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
