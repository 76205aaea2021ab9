//! Contrasts between modes: one row per environment and contrast.

use crate::cells::{Cells, whole};
use crate::differences::{Difference, of_everybody};
use crate::measure::Measure;
use crate::orders::{NoTest, SharpNull};
use crate::together::CONTRASTS;
use crate::unit::Unit;
use crate::{CompareError, Parameters, columns};
use zwidth_stats::null::Sampling;
use zwidth_stats::paired::{self, Verdict};
use zwidth_stats::sharp_null::Randomised;
use zwidth_stats::{StatsError, Tested, Unestimable, holm, sign_flip, signed_rank};
use zwidth_study::{Contrast, Families};
use zwidth_tables::{Column, Table};

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

    /// What the tests show, in words; why there is none.
    fn verdict_in_words(&self, unit: &Unit, alpha: f64) -> Option<String> {
        if let Some(verdict) = self.verdict {
            let smallest = self.out_of_reach(alpha).filter(|_| verdict == Verdict::Undecided);
            let reached = smallest
                .map(|p| format!(": the design's orders reach an adjusted p of {p:.4} at best"));
            return Some(format!("{}{}", verdict.words(), reached.unwrap_or_default()));
        }
        let why = match unit {
            Unit::Participants => self.tested.as_ref().err().map(ToString::to_string),
            Unit::Trials { .. } => self.sharp_null.as_ref().err().map(ToString::to_string),
        };
        why.map(|why| format!("no test: {why}"))
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
    parameters: &Parameters,
) -> Result<Vec<Row>, CompareError> {
    let mut rows = Vec::new();
    for (environment, orders) in orders.iter().enumerate() {
        for (contrast, sharp_null) in parameters.contrasts.iter().zip(&orders.contrasts) {
            let Some(modes) = parameters.modes_of(contrast) else { continue };
            let differences = of_everybody(cells, environment, modes, parameters.level);
            if !differences.is_empty() {
                let test = sharp_null.clone();
                rows.push(row(environment, contrast, differences, test, unit, parameters)?);
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
        all.push(number(
            "d_av",
            "difference over the root mean of the modes' variances between participants",
            rows.iter().map(|row| paired::d_av(&row.pairs()).ok()).collect(),
        ));
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
    let verdicts = rows.iter().map(|row| row.verdict_in_words(unit, parameters.alpha));
    all.push(Column::text("verdict", "what the tests show", verdicts));
    let title = format!("Modes compared: {}", measure.description);
    Ok(Table::new(&[CONTRASTS, &measure.name].concat(), &title, all)?)
}
