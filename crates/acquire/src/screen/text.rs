//! Text on a grid of cells: wrapping, cutting, bars.

use ratatui::text::Span;

/// Cells a text takes.
pub(crate) fn width(text: &str) -> usize {
    Span::raw(text).width()
}

/// Breaks a text into lines of at most `limit` cells, between words where it can.
pub(crate) fn wrap(text: &str, limit: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace().flat_map(|word| pieces(word, limit.max(1))) {
        let line = lines.last().map_or(0, |line| width(line));
        match lines.last_mut() {
            Some(last) if line == 0 => last.push_str(&word),
            Some(last) if line + 1 + width(&word) <= limit => {
                last.push(' ');
                last.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

/// Breaks a text into pieces of at most `limit` cells wherever they are full: spaces stay as they
/// were typed.
pub(crate) fn pieces(text: &str, limit: usize) -> Vec<String> {
    let mut pieces = vec![String::new()];
    for c in text.chars() {
        match pieces.last_mut() {
            Some(piece) if width(piece) + width(c.encode_utf8(&mut [0; 4])) <= limit => {
                piece.push(c)
            }
            _ => pieces.push(c.to_string()),
        }
    }
    pieces
}

/// A text cut to `limit` cells, with an ellipsis where it was cut.
pub(crate) fn fit(text: &str, limit: usize) -> String {
    if width(text) <= limit {
        return text.to_owned();
    }
    match limit {
        0 => String::new(),
        _ => pieces(text, limit - 1).swap_remove(0) + "…",
    }
}

/// A bar of `cells` cells, filled to a fraction.
pub(crate) fn bar(fraction: f64, cells: usize) -> String {
    // The product lies between 0 and `cells`: the cast cannot lose anything.
    let full = (fraction.clamp(0.0, 1.0) * cells as f64).round() as usize;
    "█".repeat(full) + &"░".repeat(cells - full.min(cells))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_broken_between_words_and_a_long_word_within() {
        assert_eq!(wrap("one two three", 8), ["one two", "three"]);
        assert_eq!(wrap("abcdefgh ij", 3), ["abc", "def", "gh", "ij"]);
        assert_eq!(wrap("", 5), [""]);
    }

    #[test]
    fn what_is_typed_keeps_its_spaces() {
        assert_eq!(pieces("a  b c ", 3), ["a  ", "b c", " "]);
        assert_eq!(pieces("日本語", 5), ["日本", "語"]);
    }

    #[test]
    fn a_text_that_is_too_long_says_so() {
        assert_eq!(fit("short", 5), "short");
        assert_eq!(fit("too long", 5), "too …");
        assert_eq!(fit("日本語", 4), "日…");
        assert_eq!([fit("long", 0), fit("long", 1)], ["", "…"]);
    }

    #[test]
    fn a_bar_is_empty_at_nought_and_full_at_one() {
        assert_eq!(bar(0.0, 4), "░░░░");
        assert_eq!(bar(0.5, 4), "██░░");
        assert_eq!(bar(7.0, 4), "████");
        assert_eq!(bar(f64::NAN, 2), "░░");
    }
}
