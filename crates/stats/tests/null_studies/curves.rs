//! What the tests of whole curves say of studies in which no node has an effect, and of some in which a part has.

use crate::drawn::normal;
use crate::judged::{ALPHA, Asked, Judged, LEVEL, Said, judge};
use core::f64::consts::PI;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use zwidth_stats::curve::{self, SKEWED, TrialCurves};
use zwidth_stats::null::Sampling;

/// Nodes of a curve.
const NODES: usize = 51;
/// Flips where there are too many to count all: fewer than the product draws, and as exact.
const DRAWS: usize = 999;
/// SD of the logarithm of skewed differences.
const SKEWED_SD: f64 = 0.8;

/// How people's differences scatter.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scatter {
    /// Normal, alike everywhere.
    Even,
    /// Normal, three times as far at the end as at the beginning.
    Rising,
    /// Lognormal.
    Skewed,
    /// Normal, and in the middle fifth all have a difference of one standard deviation.
    Different,
}

/// People, and how their differences scatter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Curves {
    people: usize,
    scatter: Scatter,
}

pub(crate) fn kinds() -> Vec<Curves> {
    let scatters = [Scatter::Even, Scatter::Rising, Scatter::Skewed, Scatter::Different];
    let kinds = [6, 8, 12, 20]
        .into_iter()
        .flat_map(|people| scatters.map(|scatter| Curves { people, scatter }));
    kinds.collect()
}

impl Curves {
    pub(crate) fn name(&self) -> String {
        let scatter = match self.scatter {
            Scatter::Even => "normal",
            Scatter::Rising => "normal, SDs 1 to 3 along the curve",
            Scatter::Skewed => "lognormal",
            Scatter::Different => "normal; an effect of one SD in a fifth",
        };
        format!("n = {}, {scatter}", self.people)
    }

    /// The mean difference at a node.
    fn truth(self, node: usize) -> f64 {
        let x = node as f64 / (NODES - 1) as f64;
        f64::from(u8::from(self.scatter == Scatter::Different && (x - 0.5).abs() <= 0.1))
    }

    /// A person's curve of differences: five waves, which hang together over about a fifth of it.
    fn curve(self, rng: &mut ChaCha8Rng) -> Vec<f64> {
        let weights: Vec<[f64; 2]> = (0..5).map(|_| [normal(rng), normal(rng)]).collect();
        let at = |node: usize| {
            let x = node as f64 / (NODES - 1) as f64;
            let waves = weights.iter().enumerate().map(|(k, [a, b])| {
                let phase = PI * k as f64 * x;
                a * phase.cos() + b * phase.sin()
            });
            // Each wave has a variance of 1 everywhere.
            let even = waves.sum::<f64>() / (weights.len() as f64).sqrt();
            match self.scatter {
                Scatter::Even => even,
                Scatter::Rising => even * (1.0 + 2.0 * x),
                Scatter::Skewed => (SKEWED_SD * even).exp() - (SKEWED_SD * SKEWED_SD / 2.0).exp(),
                Scatter::Different => even + self.truth(node),
            }
        };
        (0..NODES).map(at).collect()
    }
}

/// The largest |t|, any run, the largest mean, and both where differences are skewed, as the product claims them;
/// and any node by its own t.
pub(crate) fn tests(kind: Curves, studies: usize) -> Vec<Judged> {
    let covering = Asked::Approximate { most: 1.0, coverage: [0.935, 0.965] };
    let [exact, claimed, covers] = match kind.scatter {
        Scatter::Even | Scatter::Rising => [Asked::Exact, Asked::Exact, covering],
        // Flips are exact for differences that are as likely to have the other sign alone.
        Scatter::Skewed => {
            let most = Asked::Approximate { most: 0.065, coverage: [0.0, 1.0] };
            [Asked::Nothing, most, Asked::Nothing]
        }
        Scatter::Different => [Asked::Nothing, Asked::Nothing, covering],
    };
    let tests = [
        ("largest t", exact),
        ("any run", exact),
        ("largest mean", exact),
        ("largest t, skewed by both", claimed),
        ("any node by its own t", Asked::Nothing),
        ("band", covers),
    ];
    judge(studies, tests, |study| {
        let mut rng = ChaCha8Rng::seed_from_u64(study);
        let people: Vec<Vec<f64>> = (0..kind.people).map(|_| kind.curve(&mut rng)).collect();
        let sampling = Sampling { draws: DRAWS, seed: study };
        let found = curve::differences(&people, &[NODES], LEVEL, sampling).unwrap();
        let is_found = found.flipped.p_value <= ALPHA;
        let by_mean = found.p_unstudentised <= ALPHA;
        let claimed = is_found && (by_mean || found.skewness <= SKEWED);
        let said = |rejects: bool| Said { rejects: Some(rejects), covers: None };
        let holds = found.nodes.iter().enumerate().all(|(place, node)| {
            let truth = kind.truth(place);
            node.ends.is_none_or(|[low, high]| low <= truth && truth <= high)
        });
        [
            said(is_found),
            said(found.runs.iter().any(|run| run.p_value <= ALPHA)),
            said(by_mean),
            said(claimed),
            said(!found.runs.is_empty()),
            Said { rejects: None, covers: Some(holds) },
        ]
    })
}

/// One person's trials in two modes, each mode once in every pair of trials, in an order that chance chose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrialsOfOne {
    pairs: usize,
    scatter: Scatter,
    /// How much a trial adds to those before it.
    practice: f64,
}

pub(crate) fn kinds_of_one() -> Vec<TrialsOfOne> {
    let scatters = [
        (Scatter::Even, 0.0),
        (Scatter::Even, 0.3),
        (Scatter::Skewed, 0.0),
        (Scatter::Different, 0.0),
    ];
    let kinds = [6, 8, 12, 20].into_iter().flat_map(|pairs| {
        scatters.map(|(scatter, practice)| TrialsOfOne { pairs, scatter, practice })
    });
    kinds.collect()
}

impl TrialsOfOne {
    pub(crate) fn name(&self) -> String {
        let kind = match (self.scatter, self.practice > 0.0) {
            (Scatter::Skewed, _) => "lognormal",
            (Scatter::Different, _) => "normal; an effect of one SD in a fifth",
            (_, true) => "normal, each trial adds 0.3 SD",
            (_, false) => "normal",
        };
        format!("{} trials a mode, {kind}", self.pairs)
    }

    /// How trials of the second mode scatter, which has no effect.
    fn null(self) -> Scatter {
        if self.scatter == Scatter::Different { Scatter::Even } else { self.scatter }
    }
}

/// The largest |t| against redrawn orders.
pub(crate) fn tests_of_one(kind: TrialsOfOne, studies: usize) -> Vec<Judged> {
    let asked = match kind.scatter {
        Scatter::Different => Asked::Nothing,
        _ => Asked::Exact,
    };
    judge(studies, [("largest t, orders redrawn", asked)], |study| {
        let redraw = |seed: u64| -> Vec<usize> {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            (0..kind.pairs)
                .flat_map(|_| if rng.next_u64() % 2 == 0 { [0, 1] } else { [1, 0] })
                .collect()
        };
        let modes = redraw(study);
        let mut rng = ChaCha8Rng::seed_from_u64(study ^ u64::MAX);
        let people = Curves { people: 1, scatter: kind.scatter };
        let trials: Vec<Vec<f64>> = modes
            .iter()
            .enumerate()
            .map(|(number, mode)| {
                let scatter =
                    if *mode == 0 { people } else { Curves { scatter: kind.null(), ..people } };
                let own = scatter.curve(&mut rng).into_iter();
                own.map(|value| value + kind.practice * number as f64).collect()
            })
            .collect();
        let sessions = vec![0; trials.len()];
        let own =
            TrialCurves { curves: &trials, lengths: &[NODES], modes: &modes, sessions: &sessions };
        let sampling = Sampling { draws: DRAWS, seed: study };
        let found = curve::trials(own, &[[0, 1]], LEVEL, sampling, redraw).unwrap();
        let p = found[0].as_ref().unwrap().permuted.p_value;
        [Said { rejects: Some(p <= ALPHA), covers: None }]
    })
}
