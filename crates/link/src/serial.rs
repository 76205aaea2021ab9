//! Serial ports, and pairs of ends that behave like one.

use crate::Wire;
use serialport::SerialPort;
#[cfg(unix)]
use serialport::TTYPort;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;
use zwidth_device::DeviceError;

/// A write is given up after this long: the other end takes nothing.
const WRITE: Duration = Duration::from_millis(20);

/// A serial port, open until it is gone.
pub struct Serial {
    /// Let go at once when it is gone, so that a board that is plugged in again gets its name
    /// again.
    open: Option<Box<dyn SerialPort>>,
    /// Where it is, and its bits a second; none of a line that cannot be opened again.
    at: Option<(PathBuf, u32)>,
}

impl Serial {
    /// Opens a port.
    ///
    /// # Errors
    /// A port that is not there, or that somebody else has.
    pub fn open(port: &Path, baud: u32) -> Result<Self, DeviceError> {
        let open = open_port(port, baud).map_err(|e| DeviceError::Unable {
            device: format!("rig at {}", port.display()),
            what: format!("the port cannot be opened: {e}"),
            remedy: "plug the board in, name its port with --device rig:PORT (`zwidth ports` lists those that there are), and close what else uses it".to_owned(),
        })?;
        Ok(Self { open: Some(open), at: Some((port.to_owned(), baud)) })
    }

    /// Does something with the port; one that fails at it is gone.
    fn with<T>(&mut self, act: impl FnOnce(&mut dyn SerialPort) -> io::Result<T>) -> io::Result<T> {
        let port = self.open.as_deref_mut().ok_or(io::ErrorKind::NotConnected)?;
        let done = act(port);
        // A port that is only slow stays open.
        if done.as_ref().is_err_and(|e| e.kind() != io::ErrorKind::TimedOut) {
            self.open = None;
        }
        done
    }
}

fn open_port(port: &Path, baud: u32) -> serialport::Result<Box<dyn SerialPort>> {
    serialport::new(port.to_string_lossy(), baud).timeout(WRITE).open()
}

impl Wire for Serial {
    fn receive(&mut self, into: &mut [u8], wait: Duration) -> io::Result<usize> {
        self.with(|port| {
            port.set_timeout(wait)?;
            match port.read(into) {
                Ok(0) => Err(io::Error::from(io::ErrorKind::UnexpectedEof)),
                Err(e) if e.kind() == io::ErrorKind::TimedOut => Ok(0),
                came => came,
            }
        })
    }

    fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.with(|port| {
            port.set_timeout(WRITE)?;
            port.write_all(bytes)
        })
    }

    fn reopen(&mut self) -> io::Result<()> {
        // Closed first: a port has one owner, and a board that comes back wants its old name.
        self.open = None;
        let (port, baud) = self.at.as_ref().ok_or(io::ErrorKind::Unsupported)?;
        self.open = Some(open_port(port, *baud)?);
        Ok(())
    }
}

/// Our end of a line whose other end looks like a serial port: a pseudo-terminal.
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
        Ok(Self { ours: Serial { open: Some(Box::new(ours)), at: None }, port, _theirs: theirs })
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
