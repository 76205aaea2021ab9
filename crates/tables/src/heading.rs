//! From a column's name to its heading, and to the part that it plays.

use crate::Field;
use crate::unit::split_unit;

/// Words of names that people write otherwise.
const WORDS: [(&str, &str); 16] = [
    ("theta", "θ"),
    ("ci", "CI"),
    ("jnd", "JND"),
    ("pse", "PSE"),
    ("weber", "Weber"),
    ("icc", "ICC"),
    ("rms", "RMS"),
    ("rmse", "RMSE"),
    ("sd", "SD"),
    ("std", "std."),
    ("r2", "R²"),
    ("aicc", "AICc"),
    ("likert", "Likert"),
    ("nrmse", "NRMSE"),
    ("sparc", "SPARC"),
    ("vaf", "VAF"),
];

/// A dot above the sign before it: a first derivative in time.
const DOT: char = '\u{307}';
/// Two dots above the sign before it: a second derivative in time.
const DDOT: char = '\u{308}';

/// The column's heading for people: its name in words, and its unit in brackets unless that is 1.
///
/// `loop_area_j` → `loop area (J)`, `theta_dot_max_deg_s` → `θ̇ max (°/s)`.
pub fn heading(field: &Field) -> String {
    let words = words(&field.name, &field.unit);
    match bracketed(field) {
        Some(unit) => format!("{words} {unit}"),
        None => words,
    }
}

/// The unit in brackets, unless it is 1.
pub(crate) fn bracketed(field: &Field) -> Option<String> {
    (field.unit != "1" && !field.unit.is_empty()).then(|| format!("({})", field.unit))
}

/// A name without its unit, in words.
pub(crate) fn words(name: &str, unit: &str) -> String {
    let (stem, _) = split_unit(name, unit);
    let mut text = String::new();
    let mut symbol = false; // whether a dot can go above what was written last
    for word in stem.split('_') {
        match word {
            "dot" if symbol => text.push(DOT),
            "ddot" if symbol => text.push(DDOT),
            _ => {
                text += if text.is_empty() { "" } else { " " };
                text += WORDS.iter().find(|(name, _)| *name == word).map_or(word, |(_, own)| own);
            }
        }
        symbol = matches!(word, "theta" | "x");
    }
    text
}

/// The part a column plays in a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Part {
    Estimate,
    StdError,
    Sd,
    CiLow,
    CiHigh,
}

/// What a quantity is called whose columns have no name of its own: `std_error`, `ci_low`.
const ONLY_QUANTITY: &str = "estimate";

/// The quantity a column belongs to, and its part in it (naming rule: crate docs).
pub(crate) fn quantity(field: &Field) -> (&str, Part) {
    let (stem, _) = split_unit(&field.name, &field.unit);
    for (word, part) in [
        ("std_error", Part::StdError),
        ("sd", Part::Sd),
        ("ci_low", Part::CiLow),
        ("ci_high", Part::CiHigh),
    ] {
        match stem.strip_suffix(word) {
            Some("") => return (ONLY_QUANTITY, part),
            Some(rest) if rest.ends_with('_') => return (rest.trim_end_matches('_'), part),
            _ => {}
        }
    }
    // A table of means has one quantity, and the mean is its estimate.
    (if stem == "mean" { ONLY_QUANTITY } else { stem }, Part::Estimate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Type;

    fn field(name: &'static str, unit: &'static str) -> Field {
        Field { name: name.into(), unit: unit.into(), description: "".into(), kind: Type::Float }
    }

    #[test]
    fn headings_are_words_with_the_unit_in_brackets() {
        for (name, unit, expect) in [
            ("loop_area_j", "J", "loop area (J)"),
            ("theta_max_deg", "°", "θ max (°)"),
            ("theta_dot_max_deg_s", "°/s", "θ\u{307} max (°/s)"),
            ("x_ddot_mm_s2", "mm/s²", "x\u{308} (mm/s²)"),
            ("slope_std_error_n_per_mm", "N/mm", "slope std. error (N/mm)"),
            ("slope_ci_low_n_per_rad", "N/rad", "slope CI low (N/rad)"),
            ("r2", "1", "R²"),
            ("dot_product", "1", "dot product"),
            ("mode", "1", "mode"),
        ] {
            assert_eq!(heading(&field(name, unit)), expect);
        }
    }

    #[test]
    fn a_name_says_which_quantity_it_is_part_of() {
        for (name, unit, expect) in [
            ("slope_n_per_rad", "N/rad", ("slope", Part::Estimate)),
            ("slope_std_error_n_per_rad", "N/rad", ("slope", Part::StdError)),
            ("exponent_ci_high", "1", ("exponent", Part::CiHigh)),
            ("ci_low", "1", ("estimate", Part::CiLow)),
            ("estimate", "1", ("estimate", Part::Estimate)),
            ("mean_n", "N", ("estimate", Part::Estimate)),
            ("sd_n", "N", ("estimate", Part::Sd)),
            ("stiffness_sd_n_per_rad", "N/rad", ("stiffness", Part::Sd)),
            ("velocity_sd_ratio", "1", ("velocity_sd_ratio", Part::Estimate)),
        ] {
            assert_eq!(quantity(&field(name, unit)), expect);
        }
    }
}
