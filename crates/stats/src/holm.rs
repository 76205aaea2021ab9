//! Several claims at once.

use crate::error::{StatsError, check_probabilities};

/// Holm's adjusted p values of one family of claims, in the order of `p_values`: the i-th smallest
/// of m becomes max over j ≤ i of min(1, (m − j + 1) p₍ⱼ₎), so that equal p values stay equal and
/// the order stays. Claims whose adjusted p is below alpha are all true with probability 1 − alpha
/// at least, whatever the tests have to do with each other (Holm 1979, Scand. J. Statist. 6:65).
///
/// # Errors
/// A value outside [0, 1].
pub fn adjusted(p_values: &[f64]) -> Result<Vec<f64>, StatsError> {
    check_probabilities(p_values)?;
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|i, j| p_values[*i].total_cmp(&p_values[*j]));
    let mut adjusted = vec![0.0; p_values.len()];
    let mut largest = 0.0_f64;
    for (rank, index) in order.iter().enumerate() {
        let remaining = (p_values.len() - rank) as f64;
        // Never below that of a smaller p: the order of the claims stays.
        largest = largest.max((remaining * p_values[*index]).min(1.0));
        adjusted[*index] = largest;
    }
    Ok(adjusted)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(p_values: &[f64], expected: &[f64]) {
        let found = adjusted(p_values).unwrap();
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-15, "{found} {expected}");
        }
    }

    /// R 4.2: `p.adjust(p, "holm")`.
    #[test]
    fn adjusted_values_are_those_of_r() {
        check(&[0.04, 0.01, 0.03, 0.01, 0.5, 0.02], &[0.09, 0.06, 0.09, 0.06, 0.5, 0.08]);
        check(&[0.6, 0.7], &[1.0, 1.0]);
    }

    #[test]
    fn one_claim_keeps_its_p_value_and_none_has_none() {
        check(&[0.03], &[0.03]);
        check(&[], &[]);
    }

    #[test]
    fn ties_stay_ties_and_the_order_stays() {
        let p = [0.2, 0.001, 0.04, 0.04, 0.04, 1.0, 0.0, 0.001];
        let found = adjusted(&p).unwrap();
        for i in 0..p.len() {
            for j in 0..p.len() {
                assert!(p[i] > p[j] || found[i] <= found[j], "{i} {j}");
            }
            assert!(found[i] >= p[i] && found[i] <= 1.0);
        }
    }

    #[test]
    fn what_is_no_probability_is_refused() {
        for p in [f64::NAN, -0.1, 1.1] {
            let found = adjusted(&[0.5, p]);
            assert!(matches!(found, Err(StatsError::Probability { index: 1, .. })));
        }
    }
}
