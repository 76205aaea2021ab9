//! Whether the trials determine a parameter.

use crate::Estimate;
use crate::estimate::on_bound;
use zwidth_results::Identifiability;

/// Above this variance inflation, 1/(1 − R²), the other parameters explain 99 % of what a parameter
/// does.
const MOST_INFLATION: f64 = 100.0;

/// The verdict of an estimate; `curvature` is its entry in JᵀJ.
pub(crate) fn verdict(estimate: &Estimate, curvature: f64) -> Identifiability {
    if curvature.is_nan() || curvature <= 0.0 {
        return Identifiability::Insensitive;
    }
    // Before the inflation, which is `None` for a parameter on its bound.
    if on_bound(&estimate.parameter, estimate.fitted) {
        return Identifiability::OnBound;
    }
    if estimate.inflation.is_none_or(|inflation| inflation > MOST_INFLATION) {
        return Identifiability::Confounded;
    }
    let Some((low, high)) = estimate.interval else { return Identifiability::Uncertain };
    if on_bound(&estimate.parameter, low) || on_bound(&estimate.parameter, high) {
        return Identifiability::Flat;
    }
    if high - low > 2.0 * estimate.fitted.abs() {
        Identifiability::Uncertain
    } else {
        Identifiability::Identifiable
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Parameter;
    use crate::testing::PARAMETERS;

    fn check(change: impl Fn(&mut Estimate), expect: Identifiability) {
        let mut estimate = Estimate {
            parameter: Parameter { lower: 0.0, ..PARAMETERS[0] },
            fitted: 2.0,
            std_error: Some(0.1),
            df: Some(5.0),
            interval: Some((1.8, 2.2)),
            inflation: Some(3.0),
            profile: Vec::new(),
            verdict: Identifiability::OnBound,
        };
        change(&mut estimate);
        assert_eq!(verdict(&estimate, 1.0), expect);
    }

    #[test]
    fn each_doubt_has_its_word() {
        check(|_| {}, Identifiability::Identifiable);
        check(|e| e.fitted = 10.0, Identifiability::OnBound);
        check(|e| e.inflation = Some(101.0), Identifiability::Confounded);
        check(|e| e.inflation = None, Identifiability::Confounded);
        check(|e| e.interval = Some((0.0, 2.2)), Identifiability::Flat);
        check(|e| e.interval = Some((0.5, 10.0)), Identifiability::Flat);
        check(|e| e.interval = Some((0.5, 5.0)), Identifiability::Uncertain);
        check(|e| e.interval = None, Identifiability::Uncertain);
    }
}
