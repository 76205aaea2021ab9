//! Effects of factors: everybody's weighted sums over conditions, and their analysis of variance.

use crate::cells::{Cell, Cells};
use crate::claim::Claim;
use crate::contrasts::size;
use crate::doses::turns_at;
use crate::measure::Measure;
use crate::split::{Refused, Split, inflations};
use crate::weighed::{averaged, levels_of, of_people, placed, weighed};
use crate::{CompareError, Parameters};
use std::collections::BTreeMap;
use zwidth_results::{
    EffectDifference, EffectLevels, FactorEffect, GroupEffect, PersonValue, UnitOfAnalysis,
};
use zwidth_stats::null::Sampling;
use zwidth_stats::over_doses::{Term, own_coefficient};
use zwidth_stats::over_trials::WeighedCondition;
use zwidth_stats::{Tested, Unestimable, effect, groups, paired, sign_flip};
use zwidth_study::{Effect, EffectSize, LevelContrast, counted};

/// Flips that are drawn where there are too many participants to count all.
const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// Weights whose size differs from 1 by less are those of a difference.
const SAME: f64 = 1e-9;

/// An effect.
pub(crate) struct Row<'a> {
    effect: &'a Effect,
    /// Everybody's, as what has a weight above 0 and what has one below, each added up.
    values: BTreeMap<usize, [f64; 2]>,
    /// How many of them lack a level of the dose, and have a line over the others.
    lack_a_level: usize,
    tested: Result<Tested, Unestimable>,
    jnd: Option<f64>,
    /// The effect that is too small to matter, in the metric's unit.
    bound: Option<f64>,
    /// How many times lines over trials make its variance larger, as [`inflations`] says.
    pub(crate) inflations: Vec<f64>,
    /// Why no claim is made.
    refused: Option<Refused>,
    /// Whether it is a difference between two values, of which a bound or what is felt speaks.
    pub(crate) is_difference: bool,
    pub(crate) claim: Claim,
}

impl Row<'_> {
    /// Its name in tables.
    pub(crate) fn name(&self) -> FactorEffect {
        let Effect { term, levels, .. } = self.effect;
        let levels = (!levels.is_empty()).then(|| EffectLevels(levels.clone()));
        FactorEffect { term: term.clone(), levels }
    }

    /// Why nobody has such an effect.
    fn nobody(&self, cells: &Cells) -> String {
        let mut sessions = self.effect.weights.iter().filter_map(|weight| weight.session.as_ref());
        match sessions.find(|id| !cells.sessions.contains(id)) {
            Some(id) => format!("nobody has the session {id}"),
            None => "nobody has all conditions that it weighs".to_owned(),
        }
    }

    /// Everybody's effect, by the place of the participant.
    pub(crate) fn of_everybody(&self) -> BTreeMap<usize, f64> {
        let sides: Vec<[f64; 2]> = self.values.values().copied().collect();
        self.values.keys().copied().zip(paired::differences(&sides)).collect()
    }

    /// The mean over people of what is subtracted; none without people.
    pub(crate) fn against(&self) -> Option<f64> {
        let sum: f64 = self.values.values().map(|sides| sides[1]).sum();
        let size: f64 = self.effect.weights.iter().map(|weight| weight.weight.abs() / 2.0).sum();
        (!self.values.is_empty()).then(|| sum / self.values.len() as f64 / size)
    }

    /// Whether it is known from which difference on it is felt.
    pub(crate) fn has_jnd(&self) -> bool {
        self.jnd.is_some()
    }
}

/// The effects, tested, without a verdict.
pub(crate) fn rows<'a>(
    cells: &Cells,
    split: Option<&Split>,
    measure: &Measure,
    parameters: &'a Parameters,
) -> Result<Vec<Row<'a>>, CompareError> {
    let [apart, together] = [false, true].map(|are_levels| of_people(cells, are_levels));
    let mut rows = Vec::new();
    for effect in parameters.effects.iter().filter(|effect| effect.is_claimed) {
        let Some(weights) = placed(&effect.weights, cells, parameters) else { continue };
        let people = if effect.is_by_session() { &together } else { &apart };
        // Where nobody has any of its conditions the environment has no such metric.
        let is_weighed = |cell: &Cell| {
            let place = [cell.environment, cell.mode];
            cell.mean.is_some() && weights.iter().any(|((_, own), _)| *own == place)
        };
        if !weights.is_empty() && !cells.cells.iter().any(is_weighed) {
            continue;
        }
        let levels = effect.over.as_ref().map(|over| levels_of(over, cells, parameters));
        let levels = levels.unwrap_or_default();
        let values = averaged(people, |own| {
            let (terms, lacks) = match &effect.over {
                Some(over) => {
                    let means: Vec<Option<f64>> =
                        levels.iter().map(|level| weighed(level, own)).collect();
                    let is_bend = effect.levels.iter().any(LevelContrast::is_bend);
                    let found = own_coefficient(over, if is_bend { 2 } else { 1 }, &means)?;
                    (found.terms, found.lacks_levels)
                }
                None => {
                    let each = weights
                        .iter()
                        .map(|(at, weight)| Some(Term { weight: *weight, mean: *own.get(at)? }));
                    (each.collect::<Option<_>>()?, false)
                }
            };
            let mut sides = vec![0.0, 0.0, f64::from(u8::from(lacks))];
            for Term { weight, mean } in &terms {
                sides[usize::from(*weight < 0.0)] += weight.abs() * mean;
            }
            (!weights.is_empty()).then_some(sides)
        });
        let mut values: BTreeMap<usize, [f64; 3]> =
            values.into_iter().map(|(who, sides)| (who, [sides[0], sides[1], sides[2]])).collect();
        // Of groups nobody speaks who has none.
        values.retain(|who, _| split.is_none_or(|split| split.level(*who).is_some()));
        let lack_a_level = values.values().filter(|sides| sides[2] > 0.0).count();
        let values: BTreeMap<usize, [f64; 2]> =
            values.into_iter().map(|(who, [above, below, _])| (who, [above, below])).collect();
        let sides: Vec<[f64; 2]> = values.values().copied().collect();
        let differences = paired::differences(&sides);
        let (tested, refused) = match split {
            None => (paired::mean_difference(&differences, parameters.level), None),
            Some(split) => {
                let each = values.keys().copied().zip(differences.iter().copied());
                let levels = split.by_level(each).into_iter().filter(|level| !level.is_empty());
                let levels: Vec<_> = levels.map(|level| groups::group(&level)).collect();
                let smallest = split.smallest(values.keys().copied());
                let refused = smallest.and_then(|(n, id)| Refused::too_few(n, &id));
                (groups::mean(&levels, parameters.level), refused)
            }
        };
        let conditions = weights.iter().map(|((session, [environment, mode]), weight)| {
            let (session, environment, mode) = (*session, *environment, *mode);
            WeighedCondition { session, environment, mode, weight: *weight }
        });
        let conditions: Vec<_> = conditions.collect();
        let inflations = inflations(cells, split, values.keys().copied(), &conditions);
        let refused = refused.or_else(|| Refused::ordered(inflations.iter().copied()));
        let environment = effect
            .environment
            .as_ref()
            .and_then(|id| parameters.environments.iter().position(|own| own == id));
        // A trend is over a step of the dose, and weights can be of any size: neither is a difference between two
        // values, which a bound or what is felt speaks of.
        let size: f64 = weights.iter().map(|(_, weight)| weight.abs() / 2.0).sum();
        let is_difference = match effect.levels.as_slice() {
            [] => (size - 1.0).abs() < SAME,
            levels => levels.iter().all(|level| matches!(level, LevelContrast::Pair(_))),
        };
        let bound = measure.parameters.bound(environment).filter(|_| is_difference);
        let has_p = refused.as_ref().is_none_or(Refused::has_p);
        let equivalence = tested.as_ref().ok().zip(bound.filter(|_| has_p));
        let equivalence = equivalence
            .map(|(tested, bound)| paired::equivalence(tested, bound, parameters.alpha))
            .transpose()?;
        let p = tested.as_ref().ok().filter(|_| refused.is_none()).map(|tested| tested.p_value);
        let mut row = Row {
            effect,
            jnd: None,
            bound,
            values,
            lack_a_level,
            tested,
            inflations,
            refused,
            is_difference,
            claim: Claim::new(
                // Those over several environments come together after those of each.
                environment.unwrap_or(parameters.environments.len()),
                p,
                None,
                equivalence.map(|e| e.p_value()),
            ),
        };
        let noticed = measure.parameters.noticed.as_ref().filter(|_| is_difference);
        row.jnd = noticed
            .zip(row.against())
            .and_then(|(noticed, against)| noticed.jnd(environment, against, &measure.unit));
        rows.push(row);
    }
    Ok(rows)
}

/// Everybody's effects.
pub(crate) fn values(rows: &[Row], cells: &Cells, measure: &Measure) -> Vec<PersonValue> {
    let mut all = Vec::new();
    for row in rows {
        all.extend(row.of_everybody().into_iter().map(|(who, value)| PersonValue {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: row.effect.environment.clone(),
            effect: GroupEffect::OfFactors(row.name()),
            participant: cells.participants[who].clone(),
            value,
        }));
    }
    all
}

/// The effects by the names of what they compare.
pub(crate) fn named(
    rows: &[Row],
    cells: &Cells,
    unit: &UnitOfAnalysis,
    split: Option<&Split>,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<EffectDifference> {
    // As of contrasts: of people of one group.
    let is_sized = split.is_none() && *unit == UnitOfAnalysis::Participants;
    let has = |size| is_sized && parameters.effect_sizes.contains(&size);
    let named = rows.iter().map(|row| {
        let Row { effect: Effect { term, levels, lacks, .. }, claim, .. } = row;
        let tested = row.tested.as_ref().ok();
        let with_p = tested.filter(|_| row.refused.as_ref().is_none_or(Refused::has_p));
        let sides: Vec<[f64; 2]> = row.values.values().copied().collect();
        let differences = paired::differences(&sides);
        let mean = differences.iter().sum::<f64>() / differences.len() as f64;
        let difference = tested.map(|t| t.estimate).or((!sides.is_empty()).then_some(mean));
        // Both sides are means of people where two levels of one factor are compared; else they are sums.
        let are_means = matches!(levels[..], [LevelContrast::Pair(_)]);
        let av = effect::d_av(&sides, parameters.level).ok().filter(|_| are_means);
        let z = effect::d_z(&sides, parameters.level).ok();
        let ends = tested.zip(row.jnd).map(|(t, jnd)| [t.ci_low / jnd, t.ci_high / jnd]);
        let why = match (&row.refused, &row.tested) {
            (Some(refused), _) => Some(refused.to_string()),
            _ if row.effect.weights.is_empty() => None,
            _ if sides.is_empty() => Some(row.nobody(cells)),
            (None, Err(why)) => Some(why.to_string()),
            (None, Ok(_)) => None,
        };
        let lacking = (row.lack_a_level > 0).then(|| {
            format!(
                "{} without every level: their line is over those that they have",
                counted(row.lack_a_level, "participants")
            )
        });
        let remarks: Vec<String> = lacks.iter().cloned().chain(lacking).chain(why).collect();
        EffectDifference {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: row.effect.environment.clone(),
            effect: term.clone(),
            levels: row.name().levels,
            n: sides.len(),
            difference,
            difference_std_error: tested.map(|t| t.std_error),
            difference_ci_low: tested.map(|t| t.ci_low),
            difference_ci_high: tested.map(|t| t.ci_high),
            statistic: with_p.map(|t| t.statistic),
            df: tested.map(|t| t.df),
            p_value: with_p.map(|t| t.p_value),
            p_adjusted: claim.p_adjusted,
            g_av: av.as_ref().and_then(|e| e.g).filter(|_| has(EffectSize::GAv)),
            d_av: av.as_ref().map(|e| e.d).filter(|_| has(EffectSize::DAv)),
            g_z: z.as_ref().and_then(|e| e.g).filter(|_| has(EffectSize::GZ)),
            d_z: z.as_ref().map(|e| e.d).filter(|_| has(EffectSize::DZ)),
            p_sign_flip: sign_flip::test(&differences, SAMPLING)
                .ok()
                .filter(|_| is_sized)
                .map(|test| test.p_value),
            jnd: row.jnd,
            difference_jnd: difference.zip(row.jnd).map(|(difference, jnd)| difference / jnd),
            difference_jnd_ci_low: ends.map(|ends| ends[0]),
            difference_jnd_ci_high: ends.map(|ends| ends[1]),
            size: ends.map(size),
            bound: row.bound,
            p_not_equivalent: claim.p_not_equivalent,
            dose_unit: row.effect.over.as_ref().map(|over| over.unit.clone()),
            turns_at: tested
                .filter(|t| t.ci_low > 0.0 || t.ci_high < 0.0)
                .filter(|_| split.is_none() && levels.iter().any(LevelContrast::is_bend))
                .and_then(|_| turns_at(row.effect, sides.len(), cells, parameters)),
            verdict: claim.verdict,
            remark: (!remarks.is_empty()).then(|| remarks.join("; ").into()),
        }
    });
    named.collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::tests::{measured, parameters};
    use crate::{Groups, compare};
    use zwidth_results::{GroupEffect, GroupMember, TrialKey, Verdict};
    use zwidth_study::{GroupsCompared, OverTrials, Source, Term, Weight};

    /// A number between −½ and ½: (h³ mod 9941)/9941 − ½.
    pub(crate) fn u(of: [u64; 4]) -> f64 {
        let h = 1 + 131 * of[0] + 173 * of[1] + 197 * of[2] + 211 * of[3];
        (h * h * h % 9941) as f64 / 9941.0 - 0.5
    }

    const MODES: [(&str, u64, u64); 4] =
        [("none", 0, 0), ("brake", 0, 1), ("motor", 1, 0), ("both", 1, 1)];

    /// Eight people in two environments × motor × brake, three repeats, to three decimals, in an order drawn
    /// by formula along which they learn.
    fn eight() -> (Vec<TrialKey>, Vec<Option<f64>>) {
        let (mut keys, mut values) = (Vec::new(), Vec::new());
        for person in 1..=8_u64 {
            for (e, environment) in [(0_u64, "spring"), (1, "wall")] {
                let mut order: Vec<(u64, f64, usize)> = Vec::new();
                for repeat in 1..=3_u64 {
                    for (m, (_, a, b)) in MODES.iter().enumerate() {
                        order.push((repeat, u([person, 40 + 4 * e + 2 * a + b, repeat, 0]), m));
                    }
                }
                order.sort_by(|x, y| x.0.cmp(&y.0).then(x.1.total_cmp(&y.1)));
                for (place, (repeat, _, m)) in (1..).zip(order) {
                    let (mode, a, b) = MODES[m];
                    let trial = 12 * e + place;
                    let [fa, fb, fe] = [a, b, e].map(|x| x as f64);
                    let y = 1.0 + 0.4 * fa + 0.2 * fb + 0.25 * fa * fb + 0.3 * fe
                        - 0.2 * fa * fb * fe
                        + 0.7 * u([person, 0, 0, 0])
                        + 0.4 * fa * u([person, 1 + a, 9, 0])
                        + 0.4 * fb * u([person, 3 + b, 9, 0])
                        + 0.3 * u([person, 5 + 2 * a + b, e + 1, 0])
                        - 0.02 * trial as f64
                        + 0.3 * u([person, 9 + 2 * a + b + 4 * e, repeat, 0]);
                    keys.push(TrialKey {
                        participant: format!("P{person:02}").parse().unwrap(),
                        session: "S01".parse().unwrap(),
                        trial: trial as u32,
                        repeat: repeat as u32,
                        environment: environment.parse().unwrap(),
                        mode: mode.parse().unwrap(),
                        source: Source::Recorded,
                    });
                    values.push(Some((y * 1000.0).round() / 1000.0));
                }
            }
        }
        (keys, values)
    }

    fn effect(term: &str, environment: Option<&str>, weights: &[(&str, &str, f64)]) -> Effect {
        let term: Term = term.parse().unwrap();
        let pair: LevelContrast = "yes − no".parse().unwrap();
        let levels = if environment.is_some() {
            term.0.iter().map(|_| pair.clone()).collect()
        } else {
            Vec::new()
        };
        Effect {
            term,
            levels,
            environment: environment.map(|id| id.parse().unwrap()),
            weights: weights
                .iter()
                .map(|(environment, mode, weight)| Weight {
                    session: None,
                    environment: environment.parse().unwrap(),
                    mode: mode.parse().unwrap(),
                    weight: *weight,
                })
                .collect(),
            over: None,
            is_claimed: true,
            lacks: None,
        }
    }

    fn of_eight() -> Parameters {
        let mut effects = Vec::new();
        for e in ["spring", "wall"] {
            let of = |term: &str, weights: [f64; 4]| {
                let weights: Vec<_> =
                    MODES.iter().zip(weights).map(|((mode, ..), w)| (e, *mode, w)).collect();
                effect(term, Some(e), &weights)
            };
            effects.push(of("motor", [-0.5, -0.5, 0.5, 0.5]));
            effects.push(of("brake", [-0.5, 0.5, -0.5, 0.5]));
            effects.push(of("motor:brake", [1.0, -1.0, -1.0, 1.0]));
        }
        let mut parameters = parameters();
        parameters.metrics[0].bounds = vec![None, None];
        parameters.environments = ["spring", "wall"].map(|id| id.parse().unwrap()).to_vec();
        parameters.modes = MODES.map(|(id, ..)| id.parse().unwrap()).to_vec();
        parameters.contrasts = Vec::new();
        parameters.effects = effects;
        parameters
    }

    /// R's `aov(y ~ … + Error(id/…))` per environment and SciPy's one-sample t of everybody's effects agree on
    /// these: effect, standard error, t, p, interval; 7 degrees of freedom. Then after Holm.
    const FOUND: [([f64; 6], f64); 6] = [
        (
            [0.449375, 0.0484558049, 9.27391467, 3.50853872e-5, 0.334795229, 0.563954771],
            2.105123232e-4,
        ),
        (
            [0.324458333, 0.0534009314, 6.07589278, 5.02904728e-4, 0.198185196, 0.450731471],
            0.00251452364,
        ),
        (
            [0.118916667, 0.0541652655, 2.1954414, 0.0641613136, -0.00916383385, 0.246997167],
            0.1283226272,
        ),
        (
            [0.367333333, 0.061609763, 5.9622585, 5.63103835e-4, 0.221649394, 0.513017273],
            0.00251452364,
        ),
        (
            [0.1965, 0.0518914178, 3.78675334, 0.00683177888, 0.0737962949, 0.319203705],
            0.02049533664,
        ),
        (
            [0.0168333333, 0.100066565, 0.168221357, 0.871166399, -0.219786493, 0.25345316],
            0.871166399,
        ),
    ];

    pub(crate) fn near(found: Option<f64>, expect: f64) {
        let found = found.unwrap();
        assert!((found - expect).abs() < 2e-6 * expect.abs().max(1e-3), "{found} for {expect}");
    }

    #[test]
    fn effects_and_their_analysis_of_variance_are_rs_and_scipys() {
        let (keys, values) = eight();
        let found = compare(&measured(&keys, values.into_iter()), &of_eight()).unwrap();
        assert_eq!(found.effects.len(), 6);
        for (row, (numbers, adjusted)) in found.effects.iter().zip(FOUND) {
            let shown = [
                row.difference,
                row.difference_std_error,
                row.statistic,
                row.p_value,
                row.difference_ci_low,
                row.difference_ci_high,
            ];
            shown.into_iter().zip(numbers).for_each(|(found, expect)| near(found, expect));
            near(row.p_adjusted, adjusted);
            assert_eq!((row.n, row.df), (8, Some(7.0)));
            let line = found
                .factor_tests
                .iter()
                .find(|l| (&l.environment, &l.effect) == (&row.environment, &row.effect));
            let line = line.unwrap();
            near(Some(line.f), numbers[2] * numbers[2]);
            near(Some(line.p_gg), numbers[3]);
            assert_eq!((line.n, line.df_effect, line.df_error), (8, 1.0, 7.0));
        }
        // Of an interaction both sides are sums, which no spread within conditions stands for.
        assert!(found.effects[0].g_av.is_some() && found.effects[2].g_av.is_none());
    }

    /// NumPy: everybody's own line in each environment, least squares besides the means of the modes.
    #[test]
    fn effects_along_everybodys_own_line_over_trials_are_numpys() {
        let (keys, values) = eight();
        let parameters = Parameters { over: Some(OverTrials::Trial), ..of_eight() };
        let found = compare(&measured(&keys, values.into_iter()), &parameters).unwrap();
        let crossed = &found.effects[2];
        near(crossed.difference, 0.14443999);
        near(crossed.difference_std_error, 0.0546080023);
        near(crossed.statistic, 2.6450334);
        near(crossed.p_value, 0.0331800679);
        near(crossed.difference_ci_low, 0.0153125832);
        near(crossed.difference_ci_high, 0.273567396);
        let motor = &found.effects[3];
        near(motor.difference, 0.369108272);
        near(motor.difference_std_error, 0.0576589951);
        near(motor.p_value, 3.66732648e-4);
        let [spring, wall] = &found.over_trials[..] else { panic!("{:?}", found.over_trials) };
        near(Some(spring.change_each), -0.0219326312);
        near(spring.change_each_std_error, 0.00377492312);
        near(spring.p_value, 6.56743528e-4);
        near(spring.change_each_ci_low, -0.0308589059);
        near(spring.change_each_ci_high, -0.0130063564);
        assert_eq!((wall.n, wall.over), (8, OverTrials::Trial));
        // Learning is of the values as they are.
        let as_they_are = compare(&measured(&keys, eight().1.into_iter()), &of_eight()).unwrap();
        assert_eq!(found.learning, as_they_are.learning);
        assert!(as_they_are.over_trials.is_empty());
    }

    /// How much more the motor does at the wall than on the spring.
    fn wall_costs() -> Effect {
        let of_motor = |e: &'static str, sign: f64| {
            [("motor", 0.5), ("both", 0.5), ("none", -0.5), ("brake", -0.5)]
                .map(|(mode, weight)| (e, mode, sign * weight))
        };
        let weights = [of_motor("wall", 1.0), of_motor("spring", -1.0)].concat();
        effect("wall_costs", None, &weights)
    }

    /// The first people in the first group, the next ones in the next.
    fn groups(sizes: &[usize]) -> Groups {
        let levels: Vec<_> =
            ["few", "many", "most"][..sizes.len()].iter().map(|id| id.parse().unwrap()).collect();
        let compared = GroupsCompared {
            column: "group".parse().unwrap(),
            contrasts: vec!["many − few".parse().unwrap()],
            levels,
            assigned: false,
        };
        let of = sizes.iter().enumerate().flat_map(|(level, size)| vec![level; *size]);
        let levels_of =
            (1..).zip(of).map(|(who, level)| (format!("P{who:02}").parse().unwrap(), level));
        Groups { compared, levels_of: levels_of.collect(), blocks: BTreeMap::new() }
    }

    #[test]
    fn a_weighted_contrast_over_environments_is_the_difference_of_their_effects() {
        let (keys, values) = eight();
        let mut parameters = of_eight();
        parameters.effects = vec![wall_costs()];
        let found = compare(&measured(&keys, values.into_iter()), &parameters).unwrap();
        let [row] = &found.effects[..] else { panic!("{:?}", found.effects) };
        near(row.difference, -0.0820416667);
        near(row.difference_std_error, 0.0682969179);
        near(row.p_value, 0.268716871);
        assert_eq!((row.verdict, row.levels.as_ref()), (Verdict::Undecided, None));
        assert!(found.factor_tests.is_empty());
    }

    /// SciPy's Welch test of everybody's effects of the motor.
    #[test]
    fn groups_differ_in_an_effect_by_welchs_t_and_it_has_the_same_weight_for_each() {
        let (keys, values) = eight();
        let mut parameters = of_eight();
        parameters.groups = Some(groups(&[4, 4]));
        let found = compare(&measured(&keys, values.into_iter()), &parameters).unwrap();
        let of_motor: GroupEffect = "motor: yes − no".parse().unwrap();
        let row = found.groups.iter().find(|row| row.effect == of_motor).unwrap();
        near(row.difference, 0.0230833333);
        near(row.statistic, 0.221419796);
        near(row.df, 5.52181562);
        near(row.p_value, 0.832724144);
        assert_eq!((row.n_first, row.n_second, row.verdict), (4, 4, Some(Verdict::Undecided)));
        // As many in each group: the same mean, over which Satterthwaite's degrees of freedom are fewer.
        let effect = &found.effects[0];
        near(effect.difference, 0.449375);
        assert!(effect.df < Some(7.0) && effect.g_av.is_none(), "{effect:?}");
    }

    /// Means and standard errors of everybody's effects are those that R and SciPy confirm above; with groups those of
    /// either group are the means compared.
    #[test]
    fn everybodys_values_are_those_that_effects_and_groups_are_tested_by() {
        let (keys, values) = eight();
        let mut parameters = of_eight();
        parameters.effects.push(wall_costs());
        let found = compare(&measured(&keys, values.iter().copied()), &parameters).unwrap();
        assert_eq!(found.person_values.len(), 8 * found.effects.len());
        for row in &found.effects {
            let effect = GroupEffect::OfFactors(row.name());
            let is_own =
                |own: &&PersonValue| own.environment == row.environment && own.effect == effect;
            let own: Vec<f64> =
                found.person_values.iter().filter(is_own).map(|own| own.value).collect();
            let mean = own.iter().sum::<f64>() / 8.0;
            let squares = own.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
            near(row.difference, mean);
            near(row.difference_std_error, (squares / 7.0 / 8.0).sqrt());
        }

        // The last has no group.
        parameters.groups = Some(groups(&[3, 4]));
        let found = compare(&measured(&keys, values.into_iter()), &parameters).unwrap();
        let claimed = found.groups.iter().filter(|row| row.verdict.is_some());
        assert_eq!(found.person_values.len(), 7 * claimed.clone().count());
        for row in claimed {
            let mean = |group: &str| {
                let own = found.person_values.iter().filter(|own| {
                    let member = |row: &&GroupMember| row.participant == own.participant;
                    let group_of = found.group_members.iter().find(member).unwrap();
                    let is_row = own.environment == row.environment && own.effect == row.effect;
                    is_row && group_of.group.as_str() == group
                });
                let own: Vec<f64> = own.map(|own| own.value).collect();
                own.iter().sum::<f64>() / own.len() as f64
            };
            near(row.mean_first, mean("many"));
            near(row.mean_second, mean("few"));
        }
    }

    /// SciPy's Welch test of everybody's weighted sums over both environments, and Welch's F of three
    /// groups by his formula in NumPy.
    #[test]
    fn groups_differ_in_a_contrast_over_environments_by_welchs_t() {
        let (keys, values) = eight();
        let mut parameters = of_eight();
        parameters.effects.push(wall_costs());
        parameters.groups = Some(groups(&[4, 4]));
        let found = compare(&measured(&keys, values.iter().copied()), &parameters).unwrap();
        let over_both: Vec<_> =
            found.groups.iter().filter(|row| row.environment.is_none()).collect();
        let [row] = over_both[..] else { panic!("{over_both:?}") };
        assert_eq!(row.effect.to_string(), "contrast wall_costs");
        near(row.difference, -0.148166667);
        near(row.statistic, -1.10105175);
        near(row.df, 5.70499556);
        near(row.p_value, 0.315146836);
        near(row.difference_ci_low, -0.4816151746801661);
        near(row.difference_ci_high, 0.18528184134683293);
        assert_eq!((row.n_first, row.n_second, row.verdict), (4, 4, Some(Verdict::Undecided)));
        assert_eq!(found.groups.last(), Some(row), "after those of each environment");
        // In each of two environments groups differ in the mean over modes and in three effects, which are claims
        // themselves; those over both make one family of their own where environments are families.
        parameters.families = zwidth_study::Families::Environment;
        let apart = compare(&measured(&keys, values.iter().copied()), &parameters).unwrap();
        let own = [apart.groups.last().unwrap().p_value, apart.effects.last().unwrap().p_value];
        let [groups_p, effect_p] = own.map(Option::unwrap);
        let least = groups_p.min(effect_p);
        near(apart.groups.last().unwrap().p_adjusted, (2.0 * least).max(groups_p));

        parameters.groups = Some(groups(&[3, 2, 3]));
        let found = compare(&measured(&keys, values.into_iter()), &parameters).unwrap();
        let any = found.any_group.iter().find(|row| row.environment.is_none()).unwrap();
        near(any.f, 6.13098788);
        near(any.df_error, 2.0861104);
        near(any.p_value, 0.133809346);
    }

    /// In a second session, which P08 lacks, everybody has a tenth of their number more, and half as much again
    /// with the motor.
    #[test]
    fn sessions_that_are_levels_are_compared_within_everybody() {
        let (mut keys, mut values) = eight();
        for k in 0..keys.len() {
            let mut key = keys[k].clone();
            let person: f64 = key.participant.as_str()[1..].parse().unwrap();
            if person > 7.0 {
                continue;
            }
            let motor = if ["motor", "both"].contains(&key.mode.as_str()) { 1.5 } else { 1.0 };
            key.session = "S02".parse().unwrap();
            keys.push(key);
            values.push(values[k].map(|value| value + 0.1 * person * motor));
        }
        let mut parameters = of_eight();
        let of_session = |term: &str, sign: [f64; 2]| {
            let mut all = effect(term, Some("spring"), &[]);
            for (session, by) in [("S02", 1.0), ("S01", -1.0)] {
                for ((mode, motor, _), weight) in MODES.iter().zip([0.25; 4]) {
                    all.weights.push(Weight {
                        session: Some(session.parse().unwrap()),
                        environment: "spring".parse().unwrap(),
                        mode: mode.parse().unwrap(),
                        weight: by * weight * sign[usize::from(*motor > 0)],
                    });
                }
            }
            all
        };
        parameters.effects =
            vec![of_session("time", [1.0, 1.0]), of_session("motor:time", [-2.0, 2.0])];
        let found = compare(&measured(&keys, values.into_iter()), &parameters).unwrap();
        let [time, crossed] = &found.effects[..] else { panic!("{:?}", found.effects) };
        // Over P01 to P07: 1.25 · 0.1 · 4, and 0.5 · 0.1 · 4.
        near(time.difference, 0.5);
        near(crossed.difference, 0.2);
        assert_eq!((time.n, crossed.n), (7, 7));
        // Everybody's are multiples of their number: t = 4 √7 / 2.160246899.
        near(time.statistic, 4.898979486);
        near(Some(found.factor_tests[0].f), 24.0);
    }

    #[test]
    fn what_cannot_be_estimated_is_a_row_with_its_reason() {
        let (keys, values) = eight();
        let mut parameters = of_eight();
        parameters.effects.truncate(2);
        parameters.effects[0].weights.clear();
        parameters.effects[0].lacks =
            Some("cannot be estimated: no condition has a = no".to_owned());
        // Nobody has the mode that is left out of the trials.
        let (keys, values): (Vec<_>, Vec<_>) =
            keys.into_iter().zip(values).filter(|(key, _)| key.mode.as_str() != "none").unzip();
        let found = compare(&measured(&keys, values.into_iter()), &parameters).unwrap();
        let remarks: Vec<String> =
            found.effects.iter().map(|row| row.remark.as_ref().unwrap().to_string()).collect();
        assert_eq!(remarks[0], "cannot be estimated: no condition has a = no");
        assert_eq!(remarks[1], "nobody has all conditions that it weighs");
        assert!(found.effects.iter().all(|row| row.verdict == Verdict::NotTested && row.n == 0));
    }
}
