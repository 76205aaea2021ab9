//! What the stage `compare` estimated of a metric, as the page's script draws it: means and
//! differences with their intervals, and what it needs to estimate a difference again.

use crate::compared::{ComparedMetric, before};
use crate::groups::compared_words;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use zwidth_results::{
    EffectDifference, GroupDifference, GroupEffect, Mean, ModeDifference, RedrawnDifference, Sides,
    Size, Verdict,
};
use zwidth_study::{Better, Effect, EnvironmentId, LevelId, ModeId, ParticipantId, Setup};
use zwidth_tables::Amounts;

/// The fewest people of a group whose own values the page shows.
const SMALLEST_GROUP_WITH_VALUES: usize = 3;

/// A mean in one condition, in the metric's unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct MeanOf {
    environment: String,
    /// The mode.
    of: String,
    value: f64,
    /// Ends of the interval, where there is one.
    low: Option<f64>,
    high: Option<f64>,
    sd: Option<f64>,
    /// Units of analysis, and what they are.
    n: usize,
    unit_of_analysis: String,
}

impl MeanOf {
    pub(super) fn new(row: &Mean) -> Self {
        Self {
            environment: row.environment.to_string(),
            of: row.mode.to_string(),
            value: row.mean,
            low: row.ci_low,
            high: row.ci_high,
            sd: row.sd,
            n: row.n,
            unit_of_analysis: row.unit_of_analysis.to_string(),
        }
    }
}

fn verdict_in_words<S: Serializer>(verdict: &Verdict, to: S) -> Result<S::Ok, S::Error> {
    to.serialize_str(verdict.as_str())
}

#[allow(clippy::ref_option)] // serde gives the field
fn size_in_words<S: Serializer>(size: &Option<Size>, to: S) -> Result<S::Ok, S::Error> {
    size.map(Size::as_str).serialize(to)
}

/// A difference between two modes, in the metric's unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct DifferenceOf {
    environment: String,
    /// The contrast as the tables write it, and its two modes.
    of: String,
    mode: String,
    against: String,
    value: f64,
    error: Option<f64>,
    /// Ends of the interval, where there is one.
    low: Option<f64>,
    high: Option<f64>,
    n: usize,
    unit_of_analysis: String,
    /// The means of both modes, of those who have both.
    means: [f64; 2],
    #[serde(serialize_with = "verdict_in_words")]
    pub(super) verdict: Verdict,
    #[serde(serialize_with = "size_in_words")]
    pub(super) size: Option<Size>,
    /// The mode that is better, where one is.
    #[serde(skip)]
    pub(super) best: Option<ModeId>,
    p_adjusted: Option<f64>,
    bound: Option<f64>,
    /// The just noticeable difference, where it is known, and whether it is that of a commanded value.
    pub(super) jnd: Option<f64>,
    is_commanded: bool,
    /// The differences in other orders of the trials, had none depended on mode.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    redrawn: Vec<f64>,
}

impl DifferenceOf {
    pub(super) fn new(row: &ModeDifference, better: Better, redrawn: &[RedrawnDifference]) -> Self {
        let key = (&row.environment, &row.contrast);
        let own = redrawn.iter().filter(|other| (&other.environment, &other.contrast) == key);
        Self {
            environment: row.environment.to_string(),
            of: row.contrast.to_string(),
            mode: row.contrast.mode.to_string(),
            against: row.contrast.against.to_string(),
            value: row.difference,
            error: row.difference_std_error,
            low: row.difference_ci_low,
            high: row.difference_ci_high,
            n: row.n,
            unit_of_analysis: row.unit_of_analysis.to_string(),
            means: [row.mean_first, row.mean_second],
            verdict: row.verdict,
            size: row.size,
            best: row.best(better).cloned(),
            p_adjusted: row.p_adjusted,
            bound: row.bound,
            jnd: row.jnd,
            is_commanded: row.commanded.is_some(),
            redrawn: own.map(|other| other.difference).collect(),
        }
    }
}

/// An effect of factors, or a difference between groups, in the metric's unit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct ClaimOf {
    /// Environment, factors and levels, or groups and what of them.
    of: String,
    pub(super) is_of_groups: bool,
    /// Of logarithms: whether it says how many times as large one ratio is as another.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    is_of_ratios: bool,
    /// None over several.
    environment: Option<String>,
    /// None of one that cannot be estimated.
    value: Option<f64>,
    error: Option<f64>,
    /// Ends of the interval, where there is one.
    low: Option<f64>,
    high: Option<f64>,
    /// How many people, of groups those of the first.
    n: usize,
    /// Those of the second group.
    n_against: Option<usize>,
    #[serde(serialize_with = "verdict_in_words")]
    pub(super) verdict: Verdict,
    #[serde(serialize_with = "size_in_words")]
    pub(super) size: Option<Size>,
    p_adjusted: Option<f64>,
    pub(super) jnd: Option<f64>,
    /// The standard deviation by which it is measured where that is not known.
    deviation: Option<f64>,
    remark: Option<String>,
    /// Everybody's effect.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    people: Vec<PersonOf>,
    /// The conditions of an effect, by environment.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    conditions: Vec<ConditionsOf>,
    /// The two groups, without codes. Who has the page's trials can tell by the numbers who is of which.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    groups: Vec<GroupOf>,
}

/// A participant's value.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct PersonOf {
    participant: ParticipantId,
    value: f64,
}

/// Modes in an environment.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct ConditionsOf {
    environment: EnvironmentId,
    modes: Vec<ModeId>,
}

impl ConditionsOf {
    /// Those that have a weight in an effect, in its order.
    fn weighed(effect: &Effect) -> Vec<Self> {
        let mut conditions: Vec<Self> = Vec::new();
        for weight in effect.weights.iter().filter(|weight| weight.weight != 0.0) {
            let place = conditions.iter().position(|own| own.environment == weight.environment);
            let place = place.unwrap_or_else(|| {
                let environment = weight.environment.clone();
                conditions.push(Self { environment, modes: Vec::new() });
                conditions.len() - 1
            });
            if !conditions[place].modes.contains(&weight.mode) {
                conditions[place].modes.push(weight.mode.clone());
            }
        }
        conditions
    }
}

/// A group's people.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct GroupOf {
    label: LevelId,
    mean: Option<f64>,
    sd: Option<f64>,
    /// Everybody's, from the lowest to the highest; empty of fewer than [`SMALLEST_GROUP_WITH_VALUES`] people.
    values: Vec<f64>,
}

fn is_of_ratios(amounts: &Amounts, sides: Sides) -> bool {
    amounts.are_logarithms() && sides == Sides::Differences
}

impl ClaimOf {
    pub(super) fn of_effect(
        row: &EffectDifference,
        metric: &ComparedMetric,
        effects: &[Effect],
        study: &Setup,
    ) -> Self {
        let amounts = metric.amounts(study);
        let effect = GroupEffect::OfFactors(row.name());
        let own = metric
            .person_values
            .iter()
            .filter(|own| own.environment == row.environment && own.effect == effect);
        let levels = row.levels.as_ref().map_or(&[][..], |levels| &levels.0);
        let is_of_row = |effect: &&Effect| {
            let key = (&effect.environment, &effect.term, effect.levels.as_slice());
            key == (&row.environment, &row.effect, levels)
        };
        Self {
            of: before(study, row.environment.as_ref(), ": ")
                + &amounts.compared(&row.name().to_string()),
            environment: row.environment.as_ref().map(ToString::to_string),
            is_of_groups: false,
            is_of_ratios: is_of_ratios(&amounts, row.sides()),
            value: row.difference,
            error: row.difference_std_error,
            low: row.difference_ci_low,
            high: row.difference_ci_high,
            n: row.n,
            n_against: None,
            verdict: row.verdict,
            size: row.size,
            p_adjusted: row.p_adjusted,
            jnd: row.jnd,
            deviation: row.deviation(),
            remark: row.remark.as_ref().map(ToString::to_string),
            people: own
                .map(|own| PersonOf { participant: own.participant.clone(), value: own.value })
                .collect(),
            conditions: effects
                .iter()
                .find(is_of_row)
                .map(ConditionsOf::weighed)
                .unwrap_or_default(),
            groups: Vec::new(),
        }
    }

    /// Nothing of what is no claim.
    pub(super) fn of_groups(
        row: &GroupDifference,
        metric: &ComparedMetric,
        study: &Setup,
    ) -> Option<Self> {
        let members: BTreeMap<&ParticipantId, &LevelId> =
            metric.group_members.iter().map(|own| (&own.participant, &own.group)).collect();
        let group = |level: &LevelId, mean, sd| {
            let own = metric.person_values.iter().filter(|own| {
                own.environment == row.environment
                    && own.effect == row.effect
                    && members.get(&own.participant) == Some(&level)
            });
            let mut values: Vec<f64> = own.map(|own| own.value).collect();
            values.sort_by(f64::total_cmp);
            if values.len() < SMALLEST_GROUP_WITH_VALUES {
                values.clear();
            }
            GroupOf { label: level.clone(), mean, sd, values }
        };
        let amounts = metric.amounts(study);
        Some(Self {
            of: before(study, row.environment.as_ref(), ": ")
                + &compared_words(study, &amounts, row),
            environment: row.environment.as_ref().map(ToString::to_string),
            is_of_groups: true,
            is_of_ratios: is_of_ratios(&amounts, row.sides()),
            value: row.difference,
            error: row.difference_std_error,
            low: row.difference_ci_low,
            high: row.difference_ci_high,
            n: row.n_first,
            n_against: Some(row.n_second),
            verdict: row.verdict?,
            size: row.size,
            p_adjusted: row.p_adjusted,
            jnd: row.jnd,
            deviation: row.deviation(),
            remark: row.remark.as_ref().map(ToString::to_string),
            people: Vec::new(),
            conditions: Vec::new(),
            groups: vec![
                group(&row.groups.group, row.mean_first, row.sd_first),
                group(&row.groups.against, row.mean_second, row.sd_second),
            ],
        })
    }
}
