//! A rig by its settings, over whatever link they name.

use crate::stream::{Cell, Stream};
use crate::talk::Talk;
use crate::{Link, Rig, Serial, Settings, Wire, firmata, text};
use std::path::Path;
use zwidth_device::{Device, DeviceError};
use zwidth_study::EnvironmentId;

/// Opens the ports of a rig and asks who is there. `port`: in the place of the settings' own;
/// `environments`: the study's, in its order.
///
/// # Errors
/// Settings that make no sense; no port; no board, or one that cannot do what is needed.
pub fn open(
    port: Option<&Path>,
    settings: &Settings,
    environments: Vec<EnvironmentId>,
) -> Result<Box<dyn Device>, DeviceError> {
    settings.check()?;
    let port = port.or(settings.port.as_deref()).ok_or_else(|| DeviceError::Unable {
        device: "rig".to_owned(),
        what: "no port is named".to_owned(),
        remedy: "`zwidth ports` lists the ports that there are: name one with --device rig:PORT, or as port in rig.toml".to_owned(),
    })?;
    let wire = Serial::open(port, settings.baud())?;
    let cell = settings.hx711.as_ref().filter(|_| settings.link != Link::Framed);
    let cell = cell.map(|cell| Serial::open(&cell.port, cell.baud)).transpose()?;
    over(wire, cell, settings, environments)
}

/// A rig over wires that are there: the board's, and the load cell's where it has one of its own.
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
    let Some(talk) = talk(settings)? else {
        return Ok(Box::new(Rig::connect(wire, settings.clone(), environments)?));
    };
    let cell = cell.zip(settings.hx711.as_ref());
    let cell = cell.map(|(wire, settings)| Cell::new(wire, settings)).transpose()?;
    Ok(Box::new(Stream::connect(wire, cell, talk, settings.clone(), environments)?))
}

/// The host's end of a link that streams; none of frames.
pub(crate) fn talk(settings: &Settings) -> Result<Option<Box<dyn Talk>>, DeviceError> {
    Ok(match (settings.link, &settings.firmata, &settings.text) {
        (Link::Firmata, Some(pins), _) => Some(Box::new(firmata::host::Host::new(settings, pins)?)),
        (Link::Text, _, Some(sketch)) => Some(Box::new(text::Host::new(settings, sketch)?)),
        _ => None,
    })
}
