//! A board at the other end of a cable: both ends of a socket, in the place of a serial line.

use std::io::{ErrorKind, Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;
use zwidth_device::{
    Angle, Capabilities, Clock as _, Cue, Device, DeviceError, Reading, RealClock, Twin,
};
use zwidth_study::{Study, Voltages};

/// What the host asks for, the first number of a request; the others are the two voltages.
const HOME: f64 = 0.0;
const READ: f64 = 1.0;
const WRITE: f64 = 2.0;
const BEGIN: f64 = 3.0;
/// Numbers of a request, and of its answer: device time, count, age of the count, force, age of the
/// force.
const ASKED: usize = 3;
const TOLD: usize = 5;
/// Bytes of a number.
const BYTES: usize = size_of::<f64>();
/// A board that says nothing for this long is lost.
const SILENT: Duration = Duration::from_secs(1);

fn packed(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

fn unpacked<const N: usize>(bytes: &[u8]) -> [f64; N] {
    let mut numbers = [f64::NAN; N];
    for (number, bytes) in numbers.iter_mut().zip(bytes.as_chunks::<BYTES>().0) {
        *number = f64::from_le_bytes(*bytes);
    }
    numbers
}

/// The host's end.
pub(super) struct Remote {
    capabilities: Capabilities,
    stream: UnixStream,
}

impl Remote {
    pub(super) fn connect(socket: &Path, capabilities: Capabilities) -> anyhow::Result<Self> {
        let stream = UnixStream::connect(socket)?;
        stream.set_read_timeout(Some(SILENT))?;
        Ok(Self { capabilities, stream })
    }

    fn send(&mut self, what: f64, voltages: Voltages) -> Result<(), DeviceError> {
        let request = packed(&[what, voltages.motor_v, voltages.brake_v]);
        self.stream.write_all(&request).map_err(|error| self.lost(&error))
    }

    fn ask(&mut self, what: f64) -> Result<Reading, DeviceError> {
        self.send(what, Voltages::OFF)?;
        let mut bytes = [0; TOLD * BYTES];
        self.stream.read_exact(&mut bytes).map_err(|error| self.lost(&error))?;
        let [t_device_s, counts, angle_age_s, force_n, force_age_s] = unpacked(&bytes);
        Ok(Reading {
            t_device_s: Some(t_device_s),
            angle: Angle::Counts(counts as u16),
            angle_age_s,
            force_n,
            force_age_s: Some(force_age_s),
            extra: zwidth_study::Extra::default(),
        })
    }

    fn lost(&self, error: &std::io::Error) -> DeviceError {
        DeviceError::Lost { device: self.capabilities.name.clone(), what: error.to_string() }
    }
}

impl Device for Remote {
    fn capabilities(&self) -> &Capabilities {
        &self.capabilities
    }

    fn home(&mut self, _now_s: f64) -> Result<Reading, DeviceError> {
        self.ask(HOME)
    }

    fn read(&mut self, _now_s: f64) -> Result<Reading, DeviceError> {
        self.ask(READ)
    }

    fn write(&mut self, _now_s: f64, voltages: Voltages) -> Result<(), DeviceError> {
        self.send(WRITE, voltages)
    }

    fn begin(&mut self, _now_s: f64, _cue: &Cue<'_>) {
        // A cable that is out is found by the read that follows.
        let _ = self.send(BEGIN, Voltages::OFF);
    }
}

/// The board's end: the simulated device, in time of its own.
pub(super) struct Board<'a> {
    study: &'a Study,
    twin: Twin,
    clock: RealClock,
    stream: Option<UnixStream>,
    unread: Vec<u8>,
}

impl<'a> Board<'a> {
    pub(super) fn new(study: &'a Study, twin: Twin, stream: UnixStream) -> anyhow::Result<Self> {
        stream.set_nonblocking(true)?;
        Ok(Self { study, twin, clock: RealClock::new(), stream: Some(stream), unread: Vec::new() })
    }

    /// Whether either actuator has a voltage.
    pub(super) fn is_on(&self) -> bool {
        self.twin.voltages() != Voltages::OFF
    }

    /// Pulls the cable.
    pub(super) fn unplug(&mut self) {
        self.stream = None;
    }

    /// Does what was asked for since the last turn and moves up to now, which it returns, s.
    pub(super) fn turn(&mut self) -> anyhow::Result<f64> {
        self.hear()?;
        let whole = self.unread.len() / (ASKED * BYTES) * (ASKED * BYTES);
        let requests: Vec<u8> = self.unread.drain(..whole).collect();
        for request in requests.chunks(ASKED * BYTES) {
            self.obey(unpacked(request))?;
        }
        let now_s = self.clock.now_s();
        self.twin.read(now_s)?;
        Ok(now_s)
    }

    fn hear(&mut self) -> anyhow::Result<()> {
        let Some(stream) = &mut self.stream else { return Ok(()) };
        match stream.read_to_end(&mut self.unread).map_err(|error| error.kind()) {
            // All there is so far; or all there ever was: the other end is gone, and a serial line
            // would not tell.
            Ok(_) | Err(ErrorKind::WouldBlock | ErrorKind::ConnectionReset) => Ok(()),
            Err(other) => Err(std::io::Error::from(other).into()),
        }
    }

    fn obey(&mut self, [what, motor_v, brake_v]: [f64; ASKED]) -> anyhow::Result<()> {
        let now_s = self.clock.now_s();
        if what == WRITE {
            return Ok(self.twin.write(now_s, Voltages { motor_v, brake_v })?);
        }
        if what == BEGIN {
            let limit_s = self.study.design.trial_limit_s;
            self.twin
                .begin(now_s, &Cue { trial: 1, environment: &self.study.environments[0], limit_s });
            return Ok(());
        }
        let reading = if what == HOME { self.twin.home(now_s)? } else { self.twin.read(now_s)? };
        let t_device_s = reading.t_device_s.unwrap_or(now_s);
        let raw = reading.raw().unwrap_or_default();
        let force_age_s = reading.force_age_s.unwrap_or(0.0);
        let told = packed(&[
            t_device_s,
            f64::from(raw),
            reading.angle_age_s,
            reading.force_n,
            force_age_s,
        ]);
        if let Some(stream) = &mut self.stream {
            // A host that was killed hears nothing, and the board does not mind.
            let _ = stream.write_all(&told);
        }
        Ok(())
    }
}
