//! `[[factors]]`, `compare.effects` and `[[compare.weighted]]` of a `study.toml`.

use super::check::Check;
use super::environment::EnvironmentTable;
use super::shape::WeightedTable;
use crate::{
    DoseScale, EnvironmentId, Factor, FactorId, FactorOf, Levels, Mode, ModeId, SessionId, Term,
    Trend, Weight, Weighted,
};
use std::collections::{BTreeMap, BTreeSet};

/// No study has more factors.
const MOST_FACTORS: usize = 4;
/// No study has more effects, or weighted contrasts.
const MOST_EFFECTS: usize = 32;
/// Weights that add up to less than this share of themselves add up to 0.
const ROUNDING: f64 = 1e-9;

impl WeightedTable {
    pub(super) fn of(weighted: &Weighted) -> Self {
        let weights =
            weighted.weights.iter().map(|Weight { session, environment, mode, weight }| {
                let session = session.as_ref().map(|id| format!("{id}/")).unwrap_or_default();
                (format!("{session}{environment}/{mode}"), *weight)
            });
        Self { id: weighted.id.clone(), weights: weights.collect() }
    }
}

impl Check<'_> {
    /// The factors, and the levels that modes and environments have of them.
    pub(super) fn factors(
        &mut self,
        factors: &[Factor],
        modes: &[Mode],
        environments: &[EnvironmentTable],
    ) {
        self.unique("factors", factors.iter().map(|factor| factor.id.as_str()));
        if factors.len() > MOST_FACTORS {
            let n = factors.len();
            let problem = format!("the list has {n} entries; at most {MOST_FACTORS} are allowed");
            self.error("factors", problem);
        }
        for (i, factor) in factors.iter().enumerate() {
            self.levels(&format!("factors[{i}].levels"), &factor.levels);
            if let Some(unit) = &factor.unit {
                self.doses(i, factor, unit);
            }
            if factor.of != FactorOf::Sessions {
                continue;
            }
            if factors[..i].iter().any(|other| other.of == FactorOf::Sessions) {
                let problem = "is the second factor of sessions; a session is a level of one alone";
                self.error(&format!("factors[{i}].of"), problem);
            }
            for (k, level) in factor.levels.iter().enumerate() {
                if let Err(error) = SessionId::new(level.as_str()) {
                    self.error(&format!("factors[{i}].levels[{k}]"), error.to_string());
                }
            }
        }
        let of_modes = modes.iter().map(|mode| (mode.id.as_str(), &mode.factors));
        self.levels_of("mode", FactorOf::Modes, of_modes.collect(), factors);
        let of_environments = environments.iter().map(|e| (e.id.as_str(), &e.factors));
        self.levels_of("environment", FactorOf::Environments, of_environments.collect(), factors);
    }

    /// A dose: numbers, ascending.
    fn doses(&mut self, i: usize, factor: &Factor, unit: &str) {
        self.line(&format!("factors[{i}].unit"), unit);
        if unit.trim().is_empty() {
            self.error(&format!("factors[{i}].unit"), "is empty; a unit of a pure number is \"1\"");
        }
        if unit.contains(" × ") {
            let problem = "contains ' × ', by which tables join factors; write '·'";
            self.error(&format!("factors[{i}].unit"), problem);
        }
        if factor.of == FactorOf::Sessions {
            let problem = "is not used for sessions, whose levels are ids; leave it out";
            self.error(&format!("factors[{i}].unit"), problem);
        }
        let numbers: Vec<Option<f64>> =
            factor.levels.iter().map(|level| level.as_str().parse().ok()).collect();
        for (k, level) in factor.levels.iter().enumerate() {
            let problem = match (numbers[k], k.checked_sub(1).and_then(|before| numbers[before])) {
                (Some(number), _) if !number.is_finite() => "is not a finite number",
                (None, _) => {
                    "is not a number; a factor with a unit is a dose: leave the unit out for words"
                }
                (Some(number), Some(before)) if number <= before => {
                    "is not above the one before; doses ascend"
                }
                _ => continue,
            };
            self.error(&format!("factors[{i}].levels[{k}]"), format!("'{level}' {problem}"));
        }
    }

    /// `[compare.trend]`: of doses, with levels enough, and above 0 where they are doubled.
    pub(super) fn trends(
        &mut self,
        trends: BTreeMap<FactorId, Trend>,
        factors: &[Factor],
    ) -> BTreeMap<FactorId, Trend> {
        for (id, Trend { degree, scale }) in &trends {
            let key = format!("compare.trend.{id}");
            let doses = factors.iter().find(|factor| factor.id == *id).and_then(Factor::doses);
            let Some(doses) = doses else {
                self.error(
                    &key,
                    format!("'{id}' is no factor with a unit; give it one, and numbers"),
                );
                continue;
            };
            if !(1..=2).contains(degree) {
                self.error(
                    &key,
                    format!("the degree {degree} must be 1 (a line) or 2 (a bend too)"),
                );
            } else if doses.len() <= usize::from(*degree) {
                let n = doses.len();
                let problem =
                    format!("{n} levels are too few for degree {degree}; give it a lower one");
                self.error(&key, problem);
            }
            if *scale == DoseScale::Log2 && doses.iter().any(|dose| *dose <= 0.0) {
                self.error(&key, "a dose of 0 or below has no doublings; use scale = \"linear\"");
            }
        }
        trends
    }

    /// That each of `all`, which are modes or environments, has one level of every factor of theirs, and no two
    /// the same.
    fn levels_of(
        &mut self,
        what: &str,
        of: FactorOf,
        all: Vec<(&str, &Levels)>,
        factors: &[Factor],
    ) {
        let own: Vec<&Factor> = factors.iter().filter(|factor| factor.of == of).collect();
        let mut seen: BTreeMap<&Levels, &str> = BTreeMap::new();
        for (i, (id, levels)) in all.into_iter().enumerate() {
            let key = format!("{what}s[{i}].factors");
            for (factor, level) in levels {
                let known = own.iter().find(|own| own.id == *factor);
                let problem = match known {
                    None => {
                        format!("there is no factor '{factor}' of {what}s; name it in [[factors]]")
                    }
                    Some(own) if !own.levels.contains(level) => {
                        let all: Vec<&str> =
                            own.levels.iter().map(|level| level.as_str()).collect();
                        format!("'{level}' is no level of {factor}; there are {}", all.join(", "))
                    }
                    Some(_) => continue,
                };
                self.error(&format!("{key}.{factor}"), problem);
            }
            for factor in own.iter().filter(|factor| !levels.contains_key(&factor.id)) {
                let first = factor.levels.first().map_or("…", |level| level.as_str());
                let problem = format!(
                    "{what} '{id}' has no level of {0}; add factors = {{ {0} = \"{first}\" }} or another one",
                    factor.id
                );
                self.error(&format!("{what}s[{i}]"), problem);
            }
            if let Some(other) = seen.insert(levels, id).filter(|_| !own.is_empty()) {
                let problem = format!(
                    "{what}s '{other}' and '{id}' have the same level of every factor; add a factor in \
                     which they differ"
                );
                self.error(&key, problem);
            }
        }
    }

    /// `compare.effects`; without it every factor, and every interaction of two.
    pub(super) fn effects(&mut self, chosen: Option<Vec<Term>>, factors: &[Factor]) -> Vec<Term> {
        let Some(chosen) = chosen else { return default_effects(factors) };
        if factors.is_empty() {
            let problem = "is not used without [[factors]]; add them";
            self.error("compare.effects", problem);
        }
        if chosen.len() > MOST_EFFECTS {
            let n = chosen.len();
            let problem = format!("the list has {n} entries; at most {MOST_EFFECTS} are allowed");
            self.error("compare.effects", problem);
        }
        let mut seen = BTreeSet::new();
        for (i, term) in chosen.iter().enumerate() {
            let key = format!("compare.effects[{i}]");
            let distinct: BTreeSet<&FactorId> = term.0.iter().collect();
            let unknown = term.0.iter().find(|id| factors.iter().all(|factor| factor.id != **id));
            if let Some(unknown) = unknown {
                let all: Vec<&str> = factors.iter().map(|factor| factor.id.as_str()).collect();
                self.error(
                    &key,
                    format!("there is no factor '{unknown}'; there are {}", all.join(", ")),
                );
            } else if distinct.len() < term.0.len() {
                self.error(&key, format!("'{term}' names a factor twice; leave one out"));
            } else if !seen.insert(distinct) {
                self.error(&key, format!("'{term}' stands twice; leave one out"));
            }
        }
        chosen
    }

    /// `[[compare.weighted]]`.
    pub(super) fn weighted(
        &mut self,
        tables: Vec<WeightedTable>,
        factors: &[Factor],
        modes: &[Mode],
        environments: &[EnvironmentTable],
    ) -> Vec<Weighted> {
        self.unique("compare.weighted", tables.iter().map(|table| table.id.as_str()));
        if tables.len() > MOST_EFFECTS {
            let n = tables.len();
            let problem = format!("the list has {n} entries; at most {MOST_EFFECTS} are allowed");
            self.error("compare.weighted", problem);
        }
        let mut all = Vec::new();
        for (i, WeightedTable { id, weights: table }) in tables.into_iter().enumerate() {
            let key = format!("compare.weighted[{i}]");
            if factors.iter().any(|factor| factor.id == id) {
                self.error(&format!("{key}.id"), format!("'{id}' is a factor; choose another id"));
            }
            let mut weights = Vec::new();
            for (name, weight) in table {
                let key = format!("{key}.weights");
                let condition = condition(&name, modes, environments);
                match condition {
                    None => {
                        let problem = format!(
                            "there is no condition '{name}'; write the environment's id, '/' and the mode's, \
                             and before both a session's and '/' if it is to count there alone"
                        );
                        self.error(&key, problem);
                    }
                    Some(_) if !weight.is_finite() || weight == 0.0 => {
                        let problem = format!(
                            "'{name}' has the weight {weight}: give it one, or leave it out"
                        );
                        self.error(&key, problem);
                    }
                    Some((session, environment, mode)) => {
                        weights.push(Weight { session, environment, mode, weight });
                    }
                }
            }
            let sum: f64 = weights.iter().map(|weight| weight.weight).sum();
            let size: f64 = weights.iter().map(|weight| weight.weight.abs()).sum();
            if sum.abs() > ROUNDING * size || weights.is_empty() {
                let problem = format!(
                    "the weights add up to {sum}; those of a contrast add up to 0, such as 1 and -1"
                );
                self.error(&key, problem);
            }
            if weights.iter().any(|weight| weight.session.is_some() != weights[0].session.is_some())
            {
                let problem =
                    "some conditions name a session and others none; name it of all or of none";
                self.error(&key, problem);
            }
            all.push(Weighted { id, weights });
        }
        all
    }
}

/// What a weight is of: `spring/hybrid`, or `S01/spring/hybrid`; `None` if the study has no such condition.
fn condition(
    name: &str,
    modes: &[Mode],
    environments: &[EnvironmentTable],
) -> Option<(Option<SessionId>, EnvironmentId, ModeId)> {
    let mut parts = name.rsplit('/');
    let mode = ModeId::new(parts.next()?).ok()?;
    let environment = EnvironmentId::new(parts.next()?).ok()?;
    let session = parts.next().map(SessionId::new).transpose().ok()?;
    let is_known = parts.next().is_none()
        && environments.iter().any(|own| own.id == environment)
        && modes.iter().any(|own| own.id == mode);
    is_known.then_some((session, environment, mode))
}

/// Every factor, then every interaction of two.
pub(super) fn default_effects(factors: &[Factor]) -> Vec<Term> {
    let ids: Vec<&FactorId> = factors.iter().map(|factor| &factor.id).collect();
    let pairs = ids.iter().enumerate().flat_map(|(i, first)| {
        ids[i + 1..].iter().map(move |second| vec![(*first).clone(), (*second).clone()])
    });
    ids.iter().map(|id| vec![(*id).clone()]).chain(pairs).map(Term).collect()
}

#[cfg(test)]
mod tests {
    use crate::tests::{check_refused, check_round_trip, text};
    use crate::{Study, StudyError};

    const FACTOR: &str = "[[factors]]\nid = \"strong\"\nlevels = [\"no\", \"some\", \"yes\"]\n";

    /// The template's study whose modes have these levels of a factor, and these lines after it.
    fn with(levels: [&str; 3], factor: &str, more: &str) -> Result<Study, Vec<StudyError>> {
        let ids = ["active", "passive", "hybrid"].into_iter().zip(levels);
        let text = ids.fold(text(), |text, (id, level)| match level {
            "" => text,
            _ => {
                let id = format!("id = \"{id}\"");
                text.replacen(&id, &format!("{id}\nfactors = {{ strong = \"{level}\" }}"), 1)
            }
        });
        Study::from_toml(&format!("{text}\n{factor}{more}\n"))
    }

    #[test]
    fn factors_effects_and_weights_survive_a_round_trip() {
        let weighted = "[[compare.weighted]]\nid = \"wall_costs\"\nweights = { \"spring_wall/hybrid\" = 1, \
                        \"spring_wall/active\" = -1, \"spring/hybrid\" = -1, \"spring/active\" = 1 }\n";
        let study = with(["no", "some", "yes"], FACTOR, weighted).unwrap();
        check_round_trip(&study);
        assert!(study.compare.contrasts.is_empty(), "effects are compared in their place");
        let names: Vec<String> = study.effects().iter().map(|e| e.term.to_string()).collect();
        assert_eq!(names, ["strong", "strong", "strong", "strong", "wall_costs"]);
        let grown = weighted.replace("\"spring", "\"S02/spring");
        let study = with(["no", "some", "yes"], FACTOR, &grown).unwrap();
        check_round_trip(&study);
        let study = with(["no", "some", "yes"], FACTOR, "[compare]\neffects = []\n").unwrap();
        assert!(study.effects().is_empty());
        assert_eq!(study.compare.contrasts.len(), 2, "modes are compared as without factors");
        check_round_trip(&study);
    }

    #[test]
    fn what_cannot_be_meant_is_one_error_with_key_and_remedy() {
        let all = ["no", "some", "yes"];
        let weights =
            |weights: &str| format!("[[compare.weighted]]\nid = \"w\"\nweights = {{ {weights} }}");
        for (levels, factor, more, key, words) in [
            (
                ["no", "", "yes"],
                FACTOR,
                String::new(),
                "modes[1]",
                "add factors = { strong = \"no\" }",
            ),
            (
                ["no", "middling", "yes"],
                FACTOR,
                String::new(),
                "modes[1].factors.strong",
                "no, some, yes",
            ),
            (
                ["no", "no", "yes"],
                FACTOR,
                String::new(),
                "modes[1].factors",
                "'active' and 'passive'",
            ),
            (
                ["", "", "yes"],
                "",
                String::new(),
                "modes[2].factors.strong",
                "name it in [[factors]]",
            ),
            (
                all,
                FACTOR,
                "[compare]\neffects = [\"weak\"]".into(),
                "compare.effects[0]",
                "there are strong",
            ),
            (
                all,
                FACTOR,
                "[compare]\neffects = [\"strong:strong\"]".into(),
                "compare.effects[0]",
                "a factor twice",
            ),
            (
                all,
                FACTOR,
                "[compare]\neffects = [\"strong\", \"strong\"]".into(),
                "compare.effects[1]",
                "stands twice",
            ),
            (["", "", ""], "", "[compare]\neffects = []".into(), "compare.effects", "add them"),
            (
                all,
                FACTOR,
                weights("\"spring/hybrid\" = 1, \"spring/active\" = -0.5"),
                "compare.weighted[0]",
                "add up to 0.5",
            ),
            (
                all,
                FACTOR,
                weights("\"spring/hybrid\" = 1, \"spring/none\" = -1, \"spring/active\" = -1"),
                "compare.weighted[0].weights",
                "no condition 'spring/none'",
            ),
            (
                all,
                FACTOR,
                weights("\"spring/hybrid\" = 1, \"spring/active\" = -1")
                    .replace("\"w\"", "\"strong\""),
                "compare.weighted[0].id",
                "is a factor",
            ),
        ] {
            check_refused(with(levels, factor, &more), key, words);
        }
    }

    #[test]
    fn a_dose_is_numbers_with_a_unit_and_has_a_slope_a_bend_and_pairs_for_its_analysis() {
        let dose = "[[factors]]\nid = \"strong\"\nlevels = [0.5, 1, 2.25]\nunit = \"N\"\n";
        let trend = "[compare]\ntrend.strong = { degree = 2 }\n";
        let study = with(["0.5", "1", "2.25"], dose, trend).unwrap();
        check_round_trip(&study);
        let first = &study.environments[0].id;
        let effects = study.effects();
        let here: Vec<_> =
            effects.iter().filter(|e| e.environment.as_ref() == Some(first)).collect();
        let shown = |k: usize| (here[k].levels[0].to_string(), here[k].is_claimed);
        assert_eq!(shown(0), ("per 1 N".to_owned(), true));
        assert_eq!(shown(1), ("bend per (1 N)²".to_owned(), true));
        assert_eq!(shown(2), ("1 − 0.5".to_owned(), false));
        assert_eq!(here.len(), 4);
        // By least squares: of 3 + 2 x − x² the bend is −1.
        let bend: f64 = here[1]
            .weights
            .iter()
            .zip([2.25, 1.0, 0.5_f64])
            .map(|(w, x)| w.weight * (3.0 + 2.0 * x - x * x))
            .sum();
        assert!((bend + 1.0).abs() < 1e-12, "{bend}");
    }

    #[test]
    fn a_dose_that_is_none_is_one_error() {
        let dose = |levels: &str| {
            format!("[[factors]]\nid = \"strong\"\nlevels = {levels}\nunit = \"N\"\n")
        };
        let all = ["1", "2", "3"];
        for (levels, factor, more, key, words) in [
            (all, dose("[1, 3, 2]"), "", "factors[0].levels[2]", "'2' is not above the one before"),
            (
                ["no", "2", "3"],
                dose("[\"no\", 2, 3]"),
                "",
                "factors[0].levels[0]",
                "is not a number",
            ),
            (
                all,
                dose("[1, 2, 3]"),
                "[compare]\ntrend.weak = {}",
                "compare.trend.weak",
                "no factor with a unit",
            ),
            (
                all,
                dose("[1, 2, 3]"),
                "[compare]\ntrend.strong = { degree = 3 }",
                "compare.trend.strong",
                "must be 1 (a line)",
            ),
            (
                ["0", "2", "3"],
                dose("[0, 2, 3]"),
                "[compare]\ntrend.strong = { scale = \"log2\" }",
                "compare.trend.strong",
                "no doublings",
            ),
        ] {
            check_refused(with(levels, &factor, more), key, words);
        }
    }
}
