//! Text from outside, made safe to show: it cannot control a terminal, forge a line, or reverse the
//! direction of writing.

use std::borrow::Cow;

/// The text with every character escaped that would not be seen as itself: control characters (C0,
/// DEL, C1), those that turn the direction of what follows, those of no width, separators of lines
/// and paragraphs, and the byte-order mark. A line feed becomes `\n`, a tab `\t`, a carriage return
/// `\r`, any other its number: `\u{202e}`.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.chars().any(is_unseen) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if is_unseen(c) {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    Cow::Owned(shown)
}

/// The same for text of several lines: each as by [`printable`], the line feeds between them as
/// they are.
pub fn printable_lines(text: &str) -> Cow<'_, str> {
    if !text.chars().any(|c| is_unseen(c) && c != '\n') {
        return Cow::Borrowed(text);
    }
    Cow::Owned(text.split('\n').map(printable).collect::<Vec<_>>().join("\n"))
}

fn is_unseen(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{61c}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2066}'..='\u{2069}'
                | '\u{feff}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_that_is_seen_as_it_is_stays_as_it_is() {
        for text in ["", "a.csv", "θ = x / L, 2° « ä 日本 🖐", "back\\slash"] {
            assert!(matches!(printable(text), Cow::Borrowed(same) if same == text));
        }
    }

    #[test]
    fn what_steers_a_terminal_or_turns_a_line_is_escaped() {
        assert_eq!(printable("a\nok: b\r\t"), r"a\nok: b\r\t");
        let steered = printable("\u{1b}[2J\u{7}\u{0}\u{7f}\u{9b}1m");
        assert_eq!(steered, r"\u{1b}[2J\u{7}\u{0}\u{7f}\u{9b}1m");
        assert_eq!(printable("x\u{202e}vsc\u{2066}\u{2069}"), r"x\u{202e}vsc\u{2066}\u{2069}");
        let unseen = printable("\u{feff}\u{200b}\u{200f}\u{61c}\u{2028}");
        assert_eq!(unseen, r"\u{feff}\u{200b}\u{200f}\u{61c}\u{2028}");
        assert_eq!(printable(r"\n"), r"\n");
        assert_eq!(printable_lines("a\n\u{1b}b\n"), "a\n\\u{1b}b\n");
    }
}
