//! The session's end of the line as sockets, on a port of this machine alone. [`Reception`] decides
//! what is sent there.
//!
//! Anybody on this machine may connect to the port, so nothing waits for a client. A thread of its
//! own greets each client, within a time limit for the whole greeting. The number of greetings at
//! once is limited, and the end of the session joins none of these threads.

use super::proof::Secret;
use super::reception::{Reception, SentAway, Visit};
use super::wire::{Patient, nonce, place};
use std::collections::VecDeque;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;
use std::time::{Duration, Instant};

/// Longest time for the whole greeting: a screen of ours takes a thousandth of it.
const GREETING: Duration = Duration::from_secs(2);
/// Longest wait for a screen that takes nothing, each time.
const PATIENCE: Duration = Duration::from_millis(500);
/// Those who are greeted at once. When one more comes, the one that came first goes: a screen of ours
/// is in before so many others have come.
const MOST_GREETED: usize = 64;
/// Longest wait for our own call to the port, which ends the thread that listens there.
const CALL: Duration = Duration::from_millis(50);

/// A port at which the participant's screen finds a session. When it is dropped, the screen first
/// gets the last sight.
#[derive(Debug)]
pub struct Door {
    reception: Arc<Reception>,
    address: SocketAddr,
    hall: Arc<Hall>,
}

/// Those who are being greeted, the one that came first in front, by their numbers.
#[derive(Debug, Default)]
struct Hall(Mutex<VecDeque<(u64, Arc<TcpStream>)>>);

impl Door {
    /// Opens a port for screens that know the secret.
    ///
    /// # Errors
    /// The system gives no port, or no thread.
    pub fn open(secret: Secret) -> io::Result<Self> {
        // On this machine alone, at a port that the system chooses.
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let address = listener.local_addr()?;
        let reception = Reception::new(secret);
        let hall = Arc::new(Hall::default());
        let inner = Arc::clone(&reception);
        let greeted = Arc::clone(&hall);
        let thread = Builder::new().name("door".into());
        thread.spawn(move || listen(&listener, &inner, &greeted))?;
        Ok(Self { reception, address, hall })
    }

    /// Where it is found: what [`super::place_of`] reads.
    pub fn place(&self) -> String {
        place(self.address.port(), self.reception.secret())
    }

    /// What is shown and heard there.
    pub fn reception(&self) -> Arc<Reception> {
        Arc::clone(&self.reception)
    }
}

impl Drop for Door {
    fn drop(&mut self) {
        self.reception.close();
        for (_, stream) in self.hall.lock().drain(..) {
            let _ = stream.shutdown(Shutdown::Both);
        }
        self.reception.wait_for_tellers(PATIENCE);
        // Who listens sees that the session is over when somebody comes. Where the line is full, others
        // come.
        let _ = TcpStream::connect_timeout(&self.address, CALL);
    }
}

impl Hall {
    /// A panic elsewhere leaves plain values behind.
    fn lock(&self) -> MutexGuard<'_, VecDeque<(u64, Arc<TcpStream>)>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn enter(&self, number: u64, stream: &Arc<TcpStream>) {
        let mut greeted = self.lock();
        if greeted.len() >= MOST_GREETED
            && let Some((_, first)) = greeted.pop_front()
        {
            let _ = first.shutdown(Shutdown::Both);
        }
        greeted.push_back((number, Arc::clone(stream)));
    }

    fn leave(&self, number: u64) {
        self.lock().retain(|(greeted, _)| *greeted != number);
    }
}

/// Until the session is over.
fn listen(listener: &TcpListener, reception: &Arc<Reception>, hall: &Arc<Hall>) {
    for number in 0.. {
        let stream = listener.accept();
        if reception.is_closing() {
            break;
        }
        let greeted = stream.and_then(|(stream, _)| {
            let stream = Arc::new(stream);
            hall.enter(number, &stream);
            let reception = Arc::clone(reception);
            let hall = Arc::clone(hall);
            Builder::new().name("participant".into()).spawn(move || {
                // Who went, or has to go.
                let _ = receive(&stream, &reception, &hall, number);
                hall.leave(number);
                let _ = stream.shutdown(Shutdown::Both);
            })
        });
        if greeted.is_err() {
            hall.leave(number);
            // Who went already; or no room for another, which does not come by asking often.
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// Hears whoever came until they are gone. Once they are let in, they are greeted no longer.
///
/// # Errors
/// They have gone, or did not prove in time that they know the secret.
fn receive(
    stream: &TcpStream,
    reception: &Arc<Reception>,
    hall: &Hall,
    number: u64,
) -> io::Result<()> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut input = Patient { stream: stream.try_clone()?, until: Some(Instant::now() + GREETING) };
    let mut visit = Visit::new(reception, nonce()?);
    let mut bytes = [0; 256];
    loop {
        let length = match input.read(&mut bytes) {
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            length => length?,
        };
        if length == 0 {
            return Ok(());
        }
        let mut output = stream;
        match visit.take(&bytes[..length]) {
            Ok(back) => output.write_all(back.as_bytes())?,
            Err(SentAway(last)) => return output.write_all(last.as_bytes()),
        }
        if input.until.is_some()
            && let Some(mut teller) = visit.teller()
        {
            hall.leave(number);
            input.until = None;
            let mut output = stream.try_clone()?;
            let thread = Builder::new().name("participant's screen".into());
            // A thread of its own: this one waits for answers.
            thread.spawn(move || {
                while let Some(line) = teller.wait_for_news() {
                    if output.write_all(line.as_bytes()).is_err() {
                        break;
                    }
                }
                let _ = output.shutdown(Shutdown::Both);
            })?;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::guest::Guest;
    use super::super::proof::Knock;
    use super::super::sight::{Choice, Now, OpenQuestion, Sight};
    use super::super::wire::{Message, answer, read_line, write_line};
    use super::*;
    use std::io::BufReader;

    fn secret() -> Secret {
        Secret::new([1; 32])
    }

    /// Somebody who said this, and where they read.
    fn knock(door: &Door, line: &str) -> (TcpStream, BufReader<TcpStream>) {
        let mut stream = TcpStream::connect(door.address).unwrap();
        write_line(&mut stream, line).unwrap();
        let input = BufReader::new(stream.try_clone().unwrap());
        (stream, input)
    }

    /// A screen of ours.
    fn enter(door: &Door) -> (TcpStream, BufReader<TcpStream>) {
        let ours = Knock::new(secret(), [7; 32]);
        let (mut stream, mut input) = knock(door, &ours.hello());
        let line = read_line(&mut input).unwrap().unwrap();
        write_line(&mut stream, &ours.proof(&line).unwrap()).unwrap();
        (stream, input)
    }

    fn said(input: &mut BufReader<TcpStream>) -> Message {
        serde_json::from_str(&read_line(input).unwrap().unwrap()).unwrap()
    }

    fn sight(done: usize) -> Sight {
        Sight { done, ..Sight::default() }
    }

    fn until(mut holds: impl FnMut() -> bool) {
        while !holds() {
            std::thread::yield_now();
        }
    }

    #[test]
    fn a_screen_sees_what_is_shown_and_its_answer_is_heard() {
        let door = Door::open(secret()).unwrap();
        door.reception.show(&sight(1));
        let (mut stream, mut input) = enter(&door);
        assert_eq!(said(&mut input), Message::Sight(sight(1)));
        let choices = vec![Choice { value: -2, word: None }];
        let asked = OpenQuestion { number: 7, choices, ..OpenQuestion::default() };
        let asked = Sight { now: Now::Question(asked), ..sight(1) };
        door.reception.show(&asked);
        assert_eq!(said(&mut input), Message::Sight(asked));
        write_line(&mut stream, "start").unwrap();
        write_line(&mut stream, &answer(7, -2)).unwrap();
        until(|| door.reception.answer() == Some(-2));
    }

    #[test]
    fn who_does_not_know_the_secret_hears_nothing_of_the_session() {
        let door = Door::open(secret()).unwrap();
        door.reception.show(&sight(1));
        for line in ["GET / HTTP/1.1", "zwidth-participant-1 word", ""] {
            let mut told = Vec::new();
            // A line that waits unread may turn the end into a reset.
            let _ = knock(&door, line).1.read_to_end(&mut told);
            assert_eq!(told, b"", "{line}");
        }
        let (mut stream, mut input) = knock(&door, &Knock::new(secret(), [7; 32]).hello());
        let nonce_and_proof = read_line(&mut input).unwrap().unwrap();
        write_line(&mut stream, &nonce_and_proof).unwrap();
        let mut told = Vec::new();
        let _ = input.read_to_end(&mut told);
        assert_eq!(told, b"");
        assert!(!door.reception.is_open());
    }

    #[test]
    fn three_hundred_who_say_nothing_shut_no_screen_out() {
        let door = Door::open(secret()).unwrap();
        let idle: Vec<TcpStream> =
            (0..300).map(|_| TcpStream::connect(door.address).unwrap()).collect();
        assert_eq!(said(&mut enter(&door).1), Message::Sight(sight(0)));
        assert!(door.hall.lock().len() <= MOST_GREETED);
        drop(idle);
    }

    #[test]
    fn who_sends_a_byte_now_and_then_is_not_waited_for_at_the_end() {
        let door = Door::open(secret()).unwrap();
        let mut slow = TcpStream::connect(door.address).unwrap();
        let greeted = || door.hall.lock().front().is_some();
        until(greeted);
        slow.write_all(b"z").unwrap();
        let hall = Arc::clone(&door.hall);
        drop(door);
        let mut slow_ended = Vec::new();
        // Cut off, with or without a reset; the thread that greeted it has ended.
        let _ = slow.read_to_end(&mut slow_ended);
        until(|| Arc::strong_count(&hall) == 1);
        assert_eq!(slow_ended, b"");
    }

    #[test]
    fn a_screen_that_reads_nothing_holds_up_nothing_and_is_let_go() {
        let door = Door::open(secret()).unwrap();
        let (stream, _input) = enter(&door);
        until(|| door.reception.is_open());
        let long = "x".repeat(100_000);
        // The line takes a few megabytes by itself; then the screen is waited for, and let go.
        for done in 0.. {
            let long = Some(long.clone());
            door.reception.show(&Sight { environment: long, ..sight(done) });
            if !door.reception.is_open() {
                break;
            }
        }
        drop(stream);
    }

    #[test]
    fn the_last_sight_is_seen_before_the_door_closes() {
        let door = Door::open(secret()).unwrap();
        let (_stream, mut input) = enter(&door);
        assert_eq!(said(&mut input), Message::Sight(sight(0)));
        let left = Sight { now: Now::Left, ..sight(9) };
        door.reception.show(&left);
        drop(door);
        assert_eq!(said(&mut input), Message::Sight(left));
        assert_eq!(read_line(&mut input).unwrap(), None);
    }

    #[test]
    fn a_screen_that_was_crowded_out_before_it_was_greeted_tries_again() {
        let door = Door::open(secret()).unwrap();
        let port = door.address.port();
        // Enough to crowd it out four times, however slow it is: it comes five times.
        let crowd = std::thread::spawn(move || {
            for _ in 0..300 {
                let _ = TcpStream::connect((Ipv4Addr::LOCALHOST, port));
            }
        });
        let guest = Guest::enter(port, &secret());
        crowd.join().unwrap();
        assert!(guest.is_ok(), "{guest:?}");
    }
}
