//! What the tests of groups say of studies in which groups do not differ, and of some in which they do.

use crate::drawn::normal;
use crate::judged::{Asked, Judged, LEVEL, Said, judge};
use crate::metric::SAMPLING;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use zwidth_stats::groups::{self, LEAST_FOR_A_CLAIM, group};

/// People of two groups, and how much they scatter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TwoGroups {
    people: [usize; 2],
    scatter: [f64; 2],
    /// How much higher the first group is.
    effect: f64,
}

/// 6, 8, 12 and 20 people in two groups; scatter equal, or three times as large in the smaller group. Where a claim can be
/// made also with a difference of one SD of the second.
pub(crate) fn kinds() -> Vec<TwoGroups> {
    let mut kinds = Vec::new();
    for people in [[2, 4], [3, 3], [4, 4], [3, 9], [4, 8], [6, 6], [5, 15], [10, 10]] {
        for scatter in [[1.0, 1.0], [3.0, 1.0]] {
            kinds.push(TwoGroups { people, scatter, effect: 0.0 });
            if people[0].min(people[1]) >= LEAST_FOR_A_CLAIM {
                kinds.push(TwoGroups { people, scatter, effect: 1.0 });
            }
        }
    }
    kinds
}

impl TwoGroups {
    pub(crate) fn name(&self) -> String {
        let ([a, b], [sd_a, sd_b]) = (self.people, self.scatter);
        let effect = if self.effect > 0.0 { ", an effect of one SD" } else { "" };
        format!("{a} + {b}, SDs {sd_a}, {sd_b}{effect}")
    }
}

/// Welch's t of the difference and of the mean of two groups, and permuted labels. Of groups that are too small
/// for a claim nothing is promised, nor of permuted labels where groups scatter differently.
pub(crate) fn tests(kind: TwoGroups, studies: usize) -> Vec<Judged> {
    // With four people and three times the scatter of the others Welch's test rejects in 5.8 %.
    let welch = Asked::Approximate { most: 0.065, coverage: [0.935, 0.985] };
    let can_claim = kind.people.iter().all(|n| *n >= LEAST_FOR_A_CLAIM);
    let welch = if can_claim { welch } else { Asked::Nothing };
    let is_even = kind.scatter[0].to_bits() == kind.scatter[1].to_bits();
    let permuted = if is_even && kind.effect <= 0.0 { Asked::Exact } else { Asked::Nothing };
    // How often an effect is found is its power: its interval has to hold it.
    let welch = match welch {
        Asked::Approximate { coverage, .. } if kind.effect > 0.0 => {
            Asked::Approximate { most: 1.0, coverage }
        }
        other => other,
    };
    let tests =
        [("difference of groups", welch), ("mean of groups", welch), ("permuted labels", permuted)];
    judge(studies, tests, |study| {
        let mut rng = ChaCha8Rng::seed_from_u64(study);
        let [a, b] = [0, 1].map(|side| {
            let people = 0..kind.people[side];
            let effect = [kind.effect, 0.0][side];
            people.map(|_| effect + kind.scatter[side] * normal(&mut rng)).collect::<Vec<f64>>()
        });
        let both = [group(&a), group(&b)];
        // Its power says nothing of claims, which do not rest on it, and takes longest.
        let permuted = (kind.effect <= 0.0).then(|| groups::permuted(&a, &b, SAMPLING).ok());
        [
            Said::about(groups::difference(both, LEVEL).ok(), kind.effect),
            Said::about(groups::mean(&both, LEVEL).ok(), kind.effect / 2.0),
            permuted
                .map_or_else(Said::default, |found| Said::by_p(found.map(|found| found.p_value))),
        ]
    })
}
