//! Contrasts between modes: one row per environment and contrast.

use crate::cells::{Cells, whole};
use crate::differences::{Difference, of_everybody};
use crate::measure::Measure;
use crate::orders::{NoTest, SharpNull};
use crate::together::CONTRASTS;
use crate::unit::Unit;
use crate::{CompareError, Parameters, columns};
use zwidth_stats::effect::{self, Effect};
use zwidth_stats::null::Sampling;
use zwidth_stats::paired::{self, Verdict};
use zwidth_stats::sharp_null::Randomised;
use zwidth_stats::{StatsError, Tested, Unestimable, holm, sign_flip, signed_rank};
use zwidth_study::{Contrast, EffectSize, Families};
use zwidth_tables::{Column, Table};

/// The verdict of what has no test.
const NOT_TESTED: &str = "not tested";

/// Flips that are drawn where there are too many participants to count all.
const SAMPLING: Sampling = Sampling { draws: 9_999, seed: 1 };

/// One contrast in one environment.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// Index among the study's environments.
    pub(crate) environment: usize,
    /// What is compared.
    pub(crate) contrast: Contrast,
    /// Everybody's differences.
    pub(crate) differences: Vec<Difference>,
    /// Their mean with its test, or why there is none.
    pub(crate) tested: Result<Tested, Unestimable>,
    /// The test by randomisation over orders, or why there is none.
    pub(crate) sharp_null: Result<Randomised, NoTest>,
    /// The just noticeable difference, in the metric's unit, where it is known.
    pub(crate) jnd: Option<f64>,
    /// The p value of the claim, adjusted for the other contrasts of the family.
    pub(crate) p_adjusted: Option<f64>,
    /// The smallest that it can be, where the test counts orders.
    pub(crate) smallest_p_adjusted: Option<f64>,
    /// The p value of "the difference is not within the bound", where there is a bound.
    pub(crate) p_not_equivalent: Option<f64>,
    /// What these two say.
    pub(crate) verdict: Option<Verdict>,
}

impl Row {
    /// How many units the contrast rests on: participants, or one participant's trials.
    pub(crate) fn n(&self, unit: &Unit) -> usize {
        match unit {
            Unit::Participants => self.differences.len(),
            Unit::Trials { .. } => self.differences.iter().flat_map(|d| d.trials).sum(),
        }
    }

    /// The p value that a claim rests on, before it is adjusted: that of the participants'
    /// differences; with one participant, that of the sharp null.
    fn p_of_claim(&self, unit: &Unit) -> Option<f64> {
        match unit {
            Unit::Participants => self.tested.as_ref().ok().map(|tested| tested.p_value),
            Unit::Trials { .. } => self.sharp_null.as_ref().ok().map(|test| test.p_value),
        }
    }

    /// The smallest p value that the design's orders reach, where the claim rests on them.
    fn smallest_p(&self, unit: &Unit) -> Option<f64> {
        match unit {
            Unit::Participants => None,
            Unit::Trials { .. } => self.sharp_null.as_ref().ok().map(|test| test.smallest_p),
        }
    }

    /// The smallest adjusted p value, where it is not below `alpha`: no claim can be made.
    pub(crate) fn out_of_reach(&self, alpha: f64) -> Option<f64> {
        self.smallest_p_adjusted.filter(|p| *p >= alpha)
    }

    /// Why there is no test, or no claim can be made.
    fn remark(&self, unit: &Unit, alpha: f64) -> Option<String> {
        if let Some(verdict) = self.verdict {
            let smallest = self.out_of_reach(alpha).filter(|_| verdict == Verdict::Undecided)?;
            return Some(format!(
                "the design's orders reach an adjusted p of {smallest:.4} at best"
            ));
        }
        match unit {
            Unit::Participants => self.tested.as_ref().err().map(ToString::to_string),
            Unit::Trials { .. } => self.sharp_null.as_ref().err().map(ToString::to_string),
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
    fn in_jnds(&self, of: fn(&Tested) -> f64) -> Option<f64> {
        self.tested.as_ref().ok().map(of).zip(self.jnd).map(|(value, jnd)| value / jnd)
    }

    /// What the interval says of whether the difference is felt: a description, no claim.
    fn size_in_words(&self) -> Option<&'static str> {
        let (low, high) = (self.in_jnds(|t| t.ci_low)?, self.in_jnds(|t| t.ci_high)?);
        Some(match () {
            () if low > 1.0 || high < -1.0 => "felt",
            () if low > -1.0 && high < 1.0 => "below what is felt",
            () => "may be felt",
        })
    }

    /// How many differences are exactly zero. Neither exact test counts them.
    pub(crate) fn zeros(&self) -> usize {
        paired::differences(&self.pairs()).iter().filter(|d| d.abs() <= 0.0).count()
    }

    fn p_sign_flip(&self) -> Option<f64> {
        let differences = paired::differences(&self.pairs());
        sign_flip::test(&differences, SAMPLING).ok().map(|test| test.p_value)
    }

    fn p_signed_rank(&self) -> Option<f64> {
        let differences = paired::differences(&self.pairs());
        signed_rank::test(&differences).ok().map(|test| test.p_value)
    }
}

/// Every contrast of every environment that somebody has, tested, with p values adjusted (Holm)
/// family by family.
pub(crate) fn rows(
    cells: &Cells,
    orders: &[SharpNull],
    unit: &Unit,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Vec<Row>, CompareError> {
    let mut rows = Vec::new();
    for (environment, orders) in orders.iter().enumerate() {
        for (contrast, sharp_null) in parameters.contrasts.iter().zip(&orders.contrasts) {
            let Some(modes) = parameters.modes_of(contrast) else { continue };
            let differences = of_everybody(cells, environment, modes, parameters.level);
            if !differences.is_empty() {
                let test = sharp_null.clone();
                let row = row(environment, contrast, differences, test, unit, parameters)?;
                let noticed = parameters.noticed.as_ref();
                let jnd = noticed.and_then(|n| n.jnd(environment, row.mean(1), &measure.unit));
                rows.push(Row { jnd, ..row });
            }
        }
    }
    let whole = parameters.families == Families::Metric;
    for family in rows.chunk_by_mut(|a, b| whole || a.environment == b.environment) {
        adjust(family, unit, parameters.alpha)?;
    }
    Ok(rows)
}

fn row(
    environment: usize,
    contrast: &Contrast,
    differences: Vec<Difference>,
    sharp_null: Result<Randomised, NoTest>,
    unit: &Unit,
    parameters: &Parameters,
) -> Result<Row, StatsError> {
    let tested = match unit {
        Unit::Participants => {
            let pairs: Vec<[f64; 2]> = differences.iter().map(|d| d.means).collect();
            paired::mean_difference(&paired::differences(&pairs), parameters.level)
        }
        Unit::Trials { .. } => differences[0].within.clone(),
    };
    let equivalence = tested.as_ref().ok().zip(parameters.bounds[environment]);
    let equivalence = equivalence
        .map(|(tested, bound)| paired::equivalence(tested, bound, parameters.alpha))
        .transpose()?;
    Ok(Row {
        environment,
        contrast: contrast.clone(),
        differences,
        tested,
        sharp_null,
        jnd: None,
        p_adjusted: None,
        smallest_p_adjusted: None,
        p_not_equivalent: equivalence.map(|e| e.p_value()),
        verdict: None,
    })
}

/// Adjusts the p values of one family, and the smallest that they can be.
fn adjust(rows: &mut [Row], unit: &Unit, alpha: f64) -> Result<(), StatsError> {
    let adjusted = |p: fn(&Row, &Unit) -> Option<f64>| {
        holm::adjusted(&rows.iter().filter_map(|row| p(row, unit)).collect::<Vec<_>>())
    };
    let (claims, smallest) = (adjusted(Row::p_of_claim)?, adjusted(Row::smallest_p)?);
    let with_claim = rows.iter_mut().filter(|row| row.p_of_claim(unit).is_some());
    for (row, p) in with_claim.zip(claims) {
        row.p_adjusted = Some(p);
        row.verdict = Some(Verdict::new(p, row.p_not_equivalent, alpha));
    }
    let with_smallest = rows.iter_mut().filter(|row| row.smallest_p(unit).is_some());
    for (row, p) in with_smallest.zip(smallest) {
        row.smallest_p_adjusted = Some(p);
    }
    Ok(())
}

/// The contrasts as a table.
pub(crate) fn table(
    rows: &[Row],
    unit: &Unit,
    measure: &Measure,
    parameters: &Parameters,
) -> Result<Table, CompareError> {
    let tested = |of: fn(&Tested) -> f64| {
        rows.iter().map(move |row| row.tested.as_ref().ok().map(of)).collect::<Vec<_>>()
    };
    let sessions = rows.iter().map(|row| row.differences.iter().map(|d| d.sessions).max());
    let number =
        |name, description, values: Vec<Option<f64>>| Column::float(name, "1", description, values);

    let mut all = vec![
        columns::environments(parameters, rows.iter().map(|row| row.environment)),
        columns::contrasts(rows.iter().map(|row| &row.contrast)),
        columns::units(unit, rows.len()),
        Column::integer("n", "1", "units of analysis", rows.iter().map(|row| whole(row.n(unit)))),
        Column::integer(
            "sessions",
            "1",
            "sessions per participant, at most",
            sessions.map(|sessions| sessions.and_then(whole)),
        ),
        measure.column(
            "mean_first",
            "mean in the contrast's first mode",
            rows.iter().map(|row| Some(row.mean(0))),
        ),
        measure.column(
            "mean_second",
            "mean in the contrast's second mode",
            rows.iter().map(|row| Some(row.mean(1))),
        ),
        measure.column(
            "difference",
            "mean difference",
            rows.iter().map(|row| Some(row.estimate())),
        ),
        measure.column("difference_std_error", "its standard error", tested(|t| t.std_error)),
        measure.column("difference_ci_low", "lower end of its interval", tested(|t| t.ci_low)),
        measure.column("difference_ci_high", "upper end of its interval", tested(|t| t.ci_high)),
    ];
    let sharp_null = number(
        "p_sharp_null",
        "p value of no trial depending on mode (randomisation over orders), not adjusted",
        rows.iter().map(|row| row.sharp_null.as_ref().ok().map(|test| test.p_value)).collect(),
    );
    let adjusted = |description| {
        number("p_adjusted", description, rows.iter().map(|row| row.p_adjusted).collect())
    };
    if let Unit::Trials { .. } = unit {
        all.push(number("df", "degrees of freedom of the interval", tested(|t| t.df)));
        all.push(sharp_null);
        all.push(adjusted("that of no trial depending on mode, adjusted over its family by Holm"));
        all.push(number(
            "smallest_p_adjusted",
            "the smallest adjusted p value that the design's orders reach",
            rows.iter().map(|row| row.smallest_p_adjusted).collect(),
        ));
    } else {
        all.push(number("statistic", "t statistic", tested(|t| t.statistic)));
        all.push(number("df", "degrees of freedom", tested(|t| t.df)));
        all.push(number("p_value", "p value of no difference", tested(|t| t.p_value)));
        all.push(adjusted("the same, adjusted over its family by Holm"));
        all.extend(effect_columns(rows, parameters));
        all.push(number(
            "p_sign_flip",
            "p value of the sign-flip test, not adjusted",
            rows.iter().map(Row::p_sign_flip).collect(),
        ));
        all.push(number(
            "p_signed_rank",
            "p value of the signed-rank test, not adjusted",
            rows.iter().map(Row::p_signed_rank).collect(),
        ));
        all.push(sharp_null);
    }
    if rows.iter().any(|row| row.jnd.is_some()) {
        let in_jnds = |of: fn(&Tested) -> f64| rows.iter().map(|row| row.in_jnds(of)).collect();
        let jnds = rows.iter().map(|row| row.jnd);
        let noticed = parameters.noticed.as_ref();
        if noticed.is_some_and(|noticed| noticed.commanded.iter().any(Option::is_some)) {
            let commanded =
                rows.iter().map(|row| noticed.and_then(|n| n.commanded[row.environment]));
            all.push(measure.column("commanded", "value that the environment commands", commanded));
        }
        all.push(measure.column("jnd", "difference that is just noticed", jnds));
        all.extend([
            number(
                "difference_jnd",
                "difference over the one that is just noticed",
                rows.iter().map(|row| row.jnd.map(|jnd| row.estimate() / jnd)).collect(),
            ),
            number("difference_jnd_ci_low", "lower end of its interval", in_jnds(|t| t.ci_low)),
            number("difference_jnd_ci_high", "upper end of its interval", in_jnds(|t| t.ci_high)),
            Column::text(
                "size",
                "whether the interval is of differences that are felt, no claim",
                rows.iter().map(Row::size_in_words),
            ),
        ]);
    }
    if parameters.bounds.iter().any(Option::is_some) {
        all.push(measure.column(
            "bound",
            "differences up to this size are equivalent",
            rows.iter().map(|row| parameters.bounds[row.environment]),
        ));
        all.push(number(
            "p_not_equivalent",
            "p value of a difference beyond the bound (TOST)",
            rows.iter().map(|row| row.p_not_equivalent).collect(),
        ));
    }
    let verdicts = rows.iter().map(|row| Some(row.verdict.map_or(NOT_TESTED, Verdict::words)));
    all.push(Column::text("verdict", "what the tests show", verdicts));
    let remarks = rows.iter().map(|row| row.remark(unit, parameters.alpha));
    all.push(Column::text("remark", "why there is no test, or no claim", remarks));
    let title = format!("Modes compared: {}", measure.description);
    Ok(Table::new(&[CONTRASTS, &measure.name].concat(), &title, all)?)
}

/// The effect sizes of a study, each with the interval of its d.
fn effect_columns(rows: &[Row], parameters: &Parameters) -> Vec<Column> {
    let effects = |of: fn(&[[f64; 2]], f64) -> Result<Effect, Unestimable>| -> Vec<Option<Effect>> {
        rows.iter().map(|row| of(&row.pairs(), parameters.level).ok()).collect()
    };
    let (z, av) = (effects(effect::d_z), effects(effect::d_av));
    const D_AV: &str = "difference over the root mean of the modes' variances between participants";
    const D_Z: &str = "difference over the standard deviation of participants' differences";
    let mut columns: Vec<Column> = Vec::new();
    for size in &parameters.effect_sizes {
        let (effects, ends, description) = match size {
            EffectSize::GAv => {
                (&av, ["d_av_ci_low", "d_av_ci_high"], "d_av without its bias where people are few")
            }
            EffectSize::DAv => (&av, ["d_av_ci_low", "d_av_ci_high"], D_AV),
            EffectSize::GZ => {
                (&z, ["d_z_ci_low", "d_z_ci_high"], "d_z without its bias where people are few")
            }
            EffectSize::DZ => (&z, ["d_z_ci_low", "d_z_ci_high"], D_Z),
        };
        let of: fn(&Effect) -> Option<f64> = match size {
            EffectSize::GAv | EffectSize::GZ => |effect| effect.g,
            EffectSize::DAv | EffectSize::DZ => |effect| Some(effect.d),
        };
        let estimates = effects.iter().map(|effect| effect.as_ref().and_then(of));
        columns.push(Column::float(size.as_str(), "1", description, estimates));
        if columns.iter().all(|column| column.field.name != ends[0]) {
            let interval = |effect: &Option<Effect>| effect.as_ref()?.interval;
            let [low, high] = [0, 1].map(|side| {
                effects.iter().map(move |effect| interval(effect).map(|ends| ends[side]))
            });
            columns.push(Column::float(ends[0], "1", "lower end of the interval of d", low));
            columns.push(Column::float(ends[1], "1", "upper end of the interval of d", high));
        }
    }
    columns
}
