//! The session's end of the line without the line: it takes bytes from a screen and gives lines for
//! it. It knows no socket, so a simulation can be a screen too.

use super::proof::{Nonce, Nonces, Secret};
use super::sight::Sight;
use super::wire::{Message, read_answer};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Longest line of a screen, bytes: its first one has 85.
const MOST_LINE: usize = 128;

/// What a session shows to the participant's screen and receives from it. One screen at a time is
/// let in, and must prove that it knows the secret.
#[derive(Debug)]
pub struct Reception {
    secret: Secret,
    state: Mutex<State>,
    changed: Condvar,
}

/// The lock is held for a copy, never for input or output.
#[derive(Debug, Default)]
struct State {
    sight: Sight,
    /// How many sights there were.
    shown: u64,
    /// How many screens were let in.
    admitted: u64,
    /// The screen that is in, by its number.
    inside: Option<u64>,
    /// How many tell a screen what is to be seen.
    tellers: usize,
    /// The first answer to the open question that is one of its answers.
    answer: Option<i16>,
    closing: bool,
}

impl Reception {
    /// For screens that know the secret.
    pub fn new(secret: Secret) -> Arc<Self> {
        Arc::new(Self { secret, state: Mutex::default(), changed: Condvar::new() })
    }

    pub(super) fn secret(&self) -> &Secret {
        &self.secret
    }

    /// A panic elsewhere leaves plain values behind.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows a sight to the screen that is in, or to the next one. What was answered to another
    /// question is forgotten.
    pub(super) fn show(&self, sight: &Sight) {
        let mut state = self.lock();
        if state.sight == *sight {
            return;
        }
        let [before, now] =
            [&state.sight, sight].map(|sight| sight.question().map(|question| question.number));
        if before != now {
            state.answer = None;
        }
        state.sight.clone_from(sight);
        state.shown += 1;
        drop(state);
        self.changed.notify_all();
    }

    /// Whether a screen is in.
    pub(super) fn is_open(&self) -> bool {
        self.lock().inside.is_some()
    }

    /// The answer that a screen gave to the open question, once.
    pub(super) fn answer(&self) -> Option<i16> {
        self.lock().answer.take()
    }

    /// The session ends: the screen is told the last sight, and no other is let in.
    pub(super) fn close(&self) {
        self.lock().closing = true;
        self.changed.notify_all();
    }

    pub(super) fn is_closing(&self) -> bool {
        self.lock().closing
    }

    /// Waits until the screen that is in was told everything, but no longer than that.
    pub(super) fn wait_for_tellers(&self, longest: Duration) {
        let waited =
            self.changed.wait_timeout_while(self.lock(), longest, |state| state.tellers > 0);
        drop(waited.unwrap_or_else(PoisonError::into_inner));
    }
}

/// One screen at the session's end: from its first byte to its last.
#[derive(Debug)]
pub struct Visit {
    reception: Arc<Reception>,
    nonce: Nonce,
    stage: Stage,
    /// What came of a line that has not ended.
    line: Vec<u8>,
}

#[derive(Debug, Clone, Copy)]
enum Stage {
    /// It has said nothing.
    Outside,
    /// It has said its number, and now has to prove that it knows the secret.
    Knocking(Nonces),
    /// It is in, under this number.
    Inside(u64),
}

/// A screen that is sent away, with the message to it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SentAway(pub String);

impl Visit {
    /// Somebody who came, and a number that was never used before.
    pub fn new(reception: &Arc<Reception>, nonce: Nonce) -> Self {
        let reception = Arc::clone(reception);
        Self { reception, nonce, stage: Stage::Outside, line: Vec::new() }
    }

    /// Takes the received bytes; returns the reply.
    ///
    /// # Errors
    /// It is none of ours, or another screen is in: the line is to be closed.
    pub fn take(&mut self, bytes: &[u8]) -> Result<String, SentAway> {
        let mut back = String::new();
        for byte in bytes {
            if *byte != b'\n' {
                self.line.push(*byte);
                // No screen of ours sends so much without an end.
                if self.line.len() >= MOST_LINE {
                    return Err(SentAway(String::new()));
                }
                continue;
            }
            let line = std::mem::take(&mut self.line);
            back += &self.take_line(&String::from_utf8_lossy(&line))?;
        }
        Ok(back)
    }

    fn take_line(&mut self, line: &str) -> Result<String, SentAway> {
        let sent_away = SentAway(String::new());
        match self.stage {
            Stage::Outside => {
                let nonces = Nonces::of_hello(line, self.nonce).ok_or(sent_away)?;
                self.stage = Stage::Knocking(nonces);
                Ok(nonces.session_line(&self.reception.secret) + "\n")
            }
            Stage::Knocking(nonces) => {
                if !nonces.is_proven_by(&self.reception.secret, line) {
                    return Err(sent_away);
                }
                let mut state = self.reception.lock();
                if state.inside.is_some() || state.closing {
                    return Err(SentAway(to_line(&Message::Taken)));
                }
                state.admitted += 1;
                state.inside = Some(state.admitted);
                self.stage = Stage::Inside(state.admitted);
                Ok(String::new())
            }
            Stage::Inside(_) => {
                let mut state = self.reception.lock();
                let open = state.sight.question();
                let answer = read_answer(line).filter(|(number, value)| {
                    open.is_some_and(|open| open.number == *number && open.has(*value))
                });
                state.answer = state.answer.or(answer.map(|(_, value)| value));
                Ok(String::new())
            }
        }
    }

    /// Whether it was let in; then, who tells it what is to be seen.
    pub fn teller(&self) -> Option<Teller> {
        let Stage::Inside(number) = self.stage else { return None };
        self.reception.lock().tellers += 1;
        Some(Teller { reception: Arc::clone(&self.reception), number, last: None })
    }
}

impl Drop for Visit {
    fn drop(&mut self) {
        if let Stage::Inside(number) = self.stage {
            let mut state = self.reception.lock();
            // Another may be in by now.
            state.inside = state.inside.filter(|inside| *inside != number);
            drop(state);
            self.reception.changed.notify_all();
        }
    }
}

/// Tells a screen that is in what is to be seen.
#[derive(Debug)]
pub struct Teller {
    reception: Arc<Reception>,
    number: u64,
    last: Option<u64>,
}

impl Teller {
    /// The newest sight as a line, if it is another than the last one.
    pub fn news(&mut self) -> Option<String> {
        let state = self.reception.lock();
        let is_news = state.inside == Some(self.number) && self.last != Some(state.shown);
        self.last = Some(state.shown);
        is_news.then(|| to_line(&Message::Sight(state.sight.clone())))
    }

    /// The same, waiting for it; none if that screen is gone, or the session is over.
    pub(super) fn wait_for_news(&mut self) -> Option<String> {
        let waited = self.reception.changed.wait_while(self.reception.lock(), |state| {
            state.inside == Some(self.number) && !state.closing && self.last == Some(state.shown)
        });
        drop(waited.unwrap_or_else(PoisonError::into_inner));
        self.news()
    }
}

impl Drop for Teller {
    fn drop(&mut self) {
        self.reception.lock().tellers -= 1;
        self.reception.changed.notify_all();
    }
}

fn to_line(message: &Message) -> String {
    serde_json::to_string(message).unwrap_or_default() + "\n"
}

#[cfg(test)]
mod tests {
    use super::super::proof::Knock;
    use super::super::sight::{Choice, Now, OpenQuestion};
    use super::super::wire::answer;
    use super::*;

    const SECRET: [u8; 32] = [1; 32];
    const GONE: SentAway = SentAway(String::new());

    fn reception() -> Arc<Reception> {
        Reception::new(Secret::new(SECRET))
    }

    /// A screen that knows the secret, and how that ended.
    fn screen(reception: &Arc<Reception>, nonce: u8) -> (Visit, Result<String, SentAway>) {
        let mut visit = Visit::new(reception, [nonce; 32]);
        let knock = Knock::new(Secret::new(SECRET), [nonce + 100; 32]);
        let session = visit.take((knock.hello() + "\n").as_bytes()).unwrap();
        let proof = knock.proof(session.trim_end()).unwrap();
        let end = visit.take((proof + "\n").as_bytes());
        (visit, end)
    }

    fn question(number: u64) -> Sight {
        let choices = (1..=5).map(|value| Choice { value, word: None }).collect();
        let asked = OpenQuestion { number, choices, ..OpenQuestion::default() };
        Sight { now: Now::Question(asked), ..Sight::default() }
    }

    #[test]
    fn any_split_of_a_screens_bytes_is_understood_alike() {
        let knock = Knock::new(Secret::new(SECRET), [2; 32]);
        let hello = knock.hello() + "\n";
        let whole = Visit::new(&reception(), [3; 32]).take(hello.as_bytes()).unwrap();
        let proof = knock.proof(whole.trim_end()).unwrap();
        let said = hello + &proof + "\nstart\n" + &answer(7, 4) + "\n";
        for size in 1..said.len() {
            let reception = reception();
            reception.show(&question(7));
            let mut visit = Visit::new(&reception, [3; 32]);
            let back: String =
                said.as_bytes().chunks(size).map(|bytes| visit.take(bytes).unwrap()).collect();
            assert_eq!((back, reception.answer()), (whole.clone(), Some(4)), "{size}");
        }
    }

    #[test]
    fn a_replayed_proof_and_any_other_line_send_their_visitor_away_without_a_word() {
        let reception = reception();
        let knock = Knock::new(Secret::new(SECRET), [2; 32]);
        let mut overheard = Visit::new(&reception, [3; 32]);
        let session = overheard.take((knock.hello() + "\n").as_bytes()).unwrap();
        let proof = knock.proof(session.trim_end()).unwrap() + "\n";
        let mut replay = Visit::new(&reception, [4; 32]);
        replay.take((knock.hello() + "\n").as_bytes()).unwrap();
        assert_eq!(replay.take(proof.as_bytes()), Err(GONE));
        for line in ["GET / HTTP/1.1\n", "\n", "answer 1 4\n", "\u{1b}[2J\n", &"x".repeat(200)] {
            assert_eq!(Visit::new(&reception, [5; 32]).take(line.as_bytes()), Err(GONE), "{line}");
        }
        assert!(!reception.is_open());
        overheard.take(proof.as_bytes()).unwrap();
        assert!(reception.is_open());
    }

    #[test]
    fn a_second_screen_is_told_so_and_let_in_once_the_first_is_gone() {
        let reception = reception();
        let (first, end) = screen(&reception, 1);
        assert_eq!(end, Ok(String::new()));
        assert_eq!(screen(&reception, 2).1, Err(SentAway("\"taken\"\n".into())));
        assert!(reception.is_open());
        drop(first);
        assert!(!reception.is_open());
        assert_eq!(screen(&reception, 3).1, Ok(String::new()));
    }

    #[test]
    fn only_an_answer_of_the_open_question_is_heard_and_the_first_one_alone() {
        let reception = reception();
        let (mut visit, _) = screen(&reception, 1);
        let mut say = |line: String| visit.take((line + "\n").as_bytes()).unwrap();
        reception.show(&question(1));
        for (number, value) in [(1, 6), (1, -32768), (2, 3), (0, 3)] {
            say(answer(number, value));
            assert_eq!(reception.answer(), None, "{number} {value}");
        }
        (2..=5).for_each(|value| drop(say(answer(1, value))));
        assert_eq!([reception.answer(), reception.answer()], [Some(2), None]);
        say(answer(1, 5));
        reception.show(&question(2));
        assert_eq!(reception.answer(), None, "it belonged to the question before");
        reception.show(&Sight::default());
        say(answer(2, 5));
        assert_eq!(reception.answer(), None);
    }

    #[test]
    fn what_is_to_be_seen_is_told_once() {
        let reception = reception();
        let (visit, _) = screen(&reception, 1);
        let mut teller = visit.teller().unwrap();
        reception.show(&question(1));
        assert!(teller.news().unwrap().contains("question"));
        assert_eq!(teller.news(), None);
        drop(visit);
        reception.show(&question(2));
        assert_eq!(teller.news(), None, "that screen is gone");
        reception.wait_for_tellers(Duration::ZERO);
    }
}
