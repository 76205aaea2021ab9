//! `zwidth characterise STUDY impedance`: which stiffness and damping of a wall the device renders.
//!
//! Each search is a sweep of its own, written when it ends, so an interrupted test continues where
//! it stopped; figure and tables are made from all of them.

use super::bench::{BenchArgs, NO_WATCHDOG, carry_out, open_rig, settings, winding};
use super::device::Bench;
use super::output::Output;
use super::recover::now;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::{Context as _, anyhow, bail};
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;
use zwidth_device::{COUNTS_PER_TURN, Guard, Limits, SHAFT_PER_LEVER, TwinParameters};
use zwidth_dynamics::{DriveMode, PushedWall, SampledWall};
use zwidth_results::WallBound;
use zwidth_rig::{Left, WallPlan, WallSearch, Walls, search_of, search_sweep};
use zwidth_stability::impedance::{
    ACTUATOR, Found, Probe, Region, Response, bounds, impedance_points, probes, regions, search,
    z_widths, z_widths_table,
};
use zwidth_store::{Raw, StudyData, hex_blake3, read_sweep, record_sweep};
use zwidth_study::{ActuatorId, ActuatorKind, Mode, Source, Study, Voltages};
use zwidth_tables::Table;

/// Pushes, m.
const PUSHES_M: [f64; 2] = [5e-3, 1e-3];
/// Dampings of the wall, N s/m.
const DAMPINGS: [f64; 8] = [0.0, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0];
/// Searches of each.
const REPEATS: u32 = 3;
/// How long a push is followed, s.
const FOLLOWED_S: f64 = 3.3;
/// How far a release misses the intended push, as a share of it.
const MISSES: f64 = 0.01;
const MODES: [DriveMode; 3] = [DriveMode::Active, DriveMode::Hybrid, DriveMode::Passive];
/// At a rig each search takes a minute: those that a free lever can tell apart.
const RIG_MODES: [DriveMode; 2] = [DriveMode::Active, DriveMode::Hybrid];
const RIG_DAMPINGS: [f64; 4] = [0.0, 2.0, 4.0, 8.0];
/// What the files of the simulated device call it.
const TWIN: &str = "twin";
const SYNTHETIC: &str = "SYNTHETIC: the simulated device, not measured";

/// Makes what searches are still to be made, and figure and tables of all.
pub(super) fn impedance(
    root: &Path,
    bench: &Bench,
    raw: &Raw,
    seed: u64,
    screen: &Screen,
) -> anyhow::Result<()> {
    let id: ActuatorId = ACTUATOR.parse()?;
    let modes: Vec<DriveMode> =
        MODES.into_iter().filter(|mode| mode_of(&bench.study, *mode).is_some()).collect();
    if modes.is_empty() {
        bail!(
            "no mode of the study uses an actuator; give a mode motor_max_v or brake_max_v in study.toml"
        );
    }
    let probes = probes(&modes, &PUSHES_M, &DAMPINGS, REPEATS);
    let bar = screen.bar(probes.len());
    let mut searches = Vec::new();
    let mut before = 0;
    // A search's place in this list is the number of its sweep, by which one that exists is
    // skipped: with another order some would be made twice, and others never.
    for (number, probe) in (1..).zip(probes) {
        let path = bench.layout.sweep(&id, number);
        bar.set_message(words(&probe));
        if path.exists() {
            searches.push(recorded(&path, TWIN)?);
            before += 1;
        } else {
            let outcome = search_on_twin(bench, &probe, seed, number)?;
            let sweep = search_sweep(&probe, &outcome, number, Source::Twin, about(bench, seed))?;
            record_sweep(raw, &bench.layout, &now(), &sweep)?;
            searches.push((probe, outcome));
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if before > 0 {
        screen.say(format!("{before} of {} searches were there", searches.len()));
    }
    write(root, bench, &regions(&searches), &linear(bench)?, Source::Twin, screen)
}

fn words(probe: &Probe) -> String {
    let mode = probe.mode.as_str();
    let push_mm = 1e3 * probe.push_m;
    format!("{mode}, push {push_mm} mm, B {} N s/m, {}", probe.damping_ns_per_m, probe.repeat)
}

/// One search on the simulated device, whose counts begin anywhere and whose pushes miss a little.
fn search_on_twin(bench: &Bench, probe: &Probe, seed: u64, number: u32) -> anyhow::Result<Found> {
    let number = u64::from(number);
    let device = device(bench, probe, share(seed, number, 1));
    let push_m = probe.push_m * (1.0 + MISSES * (2.0 * share(seed, number, 2) - 1.0));
    let device = PushedWall { push_m, ..device };
    let ticks = (FOLLOWED_S / device.wall.period_s) as usize;
    search(|stiffness| device.with_stiffness(stiffness).push(ticks)).with_context(|| words(probe))
}

/// A share of 1 that follows from three numbers (SplitMix64's mixing).
fn share(seed: u64, number: u64, what: u64) -> f64 {
    let mut z = seed ^ (number << 8 | what).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    // The upper 53 bits: as many as an f64 holds without rounding.
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// The simulated device against a wall.
fn device(bench: &Bench, probe: &Probe, count_zero: f64) -> PushedWall {
    let (twin, lever_m) = (&bench.twin, bench.twin.lever_m);
    let wall = bare(twin, 1.0 / bench.study.control.rate_hz);
    let kinetic_n = twin.friction_static_n * twin.friction_kinetic_share;
    let [motor_v, brake_v] = mode_of(&bench.study, probe.mode).map(highest).unwrap_or_default();
    PushedWall {
        wall: SampledWall { wall_damping_ns_per_m: probe.damping_ns_per_m, ..wall },
        static_n: twin.friction_static_n,
        kinetic_n,
        motor_n: twin.actuators.motor.force_n(motor_v).abs(),
        brake_n: twin.actuators.brake.force_n(brake_v).abs(),
        mode: probe.mode,
        count_m: count_m(lever_m),
        count_zero,
        push_m: probe.push_m,
    }
}

/// The study's mode that uses the same actuators.
fn mode_of(study: &Study, mode: DriveMode) -> Option<&Mode> {
    study.modes.iter().find(|own| {
        let [motor, brake] = [ActuatorKind::Motor, ActuatorKind::Brake].map(|kind| own.has(kind));
        motor == (mode != DriveMode::Passive) && brake == (mode != DriveMode::Active)
    })
}

/// Highest voltages of motor and brake, V; 0 of one that is not used.
fn highest(mode: &Mode) -> [f64; 2] {
    [mode.motor_max_v, mode.brake_max_v].map(|volts| volts.unwrap_or(0.0))
}

/// The device alone, without friction.
pub(super) fn bare(twin: &TwinParameters, period_s: f64) -> SampledWall {
    let plant = twin.plant(None);
    let lever_m = twin.lever_m;
    let viscous = twin.friction_viscous_ns_per_rad + plant.back_emf_ns_per_rad.unwrap_or(0.0);
    SampledWall::bare(plant.inertia_kg_m2 / (lever_m * lever_m), viscous / lever_m, period_s)
}

/// What one count of the angle is at the lever's end, m.
pub(super) fn count_m(lever_m: f64) -> f64 {
    TAU / f64::from(COUNTS_PER_TURN) / SHAFT_PER_LEVER * lever_m
}

/// What the file of a search on the simulated device says of itself.
fn about(bench: &Bench, seed: u64) -> BTreeMap<String, String> {
    let mut about = vec![
        ("study_blake3", hex_blake3(&bench.study_toml)),
        ("device", TWIN.to_owned()),
        ("software", super::acquire::SOFTWARE.to_owned()),
    ];
    // The orders of a blinded study may be drawn with the same seed.
    if !bench.study.design.blinded {
        about.push(("seed", seed.to_string()));
    }
    about.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// The search that a file holds, if it is of this device: those of two would make one boundary.
fn recorded(path: &Path, device: &str) -> anyhow::Result<(Probe, Found)> {
    let sweep = read_sweep(path).map_err(|e| anyhow!("{e}"))?;
    let owner = sweep.file.get("device").map_or("an unknown device", String::as_str);
    if owner != device {
        bail!(
            "search {} is of {owner}, and this one would be of {device}: test each device in a study of its own (`zwidth new`)",
            path.display()
        );
    }
    search_of(&sweep).map_err(|key| {
        anyhow!(
            "sweep {} is damaged ({key} cannot be read); restore it from a copy, or remove it and run again",
            path.display()
        )
    })
}

/// Every search that is there.
fn all_recorded(
    bench: &Bench,
    id: &ActuatorId,
    device: &str,
) -> anyhow::Result<Vec<(Probe, Found)>> {
    let paths = (1..).map(|number| bench.layout.sweep(id, number)).take_while(|path| path.exists());
    paths.map(|path| recorded(&path, device)).collect()
}

/// Searches walls at a rig, guided step by step; goes on where it was left.
pub(super) fn impedance_at_rig(
    root: &Path,
    bench: &Bench,
    command: &BenchArgs,
    raw: &Raw,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let id: ActuatorId = ACTUATOR.parse()?;
    let device = open_rig(bench, command, screen)?;
    let name = device.capabilities().name.clone();
    let Some(lever_m) = bench.study.device.lever_m else {
        bail!("a wall has its stiffness at the lever's end: give device.lever_m in study.toml");
    };
    let modes: Vec<DriveMode> =
        RIG_MODES.into_iter().filter(|mode| mode_of(&bench.study, *mode).is_some()).collect();
    if modes.is_empty() {
        bail!(
            "no mode of the study uses the motor, and a free lever never swings by a brake alone"
        );
    }
    let repeats = command.sweeps.unwrap_or(REPEATS);
    let limits = Limits::of(&bench.study)?;
    let guard = Guard::new(device.capabilities(), limits, command.no_watchdog);
    let winding = winding(settings(bench)?, true);
    let mut searches = Vec::new();
    let found = all_recorded(bench, &id, &name)?;
    for probe in probes(&modes, &PUSHES_M, &RIG_DAMPINGS, repeats) {
        // By what it searched and not by its number: another --sweeps, or another mode, has another order.
        if found.iter().any(|(other, _)| *other == probe) {
            continue;
        }
        let mode = mode_of(&bench.study, probe.mode).context("the study has no such mode")?;
        guard.admit(mode, &bench.calibration)?;
        let [motor_v, brake_v] = highest(mode);
        if !winding.bears(motor_v * motor_v * FOLLOWED_S) {
            bail!(
                "a push of {FOLLOWED_S} s at {motor_v} V would warm the motor's winding by more than is allowed: give mode {} a lower \
                 motor_max_v, or correct [heat] in rig.toml",
                mode.id
            );
        }
        searches.push(WallSearch { probe, most: Voltages { motor_v, brake_v } });
    }
    if device.capabilities().watchdog_s.is_none() {
        screen.warn(NO_WATCHDOG);
    }
    let (done, all) = (found.len(), found.len() + searches.len());
    let mut walls = Walls::new(WallPlan {
        searches,
        done,
        lasts_s: FOLLOWED_S,
        lever_m,
        count_m: device.capabilities().counts_per_turn.map_or(0.0, |counts| {
            TAU / f64::from(counts) / device.capabilities().shaft_per_lever * lever_m
        }),
        winding,
        stops_rad: [limits.theta_min_rad, limits.theta_max_rad],
    });
    if done > 0 {
        screen.say(format!("{done} of {all} searches are there"));
    }
    let source = device.capabilities().source;
    let left = carry_out(bench, command, device, limits.force_n, &mut walls, raw, screen)?;
    let found = all_recorded(bench, &id, &name)?;
    if !found.is_empty() {
        // The limit of large pushes is known of a device whose mass and damping are.
        write(root, bench, &regions(&found), &[], source, screen)?;
    }
    if left == Left::Open {
        screen.warn(format!(
            "{} of {all} searches are there; the same command goes on",
            walls.done()
        ));
        return Ok(Exit::Partly);
    }
    Ok(Exit::Fine)
}

fn write(
    root: &Path,
    bench: &Bench,
    regions: &[Region],
    linear: &[[f64; 2]],
    source: Source,
    screen: &Screen,
) -> anyhow::Result<()> {
    let study = bench.layout.study();
    let folder = root.join("reports").join(study.as_str()).join("impedance");
    let is_twin = source == Source::Twin;
    let made_from = [
        ("source", if is_twin { SYNTHETIC } else { "measured at a rig" }.to_owned()),
        ("study", study.to_string()),
        ("version", zwidth_stability::VERSION.to_string()),
    ];
    let mut output = Output::new(&folder, made_from);
    let bounds = bounds(regions);
    let notes = [
        "Lever let go of at rest, a push deep in a bilateral wall; a wall is rendered if the swings end. Bars: repeats. \
         ≥: an actuator saturated first, or no wall of up to 50 kN/m swung."
            .to_owned(),
    ];
    output.figure("impedance", zwidth_figures::impedance(&bounds, linear, &notes, is_twin))?;
    output.table("impedance", &Table::of_rows(&bounds)?)?;
    output.table("zwidth", &z_widths_table(&z_widths(regions))?)?;
    let frequencies = frequency(bench, &mut output, screen)?;
    let lines: Vec<String> = regions.iter().map(region_line).collect();
    screen.give(&lines, || {
        lines.iter().chain(&frequencies).for_each(|line| screen.result(line));
        screen.files(&output.files, &["png"], "");
    })
}

/// Impedance against frequency, where the study's recorded trials tell it; one line per
/// condition.
fn frequency(bench: &Bench, output: &mut Output, screen: &Screen) -> anyhow::Result<Vec<String>> {
    let data =
        StudyData::load(&bench.layout).map_err(|findings| super::join_findings(&findings))?;
    let responses = zwidth_plan::responses(&data).map_err(|e| anyhow!("{e}"))?;
    responses.problems.iter().for_each(|problem| screen.warn(problem));
    if responses.responses.is_empty() {
        return Ok(Vec::new());
    }
    let points: Vec<_> = responses
        .responses
        .iter()
        .flat_map(|([environment, mode], response)| impedance_points(environment, mode, response))
        .collect();
    let notes = [
        "Force over velocity at the lever's end, H1; Hann windows that overlap by half, all trials that count. Bands: \
         intervals. Dotted: coherence that chance alone stays below; |Z| and phase are drawn where it is exceeded. A \
         mass has +90°, a damper 0°, a spring −90°. Friction, counts and brakes are not linear."
            .to_owned(),
    ];
    let mark = zwidth_figures::mark(responses.sources);
    output.figure("frequency", zwidth_figures::impedance_frequency(&points, &notes, mark))?;
    output.table("frequency", &Table::of_rows(&points)?)?;
    let lines = responses
        .responses
        .iter()
        .map(|([environment, mode], response)| response_line(environment, mode, response));
    Ok(lines.collect())
}

fn response_line(environment: &str, mode: &str, response: &Response) -> String {
    let above: Vec<f64> = response
        .points
        .iter()
        .filter(|point| point.coherence > response.chance)
        .map(|point| point.frequency_hz)
        .collect();
    let range = match (above.first(), above.last()) {
        (Some(first), Some(last)) => format!(
            "coherent at {} of {} frequencies from {first:.1} to {last:.1} Hz",
            above.len(),
            response.points.len()
        ),
        _ => "nowhere coherent".to_owned(),
    };
    format!(
        "{environment}, {mode}: impedance against frequency, {} segments: {range}",
        response.segments
    )
}

/// The boundary of the lifted map, (B, K): the limit of large pushes.
fn linear(bench: &Bench) -> anyhow::Result<Vec<[f64; 2]>> {
    /// Points between two dampings.
    const FINE: usize = 8;
    let wall = bare(&bench.twin, 1.0 / bench.study.control.rate_hz);
    let end = DAMPINGS[DAMPINGS.len() - 1];
    let count = FINE * (DAMPINGS.len() - 1);
    let mut boundary = Vec::new();
    for i in 0..=count {
        let damping = end * i as f64 / count as f64;
        let wall = SampledWall { wall_damping_ns_per_m: damping, ..wall };
        boundary.push([damping, wall.stiffest_stable()?.unwrap_or(f64::NAN)]);
    }
    Ok(boundary)
}

fn region_line(region: &Region) -> String {
    let [area, low, high] = region.area();
    let least = if region.is_censored() { "≥ " } else { "" };
    format!(
        "{}, push {} mm: K(0) {} N/m, largest K {} N/m at B = {} N s/m, area {least}{area:.0} ({low:.0} to {high:.0}) N²·s/m² \
         over B from 0 to {}",
        region.mode.as_str(),
        1e3 * region.push_m,
        stiffness_words(region.undamped()),
        stiffness_words(region.stiffest()),
        region.stiffest().map_or(0.0, |bound| bound.damping_ns_per_m),
        region.end_ns_per_m(),
    )
}

fn stiffness_words(bound: Option<&WallBound>) -> String {
    bound.map_or("none".to_owned(), |bound| {
        let least = if bound.is_censored { "≥ " } else { "" };
        format!("{least}{:.0}", bound.stiffness_n_per_m)
    })
}
