//! Effects of factors: everybody's weighted sums over conditions, and their analysis of variance.

use crate::cells::Cells;
use crate::claim::Claim;
use crate::contrasts::size;
use crate::measure::Measure;
use crate::split::{Split, TooFew};
use crate::{CompareError, Parameters};
use std::collections::BTreeMap;
use zwidth_results::{EffectDifference, EffectLevels, FactorTest, UnitOfAnalysis};
use zwidth_stats::null::Sampling;
use zwidth_stats::{Tested, Unestimable, effect, groups, paired, rm_anova, sign_flip};
use zwidth_study::{Effect, EffectSize};

/// Flips that are drawn where there are too many participants to count all.
const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// An effect.
pub(crate) struct Row<'a> {
    effect: &'a Effect,
    /// Everybody's, as what has a weight above 0 and what has one below, each added up.
    values: BTreeMap<usize, [f64; 2]>,
    tested: Result<Tested, Unestimable>,
    jnd: Option<f64>,
    /// The effect that is too small to matter, in the metric's unit.
    bound: Option<f64>,
    /// Why no claim is made of groups that are too small.
    refused: Option<TooFew>,
    pub(crate) claim: Claim,
}

impl Row<'_> {
    /// Whether it is known from which difference on it is felt.
    pub(crate) fn has_jnd(&self) -> bool {
        self.jnd.is_some()
    }
}

/// A weight by the places of its environment and its mode.
type Placed = ([usize; 2], f64);

fn placed(effect: &Effect, parameters: &Parameters) -> Option<Vec<Placed>> {
    let places = effect.weights.iter().map(|weight| {
        Some((parameters.condition(&weight.environment, &weight.mode)?, weight.weight))
    });
    places.collect()
}

/// Everybody's values in conditions, session by session: by participant and session.
type Sessions = BTreeMap<[usize; 2], BTreeMap<[usize; 2], f64>>;

fn by_session(cells: &Cells) -> Sessions {
    let mut sessions = Sessions::new();
    for cell in &cells.cells {
        if let Some(mean) = cell.mean {
            let own = sessions.entry([cell.participant, cell.session]).or_default();
            own.insert([cell.environment, cell.mode], mean);
        }
    }
    sessions
}

/// Everybody's mean over those of their sessions that have all of what `of` needs, by participant.
fn of_people<const N: usize>(
    sessions: &Sessions,
    of: impl Fn(&BTreeMap<[usize; 2], f64>) -> Option<[f64; N]>,
) -> BTreeMap<usize, [f64; N]> {
    let mut people: BTreeMap<usize, Vec<[f64; N]>> = BTreeMap::new();
    for ([participant, _], values) in sessions {
        if let Some(value) = of(values) {
            people.entry(*participant).or_default().push(value);
        }
    }
    let mean = |sessions: Vec<[f64; N]>| {
        std::array::from_fn(|k| {
            sessions.iter().map(|values| values[k]).sum::<f64>() / sessions.len() as f64
        })
    };
    people.into_iter().map(|(who, sessions)| (who, mean(sessions))).collect()
}

/// The effects, tested, without a verdict.
pub(crate) fn rows<'a>(
    cells: &Cells,
    split: Option<&Split>,
    measure: &Measure,
    parameters: &'a Parameters,
) -> Result<Vec<Row<'a>>, CompareError> {
    let sessions = by_session(cells);
    let mut rows = Vec::new();
    for effect in &parameters.effects {
        let Some(weights) = placed(effect, parameters) else { continue };
        // Where nobody has any of its conditions the environment has no such metric.
        let is_there =
            |(condition, _): &Placed| sessions.values().any(|s| s.contains_key(condition));
        if !weights.is_empty() && !weights.iter().any(is_there) {
            continue;
        }
        let mut values = of_people(&sessions, |own| {
            let mut sides = [0.0, 0.0];
            for (condition, weight) in &weights {
                let side = usize::from(*weight < 0.0);
                sides[side] += weight.abs() * own.get(condition)?;
            }
            (!weights.is_empty()).then_some(sides)
        });
        // Of groups nobody speaks who has none.
        values.retain(|who, _| split.is_none_or(|split| split.level(*who).is_some()));
        let sides: Vec<[f64; 2]> = values.values().copied().collect();
        let differences = paired::differences(&sides);
        let (tested, refused) = match split {
            None => (paired::mean_difference(&differences, parameters.level), None),
            Some(split) => {
                let each = values.keys().copied().zip(differences.iter().copied());
                let levels = split.by_level(each).into_iter().filter(|level| !level.is_empty());
                let levels: Vec<_> = levels.map(|level| groups::group(&level)).collect();
                let smallest = split.smallest(values.keys().copied());
                let refused = smallest.and_then(|(n, id)| TooFew::of(n, &id));
                (groups::mean(&levels, parameters.level), refused)
            }
        };
        let environment = effect
            .environment
            .as_ref()
            .and_then(|id| parameters.environments.iter().position(|own| own == id));
        // What is commanded, and what is too small to matter, can be another thing in each environment.
        let bounds = &measure.parameters.bounds;
        let bound = match environment {
            Some(place) => bounds[place],
            None => bounds[0].filter(|_| bounds.iter().all(|bound| *bound == bounds[0])),
        };
        let has_p = refused.as_ref().is_none_or(TooFew::has_p);
        let equivalence = tested.as_ref().ok().zip(bound.filter(|_| has_p));
        let equivalence = equivalence
            .map(|(tested, bound)| paired::equivalence(tested, bound, parameters.alpha))
            .transpose()?;
        let p = tested.as_ref().ok().filter(|_| refused.is_none()).map(|tested| tested.p_value);
        let noticed = measure.parameters.noticed.as_ref().filter(|noticed| {
            !sides.is_empty()
                && (environment.is_some() || noticed.commanded.iter().all(Option::is_none))
        });
        let against = sides.iter().map(|sides| sides[1]).sum::<f64>() / sides.len() as f64;
        let size: f64 = weights.iter().map(|(_, weight)| weight.abs() / 2.0).sum();
        rows.push(Row {
            effect,
            jnd: noticed.and_then(|n| {
                n.jnd(environment.unwrap_or_default(), against / size, &measure.unit)
            }),
            bound,
            values,
            tested,
            refused,
            claim: Claim::new(
                // Those over several environments come together after those of each.
                environment.unwrap_or(parameters.environments.len()),
                p,
                None,
                equivalence.map(|e| e.p_value()),
            ),
        });
    }
    Ok(rows)
}

/// The effects by the names of what they compare.
pub(crate) fn named(
    rows: &[Row],
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
        let with_p = tested.filter(|_| row.refused.as_ref().is_none_or(TooFew::has_p));
        let sides: Vec<[f64; 2]> = row.values.values().copied().collect();
        let differences = paired::differences(&sides);
        let mean = differences.iter().sum::<f64>() / differences.len() as f64;
        let difference = tested.map(|t| t.estimate).or((!sides.is_empty()).then_some(mean));
        // Both sides are means of people where one factor is averaged; those of an interaction are sums.
        let av = effect::d_av(&sides, parameters.level).ok().filter(|_| levels.len() == 1);
        let z = effect::d_z(&sides, parameters.level).ok();
        let ends = tested.zip(row.jnd).map(|(t, jnd)| [t.ci_low / jnd, t.ci_high / jnd]);
        let why = match (&row.refused, &row.tested) {
            (Some(too_few), _) => Some(too_few.to_string()),
            _ if row.effect.weights.is_empty() => None,
            _ if sides.is_empty() => Some("nobody has all conditions that it weighs".to_owned()),
            (None, Err(why)) => Some(why.to_string()),
            (None, Ok(_)) => None,
        };
        let remarks: Vec<String> = lacks.iter().cloned().chain(why).collect();
        EffectDifference {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: row.effect.environment.clone(),
            effect: term.clone(),
            levels: (!levels.is_empty()).then(|| EffectLevels(levels.clone())),
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
            verdict: claim.verdict,
            remark: (!remarks.is_empty()).then(|| remarks.join("; ").into()),
        }
    });
    named.collect()
}

/// The analysis of variance: a line for each factor and interaction, over the participants who have every
/// condition of it, each the mean of their complete sessions.
pub(crate) fn tests(cells: &Cells, measure: &Measure, parameters: &Parameters) -> Vec<FactorTest> {
    let sessions = by_session(cells);
    let mut lines = Vec::new();
    let same = |a: &Effect, b: &Effect| (&a.term, &a.environment) == (&b.term, &b.environment);
    for effects in parameters.effects.chunk_by(same) {
        let first = &effects[0];
        let weights: Option<Vec<Vec<Placed>>> =
            effects.iter().map(|effect| placed(effect, parameters)).collect();
        let Some(weights) = weights.filter(|_| !first.levels.is_empty()) else { continue };
        let mut conditions: Vec<[usize; 2]> = weights.iter().flatten().map(|w| w.0).collect();
        conditions.sort_unstable();
        conditions.dedup();
        let contrasts: Vec<Vec<f64>> = weights
            .iter()
            .map(|weights| {
                let of = |condition: &[usize; 2]| weights.iter().find(|w| w.0 == *condition);
                conditions.iter().map(|condition| of(condition).map_or(0.0, |w| w.1)).collect()
            })
            .collect();
        let mut people: BTreeMap<usize, Vec<Vec<f64>>> = BTreeMap::new();
        for ([participant, _], own) in &sessions {
            let row: Option<Vec<f64>> =
                conditions.iter().map(|condition| own.get(condition).copied()).collect();
            people.entry(*participant).or_default().extend(row);
        }
        people.retain(|_, sessions| !sessions.is_empty());
        let mean = |sessions: &Vec<Vec<f64>>| -> Vec<f64> {
            let sum = |k: usize| sessions.iter().map(|session| session[k]).sum::<f64>();
            (0..conditions.len()).map(|k| sum(k) / sessions.len() as f64).collect()
        };
        let table: Vec<Vec<f64>> = people.values().map(mean).collect();
        let Ok(found) = rm_anova::effect(&table, &contrasts) else { continue };
        let explained = found.test.statistic * found.test.df_num;
        lines.push(FactorTest {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: first.environment.clone(),
            effect: first.term.clone(),
            n: table.len(),
            f: found.test.statistic,
            df_effect: found.test.df_num,
            df_error: found.test.df_den,
            p_f: found.test.p_value,
            epsilon_gg: found.greenhouse_geisser,
            p_gg: found.p_greenhouse_geisser,
            eta_squared_partial: explained / (explained + found.test.df_den),
        });
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare;
    use crate::tests::{measured, parameters};
    use zwidth_results::{TrialKey, Verdict};
    use zwidth_study::{Source, Term, Weight};

    /// A number between −½ and ½: (h³ mod 9941)/9941 − ½.
    fn u(of: [u64; 4]) -> f64 {
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
        let pair = ["yes", "no"].map(|level| level.parse().unwrap());
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
                    environment: environment.parse().unwrap(),
                    mode: mode.parse().unwrap(),
                    weight: *weight,
                })
                .collect(),
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

    /// R's `aov(y ~ … + Error(id/…))` per environment and SciPy's `ttest_1samp` of everybody's effects agree on
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

    fn near(found: Option<f64>, expect: f64) {
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

    #[test]
    fn a_weighted_contrast_over_environments_is_the_difference_of_their_effects() {
        let (keys, values) = eight();
        let mut parameters = of_eight();
        let of_motor = |e: &'static str, sign: f64| {
            [("motor", 0.5), ("both", 0.5), ("none", -0.5), ("brake", -0.5)]
                .map(|(mode, weight)| (e, mode, sign * weight))
        };
        let weights = [of_motor("wall", 1.0), of_motor("spring", -1.0)].concat();
        parameters.effects = vec![effect("wall_costs", None, &weights)];
        let found = compare(&measured(&keys, values.into_iter()), &parameters).unwrap();
        let [row] = &found.effects[..] else { panic!("{:?}", found.effects) };
        near(row.difference, -0.0820416667);
        near(row.difference_std_error, 0.0682969179);
        near(row.p_value, 0.268716871);
        assert_eq!((row.verdict, row.levels.as_ref()), (Verdict::Undecided, None));
        assert!(found.factor_tests.is_empty());
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
