//! What ids stand for: the names by which people know them.

use crate::display::theta_to_x;
use crate::heading::words;
use crate::unit::split_unit;
use crate::{Column, Table, TableError, Values, for_people};
use serde::Serialize;
use std::borrow::Cow;
use zwidth_study::{Contrast, Coordinate, Study};

/// Columns whose texts are names that people gave, or keys that other files refer to.
const AS_THEY_ARE: [&str; 4] = ["participant", "session", "study", "key"];
/// Units that a metric's name can end with, those that end with another of them before it.
const METRIC_UNITS: [&str; 11] =
    ["N·s/rad", "N/rad", "rad/s", "N·s", "N/W", "rad", "Hz", "J", "N", "m", "s"];
/// Ids that are names of people or of formulas.
const PROPER: [(&str, &str); 6] = [
    ("dormand_prince", "Dormand–Prince"),
    ("moreau_jean", "Moreau–Jean"),
    ("rk4_per_stage", "RK4 per stage"),
    ("rk4_per_step", "RK4 per step"),
    ("symplectic_euler", "symplectic Euler"),
    ("tr_bdf2", "TR-BDF2"),
];

/// How the tables of a study speak to people: in which units, and which names its ids have.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Wording {
    /// Whether the coordinate is a lever's angle or a slide's position.
    pub coordinate: Coordinate,
    /// Ids of environments and their labels.
    pub environments: Vec<(String, String)>,
    /// Ids of modes and their labels.
    pub modes: Vec<(String, String)>,
    /// Significant digits of numbers; without them by their uncertainty, where it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub digits: Option<usize>,
}

impl Wording {
    /// That of a study.
    pub fn of(study: &Study) -> Self {
        let environments = study.environments.iter();
        let modes = study.modes.iter();
        Self {
            environments: environments.map(|e| (e.id.to_string(), e.label.clone())).collect(),
            modes: modes.map(|m| (m.id.to_string(), m.label.clone())).collect(),
            ..Self::plain(study.coordinate)
        }
    }

    /// That of a study without labels.
    pub fn plain(coordinate: Coordinate) -> Self {
        Self { coordinate, environments: Vec::new(), modes: Vec::new(), digits: None }
    }

    /// The table as people read it: in their units, its ids as names and words.
    ///
    /// # Errors
    /// Those of [`for_people`].
    pub fn tell(&self, table: &Table) -> Result<Table, TableError> {
        let table = for_people(table, self.coordinate)?;
        let mut columns = table.columns().to_vec();
        for Column { field, values } in &mut columns {
            if let Values::Text(texts) = values {
                for text in texts.iter_mut().flatten() {
                    *text = self.words(&field.name, text).into_owned().into();
                }
            }
        }
        let worded = Table::new(table.name(), table.title(), with_units(columns))?;
        Ok(worded.with_notes(table.notes_by_kind()))
    }

    fn words<'a>(&'a self, column: &str, text: &'a str) -> Cow<'a, str> {
        match column {
            "environment" => label(&self.environments, text).unwrap_or(text).into(),
            "mode" => label(&self.modes, text).unwrap_or(text).into(),
            "effect" => match label(&self.modes, text) {
                Some(label) => label.into(),
                None => self.contrast(text).map_or_else(|| id(text), Cow::from),
            },
            "metric" => self.metric(text),
            column if AS_THEY_ARE.contains(&column) => text.into(),
            _ => self.contrast(text).map_or_else(|| id(text), Cow::from),
        }
    }

    /// Two modes as their labels: `hybrid − active`.
    fn contrast(&self, text: &str) -> Option<String> {
        let Contrast { mode, against } = text.parse().ok()?;
        let [mode, against] = [mode, against].map(|mode| label(&self.modes, mode.as_str()));
        Some(format!("{} − {}", mode?, against?))
    }

    /// A metric's name in words, without its unit: `wall_past_max_rad` → `wall past max`.
    fn metric<'a>(&self, name: &'a str) -> Cow<'a, str> {
        if !is_id(name) {
            return name.into();
        }
        let unit = METRIC_UNITS.iter().find(|unit| !split_unit(name, unit).1.is_empty());
        let unit = unit.copied().unwrap_or("1");
        match self.coordinate {
            Coordinate::Rotational => words(name, unit).into(),
            Coordinate::Linear { .. } => words(&theta_to_x(name), unit).into(),
        }
    }
}

/// Where a column of units stands behind the metrics', both as one: `duration (s)`.
fn with_units(mut columns: Vec<Column>) -> Vec<Column> {
    let mut pairs = columns.windows(2);
    let beside =
        pairs.position(|pair| pair[0].field.name == "metric" && pair[1].field.name == "unit");
    let Some(at) = beside else { return columns };
    if let (Values::Text(units), Values::Text(metrics)) =
        (columns.remove(at + 1).values, &mut columns[at].values)
    {
        for (metric, unit) in metrics.iter_mut().zip(units) {
            if let (Some(metric), Some(unit)) = (metric, unit.filter(|unit| **unit != *"1")) {
                *metric = format!("{metric} ({unit})").into();
            }
        }
    }
    columns
}

/// The label of an id.
fn label<'a>(labels: &'a [(String, String)], id: &str) -> Option<&'a str> {
    labels.iter().find(|(own, _)| own == id).map(|(_, label)| label.as_str())
}

/// An id of ours in words; other texts as they are.
fn id(text: &str) -> Cow<'_, str> {
    if let Some((_, name)) = PROPER.iter().find(|(id, _)| *id == text) {
        return (*name).into();
    }
    match is_id(text) {
        true => text.replace('_', " ").into(),
        false => text.into(),
    }
}

fn is_id(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_lowercase())
        && text.chars().all(|c| matches!(c, 'a'..='z' | '0'..='9' | '_'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::UNIT_OF_ROW;

    #[test]
    fn a_metric_has_its_unit_behind_it_in_the_studys_coordinate() {
        let columns = vec![
            Column::text("metric", "", ["theta_max", "share"].map(Some)),
            Column::text("unit", "", ["rad", "1"].map(Some)),
            Column::float("hybrid", UNIT_OF_ROW, "", [Some(0.5), Some(0.25)]),
        ];
        let table = Table::new("t", "", columns).unwrap();
        let told = |coordinate| {
            let told = Wording::plain(coordinate).tell(&table).unwrap();
            assert!(told.texts("unit").is_err());
            told.texts("metric").unwrap().into_iter().flatten().collect::<Vec<_>>()
        };
        assert_eq!(told(Coordinate::Rotational), ["θ max (°)", "share"]);
        assert_eq!(told(Coordinate::Linear { lever_m: 0.05 }), ["x max (mm)", "share"]);
    }

    fn wording() -> Wording {
        let labels = |pairs: [(&str, &str); 2]| {
            pairs.map(|(id, label)| (id.to_owned(), label.to_owned())).to_vec()
        };
        Wording {
            environments: labels([("spring_wall", "Spring and wall"), ("free", "Free")]),
            modes: labels([("active", "Motor alone"), ("hybrid", "Hybrid")]),
            ..Wording::plain(Coordinate::Rotational)
        }
    }

    #[test]
    fn ids_are_told_by_the_studys_labels_and_in_words() {
        for (column, text, expect) in [
            ("environment", "spring_wall", "Spring and wall"),
            ("environment", "unlisted_one", "unlisted_one"),
            ("mode", "active", "Motor alone"),
            ("contrast", "hybrid − active", "Hybrid − Motor alone"),
            ("contrast", "S02 − S01", "S02 − S01"),
            ("participant", "left_handed", "left_handed"),
            ("key", "active_passes", "active_passes"),
            ("causality", "closed_loop", "closed loop"),
            ("solver", "moreau_jean", "Moreau–Jean"),
            ("metric", "theta_max_rad", "θ max"),
            ("metric", "stiffness_n_per_rad", "stiffness"),
            ("metric", "force_rms_error_n", "force RMS error"),
            ("metric", "rendered stiffness", "rendered stiffness"),
            ("formula", "y = a + b max(x - x0, 0)", "y = a + b max(x - x0, 0)"),
            ("shown", "tables/metrics.md", "tables/metrics.md"),
            ("parameter", "M_O", "M_O"),
        ] {
            assert_eq!(wording().words(column, text), expect, "{column}");
        }
    }
}
