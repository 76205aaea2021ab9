//! `zwidth characterise`: sweeps of an actuator, or the Z-width of the device.

use super::bench::{BenchArgs, sensors_at_rig, sweep_at_rig};
use super::device::{Bench, bench};
use super::impedance::{impedance, impedance_at_rig};
use super::recover::{lock, now, put_in_order_and_tell};
use crate::devices::DeviceSpec;
use crate::exit::Exit;
use crate::screen::Screen;
use anyhow::bail;
use clap::ValueEnum;
use std::collections::BTreeMap;
use std::path::Path;
use zwidth_device::{Device as _, Person, SweepPoint, Twin, brake_sweep, motor_sweep};
use zwidth_store::{Quantity, Raw, RealFiles, Sweep, hex_blake3, record_sweep};
use zwidth_study::{ActuatorKind, Source, StudyId};

/// What can be characterised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Subject {
    /// The motor, at a held lever
    Motor,
    /// The brake, at a lever that is driven
    Brake,
    /// The sensors of a rig: its link, the load cell, the angle
    Rig,
    /// The Z-width: which stiffness and damping of a virtual wall the device renders; goes on where
    /// it was left
    Impedance,
}

#[derive(Debug, clap::Args)]
pub(crate) struct CharacteriseArgs {
    /// The study
    pub(crate) study: StudyId,
    /// The actuator, or the impedance of the whole device
    pub(crate) actuator: Subject,
    #[command(flatten)]
    pub(crate) at: BenchArgs,
    /// Seed of the simulated device
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(crate) seed: u64,
}

pub(crate) fn characterise(
    root: &Path,
    command: &CharacteriseArgs,
    screen: &Screen,
) -> anyhow::Result<Exit> {
    let bench = bench(root, command.study.clone(), None)?;
    let lock = lock(&bench.layout, "zwidth characterise")?;
    if matches!(command.at.device, DeviceSpec::Playback(_)) {
        bail!("a recording cannot be characterised; use --device twin or rig");
    }
    let is_rig = matches!(command.at.device, DeviceSpec::Rig(_));
    put_in_order_and_tell(&bench.layout, &lock, screen);
    let raw = Raw::adds(&RealFiles, &bench.layout, &lock);
    let actuator = match command.actuator {
        Subject::Motor => ActuatorKind::Motor,
        Subject::Brake => ActuatorKind::Brake,
        Subject::Rig if is_rig => return sensors_at_rig(&bench, &command.at, &raw, screen),
        Subject::Rig => bail!("the sensors are those of a rig; use --device rig"),
        Subject::Impedance if is_rig => {
            return impedance_at_rig(root, &bench, &command.at, &raw, screen);
        }
        Subject::Impedance => {
            impedance(root, &bench, &raw, command.seed, screen)?;
            return Ok(Exit::Fine);
        }
    };
    if is_rig {
        return sweep_at_rig(&bench, &command.at, actuator, &raw, screen);
    }
    let id = actuator.as_str().parse()?;
    // Earlier sweeps stay: numbering goes on at the first number without a file.
    let first = (1..).find(|number| !bench.layout.sweep(&id, *number).exists()).unwrap_or(u32::MAX);
    for number in first..first.saturating_add(command.at.sweeps.unwrap_or(1)) {
        let software = super::acquire::SOFTWARE;
        let sweep = simulated_sweep(&bench, actuator, command.seed, number, software)?;
        let path = record_sweep(&raw, &bench.layout, &now(), &sweep)?;
        screen.result(path.display().to_string());
    }
    Ok(Exit::Fine)
}

/// One sweep on the twin.
pub(super) fn simulated_sweep(
    bench: &Bench,
    actuator: ActuatorKind,
    seed: u64,
    number: u32,
    software: &str,
) -> anyhow::Result<Sweep> {
    let points: Vec<SweepPoint> = match actuator {
        ActuatorKind::Motor => motor_sweep(&bench.twin, seed, number)?,
        // A brake's force is its level only while it slips.
        ActuatorKind::Brake => {
            brake_sweep(&bench.twin, seed, number)?.into_iter().filter(|p| p.slipping).collect()
        }
    };
    let device =
        Twin::new(bench.twin.clone(), Person::typical(seed), seed)?.capabilities().name.clone();
    let file = [
        ("study_blake3", hex_blake3(&bench.study_toml)),
        ("device", device),
        ("software", software.to_owned()),
    ];
    let mut file = BTreeMap::from(file.map(|(k, v)| (k.to_owned(), v)));
    // The orders of a blinded study may be drawn with the same seed.
    if !bench.study.design.blinded {
        file.insert("seed".to_owned(), seed.to_string());
    }
    Ok(Sweep {
        actuator: actuator.as_str().parse()?,
        sweep: number,
        source: Source::Twin,
        command: Quantity { name: "voltage".to_owned(), unit: "V".to_owned() },
        response: Quantity { name: "force".to_owned(), unit: "N".to_owned() },
        t_s: Some(points.iter().map(|p| p.t_s).collect()),
        command_values: points.iter().map(|p| p.voltage_v).collect(),
        response_values: points.iter().map(|p| p.force_n).collect(),
        file,
    })
}
