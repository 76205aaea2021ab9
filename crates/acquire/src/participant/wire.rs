//! What goes over the line between a session and the participant's screen: lines of text, at most
//! so long.

use super::sight::Sight;
use serde::{Deserialize, Serialize};
use std::io::{self, BufRead, Read as _, Write};

/// The form of the lines. A screen of another form is not let in.
const FORM: &str = "zwidth-participant-1";

/// Longest line, bytes: a question with a hundred answers, each with a long word.
const MOST_LINE: u64 = 1 << 17;

/// What the session says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Said {
    /// Another screen is open.
    Taken,
    /// What is to be seen now.
    Sight(Sight),
}

/// What a file says of where a session is found: port and word of admission.
pub fn place_of(text: &str) -> Option<(u16, &str)> {
    let (port, word) = text.trim_end().split_once(' ')?;
    Some((port.parse().ok()?, word)).filter(|(_, word)| !word.is_empty())
}

/// The text of that file.
pub(super) fn place(port: u16, word: &str) -> String {
    format!("{port} {word}\n")
}

/// The first line of a screen.
pub(super) fn hello(word: &str) -> String {
    format!("{FORM} {word}")
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

    #[test]
    fn a_place_is_read_as_it_was_written_and_nothing_else_is_one() {
        assert_eq!(place_of(&place(4_711, "word")), Some((4_711, "word")));
        for text in ["", "4711", "4711 ", "x word", "99999 word"] {
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
}
