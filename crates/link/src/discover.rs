//! Which serial ports there are, and which board is at one of them.
//!
//! A port is asked only if somebody names it, because another device might take a question for a
//! command. The host listens to it first, because a sketch that prints lines takes commands too.

use crate::firmata::Pins;
use crate::firmata::host::Host;
use crate::framed::frame::Frames;
use crate::framed::message::{Description, FromBoard, ToBoard};
use crate::talk::Talk;
use crate::text::Lines;
use crate::{AngleAt, Firmata, Serial, Wire};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;
use zwidth_device::DeviceError;

/// A serial port that the system knows.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Port {
    /// What the system calls it.
    pub path: PathBuf,
    /// The description of the USB device at it.
    pub usb: Option<String>,
}

/// Who is at a port.
#[derive(Debug, Clone, PartialEq)]
pub enum Found {
    /// A board that speaks frames.
    Framed(Description),
    /// A board that speaks Firmata.
    Firmata(Pins),
    /// A sketch that prints lines: one of them.
    Lines(String),
}

/// Asks who is at a wire of so many bits a second.
type Probe = fn(&mut dyn Wire, u32) -> Result<Option<Found>, Fault>;

/// How a port is asked, one after another, and at how many bits a second. Lines come first,
/// because a sketch could take the question of another link for a command.
const PROBES: [(Probe, u32); 4] =
    [(lines, 115_200), (framed, 500_000), (framed, 1_000_000), (firmata, 57_600)];
/// So long each time: many boards begin anew when their port is opened.
const PATIENCE: Duration = Duration::from_secs(3);
const AGAIN_EVERY: Duration = Duration::from_millis(200);
/// Lines in a row that can be read are no accident of another link's bytes.
const LINES: u32 = 3;

/// The bits per second at which a port is asked, in ascending order.
pub fn bauds() -> Vec<u32> {
    let mut bauds: Vec<u32> = PROBES.iter().map(|(_, baud)| *baud).collect();
    bauds.sort_unstable();
    bauds
}

/// The serial ports that there are.
///
/// # Errors
/// A system that does not tell them.
pub fn ports() -> Result<Vec<Port>, DeviceError> {
    let available = serialport::available_ports().map_err(|e| DeviceError::Unable {
        device: "serial ports".to_owned(),
        what: format!("the system does not list them: {e}"),
        remedy: "name the port: --device rig:PORT".to_owned(),
    })?;
    let mut ports: Vec<Port> = available
        .into_iter()
        .map(|port| Port { path: port.port_name.into(), usb: usb(&port.port_type) })
        .collect();
    ports.sort();
    Ok(ports)
}

fn usb(kind: &serialport::SerialPortType) -> Option<String> {
    let serialport::SerialPortType::UsbPort(usb) = kind else { return None };
    let number = usb.serial_number.as_ref().map(|number| format!("serial number {number}"));
    let words = [usb.product.clone(), usb.manufacturer.clone(), number];
    let ids = format!("USB {:04x}:{:04x}", usb.vid, usb.pid);
    Some(words.into_iter().flatten().chain([ids]).collect::<Vec<_>>().join(", "))
}

/// Which board is at a serial port, and at how many bits per second; none, if nothing was
/// understood.
///
/// # Errors
/// A port that cannot be opened, or that goes meanwhile.
pub fn who_is_at(port: &Path) -> Result<Option<(u32, Found)>, DeviceError> {
    who(|baud| Serial::open(port, baud)).map_err(|error| match error {
        Fault::Port(error) => error,
        Fault::Gone(why) => {
            DeviceError::Lost { device: format!("port {}", port.display()), what: why.to_string() }
        }
    })
}

/// Why a port could not be asked.
#[derive(Debug)]
enum Fault {
    Port(DeviceError),
    Gone(io::Error),
}

impl From<io::Error> for Fault {
    fn from(why: io::Error) -> Self {
        Self::Gone(why)
    }
}

/// The first answer of a port, and at how many bits a second it came.
fn who<W: Wire>(
    mut open: impl FnMut(u32) -> Result<W, DeviceError>,
) -> Result<Option<(u32, Found)>, Fault> {
    for (probe, baud) in PROBES {
        let mut wire = open(baud).map_err(Fault::Port)?;
        if let Some(board) = probe(&mut wire, baud)? {
            return Ok(Some((baud, board)));
        }
    }
    Ok(None)
}

/// Asks again and again, and gives each byte to `hear` until one completes an answer.
fn ask<T>(
    wire: &mut dyn Wire,
    question: &[u8],
    mut hear: impl FnMut(u8) -> Option<T>,
) -> Result<Option<T>, Fault> {
    let began = wire.now();
    let mut bytes = [0; 256];
    let mut next_question = began;
    loop {
        let now = wire.now();
        if now - began >= PATIENCE {
            return Ok(None);
        }
        if now >= next_question {
            wire.send(question)?;
            next_question = now + AGAIN_EVERY;
        }
        let came = wire.receive(&mut bytes, next_question - now)?;
        if let Some(answer) = bytes[..came].iter().find_map(|byte| hear(*byte)) {
            return Ok(Some(answer));
        }
    }
}

/// A line that can be read, behind others.
fn lines(wire: &mut dyn Wire, _: u32) -> Result<Option<Found>, Fault> {
    let mut lines = Lines::from_anywhere();
    let mut read = 0;
    ask(wire, &[], |byte| {
        let line = lines.push(byte)?;
        let reads = line.iter().any(u8::is_ascii_digit)
            && line.iter().all(|byte| byte.is_ascii_graphic() || matches!(byte, b' ' | b'\t'));
        read = if reads { read + 1 } else { 0 };
        (read == LINES).then(|| Found::Lines(String::from_utf8_lossy(line).into_owned()))
    })
}

fn framed(wire: &mut dyn Wire, _: u32) -> Result<Option<Found>, Fault> {
    let mut frames = Frames::default();
    let (question, length) = ToBoard::Hello.frame(1).encode();
    ask(wire, &question[..length], |byte| match FromBoard::read(&frames.push(byte)?)? {
        FromBoard::Description(board) => Some(Found::Framed(board)),
        FromBoard::Seen(_) => None,
    })
}

fn firmata(wire: &mut dyn Wire, baud: u32) -> Result<Option<Found>, Fault> {
    // Where nothing is connected yet, nothing of this counts.
    let pins = Firmata {
        rate_hz: 100.0,
        angle: AngleAt::Analog(0),
        motor_pwm: 5,
        motor_direction: 4,
        motor_reversed: false,
        brake_pwm: 6,
        motor_max_v: 1.0,
        brake_max_v: 1.0,
    };
    let mut host = Host::new(&pins, baud).map_err(Fault::Port)?;
    let mut question = Vec::new();
    host.hello(&mut question);
    ask(wire, &question, |byte| {
        host.push(byte);
        host.described().map(Found::Firmata)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulated::Bench;
    use crate::{Board, Link, Settings};
    use std::sync::{Arc, Mutex};
    use zwidth_device::{Device as _, Person, Twin, TwinParameters};

    fn bench(link: Link, angle: AngleAt) -> Bench {
        let twin = Twin::new(TwinParameters::default(), Person::draw(7), 11).unwrap();
        let cell = Path::new("/dev/null");
        let settings = Settings::of_board(link, angle, 100.0, twin.capabilities(), cell);
        let board = Board::by(&settings, twin, zwidth_testing::study().environments).unwrap();
        let baud = settings.baud();
        Bench::new(board, baud, baud, 0.0)
    }

    #[test]
    fn each_board_is_found_at_its_link_and_says_who_it_is() {
        let framed = bench(Link::Framed, AngleAt::I2c);
        let Some((500_000, Found::Framed(board))) = who(|_| Ok(framed.wire())).unwrap() else {
            panic!("no framed board");
        };
        assert!(board.name.contains("twin") && board.watchdog_ms > 0, "{board:?}");

        let firmata = bench(Link::Firmata, AngleAt::I2c);
        let Some((57_600, Found::Firmata(pins))) = who(|_| Ok(firmata.wire())).unwrap() else {
            panic!("no Firmata board");
        };
        assert!(pins.pulses.contains(&5) && pins.i2c && !pins.analog.is_empty(), "{pins:?}");

        let text = bench(Link::Text, AngleAt::I2c);
        let Some((115_200, Found::Lines(line))) = who(|_| Ok(text.wire())).unwrap() else {
            panic!("no lines");
        };
        assert_eq!(line.split(',').count(), 3, "{line}");
    }

    /// Says the same piece every 10 ms of its own time, and keeps what it hears.
    struct Says(&'static [u8], Arc<Mutex<(Duration, Vec<u8>)>>);

    impl Wire for Says {
        fn receive(&mut self, into: &mut [u8], _wait: Duration) -> io::Result<usize> {
            self.1.lock().unwrap().0 += Duration::from_millis(10);
            into[..self.0.len()].copy_from_slice(self.0);
            Ok(self.0.len())
        }

        fn send(&mut self, bytes: &[u8]) -> io::Result<()> {
            self.1.lock().unwrap().1.extend(bytes);
            Ok(())
        }

        fn now(&self) -> Duration {
            self.1.lock().unwrap().0
        }
    }

    #[test]
    fn what_is_no_board_is_nobody_and_a_sketch_is_asked_nothing() {
        for noise in
            [&b""[..], b"\0", b"AT\r\nOK\r\n", b"\xF0\x79\xF7", b"\x81\0\n", b"12\n\xFF7\n"]
        {
            let heard = Arc::default();
            let found = who(|_| Ok(Says(noise, Arc::clone(&heard)))).unwrap();
            assert_eq!(found, None, "{noise:?}");
            assert_eq!(heard.lock().unwrap().0, 4 * PATIENCE, "{noise:?}");
        }
        let heard = Arc::default();
        let found = who(|_| Ok(Says(b"1 2\n", Arc::clone(&heard)))).unwrap();
        assert_eq!(found, Some((115_200, Found::Lines("1 2".to_owned()))));
        assert_eq!(heard.lock().unwrap().1, b"");
    }

    #[test]
    fn a_port_that_is_not_there_is_told_with_what_to_do() {
        let error = who_is_at(Path::new("/nowhere/tty")).unwrap_err().to_string();
        assert!(error.contains("/nowhere/tty") && error.contains("zwidth ports"), "{error}");
    }
}
