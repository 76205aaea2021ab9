//! The participant's screen as lines, for scripts, tests and screen readers.
//!
//! It writes one line for each thing to do. A number on a line of input answers the question.
//! Numbers are taken in order, each when a question is open, so a script may write all of them at
//! once.

use super::guest::Guest;
use super::sight::{Now, OpenQuestion, Sight};
use crate::AcquireError;
use crate::plain::read_lines;
use std::collections::VecDeque;
use std::io::{self, BufRead, IsTerminal as _, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::TryRecvError;
use std::time::Duration;
use zwidth_study::printable;

/// Longest wait for the session, each time.
const WAIT: Duration = Duration::from_millis(20);

/// Shows a session as lines until it is over, nobody takes the lines any more, or `quit` is raised;
/// whether it is over.
///
/// # Errors
/// The session is gone.
pub fn show_lines(
    mut guest: Guest,
    input: impl BufRead + Send + 'static,
    mut out: impl Write,
    quit: &AtomicBool,
) -> Result<bool, AcquireError> {
    let typed = read_lines(input, |_| {});
    let is_at_terminal = io::stdin().is_terminal();
    let mut waiting = VecDeque::new();
    let mut shown = None;
    let mut open = None;
    let mut answered = None;
    while !quit.load(Ordering::SeqCst) {
        if let Some(sight) = guest.next(WAIT)? {
            // Numbers begin again in a session that goes on after a crash; its questions were closed before.
            answered = answered.filter(|_| sight.question().is_some());
            open = sight.question().filter(|question| answered != Some(question.number)).cloned();
            let line = line(&sight);
            // A pause that counts down stays one line.
            if shown.as_ref() != Some(&line) {
                if writeln!(out, "{line}").and_then(|()| out.flush()).is_err() {
                    break;
                }
                shown = Some(line);
            }
            if sight.now == Now::Left {
                return Ok(true);
            }
        }
        let has_ended = loop {
            match typed.try_recv() {
                Ok(line) => waiting.push_back(line),
                Err(ended) => break ended == TryRecvError::Disconnected,
            }
        };
        // A script may end before the session; a terminal that was hung up is none any more.
        if has_ended && is_at_terminal && !io::stdin().is_terminal() {
            break;
        }
        while let Some(question) = &open {
            let Some(line) = waiting.pop_front() else { break };
            match value(question, &line) {
                Ok(value) => {
                    guest.answer(question.number, value)?;
                    answered = Some(question.number);
                    open = None;
                }
                Err(words) => {
                    if writeln!(out, "{words}").and_then(|()| out.flush()).is_err() {
                        return Ok(false);
                    }
                }
            }
        }
    }
    Ok(false)
}

/// The answer that a line gives; the error says what may be answered.
fn value(question: &OpenQuestion, line: &str) -> Result<i16, String> {
    let value = line.parse().ok().filter(|value| question.has(*value));
    value.ok_or_else(|| format!("'{}' is not an answer: {}", printable(line), question.range))
}

/// What is to be done, as a line.
fn line(sight: &Sight) -> String {
    let practice = if sight.practice { ", practice" } else { "" };
    let interval = sight.interval.map_or(String::new(), |[n, of]| format!(", {n} of {of}"));
    let environment = sight.environment.as_deref().unwrap_or_default();
    let trial = format!("{environment}{practice}{interval}");
    let line = match &sight.now {
        Now::Wait => "wait: the device is being prepared".to_owned(),
        Now::Ready => format!("ready: finger on the lever, {trial}"),
        Now::Go => format!("go: lever forward and back, once, {trial}"),
        Now::Question(open) => {
            let answers: Vec<String> = open.shown().map(|choice| choice.words()).collect();
            format!("question {} ({}: {})", open.text, open.range, answers.join(", "))
        }
        Now::Pause { .. } if sight.is_between() => {
            "the next one follows: finger on the lever".to_owned()
        }
        Now::Pause { .. } => "pause: finger off the lever".to_owned(),
        Now::Held => "pause, held".to_owned(),
        Now::Stopped => "stopped: finger off the lever, wait for the experimenter".to_owned(),
        Now::Done => "done: that was the last trial".to_owned(),
        Now::Left => "left: the session is over".to_owned(),
    };
    match sight.told() {
        Some(word) => format!("{word} {line}"),
        None => line,
    }
}

#[cfg(test)]
mod tests {
    use super::super::door::Door;
    use super::super::proof::Secret;
    use super::super::sight::tests::telling;
    use super::super::wire::place_of;
    use super::*;
    use crate::Phase;
    use std::io::Cursor;
    use zwidth_study::AnswerScale;

    #[test]
    fn numbers_answer_questions_in_order_and_what_is_no_answer_is_told() {
        let door = Door::open(Secret::new([1; 32])).unwrap();
        let (port, secret) = place_of(&door.place()).unwrap();
        let guest = Guest::enter(port, &secret).unwrap();
        let reception = door.reception();
        let lines = std::thread::spawn(move || {
            let mut out = Vec::new();
            let over = show_lines(
                guest,
                Cursor::new("9\n\u{1b}[2J\n4\n\n2\n"),
                &mut out,
                &AtomicBool::default(),
            );
            (over.unwrap(), String::from_utf8(out).unwrap())
        });
        let answers: Vec<i16> = (1..=2)
            .map(|number| {
                let scale = AnswerScale::FivePoint;
                let phase = Phase::Question { text: format!("Question {number}?"), scale };
                reception.show(&Sight::of(&telling(phase), number));
                loop {
                    if let Some(value) = reception.answer() {
                        break value;
                    }
                }
            })
            .collect();
        assert_eq!(answers, [4, 2]);
        reception.show(&Sight::of(&telling(Phase::Left), 2));
        let (is_over, out) = lines.join().unwrap();
        assert!(is_over && out.contains("'9' is not an answer: 1 to 5"), "{out}");
        assert!(out.contains("'\\u{1b}[2J' is not an answer"), "{out}");
        assert!(out.ends_with("left: the session is over\n"), "{out}");
    }
}
