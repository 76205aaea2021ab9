//! What a key means: by the phase, and by what is being typed.
//!
//! **Stop** is the space bar: the largest key, sent as one byte, so that no terminal or multiplexer
//! holds it back to see whether more comes (as they do with Esc). Esc and Ctrl-C stop as well.
//! While a remark is typed, Space types a space, Esc discards the line, and Ctrl-C is the stop key;
//! the screen says so. Nothing can be typed while a trial runs: an open line is dropped.

use crate::flow::About;
use crate::{Input, Phase};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use std::borrow::Cow;
use zwidth_study::AnswerScale;

/// Characters of a remark, at most: three lines of the narrowest screen.
const LONGEST: usize = 200;
/// Characters of a number, at most: any answer's.
const LONGEST_NUMBER: usize = 6;

/// What is typed or asked at the foot of the screen.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Entry {
    /// A remark on a trial: the last one, if none is named.
    Note(Option<u32>, String),
    /// The reason why a trial does not count: the last one, if none is named.
    Exclude(Option<u32>, String),
    /// The number of the trial of which something is to be said.
    Which(String),
    /// That trial: what is to be said of it.
    Trial(u32),
    /// The number of an answer that no single key gives.
    Answer(String),
    /// Yes or no.
    Sure(Ask),
}

/// What is only done after a yes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ask {
    /// Do a trial again: the last one, if none is named.
    Repeat(Option<u32>),
    /// Leave the question without an answer.
    Skip,
    /// End the session here.
    Quit,
}

/// What a key press comes to: what is being typed after it, and what is asked of the session.
pub(super) fn press(
    key: KeyEvent,
    phase: &Phase,
    entry: Option<Entry>,
) -> (Option<Entry>, Option<Input>) {
    if key.kind == KeyEventKind::Release {
        return (entry, None);
    }
    let running = matches!(phase, Phase::Trial { .. });
    let has_control = key.modifiers.contains(KeyModifiers::CONTROL);
    match entry.filter(|_| !running) {
        _ if has_control && key.code == KeyCode::Char('c') => (None, Some(Input::Stop)),
        // No other key with Ctrl types its letter.
        entry if has_control => (entry, None),
        Some(Entry::Note(trial, text)) => type_text(
            key.code,
            text,
            |text| Entry::Note(trial, text),
            |text| input_about(trial, text, Input::Note, About::Note),
        ),
        Some(Entry::Exclude(trial, text)) => type_text(
            key.code,
            text,
            |text| Entry::Exclude(trial, text),
            |text| input_about(trial, text, Input::Exclude, About::Exclude),
        ),
        Some(Entry::Answer(_) | Entry::Which(_) | Entry::Trial(_)) if key.code == KeyCode::Esc => {
            (None, None)
        }
        // After the lines of text, in which Space is a letter; before all other keys.
        _ if matches!(key.code, KeyCode::Char(' ') | KeyCode::Esc) => (None, Some(Input::Stop)),
        Some(Entry::Answer(text)) => type_answer(key.code, text),
        Some(Entry::Which(text)) => type_trial(key.code, text),
        Some(Entry::Trial(trial)) => press_for_trial(key.code, trial),
        Some(Entry::Sure(ask)) => {
            let is_yes = matches!(key.code, KeyCode::Char('y' | 'Y'));
            (None, is_yes.then(|| ask.input()))
        }
        None => press_command(key.code, phase),
    }
}

/// A text on the last trial, or on the one that is named.
fn input_about(
    trial: Option<u32>,
    text: String,
    last: fn(String) -> Input,
    about: fn(String) -> About,
) -> Input {
    match trial {
        None => last(text),
        Some(trial) => Input::Of(trial, about(text)),
    }
}

fn type_text(
    code: KeyCode,
    mut text: String,
    entry: impl Fn(String) -> Entry,
    input: impl Fn(String) -> Input,
) -> (Option<Entry>, Option<Input>) {
    match code {
        KeyCode::Enter if text.trim().is_empty() => return (None, None),
        KeyCode::Enter => return (None, Some(input(text))),
        KeyCode::Esc => return (None, None),
        KeyCode::Backspace => drop(text.pop()),
        KeyCode::Char(c) if !c.is_control() && text.chars().count() < LONGEST => text.push(c),
        _ => {}
    }
    (Some(entry(text)), None)
}

/// Types the number of an answer: digits and a sign, Enter gives it, any other key is passed by.
/// The space bar stops, as it does where nothing is typed, and Esc takes the number back.
fn type_answer(code: KeyCode, mut text: String) -> (Option<Entry>, Option<Input>) {
    match code {
        // What is no number at all (a sign alone) is taken back.
        KeyCode::Enter => return (None, text.parse().ok().map(Input::Answer)),
        KeyCode::Backspace => drop(text.pop()),
        KeyCode::Char(c) if is_of_number(c) && text.len() < LONGEST_NUMBER => text.push(c),
        _ => {}
    }
    (Some(Entry::Answer(text)), None)
}

/// Types the number of a trial; Enter chooses it.
fn type_trial(code: KeyCode, mut text: String) -> (Option<Entry>, Option<Input>) {
    match code {
        KeyCode::Enter => return (text.parse().ok().map(Entry::Trial), None),
        KeyCode::Backspace => drop(text.pop()),
        KeyCode::Char(c) if c.is_ascii_digit() && text.len() < LONGEST_NUMBER => text.push(c),
        _ => {}
    }
    (Some(Entry::Which(text)), None)
}

/// What is to be said of a trial; any key that says nothing drops it.
fn press_for_trial(code: KeyCode, trial: u32) -> (Option<Entry>, Option<Input>) {
    match lower(code) {
        KeyCode::Char('n') => (Some(Entry::Note(Some(trial), String::new())), None),
        KeyCode::Char('x') => (Some(Entry::Exclude(Some(trial), String::new())), None),
        KeyCode::Char('r') => (Some(Entry::Sure(Ask::Repeat(Some(trial)))), None),
        KeyCode::Char('a') => (None, Some(Input::Of(trial, About::Ask))),
        _ => (None, None),
    }
}

fn press_command(code: KeyCode, phase: &Phase) -> (Option<Entry>, Option<Input>) {
    let c = match lower(code) {
        KeyCode::Enter => {
            return (None, is_offered("Enter", phase).then_some(Input::Start));
        }
        KeyCode::Char(c) => c,
        _ => return (None, None),
    };
    if let Phase::Question { scale, .. } = phase
        && is_of_number(c)
    {
        if !has_keys(scale) {
            return (Some(Entry::Answer(c.to_string())), None);
        }
        // The answer that a key gives, if the question has such an answer.
        let value = c.to_digit(10).and_then(|n| i16::try_from(n).ok());
        return (None, value.filter(|value| scale.has(*value)).map(Input::Answer));
    }
    if !is_offered(c.encode_utf8(&mut [0; 4]), phase) {
        return (None, None);
    }
    match c {
        'y' => (None, Some(Input::Yes)),
        's' if matches!(phase, Phase::Step { .. }) => (None, Some(Input::Skip)),
        's' => (Some(Entry::Sure(Ask::Skip)), None),
        'n' => (Some(Entry::Note(None, String::new())), None),
        'x' => (Some(Entry::Exclude(None, String::new())), None),
        'r' => (Some(Entry::Sure(Ask::Repeat(None))), None),
        'p' => (None, Some(Input::Hold)),
        't' => (Some(Entry::Which(String::new())), None),
        'q' => (Some(Entry::Sure(Ask::Quit)), None),
        _ => (None, None),
    }
}

/// Whether the screen offers this key in a phase.
fn is_offered(key: &str, phase: &Phase) -> bool {
    commands(phase).iter().any(|(keys, _)| *keys == key)
}

/// Whether each answer is a digit, whose key gives it; else the number is typed.
fn has_keys(scale: &AnswerScale) -> bool {
    scale.lowest() >= 0 && scale.highest() <= 9
}

/// What may be typed into a number.
fn is_of_number(c: char) -> bool {
    c.is_ascii_digit() || c == '-'
}

/// Capitals mean the same: the lock may be on.
fn lower(code: KeyCode) -> KeyCode {
    match code {
        KeyCode::Char(c) => KeyCode::Char(c.to_ascii_lowercase()),
        code => code,
    }
}

/// The keys of a phase besides the stop key, each with its meaning, as the screen shows them.
pub(super) fn commands(phase: &Phase) -> Vec<(Cow<'static, str>, &'static str)> {
    const NOTE: (&str, &str) = ("n", "note");
    const EXCLUDE: (&str, &str) = ("x", "exclude");
    const REPEAT: (&str, &str) = ("r", "repeat");
    const HOLD: (&str, &str) = ("p", "hold");
    const TRIAL: (&str, &str) = ("t", "trial");
    const QUIT: (&str, &str) = ("q", "quit");
    const LEAVE_OUT: (&str, &str) = ("s", "leave it out");
    let fixed: &[(&str, &str)] = match phase {
        Phase::Check | Phase::Homing => &[NOTE, QUIT],
        Phase::Step { moves: false, .. } => &[("Enter", "begin"), LEAVE_OUT, QUIT],
        Phase::Step { moves: true, .. } => &[("y", "let it move"), LEAVE_OUT, QUIT],
        Phase::AtStop => &[("Enter", "it is there"), NOTE, QUIT],
        Phase::Ready => &[("Enter", "start"), NOTE, EXCLUDE, REPEAT, TRIAL, QUIT],
        Phase::Trial { .. } | Phase::Left => &[],
        Phase::Question { .. } => &[("s", "skip"), NOTE, EXCLUDE, REPEAT, QUIT],
        Phase::Pause { .. } => &[HOLD, NOTE, EXCLUDE, REPEAT, TRIAL, QUIT],
        Phase::Done => &[NOTE, EXCLUDE, REPEAT, TRIAL, QUIT],
        Phase::Stopped { .. } => &[("Enter", "go on"), NOTE, EXCLUDE, REPEAT, TRIAL, QUIT],
    };
    let answers = match phase {
        Phase::Question { scale, .. } if has_keys(scale) => {
            Some((format!("{}–{}", scale.lowest(), scale.highest()).into(), "answer"))
        }
        Phase::Question { scale, .. } => {
            Some((format!("{}, Enter", scale.range()).into(), "answer"))
        }
        _ => None,
    };
    answers.into_iter().chain(fixed.iter().map(|(key, does)| ((*key).into(), *does))).collect()
}

/// The stop key as the screen writes it.
pub(super) fn stop_key(entry: Option<&Entry>) -> &'static str {
    match entry {
        Some(Entry::Note(..) | Entry::Exclude(..)) => "Ctrl-C",
        _ => "Space",
    }
}

impl Ask {
    fn input(self) -> Input {
        match self {
            Self::Repeat(None) => Input::Repeat,
            Self::Repeat(Some(trial)) => Input::Of(trial, About::Repeat),
            Self::Skip => Input::Skip,
            Self::Quit => Input::Quit,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::examples::phases;
    use super::*;
    use zwidth_study::AnswerScale;

    fn key(code: KeyCode) -> KeyEvent {
        KeyEvent::new(code, KeyModifiers::NONE)
    }

    /// Presses keys one after another: a character each, `\n` is Enter, `\u{8}` Backspace, `\u{1b}`
    /// Esc.
    fn type_keys(keys: &str, phase: &Phase) -> (Option<Entry>, Vec<Input>) {
        let mut entry = None;
        let mut inputs = Vec::new();
        for c in keys.chars() {
            let code = match c {
                '\n' => KeyCode::Enter,
                '\u{8}' => KeyCode::Backspace,
                '\u{1b}' => KeyCode::Esc,
                c => KeyCode::Char(c),
            };
            let (next, input) = press(key(code), phase, entry);
            entry = next;
            inputs.extend(input);
        }
        (entry, inputs)
    }

    fn check(keys: &str, phase: &Phase, expect: &[Input]) {
        let (entry, inputs) = type_keys(keys, phase);
        assert_eq!((entry, inputs.as_slice()), (None, expect), "{keys:?} in {phase:?}");
    }

    const TRIAL: Phase = Phase::Trial { t_s: 1.0, limit_s: 4.0 };

    fn question() -> Phase {
        Phase::Question { text: String::new(), scale: AnswerScale::FivePoint }
    }

    #[test]
    fn space_escape_and_control_c_stop_in_every_phase() {
        for phase in phases() {
            check(" ", &phase, &[Input::Stop]);
            check("\u{1b}", &phase, &[Input::Stop]);
            let control_c = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
            for entry in [None, Some(Entry::Note(None, "a".into())), Some(Entry::Sure(Ask::Quit))] {
                assert_eq!(press(control_c, &phase, entry), (None, Some(Input::Stop)));
            }
        }
    }

    #[test]
    fn the_keys_of_a_phase_are_those_that_do_something_in_it() {
        for phase in phases() {
            let works = |c: char| type_keys(&c.to_string(), &phase) != (None, vec![]);
            let shown = |word: &str| commands(&phase).iter().any(|(key, _)| *key == word);
            for c in ('a'..='z').filter(|c| *c != 'c') {
                assert_eq!(works(c), shown(&c.to_string()), "{c} in {phase:?}");
            }
            assert_eq!(works('\n'), shown("Enter"), "{phase:?}");
        }
    }

    #[test]
    fn answers_are_taken_in_the_question_phase_alone() {
        for phase in phases() {
            let expect = if matches!(phase, Phase::Question { .. }) {
                vec![Input::Answer(4)]
            } else {
                vec![]
            };
            check("4", &phase, &expect);
        }
        check("06", &question(), &[]);
    }

    fn asked(points: u8, from: i16) -> Phase {
        let scale = zwidth_study::NumberScale { points, from, step: 1, labels: Vec::new() };
        Phase::Question { text: String::new(), scale: AnswerScale::Numbers(scale) }
    }

    #[test]
    fn a_digit_answers_where_every_answer_is_one_and_else_the_number_is_typed() {
        check("0", &asked(7, 0), &[Input::Answer(0)]);
        check("7", &asked(7, 0), &[]);
        check("-2\n", &asked(7, -3), &[Input::Answer(-2)]);
        check("2\n", &asked(7, -3), &[Input::Answer(2)]);
        check("7\u{8}85\n", &asked(101, 0), &[Input::Answer(85)]);
        check("-\n", &asked(7, -3), &[]);
        check("85\u{1b}", &asked(101, 0), &[]);
        check("8 ", &asked(101, 0), &[Input::Stop]);
        check("sy", &asked(101, 0), &[Input::Skip]);
        assert_eq!(commands(&asked(7, -3))[0].0, "-3 to 3, Enter");
        assert_eq!(commands(&asked(7, 0))[0].0, "0–6");
    }

    #[test]
    fn while_a_trial_runs_no_key_but_stop_does_anything() {
        check("\n12345nxrtqsy", &TRIAL, &[]);
    }

    #[test]
    fn a_note_keeps_its_spaces_and_takes_back_a_letter() {
        check("nslipped  ofg\u{8}f\n", &Phase::Ready, &[Input::Note("slipped  off".into())]);
        check("n \n", &Phase::Ready, &[]);
        check("nabc\u{1b}", &Phase::Ready, &[]);
    }

    #[test]
    fn a_reason_is_asked_before_a_trial_is_excluded() {
        check("xhand slipped\n", &question(), &[Input::Exclude("hand slipped".into())]);
        check("x\n", &question(), &[]);
    }

    #[test]
    fn repeat_skip_and_quit_happen_after_a_yes_and_nothing_else() {
        check("ry", &Phase::Done, &[Input::Repeat]);
        check("rn", &Phase::Done, &[]);
        check("r\n", &Phase::Done, &[]);
        check("sy", &question(), &[Input::Skip]);
        check("qy", &Phase::Ready, &[Input::Quit]);
        check("q ", &Phase::Ready, &[Input::Stop]);
    }

    #[test]
    fn any_trial_is_chosen_by_its_number_and_then_said_what_of_it() {
        let of = |trial, about| [Input::Of(trial, about)];
        check(
            "t12\nxthe phone rang\n",
            &Phase::Ready,
            &of(12, About::Exclude("the phone rang".into())),
        );
        check("t3\nnslowly\n", &Phase::Done, &of(3, About::Note("slowly".into())));
        check("T3\nRY", &Phase::Ready, &of(3, About::Repeat));
        check("t1\u{8}2\na", &Phase::Ready, &of(2, About::Ask));
        check("t3\nrn", &Phase::Ready, &[]);
        check("t3\nz", &Phase::Ready, &[]);
        check("t\n", &Phase::Ready, &[]);
        check("t3\u{1b}", &Phase::Ready, &[]);
        check("t3\n\u{1b}", &Phase::Ready, &[]);
        check("t3 ", &Phase::Ready, &[Input::Stop]);
        check("t3\n ", &Phase::Ready, &[Input::Stop]);
    }

    #[test]
    fn a_line_is_dropped_when_a_trial_runs_so_that_space_stops_it() {
        let (entry, input) =
            press(key(KeyCode::Char(' ')), &TRIAL, Some(Entry::Note(None, "half a".into())));
        assert_eq!((entry, input), (None, Some(Input::Stop)));
    }

    #[test]
    fn a_remark_has_a_longest_length_and_no_control_characters() {
        let long = "é".repeat(LONGEST + 50);
        check(&format!("n{long}\u{7}\n"), &Phase::Ready, &[Input::Note("é".repeat(LONGEST))]);
    }

    #[test]
    fn capitals_mean_the_same_and_control_keys_nothing() {
        check("RY", &Phase::Done, &[Input::Repeat]);
        let control_n = KeyEvent::new(KeyCode::Char('n'), KeyModifiers::CONTROL);
        assert_eq!(press(control_n, &Phase::Ready, None), (None, None));
    }

    #[test]
    fn letting_go_of_a_key_is_no_key() {
        let release =
            KeyEvent::new_with_kind(KeyCode::Char(' '), KeyModifiers::NONE, KeyEventKind::Release);
        assert_eq!(press(release, &TRIAL, None), (None, None));
    }
}
