//! `[[environments]]` of `study.toml`: the keys of a scene's numbers, in both coordinates.

use super::check::{Check, FARTHEST_DEG, FARTHEST_MM};
use crate::model::{Coordinate, Environment};
use crate::scene::SceneNumber;
use crate::{EnvironmentId, Levels, QuestionId, SceneKind};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// No force is larger, N.
const LARGEST_N: f64 = 1e6;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EnvironmentTable {
    pub(super) id: EnvironmentId,
    pub(super) label: String,
    kind: SceneKind,
    stiffness_n_per_rad: Option<f64>,
    rest_deg: Option<f64>,
    wall_deg: Option<f64>,
    force_n: Option<f64>,
    delay_ms: Option<f64>,
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

impl EnvironmentTable {
    /// The keys of a number in a rotational and in a linear study, and their values.
    fn entries(&self, quantity: SceneNumber) -> [(&'static str, Option<f64>); 2] {
        let values = match quantity {
            SceneNumber::Stiffness => [self.stiffness_n_per_rad, self.stiffness_n_per_mm],
            SceneNumber::Rest => [self.rest_deg, self.rest_mm],
            SceneNumber::Wall => [self.wall_deg, self.wall_mm],
            SceneNumber::Force => [self.force_n; 2],
            SceneNumber::Delay => [self.delay_ms; 2],
        };
        let [rotational, linear] = quantity.keys();
        [(rotational, values[0]), (linear, values[1])]
    }

    /// The table of an environment.
    pub(super) fn of(e: &Environment, coordinate: Coordinate) -> Self {
        let typed = |number: SceneNumber| Some(number.typed(e.number(number)?, coordinate));
        // Of each number along the coordinate in degrees and in millimetres: one of the two is always none.
        let along = |number| match coordinate {
            Coordinate::Rotational => [typed(number), None],
            Coordinate::Linear { .. } => [None, typed(number)],
        };
        let [stiffness, rest, wall] =
            [SceneNumber::Stiffness, SceneNumber::Rest, SceneNumber::Wall].map(along);
        Self {
            id: e.id.clone(),
            label: e.label.clone(),
            kind: e.scene.kind(),
            stiffness_n_per_rad: stiffness[0],
            rest_deg: rest[0],
            wall_deg: wall[0],
            force_n: typed(SceneNumber::Force),
            // At once is what is meant where nothing is written.
            delay_ms: typed(SceneNumber::Delay).filter(|delay_ms| *delay_ms != 0.0),
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
        let delay_s = self.delay(at, e, coordinate);
        self.refuse_unused(at, e, coordinate);
        Environment {
            id: e.id.clone(),
            label: e.label.clone(),
            scene: e.kind.scene(|quantity| values.get(&quantity).copied().unwrap_or_default()),
            delay_s,
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
        let [rotational, linear] = e.entries(quantity);
        let (key, value) = match coordinate {
            Coordinate::Rotational => rotational,
            Coordinate::Linear { .. } => linear,
        };
        let key = format!("{at}.{key}");
        let value = self.required(&key, value);
        self.typed(&key, quantity, value, coordinate)
    }

    /// By how much the environment is rendered late, s: at once unless it says so.
    fn delay(&mut self, at: &str, e: &EnvironmentTable, coordinate: Coordinate) -> f64 {
        let Some(delay_ms) = e.delay_ms else { return 0.0 };
        self.typed(&format!("{at}.delay_ms"), SceneNumber::Delay, delay_ms, coordinate)
    }

    /// A number as it is typed, in SI units; one that no environment can have is an error.
    pub(super) fn typed(
        &mut self,
        key: &str,
        number: SceneNumber,
        value: f64,
        coordinate: Coordinate,
    ) -> f64 {
        let value = match (number, coordinate) {
            (SceneNumber::Rest | SceneNumber::Wall, Coordinate::Rotational) => {
                self.near(key, value, FARTHEST_DEG)
            }
            (SceneNumber::Rest | SceneNumber::Wall, Coordinate::Linear { .. }) => {
                self.near(key, value, FARTHEST_MM)
            }
            (SceneNumber::Force, _) => self.near(key, value, LARGEST_N),
            (SceneNumber::Stiffness | SceneNumber::Delay, _) => self.not_negative(key, value),
        };
        let si = number.si(value, coordinate);
        if number == SceneNumber::Delay && si > Environment::LONGEST_DELAY_S {
            let most = number.typed(Environment::LONGEST_DELAY_S, coordinate);
            self.error(key, format!("{value} must be at most {most}"));
        }
        si
    }

    /// A key that the environment's kind or the study's coordinate gives no meaning to is a
    /// mistake.
    fn refuse_unused(&mut self, at: &str, e: &EnvironmentTable, coordinate: Coordinate) {
        // As in `entries`: 0 is the rotational key, 1 the linear one.
        let here = usize::from(coordinate != Coordinate::Rotational);
        for place in [0, 1] {
            for quantity in SceneNumber::ALL {
                let keys = e.entries(quantity);
                let taken = e.kind.takes(quantity);
                let is_one = keys[0].0 == keys[1].0;
                if keys[place].1.is_none() || (taken && place == here) || (is_one && place != here)
                {
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

#[cfg(test)]
mod tests {
    use crate::tests::{check_refused, check_round_trip, demo, text as sample};
    use crate::{Scene, Study};

    const SPRING: &str = "kind = \"spring\"\nstiffness_n_per_rad = 4.0\nrest_deg = -45.0";

    #[test]
    fn a_constant_force_and_a_delay_survive_a_round_trip() {
        let force = "kind = \"force\"\nforce_n = -1.5\ndelay_ms = 12.3";
        let study = Study::from_toml(&sample().replacen(SPRING, force, 1)).unwrap();
        let environment = &study.environments[0];
        assert_eq!(environment.scene, Scene::Force { force_n: -1.5 });
        assert!((environment.delay_s - 0.0123).abs() < 1e-15);
        check_round_trip(&study);
        let slide = study.to_toml().unwrap().replace("\"rotational\"", "\"linear\"");
        assert!(slide.contains("delay_ms = 12.3"), "{slide}");
    }

    #[test]
    fn an_environment_without_a_delay_is_written_as_it_always_was() {
        let none = demo();
        assert!(!none.to_toml().unwrap().contains("delay"));
        let json = serde_json::to_string(&none.environments[0]).unwrap();
        assert!(!json.contains("delay") && !json.contains("force"), "{json}");
        let zero = sample().replacen(SPRING, &format!("{SPRING}\ndelay_ms = 0.0"), 1);
        assert_eq!(Study::from_toml(&zero).unwrap(), none);
    }

    #[test]
    fn a_force_or_a_delay_that_makes_no_sense_is_refused_by_key() {
        let check = |now: &str, key: &str, words: &str| {
            check_refused(Study::from_toml(&sample().replacen(SPRING, now, 1)), key, words);
        };
        let with = |more: &str| format!("{SPRING}\n{more}");
        let (force, delay) = ("environments[0].force_n", "environments[0].delay_ms");
        check("kind = \"force\"", force, "missing");
        check("kind = \"force\"\nforce_n = nan", force, "finite");
        check(&with("force_n = 1.0"), force, "is not used");
        check(&with("delay_ms = 1001.0"), delay, "1001 must be at most 1000");
        check(&with("delay_ms = -1.0"), delay, "0 or a number above");
        check("kind = \"free\"\ndelay_ms = 5.0", delay, "is not used");
        check("kind = \"none\"\ndelay_ms = 5.0", delay, "is not used");
    }

    #[test]
    fn a_delay_is_rendered_in_whole_ticks() {
        let mut environment = demo().environments[0].clone();
        environment.delay_s = 0.0124;
        assert_eq!(environment.delay_ticks(1000.0), 12);
        assert!((environment.delivered_delay_s(1000.0) - 0.012).abs() < 1e-15);
        assert!((environment.delivered_delay_s(120.0) - 1.0 / 120.0).abs() < 1e-15);
        assert_eq!(environment.delay_ticks(30.0), 0);
        assert!(environment.delivered_delay_s(30.0).abs() < 1e-15);
    }
}
