//! The effects of factors that a study compares.

use crate::{
    EnvironmentId, Factor, FactorId, FactorOf, LevelContrast, LevelId, ModeId, OverDose, Study,
    Term, Trend, Weight,
};
use serde::Serialize;
use std::collections::BTreeMap;

/// An effect: one weight for each of some conditions, with which everybody's means are added up.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Effect {
    /// What it is of.
    pub term: Term,
    /// How the levels of each factor are compared; none of a weighted contrast.
    pub levels: Vec<LevelContrast>,
    /// The environment in which it is; `None` of one over several.
    pub environment: Option<EnvironmentId>,
    /// The weights, which add up to 0; none where the study lacks a condition for it.
    pub weights: Vec<Weight>,
    /// Of the slope, or the bend, over a dose alone: everybody's line over the levels they have. The weights are
    /// those of somebody who has all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over: Option<OverDose>,
    /// Whether it is claimed; else it is part of an analysis of variance alone.
    pub is_claimed: bool,
    /// The condition that the study lacks, or those within which the effect is, where not all are there.
    pub lacks: Option<String>,
}

/// A condition with the level of every factor that it has.
struct Crossed<'a> {
    session: Option<&'a LevelId>,
    environment: &'a EnvironmentId,
    mode: &'a ModeId,
    levels: BTreeMap<&'a FactorId, &'a LevelId>,
}

/// A curve over a dose: the mean of everybody's own line, or parabola, over their means of its levels.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DoseCurve {
    /// The dose.
    pub dose: FactorId,
    /// The factor, and its level, within which the curve is; the other factors are averaged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub within: Option<WithinLevel>,
    /// The environment in which it is; `None` of one over several.
    pub environment: Option<EnvironmentId>,
    /// The line or parabola, and what its levels are means of.
    pub over: OverDose,
}

/// A level of a factor.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct WithinLevel {
    /// The factor.
    pub factor: FactorId,
    /// Its level.
    pub level: LevelId,
}

impl Effect {
    /// Whether each of its weights is of one session; else everybody's sessions are averaged.
    pub fn is_by_session(&self) -> bool {
        self.weights.iter().any(|weight| weight.session.is_some())
    }
}

impl Study {
    /// The effects that the study compares: of each term, every later level of a factor less the first, the
    /// other factors averaged; in every environment, unless a factor is of environments.
    pub fn effects(&self) -> Vec<Effect> {
        let mut effects = Vec::new();
        for place in self.places_of_effects() {
            let crossed = self.crossed(place);
            for term in &self.compare.effects {
                effects.extend(self.effects_of(term, place, &crossed));
            }
        }
        effects.extend(self.compare.weighted.iter().map(|weighted| {
            let first = &weighted.weights[0].environment;
            let is_within = weighted.weights.iter().all(|weight| weight.environment == *first);
            Effect {
                term: Term(vec![weighted.id.clone()]),
                levels: Vec::new(),
                environment: is_within.then(|| first.clone()),
                weights: weighted.weights.clone(),
                over: None,
                is_claimed: true,
                lacks: None,
            }
        }));
        effects
    }

    /// The curves over doses that belong to the effects: of each dose that is an effect one, the other factors averaged as in
    /// its slope; of each interaction of a dose with one other factor one for every level of that. These are within the
    /// same conditions of any third factor, those in which each level has every dose, so that their slopes can be compared;
    /// without such a condition there are none.
    pub fn dose_curves(&self) -> Vec<DoseCurve> {
        let mut curves = Vec::new();
        for place in self.places_of_effects() {
            let crossed = self.crossed(place);
            let mut add = |dose: &Factor, within: Option<WithinLevel>| {
                let over = self.over_dose(dose, within.as_ref(), place, &crossed);
                curves.extend(over.map(|over| DoseCurve {
                    dose: dose.id.clone(),
                    within,
                    environment: place.cloned(),
                    over,
                }));
            };
            for term in &self.compare.effects {
                let of_term =
                    term.0.iter().filter_map(|id| self.factors.iter().find(|own| own.id == *id));
                match of_term.collect::<Vec<&Factor>>()[..] {
                    [dose] => add(dose, None),
                    [one, other] => {
                        for (dose, factor) in [(one, other), (other, one)] {
                            for level in &factor.levels {
                                let (factor, level) = (factor.id.clone(), level.clone());
                                add(dose, Some(WithinLevel { factor, level }));
                            }
                        }
                    }
                    _ => {}
                }
            }
        }
        curves
    }

    /// Where effects are: in each environment; over all of them, which `None` stands for, if a factor is of environments.
    fn places_of_effects(&self) -> Vec<Option<&EnvironmentId>> {
        match self.factors.iter().any(|factor| factor.of == FactorOf::Environments) {
            true => vec![None],
            false => self.environments.iter().map(|environment| Some(&environment.id)).collect(),
        }
    }

    /// The line, or parabola, over a dose, with the conditions of each of its levels; `None` of a factor that is no dose, and
    /// where the study lacks conditions for it.
    fn over_dose(
        &self,
        dose: &Factor,
        within: Option<&WithinLevel>,
        place: Option<&EnvironmentId>,
        crossed: &[Crossed<'_>],
    ) -> Option<OverDose> {
        let doses = dose.doses()?;
        let other =
            within.and_then(|within| self.factors.iter().find(|factor| factor.id == within.factor));
        let of_term: Vec<&Factor> = std::iter::once(dose).chain(other).collect();
        let term = Term(of_term.iter().map(|factor| factor.id.clone()).collect());
        let others: Vec<&Factor> =
            self.factors.iter().filter(|factor| !term.0.contains(&factor.id)).collect();
        // One level alone. As in a trend, the others must be there too.
        let alone = |factor: &Factor, is_it: &dyn Fn(usize) -> bool| {
            let weights = (0..factor.levels.len()).map(|place| f64::from(u8::from(is_it(place))));
            (LevelContrast::Trend(String::new()), weights.collect::<Vec<f64>>())
        };
        let mut levels = Vec::new();
        for level in 0..doses.len() {
            let of_dose = alone(dose, &|place| place == level);
            let of_other = other.zip(within).map(|(factor, within)| {
                alone(factor, &|place| factor.levels[place] == within.level)
            });
            let chosen: Vec<_> = std::iter::once(&of_dose).chain(&of_other).collect();
            let mut mean =
                self.effect_of(&term, &of_term, &others, &chosen, place, crossed).weights;
            mean.retain(|weight| weight.weight != 0.0);
            levels.push(mean);
        }
        let trend = self.compare.trend.get(&dose.id).copied().unwrap_or_default();
        let over = OverDose { trend, doses, unit: dose.unit.clone()?, levels };
        over.levels.iter().all(|level| !level.is_empty()).then_some(over)
    }

    /// The conditions in an environment, or in all, with the levels of their modes and environments.
    fn crossed(&self, place: Option<&EnvironmentId>) -> Vec<Crossed<'_>> {
        let of_sessions = self.factors.iter().find(|factor| factor.of == FactorOf::Sessions);
        let sessions: Vec<Option<&LevelId>> = match of_sessions {
            Some(factor) => factor.levels.iter().map(Some).collect(),
            None => vec![None],
        };
        let mut crossed = Vec::new();
        for environment in &self.environments {
            if place.is_some_and(|place| environment.id != *place) {
                continue;
            }
            for mode in &self.modes {
                for session in &sessions {
                    let own = of_sessions.map(|factor| &factor.id).zip(*session);
                    crossed.push(Crossed {
                        session: *session,
                        environment: &environment.id,
                        mode: &mode.id,
                        levels: environment
                            .factors
                            .iter()
                            .chain(&mode.factors)
                            .chain(own)
                            .collect(),
                    });
                }
            }
        }
        crossed
    }

    /// The effects of a term: one for each choice of a later level of its factors.
    fn effects_of(
        &self,
        term: &Term,
        place: Option<&EnvironmentId>,
        crossed: &[Crossed<'_>],
    ) -> Vec<Effect> {
        let of_term =
            term.0.iter().filter_map(|id| self.factors.iter().find(|factor| factor.id == *id));
        let of_term: Vec<&Factor> = of_term.collect();
        let others: Vec<&Factor> =
            self.factors.iter().filter(|factor| !term.0.contains(&factor.id)).collect();
        // Of each factor the ways to compare its levels: every later one less the first; of a dose its trend
        // too, with a bend where it is not crossed with others.
        let pairs = |factor: &&Factor| -> Vec<(LevelContrast, Vec<f64>)> {
            let all = factor.levels.iter().enumerate().skip(1);
            let pairs = all.map(|(later, level)| {
                let mut weights = vec![0.0; factor.levels.len()];
                (weights[0], weights[later]) = (-1.0, 1.0);
                (LevelContrast::Pair([level.clone(), factor.levels[0].clone()]), weights)
            });
            pairs.collect()
        };
        let over = |factor: &Factor| {
            let trend = self.compare.trend.get(&factor.id).copied().unwrap_or_default();
            let degree = if term.0.len() > 1 { 1 } else { trend.degree };
            Some(OverDose {
                trend: Trend { degree, ..trend },
                doses: factor.doses()?,
                unit: factor.unit.clone()?,
                levels: Vec::new(),
            })
        };
        let trends = |factor: &&Factor| match over(factor) {
            Some(over) => {
                let all: Vec<usize> = (0..over.doses.len()).collect();
                let contrasts = over.trend.contrasts(&over.doses, &over.unit).into_iter();
                let weighed = (1..).zip(contrasts).filter_map(|(number, contrast)| {
                    Some((contrast, over.coefficient(&all, number)?))
                });
                weighed.collect()
            }
            None => pairs(factor),
        };
        let has_dose = of_term.iter().any(|factor| factor.unit.is_some());
        let claimed = of_term.iter().map(trends).collect();
        let described = has_dose.then(|| of_term.iter().map(pairs).collect());
        let mut effects = Vec::new();
        for (is_claimed, contrasts) in
            std::iter::once((true, claimed)).chain(described.map(|pairs| (false, pairs)))
        {
            let contrasts: Vec<Vec<(LevelContrast, Vec<f64>)>> = contrasts;
            for chosen in choices(contrasts.iter().map(|all| all.iter().collect())) {
                let effect = self.effect_of(term, &of_term, &others, &chosen, place, crossed);
                let over = match (of_term.as_slice(), chosen.as_slice()) {
                    ([dose], [(LevelContrast::Trend(_), _)]) => {
                        self.over_dose(dose, None, place, crossed)
                    }
                    _ => None,
                };
                effects.push(Effect { is_claimed, over, ..effect });
            }
        }
        effects
    }

    /// The effect of a term with one way to compare the levels of each of its factors.
    fn effect_of(
        &self,
        term: &Term,
        of_term: &[&Factor],
        others: &[&Factor],
        chosen: &[&(LevelContrast, Vec<f64>)],
        place: Option<&EnvironmentId>,
        crossed: &[Crossed<'_>],
    ) -> Effect {
        // What is averaged: the other factors, and the modes where none of the factors tells them apart.
        let strata = choices(others.iter().map(|factor| factor.levels.iter().collect()));
        let is_of_modes = self.factors.iter().any(|factor| factor.of == FactorOf::Modes);
        let modes: Vec<Option<&ModeId>> = match is_of_modes {
            true => vec![None],
            false => self.modes.iter().map(|mode| Some(&mode.id)).collect(),
        };
        // Every level with a weight, of every factor: a condition's weight is the product of theirs.
        let weighed = choices(of_term.iter().zip(chosen).map(|(factor, (contrast, weights))| {
            let is_trend = matches!(contrast, LevelContrast::Trend(_));
            // The level that is compared before the one that it is compared with.
            let all = factor.levels.iter().zip(weights.iter().copied()).rev();
            all.filter(|(_, weight)| is_trend || *weight != 0.0).collect()
        }));
        let mut weights = Vec::new();
        let mut within = Vec::new();
        let mut first_missing = None;
        for (stratum, mode) in strata.iter().flat_map(|s| modes.iter().map(move |m| (s, *m))) {
            let same: Vec<(&FactorId, &LevelId)> =
                others.iter().map(|factor| &factor.id).zip(stratum.iter().copied()).collect();
            let cells = weighed.iter().map(|levels| {
                let own = term.0.iter().zip(levels.iter().map(|(level, _)| *level));
                let wanted: Vec<(&FactorId, &LevelId)> = own.chain(same.iter().copied()).collect();
                let found = crossed.iter().find(|cell| {
                    mode.is_none_or(|mode| cell.mode == mode)
                        && wanted.iter().all(|(id, level)| cell.levels.get(id) == Some(level))
                });
                let weight: f64 = levels.iter().map(|(_, weight)| weight).product();
                found.map(|cell| (cell, weight)).ok_or_else(|| in_words(&wanted))
            });
            match cells.collect::<Result<Vec<_>, String>>() {
                Ok(cells) => {
                    within.push(in_words(&same));
                    weights.extend(cells.into_iter().map(|(cell, weight)| Weight {
                        // A level of a factor of sessions is one's id.
                        session: cell.session.and_then(|id| id.as_str().parse().ok()),
                        environment: cell.environment.clone(),
                        mode: cell.mode.clone(),
                        weight,
                    }));
                }
                Err(missing) => first_missing = first_missing.or(Some(missing)),
            }
        }
        let complete = within.len();
        // The same for each mode, where no factor tells modes apart.
        within.dedup();
        weights.iter_mut().for_each(|weight| weight.weight /= complete as f64);
        let lacks = match first_missing {
            Some(missing) if complete == 0 => {
                Some(format!("cannot be estimated: no condition has {missing}"))
            }
            Some(_) => Some(format!("within {}", within.join("; "))),
            None => None,
        };
        Effect {
            term: term.clone(),
            levels: chosen.iter().map(|(contrast, _)| contrast.clone()).collect(),
            environment: place.cloned(),
            weights,
            over: None,
            is_claimed: true,
            lacks,
        }
    }
}

/// `motor = no, brake = no`.
fn in_words(levels: &[(&FactorId, &LevelId)]) -> String {
    let all: Vec<String> =
        levels.iter().map(|(factor, level)| format!("{factor} = {level}")).collect();
    all.join(", ")
}

/// Every way to choose one from each list, the last list's choice changing fastest.
fn choices<T: Copy>(lists: impl Iterator<Item = Vec<T>>) -> Vec<Vec<T>> {
    lists.fold(vec![Vec::new()], |chosen, list| {
        let with = |before: &Vec<T>| {
            let before = before.clone();
            list.iter().map(move |next| [&before[..], &[*next]].concat()).collect::<Vec<_>>()
        };
        chosen.iter().flat_map(with).collect()
    })
}

#[cfg(test)]
mod tests {
    use crate::tests::text;
    use crate::{Study, Weight};

    /// The template's study with the factors motor and brake, and these modes.
    fn with(modes: &[(&str, &str, &str)], more: &str) -> Study {
        let text = text();
        let (before, rest) = text.split_once("[[modes]]").unwrap();
        let (_, questions) = rest.split_once("[[questions]]").unwrap();
        let modes: String = modes
            .iter()
            .map(|(id, motor, brake)| {
                format!(
                    "[[modes]]\nid = \"{id}\"\nlabel = \"{id}\"\n\
                     factors = {{ motor = \"{motor}\", brake = \"{brake}\" }}\n"
                )
            })
            .collect();
        let factors = "[[factors]]\nid = \"motor\"\nlevels = [\"no\", \"yes\"]\n\
                       [[factors]]\nid = \"brake\"\nlevels = [\"no\", \"yes\"]\n";
        let text = format!("{before}{modes}{factors}[[questions]]{questions}\n{more}");
        Study::from_toml(&text).unwrap()
    }

    fn weights(weights: &[Weight]) -> Vec<(&str, f64)> {
        weights.iter().map(|w| (w.mode.as_str(), w.weight)).collect()
    }

    const THREE: [(&str, &str, &str); 3] =
        [("active", "yes", "no"), ("passive", "no", "yes"), ("hybrid", "yes", "yes")];

    #[test]
    fn of_all_four_an_effect_averages_the_other_factor_and_an_interaction_is_a_difference_of_differences()
     {
        let all = [&[("none", "no", "no")], &THREE[..]].concat();
        let study = with(&all, "");
        let effects = study.effects();
        let first = &study.environments[0].id;
        let here: Vec<_> =
            effects.iter().filter(|effect| effect.environment.as_ref() == Some(first)).collect();
        assert_eq!(effects.len(), 3 * study.environments.len());
        let names: Vec<String> = here.iter().map(|effect| effect.term.to_string()).collect();
        assert_eq!(names, ["motor", "brake", "motor:brake"]);
        let motor = [("active", 0.5), ("none", -0.5), ("hybrid", 0.5), ("passive", -0.5)];
        assert_eq!(weights(&here[0].weights), motor);
        let crossed = [("hybrid", 1.0), ("active", -1.0), ("passive", -1.0), ("none", 1.0)];
        assert_eq!(weights(&here[2].weights), crossed);
        assert!(here.iter().all(|effect| effect.lacks.is_none()));
    }

    #[test]
    fn without_a_condition_effects_are_within_those_there_are_and_the_interaction_says_which_lacks()
    {
        let study = with(&THREE, "");
        let effects = study.effects();
        let [motor, brake, both] = &effects[..3] else { panic!("{effects:?}") };
        assert_eq!(weights(&motor.weights), [("hybrid", 1.0), ("passive", -1.0)]);
        assert_eq!(motor.lacks.as_deref(), Some("within brake = yes"));
        assert_eq!(weights(&brake.weights), [("hybrid", 1.0), ("active", -1.0)]);
        assert!(both.weights.is_empty());
        let lacks = "cannot be estimated: no condition has motor = no, brake = no";
        assert_eq!(both.lacks.as_deref(), Some(lacks));
    }

    #[test]
    fn a_factor_of_environments_makes_effects_over_all_of_them() {
        let text = text()
            .replacen("kind = \"spring\"", "kind = \"spring\"\nfactors = { wall = \"no\" }", 1)
            .replacen(
                "kind = \"spring_wall\"",
                "kind = \"spring_wall\"\nfactors = { wall = \"yes\" }",
                1,
            );
        let text = format!(
            "{text}\n[[factors]]\nid = \"wall\"\nlevels = [\"no\", \"yes\"]\nof = \"environments\"\n"
        );
        // Modes of the same level of every factor: none is of modes.
        let study = Study::from_toml(&text).unwrap();
        let [wall] = &study.effects()[..] else { panic!("{:?}", study.effects()) };
        assert_eq!((wall.environment.as_ref(), wall.weights.len()), (None, 6));
        assert_eq!(wall.lacks, None);
    }

    #[test]
    fn a_factor_of_sessions_crosses_every_other_and_each_weight_names_its_session() {
        let text =
            text().replacen("id = \"active\"", "id = \"active\"\nfactors = { strong = \"no\" }", 1);
        let text = text.replacen(
            "id = \"passive\"",
            "id = \"passive\"\nfactors = { strong = \"some\" }",
            1,
        );
        let text =
            text.replacen("id = \"hybrid\"", "id = \"hybrid\"\nfactors = { strong = \"yes\" }", 1);
        let study = Study::from_toml(&format!(
            "{text}\n[[factors]]\nid = \"strong\"\nlevels = [\"no\", \"some\", \"yes\"]\n\
             [[factors]]\nid = \"time\"\nlevels = [\"pre\", \"post\"]\nof = \"sessions\"\n\
             [compare]\neffects = [\"time\", \"strong:time\"]\n"
        ));
        let study = study.unwrap();
        let effects = study.effects();
        let of = |k: usize| {
            let weights = effects[k].weights.iter();
            let named = weights
                .map(|w| (w.session.as_ref().unwrap().as_str(), w.mode.as_str(), 3.0 * w.weight));
            named.collect::<Vec<_>>()
        };
        let time = ["active", "passive", "hybrid"]
            .into_iter()
            .flat_map(|mode| [("post", mode, 1.0), ("pre", mode, -1.0)]);
        assert_eq!(of(0), time.collect::<Vec<_>>());
        let crossed = [
            ("post", "passive", 3.0),
            ("pre", "passive", -3.0),
            ("post", "active", -3.0),
            ("pre", "active", 3.0),
        ];
        assert_eq!(of(1), crossed);
        // In each of the two environments time, and two later levels with it.
        assert_eq!(effects.len(), 2 * 3);
    }

    /// A study with a gain of two doses, a motor and a side, without the modes of these ids.
    fn dosed(lacks: &[&str]) -> Study {
        let text = text();
        let (before, rest) = text.split_once("[[modes]]").unwrap();
        let (_, questions) = rest.split_once("[[questions]]").unwrap();
        let mut modes = String::new();
        for (dose, motor, side) in
            [1, 2].iter().flat_map(|dose| PAIRS.map(|(motor, side)| (dose, motor, side)))
        {
            let id = format!("{motor}{dose}{side}");
            if !lacks.contains(&id.as_str()) {
                modes += &format!(
                    "[[modes]]\nid = \"{id}\"\nlabel = \"{id}\"\n\
                     factors = {{ gain = {dose}, motor = \"{motor}\", side = \"{side}\" }}\n"
                );
            }
        }
        let factors = "[[factors]]\nid = \"gain\"\nlevels = [1, 2]\nunit = \"1\"\n\
                       [[factors]]\nid = \"motor\"\nlevels = [\"no\", \"yes\"]\n\
                       [[factors]]\nid = \"side\"\nlevels = [\"l\", \"r\"]\n";
        let compare = "[compare]\neffects = [\"gain\", \"gain:motor\"]\n";
        Study::from_toml(&format!("{before}{modes}{factors}[[questions]]{questions}\n{compare}"))
            .unwrap()
    }

    const PAIRS: [(&str, &str); 4] = [("no", "l"), ("no", "r"), ("yes", "l"), ("yes", "r")];

    #[test]
    fn curves_over_a_dose_are_of_the_conditions_of_its_effect_and_of_its_interaction() {
        type Weighed = Vec<Vec<(String, f64)>>;
        let of = |lacks: &[&str]| -> Vec<(Option<String>, Weighed)> {
            let study = dosed(lacks);
            let here = study.dose_curves().into_iter();
            let here =
                here.filter(|curve| curve.environment.as_ref() == Some(&study.environments[0].id));
            let named = here.map(|curve| {
                let level = curve.within.map(|within| within.level.to_string());
                let own = |weights: &Vec<Weight>| {
                    weights.iter().map(|w| (w.mode.to_string(), w.weight)).collect()
                };
                (level, curve.over.levels.iter().map(own).collect())
            });
            named.collect()
        };
        let means = |levels: [&[&str]; 2]| -> Weighed {
            levels
                .map(|ids| {
                    ids.iter().map(|id| ((*id).to_owned(), 1.0 / ids.len() as f64)).collect()
                })
                .to_vec()
        };
        let within = |level: &str| Some(level.to_owned());
        let whole = [
            (
                None,
                means([&["no1l", "no1r", "yes1l", "yes1r"], &["no2l", "no2r", "yes2l", "yes2r"]]),
            ),
            (within("no"), means([&["no1l", "no1r"], &["no2l", "no2r"]])),
            (within("yes"), means([&["yes1l", "yes1r"], &["yes2l", "yes2r"]])),
        ];
        assert_eq!(of(&[]), whole);
        // Without one condition the interaction is within the other side, and so are both of its curves.
        let lacking = [
            (None, means([&["no1l", "no1r", "yes1l"], &["no2l", "no2r", "yes2l"]])),
            (within("no"), means([&["no1l"], &["no2l"]])),
            (within("yes"), means([&["yes1l"], &["yes2l"]])),
        ];
        assert_eq!(of(&["yes2r"]), lacking);
        assert_eq!(of(&["yes2r", "no1l"]).len(), 1, "no side has every dose with and without");
    }
}
