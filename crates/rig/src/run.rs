//! Carries out what a characterisation asks for: at a person, at the device, on the disk.

use crate::flow::Kept;
use crate::searches::search_sweep;
use crate::step::{Action, Ask, Input, Remark, Steps, SweepRun};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use zwidth_device::check::{Step, check_step};
use zwidth_device::{Attendant, Station, Trip};
use zwidth_store::{Files, Layout, Quantity, StoreError, Sweep, record_sweep};
use zwidth_study::{ActuatorId, Calibration, Check, Source};

/// The sweeps of the load cell, by weight.
const LOAD_CELL: &str = "load_cell";
/// Key of a sweep's force per voltage in its file.
const GAIN: &str = "gain_n_per_v";

/// What a person says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reply {
    /// It is done.
    Go,
    /// Not now: it can go on another time.
    Quit,
}

/// The person at the bench.
pub trait Operator {
    /// Asks them to do something, and waits.
    fn ask(&mut self, ask: &Ask) -> Reply;

    /// Tells them something.
    fn tell(&mut self, remark: &Remark);

    /// Tells them where a sweep was written.
    fn wrote(&mut self, path: &std::path::Path);
}

/// What a characterisation runs on, besides its device.
pub struct Bench<'a> {
    /// Where sweeps are written.
    pub files: &'a dyn Files,
    /// The study's folder.
    pub layout: &'a Layout,
    /// The time of day, in UTC and RFC 3339.
    pub utc: &'a dyn Fn() -> String,
    /// What every file says of itself: study, device, software.
    pub about: BTreeMap<String, String>,
    /// Measured or simulated.
    pub source: Source,
    /// The calibration in force, by which the guard knows what a motor may give.
    pub calibration: &'a Calibration,
    /// Ticks per second, Hz.
    pub rate_hz: f64,
    /// Raised to end it.
    pub stop: &'a AtomicBool,
    /// Whether somebody has said since it was asked last that they watch the motor.
    pub watched: &'a (dyn Fn() -> bool + Sync),
}

/// How it was left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Left {
    /// All is there.
    Finished,
    /// It can go on another time.
    Open,
}

/// Why it cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum RigError {
    /// A sweep cannot be written.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The device's own thread is gone.
    #[error(transparent)]
    Trip(#[from] Trip),
    /// A name that is none.
    #[error(transparent)]
    Id(#[from] zwidth_study::IdError),
}

/// Goes through a characterisation until all is there, or somebody leaves it.
///
/// # Errors
/// A sweep that cannot be written. What was kept before stays.
pub fn run<'a>(
    attendant: &mut Attendant<'a>,
    bench: &Bench<'a>,
    flow: &mut dyn Steps,
    operator: &mut dyn Operator,
) -> Result<Left, RigError> {
    let Bench { stop, watched, calibration, rate_hz, .. } = *bench;
    let mut actions = flow.begin();
    loop {
        let mut input = None;
        for action in std::mem::take(&mut actions) {
            match action {
                Action::Tell(remark) => operator.tell(&remark),
                Action::KeepLoads(loads) => keep_loads(bench, &loads, operator)?,
                Action::Keep(run) => keep(bench, &run, operator)?,
                Action::KeepSearch(probe, found) => {
                    let about = bench.about.clone();
                    write(bench, search_sweep(&probe, &found, 0, bench.source, about)?, operator)?;
                }
                Action::Finish => return Ok(Left::Finished),
                Action::Ask(ask) => {
                    if operator.ask(&ask) == Reply::Quit || stop.load(Ordering::Relaxed) {
                        return Ok(Left::Open);
                    }
                    // The device was read on meanwhile, and may be lost.
                    let fault = attendant.fault().filter(Trip::needs_homing);
                    input = Some(match fault {
                        Some(trip) if ask != Ask::GoOn => Input::Failed(trip.to_string()),
                        _ => Input::Go,
                    });
                }
                Action::Weigh(for_s) => {
                    let weighed = attendant.ask(move |station| station.weigh(for_s, stop))?;
                    input = Some(match weighed {
                        Ok(values) => Input::Weighed(values),
                        Err(trip) => Input::Failed(trip.to_string()),
                    });
                }
                Action::Home => {
                    let homed = attendant.ask(|station| station.home())?;
                    input = Some(match homed {
                        Ok(()) => Input::Homed,
                        Err(error) => Input::Failed(error.to_string()),
                    });
                }
                Action::Rest => {
                    let rested =
                        attendant.ask(move |station| rest(station, rate_hz, calibration, stop))?;
                    input = Some(match rested {
                        Ok(checks) => Input::Rested(checks),
                        Err(trip) => Input::Failed(trip.to_string()),
                    });
                }
                Action::Ramp(ramp) => {
                    let ramped = attendant.ask(move |station| {
                        station.ramp(&ramp, calibration, &mut || watched(), stop)
                    })?;
                    input = Some(Input::Ramped(ramped));
                }
                Action::Push(push) => {
                    let pushed = attendant.ask(move |station| {
                        station.push(&push, calibration, &mut || watched(), stop)
                    })?;
                    input = Some(Input::Pushed(pushed));
                }
            }
        }
        if stop.load(Ordering::Relaxed) {
            return Ok(Left::Open);
        }
        // A flow that asks for nothing and is not finished would wait for ever.
        let Some(input) = input else { return Ok(Left::Open) };
        actions = flow.step(input);
    }
}

/// The device check of a lever at rest.
fn rest(
    station: &mut Station<'_>,
    rate_hz: f64,
    calibration: &Calibration,
    stop: &AtomicBool,
) -> Result<Vec<Check>, Trip> {
    let Station { device, clock, guard, .. } = station;
    let step = (Step::Rest, 0.0);
    let found = check_step(*device, *clock, guard, calibration, rate_hz, step, stop)?;
    Ok(found.into_iter().map(|finding| finding.check).collect())
}

fn keep(bench: &Bench<'_>, run: &SweepRun, operator: &mut dyn Operator) -> Result<(), RigError> {
    let SweepRun { judged, ramp, cell } = run;
    let mut file = bench.about.clone();
    for (key, value) in [
        (GAIN, judged.gain_n_per_v),
        ("hysteresis_n", judged.hysteresis_n),
        ("cell_zero_n", cell.zero_n),
        ("cell_scale", cell.scale),
        ("cell_scale_error", cell.scale_error),
        ("cell_noise_n", cell.noise_n),
        ("lasts_s", ramp.lasts_s),
    ] {
        file.insert(key.to_owned(), value.to_string());
    }
    file.insert("gives_no_more".to_owned(), judged.is_full.to_string());
    let values = &judged.values;
    let sweep = Sweep {
        actuator: ramp.actuator.as_str().parse()?,
        sweep: 0,
        source: bench.source,
        command: Quantity { name: "voltage".to_owned(), unit: "V".to_owned() },
        response: Quantity { name: "force".to_owned(), unit: "N".to_owned() },
        t_s: Some(values.iter().map(|value| value.t_s).collect()),
        command_values: values.iter().map(|value| value.voltage_v).collect(),
        response_values: values.iter().map(|value| value.force_n).collect(),
        file,
    };
    write(bench, sweep, operator)
}

/// The loads of the cell as a sweep: the stage fits it as it fits any sensor's.
fn keep_loads(
    bench: &Bench<'_>,
    loads: &[[f64; 2]],
    operator: &mut dyn Operator,
) -> Result<(), RigError> {
    let sweep = Sweep {
        actuator: LOAD_CELL.parse()?,
        sweep: 0,
        source: bench.source,
        command: Quantity { name: "weight".to_owned(), unit: "N".to_owned() },
        response: Quantity { name: "force shown".to_owned(), unit: "N".to_owned() },
        t_s: None,
        command_values: loads.iter().map(|[weight_n, _]| *weight_n).collect(),
        response_values: loads.iter().map(|[_, shown_n]| *shown_n).collect(),
        file: bench.about.clone(),
    };
    write(bench, sweep, operator)
}

/// Writes a sweep at the first number without a file, synced, with its line in the log.
fn write(bench: &Bench<'_>, sweep: Sweep, operator: &mut dyn Operator) -> Result<(), RigError> {
    let number = next_number(bench, &sweep.actuator);
    let utc = (bench.utc)();
    let mut sweep = Sweep { sweep: number, ..sweep };
    sweep.file.insert("utc".to_owned(), utc.clone());
    let path = record_sweep(bench.files, bench.layout, &utc, &sweep)?;
    operator.wrote(&path);
    Ok(())
}

fn next_number(bench: &Bench<'_>, actuator: &ActuatorId) -> u32 {
    let is_free = |number: &u32| bench.files.kind(&bench.layout.sweep(actuator, *number)).is_none();
    (1..).find(is_free).unwrap_or(u32::MAX)
}

/// What a recorded sweep counts for when a characterisation goes on; none of one that was not
/// recorded here.
pub fn kept_sweep(sweep: &Sweep) -> Option<Kept> {
    let gain_n_per_v = sweep.file.get(GAIN)?.parse().ok()?;
    Some(Kept { gain_n_per_v })
}
