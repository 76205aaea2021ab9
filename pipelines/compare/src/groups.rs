//! Groups of people compared: what differs between them, and within each between modes.

use crate::cells::Cells;
use crate::claim::Claim;
use crate::contrasts::{self, size};
use crate::measure::Measure;
use crate::split::{Refused, Split};
use crate::{CompareError, Parameters, effects};
use std::collections::{BTreeMap, BTreeSet};
use zwidth_results::{
    AnyGroup, GroupDifference, GroupEffect, GroupMean, GroupModeDifference, PersonValue,
};
use zwidth_stats::groups::{self, Permuted, group};
use zwidth_stats::null::Sampling;
use zwidth_stats::welch::Group;
use zwidth_stats::{Tested, Unestimable, effect, interval, paired};
use zwidth_study::{EffectSize, GroupContrast};

/// Arrangements of labels that are drawn where there are too many to count all.
const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// An effect of groups in one environment, or over several.
pub(crate) struct Row<'a> {
    effect: GroupEffect,
    groups: &'a GroupContrast,
    values: [Vec<f64>; 2],
    tested: Result<Tested, Unestimable>,
    permuted: Option<Permuted>,
    jnd: Option<f64>,
    /// The difference that is too small to matter.
    bound: Option<f64>,
    /// Why no claim is made, where one could be.
    refused: Option<Refused>,
    /// Whether it is claimed, or only described.
    is_claimed: bool,
    pub(crate) claim: Claim,
}

/// Everybody's value, by the place of the participant.
type Values = BTreeMap<usize, f64>;

/// What is compared between groups in an environment, or over several.
struct Compared<'a> {
    effect: GroupEffect,
    values: Values,
    /// Whether it is claimed: the mean over modes and the differences between modes are; of single modes the one
    /// that there is.
    is_claimed: bool,
    /// The value whose share is just noticed, where it is not that of the second group: of a difference
    /// between modes the mean in the second mode.
    noticed_from: Option<f64>,
    /// Whether it is a difference between two values, of which a bound or what is felt speaks.
    is_difference: bool,
    /// How many times lines over trials make its variance larger in each group, by the place of the level; empty where
    /// no order of modes matters.
    inflations: &'a [f64],
}

/// What is compared between groups in an environment, with everybody's values; after the last environment, the effects
/// over several.
fn compared<'a>(
    environment: usize,
    cells: &Cells,
    contrasts: &'a [contrasts::Row],
    of_factors: &'a [effects::Row],
    parameters: &Parameters,
) -> Vec<Compared<'a>> {
    let in_modes: Vec<(usize, Values)> = (0..parameters.modes.len())
        .map(|mode| (mode, cells.people_in(environment, mode).collect::<Values>()))
        .filter(|(_, values)| !values.is_empty())
        .collect();
    let mut effects = Vec::new();
    if let [(_, first), others @ ..] = in_modes.as_slice()
        && !others.is_empty()
    {
        let complete = first.iter().filter_map(|(who, value)| {
            let others = others.iter().map(|(_, values)| values.get(who).copied());
            let sum = value + others.collect::<Option<Vec<f64>>>()?.iter().sum::<f64>();
            Some((*who, sum / in_modes.len() as f64))
        });
        let (effect, values) = (GroupEffect::OverModes, complete.collect());
        effects.push(Compared {
            effect,
            values,
            is_claimed: true,
            noticed_from: None,
            is_difference: true,
            inflations: &[],
        });
    }
    for row in contrasts.iter().filter(|row| row.claim.environment == environment) {
        let values = row.differences.iter().map(|one| (one.participant, one.estimate)).collect();
        let effect = GroupEffect::Of(row.contrast.clone());
        let noticed_from = Some(row.mean(1));
        effects.push(Compared {
            effect,
            values,
            is_claimed: true,
            noticed_from,
            is_difference: true,
            inflations: &row.inflations,
        });
    }
    for row in of_factors.iter().filter(|row| row.claim.environment == environment) {
        let values = row.of_everybody();
        if !values.is_empty() {
            let (effect, noticed_from) = (GroupEffect::OfFactors(row.name()), row.against());
            let is_difference = row.is_difference;
            effects.push(Compared {
                effect,
                values,
                is_claimed: true,
                noticed_from,
                is_difference,
                inflations: &row.inflations,
            });
        }
    }
    let is_claimed = in_modes.len() == 1;
    for (mode, values) in in_modes {
        let effect = GroupEffect::In(parameters.modes[mode].clone());
        effects.push(Compared {
            effect,
            values,
            is_claimed,
            noticed_from: None,
            is_difference: true,
            inflations: &[],
        });
    }
    effects
}

/// The differences between groups, tested, without a verdict.
pub(crate) fn rows<'a>(
    split: &Split<'a>,
    cells: &Cells,
    contrasts: &[contrasts::Row],
    of_factors: &[effects::Row],
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Vec<Row<'a>>, CompareError> {
    let levels = &split.groups.compared.levels;
    let mut rows = Vec::new();
    for environment in 0..=parameters.environments.len() {
        let known = (environment < parameters.environments.len()).then_some(environment);
        for compared in compared(environment, cells, contrasts, of_factors, parameters) {
            let Compared { effect, values, is_claimed, noticed_from, is_difference, inflations } =
                compared;
            let values = values.into_iter().map(|(who, value)| (who, (value, split.block(who))));
            let by_level = split.by_level(values);
            for contrast in &split.groups.compared.contrasts {
                let places = [&contrast.group, &contrast.against]
                    .map(|id| levels.iter().position(|level| level == id));
                let of_both = places.map(|place| {
                    let people = place.map(|place| by_level[place].iter().copied());
                    people.into_iter().flatten().unzip::<f64, usize, Vec<_>, Vec<_>>()
                });
                let [(first, first_blocks), (second, second_blocks)] = of_both;
                let permuted = groups::permuted_within(
                    [&first, &second],
                    [&first_blocks, &second_blocks],
                    SAMPLING,
                );
                let [a, b] = [group(&first), group(&second)];
                let tested = groups::difference([a, b], parameters.level);
                let smallest = [(a.n, &contrast.group), (b.n, &contrast.against)].into_iter().min();
                let refused = smallest.and_then(|(n, id)| Refused::too_few(n, id.as_str()));
                // What a third group has in common is no matter of these two.
                let own = places.into_iter().flatten().filter_map(|place| inflations.get(place));
                let refused = refused.or_else(|| Refused::ordered(own.copied()));
                let has_p = refused.as_ref().is_none_or(Refused::has_p);
                let bound = measure.parameters.bound(known).filter(|_| is_difference);
                let equivalence = tested.as_ref().ok().zip(bound.filter(|_| has_p));
                let equivalence = equivalence
                    .map(|(t, bound)| paired::equivalence(t, bound, parameters.alpha))
                    .transpose()?;
                let p = tested.as_ref().ok().filter(|_| is_claimed && refused.is_none());
                let p_not_equivalent = equivalence.map(|e| e.p_value());
                let noticed = measure.parameters.noticed.as_ref();
                let noticed = noticed.filter(|_| b.n > 0 && is_difference);
                rows.push(Row {
                    effect: effect.clone(),
                    groups: contrast,
                    permuted: permuted.ok(),
                    jnd: noticed
                        .and_then(|n| n.jnd(known, noticed_from.unwrap_or(b.mean), &measure.unit)),
                    claim: Claim::new(environment, p.map(|t| t.p_value), None, p_not_equivalent),
                    bound,
                    values: [first, second],
                    tested,
                    refused,
                    is_claimed,
                });
            }
        }
    }
    Ok(rows)
}

/// The differences by the names of what they compare.
pub(crate) fn named(
    rows: &[Row],
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<GroupDifference> {
    let [g_av, d_av] =
        [EffectSize::GAv, EffectSize::DAv].map(|size| parameters.effect_sizes.contains(&size));
    let named = rows.iter().map(|row| {
        let [a, b] = [0, 1].map(|side| group(&row.values[side]));
        let tested = row.tested.as_ref().ok();
        let with_p = tested.filter(|_| row.refused.as_ref().is_none_or(Refused::has_p));
        let both = (a.n > 0 && b.n > 0).then_some(a.mean - b.mean);
        let difference = tested.map(|t| t.estimate).or(both);
        let sized = groups::effect([a, b], parameters.level).ok().filter(|_| g_av || d_av);
        let ends = tested.zip(row.jnd).map(|(t, jnd)| [t.ci_low / jnd, t.ci_high / jnd]);
        let why = row.tested.as_ref().err().map(ToString::to_string);
        GroupDifference {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: parameters.environments.get(row.claim.environment).cloned(),
            effect: row.effect.clone(),
            groups: row.groups.clone(),
            n_first: a.n,
            n_second: b.n,
            mean_first: (a.n > 0).then_some(a.mean),
            mean_second: (b.n > 0).then_some(b.mean),
            sd_first: (a.n > 1).then_some(a.sd),
            sd_second: (b.n > 1).then_some(b.sd),
            difference,
            difference_std_error: tested.map(|t| t.std_error),
            difference_ci_low: tested.map(|t| t.ci_low),
            difference_ci_high: tested.map(|t| t.ci_high),
            statistic: with_p.map(|t| t.statistic),
            df: tested.map(|t| t.df),
            p_value: with_p.map(|t| t.p_value),
            p_adjusted: row.claim.p_adjusted,
            p_permuted: row.permuted.map(|test| test.p_value),
            smallest_p_permuted: row.permuted.map(|test| test.smallest_p),
            g_av: sized.and_then(|e| e.g).filter(|_| g_av),
            d_av: sized.map(|e| e.d).filter(|_| d_av),
            d_av_ci_low: sized.and_then(|e| e.interval).map(|ends| ends[0]),
            d_av_ci_high: sized.and_then(|e| e.interval).map(|ends| ends[1]),
            jnd: row.jnd,
            difference_jnd: difference.zip(row.jnd).map(|(difference, jnd)| difference / jnd),
            difference_jnd_ci_low: ends.map(|ends| ends[0]),
            difference_jnd_ci_high: ends.map(|ends| ends[1]),
            size: ends.map(size),
            bound: row.bound,
            p_not_equivalent: row.claim.p_not_equivalent,
            verdict: row.is_claimed.then_some(row.claim.verdict),
            remark: row.refused.as_ref().map(ToString::to_string).or(why).map(Into::into),
        }
    });
    named.collect()
}

/// Everybody's value of what is claimed, of those who have a group.
pub(crate) fn values(
    split: &Split,
    cells: &Cells,
    contrasts: &[contrasts::Row],
    of_factors: &[effects::Row],
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<PersonValue> {
    let mut rows = Vec::new();
    for environment in 0..=parameters.environments.len() {
        for compared in compared(environment, cells, contrasts, of_factors, parameters) {
            let people = compared.values.into_iter().filter(|_| compared.is_claimed);
            for (who, value) in people.filter(|(who, _)| split.level(*who).is_some()) {
                rows.push(PersonValue {
                    metric: measure.parameters.metric.clone(),
                    unit: measure.unit.clone(),
                    environment: parameters.environments.get(environment).cloned(),
                    effect: compared.effect.clone(),
                    participant: cells.participants[who].clone(),
                    value,
                });
            }
        }
    }
    rows
}

/// Whether any group differs from another, where there are more than two.
pub(crate) fn any(
    split: &Split,
    cells: &Cells,
    contrasts: &[contrasts::Row],
    of_factors: &[effects::Row],
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<AnyGroup> {
    let mut rows = Vec::new();
    let environments = 0..=parameters.environments.len();
    for environment in environments.filter(|_| split.groups.compared.levels.len() > 2) {
        for Compared { effect, values, .. } in
            compared(environment, cells, contrasts, of_factors, parameters)
        {
            let groups: Vec<Group> =
                split.by_level(values.into_iter()).iter().map(|values| group(values)).collect();
            let f = groups::any_difference(&groups);
            let tested = f.as_ref().ok();
            rows.push(AnyGroup {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                environment: parameters.environments.get(environment).cloned(),
                effect,
                groups: groups.len(),
                n: groups.iter().map(|group| group.n).sum(),
                f: tested.map(|f| f.statistic),
                df_groups: tested.map(|f| f.df_num),
                df_error: tested.map(|f| f.df_den),
                p_value: tested.map(|f| f.p_value),
                remark: f.as_ref().err().map(|why| why.to_string().into()),
            });
        }
    }
    rows
}

/// The mean of every group in every condition that somebody of it has.
pub(crate) fn means(
    split: &Split,
    cells: &Cells,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Vec<GroupMean>, CompareError> {
    let mut rows = Vec::new();
    for (e, environment) in parameters.environments.iter().enumerate() {
        for (m, mode) in parameters.modes.iter().enumerate() {
            let by_level = split.by_level(cells.people_in(e, m));
            for (values, level) in by_level.iter().zip(&split.groups.compared.levels) {
                let mean = interval::mean(values, parameters.level)?;
                let Some(estimate) = mean.estimate else { continue };
                rows.push(GroupMean {
                    metric: measure.parameters.metric.clone(),
                    unit: measure.unit.clone(),
                    environment: environment.clone(),
                    mode: mode.clone(),
                    group: level.clone(),
                    n: mean.n,
                    mean: estimate,
                    sd: mean.sd,
                    ci_low: mean.interval.map(|i| i.ci_low),
                    ci_high: mean.interval.map(|i| i.ci_high),
                });
            }
        }
    }
    Ok(rows)
}

/// The differences between modes within each group.
pub(crate) fn within(
    split: &Split,
    contrasts: &[contrasts::Row],
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<GroupModeDifference> {
    let chosen = |size: EffectSize| parameters.effect_sizes.contains(&size);
    let level = parameters.level;
    let mut rows = Vec::new();
    for row in contrasts {
        let pairs = row.differences.iter().map(|one| (one.participant, one.means));
        for (pairs, group) in split.by_level(pairs).iter().zip(&split.groups.compared.levels) {
            let n = pairs.len();
            let of_two = paired::mean_difference(&paired::differences(pairs), level);
            let tested = of_two.as_ref().ok();
            let mean = |side: usize| {
                (n > 0).then(|| pairs.iter().map(|pair| pair[side]).sum::<f64>() / n as f64)
            };
            let plain = mean(0).zip(mean(1)).map(|(first, second)| first - second);
            let av = effect::d_av(pairs, level).ok();
            let z = effect::d_z(pairs, level).ok();
            rows.push(GroupModeDifference {
                metric: measure.parameters.metric.clone(),
                unit: measure.unit.clone(),
                environment: parameters.environments[row.claim.environment].clone(),
                contrast: row.contrast.clone(),
                group: group.clone(),
                n,
                mean_first: mean(0),
                mean_second: mean(1),
                difference: tested.map(|t| t.estimate).or(plain),
                difference_std_error: tested.map(|t| t.std_error),
                difference_ci_low: tested.map(|t| t.ci_low),
                difference_ci_high: tested.map(|t| t.ci_high),
                statistic: tested.map(|t| t.statistic),
                df: tested.map(|t| t.df),
                p_value: tested.map(|t| t.p_value),
                g_av: av.and_then(|e| e.g).filter(|_| chosen(EffectSize::GAv)),
                d_av: av.map(|e| e.d).filter(|_| chosen(EffectSize::DAv)),
                g_z: z.and_then(|e| e.g).filter(|_| chosen(EffectSize::GZ)),
                d_z: z.map(|e| e.d).filter(|_| chosen(EffectSize::DZ)),
                remark: of_two.as_ref().err().map(|why| why.to_string().into()),
            });
        }
    }
    rows
}

/// Those who took part and have no group, by their codes.
pub(crate) fn without_group<'a>(split: &Split, cells: &'a Cells) -> Vec<&'a str> {
    let people = cells.cells.iter().filter(|cell| cell.mean.is_some());
    let people: BTreeSet<usize> = people.map(|cell| cell.participant).collect();
    let without = people.into_iter().filter(|participant| split.level(*participant).is_none());
    without.map(|participant| cells.participants[participant].as_str()).collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use crate::tests::{measured, parameters};
    use crate::{Comparison, Groups, Parameters, compare};
    use std::collections::BTreeMap;
    use zwidth_results::{GroupDifference, GroupEffect, TrialKey, Verdict};
    use zwidth_study::{GroupContrast, GroupsCompared, LevelId, ParticipantId, Source};

    /// A number between −½ and ½ that anybody can make again: (h³ mod 9941)/9941 − ½.
    fn u(of: [u64; 3]) -> f64 {
        let h = 1 + 131 * of[0] + 173 * of[1] + 197 * of[2];
        (h * h * h % 9941) as f64 / 9941.0 - 0.5
    }

    pub(crate) fn code(person: u64) -> ParticipantId {
        format!("P{person:02}").parse().unwrap()
    }

    /// Twelve people in three modes, four repeats each, of whom the last five scatter three times as much.
    pub(crate) fn comparison(parameters: &Parameters) -> Comparison {
        comparison_without(parameters, |_| false)
    }

    /// The same without some of the trials.
    fn comparison_without(
        parameters: &Parameters,
        is_lacking: impl Fn(&TrialKey) -> bool,
    ) -> Comparison {
        let mut keys = Vec::new();
        let mut values = Vec::new();
        for person in 1..=12 {
            for (m, mode) in (0_u64..).zip(["active", "passive", "hybrid"]) {
                for repeat in 1..=4 {
                    let expert = if person > 7 { 1.0 } else { 0.0 };
                    let hybrid = if m == 2 { 1.0 } else { 0.0 };
                    let value = 2.0
                        + 0.25 * m as f64
                        + (0.15 + 0.3 * expert) * hybrid
                        + 0.8 * u([person, 0, 0])
                        + 0.6 * (1.0 + 2.0 * expert) * u([person, m + 1, 0])
                        + 0.4 * u([person, m + 1, repeat]);
                    let key = TrialKey {
                        participant: code(person),
                        session: "S01".parse().unwrap(),
                        trial: (4 * m + repeat) as u32,
                        repeat: repeat as u32,
                        environment: "spring".parse().unwrap(),
                        mode: mode.parse().unwrap(),
                        source: Source::Recorded,
                    };
                    if !is_lacking(&key) {
                        values.push(Some((value * 1000.0).round() / 1000.0));
                        keys.push(key);
                    }
                }
            }
        }
        compare(&measured(&keys, values.into_iter()), parameters).unwrap()
    }

    fn level(id: &str) -> LevelId {
        id.parse().unwrap()
    }

    /// The groups of the people from 1 on, each later one against the first.
    fn split(levels: &[&str], of: &[usize]) -> Parameters {
        let levels: Vec<LevelId> = levels.iter().map(|id| level(id)).collect();
        let contrasts = levels[1..]
            .iter()
            .map(|group| GroupContrast { group: group.clone(), against: levels[0].clone() });
        let compared = GroupsCompared {
            column: "group".parse().unwrap(),
            contrasts: contrasts.collect(),
            levels,
            assigned: false,
        };
        let levels_of: BTreeMap<ParticipantId, usize> =
            (1..).map(code).zip(of.iter().copied()).collect();
        Parameters {
            groups: Some(Groups { compared, levels_of, blocks: BTreeMap::new() }),
            ..parameters()
        }
    }

    const HALVES: [usize; 12] = [0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1];

    pub(crate) fn near(found: Option<f64>, expected: f64) {
        near_to(found, expected, 1e-6);
    }

    fn near_to(found: Option<f64>, expected: f64, tolerance: f64) {
        let found = found.unwrap();
        assert!((found - expected).abs() <= tolerance * expected.abs(), "{found} {expected}");
    }

    fn of<'a>(rows: &'a [GroupDifference], effect: &str) -> &'a GroupDifference {
        let effect: GroupEffect = effect.parse().unwrap();
        rows.iter().find(|row| row.effect == effect).unwrap()
    }

    /// R 4.2 (`t.test`) and SciPy 1.17 on people's means of the same values.
    #[test]
    fn groups_differ_by_welch_and_modes_by_groups_with_equal_weight() {
        let found = comparison(&split(&["novice", "expert"], &HALVES));
        let row = of(&found.groups, "hybrid − active");
        near(row.difference, 0.0245571429);
        near(row.difference_std_error, 0.408888294);
        near(row.df, 4.33041842);
        near(row.p_value, 0.954780048);
        near(row.p_permuted, 742.0 / 792.0);
        near(row.g_av, 0.0309151729);
        assert_eq!((row.n_first, row.n_second), (5, 7));
        assert_eq!(row.groups.to_string(), "expert − novice");
        near(of(&found.groups, "hybrid").p_value, 0.631813917);
        near(of(&found.groups, "mean over modes").p_value, 0.976206109);

        let contrast = &found.contrasts[0];
        near(Some(contrast.difference), 0.667921429);
        near(contrast.difference_std_error, 0.204444147);
        near(contrast.df, 4.33041842);
        near(contrast.p_value, 0.0274871718);
        assert_eq!((contrast.n, contrast.g_av, contrast.p_sign_flip), (12, None, None));

        // lme4 1.1-31 and pbkrtest 0.5.2: y ~ group * mode + (1|participant) + (1|participant:mode).
        let beside = |effect: &str| {
            let effect: GroupEffect = effect.parse().unwrap();
            found.group_models.iter().find(|row| row.effect == effect).unwrap()
        };
        for (row, [estimate, error, df]) in [
            (beside("hybrid − active"), [0.0245571429, 0.308401035, 20.0]),
            (beside("mean over modes"), [0.00707857143, 0.208119097, 10.0]),
        ] {
            near(row.difference, estimate);
            near_to(row.difference_std_error, error, 1e-5);
            near_to(row.df, df, 1e-5);
        }
        let [interaction] = found.group_model_tests.as_slice() else {
            panic!("{:?}", found.group_model_tests)
        };
        near_to(interaction.f, 1.27123, 1e-5);
        near_to(interaction.df_error, 20.0, 1e-5);
        near_to(interaction.p_value, 0.302193894, 1e-5);
        assert_eq!((interaction.df_effect, interaction.n), (Some(2.0), 12));
        assert_eq!((interaction.groups, interaction.modes, interaction.trials), (2, 3, 144));
        let model = &found.models[0];
        near(model.difference, 0.667921429);
        near_to(model.difference_std_error, 0.154200517, 1e-5);
        near_to(model.df, 20.0, 1e-5);
        near_to(model.participant_mode_sd, 0.367984657, 1e-5);
        near_to(model.participant_sd, 0.283013434, 1e-5);
        near_to(model.residual_sd, 0.114736586, 1e-5);
        let [novice, expert] = &found.group_contrasts[..2] else { panic!() };
        assert_eq!((novice.group.as_str(), novice.n, expert.n), ("novice", 7, 5));
        near(novice.difference, 0.655642857);
        near(novice.p_value, 1.93413820e-4);
        near(expert.difference, 0.6802);
        near(expert.p_value, 0.164866159);
        // The mean of the contrast's mode has its group's weight too.
        let hybrid = found.means.iter().find(|mean| mean.mode.as_str() == "hybrid").unwrap();
        near(Some(hybrid.mean), contrast.mean_first);
        let means = found.group_means.iter().filter(|mean| mean.mode.as_str() == "hybrid");
        near(Some(hybrid.mean), means.map(|mean| mean.mean).sum::<f64>() / 2.0);
        assert!(found.any_group.is_empty());
    }

    /// Two contrasts of modes, and of groups two contrasts and the mean over modes: five claims, one family.
    #[test]
    fn claims_of_groups_and_modes_are_one_family_and_single_modes_are_described() {
        let found = comparison(&split(&["novice", "expert"], &HALVES));
        let of_modes = found.contrasts.iter().map(|row| (row.p_value, row.p_adjusted));
        let of_groups = found.groups.iter().filter(|row| row.verdict.is_some());
        let of_groups = of_groups.map(|row| (row.p_value, row.p_adjusted));
        let mut family: Vec<(f64, f64)> = of_modes
            .chain(of_groups)
            .map(|(p, adjusted)| (p.unwrap(), adjusted.unwrap()))
            .collect();
        assert_eq!(family.len(), 5);
        family.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut least = 0.0_f64;
        for (rank, (p, adjusted)) in family.iter().enumerate() {
            least = least.max(p * (5 - rank) as f64).min(1.0);
            assert!((adjusted - least).abs() < 1e-12, "{family:?}");
        }
        let described = of(&found.groups, "hybrid");
        assert!(described.p_value.is_some() && described.p_adjusted.is_none());
    }

    #[test]
    fn small_groups_have_an_interval_then_a_p_and_four_people_a_claim() {
        for (experts, has_p, words) in [
            (1, false, Some("no test: expert has 1 participant, 3 are needed")),
            (2, false, Some("no test: expert has 2 participants, 3 are needed")),
            (3, true, Some("no claim: expert has 3 participants")),
            (4, true, None),
        ] {
            let groups: Vec<usize> = (0..12).map(|person| usize::from(person < experts)).collect();
            let found = comparison(&split(&["novice", "expert"], &groups));
            let row = of(&found.groups, "hybrid − active");
            assert_eq!(row.p_value.is_some(), has_p, "{experts}");
            assert_eq!(row.difference_ci_low.is_some(), experts > 1);
            assert!(row.difference.is_some());
            let claimed = row.verdict != Some(Verdict::NotTested);
            assert_eq!((claimed, row.p_adjusted.is_some()), (experts > 3, experts > 3));
            let remark = row.remark.as_ref().map(ToString::to_string);
            assert_eq!(remark.is_some(), words.is_some(), "{remark:?}");
            assert!(remark.unwrap_or_default().starts_with(words.unwrap_or_default()));
            let contrast = &found.contrasts[0];
            assert_eq!(
                (contrast.p_value.is_some(), contrast.p_adjusted.is_some()),
                (has_p, experts > 3)
            );
        }
    }

    #[test]
    fn group_by_mode_has_no_f_where_a_group_lacks_a_mode_and_no_row_of_one_group() {
        let mut parameters = split(&["novice", "expert"], &HALVES);
        parameters.groups.as_mut().unwrap().levels_of.retain(|who, _| *who <= code(7));
        assert!(comparison(&parameters).group_model_tests.is_empty());
        let lacking = |key: &TrialKey| key.participant > code(7) && key.mode.as_str() == "passive";
        let found = comparison_without(&split(&["novice", "expert"], &HALVES), lacking);
        let [row] = found.group_model_tests.as_slice() else { panic!() };
        assert_eq!((row.f, row.p_value, row.trials), (None, None, 124));
        let remark = row.remark.as_ref().unwrap().to_string();
        assert_eq!(remark, "nobody of the group expert has trials in the mode passive");
    }

    #[test]
    fn who_has_no_group_and_a_group_of_nobody_are_named_and_in_no_number() {
        let found = comparison(&split(&["novice", "expert", "child"], &HALVES[..11]));
        let row = of(&found.groups, "hybrid");
        assert_eq!((row.n_first, found.contrasts[0].n, found.means[0].n), (4, 11, 11));
        let empty = &found.groups.iter().find(|row| row.groups.group == level("child")).unwrap();
        assert_eq!((empty.n_first, empty.difference, empty.p_value), (0, None, None));
        assert!(empty.remark.is_some() && empty.verdict == Some(Verdict::NotTested));
        let notes: Vec<String> = found.notes.iter().map(|note| note.note.to_string()).collect();
        for words in ["Without P12 (no group).", "of the group child", "without P12 (no group)"] {
            assert!(notes.iter().any(|note| note.contains(words)), "{words}: {notes:?}");
        }
    }

    /// R: `oneway.test(c ~ band)`.
    #[test]
    fn of_three_groups_welchs_f_stands_beside_the_pairs() {
        let bands: Vec<usize> = (1..=12).map(|person| person % 3).collect();
        let found = comparison(&split(&["a", "b", "c"], &bands));
        let effect: GroupEffect = "hybrid − active".parse().unwrap();
        let row = found.any_group.iter().find(|row| row.effect == effect).unwrap();
        near(row.f, 1.58017655);
        near(row.df_error, 4.52137704);
        near(row.p_value, 0.301728201);
        assert_eq!((row.groups, row.n), (3, 12));
        assert_eq!(found.groups.iter().filter(|row| row.effect == effect).count(), 2);
    }

    #[test]
    fn a_study_of_one_mode_claims_its_groups_in_that_mode() {
        let mut parameters = split(&["novice", "expert"], &HALVES);
        parameters.modes = vec!["hybrid".parse().unwrap()];
        parameters.contrasts = Vec::new();
        let found = comparison(&parameters);
        let [row] = found.groups.as_slice() else { panic!("{:?}", found.groups) };
        assert_eq!(row.effect, GroupEffect::In("hybrid".parse().unwrap()));
        near(row.p_adjusted, 0.631813917);
        assert_eq!(row.verdict, Some(Verdict::Undecided));
    }
}
