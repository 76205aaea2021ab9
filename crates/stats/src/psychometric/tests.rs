//! Fits of answers that a formula gives, whose numbers R and SciPy agree on (both by their own optimisers of the
//! likelihood), and of answers that have none.

use super::fit::{Fit, Fitted, LAPSE, Model, Profiled, Side, Verdict, fit, misfit};
use super::{Asks, LevelAnswers, Sigmoid};
use crate::StatsError;
use crate::bootstrap::{stream, uniform};
use crate::heterogeneity::two_level;
use crate::paired;
use core::f64::consts::FRAC_1_SQRT_2;

pub(super) const MORE: Model =
    Model { asks: Asks::WhichWasMore, sigmoid: Sigmoid::Norm, lapse: LAPSE, is_constant: true };

/// A number between −½ and ½ from four whole ones: (h³ mod 9941)/9941 − ½, h = 1 + 131 a + 173 b + 197 c + 211 d.
pub(super) fn scattered([a, b, c, d]: [u64; 4]) -> f64 {
    let h = 1 + 131 * a + 173 * b + 197 * c + 211 * d;
    (h.pow(3) % 9941) as f64 / 9941.0 - 0.5
}

/// Answers of persons 1 to 8, mode 0 or 1: 20 trials at each of 210, 240, … 390 N/m.
pub(super) fn person(p: u64, mode: u64) -> Vec<LevelAnswers> {
    let m = mode as f64;
    let pse = 300.0 + 30.0 * scattered([p, 1, 0, 0]) + 12.0 * m + 20.0 * scattered([p, 2, mode, 0]);
    let grown = 0.8 * scattered([p, 3, 0, 0]) + 0.25 * m + 0.5 * scattered([p, 4, mode, 0]);
    let sigma = 1.4826 * 30.0 * libm::exp(grown);
    let answers = |l: u64| {
        let level = 210.0 + 30.0 * l as f64;
        let share = 0.5 * libm::erfc(-(level - pse) / sigma * FRAC_1_SQRT_2);
        let count = 20.0 * (0.02 + 0.96 * share) + 0.5 + 2.0 * scattered([p, 10 + mode, l, 0]);
        LevelAnswers { level, trials: 20, positive: count.floor().clamp(0.0, 20.0) as u64 }
    };
    (0..7).map(answers).collect()
}

/// Whether there was a force: right or wrong of two intervals, 40 trials at each of 7 forces in N.
fn detection() -> Vec<LevelAnswers> {
    let answers = |(l, level): (u64, f64)| {
        let share = 0.5 + 0.48 * (1.0 - libm::exp(-(level / 0.08) * (level / 0.08)));
        let count = (40.0 * share + 0.5 + 3.0 * scattered([77, l, 0, 0])).floor();
        LevelAnswers { level, trials: 40, positive: count.clamp(0.0, 40.0) as u64 }
    };
    let levels = [0.02, 0.04, 0.06, 0.08, 0.12, 0.16, 0.24];
    (0..).zip(levels).map(answers).collect()
}

pub(super) fn fitted(answers: &[LevelAnswers], model: &Model) -> Fitted {
    let found = fit(answers, model, 0.95).unwrap();
    assert_eq!(found.verdict, Verdict::Estimated, "{answers:?}");
    found.fitted.unwrap()
}

fn verdict(counts: &[u64], trials: u64, asks: Asks) -> Verdict {
    let answers = counts.iter().zip(1..).map(|(positive, level)| LevelAnswers {
        level: f64::from(level),
        trials,
        positive: *positive,
    });
    let answers: Vec<LevelAnswers> = answers.collect();
    let Fit { verdict, fitted, .. } = fit(&answers, &Model { asks, ..MORE }, 0.95).unwrap();
    assert_eq!(fitted.is_some(), verdict == Verdict::Estimated);
    verdict
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "{found} instead of {expected}");
}

/// PSE, its ends, JND, its ends, λ, log-likelihood, deviance and X² of 8 people in two modes, to the digits of R 4.2
/// and SciPy 1.17.
const PEOPLE: [[f64; 10]; 16] = [
    [285.354, 273.505, 296.869, 27.262, 18.717, 36.571, 0.0000, -48.25479, 1.93391, 1.25005],
    [290.047, 274.598, 305.256, 37.552, 21.209, 54.880, 0.0159, -65.01075, 0.14133, 0.13995],
    [303.420, 285.444, 321.711, 39.762, 26.894, 70.029, 0.0600, -73.40714, 0.47570, 0.47918],
    [304.041, 281.963, 327.132, 64.026, 37.895, 101.134, 0.0000, -81.78437, 0.65213, 0.65149],
    [306.260, 292.958, 319.809, 34.386, 20.517, 46.383, 0.0000, -58.81818, 2.03059, 1.52188],
    [326.930, 311.554, 344.558, 42.478, 24.081, 59.700, 0.0000, -65.67251, 3.05867, 2.62270],
    [311.231, 296.759, 325.788, 30.512, 18.100, 49.203, 0.0372, -61.01526, 0.92589, 0.88234],
    [318.446, 301.034, 336.248, 37.094, 25.000, 65.820, 0.0590, -70.64120, 0.89844, 0.87247],
    [291.487, 280.454, 302.614, 17.302, 9.632, 29.950, 0.0455, -47.18591, 0.19218, 0.18678],
    [301.303, 288.375, 315.022, 29.989, 16.285, 41.467, 0.0065, -54.03007, 1.93634, 1.43825],
    [299.441, 286.471, 312.739, 25.750, 13.940, 38.204, 0.0171, -50.51891, 2.11822, 1.69343],
    [327.877, 314.650, 343.081, 33.952, 14.601, 46.313, 0.0000, -55.91553, 2.78604, 3.04088],
    [292.409, 280.783, 303.928, 27.077, 19.021, 36.175, 0.0000, -48.13534, 1.99174, 1.52865],
    [305.138, 292.063, 318.205, 32.924, 19.940, 44.237, 0.0000, -56.91613, 1.32611, 0.81982],
    [301.702, 290.709, 313.979, 20.809, 13.195, 32.107, 0.0168, -43.46186, 3.28441, 2.47851],
    [306.526, 293.579, 319.614, 32.818, 19.936, 44.096, 0.0000, -56.72503, 1.14424, 0.67728],
];

#[test]
fn fits_of_eight_people_in_two_modes_are_those_of_r_and_scipy() {
    for (i, expected) in (0_u64..).zip(PEOPLE) {
        let found = fitted(&person(1 + i / 2, i % 2), &MORE);
        let Profiled { estimate: pse, ci_low, ci_high } = found.threshold;
        let numbers = [
            [pse, ci_low.unwrap(), ci_high.unwrap()],
            [found.jnd.estimate, found.jnd.ci_low.unwrap(), found.jnd.ci_high.unwrap()],
        ];
        let numbers = numbers.as_flattened().iter();
        for (number, expected) in numbers.zip(expected) {
            near(*number, expected, 6e-4);
        }
        near(found.curve.lapse, expected[6], 6e-5);
        near(found.log_likelihood, expected[7], 6e-6);
        near(found.deviance, expected[8], 6e-6);
        near(found.pearson, expected[9], 6e-6);
        assert_eq!((found.curve.guess, found.dispersion), (found.curve.lapse, 1.0));
    }
}

/// Over people: R 4.2 and SciPy 1.17; the weighted mean by its definition in NumPy.
#[test]
fn modes_are_compared_over_people_by_pses_and_ratios_of_jnds() {
    let fits: Vec<[Fitted; 2]> =
        (1..9).map(|p| [0, 1].map(|mode| fitted(&person(p, mode), &MORE))).collect();
    let differences = |read: fn(&Fitted) -> f64| {
        let pairs: Vec<[f64; 2]> = fits.iter().map(|[a, h]| [read(h), read(a)]).collect();
        paired::mean_difference(&paired::differences(&pairs), 0.95).unwrap()
    };
    let pse = differences(|fitted| fitted.threshold.estimate);
    let expected = [11.1253307, 3.27800953, 3.39392973, 7.0, 0.0115374974, 3.37406989, 18.8765915];
    let found =
        [pse.estimate, pse.std_error, pse.statistic, pse.df, pse.p_value, pse.ci_low, pse.ci_high];
    for (found, expected) in found.into_iter().zip(expected) {
        near(found, expected, 1e-5 * expected);
    }
    let ratio = differences(|fitted| libm::log(fitted.jnd.estimate));
    near(libm::exp(ratio.estimate), 1.39810238, 1e-5);
    near(libm::exp(ratio.ci_low), 1.24289606, 1e-5);
    near(libm::exp(ratio.ci_high), 1.57269005, 1e-5);
    near(ratio.p_value, 2.68872414e-4, 1e-8);
    // Of the standard, 300 N/m, in the active mode.
    let ln_weber = fits.iter().map(|[a, _]| libm::log(a.curve.weber_fraction(300.0).unwrap()));
    near(libm::exp(ln_weber.sum::<f64>() / 8.0), 0.0901216351, 1e-6);
    let values: Vec<f64> =
        fits.iter().map(|[a, h]| h.threshold.estimate - a.threshold.estimate).collect();
    let error = |found: &Fitted| found.threshold_error.unwrap().powi(2);
    let variances: Vec<f64> = fits.iter().map(|[a, h]| error(a) + error(h)).collect();
    let weighted = two_level(&values, &variances, 0.95).unwrap();
    near(weighted.between, 0.0, 1e-15);
    near(weighted.mean.estimate, 11.620334, 1e-4);
    near(weighted.mean.std_error, 3.1320177, 3e-5);
    near(weighted.mean.p_value, 0.0075530821, 1e-6);
}

/// R 4.2 and SciPy 1.17, to the digits given.
#[test]
fn logistic_fits_are_those_of_r_and_scipy() {
    let logistic = Model { sigmoid: Sigmoid::Logistic, ..MORE };
    let expected = [
        (1, -48.552545, [284.66833, 272.64999, 296.47207, 25.527688, 17.160722, 35.358818], 0.0),
        (
            5,
            -47.265523,
            [291.55252, 280.41347, 302.72981, 16.818028, 8.8477272, 30.822540],
            0.0409912848,
        ),
    ];
    for (p, log_likelihood, numbers, lapse) in expected {
        let found = fitted(&person(p, 0), &logistic);
        near(found.log_likelihood, log_likelihood, 1e-6);
        near(found.curve.lapse, lapse, 2e-6 * lapse + 1e-12);
        for (profiled, expected) in [found.threshold, found.jnd].iter().zip(numbers.chunks(3)) {
            near(profiled.estimate, expected[0], 2e-6 * expected[0]);
            near(profiled.ci_low.unwrap(), expected[1], 1e-5 * expected[1]);
            near(profiled.ci_high.unwrap(), expected[2], 1e-5 * expected[2]);
        }
    }
}

/// λ fixed at 0 is a generalised linear model: R's `glm` with a probit link.
#[test]
fn without_lapses_the_fit_is_that_of_rs_glm() {
    let found = fitted(&person(1, 0), &Model { lapse: [0.0, 0.0], ..MORE });
    // To what R's iterations leave.
    near(found.threshold.estimate, 285.354374, 1e-5);
    near(found.jnd.estimate, 27.2621285, 1e-5);
    near(found.deviance, 1.93390806, 1e-8);
}

/// R 4.2, and psignifit's MAP is near.
#[test]
fn the_weibull_fit_of_right_and_wrong_is_that_of_r() {
    let weibull = Model {
        asks: Asks::RightOrWrong,
        sigmoid: Sigmoid::Weibull,
        lapse: LAPSE,
        is_constant: true,
    };
    let answers = detection();
    let found = fitted(&answers, &weibull);
    near(found.log_likelihood, -124.269147, 1e-6);
    near(libm::exp(found.curve.location), 0.0806301, 1e-6);
    near(1.0 / found.curve.scale, 2.36399, 3e-5);
    near(found.curve.lapse, 0.0374484, 1e-6);
    near(found.threshold.estimate, 0.0690501, 1e-6);
    near(found.curve.guess, 0.5, 1e-15);
    // The ends of both intervals, by the definition of a profile: the best of many curves on a grid.
    for (profiled, read) in [(found.threshold, 0), (found.jnd, 1)] {
        for end in [profiled.ci_low, profiled.ci_high] {
            let end = end.unwrap();
            let mut best = f64::NEG_INFINITY;
            for i in 0..2000 {
                let scale = libm::exp(-4.0 + 0.003 * f64::from(i));
                let mut curve = super::Curve { scale, guess: 0.5, ..found.curve };
                curve.location = 0.0;
                let unit = if read == 0 { curve.threshold() } else { curve.jnd() };
                curve.location = libm::log(end / unit);
                for lapse in (0..=60).map(|i| f64::from(i) * 1e-3) {
                    let curve = super::Curve { lapse, ..curve };
                    let terms = answers.iter().map(|answer| {
                        let share = curve.share(answer.level);
                        let (k, n) = (answer.positive as f64, answer.trials as f64);
                        k * share.ln() + (n - k) * (1.0 - share).ln()
                    });
                    best = best.max(terms.sum());
                }
            }
            near(2.0 * (found.log_likelihood - best), 3.8414588, 2e-3);
        }
    }
}

#[test]
fn trials_at_nothing_tell_the_guesses_of_yes_and_no() {
    let shares = [0.15, 0.2, 0.4, 0.75, 0.95, 0.99];
    let answers = shares.iter().zip(0..).map(|(share, i)| LevelAnswers {
        level: f64::from(i),
        trials: 10_000,
        positive: (10_000.0 * share) as u64,
    });
    let answers: Vec<LevelAnswers> = answers.collect();
    for sigmoid in [Sigmoid::Weibull, Sigmoid::Norm] {
        let model = Model { asks: Asks::YesNo, sigmoid, ..MORE };
        let found = fitted(&answers, &model);
        assert!((0.12..0.16).contains(&found.curve.guess), "{found:?}");
        assert!(found.curve.lapse < 0.06 && (2.0..3.0).contains(&found.threshold.estimate));
        assert_eq!(fit(&answers[1..], &model, 0.95), Err(StatsError::NothingShown));
    }
    // γ and λ have their best values: no other ones nearby are more likely.
    let found = fitted(&answers, &Model { asks: Asks::YesNo, sigmoid: Sigmoid::Weibull, ..MORE });
    for (guess, lapse) in [(1e-3, 0.0), (-1e-3, 0.0), (0.0, 1e-3), (0.0, -1e-3)] {
        let mut moved = found.curve;
        moved.guess += guess;
        moved.lapse = (moved.lapse + lapse).max(0.0);
        assert!(misfit(&answers, &moved).0 >= found.deviance);
    }
}

#[test]
fn answers_without_a_threshold_say_why() {
    use Asks::{RightOrWrong, WhichWasMore, YesNo};
    use Verdict::{Estimated, Falling, Flat, Outside, Steep, TooFew};
    const BELOW: Verdict = Outside(Side::Below);
    const ABOVE: Verdict = Outside(Side::Above);
    for (counts, trials, asks, expected) in [
        (&[0, 2, 5, 10, 15, 18, 20][..], 20, WhichWasMore, Estimated),
        (&[20, 18, 15, 10, 5, 2, 0], 20, WhichWasMore, Falling),
        (&[20; 7], 20, WhichWasMore, BELOW),
        (&[0; 7], 20, WhichWasMore, ABOVE),
        (&[10; 7], 20, WhichWasMore, Flat),
        (&[9, 11, 10, 10, 9, 10, 11], 20, WhichWasMore, Flat),
        (&[12, 14, 15, 17, 19, 20, 20], 20, WhichWasMore, BELOW),
        (&[0, 0, 1, 1, 3, 4, 7], 20, WhichWasMore, ABOVE),
        (&[0, 0, 0, 0, 20, 20, 20], 20, WhichWasMore, Steep),
        (&[0, 0, 0, 7, 20, 20, 20], 20, WhichWasMore, Steep),
        (&[0, 1, 0, 0, 20, 20, 19], 20, WhichWasMore, Steep),
        (&[5, 10], 20, WhichWasMore, TooFew),
        (&[2, 4, 8], 9, WhichWasMore, TooFew),
        (&[20; 7], 20, RightOrWrong, BELOW),
        (&[10; 7], 20, RightOrWrong, ABOVE),
        (&[0; 7], 20, RightOrWrong, ABOVE),
        (&[15; 7], 20, RightOrWrong, Flat),
        (&[20, 19, 17, 15, 12, 11, 10], 20, RightOrWrong, Falling),
        (&[10, 10, 10, 20, 20, 20, 20], 20, RightOrWrong, Steep),
        (&[10, 11, 13, 17, 19, 20, 20], 20, RightOrWrong, Estimated),
    ] {
        assert_eq!(verdict(counts, trials, asks), expected, "{counts:?}");
    }
    // 10⁶ trials at each level, of a smooth course and of a perfect step.
    let many: Vec<u64> =
        [0.02, 0.1, 0.3, 0.55, 0.8, 0.93, 0.98].iter().map(|share| (1e6 * share) as u64).collect();
    assert_eq!(verdict(&many, 1_000_000, WhichWasMore), Estimated);
    assert_eq!(verdict(&[0, 0, 0, 0, 1_000_000, 1_000_000], 1_000_000, WhichWasMore), Steep);
    assert_eq!(verdict(&[1_000_000; 5], 1_000_000, WhichWasMore), BELOW);
    // One level, whatever its answers, and none.
    assert_eq!(verdict(&[700], 1000, WhichWasMore), TooFew);
    assert_eq!(fit(&[], &MORE, 0.95).unwrap().verdict, TooFew);
    // Yes and no begin at level 0.
    let shown = |counts: [u64; 5]| {
        let answers = counts.iter().zip(0..).map(|(positive, level)| LevelAnswers {
            level: f64::from(level),
            trials: 20,
            positive: *positive,
        });
        let answers: Vec<LevelAnswers> = answers.collect();
        let weibull = Model { asks: YesNo, sigmoid: Sigmoid::Weibull, ..MORE };
        fit(&answers, &weibull, 0.95).unwrap().verdict
    };
    assert_eq!(shown([1, 4, 10, 17, 20]), Estimated);
    assert_eq!(shown([0; 5]), ABOVE);
    // Who says yes to nothing too has no threshold.
    assert_eq!(shown([20; 5]), Flat);
    assert_eq!(shown([20, 15, 10, 5, 0]), Falling);
}

/// Between 4, 8 and 16 nothing tells the JND: the likelihood is the same of any that is far below their distances, however
/// near to each other other levels are.
#[test]
fn how_steep_a_curve_is_is_told_by_the_levels_beside_its_threshold() {
    let at = |levels: &[f64], counts: &[u64]| -> Vec<LevelAnswers> {
        let rows = levels.iter().zip(counts);
        rows.map(|(level, positive)| LevelAnswers {
            level: *level,
            trials: 20,
            positive: *positive,
        })
        .collect()
    };
    let verdict = |answers: &[LevelAnswers]| fit(answers, &MORE, 0.95).unwrap().verdict;
    let doubled = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
    assert_eq!(verdict(&at(&doubled, &[0, 0, 0, 0, 0, 7, 20])), Verdict::Steep);
    assert_eq!(verdict(&at(&doubled, &[0, 0, 0, 0, 0, 13, 20])), Verdict::Steep);
    assert_eq!(verdict(&at(&doubled, &[0, 0, 1, 4, 8, 13, 18])), Verdict::Estimated);
    // Levels that differ by rounding are one, and no gap.
    let twice = [1.0, 2.0, 3.0, 4.0, 4.0 + 1e-9, 5.0, 6.0];
    let once = at(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], &[0, 0, 0, 7, 20, 20]);
    assert_eq!(verdict(&once), Verdict::Steep);
    let found = fit(&at(&twice, &[0, 0, 0, 3, 4, 20, 20]), &MORE, 0.95).unwrap();
    assert_eq!((found.verdict, found.levels, found.trials), (Verdict::Steep, 6, 140));
    // A JND of less than the gap and more than half of it is told.
    let smooth =
        fitted(&at(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], &[0, 0, 3, 10, 17, 20, 20]), &MORE);
    assert!((0.5..1.0).contains(&smooth.jnd.estimate) && smooth.jnd.ci_low.is_some());
}

#[test]
fn any_answers_have_a_verdict_and_finite_numbers() {
    let mut rng = stream(31, 0);
    let mut estimated = 0;
    for study in 0..150 {
        let k = 3 + study % 6;
        let spacing = libm::exp(8.0 * uniform(&mut rng) - 4.0);
        let (slope, middle) = (4.0 * uniform(&mut rng) - 0.5, 6.0 * uniform(&mut rng) - 1.0);
        let answers = (0..k).map(|i| {
            let trials = 1 + (40.0 * uniform(&mut rng)) as u64;
            let share = 1.0 / (1.0 + libm::exp(-slope * (f64::from(i) - middle)));
            let positive = (0..trials).filter(|_| uniform(&mut rng) < share).count() as u64;
            LevelAnswers { level: spacing * f64::from(i), trials, positive }
        });
        let answers: Vec<LevelAnswers> = answers.collect();
        for sigmoid in [Sigmoid::Norm, Sigmoid::Logistic, Sigmoid::Weibull] {
            for asks in [Asks::WhichWasMore, Asks::RightOrWrong, Asks::YesNo] {
                let (lapse, level) =
                    if study % 2 == 0 { (LAPSE, 0.95) } else { ([0.0, 0.0], 0.99) };
                let model = Model { asks, sigmoid, lapse, ..MORE };
                let Some(found) = fit(&answers, &model, level).unwrap().fitted else { continue };
                estimated += 1;
                for Profiled { estimate, ci_low, ci_high } in [found.threshold, found.jnd] {
                    assert!(estimate.is_finite());
                    assert!(ci_low.is_none_or(|low| low.is_finite() && low <= estimate));
                    assert!(ci_high.is_none_or(|high| high.is_finite() && estimate <= high));
                }
                assert!(found.deviance.is_finite() && found.pearson.is_finite());
                let errors = [found.threshold_error, found.ln_jnd_error];
                assert!(errors.into_iter().flatten().all(|error| 0.0 < error && error.is_finite()));
            }
        }
    }
    assert!(estimated > 200, "{estimated}");
}

/// Without lapses some curves make an answer impossible, so that the profile falls without end.
#[test]
fn an_interval_ends_before_what_is_impossible() {
    let answers: Vec<LevelAnswers> = [0, 3, 3, 6, 5]
        .into_iter()
        .zip(1..)
        .map(|(positive, level)| LevelAnswers { level: f64::from(level), trials: 6, positive })
        .collect();
    let model = Model { lapse: [0.0, 0.0], ..MORE };
    let found = fit(&answers, &model, 0.99).unwrap().fitted.unwrap();
    assert!(found.jnd.ci_low.is_some_and(|low| 0.0 < low && low < found.jnd.estimate), "{found:?}");
}

/// Answers that scatter tell little of Weibull's JND: a grid of 4,000 scales and 13 λ in NumPy stays 1.6 above the critical
/// value down to a JND of 0.05, where few scales leave the threshold among the levels.
#[test]
fn the_best_curve_of_a_small_jnd_is_found() {
    let answers: Vec<LevelAnswers> = [30, 43, 45, 50, 68, 73, 78]
        .into_iter()
        .zip(2..)
        .map(|(positive, level)| LevelAnswers { level: f64::from(level), trials: 79, positive })
        .collect();
    let model = Model { asks: Asks::RightOrWrong, sigmoid: Sigmoid::Weibull, ..MORE };
    let found = fitted(&answers, &model);
    assert!(found.jnd.ci_low.is_none_or(|low| low < 0.05), "{found:?}");
}

/// An answer far out, where 1 − ψ is not 0 but ψ rounds to 1.
#[test]
fn a_likelihood_that_is_finite_has_a_finite_deviance() {
    let answers = [
        LevelAnswers { level: 0.0, trials: 20, positive: 10 },
        LevelAnswers { level: 10.0, trials: 20, positive: 19 },
    ];
    let curve =
        super::Curve { sigmoid: Sigmoid::Norm, location: 0.0, scale: 1.0, guess: 0.0, lapse: 0.0 };
    let (deviance, pearson) = misfit(&answers, &curve);
    // SciPy: `norm.sf(10)` is 7.61985302416052e-24.
    let rest: f64 = 7.619_853_024_160_52e-24;
    let expected = 2.0 * (19.0 * 0.95_f64.ln() + (0.05 / rest).ln());
    near(deviance, expected, 1e-9 * expected);
    near(pearson * 20.0 * rest, 1.0, 1e-9);
}

#[test]
fn answers_in_any_unit_and_in_any_rows_are_one_fit() {
    let answers = person(3, 1);
    let expected = fitted(&answers, &MORE);
    for unit in [1e-6, 1e6] {
        let scaled: Vec<LevelAnswers> =
            answers.iter().map(|a| LevelAnswers { level: a.level * unit, ..*a }).collect();
        let found = fitted(&scaled, &MORE);
        near(found.threshold.estimate / unit, expected.threshold.estimate, 1e-5);
        near(found.jnd.ci_high.unwrap() / unit, expected.jnd.ci_high.unwrap(), 1e-4);
    }
    let single = answers.iter().rev().flat_map(|a| {
        (0..a.trials).map(|i| LevelAnswers { trials: 1, positive: u64::from(i < a.positive), ..*a })
    });
    assert_eq!(fitted(&single.collect::<Vec<_>>(), &MORE), expected);
}

#[test]
fn scattered_answers_have_wider_intervals() {
    let counts = [3, 1, 9, 4, 18, 12, 20];
    let answers: Vec<LevelAnswers> = counts
        .iter()
        .zip(1..)
        .map(|(positive, level)| LevelAnswers {
            level: f64::from(level),
            trials: 20,
            positive: *positive,
        })
        .collect();
    let scattered = fitted(&answers, &MORE);
    let binomial = fitted(&answers, &Model { is_constant: false, ..MORE });
    near(scattered.dispersion, scattered.pearson / 4.0, 1e-12);
    assert!(scattered.dispersion > 1.5 && binomial.dispersion <= 1.0);
    let width = |found: &Fitted| found.threshold.ci_high.unwrap() - found.threshold.ci_low.unwrap();
    assert!(width(&scattered) > 1.7 * width(&binomial));
    // R: qt(0.975, 4).
    near(scattered.threshold_error.unwrap(), width(&scattered) / 2.0 / 2.776_445_105, 1e-8);
    near(binomial.threshold_error.unwrap(), width(&binomial) / 2.0 / 1.959_963_985, 1e-8);
    let [low, high] = [binomial.jnd.ci_low.unwrap(), binomial.jnd.ci_high.unwrap()];
    near(binomial.ln_jnd_error.unwrap(), (high / low).ln() / 2.0 / 1.959_963_985, 1e-8);
    // The profile of this JND has one end at most, and then there is no error.
    assert!(scattered.jnd.ci_low.is_none() || scattered.jnd.ci_high.is_none());
    assert_eq!(scattered.ln_jnd_error, None);
    // What is free is taken from the levels: λ if it is not fixed, γ of yes and no.
    let fixed = fitted(&answers, &Model { lapse: [0.01, 0.01], ..MORE });
    near(fixed.dispersion, fixed.pearson / 5.0, 1e-12);
    let from_nothing: Vec<LevelAnswers> =
        answers.iter().map(|own| LevelAnswers { level: own.level - 1.0, ..*own }).collect();
    let guessed = fitted(&from_nothing, &Model { asks: Asks::YesNo, ..MORE });
    near(guessed.dispersion, guessed.pearson / 3.0, 1e-12);
}

#[test]
fn what_cannot_be_meant_is_refused() {
    let answers = person(1, 0);
    let refused = |answers: &[LevelAnswers], model: Model| fit(answers, &model, 0.95).unwrap_err();
    for lapse in [[-0.1, 0.1], [0.1, 0.05], [0.0, 0.5], [f64::NAN, 0.1]] {
        assert!(matches!(refused(&answers, Model { lapse, ..MORE }), StatsError::Lapse { .. }));
    }
    let row = |level, positive| [LevelAnswers { level, trials: 3, positive }];
    assert!(matches!(refused(&row(1.0, 4), MORE), StatsError::MoreThanTrials { index: 0, .. }));
    assert!(matches!(refused(&row(f64::NAN, 1), MORE), StatsError::NonFinite { .. }));
    let weibull = Model { sigmoid: Sigmoid::Weibull, ..MORE };
    assert_eq!(refused(&row(-1.0, 1), weibull), StatsError::BelowZero { level: -1.0 });
    assert_eq!(fit(&answers, &MORE, 95.0), Err(StatsError::Level { level: 95.0 }));
}
