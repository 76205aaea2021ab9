//! Contrasts between modes: one row per environment and contrast.

use crate::cells::Cells;
use crate::claim::Claim;
use crate::differences::{Difference, of_everybody};
use crate::measure::Measure;
use crate::orders::{NoTest, SharpNull};
use crate::split::{Refused, Split, inflations};
use crate::{CompareError, Parameters};
use zwidth_results::{ModeDifference, Size, UnitOfAnalysis, Verdict};
use zwidth_stats::effect;
use zwidth_stats::groups::{self, group};
use zwidth_stats::null::Sampling;
use zwidth_stats::over_trials::WeighedCondition;
use zwidth_stats::paired;
use zwidth_stats::sharp_null::Randomised;
use zwidth_stats::welch::Group;
use zwidth_stats::{Tested, Unestimable, sign_flip, signed_rank};
use zwidth_study::{Contrast, EffectSize};

/// Flips that are drawn where there are too many participants to count all.
const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// One contrast in one environment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// What is compared.
    pub(crate) contrast: Contrast,
    /// What n counts.
    pub(crate) unit: UnitOfAnalysis,
    /// Everybody's differences.
    pub(crate) differences: Vec<Difference>,
    /// The groups that have the same weight, by places among the differences: one of everybody, unless
    /// groups are compared.
    members: Vec<Vec<usize>>,
    /// Their mean with its test, or why there is none.
    pub(crate) tested: Result<Tested, Unestimable>,
    /// The test by randomisation over orders, or why there is none.
    pub(crate) sharp_null: Result<Randomised, NoTest>,
    /// The just noticeable difference, in the metric's unit, where it is known.
    pub(crate) jnd: Option<f64>,
    /// How many times lines over trials make its variance larger, as [`inflations`] says.
    pub(crate) inflations: Vec<f64>,
    /// Why no claim is made.
    refused: Option<Refused>,
    /// Whether there is a difference.
    pub(crate) claim: Claim,
}

impl Row {
    /// The number of units that the contrast rests on: participants, or one participant's trials.
    pub(crate) fn n(&self) -> usize {
        match self.unit {
            UnitOfAnalysis::Participants => self.differences.len(),
            UnitOfAnalysis::TrialsOf(_) => self.differences.iter().flat_map(|d| d.trials).sum(),
        }
    }

    /// Why there is no test, or no claim can be made.
    fn remark(&self, alpha: f64) -> Option<String> {
        if let Some(refused) = &self.refused {
            return Some(refused.to_string());
        }
        if self.claim.verdict != Verdict::NotTested {
            let undecided = self.claim.verdict == Verdict::Undecided;
            let smallest = self.claim.out_of_reach(alpha).filter(|_| undecided)?;
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
        let mean = self.over_people(|d| d.estimate);
        if paired::is_rounding(mean, &self.pairs()) { 0.0 } else { mean }
    }

    /// The mean over participants in the one mode (0) or in the other (1).
    pub(crate) fn mean(&self, side: usize) -> f64 {
        self.over_people(|d| d.means[side])
    }

    /// The mean of a value of people, each group with the same weight.
    fn over_people(&self, value: impl Fn(&Difference) -> f64) -> f64 {
        let groups = self.members.iter().map(|members| {
            let all = members.iter().map(|place| value(&self.differences[*place]));
            all.sum::<f64>() / members.len() as f64
        });
        groups.sum::<f64>() / self.members.len() as f64
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
        Some(size([self.in_jnds(|t| t.ci_low)?, self.in_jnds(|t| t.ci_high)?]))
    }

    /// The number of differences that are exactly zero. Neither exact test counts them.
    pub(crate) fn zeros(&self) -> usize {
        paired::differences(&self.pairs()).iter().filter(|d| d.abs() <= 0.0).count()
    }
}

/// Whether a difference is felt, by its interval in just noticeable differences: a description, no claim.
pub(crate) fn size([low, high]: [f64; 2]) -> Size {
    match () {
        () if low > 1.0 || high < -1.0 => Size::Felt,
        () if low > -1.0 && high < 1.0 => Size::BelowWhatIsFelt,
        () => Size::MayBeFelt,
    }
}

/// Every contrast of every environment that somebody has, tested, without a verdict.
pub(crate) fn rows(
    cells: &Cells,
    orders: &[SharpNull],
    split: Option<&Split>,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Vec<Row>, CompareError> {
    let mut rows = Vec::new();
    for (environment, orders) in orders.iter().enumerate() {
        for (contrast, null) in parameters.contrasts.iter().zip(&orders.contrasts) {
            let Some(modes) = parameters.modes_of(contrast) else { continue };
            let mut differences = of_everybody(cells, environment, modes, parameters.level);
            // Of groups nobody speaks who has none.
            differences
                .retain(|one| split.is_none_or(|split| split.level(one.participant).is_some()));
            if differences.is_empty() {
                continue;
            }
            let unit = cells.unit();
            let pairs: Vec<[f64; 2]> = differences.iter().map(|d| d.means).collect();
            let members: Vec<Vec<usize>> = match split {
                None => vec![(0..differences.len()).collect()],
                Some(split) => split.by_level(
                    differences.iter().enumerate().map(|(place, one)| (one.participant, place)),
                ),
            };
            let members: Vec<Vec<usize>> =
                members.into_iter().filter(|group| !group.is_empty()).collect();
            let (tested, refused) = match (&unit, split) {
                (UnitOfAnalysis::Participants, None) => {
                    (paired::mean_difference(&paired::differences(&pairs), parameters.level), None)
                }
                (UnitOfAnalysis::Participants, Some(split)) => {
                    let plain = paired::differences(&pairs);
                    let of_group = |places: &Vec<usize>| {
                        group(&places.iter().map(|place| plain[*place]).collect::<Vec<_>>())
                    };
                    let groups: Vec<Group> = members.iter().map(of_group).collect();
                    let smallest = split.smallest(differences.iter().map(|one| one.participant));
                    let refused = smallest.and_then(|(n, id)| Refused::too_few(n, &id));
                    (groups::mean(&groups, parameters.level), refused)
                }
                // There is one participant, so the one difference is theirs.
                (UnitOfAnalysis::TrialsOf(_), _) => (differences[0].within.clone(), None),
            };
            let of_people = unit == UnitOfAnalysis::Participants;
            let weights = [1.0, -1.0].into_iter().zip(modes).map(|(weight, mode)| {
                WeighedCondition { session: None, environment, mode, weight }
            });
            let weights: Vec<_> = weights.collect();
            let people = differences.iter().map(|one| one.participant);
            let inflations = inflations(cells, split, people, &weights);
            let refused = refused.or_else(|| Refused::ordered(inflations.iter().copied()));
            // A claim rests on the p value of the participants' differences; with one participant, on that of the
            // sharp null, which the design's orders limit.
            let p = match of_people {
                true => {
                    tested.as_ref().ok().filter(|_| refused.is_none()).map(|tested| tested.p_value)
                }
                false => null.as_ref().ok().filter(|_| refused.is_none()).map(|test| test.p_value),
            };
            let smallest_p = null.as_ref().ok().filter(|_| !of_people).map(|test| test.smallest_p);
            let has_p = refused.as_ref().is_none_or(Refused::has_p);
            let bound = measure.parameters.bounds[environment].filter(|_| has_p);
            let equivalence = tested.as_ref().ok().zip(bound);
            let equivalence = equivalence
                .map(|(tested, bound)| paired::equivalence(tested, bound, parameters.alpha))
                .transpose()?;
            let p_not_equivalent = equivalence.map(|e| e.p_value());
            let mut row = Row {
                contrast: contrast.clone(),
                unit,
                differences,
                members,
                tested,
                sharp_null: null.clone(),
                jnd: None,
                inflations,
                refused,
                claim: Claim::new(environment, p, smallest_p, p_not_equivalent),
            };
            let noticed = measure.parameters.noticed.as_ref();
            // Most JNDs are a share of the value: of the second mode's, with which the first is compared.
            row.jnd = noticed.and_then(|n| n.jnd(Some(environment), row.mean(1), &measure.unit));
            rows.push(row);
        }
    }
    Ok(rows)
}

/// The contrasts by the names of what they compare.
pub(crate) fn named(
    rows: &[Row],
    unit: &UnitOfAnalysis,
    has_groups: bool,
    measure: &Measure,
    parameters: &Parameters,
) -> Vec<ModeDifference> {
    let of_people = *unit == UnitOfAnalysis::Participants;
    // Effect sizes are scaled by the spread of people, which one participant's trials do not have; where
    // groups are compared, by that of each group, as its own exact tests would be.
    let of_one_group = of_people && !has_groups;
    let sizes = if of_one_group { parameters.effect_sizes.as_slice() } else { &[] };
    let (g_av, d_av) = (sizes.contains(&EffectSize::GAv), sizes.contains(&EffectSize::DAv));
    let (g_z, d_z) = (sizes.contains(&EffectSize::GZ), sizes.contains(&EffectSize::DZ));
    let noticed = measure.parameters.noticed.as_ref();
    let named = rows.iter().map(|row| {
        let tested = row.tested.as_ref().ok();
        let has_p = of_people && row.refused.as_ref().is_none_or(Refused::has_p);
        let by_t = tested.filter(|_| has_p);
        let pairs = row.pairs();
        let level = parameters.level;
        let av = effect::d_av(&pairs, level).ok().filter(|_| g_av || d_av);
        let z = effect::d_z(&pairs, level).ok().filter(|_| g_z || d_z);
        let differences = paired::differences(&pairs);
        let sign_flip = sign_flip::test(&differences, SAMPLING).ok().filter(|_| of_one_group);
        let signed_rank = signed_rank::test(&differences).ok().filter(|_| of_one_group);
        let av_ends = av.as_ref().and_then(|effect| effect.interval);
        let z_ends = z.as_ref().and_then(|effect| effect.interval);
        ModeDifference {
            metric: measure.parameters.metric.clone(),
            unit: measure.unit.clone(),
            environment: parameters.environments[row.claim.environment].clone(),
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
            p_adjusted: row.claim.p_adjusted,
            smallest_p_adjusted: row.claim.smallest_p_adjusted,
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
            commanded: noticed.and_then(|n| n.commanded[row.claim.environment]),
            jnd: row.jnd,
            difference_jnd: row.jnd.map(|jnd| row.estimate() / jnd),
            difference_jnd_ci_low: row.in_jnds(|t| t.ci_low),
            difference_jnd_ci_high: row.in_jnds(|t| t.ci_high),
            size: row.size(),
            bound: measure.parameters.bounds[row.claim.environment],
            p_not_equivalent: row.claim.p_not_equivalent,
            verdict: row.claim.verdict,
            remark: row.remark(parameters.alpha).map(Into::into),
        }
    });
    named.collect()
}
