//! Answers at the extremes: all right, all wrong, one level, levels near the ends of what a number holds, a million trials.
//! A fit ends in a verdict or in an error that says what is wrong, and no number in it is none.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use zwidth_stats::psychometric::fit::{Fit, Model, Profiled, Verdict, fit};
use zwidth_stats::psychometric::grid::{Grid, posterior};
use zwidth_stats::psychometric::{Asks, LevelAnswers, Sigmoid};

const CONFIDENCE: f64 = 0.95;
/// How many sets of answers `cargo test` tries; `cargo xtask soak extremes` names more.
const SETS: u64 = 200;

fn one_of<T: Copy>(rng: &mut ChaCha8Rng, values: &[T]) -> T {
    values[rng.next_u64() as usize % values.len()]
}

fn answers(rng: &mut ChaCha8Rng) -> Vec<LevelAnswers> {
    let n = one_of(rng, &[0, 1, 2, 3, 5, 7, 20, 60]);
    let origin = one_of(rng, &[0.0, 1.0, 300.0, -5.0, 1e9, -1e-6]);
    let step = one_of(rng, &[0.0, 1e-6, 1e-3, 1.0, 30.0, 1e9, 1e200]);
    let most = one_of(rng, &[1, 2, 20, 1_000_000]);
    let pattern = rng.next_u64() % 7;
    let of_level = |place: u64| {
        let trials = if pattern == 6 { rng.next_u64() % (most + 1) } else { most };
        let positive = match pattern {
            0 => 0,
            1 => trials,
            2 => trials / 2,
            3 if place < n / 2 => 0,
            3 => trials,
            4 if place < n / 2 => trials,
            4 => 0,
            5 => trials * (place + 1) / (n + 1),
            _ => rng.next_u64() % (trials + 1),
        };
        LevelAnswers { level: origin + step * place as f64, trials, positive }
    };
    (0..n).map(of_level).collect()
}

fn check(name: &str, estimate: f64, low: Option<f64>, high: Option<f64>) {
    assert!(estimate.is_finite(), "{name} is {estimate}");
    assert!(low.is_none_or(|low| low.is_finite() && low <= estimate), "{name}: {low:?} {estimate}");
    assert!(
        high.is_none_or(|high| high.is_finite() && estimate <= high),
        "{name}: {estimate} {high:?}"
    );
}

#[test]
fn every_set_of_answers_has_a_verdict_or_an_error_and_no_number_that_is_none() {
    let named = std::env::var("ZWIDTH_EXTREMES_FITS").ok();
    let sets = named.map_or(SETS, |number| number.parse().unwrap());
    let (mut estimated, mut refused) = (0_u64, 0_u64);
    for seed in 0..sets {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let answers = answers(&mut rng);
        let asks = one_of(&mut rng, &[Asks::WhichWasMore, Asks::RightOrWrong, Asks::YesNo]);
        let sigmoid = one_of(&mut rng, &[Sigmoid::Norm, Sigmoid::Logistic, Sigmoid::Weibull]);
        let lapse = one_of(&mut rng, &[[0.0, 0.06], [0.0, 0.0], [0.02, 0.02], [0.0, 0.49]]);
        let is_constant = rng.next_u64().is_multiple_of(2);
        let told = format!("{seed}: {answers:?}, {asks:?}, {sigmoid:?}, {lapse:?}");
        match fit(&answers, &Model { asks, sigmoid, lapse, is_constant }, CONFIDENCE) {
            Ok(Fit { verdict, fitted, .. }) => {
                assert_eq!(verdict == Verdict::Estimated, fitted.is_some(), "{told}");
                estimated += u64::from(fitted.is_some());
                if let Some(found) = fitted {
                    for (name, Profiled { estimate, ci_low, ci_high }) in
                        [("threshold", found.threshold), ("JND", found.jnd)]
                    {
                        check(&format!("{told}: {name}"), estimate, ci_low, ci_high);
                    }
                    let rest = [found.log_likelihood, found.deviance, found.pearson];
                    assert!(rest.iter().all(|number| number.is_finite()), "{told}: {rest:?}");
                    assert!(found.dispersion >= 1.0 && found.dispersion.is_finite(), "{told}");
                    let errors = [found.threshold_error, found.ln_jnd_error];
                    assert!(errors.iter().flatten().all(|error| error.is_finite()), "{told}");
                }
            }
            Err(error) => {
                refused += 1;
                assert!(!error.to_string().is_empty(), "{told}");
            }
        }
        // A posterior takes a hundred times as long.
        if seed % 50 == 0
            && let Ok(found) =
                posterior(&answers, &Grid { asks, sigmoid, is_overdispersed: false }, CONFIDENCE)
        {
            for (name, of) in [("threshold", found.threshold), ("JND", found.jnd)] {
                check(
                    &format!("{told}: posterior {name}"),
                    of.mean,
                    Some(of.ci_low),
                    Some(of.ci_high),
                );
            }
        }
    }
    assert!(estimated > sets / 100 && refused > sets / 100, "{estimated} {refused} of {sets}");
}
