//! Contrasts between modes: one row per environment and contrast.

use crate::cells::Cells;
use crate::differences::{Difference, of_everybody};
use crate::measure::Measure;
use crate::orders::{NoTest, SharpNull};
use crate::{CompareError, Parameters};
use zwidth_results::{ModeDifference, Size, UnitOfAnalysis, Verdict};
use zwidth_stats::effect;
use zwidth_stats::null::Sampling;
use zwidth_stats::paired;
use zwidth_stats::sharp_null::Randomised;
use zwidth_stats::{StatsError, Tested, Unestimable, holm, sign_flip, signed_rank};
use zwidth_study::{Contrast, EffectSize, Families};

/// Flips that are drawn where there are too many participants to count all.
const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// One contrast in one environment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// Index among the study's environments.
    pub(crate) environment: usize,
    /// What is compared.
    pub(crate) contrast: Contrast,
    /// What n counts.
    pub(crate) unit: UnitOfAnalysis,
    /// Everybody's differences.
    pub(crate) differences: Vec<Difference>,
    /// Their mean with its test, or why there is none.
    pub(crate) tested: Result<Tested, Unestimable>,
    /// The test by randomisation over orders, or why there is none.
    pub(crate) sharp_null: Result<Randomised, NoTest>,
    /// The just noticeable difference, in the metric's unit, where it is known.
    pub(crate) jnd: Option<f64>,
    /// How many claims are adjusted together with that of this contrast, itself among them.
    pub(crate) claims: usize,
    /// The p value of the claim, adjusted for the other contrasts of the family.
    pub(crate) p_adjusted: Option<f64>,
    /// The smallest that it can be, where the test counts orders.
    pub(crate) smallest_p_adjusted: Option<f64>,
    /// The p value of "the difference is not within the bound", where there is a bound.
    pub(crate) p_not_equivalent: Option<f64>,
    /// The verdict of these two.
    pub(crate) verdict: Verdict,
}

impl Row {
    /// The number of units that the contrast rests on: participants, or one participant's trials.
    pub(crate) fn n(&self) -> usize {
        match self.unit {
            UnitOfAnalysis::Participants => self.differences.len(),
            UnitOfAnalysis::TrialsOf(_) => self.differences.iter().flat_map(|d| d.trials).sum(),
        }
    }

    /// The p value that a claim rests on, before it is adjusted: that of the participants'
    /// differences; with one participant, that of the sharp null.
    fn p_of_claim(&self) -> Option<f64> {
        match self.unit {
            UnitOfAnalysis::Participants => self.tested.as_ref().ok().map(|tested| tested.p_value),
            UnitOfAnalysis::TrialsOf(_) => self.sharp_null.as_ref().ok().map(|test| test.p_value),
        }
    }

    /// The smallest p value that the design's orders reach, where the claim rests on them.
    fn smallest_p(&self) -> Option<f64> {
        let test = self.sharp_null.as_ref().ok()?;
        (self.unit != UnitOfAnalysis::Participants).then_some(test.smallest_p)
    }

    /// The smallest adjusted p value, where it is not below `alpha`: no claim can be made.
    pub(crate) fn out_of_reach(&self, alpha: f64) -> Option<f64> {
        self.smallest_p_adjusted.filter(|p| *p >= alpha)
    }

    /// Why there is no test, or no claim can be made.
    fn remark(&self, alpha: f64) -> Option<String> {
        if self.verdict != Verdict::NotTested {
            let undecided = self.verdict == Verdict::Undecided;
            let smallest = self.out_of_reach(alpha).filter(|_| undecided)?;
            return Some(format!(
                "the design's orders reach an adjusted p of {smallest:.4} at best"
            ));
        }
        match self.unit {
            UnitOfAnalysis::Participants => self.tested.as_ref().err().map(ToString::to_string),
            UnitOfAnalysis::TrialsOf(_) => self.sharp_null.as_ref().err().map(ToString::to_string),
        }
    }

    /// The mean difference over participants; 0 where it is only the rounding of their means.
    fn estimate(&self) -> f64 {
        let all = self.differences.iter().map(|d| d.estimate);
        let mean = all.sum::<f64>() / self.differences.len() as f64;
        if paired::is_rounding(mean, &self.pairs()) { 0.0 } else { mean }
    }

    /// The mean over participants in the one mode (0) or in the other (1).
    fn mean(&self, side: usize) -> f64 {
        let all = self.differences.iter().map(|d| d.means[side]);
        all.sum::<f64>() / self.differences.len() as f64
    }

    /// Everybody's means in the two modes.
    fn pairs(&self) -> Vec<[f64; 2]> {
        self.differences.iter().map(|d| d.means).collect()
    }

    /// An end of the interval, or the estimate, in just noticeable differences.
    fn in_jnds(&self, value: fn(&Tested) -> f64) -> Option<f64> {
        self.tested.as_ref().ok().map(value).zip(self.jnd).map(|(value, jnd)| value / jnd)
    }

    /// Whether the difference is felt, by its interval: a description, no claim.
    fn size(&self) -> Option<Size> {
        let low = self.in_jnds(|t| t.ci_low)?;
        let high = self.in_jnds(|t| t.ci_high)?;
        Some(match () {
            () if low > 1.0 || high < -1.0 => Size::Felt,
            () if low > -1.0 && high < 1.0 => Size::BelowWhatIsFelt,
            () => Size::MayBeFelt,
        })
    }

    /// The number of differences that are exactly zero. Neither exact test counts them.
    pub(crate) fn zeros(&self) -> usize {
        paired::differences(&self.pairs()).iter().filter(|d| d.abs() <= 0.0).count()
    }
}

/// Every contrast of every environment that somebody has, tested, without a verdict.
pub(crate) fn rows(
    cells: &Cells,
    orders: &[SharpNull],
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Vec<Row>, CompareError> {
    let mut rows = Vec::new();
    for (environment, orders) in orders.iter().enumerate() {
        for (contrast, null) in parameters.contrasts.iter().zip(&orders.contrasts) {
            let Some(modes) = parameters.modes_of(contrast) else { continue };
            let differences = of_everybody(cells, environment, modes, parameters.level);
            if !differences.is_empty() {
                let row = row(environment, contrast, differences, null, unit, measure, parameters)?;
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

fn row(
    environment: usize,
    contrast: &Contrast,
    differences: Vec<Difference>,
    sharp_null: &Result<Randomised, NoTest>,
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Row, StatsError> {
    let tested = match unit {
        UnitOfAnalysis::Participants => {
            let pairs: Vec<[f64; 2]> = differences.iter().map(|d| d.means).collect();
            paired::mean_difference(&paired::differences(&pairs), parameters.level)
        }
        // There is one participant, so the one difference is theirs.
        UnitOfAnalysis::TrialsOf(_) => differences[0].within.clone(),
    };
    let equivalence = tested.as_ref().ok().zip(measure.parameters.bounds[environment]);
    let equivalence = equivalence
        .map(|(tested, bound)| paired::equivalence(tested, bound, parameters.alpha))
        .transpose()?;
    let mut row = Row {
        environment,
        contrast: contrast.clone(),
        unit: unit.clone(),
        differences,
        tested,
        sharp_null: sharp_null.clone(),
        jnd: None,
        claims: 0,
        p_adjusted: None,
        smallest_p_adjusted: None,
        p_not_equivalent: equivalence.map(|e| e.p_value()),
        verdict: Verdict::NotTested,
    };
    let noticed = measure.parameters.noticed.as_ref();
    // Most JNDs are a share of the value: of the second mode's, with which the first is compared.
    row.jnd = noticed.and_then(|n| n.jnd(environment, row.mean(1), &measure.unit));
    Ok(row)
}

/// Judges the contrasts of metrics whose claims belong together, or of one metric: p values are adjusted (Holm)
/// family by family.
pub(crate) fn judge(mut rows: Vec<&mut Row>, parameters: &Parameters) -> Result<(), StatsError> {
    // The rows of a metric stand environment by environment, so each chunk is a whole family.
    let whole = parameters.families != Families::Environment;
    for family in rows.chunk_by_mut(|a, b| whole || a.environment == b.environment) {
        adjust(family, parameters.alpha)?;
    }
    Ok(())
}

/// Adjusts the p values of one family, and the smallest that they can be.
fn adjust(rows: &mut [&mut Row], alpha: f64) -> Result<(), StatsError> {
    let claims: Vec<f64> = rows.iter().filter_map(|row| row.p_of_claim()).collect();
    let claims = holm::adjusted(&claims)?;
    // Adjusted as well: how far orders reach depends on the other claims of the family, of which those
    // that do not rest on orders can have any p.
    let with_claim = rows.iter().filter(|row| row.p_of_claim().is_some());
    let smallest: Vec<f64> = with_claim.map(|row| row.smallest_p().unwrap_or(0.0)).collect();
    let smallest = holm::adjusted(&smallest)?;
    let with_claim = rows.iter_mut().filter(|row| row.p_of_claim().is_some());
    let together = claims.len();
    for ((row, p), smallest) in with_claim.zip(claims).zip(smallest) {
        row.claims = together;
        row.p_adjusted = Some(p);
        row.verdict = match paired::Verdict::new(p, row.p_not_equivalent, alpha) {
            paired::Verdict::Different => Verdict::Different,
            paired::Verdict::DifferentBelowBound => Verdict::DifferentBelowBound,
            paired::Verdict::Equivalent => Verdict::Equivalent,
            paired::Verdict::Undecided => Verdict::Undecided,
        };
        row.smallest_p_adjusted = row.smallest_p().map(|_| smallest);
    }
    Ok(())
}

/// The contrasts by the names of what they compare.
pub(crate) fn named(
    rows: &[Row],
    unit: &UnitOfAnalysis,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<ModeDifference> {
    let of_people = *unit == UnitOfAnalysis::Participants;
    // Effect sizes are scaled by the spread of people, which one participant's trials do not have.
    let sizes = if of_people { parameters.effect_sizes.as_slice() } else { &[] };
    let (g_av, d_av) = (sizes.contains(&EffectSize::GAv), sizes.contains(&EffectSize::DAv));
    let (g_z, d_z) = (sizes.contains(&EffectSize::GZ), sizes.contains(&EffectSize::DZ));
    let noticed = measure.parameters.noticed.as_ref();
    let named = rows.iter().map(|row| {
        let tested = row.tested.as_ref().ok();
        let by_t = tested.filter(|_| of_people);
        let pairs = row.pairs();
        let level = parameters.level;
        let av = effect::d_av(&pairs, level).ok().filter(|_| g_av || d_av);
        let z = effect::d_z(&pairs, level).ok().filter(|_| g_z || d_z);
        let differences = paired::differences(&pairs);
        let sign_flip = sign_flip::test(&differences, SAMPLING).ok().filter(|_| of_people);
        let signed_rank = signed_rank::test(&differences).ok().filter(|_| of_people);
        let av_ends = av.as_ref().and_then(|effect| effect.interval);
        let z_ends = z.as_ref().and_then(|effect| effect.interval);
        ModeDifference {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: parameters.environments[row.environment].clone(),
            contrast: row.contrast.clone(),
            unit_of_analysis: unit.clone(),
            n: row.n(),
            sessions: row.differences.iter().map(|d| d.sessions).max(),
            mean_first: row.mean(0),
            mean_second: row.mean(1),
            difference: row.estimate(),
            difference_std_error: tested.map(|t| t.std_error),
            difference_ci_low: tested.map(|t| t.ci_low),
            difference_ci_high: tested.map(|t| t.ci_high),
            statistic: by_t.map(|t| t.statistic),
            df: tested.map(|t| t.df),
            p_value: by_t.map(|t| t.p_value),
            p_adjusted: row.p_adjusted,
            smallest_p_adjusted: row.smallest_p_adjusted,
            g_av: av.as_ref().and_then(|e| e.g).filter(|_| g_av),
            d_av: av.as_ref().map(|e| e.d).filter(|_| d_av),
            d_av_ci_low: av_ends.map(|ends| ends[0]),
            d_av_ci_high: av_ends.map(|ends| ends[1]),
            g_z: z.as_ref().and_then(|e| e.g).filter(|_| g_z),
            d_z: z.as_ref().map(|e| e.d).filter(|_| d_z),
            d_z_ci_low: z_ends.map(|ends| ends[0]),
            d_z_ci_high: z_ends.map(|ends| ends[1]),
            p_sign_flip: sign_flip.map(|test| test.p_value),
            p_signed_rank: signed_rank.map(|test| test.p_value),
            p_sharp_null: row.sharp_null.as_ref().ok().map(|test| test.p_value),
            commanded: noticed.and_then(|n| n.commanded[row.environment]),
            jnd: row.jnd,
            difference_jnd: row.jnd.map(|jnd| row.estimate() / jnd),
            difference_jnd_ci_low: row.in_jnds(|t| t.ci_low),
            difference_jnd_ci_high: row.in_jnds(|t| t.ci_high),
            size: row.size(),
            bound: measure.parameters.bounds[row.environment],
            p_not_equivalent: row.p_not_equivalent,
            verdict: row.verdict,
            remark: row.remark(parameters.alpha).map(Into::into),
        }
    });
    named.collect()
}
