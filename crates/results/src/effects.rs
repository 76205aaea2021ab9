//! What the stage `compare` finds about factors of the design, one metric at a time. The numbers of a row
//! are in the unit of its metric, which the row names.

use crate::column::UNIT_OF_ROW;
use crate::comparison::{Sides, Size, Verdict};
use crate::row::rows;
use crate::sentence::Sentence;
use crate::value::texts;
use std::fmt;
use std::str::FromStr;
use std::sync::Arc;
use zwidth_study::{EnvironmentId, FactorId, IdError, LevelContrast, LevelId, MetricId, Term};

/// How an effect compares the levels of each of its factors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct EffectLevels(pub Vec<LevelContrast>);

/// Between those of an interaction. No id has a space.
const TIMES: &str = " × ";

impl fmt::Display for EffectLevels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of_factor = |contrast: &LevelContrast| match self.0.len() {
            1 => contrast.to_string(),
            _ => format!("({contrast})"),
        };
        f.pad(&self.0.iter().map(of_factor).collect::<Vec<_>>().join(TIMES))
    }
}

impl FromStr for EffectLevels {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        let contrasts = text.split(TIMES).map(|contrast| {
            let inner = contrast.strip_prefix('(').and_then(|rest| rest.strip_suffix(')'));
            inner.unwrap_or(contrast).parse()
        });
        contrasts.collect::<Result<_, _>>().map(Self)
    }
}

texts!(FactorId, Term, EffectLevels);

/// An effect by its factors and their levels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FactorEffect {
    /// Of which factor, or of which several; or the name of a weighted contrast.
    pub term: Term,
    /// The levels compared; none of a weighted contrast.
    pub levels: Option<EffectLevels>,
}

impl FactorEffect {
    /// Between the factors and their levels. No id has such a character.
    pub(crate) const OF: &str = ": ";
    /// Before the name of a weighted contrast, which a mode's could be taken for.
    pub(crate) const WEIGHTED: &str = "contrast ";
}

impl fmt::Display for FactorEffect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let factors = self.term.to_string().replace(':', TIMES);
        match &self.levels {
            Some(levels) => f.pad(&format!("{factors}{}{levels}", Self::OF)),
            None => f.pad(&format!("{}{factors}", Self::WEIGHTED)),
        }
    }
}

impl FromStr for FactorEffect {
    type Err = IdError;

    fn from_str(text: &str) -> Result<Self, IdError> {
        let text = text.strip_prefix(Self::WEIGHTED).unwrap_or(text);
        let (factors, levels) = text.split_once(Self::OF).unwrap_or((text, ""));
        let term = factors.replace(TIMES, ":").parse()?;
        let levels = (!levels.is_empty()).then(|| levels.parse()).transpose()?;
        Ok(Self { term, levels })
    }
}

impl EffectDifference {
    /// Its factors and levels, or the weighted contrast.
    pub fn name(&self) -> FactorEffect {
        FactorEffect { term: self.effect.clone(), levels: self.levels.clone() }
    }

    /// What it is the difference of.
    pub fn sides(&self) -> Sides {
        let factors = self.levels.as_ref().map_or(1, |levels| levels.0.len());
        if factors > 1 { Sides::Differences } else { Sides::Values }
    }

    /// The standard deviation of everybody's effects (those of conditions are of no single size), by which an effect is
    /// measured where it is not known what is felt: with it the mean of n people has this standard error. None over
    /// groups with the same weight each, where there is none of all people, and where nothing varies.
    pub fn deviation(&self) -> Option<f64> {
        self.df.filter(|df| (df - (self.n as f64 - 1.0)).abs() < 1e-9)?;
        let deviation = self.difference_std_error? * (self.n as f64).sqrt();
        (deviation > 0.0).then_some(deviation)
    }
}

rows! {
    /// The effect of a factor, of an interaction or of a weighted contrast, tested.
    EffectDifference = "effects", "Effects of factors" {
        /// what is compared
        metric: MetricId,
        /// unit of the metric
        unit: Arc<str>,
        /// what was rendered; null over several environments
        environment: Option<EnvironmentId>,
        /// of which factor, or of which several; or the name of a weighted contrast
        effect: Term,
        /// the levels compared: the one minus the other, the other factors averaged
        levels: Option<EffectLevels>,
        /// participants
        n: usize,
        /// the effect, mean over participants
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
        /// p value of no effect, not adjusted
        p_value: Option<f64>,
        /// p value adjusted after Holm within its family
        p_adjusted: Option<f64>,
        /// d_av without its bias where people are few; of a factor alone
        g_av: Option<f64>,
        /// effect over the root mean of both sides' variances between participants
        d_av: Option<f64>,
        /// d_z without its bias where people are few
        g_z: Option<f64>,
        /// effect over the standard deviation of participants' effects
        d_z: Option<f64>,
        /// p value of the sign-flip test of participants' effects
        p_sign_flip: Option<f64>,
        /// just noticeable difference
        jnd: Option<f64> = UNIT_OF_ROW,
        /// the effect in just noticeable differences
        difference_jnd: Option<f64>,
        /// lower end of its interval in just noticeable differences
        difference_jnd_ci_low: Option<f64>,
        /// upper end of its interval in just noticeable differences
        difference_jnd_ci_high: Option<f64>,
        /// whether the effect is felt, by its interval
        size: Option<Size>,
        /// difference that is too small to matter
        bound: Option<f64> = UNIT_OF_ROW,
        /// p value of an effect as large as the bound
        p_not_equivalent: Option<f64>,
        /// of a dose: its unit
        dose_unit: Option<String>,
        /// of a bend: the dose at which people's mean parabola turns; only between the lowest and the highest, where
        /// the bend's interval excludes 0 and everybody has every level
        turns_at: Option<f64>,
        /// whether there is an effect
        verdict: Verdict,
        /// within which conditions the effect is, or why something is missing
        remark: Option<Sentence>,
    }

    /// The mean of people's own lines, or parabolas, at a dose.
    DosePoint = "trend_curve", "Lines and parabolas over doses" {
        /// what is compared
        metric: MetricId,
        /// unit of the metric
        unit: Arc<str>,
        /// what was rendered; null over several environments
        environment: Option<EnvironmentId>,
        /// over which factor
        effect: Term,
        /// the other factor within a level of which the curve is; null where the others are averaged
        factor: Option<FactorId>,
        /// its level
        level: Option<LevelId>,
        /// whose people; null where no groups are compared
        group: Option<LevelId>,
        /// the dose
        dose: f64,
        /// its unit
        dose_unit: String,
        /// participants who have every dose
        n: usize,
        /// mean over participants
        mean: f64 = UNIT_OF_ROW,
        /// its standard error
        std_error: f64 = UNIT_OF_ROW,
        /// lower end of its interval at this dose alone
        ci_low: f64 = UNIT_OF_ROW,
        /// upper end of its interval at this dose alone
        ci_high: f64 = UNIT_OF_ROW,
        /// lower end of the band that covers the whole curve; null below 6 participants
        band_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of that band
        band_high: Option<f64> = UNIT_OF_ROW,
    }

    /// The slope over a dose by a mixed model with everybody's own line and their own level at each dose.
    DoseModel = "trend_models", "Mixed model of doses (for comparison)" {
        /// what is compared
        metric: MetricId,
        /// unit of the metric
        unit: Arc<str>,
        /// what was rendered; null over several environments
        environment: Option<EnvironmentId>,
        /// of which factor
        effect: Term,
        /// what the slope is over
        levels: EffectLevels,
        /// participants
        n: Option<usize>,
        /// trials
        trials: usize,
        /// mean slope
        slope: Option<f64> = UNIT_OF_ROW,
        /// its standard error
        slope_std_error: Option<f64> = UNIT_OF_ROW,
        /// lower end of its interval
        slope_ci_low: Option<f64> = UNIT_OF_ROW,
        /// upper end of its interval
        slope_ci_high: Option<f64> = UNIT_OF_ROW,
        /// degrees of freedom (Kenward–Roger)
        df: Option<f64>,
        /// p value of no slope, no claim
        p_value: Option<f64>,
        /// whether a variance was estimated as zero (pooled at the bound)
        singular: Option<bool>,
        /// why there is no test
        remark: Option<Sentence>,
    }

    /// The analysis of variance of a factor or an interaction, within participants.
    FactorTest = "anova", "Analysis of variance of factors" {
        /// what is compared
        metric: MetricId,
        /// unit of the metric
        unit: Arc<str>,
        /// what was rendered; null over several environments
        environment: Option<EnvironmentId>,
        /// of which factor, or of which several
        effect: Term,
        /// participants with every condition
        n: usize,
        /// F statistic
        f: f64,
        /// degrees of freedom of the effect
        df_effect: f64,
        /// degrees of freedom of its error
        df_error: f64,
        /// p value, under sphericity
        p_f: f64,
        /// Greenhouse and Geisser's ε
        epsilon_gg: f64,
        /// p value with degrees of freedom times ε
        p_gg: f64,
        /// partial η²: the effect's sum of squares over that and its error's
        eta_squared_partial: f64,
        /// of a dose: Hotelling's F of what its line, or its parabola, leaves
        f_lack_of_fit: Option<f64>,
        /// its degrees of freedom
        df_lack_of_fit: Option<f64>,
        /// its degrees of freedom for error
        df_lack_of_fit_error: Option<f64>,
        /// its p value
        p_lack_of_fit: Option<f64>,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_are_read_back_as_they_are_shown() {
        for text in [
            "yes − no",
            "(yes − no) × (soft − stiff)",
            "per 100 N/m",
            "bend per (100 N/m)²",
            "(per doubling) × (yes − no)",
        ] {
            let levels: EffectLevels = text.parse().unwrap();
            assert_eq!(levels.to_string(), text);
        }
        assert!("yes".parse::<EffectLevels>().is_err());
        for text in
            ["motor: yes − no", "motor × brake: (yes − no) × (soft − stiff)", "contrast wall_costs"]
        {
            let effect: FactorEffect = text.parse().unwrap();
            assert_eq!(effect.to_string(), text);
        }
    }
}
