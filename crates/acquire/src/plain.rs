//! Plain mode: lines in, lines out, for scripts, tests and screen readers.
//!
//! Lines in: `start`, `answer N` (or `N` alone), `skip`, `hold`, `repeat`, `exclude REASON`,
//! `note TEXT`, `stop`, `quit`; of any trial that ended `trial N` and one of `exclude REASON`,
//! `note TEXT`, `repeat`, `ask`, which asks its questions again. They are taken in order, each when
//! the session waits for somebody, so a script may write all of them at once. Only `stop` is obeyed
//! the moment it is read; lines before it that were not yet taken are dropped. The end of the input
//! counts as `quit`.
//!
//! Lines out: one per phase, one per message.

use crate::flow::About;
use crate::{AcquireError, Front, Input, Phase, View};
use std::collections::VecDeque;
use std::io::{BufRead, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;
use zwidth_study::{Kind, printable};

/// Lines in, lines out.
#[derive(Debug)]
pub struct Plain<W> {
    lines: Receiver<String>,
    waiting: VecDeque<Result<Input, String>>,
    out: W,
    view: View,
    shown: Option<(Phase, bool, Option<u32>)>,
    /// Whether the end of the input ends the session.
    ends: bool,
}

impl<W: Write> Plain<W> {
    /// Reads `input` on a thread of its own; `stop` is raised as soon as that word is read. `ends`:
    /// the end of the input ends the session.
    pub fn new(
        input: impl BufRead + Send + 'static,
        out: W,
        stop: Arc<AtomicBool>,
        ends: bool,
    ) -> Self {
        let lines = read_lines(input, move |line| {
            if parse(line) == Ok(Input::Stop) {
                stop.store(true, Ordering::SeqCst);
            }
        });
        Self { lines, waiting: VecDeque::new(), out, view: View::default(), shown: None, ends }
    }

    fn take(&mut self, line: &str) {
        let input = parse(line);
        if input == Ok(Input::Stop) {
            self.waiting.clear();
        }
        self.waiting.push_back(input);
    }

    /// Whether the session can do something with this input now.
    fn is_time_for(&self, input: &Result<Input, String>) -> bool {
        let busy = match self.view.phase {
            Phase::Check | Phase::Homing | Phase::Trial { .. } => true,
            Phase::Pause { .. } => !self.view.held,
            _ => false,
        };
        !busy || matches!(input, Ok(Input::Stop | Input::Note(_)) | Err(_))
    }
}

impl<W: Write> Front for Plain<W> {
    fn show(&mut self, view: &View) -> Result<(), AcquireError> {
        // Of those since the last view only as many are still kept.
        let fresh = (view.said - self.view.said).min(view.messages.len());
        for message in view.messages.iter().skip(view.messages.len() - fresh) {
            writeln!(self.out, "{}", printable(message))?;
        }
        if let Some(verdict) = view.verdict.as_ref().filter(|_| view.verdict != self.view.verdict) {
            writeln!(self.out, "{}", printable(&verdict.in_words()))?;
        }
        let now = (without_time(&view.phase), view.held, view.trial.as_ref().map(|t| t.trial));
        if self.shown.as_ref() != Some(&now) {
            writeln!(self.out, "{}", printable(&line(view)))?;
            self.shown = Some(now);
        }
        self.out.flush()?;
        self.view.clone_from(view);
        Ok(())
    }

    fn next(&mut self, wait: Duration) -> Result<Option<Input>, AcquireError> {
        while let Ok(line) = self.lines.try_recv() {
            self.take(&line);
        }
        if !self.waiting.front().is_some_and(|input| self.is_time_for(input)) {
            match self.lines.recv_timeout(wait) {
                Ok(line) => self.take(&line),
                Err(RecvTimeoutError::Timeout) => return Ok(None),
                Err(RecvTimeoutError::Disconnected) if self.waiting.is_empty() && self.ends => {
                    self.waiting.push_back(Ok(Input::Quit));
                }
                // The input has ended and the session goes on: not in a busy loop.
                Err(RecvTimeoutError::Disconnected) => std::thread::sleep(wait),
            }
        }
        match self.waiting.pop_front() {
            Some(input) if !self.is_time_for(&input) => {
                self.waiting.push_front(input);
                Ok(None)
            }
            Some(Ok(input)) => Ok(Some(input)),
            Some(Err(words)) => {
                writeln!(self.out, "{}", printable(&words))?;
                Ok(None)
            }
            None => Ok(None),
        }
    }
}

/// Lines without the space around them, but for blank ones; read on a thread of its own, which ends
/// with the input or with the program: nobody waits for a line that may never come. `hear` gets
/// each as soon as it is read.
pub(crate) fn read_lines(
    input: impl BufRead + Send + 'static,
    hear: impl Fn(&str) + Send + 'static,
) -> Receiver<String> {
    let (sender, lines) = channel();
    std::thread::spawn(move || {
        // By bytes: a letter in another encoding must not end the session.
        for bytes in input.split(b'\n').map_while(Result::ok) {
            let line = String::from_utf8_lossy(&bytes).trim().to_owned();
            if line.is_empty() {
                continue;
            }
            hear(&line);
            if sender.send(line).is_err() {
                break;
            }
        }
    });
    lines
}

/// A line's input; the error says what may be said.
fn parse(line: &str) -> Result<Input, String> {
    let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    match (word, rest.trim()) {
        ("start", "") => Ok(Input::Start),
        ("yes", "") => Ok(Input::Yes),
        ("skip", "") => Ok(Input::Skip),
        ("repeat", "") => Ok(Input::Repeat),
        ("hold", "") => Ok(Input::Hold),
        ("stop", _) => Ok(Input::Stop),
        ("quit", "") => Ok(Input::Quit),
        ("trial", about) => parse_about(about),
        ("exclude", reason) => Ok(Input::Exclude(reason.to_owned())),
        ("note", text) => Ok(Input::Note(text.to_owned())),
        ("answer", n) => n
            .parse()
            .map(Input::Answer)
            .map_err(|_| format!("'{n}' is not an answer: give a number")),
        (n, "") if n.parse::<i16>().is_ok() => Ok(Input::Answer(n.parse().unwrap_or(0))),
        _ => Err(format!(
            "'{line}' is not understood: start, yes, answer NUMBER, skip, hold, repeat, exclude REASON, note TEXT, trial NUMBER and \
             one of those three or ask, stop, quit"
        )),
    }
}

/// What is said of a trial: its number, and what.
fn parse_about(words: &str) -> Result<Input, String> {
    let (number, rest) = words.split_once(char::is_whitespace).unwrap_or((words, ""));
    let trial = number.parse().map_err(|_| format!("'{number}' is no trial: a number"))?;
    let (word, text) = rest.trim().split_once(char::is_whitespace).unwrap_or((rest.trim(), ""));
    let about = match (word, text.trim()) {
        ("exclude", reason) => About::Exclude(reason.to_owned()),
        ("note", text) => About::Note(text.to_owned()),
        ("repeat", "") => About::Repeat,
        ("ask", "") => About::Ask,
        _ => {
            return Err(format!(
                "'{rest}' is not understood of trial {trial}: exclude REASON, note TEXT, repeat, ask"
            ));
        }
    };
    Ok(Input::Of(trial, about))
}

/// The phase without what runs on in it.
fn without_time(phase: &Phase) -> Phase {
    match phase {
        Phase::Trial { limit_s, .. } => Phase::Trial { t_s: 0.0, limit_s: *limit_s },
        Phase::Pause { pause_s, .. } => Phase::Pause { left_s: 0.0, pause_s: *pause_s },
        phase => phase.clone(),
    }
}

/// A phase as a line.
fn line(view: &View) -> String {
    match &view.phase {
        Phase::Check => format!("check {}", view.device),
        Phase::Step { what, moves: false } => {
            format!("step {what} (start begins, skip leaves it out)")
        }
        Phase::Step { what, moves: true } => {
            format!("step {what} (yes lets them, skip leaves it out)")
        }
        Phase::AtStop => "hold the lever against its lower stop, then say start".to_owned(),
        Phase::Homing => "homing: lever against its lower stop".to_owned(),
        Phase::Ready => format!("ready {}", trial(view)),
        Phase::Trial { limit_s, .. } => format!("trial {}, at most {limit_s} s", trial(view)),
        Phase::Question { text, scale } => {
            let word =
                |a: i16| scale.word(a).map(|word| format!("{a} {word}")).unwrap_or(a.to_string());
            if scale.is_nominal() {
                let answers: Vec<String> = scale.answers().into_iter().map(word).collect();
                return format!("question {text} ({})", answers.join(", "));
            }
            let [first, last] = [scale.lowest(), scale.highest()].map(word);
            let steps = scale.range().split_once(" in ").map(|(_, steps)| format!(", in {steps}"));
            format!("question {text} ({first} to {last}{})", steps.unwrap_or_default())
        }
        Phase::Pause { .. } if view.held => "pause, held: start or hold ends it".to_owned(),
        Phase::Pause { left_s, .. } => format!("pause {left_s:.1} s"),
        Phase::Stopped { why } => format!("stopped {why} (start goes on, quit ends)"),
        Phase::Done => format!("done {} of {}", view.done, view.total),
        Phase::Left => format!("left {} of {}", view.done, view.total),
    }
}

/// A trial in words: `7 (place 4 of 39) spring passive`.
fn trial(view: &View) -> String {
    let Some(t) = &view.trial else { return String::new() };
    let mut words = format!("{} (place {} of {}) {}", t.trial, t.place, view.total, t.environment);
    if let Some(mode) = &t.mode {
        words += &format!(" × {mode}");
    }
    if t.kind == Kind::Familiarisation {
        words += ", familiarisation";
    }
    if let Some(task) = &view.task {
        words += &format!(", {}", task.in_words());
    }
    if let Some(trial) = t.repeats {
        words += &format!(", again for trial {trial}");
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    const SOON: Duration = Duration::from_millis(1);

    fn plain(script: &'static str) -> (Plain<Vec<u8>>, Arc<AtomicBool>) {
        let stop = Arc::new(AtomicBool::new(false));
        (Plain::new(Cursor::new(script), Vec::new(), Arc::clone(&stop), true), stop)
    }

    /// The next input in a phase, however long the reading thread takes.
    fn next(plain: &mut Plain<Vec<u8>>, phase: Phase) -> Input {
        plain.show(&View { phase, ..View::default() }).unwrap();
        loop {
            if let Some(input) = plain.next(SOON).unwrap() {
                return input;
            }
        }
    }

    fn question() -> Phase {
        Phase::Question { text: String::new(), scale: Default::default() }
    }

    #[test]
    fn a_script_is_taken_in_order_and_its_end_is_quit() {
        let (mut plain, _) =
            plain("start\n\nanswer 4\nexclude  slipped off \nnote a b\n3\nrepeat\n");
        assert_eq!(next(&mut plain, Phase::Ready), Input::Start);
        assert_eq!(next(&mut plain, question()), Input::Answer(4));
        assert_eq!(next(&mut plain, Phase::Ready), Input::Exclude("slipped off".into()));
        assert_eq!(next(&mut plain, Phase::Ready), Input::Note("a b".into()));
        assert_eq!(next(&mut plain, question()), Input::Answer(3));
        assert_eq!(next(&mut plain, Phase::Ready), Input::Repeat);
        assert_eq!(next(&mut plain, Phase::Ready), Input::Quit);
    }

    #[test]
    fn any_trial_is_spoken_of_by_its_number() {
        let (mut plain, _) = plain(
            "trial 3 exclude  the phone rang\ntrial 3 note a b\ntrial 12 repeat\ntrial 1 ask\ntrial x ask\ntrial 1\n",
        );
        let expect = [
            (3, About::Exclude("the phone rang".into())),
            (3, About::Note("a b".into())),
            (12, About::Repeat),
            (1, About::Ask),
        ];
        for (trial, about) in expect {
            assert_eq!(next(&mut plain, Phase::Ready), Input::Of(trial, about));
        }
        assert_eq!(next(&mut plain, Phase::Ready), Input::Quit);
        let told = String::from_utf8(plain.out).unwrap();
        assert!(
            told.contains("'x' is no trial") && told.contains("understood of trial 1"),
            "{told}"
        );
    }

    #[test]
    fn a_letter_in_another_encoding_ends_nothing() {
        let script: &'static [u8] = b"note w\xf6rld\r\nstart\n";
        let mut plain = Plain::new(Cursor::new(script), Vec::new(), Arc::default(), true);
        assert_eq!(next(&mut plain, Phase::Ready), Input::Note("w\u{fffd}rld".into()));
        assert_eq!(next(&mut plain, Phase::Ready), Input::Start);
    }

    #[test]
    fn while_a_trial_runs_lines_wait_for_its_end() {
        let (mut plain, _) = plain("answer 2\n");
        plain
            .show(&View { phase: Phase::Trial { t_s: 0.0, limit_s: 4.0 }, ..View::default() })
            .unwrap();
        for _ in 0..20 {
            assert_eq!(plain.next(SOON).unwrap(), None);
        }
        assert_eq!(next(&mut plain, question()), Input::Answer(2));
    }

    #[test]
    fn stop_is_obeyed_before_everything_that_waits() {
        let (mut plain, stop) = plain("start\nanswer 4\nstop\nstart\n");
        while !stop.load(Ordering::SeqCst) {
            std::thread::yield_now();
        }
        let trial = Phase::Trial { t_s: 0.0, limit_s: 4.0 };
        assert_eq!(next(&mut plain, trial), Input::Stop);
        assert_eq!(next(&mut plain, Phase::Ready), Input::Start);
        assert_eq!(next(&mut plain, Phase::Ready), Input::Quit);
    }

    #[test]
    fn what_is_not_understood_is_told_and_changes_nothing() {
        let (mut plain, _) = plain("begin\nanswer much\n\u{1b}[2J\nquit\n");
        assert_eq!(next(&mut plain, Phase::Ready), Input::Quit);
        let told = String::from_utf8(plain.out).unwrap();
        assert!(
            told.contains("'begin' is not understood: start")
                && told.contains("'much' is not an answer")
                && told.contains("'\\u{1b}[2J' is not understood"),
            "{told}"
        );
    }

    #[test]
    fn a_question_for_the_mode_lists_every_mode() {
        let scale =
            zwidth_study::AnswerScale::Modes(["Motor", "Brake"].map(str::to_owned).to_vec());
        let view = View {
            phase: Phase::Question { text: "Which mode was it?".into(), scale },
            ..View::default()
        };
        let expect = "question Which mode was it? (0 do not know, 1 Motor, 2 Brake)";
        assert_eq!(line(&view), expect);
    }

    #[test]
    fn a_phase_is_one_line_however_often_it_is_shown_and_every_message_another() {
        let (mut plain, _) = plain("");
        let mut view =
            View { phase: Phase::Pause { left_s: 5.0, pause_s: 5.0 }, ..View::default() };
        view.say("one");
        plain.show(&view).unwrap();
        view.phase = Phase::Pause { left_s: 4.0, pause_s: 5.0 };
        view.say("two");
        plain.show(&view).unwrap();
        assert_eq!(String::from_utf8(plain.out).unwrap(), "one\npause 5.0 s\ntwo\n");
    }
}
