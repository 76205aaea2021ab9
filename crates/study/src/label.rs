//! Labels in words: those that people gave to modes and environments, contrasts, curves.

use crate::{Contrast, Coordinate, Curve, Mode};

/// A label where no sentence begins: the first letter is small unless its word is written large
/// throughout (PD) or inside (McRuer); the rest is as it was given.
pub fn in_a_sentence(label: &str) -> String {
    let mut letters = label.chars();
    let Some(first) = letters.next() else { return String::new() };
    let rest = letters.as_str();
    let word = rest.split(|c: char| !c.is_alphabetic()).next().unwrap_or_default();
    let is_a_word = !word.is_empty() && word.chars().all(char::is_lowercase);
    match is_a_word {
        true => first.to_lowercase().chain(rest.chars()).collect(),
        false => label.to_owned(),
    }
}

/// A contrast by the labels of its modes; by their ids if it has other modes.
pub fn contrast_label(modes: &[Mode], contrast: &Contrast) -> String {
    both_labels(modes, contrast).join(Contrast::MINUS)
}

/// The same where the difference is read as a ratio: `Hybrid / Active`.
pub fn ratio_label(modes: &[Mode], contrast: &Contrast) -> String {
    both_labels(modes, contrast).join(Contrast::OVER)
}

fn both_labels<'a>(modes: &'a [Mode], contrast: &'a Contrast) -> [&'a str; 2] {
    [&contrast.mode, &contrast.against]
        .map(|id| modes.iter().find(|mode| mode.id == *id).map_or(id.as_str(), |mode| &mode.label))
}

/// What a curve is in words: `user's force over the angle`.
pub fn curve_label(curve: Curve, coordinate: Coordinate) -> String {
    let position = match coordinate {
        Coordinate::Rotational => "angle",
        Coordinate::Linear { .. } => "displacement",
    };
    match curve {
        Curve::ForceOverAngle => format!("user's force over the {position}"),
        Curve::ForceOverTime => "user's force over time".to_owned(),
        Curve::ThetaOverTime => format!("{position} over time"),
        Curve::VelocityOverAngle => format!("velocity over the {position}"),
    }
}

#[cfg(test)]
mod tests {
    use super::in_a_sentence;

    #[test]
    fn only_the_first_letter_of_an_ordinary_word_becomes_small() {
        let pairs = [
            ("Motor", "motor"),
            ("Controller A", "controller A"),
            ("PD", "PD"),
            ("A", "A"),
            ("McRuer's model", "McRuer's model"),
            ("Ärmel Nord", "ärmel Nord"),
            ("hybrid", "hybrid"),
            ("3 N", "3 N"),
            ("", ""),
        ];
        for (label, expect) in pairs {
            assert_eq!(in_a_sentence(label), expect);
        }
    }
}
