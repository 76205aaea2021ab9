//! A linear fit to samples of one recording, with intervals.

use crate::MetricsError;
use zwidth_numerics::NumericsError;
use zwidth_numerics::lsq::{self, LinearFit};
use zwidth_stats::interval::Estimate;
use zwidth_stats::recording::recording_fit;

/// The fit of `y` on `columns` and its coefficients with their Newey–West intervals; `None` where
/// the samples cannot show them (too few, or columns that are alike).
pub(crate) fn estimates(
    columns: &[&[f64]],
    y: &[f64],
    level: f64,
) -> Result<Option<(LinearFit, Vec<Estimate>)>, MetricsError> {
    let fit = match lsq::fit(columns, y) {
        Err(NumericsError::TooFewRows { .. } | NumericsError::RankDeficient { .. }) => {
            return Ok(None);
        }
        fit => fit?,
    };
    let estimates = recording_fit(columns, &fit, level)?.estimates;
    Ok(Some((fit, estimates)))
}
