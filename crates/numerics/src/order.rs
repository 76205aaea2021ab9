//! Medians and quantiles: values by their rank.
//!
//! NaN is beyond all numbers ([`f64::total_cmp`]): the caller checks the values before asking for a
//! rank.

/// The median: the middle value, or the mean of the two in the middle. Unit as the values; `None`
/// of none.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let sorted = sorted(values);
    let upper = *sorted.get(sorted.len() / 2)?;
    match sorted.len() % 2 {
        1 => Some(upper),
        _ => Some((sorted[sorted.len() / 2 - 1] + upper) / 2.0),
    }
}

/// The upper median: the middle value, or the larger of the two in the middle. Unit as the values;
/// `None` of none.
///
/// It is one of the values: an amplitude or an interval that occurred. The amplitudes of swings,
/// recorded and simulated, and the rates of sensors are stored by this definition; by [`median`]
/// every other of them would be another number.
pub fn upper_median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let sorted = sorted(values);
    sorted.get(sorted.len() / 2).copied()
}

/// The quantile of `sorted` values at `share` (from 0 to 1) of the way from the first to the last,
/// on straight lines between them: Hyndman & Fan (1996), Am. Stat. 50:361, definition 7, the default
/// of R and NumPy. Unit as the values; `None` of none.
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    quantile_by(sorted.len(), share, |rank| sorted.get(rank).copied())
}

/// [`quantile`] of this many values; a rule gives the value at each rank from 0 on. `None` also if
/// the rule has no value.
pub fn quantile_by(
    values: usize,
    share: f64,
    ranked: impl Fn(usize) -> Option<f64>,
) -> Option<f64> {
    let last = values.checked_sub(1)?;
    let place = share * last as f64;
    let below = place.floor() as usize;
    let low = ranked(below)?;
    let high = ranked((below + 1).min(last))?;
    Some(low + (place - below as f64) * (high - low))
}

/// The values in rising order.
pub fn sorted(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_an_odd_number_are_one_and_of_an_even_one_two() {
        assert_eq!(
            (median([3.0, 1.0, 2.0]), upper_median([3.0, 1.0, 2.0])),
            (Some(2.0), Some(2.0))
        );
        assert_eq!(
            (median([4.0, 1.0, 2.0, 9.0]), upper_median([4.0, 1.0, 2.0, 9.0])),
            (Some(3.0), Some(4.0))
        );
        assert_eq!((median([7.0]), upper_median([7.0])), (Some(7.0), Some(7.0)));
        assert_eq!((median([]), upper_median([])), (None, None));
    }

    #[test]
    fn a_quantile_lies_on_straight_lines_between_the_values() {
        let values = [1.0, 2.0, 4.0];
        let at = |share| quantile(&values, share).unwrap();
        assert!((at(0.5) - 2.0).abs() < 1e-15 && (at(0.9) - 3.6).abs() < 1e-12);
        assert!((at(0.0) - 1.0).abs() < 1e-15 && (at(1.0) - 4.0).abs() < 1e-15);
        assert_eq!((quantile(&[7.0], 0.9), quantile(&[], 0.5)), (Some(7.0), None));
    }

    /// NumPy: `np.quantile([-3, -1, 0, 0, 2, 3], [0.25, 0.5, 0.75])`.
    #[test]
    fn quartiles_are_those_of_numpy() {
        let values = [-3.0, -1.0, 0.0, 0.0, 2.0, 3.0];
        let quartiles = [0.25, 0.5, 0.75].map(|share| quantile(&values, share));
        assert_eq!(quartiles, [-0.75, 0.0, 1.5].map(Some));
    }
}
