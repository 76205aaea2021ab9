//! What a session and the participant's screen send each other: lines of text of limited length.

use super::proof::{Nonce, Secret};
use super::sight::Sight;
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead, Read, Write};
use std::net::TcpStream;
use std::time::Instant;

/// Longest line of a session, bytes: a question with a hundred answers, each with a long word.
const MOST_LINE: u64 = 1 << 17;

/// A message of the session.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Message {
    /// Another screen is open.
    Taken,
    /// What is to be seen now.
    Sight(Sight),
}

/// What a file says about where a session is found: its port, and the secret that proves who is
/// who.
pub fn place_of(text: &str) -> Option<(u16, Secret)> {
    let (port, secret) = text.trim_end().split_once(' ')?;
    Some((port.parse().ok()?, Secret::from_hex(secret)?))
}

/// The text of that file.
pub(super) fn place(port: u16, secret: &Secret) -> String {
    format!("{port} {}\n", secret.hex())
}

/// An answer to the question of that number.
pub(super) fn answer(number: u64, value: i16) -> String {
    format!("answer {number} {value}")
}

/// What such a line says; nothing if it is none.
pub(super) fn read_answer(line: &str) -> Option<(u64, i16)> {
    let (number, value) = line.strip_prefix("answer ")?.split_once(' ')?;
    Some((number.parse().ok()?, value.parse().ok()?))
}

/// A number for one line, which nobody can guess.
///
/// # Errors
/// The system gives no random numbers.
pub(super) fn nonce() -> io::Result<Nonce> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes).map_err(io::Error::other)?;
    Ok(bytes)
}

/// One end of a line, which is waited for until an instant at most, over all reads together. A limit
/// for each read alone would last for ever against somebody who sends a byte now and then.
#[derive(Debug)]
pub(super) struct Patient {
    pub(super) stream: TcpStream,
    /// None: however long it takes.
    pub(super) until: Option<Instant>,
}

impl Read for Patient {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let left = self.until.map(|until| until.saturating_duration_since(Instant::now()));
        if left.is_some_and(|left| left.is_zero()) {
            return Err(io::ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(left)?;
        self.stream.read(into)
    }
}

/// The next line, without its end; none at the end of the input.
///
/// # Errors
/// What the system says; a line that is too long, or no text.
pub(super) fn read_line(input: &mut impl BufRead) -> io::Result<Option<String>> {
    let mut line = String::new();
    input.by_ref().take(MOST_LINE).read_line(&mut line)?;
    match line.strip_suffix('\n') {
        Some(whole) => Ok(Some(whole.to_owned())),
        None if line.is_empty() => Ok(None),
        // Cut off by the end of the input, or longer than any line of ours.
        None => Err(io::ErrorKind::InvalidData.into()),
    }
}

/// Sends one line at once.
pub(super) fn write_line(output: &mut impl Write, line: &str) -> io::Result<()> {
    output.write_all(format!("{line}\n").as_bytes())?;
    output.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;
    use std::net::TcpListener;
    use std::time::Duration;

    #[test]
    fn a_place_is_read_as_it_was_written_and_nothing_else_is_one() {
        let secret = Secret::new([7; 32]);
        assert_eq!(place_of(&place(4_711, &secret)), Some((4_711, secret.clone())));
        let hex = secret.hex();
        for text in ["", "4711", "4711 ", "4711 word", &format!("x {hex}"), &format!("99999 {hex}")]
        {
            assert_eq!(place_of(text), None, "{text:?}");
        }
    }

    #[test]
    fn an_answer_is_read_as_it_was_written_and_nothing_else_is_one() {
        assert_eq!(read_answer(&answer(3, -2)), Some((3, -2)));
        for line in ["answer 3", "answer x 2", "answer 3 40000", "start", "stop"] {
            assert_eq!(read_answer(line), None, "{line}");
        }
    }

    #[test]
    fn a_line_without_an_end_is_an_error_and_the_end_is_none() {
        let mut input = Cursor::new("one\ntwo");
        assert_eq!(read_line(&mut input).unwrap().as_deref(), Some("one"));
        assert!(read_line(&mut input).is_err());
        assert_eq!(read_line(&mut input).unwrap(), None);
        let long = "x".repeat(1 << 18) + "\n";
        assert!(read_line(&mut Cursor::new(long)).is_err());
    }

    #[test]
    fn who_sends_a_byte_now_and_then_is_waited_for_no_longer_than_who_sends_nothing() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let mut slow = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
        let stream = listener.accept().unwrap().0;
        let sends = std::thread::spawn(move || while slow.write_all(b"x").is_ok() {});
        let until = Some(Instant::now() + Duration::from_millis(30));
        let mut patient = Patient { stream, until };
        let mut byte = [0];
        let error = loop {
            if let Err(error) = patient.read(&mut byte) {
                break error;
            }
        };
        assert!(matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock));
        drop(patient);
        sends.join().unwrap();
    }
}
