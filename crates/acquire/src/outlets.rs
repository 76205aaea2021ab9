//! Streams of other programs that must be there before a trial begins: outlets of the LabStreamingLayer, found by asking the
//! network as its own library does (liblsl 1.16, `udp_server`: a query in a UDP packet, answered by every outlet that fits).
//!
//! A thread of its own asks, over and over. Nothing is recorded here: that is the work of a recorder, whose file
//! `zwidth beside` takes.

use std::collections::BTreeMap;
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Between two questions.
const ASK: Duration = Duration::from_millis(500);
/// An outlet that has not answered for so long is gone: four questions.
const GONE: Duration = Duration::from_secs(2);
/// Where outlets listen for questions to all: this machine, the network's groups, and everybody on it.
const GROUPS: [Ipv4Addr; 4] = [
    Ipv4Addr::LOCALHOST,
    Ipv4Addr::new(224, 0, 0, 183),
    Ipv4Addr::new(239, 255, 172, 215),
    Ipv4Addr::BROADCAST,
];
const GROUP_PORT: u16 = 16571;
/// Where those of this machine listen besides, for a network may carry no groups.
const OWN_PORTS: std::ops::Range<u16> = 16572..16604;
/// Bytes of an answer that are read: its names come first.
const MOST_ANSWER: usize = 1 << 14;

/// The name of a stream that is waited for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StreamName(String);

impl FromStr for StreamName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // It stands in a query between single quotes.
        let is_plain = !text.contains('\'') && !text.chars().any(char::is_control);
        match is_plain && !text.trim().is_empty() {
            true => Ok(Self(text.to_owned())),
            false => Err("write the stream's name, in which no single quote can be".to_owned()),
        }
    }
}

impl std::fmt::Display for StreamName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

/// The outlets that answered to each name, by their ids, and when last.
type Heard = Vec<BTreeMap<String, Instant>>;

/// Streams that are waited for.
pub(crate) struct Outlets {
    names: Vec<StreamName>,
    heard: Arc<Mutex<Heard>>,
    ends: Arc<AtomicBool>,
    /// The outlets of each name when changes were asked for last.
    reported: Vec<Vec<String>>,
}

impl Outlets {
    /// Asks for these from now on.
    ///
    /// # Errors
    /// No socket for it.
    pub(crate) fn ask_for(names: &[StreamName]) -> std::io::Result<Self> {
        let heard = Arc::new(Mutex::new(vec![BTreeMap::new(); names.len()]));
        let ends = Arc::new(AtomicBool::new(false));
        if !names.is_empty() {
            let socket = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))?;
            socket.set_broadcast(true)?;
            let port = socket.local_addr()?.port();
            let queries = names.iter().enumerate().map(|(i, name)| {
                format!("LSL:shortinfo\r\nname='{name}'\r\n{port} {i}\r\n").into_bytes()
            });
            let queries: Vec<Vec<u8>> = queries.collect();
            let (heard, ends) = (Arc::clone(&heard), Arc::clone(&ends));
            thread::spawn(move || {
                while !ends.load(Ordering::Relaxed) {
                    for query in &queries {
                        send(&socket, query);
                    }
                    listen(&socket, &heard);
                }
            });
        }
        Ok(Self { names: names.to_vec(), heard, ends, reported: vec![Vec::new(); names.len()] })
    }

    /// Those of each name that answer.
    fn present(&self, now: Instant) -> Vec<Vec<String>> {
        let mut heard = locked(&self.heard);
        for outlets in heard.iter_mut() {
            outlets.retain(|_, last| now.saturating_duration_since(*last) < GONE);
        }
        heard.iter().map(|outlets| outlets.keys().cloned().collect()).collect()
    }

    /// What is missing, in words.
    pub(crate) fn missing(&self, now: Instant) -> Option<String> {
        let present = self.present(now);
        let missing = self.names.iter().zip(&present).filter(|(_, outlets)| outlets.is_empty());
        let names: Vec<String> = missing.map(|(name, _)| format!("'{name}'")).collect();
        let (word, are) = if names.len() == 1 { ("stream", "is") } else { ("streams", "are") };
        (!names.is_empty()).then(|| {
            format!(
                "the {word} {} {are} missing (--wait-for): start the program that sends; until then no trial begins",
                names.join(", ")
            )
        })
    }

    /// What has changed since this was asked last, in words: outlets that came, or went.
    pub(crate) fn changes(&mut self, now: Instant) -> Vec<String> {
        let present = self.present(now);
        let mut changes = Vec::new();
        for ((name, outlets), before) in self.names.iter().zip(present).zip(&mut self.reported) {
            if outlets == *before {
                continue;
            }
            changes.push(match &outlets[..] {
                [] => format!("the stream '{name}' is gone"),
                [one] => format!("the stream '{name}' comes from the outlet {one}"),
                several => {
                    format!(
                        "the stream '{name}' comes from {} outlets: {}",
                        several.len(),
                        several.join(", ")
                    )
                }
            });
            *before = outlets;
        }
        changes
    }
}

impl Drop for Outlets {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
    }
}

fn locked(heard: &Mutex<Heard>) -> MutexGuard<'_, Heard> {
    heard.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Asks everybody. A network that carries no groups refuses some of it, which others make up for.
fn send(socket: &UdpSocket, query: &[u8]) {
    let groups = GROUPS.map(|group| SocketAddr::from((group, GROUP_PORT)));
    let own = OWN_PORTS.map(|port| SocketAddr::from((Ipv4Addr::LOCALHOST, port)));
    for to in groups.into_iter().chain(own) {
        let _ = socket.send_to(query, to);
    }
}

/// Takes answers until it is time to ask again.
fn listen(socket: &UdpSocket, heard: &Mutex<Heard>) {
    let until = Instant::now() + ASK;
    let mut answer = [0; MOST_ANSWER];
    loop {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return;
        }
        let received =
            socket.set_read_timeout(Some(left)).and_then(|()| socket.recv_from(&mut answer));
        // A time that is up, or a word of a port where nobody listens: the next question follows in either case.
        let Ok((n, _)) = received else { continue };
        if let Some((place, outlet)) = read(&String::from_utf8_lossy(&answer[..n]))
            && let Some(outlets) = locked(heard).get_mut(place)
        {
            outlets.insert(outlet, Instant::now());
        }
    }
}

/// Which question an answer is to, and the outlet with its machine: the number of the question in the first line, then XML.
fn read(answer: &str) -> Option<(usize, String)> {
    let (number, xml) = answer.split_once('\n')?;
    let text = |element: &str| {
        let (_, from) = xml.split_once(&format!("<{element}>"))?;
        let (text, _) = from.split_once(&format!("</{element}>"))?;
        let is_plain = text.len() < 256 && !text.chars().any(char::is_control);
        (is_plain && !text.is_empty()).then(|| text.to_owned())
    };
    let host = text("hostname").map(|host| format!(" of {host}")).unwrap_or_default();
    Some((number.trim().parse().ok()?, format!("{}{host}", text("uid")?)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parts of an answer that are read, as liblsl 1.16 lays it out.
    fn answer(number: &str, uid: &str) -> String {
        format!(
            "{number}\r\n<?xml version=\"1.0\"?>\n<info>\n\t<name>EMG</name>\n\t<uid>{uid}</uid>\n\t<hostname>lab</hostname>\n</info>\n"
        )
    }

    #[test]
    fn an_answer_names_its_question_the_outlet_and_its_machine() {
        assert_eq!(read(&answer("1", "7d-4b")), Some((1, "7d-4b of lab".to_owned())));
        for bad in [
            answer("x", "7d"),
            answer("1", ""),
            answer("1", "\u{7}"),
            String::new(),
            "1\r\n<uid>".to_owned(),
        ] {
            assert_eq!(read(&bad), None, "{bad}");
        }
    }

    #[test]
    fn a_name_stands_between_single_quotes() {
        assert_eq!("EMG of the arm".parse::<StreamName>().unwrap().to_string(), "EMG of the arm");
        for bad in ["", " ", "it's", "a\nb"] {
            assert!(bad.parse::<StreamName>().unwrap_err().contains("single quote"), "{bad}");
        }
    }

    /// Outlets of two names with their last answers, and the moment from which these count.
    fn outlets(answers: [&[(&str, Duration)]; 2]) -> (Outlets, Instant) {
        let begun = Instant::now();
        let answered = |of_name: &[(&str, Duration)]| {
            of_name.iter().map(|(outlet, at)| ((*outlet).to_owned(), begun + *at)).collect()
        };
        let outlets = Outlets {
            names: ["EMG", "gaze"].map(|name| name.parse().unwrap()).to_vec(),
            heard: Arc::new(Mutex::new(answers.map(answered).to_vec())),
            ends: Arc::default(),
            reported: vec![Vec::new(); 2],
        };
        (outlets, begun)
    }

    #[test]
    fn an_outlet_is_there_while_it_answers_and_each_change_is_told_once() {
        let first = Duration::ZERO;
        let (mut some, begun) = outlets([&[("a of lab", ASK)], &[("b of lab", first)]]);
        assert_eq!(some.missing(begun + ASK), None);
        let none_of_gaze = some.missing(begun + GONE).unwrap();
        assert!(none_of_gaze.starts_with("the stream 'gaze' is missing"), "{none_of_gaze}");
        assert_eq!(some.changes(begun + GONE), ["the stream 'EMG' comes from the outlet a of lab"]);
        assert_eq!(some.changes(begun + GONE), Vec::<String>::new());
        locked(&some.heard)[1].insert("c of lab".to_owned(), begun + GONE);
        assert_eq!(
            some.changes(begun + GONE + ASK),
            ["the stream 'EMG' is gone", "the stream 'gaze' comes from the outlet c of lab"]
        );
        let (neither, begun) = outlets([&[], &[]]);
        let both = neither.missing(begun).unwrap();
        assert!(both.starts_with("the streams 'EMG', 'gaze' are missing"), "{both}");
        let (mut two, begun) = outlets([&[], &[("b", first), ("c", first)]]);
        assert_eq!(two.changes(begun), ["the stream 'gaze' comes from 2 outlets: b, c"]);
    }

    #[test]
    fn a_question_is_answered_over_the_network() {
        let outlets = Outlets::ask_for(&["EMG".parse().unwrap()]).unwrap();
        // A port of this machine's own: an outlet has the first that is free.
        let port =
            OWN_PORTS.rev().find_map(|port| UdpSocket::bind((Ipv4Addr::LOCALHOST, port)).ok());
        let outlet = port.unwrap();
        let mut query = [0; 256];
        while outlets.missing(Instant::now()).is_some() {
            let (n, from) = outlet.recv_from(&mut query).unwrap();
            let query = String::from_utf8_lossy(&query[..n]).into_owned();
            assert!(
                query.starts_with("LSL:shortinfo\r\nname='EMG'\r\n") && query.ends_with(" 0\r\n"),
                "{query}"
            );
            outlet.send_to(answer("0", "7d").as_bytes(), from).unwrap();
        }
    }
}
