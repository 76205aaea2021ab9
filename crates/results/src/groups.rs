//! What the stage `compare` finds about groups of people, one metric at a time. The numbers of a row
//! are in the unit of its metric, which the row names.

use crate::column::UNIT_OF_ROW;
use crate::comparison::{Sides, Size, Verdict};
use crate::effects::FactorEffect;
use crate::row::{of_metric, rows};
use crate::sentence::Sentence;
use crate::value::{named, texts};
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;
use zwidth_study::{
    Contrast, EnvironmentId, GroupContrast, IdError, LevelId, MetricId, ModeId, OverTrials,
    ParticipantId, PersonColumnId,
};

/// What of people is compared between groups.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum GroupEffect {
    /// Their mean over the modes.
    OverModes,
    /// Their value in one mode.
    In(ModeId),
    /// Their difference between two modes: whether groups differ in it.
    Of(Contrast),
    /// Their effect of factors: whether groups differ in it.
    OfFactors(FactorEffect),
}

/// How the mean over modes is called. No id has a space.
const OVER_MODES: &str = "mean over modes";

impl fmt::Display for GroupEffect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OverModes => f.pad(OVER_MODES),
            Self::In(mode) => mode.fmt(f),
            Self::Of(contrast) => contrast.fmt(f),
            Self::OfFactors(effect) => effect.fmt(f),
        }
    }
}

impl FromStr for GroupEffect {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        match text {
            OVER_MODES => Ok(Self::OverModes),
            _ if text.contains(FactorEffect::OF) || text.starts_with(FactorEffect::WEIGHTED) => {
                text.parse().map(Self::OfFactors)
            }
            _ if text.contains(Contrast::MINUS) => text.parse().map(Self::Of),
            _ => text.parse().map(Self::In),
        }
    }
}

impl GroupDifference {
    /// What it is the difference of.
    pub fn sides(&self) -> Sides {
        match self.effect {
            GroupEffect::OverModes | GroupEffect::In(_) => Sides::Values,
            GroupEffect::Of(_) | GroupEffect::OfFactors(_) => Sides::Differences,
        }
    }

    /// The root mean of both groups' variances, by which a difference is measured where it is not known what is felt;
    /// none where nothing varies.
    pub fn deviation(&self) -> Option<f64> {
        let deviation = ((self.sd_first?.powi(2) + self.sd_second?.powi(2)) / 2.0).sqrt();
        (deviation > 0.0).then_some(deviation)
    }
}

texts!(GroupEffect, GroupContrast, LevelId, PersonColumnId);
named!(OverTrials);

rows! {
    /// Who is of which group.
    GroupMember = "group_members", "Participants by group" {
        /// who
        participant: ParticipantId,
        /// of which group
        group: LevelId,
    }

    /// How many people are of a level, or how a number of people is spread.
    PersonCount = "people", "Participants" {
        /// what is known of people
        column: PersonColumnId,
        /// its level; none of a number
        level: Option<LevelId>,
        /// the unit of a number
        unit: Option<String>,
        /// participants; null where there are one or two
        n: Option<usize>,
        /// mean over participants, in its unit
        mean: Option<f64>,
        /// standard deviation over participants
        sd: Option<f64>,
        /// why something is missing
        remark: Option<Sentence>,
    }

    /// What is claimed of participants, one by one: everybody's effect of factors, or the value in which groups are
    /// compared.
    PersonValue = "person_values", "Everybody's effects, and values compared between groups" {
        /// what is compared
        metric: MetricId,
        /// unit of the metric
        unit: Arc<str>,
        /// what was rendered; null over several environments
        environment: Option<EnvironmentId>,
        /// what of people: in a mode, over all modes, their difference between two, or an effect of factors
        effect: GroupEffect,
        /// who
        participant: ParticipantId,
        /// this participant's
        value: f64 = UNIT_OF_ROW,
    }

    /// The mean of a group's people in a condition.
    GroupMean = "group_means", "Means by group and condition" {
        ..of_metric,
        /// how it was rendered
        mode: ModeId,
        /// whose people
        group: LevelId,
        /// participants
        n: usize,
        /// mean over participants
        mean: f64 = UNIT_OF_ROW,
        /// standard deviation of participants
        sd: Option<f64> = UNIT_OF_ROW,
        /// lower end of the mean's interval
        ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of the mean's interval
        ci_high: Option<f64> = UNIT_OF_ROW,
    }

    /// The difference of two modes within a group.
    GroupModeDifference = "group_contrasts", "Modes compared within each group" {
        ..of_metric,
        /// the modes compared: the one minus the other
        contrast: Contrast,
        /// whose people
        group: LevelId,
        /// participants
        n: usize,
        /// mean in the contrast's first mode
        mean_first: Option<f64> = UNIT_OF_ROW,
        /// mean in the contrast's second mode
        mean_second: Option<f64> = UNIT_OF_ROW,
        /// mean difference
        difference: Option<f64> = UNIT_OF_ROW,
        /// its standard error
        difference_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        difference_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        difference_ci_high: Option<f64> = UNIT_OF_ROW,
        /// t statistic
        statistic: Option<f64>,
        /// degrees of freedom
        df: Option<f64>,
        /// p value of no difference, not adjusted
        p_value: Option<f64>,
        /// d_av without its bias where people are few
        g_av: Option<f64>,
        /// difference over the root mean of the modes' variances between participants
        d_av: Option<f64>,
        /// d_z without its bias where people are few
        g_z: Option<f64>,
        /// difference over the standard deviation of participants' differences
        d_z: Option<f64>,
        /// why something is missing
        remark: Option<Sentence>,
    }

    /// The difference of two groups, tested.
    GroupDifference = "groups", "Groups compared" {
        /// what is compared
        metric: MetricId,
        /// unit of the metric
        unit: Arc<str>,
        /// what was rendered; null over several environments
        environment: Option<EnvironmentId>,
        /// what of people: in a mode, over all modes, their difference between two, or an effect of factors
        effect: GroupEffect,
        /// the groups compared: the one minus the other
        groups: GroupContrast,
        /// participants of the first group
        n_first: usize,
        /// participants of the second group
        n_second: usize,
        /// mean of the first group
        mean_first: Option<f64> = UNIT_OF_ROW,
        /// mean of the second group
        mean_second: Option<f64> = UNIT_OF_ROW,
        /// standard deviation of the first group's people
        sd_first: Option<f64> = UNIT_OF_ROW,
        /// standard deviation of the second group's people
        sd_second: Option<f64> = UNIT_OF_ROW,
        /// difference of the means
        difference: Option<f64> = UNIT_OF_ROW,
        /// its standard error
        difference_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        difference_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        difference_ci_high: Option<f64> = UNIT_OF_ROW,
        /// Welch's t
        statistic: Option<f64>,
        /// its degrees of freedom
        df: Option<f64>,
        /// p value of no difference, by t
        p_value: Option<f64>,
        /// p value of the claim, adjusted over its family by Holm
        p_adjusted: Option<f64>,
        /// p value of labels without meaning (permuted), not adjusted
        p_permuted: Option<f64>,
        /// the smallest that as many people can reach
        smallest_p_permuted: Option<f64>,
        /// d_av without its bias where people are few
        g_av: Option<f64>,
        /// difference over the root mean of the groups' variances
        d_av: Option<f64>,
        /// lower end of the interval of d_av
        d_av_ci_low: Option<f64>,
        /// upper end of the interval of d_av
        d_av_ci_high: Option<f64>,
        /// difference that is just noticed
        jnd: Option<f64> = UNIT_OF_ROW,
        /// difference over the one that is just noticed
        difference_jnd: Option<f64>,
        /// lower end of its interval
        difference_jnd_ci_low: Option<f64>,
        /// upper end of its interval
        difference_jnd_ci_high: Option<f64>,
        /// whether the interval is of differences that are felt, no claim
        size: Option<Size>,
        /// differences up to this size are equivalent
        bound: Option<f64> = UNIT_OF_ROW,
        /// p value of a difference beyond the bound (TOST)
        p_not_equivalent: Option<f64>,
        /// what the tests show; nothing of what is no claim
        verdict: Option<Verdict>,
        /// why there is no test, or no claim
        remark: Option<Sentence>,
    }

    /// The difference of two groups by the mixed model of all trials.
    GroupModel = "group_models", "Mixed model of groups (for comparison)" {
        ..of_metric,
        /// what of people: over all modes, or their difference between two
        effect: GroupEffect,
        /// the groups compared: the one minus the other
        groups: GroupContrast,
        /// trials
        trials: usize,
        /// difference of the groups
        difference: Option<f64> = UNIT_OF_ROW,
        /// its standard error
        difference_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        difference_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        difference_ci_high: Option<f64> = UNIT_OF_ROW,
        /// degrees of freedom (Kenward–Roger)
        df: Option<f64>,
        /// p value of no difference, no claim
        p_value: Option<f64>,
        /// why there is no test
        remark: Option<Sentence>,
    }

    /// Whether groups differ in any difference between modes, by the mixed model of all trials: F of group × mode.
    GroupModelTest = "group_model_tests", "Group × mode by the mixed model of groups (for comparison)" {
        ..of_metric,
        /// groups
        groups: usize,
        /// modes
        modes: usize,
        /// participants
        n: usize,
        /// trials
        trials: usize,
        /// F of group × mode (Kenward–Roger)
        f: Option<f64>,
        /// its degrees of freedom
        df_effect: Option<f64>,
        /// its degrees of freedom for error
        df_error: Option<f64>,
        /// its p value, no claim
        p_value: Option<f64>,
        /// why there is no test
        remark: Option<Sentence>,
    }

    /// How people's differences between two modes change with a number of people.
    CovariateSlope = "covariates", "Differences between modes over a number of people" {
        ..of_metric,
        /// the modes compared: the one minus the other
        contrast: Contrast,
        /// the number of people
        covariate: PersonColumnId,
        /// its unit
        covariate_unit: String,
        /// participants whose number is known
        n: usize,
        /// change of the difference per unit of the number
        difference_per_unit: Option<f64> = UNIT_OF_ROW,
        /// its standard error
        difference_per_unit_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        difference_per_unit_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        difference_per_unit_ci_high: Option<f64> = UNIT_OF_ROW,
        /// t statistic
        statistic: Option<f64>,
        /// degrees of freedom
        df: Option<f64>,
        /// p value of no slope, no claim
        p_value: Option<f64>,
        /// mean of the number, in its unit
        covariate_mean: Option<f64>,
        /// mean difference of these people, which is that at the mean of the number
        difference_at_mean: Option<f64> = UNIT_OF_ROW,
        /// its standard error about the line
        difference_at_mean_std_error: Option<f64> = UNIT_OF_ROW,
        /// why there is no slope
        remark: Option<Sentence>,
    }

    /// How the metric changes along everybody's own line over their trials, besides the modes.
    TrialSlope = "over_trials", "Change over trials, besides the modes" {
        ..of_metric,
        /// what the line is over: the number of the trial, or its repeat
        over: OverTrials,
        /// participants with a line
        n: usize,
        /// change from one to the next, mean over participants
        change_each: f64 = UNIT_OF_ROW,
        /// its standard error
        change_each_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        change_each_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        change_each_ci_high: Option<f64> = UNIT_OF_ROW,
        /// t statistic
        statistic: Option<f64>,
        /// degrees of freedom
        df: Option<f64>,
        /// p value of no change, no claim
        p_value: Option<f64>,
    }

    /// Whether any of several groups differs from another.
    AnyGroup = "any_group", "Any difference between groups" {
        /// what is compared
        metric: MetricId,
        /// unit of the metric
        unit: Arc<str>,
        /// what was rendered; null over several environments
        environment: Option<EnvironmentId>,
        /// what of people: in a mode, over all modes, or their difference between two
        effect: GroupEffect,
        /// groups
        groups: usize,
        /// participants
        n: usize,
        /// Welch's F
        f: Option<f64>,
        /// its degrees of freedom
        df_groups: Option<f64>,
        /// its degrees of freedom for error
        df_error: Option<f64>,
        /// its p value, no claim
        p_value: Option<f64>,
        /// why there is no test
        remark: Option<Sentence>,
    }
}
