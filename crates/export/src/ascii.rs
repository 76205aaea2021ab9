//! Texts for forms whose readers know no other letters than those of ASCII.

/// A text in ASCII: units as they are typed (`N*m`, `rad/s^2`), and `?` for letters without a likeness.
pub(crate) fn ascii(text: &str) -> String {
    let mut plain = String::new();
    for letter in text.chars() {
        match letter {
            '·' => plain.push('*'),
            '²' => plain.push_str("^2"),
            '³' => plain.push_str("^3"),
            '°' => plain.push_str("deg"),
            'µ' | 'μ' => plain.push('u'),
            '−' | '–' | '—' => plain.push('-'),
            '×' => plain.push('x'),
            '…' => plain.push_str("..."),
            '’' | '‘' => plain.push('\''),
            'θ' => plain.push_str("theta"),
            'Ω' => plain.push_str("Ohm"),
            '≥' => plain.push_str(">="),
            '≤' => plain.push_str("<="),
            letter if letter.is_ascii() => plain.push(letter),
            _ => plain.push('?'),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_as_they_are_typed_and_nothing_else_than_ascii_is_left() {
        for (text, plain) in
            [("N·m", "N*m"), ("rad/s²", "rad/s^2"), ("N", "N"), ("µm", "um"), ("力", "?")]
        {
            assert_eq!(ascii(text), plain);
        }
    }
}
