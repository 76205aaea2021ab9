//! What a posterior on a grid says of one number.

/// A number by its posterior.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Marginal {
    /// Its mean.
    pub mean: f64,
    /// Lower end of the interval with equal tails.
    pub ci_low: f64,
    /// Upper end.
    pub ci_high: f64,
}

/// The mean and the interval of values with masses that sum to 1: half of a value's mass lies on either side of it, and
/// ends between values are on a straight line.
pub(super) fn marginal(mut values: Vec<[f64; 2]>, confidence: f64) -> Marginal {
    values.sort_by(|a, b| a[0].total_cmp(&b[0]));
    values.dedup_by(|later, first| {
        let is_same = later[0].total_cmp(&first[0]).is_eq();
        if is_same {
            first[1] += later[1];
        }
        is_same
    });
    // From the lowest on: of levels that lie close together far from 0 the digits would be lost.
    let lowest = values.first().map_or(0.0, |[value, _]| *value);
    let above: f64 = values.iter().map(|[value, mass]| (value - lowest) * mass).sum();
    let mean = lowest + above;
    let quantile = |share: f64| {
        let mut below = 0.0;
        let mut before: Option<[f64; 2]> = None;
        for [value, mass] in &values {
            let here = [*value, below + mass / 2.0];
            if here[1] >= share {
                return before.map_or(*value, |[last, at]| {
                    last + (value - last) * (share - at) / (here[1] - at)
                });
            }
            below += mass;
            before = Some(here);
        }
        before.map_or(0.0, |[value, _]| value)
    };
    let tail = (1.0 - confidence) / 2.0;
    Marginal { mean, ci_low: quantile(tail), ci_high: quantile(1.0 - tail) }
}
