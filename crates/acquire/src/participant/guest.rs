//! The screen's end of the line: what it sees of a session, and the answers that it gives.

use super::proof::{Knock, Secret};
use super::sight::{Now, Sight};
use super::wire::{Message, Patient, answer, nonce, read_line, write_line};
use crate::AcquireError;
use std::io::{self, BufReader};
use std::net::{Ipv4Addr, Shutdown, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Longest wait for the whole greeting: a session answers at once.
const PATIENCE: Duration = Duration::from_secs(5);
/// A screen that is sent away before the session has said a word was crowded out by others, and
/// comes again, so often.
const ATTEMPTS: u32 = 5;

/// A session that is gone is looked for so often.
const LOOK_AGAIN: Duration = Duration::from_millis(250);

/// A participant's screen that a session has let in.
pub struct Guest {
    stream: TcpStream,
    sights: Receiver<Sight>,
    /// The last sight said that the session is over.
    is_over: bool,
    /// Where a session lets a screen in now, if there is one.
    find: Option<Find>,
    /// When the session that is gone was looked for last.
    looked: Option<Instant>,
}

type Find = Box<dyn Fn() -> Option<(u16, Secret)> + Send>;

impl std::fmt::Debug for Guest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Guest").field("is_over", &self.is_over).finish_non_exhaustive()
    }
}

/// How a greeting ended.
enum Greeted {
    /// The session has proven that it is one, and this is what it says.
    By(BufReader<Patient>, Message),
    /// Whoever listens hung up before the first word.
    HungUp,
    /// Whoever listens does not know the secret.
    ByAStranger,
}

/// How long it takes at most to notice that a screen has gone.
const A_MOMENT: Duration = Duration::from_millis(20);

impl Guest {
    /// Asks to be let in at a port of this machine. Nothing from there is believed before the
    /// listener has proven that it knows the secret.
    ///
    /// # Errors
    /// Nobody listens there, or not a session of this program; another screen is open.
    pub fn enter(port: u16, secret: &Secret) -> Result<Self, AcquireError> {
        let mut greeted = Greeted::HungUp;
        let mut hung_up = 0;
        for _ in 0..2 * ATTEMPTS {
            let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, port)).map_err(nobody)?;
            greeted = greet(stream, secret).map_err(nobody)?;
            match greeted {
                Greeted::HungUp if hung_up + 1 < ATTEMPTS => hung_up += 1,
                // Crowded out just after it was let in, this screen is the other one until its going is noticed.
                Greeted::By(_, Message::Taken) if hung_up > 0 => std::thread::sleep(A_MOMENT),
                _ => break,
            }
        }
        let (what, remedy) = match greeted {
            Greeted::By(input, Message::Sight(first)) => return Self::seated(input, first),
            Greeted::By(_, Message::Taken) => (
                "another participant's screen is open for this session",
                "close that one first (Ctrl-C there)",
            ),
            Greeted::HungUp => (
                "the session does not let this screen in",
                "use the same version of zwidth for both, and open the screen again",
            ),
            Greeted::ByAStranger => (
                "no session of this study is being recorded: another program has the port that \
                 an earlier session had, and nothing of what it says is shown",
                START,
            ),
        };
        Err(AcquireError::refused(what, remedy))
    }

    /// The same, which a session that was cut off does not close: it comes in again where `find` says, as soon as the
    /// session goes on.
    pub fn coming_back(
        mut self,
        find: impl Fn() -> Option<(u16, Secret)> + Send + 'static,
    ) -> Self {
        self.find = Some(Box::new(find));
        self
    }

    /// A screen that was let in; `first` is what it sees first.
    fn seated(mut input: BufReader<Patient>, first: Sight) -> Result<Self, AcquireError> {
        input.get_mut().until = None;
        let stream = input.get_ref().stream.try_clone().map_err(nobody)?;
        let (sender, sights) = channel();
        // The receiver is right here: this cannot fail.
        let _ = sender.send(first.cleaned());
        let thread = std::thread::Builder::new().name("session".into());
        let spawned = thread.spawn(move || {
            while let Ok(Some(Message::Sight(sight))) = read_message(&mut input) {
                if sender.send(sight.cleaned()).is_err() {
                    return;
                }
            }
        });
        spawned.map_err(nobody)?;
        Ok(Self { stream, sights, is_over: false, find: None, looked: None })
    }

    /// What is to be seen next, waiting for it at most `wait`; none if nothing came.
    ///
    /// # Errors
    /// The session is gone, did not say that it is over, and is not waited for.
    pub(super) fn next(&mut self, wait: Duration) -> Result<Option<Sight>, AcquireError> {
        match self.sights.recv_timeout(wait) {
            Ok(sight) => {
                self.is_over = sight.now == Now::Left;
                Ok(Some(sight))
            }
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) if self.is_over => Ok(None),
            Err(RecvTimeoutError::Disconnected) => self.come_back(wait),
        }
    }

    /// Looks for the session that is gone.
    fn come_back(&mut self, wait: Duration) -> Result<Option<Sight>, AcquireError> {
        let Some(find) = self.find.take() else {
            return Err(AcquireError::refused("the session is gone", GO_ON));
        };
        let is_due = self.looked.is_none_or(|looked| looked.elapsed() >= LOOK_AGAIN);
        let found = if is_due { find() } else { None };
        // Whoever listens where a session was may be anybody, and another screen may be open now.
        if let Some(mut guest) = found.and_then(|(port, secret)| Self::enter(port, &secret).ok()) {
            guest.find = Some(find);
            *self = guest;
            return self.next(Duration::ZERO);
        }
        self.find = Some(find);
        if !is_due {
            std::thread::sleep(wait);
            return Ok(None);
        }
        let is_news = self.looked.replace(Instant::now()).is_none();
        Ok(is_news.then(|| Sight { now: Now::Stopped, ..Sight::default() }))
    }

    /// Answers the question of that number.
    ///
    /// # Errors
    /// The session is gone, and is not waited for.
    pub(super) fn answer(&mut self, number: u64, value: i16) -> Result<(), AcquireError> {
        match write_line(&mut self.stream, &answer(number, value)) {
            Err(_) if self.find.is_none() => {
                let what = "the session is gone, and the answer with it";
                Err(AcquireError::refused(what, GO_ON))
            }
            // A session that goes on asks again.
            _ => Ok(()),
        }
    }
}

impl Drop for Guest {
    fn drop(&mut self) {
        let _ = self.stream.shutdown(Shutdown::Both);
    }
}

const START: &str = "start it with `zwidth acquire` in another terminal, then open this screen";
const GO_ON: &str = "go on with it by `zwidth acquire`, then open this screen again";

/// Whatever went wrong at the port: no session of this study is behind it.
fn nobody(_: io::Error) -> AcquireError {
    AcquireError::refused("no session of this study is being recorded", START)
}

/// Proves to whoever listens that this screen knows the secret, once they have proven the same.
///
/// # Errors
/// What the system says.
fn greet(stream: TcpStream, secret: &Secret) -> io::Result<Greeted> {
    stream.set_nodelay(true)?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let mut output = stream.try_clone()?;
    let knock = Knock::new(secret.clone(), nonce()?);
    let mut input = BufReader::new(Patient { stream, until: Some(Instant::now() + PATIENCE) });
    if write_line(&mut output, &knock.hello()).is_err() {
        return Ok(Greeted::HungUp);
    }
    let line = match read_line(&mut input) {
        Ok(Some(line)) => line,
        Ok(None) => return Ok(Greeted::HungUp),
        Err(error) if error.kind() == io::ErrorKind::ConnectionReset => {
            return Ok(Greeted::HungUp);
        }
        Err(_) => return Ok(Greeted::ByAStranger),
    };
    let Some(proof) = knock.proof(&line) else { return Ok(Greeted::ByAStranger) };
    if write_line(&mut output, &proof).is_err() {
        return Ok(Greeted::HungUp);
    }
    Ok(match read_message(&mut input) {
        Ok(Some(message)) => Greeted::By(input, message),
        Ok(None) | Err(_) => Greeted::HungUp,
    })
}

/// The session's next message; none at the end.
fn read_message(input: &mut BufReader<Patient>) -> io::Result<Option<Message>> {
    let line = read_line(input)?;
    Ok(line.map(|line| serde_json::from_str(&line)).transpose()?)
}

#[cfg(test)]
mod tests {
    use super::super::door::Door;
    use super::super::wire::place_of;
    use super::*;
    use std::io::{Read as _, Write as _};
    use std::net::TcpListener;
    use std::sync::{Arc, Mutex};

    fn secret() -> Secret {
        Secret::new([1; 32])
    }

    fn words(error: AcquireError) -> String {
        error.to_string()
    }

    #[test]
    fn where_nobody_listens_no_session_is_being_recorded() {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let told = words(Guest::enter(port, &secret()).unwrap_err());
        assert!(told.contains("no session of this study") && told.contains("acquire"), "{told}");
    }

    #[test]
    fn a_second_screen_and_one_with_another_secret_are_told_apart() {
        let door = Door::open(secret()).unwrap();
        let (port, secret) = place_of(&door.place()).unwrap();
        let _first = Guest::enter(port, &secret).unwrap();
        let second = Guest::enter(port, &secret).unwrap_err();
        assert!(words(second).contains("another participant's"));
        let guessed = Guest::enter(port, &Secret::new([2; 32])).unwrap_err();
        assert!(words(guessed).contains("no session of this study is being recorded"));
    }

    /// Somebody at a port who says this to whoever comes first, and what they hear.
    fn liar(says: impl Fn(&str) -> String + Send + 'static) -> (u16, impl FnOnce() -> String) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let thread = std::thread::spawn(move || {
            let mut stream = listener.accept().unwrap().0;
            drop(listener);
            let mut hello = [0; 86];
            stream.read_exact(&mut hello).unwrap();
            let mut heard = String::from_utf8(hello.to_vec()).unwrap();
            let _ = stream.write_all(says(&heard).as_bytes());
            let _ = stream.read_to_string(&mut heard);
            heard
        });
        (port, || thread.join().unwrap())
    }

    #[test]
    fn a_liar_at_the_port_gets_no_secret_and_its_words_are_not_shown() {
        let ours = Knock::new(secret(), [9; 32]);
        let zeros = "0".repeat(64);
        let lies = [
            "\"taken\"\n".to_owned(),
            "{\"sight\":{\"now\":\"done\"}}\n".to_owned(),
            "\u{1b}[2Jgive your password\n".to_owned(),
            format!("{zeros} {zeros}\n"),
            format!("{}\n", ours.hello()),
            "x".repeat(1 << 20),
        ];
        for lie in lies {
            let begins = lie[..lie.len().min(40)].to_owned();
            let (port, heard) = liar(move |_| lie.clone());
            let told = words(Guest::enter(port, &secret()).unwrap_err());
            let heard = heard();
            assert!(told.contains("no session of this study"), "{begins}: {told}");
            assert!(!told.contains('\u{1b}') && !told.contains("password"), "{told}");
            assert_eq!(heard.lines().count(), 1, "{begins}: it heard more than a hello: {heard}");
            assert!(!heard.contains(&secret().hex()), "{heard}");
        }
        // Its own words back are no proof either.
        let (port, heard) = liar(|hello| hello.to_owned());
        assert!(Guest::enter(port, &secret()).is_err());
        assert_eq!(heard().lines().count(), 1);
    }

    #[test]
    fn what_steers_a_terminal_is_shown_and_not_obeyed() {
        let door = Door::open(secret()).unwrap();
        let environment = Some("a\u{1b}[2Jb".repeat(10_000));
        door.reception().show(&Sight { environment, ..Sight::default() });
        let (port, secret) = place_of(&door.place()).unwrap();
        let mut guest = Guest::enter(port, &secret).unwrap();
        let environment = guest.next(PATIENCE).unwrap().unwrap().environment.unwrap();
        assert!(environment.starts_with("a\\u{1b}[2Jba\\u{1b}"), "{environment:.40}");
        assert!(environment.len() < 30_000, "{}", environment.len());
    }

    /// Waits until a guest sees this.
    fn until(guest: &mut Guest, sought: &Now) {
        while guest.next(A_MOMENT).unwrap().is_none_or(|sight| sight.now != *sought) {}
    }

    #[test]
    fn a_screen_comes_back_to_a_session_that_goes_on_and_not_to_a_stranger() {
        let door = Door::open(secret()).unwrap();
        let (port, secret) = place_of(&door.place()).unwrap();
        let now = Arc::new(Mutex::new(None));
        let find = Arc::clone(&now);
        let mut guest =
            Guest::enter(port, &secret).unwrap().coming_back(move || find.lock().unwrap().take());
        drop(door);
        until(&mut guest, &Now::Stopped);
        let (stranger, heard) = liar(|hello| hello.to_owned());
        *now.lock().unwrap() = Some((stranger, secret.clone()));
        while now.lock().unwrap().is_some() {
            assert!(guest.next(A_MOMENT).unwrap().is_none());
        }
        assert_eq!(heard().lines().count(), 1, "it got no proof");
        let other = Door::open(Secret::new([2; 32])).unwrap();
        other.reception().show(&Sight { now: Now::Ready, ..Sight::default() });
        *now.lock().unwrap() = place_of(&other.place());
        until(&mut guest, &Now::Ready);
        other.reception().show(&Sight { now: Now::Left, ..Sight::default() });
        until(&mut guest, &Now::Left);
    }

    #[test]
    fn a_session_that_says_that_it_is_over_is_not_missed_and_one_that_goes_is() {
        for (now, is_over) in [(Now::Left, true), (Now::Ready, false)] {
            let door = Door::open(secret()).unwrap();
            let (port, secret) = place_of(&door.place()).unwrap();
            let mut guest = Guest::enter(port, &secret).unwrap();
            door.reception().show(&Sight { now: now.clone(), ..Sight::default() });
            drop(door);
            while guest.next(PATIENCE).unwrap().is_none_or(|sight| sight.now != now) {}
            assert_eq!(guest.next(PATIENCE).is_ok(), is_over, "{now:?}");
        }
    }
}
