//! The results: plain data, ready for a table.

use zwidth_results::{CandidateVerdict, CurveModel, FittedParameter};
use zwidth_stats::StatsError;
use zwidth_stats::bootstrap::{expanded_level, percentile_interval};

/// The settings of a characterisation.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Bootstrap resamples; 0 gives no intervals.
    pub resamples: usize,
    /// Seed of the bootstrap: part of the result.
    pub seed: u64,
    /// Confidence level of all intervals, such as 0.95.
    pub level: f64,
    /// Unit of the command, for parameters and verdicts.
    pub command_unit: String,
    /// Unit of the response.
    pub response_unit: String,
}

/// The response of an actuator or sensor to its command.
#[derive(Debug, Clone, PartialEq)]
pub struct Characteristic {
    /// Sweeps with samples in them.
    pub sweeps: usize,
    /// Samples in all sweeps.
    pub points: usize,
    /// Lowest command.
    pub command_min: f64,
    /// Highest command.
    pub command_max: f64,
    /// Scatter that no curve explains, unit of the response: pooled standard deviation of the
    /// response about local straight lines over the command, one for each run of five
    /// neighbouring samples of a sweep (√(Σ rss / Σ df)). `None` without a degree of freedom.
    pub noise: Option<f64>,
    /// What was left out in cross-validation, and drawn in the bootstrap: each `sweep`, or each
    /// contiguous `block` of the only one.
    pub grouping: &'static str,
    /// Number of them that were left out in turn.
    pub folds: usize,
    /// Every candidate, by number of free parameters; those with hysteresis only if the command
    /// went both ways.
    pub candidates: Vec<Candidate>,
    /// Index of the chosen one in `candidates`.
    pub chosen: usize,
    /// Why it was chosen, in one sentence.
    pub reason: String,
}

/// One candidate on these sweeps.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// The model.
    pub name: CurveModel,
    /// Its equation.
    pub formula: String,
    /// Number of parameters that are fitted.
    pub complexity: usize,
    /// The parameters, in the model's order; empty if it could not be fitted. An interval is
    /// widened to hold the estimate: next to a parameter at the edge of the data all resamples may
    /// lie to one side.
    pub parameters: Vec<FittedParameter>,
    /// How good the fit is; `None` if it could not be fitted.
    pub quality: Option<Quality>,
    /// Chosen or not.
    pub verdict: CandidateVerdict,
    /// Why, in words.
    pub reason: String,
    /// Mean squared error on each part left out of the fit, unit of the response squared; empty if
    /// it could not be fitted.
    pub left_out: Vec<f64>,
    /// Number of independent parts that the resamples drew: the sweeps; `None` for blocks of
    /// residuals.
    pub independent: Option<usize>,
    /// The parameters on each resample that could be fitted, in the model's order: what bands are
    /// drawn from.
    pub resampled: Vec<Vec<f64>>,
}

impl Candidate {
    /// The interval that `values`, one per resample, give at confidence `level`: between
    /// percentiles further out than the level says if few sweeps were drawn
    /// ([`expanded_level`](zwidth_stats::bootstrap::expanded_level)).
    ///
    /// # Errors
    /// A value that is not finite, `level` outside (0, 1).
    pub fn interval(&self, values: &[f64], level: f64) -> Result<Option<(f64, f64)>, StatsError> {
        let level = self.independent.map_or(Ok(level), |n| expanded_level(level, n))?;
        percentile_interval(values, level)
    }
}

/// How good a fit is. Errors are in the unit of the response.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    /// Degrees of freedom: samples less parameters.
    pub df: usize,
    /// √(Σ r² / n) over all samples.
    pub rms: f64,
    /// 1 − Σ r² / Σ (y − ȳ)²; `None` for a constant response.
    pub r2: Option<f64>,
    /// Root mean square error on what was left out.
    pub cv_rms: f64,
    /// Standard error of `cv_rms`, from the spread over what was left out.
    pub cv_std_error: f64,
    /// AICc of the residuals' means in at most 50 equal bins of the command: reported, not
    /// decisive.
    pub aicc: Option<f64>,
    /// First-order autocorrelation of the residuals, within sweeps, in the order of recording.
    pub autocorrelation: Option<f64>,
    /// `rms` over the noise; `None` without noise.
    pub rms_over_noise: Option<f64>,
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// N against V, at 95 %.
    pub(crate) fn settings(resamples: usize, seed: u64) -> Settings {
        let (command_unit, response_unit) = ("V".to_owned(), "N".to_owned());
        Settings { resamples, seed, level: 0.95, command_unit, response_unit }
    }
}
