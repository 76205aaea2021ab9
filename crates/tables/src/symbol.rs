//! Symbols with something below the line, as texts write them: `M_O`, `θ_rest`.

/// A stretch of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Piece<'a> {
    /// To be set as it stands.
    Plain(&'a str),
    /// To be set below the line; its `_` is left out.
    Below(&'a str),
}

/// The pieces of `text`. Below the line stands what follows a single letter and `_`, begins with a
/// letter and ends with its word; all other words with `_` are names (`spring_wall`, `P_01`) and
/// stay as they are.
pub(crate) fn pieces(text: &str) -> Vec<Piece<'_>> {
    let mut pieces = Vec::new();
    let mut rest = 0; // where the text begins that is in no piece yet
    for (at, _) in text.match_indices('_') {
        if at >= rest
            && let Some(end) = subscript(text, at)
        {
            pieces.extend([Piece::Plain(&text[rest..at]), Piece::Below(&text[at + 1..end])]);
            rest = end;
        }
    }
    pieces.push(Piece::Plain(&text[rest..]));
    pieces.retain(|piece| *piece != Piece::Plain(""));
    pieces
}

/// Where the subscript ends whose `_` stands at `at`, if it is one.
fn subscript(text: &str, at: usize) -> Option<usize> {
    let mut before = text[..at].chars().rev();
    let symbol = before.next().is_some_and(char::is_alphabetic)
        && !before.next().is_some_and(is_part_of_name);
    let below = &text[at + 1..];
    let end = below.find(|c| !is_part_of_name(c)).unwrap_or(below.len());
    let word = below.starts_with(char::is_alphabetic) && !below[..end].contains('_');
    (symbol && word).then_some(at + 1 + end)
}

fn is_part_of_name(letter: char) -> bool {
    letter.is_alphanumeric() || letter == '_'
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, expect: &str) {
        let told: String = pieces(text)
            .into_iter()
            .map(|piece| match piece {
                Piece::Plain(text) => text.to_owned(),
                Piece::Below(text) => format!("<{text}>"),
            })
            .collect();
        assert_eq!(told, expect);
    }

    #[test]
    fn what_follows_a_single_letter_stands_below() {
        check("M_O, mass", "M<O>, mass");
        check("θ_rest and L_F0", "θ<rest> and L<F0>");
        check("(F_ex)", "(F<ex>)");
    }

    #[test]
    fn names_stay_as_they_are() {
        for name in
            ["spring_wall", "P_01", "one_trial", "a_b_c", "_x", "x_", "trial-7_b", "1_a", ""]
        {
            check(name, name);
        }
    }
}
