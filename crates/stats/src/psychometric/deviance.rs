//! Whether a curve describes the answers: its deviance among those of answers that it would give.
//!
//! With few trials at a level the deviance is not χ² (Wichmann & Hill 2001, Perception & Psychophysics 63:1293), so its
//! distribution is simulated: the curve answers as many trials at the same levels, a curve is fitted to these answers,
//! and its deviance is one draw.

use super::LevelAnswers;
use super::curve::Curve;
use super::fit::{Model, misfit};
use super::likelihood::Maximum;
use crate::bootstrap::{normal, uniform};
use crate::error::StatsError;
use crate::null::{SAME, Sampling, sampled_p};
use rand_chacha::ChaCha8Rng;

/// Draws where nobody gives another number.
pub const DRAWS: usize = 999;
/// The variance of a count from which it is drawn from the normal distribution: its steps are a hundredth of its spread.
const MANY: f64 = 10_000.0;

/// The share of draws from `curve`, fitted to `answers` as `model` says, whose deviance is at least as large as theirs:
/// a small p says that the curve does not describe the answers. (1 + those as large) / (1 + draws).
///
/// # Errors
/// What [`fit`](super::fit::fit) refuses of the answers.
pub fn p_value(
    answers: &[LevelAnswers],
    model: &Model,
    curve: &Curve,
    sampling: Sampling,
) -> Result<f64, StatsError> {
    let answers = model.checked(answers)?;
    let observed = misfit(&answers, curve).0;
    Ok(sampled_p(sampling, |rng| {
        let drawn: Vec<LevelAnswers> = answers
            .iter()
            .map(|own| {
                let positive = binomial(rng, own.trials, curve.share(own.level));
                LevelAnswers { positive, ..*own }
            })
            .collect();
        let likelihood = model.likelihood(&drawn);
        // A curve makes any of its own answers possible.
        likelihood.maximum().is_some_and(|Maximum { shape, best }| {
            misfit(&drawn, &likelihood.curve(shape, best)).0 >= observed * (1.0 - SAME)
        })
    }))
}

/// How many of `trials` succeed, each with the chance `share`.
fn binomial(rng: &mut ChaCha8Rng, trials: u64, share: f64) -> u64 {
    let n = trials as f64;
    let variance = n * share * (1.0 - share);
    if variance > MANY {
        return (n * share + variance.sqrt() * normal(rng)).round().clamp(0.0, n) as u64;
    }
    // From one of the rarer outcomes to the next: their distances are geometric (Devroye 1986, *Non-Uniform Random
    // Variate Generation*, X.4.3).
    let rare = share.min(1.0 - share);
    let mut count = 0;
    if rare > 0.0 {
        let per_trial = libm::log1p(-rare);
        let mut trial = 0.0;
        loop {
            trial += (libm::log(uniform(rng)) / per_trial).floor() + 1.0;
            if trial > n {
                break;
            }
            count += 1;
        }
    }
    if share > 0.5 { trials - count } else { count }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bootstrap::stream;
    use crate::psychometric::tests::{MORE, fitted, person};

    const SAMPLING: Sampling = Sampling { draws: 499, seed: 11 };

    #[test]
    fn drawn_counts_have_the_mean_and_the_variance_of_binomial_ones() {
        for (trials, share) in [(20, 0.02), (20, 0.5), (40, 0.97), (1_000_000, 0.3), (3, 0.0)] {
            let mut rng = stream(2, 0);
            let draws: Vec<f64> =
                (0..20_000).map(|_| binomial(&mut rng, trials, share) as f64).collect();
            let mean = draws.iter().sum::<f64>() / 20_000.0;
            let variance = draws.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / 20_000.0;
            let expected = trials as f64 * share * (1.0 - share);
            let error = (expected / 20_000.0).sqrt();
            assert!((mean - trials as f64 * share).abs() <= 4.0 * error, "{trials} {share} {mean}");
            assert!((variance - expected).abs() <= 0.05 * expected, "{trials} {share} {variance}");
        }
    }

    #[test]
    fn answers_of_a_curve_fit_and_those_of_none_do_not() {
        let answers = person(1, 0);
        let curve = fitted(&answers, &MORE).curve;
        let well = p_value(&answers, &MORE, &curve, SAMPLING).unwrap();
        // R: the deviance of 1.93 has 5 degrees of freedom without lapses.
        assert!(well > 0.5, "{well}");
        assert_eq!(p_value(&answers, &MORE, &curve, SAMPLING), Ok(well));
        let counts = [1, 8, 2, 12, 6, 19, 17];
        let scattered: Vec<LevelAnswers> = answers
            .iter()
            .zip(counts)
            .map(|(own, positive)| LevelAnswers { positive, ..*own })
            .collect();
        let curve = fitted(&scattered, &MORE).curve;
        let badly = p_value(&scattered, &MORE, &curve, SAMPLING).unwrap();
        assert!(badly < 0.01, "{badly}");
    }
}
