//! The pointwise mean of repeats on a common grid, with its band.

use crate::error::{StatsError, all_finite, check_level};
use crate::student_t::critical_value;
use zwidth_numerics::moments::Moments;

/// Mean, SD and pointwise t band of repeats, one entry per grid point. Units as the values.
///
/// Where fewer than half of the repeats have a value all four are `None`: the average ends there.
/// Where only one has (of one or two repeats) there is a mean without SD or band.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Band {
    /// Repeats that have a value here, even if they are too few.
    pub n: Vec<usize>,
    /// Mean over the repeats present.
    pub mean: Vec<Option<f64>>,
    /// Their sample standard deviation (divisor n − 1).
    pub sd: Vec<Option<f64>>,
    /// Lower end of the mean's t interval, df = n − 1. Pointwise: it covers each point, not the
    /// whole curve.
    pub ci_low: Vec<Option<f64>>,
    /// Upper end of the mean's t interval.
    pub ci_high: Vec<Option<f64>>,
}

/// The [`Band`] of `rows` (one per repeat, each as long as the grid, `None` where the repeat has
/// ended or has no value) at confidence `level`.
///
/// # Errors
/// Rows of different length, a value that is not finite (its index is that of the grid point),
/// `level` outside (0, 1).
pub fn band(rows: &[Vec<Option<f64>>], level: f64) -> Result<Band, StatsError> {
    let points = rows.first().map_or(0, Vec::len);
    if let Some(row) = rows.iter().position(|r| r.len() != points) {
        return Err(StatsError::Ragged { row, expected: points, found: rows[row].len() });
    }
    check_level(level)?;
    // t(level, n − 1) / √n for each n, once for all points; `None` below two values.
    let critical: Vec<Option<f64>> = (0..=rows.len())
        .map(|n| match n {
            0 | 1 => Ok(None),
            _ => Ok(Some(critical_value(level, (n - 1) as f64)? / (n as f64).sqrt())),
        })
        .collect::<Result<_, StatsError>>()?;
    let mut band = Band::default();
    let mut here = Vec::with_capacity(rows.len());
    for point in 0..points {
        here.clear();
        here.extend(rows.iter().filter_map(|row| row[point]));
        // The index of the grid point, not that among the values here.
        all_finite(&here).map_err(|error| match error {
            StatsError::NonFinite { value, .. } => StatsError::NonFinite { index: point, value },
            other => other,
        })?;
        let n = here.len();
        let moments = (n > 0 && 2 * n >= rows.len()).then(|| Moments::of(&here));
        let mean = moments.map(|moments| moments.mean);
        let sd = moments.and_then(|moments| moments.sd());
        let half = sd.zip(critical[n]).map(|(sd, factor)| sd * factor);
        band.n.push(n);
        band.mean.push(mean);
        band.sd.push(sd);
        band.ci_low.push(mean.zip(half).map(|(m, h)| m - h));
        band.ci_high.push(mean.zip(half).map(|(m, h)| m + h));
    }
    Ok(band)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::mean;

    #[test]
    fn each_point_is_the_mean_and_interval_of_its_repeats() {
        let rows =
            vec![vec![Some(1.0), Some(4.0)], vec![Some(2.0), None], vec![Some(4.5), Some(6.0)]];
        let band = band(&rows, 0.9).unwrap();
        for (point, values) in [(0, vec![1.0, 2.0, 4.5]), (1, vec![4.0, 6.0])] {
            let alone = mean(&values, 0.9).unwrap();
            assert_eq!(
                (band.n[point], band.mean[point], band.sd[point]),
                (alone.n, alone.estimate, alone.sd)
            );
            let (low, high) = (band.ci_low[point].unwrap(), band.ci_high[point].unwrap());
            assert!((low - alone.interval.unwrap().ci_low).abs() < 1e-14);
            assert!((high - alone.interval.unwrap().ci_high).abs() < 1e-14);
        }
    }

    #[test]
    fn the_average_ends_where_fewer_than_half_of_the_repeats_remain() {
        let lengths = [4, 3, 2, 1, 1];
        let rows: Vec<_> =
            lengths.iter().map(|&l| (0..4).map(|i| (i < l).then_some(1.0)).collect()).collect();
        let band = band(&rows, 0.95).unwrap();
        assert_eq!(band.n, [5, 3, 2, 1]);
        assert_eq!(band.mean, [Some(1.0), Some(1.0), None, None]);
        assert_eq!(band.ci_high, [Some(1.0), Some(1.0), None, None]);
    }

    #[test]
    fn a_single_repeat_has_no_band() {
        let band = band(&[vec![Some(3.0), None]], 0.95).unwrap();
        assert_eq!(
            (band.mean, band.sd, band.ci_low),
            (vec![Some(3.0), None], vec![None; 2], vec![None; 2])
        );
    }

    #[test]
    fn ragged_rows_and_nan_are_refused_with_their_place() {
        let ragged = band(&[vec![None; 3], vec![None; 2]], 0.95);
        assert_eq!(ragged, Err(StatsError::Ragged { row: 1, expected: 3, found: 2 }));
        let nan = band(&[vec![Some(1.0), Some(f64::NAN)]], 0.95);
        assert!(matches!(nan, Err(StatsError::NonFinite { index: 1, .. })));
        assert_eq!(band(&[], 0.95).unwrap(), Band::default());
    }
}
