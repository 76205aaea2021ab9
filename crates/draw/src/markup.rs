//! The small markup of labels.
//!
//! | written | set as |
//! |---|---|
//! | `*F*` | italic: a symbol for a quantity |
//! | `**a**` | bold |
//! | `_{ex}`, `^{−3}` | lowered, raised and smaller |
//! | `⁻³` | raised too, so that units may be typed as they are |
//! | `\*` | a star; a backslash takes the meaning off any sign |
//!
//! A sign without its partner stands for itself, so any text can be set: at worst a star is
//! visible. Names that come from data go through [`escape`].

/// Height of the letters of one run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Script {
    #[default]
    Base,
    Sub,
    Super,
}

/// Letters set in one style.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Run {
    pub(crate) text: String,
    pub(crate) italic: bool,
    pub(crate) bold: bool,
    pub(crate) script: Script,
}

/// `text` escaped so that it is set unchanged. Raised signs are not in the font: where there is one, raised figures are
/// plain ones set higher too, so that `10⁻³` stands on one line.
pub fn escape(text: &str) -> String {
    let mut escaped = String::new();
    let is_set_higher = text.contains(['⁻', '⁺']);
    for letter in text.chars() {
        let is_raised = raised(letter).is_some() && !is_set_higher;
        if matches!(letter, '*' | '_' | '^' | '\\' | '}') || is_raised {
            escaped.push('\\');
        }
        escaped.push(letter);
    }
    escaped
}

/// The letters without their markup: for titles of files and the like.
pub fn plain(markup: &str) -> String {
    parse(markup).into_iter().map(|run| run.text).collect()
}

/// The letters as plain text is typed: `F_ex` for what stands below the line, `10⁻³` for raised
/// figures, `x^k` for other raised letters.
pub fn typed(markup: &str) -> String {
    let mut typed = String::new();
    for Run { text, script, .. } in parse(markup) {
        // Raised letters of their own only if there are some for the whole run.
        let raise = |letter: char| Some(RAISED[LEVEL.iter().position(|plain| *plain == letter)?]);
        let raised: Option<String> = text.chars().map(raise).collect();
        match (script, raised) {
            (Script::Base, _) => typed.push_str(&text),
            (Script::Super, Some(raised)) => typed.push_str(&raised),
            (Script::Super, None) => typed.extend(["^", &text]),
            (Script::Sub, _) => typed.extend(["_", &text]),
        }
    }
    typed
}

/// Splits markup into runs. Total: every text has a reading.
pub(crate) fn parse(markup: &str) -> Vec<Run> {
    let mut runs = Vec::new();
    let mut now = Run::default();
    let mut rest = markup;
    // The order matters: a backslash before all signs, two stars before one.
    while let Some(letter) = rest.chars().next() {
        let after = &rest[letter.len_utf8()..];
        if let Some(escaped) = after.chars().next().filter(|_| letter == '\\') {
            now.text.push(escaped);
            rest = &after[escaped.len_utf8()..];
        } else if let Some(tail) =
            rest.strip_prefix("**").filter(|tail| now.bold || tail.contains("**"))
        {
            let bold = !now.bold;
            turn(&mut runs, &mut now, |run| run.bold = bold);
            rest = tail;
        } else if letter == '*' && (now.italic || after.contains('*')) {
            let italic = !now.italic;
            turn(&mut runs, &mut now, |run| run.italic = italic);
            rest = after;
        // Scripts do not nest: within one, the sign of another stands for itself.
        } else if let Some((script, tail)) =
            script_start(rest).filter(|_| now.script == Script::Base)
        {
            turn(&mut runs, &mut now, |run| run.script = script);
            rest = tail;
        } else if letter == '}' && now.script != Script::Base {
            turn(&mut runs, &mut now, |run| run.script = Script::Base);
            rest = after;
        } else if let Some(digit) = raised(letter).filter(|_| now.script == Script::Base) {
            turn(&mut runs, &mut now, |run| run.script = Script::Super);
            now.text.push(digit);
            turn(&mut runs, &mut now, |run| run.script = Script::Base);
            rest = after;
        } else {
            now.text.push(letter);
            rest = after;
        }
    }
    push(&mut runs, now);
    runs
}

/// Splits markup at its spaces into words, each with the styles that reign there. A double space
/// stays one.
pub(crate) fn words(markup: &str) -> Vec<Vec<Run>> {
    let mut words: Vec<Vec<Run>> = vec![Vec::new()];
    // The first space of two becomes one that no line breaks at, and stays with the word before it.
    for run in parse(&markup.replace("  ", "\u{a0} ")) {
        for (i, part) in run.text.split(' ').enumerate() {
            if i > 0 {
                words.push(Vec::new());
            }
            if let Some(word) = words.last_mut() {
                push(word, Run { text: part.to_owned(), ..run });
            }
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Two words with a space between them.
pub(crate) fn join(left: &[Run], right: &[Run]) -> Vec<Run> {
    let mut runs = left.to_vec();
    if let Some(last) = runs.last_mut() {
        last.text.push(' ');
    }
    append(&runs, right)
}

/// Accents and dots that stand over the letter before them.
pub(crate) fn is_mark(letter: char) -> bool {
    ('\u{300}'..='\u{315}').contains(&letter)
}

/// The letters of a word, each with the accents that stand over it.
pub(crate) fn letters(word: &[Run]) -> Vec<Vec<Run>> {
    let mut letters: Vec<Vec<Run>> = Vec::new();
    for run in word {
        for letter in run.text.chars() {
            match letters.last_mut().and_then(|runs| runs.last_mut()) {
                Some(before) if is_mark(letter) => before.text.push(letter),
                _ => letters.push(vec![Run { text: letter.to_string(), ..*run }]),
            }
        }
    }
    letters
}

/// Two parts of a word, one after the other.
pub(crate) fn append(left: &[Run], right: &[Run]) -> Vec<Run> {
    let mut runs = left.to_vec();
    right.iter().for_each(|run| push(&mut runs, run.clone()));
    runs
}

/// Ends the current run and starts the next with a changed style.
fn turn(runs: &mut Vec<Run>, now: &mut Run, change: impl FnOnce(&mut Run)) {
    let mut next = Run { text: String::new(), ..*now };
    change(&mut next);
    push(runs, std::mem::replace(now, next));
}

/// Appends a run, joined to the one before if their styles agree, so that letters are shaped
/// together.
fn push(runs: &mut Vec<Run>, run: Run) {
    match runs.last_mut() {
        _ if run.text.is_empty() => {}
        Some(last)
            if (last.italic, last.bold, last.script) == (run.italic, run.bold, run.script) =>
        {
            last.text.push_str(&run.text);
        }
        _ => runs.push(run),
    }
}

fn script_start(rest: &str) -> Option<(Script, &str)> {
    let sub = rest.strip_prefix("_{").map(|tail| (Script::Sub, tail));
    sub.or_else(|| rest.strip_prefix("^{").map(|tail| (Script::Super, tail)))
        .filter(|(_, tail)| tail.contains('}'))
}

/// Raised signs and the plain ones behind them; the font has only some of the raised ones.
const RAISED: [char; 12] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹', '⁻', '⁺'];
const LEVEL: [char; 12] = ['0', '1', '2', '3', '4', '5', '6', '7', '8', '9', '−', '+'];

/// The plain sign behind a raised one.
fn raised(letter: char) -> Option<char> {
    RAISED.iter().position(|raised| *raised == letter).map(|place| LEVEL[place])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs written as `i:F _:ex`: style letters, a colon, the text.
    fn check(markup: &str, expect: &[&str]) {
        let seen: Vec<String> = parse(markup)
            .into_iter()
            .map(|run| {
                let script = match run.script {
                    Script::Base => "",
                    Script::Sub => "_",
                    Script::Super => "^",
                };
                let bold = if run.bold { "b" } else { "" };
                let italic = if run.italic { "i" } else { "" };
                format!("{bold}{italic}{script}:{}", run.text)
            })
            .collect();
        assert_eq!(seen, expect, "{markup}");
    }

    #[test]
    fn a_symbol_with_a_roman_subscript() {
        check("*F*_{ex} (N)", &["i:F", "_:ex", ": (N)"]);
        check("*θ̇* (°/s)", &["i:θ̇", ": (°/s)"]);
        check("**a**  spring", &["b:a", ":  spring"]);
    }

    #[test]
    fn raised_digits_are_raised_however_they_are_typed() {
        check("10^{−3} kg", &[":10", "^:−3", ": kg"]);
        check("s⁻²", &[":s", "^:−2"]);
    }

    #[test]
    fn markup_is_typed_as_people_type_it() {
        for (markup, expect) in [
            ("*F*_{ex} of **a**\\*b", "F_ex of a*b"),
            ("10^{−3} s⁻²", "10⁻³ s⁻²"),
            ("x^{k}", "x^k"),
            ("spring_wall", "spring_wall"),
        ] {
            assert_eq!(typed(markup), expect);
        }
    }

    #[test]
    fn signs_without_partner_stand_for_themselves() {
        check("a * b", &[":a * b"]);
        check("session_9 x^2", &[":session_9 x^2"]);
        check("open _{brace", &[":open _{brace"]);
        check("a } b", &[":a } b"]);
        check(r"end\", &[r":end\"]);
        check("", &[]);
    }

    #[test]
    fn words_keep_the_style_that_began_before_them() {
        let words = words("the *external force* _{ex}");
        assert_eq!(words.len(), 4);
        assert!(words[1][0].italic && words[2][0].italic && !words[0][0].italic);
        assert_eq!(
            join(&words[1], &words[2]),
            [Run { text: "external force".into(), italic: true, ..Run::default() }]
        );
    }

    #[test]
    fn an_escaped_text_is_set_as_it_stands() {
        for text in ["*_{}^\\", "a*b*c", "**", "x_{1}", "m²", "θ̇"] {
            assert_eq!(plain(&escape(text)), text);
            let is_plain = |run: &Run| *run == Run { text: run.text.clone(), ..Run::default() };
            assert!(parse(&escape(text)).iter().all(is_plain));
        }
        // The font has no raised minus.
        check(&escape("6.0 × 10⁻¹²_a"), &[":6.0 × 10", "^:−12", ":_a"]);
        assert_eq!(typed(&escape("6.0 × 10⁻¹²")), "6.0 × 10⁻¹²");
    }
}
