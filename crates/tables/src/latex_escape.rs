//! Any text as LaTeX that sets it unchanged, under pdflatex and under xelatex.

use crate::shown::one_line;
use crate::symbol::{Piece, pieces};

/// Signs that LaTeX has a command for. Braces keep `[` and `*` from being read as an option of the
/// row above, and `{}` keeps two signs from becoming one ligature.
const SIGNS: [(char, &str); 27] = [
    ('\\', r"\textbackslash{}"),
    ('{', r"\{"),
    ('}', r"\}"),
    ('%', r"\%"),
    ('&', r"\&"),
    ('_', r"\_"),
    ('#', r"\#"),
    ('$', r"\$"),
    ('~', r"\textasciitilde{}"),
    ('^', r"\textasciicircum{}"),
    ('<', r"\textless{}"),
    ('>', r"\textgreater{}"),
    ('|', r"\textbar{}"),
    ('"', r"\char34{}"),
    ('`', r"\char96{}"),
    ('[', "{[}"),
    (']', "{]}"),
    ('*', "{*}"),
    ('\u{a0}', "~"),
    ('\u{202f}', r"\,"),
    ('–', "--"),
    ('—', "---"),
    ('‘', "`{}"),
    ('’', "'{}"),
    ('“', "``{}"),
    ('”', "''{}"),
    ('…', r"\dots{}"),
];

/// Signs of mathematics and their commands, and letters of it with the names of theirs.
const MATHS: &str = r"° ^\circ, · \cdot, × \times, ÷ \div, ± \pm, − -, ≤ \leq, ≥ \geq, ≠ \neq, ≈ \approx, → \rightarrow, √ \surd, ∞ \infty, ẋ \dot{x}, ẍ \ddot{x}";
const GREEK: &str = "α alpha, β beta, γ gamma, δ delta, ε varepsilon, ζ zeta, η eta, θ theta, ϑ vartheta, \
    ι iota, κ kappa, λ lambda, μ mu, µ mu, ν nu, ξ xi, π pi, ρ rho, σ sigma, τ tau, \
    υ upsilon, φ varphi, ϕ phi, χ chi, ψ psi, ω omega, Γ Gamma, Δ Delta, Θ Theta, Λ Lambda, \
    Ξ Xi, Π Pi, Σ Sigma, Φ Phi, Ω Omega";

const RAISED: &str = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺";
const LOWERED: &str = "₀₁₂₃₄₅₆₇₈₉₋₊";
const LEVEL: &str = "0123456789-+";

/// `text` on one line, every sign of TeX escaped, symbols as mathematics.
///
/// Latin letters with accents are left as they are (both engines read UTF-8). A sign outside all of
/// these is given to engines that have Unicode fonts; pdflatex, which has no such fonts, sets its
/// number: `[U+4E2D]`.
///
/// What a symbol has below the line (`M_O`) is set there.
pub fn escape(text: &str) -> String {
    let line = one_line(text);
    let set = pieces(&line).into_iter().map(|piece| match piece {
        Piece::Plain(text) => plain(text),
        Piece::Below(text) => format!(r"\textsubscript{{{}}}", plain(text)),
    });
    set.collect()
}

fn plain(text: &str) -> String {
    let mut letters = text.chars().peekable();
    let mut escaped = String::new();
    while let Some(letter) = letters.next() {
        match letters.peek().copied().and_then(accent) {
            Some(accent) => {
                letters.next();
                escaped += &format!(r"\ensuremath{{\{accent}{{{}}}}}", base(letter));
            }
            None => escaped += &sign(letter),
        }
        // Two of these in a row are one sign to TeX: a dash, a closing or a low quote.
        if matches!(letter, '-' | '\'' | ',') && letters.peek() == Some(&letter) {
            escaped += "{}";
        }
    }
    escaped
}

/// The accent of mathematics for a combining sign.
fn accent(letter: char) -> Option<&'static str> {
    match letter {
        '\u{307}' => Some("dot"),
        '\u{308}' => Some("ddot"),
        '\u{304}' | '\u{305}' => Some("bar"),
        '\u{302}' => Some("hat"),
        _ => None,
    }
}

/// What stands under an accent: a Greek letter is mathematics already, all else is text.
fn base(letter: char) -> String {
    match look_up(GREEK, letter) {
        Some(name) => format!(r"\{name}"),
        None if letter.is_ascii_alphabetic() => letter.to_string(),
        None => format!(r"\mbox{{{}}}", sign(letter)),
    }
}

fn sign(letter: char) -> String {
    if let Some((_, command)) = SIGNS.iter().find(|(sign, _)| *sign == letter) {
        return (*command).to_owned();
    }
    if letter.is_ascii() {
        return letter.to_string();
    }
    if let Some(command) = look_up(MATHS, letter) {
        return format!(r"\ensuremath{{{command}}}");
    }
    if let Some(name) = look_up(GREEK, letter) {
        return format!(r"\ensuremath{{\{name}}}");
    }
    match (level(RAISED, letter), level(LOWERED, letter)) {
        (Some(raised), _) => format!(r"\ensuremath{{^{{{raised}}}}}"),
        (_, Some(lowered)) => format!(r"\ensuremath{{_{{{lowered}}}}}"),
        _ if is_latin(letter) => letter.to_string(),
        _ => format!(
            r"\ifdefined\Umathchar {letter}\else{{[}}U+{:04X}{{]}}\fi{{}}",
            u32::from(letter)
        ),
    }
}

fn look_up(table: &'static str, letter: char) -> Option<&'static str> {
    table.split(", ").find_map(|pair| pair.strip_prefix(letter)?.strip_prefix(' '))
}

/// The sign on the line for a raised or lowered one.
fn level(row: &str, letter: char) -> Option<char> {
    row.chars().zip(LEVEL.chars()).find(|(sign, _)| *sign == letter).map(|(_, level)| level)
}

/// Letters of western and central European languages and their marks, as far as pdflatex has them
/// in its T1 fonts.
fn is_latin(letter: char) -> bool {
    let lacking = matches!(letter, 'Ħ' | 'ħ' | 'ĸ' | 'Ŀ' | 'ŀ' | 'ŉ' | 'Ŧ' | 'ŧ');
    matches!(letter, 'À'..='ž' | '¡' | '¿' | '«' | '»' | '§' | '£' | '©') && !lacking
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str, expect: &str) {
        assert_eq!(escape(text), expect, "{text}");
    }

    #[test]
    fn the_ten_signs_of_tex_are_escaped() {
        check(r"\{}%&_#$~^", r"\textbackslash{}\{\}\%\&\_\#\$\textasciitilde{}\textasciicircum{}");
    }

    #[test]
    fn signs_that_old_fonts_show_wrongly_are_spelt_out() {
        check("<|>\"`", r"\textless{}\textbar{}\textgreater{}\char34{}\char96{}");
    }

    #[test]
    fn what_could_be_taken_for_an_option_is_braced_and_ligatures_are_kept_apart() {
        check("[1]* a--b", "{[}1{]}{*} a-{}-b");
        check(",, ''", ",{}, '{}'");
    }

    #[test]
    fn symbols_are_set_as_mathematics() {
        check("θ", r"\ensuremath{\theta}");
        check("θ\u{307} x\u{308}", r"\ensuremath{\dot{\theta}} \ensuremath{\ddot{x}}");
        check("10 °/s²", r"10 \ensuremath{^\circ}/s\ensuremath{^{2}}");
        check("N·m", r"N\ensuremath{\cdot}m");
        check("10⁻⁷", r"10\ensuremath{^{-}}\ensuremath{^{7}}");
        check("F₀ − – ±", r"F\ensuremath{_{0}} \ensuremath{-} -- \ensuremath{\pm}");
    }

    #[test]
    fn what_stands_below_a_symbol_is_set_there() {
        check("M_O and θ_rest", r"M\textsubscript{O} and \ensuremath{\theta}\textsubscript{rest}");
        check("spring_wall", r"spring\_wall");
    }

    #[test]
    fn accented_letters_stay_and_others_are_named_where_fonts_lack_them() {
        check("café ž", "café ž");
        check("中", r"\ifdefined\Umathchar 中\else{[}U+4E2D{]}\fi{}");
    }
}
