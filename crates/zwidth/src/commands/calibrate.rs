//! The calibration of a rig, once motor and brake are swept.

use super::device::Bench;
use crate::screen::Screen;
use anyhow::{Context as _, anyhow};
use std::path::{Path, PathBuf};
use zwidth_rig::{CalibratedActuator, calibrated_actuator};
use zwidth_store::{Raw, Sweep, read_sweep, write_new};
use zwidth_study::{ActuatorId, ActuatorKind, CalibrationFile, CalibrationOrigin};

/// The sweeps of an actuator that a study has.
pub(super) fn sweeps(bench: &Bench, actuator: ActuatorKind) -> anyhow::Result<Vec<Sweep>> {
    let id: ActuatorId = actuator.as_str().parse()?;
    let mut sweeps = Vec::new();
    for number in 1.. {
        let path = bench.layout.sweep(&id, number);
        if !path.exists() {
            break;
        }
        sweeps.push(read_sweep(&path).map_err(|e| anyhow!("{e}"))?);
    }
    Ok(sweeps)
}

/// Writes the calibration that follows from the sweeps of both actuators at this device; without
/// the other's sweeps it says that they are missing. One that is there already stays.
pub(super) fn calibrate(
    bench: &Bench,
    device: &str,
    raw: &Raw,
    screen: &Screen,
) -> anyhow::Result<()> {
    let motor = sweeps(bench, ActuatorKind::Motor)?;
    let brake = sweeps(bench, ActuatorKind::Brake)?;
    for (name, sweeps) in [("motor", &motor), ("brake", &brake)] {
        if sweeps.is_empty() {
            screen.say(format!(
                "no calibration yet: sweep the {name} too (`zwidth characterise {} {name} …`)",
                bench.layout.study()
            ));
            return Ok(());
        }
    }
    let level = bench.study.analysis.confidence;
    let found = |actuator: ActuatorKind, sweeps: &[Sweep]| {
        let found = calibrated_actuator(actuator, sweeps, level)
            .with_context(|| format!("no calibration of the {}", actuator.as_str()))?;
        tell(actuator, &found, screen);
        anyhow::Ok(found)
    };
    let utc = motor.iter().chain(&brake).filter_map(|sweep| sweep.file.get("utc")).max();
    let motor = found(ActuatorKind::Motor, &motor)?;
    let brake = found(ActuatorKind::Brake, &brake)?;
    let file = CalibrationFile {
        motor: motor.characteristic,
        brake: brake.characteristic,
        origin: Some(CalibrationOrigin {
            utc: utc.cloned().unwrap_or_default(),
            device: device.to_owned(),
            level,
            motor: motor.interval,
            brake: brake.interval,
        }),
    };
    let text = file.to_toml()?;
    // Sessions would refuse what cannot be read: an error here, not there.
    CalibrationFile::from_toml(&text)?;
    let path = bench.layout.raw().join("calibration.toml");
    if !path.exists() {
        write_new(raw, &path, text.as_bytes())?;
        screen.result(path.display().to_string());
        return Ok(());
    }
    beside(&path, &text, raw, screen)
}

/// The calibration in force is that of sessions that were begun: it is never written over.
fn beside(path: &Path, text: &str, raw: &Raw, screen: &Screen) -> anyhow::Result<()> {
    let folder = path.parent().unwrap_or(path);
    let other = free_name(folder, "calibration", "toml")?;
    write_new(raw, &other, text.as_bytes())?;
    screen.result(other.display().to_string());
    screen.warn(format!(
        "{} stays in force, because sessions may have begun with it; to record with the new one, put {} in its place",
        path.display(),
        other.display()
    ));
    Ok(())
}

/// `name.extension` in a folder, or `name.2.extension` and so on: the first that is not there.
pub(super) fn free_name(folder: &Path, name: &str, extension: &str) -> anyhow::Result<PathBuf> {
    let first = std::iter::once(folder.join(format!("{name}.{extension}")));
    let others = (2..).map(|number: u32| folder.join(format!("{name}.{number}.{extension}")));
    let free = first.chain(others).find(|path| !path.exists());
    free.with_context(|| format!("there are too many files {name}.*.{extension}; remove some"))
}

fn tell(actuator: ActuatorKind, found: &CalibratedActuator, screen: &Screen) {
    let CalibratedActuator { characteristic, interval, reason } = found;
    let last = characteristic.force_n.len() - 1;
    screen.say(format!(
        "{}: {:.2} N at {:.1} V ({:.2} to {:.2} N), by {} sweeps; {reason}",
        actuator.as_str(),
        characteristic.force_n[last],
        characteristic.voltage_v[last],
        interval.low_n[last],
        interval.high_n[last],
        interval.sweeps,
    ));
}
