//! How often intervals of thresholds and JNDs hold the truth, of simulated people whose curve is known.

use crate::drawn::uniform;
use crate::judged::{ALPHA, Asked, Judged, LEVEL, Said, judge};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use zwidth_stats::null::Sampling;
use zwidth_stats::psychometric::deviance;
use zwidth_stats::psychometric::fit::{Fit, LAPSE, Model, Profiled, fit};
use zwidth_stats::psychometric::{Asks, Curve, LevelAnswers, Sigmoid};

/// Levels: 210, 240, … 390 N/m.
const LEVELS: usize = 7;
const LOWEST: f64 = 210.0;
const STEP: f64 = 30.0;
/// Trials are given to the levels in this order, so that those left over lie around the middle.
const ORDER: [usize; LEVELS] = [3, 2, 4, 1, 5, 0, 6];
/// The JND is one step. Thresholds are even over the step in the middle.
const JND: f64 = 30.0;
const MIDDLE: f64 = 300.0;
/// The largest share of intervals of 95 % that may hold the truth.
const MOST_COVERED: f64 = 0.98;
/// Draws of a deviance: fewer than the product's, and as exact.
const DRAWS: usize = 99;

/// People with the same curve, but for their threshold.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Thresholds {
    trials: usize,
    lapse: f64,
    /// η: the share at a level is a Beta variable with variance η² ψ (1 − ψ).
    scatter: f64,
}

pub(crate) fn kinds() -> Vec<Thresholds> {
    let mut kinds = Vec::new();
    for trials in [40, 80, 160, 400] {
        for lapse in [0.0, 0.02, 0.05] {
            kinds.push(Thresholds { trials, lapse, scatter: 0.0 });
        }
        for scatter in [0.1, 0.2, 0.3] {
            kinds.push(Thresholds { trials, lapse: 0.02, scatter });
        }
    }
    kinds
}

impl Thresholds {
    pub(crate) fn name(&self) -> String {
        let Self { trials, lapse, scatter } = self;
        format!("{trials} trials, λ = {lapse}, η = {scatter}")
    }

    fn answers(&self, curve: &Curve, rng: &mut ChaCha8Rng) -> Vec<LevelAnswers> {
        let mut trials = [0; LEVELS];
        (0..self.trials).for_each(|trial| trials[ORDER[trial % LEVELS]] += 1);
        let counts = trials.iter().enumerate().map(|(place, trials)| {
            let level = LOWEST + STEP * place as f64;
            let share = curve.share(level);
            // Pólya's urn: counts of a share that is itself a Beta variable. Without scatter it never changes.
            let start = self.scatter.powi(-2) - 1.0;
            let mut positive = 0;
            for trial in 0..*trials {
                let chance = if start.is_finite() {
                    (share * start + positive as f64) / (start + trial as f64)
                } else {
                    share
                };
                positive += u64::from(uniform(rng) < chance);
            }
            LevelAnswers { level, trials: *trials, positive }
        });
        counts.collect()
    }
}

/// Intervals as the product gives them, beside those without φ and with λ fixed at 0, and the test of the deviance. An
/// interval without an end has none there; beside it stands how often both ends are there and hold the truth.
pub(crate) fn tests(kind: Thresholds, studies: usize) -> Vec<Judged> {
    // What the curve cannot show (few trials, answers that scatter far) is shown, and not promised.
    let is_promised = kind.trials >= 80 && kind.scatter < 0.15;
    let covering = |most: f64| match is_promised {
        true => Asked::Approximate { most: 1.0, coverage: [0.93, most] },
        false => Asked::Nothing,
    };
    // Of people who lapse intervals of the JND are too wide (`docs/statistics-tried.md`): no upper limit is kept.
    let most_of_jnd = if kind.lapse > 0.0 { 1.0 } else { MOST_COVERED };
    // Where answers scatter as binomial ones do: of 1,000 studies this is at most 7 %.
    let deviance = if is_promised && kind.scatter <= 0.0 { Asked::Exact } else { Asked::Nothing };
    let tests = [
        ("PSE", covering(MOST_COVERED)),
        ("JND", covering(most_of_jnd)),
        ("PSE with both ends", Asked::Nothing),
        ("JND with both ends", Asked::Nothing),
        ("PSE without φ", Asked::Nothing),
        ("JND without φ", Asked::Nothing),
        ("PSE, λ fixed at 0", Asked::Nothing),
        ("JND, λ fixed at 0", Asked::Nothing),
        ("deviance", deviance),
    ];
    judge(studies, tests, |study| {
        let mut rng = ChaCha8Rng::seed_from_u64(study);
        let truth = MIDDLE + STEP * (uniform(&mut rng) - 0.5);
        let mut curve = Curve {
            sigmoid: Sigmoid::Norm,
            location: truth,
            scale: 1.0,
            guess: kind.lapse,
            lapse: kind.lapse,
        };
        curve.scale = JND / curve.jnd();
        let answers = kind.answers(&curve, &mut rng);
        let model = Model {
            asks: Asks::WhichWasMore,
            sigmoid: Sigmoid::Norm,
            lapse: LAPSE,
            is_constant: true,
        };
        let fitted = |model: Model| {
            let Fit { fitted, .. } = fit(&answers, &model, LEVEL).unwrap();
            fitted
        };
        let product = fitted(model);
        let binomial = fitted(Model { is_constant: false, ..model });
        let without_lapses = fitted(Model { lapse: [0.0, 0.0], ..model });
        let said = |profiled: Option<Profiled>, truth: f64| {
            let covers = profiled.map(|profiled| {
                profiled.ci_low.is_none_or(|low| low <= truth)
                    && profiled.ci_high.is_none_or(|high| truth <= high)
            });
            Said { rejects: None, covers }
        };
        let with_both = |profiled: Option<Profiled>, truth: f64| {
            let covers = profiled.map(|Profiled { ci_low, ci_high, .. }| {
                ci_low.is_some_and(|low| low <= truth) && ci_high.is_some_and(|high| truth <= high)
            });
            Said { rejects: None, covers }
        };
        let pse_with_both = with_both(product.map(|fitted| fitted.threshold), truth);
        let jnd_with_both = with_both(product.map(|fitted| fitted.jnd), JND);
        let both = [product, binomial, without_lapses].map(|fitted| {
            [
                said(fitted.map(|fitted| fitted.threshold), truth),
                said(fitted.map(|fitted| fitted.jnd), JND),
            ]
        });
        let sampling = Sampling { draws: DRAWS, seed: study };
        let p = product
            .map(|fitted| deviance::p_value(&answers, &model, &fitted.curve, sampling).unwrap());
        let [[a, b], [c, d], [e, f]] = both;
        let misfit = Said { rejects: p.map(|p| p <= ALPHA), covers: None };
        [a, b, pse_with_both, jnd_with_both, c, d, e, f, misfit]
    })
}
