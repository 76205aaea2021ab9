//! A rig by its settings, over the link that they name.

use crate::stream::{Cell, Stream};
use crate::{Process, Rig, Serial, Settings, Wire};
use std::path::Path;
use zwidth_device::{Device, DeviceError};
use zwidth_study::EnvironmentId;

/// Opens the ports of a rig and asks the board to identify itself. `port` replaces that of the
/// settings; `environments`: the study's, in its order.
///
/// # Errors
/// Settings that make no sense; no port; no board, or one that cannot do what is needed.
pub fn open(
    port: Option<&Path>,
    settings: &Settings,
    environments: Vec<EnvironmentId>,
) -> Result<Box<dyn Device>, DeviceError> {
    settings.check()?;
    if let Some(program) = settings.program()? {
        return by_program(port, program, settings, environments);
    }
    let port = port.or(settings.port.as_deref()).ok_or_else(|| DeviceError::Unable {
        device: "rig".to_owned(),
        what: "no port is named".to_owned(),
        remedy: "`zwidth ports` lists the ports that there are: name one with --device rig:PORT, or as port in rig.toml".to_owned(),
    })?;
    let streams = settings.streams()?.is_some();
    let wire = Serial::open(port, settings.baud())?;
    // A board that is asked for readings sends the force with them.
    let cell = settings.hx711.as_ref().filter(|_| streams);
    let cell = cell.map(|cell| Serial::open(&cell.port, cell.baud)).transpose()?;
    over(wire, cell, settings, environments)
}

/// A device that is a program: what it is called is in its settings.
fn by_program(
    port: Option<&Path>,
    program: &Process,
    settings: &Settings,
    environments: Vec<EnvironmentId>,
) -> Result<Box<dyn Device>, DeviceError> {
    if let Some(port) = port {
        return Err(DeviceError::Unable {
            device: format!("rig at {}", port.display()),
            what: "link in rig.toml is \"process\", and a program has no port".to_owned(),
            remedy: "leave the port out: --device rig".to_owned(),
        });
    }
    #[cfg(unix)]
    return over(crate::process::Program::start(program)?, None, settings, environments);
    #[cfg(not(unix))]
    Err(DeviceError::Unable {
        device: program.command.join(" "),
        what: "a device by a process needs Linux or macOS".to_owned(),
        remedy: "use a board, or another computer".to_owned(),
    })
}

/// A rig over existing wires: the board's, and the load cell's if it has its own.
///
/// # Errors
/// Those of [`open`].
pub fn over<W: Wire + 'static>(
    wire: W,
    cell: Option<W>,
    settings: &Settings,
    environments: Vec<EnvironmentId>,
) -> Result<Box<dyn Device>, DeviceError> {
    settings.check()?;
    let Some(talk) = settings.host()? else {
        return Ok(Box::new(Rig::connect(wire, settings.clone(), environments)?));
    };
    let cell = cell.zip(settings.hx711.as_ref());
    let cell = cell.map(|(wire, settings)| Cell::new(wire, settings)).transpose()?;
    Ok(Box::new(Stream::connect(wire, cell, talk, settings.clone(), environments)?))
}
