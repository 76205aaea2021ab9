//! The screen's end of the line: what it sees of a session, and the answers that it gives.

use super::sight::{Now, Sight};
use super::wire::{Said, answer, hello, read_line, write_line};
use crate::AcquireError;
use std::io::{self, BufReader};
use std::net::{Ipv4Addr, Shutdown, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// Longest wait for the session's first word: it answers at once.
const PATIENCE: Duration = Duration::from_secs(5);

/// A participant's screen that a session has let in.
#[derive(Debug)]
pub struct Guest {
    stream: TcpStream,
    sights: Receiver<Sight>,
    /// The last sight said that the session is over.
    is_over: bool,
}

impl Guest {
    /// Asks to be let in at a port of this machine, with the word of admission.
    ///
    /// # Errors
    /// Nobody listens there, or not a session of this program; another screen is open.
    pub fn enter(port: u16, word: &str) -> Result<Self, AcquireError> {
        let nobody = |_| refused("no session of this study is being recorded", START);
        let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).map_err(nobody)?;
        let mut input = greeted(&mut stream, word).map_err(nobody)?;
        let first = match heard(&mut input) {
            Ok(Some(Said::Sight(sight))) => sight,
            Ok(Some(Said::Taken)) => {
                return Err(refused(
                    "another participant's screen is open for this session",
                    "close that one first (Ctrl-C there)",
                ));
            }
            Ok(None) | Err(_) => {
                return Err(refused(
                    "the session does not let this screen in",
                    "use the same version of zwidth for both, and open the screen again",
                ));
            }
        };
        stream.set_read_timeout(None).map_err(nobody)?;
        let (sender, sights) = channel();
        // The receiver is right here: this cannot fail.
        let _ = sender.send(first);
        let thread = std::thread::Builder::new().name("session".into());
        thread.spawn(move || hear_all(&mut input, &sender)).map_err(nobody)?;
        Ok(Self { stream, sights, is_over: false })
    }

    /// What is to be seen next, waiting for it at most `wait`; none if nothing came.
    ///
    /// # Errors
    /// The session is gone, and did not say that it is over.
    pub(super) fn next(&mut self, wait: Duration) -> Result<Option<Sight>, AcquireError> {
        match self.sights.recv_timeout(wait) {
            Ok(sight) => {
                self.is_over = sight.now == Now::Left;
                Ok(Some(sight))
            }
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) if self.is_over => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(refused("the session is gone", GO_ON)),
        }
    }

    /// Answers the question of that number.
    ///
    /// # Errors
    /// The session is gone.
    pub(super) fn answer(&mut self, number: u64, value: i16) -> Result<(), AcquireError> {
        write_line(&mut self.stream, &answer(number, value))
            .map_err(|_| refused("the session is gone, and the answer with it", GO_ON))
    }
}

impl Drop for Guest {
    fn drop(&mut self) {
        let _ = self.stream.shutdown(Shutdown::Both);
    }
}

const START: &str = "start it with `zwidth acquire` in another terminal, then open this screen";
const GO_ON: &str = "go on with it by `zwidth acquire`, then open this screen again";

fn refused(what: &str, remedy: &str) -> AcquireError {
    AcquireError::Refused { what: what.to_owned(), remedy: remedy.to_owned() }
}

/// Says the word; what comes is read from there.
fn greeted(stream: &mut TcpStream, word: &str) -> io::Result<BufReader<TcpStream>> {
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    write_line(stream, &hello(word))?;
    Ok(BufReader::new(stream.try_clone()?))
}

/// What the session says next; none at the end.
fn heard(input: &mut BufReader<TcpStream>) -> io::Result<Option<Said>> {
    let line = read_line(input)?;
    Ok(line.map(|line| serde_json::from_str(&line)).transpose()?)
}

fn hear_all(input: &mut BufReader<TcpStream>, sights: &Sender<Sight>) {
    while let Ok(Some(Said::Sight(sight))) = heard(input) {
        if sights.send(sight).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::door::Door;
    use super::super::wire::place_of;
    use super::*;
    use std::net::TcpListener;

    fn words(error: AcquireError) -> String {
        error.to_string()
    }

    #[test]
    fn where_nobody_listens_no_session_is_being_recorded() {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let told = words(Guest::enter(port, "word").unwrap_err());
        assert!(told.contains("no session of this study") && told.contains("acquire"), "{told}");
    }

    #[test]
    fn a_second_screen_and_one_with_another_word_are_told_apart() {
        let door = Door::open("word").unwrap();
        let place = door.place();
        let (port, word) = place_of(&place).unwrap();
        let _first = Guest::enter(port, word).unwrap();
        assert!(words(Guest::enter(port, word).unwrap_err()).contains("another participant's"));
        assert!(words(Guest::enter(port, "guess").unwrap_err()).contains("does not let"));
    }

    #[test]
    fn a_session_that_says_that_it_is_over_is_not_missed_and_one_that_goes_is() {
        for (now, is_over) in [(Now::Left, true), (Now::Ready, false)] {
            let door = Door::open("word").unwrap();
            let place = door.place();
            let (port, word) = place_of(&place).unwrap();
            let mut guest = Guest::enter(port, word).unwrap();
            door.show(&Sight { now: now.clone(), ..Sight::default() });
            drop(door);
            while guest.next(PATIENCE).unwrap().is_none_or(|sight| sight.now != now) {}
            assert_eq!(guest.next(PATIENCE).is_ok(), is_over, "{now:?}");
        }
    }
}
