//! What a key means on the participant's screen: an answer to the open question, or the end of the
//! screen. Nothing else can be requested there.

use super::sight::OpenQuestion;
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};

/// Characters of a number, at most: any answer's.
const LONGEST: usize = 6;

/// What a key comes to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pressed {
    /// An answer to the open question.
    Answer(i16),
    /// The screen is to be closed.
    Close,
}

/// What a key press comes to, and what is typed after it. `open` is the question that waits for an
/// answer.
pub(super) fn press(
    key: KeyEvent,
    open: Option<&OpenQuestion>,
    mut typed: String,
) -> (String, Option<Pressed>) {
    if key.kind == KeyEventKind::Release {
        return (typed, None);
    }
    if key.modifiers.contains(KeyModifiers::CONTROL) {
        return (typed, (key.code == KeyCode::Char('c')).then_some(Pressed::Close));
    }
    let Some(open) = open else { return (String::new(), None) };
    match key.code {
        KeyCode::Char(c) if open.has_keys() => {
            let value = c.to_digit(10).and_then(|n| i16::try_from(n).ok());
            return (typed, value.filter(|value| open.has(*value)).map(Pressed::Answer));
        }
        KeyCode::Enter => {
            let value = typed.parse().ok().filter(|value| open.has(*value));
            // What is no answer stays, so that it can be seen and corrected.
            let typed = if value.is_some() { String::new() } else { typed };
            return (typed, value.map(Pressed::Answer));
        }
        KeyCode::Esc => typed.clear(),
        KeyCode::Backspace => drop(typed.pop()),
        KeyCode::Char(c) if (c.is_ascii_digit() || c == '-') && typed.len() < LONGEST => {
            typed.push(c)
        }
        _ => {}
    }
    (typed, None)
}

#[cfg(test)]
mod tests {
    use super::super::sight::Choice;
    use super::*;

    fn asked(values: impl IntoIterator<Item = i16>) -> OpenQuestion {
        let choices = values.into_iter().map(|value| Choice { value, word: None }).collect();
        OpenQuestion { choices, ..OpenQuestion::default() }
    }

    /// Presses keys one after another; `\n` is Enter, `\u{8}` Backspace.
    fn type_keys(keys: &str, asked: Option<&OpenQuestion>) -> (String, Vec<Pressed>) {
        let (mut typed, mut all) = (String::new(), Vec::new());
        for c in keys.chars() {
            let code = match c {
                '\n' => KeyCode::Enter,
                '\u{8}' => KeyCode::Backspace,
                c => KeyCode::Char(c),
            };
            let (after, pressed) = press(KeyEvent::new(code, KeyModifiers::NONE), asked, typed);
            typed = after;
            all.extend(pressed);
        }
        (typed, all)
    }

    #[test]
    fn one_key_answers_where_each_answer_is_a_digit() {
        let five = asked(1..=5);
        assert_eq!(type_keys("064", Some(&five)), (String::new(), vec![Pressed::Answer(4)]));
    }

    #[test]
    fn a_longer_number_is_typed_and_corrected_and_enter_gives_it() {
        let long = asked((-100..=100).step_by(5));
        let answer = |value| (String::new(), vec![Pressed::Answer(value)]);
        assert_eq!(type_keys("-3x5\n", Some(&long)), answer(-35));
        assert_eq!(type_keys("17\n\u{8}0\n", Some(&long)), answer(10));
        assert_eq!(type_keys("17\n", Some(&long)), ("17".to_owned(), vec![]));
    }

    #[test]
    fn without_a_question_no_key_asks_for_anything() {
        for key in "\n 12345sqrnxpty".chars() {
            assert_eq!(type_keys(&key.to_string(), None), (String::new(), vec![]), "{key:?}");
        }
        let close = KeyEvent::new(KeyCode::Char('c'), KeyModifiers::CONTROL);
        assert_eq!(press(close, None, String::new()).1, Some(Pressed::Close));
    }
}
