//! `[[environments]]` of `study.toml`: the keys of a scene's numbers, in both coordinates.

use super::check::Check;
use super::units::{MILLI, decimal, degrees};
use crate::model::{Coordinate, Environment};
use crate::scene::SceneNumber;
use crate::{EnvironmentId, Levels, QuestionId, SceneKind, TaskLevel};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EnvironmentTable {
    pub(super) id: EnvironmentId,
    pub(super) label: String,
    kind: SceneKind,
    stiffness_n_per_rad: Option<f64>,
    rest_deg: Option<f64>,
    wall_deg: Option<f64>,
    stiffness_n_per_mm: Option<f64>,
    rest_mm: Option<f64>,
    wall_mm: Option<f64>,
    question: Option<QuestionId>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    questions: Vec<QuestionId>,
    #[serde(
        default,
        skip_serializing_if = "BTreeMap::is_empty",
        deserialize_with = "crate::factors::levels"
    )]
    pub(super) factors: Levels,
}

impl SceneNumber {
    /// Every number, in the order in which problems are reported.
    const ALL: [Self; 3] = [Self::Stiffness, Self::Rest, Self::Wall];

    /// Whether it is typed as a position: in degrees, or millimetres. Else it is 0 or above, over
    /// an angle: per radian, or per millimetre.
    fn is_position(self) -> bool {
        matches!(self, Self::Rest | Self::Wall)
    }

    /// Its keys in a rotational and in a linear study.
    const fn keys(self) -> [&'static str; 2] {
        match self {
            Self::Stiffness => ["stiffness_n_per_rad", "stiffness_n_per_mm"],
            Self::Rest => ["rest_deg", "rest_mm"],
            Self::Wall => ["wall_deg", "wall_mm"],
        }
    }

    /// Its key in a study of this coordinate.
    fn key(self, coordinate: Coordinate) -> &'static str {
        self.keys()[usize::from(coordinate != Coordinate::Rotational)]
    }

    /// A value as it is typed, in SI units.
    fn in_si(self, typed: f64, coordinate: Coordinate) -> f64 {
        match (coordinate, self.is_position()) {
            (Coordinate::Rotational, true) => typed.to_radians(),
            (Coordinate::Rotational, false) => typed,
            (Coordinate::Linear { lever_m }, true) => typed * MILLI / lever_m,
            (Coordinate::Linear { lever_m }, false) => typed * (lever_m / MILLI),
        }
    }
}

// What a task may vary: every number of an environment that study.toml has a key for.
impl Environment {
    /// The keys of its numbers, as they are typed in a study of this coordinate.
    pub fn keys(&self, coordinate: Coordinate) -> Vec<&'static str> {
        self.scene.kind().quantities().iter().map(|quantity| quantity.key(coordinate)).collect()
    }

    /// The environment where the number of a key has this level, in the unit of the key; `None` if it has no such number.
    #[must_use]
    pub fn with_level(&self, key: &str, level: TaskLevel, coordinate: Coordinate) -> Option<Self> {
        let kind = self.scene.kind();
        let varies = kind.quantities().iter().find(|quantity| quantity.key(coordinate) == key)?;
        let scene = kind.scene(|quantity| match quantity == *varies {
            true => varies.in_si(level.value(), coordinate),
            // It has every number of its kind.
            false => self.scene.value(quantity).unwrap_or_default(),
        });
        Some(Self { scene, ..self.clone() })
    }
}

impl EnvironmentTable {
    /// The keys of a number in a rotational and in a linear study, and their values.
    fn entries(&self, quantity: SceneNumber) -> [(&'static str, Option<f64>); 2] {
        let [rotational, linear] = quantity.keys();
        let values = match quantity {
            SceneNumber::Stiffness => [self.stiffness_n_per_rad, self.stiffness_n_per_mm],
            SceneNumber::Rest => [self.rest_deg, self.rest_mm],
            SceneNumber::Wall => [self.wall_deg, self.wall_mm],
        };
        [(rotational, values[0]), (linear, values[1])]
    }

    /// The table of an environment.
    pub(super) fn of(e: &Environment, coordinate: Coordinate) -> Self {
        // Of each number in degrees and in millimetres: one of the two is always none.
        let [stiffness, rest, wall] = SceneNumber::ALL.map(|quantity| {
            let value = e.scene.value(quantity);
            match (coordinate, quantity.is_position()) {
                (Coordinate::Rotational, true) => [value.map(degrees), None],
                (Coordinate::Rotational, false) => [value, None],
                (Coordinate::Linear { lever_m }, true) => {
                    [None, value.map(|rad| decimal(rad * lever_m / MILLI))]
                }
                (Coordinate::Linear { lever_m }, false) => {
                    [None, value.map(|per_rad| decimal(per_rad / lever_m * MILLI))]
                }
            }
        });
        Self {
            id: e.id.clone(),
            label: e.label.clone(),
            kind: e.scene.kind(),
            stiffness_n_per_rad: stiffness[0],
            rest_deg: rest[0],
            wall_deg: wall[0],
            stiffness_n_per_mm: stiffness[1],
            rest_mm: rest[1],
            wall_mm: wall[1],
            question: e.question.clone().filter(|_| e.further.is_empty()),
            questions: if e.further.is_empty() {
                Vec::new()
            } else {
                e.questions().cloned().collect()
            },
            factors: e.factors.clone(),
        }
    }
}

impl Check<'_> {
    /// The environment of a table, which stands at `at` in the file.
    pub(super) fn environment(
        &mut self,
        at: &str,
        e: &EnvironmentTable,
        coordinate: Coordinate,
        questions: &BTreeSet<&str>,
    ) -> Environment {
        let own_questions = self.asked_questions(at, e, questions);
        let mut values = BTreeMap::new();
        for quantity in e.kind.quantities() {
            values.insert(*quantity, self.quantity(at, e, *quantity, coordinate));
        }
        self.refuse_unused(at, e, coordinate);
        Environment {
            id: e.id.clone(),
            label: e.label.clone(),
            scene: e.kind.scene(|quantity| values.get(&quantity).copied().unwrap_or_default()),
            question: own_questions.first().cloned(),
            further: own_questions.into_iter().skip(1).collect(),
            factors: e.factors.clone(),
        }
    }

    /// The questions after its trials: one, or several.
    fn asked_questions(
        &mut self,
        at: &str,
        e: &EnvironmentTable,
        questions: &BTreeSet<&str>,
    ) -> Vec<QuestionId> {
        if e.question.is_some() && !e.questions.is_empty() {
            let what = "is not used beside questions; put it into that list";
            self.error(&format!("{at}.question"), what);
        }
        self.at_most_listed(&format!("{at}.questions"), e.questions.len());
        let one = e.question.iter().map(|q| (format!("{at}.question"), q));
        let several = e.questions.iter().enumerate();
        let several = several.map(|(i, q)| (format!("{at}.questions[{i}]"), q));
        let mut seen = BTreeSet::new();
        for (key, q) in one.chain(several) {
            if !questions.contains(q.as_str()) {
                self.error(&key, format!("'{q}' is not the id of any [[questions]]"));
            } else if !seen.insert(q.as_str()) {
                let what = format!("'{q}' stands twice; a question is asked once after a trial");
                self.error(&key, what);
            }
        }
        e.question.iter().chain(&e.questions).cloned().collect()
    }

    /// A number that the environment's kind takes, in SI units.
    fn quantity(
        &mut self,
        at: &str,
        e: &EnvironmentTable,
        quantity: SceneNumber,
        coordinate: Coordinate,
    ) -> f64 {
        let [(deg_key, deg), (mm_key, mm)] = e.entries(quantity);
        if quantity.is_position() {
            return self.position(at, [deg_key, mm_key], [deg, mm], coordinate, None);
        }
        let (key, value, factor) = match coordinate {
            Coordinate::Rotational => (deg_key, deg, 1.0),
            Coordinate::Linear { lever_m } => (mm_key, mm, lever_m / MILLI),
        };
        let key = format!("{at}.{key}");
        let value = self.required(&key, value);
        self.not_negative(&key, value) * factor
    }

    /// A key that the environment's kind or the study's coordinate gives no meaning to is a
    /// mistake.
    fn refuse_unused(&mut self, at: &str, e: &EnvironmentTable, coordinate: Coordinate) {
        // As in `entries`: 0 is the rotational key, 1 the linear one.
        let here = usize::from(coordinate != Coordinate::Rotational);
        for place in [0, 1] {
            for quantity in SceneNumber::ALL {
                let keys = e.entries(quantity);
                let taken = e.kind.quantities().contains(&quantity);
                if keys[place].1.is_none() || (taken && place == here) {
                    continue;
                }
                let meant = match taken {
                    true => format!("; with this coordinate it is {}", keys[here].0),
                    false => String::new(),
                };
                let problem =
                    format!("is not used for this kind of environment and coordinate{meant}");
                self.error(&format!("{at}.{}", keys[place].0), problem);
            }
        }
    }
}
