//! Serial ports, and pairs of ends that behave like one.

use crate::Wire;
use serialport::SerialPort;
#[cfg(unix)]
use serialport::TTYPort;
use std::io::{self, Read, Write};
use std::path::Path;
#[cfg(unix)]
use std::path::PathBuf;
use std::time::Duration;
use zwidth_device::DeviceError;

/// A write is given up after this long: the other end takes nothing.
const WRITE: Duration = Duration::from_millis(20);

/// An open serial port.
pub struct Serial(Box<dyn SerialPort>);

impl Serial {
    /// Opens a port.
    ///
    /// # Errors
    /// A port that is not there, or that somebody else has.
    pub fn open(port: &Path, baud: u32) -> Result<Self, DeviceError> {
        let name = port.to_string_lossy();
        let opened = serialport::new(name.clone(), baud).timeout(WRITE).open();
        opened.map(Self).map_err(|e| DeviceError::Unable {
            device: format!("rig at {name}"),
            what: format!("the port cannot be opened: {e}"),
            remedy: "plug the board in, name its port with --device rig:PORT, and close what else uses it".to_owned(),
        })
    }
}

impl Wire for Serial {
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        self.0.set_timeout(wait)?;
        match self.0.read(into) {
            Ok(0) => Err(io::Error::from(io::ErrorKind::UnexpectedEof)),
            Err(e) if e.kind() == io::ErrorKind::TimedOut => Ok(0),
            came => came,
        }
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.set_timeout(WRITE)?;
        self.0.write_all(bytes)
    }
}

/// Our end of a line whose other end looks like a serial port to whoever opens it: a
/// pseudo-terminal.
#[cfg(unix)]
pub struct Pair {
    ours: Serial,
    port: PathBuf,
    /// Kept open: without anybody at it a pseudo-terminal is gone.
    _theirs: TTYPort,
}

#[cfg(unix)]
impl Pair {
    /// A new line.
    ///
    /// # Errors
    /// A system that gives none.
    pub fn open() -> io::Result<Self> {
        let (ours, theirs) = TTYPort::pair()?;
        let port = theirs.name().unwrap_or_default().into();
        Ok(Self { ours: Serial(Box::new(ours)), port, _theirs: theirs })
    }

    /// What the other end is called.
    pub fn port(&self) -> &Path {
        &self.port
    }
}

#[cfg(unix)]
impl Wire for Pair {
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        self.ours.receive(into, wait)
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.ours.send(bytes)
    }
}
