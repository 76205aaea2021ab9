//! `zwidth characterise STUDY motor|brake|rig --device rig`: sweeps and sensors of a rig, step by step, and what its Z-width
//! test shares with them.

use super::calibrate::{calibrate, free_name, sweeps};
use super::device::{Bench, raised_by_signals};
use super::recover::now;
use crate::devices::{DeviceSpec, days_since, open, warn_of_calibration};
use crate::exit::Exit;
use crate::limits::{MOST_SWEEPS, positive};
use crate::screen::Screen;
use anyhow::{Context as _, bail};
use serde::Serialize;
use std::collections::BTreeMap;
use std::io::{BufRead as _, IsTerminal as _, stdin};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;
use zwidth_acquire::check_value;
use zwidth_device::{Attendant, Capabilities, Device, Guard, Limits, Ramp, RealClock, Station};
use zwidth_link::Settings;
use zwidth_rig::{
    Ask, Flow, Kept, Left, Operator, Plan, Recorded, Remark, Reply, SensorPlan, Sensors, Steps,
    Winding, kept_sweep, run,
};
use zwidth_store::{Raw, hex_blake3, write_new};
use zwidth_study::{ActuatorKind, Check};

/// Highest voltage of a sweep, V (thesis App. D: 0 to 16 V of the motor, 1 to 16 V of the brake).
const TOP_V: f64 = 16.0;
/// Sweeps of each actuator (thesis App. D).
const MOTOR_SWEEPS: u32 = 15;
const BRAKE_SWEEPS: u32 = 30;
/// A hand may push so hard through a brake, N: a brake gives nothing of its own, and the prototype's
/// holds 13 N.
const PUSH_N: f64 = 30.0;
/// What is told before the motor of such a board is used.
pub(super) const NO_WATCHDOG: &str = "the board has no watchdog: if the program or the cable is gone, the motor stays on; keep a hand on its supply";
/// Keys of a held key come more often, s.
const HELD: Duration = Duration::from_millis(700);
const DAY_S: f64 = 86_400.0;

/// What is characterised, and how.
#[derive(Debug, clap::Args)]
pub(crate) struct BenchArgs {
    /// The device
    #[arg(long, default_value = "twin", value_name = "twin|rig[:PORT]")]
    pub(crate) device: DeviceSpec,
    /// Number of sweeps [default: 1 more on the simulated device; at a rig 15 of a motor and 30 of a
    /// brake in the end, and 3 repeats of each search of its Z-width]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST_SWEEPS))]
    pub(crate) sweeps: Option<u32>,
    /// At a rig: a known mass for the load cell, kg; two at least, three say which of them is wrong
    #[arg(long, value_name = "KG", value_parser = positive)]
    pub(crate) mass: Vec<f64>,
    /// At a rig: highest voltage, V [default: 16, or what the board gives]
    #[arg(long, value_name = "V", value_parser = positive)]
    pub(crate) to: Option<f64>,
    /// At a rig: how long a sweep takes, up and down, s
    #[arg(long, value_name = "S", default_value_t = 8.0, value_parser = positive)]
    pub(crate) seconds: f64,
    /// At a rig, of its sensors: how long the last mass hangs, to see the cell creep, s
    #[arg(long, value_name = "S", default_value_t = 600.0, value_parser = positive)]
    pub(crate) creep: f64,
    /// At a rig: allow the motor of a board without a watchdog; this is written into each sweep
    #[arg(long)]
    pub(crate) no_watchdog: bool,
}

/// Sweeps an actuator of a rig, guided step by step; goes on where it was left.
pub(super) fn sweep_at_rig(
    bench: &Bench,
    command: &BenchArgs,
    actuator: ActuatorKind,
    raw: &Raw,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    check_masses(command)?;
    let device = open_rig(bench, command, screen)?;
    let capabilities = device.capabilities().clone();
    let name = capabilities.name.clone();
    let plan = plan(bench, command, actuator, &capabilities)?;
    let recorded = recorded(bench, actuator, &name)?;
    if actuator == ActuatorKind::Motor && capabilities.watchdog_s.is_none() {
        screen.warn(NO_WATCHDOG);
    }
    let mut flow = Flow::new(plan, recorded);
    if flow.kept() > 0 {
        screen.say(format!("{} sweeps of the {} are there", flow.kept(), actuator.as_str()));
    }
    let force_n = match actuator {
        ActuatorKind::Motor => Limits::of(&bench.study)?.force_n,
        ActuatorKind::Brake => PUSH_N,
    };
    if carry_out(bench, command, device, force_n, &mut flow, raw, screen)? == Left::Open {
        screen.warn(format!(
            "{} sweeps of the {} are there; the same command goes on",
            flow.kept(),
            actuator.as_str()
        ));
        return Ok(Exit::Partly);
    }
    calibrate(bench, &name, raw, screen)?;
    screen.say(format!("`zwidth run {}` draws the characteristics", bench.layout.study()));
    Ok(Exit::Fine)
}

/// What is found of a rig's sensors: kept beside the study's recordings.
#[derive(Serialize)]
struct ThisRig {
    utc: String,
    device: String,
    software: &'static str,
    checks: Vec<Check>,
}

/// Looks at the sensors of a rig, guided step by step; ends with the page "this rig".
pub(super) fn sensors_at_rig(
    bench: &Bench,
    command: &BenchArgs,
    raw: &Raw,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    check_masses(command)?;
    let device = open_rig(bench, command, screen)?;
    let name = device.capabilities().name.clone();
    let limits = Limits::of(&bench.study)?;
    let mut sensors = Sensors::new(SensorPlan {
        masses_kg: command.mass.clone(),
        newtons_per_count: settings(bench)?.newtons_per_count,
        creep_s: command.creep,
        stops_rad: [limits.theta_min_rad, limits.theta_max_rad],
    });
    if carry_out(bench, command, device, PUSH_N, &mut sensors, raw, screen)? == Left::Open {
        screen.warn(
            "the rig was not looked at to the end: nothing is written but the loads of its cell",
        );
        return Ok(Exit::Partly);
    }
    let checks = sensors.found().to_vec();
    let are_all_good = checks.iter().all(|check| check.ok);
    let rig = ThisRig { utc: now(), device: name, software: super::acquire::SOFTWARE, checks };
    let path = free_name(&bench.layout.raw(), "this-rig", "json")?;
    write_new(raw, &path, serde_json::to_string_pretty(&rig)?.as_bytes())?;
    screen.give(&rig, || {
        screen.result(format!("this rig: {}, {}", rig.device, rig.utc));
        for check in &rig.checks {
            let verdict = if check.ok { "ok" } else { "NOT GOOD ENOUGH" };
            screen.result(format!("  {:<32} {:>12}  {verdict}", check.name, check_value(check)));
        }
        screen.result(path.display().to_string());
    })?;
    Ok(if are_all_good { Exit::Fine } else { Exit::Failed })
}

/// A load cell's scale is known by two masses at least.
fn check_masses(command: &BenchArgs) -> anyhow::Result<()> {
    if command.mass.len() < 2 {
        bail!(
            "a load cell's scale needs two known masses at least: --mass KG --mass KG (three say which of them is wrong)"
        );
    }
    Ok(())
}

/// The rig, and what is to be said of it before anything is asked for.
pub(super) fn open_rig(
    bench: &Bench,
    command: &BenchArgs,
    screen: &Screen,
) -> anyhow::Result<Box<dyn Device>> {
    // No session is recorded, and a device cannot be opened without the ids of one.
    let device = open(&command.device, bench, 1, &"bench".parse()?, &"bench".parse()?)?;
    warn_of_calibration(bench, &command.device, &device.capabilities().name, screen);
    Ok(device)
}

/// Goes through the steps at the rig, with somebody at the bench.
pub(super) fn carry_out(
    bench: &Bench,
    command: &BenchArgs,
    mut device: Box<dyn Device>,
    force_n: f64,
    steps: &mut dyn Steps,
    raw: &Raw,
    screen: &Screen,
) -> anyhow::Result<Left> {
    let capabilities = device.capabilities().clone();
    let limits = Limits { force_n, ..Limits::of(&bench.study)? };
    let guard = Guard::new(&capabilities, limits, command.no_watchdog);
    let rate_hz = bench.study.control.rate_hz.min(capabilities.rate_hz);
    let stop = raised_by_signals()?;
    let beat = Arc::new(AtomicBool::new(false));
    let mut at_bench =
        AtBench { lines: typed(Arc::clone(&beat)), stop: Arc::clone(&stop), screen, held: false };
    let mut about = BTreeMap::from([
        ("study_blake3".to_owned(), hex_blake3(&bench.study_toml)),
        ("device".to_owned(), capabilities.name.clone()),
        ("software".to_owned(), super::acquire::SOFTWARE.to_owned()),
    ]);
    if capabilities.watchdog_s.is_none() {
        about.insert("no_watchdog".to_owned(), "true".to_owned());
    }
    let watched = || beat.swap(false, Ordering::Relaxed);
    let rig = zwidth_rig::Bench {
        files: raw,
        layout: &bench.layout,
        utc: &now,
        about,
        source: capabilities.source,
        calibration: &bench.calibration,
        rate_hz,
        stop: &stop,
        watched: &watched,
    };
    let mut clock = RealClock::new();
    Ok(thread::scope(|scope| {
        let station = Station::new(&mut *device, &mut clock, guard, rate_hz);
        let mut attendant = Attendant::in_real_time(scope, station);
        run(&mut attendant, &rig, steps, &mut at_bench)
    })?)
}

/// A rig cannot be opened without its settings.
pub(super) fn settings(bench: &Bench) -> anyhow::Result<&Settings> {
    bench.rig.as_ref().context("rig.toml is missing (docs/rig.md)")
}

/// What is to be done, or why it cannot be.
fn plan(
    bench: &Bench,
    command: &BenchArgs,
    actuator: ActuatorKind,
    capabilities: &Capabilities,
) -> anyhow::Result<Plan> {
    let name = &capabilities.name;
    let is_motor = actuator == ActuatorKind::Motor;
    if is_motor && capabilities.watchdog_s.is_none() && !command.no_watchdog {
        bail!(
            "{name} has no watchdog, and nothing would turn the motor off if this program or its cable were gone: put the \
             firmware with a watchdog on the board, or take the risk with --no-watchdog"
        );
    }
    let most_v = if is_motor { capabilities.motor_max_v } else { capabilities.brake_max_v };
    let top_v = command.to.unwrap_or(TOP_V.min(most_v));
    if top_v > most_v || top_v <= 0.0 {
        bail!("{name} gives the {} at most {most_v} V: lower --to", actuator.as_str());
    }
    let rig = settings(bench)?;
    let ramp = Ramp { actuator, top_v, lasts_s: command.seconds };
    let winding = winding(rig, is_motor);
    if let Some(why) = winding.refuses(&ramp) {
        bail!(why);
    }
    let usual = if is_motor { MOTOR_SWEEPS } else { BRAKE_SWEEPS };
    Ok(Plan {
        ramp,
        sweeps: command.sweeps.unwrap_or(usual),
        masses_kg: command.mass.clone(),
        winding,
        stop_rad: Limits::of(&bench.study)?.theta_min_rad,
        newtons_per_count: rig.newtons_per_count,
    })
}

/// The winding of an actuator.
pub(super) fn winding(rig: &Settings, is_motor: bool) -> Winding {
    let heat = &rig.heat;
    let (resistance_ohm, mass_kg) =
        if is_motor { (heat.motor_ohm, heat.motor_kg) } else { (heat.brake_ohm, heat.brake_kg) };
    Winding { resistance_ohm, mass_kg, cooling_s: heat.cooling_s }
}

/// The sweeps that are there. Those of another device would be fitted together with these.
fn recorded(bench: &Bench, actuator: ActuatorKind, device: &str) -> anyhow::Result<Recorded> {
    let sweeps = sweeps(bench, actuator)?;
    let mut kept: Vec<Kept> = Vec::new();
    for sweep in &sweeps {
        let own = sweep.file.get("device").filter(|own| *own == device);
        let Some(sweep) = own.and_then(|_| kept_sweep(sweep)) else {
            bail!(
                "sweep {} of the {} is of another device than {device}, and a calibration is of one: characterise in a study of its \
                 own (`zwidth new`), and copy its calibration.toml here",
                sweep.sweep,
                actuator.as_str()
            );
        };
        kept.push(sweep);
    }
    let rested_s = sweeps
        .last()
        .and_then(|sweep| days_since(sweep.file.get("utc")?))
        .map_or(0.0, |days| days * DAY_S);
    Ok(Recorded { kept, rested_s })
}

/// The lines that are typed; each raises `beat`: a key that is held down repeats.
fn typed(beat: Arc<AtomicBool>) -> Receiver<String> {
    let (lines, typed) = channel();
    // Nothing joins it: it waits for a key, and ends with the program.
    thread::spawn(move || {
        for line in stdin().lock().lines() {
            let Ok(line) = line else { break };
            beat.store(true, Ordering::Relaxed);
            if lines.send(line).is_err() {
                break;
            }
        }
    });
    typed
}

/// Somebody at the bench, who reads what is said and types.
struct AtBench<'a> {
    lines: Receiver<String>,
    stop: Arc<AtomicBool>,
    screen: &'a Screen,
    /// A key was held down since the last question.
    held: bool,
}

impl Operator for AtBench<'_> {
    fn ask(&mut self, ask: &Ask) -> Reply {
        if std::mem::take(&mut self.held) && stdin().is_terminal() {
            // What a held key has typed answers no other question.
            while self.lines.recv_timeout(HELD).is_ok() {}
        }
        self.screen.say(format!("{} (q ends)", words(ask)));
        loop {
            if self.stop.load(Ordering::Relaxed) {
                return Reply::Quit;
            }
            match self.lines.recv_timeout(Duration::from_millis(100)) {
                Ok(line) if line.trim() == "q" => return Reply::Quit,
                Ok(line) if line.trim().is_empty() => {
                    self.held = matches!(ask, Ask::Sweep { .. } | Ask::Walls { .. });
                    return Reply::Go;
                }
                Ok(line) => self.screen.say(format!("{:?} is no answer: Enter, or q", line.trim())),
                Err(RecvTimeoutError::Timeout) => {}
                // Who cannot answer has not consented.
                Err(RecvTimeoutError::Disconnected) => return Reply::Quit,
            }
        }
    }

    fn tell(&mut self, remark: &Remark) {
        match told(remark) {
            (true, text) => self.screen.warn(text),
            (false, text) => self.screen.say(text),
        }
    }

    fn wrote(&mut self, path: &Path) {
        self.screen.result(path.display().to_string());
    }
}

/// What a person is asked to do.
fn words(ask: &Ask) -> String {
    match ask {
        Ask::Home => "Hold the lever still against its lower stop, and press Enter".to_owned(),
        Ask::Zero => "Let nothing touch the load cell, and press Enter".to_owned(),
        Ask::Mass(mass_kg) => format!(
            "Hang {mass_kg} kg from the load cell, so that it pulls towards the upper stop, while the lever is held where it is; \
             wait until it hangs still, and press Enter"
        ),
        Ask::Clamp => {
            "Move the lever to its fixture, clamp it against the load cell, and press Enter"
                .to_owned()
        }
        Ask::Back => {
            "Bring the lever back to its lower stop without lifting it off, and press Enter"
                .to_owned()
        }
        Ask::Up => {
            "Move the lever against its upper stop, hold it there, and press Enter".to_owned()
        }
        Ask::Hang(for_s) => format!(
            "Leave the last mass hanging for {for_s:.0} s: nothing may touch it. Press Enter"
        ),
        Ask::Sweep { ramp, number, of } if ramp.actuator == ActuatorKind::Motor => format!(
            "Sweep {number} of {of}: the motor goes to {} V and back in {} s. Take your hands off the lever. Press Enter and HOLD IT \
             DOWN: if you let go, the motor goes to 0 V",
            ramp.top_v, ramp.lasts_s
        ),
        Ask::Sweep { ramp, number, of } => format!(
            "Sweep {number} of {of}: the brake goes to {} V and back in {} s. Press Enter, and push the lever through its load cell, \
             evenly, to the upper stop, for all of this time",
            ramp.top_v, ramp.lasts_s
        ),
        Ask::Middle => {
            "Carry the lever to the middle of its work space, let go of it, and press Enter"
                .to_owned()
        }
        Ask::Walls { probe, number, of } => format!(
            "Search {number} of {of}: {} with B = {} N s/m, pushes of {} mm. Take your hands off the lever: it moves by itself, and in \
             the end it swings. Press Enter and HOLD IT DOWN: if you let go, it goes to 0 V",
            probe.mode.as_str(),
            probe.damping_ns_per_m,
            1e3 * probe.push_m
        ),
        Ask::GoOn => "Mend it, and press Enter to go on; the lever is homed again".to_owned(),
    }
}

/// What is told, and whether it is a warning.
fn told(remark: &Remark) -> (bool, String) {
    match remark {
        Remark::Cell { cell, newtons_per_count } => {
            let found = format!(
                "load cell: {:.3} N shown per newton (± {:.3}), zero {:.3} N, noise {:.4} N",
                cell.scale, cell.scale_error, cell.zero_n, cell.noise_n
            );
            match newtons_per_count {
                None => (false, found),
                Some(newtons) => (
                    true,
                    format!(
                        "{found}. The sweeps are corrected by this; for sessions write newtons_per_count = {newtons:e} into rig.toml"
                    ),
                ),
            }
        }
        Remark::CellFault(fault) => (true, fault.to_string()),
        Remark::LeverElsewhere => {
            (true, "the lever still moves, or is not where it is to be".to_owned())
        }
        Remark::Cooling(pause_s) => (false, format!("the winding cools for {pause_s:.0} s")),
        Remark::Kept(judged) => {
            let full = if judged.is_full { "; it gives no more at the highest voltages" } else { "" };
            (
                false,
                format!(
                    "kept: {:.4} N/V, up to {:.2} N, {:.3} N between both ways{full}",
                    judged.gain_n_per_v, judged.largest_n, judged.hysteresis_n
                ),
            )
        }
        Remark::SweepFault(fault) => (true, format!("this sweep does not count: {fault}")),
        Remark::Odd([own, others]) => (
            true,
            format!(
                "this sweep does not agree with those before ({own:.4} N/V, they {others:.4} N/V): it is repeated"
            ),
        ),
        Remark::OddLeftOut => {
            (false, "the repeat agrees with those before: the odd sweep is left out".to_owned())
        }
        Remark::Changed => (
            true,
            "the repeat agrees with the odd sweep: something has changed, and both are kept; look at the figure"
                .to_owned(),
        ),
        Remark::Unwatched => {
            (true, "nobody held Enter down, so the motor went to 0 V: this does not count".to_owned())
        }
        Remark::Found(_, found) => {
            let (low, high) = found.bracket();
            let upper = high.map_or("; none swung".to_owned(), |high| format!(" to {high:.0}"));
            (false, format!("kept: the stiffest wall {low:.0}{upper} N/m ({})", found.ending.as_str()))
        }
        Remark::Loose => (
            true,
            "the lever came off its clamp, so the voltage went to 0 V: clamp it anew".to_owned(),
        ),
        Remark::HeldBack => (
            true,
            "the lever has not moved since it was homed, so nothing says that its angle sensor works: home again, then move it to \
             its fixture"
                .to_owned(),
        ),
        Remark::Stopped(why) => (true, format!("stopped at 0 V: {why}")),
    }
}
