//! Metrics that other programs compute: what they are called, their unit, and which values are better.

use crate::{Better, Curve, MetricId, printable};
use serde::Serialize;

/// The longest label, characters: one that still stands on an axis.
const LONGEST_LABEL: usize = 200;

/// A metric whose values come from outside: a table that was given, or a stage of the study's own.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct OutsideMetric {
    /// Its name, as who computes it says it: `grip_peak`.
    pub id: MetricId,
    /// The column that it is in tables of metrics: `own_grip_peak_n`. No metric of zwidth begins with
    /// `own_`, in any version.
    pub column: MetricId,
    /// Its unit; `1` of a pure number. Values are kept as they are given.
    pub unit: String,
    /// What people call it.
    pub label: String,
    /// Which values are better.
    pub better: Better,
    /// Who computed it, in words: `grip.py 1.2`; `None` where nobody said.
    pub program: Option<String>,
}

impl OutsideMetric {
    /// How the columns of such metrics begin.
    pub const PREFIX: &str = "own_";

    /// A metric of that id, unit and label, of which neither higher nor lower values are better.
    ///
    /// # Errors
    /// A unit that is not known ([`is_unit`]); a column that is no name of a metric; a label that is empty, too long, or that
    /// breaks a line. In words, and what to do.
    pub fn new(id: MetricId, unit: &str, label: &str) -> Result<Self, String> {
        if !is_unit(unit) {
            return Err(format!(
                "'{}' is not a unit that is known; write one such as N, N·m, rad/s, % or 1 for a pure number",
                printable(unit)
            ));
        }
        let label = label.trim();
        let is_short = (1..=LONGEST_LABEL).contains(&label.chars().count());
        if !is_short || label.chars().any(char::is_control) {
            return Err(format!(
                "the label must be one line of text of at most {LONGEST_LABEL} characters, such as \"largest grip\""
            ));
        }
        let name = id.as_str();
        if name.starts_with(Self::PREFIX) {
            return Err(format!("'{name}' has the prefix own_ already; leave it out, it is added"));
        }
        // Tables name the deviation of a metric so.
        if name.contains("_sd_") || name.ends_with("_sd") || Curve::from_word(name).is_some() {
            return Err(format!(
                "'{name}' is a name that tables have for something else; choose another id"
            ));
        }
        let column = format!("{}{}", Self::PREFIX, with_unit(name, unit));
        let column = MetricId::new(column.clone())
            .map_err(|_| format!("the column would be {column}, which has more than 32 characters; choose a shorter id"))?;
        Ok(Self {
            column,
            unit: unit.to_owned(),
            label: label.to_owned(),
            better: Better::Neither,
            program: None,
            id,
        })
    }

    /// Whether a metric of that name comes from outside.
    pub fn is_named(metric: &str) -> bool {
        metric.starts_with(Self::PREFIX)
    }

    /// What it measures, and who says so.
    pub fn in_words(&self) -> String {
        match &self.program {
            Some(program) => format!("{}: computed outside of zwidth by {program}", self.label),
            None => format!("{}: computed outside of zwidth", self.label),
        }
    }
}

/// A name that ends in its unit, if it does not yet: `grip_peak_n`.
fn with_unit(name: &str, unit: &str) -> String {
    let suffix = suffix(unit);
    if suffix.is_empty() || name.ends_with(&suffix) {
        name.to_owned()
    } else {
        format!("{name}{suffix}")
    }
}

/// How the name of a metric ends that has a unit: `_n_per_rad` for N/rad; empty for `1`. As in zwidth's own, a product
/// sign is `_` (and none in `nm`), and a solidus `_per_`, but before a time alone `_`: `rad_s`.
fn suffix(unit: &str) -> String {
    if unit == "1" {
        return String::new();
    }
    let is_rate =
        unit.rsplit_once('/').is_some_and(|(_, below)| ["s", "s²", "s³"].contains(&below));
    let slug = unit_in_names(unit, if is_rate { "_" } else { "_per_" }, "_");
    format!("_{slug}").replace("_n_m", "_nm")
}

/// A unit as it stands in a name: lower case, `solidus` for each `/` and `dot` for each `·`.
pub fn unit_in_names(unit: &str, solidus: &str, dot: &str) -> String {
    let mut slug = String::new();
    for letter in unit.chars() {
        match letter {
            '/' => slug.push_str(solidus),
            '·' => slug.push_str(dot),
            ' ' => {}
            '²' => slug.push('2'),
            '³' => slug.push('3'),
            '°' => slug.push_str("deg"),
            'µ' | 'μ' => slug.push('u'),
            'Ω' => slug.push_str("ohm"),
            '%' => slug.push_str("percent"),
            other => slug.extend(other.to_lowercase()),
        }
    }
    slug
}

/// Units that take the prefixes of the SI.
const WITH_PREFIX: [&str; 14] =
    ["m", "g", "s", "A", "K", "N", "J", "W", "V", "Hz", "Pa", "rad", "Ω", "B"];
/// Prefixes of the SI, from pico to giga. Two letters look like µ: both are typed.
const PREFIXES: [&str; 11] = ["p", "n", "µ", "μ", "m", "c", "d", "k", "M", "G", "h"];
/// Units that take none.
const PLAIN: [&str; 13] =
    ["°", "min", "h", "bit", "bits", "count", "counts", "points", "dB", "°C", "turn", "rpm", "%"];

/// Whether a unit is one that is known: `1`, a unit of the SI with or without a prefix, a few others (`°`, `%`, `min`, `h`,
/// `bit`, `counts`, `points`, `dB`, `rpm`), or products of them with `·`, powers `²` and `³`, and one `/`: `N·m/rad`.
pub fn is_unit(text: &str) -> bool {
    let is_one = |part: &str| {
        let part = part.strip_suffix(['²', '³']).unwrap_or(part);
        let prefixed = |prefix: &&str| {
            part.strip_prefix(*prefix).is_some_and(|unit| WITH_PREFIX.contains(&unit))
        };
        PLAIN.contains(&part) || WITH_PREFIX.contains(&part) || PREFIXES.iter().any(prefixed)
    };
    let is_product = |text: &str| text.split('·').all(is_one);
    match text.split_once('/') {
        None => text == "1" || is_product(text),
        Some((above, below)) => (above == "1" || is_product(above)) && is_product(below),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn column(id: &str, unit: &str) -> String {
        OutsideMetric::new(id.parse().unwrap(), unit, "grip").unwrap().column.to_string()
    }

    #[test]
    fn a_column_is_the_id_between_its_prefix_and_its_unit() {
        for (id, unit, expect) in [
            ("grip_peak", "N", "own_grip_peak_n"),
            ("grip_peak_n", "N", "own_grip_peak_n"),
            ("delay", "ms", "own_delay_ms"),
            ("k", "N/rad", "own_k_n_per_rad"),
            ("speed", "rad/s", "own_speed_rad_s"),
            ("jerk", "m/s³", "own_jerk_m_s3"),
            ("impulse", "N·s", "own_impulse_n_s"),
            ("torque", "N·m", "own_torque_nm"),
            ("inertia", "kg·m²", "own_inertia_kg_m2"),
            ("share", "%", "own_share_percent"),
            ("entropy", "1", "own_entropy"),
            ("tremor", "1/s", "own_tremor_1_s"),
        ] {
            assert_eq!(column(id, unit), expect);
        }
    }

    #[test]
    fn units_are_products_and_quotients_of_known_ones() {
        for unit in [
            "1",
            "N",
            "mN",
            "kN",
            "N·m",
            "N/rad",
            "N·s²/rad",
            "rad/s²",
            "%",
            "°",
            "dB",
            "1/s",
            "µm",
            "μm",
        ] {
            assert!(is_unit(unit), "{unit}");
        }
        for unit in
            ["", "newton", "n", "N/", "/s", "N//m", "N/m/s", "N m", "2", "N·", "N^2", "furlong"]
        {
            assert!(!is_unit(unit), "{unit}");
        }
    }

    #[test]
    fn what_cannot_be_a_metric_is_refused_with_what_to_do() {
        let told = |id: &str, unit: &str, label: &str| {
            OutsideMetric::new(id.parse().unwrap(), unit, label).unwrap_err()
        };
        assert!(told("grip", "newton", "grip").contains("'newton' is not a unit that is known"));
        assert!(told("grip", "N", " ").contains("one line of text"));
        assert!(told("grip", "N", "a\nb").contains("one line of text"));
        assert!(told("grip", "N", &"a".repeat(201)).contains("at most 200 characters"));
        assert!(told("own_grip", "N", "grip").contains("leave it out"));
        assert!(told("grip_sd", "N", "grip").contains("choose another id"));
        assert!(told(&"g".repeat(30), "N", "grip").contains("choose a shorter id"));
    }
}
