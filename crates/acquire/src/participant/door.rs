//! The session's end of the line: lets one screen in, shows it what may be seen, hears its answers.
//!
//! It listens at a port of this machine alone, and lets in who knows the word that only this user
//! can read. Whoever does not read, or goes, is let go; nothing here waits for a screen, but threads
//! of its own.

use super::sight::Sight;
use super::wire::{Said, hello, place, read_answer, read_line, write_line};
use std::io::{self, BufReader};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

/// Longest wait for a screen, each time.
const PATIENCE: Duration = Duration::from_millis(500);
/// What may wait to be heard: more than a person says.
const WAITING: usize = 64;

/// What came from a participant's screen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Heard {
    /// A screen was opened.
    Opened,
    /// It was closed, or is gone.
    Closed,
    /// An answer.
    Answer {
        /// To which question.
        number: u64,
        /// Which.
        value: i16,
    },
}

/// The session's end of the line. When it is dropped, the screen is shown the last sight first.
#[derive(Debug)]
pub struct Door {
    shared: Arc<Shared>,
    heard: Receiver<Heard>,
    address: SocketAddr,
    word: String,
    listening: Option<JoinHandle<()>>,
}

/// What the threads share. The lock is held for a copy, never for input or output.
#[derive(Debug, Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    sight: Sight,
    /// How many sights there were.
    shown: u64,
    /// The screen that is in, by its number.
    inside: Option<u64>,
    closing: bool,
}

impl Door {
    /// Opens a door for who knows the word.
    ///
    /// # Errors
    /// The system gives no port, or no thread.
    pub fn open(word: &str) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
        let address = listener.local_addr()?;
        let (sender, heard) = sync_channel(WAITING);
        let shared = Arc::new(Shared::default());
        let (inner, hello) = (Arc::clone(&shared), hello(word));
        let thread = std::thread::Builder::new().name("door".into());
        let listening = Some(thread.spawn(move || inner.listen(&listener, &hello, &sender))?);
        Ok(Self { shared, heard, address, word: word.to_owned(), listening })
    }

    /// Where it is found: what [`super::place_of`] reads.
    pub fn place(&self) -> String {
        place(self.address.port(), &self.word)
    }

    /// Shows a sight to the screen that is in, or to the next one.
    pub(super) fn show(&self, sight: &Sight) {
        let mut state = self.shared.lock();
        if state.sight != *sight {
            state.sight.clone_from(sight);
            state.shown += 1;
            drop(state);
            self.shared.changed.notify_all();
        }
    }

    /// What came since this was asked last, one by one.
    pub(super) fn hear(&self) -> Option<Heard> {
        self.heard.try_recv().ok()
    }
}

impl Drop for Door {
    fn drop(&mut self) {
        self.shared.lock().closing = true;
        self.shared.changed.notify_all();
        // Who listens sees that the door closes when somebody comes. If nobody can come, that
        // thread is left to the end of the program.
        if TcpStream::connect_timeout(&self.address, PATIENCE).is_ok() {
            let _ = self.listening.take().map(JoinHandle::join);
        }
    }
}

impl Shared {
    /// A panic elsewhere leaves plain values behind.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Until the door closes.
    fn listen(self: &Arc<Self>, listener: &TcpListener, hello: &str, heard: &SyncSender<Heard>) {
        let mut telling = None;
        for number in 1.. {
            let stream = listener.accept();
            if self.lock().closing {
                break;
            }
            match stream.and_then(|(stream, _)| self.admit(stream, number, hello, heard)) {
                Ok(Some(thread)) => telling = Some(thread),
                Ok(None) => {}
                // Who went already; or no room for another, which does not come by asking often.
                Err(_) => std::thread::sleep(Duration::from_millis(10)),
            }
        }
        // The last sight is on its way.
        let _ = telling.map(JoinHandle::join);
    }

    /// Lets a screen in that says the right word, if no other is in; who tells it what is seen.
    fn admit(
        self: &Arc<Self>,
        mut stream: TcpStream,
        number: u64,
        hello: &str,
        heard: &SyncSender<Heard>,
    ) -> io::Result<Option<JoinHandle<()>>> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let mut input = BufReader::new(stream.try_clone()?);
        if read_line(&mut input)?.as_deref() != Some(hello) {
            return Ok(None);
        }
        if self.lock().inside.is_some() {
            write_line(&mut stream, &serde_json::to_string(&Said::Taken)?)?;
            return Ok(None);
        }
        stream.set_read_timeout(None)?;
        let named = |name: &str| std::thread::Builder::new().name(name.into());
        self.lock().inside = Some(number);
        let (inner, heard) = (Arc::clone(self), heard.clone());
        let hearing = named("participant").spawn(move || inner.hear_all(input, &heard));
        let inner = Arc::clone(self);
        let telling = hearing
            .and_then(|_| named("participant's screen").spawn(move || inner.tell(stream, number)));
        if telling.is_err() {
            self.lock().inside = None;
        }
        telling.map(Some)
    }

    /// Hears a screen until it is gone.
    fn hear_all(&self, mut input: BufReader<TcpStream>, heard: &SyncSender<Heard>) {
        // What has no room is more than a person says.
        let tell = |what| {
            let _ = heard.try_send(what);
        };
        tell(Heard::Opened);
        while let Ok(Some(line)) = read_line(&mut input) {
            if let Some((number, value)) = read_answer(&line) {
                tell(Heard::Answer { number, value });
            }
        }
        let _ = input.get_ref().shutdown(Shutdown::Both);
        self.lock().inside = None;
        self.changed.notify_all();
        tell(Heard::Closed);
    }

    /// Shows a screen what is to be seen, until it is gone or the door closes.
    fn tell(&self, mut stream: TcpStream, number: u64) {
        let mut last = None;
        while let Some((shown, sight)) = self.wait_for_news(number, last) {
            last = Some(shown);
            let line = serde_json::to_string(&Said::Sight(sight)).unwrap_or_default();
            if write_line(&mut stream, &line).is_err() {
                break;
            }
        }
        let _ = stream.shutdown(Shutdown::Both);
    }

    /// The newest sight, once it is another than the last one; none if that screen is gone, or the
    /// door closes.
    fn wait_for_news(&self, number: u64, last: Option<u64>) -> Option<(u64, Sight)> {
        let is_in = |state: &State| state.inside == Some(number);
        let idle = |state: &mut State| is_in(state) && !state.closing && Some(state.shown) == last;
        let state =
            self.changed.wait_while(self.lock(), idle).unwrap_or_else(PoisonError::into_inner);
        let is_news = is_in(&state) && Some(state.shown) != last;
        is_news.then(|| (state.shown, state.sight.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::sight::{Asked, Now};
    use super::super::wire::answer;
    use super::*;
    use std::io::Read as _;

    const WORD: &str = "open sesame";

    /// A screen that said this, and where it reads.
    fn knock(door: &Door, line: &str) -> (TcpStream, BufReader<TcpStream>) {
        let mut stream = TcpStream::connect(door.address).unwrap();
        write_line(&mut stream, line).unwrap();
        let input = BufReader::new(stream.try_clone().unwrap());
        (stream, input)
    }

    fn said(input: &mut BufReader<TcpStream>) -> Said {
        serde_json::from_str(&read_line(input).unwrap().unwrap()).unwrap()
    }

    /// The next thing that comes, however long it takes.
    fn hear(door: &Door) -> Heard {
        door.heard.recv().unwrap()
    }

    fn sight(done: usize) -> Sight {
        Sight { done, ..Sight::default() }
    }

    #[test]
    fn a_screen_sees_what_is_shown_and_its_answer_is_heard() {
        let door = Door::open(WORD).unwrap();
        door.show(&sight(1));
        let (mut stream, mut input) = knock(&door, &hello(WORD));
        assert_eq!(said(&mut input), Said::Sight(sight(1)));
        let asked = Sight { now: Now::Question(Asked::default()), ..sight(1) };
        door.show(&asked);
        assert_eq!(said(&mut input), Said::Sight(asked));
        write_line(&mut stream, "start").unwrap();
        write_line(&mut stream, &answer(7, -2)).unwrap();
        assert_eq!(
            [hear(&door), hear(&door)],
            [Heard::Opened, Heard::Answer { number: 7, value: -2 }]
        );
    }

    #[test]
    fn a_second_screen_is_told_so_and_let_in_once_the_first_is_gone() {
        let door = Door::open(WORD).unwrap();
        let (first, mut input) = knock(&door, &hello(WORD));
        assert_eq!(said(&mut input), Said::Sight(sight(0)));
        assert_eq!(said(&mut knock(&door, &hello(WORD)).1), Said::Taken);
        first.shutdown(Shutdown::Both).unwrap();
        assert_eq!([hear(&door), hear(&door)], [Heard::Opened, Heard::Closed]);
        assert_eq!(said(&mut knock(&door, &hello(WORD)).1), Said::Sight(sight(0)));
    }

    #[test]
    fn who_does_not_know_the_word_hears_nothing() {
        let door = Door::open(WORD).unwrap();
        door.show(&sight(1));
        for line in ["GET / HTTP/1.1", &hello("guessed"), ""] {
            let mut told = Vec::new();
            // A line that waits unread may turn the end into a reset.
            let _ = knock(&door, line).1.read_to_end(&mut told);
            assert_eq!(told, b"", "{line}");
        }
        assert_eq!(door.hear(), None);
    }

    #[test]
    fn a_screen_that_reads_nothing_holds_up_nothing_and_is_let_go() {
        let door = Door::open(WORD).unwrap();
        let (stream, _input) = knock(&door, &hello(WORD));
        assert_eq!(hear(&door), Heard::Opened);
        let long = "x".repeat(100_000);
        // The line takes a few megabytes by itself; then the screen is waited for, and let go.
        for done in 0.. {
            door.show(&Sight { environment: Some(long.clone()), ..sight(done) });
            if door.hear() == Some(Heard::Closed) {
                break;
            }
        }
        drop(stream);
    }

    #[test]
    fn the_last_sight_is_seen_before_the_door_closes() {
        let door = Door::open(WORD).unwrap();
        let (_stream, mut input) = knock(&door, &hello(WORD));
        assert_eq!(said(&mut input), Said::Sight(sight(0)));
        let left = Sight { now: Now::Left, ..sight(9) };
        door.show(&left);
        drop(door);
        assert_eq!(said(&mut input), Said::Sight(left));
        assert_eq!(read_line(&mut input).unwrap(), None);
    }
}
