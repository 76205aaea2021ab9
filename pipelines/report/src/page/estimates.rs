//! What the stage `compare` estimated of a metric, as the page's script draws it: means and
//! differences with their intervals, and what it needs to estimate a difference again.

use crate::compared::before;
use crate::groups::compared_words;
use serde::{Serialize, Serializer};
use zwidth_results::{
    EffectDifference, GroupDifference, Mean, ModeDifference, RedrawnDifference, Size, Verdict,
};
use zwidth_study::{Better, ModeId, Setup};

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
    /// None of one that cannot be estimated.
    value: Option<f64>,
    error: Option<f64>,
    /// Ends of the interval, where there is one.
    low: Option<f64>,
    high: Option<f64>,
    /// How many people.
    who: String,
    #[serde(serialize_with = "verdict_in_words")]
    pub(super) verdict: Verdict,
    #[serde(serialize_with = "size_in_words")]
    pub(super) size: Option<Size>,
    p_adjusted: Option<f64>,
    pub(super) jnd: Option<f64>,
    /// The standard deviation by which it is measured where that is not known.
    deviation: Option<f64>,
    remark: Option<String>,
}

impl ClaimOf {
    pub(super) fn of_effect(row: &EffectDifference, study: &Setup) -> Self {
        Self {
            of: format!("{}{}", before(study, row.environment.as_ref(), ": "), row.name()),
            is_of_groups: false,
            value: row.difference,
            error: row.difference_std_error,
            low: row.difference_ci_low,
            high: row.difference_ci_high,
            who: match row.n {
                1 => "1\u{a0}person".to_owned(),
                n => format!("{n}\u{a0}people"),
            },
            verdict: row.verdict,
            size: row.size,
            p_adjusted: row.p_adjusted,
            jnd: row.jnd,
            deviation: row.deviation(),
            remark: row.remark.as_ref().map(ToString::to_string),
        }
    }

    /// Nothing of what is no claim.
    pub(super) fn of_groups(row: &GroupDifference, study: &Setup) -> Option<Self> {
        let environment = before(study, row.environment.as_ref(), ": ");
        Some(Self {
            of: format!("{environment}{} in {}", row.groups, compared_words(study, &row.effect)),
            is_of_groups: true,
            value: row.difference,
            error: row.difference_std_error,
            low: row.difference_ci_low,
            high: row.difference_ci_high,
            who: format!("{}\u{a0}and\u{a0}{}\u{a0}people", row.n_first, row.n_second),
            verdict: row.verdict?,
            size: row.size,
            p_adjusted: row.p_adjusted,
            jnd: row.jnd,
            deviation: row.deviation(),
            remark: row.remark.as_ref().map(ToString::to_string),
        })
    }
}
