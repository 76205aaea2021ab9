//! Markers: moments of a trial that are announced to other programs as they occur.
//!
//! A thread of their own sends them. A marker that cannot be sent is reported once, and disturbs
//! nothing: neither the control loop nor the session waits for it.

mod osc;
mod target;

pub use target::Target;

use osc::{Argument, message};
use std::io::{self, Write};
use std::net::{SocketAddr, TcpStream, ToSocketAddrs, UdpSocket};
use std::sync::mpsc::{Receiver, Sender, SyncSender, channel, sync_channel};
use std::time::{Duration, Instant};
use zwidth_study::Moment;

/// Longest wait for a program that is told, each time.
const PATIENCE: Duration = Duration::from_millis(500);
/// One that could not be told is not tried again for so long.
const REST: Duration = Duration::from_secs(5);
/// Markers that may wait to be sent: those of many trials.
const WAITING: usize = 256;
/// The address of a marker's message.
const ADDRESS: &str = "/zwidth/marker";

/// A moment of a trial. It names no mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Marker {
    pub(crate) trial: u32,
    pub(crate) moment: Moment,
    /// Since the trial's start, by the host's clock, s.
    pub(crate) t_s: f64,
    /// By the device's own clock, s.
    pub(crate) t_device_s: Option<f64>,
}

impl Marker {
    /// As a line: `{"marker":"start","trial":3,"t_s":0.000012,"t_device_s":8.500000}`.
    fn line(&self) -> String {
        let Self { trial, moment, t_s, t_device_s } = self;
        let device = t_device_s.map(|s| format!(",\"t_device_s\":{s:.6}")).unwrap_or_default();
        let marker = moment.as_str();
        format!("{{\"marker\":\"{marker}\",\"trial\":{trial},\"t_s\":{t_s:.6}{device}}}\n")
    }

    /// As a message: the moment's name, the trial's number, and its times in seconds.
    fn message(&self) -> Vec<u8> {
        let trial = i32::try_from(self.trial).unwrap_or(i32::MAX);
        let mut arguments = vec![
            Argument::Text(self.moment.as_str()),
            Argument::Int(trial),
            Argument::Double(self.t_s),
        ];
        arguments.extend(self.t_device_s.map(Argument::Double));
        message(ADDRESS, &arguments)
    }
}

/// Longest wait for the markers that are still to be sent when a session ends: a program may take
/// them slowly, and a name may be looked up for long.
const LAST: Duration = Duration::from_secs(2);

/// Sends markers. When it is dropped, those that wait are sent first, for a while.
pub(crate) struct Markers {
    sender: Option<SyncSender<Marker>>,
    /// It ends with the thread that sends.
    failures: Receiver<String>,
}

impl Markers {
    /// Sends to these programs; the control loop itself tells the board.
    pub(crate) fn to(targets: &[Target]) -> Self {
        let (sender, markers) = sync_channel(WAITING);
        let (reports, failures) = channel();
        if targets.is_empty() {
            return Self { sender: None, failures };
        }
        let targets = targets.iter().cloned();
        let mut lines: Vec<Line> =
            targets.map(|target| Line { target, tcp: None, failed: None }).collect();
        std::thread::spawn(move || {
            for marker in markers {
                lines.iter_mut().for_each(|line| line.send(&marker, &reports));
            }
        });
        Self { sender: Some(sender), failures }
    }

    /// Whether anybody is told.
    pub(crate) fn are_on(&self) -> bool {
        self.sender.is_some()
    }

    /// Sends a marker, without waiting.
    pub(crate) fn send(&self, marker: Marker) {
        // One that has no room is in the session's log all the same; whoever takes none was told.
        let _ = self.sender.as_ref().map(|sender| sender.try_send(marker));
    }

    /// What could not be sent since this was asked last, in words.
    pub(crate) fn failures(&self) -> Vec<String> {
        self.failures.try_iter().collect()
    }
}

impl Drop for Markers {
    fn drop(&mut self) {
        drop(self.sender.take());
        let until = Instant::now() + LAST;
        // The channel closes when the thread has sent the last marker.
        while self.failures.recv_timeout(until.saturating_duration_since(Instant::now())).is_ok() {}
    }
}

/// The way to one program.
struct Line {
    target: Target,
    tcp: Option<TcpStream>,
    failed: Option<Instant>,
}

impl Line {
    /// Sends one marker; the first of those that cannot be sent is reported.
    fn send(&mut self, marker: &Marker, reports: &Sender<String>) {
        if self.failed.is_some_and(|failed| failed.elapsed() < REST) {
            return;
        }
        let first = self.failed.is_none();
        self.failed = None;
        if let Err(error) = self.try_send(marker) {
            (self.tcp, self.failed) = (None, Some(Instant::now()));
            if first {
                let _ = reports.send(format!("{} takes no markers: {error}", self.target));
            }
        }
    }

    fn try_send(&mut self, marker: &Marker) -> io::Result<()> {
        match &self.target {
            Target::Osc(address) => {
                let to = resolved(address)?;
                // A packet leaves by a socket of the same family of addresses.
                let from: SocketAddr =
                    if to.is_ipv4() { ([0, 0, 0, 0], 0).into() } else { ([0_u16; 8], 0).into() };
                UdpSocket::bind(from)?.send_to(&marker.message(), to).map(drop)
            }
            Target::Tcp(address) => {
                if self.tcp.is_none() {
                    let stream = TcpStream::connect_timeout(&resolved(address)?, PATIENCE)?;
                    // A marker is small, and must not wait for the next one to fill a packet.
                    stream.set_nodelay(true)?;
                    stream.set_write_timeout(Some(PATIENCE))?;
                    self.tcp = Some(stream);
                }
                self.tcp.as_mut().map_or(Ok(()), |tcp| tcp.write_all(marker.line().as_bytes()))
            }
            Target::Board => Ok(()),
        }
    }
}

fn resolved(address: &str) -> io::Result<SocketAddr> {
    let first = address.to_socket_addrs()?.next();
    first.ok_or_else(|| io::Error::new(io::ErrorKind::NotFound, "the host is not known"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{BufRead as _, BufReader};
    use std::net::TcpListener;

    fn marker(moment: Moment, t_device_s: Option<f64>) -> Marker {
        Marker { trial: 3, moment, t_s: 1.25, t_device_s }
    }

    #[test]
    fn a_line_is_json_with_both_clocks() {
        assert_eq!(
            marker(Moment::Contact, Some(8.5)).line(),
            "{\"marker\":\"contact\",\"trial\":3,\"t_s\":1.250000,\"t_device_s\":8.500000}\n"
        );
        assert_eq!(
            marker(Moment::Answer, None).line(),
            "{\"marker\":\"answer\",\"trial\":3,\"t_s\":1.250000}\n"
        );
    }

    #[test]
    fn markers_come_in_order_over_tcp_and_as_packets_over_udp() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let udp = UdpSocket::bind("127.0.0.1:0").unwrap();
        let targets = [
            Target::Tcp(listener.local_addr().unwrap().to_string()),
            Target::Osc(udp.local_addr().unwrap().to_string()),
        ];
        let markers = Markers::to(&targets);
        assert!(markers.are_on());
        let sent = [marker(Moment::Start, Some(8.5)), marker(Moment::End, None)];
        sent.into_iter().for_each(|one| markers.send(one));
        let lines = BufReader::new(listener.accept().unwrap().0).lines();
        let mut packet = [0; 128];
        for (marker, line) in sent.iter().zip(lines) {
            assert_eq!(line.unwrap() + "\n", marker.line());
            let n = udp.recv(&mut packet).unwrap();
            assert_eq!(packet[..n], marker.message());
        }
        assert_eq!(markers.failures(), Vec::<String>::new());
    }

    #[test]
    fn a_program_that_is_not_there_is_told_once_and_disturbs_nobody() {
        let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        let mut markers = Markers::to(&[Target::Tcp(free.to_string())]);
        for _ in 0..20 {
            markers.send(marker(Moment::Start, None));
        }
        drop(markers.sender.take());
        let failures: Vec<String> = markers.failures.iter().collect();
        assert!(
            matches!(&failures[..], [one] if one.starts_with(&format!("tcp:{free} takes no markers: "))),
            "{failures:?}"
        );
    }

    #[test]
    fn a_program_that_takes_markers_for_ever_does_not_hold_up_the_end() {
        let (sender, markers) = sync_channel(WAITING);
        let (told, failures) = channel();
        let (go, hangs) = channel::<()>();
        std::thread::spawn(move || {
            let _ = hangs.recv();
            drop((markers, told));
        });
        drop(Markers { sender: Some(sender), failures });
        drop(go);
    }

    #[test]
    fn without_a_program_nothing_is_sent() {
        let markers = Markers::to(&[]);
        markers.send(marker(Moment::Start, None));
        assert!(!markers.are_on() && markers.failures().is_empty());
    }
}
